"""Joints averaged over a length: hat functions on lines, in patches, along curved surfaces."""

from dataclasses import replace

import numpy as np
import pytest
from joints_in_space import random_joint, turned

import shakedown
from shakedown import Problem, UsageError, averaged
from shakedown.joint.contact_surface import (
    cell_weights,
    contact_patches,
    element_count,
    normals_of,
    surface_of,
)
from shakedown.joint.hat_functions import coarsened, hat_functions, spread_knots
from shakedown.joint.places import strips

GRID = np.stack(np.meshgrid(np.arange(7.0), np.arange(5.0), indexing="ij"), axis=-1).reshape(-1, 2)


def on_places(x, normal=None, seed=0):
    """A random joint in space with nodes at some places."""
    joint = random_joint(np.random.default_rng(seed), len(x))
    if np.shape(x)[1] == 2:
        return replace(joint, f=np.full(len(x), 0.4), x=x)
    return replace(joint, f=np.full(len(x), 0.4), coordinates=x, normal=normal)


def test_reactions_of_slips_between_knots_are_averaged_ones():
    block = shakedown.example("block-9")
    coarse = averaged(block, 0.5)
    P = hat_functions(surface_of(block), np.arange(0, 9, 2))
    slip = np.random.default_rng(1).normal(size=5)
    assert np.allclose(coarse.A @ slip, P.T @ (block.A @ (P @ slip)), rtol=1e-12)
    assert np.allclose(coarse.p_w + coarse.B @ slip, (block.p_w + block.B @ (P @ slip)) @ P, rtol=1e-12)
    assert coarse.C is None or np.allclose(coarse.C, P.T @ block.C @ P)


def test_knots_are_the_nodes_nearest_to_places_a_radius_apart():
    x = np.array([0.0, 0.1, 0.25, 0.6, 0.95, 1.2, 1.4, 1.75, 2.0])
    block = replace(shakedown.example("block-9"), x=x)
    for radius in (0.3, 0.51, 0.7, 5.0):
        count = max(1, round(2.0 / radius))
        nearest = np.abs(x[:, None] - np.linspace(0.0, 2.0, count + 1)).argmin(axis=0)
        assert averaged(block, radius).x.tolist() == x[np.unique(nearest)].tolist()


def test_the_hats_of_one_radius_are_those_of_any_mesh_with_these_knots():
    fine, coarse = (surface_of(shakedown.example(name)) for name in ("block-33", "block-9"))
    P = hat_functions(fine, np.arange(0, 33, 4))
    assert np.allclose(P[::4], hat_functions(coarse, np.arange(9)), atol=1e-12)


SKEWED = GRID + 0.2 * np.sin(GRID @ np.array([[5.0, 2.0], [3.0, 7.0]]))


@pytest.mark.parametrize("places", [GRID, SKEWED @ np.array([[0.8, -0.6], [0.6, 0.8]]), GRID * [1.0, 0.3]])
def test_hats_of_a_patch_are_not_negative_and_give_back_linear_slips(places):
    surface = surface_of(on_places(places))
    P = hat_functions(surface, spread_knots(surface, 2 * surface.spacing))
    assert (P >= 0).all()
    assert np.allclose(P.sum(axis=1), 1.0, rtol=1e-12)
    inside = ~surface.edge & (np.abs(places - places.mean(axis=0)).max(axis=1) < np.ptp(places) / 4)
    assert inside.any()
    slope = places @ np.array([0.3, -1.1])
    assert np.allclose((P @ slope[P.argmax(axis=0)])[inside], slope[inside], atol=1e-6)
    axes = np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    for normal in (None, np.tile(axes[2], (len(places), 1)), np.tile(-axes[2], (len(places), 1))):
        there = surface_of(on_places(places @ axes[:2], normal))
        assert there.edge.tolist() == surface.edge.tolist()
        np.testing.assert_allclose(hat_functions(there, P.argmax(axis=0))[inside], P[inside], atol=1e-9)
        np.testing.assert_allclose(there.spacing, surface.spacing, rtol=1e-12)


@pytest.mark.parametrize("unit", [1e-3, 25.4])
@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0])
def test_at_a_straight_edge_hats_are_nearly_those_of_the_line(unit, angle):
    """The cell of a node at the edge ends 20 distances of its farthest neighbour outside."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    found = cell_weights(unit * np.array([[2.0, 0.0], [-1.0, 0.0], [0.5, 1.0]]) @ turn)
    np.testing.assert_allclose(found, [1 / 3, 2 / 3, 0.0], atol=0.025)


def test_elements_are_counted_alike_with_faces_and_without():
    """By Euler's formula; of two patches, of triangles, around a ring, and without places as in a square."""
    corners = np.arange(35).reshape(7, 5)
    quads = np.stack([corners[:-1, :-1], corners[1:, :-1], corners[1:, 1:], corners[:-1, 1:]], axis=-1)
    flat = on_places(np.column_stack([GRID, 0 * GRID[:, 0]]))
    halves = np.vstack([quads.reshape(-1, 4)[1:], [[0, 5, 6, -1], [0, 6, 1, -1]]])
    joints = flat, on_places(GRID), *(replace(flat, faces=own) for own in (quads.reshape(-1, 4), halves))
    assert [element_count(joint) for joint in joints] == [24.0] * 4
    assert element_count(on_places(np.vstack([GRID, GRID + 50.0]))) == 48.0
    assert element_count(random_joint(np.random.default_rng(0), 25)) == pytest.approx(16.0)
    two_strips = replace(shakedown.example("block-9"), x=[0.0, 1.0, 2.0, 3.0, 9.0, 10.0, 11.0, 12.0, 13.0])
    assert element_count(two_strips) == 7.0
    assert element_count(replace(two_strips, x=None)) == 8.0


def test_two_patches_that_face_each_other_share_no_hat():
    upper = np.column_stack([GRID, np.full(len(GRID), 0.2)])
    both = np.vstack([np.column_stack([GRID, np.zeros(len(GRID))]), upper])
    normal = np.repeat([[0.0, 0, 1], [0, 0, -1]], len(GRID), axis=0)
    surface = surface_of(on_places(both, normal))
    assert [len(part) for part in surface.parts] == [35, 35]
    knots = spread_knots(surface, np.full(70, 2.0))
    P = hat_functions(surface, knots)
    assert not P[:35, knots >= 35].any()
    assert not P[35:, knots < 35].any()


@pytest.mark.parametrize(("far", "edge"), [(1.85, False), (1.95, True)])
def test_a_node_with_too_few_neighbours_this_side_of_a_hole_is_at_the_edge(far, edge):
    """Three nodes around a fourth, one of them almost twice as far away as the others."""
    angle = 2 * np.pi * np.arange(3) / 3
    around = np.column_stack([np.cos(angle), np.sin(angle)]) * [[1.0], [1.0], [far]]
    assert surface_of(on_places(np.vstack([around, [[0.0, 0.0]]]))).edge.tolist() == [True] * 3 + [edge]


@pytest.mark.parametrize(("degrees", "found"), [(59.0, [[0, 1], [2, 3]]), (61.0, [[0], [1], [2, 3]])])
def test_a_node_more_than_60_degrees_aside_is_on_another_strip(degrees, found):
    aside = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    places = np.array([[0.0, 0.0], aside, [9.0, 0.0], [8.0, 0.0]])
    ahead = np.array([[1.0 - 1e-6, 0], [1, 0], [-1, 0], [-1, 0]])  # in sum none, to six digits
    assert [own.tolist() for own in strips(places, ahead)] == found


def test_few_nodes_and_nodes_without_faces_have_their_patches():
    line = np.column_stack([np.arange(4.0), np.zeros((4, 2))])
    facing = np.repeat([[0.0, 0, 1], [0, 0, -1]], 2, axis=0)
    assert [nodes.tolist() for nodes, _ in contact_patches(line, facing, None)] == [[0, 1], [2, 3]]
    square = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.4, 0.5, 0]])
    both, faces = np.vstack([square, square + 9.0]), np.array([[0, 1, 2, 3], [5, 6, 7, 8]])
    found = [(nodes.tolist(), own.tolist()) for nodes, own in contact_patches(both, None, faces)]
    assert found == [([0, 1, 2, 3, 4], [[0, 1, 2, 3]]), ([5, 6, 7, 8, 9], [[0, 1, 2, 3]])]


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_normals_of_faces_are_twice_as_long_as_their_areas(side):
    trapezoid = np.array([[0.0, 0, 0], [4, 0, 0], [3, 2, 0], [1, 2, 0]])
    found = normals_of(trapezoid, np.tile([0, 0, side], (4, 1)), np.array([[0, 1, 2, 3], [0, 1, 2, -1]]))
    np.testing.assert_allclose(found, [[0, 0, side * 2 * 6.0], [0, 0, side * 2 * 4.0]])


@pytest.mark.parametrize("unit", [1e-3, 1.0, 25.4])
def test_half_as_many_knots_each_way_are_a_coarser_joint_in_any_unit(unit):
    every_second = unit * GRID[(GRID % 2 == 0).all(axis=1)]
    np.testing.assert_allclose(coarsened(on_places(unit * GRID)).x, every_second, rtol=1e-12)


def test_slips_are_carried_along_where_the_tangents_turn():
    joint = on_places(GRID)
    angle = np.random.default_rng(2).uniform(0, 6, joint.n)
    same, T = turned(joint, angle)
    same = replace(same, tangents=(T @ np.tile(np.eye(2, 3), (joint.n, 1))).reshape(-1, 2, 3))
    one, other = (shakedown.upper_bound(averaged(each, 2.0)) for each in (joint, same))
    assert one.load_factor == pytest.approx(other.load_factor, rel=1e-7)


def test_an_initial_slip_between_knots_stays_what_it_is():
    block = shakedown.example("block-9")
    P = hat_functions(surface_of(block), np.arange(0, 9, 2))
    slip = np.array([1.0, -2.0, 0.5, 3.0, 1.5]) * 1e-4
    given = averaged(replace(block, initial_slip=P @ slip), 0.5)
    assert np.allclose(given.initial_slip[0], slip, rtol=1e-9)
    rough = replace(block, initial_slip=np.arange(9.0) % 2)
    assert np.allclose(
        averaged(rough, 0.5).A @ averaged(rough, 0.5).initial_slip[0], P.T @ block.A @ rough.initial_slip[0]
    )


@pytest.mark.parametrize("radius", [0.0, -1.0, np.inf, np.nan])
def test_a_radius_is_a_length(radius):
    with pytest.raises(UsageError, match="radius: expected a length above 0"):
        averaged(shakedown.example("block-9"), radius)


def test_a_joint_has_to_know_where_its_nodes_are():
    with pytest.raises(UsageError, match="expected positions x"):
        averaged(shakedown.example("two-node"), 1.0)
    assert coarsened(replace(shakedown.example("block-9"), x=np.zeros(9))) is None
    assert coarsened(on_places(np.repeat(GRID, 2, axis=0)[:12])) is None


def on_a_circle(angle, **more):
    """A joint in the plane that says of its nodes where they are, and nothing else of interest."""
    n, places = len(angle), np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    ones = np.ones((2, n))
    return Problem(A=np.eye(n), B=np.zeros((n, n)), f=0.3, q_w=ones, p_w=ones, coordinates=places, **more)


def test_a_ring_has_no_end_and_its_hats_go_around():
    angle, side = 2 * np.pi * np.arange(12) / 12, 2 * np.sin(np.pi / 12)
    joint = on_a_circle(angle, x=side * np.arange(12))
    surface = surface_of(joint)
    assert (surface.edge.any(), element_count(joint)) == (False, 12.0)
    assert averaged(joint, 2 * side).n == coarsened(joint).n == 6
    P = hat_functions(surface, np.arange(0, 12, 2))
    assert np.allclose(P[11], [0.5, 0, 0, 0, 0, 0.5])


def test_an_uneven_ring_is_one_whose_areas_go_around():
    """Without what lies between its last node and its first it is an arc with two ends."""
    angle = 2 * np.pi * np.cumsum([0.0, 0.02, 0.05, 0.1, 0.12, 0.09, 0.08, 0.12, 0.15, 0.14, 0.1])
    steps = 2 * np.sin(np.diff(angle, append=2 * np.pi) / 2)  # chords, from each node to the next
    area = 0.3 * (steps + np.roll(steps, 1)) / 2
    joint = on_a_circle(angle, x=np.append(0.0, np.cumsum(steps)[:-1]), node_area=area)
    surface = surface_of(joint)
    assert not surface.edge.any()
    np.testing.assert_allclose(surface.spacing, np.minimum(steps, np.roll(steps, 1)), rtol=1e-12)
    thick = replace(joint, node_area=area * np.where(np.isin(range(11), [0, 1, 2, 8, 9, 10]), 1.0, 5.0))
    assert not surface_of(thick).edge.any()  # only what lies beside the ends tells of them
    area[[0, -1]] -= 0.3 * steps[-1] / 2
    assert np.flatnonzero(surface_of(replace(joint, node_area=area)).edge).tolist() == [0, 10]


def test_a_length_below_an_element_says_that_nothing_is_averaged(caplog):
    block = shakedown.example("block-9")
    assert (averaged(block, 0.5).n, caplog.messages) == (5, [])
    assert averaged(block, 0.1).A.tolist() == block.A.tolist()
    assert caplog.messages == ["averaging over 0.1 does nothing: elements are as long"]
