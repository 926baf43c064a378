"""Readers of matrices, nodal vectors and meshes with groups: round trips, content before name, one thing broken at a time."""

import meshlane
import numpy as np
import pytest
import writers
from hypothesis import given
from hypothesis import strategies as st
from model_files import HEAT

from shakedown import ProblemError
from shakedown.fem import ElasticBody, Material, brick_mesh, contact_condensation, read_mesh
from shakedown.models.readers.abaqus import read_nodal_loads
from shakedown.models.readers.formats import read_any_mesh, read_stiffness, stiffness_format
from shakedown.models.readers.mesh import CORNERS, EDGES
from shakedown.models.readers.mesh_files import read_universal
from shakedown.models.readers.nodal_vectors import (
    read_calculix_output,
    read_nodal_vectors,
    unit_displacement_stiffness,
)

DOFS = [(101, 1), (101, 2), (7, 1), (7, 2), (7, 3), (42, 1)]
K = writers.symmetric_matrix(len(DOFS))


def labelled(stiffness):
    """{((node, direction), (node, direction)): value}: what must survive, whatever the order of rows."""
    keys, dense = [tuple(row) for row in stiffness.dofs.tolist()], stiffness.K.toarray()
    return {(a, b): dense[i, j] for i, a in enumerate(keys) for j, b in enumerate(keys)}


def assert_same(stiffness, digits, dofs=DOFS, matrix=K):
    found = labelled(stiffness)
    assert set(found) == {(a, b) for a in dofs for b in dofs}
    for i, a in enumerate(dofs):
        for j, b in enumerate(dofs):
            assert found[a, b] == pytest.approx(matrix[i, j], rel=0, abs=digits * np.abs(matrix).max())


def write(tmp_path, text, name="wrong-name.npz"):
    path = tmp_path / name
    path.write_text(text)
    return path


LABELLED = {
    "abaqus lower": (writers.abaqus_matrix(K, DOFS), "abaqus-matrix", 1e-15),
    "abaqus upper": (writers.abaqus_matrix(K, DOFS, "upper"), "abaqus-matrix", 1e-15),
    "abaqus full": (writers.abaqus_matrix(K, DOFS, "full"), "abaqus-matrix", 1e-15),
    "substructure": (writers.abaqus_substructure(K, DOFS), "substructure", 1e-13),
    "substructure unsymmetric": (writers.abaqus_substructure(K, DOFS, True), "substructure", 1e-13),
    "dmig large": (writers.nastran_dmig(K, DOFS), "dmig", 1e-9),
    "dmig square": (writers.nastran_dmig(K, DOFS, form=1), "dmig", 1e-9),
    "dmig free": (writers.nastran_dmig(K, DOFS, style="free"), "dmig", 1e-15),
    "dmig small": (writers.nastran_dmig(K, DOFS, style="small"), "dmig", 1e-2),
}


@pytest.mark.parametrize("case", LABELLED)
def test_formats_with_labels_come_back(tmp_path, case):
    text, format, digits = LABELLED[case]
    path = write(tmp_path, text)
    assert stiffness_format(path) == format
    assert_same(read_stiffness(path), digits)


MAPPED = {
    "matrix market symmetric": (writers.matrix_market(K), "matrix-market", 1e-16),
    "matrix market general": (writers.matrix_market(K, symmetric=False), "matrix-market", 1e-16),
    "matrix market array": (writers.matrix_market(K, layout="array"), "matrix-market", 1e-16),
    "matrix market full": (writers.matrix_market(K, symmetric=False, layout="array"), "matrix-market", 1e-16),
    "op4 dense": (writers.nastran_op4(K), "op4", 1e-16),
    "op4 sparse": (writers.nastran_op4(K, style="sparse"), "op4", 1e-16),
    "op4 bigmat": (writers.nastran_op4(K, style="bigmat"), "op4", 1e-16),
    "numbered": (writers.calculix_storage(K, DOFS)[0], "numbered", 1e-13),
}


@pytest.mark.parametrize("case", MAPPED)
def test_formats_without_labels_come_back_with_a_map(tmp_path, case):
    text, format, digits = MAPPED[case]
    path, beside = write(tmp_path, text), write(tmp_path, writers.dof_map(DOFS), "rows.txt")
    assert stiffness_format(path) == format
    stiffness = read_stiffness(path, dof_map=beside)
    assert stiffness.dofs.tolist() == [list(dof) for dof in DOFS]
    assert_same(stiffness, digits)


@pytest.mark.parametrize("case", MAPPED)
def test_formats_without_labels_are_refused_without_a_map(tmp_path, case):
    path = write(tmp_path, MAPPED[case][0])
    with pytest.raises(ProblemError, match="expected a map file"):
        read_stiffness(path)
    short = write(tmp_path, writers.dof_map(DOFS[:-1]), "short.txt")
    with pytest.raises(ProblemError, match=r"expected (a map of 6|row and column numbers 1 to 5)"):
        read_stiffness(path, dof_map=short)


@given(st.permutations(range(len(DOFS))), st.sampled_from(["lower", "upper", "full"]))
def test_the_order_of_rows_does_not_matter(tmp_path_factory, order, triangle):
    text = writers.abaqus_matrix(K[np.ix_(order, order)], [DOFS[i] for i in order], triangle)
    assert_same(read_stiffness(write(tmp_path_factory.mktemp("order"), text)), 1e-15)


ABAQUS, SUBSTRUCTURE, DMIG = (LABELLED[name][0] for name in ("abaqus lower", "substructure", "dmig large"))
MARKET, OP4 = (MAPPED[name][0] for name in ("matrix market general", "op4 dense"))
FORCES = " forces (fx,fy,fz) for set N and time {}\n"


def mapped(path):
    return read_stiffness(path, dof_map=np.array(DOFS))


BROKEN = {
    "word for a number": (read_stiffness, ABAQUS + "1,1,1,1,x\n", "expected a number, found 'x'"),
    "entry twice": (read_stiffness, ABAQUS + ABAQUS.splitlines()[0], "expected every entry once"),
    "labels missing": (read_stiffness, SUBSTRUCTURE.replace("** 101, 7, 42", "** 101, 7"), "node labels in the comments"),
    "number missing": (read_stiffness, SUBSTRUCTURE.replace("*MATRIX,TYPE=MASS", "1.0"), "expected 21 numbers"),
    "position out of range": (read_stiffness, SUBSTRUCTURE.replace("2,1,2,3", "9,1,2,3"), "position 1 to 3"),
    "complex": (read_stiffness, DMIG.replace("0       6       2", "0       6       4"), "real .* found form 6, type 4"),
    "two matrices": (read_stiffness, DMIG + DMIG.replace("KAAX", "KBBX"), "expected one stiffness matrix, found KAAX, KBBX"),
    "two headers": (read_stiffness, DMIG * 2, "one DMIG header card"),
    "empty": (read_stiffness, "", "empty file"),
    "prose": (read_stiffness, "Dear all,\nplease find attached\n", "found 'Dear all,'"),
    "reactions": (read_stiffness, writers.calculix_reactions([([1], [[1.0, 0, 0]])]), "expected a matrix, found reactions"),
    "market complex": (mapped, "%%MatrixMarket matrix coordinate complex general\n6 6 1\n1 1 1.0 0\n", "real general"),
    "index twice": (mapped, MARKET.replace("\n2 1 ", "\n1 1 "), "entry once"),
    "entry missing": (mapped, MARKET.rsplit("\n", 2)[0], "expected 36 entries, found 35"),
    "value missing": (mapped, MAPPED["matrix market array"][0].rsplit("\n", 2)[0], "expected 21 numbers, found 20"),
    "no size": (mapped, "%%MatrixMarket matrix coordinate real general\n% nothing\n", "size of a square matrix"),
    "op4 too short": (mapped, "\n".join(OP4.splitlines()[:-4]), "expected whole matrices"),
    "op4 complex": (mapped, OP4.replace("       6       2", "       6       4", 1), "found type 4"),
    "sti four columns": (mapped, "1 1 2.0\n1 1 1 2.0\n", "MATRIX INPUT"),
    "two fields of a load": (read_nodal_loads, "1,2\n", "'node, dof, value'"),
    "load twice": (read_nodal_loads, "1,2,3\n1,2,4\n", "found .1, 2. twice"),
    "load of a set": (read_nodal_loads, "TOP, 2, 5.\n", "expected a node label, found the set 'TOP'"),
    "no forces": (read_calculix_output, "displacements (vx,vy,vz) for set N\n 1 0 0 0\n", "found no table"),
    "two forces": (read_calculix_output, FORCES.format(1.0) + " 1 0 0\n", "expected 'node fx fy fz'"),
    "no rows": (read_calculix_output, FORCES.format(1.0) + " 1 0 0 0\n" + FORCES.format(2.0), "empty table"),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_one_thing_broken_is_named(tmp_path, case):
    reader, text, message = BROKEN[case]
    with pytest.raises(ProblemError, match=message) as caught:
        reader(write(tmp_path, text))
    assert str(tmp_path) in str(caught.value)


def test_a_named_matrix_is_taken_out_of_several(tmp_path):
    text = writers.nastran_dmig(K, DOFS) + writers.nastran_dmig(2 * K, DOFS, name="MAAX")
    assert_same(read_stiffness(write(tmp_path, text)), 1e-9)  # the only one that starts with K
    assert_same(read_stiffness(write(tmp_path, text), matrix="MAAX"), 1e-9, matrix=2 * K)
    both = writers.nastran_op4(K) + writers.nastran_op4(3 * K, name="KBB")
    rows = write(tmp_path, writers.dof_map(DOFS), "rows.txt")
    assert_same(read_stiffness(write(tmp_path, both), dof_map=rows, matrix="KBB"), 1e-16, matrix=3 * K)
    with pytest.raises(ProblemError, match=r"expected one matrix .NO."):
        read_stiffness(write(tmp_path, both), dof_map=rows, matrix="NO")


PUNCH = """$ continuation names in columns 73 to 80, numbers that touch, exponents with D
DMIG    KAAX           0       6       2       0                       2
DMIG*   KAAX                           1               1                *K     1
*K     1               1               1 2.000000000D+00
*      1               1               2-1.866666647D+07
DMIG*   KAAX                           1               2                *K     2
*K     2               1               2 3.000000000D+00
DMIG    MAAX           0       6       2       0                       2
DMIG    MAAX           1       1               1       1     1.0
"""


def test_a_punch_file_with_continuation_names(tmp_path):
    found = read_stiffness(write(tmp_path, PUNCH))
    assert found.K.toarray().tolist() == [[2.0, -1.866666647e7], [-1.866666647e7, 3.0]]


def test_results_binary_and_missing_files_are_named(tmp_path):
    with pytest.raises(ProblemError, match="found the results of a CalculiX run"):
        stiffness_format(HEAT / "open.frd")
    path = tmp_path / "x.sim"
    path.write_bytes(b"\x01\0\0\0" * 100)
    with pytest.raises(ProblemError, match="found a binary one"):
        stiffness_format(path)
    with pytest.raises(ProblemError, match="no such file"):
        stiffness_format(tmp_path / "absent")
    with pytest.raises(ProblemError, match="expected a regular file, found a directory"):
        stiffness_format(tmp_path)


def unit_runs(matrix, nodes, order):
    """One run per contact degree of freedom of a stiffness in the order (node, direction)."""
    n = len(nodes)
    columns = range(2 * n) if order == "node-by-node" else np.arange(2 * n).reshape(n, 2).T.ravel()
    return [(nodes, np.column_stack([matrix[:, k].reshape(n, 2), np.full(n, 9.0)])) for k in columns]


@pytest.mark.parametrize("order", ["node-by-node", "direction-by-direction"])
def test_unit_displacements_make_a_stiffness(tmp_path, order):
    nodes, matrix = np.array([3, 8, 5]), writers.symmetric_matrix(6)
    path = write(tmp_path, writers.calculix_reactions(unit_runs(matrix, nodes, order)))
    found = unit_displacement_stiffness(read_calculix_output(path), nodes)
    np.testing.assert_allclose(found.K.toarray(), matrix, atol=1e-6 * matrix.max())
    assert found.dofs.tolist() == [[3, 1], [3, 2], [8, 1], [8, 2], [5, 1], [5, 2]]


def test_rigid_motions_survive_seven_digits(tmp_path):
    """A floating chain: without care the rounded stiffness has a negative eigenvalue."""
    n = 20
    difference = np.kron(np.diff(np.eye(n), axis=0), np.eye(2))
    spring = np.kron(np.diag(1.0 / (3.0 + np.arange(n - 1))), np.array([[2.0, 0.3], [0.3, 1.0]]))
    matrix, nodes = difference.T @ spring @ difference, np.arange(1, n + 1)
    path = write(tmp_path, writers.calculix_reactions(unit_runs(matrix, nodes, "node-by-node")))
    found = unit_displacement_stiffness(read_calculix_output(path), nodes).K.toarray()
    eigenvalues = np.linalg.eigvalsh(found)
    assert (np.abs(eigenvalues) < 1e-12 * eigenvalues[-1]).sum() == 2
    np.testing.assert_allclose(found, matrix, atol=1e-6 * matrix.max())


def test_unusable_reactions_are_named(tmp_path):
    nodes, matrix = np.array([3, 8, 5]), writers.symmetric_matrix(6)
    steps = read_calculix_output(
        write(tmp_path, writers.calculix_reactions(unit_runs(-matrix, nodes, "node-by-node")))
    )
    with pytest.raises(ProblemError, match="found them reversed"):
        unit_displacement_stiffness(steps, nodes)
    with pytest.raises(ProblemError, match="expected 4 steps"):
        unit_displacement_stiffness(steps, nodes[:2])
    with pytest.raises(ProblemError, match="expected contact node 9, found it not printed"):
        unit_displacement_stiffness(steps, np.array([3, 8, 9]))


def test_tables_of_several_sets_at_one_time_are_one_step(tmp_path):
    front = writers.calculix_reactions([([1, 2], np.ones((2, 3))), ([1, 2], 3 * np.ones((2, 3)))])
    back = writers.calculix_reactions([([8, 9], 2 * np.ones((2, 3))), ([8, 9], np.ones((2, 3)))], "NC1")
    halves = [text.split("\n forces") for text in (front, back)]
    text = "".join("\n forces".join(["", *pair]) for pair in zip(halves[0][1:], halves[1][1:], strict=True))
    steps = read_calculix_output(write(tmp_path, text))
    assert [step.node_sets for step in steps] == [("NC", "NC1")] * 2
    nodes, tied = np.array([2, 1]), np.array([9, 8])
    assert steps[0].at(nodes, (1, 2), tied).tolist() == [[3.0, 3.0], [3.0, 3.0]]
    with pytest.raises(ProblemError, match="one node for each of 2 contact nodes, found 1"):
        steps[0].at(nodes, (1, 2), tied[:1])


NODES = [7, 1042, 12345678]
STEPS = [(NODES, -np.arange(9.0).reshape(3, 3) / 7), (NODES, 1e-30 + np.arange(9.0).reshape(3, 3) * 1e5)]
TABLE = "step;node;U1;U2;U3\n" + "".join(
    f"{step};{node};{';'.join(map(repr, vector.tolist()))}\n"
    for step, (nodes, vectors) in enumerate(STEPS, 1)
    for node, vector in zip(nodes, vectors, strict=True)
)


FILES = {
    "dat": (writers.calculix_displacements(STEPS), 5e-7),
    "frd": (writers.calculix_frd(STEPS, ("FORC", "DISP")), 5e-6),
    "table": (TABLE, 0.0),
    "table without a heading": (TABLE.partition("\n")[2], 0.0),
}


@pytest.mark.parametrize("kind", FILES)
def test_every_file_has_the_same_displacements(tmp_path, kind):
    text, digits = FILES[kind]
    found = read_nodal_vectors(write(tmp_path, text), "displacements")
    assert [step.time for step in found] == [1.0, 2.0]
    for step, (nodes, vectors) in zip(found, STEPS, strict=True):
        assert step.nodes.tolist() == nodes
        assert step.what == "displacements"
        assert (np.abs(step.vectors - vectors) <= digits * np.abs(step.vectors)).all()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("-1.42857E-01", "", "line 10: expected a node with three numbers"),
        ("-1.42857E-01", "-1.4x857E-01", "line 10: expected a number, found '-1.4x857E-01'"),
        (" 1\n -4", " 7\n -4", r"expected a block in text form \(\*NODE FILE\), found the format '7'"),
        (f"{1042:10d}", f"{7:10d}", "expected every node once at time 1, found node 7 twice"),
    ],
)
def test_a_damaged_result_file_is_refused(tmp_path, old, new, message):
    text = writers.calculix_frd(STEPS[:1])
    assert old in text
    with pytest.raises(ProblemError, match=message):
        read_nodal_vectors(write(tmp_path, text.replace(old, new)))


def test_a_binary_result_file_is_refused(tmp_path):
    path = tmp_path / "job.frd"
    path.write_bytes((HEAT / "open.frd").read_bytes()[:2000] + b"\0\0")
    with pytest.raises(ProblemError, match=r"found a binary one \(.*CalculiX: \*NODE FILE\)"):
        read_nodal_vectors(path, "displacements")


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
}  # fmt: skip


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
    np.testing.assert_array_equal(mesh.normals(mesh.nodes("foot"), (1, 2, 3)), [[0, 0, 1]] * len(expected))
    assert mesh.element_sets["STEEL"].tolist() == [1, 2]
    if suffix == "med":
        np.testing.assert_array_equal(mesh.at(mesh.nodes("ends"))[:, 0], 0.0)
    body = ElasticBody(read_mesh(path), {"steel": STEEL})
    found = contact_condensation(body, "foot").stiffness
    same = contact_condensation(ElasticBody(BRICK, STEEL), "bottom").stiffness
    np.testing.assert_allclose(found, same, atol=1e-9 * np.abs(same).max())


@pytest.mark.parametrize(
    ("kind", "shape", "ring", "pillars"),
    [(118, "tetrahedron", 3, "points"), (113, "wedge", 3, "ring"), (116, "hexahedron", 4, "ring")],
)
def test_elements_of_second_order_in_unv(tmp_path, kind, shape, ring, pillars):
    """Nodes around the bottom, then those up from it, then those around the top, corners and middles in turn."""
    points = np.array(writers.CORNERS_OF[shape], dtype=float)

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
        ("  2412\n         1     ", "  2412\n         2     ", "every node and element once, found 2"),
        ("         8\n         1", "         7\n         1", "expected 8 nodes of an element, found 7"),
        ("         8\n         1", "        99\n         1", "expected 99 numbers|a whole number"),
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
