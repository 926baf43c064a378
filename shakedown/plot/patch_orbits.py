"""Ways in two directions: of slips, of tangential reactions within their limits."""

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of, work_unit
from shakedown.motion.event_history import EventHistory
from shakedown.plot.loops import MOST_LOOPS, chosen_nodes
from shakedown.plot.patch_colours import work_of_nodes
from shakedown.plot.patch_places import require_space
from shakedown.plot.style import GREY, LINES, Recorded, axes_for, node_name, path_of, pressed

FARTHEST = 3.0  # times the limit: reactions beyond, of nodes that hardly press, are cut off
RIM = np.linspace(0.0, 2.0 * np.pi, 121)


@checked
def slip_orbits(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    nodes: Iterable[int] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The ways of slips in their x and y, each about its own middle, with what friction dissipates there.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution, of a joint with two directions.
    problem
        The joint: units and labels.
    nodes
        Which nodes; by default the ones that dissipate most, at most four.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, there is no such node, or the joint has one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.slip_orbits(shakedown.long_term_state(joint, 1.4), joint).get_xlabel()
    'slip v_x − middle'
    """
    require_space("picture of slip orbits", problem)
    path, work = path_of(result).refined(), work_of_nodes(result, problem)
    force, length = units_of(problem)
    axes, v = axes_for(ax), problem.layout.by_node(path.v)
    for colour, node in _coloured(work, nodes, problem.n):
        way = v[:, node] - 0.5 * (v[:, node].min(axis=0) + v[:, node].max(axis=0))
        label = with_unit(f"{node_name(node, problem)}: {work[node]:.4g}", work_unit(force, length))
        axes.plot(*way.T, color=colour, lw=1.3, label=label)
        axes.plot(*way[0], "o", mfc="white", color=colour, ms=5, label="_nolegend_")
    axes.set(xlabel=with_unit("slip v_x − middle", length), ylabel=with_unit("slip v_y − middle", length))
    axes.ticklabel_format(scilimits=(-2, 3))
    return _square(axes, "dissipation")


@checked
def reaction_orbits(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    nodes: Iterable[int] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The ways of tangential reactions within the limit, q/(f p): on the rim a node slips, or is about to.

    Parameters as for :func:`slip_orbits`. While a node is open, or about to be, nothing is drawn.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.reaction_orbits(shakedown.long_term_state(joint, 1.4), joint, nodes=[0]).get_xlabel()
    'q_x / f p [–]'
    """
    require_space("picture of reaction orbits", problem)
    path, work = path_of(result).refined(), work_of_nodes(result, problem)
    axes, p = axes_for(ax), np.where(pressed(problem, path), path.p, np.nan)
    _disc(axes)
    for colour, node in _coloured(work, nodes, problem.n):
        use = _use(problem, path.q, p, node)
        axes.plot(*use.T, color=colour, lw=1.3, label=node_name(node, problem))
    axes.set(xlabel="q_x / f p [–]", ylabel="q_y / f p [–]")
    return _square(axes)


@checked
def load_orbits(
    problem: Problem, nodes: int | Iterable[int] = 0, *, load_factor: float = 1.0, ax: Axes | None = None
) -> Axes:
    """The loading of nodes, q_w/(f p_w) over a period: within the disc it does not move a node by itself.

    Parameters
    ----------
    problem
        A joint with two directions, and its loading.
    nodes
        Which one, or which ones.
    load_factor
        λ, the factor on the periodic part.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If there is no such node, or the joint has one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> plot.load_orbits(shakedown.example("one-node-3d")).get_ylabel()
    'q_w / f p in y [–]'
    """
    require_space("picture of load orbits", problem)
    wanted = chosen_nodes(nodes if isinstance(nodes, Iterable) else [nodes], problem.n)
    q, p = (np.vstack([part, part[:1]]) for part in loading(problem).at(load_factor))
    axes = axes_for(ax)
    _disc(axes)
    for colour, node in zip(LINES * len(wanted), wanted, strict=False):
        use = _use(problem, q, p, node)
        use = np.where((np.abs(use) <= FARTHEST).all(axis=1, keepdims=True), use, np.nan)
        axes.plot(*use.T, ".-", color=colour, lw=1.3, ms=4, label=node_name(node, problem))
        axes.plot(*use[0], "o", mfc="white", color=colour, label="_nolegend_")
    axes.plot([], [], "o", mfc="white", color=GREY, label="first load step")
    axes.set(xlabel="q_w / f p in x [–]", ylabel="q_w / f p in y [–]")
    axes.set_title(f"λ = {load_factor:g}", fontsize="medium")
    return _square(axes)


def _coloured(work: FloatArray, nodes: Iterable[int] | None, n: int) -> list[tuple[str, int]]:
    """The nodes to draw, by default those that dissipate most, and their colours."""
    worst: NDArray[np.intp] = np.argsort(-work, kind="stable")[:MOST_LOOPS]
    wanted = [int(node) for node in worst] if nodes is None else chosen_nodes(nodes, n)
    return list(zip(LINES * len(wanted), wanted, strict=False))


def _use(problem: Problem, q: FloatArray, p: FloatArray, node: int) -> FloatArray:
    """q/(f p) of a node, (s, 2); NaN where it has no limit, or is open."""
    limit = problem.law.limit(p)[:, node, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(limit > 0, problem.layout.by_node(q)[:, node] / limit, np.nan))


def _disc(axes: Axes) -> None:
    axes.plot(np.cos(RIM), np.sin(RIM), color=GREY, lw=1.0, label="limit |q| = f p")


def _square(axes: Axes, title: str | None = None) -> Axes:
    axes.set_aspect("equal", adjustable="datalim")
    axes.grid(alpha=0.3)
    axes.legend(title=title, fontsize="small")
    return axes
