"""Long-term states of one or many starts, of a joint and of the parts that it falls into."""

from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from functools import partial, reduce
from math import lcm
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.argument_kinds import check_count
from shakedown.ground.constants import BATCH, CYCLES, MOST_ENTRIES, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import nodes_in_words
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import on_one_thread, work_again
from shakedown.joint.arguments import (
    check_arguments,
    checked,
    checked_initial_slip,
    real_array,
    require_problem,
    reused,
)
from shakedown.joint.contact_zone import Part, coupled_parts, of_nodes, of_slips
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.limit_search import LONGEST_PERIOD, OUTCOMES, LimitSearch, empty_answers
from shakedown.long_term.plane.phase_loop import Verdict
from shakedown.long_term.plane.search import Answers
from shakedown.long_term.proved_outcome import RETURN_TOLERANCE
from shakedown.long_term.space.steady_search import SteadySearches
from shakedown.long_term.state import LongTermState
from shakedown.motion.checked_law import scales
from shakedown.motion.course import HASH_PRIME
from shakedown.motion.method import State, beginning

ORDER = Outcome.SHAKEDOWN, Outcome.SEPARATION, Outcome.CYCLIC_SLIP, Outcome.RATCHETTING, Outcome.UNDECIDED
OF_SLIPS, OF_NODES = ("initial_slip", "final_slip", "drift"), ("slip_per_cycle", "opened")
SUMS = [
    "friction_dissipation_per_cycle",
    "jump_dissipation_per_cycle",
    "jumps_per_cycle",
    "dissipations",
    "events",
]


def joined_state(
    problem: Problem, open_nodes: tuple[int, ...], parts: Sequence[Part], found: Sequence[LongTermState]
) -> LongTermState:
    """The long-term state of a joint from those of its parts.

    The outcome is the worst, the period the least common multiple; where a part is undecided or has come
    apart there is none, and no slip, drift or work per cycle of all.
    """
    worst, period = max(found, key=_rank), lcm(*(state.period for state in found))
    cycles = max(state.cycles_simulated for state in found)
    states = [_over(period, state, cycles) for state in found]

    def slips(value: Callable[[LongTermState], FloatArray]) -> FloatArray:
        return of_slips(parts, map(value, states))

    def nodes(value: Callable[[LongTermState], NDArray[Any]]) -> NDArray[Any]:
        return of_nodes(parts, map(value, states))

    u = problem.layout.joined(
        slips(lambda state: state.goal.u[state.problem.layout.slips]),
        nodes(lambda state: state.goal.u[state.problem.layout.gaps]),
    )
    lengths = [scales(each, worst.load_factor).length for each in (problem, *(part.joint for part in parts))]
    missed = [state.return_error * length for state, length in zip(states, lengths[1:], strict=True)]
    opened = [part.number(i) for part, state in zip(parts, states, strict=True) for i in state.open_nodes]
    more: dict[str, Any] = {word: slips(attrgetter(word)) for word in OF_SLIPS}
    more |= {word: nodes(attrgetter(word)) for word in OF_NODES}
    more |= {word: sum(getattr(state, word) for state in states) for word in SUMS}
    return replace(
        worst,
        problem=problem,
        reason=_reason(parts, found),
        period=period,
        open_nodes=tuple(sorted(opened)),
        cycles_simulated=cycles,
        slides_away=any(state.slides_away for state in states),
        contraction=float(np.max([state.contraction for state in states])),
        return_error=float(np.max(missed)) / lengths[0],
        error=float(np.max([state.error for state in states])),
        signature=reduce(lambda known, state: (known ^ state.signature) * int(HASH_PRIME) % 2**64, states, 0),
        met=float(np.fmax.reduce([state.met for state in states])),
        origin=replace(worst.origin, problem=problem, start=more["initial_slip"], open_nodes=open_nodes),
        goal=State(u, nodes(lambda state: state.goal.contact)),
        first_cycles=None,
        jumps=(),
        proof=None,
        parts=tuple(found),
        **more,
    )


def _rank(state: LongTermState) -> float:
    """How bad an outcome is; worse than ratchetting is a part that has come apart for good."""
    apart = state.outcome == Outcome.SEPARATION and not state.period
    return ORDER.index(Outcome.RATCHETTING) + 0.5 if apart else ORDER.index(state.outcome)


def _over(period: int, state: LongTermState, cycles: int) -> LongTermState:
    """The state of a part over a multiple of its period, in step with others after so many cycles."""
    if not period:
        return state.without_period()
    times, ahead = period // state.period, (cycles - state.cycles_simulated) % state.period
    goal, start = state.goal, state.final_slip - state.drift
    if ahead:
        motion = state.motion()
        with work_again():
            motion.advance(ahead)
        goal = motion.state
        start = goal.u[state.problem.layout.slips]
    return replace(
        state,
        goal=goal,
        final_slip=start + times * state.drift,
        drift=times * state.drift,
        slip_per_cycle=times * state.slip_per_cycle,
        dissipations=np.tile(np.roll(state.dissipations, -ahead), times),
    )


def _reason(parts: Sequence[Part], found: Sequence[LongTermState]) -> str:
    """Why the worst parts do what they do, and what the others do."""
    most, reasons, others = max(map(_rank, found)), dict[str, list[int]](), set[str]()
    for part, state in zip(parts, found, strict=True):
        if _rank(state) == most:
            reasons.setdefault(part.renumbered(state.reason), []).extend(part.nodes.tolist())
        else:
            others.add(state.outcome.value)
    if len(reasons) == 1 and not others:
        return next(iter(reasons))
    # at most three are listed
    texts = [f"{text} ({nodes_in_words(sorted(nodes))})" for text, nodes in reasons.items()][:3]
    left = [f"the nodes uncoupled from them: {', '.join(sorted(others))}"] * bool(others)
    return "; ".join([*texts, *left])


NAMES = np.array([outcome.value for outcome in OUTCOMES])


@checked
def long_term_state(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    *,
    open_nodes: Iterable[int] = (),
    max_cycles: int = CYCLES,
    longest_period: int = LONGEST_PERIOD,
    tolerances: Tolerances = DEFAULT,
) -> LongTermState:
    """Find the long-term state of a joint under its loading loop, by extrapolation instead of cycling.

    The response may repeat after 1, 2, … ``longest_period`` load cycles. As soon as that many
    cycles pass through the same sequence of contact states as those before them, the map
    from the start of one such period to the next is affine there, v ↦ J v + c. Its
    limit follows from the geometric series. It is accepted when the states
    2, 4, 8, … periods ahead still pass through that sequence, and when one more
    exact period from the limit returns to it.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    initial_slip : (n,), optional
        Slip at the start [length]; zero by default. Transient load steps, where the
        problem has them, come before the first period.
    open_nodes
        Nodes that are open at the start, as for :func:`evolve`.
    max_cycles
        Give up after so many cycles, with the outcome "undecided". In space up to three times as many
        besides may be followed from states next to those of a slow motion, which show where it goes.
    longest_period
        Longest period looked for, in cycles.
    tolerances
        What counts as zero, as reached and as periodic (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("three-node")
    >>> state = long_term_state(joint, 2.6, joint.initial_slip[0])
    >>> state.outcome.value, state.slip_per_cycle.round(6)
    ('cyclic-slip', array([3.854489, 0.      , 0.      ]))
    """
    check_arguments(load_factor, max_cycles, problem)
    check_count("longest_period", longest_period, MOST_ENTRIES)
    opened, limits = tuple(open_nodes), (max_cycles, longest_period)
    return settled_state(problem, load_factor, initial_slip, opened, limits, tolerances)


def _search(
    problem: Problem, limits: tuple[int, int], tolerances: Tolerances
) -> AbstractContextManager[LimitSearch | SteadySearches]:
    """The last search on the problem where its settings are the same: by the map of a period, or in space."""
    kind = LimitSearch if problem.directions == 1 else SteadySearches
    build = partial(kind, problem, tolerances, *limits)
    return reused(problem, (tolerances, limits), build)


@on_one_thread
def settled_state(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None,
    open_nodes: tuple[int, ...],
    limits: tuple[int, int],
    tolerances: Tolerances,
) -> LongTermState:
    """As :func:`long_term_state`, without its checks; limits: most cycles, and the longest period."""
    parts = coupled_parts(problem, open_nodes)
    if len(parts) > 1:
        start = beginning(problem, load_factor, initial_slip, open_nodes, tolerances)[0].u
        of_parts = [(part.joint, start[part.slips], part.among(open_nodes)) for part in parts]
        found = [
            settled_state(joint, load_factor, slip, opened, limits, tolerances)
            for joint, slip, opened in of_parts
        ]
        return joined_state(problem, open_nodes, parts, found)

    with _search(problem, limits, tolerances) as search:
        search.begin(float(load_factor), initial_slip, open_nodes)
        return search.state(open_nodes)


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
    """Find the long-term state of a joint under its loading loop from each of many initial slips.

    State by state the answer is that of :func:`long_term_state`. Only, of states in the plane that go
    through the same contact states in every cycle and hardly slip, the first is compared with what is
    proved, and the others where its answer changes.

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
    check_count("longest_period", longest_period, MOST_ENTRIES)
    check_count("threads", threads)
    starts = checked_initial_slips(problem, initial_slips)
    limits = max_cycles, longest_period
    batch = _Batch(problem, float(load_factor), starts, limits, tolerances)
    batch.run(min(threads, max(len(starts), 1)))
    found = batch.answers._asdict()
    outcome = NAMES[found.pop("verdict")]
    return LongTermStates(load_factor=batch.load_factor, initial_slip=starts, outcome=outcome, **found)


def checked_initial_slips(problem: Problem, initial_slips: ArrayLike) -> FloatArray:
    """Initial slips as a private array (s, n); raises ``UsageError`` if mis-shaped or too large."""
    require_problem(problem)
    slips = real_array("initial slips", initial_slips)
    size = problem.layout.slip_size
    if slips.ndim != 2 or slips.shape[1] != size:
        raise UsageError(f"initial slips: expected shape (s, {size}), found {slips.shape}")
    checked_initial_slip(problem, np.abs(slips).max(axis=0, initial=0.0))
    return slips


@dataclass
class _Batch:
    """The states to be found, in blocks that are distributed over threads."""

    problem: Problem
    load_factor: float
    starts: FloatArray
    limits: tuple[int, int]
    tolerances: Tolerances

    def __post_init__(self) -> None:
        self.answers, self.stopped = empty_answers(len(self.starts), self.problem.layout), False

    def run(self, threads: int) -> None:
        """Find all states; an interrupt ends every thread within a fraction of a second or one state."""
        # in space the paths of so many states are held against the law together, and kept until then
        most = BATCH if self.problem.directions == 1 else 64
        size = most if threads == 1 else max(1, min(most, len(self.starts) // (8 * threads)))
        blocks = [slice(first, first + size) for first in range(0, len(self.starts), size)]
        if threads == 1:
            for block in blocks:
                self._fill(block)
            return
        with ThreadPoolExecutor(threads) as pool:
            try:
                list(pool.map(self._fill, blocks))
            finally:
                self.stopped = True

    def _fill(self, block: slice) -> None:
        """Find the states of a block; each part of a joint in uncoupled parts has its own proofs."""
        starts, answers = self.starts[block], Answers._make(column[block] for column in self.answers)
        if len(coupled_parts(self.problem)) > 1:
            states: Iterable[LongTermState] = (self._alone(start) for start in starts if not self.stopped)
        else:
            with _search(self.problem, self.limits, self.tolerances) as search:
                search.begin(self.load_factor, None, ())
                states = search.from_slips(starts, answers, lambda: self.stopped)
            if isinstance(search, LimitSearch) and not self.stopped:
                self._overrule_by_proofs(starts, answers)
        for k, state in enumerate(states):
            _enter(state, answers, k)

    def _overrule_by_proofs(self, starts: FloatArray, answers: Answers) -> None:
        """Recompute single answers that are undecided, or cycles with negligible slip.

        Among cycles through the same contact states the first decides, unless its answer changes.
        """
        none = self.tolerances.periodicity * scales(self.problem, self.load_factor).length / RETURN_TOLERANCE
        slips = np.nan_to_num(answers.slip_per_cycle).max(axis=1, initial=0.0)
        found, (most, _) = answers.verdict, self.limits
        cycles = (found > Verdict.SHAKEDOWN) & ((found != Verdict.CYCLIC_SLIP) | (slips < none))
        spent = (found == Verdict.UNDECIDED) & (answers.cycles_simulated >= most)
        for signature in np.unique(answers.signature[cycles]):
            for k in np.flatnonzero(cycles & (answers.signature == signature)).tolist():
                if not self._differs(starts[k], answers, k):
                    break
        for k in np.flatnonzero(spent | (found == Verdict.BLURRED)).tolist():
            self._differs(starts[k], answers, k)

    def _alone(self, start: FloatArray) -> LongTermState:
        """The single answer for a start."""
        return settled_state(self.problem, self.load_factor, start, (), self.limits, self.tolerances)

    def _differs(self, start: FloatArray, answers: Answers, k: int) -> bool:
        """Whether the single answer for a start differs; if so it is entered."""
        state = self._alone(start)
        if OUTCOMES[answers.verdict[k]] == state.outcome:
            return False
        _enter(state, answers, k)
        return True


def _enter(state: LongTermState, answers: Answers, k: int) -> None:
    """Enter a long-term state into a row of answers."""
    answers.verdict[k], answers.dissipation[k] = OUTCOMES.index(state.outcome), state.dissipation_per_cycle
    for word in ("final_slip", "slip_per_cycle", "contraction", "period", "cycles_simulated", "signature"):
        getattr(answers, word)[k] = getattr(state, word)
