"""The joint as it is given: where its nodes are, how they are loaded, which of them limit it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from shakedown.assessment.sensitivities import KINDS, Sensitivities
from shakedown.ground.constants import EACH_SHOWN, MINOR, SIX_DIGITS, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import with_unit
from shakedown.joint.arguments import require_plane, require_problem
from shakedown.joint.constraints import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.plot import style
from shakedown.plot.patch_places import in_space
from shakedown.plot.style import axes_for, draw_arrows, finished, node_name, positions


def contact(problem: Problem, *, load_factor: float = 1.0, ax: Axes | None = None) -> Axes:
    """The contact nodes with their normals, and the loads on them as arrows.

    An arrow is the mean welded reaction on the (first) body; the line about its tail is the path
    of the tail over a period. Nodes are where they are in the model, in the plane in which they
    lie; where the problem does not know that, side by side along the contact.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ, the factor on the periodic part.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> axes = plot.contact(shakedown.example("block-9"))
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['contact nodes', 'normals', 'mean load', 'load over a period']
    """
    require_plane("picture", problem)
    place, normal, tangent, label = _plane(problem)
    mean, (q, p) = loading(problem), loading(problem).at(load_factor)
    arrows = mean.q0[:, None] * tangent + mean.p0[:, None] * normal
    tips = q[:, :, None] * tangent + p[:, :, None] * normal
    size = float(np.ptp(place, axis=0).max()) or 1.0
    largest = float(max(np.linalg.norm(tips, axis=2).max(), np.linalg.norm(arrows, axis=1).max()))
    scale = 0.16 * size / largest if largest else 0.0  # as a fraction of the size of the picture
    # nodes with arrows, about; more would cover each other
    axes, shown = axes_for(ax), slice(None, None, -(-problem.n // 40))
    axes.plot(*place.T, "o", color=style.BLACK, ms=3, label="contact nodes", zorder=3)
    ends = np.stack([place, place + style.MARGIN * size * normal], axis=1)[shown]
    axes.add_collection(LineCollection(list(ends), colors=style.GREY, linewidths=0.8, label="normals"))
    foot, vector = place[shown] - scale * arrows[shown], scale * arrows[shown]
    draw_arrows(axes, foot, vector, color=style.BLUE, label="mean load", width=0.004)
    tails = foot - scale * (tips - arrows)[:, shown]
    loops = np.concatenate([tails, tails[:1]]).swapaxes(0, 1)
    look: dict[str, Any] = {"colors": style.RED, "linewidths": 0.9, "label": "load over a period"}
    axes.add_collection(LineCollection(list(loops), **look))
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    if not label[1]:  # side by side: the vertical position has no meaning
        axes.set_yticks([])
    return finished(axes, *label)


def _plane(problem: Problem) -> tuple[FloatArray, FloatArray, FloatArray, Sequence[str]]:
    """Places, normals and tangents in the plane of the picture, each (n, 2), and the names of its axes."""
    n = problem.n
    if problem.coordinates is None or problem.normal is None or problem.tangent is None:
        along, name = positions(problem, n)
        right, up = np.tile([1.0, 0.0], (n, 1)), np.tile([0.0, 1.0], (n, 1))
        return np.column_stack([along, np.zeros(n)]), up, right, (name, "")
    spread = np.abs(problem.normal).sum(axis=0) + np.abs(problem.tangent).sum(axis=0)
    plane = sorted(np.argsort(-spread, kind="stable")[:2].tolist())
    named = [with_unit("xyz"[k], units_of(problem).length) for k in plane]
    return problem.coordinates[:, plane], problem.normal[:, plane], problem.tangent[:, plane], named


def loads_in_time(problem: Problem, *, load_factor: float = 1.0, ax: Axes | None = None) -> Axes:
    """Sums of the welded reactions of all nodes over one period.

    Where the nodes have directions of their own, as on the two faces of a lap joint, tangential
    reactions cannot be added: the sums then are those along the axes of the model. With two tangential
    directions there is a sum for either.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ, the factor on the periodic part.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> plot.loads_in_time(shakedown.example("two-node")).get_xlabel()
    'time [cycles]'
    """
    colours = (style.BLUE, style.ORANGE, style.GREEN)
    require_problem(problem)
    q, p = loading(problem).at(load_factor)
    time = np.arange(problem.m + 1) / problem.m
    axes = axes_for(ax)
    for (name, total), colour in zip(_sums(problem, q, p).items(), colours, strict=False):
        axes.plot(time, np.append(total, total[0]), ".-", color=colour, ms=4, lw=1.2, label=name)
    return finished(axes, "time [cycles]", with_unit("sum of welded reactions", units_of(problem).force))


def _sums(problem: Problem, q: FloatArray, p: FloatArray) -> dict[str, FloatArray]:
    """Sums over the nodes: normal and tangential, or along the axes where directions differ."""
    plane, normal, both = not in_space(problem), problem.normal, problem.layout.by_node(q)
    tangents = problem.tangents if not plane or problem.tangent is None else problem.tangent[:, None]
    if normal is None or tangents is None or np.allclose(tangents, tangents[0], atol=SIX_DIGITS):
        names = ["Σ q_w, all nodes"] if plane else ["Σ q_w in x", "Σ q_w in y"]
        tangential = zip(names, both.sum(axis=1).T, strict=True)
        return {"Σ p_w, all nodes": p.sum(axis=1), **dict(tangential)}
    total = p @ normal + np.einsum("snd,ndk->sk", both, tangents)
    loaded = np.abs(normal).max(axis=0) + np.abs(tangents).max(axis=(0, 1)) > SIX_DIGITS
    return {f"Σ along {'xyz'[k]}, all nodes": total[:, k] for k in np.flatnonzero(loaded)}


def sensitivity(found: Sensitivities, problem: Problem | None = None, *, ax: Axes | None = None) -> Axes:
    """By how many per cent a bound moves with one per cent more friction, constant load, load amplitude.

    The nodes on which the bound depends most, four at most, the first on top.

    Parameters
    ----------
    found
        From ``sensitivities`` (``shakedown.assessment.sensitivities``).
    problem
        For the labels of its nodes.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If the bound has no derivatives.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown.assessment.sensitivities import sensitivities
    >>> joint = shakedown.example("two-node")
    >>> axes = sensitivity(sensitivities(joint, shakedown.upper_bound(joint)))
    >>> axes.get_xlabel(), len(axes.patches)
    ('change of λ_max for 1 % more [%]', 6)
    """
    bar = 0.26  # height of a bar, as a fraction of the distance of two nodes
    names = {"friction": "friction", "constant": "constant load", "amplitude": "load amplitude"}
    nodes = found.ranked(at_least=MINOR)[:EACH_SHOWN]
    if not nodes.size:
        raise UsageError(f"found: expected a bound with derivatives, found none ({found.reason})")
    axes, places = axes_for(ax, (6.0, 0.9 + 0.7 * len(nodes))), -np.arange(len(nodes))
    for k, (kind, colour) in enumerate(zip(KINDS, (style.GREEN, style.BLUE, style.RED), strict=True)):
        at, share = places + (1 - k) * bar, getattr(found, kind).elasticity[nodes]
        axes.barh(at, share, 0.9 * bar, color=colour, label=names[kind])
    axes.set_ylim(0.5 - max(len(nodes), 3), 0.5)
    axes.axvline(0.0, color=style.GREY, lw=0.8)
    axes.set_yticks(places, [node_name(int(node), problem).replace(" (", "\n(") for node in nodes])
    return finished(axes, f"change of {found.symbol} for 1 % more [%]")
