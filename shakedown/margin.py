"""Safe slips: slips that satisfy every frictional constraint, with as much room as possible."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from shakedown.arguments import check_load_factor
from shakedown.constraints import Constraints, constraints
from shakedown.linear_program import INF, LinearProgram
from shakedown.problem import FloatArray, Problem
from shakedown.tolerances import DEFAULT


@dataclass(frozen=True)
class SafeSlip:
    """The slip with the largest margin to all 2n rows at one load factor.

    Attributes
    ----------
    status
        ``"optimal"``; ``"infeasible"`` (no safe slip at this load factor);
        ``"unbounded"`` (the margin can be made as large as one likes; ``slip`` is a
        safe slip with a margin typical of the load).
    load_factor
        The load factor asked for.
    slip : (n,)
        The safe slip [length]; NaN where there is none.
    margin
        Distance in slip space from the nearest row's hyperplane [length];
        inf where unbounded, negative where infeasible.
    active
        (node, side) of the rows at that distance.
    residual
        Largest relative violation of a row at ``slip``; ≤ 0 where it is safe.
    """

    status: str
    load_factor: float
    slip: FloatArray
    margin: float
    active: tuple[tuple[int, int], ...]
    residual: float


def safe_slip(problem: Problem, load_factor: float) -> SafeSlip:
    """The safe slip farthest from slipping: max t with G v + t‖Gᵢ‖ ≤ g − λ d (thesis (5.4)).

    From this slip the system shakes down at once: no node ever moves.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    load_factor
        λ ≥ 0, the factor on the periodic part of the loading.

    Raises
    ------
    UsageError
        If the load factor is negative or not finite.

    Examples
    --------
    >>> import shakedown
    >>> safe = shakedown.safe_slip(shakedown.example("two-node"), 0.70)
    >>> safe.status, bool(safe.margin > 0)
    ('optimal', True)
    >>> shakedown.safe_slip(shakedown.example("two-node"), 0.75).status
    'infeasible'
    """
    check_load_factor(load_factor)
    rows = constraints(problem)
    room = rows.g - load_factor * rows.d
    norms = np.linalg.norm(rows.G, axis=1)
    cap = _typical_distance(rows, load_factor, norms)
    found = widest(rows.G, norms, room, cap=cap)
    slip, margin = found.x, found.margin
    residual = float(rows.relative_excess(slip, load_factor).max())
    active = rows_named(rows, np.flatnonzero(found.multipliers))
    if residual > DEFAULT.feasibility:
        return SafeSlip("infeasible", load_factor, np.full(rows.n, nan), margin, active, residual)
    if margin > 0.75 * cap:
        return SafeSlip("unbounded", load_factor, slip, inf, (), residual)
    return SafeSlip("optimal", load_factor, slip, margin, active, residual)


def _typical_distance(rows: Constraints, load_factor: float, norms: FloatArray) -> float:
    """Twice the largest margin that a bounded margin can have [length].

    The multipliers y of the largest margin t give t = yᵀ room with yᵀ norms = 1.
    """
    reach = np.abs(rows.g) + np.abs(load_factor * rows.d)
    steep = norms > 0
    distance = np.max(reach[steep] / norms[steep], initial=0.0)
    return 2.0 * float(distance) if distance > 0 else 1.0


@dataclass(frozen=True)
class Widest:
    """The point x with the largest margin, and the multipliers ≥ 0 that prove that no larger one exists."""

    x: FloatArray
    margin: float
    multipliers: FloatArray


def widest(
    matrix: FloatArray, norms: FloatArray, right: FloatArray, *, cap: float, signed: int | None = None
) -> Widest:
    """Maximise t ≤ cap subject to M x + t·norms ≤ right, and x ≥ 0 in the column ``signed``.

    The multipliers satisfy yᵀ M = 0 (≥ 0 in the column ``signed``), yᵀ norms = 1 and
    yᵀ right = t, as long as t < cap.
    """
    rows, columns = matrix.shape
    lower = np.full(columns + 1, -INF)
    if signed is not None:
        lower[signed] = 0.0
    upper = np.full(columns + 1, INF)
    upper[-1] = cap
    program = LinearProgram(
        np.column_stack([matrix, norms]),
        cost=np.append(np.zeros(columns), -1.0),
        lower=np.full(rows, -INF),
        upper=right,
        column_lower=lower,
        column_upper=upper,
    )
    vertex = program.solve().vertex
    if vertex is None:  # rows without a norm contradict each other, whatever t
        return Widest(np.zeros(columns), -inf, np.zeros(rows))
    return Widest(vertex.x[:-1], float(vertex.x[-1]), -vertex.multipliers)


def rows_named(rows: Constraints, indices: NDArray[np.intp]) -> tuple[tuple[int, int], ...]:
    """(node, side) of some rows, in order."""
    return tuple((int(rows.node[i]), int(rows.side[i])) for i in sorted(indices))
