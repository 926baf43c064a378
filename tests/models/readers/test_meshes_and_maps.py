"""Decks, lists of nodes, bulk data and row maps: what they say, and one thing wrong at a time."""

import numpy as np
import pytest
import writers
from scipy import sparse

from shakedown import ProblemError
from shakedown.models.readers.abaqus import read_substructure_load
from shakedown.models.readers.deck import read_deck
from shakedown.models.readers.formats import read_any_mesh, read_stiffness
from shakedown.models.readers.mapped_matrices import read_harwell_boeing, read_row_map
from shakedown.models.readers.mesh import CORNERS, EDGES, Mesh
from shakedown.models.readers.mesh_files import read_coordinates
from shakedown.models.readers.nastran import read_analysis_set, read_grids
from shakedown.models.readers.nodal_vectors import read_vectors_table
from shakedown.models.readers.parsing import read_table
from shakedown.models.readers.stiffness import Stiffness

CUBE = """1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
"""
BRICKS = f"""*HEADING
Two bricks on each other
*PART, NAME=P
*END PART
*ASSEMBLY, NAME=A
*INSTANCE, NAME=P-1, PART=P
10., 0., 0.
*NODE, NSET=ALL
{CUBE}9, 0., 0., 2.
10, 1., 0., 2.
11, 1., 1., 2.
12, 0., 1., 2.
*ELEMENT, TYPE=C3D8R, ELSET=LOWER
1, 1, 2, 3, 4,
5, 6, 7, 8
*ELEMENT, TYPE=C3D8R, ELSET=UPPER
2, 5, 6, 7, 8, 9, 10, 11, 12
*NSET, NSET=base, GENERATE
1, 4, 1
*NSET, NSET=ends
base, 9, 10, 11,
12
*SURFACE, NAME=FRONT, TYPE=ELEMENT
LOWER, S3
2, S3
*END INSTANCE
*END ASSEMBLY
"""


def deck(tmp_path, text):
    path = tmp_path / "job.inp"
    path.write_text(text)
    return read_deck(path)


def test_normals_point_into_the_body(tmp_path):
    """Bottom, front and top of the bricks; the face between them is none."""
    mesh = deck(tmp_path, BRICKS)
    assert mesh.normals([1, 2, 3, 4], axes=(1, 3)).tolist() == [[0.0, 1.0]] * 4
    assert mesh.normals([9, 10, 11, 12], axes=(1, 3)).tolist() == [[0.0, -1.0]] * 4
    assert mesh.normals(mesh.nodes("FRONT"), axes=(1, 2)).tolist() == [[0.0, 1.0]] * 6
    with pytest.raises(ProblemError, match="in the plane of directions 1 and 2, found"):
        mesh.normals([1, 2, 3, 4])
    with pytest.raises(ProblemError, match="expected a face of the boundary at contact node 5"):
        mesh.normals([5, 6, 7, 8])
    with pytest.raises(ProblemError, match="expected a face of the boundary at contact node 1"):
        mesh.normals([1])


@pytest.mark.parametrize("shape", ["CPE3", "CPE4", "CPE6", "CPE8R", "C3D4", "C3D6", "C3D10", "C3D20"])
def test_every_shape_has_inward_normals_on_every_face(tmp_path, shape):
    """An element of every kind, turned: the normals of all its faces point to its middle."""
    names = {3: "triangle", 4: "quadrilateral", 6: "triangle", 8: "quadrilateral"}
    solids = {4: "tetrahedron", 6: "wedge", 8: "hexahedron", 10: "tetrahedron", 20: "hexahedron"}
    count = int("".join(filter(str.isdigit, shape[3:])))
    kind = (solids if shape.startswith("C3D") else names)[count]
    corners = writers.CORNERS_OF[kind]
    points = np.zeros((CORNERS[kind], 3))
    points[:, : len(corners[0])] = corners
    turn = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]])
    points = points @ turn.T
    middles = [(points[a] + points[b]) / 2 for a, b in EDGES[kind]]
    points = np.vstack([points, *middles])[:count] if count > CORNERS[kind] else points
    mesh = Mesh("a mesh", np.arange(1, count + 1), points, elements={1: (kind, tuple(range(1, count + 1)))})
    middle = points[: CORNERS[kind]].mean(axis=0)
    for facet in mesh.boundary(set(range(1, count + 1))):
        own = facet.corners
        inward, place = mesh.face_normals(facet.nodes)[0], mesh.at(own)
        assert inward @ (middle - place.mean(axis=0)) > 0
        assert np.abs((place - place[0]) @ inward).max() < 1e-14
        assert len(facet.between) == (0 if count == CORNERS[kind] else (1 if len(own) == 2 else len(own)))
        for node in facet.between:  # midside nodes lie on the face
            assert abs((mesh.at([node])[0] - place[0]) @ inward) < 1e-14


SQUARE = "*NODE\n1, 0., 0.\n2, 1., 0.\n3, 1., 1.\n4, 0., 1.\n*ELEMENT, TYPE=CPE4, ELSET=E\n1, 1, 2, 3, 4\n"


@pytest.mark.parametrize(
    "text",
    [
        SQUARE.replace("\n", "\r\n") + "*NSET, NSET=S\r\n1, 2\r\n",
        SQUARE.lower().replace(", ", ",\t") + "*nset,\n  nset=s\n\t1,\n2,\n",
        "\ufeff" + SQUARE + '*NSET, NSET="s", GENERATE\n 1 , 2 ,\n',
        SQUARE + "*NSET, NSET=1\n3\n*NSET, NSET=S\n1\n*NSET, NSET=S\n2\n",  # a number is a label first
        "*NODE, INPUT=nodes.txt\n" + SQUARE.partition("0., 1.\n")[2] + "*NSET, NSET=S\n1, 2\n",
        SQUARE + "*ELEMENT, TYPE=T3D2, ELSET=BAR\n7, 1, 2\n*SURFACE, NAME=S\nE, S1\n",
    ],
    ids=["crlf", "lower, tabs, continued", "mark, quoted, generated", "numbered", "input", "surface"],
)
def test_decks_in_other_dress(tmp_path, text):
    (tmp_path / "nodes.txt").write_text("** nodes\n" + SQUARE.partition("\n")[2].partition("*")[0])
    (tmp_path / "job.inp").write_bytes(text.encode())
    mesh = read_deck(tmp_path / "job.inp")
    assert mesh.nodes("S").tolist() == [1, 2]
    np.testing.assert_array_equal(mesh.at([2, 3]), [[1, 0, 0], [1, 1, 0]])
    assert mesh.elements[1] == ("quadrilateral", (1, 2, 3, 4))


def test_nodes_of_elements_and_cylindrical_coordinates(tmp_path):
    text = "*NODE, SYSTEM=C\n1, 2., 0., 5.\n2, 2., 90., 5.\n3, 1., 180.\n*ELEMENT, TYPE=CPE3, ELSET=E\n8, 1, 2, 3\n"
    mesh = deck(tmp_path, text + "*NODE\n4, 7., 8.\n*NSET, NSET=ALL, ELSET=E\n")
    places = [[2, 0, 5], [0, 2, 5], [-1, 0, 0], [7, 8, 0]]
    np.testing.assert_allclose(mesh.at([1, 2, 3, 4]), places, atol=1e-15)
    assert mesh.nodes("all").tolist() == [1, 2, 3]
    with pytest.raises(ProblemError, match="line 8: expected every element once, found element 8 twice"):
        deck(tmp_path, text + "*ELEMENT, TYPE=CPE3\n8, 3, 2, 1\n")


BRICK = f"""*NODE, NSET=NALL
{CUBE}*ELEMENT, TYPE=C3D8, ELSET=E
1, 1, 2, 3, 4, 5, 6, 7, 8
*NSET, NSET=NREF
8
*SURFACE, NAME=FOOT
1, S1
"""


@pytest.mark.parametrize(
    "change",
    {
        "a comma at the end": ("7, 8\n*NSET", "7, 8,\n*NSET"),
        "two of them": ("7, 8\n*NSET", "7, 8,\n2, 8, 7, 6, 5, 4, 3, 2, 1,\n*NSET"),
        "an equation removed": ("*NSET", "*EQUATION, REMOVE\nNALL, 3\n*NSET"),
        "an equation of an empty line": ("*NSET", "*EQUATION\n,\n2\n5, 1, 1., 1, 1, -1.\n*NSET"),
        "a shell with a surface": (
            "*NSET",
            "*ELEMENT, TYPE=S4\n2, 5, 6, 7, 8\n*SURFACE, NAME=SKIN\n2, S2\n*NSET",
        ),
        "a section of a set": ("1, S1\n", "1, S1\n*PRE-TENSION SECTION, SURFACE=CUT, NODE=NREF\n"),
        "a set with the number of an element": ("ELSET=E\n1,", "ELSET=1\n2, 8, 7, 6, 5, 4, 3, 2, 1\n1,"),
    }.values(),
)
def test_what_codes_take_is_taken(tmp_path, change):
    assert change[0] in BRICK
    mesh = deck(tmp_path, BRICK.replace(*change, 1))
    assert mesh.nodes("FOOT").tolist() == [1, 2, 3, 4]
    assert mesh.sections == ((8,) if "SECTION" in change[1] else ())


@pytest.mark.parametrize(("moved", "shift"), [("5.", [5, 0, 0]), ("1.,,", [1, 0, 0]), (",, 3.", [0, 0, 3])])
def test_an_instance_is_moved_with_its_nodes(tmp_path, moved, shift):
    """Where the part comes first, and where its nodes stand in the instance; nodes of the assembly stay."""
    instance = f"*ASSEMBLY, NAME=A\n*INSTANCE, NAME=I, PART=P\n{moved}\n"
    for text in (f"*PART, NAME=P\n{BRICK}*END PART\n{instance}", f"{instance}{BRICK}"):
        mesh = deck(tmp_path, f"{text}*END INSTANCE\n*NODE\n90, 1., 1., 1.\n*END ASSEMBLY\n")
        assert mesh.at([1, 90]).tolist() == [shift, [1.0, 1.0, 1.0]]


def test_files_that_include_each_other_many_times_are_refused(tmp_path):
    for k in range(8):
        (tmp_path / f"f{k}.inp").write_text(f"*INCLUDE, INPUT=f{k + 1}.inp\n" * 5)
    (tmp_path / "f8.inp").write_text("*NSET, NSET=A\n1\n")
    with pytest.raises(ProblemError, match="of 1000 files and 16777216 lines in all, found more"):
        deck(tmp_path, "*NODE\n1, 0., 0.\n*INCLUDE, INPUT=f0.inp\n")


def test_systems_move_and_turn_the_nodes_behind_them(tmp_path):
    turned = "*SYSTEM\n0., 5., 0., 1., 5., 0.\n0., 5., 1.\n*NODE\n1, 1., 2., 3.\n"
    about_z = "*SYSTEM\n1., 0., 7., 1., 1., 7.\n*NODE\n2, 1., 2., 3.\n"
    moved = "*SYSTEM\n1., 0., 0.\n*NODE\n3, 1., 2., 3.\n*SYSTEM\n*NODE\n4, 1., 2., 3.\n"
    found = deck(tmp_path, turned + about_z + moved).coordinates
    assert found.tolist() == [[1.0, 2.0, 2.0], [-1.0, 1.0, 10.0], [2.0, 2.0, 3.0], [1.0, 2.0, 3.0]]


NLIST = """
 LIST ALL SELECTED NODES.   DSYS=      0

    NODE        X                   Y                   Z           THXY     THYZ     THZX
       1   0.000000000000      0.500000000000      0.000000000000        0.00     0.00     0.00

    NODE        X                   Y                   Z           THXY     THYZ     THZX
       7   1.000000000000      0.000000000000     -2.000000000000        0.00     0.00     0.00
"""
ARCHIVE = """/PREP7
/COM, one component of nodes
NBLOCK,6,SOLID,     8,     4
(3i9,6e21.13e3)
        1        0        0 0.0000000000000E+000 5.0000000000000E-001
        2        0        0 1.0000000000000E+000
        3        0        0
        7        0        0 1.0000000000000E+000 0.0000000000000E+000-2.0000000000000E+000
N,R5.3,LOC,       -1,
CMBLOCK,FOOT    ,NODE,       3  ! users node component definition
(8i10)
         1        -3         7
CMBLOCK,BODY    ,ELEM,       1
(8i10)
         4
FINISH
"""


@pytest.mark.parametrize("text", [NLIST, ARCHIVE], ids=["NLIST", "archive"])
def test_nodes_are_read_as_ansys_writes_them(tmp_path, text):
    (tmp_path / "nodes").write_text(text)
    mesh = read_any_mesh(tmp_path / "nodes")
    assert mesh.at([1, 7]).tolist() == [[0.0, 0.5, 0.0], [1.0, 0.0, -2.0]]
    if text is ARCHIVE:
        assert {name: own.tolist() for name, own in mesh.node_sets.items()} == {"FOOT": [1, 2, 3, 7]}


COLLAPSED = {  # which corner stands at each of those of a brick or a quadrilateral
    "hexahedron": (0, 1, 2, 3, 4, 5, 6, 7),
    "wedge": (0, 1, 2, 2, 3, 4, 5, 5),
    "tetrahedron": (0, 1, 2, 2, 3, 3, 3, 3),
    "quadrilateral": (0, 1, 2, 3),
    "triangle": (0, 1, 2, 2),
}


@pytest.mark.parametrize("quadratic", [False, True])
@pytest.mark.parametrize("shape", COLLAPSED)
def test_elements_of_an_archive_with_nodes_that_coincide(tmp_path, shape, quadratic):
    brick = "quadrilateral" if len(COLLAPSED[shape]) == 4 else "hexahedron"
    edges = {frozenset(edge): CORNERS[shape] + k + 1 for k, edge in enumerate(EDGES[shape])}
    nodes = [corner + 1 for corner in COLLAPSED[shape]]
    if quadratic:
        ends = [[COLLAPSED[shape][k] for k in edge] for edge in EDGES[brick]]
        nodes += [edges.get(frozenset(two), two[0] + 1) for two in ends]
    count = CORNERS[shape] + len(EDGES[shape]) * quadratic
    places = {label: np.random.default_rng(label).random(3) for label in range(1, count + 1)}
    number = {("hexahedron", 0): 185, ("hexahedron", 1): 186, ("quadrilateral", 0): 182}.get(
        (brick, quadratic), 183
    )
    parts = {"FOOT": ("NODE", [1, -2]), "BODY": ("ELEM", [7])}
    (tmp_path / "m.cdb").write_text(writers.ansys_archive(places, {7: (1, nodes)}, parts, (number,)))
    mesh = read_any_mesh(tmp_path / "m.cdb")
    assert mesh.elements == {7: (shape, tuple(range(1, count + 1)))}
    assert mesh.nodes("FOOT").tolist() == [1, 2]
    assert mesh.element_sets["BODY"].tolist() == [7]


def test_other_elements_of_an_archive_have_no_faces(tmp_path):
    places = {label: np.random.default_rng(label).random(3) for label in range(1, 9)}
    cells = {2: (1, [1, 2, 3, 4, 5, 5, 5, 5]), 3: (2, [1, 2, 3, 4])}  # a pyramid and a shell
    (tmp_path / "m.cdb").write_text(writers.ansys_archive(places, cells, {}, (185, 181)))
    assert read_any_mesh(tmp_path / "m.cdb").elements == {}


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("kind", ["%d", "%.18e", "equations"])
def test_maps_count_directions_from_0_or_1_and_may_be_floats(tmp_path, first, kind):
    rows = np.array([(7, 1), (7, 2), (9, 1), (9, 2)])
    given, path = rows + np.array([0, first - 1]), tmp_path / "map"
    if kind == "equations":
        np.savetxt(path, np.column_stack([np.arange(first, first + 4), given]), fmt="%d")
    else:
        np.savetxt(path, given, fmt=kind)
    assert read_row_map(path).tolist() == rows.tolist()


MAPS = {
    "node direction": "11 1\n11 2\n7 1\n7 2\n",
    "names": "node,dof\n11,UX\n11,UY\n7,ux\n7,uy\n",
    "equations, any order": "Matrix Eqn  Node  DOF\n3 7 UX\n4 7 UY\n1 11 UX\n2 11 UY\n",
    "node vector": "%%MatrixMarket matrix array integer general\n% by hand\n2 1\n11\n7\n",
    "one node per row": "%%MatrixMarket matrix array integer general\n4 1\n11\n11\n7\n7\n",
    "plain nodes": "11\n7\n",
    "deck": "*NODE\n11, 0., 0.\n7, 1., 0.\n",
    "bulk data": "EXTRN         11      12       7      12\n",
}


@pytest.mark.parametrize("kind", MAPS)
def test_every_kind_of_row_map_says_the_same(tmp_path, kind):
    path = tmp_path / "rows"
    path.write_text(MAPS[kind])
    assert read_row_map(path, 4).tolist() == [[11, 1], [11, 2], [7, 1], [7, 2]]


@pytest.mark.parametrize(("size", "each"), [(2, 1), (6, 3), (12, 6)])
def test_nodes_alone_have_equally_many_directions(tmp_path, size, each):
    (tmp_path / "rows").write_text("11\n7\n")
    expected = [[node, direction] for node in (11, 7) for direction in range(1, each + 1)]
    assert read_row_map(tmp_path / "rows", size).tolist() == expected
    with pytest.raises(ProblemError, match="equally many directions each, found 2 nodes"):
        read_row_map(tmp_path / "rows", 14)


SETS = {
    "extrn in its own order": ("EXTRN          9      21       3       0\n", [[9, 2], [9, 1], [3, 0]]),
    "aset sorted": ("ASET           9      12       3     123\n", [[3, 1], [3, 2], [3, 3], [9, 1], [9, 2]]),
    "aset1 with thru": ("ASET1         12       3    THRU       4\n", [[3, 1], [3, 2], [4, 1], [4, 2]]),
    "several sets": ("BSET1,1,3,9\nQSET1,0,100,THRU,101\n", [[3, 1], [9, 1], [100, 0], [101, 0]]),
    "large field": ("ASET*                  3              12\n*\n", [[3, 1], [3, 2]]),
    "uset": ("USET,U1,3,12\nUSET1,U1,1,9\n", [[3, 1], [3, 2], [9, 1]]),
    "seconct": (
        "SECONCT      102       0              NO\n               3       3     101     101\nGRID,3,,0.,0.,0.\nSPOINT,101\n",
        [*([3, d] for d in range(1, 7)), [101, 0]],
    ),
}


@pytest.mark.parametrize("kind", SETS)
def test_the_analysis_set(tmp_path, kind):
    text, rows = SETS[kind]
    (tmp_path / "x.pch").write_text(text)
    assert read_analysis_set(tmp_path / "x.pch").tolist() == rows


def test_grid_points_come_with_their_own_directions(tmp_path):
    """A cylindrical system: directions radial, tangential and axial at each point."""
    (tmp_path / "x.pch").write_text(
        "CORD2C,5,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nGRID,1,5,2.,90.,3.,5\nGRID,2,,1.,1.,0.\n"
    )
    mesh = read_grids(tmp_path / "x.pch")
    np.testing.assert_allclose(mesh.at([1, 2]), [[0.0, 2.0, 3.0], [1.0, 1.0, 0.0]], atol=1e-12)
    assert list(mesh.frames) == [1]
    np.testing.assert_allclose(mesh.frames[1], [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-12)


def test_rows_in_directions_of_their_own_are_turned():
    """A spring along the x of a turned point acts along y of the model."""
    dofs = np.array([(7, 1), (7, 2), (7, 3)])
    own = Stiffness(sparse.csr_array(np.diag([5.0, 1.0, 2.0])), dofs, "by hand")
    turned = own.in_basic_directions({7: np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])})
    np.testing.assert_array_equal(turned.K.toarray(), np.diag([1.0, 5.0, 2.0]))
    short = Stiffness(sparse.csr_array(np.eye(2)), dofs[:2], "by hand")
    with pytest.raises(ProblemError, match="expected all rows of node 7"):
        short.in_basic_directions({7: np.eye(3)})
    assert short.in_basic_directions({8: np.eye(3)}) is short


DOFS = np.array([(1, 1), (1, 2), (2, 1), (2, 2), (3, 1)])
K = writers.symmetric_matrix(5)


@pytest.mark.parametrize(
    ("kind", "stored"),
    [
        ("RSA", lambda i, j: i >= j),
        ("RSA", lambda i, j: i <= j),
        ("RSA", lambda i, j: True),  # as Ansys writes superelements
        ("RUA", lambda i, j: True),
    ],
)
def test_harwell_boeing_comes_back(tmp_path, kind, stored):
    (tmp_path / "k.matrix").write_text(writers.harwell_boeing(K, kind, stored))
    found = read_stiffness(tmp_path / "k.matrix", dof_map=DOFS)
    assert found.format == "Harwell-Boeing"
    np.testing.assert_allclose(found.K.toarray(), K, rtol=1e-15)


TABLES = {
    "tab": "t\tf\n0.0\t1.5\n0.5\t-2.0\n",
    "semicolon, decimal comma": "t;f\n0,0;1,5\n0,5;-2,0\n",
    "comma": "t,f\n0.0,1.5\n0.5,-2.0\n",
    "comma and blank": '"t", "f"\n0.0, 1.5\n0.5, -2.0\n',
    "blank": "t f\n0.0 1.5\n0.5 -2.0D0\n",
    "blank, decimal comma": "t f\n0,0 1,5\n0,5 -2,0\n",
    "comment, trailing tab": "# made by hand\nt\tf\t\n0,0\t1,5\t\n0,5\t-2,\t\n",
}


@pytest.mark.parametrize("kind", TABLES)
def test_tables_in_every_dress(tmp_path, kind):
    (tmp_path / "h.csv").write_text(TABLES[kind])
    table = read_table(tmp_path / "h.csv")
    assert table.columns == ("t", "f")
    assert table.values.tolist() == [[0.0, 1.5], [0.5, -2.0]]
    assert table.column("F").tolist() == table.column(2).tolist() == [1.5, -2.0]


NODES = "Knotennummer\tX-Position (m)\tY-Position (m)\tZ-Position (m)\t\n7\t-4,99e-016\t1,e-001\t0,15\n3\t1\t2\t3\n"


def test_a_list_of_nodes_as_ansys_writes_it(tmp_path):
    (tmp_path / "nodes.txt").write_text(NODES)
    mesh = read_coordinates(tmp_path / "nodes.txt")
    assert mesh.labels.tolist() == [7, 3]
    assert mesh.at([7]).tolist() == [[-4.99e-16, 0.1, 0.15]]


def test_loads_of_a_substructure(tmp_path):
    """Positions of the node list, in comment lines behind the matrices."""
    text = writers.abaqus_substructure(K, [tuple(row) for row in DOFS.tolist()])
    text += "** SUBSTRUCTURE LOAD CASE VECTOR. SLOAD CASE: LC1\n** *CLOAD\n**     1,     2, 0.1E+02\n**     3,     1,-5.0\n"
    text += "** SUBSTRUCTURE LOAD CASE VECTOR. SLOAD CASE: LC2\n** *CLOAD\n**     2,     1, 7.0\n"
    path = tmp_path / "sub.mtx"
    path.write_text(text)
    assert read_substructure_load(path, "lc1") == {(1, 2): 10.0, (3, 1): -5.0}
    assert read_substructure_load(path, "LC2") == {(2, 1): 7.0}
    with pytest.raises(ProblemError, match="found LC1, LC2"):
        read_substructure_load(path)
    path.write_text(text.replace("     3,     1,-5.0", "     4,     1,-5.0"))
    with pytest.raises(ProblemError, match="a position from 1 to 3, found 4"):
        read_substructure_load(path, "LC1")


READERS = {  # by kind: a reader, and a text that it reads
    "deck": (lambda path: read_deck(path).nodes("NO SUCH SET"), BRICKS),
    "surface": (lambda path: read_deck(path).nodes("FOOT"), BRICK),
    "archive": (read_any_mesh, ARCHIVE),
    "hb": (lambda path: read_harwell_boeing(path, DOFS), writers.harwell_boeing(K)),
    "nodes": (read_coordinates, NODES),
    "rows": (lambda path: read_row_map(path, 4), ""),
    "table": (read_table, ""),
    "forces": (read_vectors_table, ""),
}
ONE_THING_WRONG = [  # what is replaced by what, and what is said of it
    ("deck", "3, 1., 1., 0.\n", "3, 1., 1., 0.\n3, 1., 1., 0.\n", "found node 3 twice"),
    ("deck", "3, 1., 1., 0.", "3, 1., one, 0.", "line 11: expected a number, found 'one'"),
    ("deck", "base, 9, 10", "base, 9, 99", "expected a member of 'ENDS', found 99"),
    ("deck", "1, 4, 1\n", "4, 1, 1\n", "expected 'first, last, step'"),
    ("deck", "LOWER, S3", "LOWER, S9", "expected the node set or surface"),
    ("deck", "5, 6, 7, 8\n*ELEMENT", "5, 6, 7\n*ELEMENT", "expected 8 nodes of an element, found 7"),
    ("deck", "*END INSTANCE", "*INSTANCE, NAME=Q\n*END INSTANCE", "expected one part instance"),
    ("deck", "10., 0., 0.\n*NODE", "10., 0., 0., 0., 0., 1., 90.\n*NODE", "found it turned"),
    ("deck", "*HEADING", "*INCLUDE, INPUT=none.inp", "none.inp: no such file"),
    ("deck", "base, 9, 10", "later, 9", "expected labels or earlier sets as members of 'ENDS', found 'later'"),
    ("deck", "*HEADING\nTwo bricks on each other", "*SYSTEM\n1., 0., 0., 1., 0., 0.", "SYSTEM: expected two directions that span a plane"),
    ("deck", "*HEADING", "*NGEN, NSET=MORE\n1, 4", "every node and element to be listed, found \\*NGEN"),
    ("deck", "*HEADING", "*NODE, SYSTEM=S\n90, 1., 2., 3.", "expected coordinates of SYSTEM=R or C, found 'S'"),
    ("deck", "*HEADING", "*NSET, NSET=W, ELSET=NONE\n*HEADING", "expected the element set 'NONE' of \\*NSET"),
    ("archive", "        -3 ", "        -9 ", "expected node 4, found no coordinates of it"),
    ("archive", "        -3 ", "-999999999 ", "component 'FOOT': expected the end of a range after 1"),
    ("archive", "(3i9,6e21.13e3)", "here", "line 4: expected a layout like"),
    ("archive", "        2        0", "        x        0", "line 6: expected a whole number, found 'x'"),
    ("archive", "        2        0", "        1        0", "found node 1 twice"),
    ("archive", "        -3         7", "        -3", "component 'FOOT': expected 3 numbers, as its first line says, found 2"),
    ("hb", "RSA", "RSE", "real assembled square matrix"),
    ("hb", "(16I5)", "(0I5)", "Fortran format"),
    ("hb", "    1    6", "    1   99", "column pointers"),
    ("hb", "    5    5", "    5    6", "expected"),
    ("rows", "", "1 7 UX\n1 7 UY\n", "expected equations 1 to 2, each once"),
    ("rows", "", "7 1\n7\n", "expected 'node direction'"),
    ("rows", "", "1\n2\n3\n", "equally many directions each, found 3 nodes"),
    ("rows", "", "1\n1\n1\n2\n", "every node equally often"),
    ("rows", "", "%%MatrixMarket matrix array real general\n2 1\n1.0\n2.0\n", "expected a node vector"),
    ("rows", "", "%%MatrixMarket matrix array integer general\n3 1\n1\n2\n", "expected 3 nodes, found 2"),
    ("rows", "", "$ nothing\nSPOINT 1\n", "expected the rows of the analysis set"),
    ("table", "", "t,f\n", "rows of numbers below the header"),
    ("table", "", "t,f\n1,2\n3\n", "line 3: expected 2 columns, found 1"),
    ("table", "", "t,f\n1,1e999\n", "expected a finite number"),
    ("table", "", "# nothing\n", "expected rows of numbers, found none"),
    ("forces", "", "step,node,fx,fy\n1,7,1,2\n1,7,3,4\n", "found node 7 twice in step 1"),
    ("forces", "", "step,node,fx,fy\n1,7.5,1,2\n", "expected a whole number in column 'node', found 7.5"),
    ("nodes", "7\t", "3\t", "found node 3 twice"),
    ("nodes", "7\t", "7,5\t", "whole number"),
    ("surface", "1, S1", "7, S3", "line 15: expected a face of element 7"),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "old", "new", "message"), ONE_THING_WRONG)
def test_one_thing_wrong_is_named(tmp_path, kind, old, new, message):
    reader, text = READERS[kind]
    assert old in text
    (tmp_path / "damaged").write_text(text.replace(old, new, 1))
    with pytest.raises(ProblemError, match=message):
        reader(tmp_path / "damaged")
