"""The drift of a body that creeps, as a rigid motion: by how much it turns and shifts in every cycle."""

import json
from dataclasses import dataclass
from math import nan
from typing import ClassVar

import numpy as np

from shakedown.ground.constants import SIX_DIGITS, THREE_DIGITS, FloatArray
from shakedown.ground.shown_values import few, sized
from shakedown.ground.status import Outcome
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import motions_of_a_body, rigid_slips


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class RigidDrift(Result):
    """How the first body moves in every cycle, relative to what it touches.

    Attributes
    ----------
    turn : (3,)
        Turn about the axes through the middle of the contact nodes per cycle [degrees].
    shift : (3,)
        How far this middle moves per cycle [length].
    cycles_per_revolution
        Cycles of the loading in one revolution of rolling elements; NaN where none run round.
    """

    DOCUMENT: ClassVar[str] = "turn shift cycles_per_revolution"

    turn: FloatArray
    shift: FloatArray
    cycles_per_revolution: float = nan

    def in_words(self, length: str) -> str:
        """A sentence: what it does per cycle and, under rolling elements, per revolution.

        Examples
        --------
        >>> turn = np.array([0.0, 0.0, -2e-4])
        >>> RigidDrift(turn=turn, shift=np.zeros(3), cycles_per_revolution=8.0).in_words("mm")
        'Per cycle the body turns by 0.0002° clockwise; per revolution by 0.0016°.'
        """
        (x, y, z), moves = self.turn, list[tuple[str, float, str, str]]()
        if self.turn.any():
            about = "" if not (x or y) else f" about ({few(x)}, {few(y)}, {few(z)})"
            plane = "" if about else " clockwise" if z < 0 else " counter-clockwise"
            moves.append(("turns by", float(np.linalg.norm(self.turn)), "°", about or plane))
        if self.shift.any():
            towards = ", ".join(few(part) for part in self.shift)
            moves.append(("shifts by", float(np.linalg.norm(self.shift)), length, f" along ({towards})"))
        each = " and ".join(f"{does} {_size(size, unit)}{how}" for does, size, unit, how in moves)
        if np.isnan(self.cycles_per_revolution):
            return f"Per cycle the body {each}."
        whole = (_size(self.cycles_per_revolution * size, unit) for _, size, unit, _ in moves)
        return f"Per cycle the body {each}; per revolution by {' and '.join(whole)}."


def rigid_drift(problem: Problem, outcome: Outcome, period: int, drift: FloatArray) -> RigidDrift | None:
    """The drift (dn,) per period of a state as a rigid motion; None where there is none.

    There is none where the state does not ratchet, no rigid motion of the first body keeps the contact closed
    (:func:`~shakedown.joint.rigid_slips.rigid_slips`), or the joint knows no coordinates and directions.
    Gaps come back in every cycle, so that only such a motion can drift.

    Examples
    --------
    Two nodes 2 apart, which slip along x by .001 in every cycle:

    >>> floating = Problem(
    ...     A=[[1.0, -1.0], [-1.0, 1.0]], B=np.zeros((2, 2)), f=0.5, q_w=[[1.0, 0.0]], p_w=[[3.0, 3.0]],
    ...     coordinates=[[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], normal=[[0.0, 1.0, 0.0]] * 2,
    ...     tangent=[[1.0, 0.0, 0.0]] * 2,
    ... )
    >>> rigid_drift(floating, Outcome.RATCHETTING, 1, np.array([1e-3, 1e-3])).in_words("mm")
    'Per cycle the body shifts by 0.001 mm along (0.001, 0, 0).'
    """
    if outcome != Outcome.RATCHETTING or not period or not rigid_slips(problem).pinned:
        return None
    motions, arm = motions_of_a_body(problem)
    if not motions.shape[1]:
        return None
    moved = np.zeros(problem.layout.size)
    moved[problem.layout.slips] = drift / period
    found: FloatArray = np.linalg.lstsq(motions, moved, rcond=SIX_DIGITS)[0].astype(float)
    largest = float(np.abs(moved).max())
    if np.abs(motions @ found - moved).max() > THREE_DIGITS * largest:
        return None  # several bodies, or one that its supports guide
    found[np.abs(found) <= THREE_DIGITS * largest] = 0.0  # round-off, of turns at the farthest node
    return RigidDrift(
        turn=np.degrees(found[3:] / arm),
        shift=found[:3],
        cycles_per_revolution=_cycles_per_revolution(problem),
    )


def _cycles_per_revolution(problem: Problem) -> float:
    """How many rolling elements run round, as ``source`` tells it (:class:`shakedown.fem.RollingLoad`)."""
    bodies = json.loads(problem.source).get("bodies", []) if problem.source else []
    counts = {
        load["elements"]
        for body in bodies
        for load in body.get("loads", [])
        if load.get("kind") == "RollingLoad"
    }
    return float(counts.pop()) if len(counts) == 1 else nan


def _size(size: float, unit: str) -> str:
    return f"{few(size)}°" if unit == "°" else sized(size, unit)
