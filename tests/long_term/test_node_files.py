"""Files for ParaView: faces and directions in space, names of nodes, the path at the times of a series."""

from dataclasses import replace
from xml.etree import ElementTree

import meshlane
import numpy as np
import pytest
from command import run

import shakedown
from shakedown import UsageError
from shakedown.long_term.node_results import save_node_instants


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


def test_every_instant_is_a_file_with_the_path_at_its_time(flange, state, tmp_path):
    written = save_node_instants(state, tmp_path / "nodes.vtu", 5)
    assert [path.name for path in written] == ["nodes.pvd", *(f"nodes_{k:03d}.vtu" for k in range(5))]
    assert sorted(written) == sorted(tmp_path.iterdir())
    named = list(ElementTree.parse(written[0]).iter("DataSet"))
    assert [each.get("file") for each in named] == [path.name for path in written[1:]]
    times = np.array([float(each.get("timestep")) for each in named])
    np.testing.assert_array_equal(times, np.linspace(0.0, 1.0, 5))
    begin, end = state.history.cycle[[0, -1]]
    at = state.history.at(begin + times * (end - begin))
    for k, path in enumerate(written[1:]):
        found = meshlane.read(path)
        np.testing.assert_array_equal(found.points, flange.coordinates)
        for word, values in (("v [mm]", at.v), ("q [N]", at.q)):
            there = np.einsum("nd,ndk->nk", values[k].reshape(-1, 2), flange.tangents)
            np.testing.assert_allclose(found.point_data[word], there, rtol=1e-12, atol=0.0)
        np.testing.assert_array_equal(found.point_data["normal"], flange.normal)
        np.testing.assert_array_equal(found.point_data["cycle"], at.cycle[k])
        assert {cells.type for cells in found.cells} == {"vertex", "triangle", "quad"}
        for word, values in (("p [N]", at.p), ("w [mm]", at.w), ("status", at.state)):
            np.testing.assert_array_equal(found.point_data[word], values[k])


def test_without_tangents_vectors_lie_along_the_first_axes(tmp_path):
    joint = replace(shakedown.example("four-node-3d"), coordinates=np.arange(12.0).reshape(4, 3))
    (_, path) = save_node_instants(shakedown.long_term_state(joint, 1.4), tmp_path / "nodes.vtu", 1)
    v = meshlane.read(path).point_data["v"]
    assert (v.shape, v[:, 2].any(), v.any()) == ((4, 3), False, True)


def test_the_command_writes_them_beside_the_table_of_the_period(tmp_path):
    path = tmp_path / "nodes.vtp"
    asked = ("nodes", "two-node", "--load-factor", "0.9", "--instants", "2", "-o")
    assert run(*asked, str(path))[0] == 0
    names = {found.name for found in tmp_path.iterdir()}
    assert names == {"nodes.vtp", "nodes.pvd", "nodes_000.vtp", "nodes_001.vtp"}
    code, _, err = run(*asked, str(tmp_path / "nodes.csv"))
    assert code == 2
    assert "--instants: expected -o with a name that ends in .vtu or .vtp, found" in err
    (tmp_path / "other.pvd").mkdir()
    code, _, err = run(*asked, str(tmp_path / "other.vtp"))
    assert code == 2
    assert "other.pvd: cannot be written" in err
    assert not list(tmp_path.glob("other*.vtp"))


def test_without_a_steady_period_there_is_no_series(tmp_path):
    stepped = shakedown.simulate(shakedown.example("two-node"), 0.5, method="gauss-seidel", cycles=2)
    with pytest.raises(UsageError, match="expected a steady period from event to event, found none"):
        save_node_instants(stepped, tmp_path / "nodes.vtp")
    assert not list(tmp_path.iterdir())
