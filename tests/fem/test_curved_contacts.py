"""Contacts that turn, by less and by more than half a turn, and closed ones: their order, lengths and edges."""

from dataclasses import replace

import numpy as np
import pytest
from skfem import MeshQuad

from shakedown.fem import ElasticBody, Material, Pressure, Support, contact_problem
from shakedown.joint.contact_surface import surface_of

STEEL = Material(210e3, 0.3)
COUNT, RADIUS, BORE = 24, 40.0, 32.0


def sector(turn=360.0, *, start=0.0, inner=BORE, outer=RADIUS, count=COUNT, bottom="outer"):
    """A ring, or a part of it, from quadrilaterals; its boundary called bottom is the outer or the inner one."""
    closed = turn == 360.0
    angle = np.radians(start + turn * np.arange(count + (not closed)) / count)
    radius = np.array([inner, (inner + outer) / 2, outer])
    around = np.stack([np.cos(angle), np.sin(angle)])
    places = (radius[:, None, None] * around.T).reshape(-1, 2).T
    k = np.arange(len(radius) * len(angle)).reshape(len(radius), -1)
    after = np.roll(k, -1, axis=1)
    parts = [part[:, : None if closed else -1] for part in (k[:-1], k[1:], after[1:], after[:-1])]
    mesh = MeshQuad(places, np.stack(parts).reshape(4, -1))
    sides = {
        "outer": lambda x: np.hypot(*x) > 0.97 * outer,
        "inner": lambda x: np.hypot(*x) < 1.03 * inner,
        "both": lambda x: np.abs(np.hypot(*x) - (inner + outer) / 2) > 0.4 * (outer - inner),
    }
    free = "inner" if bottom == "outer" else "outer"
    return mesh.with_boundaries({"bottom": sides[bottom], "top": sides[free]})


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
