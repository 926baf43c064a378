"""The long-term states of one joint from many initial slips."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import count

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.argument_kinds import check_count
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import BATCH, CYCLES, MANY
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import (
    check_arguments,
    checked,
    checked_initial_slip,
    real_array,
    require_problem,
)
from shakedown.joint.coupled_parts import coupled_parts
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.find_state import Patience, settled_state
from shakedown.long_term.limit_search import LONGEST_PERIOD, OUTCOMES, LimitSearch, empty_answers
from shakedown.long_term.plane.search import BLURRED, CYCLIC_SLIP, SHAKEDOWN, UNDECIDED, Answers
from shakedown.long_term.space.proved_verdict import CLEAR
from shakedown.long_term.space.returned_state import ReturnedStates, enter
from shakedown.long_term.state import LongTermState
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import Evolution

NAMES = np.array([outcome.value for outcome in OUTCOMES])


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

    def __len__(self) -> int:
        return len(self.outcome)


@checked
@on_one_thread
def long_term_states(
    problem: Problem,
    load_factor: float,
    initial_slips: ArrayLike,
    *,
    max_cycles: int = CYCLES,
    longest_period: int = LONGEST_PERIOD,
    tolerances: Tolerances = DEFAULT,
    threads: int = 1,
) -> LongTermStates:
    """The long-term state of a joint under its loading loop from each of many initial slips.

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
    check_arguments(load_factor, max_cycles, problem)
    check_count("longest_period", longest_period, MANY)
    check_count("threads", threads)
    starts = checked_initial_slips(problem, initial_slips)
    batch = _Batch(problem, float(load_factor), starts, max_cycles, longest_period, tolerances)
    batch.run(min(threads, max(len(starts), 1)))
    found = batch.answers
    return LongTermStates(
        load_factor=float(load_factor),
        initial_slip=starts,
        final_slip=found.final_slip,
        outcome=NAMES[found.verdict],
        period=found.period,
        dissipation=found.dissipation,
        slip_per_cycle=found.slip,
        contraction=found.contraction,
        cycles_simulated=found.cycles,
        signature=found.signature,
    )


def checked_initial_slips(problem: Problem, initial_slips: ArrayLike) -> FloatArray:
    """Initial slips as a private array (s, n); raises ``UsageError`` if mis-shaped or too large."""
    require_problem(problem)
    slips = real_array("initial slips", initial_slips)
    size = problem.layout.slip_size
    if slips.ndim != 2 or slips.shape[1] != size:
        raise UsageError(f"initial slips: expected shape (s, {size}), found {slips.shape}")
    checked_initial_slip(problem, np.abs(slips).max(axis=0, initial=0.0))
    return slips


class _Batch:
    """The states to be found, in blocks that are distributed over threads."""

    def __init__(
        self,
        problem: Problem,
        load_factor: float,
        starts: FloatArray,
        most: int,
        longest: int,
        tolerances: Tolerances,
    ) -> None:
        self.problem, self.load_factor, self.starts = problem, load_factor, starts
        self.most, self.longest_period, self.tolerances = most, longest, tolerances
        self.answers = empty_answers(len(starts), problem.layout)
        self.blocks = count()
        self.stopped = False

    def run(self, threads: int) -> None:
        """Find all states; an interrupt ends every thread within a fraction of a second or one state."""
        size = max(1, min(BATCH, len(self.starts) // (8 * threads)))
        if threads == 1:
            self._work(size)
            return
        with ThreadPoolExecutor(threads) as pool:
            try:  # an interrupt may come while threads begin
                for worker in [pool.submit(self._work, size) for _ in range(threads)]:
                    worker.result()
            finally:
                self.stopped = True

    def _work(self, size: int) -> None:
        """Process blocks of a given size until none are left."""
        if not len(self.starts):
            return
        search: LimitSearch | ReturnedStates | None = None
        motion = Evolution(self.problem, self.load_factor, None, self.tolerances)
        plane = self.problem.directions == 1
        if len(coupled_parts(self.problem)) > 1:
            plane = False  # each part has been held against its own proofs
        elif plane:
            search = LimitSearch(motion, self.most, self.longest_period)
        else:
            search = ReturnedStates(motion, self.most, self.longest_period)
        while not self.stopped:
            first = next(self.blocks) * size
            if first >= len(self.starts):
                return
            block = slice(first, first + size)
            answers = Answers._make(column[block] for column in self.answers)
            if search is None:
                for k, start in enumerate(self.starts[block]):
                    if not self.stopped:
                        enter(self._alone(start), answers, k)
            else:
                search.from_slips(self.starts[block], answers, lambda: self.stopped)
            if plane and not self.stopped:
                self._heed_proofs(self.starts[block], answers)

    def _heed_proofs(self, starts: FloatArray, answers: Answers) -> None:
        """Recompute single answers that are undecided, or cycles with negligible slip.

        Among cycles through the same contact states the first decides, unless its answer changes.
        """
        none = self.tolerances.periodicity * scales(self.problem, self.load_factor).length / CLEAR
        slips = np.nan_to_num(answers.slip).max(axis=1, initial=0.0)
        cycles = (answers.verdict > SHAKEDOWN) & ((answers.verdict != CYCLIC_SLIP) | (slips < none))
        spent = (answers.verdict == UNDECIDED) & (answers.cycles >= self.most)
        for signature in np.unique(answers.signature[cycles]):
            for k in np.flatnonzero(cycles & (answers.signature == signature)).tolist():
                if not self._differs(starts[k], answers, k):
                    break
        for k in np.flatnonzero(spent | (answers.verdict == BLURRED)).tolist():
            self._differs(starts[k], answers, k)

    def _alone(self, start: FloatArray) -> LongTermState:
        """The single answer for a start."""
        patience = Patience(self.most, self.longest_period)
        return settled_state(self.problem, self.load_factor, start, (), patience, self.tolerances)

    def _differs(self, start: FloatArray, answers: Answers, k: int) -> bool:
        """Whether the single answer for a start differs; if so it is entered."""
        state = self._alone(start)
        if OUTCOMES[answers.verdict[k]] == state.outcome:
            return False
        enter(state, answers, k)
        return True
