"""Along a contact in the plane: pressures, use of friction, slips and work, and its zones over time."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, NoNorm
from matplotlib.patches import Patch

from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import with_unit
from shakedown.ground.status import OPEN
from shakedown.joint.arguments import checked, require_plane, require_problem
from shakedown.joint.contact_surface import flanks
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.event_history import EventHistory
from shakedown.plot import paths, style
from shakedown.plot.over_patch import pressure_over_patch
from shakedown.plot.patch_places import in_space
from shakedown.plot.paths import Recorded
from shakedown.plot.style import axes_for, finished, positions, style_of

Times = Sequence[float] | None  # in cycles; by default of the largest and of the smallest total pressure


@checked
def pressure(
    result: Recorded, problem: Problem, *, cycles: Times = None, patch: int = 0, ax: Axes | None = None
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
        return pressure_over_patch(result, problem, cycle, patch=patch, ax=ax)
    path = paths.path_of(result)
    rows = _rows(path, cycles)
    values, label = paths.normal_reactions("normal reaction p", path.p[list(rows.values())], problem)
    return _along(problem, zip(rows, values, strict=True), label, ax)


@checked
def friction_use(result: Recorded, problem: Problem, *, cycles: Times = None, ax: Axes | None = None) -> Axes:
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
    path = paths.path_of(result)
    use = path.q / np.where(paths.pressed(problem, path), problem.law.limit(path.p), np.nan)
    lines = ((time, use[row]) for time, row in _rows(path, cycles).items())
    axes = _along(problem, lines, "use of friction q / f p [–]", ax)
    for limit in (-1.0, 1.0):
        axes.axhline(limit, color=style.BLACK, lw=0.8, ls="--")
    axes.set(ylim=(-1.15, 1.15))
    return axes


@checked
def slip_along(
    slips: Mapping[str, FloatArray], problem: Problem, *, what: str = "slip v", ax: Axes | None = None
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
    return _along(problem, slips.items(), with_unit(what, units_of(problem).length), ax)


@checked
def slip_range(result: Recorded, problem: Problem, *, ax: Axes | None = None) -> Axes:
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
    path = paths.path_of(result)
    closed = (path.state != OPEN) | (path.w == 0.0)  # a node about to open is still in contact
    low = np.where(closed, path.v, np.inf).min(axis=0)
    high = np.where(closed, path.v, -np.inf).max(axis=0)
    apart = np.where(closed.any(axis=0), high - low, np.nan)
    return _along(problem, [("", apart)], with_unit("slip range", units_of(problem).length), ax)


@checked
def dissipation_along(result: Recorded, problem: Problem, *, ax: Axes | None = None) -> Axes:
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
    work, label = paths.work_and_name(paths.work_of_nodes(result), problem)
    return _along(problem, [("", work)], label, ax)


@checked
def zones(
    result: Recorded, problem: Problem | None = None, *, marks: bool = True, ax: Axes | None = None
) -> Axes:
    """Stick, slip and open zones over position and time (like the thesis's figs. 3.2, 3.7).

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        For positions, units, and the friction that ``marks`` needs.
    marks
        Whether to mark where nodes that never slip are at their limit.
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
    >>> axes = plot.zones(shakedown.long_term_state(block, 5.0), block)
    >>> axes.get_ylabel(), axes.get_xlabel()
    ('time [cycles]', 'position along the contact [mm]')
    """
    path = paths.path_in_the_plane(result, problem)
    x, label = positions(problem, path.v.shape[1])
    keep = np.append(np.diff(path.cycle) > 0, True)  # the last of several events at one instant
    time, state = path.cycle[keep], path.state[keep]
    if len(time) < 2:
        raise UsageError("result: expected events at two instants or more, found one")
    kinds = list(style.STATES)
    image = np.vectorize(kinds.index)(state[:-1])
    colours = ListedColormap([style.STATES[kind][1] for kind in kinds])
    axes, scale = axes_for(ax, (6.0, 4.8)), NoNorm(0, len(kinds) - 1)
    for part in flanks(x):
        axes.pcolormesh(_edges(x[part]), time, image[:, part], cmap=colours, norm=scale, rasterized=True)
    for left, right in pairwise(flanks(x)):
        gap = _edges(x[left])[-1], _edges(x[right])[0]
        axes.axvspan(*gap, fill=False, edgecolor=style.GREY, hatch="///", lw=0)
    seen = [style.STATES[kind] for k, kind in enumerate(kinds) if (image == k).any()]
    handles: list[Any] = [Patch(fc=face, ec=style.BLACK, lw=0.6, label=name) for name, face in seen]
    if marks and problem is not None:
        handles += _mark_limits(axes, path, problem, x)
    finished(axes, label, "time [cycles]").grid(visible=False)
    axes.legend(handles=handles, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    return axes


def _rows(path: EventHistory, cycles: Times) -> dict[str, int]:
    """Instants in words, and the rows nearest to them; by default of the largest and least total pressure."""
    rows = list(paths.extreme_rows(path)[:2])
    if cycles is not None:
        rows = [int(np.abs(path.cycle - time).argmin()) for time in cycles]
    return {paths.time_in_words(float(path.cycle[row])): row for row in rows}


def _along(problem: Problem, lines: Iterable[tuple[str, FloatArray]], label: str, ax: Axes | None) -> Axes:
    """One line per name, (n,), along the contact; broken between flanks."""
    axes, (x, where) = axes_for(ax), positions(problem, problem.n)
    for k, (name, values) in enumerate(lines):
        look: dict[str, Any] = {"marker": ".", "ms": 4, "lw": 1.2} | style_of(name, k)
        for part in flanks(x):
            axes.plot(x[part], np.asarray(values)[part], **look)
            look["label"] = "_nolegend_"
    return finished(axes, where, label)


def _mark_limits(axes: Axes, path: EventHistory, problem: Problem, x: FloatArray) -> list[Any]:
    """Dots where a node that never slips is at its limit; the entry of the legend, if there are any."""
    limit = problem.law.limit(path.p)
    noise = NEGLIGIBLE * float(np.abs(limit).max())
    still = ~path.slips() & (path.state != OPEN).all(axis=0)
    rows, nodes = np.nonzero(still & (np.abs(np.abs(path.q) - limit) <= noise) & (limit > noise))
    # visible on “stick” and on the page, light or dark
    look: dict[str, Any] = {"color": "#D01C8B", "ms": 3, "label": "at the limit, not slipping"}
    return list(axes.plot(x[nodes], path.cycle[rows], ".", **look)) if len(rows) else []


def _edges(x: FloatArray) -> FloatArray:
    """Cell borders half-way between neighbouring nodes."""
    if len(x) == 1:
        return np.array([x[0] - 0.5, x[0] + 0.5])
    middle = 0.5 * (x[1:] + x[:-1])
    return np.concatenate([[2 * x[0] - middle[0]], middle, [2 * x[-1] - middle[-1]]])
