"""The load factor up to which a joint is proved to shake down from a given state."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from math import inf, isfinite, nan, nextafter
from numbers import Real
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.best_zone import chosen_zone
from shakedown.bounds.energy.ball_limits import DiscLimits, disc_limits
from shakedown.bounds.energy.best_bound import BestBound, best_bound
from shakedown.bounds.energy.centre_and_shares import room_about
from shakedown.bounds.energy.closed_ball import closed_radius, holds_without_load
from shakedown.bounds.energy.cone_rows import ConeRows, cone_rows
from shakedown.bounds.energy.energy_metric import EnergyMetric
from shakedown.bounds.energy.energy_rows import EnergyRows, check_resolved, without_margin
from shakedown.bounds.energy.exact_check import ExactBall
from shakedown.bounds.energy.exact_discs import ExactDiscs
from shakedown.bounds.energy.farthest import Farthest, contradiction, end_of, widest_room
from shakedown.bounds.energy.reasons import NO_ROOM, TOO_FAR, UNLIMITED
from shakedown.bounds.energy.zone_rows import zone_rows
from shakedown.ground.errors import UsageError
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, checked_initial_slip
from shakedown.joint.contact_zone import Zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

CERTIFIED_UP_TO = 40
NOT_REGULAR = "to the last stored digit A is not positive semi-definite, or B reaches outside its range"
NOT_CLEARLY = "as stored A without the pinned slips is not clearly positive definite"
NOWHERE_STRICT = "near the optimum no slip and radius satisfy all conditions strictly"


@dataclass(frozen=True, eq=False, repr=False)
class EnergyCertificate(Result):
    """Numbers that satisfy the conditions of the energy bound exactly, and strictly.

    Attributes
    ----------
    load_factor
        A load factor at which shakedown is proved without any round-off.
    slip : (n,)
        The centre of the ball [length].
    radius
        A radius that reaches the initial state and the distance around it [√(force · length)].
    """

    load_factor: float
    slip: FloatArray
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class EnergyBound(Result):
    """λ_E, the load factor below which every motion from around an initial slip is proved to shake down.

    At every load factor strictly between ``least_load_factor`` and ``load_factor`` a
    motion that begins with all nodes closed, at a slip within the energy distance
    ``distance`` of ``initial_slip``, comes to rest after a finite total slip, and no
    node ever opens. With open nodes it is said of a motion that begins with exactly these
    open, in equilibrium, and all others closed: it stays so. From all nodes closed at the
    same slips another state may be reached.

    Attributes
    ----------
    status
        ``"optimal"``; ``"infeasible"`` (nothing is proved at any load factor);
        ``"unbounded"`` (proved at every load factor from the least on); ``"undecided"``
        (no solver came to an end that the rows confirm: nothing is reported).
    load_factor
        λ_E; NaN where infeasible, inf where unbounded.
    least_load_factor
        The smallest load factor ≥ 0 at which it is proved: 0 but where the constant part
        of the loading is not the mean and too little alone; NaN where infeasible.
    slip : (n,)
        v*, the safe slip in the middle of the ball at λ_E [length]; NaN unless optimal.
    radius
        Radius of that ball, ‖v₀ − v*‖ + distance [√(force · length)]; NaN unless optimal.
    initial_slip : (n,)
        v₀ [length]; of an open node its displacement under the mean load.
    distance
        δ, the energy distance asked for [√(force · length)].
    active
        (node, side) of the rows that limit λ_E; where infeasible those that contradict each other. With two
        directions (node, load step).
    residual
        Largest violation of a row at (slip, radius, λ_E), relative to its terms; where
        infeasible, by how much the multipliers fail to prove it.
    gap
        Load factor that the multipliers prove not to be exceeded, relative to λ_E, less 1.
    certificate
        What exact arithmetic confirms (up to 40 nodes, all closed, A exactly positive
        semi-definite), else None.
    uncertified
        Why there is no certificate although it was asked for; else empty.
    reason
        The status in words; empty where optimal.
    open_nodes
        The nodes that stay open.
    pinned
        Where the joint can move as a whole: the nodes that ``slip`` is given relative to. The energy
        distance takes no account of that motion.
    multipliers : (k,)
        μ ≥ 0 that prove λ_E, dᵀμ = 1, of the rows of the closed nodes and then of the gaps, each kind
        with its transient after it; zero or empty unless optimal. With two directions one number for each
        of ``active``, that of its radius f p: at a reaction q* that of a q is −q*/|q*| times as large.
    share : (n, 2)
        With two directions what part c of the change of its own tangential reaction is counted as the
        change of the pressure of every closed node (docs/energy.md, section 8) [1]; else empty.
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor least_load_factor slip radius distance status reason certified uncertified residual "
        "initial_slip open_nodes active gap pinned"
    )
    TABLE: ClassVar[str] = "initial_slip slip"

    status: Status
    load_factor: float
    least_load_factor: float
    slip: FloatArray
    radius: float
    initial_slip: FloatArray
    distance: float
    active: tuple[tuple[int, int], ...]
    residual: float
    gap: float
    certificate: EnergyCertificate | None
    reason: str
    open_nodes: tuple[int, ...] = ()
    uncertified: str = ""
    pinned: tuple[int, ...] = ()
    multipliers: FloatArray = field(default_factory=lambda: np.zeros(0), repr=False)
    share: FloatArray = field(default_factory=lambda: np.zeros((0, 2)), repr=False)

    @property
    def certified(self) -> float | None:
        """The load factor that exact arithmetic confirms, or None."""
        return None if self.certificate is None else self.certificate.load_factor


@checked
def energy_bound(
    problem: Problem,
    initial_slip: ArrayLike | None = None,
    distance: float = 0.0,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    split: bool = True,
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> EnergyBound:
    """The load factor λ_E(v₀, δ) up to which shakedown from an initial slip is proved.

    Maximise λ subject to f p ∓ q ≥ f_i γ_i R for every node, side and load step at the
    slip v*, and ‖v₀ − v*‖_A + δ ≤ R: one second-order cone program in (v*, R, λ). With two tangential
    directions a_i |q| + f_i γ_i R ≤ f p at every load step (docs/energy.md, section 8).

    Parameters
    ----------
    problem
        The joint and its loading; transient load steps are those after ``initial_slip``.
    initial_slip : (n,), optional
        v₀ [length]; zero by default, a joint assembled without locked-in slip.
    distance
        δ ≥ 0, how far the state may be from v₀ in the energy norm [√(force · length)].
    open_nodes
        Nodes that are open from the start through every period, all others closed;
        ``"auto"`` for those of the best zone found (:func:`upper_bound`). What is given
        as their initial slip is ignored.
    split
        With two directions, whether the part c_i of a pressure that the node's own reaction determines is
        taken out of γ_i, in a few rounds; else c = 0. In the plane it always is. Only
        where no node can open inside the ball, come what may (docs/energy.md, section 8, Jumps); else c = 0.
    certify
        Whether to find a load factor that satisfies the conditions in exact arithmetic;
        by default up to 40 nodes; only with all nodes closed.
    tolerances
        What counts as zero and as feasible (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument has the wrong shape or is out of range.

    Examples
    --------
    >>> import shakedown
    >>> bound = shakedown.energy_bound(shakedown.example("two-node"))
    >>> round(bound.load_factor, 7), bound.slip.round(4), bound.certified <= bound.load_factor
    (0.6619611, array([0.0336, 1.3412]), True)
    """
    start, reach = checked_initial_slip(problem, initial_slip), _checked_distance(distance)
    zone, _ = chosen_zone(problem, open_nodes, tolerances)
    if problem.directions > 1:
        return _in_space(zone, start, reach, tolerances, split=split, certify=certify)
    rows, given = zone_rows(zone, tolerances=tolerances), start[list(zone.closed_nodes)]
    held = rows.rigid.relative(given)
    reason = without_margin(problem, rows)
    if reason:
        return _in_zone(zone, given, _nothing(rows, held, reach, reason))
    check_resolved(rows, held, reach, tolerances)
    found = sought(farthest_load_factor, rows, held, reach, tolerances)
    bound = _undecided(rows, held, reach, found) if isinstance(found, Missing) else found
    wanted = problem.n <= CERTIFIED_UP_TO if certify is None else certify
    if wanted and bound.status == Status.OPTIMAL and not zone.open_nodes:
        exact = ExactBall(problem, transient=True)
        proof = sought(_certificate, exact, rows, bound)
        if isinstance(proof, Missing):
            bound = replace(bound, uncertified=proof.reason)
        else:
            bound = replace(bound, certificate=proof)
    return _in_zone(zone, given, bound)


def _in_zone(zone: Zone, given: FloatArray, bound: EnergyBound) -> EnergyBound:
    """A bound for the closed nodes, from the slip that was given, in terms of all nodes."""
    bound = replace(bound, initial_slip=given, pinned=zone.pinned)
    if not zone.open_nodes:
        return bound
    return replace(
        bound, slip=zone.slips(bound.slip), initial_slip=zone.slips(given), open_nodes=zone.open_nodes
    )


def _in_space(
    zone: Zone, start: FloatArray, reach: float, tolerances: Tolerances, *, split: bool, certify: bool | None
) -> EnergyBound:
    """The bound of a joint with two tangential directions."""
    limits = disc_limits(zone, tolerances=tolerances)
    given = start[zone.problem.layout.slips_of(zone.closed_nodes)]
    relative = limits.rigid.relative(given)
    found = best_bound(zone.joint, limits, relative, reach, tolerances, split=split)
    if found.share.any() and not _without_jumps_that_open(zone.joint, limits.metric, found):
        found = best_bound(zone.joint, limits, relative, reach, tolerances, split=False)
    bound = EnergyBound(
        status=found.status,
        load_factor=found.load_factor,
        least_load_factor=found.least_load_factor,
        slip=found.slip,
        radius=found.radius,
        initial_slip=given,
        distance=reach,
        active=found.active,
        residual=found.residual,
        gap=found.gap,
        certificate=None,
        reason=found.reason,
        multipliers=found.multipliers,
        share=found.share,
    )
    if zone.open_nodes:
        return _in_zone(zone, given, bound)
    if bound.status == Status.OPTIMAL and (zone.joint.n <= CERTIFIED_UP_TO if certify is None else certify):
        proof = sought(_space_certificate, zone.joint, limits.shared(bound.share), bound)
        if isinstance(proof, Missing):
            bound = replace(bound, uncertified=proof.reason)
        else:
            bound = replace(bound, certificate=proof)
    return replace(bound, pinned=limits.rigid.pinned)  # without the rows of all load steps at once


def _without_jumps_that_open(joint: Problem, metric: EnergyMetric, found: BestBound) -> bool:
    """Whether the proof with shares is complete: no node opens in a jump, at any load factor from 0 on."""
    if found.status != Status.OPTIMAL:
        return found.status != Status.UNBOUNDED
    between = (0.0, found.load_factor)
    return found.radius < closed_radius(joint, metric, found.slip, between) and (
        (joint.q_mean is None and joint.p_mean is None)
        or holds_without_load(joint, metric, found.share, found.slip, found.radius)
    )


def _space_certificate(
    problem: Problem, limits: DiscLimits, bound: EnergyBound
) -> EnergyCertificate | Missing:
    """As :func:`_certificate`, with two tangential directions."""
    exact = ExactDiscs(problem, bound.share)
    if not exact.regular:
        return Missing(limits.rigid.doubt or NOT_CLEARLY)
    start = limits.rigid.relative(bound.initial_slip)
    room = room_about(limits, start, bound.distance)
    for part in (10.0**digits for digits in range(-14, -2)):
        slip = (1 - part) * bound.slip + part * room.slip
        lower = (1 - part) * bound.load_factor + part * room.load_factor
        radius = nextafter(float(exact.radius_to(slip, start, bound.distance)), inf)
        if exact.holds(lower, slip, radius):
            return EnergyCertificate(lower, slip, radius)
    return Missing(NOWHERE_STRICT)


def farthest_load_factor(
    rows: EnergyRows, start: FloatArray, distance: float, tolerances: Tolerances = DEFAULT
) -> EnergyBound:
    """The energy bound of rows of whatever kind."""
    about = cone_rows(rows, start, distance)
    end = end_of(about, tolerances)
    if end.status == Status.INFEASIBLE:
        nothing = _nothing(rows, start, distance, TOO_FAR)
        return replace(
            nothing, active=rows.names(about.carrying(end.multipliers)), residual=contradiction(about, end)
        )
    if end.status == Status.UNBOUNDED and not widest_room(about).margin > tolerances.feasibility:
        return _nothing(rows, start, distance, TOO_FAR)  # a direction of growth, but nothing to start from
    least = _least_load_factor(about, tolerances)  # required: without it nobody knows where the proof begins
    if end.status == Status.UNBOUNDED:
        nothing = _nothing(rows, start, distance, UNLIMITED)
        return replace(nothing, status=Status.UNBOUNDED, load_factor=inf, least_load_factor=least)
    if _without_room(about, end, tolerances):
        return _nothing(rows, start, distance, NO_ROOM)
    return _optimal(rows, about, end, start, least)


def _checked_distance(distance: float) -> float:
    if not (isinstance(distance, Real) and isfinite(distance) and distance >= 0):
        raise UsageError(f"distance: expected a number >= 0, found {distance!r}")
    return float(distance)


def _least_load_factor(about: ConeRows, tolerances: Tolerances) -> float:
    if np.all(about.d[:-1] >= 0):  # what holds at one load factor holds at every smaller one
        return 0.0
    end = end_of(about.reversed(), tolerances)
    return abs(end.load_factor) if end.status == Status.OPTIMAL else nan


def _without_room(about: ConeRows, end: Farthest, tolerances: Tolerances) -> bool:
    """Whether some row has no margin at any slip: neither here nor at any smaller load factor."""
    reach = float(np.linalg.norm(end.y)) + about.offset
    margins = -about.excess(end.y, end.load_factor)[:-1]
    needs = reach * about.s[:-1] / np.where(about.sizes[:-1] > 0, about.sizes[:-1], 1.0)
    doubtful = (margins <= tolerances.feasibility) & (needs <= tolerances.feasibility) & (about.d[:-1] <= 0)
    return bool(doubtful.any()) and widest_room(about).margin <= tolerances.feasibility


def _optimal(
    rows: EnergyRows, about: ConeRows, end: Farthest, start: FloatArray, least: float
) -> EnergyBound:
    slip = start + rows.metric.inverse @ end.y * about.length
    relative = (float(np.linalg.norm(end.y)) + about.offset) * about.length
    load_factor, proved = max(end.load_factor, 0.0), about.proved(end.multipliers)
    excess = -rows.room(slip, load_factor, relative) / rows.sizes(slip, load_factor, relative)
    return EnergyBound(
        status=Status.OPTIMAL,
        load_factor=load_factor,
        least_load_factor=least,
        slip=slip,
        radius=relative * rows.metric.unit,
        initial_slip=start,
        distance=about.offset * about.length * rows.metric.unit,
        active=rows.names(about.carrying(end.multipliers)),
        residual=float(excess.max()),
        gap=proved / load_factor - 1.0 if load_factor > 0 else proved,
        certificate=None,
        reason="",
        multipliers=_of_rows(rows, end.multipliers[:-1]),
    )


def _of_rows(rows: EnergyRows, multipliers: FloatArray) -> FloatArray:
    """Multipliers of the dimensionless rows in the units of the rows; zero where λ = 0 decides."""
    pull = float(rows.d @ multipliers)
    return multipliers / pull if pull > 0 else np.zeros_like(multipliers)


def _certificate(exact: ExactBall, rows: EnergyRows, bound: EnergyBound) -> EnergyCertificate | Missing:
    """Move from the optimum towards the point with the largest margins until all conditions are strict."""
    if not exact.regular:
        return Missing(rows.rigid.doubt or NOT_REGULAR)
    about = cone_rows(rows, bound.initial_slip, bound.distance)
    room = widest_room(about)
    middle = bound.initial_slip + rows.metric.inverse @ room.y * about.length
    for part in (10.0**digits for digits in range(-14, -2)):
        slip = (1 - part) * bound.slip + part * middle
        lower = (1 - part) * bound.load_factor + part * room.load_factor
        radius = nextafter(float(exact.radius_to(slip, bound.initial_slip, bound.distance)), inf)
        if exact.holds(lower, slip, radius):
            return EnergyCertificate(lower, slip, radius)
    return Missing(NOWHERE_STRICT)


def _undecided(rows: EnergyRows, start: FloatArray, distance: float, why: Missing) -> EnergyBound:
    return replace(_nothing(rows, start, distance, why.reason), status=Status.UNDECIDED)


def _nothing(rows: EnergyRows, start: FloatArray, distance: float, reason: str) -> EnergyBound:
    return EnergyBound(
        status=Status.INFEASIBLE,
        load_factor=nan,
        least_load_factor=nan,
        slip=np.full(rows.n, nan),
        radius=nan,
        initial_slip=start,
        distance=distance,
        active=(),
        residual=nan,
        gap=nan,
        certificate=None,
        reason=reason,
    )
