"""Loops: tangential reaction against slip, and the loading in the plane of one node's reactions."""

from collections.abc import Iterable

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from shakedown.errors import UsageError
from shakedown.model.loading import loading
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.units import units_of
from shakedown.plot.style import (
    GREY,
    LINES,
    Recorded,
    axes_for,
    labelled,
    node_name,
    path_of,
)

MOST_LOOPS = 4


def hysteresis(
    result: Recorded,
    problem: Problem | None = None,
    *,
    nodes: Iterable[int] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Tangential reaction against slip: the area of a loop is what friction takes in one period.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution.
    problem
        For units, where it has them.
    nodes
        Which nodes; by default the ones that dissipate most, at most four.
    ax
        Where to draw.

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
    path = path_of(result)
    work = _friction_work(path.q, path.v, path.state)
    chosen = np.argsort(-work)[:MOST_LOOPS] if nodes is None else _checked(nodes, path.v.shape[1])
    force, length = units_of(problem)
    axes = axes_for(ax)
    for colour, node in zip(LINES * len(chosen), chosen, strict=False):
        label = labelled(f"{node_name(int(node))}: {work[node]:.4g}", f"{force} {length}".strip())
        axes.plot(path.v[:, node], path.q[:, node], ".-", color=colour, lw=1.3, ms=3, label=label)
    axes.set(xlabel=labelled("slip v", length), ylabel=labelled("tangential reaction q", force))
    axes.grid(alpha=0.3)
    axes.legend(title="dissipation", fontsize="small")
    return axes


def _friction_work(q: FloatArray, v: FloatArray, state: NDArray[np.int64]) -> FloatArray:
    """What friction takes at each node along the path, (n,): −∫ q dv in contact [force × length]."""
    closed = (state[:-1] != 2) & (state[1:] != 2)
    work = -0.5 * (q[1:] + q[:-1]) * np.diff(v, axis=0)
    return np.asarray(np.where(closed, work, 0.0).sum(axis=0))


def _checked(nodes: Iterable[int], n: int) -> list[int]:
    chosen = list(nodes)
    for node in chosen:
        if not 0 <= node < n:
            raise UsageError(f"nodes: expected numbers from 0 to {n - 1}, found {node}")
    return chosen


def load_loop(problem: Problem, node: int = 0, *, load_factor: float = 1.0, ax: Axes | None = None) -> Axes:
    """The loading of one node: welded reactions (q_w, p_w) over a period, with the friction cone.

    While the loop stays inside the cone |q_w| ≤ f p_w a joint without locked-in slip
    does not slip at this node (as long as no other one does).

    Parameters
    ----------
    problem
        The joint and its loading.
    node
        Which node.
    load_factor
        λ, the factor on the periodic part.
    ax
        Where to draw.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> plot.load_loop(shakedown.example("two-node"), 1).get_xlabel()
    'welded reaction q_w'
    """
    (node,) = _checked([node], problem.n)
    q, p = (part[:, node] for part in loading(problem).at(load_factor))
    force, _ = units_of(problem)
    axes = axes_for(ax)
    axes.plot(np.append(q, q[0]), np.append(p, p[0]), ".-", color=LINES[0], lw=1.3, ms=4, label="loading")
    axes.plot(q[0], p[0], "o", mfc="white", color=LINES[0], label="first load step")
    top = 1.1 * max(float(p.max()), 0.0)
    f = float(problem.f[node])
    for side in (-1, 1):
        axes.plot(
            [0.0, side * f * top], [0.0, top], color=GREY, lw=1, label="friction limit" if side > 0 else None
        )
    axes.axhline(0.0, color=GREY, lw=0.6)
    axes.set(xlabel=labelled("welded reaction q_w", force), ylabel=labelled("welded reaction p_w", force))
    axes.set_title(f"{node_name(node)}, λ = {load_factor:g}", fontsize="medium")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    return axes
