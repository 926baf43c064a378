"""Lower bound of the load factor: the first collapse of a node's range of slips, one program per node."""

from dataclasses import dataclass, field
from functools import cached_property
from math import inf, isnan, nan
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds import certificate
from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO, Certificate, Disputed
from shakedown.bounds.proof_status import GuaranteeEvidence, GuaranteeStatus, guarantee_status
from shakedown.bounds.upper import upper_bound
from shakedown.ground.constants import CONVERGED, ITERATIONS, NEGLIGIBLE, FloatArray
from shakedown.ground.errors import Missing, attempt
from shakedown.ground.status import Guarantee, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, require_plane
from shakedown.joint.constraints import Constraints, by_side, constraints, rows_named, rows_of
from shakedown.joint.problem import Problem
from shakedown.programs.program import INF, Solution, power_of_two
from shakedown.programs.simplex import Simplex

_NEARLY_FIRST = 10 * NEGLIGIBLE  # nodes this close are distinguished by polishing, not by the solver's 1e-10


def collapses(
    rows: Constraints, program: Simplex, limits: "CollapseLimits", all_nodes: bool
) -> dict[int, Solution]:
    """The solutions of the programs of nodes: in one model the two rows of one node are reversed at a time.

    Each begins where its limit would be reached; where that is its vertex no solver is needed. Unless
    ``all_nodes`` are wanted, none is solved that cannot collapse first.
    """
    outcomes: dict[int, Solution] = {}
    free, earliest = np.full(2, INF), inf
    for node in np.argsort(limits.load_factors, kind="stable").tolist():
        if not all_nodes and limits.load_factors[node] > earliest * (1 + _NEARLY_FIRST):
            break
        pair = rows_of(node)
        program.set_rows(pair, rows.g[pair], free)
        met = program.at(limits.rows[node]) if limits.known[node] else None
        outcomes[node] = outcome = met or program.solve()
        program.set_rows(pair, -free, rows.g[pair])
        earliest = min(earliest, _solver_value(outcome))
        if not all_nodes and outcome.value <= 0.0 and _polished_value(outcome) == 0.0:
            break
    return outcomes


@dataclass(frozen=True)
class CollapseLimits:
    """Load factors that no node collapses below, from one multiplier per node and no program.

    Attributes
    ----------
    load_factors : (n,)
        0 where nothing is known, inf where a node never collapses.
    rows : (n, n + 1)
        The rows that would meet there.
    known : (n,)
        Whether there is such a limit.
    """

    load_factors: FloatArray
    rows: NDArray[np.intp]
    known: NDArray[np.bool_]


def collapse_limits(rows: Constraints) -> CollapseLimits:
    """The limits that the multipliers of one row per node prove.

    The program of node j has the multipliers y of its own rows, y₊ + y₋ = 1, and at a vertex where no
    other node is at both its limits one y_i of each other node. With s_i = ± y_i, + in the backward
    row, and s_j = y₋ − y₊ they solve

        A s = (f B)ᵀ |s|,    |s_j| replaced by −1:

    neither loads nor the load factor are in it, so that it is iterated for all nodes at once. Whatever
    the vertex is, λ ≥ y·g / y·d by weak duality; up to the first collapse it is the value itself.
    """
    n = rows.n
    limits = CollapseLimits(np.zeros(n), np.zeros((n, n + 1), dtype=np.intp), np.zeros(n, dtype=bool))
    G = by_side(rows.G[rows.sided])
    backward, forward = G[:, 0], -G[:, 1]
    stiffness = 0.5 * np.diagonal(backward + forward)
    # Where a body floats, some nodes have no row in the vertex; a node without friction is at both limits.
    if rows.pinned or not (np.all(stiffness > 0) and rows.sided.all()):
        return limits
    size = np.array([power_of_two(float(root)) for root in np.sqrt(stiffness)])
    A, fB = (part / size / size[:, None] for part in (0.5 * (backward + forward), 0.5 * (forward - backward)))
    s, converged = _multipliers(A, fB)
    if not converged.any():
        return limits
    y = np.stack([-np.maximum(s.T, 0.0), np.minimum(s.T, 0.0)], axis=2)  # by node and side
    nodes, own = np.arange(n), np.diagonal(s)
    y[nodes, nodes] = np.column_stack([0.5 * (1.0 - own), 0.5 * (1.0 + own)])
    y /= size[:, None]  # so far in units of the rows divided by the size of their node
    return _limits(rows, y.reshape(n, -1), s, converged & (np.abs(own) <= 1.0))


def _multipliers(A: FloatArray, fB: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """s of every node as columns, and which of them have converged."""
    try:
        influence: FloatArray = np.asarray(np.linalg.solve(A, fB.T), dtype=float)
    except np.linalg.LinAlgError:
        return np.zeros_like(A), np.zeros(len(A), dtype=bool)
    s, converged = -influence, np.zeros(len(A), dtype=bool)
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(ITERATIONS):
            folded = np.abs(s)
            np.fill_diagonal(folded, -1.0)
            before, s = s, influence @ folded
            converged = np.abs(s - before).max(axis=0) <= CONVERGED * np.maximum(np.abs(s).max(axis=0), 1.0)
            if converged.all():
                break
    converged &= np.isfinite(s).all(axis=0)  # growth without bound is none
    return np.where(converged, s, 0.0), converged


def _limits(rows: Constraints, y: FloatArray, s: FloatArray, known: NDArray[np.bool_]) -> CollapseLimits:
    n, terms = rows.n, np.abs(y) @ np.abs(rows.d)
    value, slope = y @ rows.g, y @ rows.d
    rising, never = slope > CONVERGED * n * terms, value > CONVERGED * n * (np.abs(y) @ np.abs(rows.g))
    with np.errstate(divide="ignore", invalid="ignore"):
        load_factors = np.where(rising, np.maximum(value / slope, 0.0), np.where(never, inf, 0.0))
    sides = 2 * np.arange(n) + (s.T <= 0.0)
    others = sides[~np.eye(n, dtype=bool)].reshape(n, n - 1)
    own = 2 * np.arange(n)[:, None] + np.arange(2)
    meeting = np.sort(np.hstack([others, own]), axis=1)
    return CollapseLimits(np.where(known, load_factors, 0.0), meeting, known)


def first_to_collapse(outcomes: dict[int, Solution]) -> int:
    """The node that collapses first; ties beyond the solver's accuracy are resolved to round-off."""
    values = {node: _solver_value(end) for node, end in sorted(outcomes.items())}
    least = min(values.values())
    if least == inf:
        return min(values)
    near = [node for node, value in values.items() if value <= least + _NEARLY_FIRST * abs(least)]
    return min(near, key=lambda node: _polished_value(outcomes[node]))


def _solver_value(outcome: Solution) -> float:
    """Where a node collapses, to the accuracy of the solver; inf where it never does."""
    return inf if isnan(outcome.value) else outcome.value


def _polished_value(outcome: Solution) -> float:
    """The same, to round-off."""
    return float(outcome.x[-1]) if outcome.optimal else inf


@dataclass(frozen=True, eq=False, repr=False)
class FirstCollapse(Evidence):
    """What only the first collapse λ_1 has, and how far it is a guarantee.

    The bound is the smallest load factor at which both limits of one node meet. Below it every node keeps a
    range of slips between its two limits, whatever slips within their own limits the other nodes have. At
    λ_1 the range of ``node`` shrinks to a point. It is unbounded where no node's range ever does, infeasible
    where there is no safe slip under the mean load to begin with, although there may be from some load
    factor on (``least_load_factor`` of λ_max).

    Its ``slip`` (n,) is the critical slip state [length]: an initial state that leads to cyclic slip of
    ``node`` above λ_1 in nearly every case. Its ``multipliers`` y (r,) are ≥ 0 in the rows of ``node`` and
    ≤ 0 in the others: yᵀG = 0, yᵀd ≤ 1 (= 1 where λ_1 > 0), yᵀg = λ_1.

    Attributes
    ----------
    known
        The evidence for the guarantee, each part computed when first read.
    node
        The node that collapses; −1 where none does (λ_1 is then λ_max, inf or NaN).
    collapse_limits : (n,)
        Load factors that each node is proved not to collapse below, in floats; 0 where nothing is
        known, inf where it never collapses, NaN where infeasible.
    """

    DOCUMENT: ClassVar[str] = (
        "status load_factor node slip guarantee coupling_ratio "
        "lift_off_bound certified uncertified disputed reduced_accuracy residual pinned"
    )
    TABLE: ClassVar[str] = "slip per_node"

    known: GuaranteeEvidence = field(repr=False, compare=False)
    node: int
    collapse_limits: FloatArray

    @property
    def problem(self) -> Problem:
        """The joint."""
        return self.known.problem

    @cached_property
    def proof(self) -> GuaranteeStatus:
        """How far λ_1 is a guarantee; computed when first read, at several times the cost of λ_1."""
        if isnan(self.known.load_factor):
            reason = "under the mean load alone no slip keeps every node within its friction limits"
            return GuaranteeStatus(Guarantee.EVIDENCE, reason, nan, nan)
        return guarantee_status(self.known)

    @cached_property
    def per_node(self) -> FloatArray:
        """The load factor at which each node collapses (n,); solves a program for each when first read.

        To the accuracy of the solver (1e-10); inf where a node never collapses, NaN where infeasible.
        """
        if self.node < 0:
            return self.collapse_limits
        rows, tolerances = constraints(self.problem), self.known.tolerances
        program = Simplex(certificate.load_factor_program(rows, towards=+1.0, tolerances=tolerances))
        outcomes = collapses(rows, program, collapse_limits(rows), all_nodes=True)
        values = np.array([_solver_value(outcomes[node]) for node in range(rows.n)])
        values[self.node] = self.known.load_factor
        return values

    @property
    def guarantee(self) -> Guarantee:
        """How certain shakedown from every initial state is below λ_1."""
        return self.proof.guarantee

    @property
    def coupling_ratio(self) -> float:
        """ρ, the spectral radius of the slip-to-slip influence; NaN where undefined."""
        return self.proof.coupling_ratio

    @property
    def lift_off_bound(self) -> float:
        """Below this load factor no admissible slip lifts a node off.

        NaN where it was not needed for the guarantee.
        """
        return self.proof.lift_off_bound

    def document(self, bound: Bound) -> dict[str, Any]:
        """The bound as JSON knows it; ``single_node_bound``, not computed any more, is null."""
        reason = "; ".join(filter(None, [bound.reason, self.proof.reason]))
        more = {"kind": "first-collapse", "reason": reason, "single_node_bound": None}
        return super().document(bound) | more

    def remark(self, bound: Bound) -> str:
        """Which node collapses, or why none does."""
        return f"collapse of node {self.problem.node_name(self.node)}" if self.node >= 0 else bound.reason


def of_joint(limits: Any) -> Bound:
    """λ_1 of a joint whose limits are computed (:data:`shakedown.bounds.registry.BOUNDS`)."""
    exact = limits.problem.n <= LOWER_CERTIFIED_UP_TO if limits.certify is None else limits.certify
    return lower_bound(limits.problem, certify=exact, tolerances=limits.tolerances)


@checked
def lower_bound(
    problem: Problem,
    *,
    guarantee: bool = False,
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Bound:
    """The load factor of first collapse λ_1, from one small linear program per node.

    For node j: the smallest λ ≥ 0 at which some slip has both rows of node j
    reversed (≥ g) and every other row kept (≤ g). For two nodes it is the
    thesis's λ_min (5.12); for more it is the first critical load factor that
    lies on the safe region.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    guarantee
        Whether to work out at once how far λ_1 is a guarantee. If not, that is done when
        ``guarantee`` or another part of the proof is first read from the result.
    certify
        Whether to check every node in exact arithmetic; by default where ``guarantee`` is
        asked for and there are at most 40 nodes, so that it is quick.
    tolerances
        The tolerances that decide.

    Raises
    ------
    SolverError
        If a linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> lower = shakedown.lower_bound(shakedown.example("two-node"))
    >>> round(lower.load_factor, 6), lower.node, lower.guarantee.value
    (0.657373, 1, 'proved')
    """
    require_plane("first collapse", problem, NO_SIDES)
    if certify is None:
        certify = guarantee and constraints(problem).n <= LOWER_CERTIFIED_UP_TO
    bound = _first_collapse(problem, certify, tolerances)
    if guarantee:
        _ = bound.proof
    return bound


def _first_collapse(problem: Problem, certify: bool, tolerances: Tolerances) -> Bound:
    rows = constraints(problem)
    program = Simplex(certificate.load_factor_program(rows, towards=+1.0, tolerances=tolerances))
    if not np.all(rows.g > 0):  # else slip zero is safe under the mean load
        start = program.solve()
        excess = rows.relative_excess(rows.slips(start.x[:-1]), 0.0).max() if start.optimal else inf
        if not excess <= tolerances.feasibility:
            return _without_collapse(problem, Status.INFEASIBLE, nan, tolerances)
    limits = collapse_limits(rows)
    outcomes = collapses(rows, program, limits, all_nodes=certify)
    node = first_to_collapse(outcomes)
    found: Certificate | Missing = Missing("")
    if certify:
        exact = attempt(certificate.certified_lower, problem, outcomes, node, tolerances)
        node, found = (node, exact) if isinstance(exact, Missing) else exact
    if not outcomes[node].optimal and isinstance(found, Missing):
        upper = upper_bound(problem, certify=certify, tolerances=tolerances)
        if upper.status == Status.OPTIMAL:
            return _vanishing(problem, upper, tolerances)
        return _without_collapse(problem, Status.UNBOUNDED, inf, tolerances)
    answer = _collapse(problem, node, outcomes, found, limits.load_factors, tolerances)
    # Where the critical slip state satisfies every row, λ_max is no smaller; so it is for a held body.
    safe = rows.relative_excess(answer.slip, answer.load_factor).max() <= tolerances.feasibility
    if rows.pinned and not safe:
        upper = upper_bound(problem, certify=certify, tolerances=tolerances)
        if upper.status == Status.OPTIMAL and upper.load_factor < answer.load_factor:
            return _vanishing(problem, upper, tolerances)
    return answer


def _collapse(
    problem: Problem,
    node: int,
    outcomes: dict[int, Solution],
    found: Certificate | Missing,
    limits: FloatArray,
    tolerances: Tolerances,
) -> Bound:
    rows, outcome = constraints(problem), outcomes[node]
    if isinstance(found, Certificate):
        x = certificate.significant(rows, found.slip, found.load_factor, tolerances)
        x[-1] = found.load_factor
        y = np.where(rows.limits_of(node), 1.0, -1.0) * found.multipliers
        active, certified = np.array(found.rows, dtype=np.intp), (found.low, found.high)
    else:
        x = np.append(rows.slips(outcome.x[:-1]), outcome.x[-1])
        y, active, certified = -outcome.multipliers, outcome.meeting[0], None
    load_factor, excess = float(x[-1]), rows.relative_excess(x[:-1], float(x[-1]))
    return Bound(
        kind="lower",
        status=Status.OPTIMAL,
        load_factor=load_factor,
        evidence=FirstCollapse(GuaranteeEvidence(problem, load_factor, tolerances), node, limits),
        slip=x[:-1],
        reason=_at_the_mean_load(problem, node) if load_factor == 0.0 else "",
        active=rows_named(rows, active),
        multipliers=y,
        residual=float(np.where(rows.limits_of(node), -excess, excess).max()),
        certified=certified,
        uncertified=found.reason if isinstance(found, Missing) else "",
        disputed=isinstance(found, Disputed),
        reduced_accuracy=any(outcome.reduced_accuracy for outcome in outcomes.values()),
        pinned=rows.pinned,
    )


def _vanishing(problem: Problem, upper: Bound, tolerances: Tolerances) -> Bound:
    """The answer where no safe slip is left at λ_max, and no node has lost its range of slips before."""
    same = ["active", "multipliers", "residual", "certified", "uncertified", "disputed", "reduced_accuracy"]
    return _without_collapse(problem, Status.OPTIMAL, upper.load_factor, tolerances).but(
        reason="all safe slips vanish together at λ_max, before any node collapses",
        collapse_limits=np.full(problem.n, inf),
        **{name: getattr(upper, name) for name in same},
    )


def _without_collapse(problem: Problem, status: Status, load_factor: float, tolerances: Tolerances) -> Bound:
    """The answer where no node collapses."""
    known = GuaranteeEvidence(problem, load_factor, tolerances)
    return Bound(
        kind="lower",
        status=status,
        load_factor=load_factor,
        evidence=FirstCollapse(known, -1, np.full(problem.n, load_factor)),
        slip=np.full(problem.n, nan),
        multipliers=np.zeros_like(constraints(problem).g),
        reason="no node ever collapses" if status == Status.UNBOUNDED else "",
        pinned=constraints(problem).pinned,
    )


def _at_the_mean_load(problem: Problem, node: int) -> str:
    """Why a node collapses at λ = 0."""
    named = f"node {problem.node_name(node)}"
    if problem.f[node] == 0:
        return f"{named} has no friction: it slips with every load"
    return f"some locked-in slip lifts {named} off, under the mean load alone"
