"""A verdict with proof: has the motion come into an energy ball, or into a box that it cannot leave?"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from math import nan

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import UsageError
from shakedown.ground.evidence import present, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.motion.cycle_record import State
from shakedown.motion.integrator import Evolution
from shakedown.motion.kernels.contact_status import OPEN
from shakedown.motion.reduced_scene import Scene
from shakedown.planar.collapse.box_bound import box_proves


@dataclass(frozen=True)
class Passage:
    """The states that a motion really passed through between its first cycles, and how to go on from there.

    Attributes
    ----------
    problem, load_factor, tolerances
        What was followed; the problem is that of the scene where there is one.
    start : (n,)
        Slip at the very start [length].
    states
        After the transient and one or more cycles.
    most
        How many more cycles may be followed.
    scene
        What was left out.
    """

    problem: Problem
    load_factor: float
    tolerances: Tolerances
    start: FloatArray
    states: tuple[State, ...]
    most: int
    scene: Scene | None = None

    def slips_in_zone(self, open_nodes: tuple[int, ...]) -> Iterator[FloatArray]:
        """Slips of all nodes after one cycle after the other, where exactly these are open."""
        for state in self.states:
            if self._open(state.contact) == open_nodes:
                yield self._of_all(state.u[self.problem.layout.slips])
        evolution = Evolution(self.problem, self.load_factor, self.start, self.tolerances)
        evolution.state, evolution.done = self.states[-1], len(self.states)
        for _ in range(self.most):
            if evolution.cycle() is None:
                return
            if self._open(evolution.active.state) == open_nodes:
                yield self._of_all(evolution.motion.u[self.problem.layout.slips].copy())

    def _open(self, contact: NDArray[np.int64]) -> tuple[int, ...]:
        """The open nodes, numbered in the whole joint."""
        nodes = np.flatnonzero(contact == OPEN)
        return tuple((nodes if self.scene is None else np.flatnonzero(self.scene.moving)[nodes]).tolist())

    def _of_all(self, slip: FloatArray) -> FloatArray:
        return slip if self.scene is None else self.scene.spread(slip, self.scene.initial_slip)


@dataclass(frozen=True)
class EnergyProof:
    """Whether shakedown is proved, and how far the final state may be off, as in :class:`LongTermState`.

    NaN where a box proves it, of which no margin is worked out.
    """

    proved: bool
    margin: float
    single_node_margin: float


NO_PROOF, BY_BOX = EnergyProof(False, nan, nan), EnergyProof(True, nan, nan)


@on_one_thread
def energy_proof(
    problem: Problem,
    load_factor: float,
    final_slip: FloatArray,
    passage: Passage,
    open_nodes: tuple[int, ...] = (),
) -> EnergyProof:
    """What an energy ball, or else the least box, proves of a motion that has been found to shake down.

    Within a ball the distance from its centre never grows. So a motion that comes to
    rest outside has never been inside, and one that comes to rest inside is there
    after finitely many cycles: the ball that holds the state at rest best is found, and
    the states that the motion really passes through are looked at until one is inside.
    Where none is, the least box of the state at rest, which is inside those of the states before,
    tells whether any of theirs can be a proof.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ.
    final_slip : (n,)
        Where the motion comes to rest [length].
    passage
        The states that it passes through.
    open_nodes
        The nodes that are open at rest, all others closed.
    """
    ball = _ball(problem, load_factor, final_slip, passage.tolerances, open_nodes)
    if ball is not None and any(ball.contains(slip) for slip in passage.slips_in_zone(open_nodes)):
        return EnergyProof(True, float(ball.margin(final_slip)), float(ball.single_node_margin(final_slip)))
    if open_nodes:
        return NO_PROOF
    states = chain([final_slip], passage.slips_in_zone(()))
    proofs = (sought(box_proves, problem, slip, load_factor, passage.tolerances) for slip in states)
    return BY_BOX if next(proofs) and any(proofs) else NO_PROOF


def _ball(
    problem: Problem,
    load_factor: float,
    final_slip: FloatArray,
    tolerances: Tolerances,
    open_nodes: tuple[int, ...],
) -> EnergyBall | None:
    """The ball that holds the state at rest best; None where there is none, or no such zone."""
    try:
        ball = sought(
            energy_ball,
            problem,
            load_factor,
            around=final_slip,
            transient=False,
            open_nodes=open_nodes,
            tolerances=tolerances,
        )
    except UsageError:  # there is no such zone
        return None
    found = present(ball)
    return found if found is not None and found.contains(final_slip) else None
