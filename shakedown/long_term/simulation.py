"""Simulation of a joint: its motion, its long-term state, where slip exceeds what is allowed."""

import os
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property
from math import inf, nan
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.named_start import named_start
from shakedown.files.atomic_write import atomic_write
from shakedown.ground.constants import CYCLES, DISTINCT, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import count, cycles_in_words, nodes_in_words, short
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_arguments, checked, is_finite
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.find_state import settled_state
from shakedown.long_term.limit_search import LONGEST_PERIOD
from shakedown.long_term.node_results import Settled, slip_extents
from shakedown.long_term.state import LongTermState, SettledState, SteppedState, of_period
from shakedown.motion.checked_law import alone, law_resolution, load_range
from shakedown.motion.event_history import EventHistory, path_violation
from shakedown.motion.fixed_steps import REMEMBERED, FixedSteps
from shakedown.motion.method import CycleRecord, Walk, cycles_of, walk
from shakedown.motion.viscous_jump import Jump


@dataclass(frozen=True, eq=False, repr=False)
class SlipCriterion(Result):
    """Whether the slip range of every node stays below a limit.

    Attributes
    ----------
    below
        The limit [length].
    met
        Whether ``largest`` is below it; None where the long-term state is undecided.
    largest
        The largest slip range of a node in the long-term state [length] (``NodeResults.slip_range``):
        0 where it shakes down, infinite where slips grow for ever (ratchetting, a body that slides
        away) or contact is lost for good, NaN where it is undecided.
    node
        The node that it is found at; −1 where there is none.
    """

    DOCUMENT: ClassVar[str] = "below met largest node"

    below: float
    met: bool | None
    largest: float
    node: int


def slip_criterion(settled: Settled, below: float, tolerances: Tolerances = DEFAULT) -> SlipCriterion:
    """Whether every node's slip range in a settled state is below a limit."""
    if settled.slides_away or settled.outcome == Outcome.RATCHETTING:
        return SlipCriterion(below, False, inf, -1)
    if not settled.period:
        left = settled.outcome == Outcome.SEPARATION
        return SlipCriterion(below, False if left else None, inf if left else nan, -1)
    if settled.outcome == Outcome.SHAKEDOWN:
        return SlipCriterion(below, True, 0.0, -1)
    ranges = settled.problem.law.size(slip_extents(settled, tolerances))
    node, largest = int(ranges.argmax()), float(ranges.max())
    return SlipCriterion(below, largest < below, largest, node)


@checked
def check_slip_below(slip_below: float) -> float:
    """A limit on the slip range; raises ``UsageError`` unless it is finite and positive."""
    if not (is_finite(slip_below) and slip_below > 0):
        raise UsageError(f"slip_below: expected a positive length, found {slip_below!r}")
    return slip_below


METHODS = ("event", "gauss-seidel")


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Simulation(Result):
    """Result of :func:`simulate`: the settled state of the joint (:class:`SettledState`), and the path to it.

    It has all attributes of the settled state, too: ``run.outcome`` is ``run.settled.outcome``. Shakedown is
    never proved with fixed load steps, which count no events.

    Attributes
    ----------
    settled
        The settled state: a :class:`LongTermState` from event to event.
    method
        The method's name.
    followed
        The path to it, where it was recorded or judged.
    slip_criterion
        Whether its slip stays below a limit, where that was requested.
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor outcome reason period initial_slip final_slip drift slip_per_cycle "
        "dissipation_per_cycle friction_dissipation_per_cycle jump_dissipation_per_cycle jumps_per_cycle "
        "open_nodes proved energy_margin cycles_simulated method events residual jumps slides_away"
    )
    TABLE: ClassVar[str] = SettledState.TABLE

    settled: Settled
    method: str
    followed: Walk | None = field(default=None, repr=False)
    slip_criterion: SlipCriterion | None = None

    def __getattr__(self, name: str) -> Any:
        """What the settled state has."""
        if name.startswith("__") or name == "settled":  # of a copy that is being made
            raise AttributeError(name)
        return getattr(self.settled, name)

    def to_dict(self) -> dict[str, Any]:
        """The words of ``DOCUMENT``, the slip criterion where one was asked for, a drift as rigid motion."""
        more = {} if self.slip_criterion is None else {"slip_criterion": self.slip_criterion.to_dict()}
        if self.settled.rigid_drift is not None:
            more["rigid_drift"] = self.settled.rigid_drift.to_dict()
        return super().to_dict() | more

    def _shown(self) -> Iterator[tuple[str, str]]:
        for word in ("load_factor", "outcome", "settled", "method", "slip_criterion"):
            yield word, short(getattr(self, word))

    @property
    def long_term(self) -> LongTermState | None:
        """The evidence for the long-term state; None with fixed load steps."""
        return self.settled if isinstance(self.settled, LongTermState) else None

    @cached_property
    def cycles(self) -> Walk:
        """Slip, dissipation and open nodes of the cycles that were followed one by one from the start on.

        From event to event the first cycle includes the transient load steps; with fixed
        load steps these come before it and are not counted. In space, where no path was recorded, those
        before the search first leapt ahead.
        """
        if self.followed is not None or self.long_term is None:
            return self.followed or Walk(self.initial_slip, (), None)
        first_cycles = self.long_term.first_cycles
        if first_cycles is not None:
            return Walk(self.initial_slip, tuple(record for record, _ in first_cycles), None)
        return walk(self.long_term.origin.motion(), _cycles_there(self.long_term))

    @property
    def history(self) -> EventHistory | None:
        """The path over these cycles, where it was asked for: events or load steps."""
        return None if self.followed is None else self.followed.history

    @property
    def jumps(self) -> tuple[Jump, ...]:
        """Discontinuities on that path, each with the energy that it releases.

        In space, where no path was recorded, those of the cycles that the search has followed.
        """
        state = self.long_term
        in_space = state is not None and state.first_cycles is not None
        return state.jumps if state and in_space and self.followed is None else self.cycles.jumps


@checked
def simulate(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | str | None = None,
    *,
    open_nodes: Iterable[int] = (),
    cycles: int = CYCLES,
    method: str = "event",
    record: bool = False,
    slip_below: float | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Simulation:
    """Follow a joint through its transient and then cycle by cycle until the outcome is clear.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    initial_slip : (n,), optional
        Slip at the start [length], or ``"safe"``, ``"witness"`` (the critical slip state), ``"given"`` (the
        first of the problem's own), ``"zero"``; zero by default.
    open_nodes
        Nodes that are open at the start, as for :func:`evolve`.
    cycles
        Give up after so many cycles, with the outcome "undecided".
    method
        ``"event"``: exact, from event to event, the long-term state in closed form
        (:func:`long_term_state`). ``"gauss-seidel"``: the thesis's fixed load
        steps (§2.3.2, (2.15)), judged by how small the slip has become.
    record
        Keep the path: every event, or every load step.
    slip_below
        A limit on the slip range of every node in the long run [length]; the result says whether it
        holds (:class:`SlipCriterion`).

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> run = shakedown.simulate(shakedown.example("two-node"), 0.6, [0.0, 0.0])
    >>> run.outcome.value, bool(run.residual < 1e-12)
    ('shakedown', True)
    """
    check_arguments(load_factor, cycles, problem)
    if slip_below is not None:
        check_slip_below(slip_below)
    if method not in METHODS:
        raise UsageError(f"method: expected one of {', '.join(METHODS)}, found '{method}'")
    open_nodes, load_factor = tuple(open_nodes), float(load_factor)
    if isinstance(initial_slip, str):
        initial_slip = named_start(problem, load_factor, initial_slip, open_nodes)
    start = problem, load_factor, initial_slip
    if method == "event":
        limits = cycles, LONGEST_PERIOD
        run = _from_event_to_event(settled_state(*start, open_nodes, limits, tolerances), record)
    else:
        motion = FixedSteps(*start, tolerances, open_nodes)
        run = _at_fixed_steps(motion, cycles, method, record)
    if slip_below is None:
        return run
    return replace(run, slip_criterion=slip_criterion(run.settled, slip_below, tolerances))


def _from_event_to_event(settled: LongTermState, record: bool) -> Simulation:
    """The way there recorded, if wanted; the state is undecided where that breaks the friction law."""
    if not record:
        return Simulation(settled=settled, method="event")
    origin = settled.origin
    path = walk(origin.motion(), _cycles_there(settled), record=True)
    if path.history is not None and settled.outcome != Outcome.UNDECIDED:
        met = path_violation(origin.problem, origin.load_factor, origin.tolerances, path.history)
        settled = settled.checked(met, law_resolution(origin.problem, origin.tolerances), "on the way there")
    return Simulation(settled=settled, method="event", followed=path)


def _cycles_there(settled: LongTermState) -> int:
    """The number of cycles needed, including the one in which it stops."""
    return min(settled.cycles_simulated + (settled.stop is not None), settled.most_cycles)


def recorded_verdict(
    cycles: Sequence[CycleRecord], threshold: FloatArray
) -> tuple[Outcome, int, FloatArray, str] | None:
    """The long-term state that the last cycles show, or None while they show none.

    Its outcome, the period in cycles, the drift of the slip per period, (n,) [length], and the reason.
    Evidence, not proof: slips of a node below its ``threshold``, (n,) [length], count as none, and
    each finding must hold over two cycles (two periods) in a row.
    """
    if len(cycles) < 2:
        return None
    last, still = cycles[-1], np.zeros_like(cycles[-1].end_slip)
    if all(np.all(cycle.slip <= threshold) for cycle in cycles[-2:]):
        breathing = np.flatnonzero(last.opened & last.closed)
        if breathing.size:
            reason = f"no frictional slip, but opening and closing every cycle: {nodes_in_words(breathing)}"
            return Outcome.SEPARATION, 1, still, reason
        return Outcome.SHAKEDOWN, 1, still, "no frictional slip in the last two cycles"
    none = np.repeat(threshold, len(still) // len(threshold))
    for period in range(1, min(REMEMBERED, (len(cycles) - 1) // 2) + 1):
        slip = np.sum([cycle.slip for cycle in cycles[-period:]], axis=0)
        # In a slow approach to shakedown the increments are as large as the slip; a limit cycle has none.
        if np.all(slip <= 1e3 * threshold):
            continue
        every, ends = cycles_in_words(period), [cycle.end_slip for cycle in cycles[-2 * period - 1 :]]
        steps = np.subtract(ends[period:], ends[: period + 1])
        if np.all(np.abs(steps) <= none):
            return Outcome.CYCLIC_SLIP, period, still, f"slip per {every} constant"
        steady = np.all(np.abs(steps - steps[-1]) <= none)
        if steady and np.any(np.abs(steps[-1]) > 1e3 * none):
            return Outcome.RATCHETTING, period, steps[-1], f"drift per {every} constant"
    return None


def _at_fixed_steps(motion: FixedSteps, cycles: int, method: str, record: bool) -> Simulation:
    """Cycle until the last cycles show the settled state, or the allowed cycles are spent."""
    problem, t, followed = motion.problem, motion.tolerances, list[CycleRecord]()
    moving, force = load_range(problem, motion.load), motion.scale.force
    threshold = alone(problem, max(t.steadiness * moving, DISTINCT * t.convergence * force))[: problem.n]
    start, verdict = motion.state.u[problem.layout.slips], None
    for cycle in cycles_of(motion, cycles, record=record):
        followed.append(cycle)
        if (verdict := recorded_verdict(followed, threshold)) is not None:
            break
    if verdict is None:
        reason = motion.stop.reason if motion.stop else f"no steady state within {count(cycles, 'cycle')}"
        verdict = Outcome.UNDECIDED, 0, np.full(len(start), np.nan), reason
    outcome, period, drift, reason = verdict
    path, slip = motion.last(period)
    records = followed[-period:] if period else []
    work = np.sum([each.work for each in records], axis=0) / period if period else np.nan
    settled = SteppedState(
        problem=problem,
        load_factor=float(motion.load_factor),
        initial_slip=motion.start,
        outcome=outcome,
        reason=reason,
        final_slip=motion.state.u[problem.layout.slips],
        drift=drift,
        cycles_simulated=len(followed) + (motion.stop is not None),
        residual=motion.residual,
        work_per_cycle=np.broadcast_to(work, problem.n).copy(),
        history=path,
        step_slip=slip,
        **of_period(records, problem.n) | {"jumps_per_cycle": np.nan},
    )
    walked = Walk(start, tuple(followed), motion.history if record else None)
    return Simulation(settled=settled, method=method, followed=walked)


@checked
def save_history(path: str | os.PathLike[str], run: Simulation) -> None:
    """Write the recorded path of a simulation to an NPZ file, whole or not at all.

    The file, compressed, has the arrays of :class:`EventHistory`, in space from event to event those of
    :class:`~shakedown.motion.event_history.CurvedHistory`, and ``load_factor``, ``initial_slip``.
    Left out is what they imply: between rows of a path in space the welded reactions change evenly, so that
    with the slips and gaps of ``curve`` the reactions are q = q_w + A v + Bᵀ w, p = p_w + B v + C w.

    Raises
    ------
    UsageError
        If the simulation was not recorded, or the file cannot be written.
    """
    if not isinstance(run, Simulation):
        raise UsageError(f"run: expected a Simulation, found {type(run).__name__}")
    if run.history is None:
        raise UsageError("nothing to write: simulate with record=True")
    arrays = {field.name: getattr(run.history, field.name) for field in fields(run.history)}
    arrays.pop("reaction_curve", None)
    with atomic_write(path) as file:
        np.savez_compressed(file, load_factor=run.load_factor, initial_slip=run.initial_slip, **arrays)
