"""The load factor up to which a joint is proved to shake down from a state, by its accumulated slip.

In the plane the conditions of the theorem are checked on the problem as it is stored, without round-off.
"""

from dataclasses import dataclass, field, replace
from math import inf, nan
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.arc_search import MARGIN, REASONS, SECTOR_PARTS, ArcSearch, NoSlipBound, SlipArcs
from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO, Exact, exact_numbers
from shakedown.ground.constants import FOUR_DIGITS, HALVINGS, ROUND_OFF, SEVEN_DIGITS, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import short
from shakedown.ground.status import Status
from shakedown.joint.arguments import check_load_factor, checked, checked_initial_slip, real_array
from shakedown.joint.constraints import loading, transient_path
from shakedown.joint.fields import LARGEST
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips, with_free_rigid_slips


def confirmed(
    problem: Problem, start: FloatArray, start_error: FloatArray, load_factor: float, arcs: SlipArcs
) -> bool:
    """Whether the theorem holds from a start at all load factors up to one, with these bounds of slips.

    In the plane only. Of the arcs all is checked, of the bounds a and N.
    """
    A, B, f, e = (exact_numbers(each) for each in (problem.A, problem.B, problem.f, np.array([1.0, -1.0])))
    a, N, total, x = (exact_numbers(each) for each in (arcs.alone, arcs.coupling, arcs.total, arcs.inverse))
    x, v, error, law = x.sum(axis=1), exact_numbers(start), exact_numbers(start_error), Law(f)
    q, p = problem.layout.split(_loads(problem, load_factor))
    # the load rises to the first one under these pressures
    first = p[: 1 if len(transient_path(problem)) else 2] + B @ v - np.abs(B) @ error
    ends = np.all(x > 0) and np.all(x - N @ x > 0) and np.all(total >= a + N @ total)  # ρ(N) < 1
    if not (ends and np.all(first > 0) and np.all(a >= 0) and np.all(N >= 0) and not np.diagonal(N).any()):
        return False
    fB = law.limit_rows(B)
    rows = fB + e[:, None, None] * A  # of the limits f p + e q in both directions e, (2, n, n)
    limit, shear, sizes = law.limit(p), e[:, None, None] * q, np.abs(fB) + np.abs(A)
    terms = np.max(np.abs(limit) + np.abs(q), axis=0) + sizes @ np.abs(v)
    slack = (limit + shear).min(axis=1) + rows @ v - np.abs(rows) @ error
    slack -= exact_numbers(np.array(MARGIN)) * terms
    sign = arcs.first[:, 0]
    slopes, arc = rows[:, :, arcs.node] * exact_numbers(sign), np.full((2, problem.n), -1)
    arc[(sign < 0).astype(int), arcs.node] = np.arange(len(sign))
    inside, mine, points = arc >= 0, arc[arc >= 0], np.arange(len(sign))
    # within their arcs nodes slip no farther than a + N s
    own = slopes[inside][points, mine]
    coupled = own[:, None] * N[mine] + slopes[inside] >= 0
    coupled[points, mine] = True
    if not (np.all(own > 0) and np.all(slack[inside] + own * a[mine] > 0) and coupled.all()):
        return False
    # outside all arcs they stay clear of their limits
    y = arcs.multipliers(slack[~inside].astype(float), slopes[~inside].astype(float))
    most = (y + sizes[None, :, arcs.node].repeat(2, axis=0)[~inside].astype(float)).max(axis=1, initial=0.0)
    Y = exact_numbers(y + 4.0 * ROUND_OFF * most[:, None] * arcs.inverse.sum(axis=0))
    return bool(np.all(Y - Y @ N + slopes[~inside] >= 0) and np.all(slack[~inside] - Y @ a > 0))


def _loads(problem: Problem, load_factor: float) -> Exact:
    """The transient load steps, the mean load, and the loop at a load factor from its first step on."""
    loop, joined = loading(problem), problem.layout.joined
    mean, periodic = exact_numbers(joined(loop.q0, loop.p0)), exact_numbers(joined(loop.q1, loop.p1))
    reached = mean + exact_numbers(np.array(load_factor)) * periodic
    return np.concatenate([exact_numbers(transient_path(problem)), mean[None], reached])


ACCURACY = {1: SEVEN_DIGITS, 2: FOUR_DIGITS}  # relative, of the load factor, by the number of directions
STEPS_BACK = (0.0, 1e-9, 1e-7, 1e-5)  # from a load factor until its conditions are confirmed, relative


@dataclass(frozen=True, eq=False, repr=False)
class TotalSlip(Evidence):
    """What only λ_S has, up to which motions are proved to shake down, and how far nodes slip in all.

    At this and every smaller load factor every motion that begins with all nodes closed, within
    ``start_error`` of ``initial_slip``, stays closed, whatever the order of the loads, and no node ever slips
    farther in all than its ``total_slip`` (docs/accumulated.md). It is infeasible where nothing is proved at
    any load factor, undecided where round-off decides. It is certified where its conditions are confirmed
    without any round-off (in the plane, up to 40 nodes, where no slip is so soft that it may be a rigid one).

    Attributes
    ----------
    total_slip : (n,)
        ∫|v̇_i| dt of every node until it rests for ever, at most [length]; NaN where infeasible.
    limited_by
        What ends the proof, or why there is none: ``"coupling"`` (slips of the nodes drive each other
        on), ``"own limit"`` (slip of a node does not relieve its own limit), ``"all directions"`` (a node may
        slip in every one), ``"start"`` (the first load takes the pressure from a node), ``"frictionless"``,
        ``"round-off"``; empty where unbounded.
    node
        The node at which it ends; −1 where that is no single one.
    arcs
        The directions in which nodes may slip, and how far; None where infeasible.
    initial_slip : (dn,)
        v₀ [length].
    start_error : (n,)
        How far every node may be from there [length].
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor status limited_by total_slip node certified reason initial_slip start_error"
    )
    TABLE: ClassVar[str] = "total_slip start_error"

    total_slip: FloatArray
    limited_by: str
    node: int
    arcs: SlipArcs | None = field(repr=False)
    initial_slip: FloatArray = field(repr=False)
    start_error: FloatArray = field(repr=False)

    def document(self, bound: Bound) -> dict[str, Any]:
        """The bound as JSON knows it; of a certificate whether there is one."""
        return super().document(bound) | {"certified": bound.certified is not None}

    def remark(self, bound: Bound) -> str:
        """What ends the proof, and at which node."""
        at = f", at node {self.node}" if self.node >= 0 else ""
        return f"{REASONS[self.limited_by]}{at}" if self.limited_by else bound.reason


def of_joint(limits: Any) -> Bound:
    """λ_S of a joint whose limits are computed (:data:`shakedown.bounds.registry.BOUNDS`)."""
    return accumulated_bound(limits.problem, limits.initial_slip)


def may_exceed(limits: Any, load_factor: float) -> bool:
    """Whether λ_S may be larger than a load factor, by its conditions there, which are quick to check."""
    found = total_slip_bound(limits.problem, load_factor, limits.initial_slip)
    return found.status == Status.OPTIMAL


@checked
def accumulated_bound(
    problem: Problem, initial_slip: ArrayLike | None = None, *, start_error: ArrayLike = 0.0
) -> Bound:
    """The load factor λ_S up to which the total slip from an initial slip is proved to be finite.

    Each node can reach its friction limit in some directions only. Its own slip there moves it away from the
    limit; slip of the other nodes may move it back, in proportion to how far they slip. So the total slips
    satisfy s ≤ a + N s, which bounds all of them if the spectral radius of N is below 1. If no node can
    then reach its limit in another direction, the joint shakes down in any order of the loads. The load
    factor is found by bisection and confirmed from the problem as stored, without round-off in the plane up
    to 40 nodes.

    Parameters
    ----------
    problem
        The joint and its loading, loop or domain; transient load steps are those after ``initial_slip``.
    initial_slip : (dn,), optional
        v₀ [length]; zero by default, a joint assembled without locked-in slip.
    start_error : () or (n,)
        How far every node may be from there [length].

    Raises
    ------
    UsageError
        If an argument has the wrong shape or is negative.

    Examples
    --------
    >>> import shakedown
    >>> bound = shakedown.accumulated_bound(shakedown.example("three-node"))
    >>> round(bound.load_factor, 6), bound.limited_by, bound.total_slip.round(3)
    (1.8, 'coupling', array([1.01 , 0.48 , 0.606]))
    """
    start, error = _checked_start(problem, initial_slip, start_error)
    load_factor, arcs, why = 0.0, None, None
    for parts in SECTOR_PARTS[problem.directions]:
        if load_factor < inf:
            try:
                load_factor, arcs, why = _bisected(ArcSearch.of(problem, start, error, parts), load_factor)
            except NoSlipBound as reason:  # narrower sectors may still prove something
                why = why or reason
    return _confirmed(problem, start, error, load_factor, arcs, why)


@checked
def total_slip_bound(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    *,
    start_error: ArrayLike = 0.0,
) -> Bound:
    """Bounds on the total slip of nodes at one load factor and below, from an initial slip.

    Parameters
    ----------
    problem, initial_slip, start_error
        As for :func:`accumulated_bound`.
    load_factor
        λ ≥ 0, that of the result; infeasible where nothing is proved there.

    Raises
    ------
    UsageError
        If an argument has the wrong shape or is negative.

    Examples
    --------
    >>> import shakedown
    >>> total_slip_bound(shakedown.example("two-node"), 0.7).total_slip.round(3)
    array([0.   , 1.251])
    """
    check_load_factor(load_factor, problem)
    start, error = _checked_start(problem, initial_slip, start_error)
    try:
        parts = SECTOR_PARTS[problem.directions][-1]
        _, arcs = ArcSearch.of(problem, start, error, parts).closed(load_factor)
    except NoSlipBound as reason:
        return _no_bound(start, error, reason)
    return _confirmed(problem, start, error, load_factor, arcs, None)


def _checked_start(
    problem: Problem, initial_slip: ArrayLike | None, start_error: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    slip, error = checked_initial_slip(problem, initial_slip), real_array("start error", start_error)
    if error.shape not in ((), (problem.n,)) or not np.all(error >= 0.0):
        expected = f"one number >= 0 or {problem.n} of them"
        raise UsageError(f"start error: expected {expected}, found {short(start_error)}")
    error = np.broadcast_to(error, problem.n).copy()
    checked_initial_slip(problem, error.repeat(problem.directions), "start error")
    return slip, error


def _bisected(search: ArcSearch, proved: float) -> tuple[float, SlipArcs, NoSlipBound | None]:
    """The largest load factor, from one that is proved, with the arcs there, and why it is no larger.

    Conditions at a load factor cover all smaller ones, and how they fail shows the later the larger it is:
    where they have failed once the distance from what is proved is doubled again, from a small one on.
    """
    search, arcs = search.closed(proved)
    accuracy, elastic = ACCURACY[search.cells.d], search.slacks.elastic
    if elastic == inf:
        return inf, arcs, None
    # first step above what is proved already, in accuracies
    low, high, at, why = proved, inf, max(elastic, (1.0 + 64.0 * accuracy) * proved), None
    step = at - low  # kept apart: a small one doubled again would double the round-off of the load factors
    for _ in range(2 * HALVINGS):
        if high - low <= accuracy * high < inf or at > LARGEST:
            break
        try:
            search, arcs = search.closed(at)
            low, at, step = at, at + min(step, 0.5 * (high - at)), 2.0 * step
        except NoSlipBound as reason:
            proved = low if high == inf else proved
            high, step, why = at, 0.5 * (at - low), reason
            while low == proved and step > 64.0 * accuracy * high:
                step *= 0.5
            at = low + step
    return low, arcs, why


def _confirmed(
    problem: Problem,
    start: FloatArray,
    start_error: FloatArray,
    found: float,
    arcs: SlipArcs | None,
    why: NoSlipBound | None,
) -> Bound:
    """The confirmed bound, at a load factor reduced as little as possible."""
    if arcs is None:
        assert why is not None
        return _no_bound(start, start_error, why)
    joint, doubt = with_free_rigid_slips(problem), rigid_slips(problem).doubt
    exact = problem.directions == 1 and problem.n <= LOWER_CERTIFIED_UP_TO and not doubt
    for back in STEPS_BACK if why is not None else STEPS_BACK[:1]:
        load_factor = (1.0 - back) * found
        at = min(load_factor, 1.0)  # where conditions hold at every load factor
        if not exact or confirmed(joint, start, start_error, at, arcs):
            total = np.bincount(arcs.node, arcs.total, minlength=problem.n).astype(float)
            word, node = ("", -1) if why is None else (why.word, why.node)
            return Bound(
                kind="accumulated",
                status=Status.OPTIMAL if load_factor < inf else Status.UNBOUNDED,
                load_factor=load_factor,
                evidence=TotalSlip(total, word, node, arcs, start, start_error),
                reason="" if load_factor < inf else "no load factor takes any node nearer to slipping",
                certified=load_factor if exact else None,
            )
    return replace(_no_bound(start, start_error, NoSlipBound("round-off", -1)), status=Status.UNDECIDED)


def _no_bound(start: FloatArray, start_error: FloatArray, why: NoSlipBound) -> Bound:
    return Bound(
        kind="accumulated",
        status=Status.INFEASIBLE,
        load_factor=nan,
        evidence=TotalSlip(np.full(len(start_error), nan), why.word, why.node, None, start, start_error),
        reason=REASONS[why.word],
    )
