"""The largest load factor up to which shakedown from every initial state is proved."""

from dataclasses import dataclass, replace
from math import inf, isnan, nan
from typing import Any, ClassVar, NamedTuple

import numpy as np

from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.collapse.lower import lower_bound
from shakedown.bounds.discs.safest_slip import safe_under_mean_load
from shakedown.bounds.every_state.bound_from_every_state import LeastPressureBound, least_pressure_bound
from shakedown.bounds.every_state.scaled_joint import scaled_joint
from shakedown.bounds.every_state.swing_bound import SwingBound, swing_bound
from shakedown.bounds.every_state.unique_rates import unique_rates
from shakedown.ground.errors import Missing, UsageError, present, sought
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked
from shakedown.joint.coupled_parts import Part, coupled_parts, weakest
from shakedown.joint.problem import Problem

ARGUMENTS = {  # what the names of the proofs stand for, where they are not self-explanatory
    "Melan": "slip changes no pressure",
    "differences": "no slip raises the differences between nodes",
    "swing": "a potential decreases with every slip",
    "least pressures": "friction under its least pressure holds each node, however the others slip",
    "rigid motions apart": "slip of a body as a whole is bounded separately",
}


@dataclass(frozen=True, eq=False, repr=False)
class EveryState(Evidence):
    """What only λ_U has, the largest load factor up to which shakedown from every initial state is proved.

    A state is one with all nodes closed that is admissible at some instant of the loop; transient
    load steps, where the problem has them, are over (``after_transient``). For every
    load factor below ``load_factor`` all nodes stay closed, the motion is without jumps (and unique, but
    for a body that friction alone holds), and slip ceases. Of a load domain this is said of every path
    inside it: then only the arguments count that ask for no order, Melan's theorem and the swing bound,
    with the lift-off bound over the hull of the corners, and least pressures.

    The load factor is at most λ_1 and 0 where nothing is proved; the bound is infeasible where no slip is
    safe under the mean load.

    Attributes
    ----------
    node
        The node that limits the argument; −1 where none does.
    argument
        ``"Melan"``, ``"first collapse"`` (coupling ratio ρ* < 1), ``"two nodes"``, ``"differences"`` (no
        slip raises the differences between nodes), ``"swing"`` or ``"none"``. With two tangential directions
        ``"Melan"``, ``"least pressures"``, ``"least pressures, N sectors"`` or ``"none"``; of a body that
        friction alone holds ``"least pressures, rigid motions apart"`` or ``"Melan, rigid motions apart"``.
    limited_by
        What the argument ends at: ``"first collapse"``, ``"swing"``, ``"lift-off"``, ``"drift"``,
        ``"uniqueness"``, ``"rates"`` (a floating body is not proved to slip without a jump), ``"mean load"``;
        ``"solver"`` where undecided. ``reason`` says the same in words.
    first_collapse
        λ_1, which is not exceeded; NaN with two tangential directions, where there is none.
    lift_off_bound
        Below this load factor no admissible slip lifts a node off; NaN where not needed.
    after_transient
        Whether the problem has transient load steps: then nothing is said of a motion
        before they are over.
    swing
        The swing bound, with the evidence to check it; None where not needed.
    pressures
        With two directions what least pressures prove, with the evidence to check it.
    """

    DOCUMENT: ClassVar[str] = "load_factor status node argument"

    node: int
    argument: str
    limited_by: str
    first_collapse: float
    lift_off_bound: float
    after_transient: bool
    swing: SwingBound | None = None
    pressures: LeastPressureBound | None = None

    def remark(self, bound: Bound) -> str:
        """What proves it, and what that means; else why nothing is proved."""
        if self.argument == "none":
            return bound.reason
        parts = self.argument.split(", ")
        return "; ".join(": ".join(filter(None, [part, ARGUMENTS.get(part)])) for part in parts)


def of_joint(limits: Any) -> Bound:
    """λ_U of a joint whose limits are computed (:data:`shakedown.bounds.registry.BOUNDS`)."""
    return universal_bound(
        limits.problem,
        first_collapse=present(limits.lower),
        certify=limits.certify,
        tolerances=limits.tolerances,
    )


class _Proved(NamedTuple):
    load_factor: float
    node: int
    argument: str
    limited_by: str


@checked
def universal_bound(
    problem: Problem,
    *,
    first_collapse: Bound | None = None,
    certify: bool | None = None,
    sectors: int | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Bound:
    """The largest load factor λ_U up to which the joint is proved to shake down from every initial state.

    Where an argument reaches λ_1 that is the answer: Melan's theorem (B = 0), a coupling ratio ρ* < 1, a
    gauge of differences, two nodes (thesis §4.4); else it is the swing bound. In every case the nodes
    must stay closed, and for the swing bound the motion must be unique. With two tangential directions it
    is what least pressures prove (docs/universal.md, statements 6.1 to 6.6), round-off included.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    first_collapse
        λ_1, where it has been computed already; there is none with two directions.
    certify
        Whether to prove the swing bound in exact arithmetic; by default where that is quick.
    sectors
        With two directions: how many sectors those of slip are divided into; 1 are discs. By default
        discs that lean, and as many sectors as raise the bound by 1 % or more.
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
    (0.3096, 0, 'swing')
    """
    if first_collapse is not None and getattr(first_collapse, "kind", None) != "lower":
        raise UsageError(
            f"first_collapse: expected a bound of the kind 'lower', found {type(first_collapse).__name__}"
        )
    if sectors is not None and problem.directions == 1:
        raise UsageError("sectors: expected none with one tangential direction, which has two signs")
    parts = coupled_parts(problem)
    if len(parts) > 1:
        of_parts = [
            universal_bound(part.joint, certify=certify, sectors=sectors, tolerances=tolerances)
            for part in parts
        ]
        return _of_parts(parts, of_parts, first_collapse)
    if problem.directions > 1:
        return _in_space(problem, sectors, tolerances)
    lower = lower_bound(problem, tolerances=tolerances) if first_collapse is None else first_collapse
    if lower.status == Status.INFEASIBLE:
        return _without(lower, nan, "mean load", "no slip is safe under the mean load")
    if lower.load_factor == 0.0:
        reason = f"some locked-in slip lifts node {lower.node} off, under the mean load alone"
        if problem.f[lower.node] == 0:
            reason = lower.reason
        return _without(lower, 0.0, "first collapse", reason)
    known = lower.known
    complete = known.argument
    if complete is None and not (unique := known.unique):
        floating = _in_floating_plane(problem, lower)
        if floating is not None:
            return floating
        why = unique.reason if isinstance(unique, Missing) else unique.argument
        return _without(lower, 0.0, "uniqueness", f"the motion is not proved to be unique: {why}")
    lift: float | Missing = inf
    if complete is None or not complete.keeps_closed:
        lift = known.lift_off
    if isinstance(lift, Missing):
        return _undecided(lower, f"the lift-off bound is missing: {lift.reason}")
    if complete is not None:
        found = _Proved(lower.load_factor, lower.node, complete.name, "first collapse")
        if complete.drift_bound < lower.load_factor:
            found = _Proved(complete.drift_bound, -1, complete.name, "drift")
        return _result(lower, found, lift)
    swing = sought(swing_bound, problem, certify=certify, tolerances=tolerances)
    if isinstance(swing, Missing):
        return _undecided(lower, f"the swing bound is missing: {swing.reason}")
    return _result(lower, _Proved(swing.load_factor, swing.node, "swing", "swing"), lift, swing)


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
        swing=None,
        pressures=None,
        parts=tuple(found),
    )


def _in_space(problem: Problem, sectors: int | None, tolerances: Tolerances) -> Bound:
    """The answer with two tangential directions."""
    sought_bound = sought(least_pressure_bound, problem, sectors=sectors)
    transient = problem.q_transient is not None
    if isinstance(sought_bound, Missing):
        reason = f"the least pressures are missing: {sought_bound.reason}"
        evidence = EveryState(-1, "none", "solver", nan, nan, transient)
        return Bound("universal", Status.UNDECIDED, nan, evidence, reason=reason)
    found = sought_bound

    def nothing(status: Status, load_factor: float, limited_by: str, reason: str) -> Bound:
        node = found.node if limited_by in ("lift-off", "swing") else -1
        lift_off = found.lift_off_bound
        evidence = EveryState(node, "none", limited_by, nan, lift_off, transient, pressures=found)
        return Bound("universal", status, load_factor, evidence, reason=reason)

    unique = unique_rates(scaled_joint(problem))
    if found.load_factor == 0.0 or not (unique or found.floats):
        safe = sought(safe_under_mean_load, problem, tolerances)
        if isinstance(safe, Missing):
            return nothing(Status.UNDECIDED, nan, "solver", f"safe under the mean load? {safe.reason}")
        if not safe:
            return nothing(Status.INFEASIBLE, nan, "mean load", "no slip is safe under the mean load")
    if found.load_factor == 0.0 and (found.node >= 0 or found.floats):
        return nothing(Status.OPTIMAL, 0.0, found.limited_by, found.reason)
    if not (unique or found.floats):
        why = f"the motion is not proved to be unique: {unique.argument}"
        return nothing(Status.OPTIMAL, 0.0, "uniqueness", why)
    return _by_pressures(problem, found, nan)


def _in_floating_plane(problem: Problem, lower: Bound) -> Bound | None:
    """What least pressures prove of a body in the plane that friction alone holds; None where nothing."""
    if not scaled_joint(problem).floats:
        return None
    found = sought(least_pressure_bound, problem)
    if isinstance(found, Missing) or found.load_factor == 0.0:
        return None
    bound = _by_pressures(problem, found, lower.load_factor)
    return replace(bound, load_factor=min(bound.load_factor, lower.load_factor))


def _by_pressures(problem: Problem, found: LeastPressureBound, first_collapse: float) -> Bound:
    """The answer where least pressures are the best argument."""
    argument = "least pressures" if problem.law.limit_rows(problem.B).any() else "Melan"
    more = ", rigid motions apart" if found.floats else f", {found.sectors} sectors" * (found.sectors > 1)
    evidence = EveryState(
        node=found.node,
        argument=argument + more,
        limited_by=found.limited_by,
        first_collapse=first_collapse,
        lift_off_bound=found.lift_off_bound,
        after_transient=problem.q_transient is not None,
        pressures=found,
    )
    reason = f"{argument}: {found.reason}"
    return Bound("universal", found.status, found.load_factor, evidence, reason=reason)


def _without(lower: Bound, load_factor: float, limited_by: str, reason: str) -> Bound:
    """The result where nothing is proved."""
    node = lower.node if limited_by == "first collapse" else -1
    transient = lower.problem.q_transient is not None
    status = Status.INFEASIBLE if lower.status == Status.INFEASIBLE else Status.OPTIMAL
    evidence = EveryState(node, "none", limited_by, lower.load_factor, nan, transient)
    return Bound("universal", status, load_factor, evidence, reason=reason)


def _undecided(lower: Bound, reason: str) -> Bound:
    """The result where a program on which it rests did not finish."""
    return replace(_without(lower, nan, "solver", reason), status=Status.UNDECIDED)


def _result(lower: Bound, found: _Proved, lift: float, swing: SwingBound | None = None) -> Bound:
    if min(lower.load_factor, lift) < found.load_factor:
        limit, node = ("lift-off", -1) if lift < lower.load_factor else ("first collapse", lower.node)
        found = _Proved(min(lower.load_factor, lift), node, found.argument, limit)
    evidence = EveryState(
        node=found.node,
        argument=found.argument,
        limited_by=found.limited_by,
        first_collapse=lower.load_factor,
        lift_off_bound=lift,
        after_transient=lower.problem.q_transient is not None,
        swing=swing,
    )
    status = Status.OPTIMAL if found.load_factor < inf else Status.UNBOUNDED
    return Bound("universal", status, found.load_factor, evidence, reason=_reason(found, lift))


def _reason(found: _Proved, lift: float) -> str:
    ends = {
        "first collapse": f"node {found.node} collapses there",
        "drift": "from there on the body, which friction alone holds, may drift",
        "lift-off": f"from {lift:.6g} on locked-in slip can lift a node off",
        "swing": f"from there on node {found.node} may slip forward and backward at the same reaction A v",
    }
    return f"{found.argument}: {ends[found.limited_by]}"
