"""Pictures of maps: what is drawn is what the map says."""

import numpy as np
import pytest

import shakedown
from shakedown import plot

JOINT = shakedown.example("two-node")


@pytest.fixture(scope="module")
def grid():
    return shakedown.initial_state_map(JOINT, 0.7, states=400, sampler="grid")


def words(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_cells_have_the_dissipation_of_their_states(grid):
    axes = plot.basin(grid)
    resting, *_, moving = axes.collections
    cycling, rows = grid.outcome == "cyclic-slip", np.arange(len(grid)) >= len(grid.sampling.named)
    np.testing.assert_array_equal(moving.get_array().compressed(), grid.dissipation[cycling & rows])
    assert resting.get_array().count() == grid.outcomes["shakedown"]


def test_states_anywhere_are_dots():
    found = shakedown.initial_state_map(JOINT, 0.7, states=200, sampler="ball", reach=3.0)
    axes = plot.basin(found)
    drawn = sum(len(collection.get_offsets()) for collection in axes.collections)
    assert drawn == 200


def apart(n):
    """Nodes that do not feel each other; node 0 opens and closes, node 1 stays where it is put."""
    p_w = np.ones((4, n))
    p_w[:, 0] = [1.0, -1.0, -2.0, -1.0]
    return shakedown.Problem(
        A=np.eye(n), B=np.zeros((n, n)), C=np.eye(n), f=0.5, q_w=np.zeros((4, n)), p_w=p_w
    )


def test_separation_has_a_colour_of_its_own():
    found = shakedown.initial_state_map(apart(2), 1.0, states=36, sampler="grid")
    assert found.outcomes == {"separation": 36}
    axes = plot.basin(found)
    assert "separation: opens and closes, no slip in contact" in words(axes)
    assert len(axes.figure.axes) == 1  # no colour bar of dissipations
    (drawn,) = [image for image in axes.collections if image.get_array().count()]
    assert drawn.get_array().count() == 36
