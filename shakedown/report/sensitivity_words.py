"""Which node limits a joint, and what one per cent more friction or load there does."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.evidence import Missing
from shakedown.ground.float_array import FloatArray
from shakedown.report.node_words import node_in_words

if TYPE_CHECKING:
    from shakedown.assessment.every_limit import Limits
    from shakedown.assessment.sensitivities import Sensitivities
    from shakedown.joint.problem import Problem

CAUSES = {"friction": "friction", "constant": "constant load", "amplitude": "load amplitude"}
IN_SPACE = (
    "Which node limits λ_max and λ_E most, and by how much, is computed in the plane only, so far. Those "
    "that reach their limits at λ_max, and in which load steps, stand in the table above."
)
SLIGHT = 5e-4  # of a per cent: what is said to change nothing


def sensitivities_in_words(limits: Limits) -> list[str]:
    """Which node limits λ_max, and which λ_E, most, and by how much the limit moves with one per cent there.

    Examples
    --------
    >>> import shakedown
    >>> for line in sensitivities_in_words(shakedown.assess(shakedown.example("two-node")).details):
    ...     print(line)
    λ_max is limited most at node 1: +0.92 % for 1 % more friction, +0.96 % for 1 % more constant
    load, −0.97 % for 1 % more load amplitude there.
    λ_E is limited most at node 1: +0.95 % for 1 % more friction, +0.95 % for 1 % more constant
    load, −0.97 % for 1 % more load amplitude there.
    """
    if limits.problem.directions > 1:
        return [IN_SPACE]
    symbols = {"upper": "λ_max", "energy": "λ_E"}
    sentences = [
        f"Which node limits {symbols[name]} is left out: {found.reason} (docs/interpretation.md)."
        if isinstance(found, Missing)
        else limited_in_words(found, limits.problem)
        for name, found in limits.sensitivities.items()
    ]
    return [sentence for sentence in sentences if sentence]


def limited_in_words(found: Sensitivities, problem: Problem) -> str:
    """Which node limits one bound; empty where there is no derivative."""
    ranked = found.ranked()
    if not ranked.size:
        return ""
    node = int(ranked[0])
    effects = [_effect(getattr(found, kind).elasticity[node], name) for kind, name in CAUSES.items()]
    where = node_in_words(problem, node)
    return f"{found.symbol} is limited most at {where}: {', '.join(filter(None, effects))} there."


def _effect(sides: FloatArray, name: str) -> str:
    """What one per cent more of something does, and one per cent less where that is not the opposite."""
    fallen, grown = sides
    if np.isnan(fallen) or np.isnan(grown):
        return ""
    more = f"{_signed(grown)} for 1 % more {name}"
    alike = abs(grown - fallen) <= SLIGHT * max(1.0, abs(grown))
    return more if alike else f"{more} ({_signed(-fallen)} for 1 % less)"


def _signed(percent: float) -> str:
    return f"{percent:+.2g} %".replace("-", "−") if abs(percent) >= SLIGHT else "0 %"
