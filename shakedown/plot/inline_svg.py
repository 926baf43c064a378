"""Pictures inside the page: self-contained SVG in the colours of the page."""

import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple
from xml.etree import ElementTree

import matplotlib
import numpy as np
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from shakedown.ground.shown_values import SUBSCRIPT, visible
from shakedown.plot.style import DOTS_PER_INCH

PANEL = (4.6, 3.2)  # inches: two side by side fill a page
SIDE_BY_SIDE = 3  # small pictures in a row
LINE = 0.17  # of a legend [inch]

# Colours that a dark page replaces, by the names of the variables in the page's style.
STYLE: Any = {
    "svg.fonttype": "none",
    "font.sans-serif": ["DejaVu Sans", "sans-serif"],
    "font.size": 9,
    "hatch.linewidth": 0.5,
    "hatch.color": "#777777",
}


@dataclass(frozen=True)
class Picture:
    """Panels (name, drawing) side by side under one caption, with their common legend."""

    caption: str
    panels: tuple[tuple[str, Markup], ...]
    legend: Markup | None = None

    @property
    def heading(self) -> str:
        """The name shared by all panels, shown once above them; empty where they differ."""
        names = {name for name, _ in self.panels}
        return names.pop() if len(names) == 1 else ""


class Drawing(NamedTuple):
    """The contents of one panel.

    Attributes
    ----------
    draw
        What draws it on ``ax``, like every function of ``shakedown.plot``.
    name
        What it is called among other panels.
    size
        Size of the picture where two are side by side [inch].
    """

    draw: Callable[..., object]
    name: str = ""
    size: tuple[float, float] = PANEL


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
        scale = 1.0 if len(drawings) % SIDE_BY_SIDE else 0.8  # how much smaller these are
        axes: list[Any] = [_drawn(drawing, scale) for drawing in drawings]
        _share_limits(axes[:alike])
        legends, common = [_taken_legend(each) for each in axes], None
        if one_legend:
            every = {name: line for entries, _ in reversed(legends) for name, line in entries.items()}
            legends, alone = [({}, "")] * len(axes), Figure(figsize=(PANEL[0], LINE), dpi=DOTS_PER_INCH)
            _legend_below(alone, every, "", "upper left")
            common = inline(alone, f"Legend of the pictures below: {', '.join(every)}") if every else None
        panels = []
        for each, drawing, legend in zip(axes, drawings, legends, strict=True):
            _legend_below(each.figure, *legend)
            panels.append((drawing.name, inline(each.figure, _alternative(caption, drawing.name, each))))
    return Picture(caption, tuple(panels), common)


def _alternative(caption: str, name: str, axes: Axes) -> str:
    """What a panel shows, for readers who do not see it: its caption, its name and what its axes are."""
    title = axes.get_title().replace("\n", ", ")
    over = " over ".join(filter(None, [axes.get_ylabel(), axes.get_xlabel()]))
    return "; ".join(filter(None, [caption.partition(". ")[0].rstrip("."), name, title, over]))


def _drawn(drawing: Drawing, scale: float) -> Axes:
    size = scale * drawing.size[0], scale * drawing.size[1]
    axes = Figure(figsize=size, dpi=DOTS_PER_INCH, layout="constrained").subplots()
    drawing.draw(ax=axes)
    return axes


def _share_limits(alike: Sequence[Axes]) -> None:
    """Give all axes the same limits, where they have the same kind of scale."""
    for name in "xy":
        axis = [axes.xaxis if name == "x" else axes.yaxis for axes in alike]
        if len({one.get_scale() for one in axis}) == 1:
            ends = [one.get_view_interval() for one in axis]
            for axes in alike:
                axes.set(**{f"{name}lim": (np.min(ends), np.max(ends))})


def _taken_legend(axes: Axes) -> tuple[dict[str, Any], str]:
    """The entries of the legend of some axes, each name once, and its title; the legend is removed."""
    legend = axes.get_legend()
    if legend is None:
        return {}, ""
    legend.remove()
    names = [text.get_text() for text in legend.texts]
    return dict(zip(names, legend.legend_handles, strict=True)), legend.get_title().get_text()


def _legend_below(
    figure: Figure, entries: dict[str, Any], title: str, place: Any = "outside lower center"
) -> None:
    """A legend below the axes, where it hides nothing, in a figure made taller for it."""
    if not entries:
        return
    width, height = figure.get_size_inches()
    # per inch, so that points of the figure are units of the picture
    # 50 points for a sample, 4.3 for a letter
    fitting = int(72 * width / (50.0 + 4.3 * max(map(len, entries))))
    columns = max(1, min(fitting, len(entries)))
    figure.set_figheight(height + LINE * (-(-len(entries) // columns) + bool(title)))
    figure.legend(
        list(entries.values()), list(entries), ncols=columns, loc=place, title=title or None,
        fontsize="small", title_fontsize="small", frameon=False, handlelength=3.0,
    )  # fmt: skip


def inline(figure: Figure, alt: str) -> Markup:
    """A figure as an SVG element of a page: all of it, of one without axes its legend.

    Examples
    --------
    >>> figure = Figure(dpi=72)
    >>> _ = figure.subplots().plot([1.0, 2.0], [3.0, 4.0], ".", label="slip")
    >>> inline(figure, "two points").startswith('<svg role="img" aria-label="two points" viewBox="0 0 460.8')
    True
    """
    svg = "{http://www.w3.org/2000/svg}"
    for paper in (figure.patch, *(axes.patch for axes in figure.axes)):  # the page provides the background
        paper.set_alpha(0.0)
    buffer = io.BytesIO()
    with matplotlib.rc_context(STYLE | {"svg.hashsalt": alt}):
        FigureCanvasSVG(figure).print_svg(buffer, metadata={"Date": None})  # savefig would draw it twice
    root = ElementTree.fromstring(buffer.getvalue())
    for element in root.iter():
        if element.tag == f"{svg}g":  # nothing refers to these, and other pictures would repeat them
            element.attrib.pop("id", None)
        # attributes whose third decimal is invisible
        for key in {"d", "x", "y", "transform"}.intersection(element.keys()):
            element.set(key, re.sub(r"(\.\d\d)\d+", r"\1", element.attrib[key]))
    shown = (child for child in root if child.tag != f"{svg}metadata")
    body = "".join(ElementTree.tostring(child, encoding="unicode") for child in shown)
    seen = root.attrib["viewBox"]
    head = f'aria-label="{Markup.escape(visible(alt))}" viewBox="{seen}" style="--wide: {seen.split()[2]}"'
    # without the namespaces that inline SVG does not need
    body = re.sub(r' xmlns:\w+="[^"]*"', "", body).replace("ns0:", "").replace("ns1:href", "href")
    body = re.sub(r"\s*\n\s*", "\n", body)
    return Markup(f'<svg role="img" {head}>{_themed(_lowered(body))}</svg>')


def _lowered(text: str) -> str:
    """The picture with real subscripts in its texts, where these have an underscore: λ_E."""
    name = re.compile(SUBSCRIPT.pattern + "([^λ]*)")  # a symbol, its subscript, what follows it
    return re.sub(r"(?<=>)[^<>]+(?=</text>)", lambda found: name.sub(_subscript, found[0]), text)


def _subscript(name: re.Match[str]) -> str:
    """A symbol with its subscript, and the rest of the text back on the baseline."""
    rest = f'<tspan dy="-.225em">{name[3]}</tspan>' if name[3] else ""
    return f'{name[1]}<tspan dy=".3em" font-size="75%">{name[2]}</tspan>{rest}'


def _themed(text: str) -> str:
    """The picture with colours that follow the page, light or dark."""
    colours = {"#000000": "ink", "#ffffff": "paper", "#0072b2": "blue", "#777777": "grey", "#cccccc": "rule"}
    for colour, name in colours.items():
        text = re.sub(rf"(?<=[:\" ]){colour}\b", f"var(--{name})", text, flags=re.IGNORECASE)
    return text
