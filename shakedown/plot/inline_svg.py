"""Pictures inside the page: SVG without outside help, in the colours of the page, with values to hover."""

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Protocol
from xml.etree import ElementTree

import matplotlib
import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import AutoLocator, MaxNLocator

from shakedown.ground.visible_text import visible

SVG = "{http://www.w3.org/2000/svg}"
POINTS = 72  # of an inch: then a place on the figure is a place in the picture
SHARP = 150  # dots per inch of what is drawn as an image
ROUNDED = {"d", "x", "y", "transform"}  # attributes in which nobody sees a third decimal
MOST_MARKERS = 700  # of one picture; with more of them lines carry none
MOST_TICKS = 5  # of an axis, less one
REACH = "4"  # about a marker, in points, within which its values are told
PANEL = (4.6, 3.5)  # inches
MARGINS = (0.72, 0.52, 0.18, 0.26)  # inches left, below, right and above the axes

# What a page in the dark draws in another colour; the names are those of the page's style.
COLOURS = {"#000000": "ink", "#ffffff": "paper", "#0072b2": "blue", "#777777": "grey", "#cccccc": "rule"}
STYLE: Any = {
    "svg.fonttype": "none",
    "font.sans-serif": ["DejaVu Sans", "sans-serif"],
    "font.size": 9,
    "hatch.linewidth": 0.5,
    "hatch.color": "#777777",
}


@dataclass(frozen=True)
class Panel:
    """One picture, or some that belong together, and its name among others."""

    name: str
    svgs: tuple[Markup, ...]


@dataclass(frozen=True)
class Picture:
    """Panels side by side, or of which the reader chooses one, under one caption."""

    caption: str
    panels: tuple[Panel, ...]
    choose: bool = False


class Draws(Protocol):
    """What draws on given axes, as every function of ``shakedown.plot`` does."""

    def __call__(self, *, ax: Axes) -> object: ...


def panel(
    alt: str,
    *draws: Draws,
    name: str = "",
    size: tuple[float, float] = PANEL,
    below: float = 0.0,
) -> Panel:
    """One picture for each function that draws.

    Parameters
    ----------
    alt
        What is to be seen, for those who do not see it.
    draws
        What draws on the axes of each.
    name
        What they are called among other panels.
    size
        Of each picture [inch].
    below
        Room for a legend below the axes [inch].
    """
    svgs = []
    for draw in draws:
        with matplotlib.rc_context(STYLE):
            figure = Figure(figsize=size, dpi=SHARP)
            axes = figure.subplots()
            left, bottom, right, top = MARGINS
            figure.subplots_adjust(
                left / size[0], (bottom + below) / size[1], 1 - right / size[0], 1 - top / size[1]
            )
            draw(ax=axes)
            _few_ticks(axes)
            svgs.append(inline(figure, alt if len(draws) == 1 else f"{alt}: {axes.get_ylabel()}"))
    return Panel(name, tuple(svgs))


def _few_ticks(axes: Axes) -> None:
    """Ticks that a narrow screen has room for; each takes a millisecond to draw."""
    for axis in (axes.xaxis, axes.yaxis):
        if isinstance(axis.get_major_locator(), AutoLocator):
            axis.set_major_locator(MaxNLocator(MOST_TICKS, steps=[1, 2, 2.5, 5, 10]))


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
    for paper in (figure.patch, *(axes.patch for axes in figure.axes)):  # that of the page is the picture's
        paper.set_alpha(0.0)
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE | {"svg.hashsalt": alt}):
        FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None})  # draws once, savefig twice
    root = ElementTree.fromstring(buffer.getvalue())
    _without_metadata(root)
    height = figure.get_figheight() * POINTS
    groups = {group.get("id"): group for group in root.iter(f"{SVG}g")}
    for gid, line in lines.items():
        if gid in groups:
            _hover(groups[gid], line, height)
    for group in groups.values():  # nothing refers to them, and another picture has the same
        group.attrib.pop("id", None)
    for element in root.iter():
        for key in ROUNDED.intersection(element.keys()):
            element.set(key, re.sub(r"(\.\d\d)\d+", r"\1", element.attrib[key]))
    body = "".join(ElementTree.tostring(child, encoding="unicode") for child in root)
    head = f'<svg role="img" aria-label="{Markup.escape(visible(alt))}" viewBox="{root.get("viewBox")}">'
    return Markup(head + _themed(_plain(body)) + "</svg>")


def _marked(figure: Figure) -> dict[str, Line2D]:
    """The lines whose points can be hovered over, by the identity that they get in the picture."""
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
    """Tell the values of each marker, and say once how all of them look."""
    markers = group.findall(f".//{SVG}use")
    label = str(line.get_label())
    name = "" if label.startswith("_") or not label else f"{label}: "
    points, spots = _points(line, height), list[ElementTree.Element]()
    for marker in markers:
        group.set("style", marker.attrib.pop("style", ""))
        x, y = float(marker.get("x", "nan")), float(marker.get("y", "nan"))
        for place, text in points:  # a point outside of the picture has no marker
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
    """Without the namespaces that an SVG inside a page does not need."""
    text = re.sub(r' xmlns:\w+="[^"]*"', "", text).replace("ns0:", "").replace("ns1:href", "href")
    return re.sub(r"\s*\n\s*", "\n", text)


def _themed(text: str) -> str:
    """With colours that follow the page, light or dark."""
    for colour, name in COLOURS.items():
        text = re.sub(rf"(?<=[:\" ]){colour}\b", f"var(--{name})", text, flags=re.IGNORECASE)
    return text
