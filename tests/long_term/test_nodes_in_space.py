"""What nodes with two tangential directions go through."""

import csv

import numpy as np
import pytest
from scipy.spatial.distance import pdist, squareform

import shakedown
from shakedown import Problem
from shakedown.joint.places import corners_of_hull
from shakedown.long_term.node_results import farthest_apart


def circling(radius: float = 1.3, limit: float = 0.5) -> Problem:
    """One node whose welded reaction goes round a circle, fp = ``limit``, A = 2 I."""
    t = 2 * np.pi * np.arange(720)[:, None] / 720
    q_w = radius * np.hstack([np.cos(t), np.sin(t)])
    return Problem(A=2 * np.eye(2), B=np.zeros((1, 2)), f=limit, q_w=q_w, p_w=np.ones((720, 1)))


def test_a_node_that_goes_round_a_circle():
    """It slips on a circle of radius √(Q² − (fp)²)/A."""
    Q, limit = 1.3, 0.5
    nodes = shakedown.node_results(shakedown.long_term_state(circling(Q, limit), 1.0))
    radius = np.sqrt(Q**2 - limit**2) / 2
    assert nodes.status == ("slip",)
    assert nodes.slip_range[0] == pytest.approx(2 * radius, rel=1e-4)
    np.testing.assert_allclose(nodes.to_dict()["slip_range_x"], 2 * radius, rtol=1e-4)
    np.testing.assert_allclose(nodes.slip_range_of_directions, 2 * radius, rtol=1e-4)
    assert nodes.accumulated_slip[0] == pytest.approx(2 * np.pi * radius, rel=1e-4)
    assert nodes.work[0] == pytest.approx(2 * np.pi * radius * limit, rel=1e-4)
    assert nodes.q_max[0] == pytest.approx(limit, rel=1e-9)


def test_the_works_add_up_and_files_have_the_components(tmp_path):
    problem = shakedown.example("four-node-3d")
    state = shakedown.long_term_state(problem, 1.5)
    nodes = shakedown.node_results(state)
    assert nodes.work.sum() == pytest.approx(state.dissipation_per_cycle, rel=1e-9)
    assert np.all(nodes.slip_range >= nodes.slip_range_of_directions.max(axis=1) * (1 - 1e-12))
    assert np.all(2 * nodes.slip_range <= nodes.accumulated_slip * (1 + 1e-9) + 1e-6)
    nodes.save(tmp_path / "nodes.csv")
    with open(tmp_path / "nodes.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    np.testing.assert_allclose(
        [float(row["slip_range_y"]) for row in rows], nodes.slip_range_of_directions[:, 1]
    )
    assert [row["status"] for row in rows] == list(nodes.status)


def test_a_limit_on_the_slip():
    problem = shakedown.example("two-node-3d")
    run = shakedown.simulate(problem, 1.0, slip_below=1e-3)
    assert run.slip_criterion.met is False
    assert run.slip_criterion.largest == pytest.approx(shakedown.node_results(run).slip_range.max())


def test_a_node_that_stays_open():
    """It does not slip in contact, and the others are as without it."""
    alone = circling()
    problem = Problem(
        A=2 * np.eye(4),
        B=np.zeros((2, 4)),
        C=np.eye(2),
        f=0.5,
        q_w=np.hstack([alone.q_w, 0.1 * alone.q_w]),
        p_w=np.hstack([alone.p_w, -alone.p_w]),
    )
    nodes = shakedown.node_results(shakedown.long_term_state(problem, 1.0))
    assert nodes.status == ("slip", "open")
    assert nodes.slip_range[0] == pytest.approx(np.sqrt(1.3**2 - 0.5**2), rel=1e-4)
    assert (nodes.slip_range[1], nodes.accumulated_slip[1], nodes.work[1]) == (0, 0, 0)


PATHS = {
    "cloud": lambda rng, s: rng.normal(size=(s, 2)),
    "walk": lambda rng, s: np.cumsum(rng.normal(size=(s, 2)), axis=0),
    "line": lambda rng, s: np.outer(rng.normal(size=s), [0.3, -0.7]),
    "ellipse": lambda rng, s: np.column_stack([np.cos(np.arange(s)), 1e-3 * np.sin(np.arange(s))]),
    "few": lambda rng, s: rng.normal(size=(3, 2))[rng.integers(3, size=s)],
}


@pytest.mark.parametrize("kind", PATHS)
def test_diameters_are_those_of_all_pairs(kind):
    rng = np.random.default_rng(0)
    for s, size in ((1, 1.0), (2, 1e-90), (7, 1e80), (300, 1.0), (500, 1e-6)):
        places, time = size * PATHS[kind](rng, s), np.cumsum(rng.integers(1, 4, size=s))
        apart = squareform(pdist(places)) if s > 1 else np.zeros((1, 1))
        corners = corners_of_hull(places)
        whole = farthest_apart(corners, np.full(len(corners), len(corners)))
        assert np.hypot(*whole) == pytest.approx(apart.max(), rel=1e-12, abs=0)
        for window in (1, 5, 200, 5000):
            near = apart[np.abs(time[:, None] - time) < window].max()
            found = farthest_apart(places, np.searchsorted(time, time + window))
            assert np.hypot(*found) == pytest.approx(near, rel=1e-12, abs=1e-15 * apart.max())
