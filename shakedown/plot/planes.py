"""Planes: the slip space of two nodes with its rows, and the load of one node with its stick sector."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from shakedown.bounds.upper import upper_bound
from shakedown.ground.constants import EACH_SHOWN, FloatArray, Mask
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import at_lambda, few, with_unit
from shakedown.ground.status import OPEN, STICK, Status
from shakedown.joint.arguments import check_load_factor, require_plane
from shakedown.joint.constraints import SIDE_NAMES, Constraints, Side, constraints
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.course import EventKind
from shakedown.motion.event_history import EventHistory, recorded_path
from shakedown.plot import style
from shakedown.plot.paths import Recorded
from shakedown.plot.style import Style, axes_for, finished, style_of
from shakedown.programs.simplex import corners


def slip_space(
    problem: Problem,
    load_factor: float,
    results: Mapping[str, Recorded] | None = None,
    *,
    ax: Axes | None = None,
) -> Axes:
    """The slip plane of a two-node joint: its four rows, the safe region, paths (thesis fig. 5.4).

    Rows hold with both nodes closed, each at its extreme load step; a path is dotted
    where a node is open or the state jumps. Above λ_max, where no region is left, the safe slip at
    λ_max is marked.

    Parameters
    ----------
    problem
        A joint of two nodes.
    load_factor
        λ at which the rows are drawn.
    results
        Name → a result with recorded events.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If the joint has another number of nodes, or a result no recorded events.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> axes = plot.slip_space(shakedown.example("two-node"), 0.7)
    >>> axes.get_xlabel(), len(axes.patches)
    ('slip of node 0', 1)
    """
    require_plane("picture", problem)
    if problem.n != 2:
        raise UsageError(f"slip space: expected a problem with 2 nodes, found {problem.n}")
    rows, axes = constraints(problem), axes_for(ax, (6.0, 5.0))
    check_load_factor(load_factor, problem)
    region = corners(rows.G, rows.g - load_factor * rows.d)  # empty where none is bounded with an interior
    if len(region):
        axes.add_patch(Polygon(region, closed=True, fc=style.GREEN, alpha=0.25, lw=0, label="safe region"))
    paths = {name: recorded_path(result) for name, result in (results or {}).items()}
    for k, (name, path) in enumerate(paths.items()):
        _draw_path(axes, path, style_of(name, k))
    last = None if len(region) else upper_bound(problem, certify=False)
    if last is not None and last.status == Status.OPTIMAL:
        axes.plot(*last.slip, "x", color=style.GREEN, ms=7, mew=2, zorder=4, label="safe slip at λ_max")
    _keep_limits(axes, 0.12)
    _draw_rows(axes, rows, rows.g - load_factor * rows.d)
    _, length = units_of(problem)
    names = with_unit("slip of node 0", length), with_unit("slip of node 1", length)
    return finished(axes, *names, title=at_lambda(load_factor))


def _draw_path(axes: Axes, path: EventHistory, look: Style) -> None:
    """The path, a circle at its start and a square at its end; dotted where it jumps or a node is open."""
    line = {"lw": 1.5, "zorder": 3} | dict(look) | {"label": "_nolegend_"}
    moves = (np.diff(path.v, axis=0) != 0).any(axis=1)
    interrupted = (path.kind[1:] == EventKind.JUMPS) | (path.state[:-1] == OPEN).any(axis=1)
    for drawn, dashes in (moves & ~interrupted, {}), (moves & interrupted, {"ls": ":"}):
        if drawn.any():
            axes.plot(*_steps(path.v, drawn), **(line | dashes))
    end = {"color": look["color"], "ls": "none", "ms": 5, "zorder": 4}
    axes.plot(*path.v[0], "o", mfc="white", label="_nolegend_", **end)
    axes.plot(*path.v[-1], "s", label=look["label"], **end)


def _steps(points: FloatArray, drawn: Mask) -> FloatArray:
    """The steps between points (s, 2) that are drawn (s − 1,), as one line (2, …) with gaps between them."""
    steps = np.stack([points[:-1], points[1:], np.full_like(points[1:], np.nan)], axis=1)
    return np.asarray(steps[drawn].reshape(-1, 2).T)


def _draw_rows(axes: Axes, rows: Constraints, limits: FloatArray) -> None:
    """The lines G v = limit of the rows of a two-node joint."""
    row_colours = (style.SKY, style.ORANGE)
    for i, (normal, limit) in enumerate(zip(rows.G, limits, strict=True)):
        size, side = float(normal @ normal), int(rows.side[i])
        if size == 0.0:
            continue
        foot = normal * limit / size
        axes.axline(
            foot, foot + [-normal[1], normal[0]] / np.sqrt(size) * (np.linalg.norm(foot) or 1.0),
            color=row_colours[rows.node[i]], ls="-" if side == Side.BACKWARD else "--", zorder=1,
            lw=1.0, label=f"node {rows.node[i]}, {SIDE_NAMES[side]} limit",
        )  # fmt: skip


def _keep_limits(axes: Axes, margin: float) -> None:
    """Leave the limits of the axes as they are, with a margin around what is drawn so far."""
    axes.margins(margin)
    axes.autoscale_view()
    axes.set_autoscale_on(False)


def reaction_space(result: Recorded, problem: Problem, node: int = 0, *, ax: Axes | None = None) -> Axes:
    """The load that one node feels, with its stick sector where it moves to (appendix A, thesis 4.2–4.9).

    The sector |F₁ + A v| ≤ f (F₂ + B v) of the plane F₁ = q_w, F₂ = p_w has its apex at
    (−A v, −B v): slip carries it along. The path is coloured by the state of the node.
    The thesis draws the forces on the body the other way round, F = −(q_w, p_w).

    Parameters
    ----------
    result
        A result with recorded events.
    problem
        The joint; of several nodes, the others count as part of the load.
    node
        The node to show.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, or there is no such node.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("one-node")
    >>> axes = plot.reaction_space(shakedown.long_term_state(joint, 0.9), joint)
    >>> axes.get_ylabel()
    'F₂ = p_w'
    """
    require_plane("picture", problem)
    if not 0 <= node < problem.n:
        raise UsageError(f"node: expected a number from 0 to {problem.n - 1}, found {node}")
    path, axes = recorded_path(result), axes_for(ax, (6.4, 5.2))
    force = loads_felt(problem, path, node)
    for state, colour in {0: style.BLACK, 1: style.RED, -1: style.BLUE, 2: style.PURPLE}.items():  # of states
        held = path.state[:-1, node] == state
        if held.any():
            axes.plot(*_steps(force, held), color=colour, lw=2.0, label=style.STATES[state][0], zorder=3)
    reach = 5.0 * float(np.ptp(force, axis=0).max() or 1.0)
    _keep_limits(axes, 0.25)
    stuck = np.unique(path.v[path.state[:, node] == STICK, node].round(9))
    for colour, v in zip(style.LINES, stuck[:: max(1, len(stuck) // EACH_SHOWN)][:EACH_SHOWN], strict=False):
        sector = stick_sector(problem, node, v, reach)
        axes.add_patch(Polygon(sector, closed=True, fc=colour, ec=colour, alpha=0.18, label=f"v = {few(v)}"))
        axes.plot(*sector[0], "^", color=colour, ms=6, zorder=2)
    unit, _ = units_of(problem)
    return finished(axes, with_unit("F₁ = q_w", unit), with_unit("F₂ = p_w", unit))


def stick_sector(problem: Problem, node: int, v: float, reach: float) -> FloatArray:
    """Apex and two far points of the loads that one node bears at a slip, (3, 2) [force]."""
    apex, f = -v * np.array([problem.A[node, node], problem.B[node, node]]), problem.f[node]
    return np.asarray(apex + reach * np.array([[0.0, 0.0], [f, 1.0], [-f, 1.0]]))


def loads_felt(problem: Problem, path: EventHistory, node: int) -> FloatArray:
    """Load of one node as if the others belonged to it, (s, 2) [force]."""
    v, w = path.v[:, node], path.w[:, node]
    q = path.q[:, node] - v * problem.A[node, node]
    p = path.p[:, node] - v * problem.B[node, node]
    if problem.C is not None:
        q, p = q - w * problem.B[node, node], p - w * problem.C[node, node]
    return np.stack([q, p], axis=1)
