"""Loops of nodes: reactions against slips or within their limits, paths of slips, the loading of nodes."""

from collections.abc import Iterable, Iterator

import numpy as np
from matplotlib.axes import Axes

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import few
from shakedown.ground.size_limits import EACH_SHOWN
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked, require_plane, require_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.event_history import EventHistory
from shakedown.plot.drawn_path import (
    Recorded,
    chosen_nodes,
    path_in_the_plane,
    path_of,
    pressed,
    work_of_nodes,
)
from shakedown.plot.patch_places import in_space, require_space
from shakedown.plot.style import FARTHEST, GREY, LINES, axes_for, finished, node_name

RIM = np.linspace(0.0, 2.0 * np.pi, 121)


@checked
def hysteresis(
    result: Recorded | EventHistory,
    problem: Problem | None = None,
    *,
    nodes: Iterable[int] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Tangential reaction against slip: the area of a loop is what friction dissipates in one period.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        For units, where it has them.
    nodes
        Which nodes; by default the ones that dissipate most, at most four.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, or there is no such node.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> state = shakedown.long_term_state(shakedown.example("two-node"), 0.9)
    >>> [text.get_text() for text in plot.hysteresis(state).get_legend().get_texts()]
    ['node 1: 961.9', 'node 0: 0']
    """
    path, work = path_in_the_plane(result, problem), work_of_nodes(result)
    force, length = units_of(problem)
    axes = axes_for(ax)
    for colour, node in _worst(work, nodes):
        label = _with_work(node, work, problem)
        axes.plot(path.v[:, node], path.q[:, node], ".-", color=colour, lw=1.3, ms=3, label=label)
    axes.ticklabel_format(scilimits=(-2, 3))
    names = with_unit("slip v", length), with_unit("tangential reaction q", force)
    return finished(axes, *names, of_legend="dissipation")


@checked
def slip_orbits(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    nodes: Iterable[int] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The paths of slips in their x and y, each about its own middle, with what friction dissipates there.

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
    path, work = path_of(result).refined(), work_of_nodes(result)
    axes, v = axes_for(ax), problem.layout.by_node(path.v)
    for colour, node in _worst(work, nodes):
        way = v[:, node] - 0.5 * (v[:, node].min(axis=0) + v[:, node].max(axis=0))
        axes.plot(*way.T, color=colour, lw=1.3, label=_with_work(node, work, problem))
        axes.plot(*way[0], "o", mfc="white", color=colour, ms=5, label="_nolegend_")
    axes.set_aspect("equal", adjustable="datalim")
    axes.ticklabel_format(scilimits=(-2, 3))
    names = (with_unit(f"slip v_{axis} − middle", units_of(problem).length) for axis in "xy")
    return finished(axes, *names, of_legend="dissipation")


@checked
def reaction_orbits(
    result: Recorded | EventHistory,
    problem: Problem,
    *,
    nodes: Iterable[int] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """The paths of tangential reactions within the limit, q/(f p): on the rim a node slips, or is about to.

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
    path = path_of(result).refined()
    axes, p = _disc(ax), np.where(pressed(problem, path), path.p, np.nan)
    for colour, node in _worst(work_of_nodes(result), nodes):
        use = _use(problem, path.q, p, node)
        axes.plot(*use.T, color=colour, lw=1.3, label=node_name(node, problem))
    return finished(axes, "q_x / f p [–]", "q_y / f p [–]")


@checked
def reactions_in_time(
    result: Recorded | EventHistory, problem: Problem, node: int = 0, *, ax: Axes | None = None
) -> Axes:
    """Tangential reaction of one node over time, between its friction limits ±f p.

    With two tangential directions its size, below f p. Where it runs along a limit the node slips, or is
    about to.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        The joint: friction, units, labels.
    node
        Which node.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, or there is no such node.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("two-node")
    >>> plot.reactions_in_time(shakedown.long_term_state(joint, 0.9), joint, 1).get_xlabel()
    'time [cycles]'
    """
    require_problem(problem)
    (node,), path = chosen_nodes([node], problem.n), path_of(result)
    path = path.refined()
    limit = problem.law.limit(path.p)[:, node]
    q, lowest, name = path.q, -limit, "q"
    if in_space(problem):
        q, lowest, name = problem.law.size(path.q), np.zeros_like(limit), "|q|"
    axes = axes_for(ax)
    axes.fill_between(path.cycle, lowest, limit, color=GREY, alpha=0.2, lw=0, label="|q| ≤ f p")
    axes.plot(path.cycle, q[:, node], ".-", color=LINES[0], lw=1.3, ms=3, label=name)
    label = with_unit(f"tangential reaction {name}", units_of(problem).force)
    return finished(axes, "time [cycles]", label, title=node_name(node, problem))


@checked
def load_loop(
    problem: Problem, nodes: int | Iterable[int] = 0, *, load_factor: float = 1.0, ax: Axes | None = None
) -> Axes:
    """The loading of nodes: welded reactions (q_w, p_w) over a period, with the friction cone.

    While the loop of a node stays inside the cone |q_w| ≤ f p_w a joint without locked-in slip
    does not slip at this node (as long as no other one does).

    Parameters
    ----------
    problem
        The joint and its loading.
    nodes
        Which one, or which ones.
    load_factor
        λ, the factor on the periodic part.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> plot.load_loop(shakedown.example("two-node"), 1).get_xlabel()
    'welded reaction q_w'
    """
    require_plane("picture", problem)
    force, axes = units_of(problem).force, axes_for(ax)
    loaded = _nodes_loaded(problem, nodes)
    chosen = [node for _, node in loaded]
    q, p = _closed_loads(problem, load_factor)
    top = 1.1 * max(float(p[:, chosen].max()), 0.0)
    for k, f in enumerate(sorted({float(problem.f[node]) for node in chosen})):
        label = "friction limit" if k == 0 else "_nolegend_"
        axes.plot([-f * top, 0.0, f * top], [top, 0.0, top], color=GREY, lw=1, label=label)
    for colour, node in loaded:
        _draw_load(axes, np.stack([q[:, node], p[:, node]]), colour, node_name(node, problem))
    axes.plot([], [], "o", mfc="white", color=GREY, label="first load step")
    axes.axhline(0.0, color=GREY, lw=0.6)
    names = with_unit("welded reaction q_w", force), with_unit("welded reaction p_w", force)
    return finished(axes, *names, title=f"λ = {load_factor:g}")


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
    loaded, (q, p) = _nodes_loaded(problem, nodes), _closed_loads(problem, load_factor)
    axes = _disc(ax)
    for colour, node in loaded:
        use = _use(problem, q, p, node)
        # Reactions of nodes that hardly press are many times their limit.
        use = np.where((np.abs(use) <= FARTHEST).all(axis=1, keepdims=True), use, np.nan)
        _draw_load(axes, use.T, colour, node_name(node, problem))
    axes.plot([], [], "o", mfc="white", color=GREY, label="first load step")
    return finished(axes, "q_w / f p in x [–]", "q_w / f p in y [–]", title=f"λ = {load_factor:g}")


def _worst(work: FloatArray, nodes: Iterable[int] | None) -> Iterator[tuple[str, int]]:
    """The nodes to draw, by default those that dissipate most, and their colours."""
    most = np.argsort(-work, kind="stable")[:EACH_SHOWN].tolist()
    return _coloured(most if nodes is None else chosen_nodes(nodes, len(work)))


def _coloured(nodes: list[int]) -> Iterator[tuple[str, int]]:
    return zip(LINES * len(nodes), nodes, strict=False)


def _with_work(node: int, work: FloatArray, problem: Problem | None) -> str:
    """The name of a node, and the friction work there."""
    return with_unit(f"{node_name(node, problem)}: {few(work[node])}", units_of(problem).work)


def _nodes_loaded(problem: Problem, nodes: int | Iterable[int]) -> list[tuple[str, int]]:
    """One node, or several, and their colours."""
    return list(_coloured(chosen_nodes(nodes if isinstance(nodes, Iterable) else [nodes], problem.n)))


def _closed_loads(problem: Problem, load_factor: float) -> tuple[FloatArray, FloatArray]:
    """Welded reactions q_w, p_w over a period, with the first load step once more at its end."""
    q, p = (np.vstack([part, part[:1]]) for part in loading(problem).at(load_factor))
    return q, p


def _draw_load(axes: Axes, way: FloatArray, colour: str, name: str) -> None:
    """The loading of a node, (2, steps), with a circle at the first load step."""
    axes.plot(*way, ".-", color=colour, lw=1.3, ms=4, label=name)
    axes.plot(*way[:, 0], "o", mfc="white", color=colour, label="_nolegend_")


def _use(problem: Problem, q: FloatArray, p: FloatArray, node: int) -> FloatArray:
    """q/(f p) of a node, (s, 2); NaN where it has no limit, or is open."""
    limit = problem.law.limit(p)[:, node, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(np.where(limit > 0, problem.layout.by_node(q)[:, node] / limit, np.nan))


def _disc(ax: Axes | None) -> Axes:
    """Axes with the limit of tangential reactions over f p."""
    axes = axes_for(ax)
    axes.plot(np.cos(RIM), np.sin(RIM), color=GREY, lw=1.0, label="limit |q| = f p")
    axes.set_aspect("equal", adjustable="datalim")
    return axes
