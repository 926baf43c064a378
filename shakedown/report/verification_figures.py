"""Figures of a verification, drawn by ``shakedown.plot``: one panel per load factor."""

from collections.abc import Sequence
from itertools import groupby
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from shakedown import plot
from shakedown.plot.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED
from shakedown.verification.verify import Run, Verification

COLOURS = {"zero": BLACK, "safe": GREEN, "witness": RED, "given": PURPLE, "random": BLUE, "ball": ORANGE}
PANEL = (4.3, 3.6)  # inches


def slip_per_cycle_figure(verification: Verification) -> Figure:
    """Slip per cycle of the node that slips most, against the cycle number."""
    groups = _by_load_factor(verification.runs)
    figure, axes = _panels(len(groups))
    for axis, (title, runs) in zip(axes, groups, strict=True):
        simulations = {run.initial: run.simulation for run in runs}
        plot.slip_per_cycle(simulations, verification.problem, styles=_styles(runs), ax=axis)
        axis.set_title(title)
    return _finished(figure, axes)


def slip_space_figure(verification: Verification) -> Figure:
    """The slip plane of a two-node system: four rows, safe region, paths (like the thesis's fig. 5.4)."""
    groups = _by_load_factor(verification.runs)
    figure, axes = _panels(len(groups))
    for axis, (title, runs) in zip(axes, groups, strict=True):
        load_factor = runs[0].simulation.load_factor
        paths = {run.initial: run.simulation for run in runs if run.simulation.history is not None}
        plot.slip_space(verification.problem, load_factor, paths, styles=_styles(runs), ax=axis)
        axis.set_title(title)
    return _finished(figure, axes)


def slip_along_contact_figure(verification: Verification) -> Figure:
    """Final slip of every run along the contact (like the thesis's fig. 5.8)."""
    groups = _by_load_factor(verification.runs)
    figure, axes = _panels(len(groups))
    for axis, (title, runs) in zip(axes, groups, strict=True):
        slips = {run.initial: run.simulation.final_slip for run in runs}
        plot.slip_along(slips, verification.problem, what="final slip", styles=_styles(runs), ax=axis)
        axis.set_title(title)
    return _finished(figure, axes)


def guarantee_curve_figure(verification: Verification) -> Figure:
    """First collapse λ_1(R) against the radius within which initial states keep to the safe slip."""
    assert verification.curve is not None
    figure, (axis,) = _panels(1)
    plot.guarantee(verification.curve, verification.bounds, ax=axis)
    return _finished(figure, [axis])


def _by_load_factor(runs: Sequence[Run]) -> list[tuple[str, list[Run]]]:
    groups = groupby(runs, key=lambda run: (run.simulation.load_factor, run.region))
    return [(f"λ = {factor:.5g}, {region}", list(group)) for (factor, region), group in groups]


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(PANEL[0] * max(count, 1), PANEL[1] + 0.5), layout="constrained")
    return figure, list(np.atleast_1d(figure.subplots(1, count)))


def _styles(runs: Sequence[Run]) -> dict[str, dict[str, Any]]:
    """One colour per kind of initial state, one dash pattern per state of a kind."""
    styles = {}
    for run in runs:
        word, _, index = run.initial.partition(" ")
        dashes = ["-", "--", ":", "-."][int(index or 0) % 4]
        label = word if word in ("random", "given", "ball") else run.initial
        styles[run.initial] = {"color": COLOURS[word], "ls": dashes, "label": label}
    return styles


def _finished(figure: Figure, axes: Sequence[Axes]) -> Figure:
    """One legend for all panels, one entry per label; the vertical axis named once."""
    entries: dict[str, Artist] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
        if (own := axis.get_legend()) is not None:
            own.remove()
        axis.title.set_fontsize("medium")
    for axis in axes[1:]:
        axis.set_ylabel("")
    figure.legend(handles=list(entries.values()), loc="outside lower center", ncols=5, frameon=False)
    return figure
