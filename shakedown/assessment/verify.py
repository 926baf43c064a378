"""Predicted against simulated: does time integration agree with the bounds?"""

import functools
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple, TypeVar

from shakedown.assessment.assess import AS_GIVEN, Assessment, assess
from shakedown.assessment.every_limit import JointLimits
from shakedown.assessment.independent_bounds import SecondBounds, independent_findings, second_bounds
from shakedown.assessment.plan import Case, case_as_given, plan_steps, planned_cases
from shakedown.assessment.runs import (
    AFTER_SPENT,
    MOST_WORK,
    Run,
    compile_loops,
    disagreements,
    is_spent,
    open_questions,
    run_of,
)
from shakedown.assessment.side_by_side import (
    Begin,
    OtherEvidence,
    evidence_steps,
    limited,
    side_by_side,
)
from shakedown.assessment.slip_limit import SlipLimit
from shakedown.assessment.three_numbers import open_ends
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.enumeration.critical import CriticalLoadFactors
from shakedown.bounds.plane_or_space import takes_long
from shakedown.bounds.registry import Claim, kinds_of
from shakedown.ground.argument_kinds import check_seed
from shakedown.ground.blas_threads import all_cores, on_one_thread
from shakedown.ground.errors import UsageError, present
from shakedown.ground.shown_values import plain
from shakedown.ground.size_limits import CYCLES, MANY
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked, require_problem
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.node_results import node_results
from shakedown.long_term.node_table import NodeResults
from shakedown.long_term.slip_criterion import check_slip_below

RANDOM_STATES = 3
Progress = Callable[[int, int], None]
T = TypeVar("T")


@dataclass(frozen=True)
class Settings:
    """The settings of a verification, so that it can be repeated.

    Attributes
    ----------
    random_states, seed
        Number of initial states that random loads leave behind, and the seed these were drawn with.
    cycles, method
        As for :func:`shakedown.simulate`.
    """

    random_states: int
    seed: int
    cycles: int
    method: str


@dataclass(frozen=True, eq=False, repr=False)
class Verification(Result):
    """Result of :func:`verify`.

    Attributes
    ----------
    assessment
        The limits that are verified, from the first given state, or from slip zero.
    second
        Both bounds once more, by an interior-point method (Clarabel).
    critical
        All (n+1)-subsets, or None where there are more than the budget allows.
    slip_limit
        Up to where every slip range stays below a length, where that was asked for.
    runs
        Every simulation.
    disagreements
        One sentence each; empty where prediction and simulation agree, and both
        solvers of the bounds.
    open_questions
        One sentence for each simulation without an outcome, each bound without an answer, and each
        that exact arithmetic disputes.
    notes
        What limits the evidence without touching an answer: one sentence for each bound
        that the independent solver does not reach, or not to full accuracy.
    settings
        How it was made.
    """

    assessment: Assessment
    second: SecondBounds
    critical: CriticalLoadFactors | None
    slip_limit: SlipLimit | None
    runs: tuple[Run, ...]
    disagreements: tuple[str, ...]
    open_questions: tuple[str, ...]
    notes: tuple[str, ...]
    settings: Settings

    def to_dict(self) -> dict[str, Any]:
        """The document that ``shakedown-bounds verify --json`` writes."""
        limits, counted = self.limits, {} if self.critical is None else self.critical.to_dict()
        second = {"lower": self.second.lower, "upper": self.second.upper}
        document = {
            "problem": self.problem,
            **limits.to_dict(),
            "agrees": self.agrees,
            "disagreements": self.disagreements,
            "open_questions": self.open_questions,
            "notes": self.notes,
            "second_road": {
                "solver": self.second.upper.solver,
                **{
                    k: None if v is None else {"status": v.status, "load_factor": v.load_factor}
                    for k, v in second.items()
                },
            },
            "critical": None if limits.subsets is None else {"total": limits.subsets, **counted},
            "friction": present(limits.friction),
            "transient": self.transient,
            "followed": None if self.transient is None else self.transient.followed,
            "sensitivities": {name: present(each) for name, each in limits.sensitivities.items()},
            **({} if self.slip_limit is None else {"slip_criterion": self.slip_limit}),
            "runs": self.runs,
            "nodes": self.nodes,
        }
        return {word: plain(value) for word, value in document.items()}

    def columns(self) -> dict[str, Any]:
        """One row per simulation."""
        words = ("region", "initial", "predicted", "agrees", "seconds")
        columns: dict[str, Any] = {
            "load_factor": [run.simulation.load_factor for run in self.runs],
            **{word: [getattr(run, word) for run in self.runs] for word in words},
        }
        columns["outcome"] = [str(run.simulation.outcome) for run in self.runs]
        columns["slip_per_cycle"] = [float(run.simulation.slip_per_cycle.max()) for run in self.runs]
        columns["dissipation_per_cycle"] = [run.simulation.dissipation_per_cycle for run in self.runs]
        return columns

    @property
    def problem(self) -> Problem:
        """The joint."""
        return self.assessment.problem

    @property
    def limits(self) -> JointLimits:
        """Every limit of the joint."""
        return self.assessment.details

    @property
    def transient(self) -> Bound | None:
        """λ_T; None where λ_max is not finite and positive, or where it is missing (``notes``)."""
        return present(self.limits.transient)

    @property
    def as_given(self) -> Run:
        """The nominal load (λ = 1) from the first given state, or from slip zero."""
        return next(run for run in self.runs if _is_as_given(run, self.problem))

    @cached_property
    def nodes(self) -> NodeResults:
        """The results of every node in the long term under the nominal load."""
        return node_results(self.as_given, tolerances=self.limits.tolerances)

    @property
    def agrees(self) -> bool:
        """Whether nothing disagrees and nothing is left open."""
        return not self.disagreements and not self.open_questions


@checked
@on_one_thread
def verify(
    problem: Problem,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = "auto",
    load_factors: Sequence[float] | None = None,
    random_states: int | None = None,
    seed: int = 0,
    cycles: int = CYCLES,
    method: str = "event",
    budget: int = 200_000,
    slip_below: float | None = None,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Verification:
    """Hold the bounds against time integration from several initial states.

    Below λ_U every initial state, closed and admissible, is proved to shake down. Below λ_1
    that is predicted, and the guarantee of λ_1 says whether it is proved. Above λ_max none can
    with all nodes in contact, nor below λ_lo where the mean load alone has no safe slip. Between the
    bounds the safe slip must shake down, and every state inside the energy ball, of
    which some are drawn just inside its surface (no farther away than the other states), and
    the first given state (else slip zero) below its λ_S; just below that it is simulated,
    where it is larger than λ_E. Other states may do either. Where λ_max
    is that of a zone, its safe slip, with its nodes open and after the transient, must
    shake down without a node that closes or opens; of all others, and above, nothing is
    predicted.

    Where there are transient load steps, they come first: the safe slip is one that they do not
    move either, or, where there is none, one that is locked in when they are over; what is said
    of every state is expected of those in which they leave all nodes closed. Of a load domain
    λ_U takes the place of λ_1, and the corners are followed in the order given: one path of many.

    Parameters
    ----------
    problem
        The joint and its loading.
    open_nodes
        The nodes that stay open (:func:`upper_bound`); ``"auto"`` searches them where the mean
        load opens some, or no slip is safe with all closed.
    load_factors
        Load factors λ to simulate; by default one in every region that is wider than four digits show.
        λ = 1 comes first, from the state asked about, whatever else is asked for.
    random_states, seed
        Number of initial states that random loads, up to twice those of the loop about its mean, leave behind
        (``slip_after_transient``), and the seed these are drawn with. None: 3, and 1 of joints in
        space of more than 50 node pairs.
    cycles, method
        As for :func:`shakedown.simulate`. In space a run is undecided, too, after 8e10 operations, half a
        minute or so (2e10 where that was too few for λ = 1); ``simulate`` has no such limit.
    budget
        Enumerate the critical load factors where there are at most so many subsets.
    slip_below
        A limit on the slip range of every node in the long run [length]; up to which load factor it
        holds from the first given state, or from slip zero, is said beside (:func:`slip_limit`).
    progress
        Called with (done, total) after every piece of work: the bounds, every simulation,
        every other bound.
    tolerances
        The tolerances that decide.

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> report = shakedown.verify(shakedown.example("two-node"), random_states=1)
    >>> report.agrees, len(report.runs)
    (True, 18)
    """
    require_problem(problem)
    if random_states is None:
        random_states = 1 if takes_long(problem) else RANDOM_STATES
    _check(random_states, seed)
    for load_factor in load_factors or ():
        check_load_factor(load_factor, problem)
    if slip_below is not None:
        check_slip_below(slip_below)
    asked = _Scope(open_nodes, load_factors, budget, slip_below)
    settings = Settings(random_states, seed, cycles, method)
    return _verified(problem, asked, settings, progress, tolerances)


class _Scope(NamedTuple):
    """What a verification is asked for besides its :class:`Settings`."""

    open_nodes: Iterable[int] | Literal["auto"]
    load_factors: Sequence[float] | None
    budget: int
    slip_below: float | None


def _verified(
    problem: Problem, asked: _Scope, settings: Settings, progress: Progress | None, tolerances: Tolerances
) -> Verification:
    """The verification itself, piece by piece."""
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    found = assess(problem, start, open_nodes=asked.open_nodes, tolerances=tolerances)
    limits = found.details
    with side_by_side(all_cores() if takes_long(problem) else 1) as begin:
        second = _find_bounds(limits, settings.method, begin)
        runs, other = _simulated(limits, asked, settings, progress, begin, second)
    findings = list(independent_findings(limits.bounds, other.second, tolerances))
    return Verification(
        assessment=found,
        second=other.second,
        critical=other.critical,
        slip_limit=present(other.slip),
        runs=tuple(runs),
        disagreements=(
            *(text for agrees, text in findings if agrees is False),
            *disagreements(runs, limits.lower),
        ),
        open_questions=(
            *open_ends(limits.lower, limits.upper, limits.energy, limits.universal),
            *open_questions(runs),
        ),
        notes=(*(text for agrees, text in findings if agrees is None), *other.missing()),
        settings=settings,
    )


def _find_bounds(limits: JointLimits, method: str, begin: Begin) -> Callable[[], SecondBounds]:
    """The bounds, in space λ_U, which takes longest, beside the others; compiled loops.

    Also what waits for the bounds by another solver.
    """
    first, every = begin(lambda: limits.upper), begin(lambda: limits.universal)
    first()
    for name in ("lower", "through_transient"):
        getattr(limits, name)
    others = [begin(functools.partial(getattr, limits, kind.name)) for kind in kinds_of(Claim.THIS_STATE)]
    others += [every, begin(lambda: compile_loops(limits, method))]
    second = begin(lambda: second_bounds(limits.problem, limits.bounds, limits.tolerances))
    for end in others:
        end()
    limits.note_what_is_known()
    return second


def _simulated(
    limits: JointLimits,
    asked: _Scope,
    settings: Settings,
    progress: Progress | None,
    begin: Begin,
    second: Callable[[], SecondBounds],
) -> tuple[list[Run], OtherEvidence]:
    """Every simulation, λ_T, and the other evidence."""
    how = settings.cycles, settings.method
    nominal = begin(lambda: _nominal_run(limits, *how))
    # early: its simulations follow from each other
    transient = begin(limited(lambda: limits.transient))
    plan = plan_steps(limits, asked.load_factors, settings.random_states, settings.seed)
    planned = [begin(limited(step)) for step in plan]
    runs: list[Run] = [nominal()]
    most = AFTER_SPENT if is_spent(runs[0].simulation) else MOST_WORK
    cases, ends = list[Case](), list[Callable[[], Run]]()
    for step in planned:  # what one load factor has begins while the next one is planned
        new = planned_cases(limits, step())
        ends += [begin(functools.partial(run_of, limits, case, *how, most)) for case in new]
        cases += new
    others = [begin(limited(step)) for step in evidence_steps(limits, asked.budget, asked.slip_below)]
    pieces, done = len(runs) + len(cases) + 2 + len(others), len(runs)

    def awaited(end: Callable[[], T]) -> T:
        nonlocal done
        result = end()
        done += 1
        if progress is not None:
            progress(done, pieces)
        return result

    first = sum(case.load_factor == AS_GIVEN for case in cases)  # λ = 1 comes first, then λ_T
    runs += [awaited(end) for end in ends[:first]]
    awaited(transient)
    runs += [awaited(end) for end in ends[first:]]
    again = awaited(second)
    critical, _, slip, _ = (awaited(end) for end in others)
    return runs, OtherEvidence(again, critical, limits.transient, slip)


def _nominal_run(limits: JointLimits, cycles: int, method: str) -> Run:
    """The nominal load, with the period of its long-term state, which every page shows."""
    run = run_of(limits, case_as_given(limits), cycles, method)
    _ = run.simulation.settled.history  # followed in this thread, and kept
    return run


def _is_as_given(run: Run, problem: Problem) -> bool:
    name = "zero" if problem.initial_slip is None else "given 0"
    return run.initial == name and run.simulation.load_factor == AS_GIVEN


def _check(random_states: int, seed: int) -> None:
    """Raise ``UsageError`` where an argument of a verification is out of range."""
    if random_states > MANY:
        raise UsageError(f"random states: expected at most {MANY:,}, found {random_states}")
    if random_states < 0:
        raise UsageError(f"random states: expected at least 0, found {random_states}")
    check_seed(seed)
