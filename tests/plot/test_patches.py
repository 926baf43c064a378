"""Patches of a contact in space: what is cut, what is unrolled, and that lengths on them stay what they are."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from shakedown import Problem, UsageError, plot
from shakedown.models.condensation.tangent_pairs import tangent_pairs
from shakedown.plot.flat_patch import laid_flat
from shakedown.plot.patch_places import places_of, triangles_of


def strips(rows: int, columns: int, closed: bool = False) -> np.ndarray:
    """Quadrilaterals of a grid whose nodes stand row by row; of a closed one the last row meets the first."""
    return np.array([
        [i * columns + j, (i + 1) % rows * columns + j, (i + 1) % rows * columns + j + 1, i * columns + j + 1]
        for i in range(rows - 1 + closed)
        for j in range(columns - 1)
    ])  # fmt: skip


def turned(places: np.ndarray, normals: np.ndarray, seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """The same anywhere in space."""
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return places @ turn.T + [3.0, -7.0, 2.0], normals @ turn.T


def cone(half: float, around: float, rows: int = 16) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Places, normals and faces of a cone of a half angle, of a cylinder R = 20 where that is zero."""
    closed = around == 2 * np.pi
    angle = np.linspace(0.0, around, rows, endpoint=not closed)
    along = np.linspace(30.0, 50.0, 5)
    T, S = (each.ravel() for each in np.meshgrid(angle, along, indexing="ij"))
    r = S * np.sin(half) if half else np.full_like(S, 20.0)
    places = np.column_stack([r * np.cos(T), r * np.sin(T), S * np.cos(half)])
    lean = np.full_like(S, -np.sin(half))
    normals = np.column_stack([np.cos(half) * np.cos(T), np.cos(half) * np.sin(T), lean])
    return *turned(places, normals), strips(rows, 5, closed)


@pytest.mark.parametrize("half", [0.0, np.radians(8.0), np.radians(55.0)])
@pytest.mark.parametrize("around", [1.5, 2 * np.pi])
@pytest.mark.parametrize("known", [True, False])
def test_what_is_unrolled_keeps_its_area_and_its_lengths(half, around, known):
    places, normals, faces = cone(half, around)
    (patch,) = laid_flat(places, normals, faces if known else None)
    assert patch.kind.startswith("cone" if half else "cylinder")
    assert set(patch.nodes) == set(range(len(places)))
    if not known:
        return
    assert len(patch.faces) == len(faces)  # with those across the seam
    for of in (places[patch.nodes], patch.points):
        assert areas(of, patch.faces).sum() == pytest.approx(areas(places, faces).sum(), rel=0.03)
    sides = np.concatenate([patch.faces[:, [k, (k + 1) % 4]] for k in range(4)])
    flat, true = (
        np.linalg.norm(np.diff(at[sides], axis=1)[:, 0], axis=1) for at in (patch.points, places[patch.nodes])
    )
    np.testing.assert_allclose(flat, true, rtol=0.04)  # an arc and its chord
    lengthwise = true[np.abs(patch.nodes[sides[:, 0]] - patch.nodes[sides[:, 1]]) == 1]
    np.testing.assert_allclose(lengthwise, 5.0)


@pytest.mark.parametrize("half", [0.0, 0.4])
def test_directions_on_an_unrolled_patch_lead_where_its_nodes_are(half):
    places, normals, faces = cone(half, 2 * np.pi)
    (patch,) = laid_flat(places, normals, faces)
    frame = patch.frame
    np.testing.assert_allclose(
        frame @ frame.swapaxes(1, 2), np.tile(np.eye(2), (len(frame), 1, 1)), atol=1e-9
    )
    np.testing.assert_allclose(np.cross(frame[:, 0], frame[:, 1]), normals[patch.nodes], atol=1e-9)
    along = patch.faces[:, [0, 3]]  # along a generator
    steps = np.diff(places[patch.nodes][along], axis=1)[:, 0]
    seen = np.einsum("ndk,nk->nd", frame[along[:, 0]], steps)
    np.testing.assert_allclose(seen, np.diff(patch.points[along], axis=1)[:, 0], atol=1e-9)


def areas(at: np.ndarray, faces: np.ndarray) -> np.ndarray:
    at = np.column_stack([at, np.zeros(len(at))]) if at.shape[1] == 2 else at
    corners = at[triangles_of(faces)]
    return 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )


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
    both = laid_flat(places, normals, faces)
    assert [len(patch.nodes) for patch in both] == [20, 20]
    assert len(np.intersect1d(*(patch.nodes for patch in both))) == shared
    assert [patch.kind for patch in both] == ["", ""]
    assert sorted(len(patch.nodes) for patch in laid_flat(places, normals, None)) == [20 - shared, 20]
    # where no normals are known, those of the faces tell an edge
    assert len(laid_flat(places, None, faces)) == 2


def test_fine_rows_far_apart_are_one_patch_and_a_sphere_is_projected():
    rows = np.array([(x, 7.0 * y, 0.0) for y in range(4) for x in range(20)])
    (patch,) = laid_flat(rows, np.tile([0.0, 0.0, 1.0], (80, 1)), None)
    np.testing.assert_allclose(patch.points, rows[:, :2])
    points = np.random.default_rng(0).normal(size=(300, 3))
    points = points[points[:, 2] > 0.3 * np.linalg.norm(points, axis=1)]
    points /= np.linalg.norm(points, axis=1)[:, None]
    (patch,) = laid_flat(5.0 * points, points, None)
    assert patch.kind == "curved, projected"


@pytest.mark.parametrize("half", [0.0, 0.3])
def test_a_free_mesh_of_triangles_is_unrolled_as_well(half):
    """Its faces lean to all sides of the surface, by a share of their size over the radius."""
    grid = np.array([(a, h) for a in np.linspace(0.0, 30.0, 21) for h in np.linspace(0.0, 30.0, 21)])
    inner = ((grid > 0) & (grid < 30)).all(axis=1)[:, None]
    along = grid + inner * np.random.default_rng(0).uniform(-0.5, 0.5, grid.shape)
    angle, radius = along[:, 0] / 20.0, 20.0 + along[:, 1] * np.tan(half)
    places = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), along[:, 1]])
    faces = np.column_stack([Delaunay(along).simplices, np.full(800, -1)])
    (patch,) = laid_flat(places, None, faces)
    assert patch.kind.startswith("cone, 17.2°" if half else "cylinder")


@pytest.mark.parametrize("scale", [2.0**-200, 2.0**200])
def test_units_change_no_patch(scale):
    for places, normals, faces in (cone(0.0, 2 * np.pi), cone(0.4, 1.5), bracket(), spacer()):
        for given in (faces, None):
            one, other = laid_flat(places, normals, given), laid_flat(scale * places, normals, given)
            assert [patch.kind for patch in one] == [patch.kind for patch in other]
            for first, second in zip(one, other, strict=True):
                np.testing.assert_array_equal(first.nodes, second.nodes)
                size = np.abs(first.points).max()
                np.testing.assert_allclose(second.points / scale, first.points, atol=1e-9 * size)


@pytest.mark.parametrize("n", [1, 2, 3, 12])
def test_nodes_at_one_place_or_in_a_row_are_drawn_there(n):
    along = np.arange(float(n))[:, None] * [1.0, 2.0, 0.5]
    for places in (np.zeros((n, 3)), along):
        (patch,) = laid_flat(places, None, None)
        assert sorted(patch.nodes) == list(range(n))
        assert np.isfinite(patch.points).all()


def test_a_seam_is_drawn_at_both_ends_and_no_node_is_counted_twice():
    places, normals, faces = cone(0.0, 2 * np.pi)
    n = len(places)
    joint = Problem(
        A=np.eye(2 * n), B=np.zeros((n, 2 * n)), f=0.5, q_w=np.ones((2, 2 * n)), p_w=np.ones((2, n)),
        coordinates=places, normal=normals, tangents=tangent_pairs(normals), faces=faces,
        node_area=np.full(n, 2.0),
    )  # fmt: skip
    drawn = places_of(joint)
    assert len(drawn.nodes) == n + 5
    assert drawn.area == pytest.approx(2.0 * n)
    vectors = drawn.seen(np.ones((n + 5, 2)))
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1), np.sqrt(2.0))
    assert plot.patch_count(joint) == 1
    with pytest.raises(UsageError, match="patch: expected a number from 0 to 0, found 1"):
        plot.loads_over_patch(joint, patch=1)
