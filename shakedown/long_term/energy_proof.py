"""A verdict with proof: has the motion come into an energy ball, or into a box that it cannot leave?"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from math import nan
from typing import TypeGuard

import numpy as np

from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.bounds.energy.energy_bound import EnergyBound, energy_bound
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import UsageError
from shakedown.ground.evidence import Missing, allowed, present, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.long_term.passage import Passage
from shakedown.motion.kernels.contact_status import OPEN
from shakedown.motion.method import cycles_of
from shakedown.planar.collapse.box_bound import box_proves


@dataclass(frozen=True)
class EnergyProof:
    """Whether shakedown is proved, and how far the final state may be off, as in :class:`LongTermState`.

    NaN where a box proves it, of which no margin is worked out.
    """

    proved: bool
    margin: float
    single_node_margin: float


NO_PROOF, WITHOUT_MARGIN = EnergyProof(False, nan, nan), EnergyProof(True, nan, nan)
BELOW = 1.0 - 1e-9  # of a load factor up to which something is proved: round-off of the bound


@on_one_thread
def energy_proof(
    problem: Problem, passage: Passage, most: int, final_slip: FloatArray, open_nodes: tuple[int, ...] = ()
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
    problem, passage
        The joint; where the motion began, of the nodes that were followed.
    most
        After how many cycles at most states are looked at.
    final_slip : (n,)
        Where the motion comes to rest [length].
    open_nodes
        The nodes that are open at rest, all others closed.
    """
    load_factor = passage.load_factor
    ball = _ball(problem, load_factor, final_slip, passage.tolerances, open_nodes)
    if ball is not None and any(ball.contains(slip) for slip in slips_in_zone(passage, most, open_nodes)):
        return EnergyProof(True, float(ball.margin(final_slip)), float(ball.single_node_margin(final_slip)))
    if bound_proves(bound_of_start(passage), load_factor):
        return WITHOUT_MARGIN
    if open_nodes or problem.directions > 1:  # boxes are of one direction
        return NO_PROOF
    states = chain([final_slip], slips_in_zone(passage, most, ()))
    proofs = (sought(box_proves, problem, slip, load_factor, passage.tolerances) for slip in states)
    return WITHOUT_MARGIN if next(proofs) and any(proofs) else NO_PROOF


def slips_in_zone(passage: Passage, most: int, open_nodes: tuple[int, ...]) -> Iterator[FloatArray]:
    """Slips of all nodes after one cycle after the other, where exactly these are open."""
    evolution, scene = passage.motion(), passage.scene
    nodes = np.arange(passage.problem.n) if scene is None else np.flatnonzero(scene.moving)
    for record in cycles_of(evolution, most):
        if tuple(nodes[evolution.state.contact == OPEN].tolist()) == open_nodes:
            yield record.end_slip if scene is None else scene.spread(record.end_slip, scene.initial_slip)


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


def bound_proves(bound: EnergyBound | Missing, load_factor: float) -> TypeGuard[EnergyBound]:
    """Whether a load factor lies where a bound proves shakedown, by more than its round-off."""
    if isinstance(bound, Missing):
        return False
    return bool(bound.least_load_factor <= load_factor < BELOW * bound.load_factor)


def bound_of_start(begun: Passage) -> EnergyBound | Missing:
    """λ_E of the start, worked out once."""
    known = _known_bounds(begun.problem)
    asked = begun.start.tobytes(), begun.open_nodes, begun.tolerances
    if asked not in known:
        known[asked] = allowed(
            energy_bound, begun.problem, begun.start, open_nodes=begun.open_nodes, certify=False,
            tolerances=begun.tolerances,
        )  # fmt: skip
    return known[asked]


@once_per_problem
def _known_bounds(problem: Problem) -> dict[object, EnergyBound | Missing]:
    """Bounds of one problem that are known already, by start, open nodes and tolerances."""
    return {}
