"""What the report says beside an outcome."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.ground.shown_values import down, up
from shakedown.motion.cycle_record import Stop
from shakedown.report.answer_words import banner_class, margin_of_answer, verdict_in_words
from shakedown.report.assessment_words import quickly_in_words
from shakedown.report.bound_words import bounds_in_words
from shakedown.report.friction_words import critical_in_words
from shakedown.report.limit_words import transient_in_words, transient_limit_as_text
from shakedown.report.page_tables import remarks
from shakedown.report.run_words import as_given_in_words, margin_at_rest
from shakedown.report.zone_words import zone_in_words
from tests.altered import with_limits


def test_jumps_open_nodes_and_proof_are_told():
    jumping = shakedown.simulate(shakedown.example("one-node-separation"), 1.0)
    assert remarks(jumping) == " (jumps per cycle: 1, damping dissipates 0.4048)"
    proved = shakedown.simulate(shakedown.example("two-node"), 0.5)
    assert remarks(proved) == " (proved)"
    apart = shakedown.Problem(A=[[1.0]], B=[[0.0]], C=[[1.0]], f=0.5, q_w=[[0.0]], p_w=[[-1.0]])
    assert remarks(shakedown.simulate(apart, 1.0)) == " (open throughout: node 0)"
    cycling = shakedown.simulate(shakedown.example("two-node"), 1.0)
    assert remarks(cycling) == ""


def test_the_document_of_a_simulation_tells_friction_from_jumps():
    document = shakedown.simulate(shakedown.example("one-node-separation"), 1.0).to_dict()
    parts = document["friction_dissipation_per_cycle"] + document["jump_dissipation_per_cycle"]
    assert document["dissipation_per_cycle"] == parts
    assert (document["jumps_per_cycle"], document["open_nodes"], document["proved"]) == (1.0, [], False)
    assert document["energy_margin"] is None
    stepped = shakedown.simulate(shakedown.example("two-node"), 1.0, method="gauss-seidel")
    assert stepped.to_dict()["jumps_per_cycle"] is None


def sliding() -> shakedown.Problem:
    """No stiffness against a rigid shift, and at λ = 1 more load than friction."""
    return shakedown.Problem(
        A=[[1.0, -1.0], [-1.0, 1.0]], B=np.zeros((2, 2)), C=np.eye(2), f=0.5,
        q_w=[[-2.0, -2.0], [2.0, 2.0]], p_w=np.ones((2, 2)),
    )  # fmt: skip


def test_a_body_that_slides_away_is_a_negative_answer() -> None:
    v = shakedown.verify(sliding(), load_factors=[1.0], random_states=0)
    said = as_given_in_words(v.as_given, "mm", v.problem, v.limits.universal)
    assert "the joint does not hold: the body slides away (gross slip) " in said
    assert "undecided" not in said
    assert banner_class(v) == "disagree"
    assert "the body slides away" in verdict_in_words(v)
    assert "Open" not in verdict_in_words(v)
    assert v.as_given.simulation.outcome == "undecided"
    assert not v.agrees


def test_the_verdict_counts_every_finding_that_stands_below_it() -> None:
    v = shakedown.verify(sliding(), load_factors=[1.0], random_states=0)
    found = replace(v, disagreements=("one",), open_questions=(*v.open_questions, "two", "three"))
    runs = len(v.open_questions)
    sliding_runs = "1 run" if runs == 1 else f"{runs} runs"
    assert verdict_in_words(found) == (
        f"DISAGREEMENT: 1 finding. In {sliding_runs} the joint does not hold: the body slides away. "
        "Open: 2 questions."
    )
    assert verdict_in_words(replace(found, open_questions=v.open_questions)).count("Open") == 0


def test_what_is_proved_from_every_state_is_said_of_the_loading_as_given() -> None:
    joint = half_load()
    v = shakedown.verify(joint, load_factors=[1.0], random_states=0)
    said = as_given_in_words(v.as_given, "", joint, v.limits.universal)
    assert "proved, and so it is from every initial state with all nodes in contact and within" in said
    assert "displaced from its final slip" in said
    assert "in the energy norm" in said
    assert "lies below λ_U" in " ".join(bounds_in_words(v.limits))
    lower = {name: replace(getattr(v.limits, name), load_factor=1.01) for name in ("energy", "accumulated")}
    assert "31.47 % larger, proved, 46.31 % in the simulation" in margin_of_answer(with_limits(v, **lower))
    assert "larger from every state and" in margin_of_answer(v)


def test_a_margin_beyond_what_friction_holds_is_not_said_in_lengths_that_no_slip_has() -> None:
    """The flange hardly couples its nodes: its ball has a radius of metres, friction holds micrometres."""
    flange = shakedown.example("bolted-flange")
    found = shakedown.simulate(flange, 1.0)
    assert found.long_term.single_node_margin > 1000.0
    stiffness, limits = flange.A.reshape(24, 2, 24, 2), flange.f * flange.p_w.max(axis=0)
    own = [np.linalg.eigvalsh(stiffness[i, :, i])[0] for i in range(24)]
    largest = max(2.0 * limit / least for limit, least in zip(limits, own, strict=True))
    said = margin_at_rest(found, "mm", flange)
    assert float(said.split("up to ")[1].split(" mm")[0]) == pytest.approx(largest, rel=1e-3)


def half_load() -> shakedown.Problem:
    """The two-node joint with half the varying load."""
    joint = shakedown.example("two-node")
    mean_q, mean_p = joint.q_w.mean(axis=0), joint.p_w.mean(axis=0)
    return replace(joint, q_w=mean_q + (joint.q_w - mean_q) / 2, p_w=mean_p + (joint.p_w - mean_p) / 2)


def test_between_proof_and_collapse_nothing_is_called_certain() -> None:
    joint = shakedown.example("three-node")
    limits = shakedown.assess(joint).details
    first = bounds_in_words(limits)[0]
    assert first.startswith(f"Between λ_U = {down(limits.universal.load_factor)} and λ_1 = 3.096 ")
    assert "shakedown is not proved from every initial state (guarantee of λ_1: evidence)" in first


def test_the_state_found_above_the_limit_is_named() -> None:
    limit = shakedown.transient_limit(shakedown.example("two-node"), accuracy=1e-3)
    assert "cyclic slip was found" in transient_in_words(limit)
    outcomes = tuple(
        shakedown.Outcome.SEPARATION if x == limit.cycling else o
        for x, o in zip(limit.scanned, limit.outcomes, strict=True)
    )
    apart = limit.but(outcomes=outcomes, at_high=replace(limit.at_high, opened=np.array([True, False])))
    assert "separation was found (node 0 opens and closes, no slip in contact)" in transient_in_words(apart)
    assert "cycle was found" not in transient_in_words(apart)
    assert "undecided" not in transient_in_words(limit)
    slow = limit.but(
        at_high=replace(limit.at_high, outcome=shakedown.Outcome.UNDECIDED, cycles_simulated=1000)
    )
    assert "; just above λ_T it is undecided after 1000 cycles (" in transient_in_words(slow)
    slides = slow.but(at_high=replace(slow.at_high, slides_away=True))
    assert "; just above λ_T the body slides away (" in transient_in_words(slides)
    cut = slow.but(
        at_high=replace(slow.at_high, stop=Stop("the computation allowed is spent", 0.5, -1, spent=True)),
    )
    assert "; just above λ_T nothing is known, as the computation allowed is spent (" in transient_in_words(
        cut
    )
    above = f"after 1000 cycles, and yet proved to shake down below λ = {down(1.1 * slow.load_factor)} ("
    assert above in transient_in_words(slow, proved_below=1.1 * slow.load_factor)
    assert "and yet" not in transient_in_words(slow, proved_below=slow.load_factor)


def test_a_free_body_is_told_why_no_subset_is_regular() -> None:
    joint = sliding()
    found, bounds = shakedown.critical_load_factors(joint), shakedown.shakedown_bounds(joint)
    said = " ".join(critical_in_words(found, found.total, bounds))
    assert "Only friction holds this body" in said
    assert "None of them is positive" not in said
    assert "λ_max = " in said


@pytest.mark.parametrize("value", [1.3276878539, 0.65, 1.9, 1e-7, 123456.7891])
def test_a_rounded_limit_is_never_on_the_wrong_side(value: float) -> None:
    assert float(down(value)) <= value <= float(up(value))
    assert float(up(value)) - float(down(value)) <= 1.0001e-6 * value


def test_what_rests_on_a_stiffness_of_unknown_accuracy_says_so_first():
    """Whether this joint can move as a whole is not clear: seven digits would leave as much."""
    A, B = np.array([[1.0, -1.0], [-1.0, 1.0 + 1e-7]]), np.array([[0.2, -0.2], [0.1, -0.1]])
    loads = {"q_w": [[1.0, 0.0], [0.0, 1.0]], "p_w": np.full((2, 2), 3.0)}
    unclear = shakedown.Problem(A=A, B=B, f=0.4, **loads)
    energy, upper = shakedown.energy_bound(unclear), shakedown.upper_bound(unclear)
    assert energy.certified is None
    assert "give stiffness_accuracy" in energy.uncertified
    first, about = quickly_in_words(energy, upper, unclear)
    assert "proved" in first
    assert about.startswith("All of this is in doubt: a rigid motion of a body meets")
    clear = replace(unclear, stiffness_accuracy=1e-7)
    assert len(quickly_in_words(energy, upper, clear)) == 1


def test_a_zone_in_which_nothing_was_found_has_no_limit_to_speak_of():
    block = shakedown.example("receding-block")
    upper = shakedown.upper_bound(block, open_nodes=(0,))
    none = replace(upper, status=shakedown.Status.UNDECIDED, load_factor=np.nan, reason="none was tried")
    assert zone_in_words(none, block) == ["No safe slip was found at any load factor: none was tried."]


def test_where_shakedown_is_proved_the_simulated_limit_is_not_cut_below_that():
    limit = shakedown.transient_limit(shakedown.example("two-node"))
    near = limit.but(load_factor=0.7315934, high=0.7315939, proved=np.nan)
    assert transient_limit_as_text(near) == "0.731593"
    assert transient_limit_as_text(near.but(proved=near.load_factor)) == "0.7315934"
    short = near.but(load_factor=0.15742009, low=0.15742009, high=0.1575, proved=0.15740009)
    assert transient_limit_as_text(short.but(proved=np.nan)) == "0.1574"
    assert transient_limit_as_text(short) == "0.15742"  # not below what is proved
