"""A verdict with proof: has the motion come into an energy ball, or into a box that it cannot leave?"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from math import inf, log, nan
from typing import NamedTuple, TypeGuard

import numpy as np

from shakedown.bounds.collapse.box_bound import BoxBound, box_bound, box_proves
from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball, holding_ball
from shakedown.bounds.energy.energy_bound import EnergyBound, energy_bound
from shakedown.bounds.methods import methods_of
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.contact_status import OPEN
from shakedown.ground.errors import UsageError
from shakedown.ground.evidence import Missing, allowed, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.long_term.passage import FirstCycles, Passage
from shakedown.motion.method import cycles_of


@dataclass(frozen=True)
class EnergyProof:
    """Whether shakedown is proved, and how far the final state may be off, as in :class:`LongTermState`.

    NaN where a box proves it, of which no margin is worked out. ``best`` says that the margins are those
    of the best ball that was found.
    """

    proved: bool
    margin: float
    single_node_margin: float
    best: bool = True


class Approach(NamedTuple):
    """How a motion comes to rest.

    Attributes
    ----------
    final_slip : (n,)
        Where [length].
    open_nodes
        The nodes that are open there, all others closed.
    most
        After how many cycles at most states are looked at.
    contraction
        Factor per cycle by which the distance shrinks in the end; NaN unknown.
    first_cycles
        The states after the first cycles, where they are kept.
    """

    final_slip: FloatArray
    open_nodes: tuple[int, ...]
    most: int
    contraction: float = nan
    first_cycles: FirstCycles | None = None


NO_PROOF, WITHOUT_MARGIN = EnergyProof(False, nan, nan), EnergyProof(True, nan, nan)
ABOVE = 1.0 + DEFAULT.agreement  # of λ_max: more than it may be off
NO_BOX = "boxes are of one tangential direction, all nodes closed"
BELOW = 1.0 - NEGLIGIBLE  # of a load factor up to which something is proved: round-off of the bound


@on_one_thread
def energy_proof(passage: Passage, approach: Approach) -> EnergyProof:
    """What an energy ball, or else the least box, proves of a motion that has been found to shake down.

    Within a ball the distance from its centre never grows. So a motion that comes to
    rest outside has never been inside, and one that comes to rest inside is there
    after finitely many cycles: the ball that holds the state at rest best is found, and
    the states that the motion really passes through are looked at until one is inside.
    Where none is, the least box of the state at rest, which is inside those of the states before,
    tells whether any of theirs can be a proof. In space any ball that holds the state comes first.

    Parameters
    ----------
    passage
        The joint, and where its motion began.
    approach
        Where it comes to rest, and what is known of how it gets there.
    """
    methods = methods_of(passage.problem)
    for best in (False, True) if methods.HOLDING_BALL_SOONER else (True,):
        ball = _ball(passage, approach, best=best)
        if not isinstance(ball, EnergyBall):
            break
        if comes_into(ball, passage, approach):
            return _proof_of(ball, approach, best=best)
    # A ball that holds the start holds the state at rest: λ_E is not worked out where none does.
    known = _key(passage) in _known_bounds(passage.problem)
    asked = best or ball is not None or known
    if asked and bound_proves(bound_of_start(passage), passage.load_factor):
        return WITHOUT_MARGIN
    if approach.open_nodes or "box" in methods.ABSENT:
        return NO_PROOF
    states = chain([approach.final_slip], slips_in_zone(passage, approach))
    about = passage.load_factor, passage.tolerances
    proofs = (sought(box_proves, passage.problem, slip, *about) for slip in states)
    return WITHOUT_MARGIN if next(proofs) and any(proofs) else NO_PROOF


def with_margins(passage: Passage, approach: Approach) -> EnergyProof:
    """The proof by an energy ball with the margins of the ball that holds the state at rest best."""
    ball = on_one_thread(_ball)(passage, approach, best=True)
    return _proof_of(ball, approach, best=True) if isinstance(ball, EnergyBall) else WITHOUT_MARGIN


def proof_in(ball: EnergyBall, passage: Passage, approach: Approach) -> EnergyProof | None:
    """The proof by a given ball of the load factor; None where it proves nothing."""
    holds = ball.open_nodes == approach.open_nodes and bool(ball.contains(approach.final_slip))
    return _proof_of(ball, approach, best=True) if holds and comes_into(ball, passage, approach) else None


def held_by_friction(problem: Problem, load_factor: float, slip: FloatArray) -> float:
    """How far friction can hold any one node off from a slip at some load step, the others in place [length].

    Off by e, with all nodes closed, the reactions of node i change by A_ii e and B_ii e: from one within
    f p to another, |A_ii e| ≤ 2 f p + f |B_ii e|. inf where that is no bound.

    Examples
    --------
    >>> import shakedown
    >>> round(held_by_friction(shakedown.example("one-node"), 0.0, np.zeros(1)), 3)
    2.667
    """
    n, d, law = problem.n, problem.directions, problem.law
    own = np.arange(n)
    least = np.linalg.svd(problem.A.reshape(n, d, n, d)[own, :, own], compute_uv=False)[:, -1]
    coupled = np.linalg.norm(problem.B.reshape(n, n, d)[own, own], axis=1)
    most = (loading(problem).at(load_factor)[1] + problem.B @ slip).max(axis=0)
    resisted = least - law.limit(coupled)
    if not resisted.min() > 0:
        return inf
    return float(np.max(2.0 * law.limit(np.maximum(most, 0.0)) / resisted))


def _proof_of(ball: EnergyBall, approach: Approach, *, best: bool) -> EnergyProof:
    slip = approach.final_slip
    return EnergyProof(True, float(ball.margin(slip)), float(ball.single_node_margin(slip)), best)


def comes_into(ball: EnergyBall, passage: Passage, approach: Approach) -> bool:
    """Whether the motion, which comes to rest in a ball, is seen to be in it after some cycle."""
    first_cycles = approach.first_cycles
    if first_cycles is None:
        return any(ball.contains(slip) for slip in slips_in_zone(passage, approach))
    zone = np.isin(np.arange(first_cycles.opened.shape[1]), approach.open_nodes)
    slips = np.array([record.end_slip for record in first_cycles.records])
    inside = ball.contains(slips) & (first_cycles.opened == zone).all(axis=1)
    if inside.any():
        return True
    away = float(ball.distance(slips[-1])) - float(ball.distance(approach.final_slip))
    if _cycles_left(away, float(ball.margin(approach.final_slip)), approach.contraction) > approach.most:
        return False
    return any(ball.contains(slip) for slip in slips_in_zone(passage, approach))


def _cycles_left(away: float, margin: float, contraction: float) -> float:
    """After how many cycles what is left of a distance that shrinks so is less than a margin, about."""
    if not away > margin or not contraction > 0.0:
        return 0.0
    return log(margin / away) / log(contraction) if contraction < 1.0 else inf


def slips_in_zone(passage: Passage, approach: Approach) -> Iterator[FloatArray]:
    """Slips after one cycle after the other, where exactly the open nodes are open.

    Where the first cycles are kept, those after them.
    """
    first_cycles, done, motion = approach.first_cycles, 0, passage.motion()
    if first_cycles is not None:
        done = len(first_cycles.records)
        motion = passage.motion_from(first_cycles.state, done)
    for record in cycles_of(motion, max(approach.most - done, 0)):
        if tuple(np.flatnonzero(motion.state.contact == OPEN).tolist()) == approach.open_nodes:
            yield record.end_slip


def _ball(passage: Passage, approach: Approach, *, best: bool) -> EnergyBall | Missing | None:
    """A ball that holds the state at rest, or the best; None where none does, or there is no such zone."""
    about, state = (passage.problem, passage.load_factor), approach.final_slip
    opened, tolerances = approach.open_nodes, passage.tolerances
    try:
        if best:
            found = sought(
                energy_ball, *about, around=state, transient=False, open_nodes=opened, tolerances=tolerances
            )
        else:
            found = sought(holding_ball, *about, state, opened, tolerances)
    except UsageError:  # there is no such zone
        return None
    return found if isinstance(found, Missing) or found.contains(approach.final_slip) else None


def bound_proves(bound: EnergyBound | Missing, load_factor: float) -> TypeGuard[EnergyBound]:
    """Whether a load factor lies where a bound proves shakedown, by more than its round-off."""
    if isinstance(bound, Missing):
        return False
    return bool(bound.least_load_factor <= load_factor < BELOW * bound.load_factor)


def bound_of_start(begun: Passage) -> EnergyBound | Missing:
    """λ_E of the start, worked out once."""
    known, asked = _known_bounds(begun.problem), _key(begun)
    if asked not in known:
        known[asked] = allowed(
            energy_bound, begun.problem, begun.start, open_nodes=begun.open_nodes, certify=False,
            tolerances=begun.tolerances,
        )  # fmt: skip
    return known[asked]


def note_bound(begun: Passage, bound: EnergyBound) -> None:
    """Keep λ_E of a start that is known already."""
    _known_bounds(begun.problem).setdefault(_key(begun), bound)


def box_of_start(begun: Passage) -> BoxBound | Missing:
    """λ_box of the start, worked out once; Missing where nodes are open there, and in space."""
    known, asked = _known_boxes(begun.problem), _key(begun)
    if begun.open_nodes or "box" in methods_of(begun.problem).ABSENT:
        return Missing(NO_BOX)
    if asked not in known:
        known[asked] = box_bound(begun.problem, begun.start, tolerances=begun.tolerances)
    return known[asked]


def note_box(begun: Passage, box: BoxBound) -> None:
    """Keep λ_box of a start that is known already."""
    _known_boxes(begun.problem).setdefault(_key(begun), box)


@once_per_problem
def _known_boxes(problem: Problem) -> dict[object, BoxBound]:
    """Boxes of one problem that are known already, by start, open nodes and tolerances."""
    return {}


def _key(begun: Passage) -> object:
    return begun.start.tobytes(), begun.open_nodes, begun.tolerances


@once_per_problem
def _known_bounds(problem: Problem) -> dict[object, EnergyBound | Missing]:
    """Bounds of one problem that are known already, by start, open nodes and tolerances."""
    return {}


@once_per_problem
def known_limits(problem: Problem) -> dict[str, float]:
    """λ_max and λ_U of a problem with all nodes closed, by their words, where they are known already."""
    return {}


def beyond_all(begun: Passage) -> bool:
    """Whether a load factor is known to be above λ_max, by more than its round-off."""
    return begun.load_factor > ABOVE * known_limits(begun.problem).get("upper", inf)
