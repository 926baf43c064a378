"""Maps of initial states: what becomes of each, in the plane of two slips; the share that shakes down."""

from math import isqrt
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import at_lambda, with_unit
from shakedown.joint.arguments import checked
from shakedown.joint.result import Result
from shakedown.joint.units import units_of
from shakedown.plot import style
from shakedown.plot.paths import of_kind
from shakedown.plot.style import axes_for, finished, node_name


@checked
def basin(found: Result, *, ax: Axes | None = None) -> Axes:
    """Which initial slips shake down, and what the others dissipate (thesis §7.2.1).

    Separation, where nodes open and close and none slips in contact, has a colour of its own. The
    cells of a grid are filled, other states are dots. Slip zero, the given and the critical state have
    marks of their own, with what becomes of them.

    Parameters
    ----------
    found
        A map of initial states.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If the joint has one node only.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> found = shakedown.initial_state_map(shakedown.example("two-node"), 0.7, states=16, sampler="grid")
    >>> plot.basin(found).get_xlabel()
    'initial slip of node 0'
    """
    named = {"zero": ("slip zero", "P"), "given": ("given", "D"), "critical": ("critical state", "*")}
    states = of_kind(found, "InitialStateMap")
    problem, sampling, size = states.problem, states.sampling, states.problem.layout.slip_size
    if size < 2:
        raise UsageError("picture of a map: expected a joint of two nodes or more, found one node")
    axes, units, pair = axes_for(ax, (6.6, 5.4)), units_of(problem), list(sampling.coordinates)
    points = np.asarray(states.initial_slip)[:, pair]
    label = with_unit("dissipation per cycle", units.work)
    handles = _draw_states(axes, states, points[states.sampled], label)
    low, high = points.min(axis=0), points.max(axis=0)
    margin = np.where(high > low, style.MARGIN * (high - low), 1.0)
    low, high = low - margin, high + margin
    d = problem.directions
    slips = [node_name(k // d, problem) + ("" if d == 1 else f" along {'xy'[k % d]}") for k in pair]
    names = [with_unit(f"initial slip of {slip}", units.length) for slip in slips]
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel=names[0], ylabel=names[1])
    look: dict[str, Any] = {"mec": style.BLACK, "ls": "none", "clip_on": False, "ms": 9}
    hollow = look | {"mfc": "none", "path_effects": [withStroke(linewidth=3.0, foreground="white")]}
    handles += axes.plot(*sampling.centre[pair], "o", label=sampling.centre_is, zorder=3, **hollow)
    for name, point, outcome in zip(sampling.named, points, states.outcome, strict=False):
        word, mark = named[name]
        label = f"{word}{', projected' * (size > 2)}: {str(outcome).replace('-', ' ')}"
        handles += axes.plot(*point, mark, label=label, mfc="white", zorder=5, **look)
    rest = size - 2 if sampling.sampler != "grid" else 0
    others = f"; the other {f'{rest} slips vary' if rest > 1 else 'slip varies'} too" if rest else ""
    axes.set_title(f"{at_lambda(states.load_factor)}{others}", fontsize="medium")
    axes.legend(handles=handles, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)
    return axes


def _draw_states(axes: Axes, found: Any, points: FloatArray, label: str) -> list[Any]:
    """Draw every state by its outcome, with a colour bar; returns entries of the legend."""
    outcome, period, dissipation = (
        np.asarray(x)[found.sampled] for x in (found.outcome, found.period, found.dissipation)
    )
    resting, undecided = outcome == "shakedown", outcome == "undecided"
    separation, leaving = outcome == "separation", (period == 0) & ~undecided
    moving = ~resting & ~undecided & ~separation
    colours = np.ma.masked_array(dissipation, mask=~(moving & ~np.isnan(dissipation)))
    kinds = (
        (resting, style.STATES[0][1], "shakes down"),
        (undecided, style.RED, "undecided"),
        (separation & ~leaving, style.SKY, "separation: opens and closes, no slip in contact"),
        (leaving, style.PURPLE, "leaves contact"),
    )
    for mask, colour, _ in kinds:
        ones = np.ma.masked_array(np.ones(len(points)), mask=~mask)
        _drawn(found, axes, points, ones, cmap=ListedColormap([colour]))
    if colours.count():
        least, most = float(colours.min()), float(colours.max())
        scale = Normalize(0.0 if resting.any() or least == most else least, most or 1.0)
        # perceptually uniform, also with colour-blindness
        shown = _drawn(found, axes, points, colours, cmap="cividis_r", norm=scale)
        axes.figure.colorbar(shown, ax=axes, label=label)
    return [Patch(fc=colour, label=name) for mask, colour, name in kinds if mask.any()]


def _drawn(found: Any, axes: Axes, points: FloatArray, values: Any, **look: Any) -> ScalarMappable:
    """Draw states: those of a square grid as cells, others as dots, smaller where there are more of them."""
    if found.sampling.sampler == "grid" and found.sampling.side > 1:
        side = isqrt(len(points))
        cells = points[:side, 0], points[::side, 1], values.reshape(side, side)
        return axes.pcolormesh(*cells, shading="nearest", rasterized=True, **look)
    size = float(np.clip(4000.0 / len(points), 1.0, 12.0))
    x, y = points[~values.mask].T
    return axes.scatter(x, y, s=size, c=values.compressed(), lw=0, rasterized=True, **look)


@checked
def shakedown_share(found: Result, *, ax: Axes | None = None) -> Axes:
    """The share of initial states that shakes down against the load factor, with its confidence interval.

    Parameters
    ----------
    found
        Maps of initial states at several load factors.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> maps = shakedown.initial_state_map(shakedown.example("two-node"), [0.6, 0.8], states=8)
    >>> plot.shakedown_share(maps).get_xlabel()
    'load factor λ'
    """
    axes, maps = axes_for(ax), of_kind(found, "InitialStateMaps")
    percent, interval = 100.0 * maps.shakedown_fraction, 100.0 * maps.interval
    axes.fill_between(maps.load_factors, *interval.T, color=style.BLUE, alpha=0.2, label="95 % interval")
    axes.plot(maps.load_factors, percent, "o-", color=style.BLUE, ms=4, label="shakes down")
    axes.set_ylim(-3.0, 103.0)
    return finished(axes, "load factor λ", "initial states [%]")
