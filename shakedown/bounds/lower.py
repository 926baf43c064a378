"""Lower bound of the load factor: the first collapse of a node's range of slips."""

from dataclasses import dataclass, replace
from math import inf, nan

import numpy as np

from shakedown.bounds.certificate import Certificate, certified_lower, certify_by_default, starts_safe
from shakedown.bounds.proof_status import GuaranteeStatus, guarantee_status
from shakedown.bounds.upper import NO_SAFE_STATE, UpperBound, load_factor_program, upper_bound
from shakedown.model.constraints import Constraints, constraints, rows_named
from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.linear_program import INF, LinearProgram, Solution
from shakedown.tolerances import DEFAULT


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
        The node that collapses; −1 where none does (λ_1 is then λ_max, inf or NaN).
    slip : (n,)
        The witness [length]: an initial state that leads to cyclic slip of ``node``
        above λ_1 in nearly every case; NaN unless optimal.
    per_node : (n,)
        The load factor at which each node collapses; inf where it never does, NaN
        where infeasible.
    active
        (node, side) of the rows that determine the witness.
    multipliers : (2n,)
        y, ≥ 0 in the rows of ``node`` and ≤ 0 in the others, that prove the value:
        yᵀG = 0, yᵀd ≤ 1 (= 1 where λ_1 > 0), yᵀg = λ_1.
    guarantee
        ``"proved"``, ``"single-node-excluded"`` or ``"evidence"``: how sure it is that
        below λ_1 the system shakes down from every initial state.
    reason
        The status of the guarantee, and why λ_1 is 0 where it is, in words.
    coupling_ratio
        ρ, the spectral radius of the slip-to-slip influence; NaN where undefined.
    single_node_bound
        Below this load factor no node alone can slip cyclically; NaN where not computed.
    lift_off_bound
        Below this load factor no admissible slip lifts a node off; NaN where it was not
        needed for the guarantee.
    residual
        Largest relative violation of the rows at ``slip``.
    certified
        (low, high), neighbouring floats that contain the exact λ_1 of the problem as
        stored, or None.
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
    lift_off_bound: float
    residual: float
    certified: tuple[float, float] | None
    kind: str = "first-collapse"


def lower_bound(problem: Problem, *, certify: bool | None = None) -> LowerBound:
    """The load factor of first collapse λ_1, from one small linear program per node.

    For node j: the smallest λ ≥ 0 at which some slip has both rows of node j
    reversed (≥ g) and every other row kept (≤ g). For two nodes it is the
    thesis's λ_min (5.12); for more it is the first critical load factor that
    lies on the safe region.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    certify
        Whether to check every node in exact arithmetic; by default where that is quick.

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
    program = load_factor_program(rows, towards=+1.0)
    start = program.solve()
    exact = certify_by_default(problem.n) if certify is None else certify
    safe = starts_safe(problem, start) if exact else None
    if safe is None:
        safe = start.vertex is not None and start.vertex.x[-1] <= 0
    if not safe:
        return _no_collapse(rows, "infeasible", nan, NO_SAFE_STATE, None)
    outcomes = _collapses(rows, program)
    per_node = np.array([inf if o.vertex is None else o.vertex.x[-1] for o in outcomes])
    node, certificate = int(np.argmin(per_node)), None
    if exact:
        node, certificate = certified_lower(problem, outcomes, node) or (node, None)
    vertex = outcomes[node].vertex
    if certificate is not None:
        x = np.append(certificate.slip, certificate.load_factor)
        per_node[node] = certificate.load_factor
    elif vertex is not None:
        x = vertex.x
    else:
        upper = upper_bound(problem, certify=certify)
        if upper.status == "optimal":
            return _vanishing(problem, rows, upper)
        status = guarantee_status(problem, inf)
        reason = f"no node ever collapses; {status.reason}"
        return _no_collapse(rows, "unbounded", inf, reason, status)
    if has_free_motion(rows):  # else λ_max has both rows of some node active, and λ_1 ≤ λ_max
        upper = upper_bound(problem, certify=certify)
        if upper.status == "optimal" and upper.load_factor < x[-1]:
            return _vanishing(problem, rows, upper)
    return _collapse(problem, rows, node, x, per_node, outcomes[node], certificate)


def _collapse(
    problem: Problem,
    rows: Constraints,
    node: int,
    x: FloatArray,
    per_node: FloatArray,
    outcome: Solution,
    certificate: Certificate | None,
) -> LowerBound:
    load_factor = float(x[-1])
    status = guarantee_status(problem, load_factor)
    if certificate is not None:
        y = np.where(rows.node == node, 1.0, -1.0) * certificate.multipliers
        active, certified = np.array(certificate.rows, dtype=np.intp), (certificate.low, certificate.high)
    else:
        assert outcome.vertex is not None
        y, active, certified = outcome.vertex.multipliers, outcome.active, None
    return LowerBound(
        status="optimal",
        load_factor=load_factor,
        node=node,
        slip=x[:-1],
        per_node=per_node,
        active=rows_named(rows, active),
        multipliers=y,
        guarantee=status.guarantee,
        reason=_reason(problem, load_factor, node, status.reason),
        coupling_ratio=status.coupling_ratio,
        single_node_bound=status.single_node_bound,
        lift_off_bound=status.lift_off_bound,
        residual=_collapse_excess(rows, node, x),
        certified=certified,
    )


def has_free_motion(rows: Constraints) -> bool:
    """Whether some slip changes no row, to round-off: a body that nothing but the contact holds."""
    sizes = np.linalg.norm(rows.G, axis=1, keepdims=True)
    values = np.linalg.svd(rows.G / np.where(sizes > 0, sizes, 1.0), compute_uv=False)
    return bool(values[-1] <= DEFAULT.degeneracy * values[0])


def _vanishing(problem: Problem, rows: Constraints, upper: UpperBound) -> LowerBound:
    """The answer where no safe slip is left at λ_max, and no node has lost its range of slips before."""
    status = guarantee_status(problem, upper.load_factor)
    reason = f"all safe slips vanish together at λ_max, before any node collapses; {status.reason}"
    answer = _no_collapse(rows, "optimal", upper.load_factor, reason, status)
    return replace(
        answer,
        per_node=np.full(rows.n, inf),
        active=upper.active,
        multipliers=upper.multipliers,
        residual=upper.residual,
        certified=upper.certified,
    )


def _no_collapse(
    rows: Constraints, status: str, load_factor: float, reason: str, proof: GuaranteeStatus | None
) -> LowerBound:
    """The answer where no node collapses; without a safe slip (``proof`` None) nothing is guaranteed."""
    return LowerBound(
        status=status,
        load_factor=load_factor,
        node=-1,
        slip=np.full(rows.n, nan),
        per_node=np.full(rows.n, load_factor),
        active=(),
        multipliers=np.zeros(2 * rows.n),
        guarantee="evidence" if proof is None else proof.guarantee,
        reason=reason,
        coupling_ratio=nan if proof is None else proof.coupling_ratio,
        single_node_bound=nan if proof is None else proof.single_node_bound,
        lift_off_bound=nan if proof is None else proof.lift_off_bound,
        residual=nan,
        certified=None,
    )


def _collapses(rows: Constraints, program: LinearProgram) -> list[Solution]:
    """The end of every node's program: in one model the two rows of one node are reversed at a time."""
    outcomes = []
    free = np.full(2, INF)
    for node in range(rows.n):
        pair = np.array([2 * node, 2 * node + 1])
        program.set_rows(pair, rows.g[pair], free)
        outcomes.append(program.solve())
        program.set_rows(pair, -free, rows.g[pair])
    return outcomes


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
