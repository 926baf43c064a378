"""Loops: tangential reaction against slip, and the loading in the plane of one node's reactions."""

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import checked, require_plane, require_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of, work_unit
from shakedown.motion.event_history import EventHistory
from shakedown.plot.style import GREY, LINES, Recorded, axes_for, node_name, path_of

MOST_LOOPS = 4


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
    if problem is not None:
        require_plane("picture", problem)
    path = path_of(result)
    work = friction_work(path)
    chosen = np.argsort(-work)[:MOST_LOOPS] if nodes is None else chosen_nodes(nodes, path.v.shape[1])
    force, length = units_of(problem)
    axes = axes_for(ax)
    for colour, node in zip(LINES * len(chosen), chosen, strict=False):
        label = with_unit(f"{node_name(int(node), problem)}: {work[node]:.4g}", work_unit(force, length))
        axes.plot(path.v[:, node], path.q[:, node], ".-", color=colour, lw=1.3, ms=3, label=label)
    axes.set(xlabel=with_unit("slip v", length), ylabel=with_unit("tangential reaction q", force))
    axes.grid(alpha=0.3)
    axes.ticklabel_format(scilimits=(-2, 3))
    axes.legend(title="dissipation", fontsize="small")
    return axes


def friction_work(path: EventHistory) -> FloatArray:
    """What friction takes at each node along a path, (n,): −∫ q dv in contact [force × length]."""
    closed = path.state[:-1] != 2  # the state of a row holds until the next one
    work = -0.5 * (path.q[1:] + path.q[:-1]) * np.diff(path.v, axis=0)
    return np.asarray(np.where(closed, work, 0.0).sum(axis=0))


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
    if problem.directions == 1:
        q, name = path.q, "q"
    else:
        path = path.refined()
        q, name = problem.law.size(path.q), "|q|"
    limit = problem.law.limit(path.p)[:, node]
    lowest = -limit if problem.directions == 1 else np.zeros_like(limit)
    axes = axes_for(ax)
    axes.fill_between(path.cycle, lowest, limit, color=GREY, alpha=0.2, lw=0, label="|q| ≤ f p")
    axes.plot(path.cycle, q[:, node], ".-", color=LINES[0], lw=1.3, ms=3, label=name)
    axes.set(xlabel="time [cycles]", ylabel=with_unit(f"tangential reaction {name}", units_of(problem)[0]))
    axes.set_title(node_name(node, problem), fontsize="medium")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    return axes


def chosen_nodes(nodes: Iterable[int], n: int) -> list[int]:
    """The nodes named, at least one; ``UsageError`` where there is none of a number."""
    chosen = list(nodes)
    for node in chosen:
        if not 0 <= node < n:
            raise UsageError(f"nodes: expected numbers from 0 to {n - 1}, found {node}")
    if not chosen:
        raise UsageError("nodes: expected at least one, found none")
    return chosen


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
    chosen = chosen_nodes(nodes if isinstance(nodes, Iterable) else [nodes], problem.n)
    force, _ = units_of(problem)
    axes = axes_for(ax)
    q, p = (np.vstack([part, part[:1]])[:, chosen] for part in loading(problem).at(load_factor))
    top = 1.1 * max(float(p.max()), 0.0)
    for k, f in enumerate(sorted({float(problem.f[node]) for node in chosen})):
        label = "friction limit" if k == 0 else "_nolegend_"
        axes.plot([-f * top, 0.0, f * top], [top, 0.0, top], color=GREY, lw=1, label=label)
    for colour, node, x, y in zip(LINES * len(chosen), chosen, q.T, p.T, strict=False):
        axes.plot(x, y, ".-", color=colour, lw=1.3, ms=4, label=node_name(node, problem))
        axes.plot(x[0], y[0], "o", mfc="white", color=colour, label="_nolegend_")
    axes.plot([], [], "o", mfc="white", color=GREY, label="first load step")
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.set(xlabel=with_unit("welded reaction q_w", force), ylabel=with_unit("welded reaction p_w", force))
    axes.set_title(f"λ = {load_factor:g}", fontsize="medium")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    return axes
