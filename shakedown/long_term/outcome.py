"""What becomes of a joint under cyclic loading, judged cycle by cycle."""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from shakedown.model.problem import FloatArray


class Outcome(StrEnum):
    """Long-term state of a contact under periodic loading.

    SHAKEDOWN
        Frictional slip has ceased and every node stays closed.
    CYCLIC_SLIP
        Nodes slip in every period and return to where they were.
    RATCHETTING
        Slips grow by a constant amount per period.
    SEPARATION
        Frictional slip has ceased, but a node is open during part of the period or all of it.
    UNDECIDED
        None of these could be established; the reason says why.
    """

    SHAKEDOWN = "shakedown"
    CYCLIC_SLIP = "cyclic-slip"
    RATCHETTING = "ratchetting"
    SEPARATION = "separation"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Cycles:
    """Record of a simulation, one row per cycle simulated so far.

    Attributes
    ----------
    end_slip : (c + 1, n)
        Slip before the first and after every cycle [length].
    slip : (c, n)
        Σ|Δv| in contact during every cycle [length].
    dissipation : (c,)
        Frictional dissipation of every cycle [force × length].
    open_nodes : (c, n)
        Whether a node was open at some load step of the cycle.
    """

    end_slip: FloatArray
    slip: FloatArray
    dissipation: FloatArray
    open_nodes: np.ndarray


@dataclass(frozen=True)
class Verdict:
    """An outcome with its period in cycles and the drift of the slip per period, (n,) [length]."""

    outcome: Outcome
    period: int
    drift: FloatArray
    reason: str


LONGEST_PERIOD = 2
WINDOW = 2 * LONGEST_PERIOD + 1  # cycles that `judge` looks back


def judge(cycles: Cycles, threshold: float) -> Verdict | None:
    """The long-term state that the last cycles show, or None while there is none yet.

    Evidence, not proof: slips below ``threshold`` [length] count as none, and
    each finding must hold over two cycles (two periods) in a row.
    """
    count = len(cycles.slip)
    if count < 2:
        return None
    still = np.zeros(cycles.slip.shape[1])
    if cycles.slip[-2:].max() <= threshold:
        if cycles.open_nodes[-1].any():
            where = ", ".join(map(str, np.flatnonzero(cycles.open_nodes[-1])[:8]))
            reason = f"no frictional slip, but contact is lost at node {where}"
            return Verdict(Outcome.SEPARATION, 1, still, reason)
        return Verdict(Outcome.SHAKEDOWN, 1, still, "no frictional slip in the last two cycles")
    for period in range(1, LONGEST_PERIOD + 1):
        verdict = _periodic(cycles, period, threshold)
        if verdict is not None:
            return verdict
    return None


def _periodic(cycles: Cycles, period: int, threshold: float) -> Verdict | None:
    """Cyclic slip or ratchetting of the given period, seen over two periods."""
    if len(cycles.slip) < 2 * period + 1:
        return None
    steps = [cycles.end_slip[-1 - k] - cycles.end_slip[-1 - k - period] for k in range(period + 1)]
    slip = cycles.slip[-period:].sum(axis=0).max()
    # A slow approach to shakedown has increments of the size of its slip; a limit cycle has none.
    if slip <= 1e3 * threshold:
        return None
    if max(np.abs(step).max() for step in steps) <= threshold:
        reason = f"the same slip every {cycles_in_words(period)}"
        return Verdict(Outcome.CYCLIC_SLIP, period, np.zeros_like(steps[0]), reason)
    change = max(np.abs(step - steps[0]).max() for step in steps[1:])
    if change <= threshold and np.abs(steps[0]).max() > 1e3 * threshold:
        reason = f"the same drift every {cycles_in_words(period)}"
        return Verdict(Outcome.RATCHETTING, period, steps[0], reason)
    return None


def cycles_in_words(period: int) -> str:
    """A period after the word "every"."""
    return "cycle" if period == 1 else f"{period} cycles"
