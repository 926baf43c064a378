"""Upper bound (a safe slip exists) and lower bound (first collapse) of the load factor."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np

from shakedown.constraints import Constraints, constraints
from shakedown.guarantee import guarantee_status
from shakedown.linear_program import INF, LinearProgram, Vertex
from shakedown.margin import rows_named, widest
from shakedown.problem import FloatArray, Problem

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
        ``"unbounded"`` (safe slips exist at every load factor).
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
        (low, high) that contain the exact λ_max of the problem as stored, or None.
    """

    status: str
    load_factor: float
    slip: FloatArray
    active: tuple[tuple[int, int], ...]
    multipliers: FloatArray
    direction: FloatArray
    reason: str
    residual: float
    least_load_factor: float = 0.0
    certified: tuple[float, float] | None = None


@dataclass(frozen=True)
class LowerBound:
    """First collapse λ_1: the smallest load factor at which both limits of one node meet.

    Below λ_1 every node keeps a range of slips between its two limits, whatever
    slips within their own limits the other nodes have. At λ_1 the range of
    ``node`` shrinks to a point.

    Attributes
    ----------
    status
        ``"optimal"``; ``"unbounded"`` (no node's range ever shrinks to a point);
        ``"infeasible"`` (there is no safe slip under the mean load to begin with).
    load_factor
        λ_1; inf where unbounded, NaN where infeasible.
    node
        The node that collapses; −1 unless optimal.
    slip : (n,)
        The witness [length]: an initial state that leads to cyclic slip of ``node``
        above λ_1 in nearly every case; NaN unless optimal.
    per_node : (n,)
        The load factor at which each node collapses; inf where it never does, NaN
        where infeasible.
    active
        (node, side) of the rows that determine the witness.
    multipliers : (2n,)
        y, ≤ 0 in the rows of ``node``, that prove the value: yᵀG = 0, yᵀd ≤ 1, yᵀg = λ_1 up to sign.
    guarantee
        ``"proved"``, ``"single-node-excluded"`` or ``"evidence"``: how sure it is that
        below λ_1 the system shakes down from every initial state.
    reason
        The status of the guarantee, and why λ_1 is 0 where it is, in words.
    coupling_ratio
        ρ, the spectral radius of the slip-to-slip influence; NaN where undefined.
    single_node_bound
        Below this load factor no node alone can slip cyclically; NaN where not computed.
    residual
        Largest relative violation of the rows at ``slip``.
    certified
        (low, high) that contain the exact λ_1 of the problem as stored, or None.
    kind
        What the number is: ``"first-collapse"``.
    """

    status: str
    load_factor: float
    node: int
    slip: FloatArray
    per_node: FloatArray
    active: tuple[tuple[int, int], ...]
    multipliers: FloatArray
    guarantee: str
    reason: str
    coupling_ratio: float
    single_node_bound: float
    residual: float
    certified: tuple[float, float] | None = None
    kind: str = "first-collapse"


@dataclass(frozen=True)
class ShakedownBounds:
    """Both bounds of one problem: between them the outcome depends on the initial state."""

    lower: LowerBound
    upper: UpperBound


def shakedown_bounds(problem: Problem) -> ShakedownBounds:
    """Lower and upper bound of the load factor.

    Examples
    --------
    >>> import shakedown
    >>> bounds = shakedown.shakedown_bounds(shakedown.example("two-node"))
    >>> round(bounds.lower.load_factor, 6), round(bounds.upper.load_factor, 6)
    (0.657373, 0.739146)
    """
    return ShakedownBounds(lower_bound(problem), upper_bound(problem))


def upper_bound(problem: Problem) -> UpperBound:
    """The largest load factor at which a safe slip exists (thesis (5.16), on the 2n extremal rows).

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
    """
    rows = constraints(problem)
    outcome = _program(rows, towards=-1.0).solve()
    if outcome.vertex is not None:
        return _optimal(rows, outcome.vertex)
    return _infeasible(rows) if outcome.status == "infeasible" else _unbounded(rows)


def _program(rows: Constraints, towards: float) -> LinearProgram:
    """Maximise (−1) or minimise (+1) λ ≥ 0 subject to every row."""
    return LinearProgram(
        np.column_stack([rows.G, rows.d]),
        cost=np.append(np.zeros(rows.n), towards),
        lower=np.full(2 * rows.n, -INF),
        upper=rows.g,
        column_lower=np.append(np.full(rows.n, -INF), 0.0),
        column_upper=np.full(rows.n + 1, INF),
    )


def _optimal(rows: Constraints, vertex: Vertex) -> UpperBound:
    slip, load_factor = vertex.x[:-1], float(vertex.x[-1])
    return UpperBound(
        status="optimal",
        load_factor=load_factor,
        slip=slip,
        active=rows_named(rows, vertex.active),
        multipliers=-vertex.multipliers,
        direction=np.full(rows.n, nan),
        reason="",
        residual=float(rows.relative_excess(slip, load_factor).max()),
        least_load_factor=_least_load_factor(rows),
    )


def _least_load_factor(rows: Constraints) -> float:
    if np.all(rows.d >= 0):  # what is safe at one load factor is safe at every smaller one
        return 0.0
    vertex = _program(rows, towards=+1.0).solve().vertex
    return nan if vertex is None else float(vertex.x[-1])


def _infeasible(rows: Constraints) -> UpperBound:
    matrix = np.column_stack([rows.G, rows.d])
    sizes = np.abs(matrix).max(axis=1)
    _, _, y = widest(matrix, np.where(sizes > 0, sizes, 1.0), rows.g, cap=INF, signed=rows.n)
    terms = np.abs(y) @ np.abs(rows.G)
    residual = float(np.max(np.abs(y @ rows.G) / np.where(terms > 0, terms, 1.0)))
    return UpperBound(
        status="infeasible",
        load_factor=nan,
        slip=np.full(rows.n, nan),
        active=rows_named(rows, np.flatnonzero(y)),
        multipliers=y,
        direction=np.full(rows.n, nan),
        reason=NO_SAFE_STATE,
        residual=residual,
        least_load_factor=nan,
    )


def _unbounded(rows: Constraints) -> UpperBound:
    if np.all(rows.d <= 0):
        direction, reason = np.zeros(rows.n), ZERO_AMPLITUDE if not np.any(rows.d) else RELIEVING
    else:
        norms = np.linalg.norm(rows.G, axis=1)
        cap = float(np.max(np.abs(rows.d)[norms > 0] / norms[norms > 0], initial=0.0))
        direction, _, _ = widest(rows.G, norms, -rows.d, cap=cap)
        reason = WEDGING
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
    )


def lower_bound(problem: Problem) -> LowerBound:
    """The load factor of first collapse λ_1, from one small linear program per node.

    For node j: the smallest λ ≥ 0 at which some slip has both rows of node j
    reversed (≥ g) and every other row kept (≤ g). For two nodes it is the
    thesis's λ_min (5.12); for more it is the first critical load factor that
    lies on the safe region.

    Raises
    ------
    SolverError
        If a linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> lower = shakedown.lower_bound(shakedown.example("two-node"))
    >>> round(lower.load_factor, 6), lower.node, lower.guarantee
    (0.657373, 1, 'proved')
    """
    rows = constraints(problem)
    program = _program(rows, towards=+1.0)
    start = program.solve().vertex
    if start is None or start.x[-1] > 0:
        return _no_collapse(rows, "infeasible", nan, NO_SAFE_STATE)
    collapses = _collapses(rows, program)
    status = guarantee_status(problem)
    if not collapses:
        return _no_collapse(rows, "unbounded", inf, f"no node ever collapses; {status.reason}")
    per_node = np.array([collapses[j].x[-1] if j in collapses else inf for j in range(rows.n)])
    node = int(np.argmin(per_node))
    vertex = collapses[node]
    return LowerBound(
        status="optimal",
        load_factor=float(per_node[node]),
        node=node,
        slip=vertex.x[:-1],
        per_node=per_node,
        active=rows_named(rows, vertex.active),
        multipliers=-vertex.multipliers,
        guarantee=status.guarantee,
        reason=_reason(problem, float(per_node[node]), node, status.reason),
        coupling_ratio=status.coupling_ratio,
        single_node_bound=status.single_node_bound,
        residual=_collapse_excess(rows, node, vertex.x),
    )


def _no_collapse(rows: Constraints, status: str, load_factor: float, reason: str) -> LowerBound:
    return LowerBound(
        status=status,
        load_factor=load_factor,
        node=-1,
        slip=np.full(rows.n, nan),
        per_node=np.full(rows.n, load_factor),
        active=(),
        multipliers=np.zeros(2 * rows.n),
        guarantee="evidence",
        reason=reason,
        coupling_ratio=nan,
        single_node_bound=nan,
        residual=nan,
    )


def _collapses(rows: Constraints, program: LinearProgram) -> dict[int, Vertex]:
    """Where every node collapses, if it does: in one model the two rows of one node are reversed."""
    found: dict[int, Vertex] = {}
    free = np.full(2, INF)
    for node in range(rows.n):
        pair = np.array([2 * node, 2 * node + 1])
        program.set_rows(pair, rows.g[pair], free)
        vertex = program.solve().vertex
        if vertex is not None:
            found[node] = vertex
        program.set_rows(pair, -free, rows.g[pair])
    return found


def _collapse_excess(rows: Constraints, node: int, x: FloatArray) -> float:
    """Largest relative violation of the rows, those of the collapsing node reversed."""
    excess = rows.relative_excess(x[:-1], float(x[-1]))
    return float(np.where(rows.node == node, -excess, excess).max())


def _reason(problem: Problem, load_factor: float, node: int, guarantee: str) -> str:
    if load_factor > 0:
        return guarantee
    if problem.f[node] == 0:
        return f"node {node} has no friction: it slips with every load; {guarantee}"
    return f"node {node} can be lifted off by locked-in slip at the mean load; {guarantee}"
