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


@pytest.mark.parametrize("seed", range(1, 12))
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


def test_tractrix_to_first_order():
    """A = 2, f p = 0.4: q = f p (cos φ, sin φ), φ = 2 arctan tanh(1/(2 f p)) after a load of 1 across."""
    angle = 2.0 * np.arctan(np.tanh(1.0 / 0.8))
    exact = (0.4 * np.array([np.cos(angle), np.sin(angle)]) - [0.4, 1.0]) / 2.0
    np.testing.assert_allclose(exact, [-0.167385753614, -0.302677140370], atol=1e-12)
    ends = []
    for parts in (50, 100, 200):
        joint = ImplicitJoint(2.0 * np.eye(2), np.zeros((1, 2)), None, np.array([0.4]), 1.0)
        joint.begin(np.zeros(2), np.zeros(1), np.array([0.4, 0.0]), np.ones(1))
        ends.append(joint.follow(np.array([[0.4, 1.0]]), np.ones((1, 1)), parts).v[0])
    errors = [np.abs(end - exact).max() for end in ends]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.02)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.01)
    np.testing.assert_allclose(2 * ends[2] - ends[1], exact, atol=0.02 * errors[2])  # extrapolated


def test_of_two_solutions_the_connected_one():
    """A = 1, B = (2, 0), f = 1, q = (0.75, 0), p = 1: it may stick, or slip by (−0.25, 0) at q = p = 0.5."""
    B = np.array([[2.0, 0.0]])
    joint = ImplicitJoint(np.eye(2), B, 5.0 * np.eye(1), np.ones(1), 1.0)
    done = joint.step(np.array([0.75, 0.0]), np.ones(1))
    np.testing.assert_array_equal(done.v, 0.0)
    other = np.array([-0.25, 0.0])
    q, p = np.array([0.75, 0.0]) + other, 1.0 + B @ other
    np.testing.assert_allclose(q, -p * other / 0.25)


def test_a_closing_node_sticks_where_it_touches():
    """One node, B = 0, C = A = 1, free at (0, 0.5) under p = −0.5; then pressed while q moves it: v = −½·0.6."""
    joint = ImplicitJoint(np.eye(2), np.zeros((1, 2)), np.eye(1), np.array([10.0]), 1.0)
    opened = joint.step(np.zeros(2), np.array([-0.5]))
    np.testing.assert_array_equal(opened.w, [[0.5]])
    done = joint.step(np.array([0.6, 0.0]), np.array([0.5]))
    np.testing.assert_allclose(done.v, [[-0.3, 0.0]], atol=1e-13)
    np.testing.assert_array_equal(done.w, 0.0)
    np.testing.assert_array_equal(done.length, 0.0)


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


@pytest.mark.parametrize("f", [0.5, 2.0])
def test_far_above_the_thresholds_a_step_is_solved_or_says_that_it_is_not(f):
    """Stiffnesses of bad condition, friction of any size: whatever is called solved satisfies the law."""
    unsolved = 0
    for seed in range(30):
        rng, n = np.random.default_rng(seed), 1 + seed % 9
        root = rng.normal(size=(3 * n, 3 * n))
        kappa = root @ root.T + 0.1 * np.eye(3 * n)
        A, B, C = kappa[: 2 * n, : 2 * n], kappa[2 * n :, : 2 * n], kappa[2 * n :, 2 * n :]
        q, p = course(n, 30, seed, 0.5)
        done = carried(A, B, C, np.full(n, f), q, p)
        good = done._replace(v=done.v[: done.solved], w=done.w[: done.solved], slip=done.slip[: done.solved])
        if done.solved:
            assert violation(A, B, C, np.full(n, f), q[: done.solved], p[: done.solved], good)[1] < 1e-10
        unsolved += done.solved < len(q)
        assert done.solved == len(q) or done.residual > 1e-12
    assert unsolved <= (0 if f < 1 else 5)
