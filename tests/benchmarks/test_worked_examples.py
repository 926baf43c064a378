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
