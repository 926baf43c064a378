"""How far the first collapse is a guarantee of shakedown from every initial state.

Notation: with the other slips fixed, node i stays within its extreme rows for
L_i ≤ v_i ≤ U_i (both affine in the other slips); it is *closed in* if L_i ≤ U_i and
*collapsed* if U_i ≤ L_i. λ_1 is the smallest λ at which some v has one node
between U_j and L_j, collapsed, and every other within its rows. A motion is taken
with all nodes closed (that no node can lift off is checked apart, ``lift_off``).

**Nothing collapses below λ_1.** Let every principal minor of A + S f B be positive
for all signs S (in particular ρ < 1). Then for every τ in [0, 1]ⁿ the equations
v_i = (1 − τ_i) U_i + τ_i L_i have one solution v(τ), continuous in τ and λ: the
determinant is multilinear in τ and positive at the corners. Every v in which each
node lies between its two limits, in either order, is such a v(τ). The set of
(τ, λ), λ < λ_1, where all U_i > L_i is open; it is also closed, because where the
first U_i = L_i, the other nodes are within their rows and λ ≥ λ_1. As it contains
λ = 0 (there is a safe state under the mean load and λ_1 > 0), it is everything:
for λ < λ_1 there is no v with all nodes between their limits and one collapsed. (*)

**Motions are bounded.** A v with G v ≤ 0 lies between the limits of the rows without
load, so it is their v(τ), which is 0: at every instant the admissible slips are bounded.

**Weak coupling, ρ ≤ 1/3.** Let a_i and b_i be the lower and upper limit of v_i(t)
as t → ∞, r_i = (b_i − a_i)/2, c_i the midpoints, d > 0 with
N d ≤ ρ d, and j the node with the largest R = r_j/d_j. If R > 0, node j slips
backward down to a_j and forward up to b_j for ever, so that U_j ≤ a_j and L_j ≥ b_j
for slips of the others in the box; moving them to c changes either by at most
ρ R d_j, so U_j(c) ≤ c_j − R d_j (1 − ρ), and L_j(c) likewise. Every other node i meets
each row at the instant when that row is extreme, somewhere in the box: at c it
violates it by at most R d_i (1 + ρ). Let v_j = c_j and let every other v_i be c_i
clipped to its two limits at v (a contraction): then |v_i − c_i| ≤ s_i with
s ≤ R (1 + ρ) d + N s, s ≤ R d (1 + ρ)/(1 − ρ). This moves U_j by at most
ρ R d_j (1 + ρ)/(1 − ρ), which is no more than R d_j (1 − ρ) as long as
(1 − ρ)² ≥ ρ (1 + ρ), that is ρ ≤ 1/3. Then all nodes lie between their limits and j
is collapsed, against (*). So R = 0: every slip converges.

**One node alone, ρ < 1.** If only node j moves, U_j ≤ a_j, L_j ≥ b_j hold at c itself,
the other nodes violate their rows by at most N_ij r_j there, the correction is at
most ρ R d_i and moves U_j by less than r_j: the same contradiction.

**Two nodes, positive minors** (thesis §4.4, argued there by pictures). Let only node 1
move: v_1 in [a_1, b_1] is collapsed throughout, so by (*) it stays above, or below, both
limits of node 2, against node 2's rows at their extremes. Let both move: v_1 is
lowest at some v_2 = y_a and highest at y_b, v_2 lowest at some v_1 = x_a and highest at
x_b. In the rectangle between them, node 1's rows say v_1 ≥ U_1 all along y_a and
v_1 ≤ L_1 all along y_b, so the points with v_1 between its limits join the other two
sides; likewise for v_2. The two sets meet in a point u, by (*) a safe one. Write U_1 =
const − x₊ v_2, L_1 = const − x₋ v_2, and y± for node 2. If y_a < y_b, comparing u with
(u_1, y_a) and (u_1, y_b) gives x± ≤ 0, else x± ≥ 0; likewise y± ≤ 0 where x_a < x_b, else
y± ≥ 0. As A is symmetric, x± and y± cannot have opposite signs unless they vanish; with equal
signs, comparing u with the corner (x_a, y_a) gives x₊ y₊ ≥ 1, against the minor
1 − x₊ y₊ > 0; and if y_a = y_b, node 1 is collapsed where node 2 is between its limits.
"""

from dataclasses import dataclass
from math import isnan, nan

from shakedown.bounds.coupling import Coupling, coupling
from shakedown.bounds.lift_off import lift_off_bound
from shakedown.bounds.single_node_cycle import single_node_cycle
from shakedown.model.problem import Problem
from shakedown.tolerances import DEFAULT
from shakedown.uniqueness.in_contact import unique_in_contact

WEAK = 1.0 / 3.0


@dataclass(frozen=True)
class GuaranteeStatus:
    """Status of the guarantee below the first collapse, with the evidence.

    Attributes
    ----------
    guarantee
        ``"proved"``: below λ_1 the system shakes down from every initial state with
        all nodes closed. ``"single-node-excluded"``: no node alone can slip
        cyclically. ``"evidence"``: nothing is proved.
    reason
        Why, in words.
    coupling_ratio
        ρ; NaN where a node is at or above its own critical friction.
    single_node_bound
        Load factor below which no node alone can slip cyclically; NaN where not computed.
    lift_off_bound
        Load factor below which no admissible slip lifts a node off; NaN where not computed.
    """

    guarantee: str
    reason: str
    coupling_ratio: float
    single_node_bound: float
    lift_off_bound: float


def guarantee_status(problem: Problem, load_factor: float) -> GuaranteeStatus:
    """What is proved about shakedown from every initial state below the first collapse.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    load_factor
        Its first collapse λ_1.

    Examples
    --------
    >>> import shakedown
    >>> status = guarantee_status(shakedown.example("three-node"), 3.096)
    >>> status.guarantee, round(status.coupling_ratio, 3), round(status.single_node_bound, 4)
    ('evidence', 1.342, 2.4442)
    """
    influence, alone = coupling(problem), single_node_cycle(problem).load_factor
    if not problem.B.any():
        reason = "no coupling (B = 0): Melan's theorem holds, both bounds coincide"
        return GuaranteeStatus("proved", reason, influence.ratio, alone, nan)
    if load_factor == 0.0:
        return GuaranteeStatus("evidence", "there is nothing to guarantee", influence.ratio, alone, nan)
    argument = _argument(problem, influence)
    if argument:
        stays_closed = lift_off_bound(problem, enough=load_factor)
        if stays_closed >= load_factor:
            return GuaranteeStatus("proved", argument, influence.ratio, alone, stays_closed)
        caveat = (
            f"{argument}, but from the load factor {stays_closed:.6g} on locked-in slip can lift a node off"
        )
        return GuaranteeStatus("single-node-excluded", caveat, influence.ratio, alone, stays_closed)
    return _without_proof(load_factor, influence, alone)


def _argument(problem: Problem, influence: Coupling) -> str:
    """The proof that holds while all nodes are closed, in words; empty where there is none."""
    if problem.n <= 2 and unique_in_contact(problem):
        return f"{'one node' if problem.n == 1 else 'two nodes'} below the friction thresholds (thesis §4.4)"
    if influence.bound <= WEAK:
        return f"weak coupling, ratio {influence.ratio:.3g} <= 1/3"
    return ""


def _without_proof(load_factor: float, influence: Coupling, alone: float) -> GuaranteeStatus:
    """No proof: at most, cycles of one node alone are excluded."""
    status, ratio = "evidence", influence.ratio
    if influence.bound < 1.0:
        status, reason = "single-node-excluded", f"coupling ratio {ratio:.3g} < 1: no node can cycle alone"
    elif alone >= load_factor * (1 - DEFAULT.feasibility):
        status, reason = "single-node-excluded", f"no node can cycle alone below {alone:.6g}"
    elif isnan(ratio):
        reason = "a node is at or above its own critical friction: there is no proof, only simulation"
    elif isnan(alone):
        reason = f"strong coupling, ratio {ratio:.3g}: there is no proof, only simulation"
    else:
        reason = f"strong coupling, ratio {ratio:.3g}: a node may cycle alone from {alone:.6g} on"
    return GuaranteeStatus(status, reason, ratio, alone, nan)
