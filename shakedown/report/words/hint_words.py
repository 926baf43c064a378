"""What a user should know of the data: load domains, likely slips of the pen, what slips are relative to."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from shakedown.joint.rigid_slips import rigid_slips
from shakedown.joint.units import loads_in_words as loads_in_words
from shakedown.report.node_words import pinned_in_words

if TYPE_CHECKING:
    from shakedown.joint.problem import Problem

LARGEST_USUAL_FRICTION = 5.0
UNALIKE = 100.0  # times: stiffnesses of one body that differ by more are probably in different units
LOAD_DOMAIN = (
    "The load steps are the corners of a load domain. What is proved, and λ_max, is about every path of the "
    "loads inside it, in whatever order; what is simulated, λ_T too, follows the corners in the order "
    "given: one path of many."
)
ONE_PATH = (
    "The load steps are the corners of a load domain, followed here in the order given: one path of many."
)


def simulated_path_in_words(problem: Problem) -> list[str]:
    """Along which of many paths a load domain was simulated; nothing for a loop, which has one."""
    return [ONE_PATH] if problem.is_domain else []


def hints_in_words(problem: Problem) -> list[str]:
    """What a user should know of the data, in words: what slips are relative to, likely slips of the pen.

    Examples
    --------
    >>> import shakedown
    >>> hints_in_words(shakedown.example("two-node"))
    []
    """
    relative = pinned_in_words(rigid_slips(problem).pinned, problem)
    hints = [relative] if relative else []
    p_mean = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    if np.all(p_mean < 0):
        hints.append(
            "The mean pressure is negative at every node: compression is positive in p_w. Is its sign right?"
        )
    if np.any(problem.f > LARGEST_USUAL_FRICTION):
        hints.append(f"The friction coefficient {problem.f.max():g} is unusually large: is it in percent?")
    return [*hints, *_units_in_doubt(problem)]


def _units_in_doubt(problem: Problem) -> Iterator[str]:
    """Numbers that do not go together, as where one file has mm and another one m."""
    tangential = float(np.abs(problem.A).max())
    normal = tangential if problem.C is None else float(np.abs(problem.C).max())
    for key, size, least in (("C", normal, 1.0 / UNALIKE), ("B", float(np.abs(problem.B).max()), 0.0)):
        if tangential > 0 and not least <= size / tangential <= UNALIKE:
            yield (
                f"The largest stiffness in {key} is {size / tangential:.3g} times the largest in A: are both "
                "in the same units?"
            )
    place = problem.x if problem.coordinates is None else problem.coordinates
    if place is None or tangential == 0:
        return
    extent = float(np.ptp(place.reshape(problem.n, -1), axis=0).max())
    moved = float(np.abs(problem.q_w).max()) / float(np.diagonal(problem.A).max())
    if 0 < extent < moved:
        yield (
            f"The load is as large as the stiffness times {moved:.3g}, more than the size of the contact, "
            f"{extent:.3g}: are forces, stiffnesses and positions in the same units?"
        )
