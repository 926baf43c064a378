"""The exact path of a joint over a number of cycles."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_arguments, checked, checked_damping, require_plane
from shakedown.joint.loading import first_load, loop_path, ramp_start, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.motion.cycle_record import CycleRecord, Stop
from shakedown.motion.event_history import EventHistory
from shakedown.motion.integrator import Evolution
from shakedown.motion.method import cycles_of
from shakedown.motion.reduced_scene import Scene, reduced_scene


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
    scene
        What was left out, where that was asked for and could be done.
    """

    DOCUMENT: ClassVar[str] = "load_factor initial_slip cycles history stop"

    load_factor: float
    initial_slip: FloatArray
    cycles: tuple[CycleRecord, ...]
    history: EventHistory
    stop: Stop | None
    scene: Scene | None = None

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
    reduce: bool = False,
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
    reduce
        Follow only the nodes that can move (:func:`reduced_scene`); the result
        is that of the full form, which is fallen back to where the state jumps.
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
    if reduce:
        require_plane("a reduced scene", problem)
        require_closed(opened)
        scene = reduced_scene(problem, load_factor, initial_slip)
        moving = scene.initial_slip[scene.moving]
        small = evolve(scene.problem, load_factor, moving, cycles=cycles, tolerances=tolerances)
        if small.stop is None and not any(cycle.jumps for cycle in small.cycles):
            return _expanded(problem, small, scene)
    evolution = Evolution(problem, load_factor, initial_slip, tolerances, damping, opened)
    start = evolution.state.u[problem.layout.slips]
    records = tuple(cycles_of(evolution, cycles, record=True))
    return EvolutionResult(float(load_factor), start, records, evolution.history, evolution.stop)


def require_closed(open_nodes: tuple[int, ...]) -> None:
    """Raise ``UsageError`` where nodes are open at the start of what is to be reduced."""
    if open_nodes:
        named = ", ".join(map(str, open_nodes[:8]))
        raise UsageError(f"reduce: expected all nodes closed at the start, found {named} open")


def _expanded(problem: Problem, small: EvolutionResult, scene: Scene) -> EvolutionResult:
    """A result of a reduced problem in terms of all nodes."""
    cycles = tuple(
        replace(
            cycle,
            end_slip=scene.spread(cycle.end_slip, scene.initial_slip),
            slip=scene.spread(cycle.slip, 0.0),
            work=scene.spread(cycle.work, 0.0),
            opened=scene.spread(cycle.opened, False),
            closed=scene.spread(cycle.closed, True),
        )
        for cycle in small.cycles
    )
    return EvolutionResult(
        load_factor=small.load_factor,
        initial_slip=scene.initial_slip,
        cycles=cycles,
        history=expanded_history(problem, small.load_factor, scene, small.history),
        stop=None,
        scene=scene,
    )


def expanded_history(
    problem: Problem, load_factor: float, scene: Scene, history: EventHistory
) -> EventHistory:
    """The history of a reduced problem in terms of all nodes."""
    v, w = scene.spread(history.v, scene.initial_slip), scene.spread(history.w, 0.0)
    welded = _welded_at(problem, load_factor, scene.initial_slip, history.cycle)
    q_w, p_w = problem.layout.split(welded)
    q, p = q_w + v @ problem.A + w @ problem.B, p_w + v @ problem.B.T
    if problem.C is not None:
        p = p + w @ problem.C
    nodes = np.flatnonzero(scene.moving)
    return EventHistory(
        cycle=history.cycle,
        kind=history.kind,
        node=np.where(history.node < 0, -1, nodes[history.node]),
        v=v,
        w=w,
        q=q,
        p=p,
        q_w=q_w,
        p_w=p_w,
        state=scene.spread(history.state, 0),
    )


def _welded_at(problem: Problem, load_factor: float, start: FloatArray, cycle: FloatArray) -> FloatArray:
    """Welded reactions (s, 2n) at times in cycles; negative ones are those before the first period."""
    loop, before = loop_path(problem, load_factor), transient_path(problem)
    at_rest = problem.layout.joined(start, np.zeros(problem.n))
    ramp = ramp_start(problem, first_load(problem, load_factor), at_rest)
    cycles = int(np.ceil(cycle.max(initial=0.0))) + 1
    path = np.vstack([ramp, before, *[loop] * cycles])
    times = (np.arange(len(path)) - 1 - len(before)) / problem.m
    return np.stack([np.interp(cycle, times, column) for column in path.T], axis=1)
