"""Chapter VI and appendix A of the thesis, line by line."""

import numpy as np

import shakedown
from benchmarks.corner_report import CornerEnd, CornerReport, corner_report, pair_thresholds
from benchmarks.thesis_entry import Entry, entry
from shakedown import Problem
from shakedown.motion.evolution import evolve


def chapter_6() -> list[Entry]:
    """Two nodes at their limits: (6.45)–(6.60), as printed and as computed."""
    joint = shakedown.example("jump")
    report = corner_report(joint, joint.q_w[0], joint.p_w[0])
    return [*_equations(joint, report), *_thresholds(joint), *_corner(report), *_end(joint, report.end)]


def _equations(joint: Problem, report: CornerReport) -> list[Entry]:
    return [
        entry(
            "(6.4)–(6.10)", "determinants of two slipping nodes; uniqueness in contact",
            "benchmarks.corner_report.pair_thresholds shakedown.friction_thresholds shakedown.bounds.coupling.unique_in_contact",
        ),
        entry("(6.15), (6.16)", "slips with both nodes at their limits", "benchmarks.corner_report"),
        entry(
            "(6.17)", "gaps of both nodes without contact; not possible, since one is negative",
            "benchmarks.corner_report.CornerReport.both_open_possible", computed=report.both_open,
        ),
        entry(
            "(6.18)–(6.22)", "viscous motion beyond the discontinuity; damping D",
            "shakedown.motion.viscous_jump.ViscousMotion shakedown.motion.viscous_jump.Jump",
        ),
        entry(
            "(6.31)–(6.40)", "perturbation of the corner; equilibrium with one node open",
            "benchmarks.corner_report benchmarks.corner_report.CornerEnd",
        ),
        entry(
            "(6.45), (6.48)", "the system: matrices with four digits, f = 0.39, loads", "shakedown.example",
            "0.39 2.5 2 1 1", [joint.f[0], *joint.q_w[0], *joint.p_w[0]], "given",
        ),
    ]  # fmt: skip


def _thresholds(joint: Problem) -> list[Entry]:
    limits = shakedown.friction_thresholds(joint)
    return [
        entry(
            "(6.46)", "thresholds of single nodes, each with its negative",
            "shakedown.friction_thresholds", "1.1241 4.229", np.sort(limits.single_node),
        ),
        entry(
            "(6.47)", "thresholds of both nodes", "benchmarks.corner_report.pair_thresholds",
            "0.3557 -0.3557 0.4079 -0.4079 4.3009 -4.3009 4.9314 -4.9314", pair_thresholds(joint),
        ),
        entry(
            "after (6.47)", "critical friction, limits II and III",
            "shakedown.friction_thresholds", "0.3557", limits.uniqueness_in_contact.value,
        ),
    ]  # fmt: skip


def _corner(report: CornerReport) -> list[Entry]:
    home = "benchmarks.corner_report"
    return [
        entry("(6.49)", "discontinuity point v", home, "-20.7296 30.9087", report.slip),
        entry("(6.50)", "H", home, "-0.3881 -0.1668 -0.1961 -0.0794", report.H),
        entry("(6.51)", "eigenvalues of H", home, "-0.4716 0.0039", report.eigenvalues),
        entry("(6.52)", "eigenvectors of H", home, "-0.8943 -0.4472 0.3914 -0.9201", report.eigenvectors),
        entry(
            "(6.54), fig. 6.5", "admissible perturbations: coefficients of a₁, a₂",
            "benchmarks.corner_report.CornerReport.admissible", "0.4218 0.0015 0.2109 -0.0036", report.coefficients,
        ),
        entry(
            "before (6.55)", "p₂ reaches zero first: node 2 opens (the toolkit's node 1)", home, "2",
            report.opening_node + 1,
        ),
    ]  # fmt: skip


def _end(joint: Problem, end: CornerEnd | None) -> list[Entry]:
    assert end is not None
    home, path = "benchmarks.corner_report.CornerEnd", evolve(joint, 1.0, joint.initial_slip[0]).history
    printed = "0.3881 0.1668 -0.0525 0.1754 0.1216 0.1082 -0.053 0.1082 0.5522"
    inverse = "18.05 -31.83 7.95 -33.39 68.85 -16.67 8.27 -16.55 5.84"
    return [
        entry("(6.55)", "G", home, printed, end.G),
        entry("(6.55)", "P*", home, "0 -2.1236 -5.4453", end.P),
        entry("(6.56)", "eigenvalues of −G", home, "-0.0112 -0.4718 -0.579", end.eigenvalues),
        entry("(6.58)", "G⁻¹", home, inverse, np.linalg.inv(end.G)),
        entry("(6.59)", "change of v₁, v₂, w₂ to the end state", home, "24.27 -55.42 3.33", end.change),
        entry("(6.60)", "end state v₁, v₂, w₂", home, "3.5459 -24.5192 3.33", [*end.slip, end.gap[1]]),
        entry(
            "(6.60)", "the same by following the viscous motion", "shakedown.motion.evolution",
            "3.5459 -24.5192 3.33", [*path.v[-1], path.w[-1][1]], figure="worked-jump",
        ),
    ]  # fmt: skip


def appendix_a() -> list[Entry]:
    """One node: no number is printed; the loops are our own."""
    melan = shakedown.shakedown_bounds(shakedown.example("one-node"))
    separation, cyclic = (_settled(name) for name in ("one-node-separation", "one-node-cyclic"))
    critical = shakedown.friction_thresholds(shakedown.example("one-node-cyclic")).single_node
    sign = "F = −(q_w, p_w); A, B, C = k₁₁, k₂₁, k₂₂"
    return [
        entry("(A.1), (A.2)", f"the model; {sign}", "shakedown.Problem shakedown.motion.checked_law.reactions"),
        entry("(A.3), (A.4)", "conditions of stick and separation", "shakedown.motion.checked_law.law_violation"),
        entry("(A.7), (A.9)", "slip of one node", "shakedown.motion.evolution"),
        entry("(A.10), (A.11)", "jump to separation above the critical friction", "shakedown.motion.viscous_jump.Jump"),
        entry(
            "f_cr = k₁₁/k₂₁", "critical friction; ours is 2/3", "shakedown.friction_thresholds",
            computed=critical,
        ),
        entry(
            "fig. A.4", "below f_cr Melan's theorem holds: λ_1 = λ_max", "shakedown.shakedown_bounds",
            computed=[melan.lower.load_factor, melan.upper.load_factor],
        ),
        entry(
            "fig. A.6", "alternating separation and stick: jumps, slip in contact per cycle",
            "shakedown.long_term_state",
            computed=[separation.jumps_per_cycle, *separation.slip_per_cycle],
            figure="worked-one-node-separation",
        ),
        entry(
            "fig. A.7", "cyclic slip: jumps, forward slip per cycle", "shakedown.long_term_state",
            computed=[cyclic.jumps_per_cycle, *cyclic.slip_per_cycle], figure="worked-one-node-cyclic",
        ),
    ]  # fmt: skip


def _settled(name: str) -> shakedown.LongTermState:
    problem = shakedown.example(name)
    return shakedown.long_term_state(problem, 1.0, problem.initial_slip[0])
