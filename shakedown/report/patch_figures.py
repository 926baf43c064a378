"""Pictures of a joint with two tangential directions: its loads, its state, the slips that runs end at."""

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np

from shakedown import plot
from shakedown.assessment.verify import Verification
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import at_lambda, few
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of, work_unit
from shakedown.motion.event_history import EventHistory
from shakedown.plot.drawn_path import extreme_rows, work_of_nodes
from shakedown.plot.inline_svg import PANEL, SMALL, Drawing, Picture, picture
from shakedown.plot.patch_arrows import MOST_DISCS, MOST_LOOPS
from shakedown.plot.patch_places import places_of
from shakedown.plot.style import node_name
from shakedown.report.cycle_figures import FEW, MOST_NODES, Pictured, as_given_state, cycling_state

INSTANTS = 3  # of one period, side by side
SHORTEST = 1e-6  # of a cycle: a node that touches its limit slips by round-off for less
HALF, THIRD = PANEL[0], SMALL[0]  # inches: widths of two or three pictures that fill a page
LEAST, MOST = 2.0, 3.6  # inches: heights of a long patch and a high one
AROUND, BESIDE = 0.85, 1.8  # inches: what stands above and below a patch, and beside it
NONE = 1e-6  # of the work of the node that dissipates most: what is no orbit to see


def load_pictures(problem: Problem) -> list[Picture]:
    """The loads over the patch, in the limits of a few nodes or as pressures of many, and over the period."""
    size = _size(problem, three=True)
    alt = "Tangential welded reactions over the patch: the mean as an arrow, the way of its tip over a period"
    loads = Drawing(alt, partial(plot.loads_over_patch, problem), size=size)
    few = problem.n <= FEW
    if few:
        alt = "Loading of each node within its limit, q_w over f p_w in x and y"
        beside = Drawing(alt, partial(plot.load_orbits, problem, range(problem.n)))
    else:
        alt = "Mean normal welded reactions over the patch"
        beside = Drawing(
            alt, partial(plot.welded_pressure_over_patch, problem), size=_size(problem, True, True)
        )
    time = Drawing("Sums of the welded reactions over one period", partial(plot.loads_in_time, problem))
    some = f" (of {MOST_LOOPS} nodes)" if problem.n > MOST_LOOPS else ""
    caption = (
        f"{_where(problem)} The tangential welded reactions at λ = 1: an arrow for the mean, a line for the "
        f"way of its tip over a period{some}; "
        + ("the way of q_w within its limit f p_w" if few else "the mean normal welded reactions")
        + "; the sums of all nodes over the period. Welded reactions are those with every contact "
        "displacement held."
    )
    return [picture(caption, loads, beside, time)]


def patch_pictures(v: Verification) -> list[Picture]:
    """Orbits of the nodes that dissipate most, reactions, zones, slip and friction work over the patch."""
    problem, given, cycling = v.problem, as_given_state(v), cycling_state(v)
    elsewhere = cycling is not None and (given is None or cycling.state is not given.state)
    pictures = [] if cycling is None else [_orbits(cycling, problem)]
    if given is not None:
        pictures.append(_reactions(given, problem) if problem.n <= FEW else _tractions(given, problem))
    shown = [] if given is None else [given]
    shown += [cycling] if cycling is not None and elsewhere else []
    moving = [one for one in shown if one.state.history.state.any()]
    if moving:
        pictures.append(_zones(moving, problem))
    if cycling is not None and problem.n > FEW:
        pictures.append(_slips(cycling, problem))
    return pictures


def final_slips(
    v: Verification,
    name: str,
    slips: Mapping[str, FloatArray],
    styles: Mapping[str, Mapping[str, Any]],
    three: bool,
) -> Drawing:
    """Slips at the end of runs as arrows over the patch."""
    draw = partial(plot.slips_over_patch, slips, v.problem, what="final slip", styles=styles)
    return Drawing(
        f"Final slip of every run over the patch, {name}", draw, name, _size(v.problem, three=three)
    )


def _where(problem: Problem) -> str:
    """Where the nodes of the pictures are."""
    places = places_of(problem)
    if not places.in_a_row:
        return f"{problem.n} contact nodes where they are in the model."
    if problem.n == 1:
        return "The one contact node."
    where = "side by side: the problem does not say where they are" if problem.x is None else "along x"
    return f"{problem.n} contact nodes, {where}."


def _size(problem: Problem, field: bool = False, three: bool = False) -> tuple[float, float] | None:
    """Of a picture of the patch, so high as the patch asks for; None where numbers stand over a row."""
    places, width = places_of(problem), THIRD if three else HALF
    if places.in_a_row:
        return None if field else (width, LEAST)
    wide, high = np.ptp(places.points, axis=0) + places.spacing
    return width, float(np.clip((width - BESIDE) * high / wide + AROUND, LEAST, MOST))


def _orbits(pictured: Pictured, problem: Problem) -> Picture:
    state = pictured.state
    work = work_of_nodes(state)
    least = NONE * work.max()
    worst = [int(node) for node in np.argsort(-work, kind="stable")[:MOST_NODES] if work[node] > least] or [0]
    names = ", ".join(node_name(node, problem) for node in worst)
    total = f"{few(state.dissipation_per_cycle)} {work_unit(*units_of(problem))}".rstrip()
    per = "cycle" if state.period == 1 else f"{state.period} cycles"
    caption = (
        f"Slip orbits of the nodes that dissipate most, over one period ({per}): {pictured.which}. Each is "
        f"drawn about its own middle, the circle is its beginning; the joint dissipates {total} per cycle. "
        "Beside them the tangential reactions over their limits: on the rim a node slips, or is about to."
    )
    slips = partial(plot.slip_orbits, state, problem, nodes=worst)
    reactions = partial(plot.reaction_orbits, state, problem, nodes=worst)
    return picture(
        caption,
        Drawing(f"Slip orbits of {names}", slips),
        Drawing(f"Tangential reactions of {names} within their limits", reactions),
    )


def _reactions(pictured: Pictured, problem: Problem) -> Picture:
    """Tangential reactions of a few nodes within their limits."""
    path, nodes = pictured.state.history, range(problem.n)
    drawings = [
        Drawing(
            f"Size of the tangential reaction of node {node} over time, below its friction limit",
            partial(plot.reactions_in_time, path, problem, node),
        )
        for node in nodes
    ]
    rim = Drawing(
        "Tangential reactions of all nodes within their limits",
        partial(plot.reaction_orbits, path, problem, nodes=nodes),
    )
    caption = f"Tangential reactions within their limits, {pictured.which}."
    return picture(caption, *drawings, rim)


def _tractions(pictured: Pictured, problem: Problem) -> Picture:
    """Normal and tangential reactions when the total pressure is largest, and when it is smallest."""
    path, drawings = pictured.state.history, list[Drawing]()
    rows = dict.fromkeys(extreme_rows(path))
    for time in path.cycle[list(rows)].tolist():
        at = f"over the patch, t = {time:.4g} cycles"
        pressure = partial(plot.pressure_over_patch, path, problem, time)
        drawings += [
            Drawing(f"Pressure {at}", pressure, size=_size(problem, True, True)),
            Drawing(
                f"Tangential reactions {at}",
                partial(plot.tractions_at, path, problem, time),
                size=_size(problem, three=True),
            ),
            Drawing(
                f"Use of friction {at}",
                partial(plot.friction_use_at, path, problem, time),
                size=_size(problem, three=True),
            ),
        ]
    discs = " within a disc" * (problem.n <= MOST_DISCS)
    smallest = ", and when it is smallest" * (len(rows) > 1)
    caption = (
        f"Normal reactions; tangential reactions as arrows; the same over their limits, q / f p{discs}: "
        f"a node at 1 slips or is about to; {pictured.which}; when the total pressure is largest{smallest}."
    )
    return picture(caption, *drawings)


def _zones(shown: Sequence[Pictured], problem: Problem) -> Picture:
    """What sticks, slips and is open at instants of the period."""
    drawings = []
    for one in shown:
        path, name = one.state.history, at_lambda(one.state.load_factor)
        for time in instants(path):
            alt = f"Nodes that stick, slip and are open, {name}, t = {time:.4g} cycles"
            drawings.append(
                Drawing(alt, partial(plot.zones_at, path, problem, time), name, _size(problem, three=True))
            )
    caption = (
        "What sticks, slips and is open, when the fewest nodes stick in each third of the period: "
        f"{'; '.join(one.which for one in shown)}."
    )
    return picture(caption, *drawings, one_legend=True)


def instants(path: EventHistory) -> list[float]:
    """Times at which the fewest nodes stick, one of each part of the period."""
    from_on, first, last = path.cycle[:-1], max(float(path.cycle[0]), 0.0), float(path.cycle[-1])
    middles = 0.5 * (from_on + path.cycle[1:])  # a state holds from its row on
    lasting = np.diff(path.cycle) > SHORTEST
    moving = np.where(lasting, (path.state[:-1] != 0).sum(axis=1), -1)
    ends = np.linspace(first, last, INSTANTS + 1)
    times = []
    for begin, end in pairwise(ends):
        inside = np.flatnonzero((middles >= begin) & (middles < end))
        times.append(float(middles[inside[moving[inside].argmax()]]) if inside.size else float(begin))
    return times


def _slips(pictured: Pictured, problem: Problem) -> Picture:
    state, size = pictured.state, _size(problem, True)
    caption = (
        "How far each node slips in all in one period, in contact, and what friction dissipates there: "
        f"{pictured.which}."
    )
    return picture(
        caption,
        Drawing("Accumulated slip over the patch", partial(plot.slip_over_patch, state, problem), size=size),
        Drawing("Friction work over the patch", partial(plot.work_over_patch, state, problem), size=size),
    )
