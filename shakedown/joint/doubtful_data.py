"""Likely mistakes in the data of a joint: a wrong sign, per cent instead of fractions, inconsistent units."""

from collections.abc import Iterator

import numpy as np

from shakedown.joint.problem import Problem

LARGEST_USUAL_FRICTION = 2.0
UNALIKE = 100.0  # ratio of stiffnesses of one body beyond which they are probably in different units


def is_pulled_everywhere(problem: Problem) -> bool:
    """Whether the mean load pulls the bodies apart at every node, as with a wrong sign of p_w."""
    mean = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    return bool((mean < 0).all())


def doubtful_data(problem: Problem) -> list[str]:
    """What is unusual in the data of a joint, each in one sentence.

    Examples
    --------
    >>> import shakedown
    >>> doubtful_data(shakedown.example("two-node"))
    []
    """
    hints = list[str]()
    if is_pulled_everywhere(problem):
        hints.append(
            "The mean pressure is negative at every node: compression is positive in p_w. Is its sign right?"
        )
    if np.any(problem.f > LARGEST_USUAL_FRICTION):
        hints.append(f"The friction coefficient {problem.f.max():g} is unusually large: is it in percent?")
    return [*hints, *_units_in_doubt(problem)]


def _units_in_doubt(problem: Problem) -> Iterator[str]:
    """Inconsistent numbers, as where one file is in mm and another one in m."""
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
