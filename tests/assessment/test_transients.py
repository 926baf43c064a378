"""Transient load steps come first: nothing is predicted from a slip that they destroy."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.ground.shown_values import down
from shakedown.joint.constraints import through_transient
from shakedown.long_term.motion_start import arrives_closed
from shakedown.motion.evolution import evolve
from shakedown.report.limit_facts import limit_sections
from tests.joints import joint_of_kind

TWO = shakedown.example("two-node")
# Pushes both nodes far over their limits: from no safe slip between the bounds does it leave anything.
DESTROYED = replace(TWO, q_transient=[[-1293.0, -1382.0]], p_transient=[[790.0, 2417.0]])
GENTLE = replace(TWO, q_transient=[[15.8, -400.0]], p_transient=[[588.5, 1300.0]])  # the mean load
# Node 1 is pulled off and set down again before the first period.
LIFTED = replace(TWO, q_transient=[[15.8, -400.0], [15.8, 0.0]], p_transient=[[588.5, -900.0], [588.5, 5.0]])


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
    (run,) = [r for r in report.runs if r.region == "between" and r.initial == "safe"]
    assert (run.after_transient, run.predicted, run.agrees) == (True, "shakedown", True)
    assert run.to_dict()["after_transient"] is True


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
    assert not any(run.after_transient for run in report.runs)
    for run in report.runs:
        if run.initial == "safe" and run.region != "above λ_max":
            assert through_transient(GENTLE).relative_excess(run.start, run.load_factor).max() <= 1e-9


@pytest.mark.parametrize("seed", range(3))
def test_a_slip_that_is_safe_through_the_transient_stays_where_it_is(seed):
    rng = np.random.default_rng(seed)
    problem = replace(joint_of_kind(rng, "loose"), f=0.4)
    k, n = 2, problem.n
    p_mean = 4.0 + np.abs(problem.p_w)
    problem = replace(
        problem, p_w=p_mean, q_transient=0.3 * rng.normal(size=(k, n)), p_transient=p_mean[:1].repeat(k, 0)
    )
    upper, lasting = shakedown.upper_bound(problem), shakedown.upper_bound(problem, transient=True)
    assert lasting.load_factor <= upper.load_factor * (1 + 1e-9)
    assert through_transient(problem).excess(lasting.slip, lasting.load_factor).max() <= 1e-9 * p_mean.max()
    if not (np.isfinite(lasting.load_factor) and lasting.load_factor > 0):
        return
    safe = shakedown.safe_slip(problem, 0.9 * lasting.load_factor, transient=True)
    run = evolve(problem, 0.9 * lasting.load_factor, safe.slip, cycles=2)
    assert sum(cycle.slip.max() for cycle in run.cycles) <= 1e-9 * max(np.abs(safe.slip).max(), 1e-3)
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
