"""Design diagrams and maps of initial states: what is proved, what depends on the state."""

from itertools import pairwise
from math import isqrt
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap, Normalize, to_rgb
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from shakedown.bounds.registry import BOUNDS, Claim, kinds_of
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import at_lambda, with_unit
from shakedown.joint.arguments import check_load_factor
from shakedown.joint.result import Result
from shakedown.joint.units import units_of
from shakedown.plot import style
from shakedown.plot.paths import of_kind
from shakedown.plot.style import axes_for, node_name


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


REGIONS = (  # from the outside in: each lies within the one before
    ("never, in contact", style.RED),
    ("undecided", style.ORANGE),
    ("proved from this state", style.SKY),
    ("proved from every state", style.GREEN),
)
LINES = {  # by what a limit is about; limits of one kind differ in their dashes
    Claim.EVERY_STATE: (style.GREEN, "-"),
    Claim.COLLAPSE: (style.BLACK, "--"),
    Claim.THIS_STATE: (style.BLUE, "-"),
    Claim.FOLLOWED: (style.PURPLE, ":"),
    Claim.CREEP: (style.PURPLE, "--"),
    Claim.IMPOSSIBLE: (style.RED, "-"),
}
NAMES = {
    "f": "friction coefficient f",
    "friction": "factor on the friction coefficients",
    "amplitude": "factor on the periodic loads",
    "mean": "factor on the mean load",
    "phase": "phase of the tangential loads [periods]",
}
LEGEND_BELOW: dict[str, Any] = {
    "loc": "upper center", "bbox_to_anchor": (0.5, -0.13), "fontsize": "small", "title_fontsize": "small",
    "frameon": False,
}  # fmt: skip
BETWEEN = "computed at the dots; between them interpolated, nothing is proved there"


def regions(diagram: Result, *, load_factor: float = 1.0, ax: Axes | None = None) -> Axes:
    """The regions of a sweep: load factor against one parameter, or two parameters at one load factor.

    They are those of the points that were computed, which are dotted. Between these the picture
    interpolates: nothing is proved there.

    Parameters
    ----------
    diagram
        From :func:`shakedown.sweep`.
    load_factor
        λ at which the regions are drawn where there are two parameters.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If there are not one or two parameters.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> found = shakedown.sweep(shakedown.example("two-node"), {"f": [0.2, 0.4]}, bounds=["lower", "upper"])
    >>> axes = plot.regions(found)
    >>> axes.get_xlabel(), axes.get_ylabel()
    ('friction coefficient f', 'load factor λ')
    """
    found = of_kind(diagram, "Sweep")
    check_load_factor(load_factor)
    if len(found.parameters) == 1:
        return _against_one(found, axes_for(ax, (6.4, 5.2)))
    if len(found.parameters) != 2:
        raise UsageError(f"regions: expected one or two parameters, found {len(found.parameters)}")
    return _over_two(found, load_factor, axes_for(ax, (6.8, 5.4)))


def _against_one(diagram: Any, axes: Axes) -> Axes:
    x, edges = diagram.values[0], diagram.boundaries
    curves = {name: diagram.load_factors(name) for name in BOUNDS if name in diagram.bounds}
    known = np.concatenate([c[np.isfinite(c)] for c in (*curves.values(), edges.this)])
    top = 1.15 * float(known.max(initial=0.0)) or 1.0  # top of the axis, times the largest limit
    every, this, never = (np.clip(edge, 0.0, top) for edge in edges)
    heights = np.full_like(x, top), np.maximum(this, never), this, every, np.zeros_like(x)
    for (label, colour), (upper, lower) in zip(REGIONS, pairwise(heights), strict=True):
        if (upper > lower).any():
            axes.fill_between(x, lower, upper, color=_tinted(colour), lw=0, label=label)
    seen = [name for name, curve in curves.items() if (np.isfinite(curve) & (curve > 0)).any()]
    for name in seen:
        (colour, dashes), alike = LINES[BOUNDS[name].claim], kinds_of(BOUNDS[name].claim)
        dashes = dashes if BOUNDS[name] == alike[0] else ":"
        whole = diagram.of_joint(name)
        curve = np.where(np.isfinite(whole), whole, np.nan)
        axes.plot(x, curve, color=colour, ls=dashes, marker=".", ms=4, lw=1.4, label=BOUNDS[name].titled)
    axes.set(xlabel=_named(diagram, 0), ylabel="load factor λ", ylim=(0.0, top))
    if len(x) > 1:
        axes.set_xlim(x[0], x[-1])
    unseen = ", ".join(BOUNDS[name].symbol for name in curves if name not in seen)
    remarks = [BETWEEN * (len(x) > 1), f"zero, or no number, at every point: {unseen}" * bool(unseen)]
    title = "\n".join(filter(None, remarks)) or None
    axes.legend(*axes.get_legend_handles_labels(), title=title, ncols=2, **LEGEND_BELOW)
    return axes


def _named(diagram: Any, axis: int) -> str:
    """The label of a parameter's axis."""
    own = with_unit(diagram.parameters[axis], diagram.units[axis])
    return NAMES.get(diagram.meanings[axis], own)


def _tinted(colour: str) -> tuple[float, ...]:
    """The light colour of a region's area."""
    # share of a region's colour in the tint of its area
    return tuple(1.0 - 0.35 * (1.0 - part) for part in to_rgb(colour))


def _over_two(diagram: Any, load_factor: float, axes: Axes) -> Axes:
    no_joint = "#EEEEEE"
    (x, y), edges = diagram.values, diagram.boundaries
    if min(len(x), len(y)) < 2:
        raise UsageError("regions: expected two values or more of each of two parameters, found one")
    missing = np.isnan(edges.every)
    axes.set_facecolor(no_joint)
    high = 2.0 * load_factor or 1.0  # where there is no limit, so that a boundary lies half-way to there
    every, this, never = (np.where(np.isinf(edge), high, edge) for edge in edges)
    outer = np.full_like(this, high), np.maximum(this, never), this, every, np.zeros_like(this)
    areas = []
    for (label, colour), (edge, within) in zip(REGIONS, pairwise(outer), strict=True):
        inner = (within > load_factor) | (within == edge)
        if (edge > load_factor).any() and not inner[~missing].all():
            areas.append((label, _tinted(colour)))
        field = np.ma.masked_array(edge, missing).T
        axes.contourf(x, y, field, levels=[load_factor, np.inf], colors=[_tinted(colour)])
    grid = np.meshgrid(x, y, indexing="ij")
    axes.plot(*(part[~missing] for part in grid), ".", color=style.BLACK, ms=2.4, mew=0, clip_on=False)
    axes.set(xlabel=_named(diagram, 0), ylabel=_named(diagram, 1), xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    axes.set_title(f"at λ = {load_factor:g}", fontsize="medium")
    areas = areas[::-1] + [("no joint", to_rgb(no_joint))] * bool(missing.any())
    patches = [Patch(fc=colour, ec=style.GREY, label=label) for label, colour in areas]
    axes.legend(handles=patches, title=BETWEEN, ncols=2, **LEGEND_BELOW)
    return axes
