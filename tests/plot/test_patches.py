"""Patches of a contact in space: what is cut, where it is drawn, and what is said of a curved one."""

import numpy as np
import pytest

from shakedown import Problem, plot
from shakedown.models.condensation.contact_frame import tangent_pairs
from shakedown.plot.patch_places import places_of


def strips(rows: int, columns: int) -> np.ndarray:
    """Quadrilaterals of a grid whose nodes stand row by row."""
    return np.array([
        [i * columns + j, (i + 1) * columns + j, (i + 1) * columns + j + 1, i * columns + j + 1]
        for i in range(rows - 1)
        for j in range(columns - 1)
    ])  # fmt: skip


def turned(places: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same anywhere in space."""
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    return places @ turn.T + [3.0, -7.0, 2.0], normals @ turn.T


def joint(places: np.ndarray, normals: np.ndarray | None, faces: np.ndarray | None = None) -> Problem:
    n = len(places)
    tangents = None if normals is None else tangent_pairs(normals)
    return Problem(
        A=np.eye(2 * n), B=np.zeros((n, 2 * n)), f=0.5, q_w=np.ones((2, 2 * n)), p_w=np.ones((2, n)),
        coordinates=places, normal=normals, tangents=tangents, faces=faces,
    )  # fmt: skip


def patches(problem: Problem) -> list:
    return [places_of(problem, k) for k in range(plot.patch_count(problem))]


def bracket() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two squares at a right angle: at the edge the normals are the mean of both."""
    steps = np.arange(5.0)
    outline = np.concatenate(
        [np.column_stack([steps[::-1], 0 * steps]), np.column_stack([0 * steps, steps])[1:]]
    )
    places = np.array([(x, y, z) for x, z in outline for y in np.arange(4.0)])
    flat, edge, upright = [0.0, 0.0, 1.0], [0.5**0.5, 0.0, 0.5**0.5], [1.0, 0.0, 0.0]
    return places, np.repeat([flat] * 4 + [edge] + [upright] * 4, 4, axis=0), strips(9, 4)


def spacer() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Both faces of a plate thinner than its elements are wide."""
    grid = np.array([(x, y, 0.0) for x in range(5) for y in range(4)])
    normals = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], 20, axis=0)
    return (
        np.concatenate([grid, grid + np.array([0, 0, 0.3])]),
        normals,
        np.concatenate([strips(5, 4), strips(5, 4) + 20]),
    )


@pytest.mark.parametrize(("body", "shared"), [(bracket, 4), (spacer, 0)])
def test_edges_and_opposite_faces_are_cut(body, shared):
    places, normals, faces = body()
    places, normals = turned(places, normals)
    both = patches(joint(places, normals, faces))
    assert [len(patch.nodes) for patch in both] == [20, 20]
    assert len(np.intersect1d(*(patch.nodes for patch in both))) == shared
    assert [patch.name for patch in both] == ["patch 1 of 2", "patch 2 of 2"]
    # where no normals are known, those of the faces tell an edge
    assert plot.patch_count(joint(places, None, faces)) == 2


def test_a_plane_patch_anywhere_keeps_its_lengths_and_that_along_the_axes_its_places():
    places, normals, faces = bracket()
    first, second = patches(joint(places, normals, faces))
    assert {first.axes, second.axes} == {("x", "y"), ("y", "z")}
    for patch in (first, second):
        kept = ["xyz".index(axis) for axis in patch.axes]
        np.testing.assert_allclose(patch.points, places[patch.nodes][:, kept])
    inclined = patches(joint(*turned(places, normals), faces))
    for patch, same in zip((first, second), inclined, strict=True):
        apart = [np.linalg.norm(each.points[:, None] - each.points, axis=2) for each in (patch, same)]
        np.testing.assert_allclose(apart[1], apart[0], atol=1e-12)


@pytest.mark.parametrize("scale", [2.0**-200, 2.0**200])
def test_units_change_no_patch(scale):
    for places, normals, faces in (bracket(), spacer()):
        for given in (faces, None):
            one, other = (patches(joint(factor * places, normals, given)) for factor in (1.0, scale))
            for first, second in zip(one, other, strict=True):
                np.testing.assert_array_equal(first.nodes, second.nodes)
                size = np.abs(first.points).max()
                np.testing.assert_allclose(second.points / scale, first.points, atol=1e-9 * size)


@pytest.mark.parametrize("n", [1, 2, 3, 12])
def test_nodes_at_one_place_or_in_a_row_are_drawn_there(n):
    along = np.arange(float(n))[:, None] * [1.0, 2.0, 0.5]
    for places in (np.zeros((n, 3)), along):
        (patch,) = patches(joint(places, None))
        assert sorted(patch.nodes) == list(range(n))
        assert np.isfinite(patch.points).all()
        assert patch.triangles is None
