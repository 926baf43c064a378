"""Figures of an evolution: the load plane with the moving stick sector, and the slip space with its rows."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from shakedown.errors import UsageError
from shakedown.evolution.event_history import EventHistory, EventKind
from shakedown.model.constraints import SIDE_NAMES
from shakedown.model.problem import FloatArray, Problem

STATES = {
    0: ("stick", "#4c78a8"),
    1: ("backward slip", "#e45756"),
    -1: ("forward slip", "#f58518"),
    2: ("open", "#72b7b2"),
}
SHADES = ("#4c78a8", "#54a24b", "#b279a2", "#9d755d")


def load_plane(problem: Problem, history: EventHistory, node: int = 0) -> Figure:
    """The path of the load in the plane F₁ = q_w, F₂ = p_w of one node, with its stick sector as it moves.

    The sector |F₁ + A v| ≤ f (F₂ + B v) has its apex at (−A v, −B v) (appendix
    A); it is drawn for every slip at which the node sticks, the path coloured
    by the state of the node.

    Parameters
    ----------
    problem
        A problem of one node; of more, the others count as part of the load.
    history
        Its evolution.
    node
        The node to show.
    """
    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    axes = figure.add_subplot()
    force = _loads_felt(problem, history, node)
    _colour_path(axes, force, history.state[:, node])
    size = 0.12 * float(np.ptp(force, axis=0).max() or 1.0)
    low, high = force.min(axis=0) - 2 * size, force.max(axis=0) + 2 * size
    stuck = history.v[history.state[:, node] == 0, node]
    for k, v in enumerate(np.unique(stuck.round(9))[:: max(1, len(np.unique(stuck.round(9))) // 4)][:4]):
        apex = np.array([-problem.A[node, node] * v, -problem.B[node, node] * v])
        _sector(axes, apex, float(problem.f[node]), float(np.max(high - low)) * 3, SHADES[k], f"v = {v:.4g}")
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set(xlabel="F₁ = q_w  [force]", ylabel="F₂ = p_w  [force]", title=problem.name or "load plane")
    axes.legend(fontsize=8, loc="best")
    return figure


def slip_space(problem: Problem, history: EventHistory) -> Figure:
    """The path of a two-node system in slip space (v₁, v₂), with its four rows at the final load.

    Each row is the line on which a node is at a limit, (A_j ∓ f B_j)·v = ±f p_w − q_w;
    its shaded side is not admissible. Rows hold with both nodes closed; the path is
    dotted where one is open, and in colour where the state jumps.
    """
    if problem.n != 2:
        raise UsageError(f"slip space: expected a problem with 2 nodes, found {problem.n}")
    figure = Figure(figsize=(6.4, 5.2), layout="constrained")
    axes = figure.add_subplot()
    v, opened = history.v, (history.state == 2).any(axis=1)
    for k in range(len(v) - 1):
        if np.any(v[k] != v[k + 1]):
            leaps = history.kind[k + 1] == EventKind.JUMPS
            style = ":" if leaps or opened[k] else "-"
            axes.plot(*v[k : k + 2].T, style, color="#b279a2" if leaps else "black", lw=1.6, zorder=3)
    axes.plot(*v[0], "o", color="black", label="start", zorder=4)
    axes.plot(*v[-1], "s", color="#e45756", label="end", zorder=4)
    span = np.maximum(np.ptp(v, axis=0), 1e-9 + 0.3 * np.ptp(v, axis=0).max())
    low, high = v.min(axis=0) - 0.25 * span, v.max(axis=0) + 0.25 * span
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    _rows(axes, problem, history.q_w[-1], history.p_w[-1], low, high)
    axes.set(xlabel="v₀  [length]", ylabel="v₁  [length]", title=problem.name or "slip space")
    axes.legend(fontsize=8, loc="best")
    return figure


def _loads_felt(problem: Problem, history: EventHistory, node: int) -> FloatArray:
    """Load of one node as if the others belonged to it, (s, 2)."""
    q = history.q - history.v[:, [node]] * problem.A[node, node]
    p = history.p - history.v[:, [node]] * problem.B[node, node]
    if problem.C is not None:
        q = q - history.w[:, [node]] * problem.B[node, node]
        p = p - history.w[:, [node]] * problem.C[node, node]
    return np.stack([q[:, node], p[:, node]], axis=1)


def _colour_path(axes: Axes, force: FloatArray, state: np.ndarray) -> None:
    named: set[int] = set()
    for k in range(len(force) - 1):
        label, colour = STATES[int(state[k])]
        first = None if state[k] in named else label
        named.add(int(state[k]))
        axes.plot(*force[k : k + 2].T, color=colour, lw=2.2, label=first, zorder=3)
        axes.plot(*force[k], ".", color=colour, ms=5, zorder=4)


def _sector(axes: Axes, apex: FloatArray, f: float, reach: float, colour: str, label: str) -> None:
    """The wedge of loads at which the node sticks."""
    corners = apex + reach * np.array([[0.0, 0.0], [f, 1.0], [-f, 1.0]])
    axes.add_patch(Polygon(corners, closed=True, fc=colour, ec=colour, alpha=0.18, zorder=1, label=label))
    axes.plot(*apex, "^", color=colour, ms=6, zorder=2)


def _rows(
    axes: Axes, problem: Problem, q_w: FloatArray, p_w: FloatArray, low: FloatArray, high: FloatArray
) -> None:
    """Lines and forbidden sides of the four rows within the frame."""
    names = ("I", "II", "III", "IV")
    corners = np.array([[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]])
    for k in range(4):
        node, side = k // 2, 1 if k % 2 == 0 else -1
        normal = side * problem.A[node] - problem.f[node] * problem.B[node]
        limit = problem.f[node] * p_w[node] - side * q_w[node]
        forbidden = _half_plane(corners, normal, limit)
        colour = SHADES[k]
        if len(forbidden):
            axes.add_patch(Polygon(forbidden, closed=True, fc=colour, alpha=0.12, ec="none"))
        line = np.array(_crossings(corners, normal, limit))
        if len(line) == 2:
            axes.plot(
                *line.T, color=colour, lw=1.3, label=f"{names[k]}: node {node}, {SIDE_NAMES[int(side)]}"
            )


def _crossings(corners: FloatArray, normal: FloatArray, limit: float) -> list[FloatArray]:
    """Where the line normal·v = limit crosses the edges of a convex polygon."""
    excess, out = corners @ normal - limit, []
    for k in range(len(corners)):
        a, b = excess[k], excess[(k + 1) % len(corners)]
        if a * b < 0:
            out.append(corners[k] + a / (a - b) * (corners[(k + 1) % len(corners)] - corners[k]))
    return out


def _half_plane(corners: FloatArray, normal: FloatArray, limit: float) -> FloatArray:
    """The part of a convex polygon with normal·v > limit."""
    excess, out = corners @ normal - limit, []
    for k in range(len(corners)):
        a, b = excess[k], excess[(k + 1) % len(corners)]
        if a >= 0:
            out.append(corners[k])
        if a * b < 0:
            out.append(corners[k] + a / (a - b) * (corners[(k + 1) % len(corners)] - corners[k]))
    return np.array(out)
