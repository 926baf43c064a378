"""Lower bound of the load factor: the first collapse of a node's range of slips."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, nan
from typing import Any, ClassVar

import numpy as np

from shakedown.bounds.certificate import (
    LOWER_CERTIFIED_UP_TO,
    Certificate,
    Disputed,
    certified_lower,
    significant,
)
from shakedown.bounds.collapse.collapse_programs import (
    collapse_excess,
    collapse_limits,
    collapse_values,
    collapses,
    first_to_collapse,
    mean_load_is_safe,
)
from shakedown.bounds.collapse.proof_status import Evidence, GuaranteeStatus, guarantee_status
from shakedown.bounds.results import UNSAFE_MEAN, UpperBound
from shakedown.bounds.row_programs import load_factor_program
from shakedown.bounds.upper import upper_bound
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Guarantee, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, require_plane
from shakedown.joint.constraints import constraints, rows_named
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.program import Solution
from shakedown.programs.simplex import Simplex


@dataclass(frozen=True, eq=False, repr=False)
class LowerBound(Result):
    """First collapse λ_1: the smallest load factor at which both limits of one node meet.

    Below λ_1 every node keeps a range of slips between its two limits, whatever
    slips within their own limits the other nodes have. At λ_1 the range of
    ``node`` shrinks to a point.

    Attributes
    ----------
    problem
        The joint.
    status
        Optimal; unbounded (no node's range ever shrinks to a point); infeasible
        (there is no safe slip under the mean load to begin with, although there may be
        from some load factor on: ``UpperBound.least_load_factor``).
    load_factor
        λ_1; inf where unbounded, NaN where infeasible.
    node
        The node that collapses; −1 where none does (λ_1 is then λ_max, inf or NaN).
    slip : (n,)
        The critical slip state [length] (``"witness"``): an initial state that leads to cyclic slip of
        ``node`` above λ_1 in nearly every case; NaN unless optimal.
    collapse_limits : (n,)
        Load factors that each node is proved not to collapse below, in floats; 0 where nothing is
        known, inf where it never collapses, NaN where infeasible.
    active
        (node, side) of the rows that determine it.
    multipliers : (r,)
        y, ≥ 0 in the rows of ``node`` and ≤ 0 in the others, that prove the value:
        yᵀG = 0, yᵀd ≤ 1 (= 1 where λ_1 > 0), yᵀg = λ_1.
    residual
        Largest relative violation of the rows at ``slip``.
    certified
        (low, high), neighbouring floats that contain the exact λ_1 of the problem as
        stored, or None.
    uncertified
        Why there is no certificate although it was asked for; else empty.
    disputed
        Whether exact arithmetic on the stored digits contradicts the number by more than the data allow.
    reduced_accuracy
        Whether a linear program ended only at loosened tolerances (1e-7).
    tolerances
        The tolerances that decided.
    kind
        What the number is: ``"first-collapse"``.
    pinned
        Where the joint can move as a whole: the nodes that slips are given relative to, their own being 0.
    """

    DOCUMENT: ClassVar[str] = (
        "status load_factor node slip kind guarantee reason coupling_ratio "
        "lift_off_bound certified uncertified disputed reduced_accuracy residual pinned"
    )
    TABLE: ClassVar[str] = "slip per_node"

    problem: Problem = field(repr=False)
    status: Status
    load_factor: float
    node: int
    slip: FloatArray
    collapse_limits: FloatArray
    active: tuple[tuple[int, int], ...]
    multipliers: FloatArray
    residual: float
    certified: tuple[float, float] | None = None
    uncertified: str = ""
    disputed: bool = False
    reduced_accuracy: bool = False
    tolerances: Tolerances = field(default=DEFAULT, repr=False)
    kind: str = "first-collapse"
    pinned: tuple[int, ...] = ()

    @cached_property
    def proof(self) -> GuaranteeStatus:
        """How far λ_1 is a guarantee; computed when first read, at several times the cost of λ_1."""
        if self.status == Status.INFEASIBLE:
            return GuaranteeStatus(Guarantee.EVIDENCE, UNSAFE_MEAN, nan, nan)
        return guarantee_status(self.evidence)

    @cached_property
    def evidence(self) -> Evidence:
        """The evidence for the guarantee, each part computed when first read."""
        return Evidence(self.problem, self.load_factor, self.tolerances)

    @cached_property
    def per_node(self) -> FloatArray:
        """The load factor at which each node collapses (n,); solves a program for each when first read.

        To the accuracy of the solver (1e-10); inf where a node never collapses, NaN where infeasible.
        """
        if self.node < 0:
            return self.collapse_limits
        rows = constraints(self.problem)
        program = Simplex(load_factor_program(rows, towards=+1.0, tolerances=self.tolerances), dense=False)
        values = collapse_values(rows.n, collapses(rows, program, collapse_limits(rows), all_nodes=True))
        values[self.node] = self.load_factor
        return values

    @property
    def guarantee(self) -> Guarantee:
        """How certain shakedown from every initial state is below λ_1."""
        return self.proof.guarantee

    @property
    def reason(self) -> str:
        """The status of the guarantee, and why λ_1 is 0 where it is, in words."""
        why = self.why()
        return f"{why}; {self.proof.reason}" if why else self.proof.reason

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

    def to_dict(self) -> dict[str, Any]:
        """The JSON document; ``single_node_bound``, not computed any more, stays as null for one version."""
        return super().to_dict() | {"single_node_bound": None}

    def why(self) -> str:
        """Why there is no node that collapses, or why it does at the mean load; empty elsewhere."""
        if self.status == Status.UNBOUNDED:
            return "no node ever collapses"
        if self.status == Status.OPTIMAL and self.node < 0:
            return "all safe slips vanish together at λ_max, before any node collapses"
        if self.load_factor != 0:
            return ""
        node = f"node {self.problem.node_name(self.node)}"
        if self.problem.f[self.node] == 0:
            return f"{node} has no friction: it slips with every load"
        return f"some locked-in slip lifts {node} off, under the mean load alone"


@checked
def lower_bound(
    problem: Problem,
    *,
    guarantee: bool = False,
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> LowerBound:
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


def _first_collapse(problem: Problem, certify: bool, tolerances: Tolerances) -> LowerBound:
    rows = constraints(problem)
    program = Simplex(load_factor_program(rows, towards=+1.0, tolerances=tolerances), dense=False)
    if not mean_load_is_safe(problem, rows, program, certify, tolerances):
        return _without_collapse(problem, Status.INFEASIBLE, nan, tolerances)
    limits = collapse_limits(rows)
    outcomes = collapses(rows, program, limits, all_nodes=certify)
    node = first_to_collapse(outcomes)
    found: Certificate | Missing = Missing("")
    if certify:
        exact = sought(certified_lower, problem, outcomes, node, tolerances)
        node, found = (node, exact) if isinstance(exact, Missing) else exact
    if not outcomes[node].optimal and isinstance(found, Missing):
        upper = upper_bound(problem, certify=certify, tolerances=tolerances)
        if upper.status == Status.OPTIMAL:
            return _vanishing(problem, upper, tolerances)
        return _without_collapse(problem, Status.UNBOUNDED, inf, tolerances)
    answer = replace(
        _collapse(problem, node, outcomes, found, tolerances), collapse_limits=limits.load_factors
    )
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
    tolerances: Tolerances,
) -> LowerBound:
    rows, outcome = constraints(problem), outcomes[node]
    if isinstance(found, Certificate):
        x = significant(rows, found.slip, found.load_factor, tolerances)
        x[-1] = found.load_factor
        y = np.where(rows.limits_of(node), 1.0, -1.0) * found.multipliers
        active, certified = np.array(found.rows, dtype=np.intp), (found.low, found.high)
    else:
        x = np.append(rows.slips(outcome.x[:-1]), outcome.x[-1])
        y, active, certified = -outcome.multipliers, outcome.meeting[0], None
    return LowerBound(
        problem=problem,
        status=Status.OPTIMAL,
        load_factor=float(x[-1]),
        node=node,
        slip=x[:-1],
        collapse_limits=np.zeros(rows.n),
        active=rows_named(rows, active),
        multipliers=y,
        residual=collapse_excess(rows, node, x),
        certified=certified,
        uncertified=found.reason if isinstance(found, Missing) else "",
        disputed=isinstance(found, Disputed),
        reduced_accuracy=any(outcome.reduced_accuracy for outcome in outcomes.values()),
        tolerances=tolerances,
        pinned=rows.pinned,
    )


def _vanishing(problem: Problem, upper: UpperBound, tolerances: Tolerances) -> LowerBound:
    """The answer where no safe slip is left at λ_max, and no node has lost its range of slips before."""
    return replace(
        _without_collapse(problem, Status.OPTIMAL, upper.load_factor, tolerances),
        collapse_limits=np.full(problem.n, inf),
        active=upper.active,
        multipliers=upper.multipliers,
        residual=upper.residual,
        certified=upper.certified,
        uncertified=upper.uncertified,
        disputed=upper.disputed,
        reduced_accuracy=upper.reduced_accuracy,
    )


def _without_collapse(
    problem: Problem, status: Status, load_factor: float, tolerances: Tolerances
) -> LowerBound:
    """The answer where no node collapses."""
    return LowerBound(
        problem=problem,
        status=status,
        load_factor=load_factor,
        node=-1,
        slip=np.full(problem.n, nan),
        collapse_limits=np.full(problem.n, load_factor),
        active=(),
        multipliers=np.zeros_like(constraints(problem).g),
        residual=nan,
        tolerances=tolerances,
        pinned=constraints(problem).pinned,
    )
