"""What a simulation found: the nominal load, its proof and its margin."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from shakedown.bounds.bound_result import Bound
from shakedown.ground.shown_values import FEW_DIGITS, count, down, up
from shakedown.ground.status import Outcome
from shakedown.joint.doubtful_data import is_pulled_everywhere
from shakedown.joint.units import units_of
from shakedown.report.assessment_words import admissible_in_words, proved_up_to, start_in_words
from shakedown.report.node_words import open_in_words, slipping_nodes

if TYPE_CHECKING:
    from shakedown.assessment.runs import Run
    from shakedown.joint.problem import Problem
    from shakedown.long_term.energy_proof import EnergyProof
    from shakedown.long_term.simulation import Simulation

APART = "All nodes are open: the bodies separate."
SEPARATED = f"{APART} Is the sign of p_w right, or does an initial gap stay open?"
SEPARATION = (
    "Separation: within the period nodes open and close, and none slips while it is closed, except "
    "perhaps in a jump."
)


def separated_in_words(problem: Problem | None) -> str:
    """That the bodies separate; asks for the sign of the load unless :func:`doubtful_data` does."""
    return APART if problem is not None and is_pulled_everywhere(problem) else SEPARATED


def as_given_in_words(
    run: Run, unit: str = "", problem: Problem | None = None, universal: Bound | None = None
) -> str:
    """What becomes of the joint under the nominal load, with the unit of slips.

    With the problem, nodes are called by their labels; with the universal bound, the text says
    where shakedown is proved from every state.

    Examples
    --------
    >>> import shakedown
    >>> result = shakedown.verify(shakedown.example("two-node"), load_factors=[1.0], random_states=0)
    >>> print(as_given_in_words(result.as_given))
    At the nominal load (λ = 1), starting without slip, the joint slips in every cycle (node 1): cyclic
    slip, in the simulation.
    """
    state = run.simulation
    order = ", with the corners of the load domain in their order" * (
        problem is not None and problem.is_domain
    )
    start = start_in_words(run.initial != "zero")
    here = f"At the nominal load (λ = 1){order}, starting {start}, the joint"
    if state.separated:
        return separated_in_words(problem)
    slipping = open_in_words(slipping_nodes(state.slip_per_cycle), problem)
    if state.outcome == Outcome.SHAKEDOWN:
        kept = f" with {open_in_words(state.open_nodes, problem)} open" if len(state.open_nodes) else ""
        return f"{here} shakes down{kept}: {_certainty(state, unit, problem, universal)}."
    if state.slides_away:
        return f"{here} does not hold: {sliding_in_words(state)}."
    words = {
        Outcome.CYCLIC_SLIP: f"slips in every cycle ({slipping}): cyclic slip, in the simulation.",
        Outcome.RATCHETTING: f"slips on and on in every cycle ({slipping}): ratchetting, in the simulation.",
        Outcome.SEPARATION: f"is in separation, in the simulation: {state.reason}.",
        Outcome.UNDECIDED: f"is undecided: {state.reason}.",
    }
    return f"{here} {words[state.outcome]}"


def start_remark(run: Run) -> str:
    """A remark on an initial state: whether nodes are open in it, or whether it follows the transient."""
    if run.open_nodes:
        return " (zone)"
    return " (after)" * run.case.after_transient


def sliding_in_words(run: Simulation) -> str:
    """That the body slides away, and when, in the words of the simulation."""
    from shakedown.motion.cycle_record import SLIDES_AWAY  # compiled code stands behind it

    return run.reason.replace(SLIDES_AWAY, f"{SLIDES_AWAY} (gross slip)", 1)


def _certainty(state: Simulation, unit: str, problem: Problem | None, universal: Bound | None) -> str:
    """Whether shakedown at λ = 1 is proved, and how far the state at rest may be disturbed."""
    everywhere = proved_up_to(universal) > 1
    from_all = f"from every initial state {admissible_in_words(universal)}"
    if not state.proved or state.long_term is None:
        return f"simulated; it is proved {from_all}" if everywhere else "simulated, not proved"
    proved = f"proved, and so it is {from_all} (λ = 1 < λ_U)" if everywhere else "proved"
    return f"{proved}. {margin_at_rest(state, unit, problem)}"


def without_margin_in_words(proof: EnergyProof, unit: str) -> str:
    """What proves shakedown where no energy ball does; without a full stop.

    Examples
    --------
    >>> from shakedown.long_term.energy_proof import EnergyProof
    >>> without_margin_in_words(EnergyProof(True, cycles=2, by="λ_S", further=0.5), "mm")
    'After 2 cycles no node can slip more than 0.5 mm in all, in whatever order the loads come'
    """
    if proof.by == "λ_S":
        begins = f"After {count(proof.cycles, 'cycle')}" if proof.cycles else "From its start on"
        most = f"{up(proof.further, FEW_DIGITS)} {unit}".rstrip()
        return f"{begins} no node can slip more than {most} in all, in whatever order the loads come"
    if proof.by == "λ_E":
        return "The load lies below λ_E of its initial state"
    return "Each of its uncoupled parts is proved to shake down by itself"


def margin_at_rest(state: Simulation, unit: str, problem: Problem | None = None) -> str:
    """How far slips may deviate from those at rest, one node at a time or together; without a full stop."""
    from shakedown.long_term.energy_proof import held_by_friction  # compiled code stands behind it

    if state.long_term is not None and np.isnan(state.long_term.single_node_margin):
        return without_margin_in_words(state.long_term.proof_found, unit)
    if state.long_term is None or np.isinf(state.long_term.single_node_margin):
        return "This remains true whatever displaces the nodes from their final slips"
    found = state.long_term
    one, most = found.single_node_margin, inf
    if not found.open_nodes:
        most = held_by_friction(found.problem, found.load_factor, found.final_slip)
    if one >= most:
        held = f"{up(most, FEW_DIGITS)} {unit}".rstrip()
        return (
            "This remains true if any one node is displaced from its final slip as far as friction can hold "
            f"it there (up to {held}), all others in place"
        )
    work = units_of(problem).work
    energy_unit = f"√({work})" if work else ""
    one_node, all_nodes = (
        f"{down(margin, FEW_DIGITS)} {name}".rstrip()
        for margin, name in ((one, unit), (found.energy_margin, energy_unit))
    )
    return (
        f"This remains true if any one node is displaced from its final slip by up to {one_node}, all others "
        f"in place, or several nodes by {all_nodes} in the energy norm"
    )
