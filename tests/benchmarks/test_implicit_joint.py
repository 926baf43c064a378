"""One implicit load step with two tangential directions: closed forms, the law, other methods, units, failures."""

import numpy as np
import pytest

from benchmarks.implicit_joint import ImplicitJoint
from shakedown.joint.law import Law, Layout
from shakedown.motion.checked_law import Scales, law_violation
from shakedown.motion.fixed_steps import contact_nodes, load_steps, places_by_node


def blocks(n, seed, coupling=1.0):
    """A, B, C of a random joint; ``coupling`` scales B."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3 * n, 3 * n))
    kappa = root @ root.T + 3 * n * np.eye(3 * n)
    return kappa[: 2 * n, : 2 * n], coupling * kappa[2 * n :, : 2 * n], kappa[2 * n :, 2 * n :]


def course(n, steps, seed, mean=3.0):
    """Welded reactions (k, 2n), (k, n) around a loop in space; a small mean opens nodes."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 4 * np.pi, steps)[:, None]
    q = rng.normal(size=2 * n) * np.cos(t) + rng.normal(size=2 * n) * np.sin(t)
    return 2.0 * q, mean + rng.normal(size=n) * np.cos(t) + rng.normal(size=n) * np.sin(2 * t)


def carried(A, B, C, f, q, p):
    joint = ImplicitJoint(A, B, C, f, max(np.abs(q).max(), np.abs(p).max()))
    return joint.follow(q, p)


def swept(layout, A, B, C, f, q, p):
    """Slips and gaps after, and slip in contact during load steps, by Gauss–Seidel."""
    at, loads, u = places_by_node(layout), layout.joined(q, p), np.zeros(layout.size)
    nodes = contact_nodes(layout, layout.of_blocks(A, B, C), f, True, 1.0)
    found, slip = np.empty_like(loads), np.empty_like(q)
    *_, failed, _ = load_steps(nodes, loads[:, at].copy(), u, 1e-14, 10_000, found, slip)
    assert failed < 0
    path = np.empty_like(found)
    path[:, at] = found
    return *layout.split(path), slip


def violation(A, B, C, f, q, p, done):
    """The law at every step from slips and gaps alone, and the distance of q from the disc at q − slip."""
    q, p = q + done.v @ A + done.w @ B, p + done.v @ B.T + done.w @ C
    force = max(np.abs(q).max(), np.abs(p).max())
    length = force / np.diag(A).min()
    q, slip = q / force, done.slip / length
    apart = np.abs(q - Law(f, 2).projection(q - slip, np.maximum(p / force - done.w / length, 0.0))).max()
    return law_violation(f, force * q, p, done.w, done.slip, Scales(force, length)).max(), apart


def test_a_node_alone_slips_by_what_exceeds_the_limit():
    q, p = np.array([[0.3, 0.4], [3.0, 4.0]]), np.array([[2.0], [2.0]])
    done = carried(4.0 * np.eye(2), np.zeros((1, 2)), np.eye(1), np.array([0.5]), q, p)
    np.testing.assert_array_equal(done.v[0], 0.0)
    np.testing.assert_allclose(done.v[1], [-0.6, -0.8], rtol=1e-14)  # (5 − 1)/4 against q
    np.testing.assert_allclose(done.work[1], [1.0], rtol=1e-14)


@pytest.mark.parametrize("seed", range(1, 5))
@pytest.mark.parametrize("mean", [4.0, 0.5])
def test_the_law_holds_at_every_step(seed, mean):
    n = seed
    (A, B, C), f = blocks(n, seed), np.random.default_rng(seed).uniform(0.1, 0.5, n)
    q, p = course(n, 40, seed, mean)
    done = carried(A, B, C, f, q, p)
    assert done.solved == len(q)
    met, apart = violation(A, B, C, f, q, p, done)
    assert apart < 1e-11
    assert met < np.sqrt(apart) + 1e-11  # of slips as small as that the direction is not known better
    assert done.residual < 1e-11
    assert (done.w > 0).any() or mean > 1
    assert (done.length > 0).any()


@pytest.mark.parametrize("mean", [4.0, 0.5])
def test_sweeps_alone_come_to_the_same(mean):
    (A, B, C), f = blocks(6, 3, 0.3), np.full(6, 0.3)
    q, p = course(6, 40, 3, mean)
    one, (v, w, slip) = carried(A, B, C, f, q, p), swept(Layout(6, 2), A, B, C, f, q, p)
    assert one.solved == len(q)
    np.testing.assert_allclose(v, one.v, atol=1e-9)
    np.testing.assert_allclose(w, one.w, atol=1e-9)
    np.testing.assert_allclose(slip, one.slip, atol=1e-9)


def test_of_two_solutions_the_connected_one():
    """A = 1, B = (2, 0), f = 1, q = (0.75, 0), p = 1: it may stick, or slip by (−0.25, 0) at q = p = 0.5."""
    B = np.array([[2.0, 0.0]])
    joint = ImplicitJoint(np.eye(2), B, 5.0 * np.eye(1), np.ones(1), 1.0)
    done = joint.step(np.array([0.75, 0.0]), np.ones(1))
    np.testing.assert_array_equal(done.v, 0.0)
    other = np.array([-0.25, 0.0])
    q, p = np.array([0.75, 0.0]) + other, 1.0 + B @ other
    np.testing.assert_allclose(q, -p * other / 0.25)


def test_a_node_that_may_not_open_is_not_in_tension():
    joint = ImplicitJoint(np.eye(4), np.zeros((2, 4)), None, np.full(2, 0.5), 1.0)
    done = joint.follow(np.zeros((2, 4)), np.array([[1.0, 1.0], [1.0, -0.1]]))
    assert done.solved == 1
    assert done.residual == pytest.approx(0.1)


def test_a_floating_block_cannot_open_as_a_whole():
    C = np.array([[1.0, -1.0], [-1.0, 1.0]])
    joint = ImplicitJoint(np.eye(4), np.zeros((2, 4)), C, np.full(2, 0.5), 1.0)
    done = joint.step(np.zeros(4), np.full(2, -0.1))
    assert done.solved == 0
    assert done.residual > 0.01
