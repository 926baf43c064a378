"""Figures of a verification: slip per cycle, slip space, slip along the contact."""

from collections.abc import Sequence
from itertools import groupby

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from shakedown.model.constraints import BACKWARD, SIDE_NAMES, Constraints, constraints
from shakedown.model.problem import FloatArray
from shakedown.verification.verify import Run, Verification

# Okabe–Ito colours, told apart by readers with colour-blindness; one per kind of initial state.
COLOURS = {
    "zero": "#000000",
    "safe": "#009E73",
    "witness": "#D55E00",
    "given": "#CC79A7",
    "random": "#0072B2",
}
PANEL = (4.3, 3.6)  # inches


def slip_per_cycle_figure(verification: Verification) -> Figure:
    """Slip per cycle of the node that slips most, against the cycle number; one panel per load factor."""
    groups = _by_load_factor(verification.runs)
    figure, axes = _panels(len(groups))
    floor = _floor(verification.runs)
    for axis, (title, runs) in zip(axes, groups, strict=True):
        for run in runs:
            slip = run.simulation.cycles.slip
            if len(slip):
                worst = np.maximum(slip.max(axis=1), floor)
                axis.plot(np.arange(1, len(slip) + 1), worst, marker=".", **_style(run.initial))
        axis.set(title=title, xlabel="cycle", yscale="log")
        if max(len(run.simulation.cycles.slip) for run in runs) > 100:
            axis.set_xscale("log")
        else:
            axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes[0].set_ylabel(f"slip per cycle, largest node{_unit(verification)}")
    _mark_floor(axes, floor)
    _legend(figure, axes)
    return figure


def slip_space_figure(verification: Verification) -> Figure:
    """The slip plane of a two-node system: four rows, safe region, paths (like the thesis's fig. 5.4)."""
    rows = constraints(verification.problem)
    groups = _by_load_factor(verification.runs)
    figure, axes = _panels(len(groups))
    for axis, (title, runs) in zip(axes, groups, strict=True):
        load_factor = runs[0].simulation.load_factor
        corners = safe_polygon(rows, load_factor)
        for run in runs:
            _draw_path(axis, run)
        window = _window([run.simulation for run in runs], corners)
        if len(corners):
            axis.fill(*corners.T, color="#009E73", alpha=0.25, lw=0, label="safe region")
        for i in range(len(rows.g)):
            _draw_row(axis, rows, i, load_factor, window)
        axis.set(title=title, xlabel=f"slip of node 0{_unit(verification)}", xlim=window[0], ylim=window[1])
    axes[0].set_ylabel(f"slip of node 1{_unit(verification)}")
    _legend(figure, axes)
    return figure


def slip_along_contact_figure(verification: Verification) -> Figure:
    """Final slip of every run along the contact (like the thesis's fig. 5.8); one panel per load factor."""
    problem = verification.problem
    position = np.arange(problem.n) if problem.x is None else problem.x
    groups = _by_load_factor(verification.runs)
    figure, axes = _panels(len(groups))
    for axis, (title, runs) in zip(axes, groups, strict=True):
        for run in runs:
            axis.plot(position, run.simulation.final_slip, marker=".", **_style(run.initial))
        axis.set(title=title, xlabel="node" if problem.x is None else "position x")
        axis.ticklabel_format(axis="y", scilimits=(-2, 3))
        if problem.x is None:
            axis.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes[0].set_ylabel(f"final slip{_unit(verification)}")
    _legend(figure, axes)
    return figure


def guarantee_curve_figure(verification: Verification) -> Figure:
    """First collapse λ_1(R) against the radius within which initial states keep to the safe slip."""
    curve, bounds = verification.curve, verification.bounds
    assert curve is not None
    figure, (axis,) = _panels(1)
    axis.plot(curve.radii, curve.load_factors, "o-", color="#0072B2", ms=4, label="λ_1(R)")
    axis.axhline(bounds.upper.load_factor, color="#D55E00", ls="--", lw=1, label="λ_max")
    axis.axhline(bounds.lower.load_factor, color="#009E73", ls="--", lw=1, label="λ_1, every initial state")
    first = min(radius for radius in curve.radii if radius > 0)
    axis.set_xscale("symlog", linthresh=first, linscale=0.5)
    axis.set(xlabel="radius R, in multiples of max |safe slip|", ylabel="load factor")
    axis.set_xlim(left=0.0)
    _legend(figure, [axis])
    return figure


def safe_polygon(rows: Constraints, load_factor: float) -> FloatArray:
    """Corners of the safe region G v ≤ g − λ d of a two-node system, in order, (k, 2) [length].

    Empty where there is no bounded region with an interior.
    """
    limit = rows.g - load_factor * rows.d
    corners = []
    for i in range(len(limit)):
        for j in range(i):
            pair = rows.G[[i, j]]
            if abs(np.linalg.det(pair)) > 1e-12 * np.prod(np.linalg.norm(pair, axis=1)):
                corner = np.linalg.solve(pair, limit[[i, j]])
                size = np.abs(rows.G) @ np.abs(corner) + np.abs(limit)
                if np.all(rows.G @ corner - limit <= 1e-9 * size):
                    corners.append(corner)
    if len(corners) < 3:
        return np.empty((0, 2))
    polygon = np.array(corners)
    around = polygon - polygon.mean(axis=0)
    return polygon[np.argsort(np.arctan2(around[:, 1], around[:, 0]))]


def _by_load_factor(runs: Sequence[Run]) -> list[tuple[str, list[Run]]]:
    groups = groupby(runs, key=lambda run: (run.simulation.load_factor, run.region))
    return [(f"λ = {factor:.5g}, {region}", list(group)) for (factor, region), group in groups]


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(PANEL[0] * max(count, 1), PANEL[1] + 0.5), layout="constrained")
    axes = list(np.atleast_1d(figure.subplots(1, count)))
    for axis in axes:
        axis.grid(True, alpha=0.3)
        axis.title.set_fontsize("medium")
    return figure, axes


def _style(initial: str) -> dict:
    word, _, index = initial.partition(" ")
    dashes = ["-", "--", ":", "-."][int(index or 0) % 4]
    return {"color": COLOURS[word], "ls": dashes, "label": word if word in ("random", "given") else initial}


def _legend(figure: Figure, axes: Sequence[Axes]) -> None:
    """One legend for all panels, one entry per label."""
    entries: dict[str, Artist] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    handles = list(entries.values())
    figure.legend(handles=handles, loc="outside lower center", ncols=5, frameon=False)


def _unit(verification: Verification) -> str:
    units = verification.problem.units
    return f" ({units.split(',')[-1].strip()})" if "," in units else ""


def _floor(runs: Sequence[Run]) -> float:
    """Where zero is drawn on a logarithmic axis."""
    slips = np.concatenate([run.simulation.cycles.slip.max(axis=1, initial=0.0) for run in runs])
    return 1e-13 * float(slips.max(initial=0.0)) or 1e-13


def _mark_floor(axes: Sequence[Axes], floor: float) -> None:
    for axis in axes:
        axis.set_ylim(bottom=floor / 30)
        axis.axhline(floor, color="0.6", lw=0.8)
        axis.text(
            0.99,
            floor / 8,
            "no slip",
            transform=axis.get_yaxis_transform(),
            ha="right",
            color="0.4",
            fontsize="small",
        )


def _draw_path(axis: Axes, run: Run) -> None:
    style = _style(run.initial)
    start, history = run.simulation.initial_slip, run.simulation.history
    points = start[None] if history is None else np.vstack([start, history.v])
    axis.plot(*points.T, lw=1.2, **style)
    axis.plot(*start, "o", color=style["color"], ms=4, mfc="white")
    axis.plot(*run.simulation.final_slip, "s", color=style["color"], ms=4)


def _window(simulations: Sequence, corners: FloatArray) -> FloatArray:
    """Axis limits (2, 2) around the safe region and every start and end."""
    points = [corners, *(np.vstack([s.initial_slip, s.final_slip]) for s in simulations)]
    stacked = np.vstack(points)
    low, high = stacked.min(axis=0), stacked.max(axis=0)
    margin = 0.08 * np.maximum(high - low, 1e-12 + 0.05 * np.abs(stacked).max())
    return np.column_stack([low - margin, high + margin])


def _draw_row(axis: Axes, rows: Constraints, i: int, load_factor: float, window: FloatArray) -> None:
    """The line on which row i is active, within the window."""
    normal, limit = rows.G[i], rows.g[i] - load_factor * rows.d[i]
    span = float(np.linalg.norm(window[:, 1] - window[:, 0]))
    size = float(normal @ normal)
    if size == 0.0:
        return
    centre = window.mean(axis=1)
    foot = centre + normal * (limit - normal @ centre) / size
    along = np.array([-normal[1], normal[0]]) / np.sqrt(size) * 2 * span
    side = SIDE_NAMES[int(rows.side[i])]
    colour = ("#56B4E9", "#E69F00")[rows.node[i]]
    dashes = "-" if rows.side[i] == BACKWARD else "--"
    line = np.array([foot - along, foot + along])
    axis.plot(*line.T, color=colour, ls=dashes, lw=1.0, label=f"node {rows.node[i]}, {side} limit", zorder=0)
