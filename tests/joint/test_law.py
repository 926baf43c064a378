"""Coulomb's law as an interval and as a disc: limits, violation, the nearest allowed reaction."""

import numpy as np
import pytest

from shakedown.joint.law import Law, Layout

N, STATES = 4, 200


def drawn(d: int, seed: int = 0) -> tuple[Law, np.ndarray, np.ndarray]:
    """A law of some nodes, one of them without friction, and random reactions (…, dn), (…, n)."""
    rng = np.random.default_rng(seed)
    f = rng.uniform(0.1, 1.5, N)
    f[-1] = 0.0
    return Law(f, d), rng.normal(size=(STATES, d * N)), rng.uniform(0.0, 2.0, (STATES, N))


def turned(q: np.ndarray, node: int, angle: float) -> np.ndarray:
    """Reactions (…, 2n) in another tangent frame of one node."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    parts = q.reshape(*q.shape[:-1], -1, 2).copy()
    parts[..., node, :] = parts[..., node, :] @ turn.T
    return parts.reshape(q.shape)


@pytest.mark.parametrize("d", [1, 2])
def test_no_allowed_reaction_is_nearer_than_the_projection(d):
    law, q, p = drawn(d)
    nearest = law.projection(q, p)
    assert law.excess(nearest, p).max() <= 1e-15
    rng = np.random.default_rng(1)
    away = law.size(q - nearest)
    for _ in range(200):  # any allowed reaction: a direction, and a share of f p
        direction = rng.normal(size=q.shape)
        direction /= np.repeat(law.size(direction), d, axis=-1)
        other = direction * np.repeat(rng.uniform(0.0, 1.0, p.shape) * law.limit(p), d, axis=-1)
        assert np.all(away <= law.size(q - other) + 1e-12)
    inside = law.excess(q, p) <= 0
    np.testing.assert_array_equal(law.size(q - nearest)[inside], 0.0)
    assert inside.any()
    assert not inside.all()


@pytest.mark.parametrize("d", [1, 2])
def test_the_terms_of_a_stiffness_are_those_of_the_side_where_they_add_up(d):
    law, q, p = drawn(d)
    A, B = (np.random.default_rng(3).normal(size=(each.shape[-1], 4)) for each in (q, p))
    rows = np.abs(law.stiffness(A, B))
    if d == 1:
        rows[: 2 * len(B)] = np.repeat(rows[: 2 * len(B)].reshape(-1, 2, 4).max(axis=1), 2, axis=0)
    np.testing.assert_allclose(law.stiffness_terms(A, B), rows, rtol=1e-13)


@pytest.mark.parametrize("d", [1, 2])
def test_no_reaction_is_allowed_in_tension(d):
    law, q, p = drawn(d)
    np.testing.assert_array_equal(law.projection(q, -p), 0.0)


@pytest.mark.parametrize("d", [1, 2])
def test_a_node_at_rest_breaks_the_law_only_outside_its_limit(d):
    law, q, p = drawn(d)
    violation = law.violation(q, p, np.zeros_like(q))
    inside = law.size(q) <= law.limit(p)
    assert np.all(violation[inside] <= 0)
    assert np.all(violation[~inside] > 0)


@pytest.mark.parametrize("d", [1, 2])
def test_slip_against_the_reaction_at_the_limit_keeps_the_law(d):
    law, q, p = drawn(d)
    slip = np.repeat(np.random.default_rng(2).uniform(0.1, 3.0, p.shape), d, axis=-1) * law.direction(q)
    at_limit = -law.direction(q) * np.repeat(law.limit(p), d, axis=-1)
    assert law.violation(at_limit, p, slip).max() <= 1e-15
    rubbing = law.limit(p) > 0.01
    assert np.all(law.violation(at_limit, p, -slip)[rubbing] > 0)  # along the reaction
    assert np.all(law.violation(0.9 * at_limit, p, slip)[rubbing] > 0)  # before the limit


def test_slip_across_the_reaction_breaks_the_law_by_that_much():
    law, p = Law(np.array([0.5]), 2), np.array([2.0])
    q, across = np.array([-1.0, 0.0]), np.array([0.0, 3.0])
    assert law.violation(q, p, across) == pytest.approx(np.sqrt(2.0))
    assert law.violation(q, p, 1e-3 * across) == pytest.approx(3e-3)


def test_along_one_direction_a_disc_is_the_interval():
    plane, q, p = drawn(1)
    space, flat = Law(plane.f, 2), np.zeros((STATES, 2 * N))
    flat[:, ::2] = q
    slip = np.random.default_rng(3).normal(size=q.shape)
    moved = np.zeros_like(flat)
    moved[:, ::2] = slip
    np.testing.assert_allclose(space.excess(flat, p), plane.excess(q, p), atol=1e-15)
    np.testing.assert_allclose(space.projection(flat, p)[:, ::2], plane.projection(q, p), atol=1e-15)
    found, expected = space.violation(flat, p, moved), plane.violation(q, p, slip)
    np.testing.assert_allclose(np.maximum(found, 0), np.maximum(expected, 0), atol=1e-15)


@pytest.mark.parametrize("angle", [0.3, 2.0, -1.2])
def test_the_tangent_frame_of_a_node_does_not_matter(angle):
    law, q, p = drawn(2)
    slip = np.random.default_rng(4).normal(size=q.shape)
    again = turned(q, 1, angle)
    np.testing.assert_allclose(law.excess(again, p), law.excess(q, p), atol=1e-14)
    found = law.violation(again, p, turned(slip, 1, angle))
    np.testing.assert_allclose(found, law.violation(q, p, slip), atol=1e-14)
    np.testing.assert_allclose(law.projection(again, p), turned(law.projection(q, p), 1, angle), atol=1e-14)
    np.testing.assert_allclose(law.direction(again), turned(law.direction(q), 1, angle), atol=1e-14)


@pytest.mark.parametrize("d", [1, 2])
def test_the_cone_holds_the_reactions_that_the_law_allows(d):
    law, q, p = drawn(d)
    rows = law.cone(q, p)
    s = law.of_nodes(rows)
    inside = s.min(axis=-1) >= 0 if d == 1 else np.linalg.norm(s[..., 1:], axis=-1) <= s[..., 0]
    np.testing.assert_array_equal(inside, law.excess(q, p) <= 0)
    np.testing.assert_array_equal(rows[:, law.rows * N :], p[:, law.f == 0.0])  # no limit says p >= 0 there
    np.testing.assert_array_equal(law.load_terms(q, p), -law.cone(q, p))
    rng = np.random.default_rng(5)
    A, B, v = rng.normal(size=(d * N, d * N)), rng.normal(size=(N, d * N)), rng.normal(size=d * N)
    np.testing.assert_allclose(law.stiffness(A, B) @ v, law.load_terms(A @ v, B @ v), atol=1e-13)


@pytest.mark.parametrize("d", [1, 2])
def test_every_slip_and_gap_has_one_place(d):
    layout = Layout(3, d)
    u = np.arange(layout.size)
    slips, gaps = layout.split(u)
    np.testing.assert_array_equal(layout.joined(slips, gaps), u)
    assert len(slips) == d * 3
    assert len(gaps) == 3
    np.testing.assert_array_equal(np.sort(np.r_[layout.slips_of([2, 0, 1]), layout.gaps_of([2, 0, 1])]), u)
    some = layout.of_nodes([2, 0])
    one, other = Layout(2, d).split(u[some])
    np.testing.assert_array_equal(one, layout.by_node(slips)[[2, 0]].ravel())
    np.testing.assert_array_equal(other, gaps[[2, 0]])
