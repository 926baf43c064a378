"""Pictures inside the page: self-contained SVG in the colours of the page, with values shown on hover."""

import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol
from xml.etree import ElementTree

import matplotlib
import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.ticker import AutoLocator, MaxNLocator
from matplotlib.transforms import Bbox

from shakedown.ground.visible_text import SUBSCRIPT, visible
from shakedown.plot.style import DOTS_PER_INCH

SVG = "{http://www.w3.org/2000/svg}"
POINTS = 72  # per inch, so that points of the figure are units of the picture
ROUNDED = {"d", "x", "y", "transform"}  # attributes whose third decimal is invisible
MOST_MARKERS = 700  # in one picture; lines with more points have none
REACH = "4"  # radius about a marker, in points, within which its values are shown
PANEL, SMALL = (4.6, 3.2), (3.7, 2.9)  # inches: two, or three, side by side fill a page
SIDE_BY_SIDE = 3  # small pictures in a row: of nodes up to so many each has its own
MARGINS = (0.72, 0.52, 0.22, 0.26)  # inches left, below, right and above the axes
SCALE = 0.82  # inches beside the axes for a colour bar
EDGE = 3.0  # points kept free around labels that extend beyond the figure
LETTER, SAMPLE = 4.3, 44.0  # widths in a legend, in points: of a letter, of the line before a name
LEGEND, LINE = 0.46, 0.17  # inches from the axes down to their legend; height of one line of it

# Colours that a dark page replaces, by the names of the variables in the page's style.
COLOURS = {"#000000": "ink", "#ffffff": "paper", "#0072b2": "blue", "#777777": "grey", "#cccccc": "rule"}
NAME = re.compile(SUBSCRIPT.pattern + "([^λ]*)")  # a symbol, its subscript, what follows it
STYLE: Any = {
    "svg.fonttype": "none",
    "font.sans-serif": ["DejaVu Sans", "sans-serif"],
    "font.size": 9,
    "hatch.linewidth": 0.5,
    "hatch.color": "#777777",
}


@dataclass(frozen=True)
class Panel:
    """One picture, and its name among others."""

    name: str
    svg: Markup


@dataclass(frozen=True)
class Picture:
    """Panels side by side under one caption, with their common legend."""

    caption: str
    panels: tuple[Panel, ...]
    legend: Markup | None = None

    @property
    def heading(self) -> str:
        """The name shared by all panels, shown once above them; empty where they differ."""
        names = {panel.name for panel in self.panels}
        return names.pop() if len(names) == 1 else ""


class Draws(Protocol):
    """A function that draws on given axes, like every function of ``shakedown.plot``."""

    def __call__(self, *, ax: Axes) -> object: ...


class Drawing(NamedTuple):
    """The contents of one panel.

    Attributes
    ----------
    alt
        Text that describes the picture for readers who do not see it.
    draw
        What draws it.
    name
        What it is called among other panels.
    size
        Size of the picture [inch]; by default two, or three, of them side by side fill a page.
    """

    alt: str
    draw: Draws
    name: str = ""
    size: tuple[float, float] | None = None


def picture(caption: str, *drawings: Drawing, alike: int = 0, one_legend: bool = False) -> Picture:
    """Panels side by side under one caption.

    Parameters
    ----------
    caption
        What they show.
    drawings
        What is drawn on each.
    alike
        The number of first panels whose axes share their limits.
    one_legend
        Whether all panels have one legend, above them.
    """
    with matplotlib.rc_context(STYLE):
        size = SMALL if len(drawings) % SIDE_BY_SIDE == 0 else PANEL
        sizes = [drawing.size or size for drawing in drawings]
        figures = [Figure(figsize=size, dpi=DOTS_PER_INCH) for size in sizes]
        axes = [_drawn(*each) for each in zip(figures, sizes, drawings, strict=True)]
        _share_limits(axes[:alike])
        legend = _common_legend(axes) if one_legend else None
        for each in zip(figures, axes, sizes, strict=True):
            _legend_below(*each)
        panels = [
            Panel(drawing.name, inline(figure, drawing.alt))
            for figure, drawing in zip(figures, drawings, strict=True)
        ]
    return Picture(caption, tuple(panels), legend)


def _drawn(figure: Figure, size: tuple[float, float], drawing: Drawing) -> Axes:
    axes = figure.add_axes(_place(size))
    drawing.draw(ax=axes)
    axes.set_position(_place(size, beside=_beside(axes)))
    for axis in (axes.xaxis, axes.yaxis):  # each tick takes a millisecond to draw
        if isinstance(axis.get_major_locator(), AutoLocator):
            axis.set_major_locator(MaxNLocator(nbins=5, steps=[1, 2, 2.5, 5, 10]))
    return axes


def _beside(axes: Axes) -> float:
    """The width of a colour bar [inch]."""
    return SCALE if axes.child_axes else 0.0


def _place(
    size: tuple[float, float], below: float = 0.0, beside: float = 0.0
) -> tuple[float, float, float, float]:
    """The axes' rectangle in a figure made taller below and wider beside, as fractions of its size."""
    (width, height), (left, bottom, right, top) = size, MARGINS
    tall, wide = height + below, width - left - right - beside
    return left / width, (bottom + below) / tall, wide / width, (height - bottom - top) / tall


def _share_limits(alike: Sequence[Axes]) -> None:
    """Give all axes the same limits, where they have the same kind of scale."""
    for name in "xy":
        axis = [axes.xaxis if name == "x" else axes.yaxis for axes in alike]
        if len({one.get_scale() for one in axis}) == 1:
            ends = [one.get_view_interval() for one in axis]
            for axes in alike:
                axes.set(**{f"{name}lim": (np.min(ends), np.max(ends))})


def _common_legend(axes: Sequence[Axes]) -> Markup | None:
    """Replace the legends of the panels by a common one, as a picture of its own."""
    legends = [legend for each in axes if (legend := each.get_legend()) is not None]
    entries: dict[str, Any] = {}
    for legend in legends:
        entries = _entries(legend) | entries
    for legend in legends:
        legend.remove()
    if not entries:
        return None
    figure = Figure(figsize=PANEL, dpi=DOTS_PER_INCH)
    figure.legend(
        list(entries.values()), list(entries), ncols=_columns(entries, POINTS * PANEL[0]), loc="upper left",
        fontsize="small", frameon=False,
    )  # fmt: skip
    return inline(figure, f"Legend of the pictures below: {', '.join(entries)}")


def _legend_below(figure: Figure, axes: Axes, size: tuple[float, float]) -> None:
    """Move the legend below the axes, where it hides nothing, and enlarge the figure for it."""
    legend = axes.get_legend()
    if legend is None:
        return
    (width, height), entries, title = size, _entries(legend), legend.get_title().get_text()
    columns = _columns(entries, POINTS * (width - MARGINS[0] + MARGINS[2]))
    below = LINE * (-(-len(entries) // columns) + bool(title))
    figure.set_size_inches(width, height + below)
    axes.set_position(_place(size, below, _beside(axes)))
    axes.legend(
        list(entries.values()), list(entries), ncols=columns, loc="upper center", borderaxespad=0.0,
        bbox_to_anchor=(0.5, -LEGEND / (height - MARGINS[1] - MARGINS[3])), fontsize="small", frameon=False,
        title=title or None, title_fontsize="small",
    )  # fmt: skip


def _entries(legend: Legend) -> dict[str, Any]:
    """The entries of a legend, each name once."""
    return {text.get_text(): line for text, line in zip(legend.texts, legend.legend_handles, strict=True)}


def _columns(names: Iterable[str], width: float) -> int:
    """How many entries of a legend stand side by side within a width [points]."""
    return max(1, min(int(width / (SAMPLE + LETTER * max(map(len, names)))), len(list(names))))


def inline(figure: Figure, alt: str) -> Markup:
    """A figure as an SVG element of a page.

    Examples
    --------
    >>> figure = Figure(dpi=POINTS)
    >>> _ = figure.subplots().plot([1.0, 2.0], [3.0, 4.0], ".", label="slip")
    >>> text = inline(figure, "two points")
    >>> text.startswith('<svg role="img" aria-label="two points"'), "<title>slip: 1, 3</title>" in text
    (True, True)
    """
    lines = _marked(figure)
    for paper in (figure.patch, *(axes.patch for axes in figure.axes)):  # the page provides the background
        paper.set_alpha(0.0)
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE | {"svg.hashsalt": alt}):
        FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None})  # savefig would draw twice
    root = ElementTree.fromstring(buffer.getvalue())
    _without_metadata(root)
    height = figure.get_figheight() * POINTS
    groups = {group.get("id"): group for group in root.iter(f"{SVG}g")}
    for gid, line in lines.items():
        if gid in groups:
            _hover(groups[gid], line, height)
    for group in groups.values():  # nothing refers to these identifiers, and other pictures would repeat them
        group.attrib.pop("id", None)
    for element in root.iter():
        for key in ROUNDED.intersection(element.keys()):
            element.set(key, re.sub(r"(\.\d\d)\d+", r"\1", element.attrib[key]))
    body = "".join(ElementTree.tostring(child, encoding="unicode") for child in root)
    head = f'<svg role="img" aria-label="{Markup.escape(visible(alt))}" {_size(figure, height)}>'
    return Markup(head + _themed(_lowered(_plain(body))) + "</svg>")


def _size(figure: Figure, height: float) -> str:
    """The visible extent: the figure with labels that extend beyond it, or a legend alone."""
    boxes = [legend.get_window_extent() for legend in figure.legends]
    for axes in figure.axes:
        boxes += [axes.title.get_window_extent()] if axes.get_title() else []
        boxes += [box for axis in (axes.xaxis, axes.yaxis) if (box := axis.get_tightbbox()) is not None]
    padded = [box.padded(EDGE) for box in boxes]
    box = Bbox.union(padded if figure.legends else [figure.bbox, *padded])
    left, top = np.floor([box.x0, height - box.y1])
    width, tall = np.ceil([box.x1, height - box.y0]) - (left, top)
    return f'viewBox="{left:g} {top:g} {width:g} {tall:g}" style="--wide: {width:g}"'


def _marked(figure: Figure) -> dict[str, Line2D]:
    """The lines whose points show values on hover, by their identifiers in the picture."""
    drawn = [
        line for axes in figure.axes for line in axes.get_lines() if line.get_marker() not in ("", "None")
    ]
    if sum(np.asarray(line.get_xydata()).size for line in drawn) > 2 * MOST_MARKERS:
        for line in drawn:
            line.set_marker("")
        return {}
    lines = {f"hover-{k}": line for k, line in enumerate(drawn)}
    for gid, line in lines.items():
        line.set_gid(gid)
    return lines


def _hover(group: ElementTree.Element, line: Line2D, height: float) -> None:
    """Attach the values to each marker, and define the marker's shape once."""
    markers = group.findall(f".//{SVG}use")
    label = str(line.get_label())
    name = "" if label.startswith("_") or not label else f"{label}: "
    points, spots = _points(line, height), list[ElementTree.Element]()
    for marker in markers:
        group.set("style", marker.attrib.pop("style", ""))
        x, y = float(marker.get("x", "nan")), float(marker.get("y", "nan"))
        for place, text in points:  # a point outside the picture has no marker
            if np.hypot(place[0] - x, place[1] - y) < 0.01:
                spot = {"cx": f"{x:.2f}", "cy": f"{y:.2f}", "r": REACH, "class": "spot"}
                spots.append(ElementTree.Element(f"{SVG}circle", spot))
                ElementTree.SubElement(spots[-1], f"{SVG}title").text = name + text
                break
    group.extend(spots)


def _points(line: Line2D, height: float) -> Iterator[tuple[tuple[float, float], str]]:
    """Where the points of a line are in the picture, and their values."""
    data = np.asarray(line.get_xydata(), dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        places = line.get_transform().transform(data)
    for (x, y), (u, v) in zip(data, places, strict=True):
        yield (float(u), height - float(v)), f"{x:.5g}, {y:.5g}"


def _without_metadata(root: ElementTree.Element) -> None:
    for child in root.findall(f"{SVG}metadata"):
        root.remove(child)


def _plain(text: str) -> str:
    """The element without the namespaces that inline SVG does not need."""
    text = re.sub(r' xmlns:\w+="[^"]*"', "", text).replace("ns0:", "").replace("ns1:href", "href")
    return re.sub(r"\s*\n\s*", "\n", text)


def _lowered(text: str) -> str:
    """The picture with real subscripts in its texts, where these have an underscore: λ_E."""
    return re.sub(r"(?<=>)[^<>]+(?=</text>)", lambda found: NAME.sub(_subscript, found[0]), text)


def _subscript(name: re.Match[str]) -> str:
    """A symbol with its subscript, and the rest of the text back on the baseline."""
    rest = f'<tspan dy="-.225em">{name[3]}</tspan>' if name[3] else ""
    return f'{name[1]}<tspan dy=".3em" font-size="75%">{name[2]}</tspan>{rest}'


def _themed(text: str) -> str:
    """The picture with colours that follow the page, light or dark."""
    for colour, name in COLOURS.items():
        text = re.sub(rf"(?<=[:\" ]){colour}\b", f"var(--{name})", text, flags=re.IGNORECASE)
    return text
