"""Contacts that turn, open and closed, and rolling elements in a ring: order, lengths, edges, laws of mechanics."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshQuad

from shakedown import ProblemError
from shakedown.fem import ElasticBody, Material, Pressure, RollingLoad, Support, contact_problem, ring_mesh
from shakedown.joint.contact_surface import surface_of
from shakedown.joint.places import strips

STEEL = Material(210e3, 0.3)
COUNT, RADIUS, BORE = 24, 40.0, 32.0


def sector(turn=360.0, *, start=0.0):
    """A ring, or a part of it, from quadrilaterals; its outer boundary is called bottom."""
    closed = turn == 360.0
    angle = np.radians(start + turn * np.arange(COUNT + (not closed)) / COUNT)
    radius = np.array([BORE, (BORE + RADIUS) / 2, RADIUS])
    around = np.stack([np.cos(angle), np.sin(angle)])
    places = (radius[:, None, None] * around.T).reshape(-1, 2).T
    k = np.arange(len(radius) * len(angle)).reshape(len(radius), -1)
    after = np.roll(k, -1, axis=1)
    parts = [part[:, : None if closed else -1] for part in (k[:-1], k[1:], after[1:], after[:-1])]
    mesh = MeshQuad(places, np.stack(parts).reshape(4, -1))
    outer, inner = (lambda x: np.hypot(*x) > 0.97 * RADIUS), (lambda x: np.hypot(*x) < 1.03 * BORE)
    return mesh.with_boundaries({"bottom": outer, "top": inner})


def joint(mesh, **more):
    body = ElasticBody(mesh, STEEL, loads=[Pressure("top", 1.0, history=np.array([0.0, 1.0]))], **more)
    return contact_problem(body, "bottom", 0.3, gap=-0.01)


def angles(problem):
    return np.degrees(np.arctan2(problem.coordinates[:, 1], problem.coordinates[:, 0]))


@pytest.mark.parametrize("turn", [90.0, 200.0, 345.0, 360.0])
@pytest.mark.parametrize("order", [1, 2])
def test_positions_are_lengths_along_the_contact(turn, order):
    problem = joint(sector(turn, start=15.0), order=order)
    pieces = COUNT * order
    step = 2 * RADIUS * np.sin(np.radians(turn / COUNT / 2)) / order  # edges are straight
    np.testing.assert_allclose(problem.x, step * np.arange(pieces + (turn < 360.0)), rtol=1e-12)
    assert np.all(np.abs(np.diff(np.unwrap(angles(problem), period=360.0))) < 1.5 * turn / pieces)


@pytest.mark.parametrize("turn", [200.0, 345.0, 360.0])
def test_the_ends_are_those_of_the_mesh(turn):
    """Also where the ends of an open ring are nearer to each other than two nodes elsewhere."""
    surface = surface_of(joint(sector(turn)))
    assert np.flatnonzero(surface.edge).tolist() == ([] if turn == 360.0 else [0, COUNT])


@pytest.mark.parametrize("turn", [90.0, 200.0, 360.0])
def test_without_edges_a_node_is_followed_by_the_nearest_ahead(turn):
    """Nodes in any order, of two strips that face each other."""
    problem = joint(sector(turn))
    count, order = problem.n, np.random.default_rng(0).permutation(2 * problem.n)
    places = np.vstack([problem.coordinates, 0.97 * problem.coordinates])[order]
    found = strips(places, np.vstack([problem.tangent, -problem.tangent])[order])
    assert len(found) == 2
    for strip in found:
        nodes = order[strip] % count
        way = 1 if order[strip[0]] < count else -1
        first = nodes[0] if turn == 360.0 else (count - 1 if way < 0 else 0)
        np.testing.assert_array_equal(nodes, (first + way * np.arange(count)) % count)


@pytest.mark.parametrize("order", [1, 2])
def test_a_narrow_slit_is_no_element(order):
    problem = joint(sector(345.0 + 7.5), order=order)
    assert surface_of(problem).edge.sum() == 2
    assert not surface_of(replace(problem, node_area=None)).edge.any()  # places alone do not tell


@pytest.mark.parametrize("turn", [90.0, 200.0, 360.0])
def test_it_is_the_same_joint_wherever_it_begins(turn):
    """By steps of half an element and less, for which sums of normals round differently."""
    expected = joint(sector(turn))
    for start in (3.0, 7.5, 90.0, 123.0):
        found = joint(sector(turn, start=start))
        np.testing.assert_allclose(found.x, expected.x, rtol=1e-12)
        size = np.abs(expected.kappa).max()
        np.testing.assert_allclose(found.kappa, expected.kappa, rtol=0, atol=1e-9 * size)


def test_a_held_node_opens_a_ring():
    mesh = sector()
    held = lambda x: (np.hypot(*x) > 0.97 * RADIUS) & (np.abs(np.arctan2(x[1], x[0])) < 2 * np.pi / COUNT)  # noqa: E731
    problem = joint(mesh.with_boundaries({"held": held}), supports=[Support("held")])
    assert problem.n == COUNT - 3
    assert np.flatnonzero(surface_of(problem).edge).tolist() == [0, problem.n - 1]
    assert np.all(np.diff(problem.x) > 0)


def ring(around, order=1, **more):
    return ElasticBody(ring_mesh(35.0, 40.0, around, 2), STEEL, plane="stress", order=order, **more)


def test_a_ring_in_a_rigid_housing_bears_the_pressure_of_lame():
    body = ring(96, 2, loads=[Pressure("inside", 0.0, history=1.0)])
    joint = contact_problem(body, "outside", 0.2, gap=-1e-3, steps=1)
    stiffness = STEEL.young / 40.0 / ((40.0**2 + 35.0**2) / (40.0**2 - 35.0**2) - 0.3)
    assert joint.p_w.sum() / joint.node_area.sum() == pytest.approx(1e-3 * stiffness, rel=2e-3)
    assert np.abs(joint.q_w).max() < 1e-9 * joint.p_w.max()


@pytest.mark.parametrize(("around", "order"), [(20, 1), (20, 2), (33, 1)])
@pytest.mark.parametrize("half_width", [0.02, 6.0])
def test_rolling_elements_press_with_their_force_on_any_mesh(around, order, half_width):
    body, load = ring(around, order), RollingLoad("inside", 3e3, elements=7, half_width=half_width)
    for t in (0.0, 0.37):
        nodal = load.nodal(body, t)
        at = 2 * np.pi * (np.arange(7) + t) / 7
        # the resultant of a half ellipse over an arc: 2 J₁(b/R) R/b of a force at its middle
        force = 3e3 * np.clip(np.cos(at), 0, None) ** 1.5 * (1 - (half_width / 35.0) ** 2 / 8)
        expected = [(force * np.cos(at - np.pi / 2)).sum(), (force * np.sin(at - np.pi / 2)).sum()]
        assert nodal.reshape(-1, 2).sum(axis=0) == pytest.approx(expected, abs=1e-4 * force.max())
        assert load.nodal(body, t + 1.0) == pytest.approx(nodal, abs=1e-9 * force.max())
        mirrored = replace(load, backwards=True).nodal(body, t).reshape(-1, 2).sum(axis=0)
        there = nodal.reshape(-1, 2).sum(axis=0)
        assert mirrored == pytest.approx([-there[0], there[1]], abs=1e-9 * force.max())


def test_the_work_of_rolling_elements_converges_with_the_mesh():
    load, work = RollingLoad("inside", 3e3, elements=7, half_width=0.3), []
    for around in (24, 48, 96, 192):
        body = ring(around)
        x, y = body.basis.doflocs[:, ::2]
        along = np.column_stack([x * y, y**2 - x]).ravel() / 35.0
        work.append(load.nodal(body, 0.3) @ along)
    steps = np.abs(np.diff(work))
    assert steps[0] / steps[2] > 10  # of order 2 on average: 16; it depends on where the facets end


def test_an_inner_ring_is_pressed_inwards_and_what_is_no_raceway_is_refused():
    body = ring(24)
    above = RollingLoad("outside", 1e3, elements=5, half_width=0.3)  # the middle element, at −90°
    assert above.nodal(body, 0.0).reshape(-1, 2).sum(axis=0)[1] > 0
    with pytest.raises(ProblemError, match="expected a circle about"):
        replace(above, centre=(1.0, 0.0)).nodal(body, 0.0)
    with pytest.raises(ProblemError, match="half_width: expected less than"):
        replace(above, half_width=30.0).nodal(body, 0.0)
    with pytest.raises(ProblemError, match="steps: needed"):
        contact_problem(replace(body, loads=[above]), "inside", 0.1)
    with pytest.raises(ProblemError, match="radii 0 < inside < outside"):
        ring_mesh(40.0, 35.0, 24, 2)


@pytest.mark.parametrize("around", [3, 8])
def test_a_coarse_ring_has_both_boundaries(around):
    boundaries = ring_mesh(35.0, 40.0, around, 2).boundaries
    assert {name: len(facets) for name, facets in boundaries.items()} == {"inside": around, "outside": around}
