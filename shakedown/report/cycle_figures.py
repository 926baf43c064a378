"""Pictures of the state of the joint: loops, pressures, zones, slips."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes

from shakedown import plot
from shakedown.ground.status import Outcome
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of, work_unit
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory
from shakedown.motion.evolve import evolve
from shakedown.plot.inline_svg import Panel, Picture, panel
from shakedown.plot.loops import friction_work
from shakedown.plot.style import node_name
from shakedown.verification.verify import Verification

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
    return (
        None if state is None or len(state.history) < 2 else Pictured(state, "at λ = 1, the loading as given")
    )


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
    return Pictured(state, f"at λ = 1 {at_one}; shown at λ = {state.load_factor:.5g}, where it slips")


def state_pictures(v: Verification) -> list[Picture]:
    """Loops of the nodes that dissipate most, reactions, zones and slips along the contact."""
    problem, given, cycling = v.problem, as_given_state(v), cycling_state(v)
    elsewhere = cycling is not None and (given is None or cycling.state is not given.state)
    pictures = [] if cycling is None else [_loops(cycling, problem)]
    if given is not None:
        if problem.n > FEW:
            pictures.append(_along(given, problem))
        elif cycling is None or elsewhere:
            pictures.append(_reactions(given, problem))
        pictures.append(_zones(v, given, problem))
    if cycling is not None:
        if elsewhere:
            pictures.append(_zones_of(cycling, problem))
        if problem.n > FEW:
            pictures.append(_slips(cycling, problem))
    return pictures


def no_pictures(v: Verification) -> str:
    """Why there is no picture of something, or nothing."""
    if as_given_state(v) is None:
        return "No state is drawn: the simulations did not go from event to event."
    if cycling_state(v) is None:
        return (
            "There are no hysteresis loops to draw: no simulated state from this start slips in every cycle."
        )
    return ""


def _loops(pictured: Pictured, problem: Problem) -> Picture:
    state = pictured.state
    work = friction_work(state.history)
    worst = [int(node) for node in np.argsort(-work, kind="stable")[:MOST_NODES] if work[node] > 0]
    unit = work_unit(*units_of(problem))
    panels = tuple(_loop(state.history, problem, node, float(work[node]), unit) for node in worst or [0])
    total = f"{state.dissipation_per_cycle:.4g} {unit}".rstrip()
    per = "cycle" if state.period == 1 else f"{state.period} cycles"
    caption = (
        f"Hysteresis loops of the nodes that dissipate most: {pictured.which}. The area of a loop is what "
        f"friction takes at the node in one period ({per}); the joint takes {total} per cycle. Beside it the "
        "tangential reaction between its limits."
    )
    return Picture(caption, panels, choose=len(panels) > 1)


def _loop(path: EventHistory, problem: Problem, node: int, work: float, unit: str) -> Panel:
    name = node_name(node, problem)
    return panel(
        f"Hysteresis loop of {name}: tangential reaction against slip; {work:.4g} {unit} per period".strip(),
        partial(plot.hysteresis, path, problem, nodes=[node]),
        partial(plot.reactions_in_time, path, problem, node),
        name=name,
    )


def _along(pictured: Pictured, problem: Problem) -> Picture:
    """Pressure and use of friction at instants of the period, the same axes for all of them."""
    path = pictured.state.history
    times = path.cycle[0] + np.arange(INSTANTS) / INSTANTS * (path.cycle[-1] - path.cycle[0])
    states = [path.at(np.array([time])) for time in times]
    highest = max(_highest(plot.pressure(at, problem)) for at in states)
    panels = []
    for time, at in zip(times, states, strict=True):

        def pressure(*, ax: Axes, at: EventHistory = at) -> None:
            plot.pressure(at, problem, ax=ax).set_ylim(-0.04 * highest, 1.08 * highest)

        panels.append(
            panel(
                f"Normal reaction and use of friction along the contact at t = {time:.4g} cycles",
                pressure,
                partial(plot.friction_use, at, problem),
                name=f"t = {time:.4g}",
            )
        )
    caption = (
        f"Normal reactions and use of friction along the contact, {pictured.which}, at instants of the "
        "period (t in cycles). At ±1 a node slips or is about to; open nodes use none and are left out."
    )
    return Picture(caption, tuple(panels), choose=True)


def _highest(axes: Axes) -> float:
    values = np.concatenate([np.asarray(line.get_ydata(), dtype=float) for line in axes.get_lines()])
    return float(np.nanmax(values, initial=0.0)) or 1.0


def _reactions(pictured: Pictured, problem: Problem) -> Picture:
    path = pictured.state.history
    panels = [
        panel(
            f"Tangential reaction of node {node} over time, between its friction limits",
            partial(plot.reactions_in_time, path, problem, node),
        )
        for node in range(problem.n)
    ]
    return Picture(f"Tangential reactions between their limits, {pictured.which}.", tuple(panels))


def _zones(v: Verification, pictured: Pictured, problem: Problem) -> Picture:
    """Stick, slip and open zones in early cycles and in the long term, at λ = 1."""
    simulation = v.as_given.simulation
    last = max(1, min(max(EARLY), simulation.cycles_simulated))  # the first one may not come to its end
    panels = []
    path = evolve(problem, simulation.load_factor, simulation.initial_slip, cycles=last).history
    end = float(pictured.state.history.cycle[0])
    for cycle in EARLY:
        piece = _cycle(path, cycle)
        if cycle <= last and piece is not None and cycle < end + 1:
            panels.append(_zone_panel(piece, problem, f"cycle {cycle}"))
    panels.append(_zone_panel(pictured.state.history, problem, "long term"))
    caption = (
        f"Stick, slip and open zones over position and time, {pictured.which}: early cycles, and the period "
        "of the long-term state. Dots: a node that never slips is at its limit."
    )
    return Picture(caption, tuple(panels))


def _cycle(path: EventHistory, number: int) -> EventHistory | None:
    """The rows of one cycle, counted from one; None where it was not followed to its end."""
    inside = np.flatnonzero((path.cycle >= number - 1) & (path.cycle <= number))
    piece = path.rows(inside)
    return piece if len(np.unique(piece.cycle)) > 1 else None


def _zones_of(pictured: Pictured, problem: Problem) -> Picture:
    zones = _zone_panel(pictured.state.history, problem, "long term")
    return Picture(f"Stick, slip and open zones over position and time: {pictured.which}.", (zones,))


def _zone_panel(path: EventHistory, problem: Problem, name: str) -> Panel:
    return panel(
        f"Map of stick, slip and open contact over position and time, {name}",
        partial(plot.zones, path, problem),
        name=name,
        size=(4.6, 4.6),
        below=0.5,
    )


def _slips(pictured: Pictured, problem: Problem) -> Picture:
    path = pictured.state.history
    slips = panel("Slip range along the contact", partial(plot.slip_range, path, problem))
    work = panel("Friction work along the contact", partial(plot.dissipation_along, path, problem))
    caption = (
        f"How far each node slips back and forth in contact, and what friction takes there in one period: "
        f"{pictured.which}."
    )
    return Picture(caption, (slips, work))
