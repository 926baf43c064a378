"""The long-term states that one joint settles into from many initial slips."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.errors import UsageError
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.limit_search import LONGEST_PERIOD
from shakedown.long_term.outcome import Outcome
from shakedown.long_term.state import LongTermState
from shakedown.model.arguments import (
    check_arguments,
    check_count,
    checked_initial_slip,
    real_array,
    require_problem,
)
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.result import Result
from shakedown.tolerances import DEFAULT, Tolerances

OUTCOMES = np.dtype(f"U{max(map(len, Outcome))}")


@dataclass(frozen=True, eq=False, repr=False)
class LongTermStates(Result):
    """Result of :func:`long_term_states`, one row or entry per initial slip.

    Attributes
    ----------
    load_factor
        λ.
    initial_slip : (s, n)
        Slips at the start [length].
    final_slip : (s, n)
        Slips at the end of a period of the long-term state, or where the search has ended [length].
    outcome : (s,)
        Values of :class:`Outcome`.
    period : (s,)
        Cycles after which the state repeats; 0 where undecided, and where the body leaves.
    dissipation : (s,)
        What friction and jumps take per cycle, averaged over the period [force × length]; NaN
        where undecided.
    slip_per_cycle : (s, n)
        Σ|Δv| in contact over one period [length]; NaN where undecided.
    contraction : (s,)
        Factor per cycle by which the distance to the long-term state shrinks in the end; 0
        where it is reached exactly, NaN where undecided.
    cycles_simulated : (s,)
        Effort: cycles followed in all.
    signature : (s,)
        Identifies the contact states of one period of the long-term state and the changes between
        them, wherever the period is cut; 0 where undecided, and where the body leaves.
    compiled : (s,)
        Whether the state was decided within the compiled loop, and not by :func:`long_term_state`.
    """

    load_factor: float
    initial_slip: FloatArray
    final_slip: FloatArray
    outcome: NDArray[np.str_]
    period: NDArray[np.int64]
    dissipation: FloatArray
    slip_per_cycle: FloatArray
    contraction: FloatArray
    cycles_simulated: NDArray[np.int64]
    signature: NDArray[np.uint64]
    compiled: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.outcome)


def long_term_states(
    problem: Problem,
    load_factor: float,
    initial_slips: ArrayLike,
    *,
    max_cycles: int = 1000,
    longest_period: int = LONGEST_PERIOD,
    tolerances: Tolerances = DEFAULT,
    threads: int = 1,
) -> LongTermStates:
    """What becomes of a joint under its loading loop from each of many initial slips.

    State by state the answer is that of :func:`long_term_state`. It depends neither on the
    other states of the batch nor on the number of threads.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    initial_slips : (s, n)
        Slips at the start [length]. Transient load steps, where the problem has them, come
        before the first period.
    max_cycles, longest_period, tolerances
        As for :func:`long_term_state`.
    threads
        How many threads share the states.

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("three-node")
    >>> states = long_term_states(joint, 2.6, [joint.initial_slip[0], [0.0, 0.0, 0.0]])
    >>> states.outcome.tolist(), states.slip_per_cycle.round(6).tolist()
    (['cyclic-slip', 'shakedown'], [[3.854489, 0.0, 0.0], [0.0, 0.0, 0.0]])
    """
    check_arguments(load_factor, max_cycles)
    check_count("longest_period", longest_period)
    check_count("threads", threads)
    starts = checked_initial_slips(problem, initial_slips)
    states = _room(float(load_factor), starts)
    for row, start in enumerate(starts):
        one = long_term_state(
            problem,
            load_factor,
            start,
            max_cycles=max_cycles,
            longest_period=longest_period,
            tolerances=tolerances,
        )
        _enter(states, row, one)
    return states


def checked_initial_slips(problem: Problem, initial_slips: ArrayLike) -> FloatArray:
    """Initial slips as a private array (s, n); raises ``UsageError`` if mis-shaped or too large."""
    require_problem(problem)
    slips = real_array("initial slips", initial_slips)
    if slips.ndim != 2 or slips.shape[1] != problem.n:
        raise UsageError(f"initial slips: expected shape (s, {problem.n}), found {slips.shape}")
    checked_initial_slip(problem, np.abs(slips).max(axis=0, initial=0.0))
    return slips


def _room(load_factor: float, starts: FloatArray) -> LongTermStates:
    s, n = starts.shape
    return LongTermStates(
        load_factor=load_factor,
        initial_slip=starts,
        final_slip=np.full((s, n), np.nan),
        outcome=np.full(s, Outcome.UNDECIDED.value, dtype=OUTCOMES),
        period=np.zeros(s, dtype=np.int64),
        dissipation=np.full(s, np.nan),
        slip_per_cycle=np.full((s, n), np.nan),
        contraction=np.full(s, np.nan),
        cycles_simulated=np.zeros(s, dtype=np.int64),
        signature=np.zeros(s, dtype=np.uint64),
        compiled=np.zeros(s, dtype=np.bool_),
    )


def _enter(states: LongTermStates, row: int, one: LongTermState) -> None:
    """The answer for one initial slip."""
    states.final_slip[row], states.slip_per_cycle[row] = one.final_slip, one.slip_per_cycle
    states.outcome[row], states.period[row] = one.outcome.value, one.period
    states.dissipation[row], states.contraction[row] = one.dissipation_per_cycle, one.contraction
    states.cycles_simulated[row], states.signature[row] = one.cycles_simulated, one.signature
