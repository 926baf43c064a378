"""The simulations of a verification, each compared with its prediction."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from shakedown.assessment.every_limit import JointLimits
from shakedown.assessment.load_regions import BELOW, NO_ZONE
from shakedown.assessment.plan import Case
from shakedown.bounds.bound_result import Bound
from shakedown.ground.errors import Missing, present
from shakedown.ground.shown_values import at_lambda, nodes_in_words, plain, short
from shakedown.ground.status import Guarantee, Outcome
from shakedown.ground.work_limit import limited_work
from shakedown.joint.result import Result
from shakedown.long_term.energy_proof import proof_in
from shakedown.long_term.simulation import Simulation, simulate

MOST_WORK = 8e10  # multiplications and additions that a run may take, and λ_T in all: half a minute or so
AFTER_SPENT = 0.25 * MOST_WORK  # where they were too few for λ = 1
LEAST_WORK = 1e6  # of a cycle that is followed for its code only
GO_ON = "simulate, which has no such limit, goes on with it"
WORKED_OUT = ("proved", "energy_margin", "residual", "jumps")  # of a simulation when it is asked for


@dataclass(frozen=True, eq=False, repr=False)
class Run(Result):
    """One simulation with its prediction.

    Attributes
    ----------
    case
        What was to be simulated, and what is predicted for it.
    agrees
        True, False, or None where nothing was predicted, the simulation is undecided, or comes to rest
        with other nodes open than the prediction is about.
    simulation, seconds
        The result, and the time it took [s].
    """

    case: Case
    agrees: bool | None
    simulation: Simulation
    seconds: float = field(compare=False)

    def to_dict(self) -> dict[str, Any]:
        """The prediction, and the document of the simulation."""
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


def compile_loops(limits: JointLimits, method: str) -> None:
    """Follow a joint through one cycle at λ = 0, so that no run's time includes compilation."""
    with limited_work(LEAST_WORK):
        simulate(limits.problem, 0.0, cycles=1, method=method)


def run_of(limits: JointLimits, case: Case, cycles: int, method: str, most: float = MOST_WORK) -> Run:
    """Simulate a case with so much work at most, and compare it with the prediction and the plan's ball."""
    with limited_work(most):
        return _run_of(limits, case, cycles, method)


def _run_of(limits: JointLimits, case: Case, cycles: int, method: str) -> Run:
    began, problem = time.perf_counter(), limits.problem
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
        tolerances=limits.tolerances,
    )
    state = simulation.long_term
    if state is not None and state.first_cycles is not None and state.outcome == Outcome.SHAKEDOWN:
        ball = present(limits.ball_at(case.load_factor))
        proof = None if ball is None else proof_in(ball, state.begun, state.approach)
        simulation = replace(simulation, settled=replace(state, proof=proof))
    seconds = time.perf_counter() - began
    for word in WORKED_OUT:  # in this thread, and kept
        getattr(simulation, word)
    return Run(case, _agreement(case, simulation), simulation, seconds)


def _agreement(case: Case, run: Simulation) -> bool | None:
    """Whether the result agrees; the bounds are about all nodes closed, exactly these open, or every zone."""
    if case.predicted == "either" or run.outcome == Outcome.UNDECIDED:
        return None
    shakes_down = case.predicted == "shakedown"
    if run.outcome != Outcome.SHAKEDOWN or run.separated:
        return not shakes_down
    if run.open_nodes == case.open_nodes or case.region == NO_ZONE:
        return shakes_down
    return False if shakes_down else None


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
        below = run.region == BELOW
        if below and not isinstance(lower, Missing) and lower.guarantee != Guarantee.PROVED:
            text += f"; λ_1 is no proved bound here ({lower.guarantee}), and this is a counter-example"
        yield text


def open_questions(runs: Sequence[Run]) -> Iterator[str]:
    """One sentence for each run without an outcome, or at rest in a zone that no prediction is about."""
    for run in runs:
        found = run.simulation
        where = f"{run.initial} at {at_lambda(found.load_factor)}"
        if found.outcome == Outcome.UNDECIDED:
            # Why a body slides away is in the answer.
            why = found.reason.partition(":")[0] if found.slides_away else found.reason
            yield f"{where}: {why}{'; ' * is_spent(found)}{GO_ON * is_spent(found)}"
        elif run.agrees is None and run.predicted != "either":
            named = nodes_in_words(found.open_nodes)
            yield f"{where}: shakes down with {named} open: a zone that λ_max is not about (open_nodes)"
