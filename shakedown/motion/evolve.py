"""The exact path of a joint over a number of cycles."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_arguments, checked, checked_damping
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.motion.cycle_record import CycleRecord, Stop
from shakedown.motion.event_history import EventHistory
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import cycles_of


@dataclass(frozen=True, eq=False, repr=False)
class EvolutionResult(Result):
    """Result of :func:`evolve`.

    Attributes
    ----------
    load_factor, initial_slip
        What was simulated; the slip of a node that was open at the start is its displacement.
    cycles
        What every cycle did.
    history
        Every event.
    stop
        Why it ended before its time; None where it did not.
    """

    DOCUMENT: ClassVar[str] = "load_factor initial_slip cycles history stop"

    load_factor: float
    initial_slip: FloatArray
    cycles: tuple[CycleRecord, ...]
    history: EventHistory
    stop: Stop | None

    def columns(self) -> dict[str, Any]:
        """One row per event."""
        return self.history.columns()


@checked
def evolve(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    *,
    open_nodes: Iterable[int] = (),
    cycles: int = 1,
    damping: ArrayLike | None = None,
    tolerances: Tolerances = DEFAULT,
) -> EvolutionResult:
    """The exact path of a joint through its transient and a number of cycles (thesis (2.10), (2.3)–(2.9)).

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    initial_slip : (n,), optional
        Slip at the start [length]; zero by default.
    open_nodes
        Nodes that are open at the start, all others closed: they are in equilibrium with
        the first load step (:func:`beginning`), and their initial slips are ignored.
    cycles
        How many.
    damping : (2n,), optional
        Diagonal of the matrix D that carries the state across jumps, only ratios
        matter; by default in proportion to the diagonal of κ.
    tolerances
        What counts as zero, as reached and as periodic (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range, or an open node would overlap.

    Examples
    --------
    >>> import shakedown
    >>> run = evolve(shakedown.example("three-node"), 2.6, [2.60902, -0.60226, -0.36541], cycles=2)
    >>> run.stop is None, run.cycles[1].events
    (True, 3)
    """
    check_arguments(load_factor, cycles, problem)
    damping, opened = checked_damping(problem, damping), tuple(open_nodes)
    evolution = Evolution(problem, load_factor, initial_slip, tolerances, damping, opened)
    start = evolution.state.u[problem.layout.slips]
    records = tuple(cycles_of(evolution, cycles, record=True))
    return EvolutionResult(float(load_factor), start, records, evolution.history, evolution.stop)
