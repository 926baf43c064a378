"""One number per node: lines along a contact in the plane, colours over a patch in space.

Each picture works out its numbers and what they are called; ``_along`` or ``_over`` draws them.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import OPEN
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked, real_array, require_plane, require_problem
from shakedown.joint.contact_surface import flanks
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.event_history import EventHistory
from shakedown.plot.drawn_path import (
    Recorded,
    at_instant,
    extreme_rows,
    path_of,
    pressed,
    slip_of_nodes,
    time_in_words,
    work_of_nodes,
)
from shakedown.plot.patch_places import Places, in_space, patch_axes, places_of, require_space
from shakedown.plot.style import (
    BLACK,
    BLUE,
    GREY,
    Style,
    axes_for,
    finished,
    positions,
    style_of,
)

COLOURS = "viridis"
LONG = 24  # characters; the unit of a longer label stands on a line of its own
BAR = (1.04, 0.0, 0.045, 1.0)  # place of the colour bar, as fractions of the axes

Numbers = tuple[FloatArray, str]  # one number per node, and their name with its unit


@checked
def pressure(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    cycles: Sequence[float] | None = None,
    node_area: FloatArray | None = None,
    patch: int = 0,
    ax: Axes | None = None,
) -> Axes:
    """Normal reactions along the contact, at chosen instants; pressures where node areas are known.

    With two tangential directions :func:`pressure_over_patch` draws one instant.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        The joint: positions and units.
    cycles
        Times in cycles, over a patch one; by default when the total is largest and when it is smallest.
    node_area : (n,), optional
        Area of each node [length²]: reactions are divided by it. By default the problem's own.
    patch
        With two directions the part of the contact that is drawn.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, or over a patch more than one time is asked for.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.pressure(shakedown.long_term_state(block, 1.0), block).get_ylabel()
    'normal reaction p [N]'
    """
    require_problem(problem)
    if in_space(problem):
        if cycles is not None and len(cycles) != 1:
            raise UsageError(f"cycles: expected one time (a picture of a patch), found {len(cycles)}")
        cycle = None if cycles is None else cycles[0]
        return pressure_over_patch(result, problem, cycle, node_area=node_area, patch=patch, ax=ax)
    path = path_of(result)
    rows = _rows(path, cycles)
    values, label = normal_reactions("normal reaction p", path.p[rows], problem, node_area)
    return _along(problem, zip(_times(path, rows), values, strict=True), label, ax)


@checked
def pressure_over_patch(
    result: Recorded | EventHistory,
    problem: Problem,
    cycle: float | None = None,
    *,
    node_area: FloatArray | None = None,
    patch: int = 0,
    ax: Axes | None = None,
) -> Axes:
    """Normal reactions over a patch at one instant; pressures where node areas are known.

    Colours between the nodes are interpolated. Where the joint does not know where its nodes are, the
    numbers stand over those of the nodes.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution, of a joint with two directions.
    problem
        The joint: places and units.
    cycle
        The time in cycles; by default when the total is largest.
    node_area : (n,), optional
        Area of each node [length²]: reactions are divided by it. By default the problem's own.
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
    require_space("picture of a patch", problem)
    now, title = at_instant(path_of(result), cycle)
    values = normal_reactions("normal reaction p", now.p[0], problem, node_area)
    return _over(problem, *values, patch, ax, title)


@checked
def welded_pressure_over_patch(
    problem: Problem, *, node_area: FloatArray | None = None, patch: int = 0, ax: Axes | None = None
) -> Axes:
    """Mean normal welded reactions p_w over a patch; pressures where node areas are known.

    Parameters
    ----------
    problem
        A joint with two directions, and its loading.
    node_area, patch, ax
        As for :func:`pressure_over_patch`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> plot.welded_pressure_over_patch(shakedown.example("four-node-3d")).get_ylabel()
    'mean welded reaction p_w'
    """
    require_space("picture of a patch", problem)
    mean = loading(problem).p0
    return _over(problem, *normal_reactions("mean welded reaction p_w", mean, problem, node_area), patch, ax)


@checked
def friction_use(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    cycles: Sequence[float] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """How much of the friction each node uses, q / f p, along the contact at chosen instants.

    At ±1 a node is at its limit. Open nodes are left out. Parameters as for :func:`pressure`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> axes = plot.friction_use(shakedown.long_term_state(block, 1.0), block)
    >>> axes.get_ylabel()
    'use of friction q / f p [–]'
    """
    require_plane("picture", problem)
    path = path_of(result)
    most, rows = np.where(pressed(problem, path), problem.law.limit(path.p), np.nan), _rows(path, cycles)
    use = zip(_times(path, rows), path.q[rows] / most[rows], strict=True)
    axes = _along(problem, use, "use of friction q / f p [–]", ax)
    for limit in (-1.0, 1.0):
        axes.axhline(limit, color=BLACK, lw=0.8, ls="--")
    axes.set(ylim=(-1.15, 1.15))
    return axes


@checked
def slip_along(
    slips: Mapping[str, FloatArray],
    problem: Problem,
    *,
    what: str = "slip v",
    styles: Mapping[str, Style] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Slips, or anything else that has one number per node in units of length, along the contact.

    Parameters
    ----------
    slips
        Name → (n,) [length].
    problem
        The joint: positions and units.
    what
        Name of the quantity, for the axis.
    styles
        Keywords of ``Axes.plot`` for the line of a name.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.slip_along({"safe slip": shakedown.upper_bound(block).slip}, block).get_ylabel()
    'slip v [mm]'
    """
    require_plane("picture", problem)
    return _along(problem, slips.items(), with_unit(what, units_of(problem).length), ax, styles)


@checked
def slip_range(result: Recorded | EventHistory, problem: Problem, *, ax: Axes | None = None) -> Axes:
    """How far each node slips back and forth in contact, max v − min v over a path, along the contact.

    Nothing is drawn for nodes that are never closed. Parameters as for :func:`pressure`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.slip_range(shakedown.long_term_state(block, 5.0), block).get_ylabel()
    'slip range [mm]'
    """
    require_plane("picture", problem)
    path = path_of(result)
    closed = (path.state != OPEN) | (path.w == 0.0)  # a node about to open is still in contact
    low = np.where(closed, path.v, np.inf).min(axis=0)
    high = np.where(closed, path.v, -np.inf).max(axis=0)
    apart = np.where(closed.any(axis=0), high - low, np.nan)
    return _along(problem, [("", apart)], with_unit("slip range", units_of(problem).length), ax)


@checked
def slip_over_patch(
    result: Recorded | EventHistory, problem: Problem, *, patch: int = 0, ax: Axes | None = None
) -> Axes:
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
    require_space("picture of a patch", problem)
    label = with_unit("accumulated slip", units_of(problem).length)
    return _over(problem, slip_of_nodes(result, problem), label, patch, ax)


@checked
def dissipation_along(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    node_area: FloatArray | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Friction work of each node along a path, along the contact; per area where areas are known.

    Parameters as for :func:`pressure`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.dissipation_along(shakedown.long_term_state(block, 5.0), block).get_ylabel()
    'friction work [N mm]'
    """
    require_plane("picture", problem)
    work, label = _work(result, problem, node_area)
    return _along(problem, [("", work)], label, ax)


@checked
def work_over_patch(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    node_area: FloatArray | None = None,
    patch: int = 0,
    ax: Axes | None = None,
) -> Axes:
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
    require_space("picture of a patch", problem)
    return _over(problem, *_work(result, problem, node_area), patch, ax)


def normal_reactions(
    what: str, p: FloatArray, problem: Problem, node_area: FloatArray | None = None
) -> Numbers:
    """Normal reactions (…, n), or pressures where areas are known."""
    area, units = _areas_of(problem, node_area), units_of(problem)
    if area is None:
        return p, with_unit(what, units.force)
    named = what.replace("normal reaction p", "pressure").replace("reaction", "pressure")
    return _over_areas(p, area), with_unit(named, units.stress)


def _work(result: Recorded | EventHistory, problem: Problem, node_area: FloatArray | None) -> Numbers:
    return per_area(work_of_nodes(result), problem, node_area)


def per_area(work: FloatArray, problem: Problem, node_area: FloatArray | None = None) -> Numbers:
    """Friction work of the nodes (…, n), per area where areas are known."""
    area = _areas_of(problem, node_area)
    if area is None:
        return work, with_unit("friction work", units_of(problem).work)
    return _over_areas(work, area), with_unit("friction work per area", units_of(problem).stiffness)


def _areas_of(problem: Problem, node_area: FloatArray | None) -> FloatArray | None:
    """The areas that are given, else those of the problem, else none."""
    area = problem.node_area if node_area is None else node_area
    if area is None:
        return None
    array = real_array("node area", area)
    if array.shape != (problem.n,):
        raise UsageError(f"node area: expected shape ({problem.n},), found {array.shape}")
    return array


def _over_areas(values: FloatArray, area: FloatArray) -> FloatArray:
    """Values per area; a node without area has none."""
    with np.errstate(over="ignore"):  # where an area is almost zero
        found = np.where(area > 0, values / np.where(area > 0, area, 1.0), np.nan)
    return np.where(np.isfinite(found), found, np.nan)


def _rows(path: EventHistory, cycles: Sequence[float] | None) -> list[int]:
    """Rows of the path nearest to some times; by default those of the largest and smallest total pressure."""
    if cycles is None:
        return list(dict.fromkeys(extreme_rows(path)))
    return [int(np.abs(path.cycle - time).argmin()) for time in cycles]


def _times(path: EventHistory, rows: Sequence[int]) -> list[str]:
    return list(map(time_in_words, path.cycle[rows].tolist()))


def _along(
    problem: Problem,
    lines: Iterable[tuple[str, FloatArray]],
    label: str,
    ax: Axes | None,
    styles: Mapping[str, Style] | None = None,
) -> Axes:
    """One line per name, (n,), along the contact; broken between flanks."""
    axes, (x, where) = axes_for(ax), positions(problem, problem.n)
    for k, (name, values) in enumerate(lines):
        look: dict[str, Any] = {"marker": ".", "ms": 4, "lw": 1.2} | style_of(name, k, styles)
        for part in flanks(x):
            axes.plot(x[part], np.asarray(values)[part], **look)
            look["label"] = "_nolegend_"
    axes.ticklabel_format(axis="y", scilimits=(-2, 3))
    if problem.x is None:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    return finished(axes, where, label)


def _over(
    problem: Problem, of_nodes: FloatArray, label: str, patch: int, ax: Axes | None, title: str = ""
) -> Axes:
    """Values over a patch in colours; over the numbers of the nodes where there is no patch."""
    places = places_of(problem, patch)
    values, title = of_nodes[places.nodes], places.titled(title)
    if places.in_a_row:
        return _over_row(places, values, label, ax, title)
    axes, (x, y) = patch_axes(places, ax, 0.0), places.points.T
    scale = ScalarMappable(Normalize(*_ends(of_nodes)), COLOURS)
    known, mesh = np.isfinite(values), places.triangles
    whole = None if mesh is None else mesh.triangles[known[mesh.triangles].all(axis=1)]
    if whole is not None and len(whole):
        levels = MaxNLocator(nbins=10).tick_values(*_ends(of_nodes))
        scale.set_norm(Normalize(levels[0], levels[-1]))
        inside = np.clip(np.where(known, values, 0.0), levels[0], levels[-1])  # an open node may have −1e-17
        axes.tricontourf(Triangulation(x, y, whole), inside, levels, cmap=COLOURS)
        axes.scatter(x, y, s=6.0, color=GREY, lw=0, zorder=3)
        known = known & ~np.isin(np.arange(len(values)), whole)
    axes.scatter(x[known], y[known], s=60.0, color=scale.to_rgba(values[known]), lw=0, zorder=3)
    _colour_scale(axes, scale, label)
    axes.set_title(title, fontsize="medium")
    return axes


def _ends(values: FloatArray) -> tuple[float, float]:
    """The ends of the scale: from zero, or from the smallest value where that is negative."""
    known = values[np.isfinite(values)]
    low, high = float(known.min(initial=0.0)), float(known.max(initial=0.0))
    return (low, high) if high > low else (0.0, 1.0)


def _colour_scale(axes: Axes, scale: ScalarMappable, label: str) -> None:
    beside = axes.inset_axes(BAR)
    bar = axes.figure.colorbar(scale, cax=beside)
    bar.set_label(label.replace(" [", "\n[") if len(label) > LONG else label)
    bar.outline.set_visible(False)
    beside.yaxis.set_major_locator(MaxNLocator(6))
    beside.ticklabel_format(axis="y", scilimits=(-2, 3))


def _over_row(places: Places, values: FloatArray, label: str, ax: Axes | None, title: str) -> Axes:
    """Values over a row of nodes."""
    axes = axes_for(ax)
    axes.plot(places.points[:, 0], values, "o", ms=5, color=BLUE)
    axes.set_ylim(*np.array(_ends(values)) * 1.08)
    axes.ticklabel_format(axis="y", scilimits=(-2, 3))
    if places.axes[0] == "node":
        axes.xaxis.set_major_locator(MaxNLocator(9, integer=True, min_n_ticks=1))
    return finished(axes, with_unit(places.axes[0], places.unit), label, title=title)
