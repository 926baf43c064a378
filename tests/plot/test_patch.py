"""Patches of a contact in space: what is cut, where it is drawn; pictures show the numbers of the results there."""

from dataclasses import replace

import numpy as np
import pytest
from joints_in_space import turned
from matplotlib.collections import EllipseCollection
from matplotlib.quiver import Quiver

import shakedown
from shakedown import plot
from shakedown.ground.status import SLIP
from shakedown.joint.constraints import loading
from shakedown.models.condensation.contact_frame import tangent_pairs
from shakedown.plot.patch_places import places_of

BARE = shakedown.example("four-node-3d")
CORNERS = np.array([[0.0, 0.0, 5.0], [2.0, 0.0, 5.0], [2.0, 1.0, 5.0], [0.0, 1.0, 5.0]])
UP, ALONG = np.tile([0.0, 0.0, 1.0], (4, 1)), np.tile(np.eye(3)[:2], (4, 1, 1))
JOINT = replace(
    BARE, coordinates=CORNERS, normal=UP, tangents=ALONG, units="N, mm", node_area=np.full(4, 2.0)
)


@pytest.fixture(scope="module")
def cyclic():
    return shakedown.long_term_state(JOINT, 1.4)


def arrows(axes):
    """Feet, vectors of all arrows, in the order of their feet."""
    found = [c for c in axes.collections if isinstance(c, Quiver)]
    rows = np.concatenate([np.column_stack([c.XY, c.U, c.V]) for c in found])
    return rows[np.lexsort(rows.T[:2])]


def test_arrows_are_the_use_of_friction_in_the_model_and_none_leaves_its_disc(cyclic):
    time = cyclic.history.cycle[0] + 0.3
    now = cyclic.history.at(np.array([time]))
    q, limit = JOINT.layout.by_node(now.q)[0], JOINT.law.limit(now.p)[0]
    axes = plot.friction_use_at(cyclic, JOINT, time)
    drawn, order = arrows(axes), np.lexsort(CORNERS.T[:2])
    np.testing.assert_allclose(drawn[:, :2], CORNERS[order, :2])
    (discs,) = [c for c in axes.collections if isinstance(c, EllipseCollection)]
    radius = float(discs._widths[0])  # of an ellipse it keeps half the width
    np.testing.assert_allclose(discs._widths, radius)
    np.testing.assert_allclose(drawn[:, 2:] / radius, (q / limit[:, None])[order], atol=1e-12)
    assert np.linalg.norm(drawn[:, 2:], axis=1).max() <= (1 + 1e-7) * radius


def test_turned_tangents_change_no_arrow():
    other, turn = turned(JOINT, np.full(4, np.arctan2(0.8, 0.6)))
    other = replace(other, tangents=np.tile(turn[:2, :2] @ np.eye(3)[:2], (4, 1, 1)))
    states = (shakedown.long_term_state(joint, 1.4) for joint in (JOINT, other))
    one, same = (
        arrows(plot.friction_use_at(state, state.problem, float(state.history.cycle[0]) + 0.3))
        for state in states
    )
    np.testing.assert_allclose(same, one, atol=1e-6)


def test_orbits_stay_within_the_limit_and_say_the_work_of_node_results(cyclic):
    nodes = shakedown.node_results(cyclic)
    axes = plot.reaction_orbits(cyclic, JOINT, nodes=range(4))
    for line, work in zip(axes.lines[1:], nodes.work, strict=True):
        farthest = np.linalg.norm(line.get_xydata(), axis=1).max()
        assert farthest < 1.0 + 1e-6
        assert farthest > 1.0 - 1e-6 or work == 0.0
    worst = int(nodes.work.argmax())
    axes = plot.slip_orbits(cyclic, JOINT, nodes=[worst])
    (text,) = axes.get_legend().get_texts()
    assert text.get_text() == f"node {worst}: {cyclic.period * nodes.work[worst]:.4g} [N mm]"
    way = axes.lines[0].get_xydata()
    np.testing.assert_allclose(np.ptp(way, axis=0), nodes.slip_range_of_directions[worst], rtol=1e-12)
    assert axes.get_xlabel() == "slip v_x − middle [mm]"


def test_without_places_numbers_stand_over_those_of_the_nodes(cyclic):
    time = float(cyclic.history.cycle[3])
    axes = plot.pressure_over_patch(cyclic, BARE, time)
    (line,) = axes.lines
    np.testing.assert_array_equal(line.get_xdata(), np.arange(4))
    np.testing.assert_array_equal(line.get_ydata(), cyclic.history.at(np.array([time])).p[0])
    axes = plot.pressure_over_patch(cyclic, JOINT, time)
    assert not axes.lines
    assert axes.figure.axes[-1].get_ylabel() == "pressure [MPa]"


def grid(n: int, m: int) -> np.ndarray:
    return np.stack(np.meshgrid(np.arange(float(n)), np.arange(float(m))), axis=-1).reshape(-1, 2)


def joint(**places) -> shakedown.Problem:
    """One that says of its nodes where they are, first by (n, …), and nothing else of interest."""
    n = len(next(iter(places.values())))
    return shakedown.Problem(
        A=np.eye(2 * n), B=np.zeros((n, 2 * n)), f=0.5, q_w=np.ones((2, 2 * n)), p_w=np.ones((2, n)), **places
    )


def in_space(places, normals=None, faces=None) -> shakedown.Problem:
    tangents = None if normals is None else tangent_pairs(normals)
    return joint(coordinates=places, normal=normals, tangents=tangents, faces=faces)


def patches(problem: shakedown.Problem) -> list:
    return [places_of(problem, k) for k in range(plot.patch_count(problem))]


def test_no_triangle_lies_across_a_hole_or_between_two_patches():
    whole = grid(12, 12)
    hole = whole[np.linalg.norm(whole - 5.5, axis=1) > 3.2]
    apart = np.concatenate([grid(5, 5), grid(5, 5) + np.array([20.0, 0.0])])
    for x, count in ((hole, 1), (apart, 2)):
        places = patches(joint(x=x))
        assert len(places) == count
        middle = np.concatenate([each.points[each.triangles.triangles].mean(axis=1) for each in places])
        assert len(middle) > 20
        assert np.linalg.norm(middle[:, None] - x, axis=2).min(axis=1).max() < 1.0
    angle = 2 * np.pi * np.arange(24) / 24
    ring = np.concatenate([r * np.stack([np.cos(angle), np.sin(angle)], axis=1) for r in (8.0, 10.0, 12.0)])
    assert len(places_of(joint(x=ring)).triangles.triangles) == 2 * 2 * 24
    coarse = shakedown.example("bolted-flange")  # so coarse a ring that its hole is no larger than a triangle
    drawn = places_of(coarse).triangles
    assert np.hypot(*coarse.x[drawn.triangles].mean(axis=1).T).min() > 13.0 * np.cos(np.pi / 8) - 1e-9
    assert len(drawn.triangles) == 2 * 2 * 8
    facing = replace(
        joint(x=grid(6, 6)), coordinates=np.column_stack([grid(6, 6), np.zeros(36)]), tangents=None,
        normal=np.where(grid(6, 6)[:, :1] < 2.5, 1.0, -1.0) * np.array([0.8, 0.0, 0.6]) + [0.0, 0.0, 0.0],
    )  # fmt: skip
    assert [len(one.triangles.triangles) for one in patches(facing)] == [2 * 2 * 5] * 2
    assert places_of(joint(x=grid(5, 1))).triangles is None
    assert len(places_of(joint(x=grid(2, 2) + 1e9)).triangles.triangles) == 2


def test_loads_of_nodes_with_tangents_of_their_own_are_summed_along_the_axes():
    faces = ALONG.copy()
    faces[2:] = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]]
    joint = replace(JOINT, tangents=faces, normal=np.cross(faces[:, 0], faces[:, 1]))
    q, p = loading(joint).at(1.0)
    lines = plot.loads_in_time(joint).lines
    assert [line.get_label() for line in lines] == [f"Σ along {axis}, all nodes" for axis in "xyz"]
    x = q[:, [0, 2, 5, 7]].sum(axis=1)
    np.testing.assert_allclose(lines[0].get_ydata()[:-1], x)
    np.testing.assert_allclose(lines[2].get_ydata()[:-1], p[:, :2].sum(axis=1) - p[:, 2:].sum(axis=1))
    assert plot.loads_in_time(JOINT).lines[1].get_label() == "Σ q_w in x"


def strips(rows: int, columns: int) -> np.ndarray:
    """Quadrilaterals of a grid whose nodes stand row by row."""
    first = columns * np.arange(rows - 1)[:, None] + np.arange(columns - 1)
    return first.reshape(-1, 1) + np.array([0, columns, columns + 1, 1])


def elsewhere(places: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same anywhere in space."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    return places @ turn.T + [3.0, -7.0, 2.0], normals @ turn.T


def bracket():
    """Two squares at a right angle: at the edge the normals are the mean of both."""
    steps = np.arange(5.0)
    outline = np.concatenate(
        [np.column_stack([steps[::-1], 0 * steps]), np.column_stack([0 * steps, steps])[1:]]
    )
    places = np.array([(x, y, z) for x, z in outline for y in np.arange(4.0)])
    flat, edge, upright = [0.0, 0.0, 1.0], [0.5**0.5, 0.0, 0.5**0.5], [1.0, 0.0, 0.0]
    return places, np.repeat([flat] * 4 + [edge] + [upright] * 4, 4, axis=0), strips(9, 4)


def spacer():
    """Both faces of a plate thinner than its elements are wide."""
    grid = np.array([(x, y, 0.0) for x in range(5) for y in range(4)])
    normals = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], 20, axis=0)
    faces = np.concatenate([strips(5, 4), strips(5, 4) + 20])
    return np.concatenate([grid, grid + np.array([0, 0, 0.3])]), normals, faces


@pytest.mark.parametrize(("body", "shared"), [(bracket, 4), (spacer, 0)])
def test_edges_and_opposite_faces_are_cut(body, shared):
    places, normals, faces = body()
    places, normals = elsewhere(places, normals)
    both = patches(in_space(places, normals, faces))
    assert [len(patch.nodes) for patch in both] == [20, 20]
    assert len(np.intersect1d(*(patch.nodes for patch in both))) == shared
    assert [patch.name for patch in both] == ["patch 1 of 2", "patch 2 of 2"]
    # where no normals are known, those of the faces tell an edge
    assert plot.patch_count(in_space(places, None, faces)) == 2


def test_a_plane_patch_anywhere_keeps_its_lengths_and_that_along_the_axes_its_places():
    places, normals, faces = bracket()
    first, second = patches(in_space(places, normals, faces))
    assert {first.axes, second.axes} == {("x", "y"), ("y", "z")}
    for patch in (first, second):
        kept = ["xyz".index(axis) for axis in patch.axes]
        np.testing.assert_allclose(patch.points, places[patch.nodes][:, kept])
    inclined = patches(in_space(*elsewhere(places, normals), faces))
    for patch, same in zip((first, second), inclined, strict=True):
        apart = [np.linalg.norm(each.points[:, None] - each.points, axis=2) for each in (patch, same)]
        np.testing.assert_allclose(apart[1], apart[0], atol=1e-12)


@pytest.mark.parametrize("scale", [2.0**-200, 2.0**200])
def test_units_change_no_patch(scale):
    for places, normals, faces in (bracket(), spacer()):
        for given in (faces, None):
            one, other = (patches(in_space(factor * places, normals, given)) for factor in (1.0, scale))
            for first, second in zip(one, other, strict=True):
                np.testing.assert_array_equal(first.nodes, second.nodes)
                size = np.abs(first.points).max()
                np.testing.assert_allclose(second.points / scale, first.points, atol=1e-9 * size)


@pytest.mark.parametrize("n", [1, 2, 3, 12])
def test_nodes_at_one_place_or_in_a_row_are_drawn_there(n):
    along = np.arange(float(n))[:, None] * [1.0, 2.0, 0.5]
    for places in (np.zeros((n, 3)), along):
        (patch,) = patches(in_space(places))
        assert sorted(patch.nodes) == list(range(n))
        assert np.isfinite(patch.points).all()
        assert patch.triangles is None


@pytest.mark.parametrize(("slip", "shown"), [(4e-13, "4 stick, 0 slip"), (1e-3, "3 stick, 1 slip")])
def test_round_off_is_drawn_as_no_slip(slip, shown):
    still = shakedown.long_term_state(JOINT, 0.5).history
    v, state = still.v.copy(), still.state.copy()
    v[2:, 0] += slip
    state[1, 0] = SLIP
    path = replace(still, v=v, state=state)
    assert shown in plot.zones_at(path, JOINT, float(path.cycle[1])).get_title()
    names = [
        text.get_text()
        for text in plot.friction_use_at(path, JOINT, float(path.cycle[1])).get_legend().get_texts()
    ]
    assert ("slips" in names) == ("1 slip" in shown)
