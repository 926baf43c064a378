"""Pictures of the state of the joint: loops or orbits, reactions, zones, slips and friction work."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from shakedown import plot
from shakedown.assessment.verify import Verification
from shakedown.ground.round_off import SIX_DIGITS
from shakedown.ground.shown_values import at_lambda, cycles_in_words, sized
from shakedown.ground.size_limits import EACH_SHOWN
from shakedown.ground.status import OPEN, STICK, Outcome
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory
from shakedown.motion.evolve import evolve
from shakedown.plot.drawn_path import extreme_rows, most_sheared_row, time_in_words, work_of_nodes
from shakedown.plot.inline_svg import SIDE_BY_SIDE, Drawing, Picture, picture
from shakedown.plot.patch_arrows import MOST_DISCS
from shakedown.plot.patch_data import patch_data
from shakedown.plot.patch_places import places_of
from shakedown.plot.style import node_name
from shakedown.report.load_figures import (
    drawn_patches,
    left_out,
    load_loops_pictures,
    patch_size,
)
from shakedown.report.node_words import open_in_words

EARLY = (1, 9)  # cycles whose zones are shown beside those of the long-term state
AT_ONE = {
    Outcome.SHAKEDOWN: "nothing slips in the long term",
    Outcome.SEPARATION: "nothing slips in contact in the long term",
}
MOVING = (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING)


@dataclass(frozen=True, eq=False)
class Pictured:
    """A long-term state to draw, with words that identify it."""

    state: LongTermState
    which: str

    @property
    def name(self) -> str:
        """The heading of its pictures."""
        return at_lambda(self.state.load_factor)

    def picture(self, caption: str, *drawings: Drawing) -> Picture:
        """Panels under one caption, with the load factor above them."""
        return picture(caption, *(drawing._replace(name=self.name) for drawing in drawings))


class Family(NamedTuple):
    """How states are drawn, for joints with one tangential direction or with two.

    Attributes
    ----------
    loops
        What the paths of the nodes are called.
    ways, reactions, contact, slips
        Pictures of one state: nodes that dissipate most, reactions of a few nodes, of all nodes, slips.
    zones
        A picture of several states: which nodes stick, slip and are open.
    all_in_ways
        Whether ``ways`` also shows the reactions; zones are then drawn for states at rest as well.
    """

    loops: str
    ways: Callable[[Pictured, Problem], Picture]
    reactions: Callable[[Pictured, Problem], Picture]
    contact: Callable[[Pictured, Problem], Picture]
    slips: Callable[[Pictured, Problem], Picture]
    zones: Callable[[Verification, Sequence[Pictured], Problem], Picture]
    all_in_ways: bool


def as_given_state(v: Verification) -> Pictured | None:
    """The long-term state at λ = 1; None where it was not followed from event to event."""
    state = v.as_given.simulation.long_term
    return None if state is None or len(state.history) < 2 else Pictured(state, "at λ = 1, the nominal load")


def cycling_state(v: Verification) -> Pictured | None:
    """A state in which nodes slip: at λ = 1, or at the nearest simulated load factor above."""
    if v.as_given.simulation.outcome in MOVING:
        return as_given_state(v)
    runs = [run.simulation for run in v.runs if run.initial == v.as_given.initial]
    moving = [run for run in runs if run.outcome in MOVING and run.load_factor > 1]
    nearest = min(moving, key=lambda run: run.load_factor, default=None)
    state = None if nearest is None else nearest.long_term
    if state is None and v.transient is not None and v.transient.at_high is not None:
        found = v.transient.at_high
        state = found if found.outcome in MOVING and found.load_factor > 1 else None
    if state is None or len(state.history) < 2:
        return None
    at_one = AT_ONE.get(v.as_given.simulation.outcome, "no slip in every cycle is known")
    return Pictured(state, f"at λ = 1 {at_one}; shown at {at_lambda(state.load_factor)}, where it slips")


def state_pictures(v: Verification) -> list[Picture]:
    """Loops of the nodes that dissipate most, reactions, zones, slips and friction work of all nodes."""
    problem, given, cycling = v.problem, as_given_state(v), cycling_state(v)
    family, many = _family(problem), problem.n > SIDE_BY_SIDE
    elsewhere = cycling is not None and (given is None or cycling.state is not given.state)
    pictures = [] if cycling is None else [family.ways(cycling, problem)]
    pictures += [] if cycling is None else load_loops_pictures(cycling.state, cycling.which)
    if given is not None and many:
        pictures.append(family.contact(given, problem))
    elif given is not None and (not family.all_in_ways or cycling is None or elsewhere):
        pictures.append(family.reactions(given, problem))
    shown = [] if given is None else [given]
    shown += [cycling] if cycling is not None and elsewhere else []
    zoned = [one for one in shown if family.all_in_ways or one.state.history.state.any()]
    if zoned:
        pictures.append(family.zones(v, zoned, problem))
    if cycling is not None and many:
        pictures.append(family.slips(cycling, problem))
    return pictures


def contact_to_turn(v: Verification) -> dict[str, str] | None:
    """Data for the script of the view: a state in which nodes slip, or else that at λ = 1; and which."""
    pictured = cycling_state(v) or as_given_state(v)
    if pictured is None or _family(v.problem) is not IN_SPACE or places_of(v.problem).in_a_row:
        return None
    return {"data": Markup(patch_data(pictured.state)), "which": pictured.which, "name": pictured.name}


def no_pictures(v: Verification) -> str:
    """Why some pictures are missing; empty where none are."""
    if v.as_given.simulation.long_term is None:
        return "No state is drawn: the simulations did not go from event to event."
    if as_given_state(v) is None and cycling_state(v) is None:
        return "No state is drawn: at λ = 1 no long-term state was found."
    if cycling_state(v) is None:
        loops = _family(v.problem).loops
        return f"There are no {loops} to draw: no simulated state from this start slips in every cycle."
    return ""


def _hysteresis(pictured: Pictured, problem: Problem) -> Picture:
    """Loops of the nodes that dissipate most."""
    path, worst = pictured.state.history, _worst(pictured.state)
    names = [node_name(node, problem) for node in worst]
    return pictured.picture(
        f"Hysteresis loops of the nodes that dissipate most: {pictured.which}. The area of a loop is "
        f"what friction dissipates at the node in {_period(pictured.state)}; {_whole(pictured.state)}Beside "
        f"them the tangential reaction of {names[0]} between its limits.",
        Drawing(
            f"Hysteresis loops of {', '.join(names)}: tangential reaction against slip",
            partial(plot.hysteresis, path, problem, nodes=worst),
        ),
        Drawing(
            f"Tangential reaction of {names[0]} over time, between its friction limits",
            partial(plot.reactions_in_time, path, problem, worst[0]),
        ),
    )


def _orbits(pictured: Pictured, problem: Problem) -> Picture:
    """Orbits of slips and reactions of the nodes that dissipate most."""
    state, worst = pictured.state, _worst(pictured.state)
    names = ", ".join(node_name(node, problem) for node in worst)
    slips = partial(plot.slip_orbits, state, problem, nodes=worst)
    reactions = partial(plot.reaction_orbits, state, problem, nodes=worst)
    closes = (
        "Every path is closed: where it looks like an open line, the node returns the way it came; "
        if state.outcome is Outcome.CYCLIC_SLIP
        else ""
    )
    return pictured.picture(
        f"Slip orbits of the nodes that dissipate most, over {_period(state)}: {pictured.which}. "
        f"Each is drawn about its own middle, the circle is its beginning. {closes}{_whole(state)}"
        "Beside them the tangential reactions over their limits: on the rim a node slips, or is about to.",
        Drawing(f"Slip orbits of {names}", slips),
        Drawing(f"Tangential reactions of {names} within their limits", reactions),
    )


def _worst(state: LongTermState) -> list[int]:
    """The few nodes that dissipate most."""
    work = work_of_nodes(state)
    most = np.argsort(-work, kind="stable")[:EACH_SHOWN].tolist()
    return [node for node in most if work[node] > SIX_DIGITS * work.max()] or [0]


def _period(state: LongTermState) -> str:
    return f"one period ({cycles_in_words(state.period)})"


def _whole(state: LongTermState) -> str:
    total = sized(state.dissipation_per_cycle, units_of(state.problem).work)
    return f"the joint dissipates {total} per cycle. "


def _reactions(pictured: Pictured, problem: Problem) -> Picture:
    """Tangential reactions of a few nodes over time."""
    drawings = _over_time(pictured, problem, "Tangential reaction", "between its friction limits")
    return pictured.picture(f"Tangential reactions between their limits, {pictured.which}.", *drawings)


def _reactions_within(pictured: Pictured, problem: Problem) -> Picture:
    """Sizes of tangential reactions of a few nodes over time, and all of these within their limits."""
    drawings = _over_time(pictured, problem, "Size of the tangential reaction", "below its friction limit")
    rim = partial(plot.reaction_orbits, pictured.state.history, problem, nodes=range(problem.n))
    rims = Drawing("Tangential reactions of all nodes within their limits", rim)
    return pictured.picture(f"Tangential reactions within their limits, {pictured.which}.", *drawings, rims)


def _over_time(pictured: Pictured, problem: Problem, what: str, limit: str) -> list[Drawing]:
    path = pictured.state.history
    return [
        Drawing(
            f"{what} of node {node} over time, {limit}", partial(plot.reactions_in_time, path, problem, node)
        )
        for node in range(problem.n)
    ]


def _along(pictured: Pictured, problem: Problem) -> Picture:
    """Pressure and use of friction at instants of the period."""
    path = pictured.state.history
    times = path.cycle[0] + np.arange(EACH_SHOWN) / EACH_SHOWN * (path.cycle[-1] - path.cycle[0])
    at = path.at(times)
    caption = (
        f"Normal reactions and use of friction along the contact, {pictured.which}, at instants of the "
        "period (t in cycles). At ±1 a node slips or is about to; open nodes use none and are left out."
    )
    drawings = [
        Drawing(
            f"{what} along the contact at instants of the period", partial(draw, at, problem, cycles=times)
        )
        for what, draw in (("Normal reactions", plot.pressure), ("Use of friction", plot.friction_use))
    ]
    return pictured.picture(caption, *drawings)


def _tractions(pictured: Pictured, problem: Problem) -> Picture:
    """Reactions when the tangential ones are largest, and when the total pressure is smallest."""
    path = pictured.state.history
    times = [float(path.cycle[row]) for row in (most_sheared_row(path), extreme_rows(path)[1])]
    times = times[: 1 + (abs(times[1] - times[0]) > 0.5 / SIDE_BY_SIDE)]  # closer in time they look the same
    drawn = (
        ("Pressure", plot.pressure_over_patch, True),
        ("Tangential reactions", plot.tractions_at, False),
        ("Use of friction", plot.friction_use_at, False),
    )
    drawings = [
        Drawing(
            f"{what} over the patch, {time_in_words(time)}",
            partial(draw, path, problem, time, patch=patch),
            size=patch_size(problem, patch, numbers=numbers, three=True),
        )
        for patch in drawn_patches(problem)
        for time in times
        for what, draw, numbers in drawn
    ]
    discs = " within a disc" * (problem.n <= MOST_DISCS)
    smallest = ", and when the total pressure is smallest" * (len(times) > 1)
    caption = (
        f"Normal reactions; tangential reactions as arrows, all to one scale; the same over their limits, "
        f"q / f p{discs}: a node at 1 slips or is about to; {pictured.which}; when the tangential reactions "
        f"are largest in all{smallest}.{left_out(problem)}"
    )
    return pictured.picture(caption, *drawings)


def _zones(v: Verification, shown: Sequence[Pictured], problem: Problem) -> Picture:
    """Stick, slip and open zones in the long term, and in early cycles at λ = 1 with slip."""
    maps = [(one.state.history, f"{at_lambda(one.state.load_factor)}, long term") for one in shown]
    if shown[0].state is v.as_given.simulation.long_term:
        early = _early(v, shown[0], problem).items()
        maps = [(piece, f"λ = 1, cycle {cycle}") for cycle, piece in early if piece.state.any()] + maps
    alt = "Map of stick, slip and open contact over position and time"
    drawings = [Drawing(f"{alt}, {name}", partial(plot.zones, path, problem), name) for path, name in maps]
    caption = (
        f"Stick, slip and open zones over position and time, {'; '.join(one.which for one in shown)}: "
        "early cycles with slip, and the period of the long-term state. Dots: a node that never slips is at "
        "its limit."
    )
    return picture(caption, *drawings)


def _early(v: Verification, given: Pictured, problem: Problem) -> dict[int, EventHistory]:
    """Early cycles at λ = 1 that were completed before the long-term state."""
    simulation, end = v.as_given.simulation, float(given.state.history.cycle[0])
    last = max(1, min(max(EARLY), simulation.cycles_simulated))  # the first one may not be completed
    path = evolve(problem, simulation.load_factor, simulation.initial_slip, cycles=last).history
    pieces = {cycle: _cycle(path, cycle) for cycle in EARLY if cycle <= last and cycle < end + 1}
    return {cycle: piece for cycle, piece in pieces.items() if piece is not None}


def _cycle(path: EventHistory, number: int) -> EventHistory | None:
    """The rows of one cycle, counted from one; None where it was not followed to its end."""
    inside = np.flatnonzero((path.cycle >= number - 1) & (path.cycle <= number))
    piece = path.rows(inside)
    return piece if len(np.unique(piece.cycle)) > 1 else None


def _zones_at_instants(_: Verification, shown: Sequence[Pictured], problem: Problem) -> Picture:
    """Which nodes stick, slip and are open at instants of the period."""
    drawings = []
    times = {one.name: instants(one.state.history) for one in shown}
    for one, patch in product(shown, drawn_patches(problem)):
        path, name = one.state.history, one.name
        for time in times[name]:
            alt = f"Nodes that stick, slip and are open, {name}, {time_in_words(time)}"
            draw = partial(plot.zones_at, path, problem, time, patch=patch)
            drawings.append(Drawing(alt, draw, name, patch_size(problem, patch, three=True)))
    caption = (
        "What sticks, slips and is open, when the fewest nodes stick in each third of the period: "
        f"{'; '.join(one.which for one in shown)}.{open_between(shown, times, problem)}"
    )
    return picture(caption, *drawings, one_legend=True)


def open_between(shown: Sequence[Pictured], times: dict[str, list[float]], problem: Problem) -> str:
    """Which nodes are open for part of a period, but not at the instants that are drawn."""
    said = ""
    for one in shown:
        path = one.state.history
        from_on, until = path.cycle[:-1, None], path.cycle[1:, None]
        is_open = (path.state[:-1] == OPEN) & (until - from_on > SIX_DIGITS)
        drawn = ((from_on <= times[one.name]) & (times[one.name] < until)).any(axis=1)
        hidden = np.flatnonzero(is_open.any(axis=0) & ~is_open[drawn].any(axis=0))
        if hidden.size:
            nodes = open_in_words(tuple(hidden.tolist()), problem)
            said += f" Also open for part of the period, {one.name}: {nodes}."
    return said


def instants(path: EventHistory) -> list[float]:
    """Times at which the fewest nodes stick, one of each part; where it can be, at one some are open."""
    from_on, first, last = path.cycle[:-1], max(float(path.cycle[0]), 0.0), float(path.cycle[-1])
    middles = 0.5 * (from_on + path.cycle[1:])  # a state holds until the next row
    # shorter intervals are round-off: a node that just touches its limit
    lasting = np.diff(path.cycle) > SIX_DIGITS
    moving = np.where(lasting, (path.state[:-1] != STICK).sum(axis=1), -1)
    opened = (path.state[:-1] == OPEN).any(axis=1)
    ends = np.linspace(first, last, SIDE_BY_SIDE + 1)
    times, not_yet_open = list[float](), True
    for begin, end in pairwise(ends):
        inside = np.flatnonzero((middles >= begin) & (middles < end))
        if not inside.size:
            times.append(float(begin))
            continue
        fewest = inside[moving[inside] == moving[inside].max()]
        row = fewest[opened[fewest].argmax()] if not_yet_open else fewest[0]
        not_yet_open &= not opened[row]
        times.append(float(middles[row]))
    return times


def _slips_along(pictured: Pictured, problem: Problem) -> Picture:
    """How far each node slips back and forth, and what friction dissipates there."""
    return pictured.picture(
        f"Slip range of each node in contact, and the friction work there over one period: {pictured.which}.",
        Drawing("Slip range along the contact", partial(plot.slip_range, pictured.state, problem)),
        Drawing("Friction work along the contact", partial(plot.dissipation_along, pictured.state, problem)),
    )


def _slips_over_patch(pictured: Pictured, problem: Problem) -> Picture:
    """How far each node slips in all, and what friction dissipates there."""
    patches, drawn = drawn_patches(problem), (
        ("Accumulated slip", plot.slip_over_patch),
        ("Friction work", plot.work_over_patch),
    )  # fmt: skip
    three = len(patches) == 3  # two of each
    drawings = [
        Drawing(
            f"{what} over the patch",
            partial(draw, pictured.state, problem, patch=patch),
            size=patch_size(problem, patch, numbers=True, three=three),
        )
        for patch in patches
        for what, draw in drawn
    ]
    caption = (
        "Accumulated slip of each node over one period, in contact, and the friction work there: "
        f"{pictured.which}.{left_out(problem)}"
    )
    return pictured.picture(caption, *drawings)


IN_THE_PLANE = Family("hysteresis loops", _hysteresis, _reactions, _along, _slips_along, _zones, True)
IN_SPACE = Family(
    "slip orbits", _orbits, _reactions_within, _tractions, _slips_over_patch, _zones_at_instants, False
)


def _family(problem: Problem) -> Family:
    """How the states of a joint are drawn."""
    return IN_THE_PLANE if problem.directions == 1 else IN_SPACE
