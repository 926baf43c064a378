"""Verification of partly open joints and of load domains: no prediction is believed unsupported.

Transient load steps come first: nothing is predicted from a slip that they destroy.
"""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import verify
from shakedown.assessment.plan import OUTSIDE
from shakedown.ground.shown_values import down
from shakedown.joint.constraints import through_transient
from shakedown.joint.contact_zone import contact_zone
from shakedown.long_term.motion_start import arrives_closed
from shakedown.motion.evolution import evolve
from shakedown.report.facts import notes, sheet_as_text
from shakedown.report.limit_facts import decided_by, limit_sections
from shakedown.report.run_facts import verify_sheet
from tests.command import document, run
from tests.joints import joint_of_kind
from tests.partly_open import SOME, partly_open, zone_bound

RECEDING = shakedown.example("receding-block")
TWO = shakedown.example("two-node")
DOMAIN = replace(TWO, load_path="domain")
# Pushes both nodes far over their limits: from no safe slip between the bounds does it leave anything.
DESTROYED = replace(TWO, q_transient=[[-1293.0, -1382.0]], p_transient=[[790.0, 2417.0]])
GENTLE = replace(TWO, q_transient=[[15.8, -400.0]], p_transient=[[588.5, 1300.0]])  # the mean load
# Node 1 is pulled off and set down again before the first period.
LIFTED = replace(TWO, q_transient=[[15.8, -400.0], [15.8, 0.0]], p_transient=[[588.5, -900.0], [588.5, 5.0]])


@pytest.mark.parametrize("seed", SOME[2:3])
def test_predictions_of_zones_agree(seed):
    problem = partly_open(seed)
    result = verify(problem, random_states=1)
    upper = result.limits.upper
    assert not result.disagreements
    in_zone = [one for one in result.runs if one.open_nodes]
    if upper.status == "optimal" and upper.open_nodes:
        assert len(in_zone) >= 2
        assert all(one.predicted == "shakedown" and one.agrees for one in in_zone)
        assert all(one.simulation.open_nodes == upper.open_nodes for one in in_zone)
        beyond = [one for one in result.runs if one.region == OUTSIDE]
        assert beyond
        assert {one.predicted for one in beyond if not one.simulation.proved} <= {"either"}


def test_the_receding_block_is_predicted_and_agrees():
    result = verify(RECEDING, random_states=0, load_factors=[0.1, 0.3])
    judged = [(one.initial, one.agrees) for one in result.runs if one.agrees is not None]
    assert judged == [("safe", True)]
    assert result.second.upper.load_factor == pytest.approx(result.limits.upper.load_factor, rel=1e-7)
    assert not result.disagreements


def test_a_wrong_zone_is_reported_not_believed():
    result = verify(RECEDING, random_states=0, open_nodes=[16])
    assert result.limits.upper.status == "infeasible"
    assert all(one.agrees is None for one in result.runs)
    shown = {each.label: each.shown for each in decided_by(result.assessment)}
    assert (shown["open nodes"], shown["safe slip"]) == ("node 16 (FE 144)", "none")


def test_a_zone_that_was_not_found_is_an_open_question(monkeypatch):
    """Shakedown in another zone neither agrees with "slips or opens" nor contradicts it."""
    problem, known = partly_open(SOME[0]), zone_bound(SOME[0])
    closed = contact_zone(problem, ())
    monkeypatch.setattr("shakedown.bounds.upper.chosen_zone", lambda *given: (closed, True))
    missed = verify(problem, random_states=0, load_factors=[0.5 * known.load_factor])
    monkeypatch.setattr("shakedown.bounds.upper.chosen_zone", lambda *given: (closed, False))
    denied = verify(problem, random_states=0, load_factors=[0.5 * known.load_factor])
    unsearched = verify(problem, random_states=0, load_factors=[0.5 * known.load_factor], open_nodes=())
    for report in (missed, denied, unsearched):
        state = report.runs[1].simulation
        assert (state.outcome, state.open_nodes) == ("shakedown", known.open_nodes)
        assert not report.agrees
    assert missed.runs[1].predicted == "either"
    assert any(question.startswith("λ_max is open: no contact zone") for question in missed.open_questions)
    assert (denied.runs[1].predicted, denied.runs[1].agrees) == ("slips or opens", False)
    assert unsearched.runs[1].agrees is None
    assert any("a zone that λ_max is not about" in question for question in unsearched.open_questions)


@pytest.fixture(scope="module")
def of_domain():
    return shakedown.verify(DOMAIN, random_states=1)


def test_predictions_end_where_every_path_is_proved(of_domain):
    assert of_domain.agrees, of_domain.disagreements
    assert of_domain.limits.lower.guarantee == "evidence"
    proved = of_domain.limits.universal.load_factor
    assert proved < of_domain.limits.lower.load_factor
    for found in of_domain.runs:
        if found.region == "below λ_U":
            assert found.simulation.load_factor < proved
            assert found.predicted == "shakedown"
        elif found.region == "between" and not found.proved and found.initial != "safe":
            assert found.predicted == "either"
    assert {found.region for found in of_domain.runs} == {"below λ_U", "between", "above λ_max"}


def test_it_is_said_for_which_paths_the_limits_hold(of_domain):
    text = " ".join(sheet_as_text(verify_sheet(of_domain, details=True)).split())
    for note in (notes.load_domain, notes.one_path):
        assert text.count(note) == 1
    assert "all corners passed" in text
    assert "load domain of 50 corners" in text
    assert of_domain.to_dict()["problem"]["load_path"] == "domain"


def test_the_commands_say_it(tmp_path):
    path = str(tmp_path / "domain.npz")
    shakedown.save_problem(path, DOMAIN)
    text = run("solve", path, "--details")[1]
    assert "load domain of 50 corners" in text
    assert "λ_U from every state 0.6035" in " ".join(text.split())
    assert "least pressures" in text
    found = document("solve", path)
    assert found["problem"]["load_path"] == "domain"
    assert found["lower"]["guarantee"] == "evidence"
    assert found["universal"]["argument"] == "least pressures"
    said = " ".join(run("simulate", path, "--load-factor", "0.5")[1].split())
    assert "simulated in the order given: one path of many." in said


def test_a_sweep_of_a_domain_keeps_it():
    found = shakedown.sweep(DOMAIN, {"f": [0.35]}, bounds=("lower", "universal"))
    (point,) = found.points
    assert point["guarantee"] == "evidence"
    assert point["universal"]["load_factor"] == pytest.approx(0.6035788, abs=1e-7)
    assert np.isfinite(point["lower"]["load_factor"])


def between(problem):
    bounds = shakedown.shakedown_bounds(problem)
    low, high = bounds.lower.load_factor, bounds.upper.load_factor
    return low + 0.3 * (high - low)


def test_a_safe_slip_that_the_transient_destroys_is_not_predicted_to_shake_down():
    load_factor = between(DESTROYED)
    slip = shakedown.safe_slip(DESTROYED, load_factor).slip
    assert shakedown.simulate(DESTROYED, load_factor, slip).outcome == "cyclic-slip"
    report = shakedown.verify(DESTROYED, random_states=1)
    assert report.agrees, report.disagreements
    (found,) = [one for one in report.runs if one.region == "between" and one.initial == "safe"]
    assert (found.after_transient, found.predicted, found.agrees) == (True, "shakedown", True)
    assert found.to_dict()["after_transient"] is True


def test_it_is_said_what_the_transient_leaves():
    for joint, there in ((DESTROYED, True), (GENTLE, True), (TWO, False)):
        found = shakedown.assess(joint)
        _, about, _ = limit_sections(found)
        told = [each.shown for each in about.facts if each.label == "safe in the transient"]
        assert len(told) == there
        if there and (before := found.details.through_transient).status == "infeasible":
            assert told == ["none"]
        elif there:
            assert told == [f"up to λ = {down(before.load_factor, 4)}"]
    assert not shakedown.assess(DESTROYED).details.through_transient.load_factor > between(DESTROYED)


def test_a_gentle_transient_leaves_a_safe_slip_where_it_is():
    bounds = shakedown.shakedown_bounds(GENTLE)
    assert bounds.through_transient.load_factor == pytest.approx(bounds.upper.load_factor, rel=1e-12)
    assert bounds.to_dict()["through_transient"]["status"] == "optimal"
    assert shakedown.shakedown_bounds(TWO).through_transient is None
    report = shakedown.verify(GENTLE, random_states=1)
    assert report.agrees
    assert not any(one.after_transient for one in report.runs)
    for one in report.runs:
        if one.initial == "safe" and one.region != "above λ_max":
            assert through_transient(GENTLE).relative_excess(one.start, one.load_factor).max() <= 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_a_slip_that_is_safe_through_the_transient_stays_where_it_is(seed):
    rng = np.random.default_rng(seed)
    problem = replace(joint_of_kind(rng, "loose"), f=0.4)
    p_mean = 4.0 + np.abs(problem.p_w)
    before = {"q_transient": 0.3 * rng.normal(size=(2, problem.n)), "p_transient": p_mean[:1].repeat(2, 0)}
    problem = replace(problem, p_w=p_mean, **before)
    upper, lasting = shakedown.upper_bound(problem), shakedown.upper_bound(problem, transient=True)
    assert lasting.load_factor <= upper.load_factor * (1 + 1e-9)
    assert through_transient(problem).excess(lasting.slip, lasting.load_factor).max() <= 1e-9 * p_mean.max()
    if not (np.isfinite(lasting.load_factor) and lasting.load_factor > 0):
        return
    safe = shakedown.safe_slip(problem, 0.9 * lasting.load_factor, transient=True)
    path = evolve(problem, 0.9 * lasting.load_factor, safe.slip, cycles=2)
    assert sum(cycle.slip.max() for cycle in path.cycles) <= 1e-9 * max(np.abs(safe.slip).max(), 1e-3)
    above = shakedown.safe_slip(problem, 1.01 * lasting.load_factor, transient=True)
    assert above.status == "infeasible"


def test_open_nodes_are_those_of_a_state_after_the_transient():
    with pytest.raises(shakedown.UsageError, match="transient: expected all nodes closed, found 1 open"):
        shakedown.upper_bound(DESTROYED, open_nodes=[1], transient=True)


def test_nothing_is_predicted_of_a_state_that_arrives_with_a_node_open():
    assert not arrives_closed(replace(LIFTED, p_w=LIFTED.p_w - 3000.0), 0.1, np.zeros(2))
    assert arrives_closed(DESTROYED, 0.5, np.zeros(2))
    assert arrives_closed(TWO, 0.5, np.zeros(2))
    report = shakedown.verify(LIFTED, random_states=1)
    assert report.agrees, report.disagreements


def test_a_limit_that_asks_for_closed_nodes_contradicts_no_history_with_a_transient():
    """A sweep compares λ_T with λ_U: not where the transient may have opened nodes."""
    found = shakedown.sweep(LIFTED, {"f": [0.35]}, bounds=("universal", "transient"))
    assert found.contradictions == ()
