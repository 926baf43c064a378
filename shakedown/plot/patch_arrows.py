"""Over a patch, arrows and marks: reactions and zones at an instant, use of friction, loads, slips."""

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from numpy.typing import NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import THREE_DIGITS
from shakedown.ground.shown_values import SHORT_DIGITS, sized
from shakedown.ground.status import OPEN, SLIP, STICK
from shakedown.joint.arguments import checked, real_array
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.motion.event_history import EventHistory
from shakedown.plot.drawn_path import Recorded, at_instant, path_of, pressed
from shakedown.plot.patch_places import Places, numbered, patch_axes, places_of, require_space
from shakedown.plot.style import BLUE, GREY, RED, Style, draw_arrows, finished, style_of

MOST_DISCS = 100  # nodes with a disc or a loop: of more, arrows alone, or the loops of some, evenly spread
LONG = 0.9  # length of an arrow, width of a disc or a loop, as a fraction of the distance of two nodes
SEEN = 0.08  # least length of the longest arrow, as a fraction of the size of the patch
ROOM = 0.6  # margin around the outer nodes, as a fraction of that distance
KINDS = ((0, "stick", "s", BLUE), (1, "slip", "o", RED), (2, "open", "o", "none"))
DOT = 3.0  # smallest visible diameter of a node [points]
LARGEST, SHARE = 8.0, 75.0  # marker size [points]; about SHARE in a row fill a panel


@checked
def tractions_at(
    result: Recorded | EventHistory,
    problem: Problem,
    cycle: float | None = None,
    *,
    patch: int = 0,
    ax: Axes | None = None,
) -> Axes:
    """Tangential reactions of the nodes at one instant as arrows, told apart by whether the node slips.

    The length of the arrows is that of the largest reaction of the whole path, on every patch.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution, of a joint with two directions.
    problem
        The joint: places, friction, units.
    cycle
        The time in cycles; by default when the tangential reactions are largest in all.
    patch
        Which part of the contact is drawn, of the ``plot.patch_count(problem)`` that there are.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, there is no such patch, the time lies outside them, or the joint has
        one direction.

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
    path = path_of(result)
    now, title = at_instant(path, cycle, sheared=True)
    places, longest = places_of(problem, patch), float(problem.law.size(path.q).max())
    q = problem.layout.by_node(now.q)[0][places.nodes]
    axes = _axes(places, ax)
    _by_state(axes, places, _scale(places, longest) * places.seen(q), now.state[0][places.nodes])
    most = _largest("|q|", np.linalg.norm(q, axis=1), units_of(problem).force, longest)
    return _finished(axes, places, f"{title}, {most}")


@checked
def friction_use_at(
    result: Recorded | EventHistory,
    problem: Problem,
    cycle: float | None = None,
    *,
    patch: int = 0,
    ax: Axes | None = None,
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
    now, title = at_instant(path_of(result), cycle, sheared=True)
    places = places_of(problem, patch)
    limit, held, state, q = (
        of_nodes[0][places.nodes]
        for of_nodes in (
            problem.law.limit(now.p), pressed(problem, now), now.state, problem.layout.by_node(now.q)
        )
    )  # fmt: skip
    use = q / np.where(held, limit, np.inf)[:, None]
    discs = len(places.points) <= MOST_DISCS
    reach = 0.5 * LONG * places.spacing if discs else _reach(places)
    axes = _axes(places, ax)
    if discs:
        _discs(axes, places, np.where(held, reach, 0.0))
    _by_state(axes, places, reach * places.seen(use), state)
    most = _largest("|q| / f p", np.linalg.norm(use, axis=1).clip(max=1.0), "", 1.0)
    return _finished(axes, places, f"{title}, {most}")


@checked
def loads_over_patch(
    problem: Problem, *, load_factor: float = 1.0, patch: int = 0, ax: Axes | None = None
) -> Axes:
    """Tangential welded reactions over a patch: the mean as an arrow, the path of its tip over a period.

    All patches have one scale. A mean that is next to nothing has no arrows. Of very many nodes some are
    drawn.

    Parameters
    ----------
    problem
        A joint with two directions, and its loading.
    load_factor
        λ, the factor on the periodic part.
    patch
        Which part of the contact is drawn, of the ``plot.patch_count(problem)`` that there are.
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
    places, given = places_of(problem, patch), loading(problem)
    whole = given.at(load_factor)[0]
    loop, mean = (problem.layout.by_node(q)[..., places.nodes, :] for q in (whole, given.q0))
    longest = float(problem.law.size(whole).max())
    fewer = max(len(places.points) / MOST_DISCS, 1.0)  # the drawn ones have this many times more space
    scale, axes = 0.5 * np.sqrt(fewer) * _scale(places, longest), _axes(places, ax)
    chosen = _spread(places.points, MOST_DISCS)
    _nodes(axes, places)
    if problem.law.size(given.q0).max() > THREE_DIGITS * longest:
        _arrows(axes, places.points[chosen], scale * places.seen(mean)[chosen], BLUE, "mean q_w")
    ways = places.points + scale * places.seen(loop)
    ways = np.concatenate([ways, ways[:1]])[:, chosen]
    axes.add_collection(
        LineCollection(list(ways.swapaxes(0, 1)), colors=RED, linewidths=0.9, label="q_w over a period")
    )
    numbered(axes, places)
    sizes = np.linalg.norm(loop, axis=2)
    most = _largest("|q_w|", sizes, units_of(problem).force, longest)
    return _finished(axes, places, f"λ = {load_factor:g}, {most}")


@checked
def slips_over_patch(
    slips: Mapping[str, FloatArray],
    problem: Problem,
    *,
    what: str = "slip",
    styles: Mapping[str, Style] | None = None,
    patch: int = 0,
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
    places, size = places_of(problem, patch), problem.layout.slip_size
    known = {name: real_array(f"slips, {name}", slip) for name, slip in slips.items()}
    for name, slip in known.items():
        if slip.shape != (size,):
            raise UsageError(f"slips, {name}: expected shape ({size},), found {slip.shape}")
    vectors = {name: problem.layout.by_node(slip)[places.nodes] for name, slip in known.items()}
    sizes = np.concatenate([np.zeros(1), *(np.linalg.norm(each, axis=1) for each in vectors.values())])
    longest = max((float(np.nanmax(problem.law.size(slip))) for slip in known.values()), default=0.0)
    scale, axes = _scale(places, longest), _axes(places, ax)
    _nodes(axes, places)
    for k, (name, each) in enumerate(vectors.items()):
        look = style_of(name, k, styles)
        if each.any():
            _arrows(axes, places.points, scale * places.seen(each), look["color"], look["label"])
    numbered(axes, places)
    return _finished(axes, places, _largest(what, sizes, units_of(problem).length, longest))


@checked
def zones_at(
    result: Recorded | EventHistory,
    problem: Problem,
    cycle: float | None = None,
    *,
    patch: int = 0,
    ax: Axes | None = None,
) -> Axes:
    """Stick, slip and open nodes of a patch at one instant, told apart by colour and shape.

    Parameters
    ----------
    result
        A long-term state, or a recorded simulation or evolution, of a joint with two directions.
    problem
        The joint: places of its nodes.
    cycle
        The time in cycles; by default when the tangential reactions are largest in all.
    patch
        Which part of the contact is drawn, of the ``plot.patch_count(problem)`` that there are.
    ax
        Where to draw; by default a new figure, which ``plot.save(axes, path)`` writes.

    Raises
    ------
    UsageError
        If no events were recorded, there is no such patch, the time lies outside them, or the joint has
        one direction.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown import plot
    >>> joint = shakedown.example("four-node-3d")
    >>> plot.zones_at(shakedown.long_term_state(joint, 0.5), joint, 0.0).get_title()
    't = 0 cycles: 4 stick, 0 slip, 0 open'
    """
    require_space("picture of a patch", problem)
    now, title = at_instant(path_of(result), cycle, sheared=True)
    places = places_of(problem, patch)
    state = np.abs(now.state[0])[places.nodes]
    axes = _axes(places, ax, 0.5 * places.spacing)
    size = float(np.clip(SHARE / np.sqrt(problem.n), DOT, LARGEST))
    for number, name, shape, colour in KINDS:
        here = places.points[state == number]
        edge = GREY if colour == "none" else colour
        axes.scatter(here[:, 0], here[:, 1], s=size**2, marker=shape, fc=colour, ec=edge, lw=0.8, label=name)
    numbered(axes, places)
    once = state[np.unique(places.nodes, return_index=True)[1]]
    counts = ", ".join(f"{int((once == number).sum())} {name}" for number, name, *_ in KINDS)
    return _finished(axes, places, f"{title}: {counts}")


def _finished(axes: Axes, places: Places, title: str) -> Axes:
    finished(axes, title=places.titled(title))
    if (legend := axes.get_legend()) is not None:  # beside the axes, as arrows may be anywhere
        legend.set_loc("upper left")
        legend.set_bbox_to_anchor((1.0, 1.0), axes.transAxes)
    return axes


def _axes(places: Places, ax: Axes | None, room: float | None = None) -> Axes:
    """Axes with a grid below what is drawn, and room about the outer nodes."""
    axes = patch_axes(places, ax, ROOM * places.room if room is None else room)
    axes.set_axisbelow(True)
    return axes


def _spread(points: FloatArray, most: int) -> NDArray[np.intp]:
    """A number of the points, each the farthest from those before; all where there are no more."""
    if len(points) <= most:
        return np.arange(len(points))
    chosen, apart = [0], np.full(len(points), np.inf)
    while len(chosen) < most:
        apart = np.minimum(apart, np.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(apart.argmax()))
    return np.sort(chosen)


def _reach(places: Places) -> float:
    """The length of the longest arrow: visible, and short enough to keep (nearly) clear of its neighbours."""
    return max(LONG * places.room, SEEN * float(np.ptp(places.points, axis=0).max()))


def _scale(places: Places, longest: float) -> float:
    """Length in the picture per force or slip, so that the given value has the longest arrow."""
    return _reach(places) / longest if longest > 0 else 0.0


def _largest(what: str, sizes: FloatArray, unit: str, longest: float) -> str:
    """The largest value on a patch; if negligible beside the longest arrow, only a bound on it."""
    most, shown = float(np.nanmax(sizes, initial=0.0)), THREE_DIGITS * longest
    if most < shown:
        return f"{what} < {sized(shown, unit, SHORT_DIGITS)}"
    return f"largest {what} = {sized(most, unit, SHORT_DIGITS)}"


def _nodes(axes: Axes, places: Places) -> None:
    """Dots at the nodes, since nodes without a visible arrow would otherwise not be seen."""
    axes.scatter(places.points[:, 0], places.points[:, 1], s=DOT**2, color=GREY, lw=0)


def _by_state(axes: Axes, places: Places, arrows: FloatArray, state: NDArray[np.int64]) -> None:
    """Arrows of the nodes that stick and of those that slip; a ring where a node is open."""
    _nodes(axes, places)
    for name, kind, colour in (("sticks", state == STICK, BLUE), ("slips", np.abs(state) == SLIP, RED)):
        if kind.any():
            _arrows(axes, places.points[kind], arrows[kind], colour, name)
    if (state == OPEN).any():
        axes.plot(*places.points[state == OPEN].T, "o", mfc="none", mec=GREY, ms=4, ls="", label="open")
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
    draw_arrows(axes, feet, vectors, width=0.0035, minlength=0.5, color=colour, label=name, zorder=3)
