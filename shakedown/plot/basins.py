"""Maps of initial states: what becomes of each, in the plane of two slips; the share that shakes down."""

from collections.abc import Collection
from math import isqrt
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke
from numpy.typing import NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import at_lambda
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.plot.style import BLACK, BLUE, MARGIN, PURPLE, RED, SKY, axes_for, finished, node_name

NAMED = {"zero": ("slip zero", "P"), "given": ("given", "D"), "critical": ("critical state", "*")}
RESTING = "#D9D9D9"  # states that shake down
DISSIPATION = "cividis_r"  # perceptually uniform, also with colour-blindness


class Chosen(Protocol):
    """How the states were chosen."""

    @property
    def sampler(self) -> str: ...
    @property
    def coordinates(self) -> tuple[int, int]: ...
    @property
    def side(self) -> int: ...
    @property
    def centre(self) -> FloatArray: ...
    @property
    def centre_is(self) -> str: ...
    @property
    def named(self) -> Collection[str]: ...


class Mapped(Protocol):
    """A map of initial states, as :func:`shakedown.initial_state_map` makes them."""

    @property
    def problem(self) -> Problem: ...
    @property
    def load_factor(self) -> float: ...
    @property
    def sampling(self) -> Chosen: ...
    @property
    def initial_slip(self) -> FloatArray: ...
    @property
    def outcome(self) -> NDArray[np.str_]: ...
    @property
    def period(self) -> NDArray[np.int64]: ...
    @property
    def dissipation(self) -> FloatArray: ...
    @property
    def sampled(self) -> slice: ...


class MappedRange(Protocol):
    """Maps of initial states at several load factors."""

    @property
    def load_factors(self) -> FloatArray: ...
    @property
    def shakedown_fraction(self) -> FloatArray: ...
    @property
    def interval(self) -> FloatArray: ...


@checked
def basin(found: Mapped, *, ax: Axes | None = None) -> Axes:
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
    if found.problem.layout.slip_size < 2:
        raise UsageError("picture of a map: expected a joint of two nodes or more, found one node")
    axes = axes_for(ax, (6.6, 5.4))
    units = units_of(found.problem)
    pair = list(found.sampling.coordinates)
    points = np.asarray(found.initial_slip)[:, pair]
    handles = _draw_states(axes, found, points[found.sampled], with_unit("dissipation per cycle", units.work))
    low, high = points.min(axis=0), points.max(axis=0)
    margin = np.where(high > low, MARGIN * (high - low), 1.0)
    axes.set_xlim(low[0] - margin[0], high[0] + margin[0])
    axes.set_ylim(low[1] - margin[1], high[1] + margin[1])
    plane = found.problem.layout.slip_size == 2 or found.sampling.sampler == "grid"
    look: dict[str, Any] = {"mec": BLACK, "ls": "none", "clip_on": False}
    halo = [withStroke(linewidth=3.0, foreground="white")]
    centre = found.sampling.centre[pair]  # hollow: what lies under it shows
    handles += axes.plot(
        *centre, "o", label=found.sampling.centre_is, mfc="none", ms=9, zorder=3, path_effects=halo, **look
    )
    for name, point, outcome in zip(found.sampling.named, points, found.outcome, strict=False):
        word, mark = NAMED[name]
        label = (
            f"{word}{', projected' * (found.problem.layout.slip_size > 2)}: {str(outcome).replace('-', ' ')}"
        )
        handles += axes.plot(*point, mark, label=label, mfc="white", ms=9, zorder=5, **look)
    axes.set(
        xlabel=with_unit(f"initial slip of {_slip_name(pair[0], found.problem)}", units.length),
        ylabel=with_unit(f"initial slip of {_slip_name(pair[1], found.problem)}", units.length),
    )
    rest = found.problem.layout.slip_size - 2
    others = "" if plane else f"; the other {f'{rest} slips vary' if rest > 1 else 'slip varies'} too"
    axes.set_title(f"{at_lambda(found.load_factor)}{others}", fontsize="medium")
    axes.legend(handles=handles, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)
    return axes


def _slip_name(place: int, problem: Problem) -> str:
    """Which node's slip a place holds; in space also along which of its tangents."""
    d = problem.directions
    return node_name(place // d, problem) + ("" if d == 1 else f" along {'xy'[place % d]}")


def _draw_states(axes: Axes, found: Mapped, points: FloatArray, label: str) -> list[Any]:
    """Draw every state by its outcome, with a colour bar; returns entries of the legend."""
    outcome, period, dissipation = (
        np.asarray(x)[found.sampled] for x in (found.outcome, found.period, found.dissipation)
    )
    resting, undecided = outcome == "shakedown", outcome == "undecided"
    separation, leaving = outcome == "separation", (period == 0) & ~undecided
    moving = ~resting & ~undecided & ~separation
    colours = np.ma.masked_array(dissipation, mask=~(moving & ~np.isnan(dissipation)))
    kinds = (
        (resting, RESTING, "shakes down"),
        (undecided, RED, "undecided"),
        (separation & ~leaving, SKY, "separation: opens and closes, no slip in contact"),
        (leaving, PURPLE, "leaves contact"),
    )
    draw = _cells if found.sampling.sampler == "grid" and found.sampling.side > 1 else _dots
    for mask, colour, _ in kinds:
        draw(axes, points, np.ma.masked_array(np.ones(len(points)), mask=~mask), ListedColormap([colour]))
    if colours.count():
        least, most = float(colours.min()), float(colours.max())
        scale = Normalize(0.0 if resting.any() or least == most else least, most or 1.0)
        shown = draw(axes, points, colours, DISSIPATION, scale)
        axes.figure.colorbar(shown, ax=axes, label=label)
    return [Patch(fc=colour, label=name) for mask, colour, name in kinds if mask.any()]


def _cells(
    axes: Axes,
    points: FloatArray,
    values: np.ma.MaskedArray,
    colours: str | Colormap,
    scale: Normalize | None = None,
) -> ScalarMappable:
    """Draw the states of a square grid as cells."""
    side = isqrt(len(points))
    x, y, image = points[:side, 0], points[::side, 1], values.reshape(side, side)
    return axes.pcolormesh(x, y, image, cmap=colours, norm=scale, shading="nearest", rasterized=True)


def _dots(
    axes: Axes,
    points: FloatArray,
    values: np.ma.MaskedArray,
    colours: str | Colormap,
    scale: Normalize | None = None,
) -> ScalarMappable:
    """Draw scattered states as dots, smaller where there are more of them."""
    x, y = points[~values.mask].T
    size = float(np.clip(4000.0 / len(points), 1.0, 12.0))
    return axes.scatter(x, y, s=size, c=values.compressed(), cmap=colours, norm=scale, lw=0, rasterized=True)


@checked
def shakedown_share(found: MappedRange, *, ax: Axes | None = None) -> Axes:
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
    axes = axes_for(ax)
    percent, interval = 100.0 * found.shakedown_fraction, 100.0 * found.interval
    axes.fill_between(found.load_factors, *interval.T, color=BLUE, alpha=0.2, lw=0, label="95 % interval")
    axes.plot(found.load_factors, percent, "o-", color=BLUE, ms=4, label="shakes down")
    axes.set_ylim(-3.0, 103.0)
    return finished(axes, "load factor λ", "initial states [%]")
