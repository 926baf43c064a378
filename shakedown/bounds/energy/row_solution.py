"""The largest load factor that the rows about a slip allow: active rows first, then Newton's method."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.energy.cone_rows import ConeRows
from shakedown.ground.errors import Missing, SolverError, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, SIX_DIGITS
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.programs.program import Program, ball
from shakedown.programs.solver import METHOD_COUNT, solve

# With these, and half as many as there are nodes, most programs are solved in one or two rounds.
FIRST_ROWS = 40
NEWTON_STEPS = 5
SHARP = NEGLIGIBLE / 10  # relative gap allowed between λ and the value proved by its multipliers
PULLING, NEAR = 1e-7, 1e-5  # active rows have larger multipliers and smaller slacks, relatively
ROUND_OFF = 32 * np.finfo(float).eps


@dataclass(frozen=True)
class RowSolution:
    """The solution of the program: max λ subject to :class:`ConeRows`.

    Attributes
    ----------
    status
        How it ended.
    y : (r,)
        The solution.
    load_factor
        The largest λ that the rows allow at y in floats.
    multipliers : (k,)
        μ ≥ 0. Optimal: dᵀμ = 1, ‖Hᵀμ‖ ≤ sᵀμ, and μᵀ(g − δ s) = λ. Infeasible:
        the last is negative, with dᵀμ ≥ 0.
    """

    status: Status
    y: FloatArray
    load_factor: float
    multipliers: FloatArray


def solve_rows(rows: ConeRows, tolerances: Tolerances, method: int = 0) -> RowSolution:
    """Maximise λ, by one method for cone programs. Rows are added to it as they turn out to be violated.

    The solution is a combination of the rows that carry a multiplier, so k rows
    need no more than k + 2 unknowns.
    """
    chosen = _first_rows(rows)
    while True:  # ends: every round takes further rows, and there are finitely many
        part = rows.among(chosen)
        found = _solved(part, method)
        if found.status != Status.OPTIMAL and len(chosen) < len(rows.d):
            if found.status == Status.INFEASIBLE:
                return _among_all(found, chosen, rows)
            chosen = np.arange(len(rows.d))
            continue
        if found.status != Status.OPTIMAL:
            return found
        excess = rows.excess(found.y, found.load_factor)
        violated = np.flatnonzero(excess > tolerances.feasibility)
        added = np.setdiff1d(violated, chosen)
        if not added.size:
            return _sharp(rows, _among_all(found, chosen, rows))
        worst = added[np.argsort(-excess[added])[: max(FIRST_ROWS, len(chosen))]]
        chosen = np.sort(np.append(chosen, worst))


def _first_rows(rows: ConeRows) -> NDArray[np.intp]:
    """The rows that limit λ first at y = 0, and the sign of λ."""
    count = len(rows.d)
    with np.errstate(divide="ignore", invalid="ignore"):
        right = rows.g - rows.offset * rows.s
        slope = np.maximum(np.linalg.norm(rows.H, axis=1), rows.s)
        first = np.where(rows.d > 0, right / rows.d, np.where(right < 0, -np.inf, np.inf))
        first = np.where((rows.d > 0) | (slope > 0), first, np.inf)
    kept = np.argsort(first[:-1], kind="stable")[: FIRST_ROWS + count // 4]
    return np.sort(np.append(kept, count - 1))


def _solved(rows: ConeRows, method: int) -> RowSolution:
    """The program of a few rows, in the space of y that they span."""
    basis = _span(rows.H)
    rank = basis.shape[1]
    matrix = np.column_stack([rows.H @ basis, rows.s, rows.d])
    found = solve(_within_cone(matrix, rows.g, rank, rows.offset), method)
    y = basis @ found.x[:rank]
    return RowSolution(found.status, y, float(found.x[-1]), found.multipliers[: len(rows.g)])


def _within_cone(matrix: FloatArray, right: FloatArray, rank: int, offset: float) -> Program:
    """Maximise the last of the unknowns (y, R, …) subject to rows and to ‖y‖ + offset ≤ R."""
    columns = matrix.shape[1]
    return Program(
        np.vstack([matrix, ball(rank, columns)]),
        np.concatenate([right, [-offset], np.zeros(rank)]),
        cost=np.append(np.zeros(columns - 1), -1.0),
        cones=(rank + 1,),
    )


def _span(H: FloatArray) -> FloatArray:
    """Orthonormal columns that span the rows of H, or all of its space where that is not larger."""
    if len(H) >= H.shape[1]:
        return np.eye(H.shape[1])
    return np.linalg.qr(H.T)[0]


def _among_all(found: RowSolution, chosen: NDArray[np.intp], rows: ConeRows) -> RowSolution:
    multipliers = np.zeros(len(rows.d))
    multipliers[chosen] = found.multipliers
    return replace(found, multipliers=multipliers)


def _sharp(rows: ConeRows, found: RowSolution) -> RowSolution:
    """The solution with its conditions refined by Newton's method, where that improves it.

    At any y the rows themselves give a load factor that holds in floats; the y at which
    it comes nearest to what the multipliers prove is kept.
    """
    best = replace(found, load_factor=rows.largest_load_factor(found.y))
    for singular in (ROUND_OFF, SIX_DIGITS):  # the cone solver resolves none below SIX_DIGITS
        candidate = _newton(rows, found, singular)
        if candidate is None:
            continue
        sharper = replace(candidate, load_factor=rows.largest_load_factor(candidate.y))
        worst = rows.excess(sharper.y, sharper.load_factor).max()
        allowed = max(rows.excess(best.y, best.load_factor).max(), ROUND_OFF)
        if worst <= allowed and _open(rows, sharper) < _open(rows, best):
            best = sharper
        if _open(rows, best) <= ROUND_OFF * abs(best.load_factor):  # no improvement possible
            break
    return best


def _open(rows: ConeRows, end: RowSolution) -> float:
    """The gap between a load factor and the value proved by its multipliers."""
    return abs(rows.proved(end.multipliers) - end.load_factor)


def _newton(rows: ConeRows, found: RowSolution, singular: float) -> RowSolution | None:
    """Stationarity and the active rows as equations in (y, λ, μ); None where they cannot be solved.

    The equations are singular where both limits of one node decide alone: moving the
    centre so that the pressure of that node rises then gains as much slack as the larger
    radius needs. The shortest step is taken, what is below ``singular`` counts as zero.
    """
    share = found.multipliers * np.maximum(np.linalg.norm(rows.H, axis=1), np.abs(rows.d))
    slack = -rows.excess(found.y, found.load_factor)
    active = np.flatnonzero((share > PULLING * share.max()) & (slack < NEAR))
    part = rows.among(active)
    basis = _span(part.H)
    part = replace(part, H=part.H @ basis)
    y, load_factor, mu = basis.T @ found.y, found.load_factor, found.multipliers[active]
    rank = len(y)
    for _ in range(NEWTON_STEPS):
        if not 0 < np.linalg.norm(y) < np.inf:
            return None
        step = np.linalg.lstsq(*_equations(part, y, load_factor, mu), rcond=singular)[0]
        y, load_factor, mu = y + step[:rank], load_factor + step[rank], mu + step[rank + 1 :]
    if np.any(mu < 0) or not np.isfinite(load_factor):
        return None
    multipliers = np.zeros(len(rows.d))
    multipliers[active] = mu
    return RowSolution(Status.OPTIMAL, basis @ y, float(load_factor), multipliers)


def _equations(
    rows: ConeRows, y: FloatArray, load_factor: float, mu: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Matrix and right-hand side of one Newton step in (y, λ, μ)."""
    rank, count = len(y), len(mu)
    length = float(np.linalg.norm(y))
    towards, pull = y / length, float(rows.s @ mu)
    slopes = rows.H + rows.s[:, None] * towards
    matrix = np.zeros((rank + 1 + count, rank + 1 + count))
    matrix[:rank, :rank] = pull / length * (np.eye(rank) - np.outer(towards, towards))
    matrix[:rank, rank + 1 :] = slopes.T
    matrix[rank, rank + 1 :] = rows.d
    matrix[rank + 1 :, :rank] = slopes
    matrix[rank + 1 :, rank] = rows.d
    value = rows.H @ y + load_factor * rows.d + (length + rows.offset) * rows.s - rows.g
    return matrix, -np.concatenate([slopes.T @ mu, [rows.d @ mu - 1.0], value])


@dataclass(frozen=True)
class WidestMargin:
    """The point (y, λ) with the largest margin t ≤ 1 to every row, relative to its size.

    Where t < 0 the multipliers prove that the rows contradict each other, as those of
    :class:`RowSolution` do.
    """

    y: FloatArray
    load_factor: float
    margin: float
    multipliers: FloatArray


def widest_margin(rows: ConeRows) -> WidestMargin:
    """Maximise the margin that every row keeps."""
    sizes = np.maximum(rows.sizes, np.linalg.norm(rows.H, axis=1))
    sizes[-1] = 0.0
    rank = rows.H.shape[1]
    matrix = np.column_stack([rows.H, rows.s, rows.d, sizes])
    matrix = np.vstack([matrix, np.append(np.zeros(rank + 2), 1.0)])
    found = solve(_within_cone(matrix, np.append(rows.g, 1.0), rank, rows.offset))
    if found.status != Status.OPTIMAL:
        raise SolverError(f"the cone program for the largest margin ended as '{found.status}'")
    multipliers = found.multipliers[: len(rows.g)]
    return WidestMargin(found.x[:rank], float(found.x[-2]), float(found.x[-1]), multipliers)


def row_solution(about: ConeRows, tolerances: Tolerances) -> RowSolution:
    """The solution of the program by the first method by which it is one; of several optima the sharpest.

    Where the solver finds none, or no proof of it, the largest margin tells whether there is one.

    Raises
    ------
    SolverError
        If no method comes to an end that the rows confirm.
    """
    best, failure = None, "the cone program ended with limits broken"
    for method in range(METHOD_COUNT):
        end = sought(solve_rows, about, tolerances, method)
        if isinstance(end, Missing):
            failure = end.reason
            break  # the program itself has tried the following methods already
        if end.status == Status.UNBOUNDED:
            return end
        if end.status == Status.INFEASIBLE:
            if contradiction(about, end) <= tolerances.feasibility:
                return end
            failure = "the cone program ended as infeasible without a proof"
        elif _kept(about, end) <= tolerances.feasibility:
            best = end if best is None or _open(about, end) < _open(about, best) else best
            enough = tolerances.agreement if method else SHARP
            if _open(about, best) <= enough * abs(best.load_factor):
                break
    if best is not None:
        return best
    widest = widest_margin(about)
    if widest.margin > tolerances.feasibility:
        raise SolverError(failure)
    return RowSolution(Status.INFEASIBLE, widest.y, np.nan, widest.multipliers)


def _kept(about: ConeRows, end: RowSolution) -> float:
    """The largest violation of a row other than the sign of λ, which is clipped at zero."""
    load_factor = end.load_factor if end.load_factor * about.d[-1] <= 0.0 else 0.0
    return float(about.excess(end.y, load_factor).max())


def contradiction(about: ConeRows, end: RowSolution) -> float:
    """The error of multipliers as a proof that the rows contradict each other (Farkas)."""
    mu = end.multipliers
    value = -mu @ (about.g - about.offset * about.s)
    if not value > 0:
        return np.inf
    pull = float(np.linalg.norm(about.H.T @ mu) - about.s @ mu)
    sizes = float(np.linalg.norm(np.abs(about.H).T @ mu)) or 1.0
    d, weights = about.d[:-1], mu[:-1]  # the row for the sign of λ takes the positive part
    drift = -float(d @ weights) / float(np.abs(d) @ weights or 1.0)
    return max(pull / sizes, drift, 0.0)
