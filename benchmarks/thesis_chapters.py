"""Chapters II to V and VII of the thesis, line by line; chapter VI and appendix A have their own module."""

import numpy as np

import shakedown
from benchmarks.corner_report import pair_thresholds
from benchmarks.receding import cycles, zones
from benchmarks.thesis_entry import Entry, entry
from shakedown import Problem
from shakedown.bounds.critical import subset_count
from shakedown.ground.constants import FloatArray
from shakedown.motion.evolution import evolve

REFINEMENT = 12  # of the receding block: 97 nodes on the half
OTHER_BLOCK = "another block"


def chapter_2() -> list[Entry]:
    """The discrete system and its time integration."""
    return [
        entry("(2.3)–(2.9)", "Coulomb's law, node by node", "shakedown.joint.law.Law"),
        entry(
            "(2.10), (2.11)",
            "the discrete system",
            "shakedown.Problem shakedown.motion.checked_law.reactions",
        ),
        entry(
            "(2.15), fig. 2.2",
            "Gauss–Seidel at fixed load steps (method 'gauss-seidel')",
            "shakedown.simulate",
        ),
    ]


def chapter_3() -> list[Entry]:
    """Receding contact: words and drawings, two numbers; on 97 nodes of the half, plane strain."""
    row, found = cycles(REFINEMENT), zones(REFINEMENT)
    left = [0.0 if found[key] < 1e-12 else found[key] for key in ("slip_left", "gap_left")]  # round-off
    exponents = [row["exponents"][window] for window in ("5-20", "10-40")]
    study = "benchmarks.receding.zones"
    return [
        entry("3.2, fig. 3.1", "block h × 4h, loaded on 2h, f = 0.35, ν = 0.3", "benchmarks.bodies.blocks.receding_block"),
        entry(
            "fig. 3.2", "nodes whose zone changes during the first loading", study, "0",
            found["first_loading_changes"], figure="receding-histories",
        ),
        entry(
            "fig. 3.3", "unloading to zero: what is left of slips, of gaps", study, "0 0", left,
            "0 to within round-off", "receding-histories",
        ),
        entry(
            "fig. 3.4", "tractions at p_max/3, in unloading",
            "shakedown.plot.pressure shakedown.plot.friction_use", figure="receding-unloaded",
        ),
        entry(
            "fig. 3.5", "ninth cycle: of the inner nodes that slip in unloading, those that slip again in "
            "the first nine tenths of the reloading", study, "0", found["ninth_inner_slipping_early"],
            figure="receding-histories",
        ),
        entry(
            "fig. 3.6", "slip increment ~ N^s, N the cycle: s over N = 5–20 and 10–40",
            "benchmarks.receding.cycles", "-3.1 -3.1", exponents, figure="receding-cycles",
        ),
        entry(
            "fig. 3.7", "nodes that slip in the first cycle, in the steady state; nodes then at the limit without slip",
            "shakedown.plot.zones",
            computed=[found["first_slipping"], found["steady_slipping"], found["steady_at_limit"]],
            figure="receding-histories",
        ),
        entry(
            "fig. 3.8", "dissipation, steady over first cycle", "benchmarks.receding.cycles", "0.56",
            row["dissipation_ratio"], figure="receding-cycles",
        ),
    ]  # fmt: skip


def chapter_4() -> list[Entry]:
    """One and two nodes in contact. Nothing printed is at hand; the numbers are the two-node system's."""
    joint = shakedown.example("two-node")
    limits = shakedown.friction_thresholds(joint)
    pair = pair_thresholds(joint)[::2]  # each has its negative
    transient = shakedown.transient_limit(joint, accuracy=1e-8)
    return [
        entry(
            "(4.1)", "threshold of single nodes, A_jj/|B_jj|", "shakedown.friction_thresholds",
            computed=limits.single_node,
        ),
        entry("figs 4.2–4.9", "load of one node, with its stick sector", "shakedown.plot.reaction_space"),
        entry(
            "(4.14)–(4.17)", "the second node in the plane of the first one's reactions: M = L₂L₁⁻¹",
            "benchmarks.thesis_chapters.reaction_map", computed=reaction_map(joint),
            figure="planes-reactions",
        ),
        entry(
            "figs 4.13–4.15", "slip space, extreme limits", "shakedown.plot.slip_space",
            figure="planes-slip",
        ),
        entry("(4.18)", "transient load steps", "shakedown.Problem"),
        entry(
            "(4.23)", "thresholds of two nodes, the real ones", "benchmarks.corner_report.pair_thresholds",
            computed=pair[np.isfinite(pair)],
        ),
        entry("(4.21), (4.24)", "extremal constraints", "shakedown.joint.constraints"),
        entry(
            "4.3.2", "wedging, |A v| ≤ f B v (marked), least f", "shakedown.bounds.friction_thresholds.Wedging",
            computed=limits.wedging.value, figure="planes-wedging",
        ),
        entry(
            "4.3.5", "load factor up to which a given history shakes down, from zero slip", "shakedown.transient_limit",
            computed=transient.load_factor,
        ),
        entry("4.4", "proof for two nodes", "shakedown.lower_bound"),
        entry("4.4.4", "convergence to the limit as a geometric series", "shakedown.long_term_state"),
    ]  # fmt: skip


def reaction_map(problem: Problem) -> FloatArray:
    """M = L₂ L₁⁻¹ of a two-node joint: changes of node 0's (q, p) to those of node 1's (4.14)–(4.17).

    The reactions of node j are r_j = r_w,j + L_j v with L_j = [A_j; B_j].
    """
    first, second = (np.stack([problem.A[j], problem.B[j]]) for j in (0, 1))
    return np.linalg.solve(first.T, second.T).T


def chapter_5() -> list[Entry]:
    """Load factors: the two-node system, and the nine-node block."""
    return [*_definitions(), *_two_nodes(), *_nine_nodes()]


def _definitions() -> list[Entry]:
    return [
        entry(
            "(5.3)–(5.7)", "extremal constraints in slip and load factor",
            "shakedown.joint.constraints",
        ),
        entry(
            "figs 5.1–5.3", "extreme points of the reaction loop", "shakedown.joint.constraints",
            figure="planes-extreme-points",
        ),
        entry("(5.8), (5.10)", "edges of the constraints", "shakedown.joint.constraints.Constraints"),
        entry("(5.11), (5.12)", "critical load factors", "shakedown.critical_load_factors"),
        entry("(5.16)", "λ_max by a linear program", "shakedown.upper_bound"),
    ]  # fmt: skip


def _two_nodes() -> list[Entry]:
    joint = shakedown.example("two-node")
    bounds = shakedown.shakedown_bounds(joint)
    factors = shakedown.critical_load_factors(joint, values=True).load_factors
    return [
        entry(
            "5.3.1, 5.3.2", "the four critical load factors, with fifty load steps",
            "shakedown.critical_load_factors", "0.6574 0.7391 1.0525 2.9349", factors,
        ),
        entry("5.3.2", "λ_min, here λ_1", "shakedown.lower_bound", "0.6574", bounds.lower.load_factor),
        entry("5.3.2", "λ_max", "shakedown.upper_bound", "0.7391", bounds.upper.load_factor),
        entry(
            "fig. 5.4", "slip space at these load factors", "shakedown.plot.slip_space", figure="planes-slip"
        ),
    ]  # fmt: skip


def _nine_nodes() -> list[Entry]:
    block = shakedown.example("cantilevered-block")
    critical, upper = shakedown.critical_load_factors(block), shakedown.upper_bound(block)
    safe = float(tenth_cycle(block, upper.slip).max())
    least = 1e-9 * np.abs(upper.slip).max()  # less is round-off
    return [
        entry("5.4, figs 5.5, 5.6", "cantilevered block h × 4.5h", "benchmarks.bodies.blocks.cantilevered_block"),
        entry("5.4", "nine nodes: subsets of 10 of the 18 constraints", "shakedown.bounds.critical.subset_count", "43758", subset_count(9)),
        entry(
            "5.4", "λ_min", "shakedown.critical_load_factors", "0.0013",
            critical.smallest_positive.load_factor, OTHER_BLOCK,
        ),
        entry("5.4", "λ_max", "shakedown.upper_bound", "1.0821", upper.load_factor, OTHER_BLOCK),
        entry(
            "fig. 5.7", "reaction loops of nodes 1 and 9 with their extreme points", "shakedown.joint.constraints",
            figure="planes-block-loops",
        ),
        entry(
            "fig. 5.8", "largest slip in the tenth cycle at λ_max from the safe slip: none (here none "
            "from zero slip either; from the critical slip state it does slip)", "shakedown.motion.evolution", "0",
            safe if safe > least else 0.0, OTHER_BLOCK, "planes-tenth-cycle",
        ),
    ]  # fmt: skip


def tenth_cycle(problem: Problem, start: FloatArray) -> FloatArray:
    """Σ|Δv| of every node in the tenth cycle at λ_max."""
    load_factor = shakedown.upper_bound(problem).load_factor
    return evolve(problem, load_factor, start, cycles=10).cycles[-1].slip


def conjectures() -> list[Entry]:
    """What the thesis leaves open or conjectures, and what became of it."""
    joint = shakedown.example("two-node")
    run = shakedown.simulate(joint, 1.16549, [1.986, 1.706])
    return [
        entry(
            "3.3.2", "dissipation never rises from cycle to cycle: false. Two-node system, λ = 1.16549, "
            "from v = (1.986, 1.706), second and third cycle", "shakedown.simulate",
            computed=run.cycles.dissipation[1:3],
        ),
        entry(
            "4.4, extended to n ≥ 3", "no cyclic slip below the first collapse: false. Three-node system: "
            "λ_1, and a load factor with cyclic slip", "shakedown.lower_bound shakedown.simulate",
            computed=_below_collapse(),
        ),
        entry(
            "7.2.1", "final state from the initial one: followed, not predicted",
            "shakedown.simulate shakedown.long_term_state",
        ),
        entry(
            "7.2.2", "one limit cycle: false (Andersson, Barber and Ahn 2013); states with periods of "
            "several cycles are found", "shakedown.LongTermState",
        ),
    ]  # fmt: skip


def _below_collapse() -> list[float]:
    """λ_1 of the three-node system, and 1.01 times the load factor from which node 0 cycles below it."""
    joint, load_factor = shakedown.example("three-node"), 1.01 * 2.4442
    if shakedown.simulate(joint, load_factor, joint.initial_slip[0]).outcome != "cyclic-slip":
        raise RuntimeError(f"three-node: expected cyclic slip at {load_factor}")
    return [shakedown.lower_bound(joint).load_factor, load_factor]
