"""Arrows over a patch: tangential reactions, how much of the friction they use, loads, slips."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from numpy.typing import NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.joint.arguments import checked, real_array
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.event_history import EventHistory
from shakedown.plot.patch_colours import at_instant
from shakedown.plot.patch_places import Places, numbered, patch_axes, places_of, require_space
from shakedown.plot.style import BLUE, GREY, RED, Recorded, Style, path_of, pressed, style_of

MOST_DISCS = 120  # nodes; of more of them arrows alone are drawn, and these a little longer
MOST_LOOPS = 150  # nodes whose loads are drawn, evenly taken
DISC, LONG = 0.47, 1.4  # of the usual distance of two nodes: radius of a disc, an arrow without discs
ROOM = 0.6  # about the outer nodes, of that distance
SHAFT = 0.0035  # of the width of the axes


@checked
def tractions_at(
    result: Recorded | EventHistory, problem: Problem, cycle: float | None = None, *, ax: Axes | None = None
) -> Axes:
    """Tangential reactions of the nodes at one instant as arrows, told apart by whether the node slips.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution, of a joint with two directions.
    problem
        The joint: places, friction, units.
    cycle
        The time in cycles; by default when the total pressure is largest.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, the time lies outside them, or the joint has one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> axes = plot.tractions_at(shakedown.long_term_state(joint, 1.4), joint)
    >>> axes.get_legend().get_texts()[0].get_text()
    'sticks'
    """
    require_space("picture of a patch", problem)
    now, title = at_instant(path_of(result), cycle)
    places, q = places_of(problem), problem.layout.by_node(now.q)[0]
    sizes = np.linalg.norm(q, axis=1)
    axes = patch_axes(places, ax, ROOM * places.room)
    scale = _scale(places, sizes, problem.n <= MOST_DISCS)
    _by_state(axes, places, scale * places.seen(q), now.state[0])
    axes.set_title(f"{title}, {_largest('|q|', sizes, units_of(problem)[0])}", fontsize="medium")
    return _finished(axes)


@checked
def friction_use_at(
    result: Recorded | EventHistory, problem: Problem, cycle: float | None = None, *, ax: Axes | None = None
) -> Axes:
    """How much of its friction each node uses at one instant: q/(f p) as an arrow within a disc.

    An arrow that reaches the rim is at its limit: that node slips, or is about to. Over very many nodes the
    discs are left out. Parameters as for :func:`tractions_at`.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> axes = plot.friction_use_at(shakedown.long_term_state(joint, 1.4), joint)
    >>> axes.get_legend().get_texts()[0].get_text()
    'limit |q| = f p'
    """
    require_space("picture of a patch", problem)
    now, title = at_instant(path_of(result), cycle)
    places, few = places_of(problem), problem.n <= MOST_DISCS
    limit, held, state = problem.law.limit(now.p)[0], pressed(problem, now)[0], now.state[0]
    use = problem.layout.by_node(now.q)[0] / np.where(held, limit, np.inf)[:, None]
    reach = DISC * places.spacing if few else LONG * places.room
    axes = patch_axes(places, ax, ROOM * places.room)
    if few:
        _discs(axes, places, np.where(held, reach, 0.0))
    _by_state(axes, places, reach * places.seen(use), state)
    most = float(np.linalg.norm(use, axis=1).max())
    axes.set_title(f"{title}, largest |q| / f p = {min(most, 1.0):.3g}", fontsize="medium")
    return _finished(axes)


@checked
def loads_over_patch(problem: Problem, *, load_factor: float = 1.0, ax: Axes | None = None) -> Axes:
    """Tangential welded reactions over a patch: the mean as an arrow, the way of its tip over a period.

    Of very many nodes some are drawn.

    Parameters
    ----------
    problem
        A joint with two directions, and its loading.
    load_factor
        λ, the factor on the periodic part.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If the joint has one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> axes = plot.loads_over_patch(shakedown.example("four-node-3d"))
    >>> [text.get_text() for text in axes.get_legend().get_texts()]
    ['mean q_w', 'q_w over a period']
    """
    require_space("picture of a patch", problem)
    places, mean = places_of(problem), loading(problem)
    by_node = problem.layout.by_node
    loop = by_node(mean.at(load_factor)[0])
    sizes = np.linalg.norm(loop, axis=2).max(axis=0)
    scale = _scale(places, sizes, problem.n <= MOST_DISCS)
    axes = patch_axes(places, ax, ROOM * places.room)
    chosen = np.unique(np.linspace(0, problem.n - 1, min(problem.n, MOST_LOOPS)).round().astype(int))
    axes.scatter(places.points[:, 0], places.points[:, 1], s=3.0, color=GREY, lw=0)
    _arrows(axes, places.points[chosen], scale * places.seen(by_node(mean.q0))[chosen], BLUE, "mean q_w")
    ways = places.points + scale * places.seen(loop)
    ways = np.concatenate([ways, ways[:1]])[:, chosen]
    axes.add_collection(
        LineCollection(list(ways.swapaxes(0, 1)), colors=RED, linewidths=0.9, label="q_w over a period")
    )
    numbered(axes, places)
    axes.set_title(
        f"λ = {load_factor:g}, {_largest('|q_w|', sizes, units_of(problem)[0])}", fontsize="medium"
    )
    return _finished(axes)


@checked
def slips_over_patch(
    slips: Mapping[str, FloatArray],
    problem: Problem,
    *,
    what: str = "slip",
    styles: Mapping[str, Style] | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Slips of all nodes as arrows, those of one name in one colour.

    Parameters
    ----------
    slips
        Name → (2n,) [length].
    problem
        A joint with two directions: places and units.
    what
        Name of the quantity, for the title.
    styles
        Colours of a name, as for :func:`slip_along`.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If slips have another length, or the joint has one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.slips_over_patch({"safe slip": shakedown.upper_bound(joint).slip}, joint).get_xlabel()
    'node'
    """
    require_space("picture of a patch", problem)
    places, size = places_of(problem), problem.layout.slip_size
    known = {name: real_array(f"slips, {name}", slip) for name, slip in slips.items()}
    for name, slip in known.items():
        if slip.shape != (size,):
            raise UsageError(f"slips, {name}: expected shape ({size},), found {slip.shape}")
    vectors = {name: problem.layout.by_node(slip) for name, slip in known.items()}
    sizes = np.concatenate([np.zeros(1), *(np.linalg.norm(each, axis=1) for each in vectors.values())])
    scale = _scale(places, sizes, problem.n <= MOST_DISCS)
    axes = patch_axes(places, ax, ROOM * places.room)
    axes.scatter(places.points[:, 0], places.points[:, 1], s=3.0, color=GREY, lw=0)
    for k, (name, each) in enumerate(vectors.items()):
        look = style_of(name, k, styles)
        _arrows(axes, places.points, scale * places.seen(each), look["color"], look["label"])
    numbered(axes, places)
    axes.set_title(_largest(what, sizes, units_of(problem)[1]), fontsize="medium")
    return _finished(axes)


def _scale(places: Places, sizes: FloatArray, discs: bool) -> float:
    """Lengths in the picture per force or slip: the largest of them keeps clear of the neighbours."""
    most = float(np.nanmax(sizes, initial=0.0))
    reach = DISC * places.spacing if discs else LONG * places.room
    return reach / most if most > 0 else 0.0


def _largest(what: str, sizes: FloatArray, unit: str) -> str:
    return f"largest {what} = {float(np.nanmax(sizes, initial=0.0)):.3g} {unit}".rstrip()


def _by_state(axes: Axes, places: Places, arrows: FloatArray, state: NDArray[np.int64]) -> None:
    """Arrows of the nodes that stick and of those that slip; a ring where a node is open."""
    for name, kind, colour in (("sticks", state == 0, BLUE), ("slips", np.abs(state) == 1, RED)):
        if kind.any():
            _arrows(axes, places.points[kind], arrows[kind], colour, name)
    if (state == 2).any():
        axes.plot(*places.points[state == 2].T, "o", mfc="none", mec=GREY, ms=4, ls="", label="open")
    numbered(axes, places)


def _discs(axes: Axes, places: Places, radius: FloatArray) -> None:
    """Limits of the tangential reactions."""
    wide = 2.0 * np.maximum(radius, 0.0)
    discs = EllipseCollection(
        wide, wide, np.zeros_like(wide), units="xy", offsets=places.points,
        offset_transform=axes.transData, facecolors="none", edgecolors=GREY, linewidths=0.7,
    )  # fmt: skip
    axes.add_collection(discs)
    axes.plot([], [], "o", ms=8, mfc="none", mec=GREY, ls="", label="limit |q| = f p")


def _arrows(axes: Axes, feet: FloatArray, vectors: FloatArray, colour: str, name: str) -> None:
    axes.quiver(
        *feet.T, *vectors.T, angles="xy", scale_units="xy", scale=1.0, width=SHAFT, minlength=0.5,
        color=colour, label=name, zorder=3,
    )  # fmt: skip


def _finished(axes: Axes) -> Axes:
    axes.grid(alpha=0.3)
    axes.set_axisbelow(True)
    if axes.get_legend_handles_labels()[1]:
        axes.legend(fontsize="small")
    return axes
