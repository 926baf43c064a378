"""Upper bound of the load factor: the largest at which a safe slip exists."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from math import inf, nan
from typing import ClassVar, Literal

import numpy as np

from shakedown.bounds.best_zone import chosen_zone
from shakedown.bounds.certificate import (
    UPPER_CERTIFIED_UP_TO,
    Certificate,
    Disputed,
    certified_upper,
    significant,
)
from shakedown.bounds.discs.disc_limits import largest_load_factor, relieving
from shakedown.bounds.discs.disc_rows import DiscRows, disc_rows, zone_rows
from shakedown.bounds.least_slip import least_slip
from shakedown.bounds.row_programs import contradiction, load_factor_program
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked
from shakedown.joint.constraints import Constraints, constraints, rows_named
from shakedown.joint.contact_zone import Zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.margin import widest
from shakedown.programs.program import Solution
from shakedown.programs.solver import solve

UNSAFE_MEAN = "under the mean load alone no slip keeps every node within its friction limits"
NO_SAFE_STATE = "no slip keeps every node within its friction limits, even under the mean load alone"
SPACE_CERTIFIED_UP_TO = 1000  # nodes with two directions: as long as the bound itself
NOT_FOUND = (
    "no contact zone that was tried has a safe slip, and not all were: "
    "the nodes that stay open in the long run (simulate names them) may be given"
)
MOVED = "no slip is safe both under the transient load steps and in the loop, at any load factor"
ZERO_AMPLITUDE = "zero-amplitude loop: the loading does not change over the period, whatever the load factor"
RELIEVING = "the periodic part of the loading brings no node nearer to its limits at any load factor"
WEDGING = "wedging: slip along one direction raises the friction limits faster than any load factor needs"


@dataclass(frozen=True, eq=False, repr=False)
class UpperBound(Result):
    """Largest load factor at which a safe slip exists: λ_max of thesis (5.16).

    With all nodes in contact: above it no slip keeps every node closed and at rest
    through the period. With nodes of a zone open: above it there is no state at rest with
    exactly these nodes open throughout; other zones may do better.

    Attributes
    ----------
    status
        Optimal; infeasible (no safe slip at any load factor); unbounded (safe slips
        exist at arbitrarily large load factors); undecided where a search found no zone with a safe slip,
        and not all zones were tried.
    load_factor
        λ_max; NaN where infeasible, inf where unbounded.
    slip : (dn,)
        The safe slip at λ_max [length]; NaN unless optimal. Of a zone with open nodes the one in which
        the largest slip of a closed node is least.
    active
        (node, side) of the rows that determine it; with two directions (node, load step) of the limits,
        steps of a transient counted from −k to −1.
    multipliers : (r,)
        y ≥ 0 that prove the status, of the r rows of the constraints (with two directions, in their cones).
        Optimal: yᵀG = 0, yᵀd = 1, yᵀg = λ_max. Infeasible (Farkas): yᵀG = 0, yᵀd ≥ 0, yᵀg < 0.
        Zero where unbounded.
    direction : (dn,)
        Where unbounded: v with G v + d ≤ 0, along which every load factor stays
        safe [length]; else NaN.
    reason
        The status in words; empty where optimal.
    residual
        Largest relative violation of what the status claims: of the rows at
        ``slip`` or along ``direction``, or of the equalities of ``multipliers``.
    least_load_factor
        λ_lo, the smallest load factor ≥ 0 with a safe slip: safe slips exist from λ_lo
        to λ_max. It is 0 but where the constant part of the loading is not the mean
        and has no safe slip of its own; NaN where infeasible.
    certified
        (low, high) with the exact λ_max of the problem as stored between them: neighbouring floats, with
        two directions 1e-10 apart as a rule, relatively (docs/space.md, U1 and U2); (inf, inf) where it is
        proved unbounded, else None.
    exact
        Whether the status was checked in exact arithmetic, with two directions with every rounding bounded.
    uncertified
        Why there is no certificate although it was asked for; else empty.
    disputed
        Whether exact arithmetic on the stored digits contradicts the number by more than the data allow.
    missing
        Other evidence that a solver failed to give, and why: ``multipliers`` or ``direction``,
        ``least_load_factor``, which is NaN then.
    reduced_accuracy
        Whether the linear program ended only at loosened tolerances (1e-7).
    open_nodes
        The nodes that are open through the whole period; empty with all nodes in contact.
        The slip of an open node is its displacement under the mean load.
    pinned
        Where the joint can move as a whole: the nodes that slips are given relative to. Their own
        slips are 0, as safe slips are known only up to that motion; empty for a joint that is held.
    in_floats : (dn + 1,)
        Safe slip [length] and load factor as the linear program found them, before exact arithmetic moved
        their last digits: where searches that end at λ_max begin. NaN where it found none.
    """

    DOCUMENT: ClassVar[str] = (
        "status load_factor least_load_factor slip open_nodes direction active certified uncertified "
        "disputed missing exact reduced_accuracy reason residual pinned"
    )
    TABLE: ClassVar[str] = "slip"

    status: Status
    load_factor: float
    slip: FloatArray
    active: tuple[tuple[int, int], ...]
    multipliers: FloatArray
    direction: FloatArray
    reason: str
    residual: float
    least_load_factor: float
    certified: tuple[float, float] | None
    exact: bool
    uncertified: str = ""
    disputed: bool = False
    missing: tuple[str, ...] = ()
    reduced_accuracy: bool = False
    open_nodes: tuple[int, ...] = ()
    pinned: tuple[int, ...] = ()
    in_floats: FloatArray = field(default_factory=lambda: np.full(1, nan), repr=False)


@checked
def upper_bound(
    problem: Problem,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    transient: bool = False,
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> UpperBound:
    """The largest load factor at which a safe slip exists (thesis (5.16), on the 2n extremal rows).

    Parameters
    ----------
    problem
        The contact and its loading loop.
    open_nodes
        The nodes that stay open through the whole period, all others closed: the rows are
        those of the condensed joint, and each open node adds its gap. ``"auto"`` searches
        the zone with the largest λ_max, from the nodes that the mean load opens.
    transient
        Whether the slip has to be safe under the transient load steps too, which the load factor
        does not scale: then nothing moves it although they are still to come. Only with all
        nodes in contact.
    certify
        Whether to re-solve the active rows in exact arithmetic and, where they are
        not exactly the best, to go on from them; by default up to 250 nodes, where it
        takes about a second. With two directions: whether to prove an enclosure, by default up to
        1000 nodes. Only with all nodes in contact, and without a transient.
    tolerances
        The tolerances that decide.

    Raises
    ------
    SolverError
        If the linear program ends without an answer.
    UsageError
        If there is no such node, no node stays closed, nothing holds the open ones, or nodes
        are open before the transient.
    ProblemError
        If nodes are open and the problem has no C.

    Examples
    --------
    >>> import shakedown
    >>> upper = shakedown.upper_bound(shakedown.example("two-node"))
    >>> upper.status.value, round(upper.load_factor, 6), upper.slip.round(5)
    ('optimal', 0.739146, array([-0.15635,  1.28773]))
    >>> low, high = upper.certified
    >>> low <= upper.load_factor <= high, high - low < 1e-15
    (True, True)
    """
    zone, others_left = chosen_zone(problem, open_nodes, tolerances)
    found = _of_zone(zone, transient, certify, tolerances)
    if others_left and found.status == Status.INFEASIBLE:
        return replace(found, status=Status.UNDECIDED, reason=NOT_FOUND, active=(), exact=False)
    return found


def _of_zone(zone: Zone, transient: bool, certify: bool | None, tolerances: Tolerances) -> UpperBound:
    """The bound of one zone."""
    problem = zone.problem
    if problem.directions > 1:
        return _in_space(zone, transient, certify, tolerances)
    rows = zone.rows(transient)
    if zone.open_nodes:
        return _in_zone(zone, _solved(problem, rows, False, tolerances), tolerances)
    if rows is not constraints(problem):
        found = _solved(problem, rows, False, tolerances)
        return replace(found, reason=MOVED) if found.status == Status.INFEASIBLE else found
    certify = problem.n <= UPPER_CERTIFIED_UP_TO if certify is None else certify
    return _solved(problem, rows, certify, tolerances)


def _in_space(zone: Zone, transient: bool, certify: bool | None, tolerances: Tolerances) -> UpperBound:
    """The bound over the discs of all closed nodes."""
    if transient:
        zone.check_transient()
    problem, rows = zone.problem, zone_rows(zone, transient)
    plain = not zone.open_nodes and len(rows.c) == len(disc_rows(problem).c)
    certify = (problem.n <= SPACE_CERTIFIED_UP_TO if certify is None else certify) and plain
    balanced = plain and problem.q_mean is None and problem.p_mean is None
    found = largest_load_factor(rows, problem if certify else None, balanced, tolerances)
    slips, optimal = rows.half_spaces.slips(found.x), found.status == Status.OPTIMAL
    nowhere = np.full(len(slips), nan)
    direction = slips if found.status == Status.UNBOUNDED else nowhere
    bound = UpperBound(
        status=found.status,
        load_factor=found.load_factor,
        slip=slips if optimal else nowhere,
        active=rows.named(*found.carrying),
        multipliers=found.multipliers,
        direction=direction,
        reason=_reason(found.status, rows, transient),
        residual=found.residual,
        least_load_factor=found.least_load_factor,
        certified=found.certified,
        exact=found.exact,
        uncertified=found.uncertified,
        missing=found.missing,
        reduced_accuracy=found.reduced_accuracy,
        pinned=rows.half_spaces.pinned,
        in_floats=np.append(slips, found.load_factor) if optimal else np.full(len(slips) + 1, nan),
    )
    return _in_zone(zone, bound, tolerances) if zone.open_nodes else bound


def _reason(status: Status, rows: DiscRows, transient: bool) -> str:
    if status == Status.INFEASIBLE:
        return MOVED if transient else NO_SAFE_STATE
    if status == Status.OPTIMAL:
        return ""
    if not relieving(rows):
        return WEDGING
    return RELIEVING if rows.e.any() or rows.half_spaces.d.any() else ZERO_AMPLITUDE


def _in_zone(zone: Zone, found: UpperBound, tolerances: Tolerances) -> UpperBound:
    """A bound on the closed nodes in terms of all nodes, with the least of its safe slips."""
    slip, residual, rows = found.slip, found.residual, zone.constraints
    if found.status == Status.OPTIMAL:
        slip = least_slip(rows, zone.problem.directions, found.load_factor, slip, tolerances)
        residual = float(rows.relative_excess(slip, found.load_factor).max())
    return replace(
        found,
        slip=zone.slips(slip),
        residual=residual,
        direction=zone.spread(found.direction),
        open_nodes=zone.open_nodes,
        pinned=zone.pinned,
        in_floats=np.append(zone.slips(found.in_floats[:-1]), found.in_floats[-1]),
    )


def _solved(problem: Problem, rows: Constraints, certify: bool, tolerances: Tolerances) -> UpperBound:
    outcome = solve(load_factor_program(rows, towards=-1.0, tolerances=tolerances))
    found: Certificate | Missing = Missing("")
    if certify:
        found = sought(certified_upper, problem, outcome, tolerances)
    certificate = found if isinstance(found, Certificate) else None
    status = outcome.status if certificate is None else certificate.status
    answer = {Status.OPTIMAL: _optimal, Status.INFEASIBLE: _infeasible, Status.UNBOUNDED: _unbounded}[status]
    return replace(
        answer(rows, outcome, certificate, tolerances),
        uncertified=found.reason if isinstance(found, Missing) else "",
        disputed=isinstance(found, Disputed),
        reduced_accuracy=outcome.reduced_accuracy,
        pinned=rows.pinned,
        in_floats=_in_floats(rows, outcome),
    )


def _in_floats(rows: Constraints, outcome: Solution) -> FloatArray:
    """The slip and the load factor that a program found, (n + 1,); NaN where it found none."""
    if not outcome.optimal:
        return np.full(rows.n + 1, nan)
    return np.append(rows.slips(outcome.x[:-1]), outcome.x[-1])


def _optimal(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> UpperBound:
    if certificate is not None:
        load_factor, y = certificate.load_factor, certificate.multipliers
        slip = significant(rows, certificate.slip, load_factor, tolerances)[:-1]
        active, certified = np.array(certificate.rows, dtype=np.intp), (certificate.low, certificate.high)
    else:
        slip, load_factor = _in_floats(rows, outcome)[:-1], float(outcome.x[-1])
        y, active, certified = outcome.multipliers, outcome.meeting[0], None
    least, missing = _least(rows, tolerances)
    return UpperBound(
        status=Status.OPTIMAL,
        load_factor=load_factor,
        slip=slip,
        active=rows_named(rows, active),
        multipliers=y,
        direction=np.full(rows.n, nan),
        reason="",
        residual=float(rows.relative_excess(slip, load_factor).max()),
        least_load_factor=least,
        certified=certified,
        exact=certificate is not None,
        missing=missing,
    )


def _least(rows: Constraints, tolerances: Tolerances) -> tuple[float, tuple[str, ...]]:
    """λ_lo; NaN where its program fails, and that it did."""
    found = sought(least_load_factor, rows, tolerances)
    return (nan, (f"λ_lo: {found.reason}",)) if isinstance(found, Missing) else (found, ())


def least_load_factor(rows: Constraints, tolerances: Tolerances) -> float:
    """λ_lo ≥ 0, from where on there are safe slips; NaN where there are none."""
    if np.all(rows.d >= 0) or np.all(
        rows.g >= 0
    ):  # what is safe is so at every smaller load factor; v = 0 is
        return 0.0
    least = solve(load_factor_program(rows, towards=+1.0, tolerances=tolerances))
    if not least.optimal:
        return nan
    at_mean = rows.relative_excess(rows.slips(least.x[:-1]), 0.0).max()
    return 0.0 if at_mean <= tolerances.feasibility else float(least.x[-1])


def _infeasible(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> UpperBound:
    y, missing = np.full(len(rows.g), nan), tuple[str, ...]()
    if certificate is not None:
        y = certificate.multipliers
    else:
        found = sought(contradiction, rows, tolerances)
        if isinstance(found, Missing):
            missing = (f"multipliers: {found.reason}",)
        else:
            y = found.multipliers
    terms = np.abs(y) @ np.abs(rows.G)
    return UpperBound(
        status=Status.INFEASIBLE,
        load_factor=nan,
        slip=np.full(rows.n, nan),
        active=rows_named(rows, np.flatnonzero(y != 0)) if not missing else (),
        multipliers=y,
        direction=np.full(rows.n, nan),
        reason=NO_SAFE_STATE,
        residual=float(np.max(np.abs(y @ rows.coefficients) / np.where(terms > 0, terms, 1.0))),
        least_load_factor=nan,
        certified=None,
        exact=certificate is not None,
        missing=missing,
    )


def _unbounded(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> UpperBound:
    least, missing = _least(rows, tolerances)
    if np.all(rows.d <= 0):
        direction, reason = np.zeros(rows.n), ZERO_AMPLITUDE if not np.any(rows.d) else RELIEVING
    else:
        found, reason = sought(_widest_direction, rows, certificate, tolerances), WEDGING
        if isinstance(found, Missing):
            direction, missing = np.full(rows.n, nan), (*missing, f"direction: {found.reason}")
        else:
            direction = found
    terms = np.maximum(np.max(np.abs(rows.G * direction), axis=1), np.abs(rows.d))
    excess = (rows.G @ direction + rows.d) / np.where(terms > 0, terms, 1.0)
    return UpperBound(
        status=Status.UNBOUNDED,
        load_factor=inf,
        slip=np.full(rows.n, nan),
        active=(),
        multipliers=np.zeros(len(rows.g)),
        direction=direction,
        reason=reason,
        residual=float(excess.max()),
        least_load_factor=least,
        missing=missing,
        certified=None if certificate is None else (inf, inf),
        exact=certificate is not None,
    )


def _widest_direction(
    rows: Constraints, certificate: Certificate | None, tolerances: Tolerances
) -> FloatArray:
    """v with G v + d ≤ 0, with room to spare where there is any."""
    norms = np.linalg.norm(rows.G, axis=1)
    cap = float(np.max(np.abs(rows.d)[norms > 0] / norms[norms > 0], initial=0.0))
    found = widest(rows.coefficients, norms, -rows.d, cap=cap, tolerances=tolerances)
    return rows.slips(found.x) if found.margin >= 0 or certificate is None else certificate.slip
