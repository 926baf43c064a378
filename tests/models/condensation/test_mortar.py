"""Surfaces that do not match: constant pressures, rigid motions, trimmed edges, matching meshes, curved faces."""

import numpy as np
import pytest

from shakedown import ProblemError, ShakedownError
from shakedown.models.condensation.surface_coupling import surface_coupling
from shakedown.models.condensation.surface_mesh import ContactSurface, shapes

SIDES = (2.0, 1.5)


def grid(
    counts, first, into, *, triangles=False, skew=0.0, shift=0.0, middles=False, centres=False, unit=1.0
):
    """A rectangle in the plane z = 0, the body on the side of ``into``."""
    x, y = np.meshgrid(*(np.linspace(0, s, n + 1) for s, n in zip(SIDES, counts, strict=True)), indexing="ij")
    inner = (slice(1, -1), slice(1, -1))
    random = np.random.default_rng(first)
    x[inner] += skew * random.uniform(-1, 1, x[inner].shape) / counts[0]
    y[inner] += skew * random.uniform(-1, 1, y[inner].shape) / counts[1]
    places = [*np.column_stack([x.ravel() + shift, y.ravel(), np.zeros(x.size)])]
    number = np.arange(x.size).reshape(x.shape)
    quads = np.stack([number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]], -1).reshape(-1, 4)
    facets = [tuple(quad) for quad in quads.tolist()]
    if triangles:
        facets = [part for a, b, c, d in facets for part in ((a, b, c), (a, c, d))]
    if middles:
        facets = quadratic(facets, places, centres)
    inside = [np.mean([places[k] for k in facet], axis=0) + np.array([0, 0, into]) for facet in facets]
    labels, places, inside = first + np.arange(len(places)), unit * np.array(places), unit * np.array(inside)
    return ContactSurface(labels, places, [tuple(first + np.array(facet)) for facet in facets], inside)


def quadratic(facets, places, centres):
    between, found = {}, []
    for facet in facets:
        sides = []
        for a, b in zip(facet, facet[1:] + facet[:1], strict=True):
            if (key := frozenset((a, b))) not in between:
                between[key] = len(places)
                places.append((places[a] + places[b]) / 2)
            sides.append(between[key])
        middle = ()
        if centres:
            middle = (len(places),)
            places.append(np.mean([places[k] for k in facet], axis=0))
        found.append((*facet, *sides, *middle))
    return found


def areas(surface):
    """∫N of every node, by Gauss points on the facets themselves."""
    place, weight = np.polynomial.legendre.leggauss(4)
    total = np.zeros(len(surface.labels))
    for kind, nodes, _ in surface.blocks:
        s, t = (axis.ravel() for axis in np.meshgrid(place, place))
        w = np.outer(weight, weight).ravel()
        corners = 3 if kind[1] in (3, 6) else 4
        if corners == 3:
            s, t, w = (1 + s) / 2, (1 + t) * (1 - s) / 4, w * (1 - s) / 8
        points, step = np.column_stack([s, t]), 1e-6
        straight = [shapes((3, corners), points + step * axis) for axis in (np.eye(2)[0], -np.eye(2)[0])]
        across = [shapes((3, corners), points + step * axis) for axis in (np.eye(2)[1], -np.eye(2)[1])]
        sides = [
            (one - other) @ surface.places[nodes[:, :corners]] / (2 * step)
            for one, other in (straight, across)
        ]
        jacobian = np.linalg.norm(np.cross(*sides), axis=2)
        np.add.at(total, nodes, np.einsum("fg,g,gk->fk", jacobian, w, shapes(kind, points)))
    return total


CASES = {
    "quadrilaterals, 2:3": ({"counts": (2, 2)}, {"counts": (3, 4)}),
    "quadrilaterals, 3:2": ({"counts": (3, 4)}, {"counts": (2, 2)}),
    "skewed": ({"counts": (3, 3), "skew": 0.2}, {"counts": (4, 3), "skew": 0.2}),
    "triangles": ({"counts": (3, 2), "triangles": True}, {"counts": (4, 5), "triangles": True}),
    "triangles on quadrilaterals": ({"counts": (3, 2), "triangles": True}, {"counts": (4, 5)}),
    "six nodes": tuple({"counts": (k, 2), "triangles": True, "middles": True} for k in (2, 3)),
    "eight nodes": ({"counts": (2, 2), "middles": True}, {"counts": (3, 2), "middles": True}),
    "nine nodes": tuple({"counts": (k, 2), "middles": True, "centres": True} for k in (2, 3)),
    "six nodes on four": ({"counts": (2, 2), "triangles": True, "middles": True}, {"counts": (3, 3)}),
}


def rigid(places):
    """Translations and turns, (k, d, r)."""
    turned = np.stack([np.cross(axis, places) for axis in np.eye(3)], axis=2)
    return np.concatenate([np.broadcast_to(np.eye(3), (len(places), 3, 3)), turned], axis=2)


def apart(found, master, motion=rigid):
    """How far rigid motions of both bodies slip or open, at most."""
    at = master.places[np.searchsorted(master.labels, found.master)]
    blocks = found.P.toarray().reshape(len(found.labels), found.normals.shape[1], len(at), -1)
    return np.abs(np.einsum("jakb,kbr->jar", blocks, motion(at)) - motion(found.places)).max()


@pytest.mark.parametrize("case", CASES)
def test_a_constant_pressure_and_rigid_motions_pass(case):
    slave, master = (
        grid(first=f, into=i, **c) for c, f, i in zip(CASES[case], (1, 900), (1, -1), strict=True)
    )
    found = surface_coupling(slave, master)
    assert found.area.min() > 0
    assert found.area.sum() == pytest.approx(3.0, rel=1e-13)
    pressed = np.zeros((len(found.labels), 3))
    pressed[:, 2] = found.area
    arrives = -found.on_master(pressed)
    np.testing.assert_allclose(arrives[:, 2], areas(master), rtol=0, atol=1e-9)  # differences of shapes above
    np.testing.assert_allclose(arrives[:, :2], 0.0, atol=1e-13)
    assert apart(found, master) < 1e-12
    assert (found.flat, found.share) == (True, pytest.approx([1.0, 1.0]))
    assert np.abs(found.gap).max() < 1e-13


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_units_of_length_change_no_coupling(unit):
    one, other = (
        surface_coupling(grid((3, 2), 1, 1.0, skew=0.2, unit=u), grid((4, 3), 900, -1.0, skew=0.2, unit=u))
        for u in (1.0, unit)
    )
    np.testing.assert_allclose(other.area, unit**2 * one.area, rtol=1e-12)
    np.testing.assert_allclose(other.P.toarray(), one.P.toarray(), atol=1e-12)
    assert other.flat


@pytest.mark.parametrize("shift", [0.3, 0.66, 0.999])
@pytest.mark.parametrize("triangles", [False, True])
def test_edges_are_trimmed(shift, triangles):
    """The slave reaches over the master: what is covered carries, no row blows up, nothing turns."""
    slave = grid((3, 3), 1, 1.0, shift=shift * SIDES[0] / 3, triangles=triangles)
    master = grid((4, 4), 900, -1.0, triangles=triangles)
    found = surface_coupling(slave, master)
    assert found.area.sum() == pytest.approx(3.0 * (1 - shift / 3), rel=2e-3)
    assert found.largest_weight < 3
    assert apart(found, master) < 1e-11
    assert "of the area of the first surface lies beside the second" in found.warnings[0]


def ring(count, first, into, radius=20.0):
    angle = np.linspace(0, 2 * np.pi, count, endpoint=False)
    places = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    labels = first + np.arange(count)
    ends = np.column_stack([labels, np.roll(labels, -1)])
    middles = 0.5 * (places + np.roll(places, -1, axis=0))
    return ContactSurface(labels, places, ends.tolist(), middles * (1 + into))


def plane_motions(places):
    turned = np.column_stack([-places[:, 1], places[:, 0]])[:, :, None]
    return np.concatenate([np.broadcast_to(np.eye(2), (len(places), 2, 2)), turned], axis=2)


@pytest.mark.parametrize(("hub", "shaft"), [(32, 48), (48, 32), (32, 87)])
def test_curved_faces_turn_freely(hub, shaft):
    slave, master = ring(hub, 1, 0.1), ring(shaft, 900, -0.1)
    found = surface_coupling(slave, master)
    assert found.chord > 1e-3
    assert apart(found, master, plane_motions) < 1e-12
    assert not found.flat
    # nodal forces of a pressure all around: in equilibrium with what arrives
    forces = found.area[:, None] * found.normals
    moved = -found.on_master(forces)
    at = master.places[np.searchsorted(master.labels, found.master)]
    np.testing.assert_allclose(moved.sum(axis=0), forces.sum(axis=0), atol=1e-11)
    turning = [r[:, 0] @ own[:, 1] - r[:, 1] @ own[:, 0] for r, own in ((found.places, forces), (at, moved))]
    assert turning[0] == pytest.approx(turning[1], abs=1e-10)


def test_bodies_of_revolution_have_the_areas_of_their_faces():
    """Edges along the axis and across it: 2πr times a length; a constant pressure passes."""
    ends = np.linspace(1.0, 3.0, 4), np.linspace(1.0, 3.0, 6)
    for along in (0, 1):
        slave, master = (
            ContactSurface(
                first + np.arange(len(r)),
                np.column_stack([r, np.zeros(len(r))] if along == 0 else [np.full(len(r), 2.0), r]),
                [(first + k, first + k + 1) for k in range(len(r) - 1)],
                [[2.0 + into * along, 2.0 + into * (1 - along)]] * (len(r) - 1),
            )
            for r, first, into in ((ends[0], 1, 5.0), (ends[1], 900, -5.0))
        )
        found = surface_coupling(slave, master, revolved=True)
        assert found.area.sum() == pytest.approx(8 * np.pi, rel=1e-13)
        pressed = found.area[:, None] * found.normals
        arrives = -found.on_master(pressed)[:, 1 - along]
        size = np.diff(ends[1])
        inner, outer = (ends[1][:-1], ends[1][1:]) if along == 0 else (np.full(5, 2.0), np.full(5, 2.0))
        expected = np.zeros(6)
        expected[:-1] += 2 * np.pi * size * (inner / 3 + outer / 6)
        expected[1:] += 2 * np.pi * size * (inner / 6 + outer / 3)
        np.testing.assert_allclose(np.abs(arrives), expected, rtol=1e-12)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"labels": [2, 2]}, "labels: expected one whole number for each node"),
        ({"labels": ["a", 2]}, "labels: expected real numbers"),
        ({"places": [[0, 0], [1]]}, "places: expected a regular array"),
        ({"inside": [[0.5, 1], [0.5, 1]]}, "inside: expected shape"),
        ({"inside": [[0.5, 1, 0]]}, "inside: expected places of as many coordinates"),
        ({"facets": [(1, 3)]}, "surface: expected facets of 2 or 3 nodes"),
    ],
)
def test_what_is_no_surface_is_refused(given, said):
    good = {"labels": [1, 2], "places": [[0, 0], [1, 0]], "facets": [(1, 2)], "inside": [[0.5, 1]]}
    surface = ContactSurface(**good)
    with pytest.raises(ShakedownError, match=said):
        ContactSurface(**good | given)
    with pytest.raises(ProblemError, match="expected two in the plane or two in space"):
        surface_coupling(surface, grid((3, 2), 900, -1.0))
