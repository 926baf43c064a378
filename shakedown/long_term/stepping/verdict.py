"""How the last cycles of a motion are judged: by what they slip, over two of them or two periods in a row."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import cycles_in_words, nodes_in_words
from shakedown.ground.status import Outcome
from shakedown.long_term.stepping.cycle_log import Cycles


@dataclass(frozen=True)
class Verdict:
    """An outcome with its period in cycles and the drift of the slip per period, (n,) [length]."""

    outcome: Outcome
    period: int
    drift: FloatArray
    reason: str
    open_nodes: tuple[int, ...] = ()  # through the whole period


LONGEST_PERIOD = 2
WINDOW = 2 * LONGEST_PERIOD + 1  # cycles that `judge` looks back


def judge(cycles: Cycles, always_open: NDArray[np.bool_], threshold: float) -> Verdict | None:
    """The long-term state that the last cycles show, or None while there is none yet.

    Evidence, not proof: slips below ``threshold`` [length] count as none, and
    each finding must hold over two cycles (two periods) in a row. ``always_open``
    (c, n): whether a node was open at every load step of the cycle.
    """
    count = len(cycles.slip)
    if count < 2:
        return None
    still = np.zeros(cycles.slip.shape[1])
    if cycles.slip[-2:].max() <= threshold:
        stays_open = _numbers(always_open[-1])
        breathing = _numbers(cycles.open_nodes[-1] & ~always_open[-1])
        if breathing:
            reason = f"no frictional slip, but opening and closing every cycle: {nodes_in_words(breathing)}"
            return Verdict(Outcome.SEPARATION, 1, still, reason, stays_open)
        reason = "no frictional slip in the last two cycles"
        return Verdict(Outcome.SHAKEDOWN, 1, still, reason, stays_open)
    for period in range(1, LONGEST_PERIOD + 1):
        verdict = _periodic(cycles, always_open[-period:], period, threshold)
        if verdict is not None:
            return verdict
    return None


def _periodic(
    cycles: Cycles, always_open: NDArray[np.bool_], period: int, threshold: float
) -> Verdict | None:
    """Cyclic slip or ratchetting of the given period, seen over two periods."""
    if len(cycles.slip) < 2 * period + 1:
        return None
    stays_open = _numbers(np.all(always_open, axis=0))
    steps = [cycles.end_slip[-1 - k] - cycles.end_slip[-1 - k - period] for k in range(period + 1)]
    slip = cycles.slip[-period:].sum(axis=0).max()
    # A slow approach to shakedown has increments of the size of its slip; a limit cycle has none.
    if slip <= 1e3 * threshold:
        return None
    if max(np.abs(step).max() for step in steps) <= threshold:
        reason = f"the same slip every {cycles_in_words(period)}"
        return Verdict(Outcome.CYCLIC_SLIP, period, np.zeros_like(steps[0]), reason, stays_open)
    change = max(np.abs(step - steps[0]).max() for step in steps[1:])
    if change <= threshold and np.abs(steps[0]).max() > 1e3 * threshold:
        reason = f"the same drift every {cycles_in_words(period)}"
        return Verdict(Outcome.RATCHETTING, period, steps[0], reason, stays_open)
    return None


def _numbers(nodes: NDArray[np.bool_]) -> tuple[int, ...]:
    """Numbers of the nodes that are marked."""
    return tuple(np.flatnonzero(nodes).tolist())
