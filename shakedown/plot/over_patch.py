"""Over a patch in space: numbers in colours; use of friction and loads as arrows; what sticks and slips."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.colors import Normalize
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from shakedown.ground.constants import THREE_DIGITS, FloatArray
from shakedown.ground.shown_values import SHORT_DIGITS, sized, with_unit
from shakedown.ground.status import OPEN, SLIP, STICK
from shakedown.joint.constraints import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.event_history import recorded_path
from shakedown.plot import paths, style
from shakedown.plot.patch_places import Places, patch_axes, places_of
from shakedown.plot.paths import Recorded
from shakedown.plot.style import axes_for, draw_arrows, finished

Numbers = tuple[FloatArray, str]  # of all nodes, and their name with its unit
LONGEST = 0.9  # longest arrow, widest disc or loop, as a fraction of the distance of two nodes
ROOM = 0.6  # margin around the outer nodes, as a fraction of that distance
DOT = 3.0  # smallest visible diameter of a node [points]


def pressure_over_patch(
    result: Recorded, problem: Problem, cycle: float | None = None, *, patch: int = 0, ax: Axes | None = None
) -> Axes:
    """Normal reactions over a patch at one instant; pressures where node areas are known.

    The colours are those of the whole path: instants and patches of one result can be compared. Between
    nodes they are interpolated. Where the joint does not know where its nodes are, the numbers stand over
    those of the nodes.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution, of a joint with two directions.
    problem
        The joint: places and units.
    cycle
        The time in cycles; by default when the total is largest.
    patch
        Which part of the contact is drawn, of the ``plot.patch_count(problem)`` that there are.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, there is no such patch, the time lies outside them, or the joint has
        one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.pressure_over_patch(shakedown.long_term_state(joint, 0.5), joint).get_ylabel()
    'normal reaction p'
    """
    path = recorded_path(result)
    now, title = paths.at_instant(path, cycle)
    numbers = paths.normal_reactions("normal reaction p", np.vstack([now.p, path.p]), problem)
    return _coloured(problem, numbers, patch, ax, title)


def welded_pressure_over_patch(problem: Problem, *, patch: int = 0, ax: Axes | None = None) -> Axes:
    """Mean normal welded reactions p_w over a patch; pressures where node areas are known.

    Parameters
    ----------
    problem
        A joint with two directions, and its loading.
    patch, ax
        As for :func:`pressure_over_patch`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> plot.welded_pressure_over_patch(shakedown.example("four-node-3d")).get_ylabel()
    'mean welded reaction p_w'
    """
    numbers = paths.normal_reactions("mean welded reaction p_w", loading(problem).p0, problem)
    return _coloured(problem, numbers, patch, ax)


def slip_over_patch(result: Recorded, problem: Problem, *, patch: int = 0, ax: Axes | None = None) -> Axes:
    """How far each node slips in all along a path, Σ|Δv| in contact, over a patch.

    Parameters as for :func:`pressure_over_patch`; of a long-term state the path is one period.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.slip_over_patch(shakedown.long_term_state(joint, 1.4), joint).get_ylabel()
    'accumulated slip'
    """
    label = with_unit("accumulated slip", units_of(problem).length)
    return _coloured(problem, (paths.slip_of_nodes(result, problem), label), patch, ax)


def work_over_patch(result: Recorded, problem: Problem, *, patch: int = 0, ax: Axes | None = None) -> Axes:
    """Friction work of each node along a path, over a patch; per area where areas are known.

    Parameters as for :func:`pressure_over_patch`; of a long-term state the path is one period.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.work_over_patch(shakedown.long_term_state(joint, 1.4), joint).get_ylabel()
    'friction work'
    """
    return _coloured(problem, paths.work_and_name(paths.work_of_nodes(result), problem), patch, ax)


def friction_use_at(
    result: Recorded, problem: Problem, cycle: float | None = None, *, patch: int = 0, ax: Axes | None = None
) -> Axes:
    """How much of its friction each node uses at one instant: q/(f p) as an arrow within a disc.

    An arrow that reaches the rim is at its limit: that node slips, or is about to.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution, of a joint with two directions.
    problem
        The joint: places, friction, units.
    cycle
        The time in cycles; by default when the tangential reactions are largest in all.
    patch
        Which part of the contact is drawn, of the ``plot.patch_count(problem)`` that there are.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, there is no such patch, the time lies outside them, or the joint has
        one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> axes = plot.friction_use_at(shakedown.long_term_state(joint, 1.4), joint)
    >>> axes.get_legend().get_texts()[0].get_text()
    'limit |q| = f p'
    """
    path, places = recorded_path(result).without_round_off(problem), places_of(problem, patch)
    now, title = paths.at_instant(path, cycle, sheared=True)
    q, state = problem.layout.by_node(now.q)[0][places.nodes], now.state[0][places.nodes]
    axes, scale = patch_axes(places, ax, ROOM * places.spacing), 0.5 * LONGEST * places.spacing
    limit = np.where(paths.pressed(problem, now), problem.law.limit(now.p), np.inf)[0][places.nodes]
    use, wide = q / limit[:, None], np.where(limit < np.inf, 2.0 * scale, 0.0)
    rim: dict[str, Any] = {"facecolors": "none", "edgecolors": style.GREY, "linewidths": 0.7}
    rim |= {"units": "xy", "offsets": places.points, "offset_transform": axes.transData}
    axes.add_collection(EllipseCollection(wide, wide, np.zeros_like(wide), **rim))
    axes.plot([], [], "o", ms=8, mfc="none", mec=style.GREY, ls="", label="limit |q| = f p")
    _nodes(axes, places)
    arrows = scale * places.seen(use)
    for name, kind, colour in ("sticks", STICK, style.BLUE), ("slips", SLIP, style.RED):
        own = np.abs(state) == kind
        if own.any():
            _arrows(axes, places.points[own], arrows[own], colour, name)
    if (state == OPEN).any():
        axes.plot(*places.points[state == OPEN].T, "o", mfc="none", mec=style.GREY, ms=4, ls="", label="open")
    return _finished(axes, places, f"{title}, {_largest('|q| / f p', use, '', 1.0)}")


def zones_at(
    result: Recorded, problem: Problem, cycle: float | None = None, *, patch: int = 0, ax: Axes | None = None
) -> Axes:
    """Stick, slip and open nodes of a patch at one instant, told apart by colour and shape.

    Parameters as for :func:`friction_use_at`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.zones_at(shakedown.long_term_state(joint, 0.5), joint, 0.0).get_title()
    't = 0 cycles: 4 stick, 0 slip, 0 open'
    """
    kinds = ((STICK, "stick", "s", style.BLUE), (SLIP, "slip", "o", style.RED), (OPEN, "open", "o", "none"))
    path, places = recorded_path(result).without_round_off(problem), places_of(problem, patch)
    now, title = paths.at_instant(path, cycle, sheared=True)
    state = np.abs(now.state[0])[places.nodes]
    axes = patch_axes(places, ax, ROOM * places.spacing)
    # diameter [points]: about 75 in a row fill a panel
    size = float(np.clip(75.0 / np.sqrt(problem.n), DOT, 8.0))
    for number, name, shape, colour in kinds:
        (x, y), edge = places.points[state == number].T, style.GREY if colour == "none" else colour
        axes.scatter(x, y, s=size**2, marker=shape, fc=colour, ec=edge, lw=0.8, label=name)
    counts = ", ".join(f"{int((state == number).sum())} {name}" for number, name, *_ in kinds)
    return _finished(axes, places, f"{title}: {counts}")


def _coloured(problem: Problem, numbers: Numbers, patch: int, ax: Axes | None, title: str = "") -> Axes:
    """Numbers of all nodes, (n,), over a patch in colours; of several rows the first, in the colours of all.

    Over the numbers of the nodes where there is no patch.
    """
    places, every = places_of(problem, patch), np.atleast_2d(numbers[0])
    known, values, label = every[np.isfinite(every)], every[0][places.nodes], numbers[1]
    low, high = float(known.min(initial=0.0)), float(known.max(initial=0.0))
    high = high if high > low else 1.0
    if places.in_a_row:
        axes = axes_for(ax)
        axes.plot(places.nodes, values, "o", ms=5, color=style.BLUE)
        axes.set_ylim(1.08 * low, 1.08 * high)
        return finished(axes, "node", label, title=title)
    axes, (x, y) = patch_axes(places, ax, 0.0), places.points.T
    look: dict[str, Any] = {"cmap": "viridis", "norm": Normalize(low, high)}
    corners = np.zeros((0, 3), np.intp) if places.triangles is None else places.triangles.triangles
    corners = corners[np.isfinite(values)[corners].all(axis=1)]
    if len(corners):
        mesh = Triangulation(x, y, corners)
        axes.tripcolor(mesh, np.nan_to_num(values), shading="gouraud", rasterized=True, **look)
    size = 16.0 if len(corners) else 60.0
    drawn = axes.scatter(x, y, s=size, c=values, ec=style.GREY, lw=0.4, **look)
    bar = axes.figure.colorbar(drawn, ax=axes, ticks=MaxNLocator(6))
    # characters; the unit of a longer label stands on a line of its own
    bar.set_label(label.replace(" [", "\n[") if len(label) > 24 else label)
    bar.outline.set_visible(False)
    bar.ax.ticklabel_format(axis="y", scilimits=(-2, 3))
    axes.set_title(places.titled(title), fontsize="medium")
    return axes


def _finished(axes: Axes, places: Places, title: str) -> Axes:
    """A title, a grid below, numbers of few nodes, the legend beside the axes, as arrows may be anywhere."""
    finished(axes, title=places.titled(title)).set_axisbelow(True)
    if len(places.points) <= 16 and not places.in_a_row:  # nodes whose numbers stand beside them
        look: dict[str, Any] = {"textcoords": "offset points", "color": style.GREY, "fontsize": "x-small"}
        for node, point in zip(places.nodes.tolist(), places.points.tolist(), strict=True):
            axes.annotate(str(node), point, (3, 3), **look)
    if (legend := axes.get_legend()) is not None:
        legend.set_loc("upper left")
        legend.set_bbox_to_anchor((1.0, 1.0), axes.transAxes)
    return axes


def _largest(what: str, vectors: FloatArray, unit: str, longest: float) -> str:
    """The largest vector on a patch; if negligible beside the longest arrow, only a bound on it."""
    most = min(float(np.nanmax(np.linalg.norm(vectors, axis=-1), initial=0.0)), longest)
    shown = THREE_DIGITS * longest
    if most < shown:
        return f"{what} < {sized(shown, unit, SHORT_DIGITS)}"
    return f"largest {what} = {sized(most, unit, SHORT_DIGITS)}"


def _nodes(axes: Axes, places: Places) -> None:
    """Dots at the nodes, since nodes without a visible arrow would otherwise not be seen."""
    axes.scatter(places.points[:, 0], places.points[:, 1], s=DOT**2, color=style.GREY, lw=0)


def _arrows(axes: Axes, feet: FloatArray, vectors: FloatArray, colour: str, name: str) -> None:
    draw_arrows(axes, feet, vectors, width=0.0035, minlength=0.5, color=colour, label=name, zorder=3)
