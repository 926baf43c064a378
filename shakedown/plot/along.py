"""Along a contact in the plane: pressures, use of friction, slip; and numbers of a joint on one scale."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, NoNorm
from matplotlib.patches import Patch

from shakedown.assessment.transient_limit import SlipLimit
from shakedown.ground.constants import NEGLIGIBLE, ROUND_OFF, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import DIGITS, few, with_unit
from shakedown.ground.status import OPEN, STICK
from shakedown.joint.arguments import require_plane, require_problem
from shakedown.joint.contact_surface import flanks
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import units_of
from shakedown.long_term.simulation import Simulation
from shakedown.motion.event_history import EventHistory, recorded_path
from shakedown.plot import paths, style
from shakedown.plot.over_patch import pressure_over_patch
from shakedown.plot.patch_places import in_space
from shakedown.plot.paths import Recorded, of_kind
from shakedown.plot.style import Styles, axes_for, finished, positions, style_of

Bands = Mapping[str, tuple[float, float]] | None  # what holds between two load factors


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
    # a letter of 5 points, on axes that take at least 0.8 of the width of the picture
    letter = 5.0 / (0.8 * axes.figure.bbox.width * 72 / axes.figure.dpi)  # relative to the scale
    top = max(value / (1.0 - letter * len(text)) for value, text in texts)
    levels = _levels([(value, value + letter * len(text) * top) for value, text in texts])
    # heights of the axes with one level of text, and of the coloured band
    highest, band = 0.95 + 0.3 * max(levels), 0.27
    colours = style.GREEN, style.RED, *style.LINES
    for colour, (name, (low, high)) in zip(colours, (bands or {}).items(), strict=False):
        axes.axvspan(low, min(high, top), 0.0, band / highest, color=colour, alpha=0.3, lw=0, label=name)
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


def slip_over_load(limit: SlipLimit, problem: Problem | None = None, *, ax: Axes | None = None) -> Axes:
    """The largest slip range of a node versus the load factor, with the length that it is to stay below.

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
    mesh_marks, colours = "os^Dvx*P+", (*style.LINES, style.BLACK, style.GREY)
    axes, meshes = axes_for(ax, (7.5, 4.6)), of_kind(found, "Refinement")
    for k, (name, values) in enumerate(meshes.numbers.items()):
        limit = meshes.limit[name]
        known = values[np.isfinite(values)]
        if not known.size or not known.max() > 0:
            continue
        unit = values[-1] if np.isfinite(values[-1]) and values[-1] > 0 else known.max()
        label, colour = f"{name.replace('_', ' ')}: {meshes.verdict[name]}", colours[k % len(colours)]
        axes.plot(meshes.nodes, values / unit, f"{mesh_marks[k]}-", color=colour, label=label, ms=5)
        if np.isfinite(limit):
            axes.plot(meshes.nodes[-1] * np.array([1.0, 1.6]), 2 * [limit / unit], "--", color=colour)
    axes.set_xscale("log")
    axes.set_xticks(meshes.nodes, labels=[str(n) for n in meshes.nodes])
    axes.minorticks_off()
    axes.set_ylim(0.0, min(3.0, axes.get_ylim()[1]))  # what is far beyond the range of interest is cut off
    return finished(axes, "contact nodes", "share of the number on the finest mesh")


Times = Sequence[float] | None  # in cycles; by default of the largest and of the smallest total pressure


def pressure(
    result: Recorded, problem: Problem, *, cycles: Times = None, patch: int = 0, ax: Axes | None = None
) -> Axes:
    """Normal reactions along the contact, at chosen instants; pressures where node areas are known.

    With two tangential directions :func:`pressure_over_patch` draws one instant.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        The joint: positions and units.
    cycles
        Times in cycles, over a patch one; by default when the total is largest and when it is smallest.
    patch
        With two directions the part of the contact that is drawn.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, or over a patch more than one time is asked for.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.pressure(shakedown.long_term_state(block, 1.0), block).get_ylabel()
    'normal reaction p [N]'
    """
    require_problem(problem)
    if in_space(problem):
        if cycles is not None and len(cycles) != 1:
            raise UsageError(f"cycles: expected one time (a picture of a patch), found {len(cycles)}")
        cycle = None if cycles is None else cycles[0]
        return pressure_over_patch(result, problem, cycle, patch=patch, ax=ax)
    path = recorded_path(result)
    rows = _rows(path, cycles)
    values, label = paths.normal_reactions("normal reaction p", path.p[list(rows.values())], problem)
    return _along(problem, zip(rows, values, strict=True), label, ax)


def friction_use(result: Recorded, problem: Problem, *, cycles: Times = None, ax: Axes | None = None) -> Axes:
    """How much of the friction each node uses, q / f p, along the contact at chosen instants.

    At ±1 a node is at its limit. Open nodes are left out. Parameters as for :func:`pressure`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> axes = plot.friction_use(shakedown.long_term_state(block, 1.0), block)
    >>> axes.get_ylabel()
    'use of friction q / f p [–]'
    """
    require_plane("picture", problem)
    path = recorded_path(result)
    use = path.q / np.where(paths.pressed(problem, path), problem.law.limit(path.p), np.nan)
    lines = ((time, use[row]) for time, row in _rows(path, cycles).items())
    axes = _along(problem, lines, "use of friction q / f p [–]", ax)
    for limit in (-1.0, 1.0):
        axes.axhline(limit, color=style.BLACK, lw=0.8, ls="--")
    axes.set(ylim=(-1.15, 1.15))
    return axes


def slip_along(
    slips: Mapping[str, FloatArray], problem: Problem, *, what: str = "slip v", ax: Axes | None = None
) -> Axes:
    """Slips, or anything else that has one number per node in units of length, along the contact.

    Parameters
    ----------
    slips
        Name → (n,) [length].
    problem
        The joint: positions and units.
    what
        Name of the quantity, for the axis.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.slip_along({"safe slip": shakedown.upper_bound(block).slip}, block).get_ylabel()
    'slip v [mm]'
    """
    require_plane("picture", problem)
    return _along(problem, slips.items(), with_unit(what, units_of(problem).length), ax)


def slip_range(result: Recorded, problem: Problem, *, ax: Axes | None = None) -> Axes:
    """How far each node slips back and forth in contact, max v − min v over a path, along the contact.

    Nothing is drawn for nodes that are never closed. Parameters as for :func:`pressure`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.slip_range(shakedown.long_term_state(block, 5.0), block).get_ylabel()
    'slip range [mm]'
    """
    require_plane("picture", problem)
    path = recorded_path(result)
    closed = (path.state != OPEN) | (path.w == 0.0)  # a node about to open is still in contact
    low = np.where(closed, path.v, np.inf).min(axis=0)
    high = np.where(closed, path.v, -np.inf).max(axis=0)
    apart = np.where(closed.any(axis=0), high - low, np.nan)
    return _along(problem, [("", apart)], with_unit("slip range", units_of(problem).length), ax)


def dissipation_along(result: Recorded, problem: Problem, *, ax: Axes | None = None) -> Axes:
    """Friction work of each node along a path, along the contact; per area where areas are known.

    Parameters as for :func:`pressure`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> plot.dissipation_along(shakedown.long_term_state(block, 5.0), block).get_ylabel()
    'friction work [N mm]'
    """
    require_plane("picture", problem)
    work, label = paths.work_and_name(paths.work_of_nodes(result), problem)
    return _along(problem, [("", work)], label, ax)


def zones(
    result: Recorded, problem: Problem | None = None, *, marks: bool = True, ax: Axes | None = None
) -> Axes:
    """Stick, slip and open zones over position and time (like the thesis's figs. 3.2, 3.7).

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        For positions, units, and the friction that ``marks`` needs.
    marks
        Whether to mark where nodes that never slip are at their limit.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> block = shakedown.example("block-9")
    >>> axes = plot.zones(shakedown.long_term_state(block, 5.0), block)
    >>> axes.get_ylabel(), axes.get_xlabel()
    ('time [cycles]', 'position along the contact [mm]')
    """
    path = paths.path_in_the_plane(result, problem)
    x, label = positions(problem, path.v.shape[1])
    keep = np.append(np.diff(path.cycle) > 0, True)  # the last of several events at one instant
    time, state = path.cycle[keep], path.state[keep]
    if len(time) < 2:
        raise UsageError("result: expected events at two instants or more, found one")
    kinds = list(style.STATES)
    image = np.vectorize(kinds.index)(state[:-1])
    colours = ListedColormap([style.STATES[kind][1] for kind in kinds])
    axes, scale = axes_for(ax, (6.0, 4.8)), NoNorm(0, len(kinds) - 1)
    for part in flanks(x):
        axes.pcolormesh(_edges(x[part]), time, image[:, part], cmap=colours, norm=scale, rasterized=True)
    for left, right in pairwise(flanks(x)):
        gap = _edges(x[left])[-1], _edges(x[right])[0]
        axes.axvspan(*gap, fill=False, edgecolor=style.GREY, hatch="///", lw=0)
    seen = [style.STATES[kind] for k, kind in enumerate(kinds) if (image == k).any()]
    handles: list[Any] = [Patch(fc=face, ec=style.BLACK, lw=0.6, label=name) for name, face in seen]
    if marks and problem is not None:
        handles += _mark_limits(axes, path, problem, x)
    finished(axes, label, "time [cycles]").grid(visible=False)
    axes.legend(handles=handles, fontsize="small", loc="upper center", bbox_to_anchor=(0.5, -0.17), ncols=3)
    return axes


def _rows(path: EventHistory, cycles: Times) -> dict[str, int]:
    """Instants in words, and the rows nearest to them; by default of the largest and least total pressure."""
    rows = list(paths.extreme_rows(path)[:2])
    if cycles is not None:
        rows = [int(np.abs(path.cycle - time).argmin()) for time in cycles]
    return {paths.time_in_words(float(path.cycle[row])): row for row in rows}


def _along(problem: Problem, lines: Iterable[tuple[str, FloatArray]], label: str, ax: Axes | None) -> Axes:
    """One line per name, (n,), along the contact; broken between flanks."""
    axes, (x, where) = axes_for(ax), positions(problem, problem.n)
    for k, (name, values) in enumerate(lines):
        look: dict[str, Any] = {"marker": ".", "ms": 4, "lw": 1.2} | style_of(name, k)
        for part in flanks(x):
            axes.plot(x[part], np.asarray(values)[part], **look)
            look["label"] = "_nolegend_"
    return finished(axes, where, label)


def _mark_limits(axes: Axes, path: EventHistory, problem: Problem, x: FloatArray) -> list[Any]:
    """Dots where a node that never slips is at its limit; the entry of the legend, if there are any."""
    limit = problem.law.limit(path.p)
    noise = NEGLIGIBLE * float(np.abs(limit).max())
    still = (path.state == STICK).all(axis=0)
    rows, nodes = np.nonzero(still & (np.abs(np.abs(path.q) - limit) <= noise) & (limit > noise))
    # visible on “stick” and on the page, light or dark
    look: dict[str, Any] = {"color": "#D01C8B", "ms": 3, "label": "at the limit, not slipping"}
    return list(axes.plot(x[nodes], path.cycle[rows], ".", **look)) if len(rows) else []


def _edges(x: FloatArray) -> FloatArray:
    """Cell borders half-way between neighbouring nodes."""
    if len(x) == 1:
        return np.array([x[0] - 0.5, x[0] + 0.5])
    middle = 0.5 * (x[1:] + x[:-1])
    return np.concatenate([[2 * x[0] - middle[0]], middle, [2 * x[-1] - middle[-1]]])


def drift_over_load(runs: Iterable[Simulation], *, ax: Axes | None = None) -> Axes:
    """By how much a body turns, or shifts where it does not turn, in every cycle, versus the load factor.

    Parameters
    ----------
    runs
        Simulations of one joint; where one does not drift as a rigid body the number is 0, and where it is
        undecided none is drawn.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If there is no simulation.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("bearing-ring")
    >>> plot.drift_over_load([shakedown.simulate(joint, x) for x in (0.2, 1.0)]).get_ylabel()
    'turn per cycle [°]'
    """
    found = sorted((run for run in runs if run.period), key=lambda run: run.load_factor)
    if not found:
        raise UsageError("runs: expected at least one that is decided, found none")
    moves = [run.rigid_drift for run in found]
    turns = any(drift is not None and drift.turn.any() for drift in moves)
    parts = [np.zeros(3) if drift is None else drift.turn if turns else drift.shift for drift in moves]
    along = max(parts, key=lambda part: float(np.abs(part).max()))  # the axis with the largest number
    sizes = [part[np.abs(along).argmax()] for part in parts]
    axes = axes_for(ax)
    axes.plot([run.load_factor for run in found], sizes, "o-", color=style.BLUE, ms=4, label="simulated")
    axes.axhline(0.0, color=style.GREY, lw=1)
    unit = "°" if turns else units_of(found[0].problem).length
    return finished(axes, "load factor λ", with_unit(f"{'turn' if turns else 'shift'} per cycle", unit))
