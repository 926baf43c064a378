"""The adversary of joints with two tangential directions: what it finds cycles, above what is proved."""

import numpy as np
import pytest
from command import run
from joints_in_space import in_units

import shakedown
from shakedown.motion.checked_law import admissible
from shakedown.studies.cycle_search import AttackingStates

JOINT = shakedown.example("one-node-3d")
FEW = {"states": 2, "rounds": 1, "accuracy": 1e-2}


@pytest.fixture(scope="module")
def found():
    return shakedown.smallest_cycle(JOINT, **FEW)


def test_what_is_found_cycles_between_what_is_proved_and_what_is_impossible(found):
    assert found.status == "found"
    assert found.limits.universal.load_factor <= found.load_factor <= 1.01 * found.limits.upper.load_factor
    state = shakedown.long_term_state(JOINT, found.load_factor, found.initial_slip)
    assert state.outcome == found.outcome == "cyclic-slip"
    assert state.dissipation_per_cycle > found.least_dissipation
    assert found.slipping_nodes == (0,)
    assert found.slip_per_cycle.shape == (1,)
    fine = shakedown.long_term_state(
        JOINT, found.load_factor, found.initial_slip, tolerances=shakedown.Tolerances(path=1e-11)
    )
    assert fine.dissipation_per_cycle == pytest.approx(state.dissipation_per_cycle, rel=1e-2)


def test_there_is_no_first_collapse(found):
    assert found.below_first_collapse is False
    assert found.to_dict()["lower"] is None
    assert not found.limits.lower


def test_units_do_not_matter():
    joint = shakedown.Problem(A=[[2, 0], [0, 2]], B=[[0, 0]], f=0.4, q_w=[[0.4, 0], [0.4, 1]], p_w=[[1], [1]])
    one, other = (shakedown.smallest_cycle(x, **FEW) for x in (joint, in_units(joint, 2.0**12, 2.0**-6)))
    assert one.status == "found"
    assert other.load_factor == pytest.approx(one.load_factor, rel=1e-9)
    np.testing.assert_allclose(other.initial_slip, one.initial_slip * 2.0**-6, rtol=1e-6)


@pytest.mark.parametrize("load_factor", [0.3, 1.2])
def test_states_are_drawn_within_the_discs_of_the_first_load_and_at_their_rim(load_factor):
    joint, tolerances = shakedown.example("four-node-3d"), shakedown.Tolerances()
    attack = AttackingStates(joint, np.zeros((1, 8)), np.random.default_rng(0), tolerances)
    drawn = attack.drawn(load_factor, 60)[1:]
    assert admissible(joint, load_factor, drawn, tolerances).all()
    middle = drawn.mean(axis=0)
    beyond = admissible(joint, load_factor, middle + 1.2 * (drawn[:24] - middle), tolerances)
    assert beyond.mean() < 0.2


def test_the_command(found, monkeypatch):
    monkeypatch.setattr(shakedown, "smallest_cycle", lambda *_, **__: found)
    code, text, err = run("adversary", "one-node-3d", "--rounds", "1", "--states", "2", "-q")
    assert (code, err) == (0, "")
    assert max(map(len, text.splitlines())) <= 80
    assert "first collapse" not in text
    assert "initial slip x" in text
    assert "initial slip y" in text
