"""How far the first collapse is a guarantee of shakedown from every initial state.

The proofs are Theorems 1 to 6 of docs/guarantee.md. In short: where the coupling ratio ρ* is below 1
every motion below λ_1 comes to rest (Theorem 3), for any number of nodes; also where no slip raises a
measure of the differences between nodes (4), as of many bodies that friction alone holds; for two nodes
wherever the motion is unique (5).
That no node lifts off is checked apart (6, ``lift_off_bound``). All of it follows one loop in its
order: of a load domain nothing is proved here unless slip changes no pressure.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, isnan, nan
from typing import NamedTuple

import numpy as np

from shakedown.bounds.coupling import Uniqueness, coupling, difference_gauge, unique_in_contact
from shakedown.ground.constants import NEGLIGIBLE
from shakedown.ground.errors import Missing, attempt
from shakedown.ground.shown_values import up
from shakedown.ground.status import Guarantee
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import constraints, step_loads
from shakedown.joint.contact_zone import coupled_parts
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import INF, Program
from shakedown.programs.simplex import Simplex


def lift_off_bound(problem: Problem, *, tolerances: Tolerances = DEFAULT) -> float:
    """A load factor below which all nodes stay closed, whatever admissible slips they have.

    A closed node j lifts off where both its limits are met at once, p = q = 0,
    while every other node is within its limits *of that instant*. The smallest
    load factor at which that is possible is a linear program in v and the load r⁰ + Σ α_k r_k, α ≥ 0,
    anywhere in the convex hull of the loop: the least Σ α, one program per node.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    tolerances
        The tolerances of the programs.

    Returns
    -------
        The load factor; inf where no load factor lifts any node.

    Examples
    --------
    >>> import shakedown
    >>> lift_off_bound(shakedown.example("two-node")) >= 0.6574
    True
    """
    rows, corners = constraints(problem), step_loads(problem)
    # a load that is round-off of the others would be scaled up to them, and its cost above theirs
    size = np.maximum(np.abs(rows.g), np.abs(corners).max(axis=0))
    corners = corners[(np.abs(corners) > NEGLIGIBLE * size).any(axis=1)]
    program = Simplex(
        Program(
            np.column_stack([rows.coefficients, corners.T]),
            rows.g,
            cost=np.append(np.zeros(rows.n), np.ones(len(corners))),
            lower=np.append(np.full(rows.n, -INF), np.zeros(len(corners))),
            tolerances=tolerances,
        )
    )
    first = inf
    for node in range(problem.n):
        own = np.flatnonzero(rows.node == node)
        free = np.full(len(own), INF)
        program.set_rows(own, rows.g[own], free)
        found = program.solve()
        program.set_rows(own, -free, rows.g[own])
        if found.optimal:
            first = min(first, float(found.x[rows.n :].sum()))
    return first


ANY_ORDER = (
    "the load steps are the corners of a load domain, and λ_1 is about a loop that returns to each of them "
    "in every period: what is proved of every path is λ_U"
)


@dataclass(frozen=True, eq=False, repr=False)
class GuaranteeStatus(Result):
    """Status of the guarantee below the first collapse, with the evidence.

    Attributes
    ----------
    guarantee
        Proved or evidence (:class:`Guarantee`).
    reason
        Why, in words.
    coupling_ratio
        ρ*; NaN where a node is at or above its own critical friction.
    lift_off_bound
        Load factor below which no admissible slip lifts a node off; NaN where not computed.
    """

    guarantee: Guarantee
    reason: str
    coupling_ratio: float
    lift_off_bound: float


class Argument(NamedTuple):
    """A proof that holds up to the first collapse.

    Attributes
    ----------
    name, reason
        What it is called, and why it applies.
    keeps_closed
        Whether no node can lift off below the first collapse either.
    drift_bound
        Below it a body that friction alone holds cannot drift; inf where something else holds it.
    """

    name: str
    reason: str
    keeps_closed: bool = False
    drift_bound: float = inf


class GuaranteeEvidence:
    """The evidence for the guarantee of a first collapse, each part computed once, when first read.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    load_factor
        Its first collapse λ_1.
    tolerances
        A bound that misses λ_1 by no more than ``feasibility`` reaches it: the claim is
        about load factors below λ_1.
    """

    def __init__(self, problem: Problem, load_factor: float, tolerances: Tolerances = DEFAULT) -> None:
        self.problem, self.load_factor, self.tolerances = problem, load_factor, tolerances

    @cached_property
    def argument(self) -> Argument | None:
        """The proof that every state shakes down up to λ_1 while all nodes stay closed; None without one.

        Without coupling it holds for every path inside a load domain; the others follow a loop.
        """
        problem = self.problem
        if not problem.B.any():
            reason = "no coupling (B = 0): Melan's theorem holds, both bounds coincide"
            return Argument("Melan", reason, keeps_closed=True)
        if problem.is_domain:
            return None
        ratio, bound = coupling(problem).ratio, coupling(problem).bound
        if bound < 1.0:
            reason = f"coupling ratio {ratio:.4g} below 1: the first collapse is the limit"
            return Argument("first collapse", reason)
        if problem.n == 2 and self.unique:
            return Argument("two nodes", "two nodes below the friction thresholds (thesis §4.4)")
        if difference_gauge(problem) is not None:
            drift_bound = _drift_bound(problem) if rigid_slips(problem).pinned else inf
            reason = "no slip raises the differences between the nodes: the first collapse is the limit"
            return Argument("differences", reason, drift_bound=drift_bound)
        return None

    @cached_property
    def unique(self) -> Uniqueness | Missing:
        """Whether the motion in contact is unique."""
        return attempt(unique_in_contact, self.problem, tolerances=self.tolerances)

    @cached_property
    def lift_off(self) -> float | Missing:
        """Below this load factor no admissible slip lifts a node off."""
        return attempt(lift_off_bound, self.problem, tolerances=self.tolerances)


def guarantee_status(known: GuaranteeEvidence) -> GuaranteeStatus:
    """Whether shakedown from every initial state is proved below the first collapse.

    Examples
    --------
    >>> import shakedown
    >>> status = guarantee_status(GuaranteeEvidence(shakedown.example("three-node"), 3.096))
    >>> status.guarantee.value, round(status.coupling_ratio, 3)
    ('evidence', 1.039)
    """
    parts = coupled_parts(known.problem)
    if len(parts) > 1:
        found = [
            guarantee_status(GuaranteeEvidence(p.joint, known.load_factor, known.tolerances)) for p in parts
        ]
        worst = max(range(len(parts)), key=lambda k: list(Guarantee).index(found[k].guarantee))
        return replace(
            found[worst],
            reason=parts[worst].renumbered(found[worst].reason),
            coupling_ratio=float(np.max([each.coupling_ratio for each in found])),
            lift_off_bound=float(np.fmin.reduce([each.lift_off_bound for each in found])),
        )
    load_factor, ratio, argument = known.load_factor, coupling(known.problem).ratio, known.argument
    if known.problem.is_domain and load_factor > 0.0:
        return GuaranteeStatus(Guarantee.EVIDENCE, ANY_ORDER, ratio, nan)
    if argument is not None and argument.keeps_closed:
        return GuaranteeStatus(Guarantee.PROVED, argument.reason, ratio, nan)
    if load_factor == 0.0:
        return GuaranteeStatus(Guarantee.EVIDENCE, "there is no load factor below it", ratio, nan)
    reached = load_factor * (1 - known.tolerances.feasibility)
    if argument is None or argument.drift_bound < reached:
        why = f"coupling ratio {ratio:.4g}, not below 1"
        if isnan(ratio):
            why = "a node is at or above its own critical friction"
        return GuaranteeStatus(Guarantee.EVIDENCE, f"{why}: there is no proof, only simulation", ratio, nan)
    stays_closed = known.lift_off
    if isinstance(stays_closed, Missing):
        caveat = f"{argument.reason}, but the lift-off bound is missing: {stays_closed.reason}"
        return GuaranteeStatus(Guarantee.EVIDENCE, caveat, ratio, nan)
    if stays_closed >= reached:
        return GuaranteeStatus(Guarantee.PROVED, argument.reason, ratio, stays_closed)
    caveat = f"from the load factor {up(stays_closed)} on locked-in slip can lift a node off"
    return GuaranteeStatus(Guarantee.EVIDENCE, f"{argument.reason}, but {caveat}", ratio, stays_closed)


def _drift_bound(problem: Problem) -> float:
    """Load factor at which a floating body may reach all limits of one side at once, λ_w.

    With y (A ∓ f B) = 0 and y > 0 the slips drop out of y · (g − G v − λ d): it vanishes where all these
    limits are reached. One side is that of one direction of the rigid slip, so it is the other limit of nodes
    whose own slip is counted the other way round.
    """
    rows, bounds = constraints(problem), [inf]
    turned = rigid_slips(problem).motions[:, 0] < 0.0
    for side in (0, 1):
        chosen = 2 * np.arange(problem.n) + np.where(turned, 1 - side, side)
        y = np.linalg.svd(rows.G[chosen])[0][:, -1]
        y = y * np.sign(y.sum())
        slack, load = float(y @ rows.g[chosen]), float(y @ rows.d[chosen])
        if not (np.all(y > 0.0) and slack > 0.0):
            return 0.0
        bounds.append(slack / load if load > 0.0 else inf)
    return min(bounds)
