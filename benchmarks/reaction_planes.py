"""Chapters IV and V of the thesis in pictures: planes of slips and of reactions, wedging, the tenth cycle.

*Two nodes in contact* (4.14)–(4.17): the reactions of node j are r_j = r_w,j + L_j v with
L_j = [A_j; B_j], so the second node's change follows from the first one's, Δr₂ = M Δr₁,
M = L₂ L₁⁻¹. M⁻¹ carries the second node's friction cone |q₂| ≤ f p₂ into the plane of the
first: the state sticks while the first node's reactions lie in both sectors. (How L_j is
made up is inferred: only the product L₂L₁⁻¹ is at hand.)

*Wedging* (4.3.2): a slip v ≠ 0 with |A v| ≤ f B v stays without any load.

*Slip space* (fig. 5.4) at the four critical load factors of the two-node system.

*Extreme points* (figs. 5.1–5.3, 5.7): of the reactions of one period only the steps matter that
come nearest to a limit: the largest q − f p and −q − f p.

*Tenth cycle* (fig. 5.8): slip along the contact at λ_max, from the safe slip and from others.
The thesis's block of fig. 5.5 has an angle and a loaded strip of which only a drawing exists:
this one is ``benchmarks.bodies.blocks.cantilevered_block``, like it in kind and not in numbers.
"""

from itertools import combinations
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

import shakedown
from shakedown import Problem, plot
from shakedown.ground.constants import FloatArray
from shakedown.ground.shown_values import with_unit
from shakedown.joint.constraints import Constraints, constraints, loading
from shakedown.motion.evolution import evolve
from shakedown.plot.style import BLUE, GREEN, GREY, ORANGE, RED, units_of
from shakedown.report.facts import table

TITLE = "Chapters IV and V: planes of slips and reactions, wedging, slip in the tenth cycle"
CYCLE = 9  # the tenth
REACH = 1e4  # how far a sector is drawn, in units of its own edges


def cases(short: bool) -> list[dict[str, Any]]:
    return [
        {"what": "reaction map", "problem": "two-node"},
        {"what": "wedging", "problem": "two-node"},
        {"what": "extreme points", "problem": "two-node"},
        {"what": "tenth cycle", "problem": "cantilevered-block"},
    ]


def measure(case: dict[str, Any]) -> dict[str, Any]:
    problem = shakedown.example(case["problem"])
    if case["what"] == "reaction map":
        return {"found": reaction_map(problem).tolist(), "says": "M = L₂ L₁⁻¹"}
    if case["what"] == "wedging":
        wedged = shakedown.friction_thresholds(problem).wedging
        return {"found": [wedged.value, *wedged.slip.tolist()], "says": "friction, locked-in slip"}
    if case["what"] == "extreme points":
        rows = constraints(problem)
        return {"found": rows.step.tolist(), "says": "load step of each row, backward and forward"}
    slips = tenth_cycle(problem)
    return {"found": [float(slip.max()) for slip in slips.values()], "says": ", ".join(slips)}


def reaction_map(problem: Problem) -> FloatArray:
    """M = L₂ L₁⁻¹ of a two-node joint: changes of node 0's (q, p) to those of node 1's."""
    first, second = (np.stack([problem.A[j], problem.B[j]]) for j in (0, 1))
    return np.asarray(np.linalg.solve(first.T, second.T).T)


def tenth_cycle(problem: Problem) -> dict[str, FloatArray]:
    """Σ|Δv| of every node in the tenth cycle at λ_max, from the safe slip and from two others."""
    upper = shakedown.upper_bound(problem)
    critical = shakedown.lower_bound(problem).slip
    starts = {"safe slip": upper.slip, "slip 0": 0 * upper.slip, "critical slip state": critical}
    return {
        name: evolve(problem, upper.load_factor, start, cycles=CYCLE + 1).cycles[CYCLE].slip
        for name, start in starts.items()
    }


def tables(rows: list[dict[str, Any]]) -> str:
    lines = [[row["what"], row["problem"], row["says"], _numbers(row["found"])] for row in rows]
    return table(["what", "problem", "numbers", "found"], lines)


def _numbers(values: Any) -> str:
    return " ".join(f"{value:.6g}" for value in np.ravel(values))


def figures(rows: list[dict[str, Any]]) -> dict[str, Figure]:
    return {
        "planes-reactions": reaction_figure(),
        "planes-wedging": wedging_figure(),
        "planes-slip": slip_figure(),
        "planes-extreme-points": extreme_figure(
            shakedown.example("two-node"), (0, 1), "(thesis figs 5.1–5.3)"
        ),
        "planes-block-loops": extreme_figure(
            shakedown.example("cantilevered-block"), (0, 8), "(like thesis fig. 5.7)"
        ),
        "planes-tenth-cycle": tenth_cycle_figure(),
    }


def reaction_figure() -> Figure:
    """Both friction cones in the plane of node 0's reactions, at one load, with a path (4.14)–(4.17)."""
    problem, load_factor = shakedown.example("two-node"), 0.7
    figure = Figure(figsize=(11, 5.0), layout="constrained")
    panels = figure.subplots(1, 2, sharex=True, sharey=True)
    slip = shakedown.safe_slip(problem, load_factor).slip
    for axes, step in zip(panels, (0, problem.m // 2), strict=True):
        _sectors(axes, problem, load_factor, step, slip)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(f"Two nodes in the plane of the first one's reactions, λ = {load_factor}")
    return figure


def _sectors(axes: Axes, problem: Problem, load_factor: float, step: int, slip: FloatArray) -> None:
    q_w, p_w = (side[step] for side in loading(problem).at(load_factor))
    back = np.linalg.inv(reaction_map(problem))
    welded = np.stack([q_w, p_w], axis=1)
    apex = welded[0] - back @ welded[1]  # where node 1 has no reactions
    for node, origin, turn, colour, name in (
        (0, np.zeros(2), np.eye(2), BLUE, "node 0: |q| ≤ f p"),
        (1, apex, back, ORANGE, "node 1, carried over by M⁻¹"),
    ):
        edges = REACH * np.array([[problem.f[node], 1.0], [-problem.f[node], 1.0]]) @ turn.T
        corners = origin + np.vstack([np.zeros(2), edges])
        axes.add_patch(Polygon(corners, closed=True, fc=colour, ec=colour, alpha=0.25, label=name))
        axes.plot(*origin, "^", color=colour)
    q, p = q_w + problem.A @ slip, p_w + problem.B @ slip
    axes.plot(q[0], p[0], "o", color=GREEN, label="reactions with the safe slip")
    axes.plot(q_w[0], p_w[0], "s", color=GREY, label="with slip 0")
    axes.set(xlim=(-900, 900), ylim=(-200, 1500), xlabel="q of node 0", ylabel="p of node 0")
    axes.set_title(f"load step {step}")
    axes.grid(alpha=0.3)


def wedging_figure() -> Figure:
    """|A v| ≤ f B v over the direction of v, for both nodes, and the slip that wedges (4.3.2)."""
    problem = shakedown.example("two-node")
    wedged = shakedown.friction_thresholds(problem).wedging
    figure = Figure(figsize=(7, 5.0), layout="constrained")
    axes = figure.subplots()
    angle = np.linspace(0, 2 * np.pi, 1441)
    v = np.stack([np.cos(angle), np.sin(angle)])
    q, p = problem.A @ v, problem.B @ v
    for node, colour in enumerate((BLUE, ORANGE)):
        need = np.where(p[node] > 0, np.abs(q[node]) / np.where(p[node] > 0, p[node], 1.0), np.nan)
        axes.plot(
            np.degrees(angle), need, color=colour, label=f"friction that node {node} needs, |A v| / B v"
        )
    where = np.degrees(np.arctan2(wedged.slip[1], wedged.slip[0])) % 360
    axes.plot(where, wedged.value, "o", color=RED, label=f"wedging, f = {wedged.value:.4g}")
    axes.axhline(wedged.value, color=GREY, lw=0.8, ls="--")
    axes.set(ylim=(0, 3 * wedged.value), xlim=(0, 360), xticks=range(0, 361, 45))
    axes.set(xlabel="direction of the slip (v₀, v₁) [degrees]", ylabel="friction coefficient f")
    axes.set_title("Wedging: both nodes hold themselves without any load")
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=2, frameon=False, fontsize="small")
    return figure


def slip_figure() -> Figure:
    """Slip space at the four critical load factors: each time three rows meet in a point (fig. 5.4)."""
    problem = shakedown.example("two-node")
    rows = constraints(problem)
    figure = Figure(figsize=(11, 8.6), layout="constrained")
    panels = figure.subplots(2, 2).ravel()
    for axes, (load_factor, point) in zip(panels, meeting_points(rows), strict=True):
        plot.slip_space(problem, load_factor, ax=axes)
        axes.plot(*point, "o", color=RED, zorder=5, label="three limits meet")
        corners = pair_corners(rows, load_factor)
        low, high = corners.min(axis=0), corners.max(axis=0)
        margin = 0.15 * (high - low)
        axes.set(
            xlim=(low[0] - margin[0], high[0] + margin[0]), ylim=(low[1] - margin[1], high[1] + margin[1])
        )
        axes.get_legend().remove()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, frameon=False)
    figure.suptitle("Slip space at the critical load factors of the two-node system (thesis fig. 5.4)")
    return figure


def meeting_points(rows: Constraints) -> list[tuple[float, FloatArray]]:
    """Load factor and slip at which three of the four rows are active (5.11), (5.12), in increasing order."""
    system = np.column_stack([rows.G, rows.d])
    found = [np.linalg.solve(system[list(t)], rows.g[list(t)]) for t in combinations(range(4), 3)]
    return sorted(((float(x[2]), x[:2]) for x in found), key=lambda pair: pair[0])


def pair_corners(rows: Constraints, load_factor: float) -> FloatArray:
    """Where a row of the one node meets a row of the other, (4, 2)."""
    right = rows.g - load_factor * rows.d
    pairs = [[i, j] for i in np.flatnonzero(rows.node == 0) for j in np.flatnonzero(rows.node == 1)]
    return np.array([np.linalg.solve(rows.G[pair], right[pair]) for pair in pairs])


def extreme_figure(problem: Problem, nodes: tuple[int, int], where: str) -> Figure:
    """The reactions of one period of two nodes at the safe slip, with their extreme load steps."""
    upper, rows = shakedown.upper_bound(problem), constraints(problem)
    q_w, p_w = loading(problem).at(upper.load_factor)
    q, p = q_w + upper.slip @ problem.A.T, p_w + upper.slip @ problem.B.T
    figure = Figure(figsize=(11, 5.0), layout="constrained")
    panels = figure.subplots(1, 2)
    for node, axes in zip(nodes, panels, strict=True):
        loop = np.append(np.arange(problem.m), 0)
        axes.plot(q[loop, node], p[loop, node], ".-", color=GREY, ms=3, label="reactions of one period")
        top = 1.15 * float(p[:, node].max())
        for side in (1, -1):
            label = "limits |q| = f p" if side == 1 else None
            axes.plot([0, side * problem.f[node] * top], [0, top], "k--", lw=0.9, label=label)
            step = rows.step[(rows.node == node) & (rows.side == side)][0]
            name, colour, size = {1: ("backward", RED, 10), -1: ("forward", BLUE, 5)}[side]  # may coincide
            axes.plot(
                q[step, node], p[step, node], "o", color=colour, ms=size, label=f"extreme, {name} limit"
            )
        axes.set(title=f"node {node}")
        axes.set(xlabel=with_unit("tangential reaction q", units_of(problem)[0]))
        axes.grid(alpha=0.3)
    panels[0].set_ylabel(with_unit("normal reaction p", units_of(problem)[0]))
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(
        f"Extreme points of the reaction loops {where}, safe slip, λ_max = {upper.load_factor:.6g}"
    )
    return figure


def tenth_cycle_figure() -> Figure:
    """Slip along the contact in the tenth cycle at λ_max (like fig. 5.8), on our block."""
    problem = shakedown.example("cantilevered-block")
    figure = Figure(figsize=(7, 4.6), layout="constrained")
    axes = figure.subplots()
    plot.slip_along(tenth_cycle(problem), problem, what="slip in the tenth cycle Σ|Δv|", ax=axes)
    axes.set_title(f"Cantilevered block, f = {problem.f[0]}, at λ_max (like thesis fig. 5.8)")
    return figure
