"""Import of solid models: two tangents per node, when a plane is meant, and CalculiX's own elements."""

import meshed_apart
import numpy as np
import pytest
import solids
import writers
from calculix import ccx, needs_ccx
from command import run
from meshed_apart import LOADS
from scipy.linalg import block_diag
from scipy.sparse import csr_array

from shakedown import ProblemError, UsageError, import_model
from shakedown.models.importing.contact_figure import contact_picture
from shakedown.models.importing.model_evidence import rigid_residual
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.stiffness import Stiffness

PAIRS = 'pairs = ["UPPER_FOOT", "LOWER_TOP"]'


def configuration(folder, contact=PAIRS, loads=LOADS, name="import.toml", supports=""):
    return meshed_apart.configuration(folder, contact, supports, loads=loads, name=name)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    target = tmp_path_factory.mktemp("blocks")
    solids.write_model(target, solids.places())
    return target


@pytest.fixture(scope="module")
def made(folder):
    return import_model(configuration(folder))


def test_two_blocks_come_without_hand_work(made):
    problem, n = made.problem, 12
    assert (problem.n, problem.directions, made.condensation.zero_modes) == (n, 2, 6)
    assert made.contact.names[0] == "25/13"
    np.testing.assert_allclose(problem.normal, np.tile([0.0, 0.0, 1.0], (n, 1)), atol=1e-15)
    np.testing.assert_allclose(problem.tangents, np.tile(np.eye(3)[:2], (n, 1, 1)), atol=1e-15)
    np.testing.assert_allclose(problem.x, problem.coordinates[:, :2])
    assert problem.node_area.sum() == pytest.approx(3.0)
    corners = problem.coordinates[problem.faces]  # four around each rectangle
    np.testing.assert_allclose(corners[:, 0] + corners[:, 2], corners[:, 1] + corners[:, 3])
    np.testing.assert_array_equal(np.bincount(problem.faces.ravel()).sum(), 4 * 6)
    assert made.notes[0].startswith("floating: 6 rigid motion(s)")
    assert len(made.notes) == 1
    assert made.rigid_residual > 0.1  # the lower block is held
    for load in made.loads:
        np.testing.assert_allclose(load.contact, -load.applied, atol=1e-9 * np.abs(load.applied).max())


def test_blocks_that_nothing_holds_resist_no_rigid_motion():
    """And all nodes of the mesh have rows."""
    xyz = solids.places()
    K, dofs = solids.stiffness(xyz, held=())
    mesh = Mesh("blocks", np.arange(1, len(xyz) + 1), xyz)
    assert rigid_residual(Stiffness(csr_array(K), dofs, "numbered"), mesh, (1, 2, 3)) < 1e-12


def turned(vector):
    """x → z, y → x, z → y: the interface then has the normal y."""
    return np.asarray(vector)[..., [1, 2, 0]]


def test_a_normal_in_the_plane_of_x_and_y_is_no_plane_problem(made, tmp_path):
    """The blocks lie on their side: nothing in the configuration says so, the matrix does."""
    solids.write_model(tmp_path, turned(solids.places()))
    loads = LOADS.replace('"TOP", 3', '"TOP", 2').replace(
        '["TOP", 1, 2.0], ["TOP", 2, 1.0]', '["TOP", 3, 2.0], ["TOP", 1, 1.0]'
    )
    for contact in ("", "\nnormal = [0, 1, 0]", "\ndirections = 2"):
        other = import_model(configuration(tmp_path, f"{PAIRS}{contact}\n", loads))
        assert other.problem.directions == 2
        np.testing.assert_allclose(other.problem.normal, np.tile([0.0, 1.0, 0.0], (12, 1)), atol=1e-15)
    along = import_model(configuration(tmp_path, f"{PAIRS}\ntangent = [0, 0, 1]\n", loads)).problem
    np.testing.assert_allclose(along.tangents, turned(made.problem.tangents), atol=1e-15)
    size = np.abs(made.problem.kappa).max()
    np.testing.assert_allclose(along.kappa, made.problem.kappa, atol=1e-8 * size)
    np.testing.assert_allclose(along.q_w, made.problem.q_w, atol=1e-8)
    np.testing.assert_allclose(along.p_w, made.problem.p_w, atol=1e-7)


def test_a_plane_is_taken_where_it_is_said_or_held(folder):
    """One direction: said by the axes, or by supports that hold the other."""
    plane = f"{PAIRS}\naxes = [1, 3]"
    held = "[supports]\nfixed = [" + ", ".join(f'["{name}", 2]' for name in ("UPPER_FOOT", "LOWER_TOP")) + "]"
    one = import_model(configuration(folder, plane, supports=held))
    assert one.problem.directions == 1
    left_out = "friction across the plane of slip and normal is left out"
    assert f"direction 2 of the contact nodes is held: {left_out}" in one.notes
    with pytest.raises(ProblemError, match=r"free in direction 2 too; ask for friction in both directions"):
        import_model(configuration(folder, plane))
    with pytest.raises(ProblemError, match=r"2 numbers, along directions 1 and 2, .* or directions = 2"):
        import_model(configuration(folder, f"{PAIRS}\ndirections = 1\nnormal = [0, 0, 1]"))


TRANSFORMS = """*TRANSFORM, NSET=UPPER_FOOT, TYPE=C
-1., -1., 0., -1., -1., 5.
*TRANSFORM, NSET=LOWER_TOP
0.8, 0.6, 0., -0.6, 0.8, 0.
"""


def test_nodes_in_a_transform_are_the_same_joint(folder, made, tmp_path):
    """CalculiX stores x, y, z all the same; what it prints along the directions of a node is turned back."""
    sets, places = solids.node_sets(), solids.places()
    for name in ("job.inp", "job.sti", "job.dof"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    nodes = np.concatenate([sets["UPPER_FOOT"], sets["LOWER_TOP"]])
    moved = np.random.default_rng(0).normal(size=(len(nodes), 3)).round(3)
    arm = places[nodes - 1, :2] + 1.0
    radial = arm / np.linalg.norm(arm, axis=1)[:, None]
    radial[12:] = [0.8, 0.6]
    across = np.column_stack([-radial[:, 1], radial[:, 0]])
    own = np.column_stack([*((way * moved[:, :2]).sum(axis=1) for way in (radial, across)), moved[:, 2]])
    for name, vectors, mark in (("model.dat", moved, ""), ("own.dat", own, " L")):
        rows = [" displacements (vx,vy,vz) for set BOTH and time  0.1000000E+01", ""]
        rows += [f"{n} {' '.join(map(repr, v))}{mark}" for n, v in zip(nodes, vectors.tolist(), strict=True)]
        (tmp_path / name).write_text("\n".join([*rows, ""]))

    def imported(file, loads=LOADS):
        return import_model(
            configuration(tmp_path, loads=f'{loads}[[load]]\nopen = {{ file = "{file}" }}\nhistory = 1.0\n')
        )

    straight = imported("model.dat").problem
    with pytest.raises(ProblemError, match=r"found those of node 13 in directions of its own \(\*NODE PRINT"):
        imported("own.dat")
    text = (tmp_path / "job.inp").read_text()
    (tmp_path / "job.inp").write_text(text.replace("*STEP", f"{TRANSFORMS}*STEP"))
    (tmp_path / "other.mtx").write_text(
        writers.abaqus_matrix(made.stiffness.K.toarray(), made.stiffness.dofs.tolist())
    )
    other = configuration(tmp_path, name="other.toml")
    other.write_text(other.read_text().replace('"job.sti"', '"other.mtx"'))
    with pytest.raises(ProblemError, match=r"expected contact nodes with rows along x, y, z"):
        import_model(other)
    for file in ("model.dat", "own.dat"):
        turned = imported(file).problem
        np.testing.assert_array_equal(turned.kappa, made.problem.kappa)
        size = np.abs(straight.q_w).max()
        np.testing.assert_allclose(turned.q_w, straight.q_w, atol=1e-12 * size)
        np.testing.assert_allclose(turned.p_w, straight.p_w, atol=1e-12 * size)
    rows = (tmp_path / "job.dof").read_text()
    (tmp_path / "job.dof").write_text(rows.replace("25.1\n", "99.1\n", 1))
    with pytest.raises(ProblemError, match=r"in a \*TRANSFORM all three.*found 2 of node 25"):
        imported("model.dat")
    (tmp_path / "job.dof").write_text(rows)
    (tmp_path / "job.inp").write_text(text.replace("*STEP", f"{TRANSFORMS.replace('TYPE=C', 'TYPE=S')}*STEP"))
    with pytest.raises(ProblemError, match=r"\*TRANSFORM of TYPE=R or C with two points, found 'S, -1"):
        imported("own.dat")


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("directions = 3", "key 'directions': expected 1 or 2, found 3"),
        ("tangent = [1, 0, 0]\naxes = [1, 3]", "key 'axes': .* found it beside 'tangent'"),
        ("directions = 2\naxes = [1, 3]", "key 'axes': .* found it beside directions = 2"),
        ("directions = 1\ntangent = [1, 0, 0]", "key 'tangent': expected beside directions = 2 only"),
        ("tangent = [0, 0, 1]", r"tangent: expected a finite direction across the normal \[0.0, 0.0, 1.0\]"),
        ("tangents = [[1, 0, 0]]", "key 'tangents': expected one for each of 12 nodes, found 1"),
        ("directions = 2\nnormal = [0, 1]", "key 'normal': expected 3 numbers beside directions = 2, found 2"),
    ],
)  # fmt: skip
def test_one_thing_wrong_is_named(folder, keys, message):
    with pytest.raises(ProblemError, match=message):
        import_model(configuration(folder, f"{PAIRS}\n{keys}"))


def test_what_was_read_is_shown(folder, made):
    code, out, _ = run("import", str(configuration(folder)), "--check")
    assert code == 0
    words = " ".join(out.split())
    assert "tangent of every node 1 0 0" in words
    assert "rigid motions 6 of the contact nodes, without resistance" in words
    assert "second tangent normal × tangent" in words
    columns = [f"{name}{axis}" for name in ("", "normal ", "tangent 1 ", "tangent 2 ") for axis in "xyz"]
    assert list(made.columns()) == ["nodes", *columns, "area"]
    assert np.shape(made.to_dict()["tangents"]) == (12, 2, 3)
    drawn = contact_picture(made)
    assert drawn.name == "3d"
    legend = [text.get_text() for text in drawn.get_legend().get_texts()]
    assert legend[1:] == ["first tangent", "second tangent"]
    assert [text.get_text() for text in drawn.texts] == list(made.contact.names)
    frame = made.condensation.frame
    for line, along in zip(drawn.lines[-4:-1], [frame.normals, *frame.slip_axes.swapaxes(0, 1)], strict=True):
        start, end, gap = np.reshape(np.transpose(line.get_data_3d()), (-1, 3, 3)).swapaxes(0, 1)
        np.testing.assert_array_equal(start, made.contact.coordinates)
        np.testing.assert_allclose(end - start, along * np.linalg.norm(end[0] - start[0]), atol=1e-12)
        assert np.isnan(gap).all()
    with pytest.raises(UsageError, match="expected axes in 3 dimensions"):
        contact_picture(made, ax=drawn.figure.add_subplot())


@needs_ccx
@pytest.mark.parametrize("kind", ["C3D8", "C3D8I", "C3D4"])
def test_calculix_stores_what_is_imported(tmp_path, made, kind):
    """Its own C3D8: the same joint as from this element, to the digits of the file; of all, six rigid motions."""
    text = solids.deck(solids.places(), kind=kind)
    (tmp_path / "job.inp").write_text(text if kind == "C3D4" else text.replace("*STEP", f"{TRANSFORMS}*STEP"))
    ccx(tmp_path, "job")
    found = import_model(configuration(tmp_path))
    assert (found.condensation.zero_modes, found.problem.warnings) == (6, ())
    for load in found.loads:
        np.testing.assert_allclose(load.contact, -load.applied, atol=1e-9 * np.abs(load.applied).max())
    size = np.abs(made.problem.kappa).max()
    apart = np.abs(found.problem.kappa - made.problem.kappa).max() / size
    assert (apart < 1e-8) == (kind == "C3D8")


def test_nodes_of_incompatible_modes_are_no_strangers(tmp_path):
    """CalculiX gives every C3D8I three nodes: they stay where they are when a body moves rigidly."""
    xyz = solids.places()
    K, dofs = solids.with_modes(xyz)
    sti, dof = writers.calculix_storage(K, dofs)
    for name, text in (("job.inp", solids.deck(xyz, kind="C3D8I")), ("job.sti", sti), ("job.dof", dof)):
        (tmp_path / name).write_text(text)
    found = import_model(configuration(tmp_path))
    assert (found.condensation.zero_modes, found.problem.warnings) == (6, ())
    first, second = found.evidence.bodies
    assert (len(first.free), len(first.nodes), len(second.nodes)) == (6, 24, 24 - 12)
    assert 0.0 < found.rigid_residual < np.inf
    sti, dof = writers.calculix_storage(block_diag(K, K[:1, :1]), [*dofs.tolist(), (10**6, 1)])
    (tmp_path / "job.sti").write_text(sti)
    (tmp_path / "job.dof").write_text(dof)
    other = import_model(configuration(tmp_path))  # one node too many: these are of another run
    assert other.warnings[0].startswith("109 of 217 rows are of nodes that are none of the deck, first 49")
    assert other.notes[1] == "1 part(s) of the model have no contact node, one of 1 node(s) from 1000000"
