"""Design diagrams: what is proved, what depends on the state, what never shakes down (Bree-like)."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.contour import ContourSet
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import named
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.plot.style import (
    BLACK,
    BLUE,
    FARTHEST,
    GREEN,
    GREY,
    MARGIN,
    ORANGE,
    PURPLE,
    RED,
    SKY,
    axes_for,
)

EVERY, THIS, DEPENDS, NEVER = (
    "proved from every state",
    "proved from this state",
    "depends on the state, or open",
    "never, in contact",
)
COLOURS = {EVERY: GREEN, THIS: SKY, DEPENDS: ORANGE, NEVER: RED}
LINES = {
    "universal": (named("λ_U"), GREEN, "-"),
    "lower": (named("λ_1"), BLACK, "--"),
    "energy": (named("λ_E"), BLUE, "-"),
    "accumulated": (named("λ_S"), BLUE, ":"),
    "transient": (named("λ_T"), PURPLE, ":"),
    "upper": ("λ_max", RED, "-"),
}
MARKS = {"shakedown": ("shakes down", "o"), "cyclic-slip": ("slips for ever", "x")}
OTHER_MARK = ("other outcomes", "+")
NAMES = {
    "f": "friction coefficient f",
    "friction": "factor on the friction coefficients",
    "amplitude": "factor on the periodic loads",
    "mean": "factor on the mean load",
    "phase": "phase of the tangential loads [periods]",
    "stiffness": "factor on the stiffness",
    "coupling": "factor on the coupling B",
}
NO_JOINT = "#EEEEEE"
# Light enough for black numbers to stay readable.
BETWEEN_LINES = LinearSegmentedColormap.from_list("light", ["#F7FBFF", "#6BAED6"])
BELOW: dict[str, Any] = {
    "loc": "upper center", "bbox_to_anchor": (0.5, -0.13), "fontsize": "small", "title_fontsize": "small",
    "frameon": False,
}  # fmt: skip
TINT = 0.35  # share of a region's colour in the tint of its area
HEADROOM = 1.15  # top of the axis, times the largest limit
ROOM_FOR_A_NAME = 0.1  # height that a region's name needs, as a fraction of the axes
BETWEEN = "computed at the dots; between them interpolated, nothing is proved there"


Colour = tuple[float, float, float]


class Boundary(Protocol):
    """Load factors at which one region ends and the next begins, one per point; NaN without a joint."""

    @property
    def every(self) -> FloatArray:
        """Shakedown is proved from every state below it."""

    @property
    def this(self) -> FloatArray:
        """Shakedown is proved from this state below it."""

    @property
    def never(self) -> FloatArray:
        """The load factors above which shakedown is impossible."""


class Diagram(Protocol):
    """Limits over one or two parameters, as :class:`shakedown.Sweep` has them."""

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names."""

    @property
    def meanings(self) -> tuple[str, ...]:
        """Which quantity of the joint each one changes; empty for the user's own."""

    @property
    def units(self) -> tuple[str, ...]:
        """Their units; empty where they are not known."""

    @property
    def values(self) -> tuple[FloatArray, ...]:
        """Values of each parameter."""

    @property
    def bounds(self) -> tuple[str, ...]:
        """Limits that were asked for."""

    @property
    def load_factors_simulated(self) -> tuple[float, ...]:
        """Where the joint was simulated."""

    @property
    def outcomes(self) -> NDArray[np.str_]:
        """What became of it, load factors on the last axis."""

    @property
    def boundaries(self) -> Boundary:
        """Where the regions meet."""

    def load_factors(self, name: str) -> FloatArray:
        """One limit at every point."""


@checked
def regions(
    diagram: Diagram, *, load_factor: float = 1.0, contours: str | None = None, ax: Axes | None = None
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
    check_load_factor(load_factor)
    if len(diagram.parameters) == 1:
        return _against_one(diagram, axes_for(ax, (6.4, 5.2)))
    if len(diagram.parameters) != 2:
        raise UsageError(f"regions: expected one or two parameters, found {len(diagram.parameters)}")
    if contours is None:
        contours = next(name for name in reversed(LINES) if name in diagram.bounds)
    elif contours not in diagram.bounds:
        raise UsageError(f"contours: expected one of {', '.join(diagram.bounds)}, found {contours}")
    return _over_two(diagram, load_factor, contours, axes_for(ax, (6.8, 5.4)))


class _Layer(NamedTuple):
    """One region between two lines."""

    name: str
    bottom: FloatArray
    top: FloatArray


def _against_one(diagram: Diagram, axes: Axes) -> Axes:
    x, edges = diagram.values[0], diagram.boundaries
    curves = {name: diagram.load_factors(name) for name in LINES if name in diagram.bounds}
    known = np.concatenate([c[np.isfinite(c)] for c in (*curves.values(), edges.this)])
    top = HEADROOM * float(known.max(initial=0.0)) or 1.0
    every, this, never = (np.clip(edge, 0.0, top) for edge in (edges.every, edges.this, edges.never))
    lines = [*curves.values(), *(np.full_like(x, at) for at in diagram.load_factors_simulated)]
    layers = [
        _Layer(EVERY, np.zeros_like(every), every),
        _Layer(THIS, every, this),
        _Layer(DEPENDS, this, np.maximum(this, never)),
        _Layer(NEVER, np.maximum(this, never), np.full_like(never, top)),
    ]
    for layer in layers:
        named = _name_inside(axes, x, layer, top, lines) or not (layer.top > layer.bottom).any()
        label = "_nolegend_" if named else layer.name
        axes.fill_between(x, layer.bottom, layer.top, color=_tinted(layer.name), lw=0, label=label)
    seen = {name: curve for name, curve in curves.items() if (np.isfinite(curve) & (curve > 0)).any()}
    for name, curve in seen.items():
        label, colour, style = LINES[name]
        finite = np.where(np.isfinite(curve), curve, np.nan)
        axes.plot(x, finite, color=colour, ls=style, marker=".", ms=4, lw=1.4, label=label)
    _draw_outcomes(axes, diagram)
    axes.set(xlabel=_named(diagram, 0), ylabel="load factor λ")
    axes.set_ylim(0.0, top)
    if len(x) > 1:
        axes.set_xlim(x[0], x[-1])
    remarks = [BETWEEN] if len(x) > 1 else []
    remarks += _unseen({name: curve for name, curve in curves.items() if name not in seen})
    axes.legend(*axes.get_legend_handles_labels(), title="\n".join(remarks) or None, ncols=2, **BELOW)
    return axes


def _unseen(curves: Mapping[str, FloatArray]) -> list[str]:
    """Which limits have no curve, and why."""
    why = {
        "zero at every point": [name for name, curve in curves.items() if (curve == 0).all()],
        "no number at any point": [name for name, curve in curves.items() if not (curve == 0).any()],
    }
    why["zero or none"] = [name for name in curves if not any(name in names for names in why.values())]
    short = {name: LINES[name][0].partition(",")[0] for name in curves}
    return [f"{reason}: {', '.join(short[name] for name in names)}" for reason, names in why.items() if names]


def _named(diagram: Diagram, axis: int) -> str:
    """The label of a parameter's axis."""
    own = with_unit(diagram.parameters[axis], diagram.units[axis])
    return NAMES.get(diagram.meanings[axis], own)


def _name_inside(axes: Axes, x: FloatArray, layer: _Layer, top: float, lines: list[FloatArray]) -> bool:
    """Write the name of a region where it is high and wide, away from lines; returns whether it fits."""
    height = np.nan_to_num(layer.top - layer.bottom)
    if len(height) > 4:  # neither at the edge nor on a peak
        k = 1 + int(np.argmax(np.min([height[:-2], height[1:-1], height[2:]], axis=0)))
    else:
        k = int(np.argmax(height))
    if height[k] < ROOM_FOR_A_NAME * top:
        return False
    place = (x[k] - x[0]) / (x[-1] - x[0]) if x[-1] > x[0] else 0.5
    side = "left" if place < 0.3 else "right" if place > 0.7 else "center"
    levels = layer.bottom[k] + height[k] * np.array([0.5, 0.35, 0.65])
    at = np.array([-top, *(line[k] for line in lines if np.isfinite(line[k]))])
    away = np.abs(levels[:, None] - at).min(axis=1)
    text = layer.name.replace(" from ", "\nfrom ").replace(", ", ",\n").replace("depends on ", "depends on\n")
    aside = {"left": 4, "right": -4, "center": 0}[side], 0
    axes.annotate(
        text, (x[k], levels[np.argmax(away)]), aside, textcoords="offset points", ha=side, va="center",
        fontsize="small", zorder=1.5,
    )  # fmt: skip
    return True


def _tinted(name: str) -> Colour:
    """The light colour of a region's area."""
    red, green, blue = (1.0 - TINT * (1.0 - part) for part in to_rgb(COLOURS[name]))
    return red, green, blue


def _draw_outcomes(axes: Axes, diagram: Diagram) -> None:
    """Draw simulated outcomes on top."""
    drawn = set()
    for k, load_factor in enumerate(diagram.load_factors_simulated):
        for x, outcome in zip(diagram.values[0], diagram.outcomes[:, k], strict=True):
            if outcome:
                label, mark = MARKS.get(outcome, OTHER_MARK)
                face = "white" if mark == "o" else BLACK
                shown = f"simulated: {label}" if label not in drawn else "_nolegend_"
                axes.plot(
                    x, load_factor, mark, color=BLACK, mfc=face, ms=5, mew=1.2, zorder=4, clip_on=False,
                    label=shown,
                )  # fmt: skip
                drawn.add(label)


def _over_two(diagram: Diagram, load_factor: float, contours: str, axes: Axes) -> Axes:
    (x, y), edges = diagram.values, diagram.boundaries
    if min(len(x), len(y)) < 2:
        raise UsageError("regions: expected two values or more of each of two parameters, found one")
    missing = np.isnan(edges.every)
    outer = np.maximum(edges.this, edges.never)
    ceiling = FARTHEST * max(load_factor, float(np.max(outer, initial=0.0, where=np.isfinite(outer)))) or 1.0
    axes.set_facecolor(NO_JOINT)
    shown = _shown(
        {NEVER: np.full_like(outer, np.inf), DEPENDS: outer, THIS: edges.this, EVERY: edges.every},
        load_factor,
    )
    for name, edge in shown.items():
        field = np.ma.masked_array(np.clip(edge, 0.0, ceiling), missing).T
        axes.contourf(x, y, field, levels=[load_factor, 2.0 * ceiling], colors=[_tinted(name)])
    grid = np.meshgrid(x, y, indexing="ij")
    axes.plot(*(part[~missing] for part in grid), ".", color=BLACK, ms=2.4, mew=0, clip_on=False)
    axes.set(xlabel=_named(diagram, 0), ylabel=_named(diagram, 1), xlim=(x[0], x[-1]), ylim=(y[0], y[-1]))
    alone = "".join(shown) if len(shown) == 1 else ""
    _draw_contours(axes, diagram, contours, filled=bool(alone))
    at, lines = f"λ = {load_factor:g}", LINES[contours][0]
    title = f"{at} everywhere: {alone}; colours and lines: {lines}" if alone else f"at {at}; lines: {lines}"
    axes.set_title(title, fontsize="medium")
    patches = [Patch(fc=_tinted(name), ec=GREY, label=name) for name in reversed(shown) if not alone]
    patches += [Patch(fc=NO_JOINT, ec=GREY, label="no joint")] if missing.any() else []
    axes.legend(handles=patches, title=BETWEEN, ncols=2, **BELOW)
    return axes


def _shown(edges: Mapping[str, FloatArray], load_factor: float) -> dict[str, FloatArray]:
    """The regions that have an area at a load factor, from the outside in, and their boundaries."""
    known = ~np.isnan(edges[EVERY])
    inner = [*list(edges.values())[1:], np.zeros_like(edges[EVERY])]
    return {
        name: outer
        for (name, outer), within in zip(edges.items(), inner, strict=True)
        if (outer > load_factor).any()
        and not (within[known] > load_factor).all()
        and (outer != within)[known].any()
    }


def _draw_contours(axes: Axes, diagram: Diagram, name: str, filled: bool = False) -> None:
    """Lines of equal load factor, each with its value; the areas between them filled."""
    (x, y), field = diagram.values, np.ma.masked_invalid(diagram.load_factors(name))
    if field.count() < 2 or field.max() == field.min():
        return
    levels = np.array(MaxNLocator(7).tick_values(float(field.min()), float(field.max())))
    levels = levels[(levels > field.min()) & (levels < field.max())]
    if len(levels):
        if filled:
            axes.contourf(x, y, field.T, levels=levels, cmap=BETWEEN_LINES, extend="both")
        lines = axes.contour(x, y, field.T, levels=levels, colors=BLACK, linewidths=0.8)
        places = list(_places(lines, axes))
        if places:
            axes.clabel(lines, fontsize="small", fmt="%g", manual=places)


def _places(lines: ContourSet, axes: Axes) -> Iterator[tuple[float, float]]:
    """Where each line has its label: where it is farthest from the edge of the axes."""
    for segment in (segment for level in lines.allsegs for segment in level):
        inside = axes.transLimits.transform(segment)
        depth = np.minimum(inside, 1.0 - inside).min(axis=1)
        if depth.max(initial=0.0) > MARGIN:  # a number has room there
            x, y = segment[np.argmax(depth)]
            yield float(x), float(y)
