"""Maps of joints with two tangential directions: single runs, and the plane."""

import numpy as np
import pytest
from command import refused, run

import shakedown

JOINT = shakedown.example("two-node-3d")


@pytest.fixture(scope="module")
def found():
    return shakedown.initial_state_map(JOINT, 0.98 * shakedown.upper_bound(JOINT).load_factor, states=8)


def test_it_agrees_bit_by_bit_with_single_states(found):
    for k in (0, 5):
        state = shakedown.long_term_state(JOINT, found.load_factor, found.initial_slip[k])
        assert (found.outcome[k], found.period[k]) == (state.outcome, state.period)
        assert found.signature[k] == state.signature
        np.testing.assert_array_equal(found.final_slip[k], state.final_slip)
        np.testing.assert_array_equal(found.slip_per_cycle[k], state.slip_per_cycle)
    assert found.initial_slip.shape == found.final_slip.shape == (len(found.sampling.named) + 8, 4)
    assert found.slip_per_cycle.shape == (len(found), 2)


@pytest.mark.parametrize("sampler", ["ball", "transients"])
def test_every_sampler_has_states(sampler):
    some = shakedown.initial_state_map(JOINT, 0.5, states=5, sampler=sampler, seed=3)
    np.testing.assert_array_equal(some.sampling.slips(4, 5), some.initial_slip[some.sampled][4:5])
    assert len(np.unique(some.initial_slip[:, 0])) > 1 or sampler == "transients"
    if sampler == "ball":
        assert (some.sampling.ball.distance(some.initial_slip) <= some.sampling.ball.radius).all()
        assert some.outcomes == {"shakedown": 5}


def test_the_command(tmp_path):
    words = ["map", "two-node-3d", "--load-factor", "0.5", "--states", "4", "-q"]
    code, text, err = run(*words, "--grid", "0:y", "1:x", "-o", "map.npz", cwd=tmp_path)
    assert (code, err) == (0, "")
    assert max(map(len, text.splitlines())) <= 80
    kept = np.load(tmp_path / "map.npz")["initial_slip"][-4:]
    assert [len(np.unique(column)) for column in kept.T] == [1, 2, 2, 1]
    for grid, line in (
        (["0", "1"], "--grid: expected NODE:x or NODE:y twice, as the joint has two directions, found 0 1"),
        (["0:x", "9:x"], "grid: expected two different slips (x0, y0, x1, y1, …) from 0 to 3, found (0, 18)"),
        (
            ["0:z", "1:x"],
            "--grid: expected NODE:x or NODE:y twice, as the joint has two directions, found 0:z 1:x",
        ),
    ):
        refused(*words, "--grid", *grid, cwd=tmp_path, message=line)
    code, _, err = run("map", "two-node", "--load-factor", "0.5", "--grid", "0:x", "1:x", "-q", cwd=tmp_path)
    assert code == 2
    assert "--grid: expected two node numbers, found 0:x 1:x" in err
