"""Upper bound of the load factor: the largest at which a safe slip exists."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np

from shakedown.bounds.certificate import Certificate, certified_upper, certify_by_default
from shakedown.model.constraints import Constraints, constraints, rows_named
from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.linear_program import INF, LinearProgram, Solution
from shakedown.programs.widest import widest

NO_SAFE_STATE = "no slip keeps every node within its friction limits, even under the mean load alone"
ZERO_AMPLITUDE = "zero-amplitude loop: the loading does not change over the period, any load factor is safe"
RELIEVING = "the periodic part of the loading brings no node nearer to its limits at any load factor"
WEDGING = "wedging: slip along one direction raises the friction limits faster than any load factor needs"


@dataclass(frozen=True)
class UpperBound:
    """Largest load factor at which a safe slip exists: λ_max of thesis (5.16).

    Above it shakedown is impossible, whatever the initial state.

    Attributes
    ----------
    status
        ``"optimal"``; ``"infeasible"`` (no safe slip at any load factor);
        ``"unbounded"`` (safe slips exist at arbitrarily large load factors).
    load_factor
        λ_max; NaN where infeasible, inf where unbounded.
    slip : (n,)
        The safe slip at λ_max [length]; NaN unless optimal.
    active
        (node, side) of the rows that determine it.
    multipliers : (2n,)
        y ≥ 0 that prove the status. Optimal: yᵀG = 0, yᵀd = 1, yᵀg = λ_max.
        Infeasible (Farkas): yᵀG = 0, yᵀd ≥ 0, yᵀg < 0. Zero where unbounded.
    direction : (n,)
        Where unbounded: v with G v + d ≤ 0, along which every load factor stays
        safe [length]; else NaN.
    reason
        The status in words; empty where optimal.
    residual
        Largest relative violation of what the status claims: of the rows at
        ``slip`` or along ``direction``, or of the equalities of ``multipliers``.
    least_load_factor
        The smallest load factor ≥ 0 with a safe slip: 0 but where the constant part
        of the loading is not the mean and alone has none; NaN where infeasible.
    certified
        (low, high), neighbouring floats that contain the exact λ_max of the problem
        as stored, (inf, inf) where it is proved unbounded, else None.
    exact
        Whether the status was checked in exact arithmetic.
    """

    status: str
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


def upper_bound(problem: Problem, *, certify: bool | None = None) -> UpperBound:
    """The largest load factor at which a safe slip exists (thesis (5.16), on the 2n extremal rows).

    Parameters
    ----------
    problem
        The contact and its loading loop.
    certify
        Whether to re-solve the active rows in exact arithmetic and, where they are
        not exactly the best, to go on from them; by default where that is quick.

    Raises
    ------
    SolverError
        If the linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> upper = shakedown.upper_bound(shakedown.example("two-node"))
    >>> upper.status, round(upper.load_factor, 6), upper.slip.round(5)
    ('optimal', 0.739146, array([-0.15635,  1.28773]))
    >>> low, high = upper.certified
    >>> low <= upper.load_factor <= high, high - low < 1e-15
    (True, True)
    """
    rows = constraints(problem)
    outcome = load_factor_program(rows, towards=-1.0).solve()
    certificate = None
    if certify_by_default(problem.n) if certify is None else certify:
        certificate = certified_upper(problem, outcome)
    status = outcome.status if certificate is None else certificate.status
    if status == "optimal":
        return _optimal(rows, outcome, certificate)
    return (_infeasible if status == "infeasible" else _unbounded)(rows, certificate)


def load_factor_program(rows: Constraints, towards: float) -> LinearProgram:
    """Maximise (−1) or minimise (+1) λ ≥ 0 over the columns (v, λ), subject to every row."""
    return LinearProgram(
        np.column_stack([rows.G, rows.d]),
        cost=np.append(np.zeros(rows.n), towards),
        lower=np.full(2 * rows.n, -INF),
        upper=rows.g,
        column_lower=np.append(np.full(rows.n, -INF), 0.0),
        column_upper=np.full(rows.n + 1, INF),
    )


def _optimal(rows: Constraints, outcome: Solution, certificate: Certificate | None) -> UpperBound:
    if certificate is not None:
        slip, load_factor, y = certificate.slip, certificate.load_factor, certificate.multipliers
        active, certified = np.array(certificate.rows, dtype=np.intp), (certificate.low, certificate.high)
    else:
        assert outcome.vertex is not None
        slip, load_factor = outcome.vertex.x[:-1], float(outcome.vertex.x[-1])
        y, active, certified = -outcome.vertex.multipliers, outcome.active, None
    return UpperBound(
        status="optimal",
        load_factor=load_factor,
        slip=slip,
        active=rows_named(rows, active),
        multipliers=y,
        direction=np.full(rows.n, nan),
        reason="",
        residual=float(rows.relative_excess(slip, load_factor).max()),
        least_load_factor=_least_load_factor(rows),
        certified=certified,
        exact=certificate is not None,
    )


def _least_load_factor(rows: Constraints) -> float:
    if np.all(rows.d >= 0):  # what is safe at one load factor is safe at every smaller one
        return 0.0
    vertex = load_factor_program(rows, towards=+1.0).solve().vertex
    return nan if vertex is None else float(vertex.x[-1])


def _infeasible(rows: Constraints, certificate: Certificate | None) -> UpperBound:
    if certificate is not None:
        y = certificate.multipliers
    else:
        matrix = np.column_stack([rows.G, rows.d])
        sizes = np.abs(matrix).max(axis=1)
        y = widest(matrix, np.where(sizes > 0, sizes, 1.0), rows.g, cap=INF, signed=rows.n).multipliers
    terms = np.abs(y) @ np.abs(rows.G)
    return UpperBound(
        status="infeasible",
        load_factor=nan,
        slip=np.full(rows.n, nan),
        active=rows_named(rows, np.flatnonzero(y)),
        multipliers=y,
        direction=np.full(rows.n, nan),
        reason=NO_SAFE_STATE,
        residual=float(np.max(np.abs(y @ rows.G) / np.where(terms > 0, terms, 1.0))),
        least_load_factor=nan,
        certified=None,
        exact=certificate is not None,
    )


def _unbounded(rows: Constraints, certificate: Certificate | None) -> UpperBound:
    if np.all(rows.d <= 0):
        direction, reason = np.zeros(rows.n), ZERO_AMPLITUDE if not np.any(rows.d) else RELIEVING
    else:
        direction, reason = _widest_direction(rows, certificate), WEDGING
    terms = np.maximum(np.max(np.abs(rows.G * direction), axis=1), np.abs(rows.d))
    excess = (rows.G @ direction + rows.d) / np.where(terms > 0, terms, 1.0)
    return UpperBound(
        status="unbounded",
        load_factor=inf,
        slip=np.full(rows.n, nan),
        active=(),
        multipliers=np.zeros(2 * rows.n),
        direction=direction,
        reason=reason,
        residual=float(excess.max()),
        least_load_factor=_least_load_factor(rows),
        certified=None if certificate is None else (inf, inf),
        exact=certificate is not None,
    )


def _widest_direction(rows: Constraints, certificate: Certificate | None) -> FloatArray:
    """v with G v + d ≤ 0, with room to spare where there is any."""
    norms = np.linalg.norm(rows.G, axis=1)
    cap = float(np.max(np.abs(rows.d)[norms > 0] / norms[norms > 0], initial=0.0))
    found = widest(rows.G, norms, -rows.d, cap=cap)
    return found.x if found.margin >= 0 or certificate is None else certificate.slip
