"""Safe slips: slips that satisfy every frictional constraint, with as much room as possible."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np

from shakedown.model.arguments import check_load_factor
from shakedown.model.constraints import Constraints, constraints, rows_named
from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.widest import widest
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
