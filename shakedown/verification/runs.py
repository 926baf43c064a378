"""The simulations of a verification, each held against what was predicted for it."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from shakedown.ground.evidence import Missing
from shakedown.ground.shown_values import at_lambda, plain, short
from shakedown.ground.status import Guarantee, Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.simulation import Simulation, simulate
from shakedown.planar.collapse.lower import LowerBound
from shakedown.verification.load_regions import BELOW
from shakedown.verification.plan import Case


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


def run_of(problem: Problem, case: Case, cycles: int, method: str, tolerances: Tolerances) -> Run:
    """Simulate a case, and hold what comes out against what is predicted."""
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


def disagreements(runs: Sequence[Run], lower: LowerBound | Missing) -> Iterator[str]:
    """One sentence for each run that does not do what is predicted."""
    for run in runs:
        if run.agrees is not False:
            continue
        text = (
            f"{at_lambda(run.simulation.load_factor)}, {run.region}, initial state {run.initial}: "
            f"predicted {run.predicted}, simulated {run.simulation.outcome}"
        )
        below = run.region == BELOW
        if below and isinstance(lower, LowerBound) and lower.guarantee != Guarantee.PROVED:
            text += f"; λ_1 is no proved bound here ({lower.guarantee}), and this is a counter-example"
        yield text


def open_questions(runs: Sequence[Run]) -> Iterator[str]:
    """One sentence for each run without an outcome."""
    for run in runs:
        if run.simulation.outcome == Outcome.UNDECIDED:
            yield f"{run.initial} at {at_lambda(run.simulation.load_factor)}: {run.simulation.reason}"
