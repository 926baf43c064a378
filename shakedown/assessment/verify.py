"""Predicted against simulated: does time integration agree with the bounds?"""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, Literal

from shakedown.assessment.assess import Assessment, SecondBounds, assess, independent_findings, second_bounds
from shakedown.assessment.every_limit import JointLimits
from shakedown.assessment.plan import BELOW, NO_ZONE, Case, case_as_given, plan_steps
from shakedown.assessment.transient_limit import SlipLimit
from shakedown.bounds.bound_result import Bound, open_ends
from shakedown.bounds.critical import CriticalLoadFactors, critical_load_factors
from shakedown.bounds.registry import BOUNDS, Claim, kinds_of, takes_long
from shakedown.ground.argument_kinds import check_count, check_seed
from shakedown.ground.constants import CYCLES, MOST_ENTRIES
from shakedown.ground.errors import Missing, present
from shakedown.ground.shown_values import at_lambda, nodes_in_words, plain, short
from shakedown.ground.status import Guarantee, Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.ground.work_limit import all_cores, limited_work, on_one_thread
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import can_creep
from shakedown.long_term.node_results import NodeResults, node_results
from shakedown.long_term.simulation import Simulation, check_slip_below, simulate
from shakedown.long_term.state import proof_in

Progress = Callable[[int, int], None]

MOST_WORK = 8e10  # multiplications and additions that a run may take, and λ_T in all: half a minute or so


@dataclass(frozen=True, eq=False, repr=False)
class Run(Case):
    """One simulation with its prediction.

    Attributes
    ----------
    simulation, seconds
        The result, and the time it took [s].
    """

    simulation: Simulation
    seconds: float = field(compare=False)

    @property
    def agrees(self) -> bool | None:
        """Whether prediction and result agree; None where nothing was predicted or found.

        Bounds are about all nodes closed, exactly these open, or every zone: of a joint that comes to rest in
        another one they say nothing.
        """
        found, shakes_down = self.simulation, self.predicted == "shakedown"
        if self.predicted == "either" or found.outcome == Outcome.UNDECIDED:
            return None
        if found.outcome != Outcome.SHAKEDOWN or found.separated:
            return not shakes_down
        if found.open_nodes == self.open_nodes or self.region == NO_ZONE:
            return shakes_down
        return False if shakes_down else None

    def to_dict(self) -> dict[str, Any]:
        """The prediction, and the document of the simulation."""
        words = ("region", "initial", "predicted", "agrees", "seconds")
        about = {word: plain(getattr(self, word)) for word in words}
        about |= {"initially_open": plain(self.open_nodes), "after_transient": self.after_transient}
        return about | self.simulation.to_dict()

    def columns(self) -> dict[str, Any]:
        """Those of the simulation."""
        return self.simulation.columns()

    def _shown(self) -> Iterator[tuple[str, str]]:
        found = self.simulation
        yield from (("load_factor", short(found.load_factor)), ("outcome", short(found.outcome)))
        for word in ("initial", "predicted", "agrees", "simulation"):
            yield word, short(getattr(self, word))


def compile_loops(limits: JointLimits, method: str) -> None:
    """Follow a joint through one cycle at λ = 0, so that no run's time includes compilation."""
    limited_work(1e6)(simulate)(limits.problem, 0.0, cycles=1, method=method)  # followed for its code only


def run_of(limits: JointLimits, case: Case, asked: "Settings") -> Run:
    """Simulate a case, and compare it with the prediction and the plan's ball."""
    began, problem = time.perf_counter(), limits.problem
    if case.after_transient:
        problem = replace(problem, q_transient=None, p_transient=None)
    if case.only_slips and asked.method == "event" and takes_long(problem):
        simulation, _ = limits.slip_beyond(case.load_factor, case.start, asked.cycles)
    else:
        simulation = simulate(
            problem,
            case.load_factor,
            case.start,
            open_nodes=case.open_nodes,
            cycles=asked.cycles,
            method=asked.method,
            tolerances=limits.tolerances,
        )
    state = simulation.long_term
    if state is not None and state.first_cycles is not None and state.outcome == Outcome.SHAKEDOWN:
        ball = present(limits.ball_at(case.load_factor))
        proof = None if ball is None else proof_in(ball, state)
        simulation = replace(simulation, settled=replace(state, proof=proof))
    seconds = time.perf_counter() - began
    for word in ("proved", "energy_margin", "residual", "jumps"):  # asked for in this thread, and kept
        getattr(simulation, word)
    return Run(**vars(case), simulation=simulation, seconds=seconds)


def is_spent(found: Simulation) -> bool:
    """Whether a run was given up because it took more work than is allowed."""
    stop = None if found.long_term is None else found.long_term.stop
    return found.outcome == Outcome.UNDECIDED and stop is not None and stop.spent


def disagreements(runs: Sequence[Run], lower: Bound | Missing) -> Iterator[str]:
    """One sentence for each run that contradicts its prediction."""
    for run in runs:
        if run.agrees is not False:
            continue
        text = (
            f"{at_lambda(run.simulation.load_factor)}, {run.region}, initial state {run.initial}: "
            f"predicted {run.predicted}, simulated {run.simulation.outcome}"
        )
        if run.region == BELOW and not isinstance(lower, Missing) and lower.guarantee != Guarantee.PROVED:
            text += f"; λ_1 is no proved bound here ({lower.guarantee}), and this is a counter-example"
        yield text


def open_questions(runs: Sequence[Run]) -> Iterator[str]:
    """One sentence for each run without an outcome, or at rest in a zone that no prediction is about."""
    go_on = "simulate, which has no such limit, goes on with it"
    for run in runs:
        found = run.simulation
        where = f"{run.initial} at {at_lambda(found.load_factor)}"
        if found.outcome == Outcome.UNDECIDED:
            # Why a body slides away is in the answer.
            why = found.reason.partition(":")[0] if found.slides_away else found.reason
            yield f"{where}: {why}{'; ' * is_spent(found)}{go_on * is_spent(found)}"
        elif run.agrees is None and run.predicted != "either":
            named = nodes_in_words(found.open_nodes)
            yield f"{where}: shakes down with {named} open: a zone that λ_max is not about (open_nodes)"


@dataclass(frozen=True)
class Settings:
    """The settings of a verification, so that it can be repeated.

    Attributes
    ----------
    load_factors
        Those asked for; None: one in every region.
    random_states, seed
        Number of initial states that random loads leave behind, and the seed these were drawn with.
    cycles, method
        As for :func:`shakedown.simulate`.
    budget, slip_below
        As for :func:`verify`.
    """

    load_factors: tuple[float, ...] | None
    random_states: int
    seed: int
    cycles: int
    method: str
    budget: int
    slip_below: float | None


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
        Every simulation, that of the nominal load first.
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
            **({"creep": present(limits.creep)} if can_creep(self.problem) else {}),
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
        return self.runs[0]

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
    """Compare the limits of a joint with time integration from several initial states.

    Below λ_U every initial state, closed and admissible, is proved to shake down. Below λ_1
    that is predicted, and the guarantee of λ_1 says whether it is proved. Above λ_max no state can
    shake down with all nodes in contact. If no slip is safe under the mean load alone, the same holds
    below λ_lo, the smallest load factor that has a safe slip.

    Between λ_1 and λ_max three kinds of states must shake down: the safe slip; every state inside the
    energy ball, of which some are drawn just inside its surface, no farther from its centre than the
    other initial states; and, below its λ_S, the first given state (else slip zero), which is
    simulated just below λ_S where that exceeds λ_E. Other states may do either. If λ_max
    belongs to a zone of closed nodes, only its safe slip is predicted to shake down, with the other
    nodes open, after the transient, and without a node that opens or closes. Nothing is predicted for
    other states, or above this λ_max.

    Transient load steps come first. The safe slip is one that they do not move either or, if there is
    none, one imposed after them. Limits for every state are expected to hold if the transient leaves all
    nodes closed. For a load domain λ_U takes the place of λ_1, and the corners are followed in the order
    given, which is only one of the possible load paths.

    Parameters
    ----------
    problem
        The joint and its loading.
    open_nodes
        The nodes that stay open (:func:`upper_bound`); ``"auto"`` searches for them if the mean
        load opens some, or if no slip is safe with all nodes closed.
    load_factors
        Load factors λ to simulate; by default one in each interval between limits that differ in four
        digits. λ = 1, from the state asked about, is always simulated, and first.
    random_states, seed
        Number of initial states that random load histories leave behind (``slip_after_transient``), whose
        deviations from the mean reach twice those of the loop; and the seed. None: 3, and 1 for joints
        in space of more than 50 node pairs.
    cycles, method
        As for :func:`shakedown.simulate`. In space a run is also stopped as undecided after 8e10 operations,
        about half a minute (2e10 where that was too few for λ = 1); ``simulate`` has no such limit. Above
        λ_max a joint in space of more than 50 node pairs is followed until its slip is known to three
        digits, within 4e10 operations; from other states than the first one within what that has left of
        them, 1e10 at least.
    budget
        Enumerate the critical load factors if there are at most so many subsets.
    slip_below
        A limit on the slip range of every node in the long run [length]. The load factor up to which it
        holds from the first given state, or from slip zero, is found as well (:func:`slip_limit`).
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
    if random_states is None:
        random_states = 1 if takes_long(problem) else 3
    check_count("random states", random_states, MOST_ENTRIES, least=0)
    check_seed(seed)
    for load_factor in load_factors or ():
        check_load_factor(load_factor, problem)
    if slip_below is not None:
        check_slip_below(slip_below)
    asked = None if load_factors is None else tuple(load_factors)
    settings = Settings(asked, random_states, seed, cycles, method, budget, slip_below)
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    return _verified(assess(problem, start, open_nodes=open_nodes, tolerances=tolerances), settings, progress)


Begin = Callable[[Callable[[], Any]], Callable[[], Any]]
"""Takes a piece of work and returns what waits for its result."""


@contextmanager
def side_by_side(threads: int) -> Iterator[Begin]:
    """Pieces of work done by threads in their order; with one thread each when its result is asked for.

    The motions of each take ``MOST_WORK`` at most.
    Most of their time is spent in compiled code that releases the lock of the interpreter.

    Examples
    --------
    >>> with side_by_side(threads=2) as begin:
    ...     one, two = begin(lambda: 1), begin(lambda: 2)
    ...     one(), two()
    (1, 2)
    """
    limited = limited_work(MOST_WORK)
    if threads == 1:
        yield limited
        return
    pool = ThreadPoolExecutor(threads)
    try:
        yield lambda step: pool.submit(limited(step)).result
    finally:
        pool.shutdown(wait=False, cancel_futures=True)


def _verified(found: Assessment, settings: Settings, progress: Progress | None) -> Verification:
    """The verification itself, piece by piece."""
    limits = found.details
    with side_by_side(all_cores() if takes_long(limits.problem) else 1) as begin:
        again = _find_bounds(limits, settings.method, begin)
        runs, (second, critical, slip) = _simulated(limits, settings, begin, again, progress)
    findings = list(independent_findings(limits.bounds, second, limits.tolerances))
    missing = {"λ_T": limits.transient, "the slip limit": slip}
    if BOUNDS["creep"].exists_for(limits.problem):
        missing["λ_c"] = limits.creep
    return Verification(
        assessment=found,
        second=second,
        critical=critical,
        slip_limit=present(slip),
        runs=tuple(runs),
        disagreements=(
            *(text for agrees, text in findings if agrees is False),
            *disagreements(runs, limits.lower),
        ),
        open_questions=(
            *open_ends(limits.lower, limits.upper, limits.energy, limits.universal),
            *open_questions(runs),
        ),
        notes=(
            *(text for agrees, text in findings if agrees is None),
            *(f"{name} is missing: {x.reason}" for name, x in missing.items() if isinstance(x, Missing)),
        ),
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
    others = [begin(partial(getattr, limits, kind.name)) for kind in kinds_of(Claim.THIS_STATE)]
    others += [every, begin(lambda: compile_loops(limits, method))]
    second = begin(lambda: second_bounds(limits.problem, limits.bounds, limits.tolerances))
    for end in others:
        end()
    limits.note_what_is_known()
    return second


def _simulated(
    limits: JointLimits,
    asked: Settings,
    begin: Begin,
    second: Callable[[], SecondBounds],
    progress: Progress | None,
) -> tuple[list[Run], list[Any]]:
    """Every simulation, and λ_T; the bounds by another solver, the critical load factors, the slip limit."""
    nominal = begin(lambda: _nominal_run(limits, asked))
    # early: its simulations follow from each other
    transient = begin(lambda: limits.transient)
    steps = plan_steps(limits, asked.load_factors, asked.random_states, asked.seed)
    planned = [begin(step) for step in steps]
    first = nominal()
    # where they were too few for λ = 1
    follow = limited_work(0.25 * MOST_WORK if is_spent(first.simulation) else MOST_WORK)(run_of)
    ends = list[Callable[[], Any]]()
    for step in planned:  # what one load factor has begins while the next one is planned
        ends += [begin(partial(follow, limits, case, asked)) for case in step()]
    few = limits.subsets is not None and limits.subsets <= asked.budget
    others = [
        second,
        begin(lambda: critical_load_factors(limits.problem, values=False) if few else None),
        begin(lambda: None if asked.slip_below is None else limits.slip(asked.slip_below)),
        transient,
        begin(lambda: limits.creep),
        begin(lambda: limits.friction),
        begin(lambda: limits.mesh),
    ]
    results = list[Any]()
    for end in [*ends, *others]:
        results.append(end())
        if progress is not None:
            progress(len(results) + 1, len(ends) + len(others) + 1)
    return [first, *results[: len(ends)]], results[len(ends) : len(ends) + 3]


def _nominal_run(limits: JointLimits, asked: Settings) -> Run:
    """The nominal load, with the period of its long-term state, which every page shows."""
    run = limited_work(MOST_WORK)(run_of)(limits, case_as_given(limits), asked)
    _ = run.simulation.settled.history  # followed in this thread, and kept
    return run
