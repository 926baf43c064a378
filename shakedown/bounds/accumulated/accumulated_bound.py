"""The load factor up to which a joint is proved to shake down from a state, by its accumulated slip."""

from dataclasses import dataclass, field, replace
from math import inf, nan
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.accumulated.arc_search import (
    ALL_AROUND,
    START,
    ArcLimits,
    ArcSearch,
    FoundArcs,
    farthest,
    search_about,
)
from shakedown.bounds.accumulated.lid_check import Start, confirmed
from shakedown.bounds.accumulated.slip_arcs import FINER, OWN, TOGETHER, NoLids, Numbers
from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO
from shakedown.ground.argument_kinds import written
from shakedown.ground.constants import FOUR_DIGITS, SEVEN_DIGITS, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.status import Status
from shakedown.joint.arguments import check_load_factor, checked, checked_initial_slip, real_array
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import rigid_slips, with_free_rigid_slips

ACCURACY = {1: SEVEN_DIGITS, 2: FOUR_DIGITS}  # relative, of the load factor, by the number of directions
PARTS = {1: (1,), 2: (1, FINER**2)}  # numbers of parts of a 96th of the circle, undivided at first
FIRST_STEP = 64.0  # times the accuracy: first step above what is proved already
BACK = (0.0, 1e-9, 1e-7, 1e-5)  # relative steps back from a load factor until its conditions are confirmed
UNLIMITED = "no load factor takes any node nearer to slipping"
FRICTIONLESS, ROUND_OFF_ALONE = "frictionless", "round-off"
REASONS = {
    FRICTIONLESS: "a node without friction slips under any load",
    START: "the first load step, or the mean load, leaves a node without pressure there",
    OWN: "slip of a node does not relieve its own limit",
    TOGETHER: "slips of the nodes may drive each other on",
    ALL_AROUND: "a node may slip in every direction",
    ROUND_OFF_ALONE: "round-off decides whether the conditions hold",
}


@dataclass(frozen=True, eq=False, repr=False)
class SlipArcs(Result):
    """Bounds on the slip of nodes by direction: the evidence of :func:`accumulated_bound`.

    Attributes
    ----------
    node : (K,)
        The node that may slip.
    first, last : (K, d)
        Unit vectors: the arc of directions in which it may; in the plane both are ±1.
    lid : (K,)
        a, how far with all others at rest [length].
    hindered : (K, K)
        N, how much farther by slip of the others [–].
    total : (K,)
        S ≥ a + N S, how far in all [length].
    """

    node: Numbers
    first: FloatArray
    last: FloatArray
    lid: FloatArray
    hindered: FloatArray
    total: FloatArray


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

    @property
    def limited_because(self) -> str:
        """``limited_by`` in words; empty where nothing limits it."""
        return REASONS.get(self.limited_by, "")

    def document(self, bound: Bound) -> dict[str, Any]:
        """The bound as JSON knows it; of a certificate whether there is one."""
        return super().document(bound) | {"certified": bound.certified is not None}

    def remark(self, bound: Bound) -> str:
        """What ends the proof, and at which node."""
        at = f", at node {self.node}" if self.node >= 0 else ""
        return f"{self.limited_because}{at}" if self.limited_by else bound.reason


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

    Nodes reach limits in some directions only. Slip there relieves its own limit, and what slips of others
    take from it is bounded by how far these go: lids on all slips, s ≤ a + N s. Where the lids hold and
    leave all other limits alone, the joint shakes down in any order of the loads. The load factor is
    bisected; what is found is confirmed from the problem as it is stored, without round-off in the plane
    up to 40 nodes.

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
    start = _checked_start(problem, initial_slip, start_error)
    found, why = None, None
    for parts in PARTS[problem.directions]:
        if found is None or found.load_factor < inf:
            try:
                found, why = _farthest(_search(problem, start, parts), found)
            except NoLids as reason:  # narrower sectors may still prove something
                why = why or reason
    if found is None:
        assert why is not None
        return _nothing(start, why)
    return _confirmed(problem, start, found, why)


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
    start = _checked_start(problem, initial_slip, start_error)
    try:
        found = _search(problem, start, PARTS[problem.directions][-1]).closed(load_factor)
    except NoLids as reason:
        return _nothing(start, reason)
    return _confirmed(problem, start, found, None)


def _checked_start(problem: Problem, initial_slip: ArrayLike | None, start_error: ArrayLike) -> Start:
    slip, error = checked_initial_slip(problem, initial_slip), real_array("start error", start_error)
    if error.shape not in ((), (problem.n,)) or not np.all(error >= 0.0):
        expected = f"one number >= 0 or {problem.n} of them"
        raise UsageError(f"start error: expected {expected}, found {written(start_error)}")
    error = np.broadcast_to(error, problem.n).copy()
    checked_initial_slip(problem, error.repeat(problem.directions), "start error")
    return Start(slip, error)


def _search(problem: Problem, start: Start, parts: int) -> ArcSearch:
    if problem.law.smooth.size:
        raise NoLids(FRICTIONLESS, int(problem.law.smooth[0]))
    return search_about(ArcLimits(with_free_rigid_slips(problem), *start), parts)


def _farthest(search: ArcSearch, known: FoundArcs | None) -> tuple[FoundArcs, NoLids | None]:
    """The largest load factor, starting from one that wider sectors prove."""
    low = search.closed(0.0 if known is None else known.load_factor)
    accuracy, elastic = ACCURACY[search.cells.d], search.slacks.elastic
    if elastic == inf:
        return replace(low, load_factor=inf), None
    return farthest(low, max(elastic, (1.0 + FIRST_STEP * accuracy) * low.load_factor), accuracy)


def _confirmed(problem: Problem, start: Start, found: FoundArcs, why: NoLids | None) -> Bound:
    """The confirmed bound, at a load factor reduced as little as possible."""
    joint, doubt = with_free_rigid_slips(problem), rigid_slips(problem).doubt
    exact = problem.directions == 1 and problem.n <= LOWER_CERTIFIED_UP_TO and not doubt
    arcs, lids, total = found.arcs, found.lids, found.lids.total
    for back in BACK if why is not None else BACK[:1]:
        load_factor = (1.0 - back) * found.load_factor
        at = min(load_factor, 1.0)  # where conditions hold at every load factor
        if not exact or confirmed(joint, start, at, arcs, lids):
            evidence = TotalSlip(
                total_slip=np.bincount(arcs.node, total, minlength=problem.n).astype(float),
                limited_by="" if why is None else why.word,
                node=-1 if why is None else why.node,
                arcs=SlipArcs(arcs.node, arcs.first, arcs.last, lids.a, lids.N, total),
                initial_slip=start.slip,
                start_error=start.error,
            )
            return Bound(
                kind="accumulated",
                status=Status.OPTIMAL if load_factor < inf else Status.UNBOUNDED,
                load_factor=load_factor,
                evidence=evidence,
                reason="" if load_factor < inf else UNLIMITED,
                certified=load_factor if exact else None,
            )
    return replace(_nothing(start, NoLids(ROUND_OFF_ALONE, -1)), status=Status.UNDECIDED)


def _nothing(start: Start, why: NoLids) -> Bound:
    nowhere = np.full(len(start.error), nan)
    return Bound(
        kind="accumulated",
        status=Status.INFEASIBLE,
        load_factor=nan,
        evidence=TotalSlip(nowhere, why.word, why.node, None, start.slip, start.error),
        reason=REASONS[why.word],
    )
