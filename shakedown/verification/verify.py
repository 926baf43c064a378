"""Predicted against simulated: does time integration agree with the bounds?"""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeVar

import numpy as np

from shakedown.assessment.shakedown_bounds import ShakedownBounds, shakedown_bounds
from shakedown.assessment.transient_limit import TransientLimit, transient_limit
from shakedown.bounds.energy.energy_bound import EnergyBound, energy_bound
from shakedown.bounds.interior_point import ConicBound
from shakedown.bounds.upper import UpperBound
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import UsageError
from shakedown.ground.evidence import Missing, present, sought
from shakedown.ground.shown_values import plain, short
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import MANY, check_load_factor, check_seed, checked, require_plane
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.simulation import Simulation, simulate
from shakedown.planar.collapse.box_bound import BoxBound, box_bound
from shakedown.planar.collapse.lower import LowerBound
from shakedown.planar.enumeration.critical import CriticalLoadFactors, critical_load_factors, subset_count
from shakedown.planar.friction.thresholds import FrictionThresholds, friction_thresholds
from shakedown.planar.universal.guarantee_curve import GuaranteeCurve, guarantee_curve
from shakedown.planar.universal.universal_bound import UniversalBound, universal_bound
from shakedown.verification.from_state import FromState, from_state
from shakedown.verification.open_ends import open_ends
from shakedown.verification.plan import AS_GIVEN, BELOW, Case, Known, planned_cases
from shakedown.verification.second_road import road_findings, second_road

CURVE_RADII = (0.0, 0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0)  # in multiples of max |safe slip|
SCANNED = 20  # load factors scanned for the transient limit
SCAN_ABOVE = 1.05  # where their range ends, relative to λ_max
PHASES = 8  # pieces of work beside the simulations

T = TypeVar("T")


@dataclass(frozen=True)
class Settings:
    """How a verification was made, so that it can be made again.

    Attributes
    ----------
    random_states, seed
        Number of random initial states, and the seed they were drawn with.
    cycles, method
        As for :func:`shakedown.simulate`.
    """

    random_states: int
    seed: int
    cycles: int
    method: str


@dataclass(frozen=True, eq=False, repr=False)
class Run(Result):
    """One simulation, with what was predicted for it.

    Attributes
    ----------
    case
        What was to be simulated, and what is predicted for it.
    agrees
        True, False, or None where nothing was predicted or the simulation is undecided.
    simulation, seconds
        What came out, and the time it took [s].
    """

    case: Case
    agrees: bool | None
    simulation: Simulation
    seconds: float = field(compare=False)

    def to_dict(self) -> dict[str, Any]:
        """What was predicted, and the words of the simulation."""
        words = ("region", "initial", "predicted", "agrees", "seconds")
        about = {word: plain(getattr(self, word)) for word in words}
        about |= {"initially_open": plain(self.open_nodes), "after_transient": self.case.after_transient}
        return about | self.simulation.to_dict()

    def columns(self) -> dict[str, Any]:
        """Those of the simulation."""
        return self.simulation.columns()

    def _shown(self) -> Iterator[tuple[str, str]]:
        found = self.simulation
        yield from (("load_factor", short(found.load_factor)), ("outcome", short(found.outcome)))
        for word in ("initial", "predicted", "agrees", "simulation"):
            yield word, short(getattr(self, word))

    @property
    def region(self) -> str:
        """Where the load factor lies."""
        return self.case.region

    @property
    def initial(self) -> str:
        """Name of the initial state."""
        return self.case.initial

    @property
    def predicted(self) -> str:
        """ "shakedown", "slips or opens", or "either" where nothing is predicted."""
        return self.case.predicted

    @property
    def open_nodes(self) -> tuple[int, ...]:
        """The nodes that are open at the start."""
        return self.case.open_nodes


@dataclass(frozen=True, eq=False, repr=False)
class Verification(Result):
    """Result of :func:`verify`.

    Attributes
    ----------
    problem
        The joint.
    energy
        λ_E: up to where shakedown is proved from the first given state, or from slip zero.
    box
        Up to where the box bound proves it from that state (:func:`box_bound`).
    universal
        λ_U: up to where it is proved from every initial state.
    bounds
        Both bounds, by linear programming (HiGHS).
    second_lower, second_upper
        Both bounds once more, by an interior-point method (Clarabel).
    critical
        All (n+1)-subsets, or None where there are more than the budget allows.
    subsets
        Their number.
    friction
        Friction thresholds.
    transient
        Up to where the history from the first given state, or from zero slip,
        shakes down; None where λ_max is not finite and positive.
    curve
        λ_1(R) for initial states near the safe slip, or None where there is no
        gap between the bounds to close, and for a load domain.
    runs
        Every simulation.
    disagreements
        One sentence each; empty where prediction and simulation agree, and both
        roads to the bounds.
    open_questions
        One sentence for each simulation without an outcome, each bound without an answer, and each
        that exact arithmetic disputes.
    notes
        What limits the evidence without touching an answer: one sentence for each bound
        that the second road does not reach, or not to full accuracy.
    settings
        How it was made.
    """

    problem: Problem
    energy: EnergyBound
    box: BoxBound
    universal: UniversalBound
    bounds: ShakedownBounds
    second_lower: ConicBound
    second_upper: ConicBound
    critical: CriticalLoadFactors | None
    subsets: int
    friction: FrictionThresholds
    transient: TransientLimit | None
    curve: GuaranteeCurve | None
    runs: tuple[Run, ...]
    disagreements: tuple[str, ...]
    open_questions: tuple[str, ...]
    notes: tuple[str, ...]
    settings: Settings

    def to_dict(self) -> dict[str, Any]:
        """The document that ``shakedown-bounds verify --json`` writes."""
        counted = {} if self.critical is None else self.critical.to_dict()
        second = {"lower": self.second_lower, "upper": self.second_upper}
        document = {
            "problem": self.problem,
            **self.bounds.to_dict(),
            "energy": self.energy,
            "box": self.box,
            **self.universal.document(),
            "agrees": self.agrees,
            "disagreements": self.disagreements,
            "open_questions": self.open_questions,
            "notes": self.notes,
            "second_road": {
                "solver": self.second_upper.solver,
                **{k: {"status": v.status, "load_factor": v.load_factor} for k, v in second.items()},
            },
            "critical": {"total": self.subsets, **counted},
            "friction": self.friction,
            "transient": self.transient,
            "guarantee_curve": self.curve,
            "runs": self.runs,
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
    def as_given(self) -> Run:
        """The loading as given (λ = 1) from the first given state, or from slip zero."""
        name = "zero" if self.problem.initial_slip is None else "given 0"
        found = [run for run in self.runs if run.simulation.load_factor == AS_GIVEN and run.initial == name]
        return found[0]

    @property
    def from_state(self) -> FromState:
        """What is proved from the first given state, or from slip zero: the larger of both bounds."""
        return from_state(self.energy, self.box)

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
    random_states: int = 3,
    seed: int = 0,
    cycles: int = 1000,
    method: str = "event",
    budget: int = 200_000,
    progress: Callable[[int, int], None] | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Verification:
    """Hold the bounds against time integration from several initial states.

    Below λ_U every initial state, closed and admissible, is proved to shake down. Below λ_1
    that is predicted, and the guarantee of λ_1 says whether it is proved. Above λ_max none can
    with all nodes in contact, nor below λ_lo where the mean load alone has no safe slip. Between the
    bounds the safe slip must shake down, and every state inside the energy ball, of
    which some are drawn just inside its surface, and the first given state (else slip zero) below its
    box bound, just below which it is simulated; other states may do either. Where λ_max
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
        Load factors λ to simulate; by default one in every region that exists.
    random_states, seed
        Number of random initial states, and the seed they are drawn with.
    cycles, method
        As for :func:`shakedown.simulate`.
    budget
        Enumerate the critical load factors where there are at most so many subsets.
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
    require_plane("verification", problem)
    _check(random_states, seed)
    for load_factor in load_factors or ():
        check_load_factor(load_factor, problem)
    bounds = shakedown_bounds(problem, open_nodes=open_nodes, tolerances=tolerances)
    lower, upper = bounds.lower, bounds.upper
    universal = universal_bound(problem, first_collapse=lower, tolerances=tolerances)
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    energy = energy_bound(problem, start, open_nodes=upper.open_nodes, tolerances=tolerances)
    box = box_bound(problem, start, tolerances=tolerances)
    known = Known(bounds, universal, energy, box)
    cases = list(planned_cases(problem, known, load_factors, random_states, seed, tolerances))
    simulate(problem, 0.0, cycles=1, method=method)  # loads compiled code: no run's time should count it
    work = _Work(len(cases) + PHASES, progress)
    work.done(bounds)
    work.done(universal)
    work.done(energy)
    runs = tuple(work.done(_run(problem, case, cycles, method, tolerances)) for case in cases)
    second = work.done(second_road(problem, bounds, tolerances))
    roads = list(road_findings(bounds, second, tolerances))
    curve, transient = _curve(problem, bounds, tolerances), _transient(problem, upper, tolerances)
    missing = [
        f"{name} is missing: {found.reason}"
        for name, found in (("the guarantee curve", curve), ("λ_T", transient))
        if isinstance(found, Missing)
    ]
    subsets = subset_count(problem.n)
    return Verification(
        problem=problem,
        energy=energy,
        box=box,
        curve=work.done(present(curve)),
        universal=universal,
        bounds=bounds,
        second_lower=second.lower,
        second_upper=second.upper,
        critical=work.done(critical_load_factors(problem) if subsets <= budget else None),
        subsets=subsets,
        friction=work.done(friction_thresholds(problem, tolerances=tolerances)),
        transient=work.done(present(transient)),
        runs=runs,
        disagreements=(*(text for agrees, text in roads if agrees is False), *_disagreements(runs, lower)),
        open_questions=(*open_ends(lower, upper, energy, universal), *_open_questions(runs)),
        notes=(*(text for agrees, text in roads if agrees is None), *missing),
        settings=Settings(random_states, seed, cycles, method),
    )


def _curve(
    problem: Problem, bounds: ShakedownBounds, tolerances: Tolerances
) -> GuaranteeCurve | Missing | None:
    """λ_1(R); None where there is no gap between the bounds to close."""
    if not bounds.have_gap or problem.is_domain:
        return None
    return sought(guarantee_curve, problem, CURVE_RADII, tolerances=tolerances)


def _check(random_states: int, seed: int) -> None:
    """Raise ``UsageError`` where an argument of a verification is out of range."""
    if random_states > MANY:
        raise UsageError(f"random states: expected at most {MANY:,}, found {random_states}")
    if random_states < 0:
        raise UsageError(f"random states: expected at least 0, found {random_states}")
    check_seed(seed)


class _Work:
    """Pieces of work of which somebody is told that they are done."""

    def __init__(self, pieces: int, progress: Callable[[int, int], None] | None) -> None:
        self.pieces, self.progress, self.count = pieces, progress, 0

    def done(self, result: T) -> T:
        """The result of a piece of work, unchanged."""
        self.count += 1
        if self.progress is not None:
            self.progress(self.count, self.pieces)
        return result


def _transient(
    problem: Problem, upper: UpperBound, tolerances: Tolerances
) -> TransientLimit | Missing | None:
    if not 0 < upper.load_factor < np.inf:
        return None
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    largest = SCAN_ABOVE * upper.load_factor
    return sought(
        transient_limit, problem, start, largest=largest, steps=SCANNED, accuracy=1e-6, tolerances=tolerances
    )


def _run(problem: Problem, case: Case, cycles: int, method: str, tolerances: Tolerances) -> Run:
    began = time.perf_counter()
    if case.after_transient:
        problem = replace(problem, q_transient=None, p_transient=None)
    simulation = simulate(
        problem,
        case.load_factor,
        case.start,
        open_nodes=case.open_nodes,
        cycles=cycles,
        method=method,
        record=problem.n <= 2,
        tolerances=tolerances,
    )
    seconds = time.perf_counter() - began
    agrees = _agreement(case.predicted, simulation, case.open_nodes)
    return Run(case, agrees, simulation, seconds)


def _agreement(predicted: str, run: Simulation, open_nodes: tuple[int, ...] = ()) -> bool | None:
    """The bounds speak of shakedown with all nodes closed, or exactly these open."""
    if predicted == "either" or run.outcome == Outcome.UNDECIDED:
        return None
    kept = run.outcome == Outcome.SHAKEDOWN and run.open_nodes == open_nodes
    return kept == (predicted == "shakedown")


def _disagreements(runs: Sequence[Run], lower: LowerBound) -> Iterator[str]:
    for run in runs:
        if run.agrees is not False:
            continue
        text = (
            f"λ = {run.simulation.load_factor:.6g}, {run.region}, initial state {run.initial}: "
            f"predicted {run.predicted}, simulated {run.simulation.outcome}"
        )
        if run.region == BELOW and lower.guarantee != "proved":
            text += f"; λ_1 is no proved bound here ({lower.guarantee}), and this is a counter-example"
        yield text


def _open_questions(runs: Sequence[Run]) -> Iterator[str]:
    for run in runs:
        if run.simulation.outcome == Outcome.UNDECIDED:
            yield f"{run.initial} at λ = {run.simulation.load_factor:.6g}: {run.simulation.reason}"
