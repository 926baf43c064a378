"""The verdict at fixed steps: what the last recorded cycles show."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import cycles_in_words, nodes_in_words
from shakedown.ground.status import Outcome
from shakedown.motion.fixed_steps import REMEMBERED
from shakedown.motion.method import CycleRecord

LONGEST_PERIOD = REMEMBERED  # cycles


@dataclass(frozen=True)
class Verdict:
    """An outcome with its period in cycles and the drift of the slip per period, (n,) [length]."""

    outcome: Outcome
    period: int
    drift: FloatArray
    reason: str
    open_nodes: tuple[int, ...] = ()  # open through the whole period


def recorded_verdict(cycles: Sequence[CycleRecord], threshold: FloatArray) -> Verdict | None:
    """The long-term state that the last cycles show, or None while they show none.

    Evidence, not proof: slips of a node below its ``threshold``, (n,) [length], count as none, and
    each finding must hold over two cycles (two periods) in a row.
    """
    if len(cycles) < 2:
        return None
    last, still = cycles[-1], np.zeros_like(cycles[-1].end_slip)
    if all(np.all(cycle.slip <= threshold) for cycle in cycles[-2:]):
        stays_open, breathing = _numbers(~last.closed), _numbers(last.opened & last.closed)
        if breathing:
            reason = f"no frictional slip, but opening and closing every cycle: {nodes_in_words(breathing)}"
            return Verdict(Outcome.SEPARATION, 1, still, reason, stays_open)
        reason = "no frictional slip in the last two cycles"
        return Verdict(Outcome.SHAKEDOWN, 1, still, reason, stays_open)
    for period in range(1, LONGEST_PERIOD + 1):
        verdict = _periodic(cycles, period, threshold)
        if verdict is not None:
            return verdict
    return None


def _periodic(cycles: Sequence[CycleRecord], period: int, threshold: FloatArray) -> Verdict | None:
    """Cyclic slip or ratchetting of the given period, seen over two periods."""
    if len(cycles) < 2 * period + 1:
        return None
    stays_open = _numbers(~np.any([cycle.closed for cycle in cycles[-period:]], axis=0))
    steps = [cycles[-1 - k].end_slip - cycles[-1 - k - period].end_slip for k in range(period + 1)]
    slip = np.sum([cycle.slip for cycle in cycles[-period:]], axis=0)
    # In a slow approach to shakedown the increments are as large as the slip; a limit cycle has none.
    if np.all(slip <= 1e3 * threshold):
        return None
    none = np.repeat(threshold, len(steps[0]) // len(threshold))
    if np.all(np.abs(steps) <= none):
        reason = f"slip per {cycles_in_words(period)} constant"
        return Verdict(Outcome.CYCLIC_SLIP, period, np.zeros_like(steps[0]), reason, stays_open)
    steady = np.all(np.abs(np.subtract(steps, steps[0])) <= none)
    if steady and np.any(np.abs(steps[0]) > 1e3 * none):
        reason = f"drift per {cycles_in_words(period)} constant"
        return Verdict(Outcome.RATCHETTING, period, steps[0], reason, stays_open)
    return None


def _numbers(nodes: NDArray[np.bool_]) -> tuple[int, ...]:
    """The numbers of the marked nodes."""
    return tuple(np.flatnonzero(nodes).tolist())
