"""Faces of a contact in files for ParaView: the cells, the directions in space, the names of the nodes."""

from dataclasses import replace

import meshlane
import numpy as np
import pytest

import shakedown


@pytest.fixture(scope="module")
def flange():
    """Turned so that no direction of it is an axis; the first five faces only, one of them a triangle."""
    joint = shakedown.example("bolted-flange")
    turn = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    faces = joint.faces.copy()
    faces[0, 3] = -1
    placed = {key: getattr(joint, key) @ turn for key in ("coordinates", "normal", "tangents")}
    return replace(joint, faces=faces[:5], **placed)


@pytest.fixture(scope="module")
def state(flange):
    return shakedown.long_term_state(flange, 1.2 * shakedown.upper_bound(flange).load_factor)


def test_the_faces_are_cells_and_the_other_nodes_vertices(flange, state, tmp_path):
    shakedown.node_results(state).save(tmp_path / "n.vtu")
    mesh = meshlane.read(tmp_path / "n.vtu")
    cells = {block.type: block.data for block in mesh.cells}
    assert np.sort(cells["triangle"]).tolist() == np.sort(flange.faces[:1, :3]).tolist()
    assert np.sort(cells["quad"]).tolist() == np.sort(flange.faces[1:]).tolist()
    for corners in cells["triangle"], cells["quad"]:  # counter-clockwise, seen against the normals
        at = mesh.points[corners]
        across = np.cross(at[:, 1] - at[:, 0], at[:, 2] - at[:, 1])
        assert ((across * flange.normal[0]).sum(axis=1) > 0).all()
    assert sorted([*cells["vertex"].ravel(), *{*flange.faces.ravel()} - {-1}]) == list(range(flange.n))
    labels = [f"{a}/{b}" for a, b in zip(mesh.point_data["node_1"], mesh.point_data["node_2"], strict=True)]
    assert labels == list(flange.label)


def test_slip_vectors_lie_in_the_surface_and_are_as_long_as_the_range(flange, state):
    found = shakedown.node_results(state)
    assert found.slip_range.max() > 0
    np.testing.assert_allclose(np.linalg.norm(found.slip_range_vector, axis=1), found.slip_range, rtol=1e-12)
    across = np.einsum("nk,nk->n", found.slip_range_vector, flange.normal)
    assert np.abs(across).max() <= 1e-9 * found.slip_range.max()
    by_node = state.history.refined().v.reshape(-1, flange.n, 2)
    whole = np.einsum("snd,ndk->snk", by_node, flange.tangents)
    apart = np.linalg.norm(whole[:, None] - whole[None], axis=-1)
    closed = np.isin(found.status, ["stick", "slip"])  # what moves while a node is open is no slip
    assert "slip" in found.status
    np.testing.assert_allclose(
        apart.max(axis=(0, 1))[closed], found.slip_range[closed], atol=1e-9 * found.slip_range.max()
    )


def test_the_normal_follows_from_both_tangents(flange, state):
    without = shakedown.node_results(replace(state, problem=replace(flange, normal=None)))
    np.testing.assert_allclose(without.normal, flange.normal, atol=1e-12)
