"""Meshes with groups: MED, Gmsh, VTU, UNV and archives of Ansys, for an import and for bodies."""

import meshlane
import numpy as np
import pytest
import writers

from shakedown import ProblemError
from shakedown.fem import ElasticBody, Material, brick_mesh, contact_condensation, read_mesh
from shakedown.models.readers.formats import read_any_mesh
from shakedown.models.readers.mesh import CORNERS, EDGES
from shakedown.models.readers.mesh_files import read_universal

STEEL = Material(200.0, 0.3)
BRICK = brick_mesh((2.0, 1.0, 1.0), (2, 1, 1))
ORDER = [0, 3, 6, 2, 1, 5, 7, 4]  # of the corners of scikit-fem's hexahedra


def hexahedra():
    return BRICK.t[ORDER].T.astype(int)


def sides(name):
    """Quadrilaterals on a side, in order around each."""
    found = []
    for facet in BRICK.boundaries[name]:
        corners = BRICK.facets[:, facet]
        arms = BRICK.p[:, corners].T - BRICK.p[:, corners].T.mean(axis=0)
        flat = arms[:, np.ptp(arms, axis=0) > 0]
        found.append(corners[np.argsort(np.arctan2(*flat.T))].tolist())
    return found


def grouped(path):
    """The brick with the groups steel (elements), foot (sides) and ends (nodes), as meshlane writes it."""
    foot, ends = sides("bottom"), np.flatnonzero(BRICK.p[0] == 0)
    blocks = [("hexahedron", hexahedra()), ("quad", foot)]
    sets = {"steel": [[0, 1], []], "foot": [[], list(range(len(foot)))]}
    if path.suffix == ".msh":
        tags = [np.full(2, 1), np.full(len(foot), 1)]  # the same number in two dimensions
        data = {"gmsh:physical": tags, "gmsh:geometrical": tags}
        named = {"steel": np.array([1, 3]), "foot": np.array([1, 2])}
        mesh = meshlane.Mesh(BRICK.p.T, blocks, cell_data=data, field_data=named)
        mesh.write(path, file_format="gmsh22", binary=False)
    else:
        points = {} if path.suffix == ".vtu" else {"ends": ends}
        meshlane.Mesh(BRICK.p.T, blocks, cell_sets=sets, point_sets=points).write(path)
    return path


GMSH_NODES = {
    "2.2": "4\n10 0 0 0\n20 1 0 0\n99 0 1 0\n35 1 1 0\n",
    "4.0": "2 4\n1 1 0 2\n10 0 0 0\n20 1 0 0\n1 2 0 2\n99 0 1 0\n35 1 1 0\n",
    "4.1": "2 4 10 99\n1 1 0 2\n10\n20\n0 0 0\n1 0 0\n2 1 0 2\n99\n35\n0 1 0\n1 1 0\n",
}
GMSH_ELEMENTS = {
    "2.2": "1\n1 3 2 1 1 10 20 35 99\n",
    "4.0": "1 1\n1 2 3 1\n1 10 20 35 99\n",
    "4.1": "1 1 1 1\n2 1 3 1\n1 10 20 35 99\n",
}


@pytest.mark.parametrize("version", GMSH_NODES)
def test_nodes_keep_the_numbers_that_gmsh_gives_them(tmp_path, version):
    """They need not be 1 to n, nor in order: the map of a matrix names them."""
    nodes, elements = GMSH_NODES[version], GMSH_ELEMENTS[version]
    (tmp_path / "m.msh").write_text(
        f"$MeshFormat\n{version} 0 8\n$EndMeshFormat\n$Nodes\n{nodes}$EndNodes\n"
        f"$Elements\n{elements}$EndElements\n"
    )
    mesh = read_any_mesh(tmp_path / "m.msh")
    assert mesh.at([35, 99]).tolist() == [[1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
    assert mesh.elements == {1: ("quadrilateral", (10, 20, 35, 99))}


def test_a_binary_gmsh_file_with_other_numbers_is_refused(tmp_path):
    """As meshlane does not say which they are."""
    path = tmp_path / "m.msh"
    meshlane.Mesh(BRICK.p.T, [("hexahedron", hexahedra())]).write(path, file_format="gmsh", binary=True)
    assert read_any_mesh(path).labels.tolist() == list(range(1, 13))
    numbers = np.array([1, 12, 1, 12], dtype=np.uint64)
    other = np.array([1, 12, 5, 16], dtype=np.uint64)
    assert numbers.tobytes() in path.read_bytes()
    path.write_bytes(path.read_bytes().replace(numbers.tobytes(), other.tobytes()))
    with pytest.raises(ProblemError, match=r"m.msh.*expected nodes 1 to 12, found 5 to 16"):
        read_any_mesh(path)


@pytest.mark.parametrize("suffix", ["med", "msh", "vtu"])
def test_groups_are_sets_surfaces_and_boundaries(tmp_path, suffix):
    """Whatever the file is called."""
    path = grouped(tmp_path / f"brick.{suffix}").rename(tmp_path / "mesh.dat")
    mesh, expected = read_any_mesh(path), np.unique(sides("bottom")) + 1
    assert sorted(mesh.nodes("Foot").tolist()) == expected.tolist()
    np.testing.assert_array_equal(
        mesh.normals(mesh.nodes("foot"), (1, 2, 3)), [[0.0, 0.0, 1.0]] * len(expected)
    )
    assert mesh.element_sets["STEEL"].tolist() == [1, 2]
    if suffix == "med":
        np.testing.assert_array_equal(mesh.at(mesh.nodes("ends"))[:, 0], 0.0)
    body = ElasticBody(read_mesh(path), {"steel": STEEL})
    found = contact_condensation(body, "foot").stiffness
    same = contact_condensation(ElasticBody(BRICK, STEEL), "bottom").stiffness
    np.testing.assert_allclose(found, same, atol=1e-9 * np.abs(same).max())


CORNERS_OF = {
    "tetrahedron": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "wedge": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1)],
    "hexahedron": [(x, y, z) for z in (0, 1) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))],
}


@pytest.mark.parametrize(
    ("kind", "shape", "ring", "pillars"),
    [(118, "tetrahedron", 3, "points"), (113, "wedge", 3, "ring"), (116, "hexahedron", 4, "ring")],
)
def test_elements_of_second_order_in_unv(tmp_path, kind, shape, ring, pillars):
    """Nodes around the bottom, then those up from it, then those around the top, corners and middles in turn."""
    points = np.array(CORNERS_OF[shape], dtype=float)

    def around(first):
        ends = points[first : first + ring]
        return np.stack([ends, (ends + np.roll(ends, -1, axis=0)) / 2], axis=1).reshape(-1, 3)

    top = points[ring:] if pillars == "points" else around(ring)
    ups = (points[:ring] + (points[ring:] if pillars == "ring" else points[ring])) / 2
    places, labels = np.vstack([around(0), ups, top]), np.arange(11, 11 + CORNERS[shape] + len(EDGES[shape]))
    (tmp_path / "m.unv").write_text(writers.universal(places, labels, [(kind, labels.tolist())]))
    mesh = read_universal(tmp_path / "m.unv")
    found, own = mesh.elements[1]
    assert found == shape
    np.testing.assert_array_equal(mesh.at(own[: CORNERS[shape]]), points)
    middles = [(points[a] + points[b]) / 2 for a, b in EDGES[shape]]
    np.testing.assert_array_equal(mesh.at(own[CORNERS[shape] :]), middles)


@pytest.fixture
def unv(tmp_path):
    foot = sides("bottom")
    cells = [
        *((115, (own + 1).tolist()) for own in hexahedra()),
        *((94, [n + 1 for n in own]) for own in foot),
    ]
    groups = [("steel", 8, [1, 2]), ("foot", 8, list(range(3, 3 + len(foot)))), ("ends", 7, [1, 2])]
    path = tmp_path / "brick.unv"
    path.write_text(writers.universal(BRICK.p.T, range(1, BRICK.nvertices + 1), cells, groups))
    return path


def test_groups_of_unv(unv):
    mesh = read_any_mesh(unv)
    assert sorted(mesh.nodes("FOOT").tolist()) == (np.unique(sides("bottom")) + 1).tolist()
    assert mesh.nodes("ends").tolist() == [1, 2]
    skfem = read_mesh(unv)
    assert {name: len(own) for name, own in skfem.boundaries.items()} == {"foot": 2}
    assert {name: len(own) for name, own in skfem.subdomains.items()} == {"steel": 2}


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "  2412\n         1       115",
            "  2412\n         2       115",
            "every node and element once, found 2",
        ),
        ("         8\n         1", "         7\n         1", "expected 8 nodes of an element, found 7"),
        (
            "         8\n         1",
            "        99\n         1",
            "expected whole|expected 99 numbers|a whole number",
        ),
        ("0.0000000000000000D+00", "x", "expected a number, found 'x'"),
        ("-1\n  2412", "  2412", "expected the end of a dataset"),
        ("         1       115", "         1", "expected the head of a record"),
    ],
)
def test_one_thing_wrong_in_unv_is_named(unv, old, new, message):
    assert old in unv.read_text()
    unv.write_text(unv.read_text().replace(old, new, 1))
    with pytest.raises(ProblemError, match=message):
        read_any_mesh(unv)
