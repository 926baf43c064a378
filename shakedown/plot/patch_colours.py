"""One number per node over a patch: pressure, ways of slip, friction work."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation

from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import stress_unit, units_of, work_unit
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory
from shakedown.plot.contact_line import areas_of, over_areas
from shakedown.plot.patch_places import Places, patch_axes, places_of, require_space
from shakedown.plot.style import BLUE, GREY, Recorded, axes_for, path_of

COLOURS, LEVELS = "viridis", 10
LONG = 24  # characters of a label: the unit of a longer one stands below it
BAR = (1.04, 0.0, 0.045, 1.0)  # of the axes: the scale of colours beside them
DOT, SPOT = 3.0, 60.0  # areas of markers [points²]: between colours, and coloured themselves


@checked
def pressure_over_patch(
    result: Recorded | EventHistory,
    problem: Problem,
    cycle: float | None = None,
    *,
    node_area: FloatArray | None = None,
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
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, the time lies outside them, or the joint has one direction.

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
    axes = _normal("normal reaction p", now.p[0], problem, node_area, ax)
    axes.set_title(title, fontsize="medium")
    return axes


@checked
def welded_pressure_over_patch(
    problem: Problem, *, node_area: FloatArray | None = None, ax: Axes | None = None
) -> Axes:
    """Mean normal welded reactions p_w over a patch; pressures where node areas are known.

    Parameters
    ----------
    problem
        A joint with two directions, and its loading.
    node_area, ax
        As for :func:`pressure_over_patch`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> plot.welded_pressure_over_patch(shakedown.example("four-node-3d")).get_ylabel()
    'mean welded reaction p_w'
    """
    require_space("picture of a patch", problem)
    return _normal("mean welded reaction p_w", loading(problem).p0, problem, node_area, ax)


@checked
def slip_over_patch(result: Recorded | EventHistory, problem: Problem, *, ax: Axes | None = None) -> Axes:
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
    slip = slip_of_nodes(result, problem)
    return _field(places_of(problem), slip, with_unit("accumulated slip", units_of(problem)[1]), ax)


@checked
def work_over_patch(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    node_area: FloatArray | None = None,
    ax: Axes | None = None,
) -> Axes:
    """What friction takes at each node along a path, over a patch; per area where areas are known.

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
    work, area = work_of_nodes(result, problem), areas_of(problem, node_area)
    force, length = units_of(problem)
    if area is None:
        label = with_unit("friction work", work_unit(force, length))
    else:
        work = over_areas(work, area)
        label = with_unit("friction work per area", f"{force}/{length}" if force and length else "")
    return _field(places_of(problem), work, label, ax)


def at_instant(path: EventHistory, cycle: float | None) -> tuple[EventHistory, str]:
    """The state at a time, by default when the total pressure is largest, and what a picture calls it."""
    time = float(path.cycle[extreme_rows(path)[0]]) if cycle is None else cycle
    return path.at(np.array([time])), f"t = {time:.4g} cycles"


def extreme_rows(path: EventHistory) -> tuple[int, int]:
    """The rows with the largest and the smallest total pressure, once the first period has begun."""
    begun = path.cycle >= 0
    total = np.where(begun if begun.any() else True, path.p.sum(axis=1), np.nan)
    return int(np.nanargmax(total)), int(np.nanargmin(total))


def slip_of_nodes(result: Recorded | EventHistory, problem: Problem) -> FloatArray:
    """Σ|Δv| in contact along a path, (n,) [length]."""
    if isinstance(result, LongTermState) and result.period:
        return np.asarray(result.slip_per_cycle)
    path = path_of(result).refined()
    steps = problem.law.size(np.diff(path.v, axis=0))
    return np.asarray(np.where(path.state[:-1] != 2, steps, 0.0).sum(axis=0))


def work_of_nodes(result: Recorded | EventHistory, problem: Problem) -> FloatArray:
    """−∫ q dv in contact along a path, (n,) [force × length]: of a long-term state as it was integrated."""
    if isinstance(result, LongTermState) and result.period:
        return np.asarray(result.period * result.work_per_cycle)
    path = path_of(result).refined()
    steps = -0.5 * (path.q[1:] + path.q[:-1]) * np.diff(path.v, axis=0)
    work = problem.layout.by_node(steps).sum(axis=-1)
    return np.asarray(np.where(path.state[:-1] != 2, work, 0.0).sum(axis=0))


def _normal(
    what: str, p: FloatArray, problem: Problem, node_area: FloatArray | None, ax: Axes | None
) -> Axes:
    """Normal reactions, or pressures where areas are known."""
    area, (force, length) = areas_of(problem, node_area), units_of(problem)
    if area is None:
        return _field(places_of(problem), p, with_unit(what, force), ax)
    named = what.replace("normal reaction p", "pressure").replace("reaction", "pressure")
    return _field(places_of(problem), over_areas(p, area), with_unit(named, stress_unit(force, length)), ax)


def _field(places: Places, values: FloatArray, label: str, ax: Axes | None) -> Axes:
    """Values over the patch in colours; over the numbers of the nodes where there is no patch."""
    if places.in_a_row:
        return _over_row(places, values, label, ax)
    axes, (x, y) = patch_axes(places, ax, 0.0), places.points.T
    scale = ScalarMappable(Normalize(*_ends(values)), COLOURS)
    known, mesh = np.isfinite(values), places.triangles
    whole = None if mesh is None else mesh.triangles[known[mesh.triangles].all(axis=1)]
    if whole is not None and len(whole):
        levels = MaxNLocator(LEVELS).tick_values(*_ends(values))
        scale.set_norm(Normalize(levels[0], levels[-1]))
        patch = Triangulation(x, y, whole)
        inside = np.clip(np.where(known, values, 0.0), levels[0], levels[-1])  # −1e-17 of an open node
        axes.tricontourf(patch, inside, levels, cmap=COLOURS)
        axes.scatter(x, y, s=DOT, color=GREY, lw=0, zorder=3)
        known = known & ~np.isin(np.arange(len(values)), whole)
    axes.scatter(x[known], y[known], s=SPOT, color=scale.to_rgba(values[known]), lw=0, zorder=3)
    _colour_scale(axes, scale, label)
    return axes


def _ends(values: FloatArray) -> tuple[float, float]:
    """The ends of the scale: from zero, or what is below."""
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


def _over_row(places: Places, values: FloatArray, label: str, ax: Axes | None) -> Axes:
    """Values over a row of nodes."""
    axes = axes_for(ax)
    axes.plot(places.points[:, 0], values, "o", ms=5, color=BLUE)
    axes.set(xlabel=with_unit(places.axes[0], places.unit), ylabel=label)
    axes.set_ylim(*np.array(_ends(values)) * 1.08)
    axes.ticklabel_format(axis="y", scilimits=(-2, 3))
    if places.axes[0] == "node":
        axes.xaxis.set_major_locator(MaxNLocator(9, integer=True, min_n_ticks=1))
    axes.grid(alpha=0.3)
    return axes
