"""The series for ParaView: the files it names are there, and hold the path at its times."""

from dataclasses import replace
from xml.etree import ElementTree

import meshlane
import numpy as np
import pytest
from command import run

import shakedown
from shakedown import UsageError
from shakedown.long_term.node_results import save_node_instants

TURNED = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])  # x and y of every node in the model


@pytest.fixture(scope="module")
def state():
    joint = replace(
        shakedown.example("four-node-3d"),
        coordinates=np.arange(12.0).reshape(4, 3),
        tangents=np.tile(TURNED, (4, 1, 1)),
        normal=np.tile([1.0, 0.0, 0.0], (4, 1)),
        faces=[[2, 1, 0, -1]],
        units="N, mm",
    )
    return shakedown.long_term_state(joint, 1.4)


def test_every_instant_is_a_file_with_the_path_at_its_time(state, tmp_path):
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
        np.testing.assert_array_equal(found.points, state.problem.coordinates)
        np.testing.assert_array_equal(found.point_data["v [mm]"], at.v[k].reshape(4, 2) @ TURNED)
        np.testing.assert_array_equal(found.point_data["q [N]"], at.q[k].reshape(4, 2) @ TURNED)
        np.testing.assert_array_equal(found.point_data["normal"], state.problem.normal)
        np.testing.assert_array_equal(found.point_data["cycle"], at.cycle[k])
        assert [(cells.type, cells.data.tolist()) for cells in found.cells] == [
            ("vertex", [[3]]),
            ("triangle", [[2, 1, 0]]),
        ]
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
