"""The load factor up to which least pressures prove shakedown from every state."""

from dataclasses import dataclass, replace
from math import inf, nan

import numpy as np

from shakedown.bounds.every_state.bound_of_floating import Reach, floating_reach
from shakedown.bounds.every_state.least_pressures import (
    LeastPressures,
    least_pressures,
    pressures_of_floating,
)
from shakedown.bounds.every_state.reaction_centres import Loops, reaction_centres
from shakedown.bounds.every_state.scaled_joint import ScaledJoint, scaled_joint
from shakedown.bounds.every_state.slip_curves import slip_curves
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.arguments import checked
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class LeastPressureBound(Result):
    """Largest load factor up to which friction under least pressures suffices everywhere.

    Attributes
    ----------
    status
        ``"optimal"``; ``"unbounded"`` where no load factor ends it.
    load_factor
        Proved of motions with all nodes closed, with all round-off taken off; 0 where least pressures prove
        nothing under the mean load.
    node
        The node that ends it; −1 where none does.
    limited_by
        What ends it: ``"swing"`` of a node's load, ``"lift-off"``, or ``"rates"``: from there on motions are
        not proved to go on without a jump.
    reason
        The same in words.
    pressures : (n,)
        The least pressures under the mean load, over all slips [force]; NaN where no multipliers were found.
    lift_off_bound
        Up to here no slip lifts a node off.
    floats
        Whether friction alone holds the body: then only motions without their rigid part are unique.
    reactions : (dn,)
        z = A v*: under the load factor λ itself f_i p_i + u · (q_w,i + z_i) is positive in every slip of
        node i along u [force]; NaN where the bound is 0 or inf. For smaller load factors
        −q⁰ + (λ'/λ)(z + q⁰) will do where something holds the body; else that need not be the A v* of any
        slip, and z⁰ + (λ'/λ)(z − z⁰) will.
    mean_reactions : (dn,)
        Of a floating body z⁰, which does the same under the mean load alone [force]; else NaN.
    """

    status: Status
    load_factor: float
    node: int
    limited_by: str
    reason: str
    pressures: FloatArray
    lift_off_bound: float
    floats: bool
    reactions: FloatArray
    mean_reactions: FloatArray


@checked
def least_pressure_bound(problem: Problem, *, unique: bool = False) -> LeastPressureBound:
    """The load factor below which every closed motion shakes down, from every state, by least pressures.

    Every node i needs a reaction z_i with f_i p_i + u · (q_w,i + z_i) > 0 under every load of the hull of the
    loop, for all admissible slips in which it slips along u; z = A v*. Then the elastic energy of the
    distance to v* falls whenever a node slips (docs/universal.md, statements 6.1 to 6.5).

    Parameters
    ----------
    problem
        The contact and its loading loop.
    unique
        Whether motions are known to be unique: then the rigid motions of a body that friction alone
        holds need no proof of their own.

    Examples
    --------
    >>> import shakedown
    >>> bound = least_pressure_bound(shakedown.example("two-node"))
    >>> round(bound.load_factor, 7), bound.node
    (0.6035788, 1)
    """
    joint = scaled_joint(problem)
    nowhere = np.full(len(joint.q0), nan)
    found = LeastPressureBound(
        status=Status.OPTIMAL,
        load_factor=0.0,
        node=-1,
        limited_by="swing",
        reason="only friction holds the body, and the least that is left of it does not",
        pressures=np.full(joint.n, nan),
        lift_off_bound=0.0,
        floats=joint.floats,
        reactions=nowhere,
        mean_reactions=nowhere,
    )
    if not joint.held or (joint.floats and (joint.f == 0).any()):
        return found
    least = pressures_of_floating(joint) if joint.floats else least_pressures(joint)
    pressures = least.at(joint, joint.q0[None], joint.p0[None])[0]
    found = replace(found, pressures=np.where(least.proved, pressures, nan) / joint.lengths)
    if not (pressures > 0).all():
        node = int(pressures.argmin())
        reason = f"some locked-in slip may lift node {node} off, under the mean load alone"
        if not least.proved[node]:
            reason = f"no least pressure of node {node} was found"
        return replace(found, node=node, limited_by="lift-off", reason=reason)
    lift_off = _lift_off(joint, least, pressures)
    found = replace(found, lift_off_bound=_load_factor(lift_off.max()))
    if joint.floats:
        reach = floating_reach(joint, least, unique, DEFAULT)
    else:
        reach = _of_held(joint, least, pressures, lift_off)
    if reach is None:
        return found
    load_factor, node = reach.load_factor, reach.node
    reasons = {
        "swing": f"the least friction of node {node} does not outweigh the swing of its load",
        "lift-off": f"locked-in slip may lift node {node} off",
        "rates": "the body, which friction alone holds, is not proved to slip without a jump",
    }
    reason = "from there on " * (load_factor > 0.0) + reasons[reach.limited_by]
    if load_factor == 0.0 and not joint.floats:
        reason = f"node {node} has no friction, and its load varies"
    closed = joint.floats or joint.d == 2
    return replace(
        found,
        status=Status.OPTIMAL if load_factor < inf else Status.UNBOUNDED,
        load_factor=load_factor,
        node=node if load_factor < inf else -1,
        limited_by=reach.limited_by,
        reason=reason if load_factor < inf else "no load factor ends the proof",
        lift_off_bound=max(load_factor if closed else 0.0, found.lift_off_bound),
        reactions=joint.of_joint(reach.reactions) if load_factor > 0.0 else nowhere,
        mean_reactions=joint.of_joint(reach.mean_reactions),
    )


def _of_held(joint: ScaledJoint, least: LeastPressures, pressures: FloatArray, lift_off: FloatArray) -> Reach:
    """How far every node by itself lets the load grow; one without friction bears no change."""
    path, growing = joint.law.layout.by_node(joint.q1), least.at(joint, joint.q1, joint.p1)
    inverse, centre = np.where(path.any(axis=(0, 2)), inf, lift_off), np.zeros((joint.n, joint.d))
    rough = np.flatnonzero(joint.f > 0)
    f, curves = joint.f[rough], slip_curves(joint, least).part(rough)
    loops = Loops(curves, path[:, rough], f * growing[:, rough], f * pressures[rough])
    inverse[rough], centre[rough] = reaction_centres(loops)
    node, load_factor, nowhere = int(inverse.argmax()), _load_factor(inverse.max()), np.full(centre.size, nan)
    lifts = inverse[node] > 0.0 and lift_off[node] >= (1.0 - NEGLIGIBLE) * inverse[node]
    z = load_factor * centre.ravel() - joint.q0 if load_factor < inf else nowhere
    return Reach(load_factor, z, nowhere, node, "lift-off" if lifts else "swing")


def _lift_off(joint: ScaledJoint, least: LeastPressures, pressures: FloatArray) -> FloatArray:
    """1/λ of the load factor at which the least pressure of every node vanishes, (n,)."""
    return np.maximum(-least.at(joint, joint.q1, joint.p1).min(axis=0), 0.0) / pressures


def _load_factor(inverse: float) -> float:
    return inf if inverse <= 0.0 else 1.0 / float(inverse)
