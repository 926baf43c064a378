"""Pictures of the state of the joint: loops or orbits, reactions, zones, slips and friction work."""

from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from shakedown import plot
from shakedown.assessment.verify import Verification
from shakedown.ground.round_off import SIX_DIGITS
from shakedown.ground.shown_values import at_lambda, sized
from shakedown.ground.size_limits import EACH_SHOWN
from shakedown.ground.status import OPEN, STICK, Outcome
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory
from shakedown.plot.inline_svg import SIDE_BY_SIDE, Drawing, Picture, picture
from shakedown.plot.patch_data import can_be_turned, patch_data
from shakedown.plot.patch_places import model_places
from shakedown.plot.paths import extreme_rows, time_in_words, work_of_nodes
from shakedown.report.load_figures import drawn_patches, left_out, load_loops_pictures, patch_size

MOVING = (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING)


class Pictured(NamedTuple):
    """A long-term state to draw, with words that identify it."""

    state: LongTermState
    which: str

    def picture(self, caption: str, *drawings: Drawing) -> Picture:
        """Panels under one caption, with the load factor above them."""
        name = at_lambda(self.state.load_factor)
        said = f"{caption} ({self.which}).{left_out(self.state.problem)}"
        return picture(said, *(each._replace(name=name) for each in drawings))


def as_given_state(v: Verification) -> Pictured | None:
    """The long-term state at λ = 1; None where it was not followed from event to event."""
    state = v.as_given.simulation.long_term
    return None if state is None or len(state.history) < 2 else Pictured(state, "at λ = 1, the nominal load")


def cycling_state(v: Verification) -> Pictured | None:
    """A state in which nodes slip: at λ = 1, or at the nearest simulated load factor above."""
    if v.as_given.simulation.outcome in MOVING:
        return as_given_state(v)
    runs = [run.simulation for run in v.runs if run.initial == v.as_given.initial]
    states = [run.long_term for run in runs if run.outcome in MOVING and run.load_factor > 1]
    if v.transient is not None and not any(states):
        states = [v.transient.at_high]
    known = [state for state in states if state is not None and len(state.history) > 1]
    known = [state for state in known if state.outcome in MOVING and state.load_factor > 1]
    nearest = min(known, key=lambda state: state.load_factor, default=None)
    if nearest is None:
        return None
    return Pictured(nearest, f"at {at_lambda(nearest.load_factor)}, the nearest simulated load that slips")


def state_pictures(v: Verification) -> list[Picture]:
    """Loops of the nodes that dissipate most, slips and friction work, reactions, zones."""
    given, cycling, pictures = as_given_state(v), cycling_state(v), list[Picture]()
    if cycling is not None:
        pictures += [_loops(cycling, v.problem), *load_loops_pictures(*cycling)]
        pictures += [_slips(cycling, v.problem)] if v.problem.n > SIDE_BY_SIDE else []
    if given is not None:
        pictures.append((_along if v.problem.directions == 1 else _over_patches)(given, v.problem))
    shown = cycling or given
    if shown is not None and shown.state.history.state.any():
        pictures.append(_zones(shown, v.problem))
    return pictures


def contact_to_turn(v: Verification) -> dict[str, str] | None:
    """Data for the script of the view: a state in which nodes slip, or else that at λ = 1; and which."""
    pictured = cycling_state(v) or as_given_state(v)
    if pictured is None or not can_be_turned(v.problem):
        return None
    name = at_lambda(pictured.state.load_factor)
    return {"data": Markup(patch_data(pictured.state)), "which": pictured.which, "name": name}


def no_pictures(v: Verification) -> str:
    """Why some pictures are missing; empty where none are."""
    if v.as_given.simulation.long_term is None:
        return "No state is drawn: the simulations did not go from event to event."
    cycling, loops = cycling_state(v), "hysteresis loops" if v.problem.directions == 1 else "slip orbits"
    if cycling is None and as_given_state(v) is None:
        return "No state is drawn: at λ = 1 no long-term state was found."
    said = f"There are no {loops} to draw: no simulated state from this start slips in every cycle."
    missing = [said] if cycling is None else []
    if v.problem.directions > 1 and not can_be_turned(v.problem):
        known = "the problem does not say where its nodes are"
        why = known if model_places(v.problem) is None else "its nodes are in a line"
        missing.append(f"There is no view to turn: {why}.")
    return " ".join(missing)


def _loops(pictured: Pictured, problem: Problem) -> Picture:
    """Hysteresis loops, or orbits of slips and reactions, of the nodes that dissipate most."""
    state, worst = pictured.state, _worst(pictured.state)
    what, draw, beside = "Slip orbits", plot.slip_orbits, partial(plot.reaction_orbits, nodes=worst)
    if problem.directions == 1:
        what, draw, beside = (
            "Hysteresis loops",
            plot.hysteresis,
            partial(plot.reactions_in_time, node=worst[0]),
        )
    drawings = (
        Drawing(f"{what} of the nodes that dissipate most", partial(draw, state, problem, nodes=worst)),
        Drawing("Tangential reactions within their limits", partial(beside, state, problem)),
    )
    total = sized(state.dissipation_per_cycle, units_of(problem).work)
    caption = f"{what} of the nodes that dissipate most, and their reactions; {total} per cycle in all"
    return pictured.picture(caption, *drawings)


def _worst(state: LongTermState) -> list[int]:
    """The few nodes that dissipate most."""
    work = work_of_nodes(state)
    most = np.argsort(-work, kind="stable")[:EACH_SHOWN].tolist()
    return [node for node in most if work[node] > SIX_DIGITS * work.max()] or [0]


def _along(pictured: Pictured, problem: Problem) -> Picture:
    """Reactions of a few nodes over time; of more, pressure and use of friction at instants."""
    path = pictured.state.history
    if problem.n <= SIDE_BY_SIDE:
        each = [partial(plot.reactions_in_time, path, problem, node) for node in range(problem.n)]
        drawings = [Drawing("Tangential reaction over time, between its limits", draw) for draw in each]
        return pictured.picture("Tangential reactions between their limits", *drawings)
    times = path.cycle[0] + np.arange(EACH_SHOWN) / EACH_SHOWN * (path.cycle[-1] - path.cycle[0])
    drawn = ("Normal reactions", plot.pressure), ("Use of friction", plot.friction_use)
    at = path.at(times)
    drawings = [Drawing(f"{what} at instants", partial(f, at, problem, cycles=times)) for what, f in drawn]
    return pictured.picture("Normal reactions, and use of friction: at ±1 a node is at its limit", *drawings)


def _over_patches(pictured: Pictured, problem: Problem) -> Picture:
    """Pressure and use of friction when reactions are largest, and when the total pressure is smallest."""
    path = pictured.state.history
    times = [float(path.cycle[row]) for row in extreme_rows(path)[:0:-1]]
    times = times[: 1 + (abs(times[1] - times[0]) > 0.5 / SIDE_BY_SIDE)]  # closer in time they look the same
    drawn = ("Pressure", plot.pressure_over_patch), ("Use of friction", plot.friction_use_at)
    drawings = [
        Drawing(f"{what}, {time_in_words(time)}", partial(draw, path, problem, time, patch=patch), size=size)
        for patch, time in product(range(drawn_patches(problem)), times)
        for size in [patch_size(problem, patch)]
        for what, draw in drawn
    ]
    caption = "Normal reactions, and use of friction: at the rim a node is at its limit"
    return pictured.picture(caption, *drawings)


def _slips(pictured: Pictured, problem: Problem) -> Picture:
    """How far each node slips, and what friction dissipates there."""
    state = pictured.state
    if problem.directions == 1:
        drawings = [
            Drawing("Slip range along the contact", partial(plot.slip_range, state, problem)),
            Drawing("Friction work along the contact", partial(plot.dissipation_along, state, problem)),
        ]
        return pictured.picture("Slip range of each node, and its friction work in one period", *drawings)
    drawn = ("Accumulated slip", plot.slip_over_patch), ("Friction work", plot.work_over_patch)
    drawings = [
        Drawing(f"{what} over the patch", partial(draw, state, problem, patch=patch), size=size)
        for patch in range(drawn_patches(problem))
        for size in [patch_size(problem, patch)]
        for what, draw in drawn
    ]
    return pictured.picture("Slip Σ|Δv| and friction work of one period", *drawings)


def _zones(pictured: Pictured, problem: Problem) -> Picture:
    """Stick, slip and open zones: over position and time, or at instants of the period."""
    path, name = pictured.state.history, at_lambda(pictured.state.load_factor)
    caption = f"What sticks, slips and is open in one period ({pictured.which})."
    if problem.directions == 1:
        alt = f"Map of stick, slip and open contact over position and time, {name}"
        return picture(caption, Drawing(alt, partial(plot.zones, path, problem), name))
    drawings = []
    for patch, time in product(range(drawn_patches(problem)), instants(path)):
        alt, draw = (
            f"What sticks and slips, {time_in_words(time)}",
            partial(plot.zones_at, path, problem, time),
        )
        drawings.append(Drawing(alt, partial(draw, patch=patch), name, patch_size(problem, patch)))
    return picture(caption, *drawings, one_legend=True)


def instants(path: EventHistory) -> list[float]:
    """Times in each third of a path at which the fewest nodes stick, for longer than round-off."""
    lasting = np.diff(path.cycle) > SIX_DIGITS
    middles, state = 0.5 * (path.cycle[:-1] + path.cycle[1:])[lasting], path.state[:-1][lasting]
    moving = (state != STICK).sum(axis=1) + 0.5 * (state == OPEN).any(axis=1)
    thirds = np.array_split(np.arange(len(middles)), SIDE_BY_SIDE)
    return [float(middles[third[moving[third].argmax()]]) for third in thirds if len(third)]
