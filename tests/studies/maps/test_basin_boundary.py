"""Boundaries between basins: on the apex line where that is predicted, and between two attractors."""

import numpy as np
import pytest

import shakedown
from shakedown.motion.checked_law import admissible


def test_of_admissible_states_it_is_the_apex_line():
    """The line v₁ = 0.65407 through the apex of the other node's rows, at λ = 0.70."""
    joint = shakedown.example("two-node")
    found = shakedown.initial_state_map(joint, 0.7, states=900, sampler="grid")
    points = shakedown.basin_boundary(found)
    inside = admissible(joint, 0.7, points)
    assert inside.sum() >= 5
    np.testing.assert_allclose(points[inside, 0], found.plane.apexes[1][0], atol=1e-7)
    assert found.plane.apexes[1][0] == pytest.approx(0.65407, abs=1e-5)


def test_between_two_attractors_either_side_leads_to_another_limit_cycle():
    joint = shakedown.example("two-attractors")
    found = shakedown.initial_state_map(joint, 1.0, states=100, sampler="grid")
    points = shakedown.basin_boundary(found)
    assert len(points) > 20
    ways = []
    for away in (-1e-6, 1e-6):
        for axis in np.eye(2):
            states = shakedown.long_term_states(joint, 1.0, points + away * axis)
            ways.append(states.dissipation > 2.0)
    assert (np.ptp(np.array(ways, dtype=int), axis=0) == 1).all()


def test_one_basin_has_no_boundary_and_only_a_grid_has_neighbours():
    joint = shakedown.example("two-node")
    whole = shakedown.initial_state_map(joint, 0.5, states=9, sampler="grid")
    assert shakedown.basin_boundary(whole).shape == (0, 2)
    with pytest.raises(shakedown.UsageError, match="expected a map on a grid, found sampler sobol"):
        shakedown.basin_boundary(shakedown.initial_state_map(joint, 0.5, states=4))
