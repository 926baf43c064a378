"""One instant of a motion, and animations: rows that sweep the slip, a stick sector that moves with it."""

import os
from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from shakedown.files.atomic_write import atomic_write
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import MANY
from shakedown.ground.status import OPEN
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked, is_finite, require_plane
from shakedown.joint.constraints import constraints
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.event_history import EventHistory
from shakedown.plot.drawn_path import Recorded, path_of
from shakedown.plot.planes import draw_rows, loads_felt, stick_sector, window
from shakedown.plot.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    PURPLE,
    RED,
    STATES,
    axes_for,
    node_name,
)
from shakedown.programs.polygon import corners

PER_SECOND = 12
INSTANT = (5.6, 5.0)  # inches
COLOURS = {0: BLACK, 1: RED, -1: BLUE, 2: PURPLE}  # of the contact states


@checked
def slip_space_at(result: Recorded, problem: Problem, cycle: float, *, ax: Axes | None = None) -> Axes:
    """The slip plane of a two-node joint at one instant: its rows, the slips that stick, the way so far.

    The rows move with the load. Where one of them touches the slip, that node is at its
    limit (thick line) and is pushed along (thesis figs 4.13–4.15).

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        A joint of two nodes.
    cycle
        The time in cycles.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If the joint has another number of nodes, or no events were recorded.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> from shakedown.motion.evolve import evolve
    >>> joint = shakedown.example("two-node")
    >>> axes = plot.slip_space_at(evolve(joint, 0.9, cycles=2), joint, 1.25)
    >>> axes.get_title()
    't = 1.25 cycles'
    """
    require_plane("picture", problem)
    if problem.n != 2:
        raise UsageError(f"slip space: expected a problem with 2 nodes, found {problem.n}")
    path, rows = path_of(result), constraints(problem)
    axes, now = axes_for(ax, INSTANT), path.at(np.array([cycle]))
    slip, state = now.v[0], now.state[0]
    limits = problem.law.cone(now.q[0], now.p[0]) + rows.G @ slip  # that load and gaps leave now
    region = corners(rows.G, limits)  # empty where no pair of slips lets both nodes stick
    axes.fill(*region.T, fc=GREEN, alpha=0.25, lw=0, label="both stick")
    draw_rows(axes, rows, limits, active=state[rows.node] == rows.side)
    way = path.v[path.cycle <= cycle]
    axes.plot(*np.vstack([way, slip]).T, color=GREY, lw=1.2, zorder=2, label="way so far")
    axes.plot(*slip, "o", color=BLACK, ms=6, zorder=4, label="slip")
    low, high = window(path.v)
    margin = 0.6 * np.max(high - low)
    _, length = units_of(problem)
    axes.set(xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    axes.set(
        xlabel=with_unit(f"slip of {node_name(0, problem)}", length),
        ylabel=with_unit(f"slip of {node_name(1, problem)}", length),
    )
    _finish(axes, cycle)
    return axes


@checked
def reactions_at(
    result: Recorded, problem: Problem, cycle: float, node: int = 0, *, ax: Axes | None = None
) -> Axes:
    """The load that one node feels at one instant, and its stick sector (thesis figs 4.2–4.9, 5.1–5.3).

    As :func:`reaction_space`; the sector is that of the present slip.

    Parameters
    ----------
    result, problem, cycle, ax
        As for :func:`slip_space_at`, for any number of nodes.
    node
        The node to show.

    Raises
    ------
    UsageError
        If no events were recorded, or there is no such node.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("one-node")
    >>> axes = plot.reactions_at(shakedown.long_term_state(joint, 1.1), joint, 2.25)
    >>> axes.get_xlabel()
    'F₁ = q_w'
    >>> axes.get_title()
    'node 0, t = 2.25 cycles'
    """
    require_plane("picture", problem)
    if not 0 <= node < problem.n:
        raise UsageError(f"node: expected a number from 0 to {problem.n - 1}, found {node}")
    path = path_of(result)
    axes, now = axes_for(ax, INSTANT), path.at(np.array([cycle]))
    force, here = loads_felt(problem, path, node), loads_felt(problem, now, node)[0]
    closed = path.state[:, node] != OPEN
    apexes = -path.v[closed, node, None] * np.array([problem.A[node, node], problem.B[node, node]])
    shown = np.vstack([force, apexes])
    margin = 0.15 * float(np.ptp(shown, axis=0).max() or 1.0)
    low, high = shown.min(axis=0) - margin, shown.max(axis=0) + margin
    kind = int(now.state[0, node])
    sector = stick_sector(problem, node, float(now.v[0, node]), 3.0 * float(np.max(high - low)))
    shown = sector if kind != OPEN else sector[:0]
    axes.fill(*shown.T, fc=GREEN, alpha=0.25, lw=0, label="sticks")
    axes.plot(*shown[:1].T, "^", color=GREEN, ms=7, zorder=3)
    axes.plot(*force.T, color=GREY, lw=0.8, zorder=1, label="whole way")
    for state, colour in COLOURS.items():
        place = here if state == kind else np.full(2, np.nan)
        axes.plot(*place, "o", color=colour, ms=7, zorder=4, label=STATES[state][0])
    unit, _ = units_of(problem)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))
    axes.set(xlabel=with_unit("F₁ = q_w", unit), ylabel=with_unit("F₂ = p_w", unit))
    _finish(axes, cycle, f"{node_name(node, problem)}, ")
    return axes


def _finish(axes: Axes, cycle: float, of: str = "") -> None:
    axes.set_title(f"{of}t = {cycle:.2f} cycles", fontsize="medium")
    axes.legend(fontsize="x-small", loc="upper center", bbox_to_anchor=(0.5, -0.13), ncols=4)


@checked
def animate_slip_space(
    result: Recorded,
    problem: Problem,
    path: str | os.PathLike[str],
    *,
    longest: float = 3.0,
    frames: int = 60,
) -> None:
    """Write the motion of :func:`slip_space_at` as an animation (GIF), whole or not at all.

    Parameters
    ----------
    result, problem
        As for :func:`slip_space_at`.
    path
        Where to write.
    longest
        How many cycles to show, from the beginning of what is recorded.
    frames
        Number of pictures, shown at twelve a second.

    Raises
    ------
    UsageError
        As for :func:`slip_space_at`, or if the file cannot be written.

    Examples
    --------
    >>> import tempfile, pathlib, shakedown
    >>> from shakedown import plot
    >>> joint, target = shakedown.example("two-node"), pathlib.Path(tempfile.mkdtemp()) / "slip.gif"
    >>> plot.animate_slip_space(shakedown.long_term_state(joint, 0.9), joint, target, frames=3)
    >>> target.read_bytes()[:6]
    b'GIF89a'
    """
    require_plane("picture", problem)

    def draw(cycle: float, axes: Axes) -> None:
        slip_space_at(result, problem, cycle, ax=axes)

    _animate(path_of(result), draw, path, longest, frames)


@checked
def animate_reactions(
    result: Recorded,
    problem: Problem,
    path: str | os.PathLike[str],
    node: int = 0,
    *,
    longest: float = 3.0,
    frames: int = 60,
) -> None:
    """Write the motion of :func:`reactions_at` as an animation (GIF), whole or not at all.

    Parameters as for :func:`animate_slip_space`; ``node`` is the one to show.
    """
    require_plane("picture", problem)

    def draw(cycle: float, axes: Axes) -> None:
        reactions_at(result, problem, cycle, node, ax=axes)

    _animate(path_of(result), draw, path, longest, frames)


def _animate(
    history: EventHistory,
    draw: Callable[[float, Axes], None],
    path: str | os.PathLike[str],
    longest: float,
    frames: int,
) -> None:
    check_count("frames", frames, MANY)
    if not (is_finite(longest) and longest > 0):
        raise UsageError(f"longest: expected a number of cycles > 0, found {longest:g}")
    first = float(history.cycle[0])
    last = min(float(history.cycle[-1]), first + longest)
    figure = Figure(figsize=INSTANT, dpi=80, layout="constrained")
    axes = figure.subplots()
    pictures = []
    for cycle in _times(first, last, frames):
        axes.clear()
        draw(float(cycle), axes)
        pictures.append(_picture(figure))
        figure.set_layout_engine("none")  # keep the layout of the first frame
    with atomic_write(path) as file:
        pictures[0].save(
            file, "GIF", save_all=True, append_images=pictures[1:], duration=1000 // PER_SECOND, loop=0
        )


def _times(first: float, last: float, frames: int) -> FloatArray:
    """Evenly spaced times, without the last one where the motion repeats from there."""
    return np.linspace(first, last, frames, endpoint=False) if frames > 1 else np.array([first])


def _picture(figure: Figure) -> Image.Image:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    whole = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    return whole.quantize(colors=64, dither=Image.Dither.NONE)  # few enough for a small file
