"""Initial states of a map: each from the seed and its number alone, where it should be."""

import numpy as np
import pytest

import shakedown
from shakedown.studies.samplers import Sampler, Sampling

JOINT = shakedown.example("two-node")


@pytest.mark.slow
@pytest.mark.parametrize("sampler", Sampler)
def test_a_state_follows_from_its_number_alone(sampler):
    count = 81 if sampler == Sampler.TRANSIENTS else 144  # the first of them are simulated
    chosen = Sampling(JOINT, 0.7, sampler, states=count, seed=3)
    every = chosen.slips(0, count)
    assert every.shape == (chosen.states, 2)
    for start, stop in ((0, 1), (63, 65), (70, count)):
        np.testing.assert_array_equal(chosen.slips(start, stop), every[start:stop])
    more = Sampling(JOINT, 0.7, sampler, states=169, seed=3)
    if sampler != Sampler.GRID:
        np.testing.assert_array_equal(more.slips(0, count), every)
        assert (Sampling(JOINT, 0.7, sampler, states=count, seed=4).slips(0, 9) != every[:9]).any()


@pytest.mark.parametrize("sampler", [Sampler.GRID, Sampler.SOBOL])
def test_a_box_is_about_the_safe_slip_and_filled(sampler):
    chosen = Sampling(JOINT, 0.7, sampler, states=1024, reach=2.0)
    place = (chosen.slips(0, 1024) - shakedown.safe_slip(JOINT, 0.7).slip) / chosen.half_width
    assert np.abs(place).max() <= 1.0 + 1e-12
    assert np.abs(place.mean(axis=0)).max() < 0.01
    np.testing.assert_allclose((place**2).mean(axis=0), 1.0 / 3.0, atol=0.03)


@pytest.mark.parametrize("name", ["two-attractors", "two-node-3d"])
@pytest.mark.parametrize("sampler", [Sampler.GRID, Sampler.SOBOL])
def test_a_box_contains_the_named_states_and_what_loads_leave_behind(name, sampler):
    joint = shakedown.example(name)
    chosen = Sampling(joint, 1.1, sampler, states=16)
    left = Sampling(joint, 1.1, Sampler.TRANSIENTS, states=4).slips(0, 4)
    for slip in chosen.named.values():
        assert (np.abs(slip - chosen.centre) <= chosen.half_width * (1 + 1e-12)).all()
    assert (np.abs(left - chosen.centre) <= 1.5 * chosen.half_width).all()


def test_states_of_a_ball_are_uniform_in_it():
    chosen = Sampling(JOINT, 0.7, Sampler.BALL, states=4000, reach=1.5)
    share = chosen.ball.distance(chosen.slips(0, 4000)) / chosen.ball.radius
    assert share.max() <= 1.5 * (1 + 1e-12)
    assert (share < 0.75).mean() == pytest.approx(0.25, abs=0.03)


def test_what_a_transient_leaves_is_admissible_at_the_first_load():
    from shakedown.motion.checked_law import admissible

    slips = Sampling(JOINT, 0.7, Sampler.TRANSIENTS, states=64).slips(0, 64)
    assert admissible(JOINT, 0.7, slips).all()
    assert len(np.unique(slips.round(9), axis=0)) > 30


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ({"sampler": "monte-carlo"}, "sampler: expected one of grid, sobol, ball, transients"),
        ({"states": 0}, "states: expected a whole number from 1"),
        ({"seed": -1}, "seed: expected a whole number >= 0"),
        ({"reach": 0.0}, "reach: expected a number > 0"),
        ({"coordinates": (0, 0)}, "two different nodes from 0 to 1"),
        ({"coordinates": (0, 2)}, "two different nodes from 0 to 1"),
    ],
)
def test_what_cannot_be_sampled_is_said_in_one_line(words, said):
    with pytest.raises(shakedown.UsageError, match=said):
        Sampling(JOINT, 0.7, **words)
