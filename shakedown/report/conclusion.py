"""The answer for the nominal load: its colour, its agreement with simulations, its limits of validity."""

from shakedown.assessment.verify import Verification
from shakedown.ground.shown_values import count
from shakedown.ground.status import Outcome
from shakedown.joint.problem import Problem
from shakedown.report.assessment_words import IN_CONTACT
from shakedown.report.hint_words import LOAD_DOMAIN
from shakedown.report.node_words import open_in_words

ASSUMPTIONS = (
    "Assumed: loads change slowly (quasi-static); Coulomb friction, with one constant coefficient per node "
    "for sticking and slipping; linear elastic bodies; small displacements"
)
NOT_SAID = "Nothing is said about the strength of the material, wear, or fretting fatigue."


def banner_class(v: Verification) -> str:
    """The colour of the banner: green only where the joint shakes down, red where it slips for ever.

    Runs at other load factors that are left open do not colour the answer for the nominal one.
    """
    run = v.as_given.simulation
    elsewhere = sum(
        each.simulation.outcome == Outcome.UNDECIDED and each.simulation.load_factor != run.load_factor
        for each in v.runs
    )
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
        return f"The bounds predict no outcome of any of the {runs} runs: there is nothing to agree with."
    if judged == runs:
        return f"Prediction and time integration agree in all {runs} runs."
    return (
        f"Prediction and time integration agree in all {judged} runs for which the bounds predict "
        f"an outcome ({runs} runs in all)."
    )


def _paths_in_words(problem: Problem, plane: bool) -> str:
    """For which paths through the load steps the numbers hold."""
    if problem.is_domain:
        return LOAD_DOMAIN
    others = "λ_1, λ_U, λ_box" if plane else "λ_U"
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
            f"{'λ_1, λ_U, λ_box' if plane else 'λ_U'} and λ_S hold while all nodes stay in contact."
        )
    if problem.C is None:
        zone += " The problem has no normal stiffness C: whether nodes open and close again is not followed."
    start = "zero slip" if problem.initial_slip is None else "the first given slip"
    states = (
        f"Initial states: λ = 1, λ_E{', λ_box' * plane}, λ_S and λ_T start from {start} in contact. "
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
