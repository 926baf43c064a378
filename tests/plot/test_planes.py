"""Planes show what happened, and refuse what they cannot show."""

import numpy as np
import pytest

import shakedown
from shakedown import plot
from shakedown.joint.constraints import constraints
from shakedown.motion.evolution import evolve
from shakedown.plot.planes import loads_felt, stick_sector
from shakedown.programs import simplex


def texts(axes):
    return [text.get_text() for text in axes.get_legend().get_texts()]


def test_reaction_space_shows_states_and_sectors():
    problem = shakedown.example("one-node-separation")
    run = evolve(problem, 1.0, problem.initial_slip[0], cycles=3)
    shown = texts(plot.reaction_space(run, problem))
    assert {"stick", "open"} <= set(shown)
    assert "v = -1" in shown
    assert "backward slip" not in shown


@pytest.mark.parametrize("load_factor", [0.0, 0.3, 0.6573, 0.7, 0.73])
def test_the_safe_polygon_is_the_safe_region(load_factor):
    """Its corners are on two rows each and inside the others; random points agree with the rows."""
    rows = constraints(shakedown.example("two-node"))
    corners = simplex.corners(rows.G, rows.g - load_factor * rows.d)
    excess = corners @ rows.G.T + load_factor * rows.d - rows.g
    size = np.abs(rows.g).max()
    assert (np.sort(np.abs(excess), axis=1)[:, :2] < 1e-10 * size).all()
    assert (excess < 1e-10 * size).all()
    low, high = corners.min(axis=0), corners.max(axis=0)
    points = np.random.default_rng(0).uniform(low, high, (200, 2))
    edges = np.roll(corners, -1, axis=0) - corners
    left = edges[:, 0] * (points[:, None, 1] - corners[:, 1]) - edges[:, 1] * (
        points[:, None, 0] - corners[:, 0]
    )
    inside = (points @ rows.G.T + load_factor * rows.d <= rows.g).all(axis=1)
    assert np.array_equal((left >= 0).all(axis=1), inside)


@pytest.mark.parametrize("factor", [1.0, 1.3, 3.0])
def test_above_the_last_safe_slip_the_window_has_that_slip(factor):
    """Paths may end far away: the thesis draws the limits about the safe slip, figure 5.4 (d)."""
    problem = shakedown.example("two-node")
    last = shakedown.upper_bound(problem)
    load_factor = factor * last.load_factor * (1 + 1e-9)
    run = evolve(problem, load_factor, [3.0, 6.0], cycles=1)
    for results in ({}, {"path": run}):
        axes = plot.slip_space(problem, load_factor, results)
        for (low, high), slip in zip((axes.get_xlim(), axes.get_ylim()), last.slip, strict=True):
            assert low < slip < high
        assert "safe slip at λ_max" in texts(axes)
    below = plot.slip_space(problem, 0.7)
    assert "safe slip at λ_max" not in texts(below)


def test_the_load_is_on_the_edge_of_its_sector_where_the_node_slips():
    joint = shakedown.example("two-node")
    path = evolve(joint, 0.72, [1.5, 1.5]).history
    felt = loads_felt(joint, path, 1)
    for (tangential, normal), v, state in zip(felt, path.v[:, 1], path.state[:, 1], strict=True):
        apex = stick_sector(joint, 1, v, 1.0)[0]
        use = (tangential - apex[0]) / (joint.f[1] * (normal - apex[1]))
        assert abs(use) <= 1 + 1e-9
        assert not state or use == pytest.approx(state, abs=1e-9)
    assert path.state[:, 1].any()
