"""Appendix A above the critical friction, and the transient limit, each against an independent method."""

import numpy as np
import pytest

import shakedown


@pytest.mark.parametrize(
    ("name", "outcome"), [("one-node-separation", "separation"), ("one-node-cyclic", "cyclic-slip")]
)
def test_melan_fails_above_the_critical_friction(name, outcome):
    problem = shakedown.example(name)
    assert problem.f[0] > shakedown.friction_thresholds(problem).single_node[0]
    cycling, safe = problem.initial_slip
    assert shakedown.long_term_state(problem, 1.0, cycling).outcome == outcome
    assert shakedown.long_term_state(problem, 1.0, safe).outcome == "shakedown"


def test_separation_and_stick_alternate_without_slip_between_jumps():
    problem = shakedown.example("one-node-separation")
    state = shakedown.long_term_state(problem, 1.0, problem.initial_slip[0])
    assert set(state.history.state[:, 0]) == {0, 2}
    assert state.slip_per_cycle[0] == 0
    # by hand: it closes where the apex (−A v, −B v) of the sector is on the path q_w = 1
    closed = state.history.v[state.history.state[:, 0] == 0]
    assert np.unique(closed.round(12)) == pytest.approx([-1.0])


def test_cyclic_slip_visits_slip_and_separation():
    problem = shakedown.example("one-node-cyclic")
    state = shakedown.long_term_state(problem, 1.0, problem.initial_slip[0])
    assert state.opened[0]
    assert state.open_nodes == ()
    assert set(state.history.state[:, 0]) == {0, -1, 2}
    assert state.residual <= 1e-12


def test_transient_limit_is_where_gauss_seidel_changes_its_mind():
    problem = shakedown.example("two-node")
    limit = shakedown.transient_limit(problem, accuracy=1e-6)
    assert limit.high - limit.low <= 2e-6
    assert limit.at_low.outcome == "shakedown"
    assert limit.at_high.outcome == "cyclic-slip"
    outcomes = [
        shakedown.simulate(problem, limit.load_factor * x, method="gauss-seidel").outcome
        for x in (0.999, 1.001)
    ]
    assert outcomes == ["shakedown", "cyclic-slip"]


def test_transient_limit_lies_between_the_bounds_and_scans_what_it_says():
    problem = shakedown.example("two-node")
    bounds = shakedown.shakedown_bounds(problem)
    limit = shakedown.transient_limit(problem, bounds.upper.slip, steps=20, accuracy=1e-8)
    assert limit.load_factor == pytest.approx(bounds.upper.load_factor, rel=1e-6)
    assert len(limit.scanned) == len(limit.outcomes) >= 21
    assert np.all(np.diff(limit.scanned) > 0)


def test_transient_limit_of_a_state_with_open_nodes_is_that_of_its_zone():
    problem = shakedown.example("cylinder-on-flat")
    upper = shakedown.upper_bound(problem, open_nodes="auto")
    assert upper.open_nodes
    limit = shakedown.transient_limit(
        problem, upper.slip, open_nodes=upper.open_nodes, steps=8, accuracy=1e-5
    )
    assert limit.load_factor == pytest.approx(upper.load_factor, rel=2e-5)
    assert limit.at_low.open_nodes == upper.open_nodes
    assert 0.999 * upper.load_factor < limit.proved <= upper.load_factor < limit.cycling
    with pytest.raises(shakedown.UsageError, match="open nodes"):
        shakedown.transient_limit(problem, open_nodes=[13], largest=1.0)


def test_transient_limit_below_everything_is_nan_and_above_everything_open():
    problem = shakedown.example("two-node")
    far = shakedown.transient_limit(problem, largest=0.3, steps=3)
    assert (far.low, far.high) == (0.3, np.inf)
    floating = shakedown.example("one-node-separation")
    with pytest.raises(shakedown.UsageError, match="largest"):
        shakedown.transient_limit(floating)
    with pytest.raises(shakedown.UsageError, match="steps"):
        shakedown.transient_limit(problem, steps=0)
    with pytest.raises(shakedown.UsageError, match="accuracy"):
        shakedown.transient_limit(problem, accuracy=0.0)
