"""What all pictures share: axes, colours, units, names, node positions."""

import io
import os
from collections.abc import Mapping
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import AutoLocator, MaxNLocator, ScalarFormatter

from shakedown.files.atomic_write import atomic_write, check_target
from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import SIX_DIGITS, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import shortened, with_unit
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of

# Okabe–Ito colours, told apart by readers with colour-blindness.
BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, RED, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#777777"
LINES = (BLUE, RED, GREEN, PURPLE, ORANGE, SKY)

# Contact states as events record them: name and colour. Maps are images, whose colours do not change
# on a dark page: none of these is one that changes there.
STATES = {
    0: ("stick", "#D9D9D9"),
    1: ("backward slip", RED),
    -1: ("forward slip", "#1F78B4"),
    2: ("open", "none"),  # the paper shows
}

MARGIN = 0.06  # around what is drawn, as a fraction of its size
DOTS_PER_INCH = 150
UNDATED = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}  # the same picture has the same bytes

LONGEST_LABEL = 40  # letters in a legend

Style = Mapping[str, Any]  # keywords of Axes.plot
Styles = Mapping[str, Style] | None  # by the names of lines


def axes_for(ax: Axes | None, size: tuple[float, float] = (6.0, 4.2)) -> Axes:
    """The axes given, or those of a new figure."""
    return Figure(figsize=size, layout="constrained").subplots() if ax is None else ax


def finished(axes: Axes, xlabel: str = "", ylabel: str = "", *, title: str = "", of_legend: str = "") -> Axes:
    """The names of the axes and of the picture, ticks, a grid, a legend where anything drawn has a name."""
    axes.set(**{name: text for name, text in (("xlabel", xlabel), ("ylabel", ylabel)) if text})
    for axis in (axes.xaxis, axes.yaxis):
        if isinstance(numbers := axis.get_major_formatter(), ScalarFormatter):
            numbers.set_powerlimits((-2, 4))
        if isinstance(ticks := axis.get_major_locator(), AutoLocator):
            ticks.set_params(nbins=6)
    if axes.get_xlabel() in ("node", "cycle") and axes.get_xscale() == "linear":
        axes.xaxis.set_major_locator(MaxNLocator(9, integer=True, min_n_ticks=1))
    if title:
        axes.set_title(title, fontsize="medium")
    axes.grid(alpha=0.3)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(title=of_legend or None, fontsize="small")
    return axes


def draw_arrows(axes: Axes, feet: FloatArray, vectors: FloatArray, **look: Any) -> None:
    """Arrows in the units of the axes, (k, 2) and (k, 2)."""
    axes.quiver(*feet.T, *vectors.T, angles="xy", scale_units="xy", scale=1.0, **look)


@checked
def save(ax: Axes, path: str | os.PathLike[str]) -> None:
    """Write the figure that some axes belong to, whole or not at all; the name's ending says in which format.

    SVG and PDF bear no date: what is drawn twice has the same bytes.

    Raises
    ------
    UsageError
        If there is no picture, matplotlib knows no format of that name, or the file cannot
        be written.

    Examples
    --------
    >>> import shakedown
    >>> save(shakedown.plot.load_loop(shakedown.example("two-node"), 0), "loop.png")  # doctest: +SKIP
    """
    if not isinstance(ax, Axes):
        raise UsageError(f"ax: expected the axes of a picture, found {shortened(repr(ax), 60)}")
    figure: Any = ax.figure
    ending = check_target(path).suffix.removeprefix(".").lower()
    known = figure.canvas.get_supported_filetypes()
    if ending not in known:
        raise UsageError(f"{path}: expected a name that ends in one of {', '.join(known)}, found '.{ending}'")
    picture = io.BytesIO()  # drawn first, so that a picture that fails leaves the old file
    with matplotlib.rc_context({"svg.hashsalt": "shakedown"}):
        figure.savefig(picture, format=ending, dpi=DOTS_PER_INCH, metadata=UNDATED.get(ending))
    with atomic_write(path) as file:
        file.write(picture.getbuffer())


def positions(problem: Problem | None, n: int) -> tuple[FloatArray, str]:
    """Where the nodes are drawn, (n,), and the label of that axis.

    Along a straight contact that lies along an axis of the model these are its coordinates.
    """
    if problem is None or problem.x is None:
        return np.arange(n, dtype=float), "node"
    unit, known = units_of(problem).length, problem.coordinates
    if known is not None and n > 1:
        extent = np.ptp(known, axis=0)
        k = int(extent.argmax())
        if np.delete(extent, k).max(initial=0.0) <= SIX_DIGITS * extent[k]:
            return known[:, k], with_unit("xyz"[k], unit)
    return problem.x, with_unit("position along the contact", unit)


def node_name(node: int, problem: Problem | None = None) -> str:
    """How a node is called in legends: by its number, and by its label where it has one."""
    name = f"{node}" if problem is None else problem.node_name(node)
    return "node " + shortened(name, LONGEST_LABEL).replace("$", r"\$")  # a bare $ would begin a formula


def style_of(name: str, k: int, styles: Styles = None) -> dict[str, Any]:
    """The keywords with which line ``k`` is drawn: the caller's for its name, or a colour of its own."""
    own = {"color": LINES[k % len(LINES)], "label": name or "_nolegend_"}
    return own | dict((styles or {}).get(name, {}))
