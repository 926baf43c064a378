"""λ_U: up to which load factor a joint is proved to shake down from every initial state."""

from dataclasses import dataclass, replace
from math import inf, isnan, nan
from typing import Any, ClassVar

import numpy as np

from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.coupling import Uniqueness
from shakedown.bounds.every_state import least_pressures
from shakedown.bounds.every_state.bound_of_floating import Reach, floating_reach, unique_rates
from shakedown.bounds.every_state.least_pressures import LeastPressures, NodeLoads, ScaledJoint, SlipCurves
from shakedown.bounds.lower import lower_bound
from shakedown.bounds.proof_status import Argument
from shakedown.bounds.scaled_solution import safe_under_mean_load
from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.errors import Missing, UsageError, attempt, present
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked
from shakedown.joint.contact_zone import Part, coupled_parts, weakest
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

    pressures: FloatArray
    reactions: FloatArray
    mean_reactions: FloatArray
    floats: bool
    status: Status = Status.OPTIMAL
    load_factor: float = 0.0
    node: int = -1
    limited_by: str = "swing"
    reason: str = "only friction holds the body, and the least that is left of it does not"
    lift_off_bound: float = 0.0


@checked
def least_pressure_bound(problem: Problem, *, unique: bool = False) -> LeastPressureBound:
    """The load factor below which every closed motion shakes down, from every state, by least pressures.

    Every node i needs a reaction z_i with f_i p_i + u · (q_w,i + z_i) > 0 under every load of the hull of the
    loop, for all admissible slips in which it slips along u; z = A v*. Then the elastic energy of the
    distance to v* falls whenever a node slips (docs/universal.md, Theorem 2).

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
    joint = least_pressures.scaled_joint(problem)
    nowhere = np.full(len(joint.q0), nan)
    found = LeastPressureBound(np.full(joint.n, nan), nowhere, nowhere, joint.floats)
    if not joint.held or (joint.floats and (joint.f == 0).any()):
        return found
    found_by = least_pressures.pressures_of_floating if joint.floats else least_pressures.least_pressures
    least = found_by(joint)
    pressures = least.at(joint, joint.q0[None], joint.p0[None])[0]
    found = replace(found, pressures=np.where(least.proved, pressures, nan) / joint.lengths)
    if not (pressures > 0).all():
        node = int(pressures.argmin())
        reason = f"some locked-in slip may lift node {node} off, under the mean load alone"
        if not least.proved[node]:
            reason = f"no least pressure of node {node} was found"
        return replace(found, node=node, limited_by="lift-off", reason=reason)
    # 1/λ of the load factor at which the least pressure of every node vanishes
    lift_off = np.maximum(-least.at(joint, joint.q1, joint.p1).min(axis=0), 0.0) / pressures
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
    return replace(
        found,
        status=Status.OPTIMAL if load_factor < inf else Status.UNBOUNDED,
        load_factor=load_factor,
        node=node if load_factor < inf else -1,
        limited_by=reach.limited_by,
        reason=reason if load_factor < inf else "no load factor ends the proof",
        lift_off_bound=max(load_factor, found.lift_off_bound),
        reactions=joint.unscaled(reach.reactions) if load_factor > 0.0 else nowhere,
        mean_reactions=joint.unscaled(reach.mean_reactions),
    )


def _of_held(joint: ScaledJoint, least: LeastPressures, pressures: FloatArray, lift_off: FloatArray) -> Reach:
    """How far every node by itself lets the load grow; one without friction bears no change."""
    path, growing = joint.law.layout.by_node(joint.q1), least.at(joint, joint.q1, joint.p1)
    inverse, centre = np.where(path.any(axis=(0, 2)), inf, lift_off), np.zeros((joint.n, joint.d))
    rough = np.flatnonzero(joint.f > 0)
    f, curves = joint.f[rough], least_pressures.slip_curves(joint, least)
    curves = SlipCurves(curves.size[rough], curves.lean[rough], curves.loose[rough])
    loops = NodeLoads(curves, path[:, rough], f * growing[:, rough], f * pressures[rough])
    inverse[rough], centre[rough] = least_pressures.reaction_centres(loops)
    node, load_factor, nowhere = int(inverse.argmax()), _load_factor(inverse.max()), np.full(centre.size, nan)
    lifts = inverse[node] > 0.0 and lift_off[node] >= (1.0 - NEGLIGIBLE) * inverse[node]
    z = load_factor * centre.ravel() - joint.q0 if load_factor < inf else nowhere
    return Reach(load_factor, z, nowhere, node, "lift-off" if lifts else "swing")


def _load_factor(inverse: float) -> float:
    return inf if inverse <= 0.0 else 1.0 / float(inverse)


ARGUMENTS = {  # what the names of the proofs stand for, where they are not self-explanatory
    "Melan": "slip changes no pressure",
    "differences": "no slip raises the differences between nodes",
    "least pressures": "each node is held by friction under the least pressure that slip of others can leave",
    "rigid motions apart": "slip of a body as a whole is bounded on its own",
}


@dataclass(frozen=True, eq=False, repr=False)
class EveryState(Evidence):
    """What only λ_U has, the largest load factor up to which shakedown from every initial state is proved.

    A state is one with all nodes closed that is admissible at some instant of the loop; transient
    load steps, where the problem has them, are over (``after_transient``). For every
    load factor below ``load_factor`` all nodes stay closed, the motion is without jumps (and unique, but
    for a body that friction alone holds), and slip ceases. For a load domain this holds for every path
    inside it: then only the arguments count that ask for no order, Melan's theorem and least pressures,
    with the lift-off bound over the hull of the corners.

    The load factor is at most λ_1 and 0 where nothing is proved; the bound is infeasible where no slip is
    safe under the mean load.

    Attributes
    ----------
    node
        The node that limits the argument; −1 where none does.
    argument
        ``"Melan"``, ``"least pressures"``, ``"none"``; with one direction also ``"first collapse"`` (coupling
        ratio ρ* < 1), ``"two nodes"``, ``"differences"`` (no slip raises the differences between nodes); of a
        body that friction alone holds ``"least pressures, rigid motions apart"``.
    limited_by
        What the argument ends at: ``"first collapse"``, ``"swing"``, ``"lift-off"``, ``"drift"``,
        ``"uniqueness"``, ``"rates"`` (a floating body is not proved to slip without a jump), ``"mean load"``;
        ``"solver"`` where undecided. ``reason`` says the same in words.
    first_collapse
        λ_1, which is not exceeded; NaN with two tangential directions, where there is none.
    lift_off_bound
        Below this load factor no admissible slip lifts a node off; NaN where not needed.
    after_transient
        Whether the problem has transient load steps: then nothing is proved of a motion
        before they are over.
    pressures
        What least pressures prove, with the evidence to check it; None where not needed.
    """

    DOCUMENT: ClassVar[str] = "load_factor status node argument"

    node: int
    argument: str
    limited_by: str
    first_collapse: float
    lift_off_bound: float
    after_transient: bool
    pressures: LeastPressureBound | None = None

    def remark(self, bound: Bound) -> str:
        """What proves it, and what that means; else why nothing is proved."""
        if self.argument == "none":
            return bound.reason
        parts = self.argument.split(", ")
        return "; ".join(": ".join(filter(None, [part, ARGUMENTS.get(part)])) for part in parts)


def of_joint(limits: Any) -> Bound:
    """λ_U of a joint whose limits are computed (:data:`shakedown.bounds.registry.BOUNDS`)."""
    return universal_bound(limits.problem, first_collapse=present(limits.lower), tolerances=limits.tolerances)


@checked
def universal_bound(
    problem: Problem, *, first_collapse: Bound | None = None, tolerances: Tolerances = DEFAULT
) -> Bound:
    """The largest load factor λ_U up to which the joint is proved to shake down from every initial state.

    λ_U equals λ_1 if one of four arguments applies, all for one tangential direction: Melan's theorem
    (B = 0), a coupling ratio ρ* < 1, a gauge of differences, or two nodes (thesis §4.4). Otherwise it is
    what least pressures prove where motions are unique (docs/universal.md, section 3), with round-off
    accounted for. In every case the nodes must stay closed.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    first_collapse
        λ_1, where it has been computed already; there is none with two directions.
    tolerances
        What decides (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range.
    SolverError
        If λ_1 was not given, and a linear program of it ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> bound = universal_bound(shakedown.example("three-node"))
    >>> round(bound.load_factor, 6), bound.node, bound.argument
    (0.3096, 0, 'least pressures')
    """
    kind = getattr(first_collapse, "kind", type(first_collapse).__name__)
    if first_collapse is not None and kind != "lower":
        raise UsageError(f"first_collapse: expected a bound of the kind 'lower', found {kind!r}")
    parts = coupled_parts(problem)
    if len(parts) > 1:
        of_parts = [universal_bound(part.joint, tolerances=tolerances) for part in parts]
        return _of_parts(parts, of_parts, first_collapse)
    transient = problem.q_transient is not None
    nothing = Bound(
        "universal", Status.OPTIMAL, 0.0, EveryState(-1, "none", "uniqueness", nan, nan, transient)
    )
    if problem.directions == 2:
        unique = unique_rates(least_pressures.scaled_joint(problem))
        return _by_least_pressures(problem, nothing, None, unique, tolerances)
    lower = lower_bound(problem, tolerances=tolerances) if first_collapse is None else first_collapse
    nothing = nothing.but(first_collapse=lower.load_factor)
    if lower.status == Status.INFEASIBLE:
        return _unsafe(nothing)
    if lower.load_factor == 0.0:
        reason = f"some locked-in slip lifts node {lower.node} off, under the mean load alone"
        if problem.f[lower.node] == 0:
            reason = lower.reason
        return nothing.but(node=lower.node, limited_by="first collapse", reason=reason)
    if lower.known.argument is None:
        return _by_least_pressures(problem, nothing, lower, lower.known.unique, tolerances)
    return _by_first_collapse(nothing, lower, lower.known.argument)


def _of_parts(parts: tuple[Part, ...], found: list[Bound], first_collapse: Bound | None) -> Bound:
    """The bound of a joint in uncoupled parts, not above its first collapse."""
    least = weakest(found)
    part, bound = parts[least], found[least]
    lower = float(np.min([each.first_collapse for each in found]))
    if first_collapse is not None:
        lower = first_collapse.load_factor
    return bound.but(
        load_factor=min(bound.load_factor, inf if isnan(lower) else lower),
        node=part.number(bound.node),
        reason=part.renumbered(bound.reason),
        first_collapse=lower,
        lift_off_bound=float(np.fmin.reduce([each.lift_off_bound for each in found])),
        pressures=None,
        parts=tuple(found),
    )


def _by_first_collapse(nothing: Bound, lower: Bound, argument: Argument) -> Bound:
    """The answer where an argument reaches λ_1, as far as nodes stay closed and no body drifts."""
    lift = inf if argument.keeps_closed else lower.known.lift_off
    if isinstance(lift, Missing):
        return _undecided(nothing, f"the lift-off bound is missing: {lift.reason}")
    found = _collapsing(nothing.but(argument=argument.name), lower)
    if argument.drift_bound < lower.load_factor:
        reason = f"{argument.name}: from there on the body, which friction alone holds, may drift"
        found = found.but(load_factor=argument.drift_bound, limited_by="drift", reason=reason)
    return _limited(found, lower, lift)


def _by_least_pressures(
    problem: Problem,
    nothing: Bound,
    lower: Bound | None,
    unique: Uniqueness | Missing,
    tolerances: Tolerances,
) -> Bound:
    """The answer where least pressures are the best argument; with two directions there is no λ_1."""
    found = attempt(least_pressure_bound, problem, unique=bool(unique))
    if isinstance(found, Missing):
        return _undecided(nothing, f"the least pressures are missing: {found.reason}")
    nothing = nothing.but(lift_off_bound=found.lift_off_bound, pressures=found)
    jumps = not (unique or found.floats)
    if lower is None and (jumps or found.load_factor == 0.0):
        safe = attempt(safe_under_mean_load, problem, tolerances)
        if isinstance(safe, Missing):
            return _undecided(nothing, f"safe under the mean load? {safe.reason}")
        if not safe:
            return _unsafe(nothing)
    if found.load_factor == 0.0 and (found.node >= 0 or found.floats):
        return nothing.but(node=found.node, limited_by=found.limited_by, reason=found.reason)
    if jumps:
        why = unique.reason if isinstance(unique, Missing) else unique.argument
        return nothing.but(reason=f"the motion is not proved to be unique: {why}")
    argument = "least pressures" if problem.law.limit_rows(problem.B).any() else "Melan"
    proved = nothing.but(
        load_factor=found.load_factor,
        node=found.node,
        argument=argument + ", rigid motions apart" * found.floats,
        limited_by=found.limited_by,
        reason=f"{argument}: {found.reason}",
    )
    return _limited(proved, lower, found.lift_off_bound)


def _limited(found: Bound, lower: Bound | None, lift: float) -> Bound:
    """What is proved, no further than the first collapse, where there is one, and lift-off."""
    found = found.but(lift_off_bound=lift)
    if lower is not None and lower.load_factor < found.load_factor:
        found = _collapsing(found, lower)
    if lift < found.load_factor:
        reason = f"{found.argument}: from {lift:.6g} on locked-in slip can lift a node off"
        found = found.but(load_factor=lift, node=-1, limited_by="lift-off", reason=reason)
    return found.but(status=Status.OPTIMAL if found.load_factor < inf else Status.UNBOUNDED)


def _collapsing(found: Bound, lower: Bound) -> Bound:
    reason = f"{found.argument}: node {lower.node} collapses there"
    limit = {"load_factor": lower.load_factor, "node": lower.node}
    return found.but(**limit, limited_by="first collapse", reason=reason)


def _unsafe(nothing: Bound) -> Bound:
    """The result where no slip is safe under the mean load."""
    reason = "no slip is safe under the mean load"
    return nothing.but(status=Status.INFEASIBLE, load_factor=nan, limited_by="mean load", reason=reason)


def _undecided(nothing: Bound, reason: str) -> Bound:
    """The result where a program on which it rests did not finish."""
    return nothing.but(status=Status.UNDECIDED, load_factor=nan, limited_by="solver", reason=reason)
