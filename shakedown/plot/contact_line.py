"""What happens along the contact: pressure, use of friction, stick and slip zones, slips."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from shakedown.errors import UsageError
from shakedown.evolution.event_history import EventHistory
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.units import units_of
from shakedown.plot.style import (
    BLACK,
    STATES,
    Recorded,
    Style,
    axes_for,
    flanks,
    labelled,
    path_of,
    positions,
    style_of,
)

AT_THE_LIMIT = 1e-9  # how far from its limit, relative, a stuck node counts as being there


def pressure(
    result: Recorded,
    problem: Problem,
    *,
    cycles: Sequence[float] | None = None,
    node_area: FloatArray | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Normal reactions along the contact, at chosen instants; tractions where node areas are given.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        The joint: positions and units.
    cycles
        Times in cycles; by default when the total is largest and when it is smallest.
    node_area : (n,), optional
        Area of each node [length²]: reactions are divided by it.
    ax
        Where to draw.

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
    path = path_of(result)
    force, length = units_of(problem)
    area = np.ones(problem.n) if node_area is None else np.asarray(node_area, dtype=float)
    axes = axes_for(ax)
    for k, row in enumerate(_instants(path, cycles)):
        _along(axes, problem, path.p[row] / area, _at_time(path, row, k))
    unit = f"{force}/{length}²" if node_area is not None and force else force
    what = "normal reaction p" if node_area is None else "pressure"
    axes.set(xlabel=positions(problem, problem.n)[1], ylabel=labelled(what, unit))
    return _finished(axes, problem)


def friction_use(
    result: Recorded, problem: Problem, *, cycles: Sequence[float] | None = None, ax: Axes | None = None
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
    path = path_of(result)
    axes = axes_for(ax)
    for k, row in enumerate(_instants(path, cycles)):
        limit = problem.f * path.p[row]
        with np.errstate(divide="ignore", invalid="ignore"):
            use = np.where((path.state[row] != 2) & (limit > 0), path.q[row] / limit, np.nan)
        _along(axes, problem, use, _at_time(path, row, k))
    for limit in (-1.0, 1.0):
        axes.axhline(limit, color=BLACK, lw=0.8, ls="--")
    axes.set(
        xlabel=positions(problem, problem.n)[1], ylabel="use of friction q / f p [–]", ylim=(-1.15, 1.15)
    )
    return _finished(axes, problem)


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
        Where to draw.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.slip_along({"safe slip": shakedown.upper_bound(block).slip}, block).get_ylabel()
    'slip v [mm]'
    """
    axes = axes_for(ax)
    for k, (name, slip) in enumerate(slips.items()):
        _along(axes, problem, np.asarray(slip), style_of(name, k, styles))
    axes.set(xlabel=positions(problem, problem.n)[1], ylabel=labelled(what, units_of(problem)[1]))
    axes.ticklabel_format(axis="y", scilimits=(-2, 3))
    return _finished(axes, problem)


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
        Where to draw.

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
    path = path_of(result)
    x, label = positions(problem, path.v.shape[1])
    order = np.argsort(x, kind="stable")
    keep = np.append(np.diff(path.cycle) > 0, True)  # of several events at one instant the last
    time, state = path.cycle[keep], path.state[keep][:, order]
    if len(time) < 2:
        raise UsageError("result: expected events at two instants or more, found one")
    kinds = list(STATES)
    image = np.vectorize(kinds.index)(state[:-1])
    axes = axes_for(ax, (6.0, 4.8))
    axes.pcolormesh(
        _edges(x[order]), time, image, cmap=ListedColormap([STATES[kind][1] for kind in kinds]),
        vmin=-0.5, vmax=len(kinds) - 0.5, shading="flat", rasterized=True,
    )  # fmt: skip
    seen = [kind for k, kind in enumerate(kinds) if (image == k).any()]
    handles = [Patch(facecolor=STATES[k][1], edgecolor=BLACK, lw=0.6, label=STATES[k][0]) for k in seen]
    if marks and problem is not None:
        handles += _mark_limits(axes, path, problem, x)
    axes.set(xlabel=label, ylabel="time [cycles]")
    if problem is None or problem.x is None:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.legend(handles=handles, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.14), ncols=3)
    return axes


def _mark_limits(axes: Axes, path: EventHistory, problem: Problem, x: FloatArray) -> list:
    """Dots where a node that never slips is at its limit; the entry of the legend, if there are any."""
    limit = problem.f * path.p
    noise = AT_THE_LIMIT * float(np.abs(limit).max())
    still = (path.state == 0).all(axis=0)
    rows, nodes = np.nonzero(still & (np.abs(np.abs(path.q) - limit) <= noise) & (limit > noise))
    if len(rows) == 0:
        return []
    return list(axes.plot(x[nodes], path.cycle[rows], "k.", ms=2.5, label="at the limit, not slipping"))


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


def _edges(x: FloatArray) -> FloatArray:
    """Cell borders half-way between neighbouring nodes."""
    if len(x) == 1:
        return np.array([x[0] - 0.5, x[0] + 0.5])
    middle = 0.5 * (x[1:] + x[:-1])
    return np.concatenate([[2 * x[0] - middle[0]], middle, [2 * x[-1] - middle[-1]]])


def _finished(axes: Axes, problem: Problem) -> Axes:
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    if problem.x is None:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    return axes
