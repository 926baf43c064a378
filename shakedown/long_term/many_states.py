"""The long-term states that one joint settles into from many initial slips."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import (
    MANY,
    check_arguments,
    check_count,
    checked,
    checked_initial_slip,
    real_array,
    require_plane,
    require_problem,
)
from shakedown.joint.loading import transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.cycle_map import limit
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.limit_search import LONGEST_PERIOD
from shakedown.long_term.settling.path_check import Scale, path_check
from shakedown.long_term.settling.period_map import period_map
from shakedown.long_term.settling.search import (
    CYCLIC_SLIP,
    HANDED_OVER,
    LIMIT_WANTED,
    RATCHETTING,
    SEPARATION,
    SHAKEDOWN,
    Answers,
    Rules,
    Search,
    search,
)
from shakedown.long_term.settling.settle import nodes_of_map, restart, settle, take_limit
from shakedown.long_term.state import LongTermState
from shakedown.motion.integrator import RECORD_ROWS, ROUNDING, Evolution
from shakedown.motion.kernels.event_loop import DONE, EFFORT, PAUSED
from shakedown.motion.kernels.moving_state import room_for
from shakedown.motion.kernels.run import run_along

BLOCK = 4096  # states that a thread takes at once
MOST_REMEMBERED = 4096  # states between two cycles
OUTCOMES = np.dtype(f"U{max(map(len, Outcome))}")
NAMES = np.full(SEPARATION + 1, Outcome.UNDECIDED.value, dtype=OUTCOMES)
NAMES[SHAKEDOWN], NAMES[CYCLIC_SLIP] = Outcome.SHAKEDOWN.value, Outcome.CYCLIC_SLIP.value
NAMES[RATCHETTING], NAMES[SEPARATION] = Outcome.RATCHETTING.value, Outcome.SEPARATION.value


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
        where it is reached exactly, NaN where undecided. An estimate, limited by round-off:
        that of :func:`long_term_state` may differ from it by a few per cent.
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


@checked
@on_one_thread
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
    require_plane("long-term states", problem)
    check_arguments(load_factor, max_cycles, problem)
    check_count("longest_period", longest_period, MANY)
    check_count("threads", threads)
    starts = checked_initial_slips(problem, initial_slips)
    states = _room(float(load_factor), starts)
    batch = _Batch(problem, states, max_cycles, longest_period, tolerances)
    batch.run(min(threads, max(len(starts), 1)))
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


class _Batch:
    """The states to be found, in blocks that threads take one after the other."""

    def __init__(
        self, problem: Problem, states: LongTermStates, most: int, longest_period: int, tolerances: Tolerances
    ) -> None:
        self.problem, self.states, self.tolerances = problem, states, tolerances
        self.most, self.longest_period = most, longest_period
        self.blocks = count()
        self.stopped = False

    def run(self, threads: int) -> None:
        """Find all states; an interrupt ends every thread within a fraction of a second or one state."""
        size = max(1, min(BLOCK, len(self.states) // (8 * threads)))
        if threads == 1:
            self._work(size)
            return
        with ThreadPoolExecutor(threads) as pool:
            workers = [pool.submit(self._work, size) for _ in range(threads)]
            try:
                for worker in workers:
                    worker.result()
            finally:
                self.stopped = True

    def _work(self, size: int) -> None:
        """Take blocks of so many states until there are none left."""
        if not len(self.states):
            return
        compiled = self._search()
        while not self.stopped:
            first = next(self.blocks) * size
            if first >= len(self.states):
                return
            self._settle(compiled, slice(first, first + size))

    def _search(self) -> Search:
        """A compiled search for the states of this joint."""
        problem, t = self.problem, self.tolerances
        evolution, n = Evolution(problem, self.states.load_factor, None, t), problem.n
        parts = evolution.active, evolution.rates, evolution.motion
        transient = np.vstack([problem.layout.zeros(1), transient_path(problem)])  # row 0: initial slip
        first = run_along(*parts, room_for(0, n), evolution.course_after(transient))
        cyclic, recorded = (
            run_along(*parts, room_for(rows, n), evolution.course_after(evolution.load[-1:]))
            for rows in (0, RECORD_ROWS)
        )
        scale = evolution.scale
        rules = Rules(
            most_cycles=self.most,
            longest_period=self.longest_period,
            capacity=min(self.most + self.longest_period, MOST_REMEMBERED),
            least_force=scale.force,
            limit=t.limit,
            rounding=ROUNDING,
            friction_law=t.friction_law,
            stiffness=float(np.abs(evolution.kappa).max()),
        )
        check = path_check(n, Scale(scale.force, scale.length, t.periodicity * scale.length))
        return search((first, cyclic, recorded), period_map(n), check, rules)

    def _settle(self, search: Search, block: slice) -> None:
        """Find the states of a block, in compiled code and where that hands over by the single search."""
        starts, states = self.states.initial_slip[block], self.states
        verdict = np.full(len(starts), HANDED_OVER)
        answers = Answers(
            states.final_slip[block],
            states.slip_per_cycle[block],
            states.dissipation[block],
            states.contraction[block],
            verdict,
            states.period[block],
            states.cycles_simulated[block],
            states.signature[block],
        )
        restart(search)
        status = PAUSED
        while status != DONE and not self.stopped:
            status = settle(search, starts, answers, EFFORT)
            if status == LIMIT_WANTED:
                _give_limit(search)
        states.outcome[block] = NAMES[verdict]
        states.compiled[block] = verdict != HANDED_OVER
        for row in block.start + np.flatnonzero(verdict == HANDED_OVER):
            if not self.stopped:
                _enter(states, row, self._one(states.initial_slip[row]))

    def _one(self, start: FloatArray) -> LongTermState:
        return long_term_state(
            self.problem,
            self.states.load_factor,
            start,
            max_cycles=self.most,
            longest_period=self.longest_period,
            tolerances=self.tolerances,
        )


def _give_limit(search: Search) -> None:
    """The limit of an affine map that drifts, or nearly so."""
    affine, k = search.map, nodes_of_map(search)
    end = limit(affine.power.ravel()[: k * k].reshape(k, k), affine.change[:k])
    affine.limit[:k], affine.drift[:k] = end.change, end.drift
    take_limit(search, end.decaying, end.contraction)


def _enter(states: LongTermStates, row: int, one: LongTermState) -> None:
    """The answer for one initial slip."""
    states.final_slip[row], states.slip_per_cycle[row] = one.final_slip, one.slip_per_cycle
    states.outcome[row], states.period[row] = one.outcome.value, one.period
    states.dissipation[row], states.contraction[row] = one.dissipation_per_cycle, one.contraction
    states.cycles_simulated[row], states.signature[row] = one.cycles_simulated, one.signature
