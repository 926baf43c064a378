"""Loops of nodes, in slips, reactions and loads; the loop of a load, and damping over its amplitude."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from shakedown.assessment.damping import DampingCurve
from shakedown.ground.constants import EACH_SHOWN, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import down, few, shortened, sized, with_unit
from shakedown.ground.status import Outcome
from shakedown.joint.arguments import require_plane, require_problem
from shakedown.joint.constraints import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.long_term.simulation import Simulation
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import recorded_path
from shakedown.plot import paths, style
from shakedown.plot.patch_places import in_space, require_space
from shakedown.plot.paths import Recorded
from shakedown.plot.style import axes_for, finished, node_name

Nodes = Iterable[int] | None  # by default those that dissipate most


def hysteresis(
    result: Recorded, problem: Problem | None = None, *, nodes: Nodes = None, ax: Axes | None = None
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
    path, work = paths.path_in_the_plane(result, problem), paths.work_of_nodes(result)
    force, length = units_of(problem)
    axes = axes_for(ax)
    for colour, node in _chosen(nodes, len(work), work):
        label = _with_work(node, work, problem)
        axes.plot(path.v[:, node], path.q[:, node], ".-", color=colour, lw=1.3, ms=3, label=label)
    names = with_unit("slip v", length), with_unit("tangential reaction q", force)
    return finished(axes, *names, of_legend="dissipation")


def slip_orbits(result: Recorded, problem: Problem, *, nodes: Nodes = None, ax: Axes | None = None) -> Axes:
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
    path, work = recorded_path(result).refined(), paths.work_of_nodes(result)
    axes, v = axes_for(ax), problem.layout.by_node(path.v)
    for colour, node in _chosen(nodes, len(work), work):
        way = v[:, node] - 0.5 * (v[:, node].min(axis=0) + v[:, node].max(axis=0))
        axes.plot(*way.T, color=colour, lw=1.3, label=_with_work(node, work, problem))
        axes.plot(*way[0], "o", mfc="white", color=colour, ms=5, label="_nolegend_")
    axes.set_aspect("equal", adjustable="datalim")
    names = (with_unit(f"slip v_{axis} − middle", units_of(problem).length) for axis in "xy")
    return finished(axes, *names, of_legend="dissipation")


def reaction_orbits(
    result: Recorded, problem: Problem, *, nodes: Nodes = None, ax: Axes | None = None
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
    path = recorded_path(result).refined()
    axes, p = axes_for(ax), np.where(paths.pressed(problem, path), path.p, np.nan)
    rim = np.linspace(0.0, 2.0 * np.pi, 121)
    axes.plot(np.cos(rim), np.sin(rim), color=style.GREY, lw=1.0, label="limit |q| = f p")
    axes.set_aspect("equal", adjustable="datalim")
    for colour, node in _chosen(nodes, problem.n, paths.work_of_nodes(result)):
        use = problem.layout.by_node(path.q)[:, node] / problem.law.limit(p)[:, node, None]
        axes.plot(*use.T, color=colour, lw=1.3, label=node_name(node, problem))
    return finished(axes, "q_x / f p [–]", "q_y / f p [–]")


def reactions_in_time(result: Recorded, problem: Problem, node: int = 0, *, ax: Axes | None = None) -> Axes:
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
    (node,), path = paths.chosen_nodes([node], problem.n), recorded_path(result).refined()
    limit = problem.law.limit(path.p)[:, node]
    q, lowest, name = path.q, -limit, "q"
    if in_space(problem):
        q, lowest, name = problem.law.size(path.q), np.zeros_like(limit), "|q|"
    axes = axes_for(ax)
    axes.fill_between(path.cycle, lowest, limit, color=style.GREY, alpha=0.2, lw=0, label="|q| ≤ f p")
    axes.plot(path.cycle, q[:, node], ".-", color=style.LINES[0], lw=1.3, ms=3, label=name)
    label = with_unit(f"tangential reaction {name}", units_of(problem).force)
    return finished(axes, "time [cycles]", label, title=node_name(node, problem))


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
    force, axes, loaded = units_of(problem).force, axes_for(ax), _chosen(nodes, problem.n)
    q, p = (np.vstack([part, part[:1]]) for part in loading(problem).at(load_factor))
    top = 1.1 * max(float(p[:, [node for _, node in loaded]].max()), 0.0)
    frictions = sorted({float(problem.f[node]) for _, node in loaded})
    limits = axes.plot(np.outer([-top, 0.0, top], frictions), [top, 0.0, top], color=style.GREY, lw=1)
    limits[0].set_label("friction limit")
    for colour, node in loaded:
        axes.plot(q[:, node], p[:, node], ".-", color=colour, lw=1.3, ms=4, label=node_name(node, problem))
        axes.plot(q[0, node], p[0, node], "o", mfc="white", color=colour, label="_nolegend_")
    axes.plot([], [], "o", mfc="white", color=style.GREY, label="first load step")
    names = with_unit("welded reaction q_w", force), with_unit("welded reaction p_w", force)
    return finished(axes, *names, title=f"λ = {load_factor:g}")


def load_title(problem: Problem, load: int) -> str:
    """How a load is called: by its name where the problem has one for each."""
    names = problem.load_names or ()
    count = 0 if problem.load_reactions is None else len(problem.load_reactions)
    name = names[load] if len(names) == count else ""
    return f"load {load}" + (f" ({shortened(name, style.LONGEST_LABEL)})" if name else "").replace("$", r"\$")


def loop(state: LongTermState | Simulation, *, load: int = 0, ax: Axes | None = None) -> Axes:
    """A load against the displacement that it works along, over one period of a long-term state.

    The areas of the loops of all loads are together what friction (and the damping of jumps) dissipates.

    Parameters
    ----------
    state
        A long-term state, or a simulation that found one.
    load
        Which load of the problem, by number.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    ProblemError
        If the problem does not know its loads or their compliance.
    UsageError
        If no events were recorded, or there is no such load.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.Problem(
    ...     A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-3.0], [3.0]], p_w=[[2.0], [2.0]],
    ...     load_reactions=[[-1.0, 0.0]], load_history=[[3.0], [-3.0]], load_compliance=[[0.1]],
    ... )
    >>> plot.loop(shakedown.long_term_state(joint, 1.0)).get_title()
    'load 0\\narea 4 in one period'
    """
    problem = state.problem
    loops = load_loops(problem, getattr(state, "settled", state))
    if not 0 <= load < loops.load.shape[1]:
        raise UsageError(f"load: expected a number from 0 to {loops.load.shape[1] - 1}, found {load}")
    axes = axes_for(ax)
    axes.plot(loops.displacement[:, load], loops.load[:, load], ".-", color=style.LINES[0], lw=1.3, ms=3)
    area = sized(float(loops.areas[load]), units_of(problem).work)
    title = f"{load_title(problem, load)}\narea {area} in one period"
    moved = with_unit("conjugate displacement", loops.units[load].moved(problem))
    return finished(axes, moved, with_unit("load", loops.units[load].load or "units of it"), title=title)


def damping_curve(curve: DampingCurve, *, ax: Axes | None = None) -> Axes:
    """Damping and stiffness versus the amplitude of a load, with the limit below which nothing damps.

    The loss factor (of a mode the damping ratio) on the left, the secant stiffness (the frequency) on the
    right, each in absolute terms, as computed. Amplitudes without a closed loop are marked below.

    Parameters
    ----------
    curve
        What :func:`shakedown.damping` found.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.Problem(
    ...     A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-1.0], [1.0]], p_w=[[2.0], [2.0]],
    ...     load_reactions=[[-1.0, 0.0]], load_history=[[1.0], [-1.0]], load_compliance=[[0.1]],
    ... )
    >>> plot.damping_curve(shakedown.damping(joint, [0.5, 1.5, 2.0])).get_ylabel()
    'loss factor η [–]'
    """
    axes = axes_for(ax)
    modal = not np.isnan(curve.load_frequency)
    left = curve.damping_ratio if modal else curve.loss_factor
    right = curve.frequency / (2 * np.pi) if modal else curve.secant_stiffness
    names = ("damping ratio ζ", "frequency") if modal else ("loss factor η", "secant stiffness")
    (one,) = axes.plot(curve.amplitude, left, ".-", color=style.BLUE, lw=1.3, label=names[0])
    handles: list[Any] = [one]
    if len(curve.states):
        word = "damping_ratio" if modal else "loss_factor"
        ends, label = (curve.least[word], curve.largest[word]), f"from {len(curve.states)} initial slips"
        handles.append(axes.fill_between(curve.amplitude, *ends, color=style.BLUE, alpha=0.2, label=label))
        handles += _unique_line(axes, curve, left)
    beside = axes.twinx()
    (other,) = beside.plot(curve.amplitude, right, ".--", color=style.RED, lw=1.1, label=names[1])
    unit = "1/time" if modal else curve.unit.stiffness or "load/displacement"
    beside.set_ylabel(with_unit(names[1], unit), color=style.RED)
    positive = curve.amplitude[curve.amplitude > 0]
    # ratio of the largest to the smallest amplitude from which on the axis is logarithmic
    if len(positive) > 1 and positive[-1] >= 10.0 * positive[0]:
        axes.set_xscale("log")
    axes.set_ylim(bottom=0.0)
    name = load_title(curve.problem, curve.load)
    finished(axes, f"amplitude of {name} [–]", f"{names[0]} [–]")
    below: dict[str, Any] = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.13), "frameon": False}
    axes.legend(handles=[*handles, other, *_marks(axes, curve)], fontsize="small", ncols=2, **below)
    return axes


def _unique_line(axes: Axes, curve: DampingCurve, values: FloatArray) -> list[Any]:
    """A thicker line where the limit cycle is proved to be the only one."""
    if not curve.unique.any():
        return []
    proved = np.where(curve.unique, values, np.nan)
    return axes.plot(
        curve.amplitude, proved, color=style.GREEN, lw=3, alpha=0.5, label="the same from every state"
    )


def _marks(axes: Axes, curve: DampingCurve) -> list[Any]:
    """Lines at λ_E and λ_T, and marks on the axis at amplitudes whose loop does not close."""
    marks = {Outcome.RATCHETTING: "x", Outcome.SEPARATION: "o", "slides away": "v", Outcome.UNDECIDED: "d"}
    found: list[Any] = []
    for name, limit, meaning, colour, dashes in (
        ("λ_E", curve.proved_limit, "none below, proved", style.GREEN, "-"),
        ("λ_T", curve.simulated_limit, "none found below", style.GREY, ":"),
    ):
        if 0 < limit < np.inf:
            label = f"{name} = {down(limit, 6)}: {meaning}"
            found.append(axes.axvline(limit, label=label, color=colour, lw=1.2, ls=dashes))
    words = np.where(curve.slides_away, "slides away", [str(outcome) for outcome in curve.outcome])
    for word, mark in marks.items():
        chosen = curve.amplitude[words == word]
        look: dict[str, Any] = {"color": style.GREY, "transform": axes.get_xaxis_transform(), "label": word}
        found += axes.plot(chosen, np.full(len(chosen), 0.02), mark, **look) if len(chosen) else []
    return found


def _chosen(nodes: Nodes | int, n: int, work: FloatArray | None = None) -> list[tuple[str, int]]:
    """Nodes and their colours; by default those of the most work."""
    if nodes is None:
        nodes = [] if work is None else np.argsort(-work, kind="stable")[:EACH_SHOWN].tolist()
    chosen = paths.chosen_nodes(nodes if isinstance(nodes, Iterable) else [nodes], n)
    return list(zip(style.LINES * len(chosen), chosen, strict=False))


def _with_work(node: int, work: FloatArray, problem: Problem | None) -> str:
    """The name of a node, and the friction work there."""
    return with_unit(f"{node_name(node, problem)}: {few(work[node])}", units_of(problem).work)
