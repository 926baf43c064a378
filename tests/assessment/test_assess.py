"""The three numbers of a joint: those of its bounds, each computed once, and what follows from them."""

from dataclasses import replace

import numpy as np
import pytest
from joints_in_space import random_joint

import shakedown
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from benchmarks.problems import random_problem
from shakedown.assessment.every_limit import admitted_up_to
from shakedown.bounds import accumulated_bound as accumulated_module
from shakedown.bounds import upper as upper_module
from shakedown.ground.status import LimitsVerdict
from shakedown.joint.constraints import loading
from tests.joints import any_joint

TWO, THREE, BLOCK = (shakedown.example(name) for name in ("two-node", "three-node", "block-9"))
RECEDING = shakedown.example("receding-block")


def random_joint_of_two(_, seed):
    return random_joint(np.random.default_rng(seed), 2)


@pytest.mark.parametrize("problem", [TWO, THREE, BLOCK])
def test_the_numbers_are_those_of_the_bounds(problem):
    found = shakedown.assess(problem)
    lower, energy = shakedown.lower_bound(problem, certify=True), shakedown.energy_bound(problem)
    every = shakedown.universal_bound(problem, first_collapse=lower)
    upper = shakedown.upper_bound(problem)
    assert found.proved_from_every_state == every.load_factor
    slip = shakedown.accumulated_bound(problem)
    assert found.proved_from_this_state == np.fmax(energy.load_factor, slip.load_factor)
    above = upper.load_factor if upper.certified is None else upper.certified[1]
    assert found.impossible_above == max(above, upper.load_factor)
    assert found.details.lower == lower


def test_a_state_known_to_a_distance_has_what_its_ball_proves():
    found = shakedown.assess(shakedown.example("pair-cycle"), distance=1.0)
    assert found.proved_from_this_state == found.details.energy.load_factor < found.proved_from_every_state


@pytest.mark.parametrize("seed", range(3))
def test_what_is_proved_and_what_is_impossible_is_so(seed):
    rng = np.random.default_rng(seed)
    problem = any_joint(rng)
    slip = rng.normal(size=problem.n) * (seed % 2)
    found = shakedown.assess(problem, slip, open_nodes=())
    every, here, above = (
        found.proved_from_every_state,
        found.proved_from_this_state,
        found.impossible_above,
    )
    assert max(every, here) <= above * (1 + 1e-9)
    if 0 < here < np.inf:
        for share in (0.5, 0.999):
            state = shakedown.long_term_state(problem, share * here, slip)
            assert (state.outcome, state.open_nodes) == (shakedown.Outcome.SHAKEDOWN, ())
    if above < np.inf:
        state = shakedown.long_term_state(problem, 1.01 * above + 1e-3, slip)
        assert state.outcome != shakedown.Outcome.SHAKEDOWN or state.open_nodes
    assert found.verdict != LimitsVerdict.SHAKEDOWN or found.as_given == shakedown.Outcome.SHAKEDOWN


@pytest.mark.parametrize("exponent", [3, 9, 30])
@pytest.mark.parametrize("number", range(4))
def test_no_claim_refutes_another_however_small_friction_is(number, exponent):
    """What is proved at any friction is not above what is proved to be impossible there, by not one bit."""
    makers = (drawn_joint, drawn_joint_in_space, lambda _, seed: random_problem(2, seed), random_joint_of_two)
    problem = makers[number](5, exponent % 3)
    problem = replace(problem, f=10.0**-exponent * np.broadcast_to(problem.f, problem.n))
    found = shakedown.assess(problem, open_nodes=())
    limits, above = found.details, found.impossible_above
    proved = [found.proved_from_every_state, found.proved_from_this_state]
    proved += [limits.energy.load_factor, limits.accumulated.load_factor]
    assert not any(each > above for each in proved)
    assert above > 0.0 or limits.upper.status == "infeasible" or not problem.f.any()


def test_a_proof_that_certified_numbers_refute_is_withdrawn(monkeypatch):
    """As round-off may leave it: λ_S 1e-6 above the exact λ_max."""
    above = (1.0 + 1e-6) * shakedown.upper_bound(TWO).load_factor
    wrong = replace(shakedown.accumulated_bound(TWO), load_factor=above)
    monkeypatch.setattr(accumulated_module, "accumulated_bound", lambda *_: wrong)
    found = shakedown.assess(TWO, open_nodes=())
    withdrawn = found.details.accumulated
    assert (withdrawn.status, np.isnan(withdrawn.load_factor)) == ("undecided", True)
    assert "round-off decides" in withdrawn.reason
    assert not found.proved_from_this_state > found.impossible_above


def test_a_bound_in_floats_that_a_proof_refutes_is_withdrawn(monkeypatch):
    problem = shakedown.example("two-node-3d")
    every, upper = shakedown.universal_bound(problem), shakedown.upper_bound(problem)
    for factor, status in ((1.0 - 1e-9, "optimal"), (0.99, "undecided")):
        wrong = replace(upper, load_factor=factor * every.load_factor, certified=None, uncertified="too soft")
        monkeypatch.setattr(upper_module, "upper_bound", lambda *_, wrong=wrong, **__: wrong)
        found = shakedown.assess(problem)
        assert found.details.upper.status == status
        assert not found.proved_from_every_state > found.impossible_above
    assert np.isnan(found.impossible_above)
    assert "shakedown is proved up to" in found.details.upper.reason


def test_every_state_is_one_that_the_first_load_admits_after_the_transient():
    here = admitted_up_to(THREE, np.zeros(3))
    loop = loading(THREE)
    q, p = loop.at(here)
    assert np.max(np.abs(q[0]) - THREE.f * p[0]) == pytest.approx(0.0, abs=1e-9 * np.abs(p).max())
    far = 100.0 * np.ones(3)
    assert admitted_up_to(THREE, far) == 0.0
    moved = shakedown.assess(THREE, far)
    assert moved.proved_from_this_state < moved.proved_from_every_state
    before = replace(TWO, q_transient=[[15.8, -400.0]], p_transient=[[588.5, 1300.0]])
    limits = shakedown.assess(before).details
    known = [getattr(limits, name).load_factor for name in ("energy", "accumulated")]
    assert shakedown.assess(before).proved_from_this_state == np.fmax.reduce(known)


def test_of_open_nodes_nothing_is_excluded_and_the_bounds_do_not_decide():
    found = shakedown.assess(RECEDING)
    assert found.details.open_nodes
    assert (found.impossible_above, found.verdict) == (np.inf, LimitsVerdict.OPEN)
    closed = shakedown.assess(RECEDING, open_nodes=())
    assert (closed.impossible_above, closed.verdict) == (0.0, LimitsVerdict.IMPOSSIBLE)


def test_one_joint_has_one_transient_limit():
    limits = shakedown.assess(TWO).details
    verified = shakedown.verify(TWO, load_factors=[1.0], random_states=0).transient
    swept = shakedown.sweep(TWO, {"f": [0.35]}, bounds=["transient"])
    finer = shakedown.transient_limit(TWO)
    assert limits.transient == verified
    assert swept.transient[0] == pytest.approx(verified.load_factor, rel=1e-14)
    assert verified.low <= finer.low * (1 + 1e-14)
    assert finer.high <= verified.high * (1 + 1e-14)
