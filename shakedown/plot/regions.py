"""Design diagrams: what is proved, what depends on the state, what never shakes down (Bree-like)."""

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from shakedown.bounds.registry import BOUNDS, Claim, kinds_of
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import with_unit
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.result import Result
from shakedown.plot import style
from shakedown.plot.paths import of_kind
from shakedown.plot.style import axes_for

REGIONS = (  # from the outside in: each lies within the one before
    ("never, in contact", style.RED),
    ("depends on the state, or open", style.ORANGE),
    ("proved from this state", style.SKY),
    ("proved from every state", style.GREEN),
)
LINES = {  # by what a limit is about; limits of one kind differ in their dashes
    Claim.EVERY_STATE: (style.GREEN, "-"),
    Claim.COLLAPSE: (style.BLACK, "--"),
    Claim.THIS_STATE: (style.BLUE, "-"),
    Claim.FOLLOWED: (style.PURPLE, ":"),
    Claim.IMPOSSIBLE: (style.RED, "-"),
}
NAMES = {
    "f": "friction coefficient f",
    "friction": "factor on the friction coefficients",
    "amplitude": "factor on the periodic loads",
    "mean": "factor on the mean load",
    "phase": "phase of the tangential loads [periods]",
    "stiffness": "factor on the stiffness",
    "coupling": "factor on the coupling B",
}
BELOW: dict[str, Any] = {
    "loc": "upper center", "bbox_to_anchor": (0.5, -0.13), "fontsize": "small", "title_fontsize": "small",
    "frameon": False,
}  # fmt: skip
BETWEEN = "computed at the dots; between them interpolated, nothing is proved there"


@checked
def regions(
    diagram: Result, *, load_factor: float = 1.0, contours: str | None = None, ax: Axes | None = None
) -> Axes:
    """The regions of a sweep: load factor against one parameter, or two parameters at one load factor.

    They are those of the points that were computed, which are dotted. Between these the picture
    interpolates: nothing is proved there.

    Parameters
    ----------
    diagram
        From :func:`shakedown.sweep`.
    load_factor
        λ at which the regions are drawn where there are two parameters.
    contours
        The limit whose contour lines are drawn over them; by default the last of λ_max, λ_T,
        λ_S, λ_E, λ_1, λ_U that was asked for.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If there are not one or two parameters, or the limit was not asked for.

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
    if contours is None:
        contours = next(name for name in reversed(BOUNDS) if name in found.bounds)
    elif contours not in found.bounds:
        raise UsageError(f"contours: expected one of {', '.join(found.bounds)}, found {contours}")
    return _over_two(found, load_factor, contours, axes_for(ax, (6.8, 5.4)))


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
    _draw_outcomes(axes, diagram)
    axes.set(xlabel=_named(diagram, 0), ylabel="load factor λ", ylim=(0.0, top))
    if len(x) > 1:
        axes.set_xlim(x[0], x[-1])
    unseen = ", ".join(BOUNDS[name].symbol for name in curves if name not in seen)
    remarks = [BETWEEN * (len(x) > 1), f"zero, or no number, at every point: {unseen}" * bool(unseen)]
    title = "\n".join(filter(None, remarks)) or None
    axes.legend(*axes.get_legend_handles_labels(), title=title, ncols=2, **BELOW)
    return axes


def _named(diagram: Any, axis: int) -> str:
    """The label of a parameter's axis."""
    own = with_unit(diagram.parameters[axis], diagram.units[axis])
    return NAMES.get(diagram.meanings[axis], own)


def _tinted(colour: str) -> tuple[float, ...]:
    """The light colour of a region's area."""
    # share of a region's colour in the tint of its area
    return tuple(1.0 - 0.35 * (1.0 - part) for part in to_rgb(colour))


def _draw_outcomes(axes: Axes, diagram: Any) -> None:
    """Draw simulated outcomes on top."""
    marks = {"shakedown": ("shakes down", "o"), "cyclic-slip": ("slips for ever", "x"), "": ("others", "+")}
    x, y = np.meshgrid(diagram.values[0], diagram.load_factors_simulated, indexing="ij")
    left = diagram.outcomes != ""
    for outcome, (label, mark) in marks.items():
        here = left & (diagram.outcomes == outcome) if outcome else left
        left &= ~here
        if here.any():
            look: dict[str, Any] = {
                "mfc": "white" if mark == "o" else style.BLACK,
                "label": f"simulated: {label}",
            }
            axes.plot(
                x[here], y[here], mark, color=style.BLACK, ms=5, mew=1.2, zorder=4, clip_on=False, **look
            )


def _over_two(diagram: Any, load_factor: float, contours: str, axes: Axes) -> Axes:
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
    _draw_contours(axes, diagram, contours)
    axes.set_title(f"at λ = {load_factor:g}; lines: {BOUNDS[contours].titled}", fontsize="medium")
    areas = areas[::-1] + [("no joint", to_rgb(no_joint))] * bool(missing.any())
    patches = [Patch(fc=colour, ec=style.GREY, label=label) for label, colour in areas]
    axes.legend(handles=patches, title=BETWEEN, ncols=2, **BELOW)
    return axes


def _draw_contours(axes: Axes, diagram: Any, name: str) -> None:
    """Lines of equal load factor, each with its value."""
    (x, y), field = diagram.values, np.ma.masked_invalid(diagram.load_factors(name))
    if field.count() < 2 or field.max() == field.min():
        return
    levels = np.array(MaxNLocator(7).tick_values(float(field.min()), float(field.max())))
    levels = levels[(levels > field.min()) & (levels < field.max())]
    if len(levels):
        lines = axes.contour(x, y, field.T, levels=levels, colors=style.BLACK, linewidths=0.8)
        segments = [
            axes.transLimits.transform(line) for level in lines.allsegs for line in level if len(line)
        ]
        deepest = [max(line.tolist(), key=lambda at: min(*at, 1 - at[0], 1 - at[1])) for line in segments]
        inside = [
            at for at in deepest if min(*at, 1 - at[0], 1 - at[1]) > style.MARGIN
        ]  # has room for a number
        places = axes.transLimits.inverted().transform(np.reshape(inside, (-1, 2))).tolist()
        axes.clabel(lines, fontsize="small", fmt="%g", manual=places)
