"""What happens along the contact: pressure, use of friction, slips, dissipation."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked, real_array, require_plane
from shakedown.joint.problem import Problem
from shakedown.joint.units import stress_unit, units_of, work_unit
from shakedown.motion.event_history import EventHistory
from shakedown.plot.loops import friction_work
from shakedown.plot.style import (
    BLACK,
    Recorded,
    Style,
    axes_for,
    flanks,
    path_of,
    positions,
    pressed,
    style_of,
)


@checked
def pressure(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    cycles: Sequence[float] | None = None,
    node_area: FloatArray | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Normal reactions along the contact, at chosen instants; pressures where node areas are known.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        The joint: positions and units.
    cycles
        Times in cycles; by default when the total is largest and when it is smallest.
    node_area : (n,), optional
        Area of each node [length²]: reactions are divided by it. By default the problem's own.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.pressure(shakedown.long_term_state(block, 1.0), block).get_ylabel()
    'normal reaction p [N]'
    """
    require_plane("picture", problem)
    path, area = path_of(result), areas_of(problem, node_area)
    force, length = units_of(problem)
    axes = axes_for(ax)
    for k, row in enumerate(_instants(path, cycles)):
        values = path.p[row] if area is None else over_areas(path.p[row], area)
        _along(axes, problem, values, _at_time(path, row, k))
    unit = force if area is None else stress_unit(force, length)
    what = "normal reaction p" if area is None else "pressure"
    return _finished(axes, problem, with_unit(what, unit))


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
    axes, most = axes_for(ax), np.where(pressed(problem, path), problem.law.limit(path.p), np.nan)
    for k, row in enumerate(_instants(path, cycles)):
        use = path.q[row] / most[row]
        _along(axes, problem, use, _at_time(path, row, k))
    for limit in (-1.0, 1.0):
        axes.axhline(limit, color=BLACK, lw=0.8, ls="--")
    axes.set(ylim=(-1.15, 1.15))
    return _finished(axes, problem, "use of friction q / f p [–]")


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
    axes = axes_for(ax)
    for k, (name, slip) in enumerate(slips.items()):
        _along(axes, problem, np.asarray(slip), style_of(name, k, styles))
    return _finished(axes, problem, with_unit(what, units_of(problem)[1]))


@checked
def slip_range(result: Recorded | EventHistory, problem: Problem, *, ax: Axes | None = None) -> Axes:
    """How far each node slips back and forth in contact, max v − min v over a path, along the contact.

    Of nodes that are never closed nothing is drawn. Parameters as for :func:`pressure`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.slip_range(shakedown.long_term_state(block, 5.0), block).get_ylabel()
    'slip range [mm]'
    """
    require_plane("picture", problem)
    path, axes = path_of(result), axes_for(ax)
    closed = (path.state != 2) | (path.w == 0.0)  # a node that is about to open is in contact still
    low = np.where(closed, path.v, np.inf).min(axis=0)
    high = np.where(closed, path.v, -np.inf).max(axis=0)
    _along(axes, problem, np.where(closed.any(axis=0), high - low, np.nan), style_of("", 0, None))
    return _finished(axes, problem, with_unit("slip range", units_of(problem)[1]))


@checked
def dissipation_along(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    node_area: FloatArray | None = None,
    ax: Axes | None = None,
) -> Axes:
    """What friction takes at each node along a path, along the contact; per area where areas are known.

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
    path, axes = path_of(result), axes_for(ax)
    area, (force, length) = areas_of(problem, node_area), units_of(problem)
    work = friction_work(path) if area is None else over_areas(friction_work(path), area)
    _along(axes, problem, work, style_of("", 0, None))
    if area is None:
        label = with_unit("friction work", work_unit(force, length))
    else:
        label = with_unit("friction work per area", f"{force}/{length}" if force and length else "")
    return _finished(axes, problem, label)


def areas_of(problem: Problem, node_area: FloatArray | None) -> FloatArray | None:
    """The areas that are given, else those of the problem, else none."""
    area = problem.node_area if node_area is None else node_area
    if area is None:
        return None
    array = real_array("node area", area)
    if array.shape != (problem.n,):
        raise UsageError(f"node area: expected shape ({problem.n},), found {array.shape}")
    return array


def over_areas(values: FloatArray, area: FloatArray) -> FloatArray:
    """Values per area; a node without area has none."""
    with np.errstate(over="ignore"):  # of an area next to nothing
        found = np.where(area > 0, values / np.where(area > 0, area, 1.0), np.nan)
    return np.where(np.isfinite(found), found, np.nan)


def _instants(path: EventHistory, cycles: Sequence[float] | None) -> list[int]:
    """Rows of the path nearest to some times; by default those of the largest and smallest total pressure."""
    if cycles is None:
        total = path.p.sum(axis=1)
        return list(dict.fromkeys([int(total.argmax()), int(total.argmin())]))
    return [int(np.abs(path.cycle - time).argmin()) for time in cycles]


def _at_time(path: EventHistory, row: int, k: int) -> Style:
    return style_of(f"t = {path.cycle[row]:.4g} cycles", k, None)


def _along(axes: Axes, problem: Problem, values: FloatArray, style: Style) -> None:
    """One line per flank."""
    x, _ = positions(problem, problem.n)
    look: dict[str, Any] = {"marker": ".", "ms": 4, "lw": 1.2} | dict(style)
    for part in flanks(x):
        axes.plot(x[part], values[part], **look)
        look["label"] = "_nolegend_"


def _finished(axes: Axes, problem: Problem, quantity: str) -> Axes:
    axes.set(xlabel=positions(problem, problem.n)[1], ylabel=quantity)
    axes.grid(alpha=0.3)
    axes.ticklabel_format(axis="y", scilimits=(-2, 3))
    if axes.get_legend_handles_labels()[1]:
        axes.legend(fontsize="small")
    if problem.x is None:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    return axes
