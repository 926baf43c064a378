"""Pictures of the state of the joint: loops, pressures, zones, slips."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from shakedown import plot
from shakedown.assessment.verify import Verification
from shakedown.ground.shown_values import at_lambda, few
from shakedown.ground.status import Outcome
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of, work_unit
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory
from shakedown.motion.evolve import evolve
from shakedown.plot.drawn_path import work_of_nodes
from shakedown.plot.inline_svg import Drawing, Picture, picture
from shakedown.plot.style import node_name

MOST_NODES = 4  # with loops of their own
FEW = 3  # nodes up to which each one has its own picture
INSTANTS = 4  # of one period
EARLY = (1, 9)  # cycles whose zones are shown beside those of the long-term state
AT_ONE = {
    Outcome.SHAKEDOWN: "nothing slips in the long term",
    Outcome.SEPARATION: "nothing slips in contact in the long term",
}
MOVING = (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING)


@dataclass(frozen=True, eq=False)
class Pictured:
    """A long-term state that is drawn, and in words which one it is."""

    state: LongTermState
    which: str


def as_given_state(v: Verification) -> Pictured | None:
    """The long-term state at λ = 1; None where it was not followed from event to event."""
    state = v.as_given.simulation.long_term
    return None if state is None or len(state.history) < 2 else Pictured(state, "at λ = 1, the nominal load")


def cycling_state(v: Verification) -> Pictured | None:
    """A state in which nodes slip: that at λ = 1, or the nearest load factor above that was simulated."""
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
    """Loops of the nodes that dissipate most, reactions, zones and slips along the contact."""
    problem, given, cycling = v.problem, as_given_state(v), cycling_state(v)
    elsewhere = cycling is not None and (given is None or cycling.state is not given.state)
    pictures = [] if cycling is None else [_loops(cycling, problem)]
    if given is not None and problem.n > FEW:
        pictures.append(_along(given, problem))
    elif given is not None and (cycling is None or elsewhere):
        pictures.append(_reactions(given, problem))
    shown = [] if given is None else [given]
    shown += [cycling] if cycling is not None and elsewhere else []
    if shown:
        pictures.append(_zones(v, shown, problem))
    if cycling is not None and problem.n > FEW:
        pictures.append(_slips(cycling, problem))
    return pictures


def no_pictures(v: Verification) -> str:
    """Why there is no picture of something, or nothing."""
    if as_given_state(v) is None:
        return "No state is drawn: the simulations did not go from event to event."
    if cycling_state(v) is None:
        loops = "hysteresis loops" if v.problem.directions == 1 else "slip orbits"
        return f"There are no {loops} to draw: no simulated state from this start slips in every cycle."
    return ""


def _loops(pictured: Pictured, problem: Problem) -> Picture:
    state = pictured.state
    path, work = state.history, work_of_nodes(state)
    worst = [int(node) for node in np.argsort(-work, kind="stable")[:MOST_NODES] if work[node] > 0] or [0]
    names = [node_name(node, problem) for node in worst]
    total = f"{few(state.dissipation_per_cycle)} {work_unit(*units_of(problem))}".rstrip()
    per = "cycle" if state.period == 1 else f"{state.period} cycles"
    caption = (
        f"Hysteresis loops of the nodes that dissipate most: {pictured.which}. The area of a loop is what "
        f"friction dissipates at the node in one period ({per}); the joint dissipates {total} per cycle. "
        f"Beside them the tangential reaction of {names[0]} between its limits."
    )
    return picture(
        caption,
        Drawing(
            f"Hysteresis loops of {', '.join(names)}: tangential reaction against slip",
            partial(plot.hysteresis, path, problem, nodes=worst),
        ),
        Drawing(
            f"Tangential reaction of {names[0]} over time, between its friction limits",
            partial(plot.reactions_in_time, path, problem, worst[0]),
        ),
    )


def _along(pictured: Pictured, problem: Problem) -> Picture:
    """Pressure and use of friction at instants of the period."""
    path = pictured.state.history
    times = path.cycle[0] + np.arange(INSTANTS) / INSTANTS * (path.cycle[-1] - path.cycle[0])
    at = path.at(times)
    caption = (
        f"Normal reactions and use of friction along the contact, {pictured.which}, at instants of the "
        "period (t in cycles). At ±1 a node slips or is about to; open nodes use none and are left out."
    )
    return picture(
        caption,
        Drawing(
            "Normal reactions along the contact at instants of the period",
            partial(plot.pressure, at, problem, cycles=times),
        ),
        Drawing(
            "Use of friction along the contact at instants of the period",
            partial(plot.friction_use, at, problem, cycles=times),
        ),
    )


def _reactions(pictured: Pictured, problem: Problem) -> Picture:
    path = pictured.state.history
    drawings = [
        Drawing(
            f"Tangential reaction of node {node} over time, between its friction limits",
            partial(plot.reactions_in_time, path, problem, node),
        )
        for node in range(problem.n)
    ]
    return picture(f"Tangential reactions between their limits, {pictured.which}.", *drawings)


def _zones(v: Verification, shown: Sequence[Pictured], problem: Problem) -> Picture:
    """Stick, slip and open zones in the long term, and in early cycles at λ = 1 in which not all stick."""
    drawings = []
    if shown[0].state is v.as_given.simulation.long_term:
        drawings += [
            _zone_map(piece, problem, f"λ = 1, cycle {cycle}")
            for cycle, piece in _early(v, shown[0], problem).items()
            if piece.state.any()
        ]
    drawings += [
        _zone_map(one.state.history, problem, f"{at_lambda(one.state.load_factor)}, long term")
        for one in shown
    ]
    caption = (
        f"Stick, slip and open zones over position and time, {'; '.join(one.which for one in shown)}: "
        "early cycles with slip, and the period of the long-term state. Dots: a node that never slips is at "
        "its limit."
    )
    return picture(caption, *drawings)


def _early(v: Verification, given: Pictured, problem: Problem) -> dict[int, EventHistory]:
    """Early cycles at λ = 1 that came to their end before the long-term state."""
    simulation, end = v.as_given.simulation, float(given.state.history.cycle[0])
    last = max(1, min(max(EARLY), simulation.cycles_simulated))  # the first one may not come to its end
    path = evolve(problem, simulation.load_factor, simulation.initial_slip, cycles=last).history
    pieces = {cycle: _cycle(path, cycle) for cycle in EARLY if cycle <= last and cycle < end + 1}
    return {cycle: piece for cycle, piece in pieces.items() if piece is not None}


def _cycle(path: EventHistory, number: int) -> EventHistory | None:
    """The rows of one cycle, counted from one; None where it was not followed to its end."""
    inside = np.flatnonzero((path.cycle >= number - 1) & (path.cycle <= number))
    piece = path.rows(inside)
    return piece if len(np.unique(piece.cycle)) > 1 else None


def _zone_map(path: EventHistory, problem: Problem, name: str) -> Drawing:
    alt = f"Map of stick, slip and open contact over position and time, {name}"
    return Drawing(alt, partial(plot.zones, path, problem), name)


def _slips(pictured: Pictured, problem: Problem) -> Picture:
    path = pictured.state.history
    caption = (
        f"How far each node slips back and forth in contact, and what friction dissipates there in one "
        f"period: {pictured.which}."
    )
    return picture(
        caption,
        Drawing("Slip range along the contact", partial(plot.slip_range, path, problem)),
        Drawing("Friction work along the contact", partial(plot.dissipation_along, path, problem)),
    )
