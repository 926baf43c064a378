"""The load factor up to which least pressures prove shakedown from every state, with two directions."""

from dataclasses import dataclass, replace
from math import inf, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.bound_of_floating import bound_of_floating
from shakedown.bounds.every_state.disc_centres import Loops, disc_centres, leaning_discs
from shakedown.bounds.every_state.least_pressures import LeastPressures, least_pressures
from shakedown.bounds.every_state.scaled_joint import ScaledJoint, scaled_joint
from shakedown.bounds.every_state.sector_rows import sector_rows
from shakedown.bounds.every_state.sectors import every_direction, sectors_of
from shakedown.bounds.every_state.unique_rates import held
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, PER_CENT
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.arguments import checked
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

FIRST_SECTORS, MOST_SECTORS = 32, 256


@dataclass(frozen=True, eq=False, repr=False)
class LeastPressureBound(Result):
    """Largest load factor up to which friction under least pressures suffices everywhere.

    Attributes
    ----------
    status
        ``"optimal"``; ``"unbounded"`` where no load factor ends it.
    load_factor
        Proved, with all round-off taken off; 0 where least pressures prove nothing under the mean load.
    node
        The node that ends it; −1 where none does.
    lifts
        Whether it ends because that node could lift off.
    sectors
        Into how many sectors the directions of slip of that node were divided; 1: a disc.
    reactions : (dn,)
        z = A v*: under the load factor λ itself |q_w,i + z_i| is less than f_i p_i in every slip of node i
        [force]; NaN where the bound is 0 or inf. For smaller load factors −q⁰ + (λ'/λ)(z + q⁰) will do where
        something holds the body; else that need not be the A v* of any slip, and z⁰ + (λ'/λ)(z − z⁰) will.
    pressures : (n,)
        The least pressures under the mean load, over all slips [force]; NaN where no multipliers were found.
    lift_off_bound
        Up to here no slip lifts a node off: they stay positive at every load step, or those of sectors do.
    floats
        Whether friction alone holds the body: then only motions without their rigid part are unique.
    jumps
        Whether it ends because from there on motions are not proved to go on without a jump.
    of_nodes : (n,)
        Up to which load factor each node by itself would go; NaN where friction alone holds the body.
    mean_reactions : (dn,)
        Of a floating body z⁰, which does the same under the mean load alone [force]; else NaN.
    """

    status: Status
    load_factor: float
    node: int
    lifts: bool
    sectors: int
    reactions: FloatArray
    pressures: FloatArray
    lift_off_bound: float
    floats: bool
    jumps: bool
    mean_reactions: FloatArray
    of_nodes: FloatArray

    @property
    def limited_by(self) -> str:
        """The same as a word: swing, lift-off or rates."""
        return "rates" if self.jumps else "lift-off" if self.lifts else "swing"

    @property
    def reason(self) -> str:
        """What limits the bound, in words."""
        if self.status == Status.UNBOUNDED:
            return "no load factor ends the proof"
        if self.jumps:
            whole = "the body, which friction alone holds, is not proved to slip without a jump"
            return whole if self.load_factor == 0.0 else f"from there on {whole}"
        if self.node < 0:
            return "only friction holds the body, and the least that is left of it does not"
        if self.load_factor == 0.0 and not self.lifts:
            return f"node {self.node} has no friction, and its load varies"
        if self.load_factor == 0.0 and np.isnan(self.pressures[self.node]):
            return f"no least pressure of node {self.node} was found"
        if self.load_factor == 0.0:
            return f"some locked-in slip may lift node {self.node} off, under the mean load alone"
        if self.lifts:
            return f"from there on locked-in slip may lift node {self.node} off"
        return f"from there on the least friction of node {self.node} does not outweigh the swing of its load"


class _Reach(NamedTuple):
    """The limits set by the nodes: 1/λ, their centres, and their numbers of sectors."""

    inverse: FloatArray
    centre: FloatArray
    sectors: NDArray[np.intp]

    @property
    def of_nodes(self) -> FloatArray:
        """λ of every node."""
        return np.divide(1.0, self.inverse, out=np.full(len(self.inverse), inf), where=self.inverse > 0)


@checked
def least_pressure_bound(problem: Problem, *, sectors: int | None = None) -> LeastPressureBound:
    """The load factor below which every closed motion shakes down, from every state, by least pressures.

    Every node i needs a reaction z_i with |q_w,i + z_i| < f_i p_i under every load of the loop, for the
    least p_i of all admissible slips in which it slips; z = A v*. Then the elastic energy of the distance
    to v* falls whenever a node slips (docs/universal.md, statements 6.1 to 6.5).

    Parameters
    ----------
    problem
        A joint with two tangential directions, or with one that friction alone holds.
    sectors
        How many sectors the directions of slip are divided into: 1 are discs. By default discs that lean the
        way slip itself presses a node, and as many sectors as raise the bound by 1 % or more, only at nodes
        that limit it.

    Raises
    ------
    UsageError
        If the joint has one tangential direction and is held, or ``sectors`` is neither 1 nor 4 to 4096.

    Examples
    --------
    >>> loop = {"f": 0.4, "q_w": [[0.5, 0.0], [-0.5, 0.0]], "p_w": [[2.0], [2.0]]}
    >>> bound = least_pressure_bound(Problem(A=np.eye(2), B=np.zeros((1, 2)), **loop))
    >>> round(bound.load_factor, 9), bound.node, bound.pressures
    (1.6, 0, array([2.]))
    """
    joint = scaled_joint(problem)
    if problem.directions != 2 and not joint.floats:
        raise UsageError("least pressures: expected two tangential directions, found one (swing_bound)")
    if sectors is not None:
        check_count("sectors", sectors)
        if sectors in (2, 3) or sectors > 4096:
            raise UsageError(f"sectors: expected 1, or 4 to 4096, found {sectors}")
    if not held(joint) or (joint.floats and (joint.f == 0).any()):
        return _nothing(joint, -1, np.full(joint.n, nan))
    if joint.floats:
        return _floating(problem, joint)
    discs = least_pressures(joint, every_direction(np.arange(joint.n)))
    pressures = discs.at(joint, joint.q0[None], joint.p0[None])[0]
    lift_off = _lift_off(joint, discs, pressures)
    reach = _of_discs(joint, discs, pressures, lean=sectors is None)
    if not (pressures > 0).all():
        return replace(_nothing(joint, int(pressures.argmin()), pressures), of_nodes=reach.of_nodes)
    reach = _divided(joint, reach, sectors)
    return _result(joint, reach, pressures, lift_off)


def _floating(problem: Problem, joint: ScaledJoint) -> LeastPressureBound:
    """The bound for a body that friction alone holds."""
    discs, reach = bound_of_floating(problem, DEFAULT)
    pressures = discs.at(joint, joint.q0[None], joint.p0[None])[0]
    if reach is None:
        lowest = int(pressures.argmin())
        return _nothing(joint, lowest if pressures[lowest] <= 0 else -1, pressures)
    if reach.load_factor == 0.0:
        return replace(_nothing(joint, -1, pressures), jumps=reach.jumps)
    lifted = float(_lift_off(joint, discs, pressures).max())
    return LeastPressureBound(
        status=Status.OPTIMAL if reach.load_factor < inf else Status.UNBOUNDED,
        load_factor=reach.load_factor,
        node=reach.node,
        lifts=False,
        sectors=1,
        reactions=joint.of_joint(reach.reactions),
        pressures=pressures / joint.lengths,
        lift_off_bound=max(reach.load_factor, inf if lifted <= 0.0 else 1.0 / lifted),
        floats=True,
        jumps=reach.jumps,
        mean_reactions=joint.of_joint(reach.mean_reactions),
        of_nodes=np.full(joint.n, nan),
    )


def _lift_off(joint: ScaledJoint, discs: LeastPressures, pressures: FloatArray) -> FloatArray:
    """1/λ of the load factor at which the least pressure of every node vanishes, (n,)."""
    falling = -discs.at(joint, joint.q1, joint.p1).min(axis=0)
    return np.maximum(falling, 0.0) / np.where(pressures > 0, pressures, nan)


def _of_discs(joint: ScaledJoint, discs: LeastPressures, pressures: FloatArray, *, lean: bool) -> _Reach:
    """The requirements of every node with one disc, leaning or not; a node without friction bears no change.

    A node that locked-in slip may lift off under the mean load alone bears nothing.
    """
    n, path = joint.n, joint.q1.reshape(len(joint.q1), -1, 2)
    varies = path.any(axis=(0, 2))
    pressed = pressures > 0
    inverse, centre = np.where(varies | ~pressed, inf, 0.0), np.zeros((n, 2))
    rough = np.flatnonzero((joint.f > 0) & pressed)
    if len(rough):
        growing, constant = joint.f * discs.at(joint, joint.q1, joint.p1), joint.f * pressures
        found = disc_centres(
            Loops(every_direction(rough), path[:, rough], growing[:, rough, None], constant[rough, None])
        )
        inverse[rough], centre[rough] = found.above, found.centre
    if len(rough) and lean:
        shapes, regular = leaning_discs(joint, discs)
        chosen = rough[regular[rough]]
        own = Loops(shapes.part(chosen), path[:, chosen], growing[:, chosen, None], constant[chosen, None])
        found = disc_centres(own)
        better = found.above < inverse[chosen]
        inverse[chosen[better]], centre[chosen[better]] = found.above[better], found.centre[better]
    smooth = (joint.f == 0) & pressed
    inverse[smooth] = np.maximum(inverse, _lift_off(joint, discs, pressures))[smooth]
    return _Reach(inverse, centre, np.ones(n, dtype=np.intp))


def _divided(joint: ScaledJoint, reach: _Reach, sectors: int | None) -> _Reach:
    """The bound improved by sectors at the nodes that limit it."""
    if sectors == 1 or not joint.fB.any():
        return reach
    if sectors is not None:
        return _with_sectors(joint, reach, sectors)
    count = FIRST_SECTORS
    while count <= MOST_SECTORS:
        before, reach = reach.inverse.max(), _with_sectors(joint, reach, count)
        if not reach.inverse.max() * (1.0 + PER_CENT) <= before:
            break
        count *= 2
    return reach


def _with_sectors(joint: ScaledJoint, reach: _Reach, count: int) -> _Reach:
    """Use a number of sectors at the limiting node, until no node with fewer sectors limits the bound."""
    inverse, centre, taken = reach.inverse.copy(), reach.centre.copy(), reach.sectors.copy()
    tried = joint.f == 0
    while not tried[node := int(inverse.argmax())] and 0.0 < inverse[node] < inf:
        tried[node] = True
        found = _one_node(joint, node, count)
        if found is not None and found[0] < inverse[node]:
            inverse[node], centre[node], taken[node] = *found, count
    return _Reach(inverse, centre, taken)


def _one_node(joint: ScaledJoint, node: int, count: int) -> tuple[float, FloatArray] | None:
    """1/λ and the centre of one node with so many sectors; None where they prove nothing."""
    first, half = _first_direction(joint, node)[None], np.pi / count
    least = least_pressures(joint, replace(sectors_of(np.array([node]), first, count), half=0.0))
    ends, sizes = sector_rows(joint, least, half)
    limits = joint.f[node] / sizes
    constant = np.repeat(least.at(joint, joint.q0[None], joint.p0[None]), 2, axis=1) * limits
    if not (constant > 0).all():
        return None
    growing = np.repeat(least.at(joint, joint.q1, joint.p1), 2, axis=1) * limits
    path = joint.q1[:, None, 2 * node : 2 * node + 2]
    found = disc_centres(Loops(ends, path, growing[:, None], constant))
    return float(found.above[0]), found.centre[0]


def _first_direction(joint: ScaledJoint, node: int) -> FloatArray:
    """A direction that turns with the tangents: how its own slip presses a node, or its largest load."""
    own = joint.B[node, 2 * node : 2 * node + 2]
    if not own.any():
        path = joint.q1[:, 2 * node : 2 * node + 2]
        own = path[np.hypot(path[:, 0], path[:, 1]).argmax()]
    size = np.hypot(own[0], own[1])
    return np.asarray(own / size if size > 0 else np.array([1.0, 0.0]))


def _result(
    joint: ScaledJoint, reach: _Reach, pressures: FloatArray, lift_off: FloatArray
) -> LeastPressureBound:
    node = int(reach.inverse.argmax())
    largest, lifted = float(reach.inverse[node]), float(lift_off.max())
    load_factor = inf if largest <= 0.0 else 1.0 / largest
    known = 0.0 < load_factor < inf
    z = load_factor * reach.centre.ravel() - joint.q0 if known else np.full(2 * joint.n, nan)
    return LeastPressureBound(
        status=Status.OPTIMAL if load_factor < inf else Status.UNBOUNDED,
        load_factor=load_factor,
        node=node if load_factor < inf else -1,
        lifts=bool(lift_off[node] >= (1.0 - NEGLIGIBLE) * largest) and largest > 0,
        sectors=int(reach.sectors[node]),
        reactions=z / np.repeat(joint.lengths, 2),
        pressures=pressures / joint.lengths,
        lift_off_bound=max(load_factor, inf if lifted <= 0.0 else 1.0 / lifted),
        floats=False,
        jumps=False,
        mean_reactions=np.full(2 * joint.n, nan),
        of_nodes=reach.of_nodes,
    )


def _nothing(joint: ScaledJoint, node: int, pressures: FloatArray) -> LeastPressureBound:
    found = np.where(np.isfinite(pressures), pressures, nan) / joint.lengths
    nowhere = np.full(joint.directions * joint.n, nan)
    return LeastPressureBound(
        Status.OPTIMAL, 0.0, node, node >= 0, 1, nowhere, found, 0.0, joint.floats, False, nowhere, 0 * found
    )
