"""The answer of a verification: one sentence in the user's loads, its margin, colour, how far it holds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.assessment.assess import proved_limit
from shakedown.ground.shown_values import count, down, sized, up
from shakedown.ground.status import Outcome
from shakedown.joint.units import constant_loads_in_words, units_of, varying_loads_in_words
from shakedown.report.assessment_words import (
    IN_CONTACT,
    admissible_in_words,
    at_load_factor,
    loads_at,
    start_in_words,
)
from shakedown.report.hint_words import LOAD_DOMAIN
from shakedown.report.next_words import margin_in_words, starting_in_words
from shakedown.report.node_words import node_in_words, open_in_words
from shakedown.report.run_words import separated_in_words, sliding_in_words

if TYPE_CHECKING:
    from shakedown.assessment.verify import Verification
    from shakedown.joint.problem import Problem

ASSUMPTIONS = (
    "Assumed: loads change slowly (quasi-static); Coulomb friction, with one constant coefficient per node "
    "for sticking and slipping; linear elastic bodies; small displacements"
)
NOT_SAID = "Nothing is said about the strength of the material, wear, or fretting fatigue."


def answer_in_words(v: Verification) -> str:
    """What becomes of the joint under the nominal load, and up to which loads it shakes down.

    Examples
    --------
    >>> import dataclasses, shakedown
    >>> joint = dataclasses.replace(
    ...     shakedown.example("two-node"), load_names=["bolt preload", "axial load"],
    ...     load_mean=[12, 20], load_amplitude=[0, 20], load_units=["kN", "kN"],
    ... )
    >>> print(answer_in_words(shakedown.verify(joint, load_factors=[1.0], random_states=0)))
    At axial load 20 ± 20 kN (λ = 1) the joint slips in every cycle, with a slip range of up to 1.511
    at node 1, in the simulation. Starting without slip, it is proved to shake down up to 20 ± 14.63 kN
    (λ = 0.7315934); bolt preload 12 kN, unchanged.
    """
    if v.as_given.simulation.separated:
        return separated_in_words(v.problem)
    loads = varying_loads_in_words(v.problem)
    if not loads:  # then the margin says the same number
        proved = "" if margin_of_answer(v) else _proved(v)
        return " ".join(filter(None, [f"At the nominal load (λ = 1) {_what(v)}.", proved]))
    said = " ".join(filter(None, [f"At {loads} (λ = 1) {_what(v)}.", _proved(v)]))
    constant = constant_loads_in_words(v.problem)
    return f"{said[:-1]}; {constant}." if constant else said


def _what(v: Verification) -> str:
    """What the joint does under the nominal load, and how that is known."""
    run, limit = v.as_given.simulation, proved_limit(v.assessment)
    path = ", with the corners of the load domain in their order" * v.problem.is_domain
    if run.slides_away:
        return f"the joint does not hold: {sliding_in_words(run)}"
    if run.outcome == Outcome.UNDECIDED:
        return f"it is undecided what the joint does: {run.reason}"
    if run.outcome == Outcome.SEPARATION:
        return f"the joint is in separation, in the simulation{path}: {run.reason}"
    if run.outcome != Outcome.SHAKEDOWN:
        return f"{_does(v)}, in the simulation{path}"
    with_open = f" with {open_in_words(run.open_nodes, v.problem)} open" if run.open_nodes else ""
    if limit.load_factor > 1:
        state = "every" if v.assessment.proved_from_every_state > 1 else "this"
        proved = "" if v.problem.loads else f", proved from {state} state"  # with loads, said next
        return f"the joint shakes down{with_open}{proved}"
    how = "proved by following its cycles" if run.proved else f"in the simulation{path}, not proved"
    return f"the joint shakes down{with_open}, {how}"


def _proved(v: Verification) -> str:
    """Up to which loads shakedown is proved; empty where it is not, or where the joint slides away."""
    run, limit = v.as_given.simulation, proved_limit(v.assessment)
    rests = run.outcome == Outcome.SHAKEDOWN
    if (
        run.slides_away
        or run.outcome == Outcome.UNDECIDED
        or not (limit.load_factor > 1 if rests else 0 < limit.load_factor < 1)
    ):
        return ""
    energy, universal = v.limits.energy, v.limits.universal
    closed = np.delete(energy.initial_slip, v.problem.layout.slips_of(energy.open_nodes))
    here = f"Starting {start_in_words(closed)}"
    if limit.of_every_state:
        here = f"From every state {admissible_in_words(universal)}"
    least = 0.0 if limit.of_every_state else v.limits.from_state.least_load_factor
    begins = f" from λ = {up(least)} on" if least > 0 else ""
    again = "do so" if rests else "shake down"
    return f"{here}, it is proved to {again}{begins} {up_to(v.problem, limit.load_factor)}."


def _does(v: Verification) -> str:
    """What a joint does that slips in every cycle."""
    run = v.as_given.simulation
    verb = "slips on and on" if run.outcome == Outcome.RATCHETTING else "slips"
    nodes = v.nodes
    most = int(nodes.slip_range.argmax())
    size = sized(nodes.slip_range[most], units_of(v.problem).length)
    where = node_in_words(v.problem, most)
    return f"the joint {verb} in every cycle, with a slip range of up to {size} at {where}"


def up_to(problem: Problem, load_factor: float) -> str:
    """The loads up to which a statement holds, rounded down."""
    if np.isinf(load_factor):
        return "at every load factor"
    loads = loads_at(problem, load_factor, down)  # with them the factor needs no explanation
    return f"up to {at_load_factor(problem, load_factor, down)}{'' if loads else ' times the load amplitude'}"


def margin_of_answer(v: Verification) -> str:
    """The margin of the amplitude, and up to where no node slips; empty where no limit is known.

    Examples
    --------
    >>> import shakedown
    >>> print(margin_of_answer(shakedown.verify(shakedown.example("block-9"), random_states=0)))
    The varying part of the load alone may be 366.3 % larger, proved for this mesh, 370.2 % in the
    simulation. No node slips up to λ = 4.334039, starting without slip.
    """
    limit = v.transient
    known = limit is not None and limit.monotone and limit.load_factor > 0
    margin = margin_in_words(v.assessment, limit.load_factor if limit is not None and known else np.nan)
    slip = v.limits.first_slip.load_factor
    if not margin or not 1 < slip < np.inf:
        return margin
    start = starting_in_words(v.assessment)
    return f"{margin} No node slips up to {at_load_factor(v.problem, slip, down)}, {start}."


def banner_class(v: Verification) -> str:
    """The colour of the banner: green only where the joint shakes down, red where it slips for ever.

    Runs at other load factors that are left open do not colour the answer for the nominal one.
    """
    run = v.as_given.simulation
    elsewhere = sum(
        each.simulation.outcome == Outcome.UNDECIDED and each.simulation.load_factor != run.load_factor
        for each in v.runs
    )
    if run.separated and not v.disagreements:
        return "open"
    if v.disagreements or run.slides_away or run.outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING):
        return "disagree"
    exact = run.proved or run.long_term is not None  # at fixed load steps slow slip may look like none
    return (
        "agree"
        if run.outcome == Outcome.SHAKEDOWN and exact and len(v.open_questions) == elsewhere
        else "open"
    )


def verdict_in_words(v: Verification) -> str:
    """Whether prediction and simulation agree, and both solvers of the bounds; every finding is counted."""
    judged = sum(run.agrees is not None for run in v.runs)
    if v.disagreements or v.open_questions:
        wrong, sliding = len(v.disagreements), sum(run.simulation.slides_away for run in v.runs)
        said = (
            (wrong, f"DISAGREEMENT: {count(wrong, 'finding')}."),
            (sliding, f"In {count(sliding, 'run')} the joint does not hold: the body slides away."),
            (asked := len(v.open_questions) - sliding, f"Open: {count(asked, 'question')}."),
        )
        return " ".join(text for number, text in said if number > 0)
    return agreement_in_words(judged, len(v.runs))


def agreement_in_words(judged: int, runs: int) -> str:
    """That the simulations agree with the bounds, in how many runs with a predicted outcome, and in all.

    Examples
    --------
    >>> agreement_in_words(0, 4)
    'The bounds predict no outcome of any of the 4 runs: there is nothing to agree with.'
    """
    if not judged:
        any_run = "the one run" if runs == 1 else f"any of the {runs} runs"
        return f"The bounds predict no outcome of {any_run}: there is nothing to agree with."
    agree = (
        f"Prediction and time integration agree in {'the one run' if judged == 1 else f'all {judged} runs'}"
    )
    if judged == runs:
        return f"{agree}."
    return f"{agree} for which the bounds predict an outcome ({runs} runs in all)."


def _paths_in_words(problem: Problem, plane: bool) -> str:
    """For which paths through the load steps the numbers hold."""
    if problem.is_domain:
        return LOAD_DOMAIN
    others = "λ_1, λ_U" if plane else "λ_U"
    return (
        f"λ_E, λ_S and λ_max hold for every path through these load steps; {others} and what is simulated "
        "hold for this order, period after period."
    )


def limits_in_words(v: Verification) -> list[str]:
    """For which zone, loads and initial states the answer holds, and what is assumed."""
    problem, upper, asked = v.problem, v.limits.upper, v.settings
    plane = problem.directions == 1
    zone = f"Zone: the bounds hold {IN_CONTACT}."
    if upper.open_nodes:
        opened = open_in_words(upper.open_nodes, v.problem)
        zone = (
            f"Zone: λ_max and λ_E are about the joint with {opened} open and all others closed throughout; "
            f"{'λ_1, λ_U' if plane else 'λ_U'} and λ_S hold while all nodes stay in contact."
        )
    if problem.C is None:
        zone += " The problem has no normal stiffness C: whether nodes open and close again is not followed."
    start = "zero slip" if problem.initial_slip is None else "the first given slip"
    states = (
        f"Initial states: λ = 1, λ_E, λ_S and λ_T start from {start} in contact. "
        f"Simulated besides: the safe slip, {'the critical slip state, ' * plane}"
        f"what {count(asked.random_states, 'random transient')} with up to twice the load amplitudes "
        f"{'leaves' if asked.random_states == 1 else 'leave'} behind (seed {asked.seed})."
    )
    loads = (
        f"Loads: λ multiplies the periodic part of {count(problem.m, 'load step')}; the constant part"
        + (" and the transient load steps stay" if problem.q_transient is not None else " stays")
        + f" as given. {_paths_in_words(problem, plane)}"
    )
    model = (
        f"Model: {count(problem.n, 'contact node')}; the numbers are those of this mesh. As it gets finer, "
        "slips and friction work at one load tend to a limit, λ_max only where the edges of the contact do "
        f"not slip{'; λ_1 usually falls' * plane} (shakedown-bounds refine)."
    )
    assumed = f"{ASSUMPTIONS}{'; slip in one tangential direction' * plane}."
    return [zone, loads, states, model, assumed, NOT_SAID]
