"""Numbers of a joint: limits on one scale, slip over the load and per cycle, numbers over the mesh."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from shakedown.assessment.transient_limit import SlipLimit
from shakedown.ground.constants import ROUND_OFF
from shakedown.ground.shown_values import DIGITS, few, with_unit
from shakedown.joint.arguments import checked
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import units_of
from shakedown.long_term.simulation import Simulation
from shakedown.plot import style
from shakedown.plot.paths import of_kind
from shakedown.plot.style import Styles, axes_for, finished, style_of

Bands = Mapping[str, tuple[float, float]] | None  # what holds between two load factors
BAND, LOWEST_TEXT = 0.27, 0.95  # heights of the coloured band and of the axes with one level of text


@checked
def load_factor_scale(marks: Mapping[str, float], *, bands: Bands = None, ax: Axes | None = None) -> Axes:
    """Limits of the load factor on one scale, with the load factor of the nominal load.

    Parameters
    ----------
    marks
        Name → load factor; what is not finite is left out.
    bands
        Name → (low, high), what holds between two load factors; ``inf`` for the end of the scale.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> from shakedown import plot
    >>> axes = plot.load_factor_scale({"λ_E": 0.66, "λ_max": 0.74}, bands={"proved": (0.0, 0.66)})
    >>> [text.get_text() for text in axes.texts]
    ['λ_E = 0.66', 'λ_max = 0.74', 'λ = 1 (nominal)']
    """
    nominal = "λ = 1 (nominal)"
    known = [(value, f"{name} = {few(value, DIGITS)}") for name, value in marks.items() if np.isfinite(value)]
    axes = axes_for(ax, (9.0, 1.6))
    texts = sorted([*known, (1.0, nominal)])
    # width of one letter on the scale of load factors, in points
    # smallest width of the axes, as a fraction of the picture
    letter = 5.0 / (0.8 * axes.figure.bbox.width * 72 / axes.figure.dpi)  # relative to the scale
    top = max(value / (1.0 - letter * len(text)) for value, text in texts)
    levels = _levels([(value, value + letter * len(text) * top) for value, text in texts])
    highest = LOWEST_TEXT + 0.3 * max(levels)
    colours = style.GREEN, style.RED, *style.LINES
    for colour, (name, (low, high)) in zip(colours, (bands or {}).items(), strict=False):
        axes.axvspan(low, min(high, top), 0.0, BAND / highest, color=colour, alpha=0.3, lw=0, label=name)
    for (value, text), level in zip(texts, levels, strict=True):
        own = text == nominal
        colour, height = style.RED if own else style.GREY, 0.7 + 0.3 * level
        axes.plot([value, value], [0.0, height], lw=2.0 if own else 0.9, color=colour)
        look: dict[str, Any] = {"weight": "bold", "color": style.RED} if own else {}
        axes.text(value + 0.3 * letter * top, height, text, va="center", fontsize="small", **look)
    axes.set(xlim=(0.0, top), ylim=(0.0, highest), yticks=[], xlabel="load factor λ")
    axes.spines[["left", "right", "top"]].set_visible(False)
    return axes


def _levels(spans: list[tuple[float, float]]) -> list[int]:
    """The level of each text, from right to left, so that none covers another text or its line."""
    levels: list[int] = []
    for k in range(len(spans) - 1, -1, -1):
        touched = [levels[i] for i, span in enumerate(reversed(spans[k + 1 :])) if span[0] < spans[k][1]]
        levels.append(max(touched, default=-1) + 1)
    return levels[::-1]


@checked
def slip_over_load(limit: SlipLimit, problem: Problem | None = None, *, ax: Axes | None = None) -> Axes:
    """The largest slip range of a node over the load factor, with the length that it is to stay below.

    Parameters
    ----------
    limit
        From :func:`~shakedown.assessment.transient_limit.slip_limit`.
    problem
        For the unit, where it has one.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> from shakedown.assessment.transient_limit import slip_limit
    >>> joint = shakedown.example("press-fit")
    >>> plot.slip_over_load(slip_limit(joint, 1e-3), joint).get_ylabel()
    'largest slip range [mm]'
    """
    axes, known = axes_for(ax), np.isfinite(limit.slip_range)
    axes.plot(limit.scanned[known], limit.slip_range[known], "o-", color=style.BLUE, ms=4, label="simulated")
    axes.axhline(limit.below, color=style.RED, ls="--", lw=1, label="to stay below")
    if np.isfinite(limit.load_factor):
        axes.axvline(limit.load_factor, color=style.GREEN, ls="--", lw=1, label="up to here it does")
    for load_factor in limit.scanned[np.isinf(limit.slip_range)]:
        axes.axvline(load_factor, color=style.GREY, ls=":", lw=1)
    axes.set(xlim=(0.0, None), ylim=(0.0, None))
    return finished(axes, "load factor λ", with_unit("largest slip range", units_of(problem).length))


@checked
def slip_per_cycle(
    runs: Mapping[str, Simulation] | Simulation,
    problem: Problem | None = None,
    *,
    styles: Styles = None,
    resolution: float = 0.0,
    ax: Axes | None = None,
) -> Axes:
    """Slip of the node that slips most, against the cycle: falls to the floor where the joint shakes down.

    Parameters
    ----------
    runs
        One simulation, or name → simulation.
    problem
        For units.
    styles
        Keywords of ``Axes.plot`` for the line of a name.
    resolution
        Slip per cycle up to which there is none [length]: it is drawn on the floor.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> run = shakedown.simulate(shakedown.example("two-node"), 0.9)
    >>> plot.slip_per_cycle(run).get_yscale()
    'log'
    """
    named = {"": runs} if isinstance(runs, Simulation) else dict(runs)
    axes = axes_for(ax)
    largest = max((float(run.cycles.slip.max(initial=0.0)) for run in named.values()), default=0.0)
    floor = max(ROUND_OFF * largest, resolution) or ROUND_OFF
    for k, (name, run) in enumerate(named.items()):
        worst = np.maximum(run.cycles.slip.max(axis=1, initial=0.0), floor)
        axes.plot(np.arange(1, len(worst) + 1), worst, marker=".", **style_of(name, k, styles))
    axes.axhline(floor, color=style.GREY, lw=0.8)
    below = f"no slip: at most {floor:.0e} {units_of(problem).length}".rstrip() if resolution else "no slip"
    look: dict[str, Any] = {"transform": axes.get_yaxis_transform(), "ha": "right", "color": style.GREY}
    axes.text(0.99, floor / 8, below, fontsize="small", **look)
    # range of the axis above the floor “no slip”, so that it reads as a floor
    axes.set_ylim(floor / 30, 4.0 * largest if largest > floor else 1e6 * floor)
    # from here on the cycles are drawn on a logarithmic axis
    axes.set(yscale="log", xscale="log" if axes.get_xlim()[1] > 100 else "linear")
    axes.minorticks_off()
    return finished(axes, "cycle", with_unit("slip per cycle, largest node", units_of(problem).length))


@checked
def refinement(found: Result, *, ax: Axes | None = None) -> Axes:
    """Every number over the nodes of its mesh, relative to the finest: a level line has converged.

    Where that is zero, relative to the largest. Dashed: the extrapolated limits.

    Parameters
    ----------
    found
        From ``shakedown.refine``.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> joints = {9: shakedown.example("block-9"), 33: shakedown.example("block-33")}
    >>> refinement(shakedown.refine(joints, [9, 33])).get_xscale()
    'log'
    """
    mesh_marks = "os^Dvx*"
    axes, meshes = axes_for(ax, (7.5, 4.6)), of_kind(found, "Refinement")
    for k, (name, values) in enumerate(meshes.numbers.items()):
        limit = meshes.limit[name]
        known = values[np.isfinite(values)]
        if not known.size or not known.max() > 0:
            continue
        unit = values[-1] if np.isfinite(values[-1]) and values[-1] > 0 else known.max()
        label, colour = f"{name.replace('_', ' ')}: {meshes.verdict[name]}", (*style.LINES, style.BLACK)[k]
        axes.plot(meshes.nodes, values / unit, f"{mesh_marks[k]}-", color=colour, label=label, ms=5)
        if np.isfinite(limit):
            axes.plot(meshes.nodes[-1] * np.array([1.0, 1.6]), 2 * [limit / unit], "--", color=colour)
    axes.set_xscale("log")
    axes.set_xticks(meshes.nodes, labels=[str(n) for n in meshes.nodes])
    axes.minorticks_off()
    axes.set_ylim(0.0, min(style.FARTHEST, axes.get_ylim()[1]))
    return finished(axes, "contact nodes", "share of the number on the finest mesh")
