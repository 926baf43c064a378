"""The answer of a verification in one sentence, in the user's loads, and its margin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.assessment.assess import ProvedLimit, proved_limit
from shakedown.ground.shown_values import down, sized, up
from shakedown.ground.status import Outcome
from shakedown.joint.units import constant_loads_in_words, units_of, varying_loads_in_words
from shakedown.report.assessment_words import admissible_in_words, at_load_factor, percent
from shakedown.report.node_words import node_in_words, open_in_words
from shakedown.report.run_words import sliding_in_words

if TYPE_CHECKING:
    from shakedown.assessment.verify import Verification
    from shakedown.joint.problem import Problem


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
    Axial load 20 ± 20 kN given: the joint slips in every cycle, with a slip range of up to 1.511
    at node 1, simulated; reduced to 20 ± 14.63 kN (λ = 0.7315934) it shakes down, proved; bolt
    preload 12 kN, unchanged.
    """
    loads = varying_loads_in_words(v.problem)
    given = f"{loads[:1].upper()}{loads[1:]} given" if loads else "The nominal load (λ = 1)"
    constant = constant_loads_in_words(v.problem) if loads else ""
    return f"{given}: {'; '.join(filter(None, [_what(v), constant]))}."


def _what(v: Verification) -> str:
    """What the joint does, and how far that is proved."""
    run, limit = v.as_given.simulation, proved_limit(v.assessment)
    state = _of_state(v, limit)
    path = ", with the corners of the load domain in their order" * v.problem.is_domain
    if run.slides_away:
        return f"the joint does not hold: {sliding_in_words(run)}"
    if run.outcome == Outcome.UNDECIDED:
        return f"it is undecided what the joint does: {run.reason}"
    if run.outcome == Outcome.SHAKEDOWN:
        with_open = f" with {open_in_words(run.open_nodes, v.problem)} open" if run.open_nodes else ""
        if limit.load_factor > 1:
            least = 0.0 if limit.of_every_state else v.limits.from_state.least_load_factor
            begins = f" from λ = {up(least)} on" if least > 0 else ""
            until = up_to(v.problem, limit.load_factor)
            return f"the joint shakes down{with_open}{begins} {until}, proved{state}"
        how = "proved" if run.proved else f"simulated{path}, not proved"
        return f"the joint shakes down{with_open}, {how}"
    reduced = ""
    if 0 < limit.load_factor < 1:
        less = at_load_factor(v.problem, limit.load_factor, down)
        reduced = f"; reduced to {less} it shakes down, proved{state}"
    return f"{_does(v)}, simulated{path}{reduced}"


def _does(v: Verification) -> str:
    """What a joint does that does not come to rest."""
    run = v.as_given.simulation
    if run.outcome == Outcome.SEPARATION:
        return f"the joint is in separation: {run.reason}"
    verb = "slips on and on" if run.outcome == Outcome.RATCHETTING else "slips"
    nodes = v.nodes
    most = int(nodes.slip_range.argmax())
    size = sized(nodes.slip_range[most], units_of(v.problem).length)
    where = node_in_words(v.problem, most)
    return f"the joint {verb} in every cycle, with a slip range of up to {size} at {where}"


def _of_state(v: Verification, limit: ProvedLimit) -> str:
    """Of which states a limit is proved besides the one asked about."""
    return f" from every state, {admissible_in_words(v.limits.universal)}" * limit.of_every_state


def up_to(problem: Problem, load_factor: float) -> str:
    """Up to which loads something holds, rounded down."""
    if np.isinf(load_factor):
        return "at every load factor"
    return f"up to {at_load_factor(problem, load_factor, down)}"


def margin_of_answer(v: Verification) -> str:
    """By how much the amplitude may grow, or how much less is enough; empty where no limit is known.

    Examples
    --------
    >>> import shakedown
    >>> print(margin_of_answer(shakedown.verify(shakedown.example("block-9"), random_states=0)))
    Margin on the amplitude: 369.9 % proved, 370.2 % simulated.
    """
    limit, known = proved_limit(v.assessment), []
    if limit.load_factor > 0:
        known.append((limit.load_factor, f"proved{_of_state(v, limit)}"))
    if v.transient is not None and v.transient.monotone and v.transient.load_factor > 0:
        known.append((v.transient.load_factor, "simulated"))
    if v.as_given.simulation.outcome == Outcome.SHAKEDOWN:
        parts = [f"{percent(value, down)} {how}" for value, how in known if value > 1]
        return f"Margin on the amplitude: {', '.join(parts)}." if parts else ""
    parts = [f"{percent(value, up)}, {how}" for value, how in known if 0 < value < 1]
    return f"Reduce the amplitude by {'; by '.join(parts)}." if parts else ""
