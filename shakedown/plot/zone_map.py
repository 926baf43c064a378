"""Stick, slip and open zones over position and time."""

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.status import OPEN
from shakedown.joint.arguments import checked
from shakedown.joint.contact_surface import flanks
from shakedown.joint.problem import Problem
from shakedown.motion.event_history import EventHistory
from shakedown.plot.drawn_path import Recorded, path_in_the_plane
from shakedown.plot.style import BLACK, GREY, STATES, axes_for, positions

DOTS = "#D01C8B"  # visible on “stick” and on the page, light or dark


@checked
def zones(
    result: Recorded | EventHistory,
    problem: Problem | None = None,
    *,
    marks: bool = True,
    ax: Axes | None = None,
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
    path = path_in_the_plane(result, problem)
    x, label = positions(problem, path.v.shape[1])
    order = np.argsort(x, kind="stable")
    keep = np.append(np.diff(path.cycle) > 0, True)  # the last of several events at one instant
    time, state = path.cycle[keep], path.state[keep][:, order]
    if len(time) < 2:
        raise UsageError("result: expected events at two instants or more, found one")
    kinds = list(STATES)
    image = np.vectorize(kinds.index)(state[:-1])
    colours = ListedColormap([STATES[kind][1] for kind in kinds])
    axes, first = axes_for(ax, (6.0, 4.8)), 0
    for part in flanks(x):  # no contact between two flanks
        columns = slice(first, first + len(part))
        axes.pcolormesh(
            _edges(x[part]), time, image[:, columns], cmap=colours, vmin=-0.5, vmax=len(kinds) - 0.5,
            shading="flat", rasterized=True,
        )  # fmt: skip
        first += len(part)
    for left, right in pairwise(flanks(x)):
        gap = _edges(x[left])[-1], _edges(x[right])[0]
        axes.axvspan(*gap, fill=False, edgecolor=GREY, hatch="///", lw=0)
    seen = [kind for k, kind in enumerate(kinds) if (image == k).any()]
    handles = [Patch(facecolor=STATES[k][1], edgecolor=BLACK, lw=0.6, label=STATES[k][0]) for k in seen]
    if marks and problem is not None:
        handles += _mark_limits(axes, path, problem, x)
    axes.set(xlabel=label, ylabel="time [cycles]")
    if problem is None or problem.x is None:
        axes.xaxis.set_major_locator(MaxNLocator(min(path.v.shape[1], 9), integer=True, min_n_ticks=1))
    axes.legend(handles=handles, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    return axes


def _mark_limits(axes: Axes, path: EventHistory, problem: Problem, x: FloatArray) -> list[Any]:
    """Dots where a node that never slips is at its limit; the entry of the legend, if there are any."""
    limit = problem.law.limit(path.p)
    noise = NEGLIGIBLE * float(np.abs(limit).max())
    still = ~path.slips() & (path.state != OPEN).all(axis=0)
    rows, nodes = np.nonzero(still & (np.abs(np.abs(path.q) - limit) <= noise) & (limit > noise))
    if len(rows) == 0:
        return []
    return list(
        axes.plot(x[nodes], path.cycle[rows], ".", color=DOTS, ms=3, label="at the limit, not slipping")
    )


def _edges(x: FloatArray) -> FloatArray:
    """Cell borders half-way between neighbouring nodes."""
    if len(x) == 1:
        return np.array([x[0] - 0.5, x[0] + 0.5])
    middle = 0.5 * (x[1:] + x[:-1])
    return np.concatenate([[2 * x[0] - middle[0]], middle, [2 * x[-1] - middle[-1]]])
