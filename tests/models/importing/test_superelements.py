"""Nastran files of superelements: one matrix of several comes out as from a file of its own."""

import numpy as np
import pytest
import writers

from shakedown import ProblemError, import_model
from shakedown.models.readers.formats import read_stiffness
from shakedown.models.readers.nastran import read_analysis_set, read_nastran_dmig

DOFS = {101: [(n, d) for n in (3, 9) for d in (1, 2)], 102: [(n, d) for n in (9, 5, 3) for d in (1, 2)]}
PUNCH = {
    101: "EXTRN          3      12       9      12\nGRID,3,,0.,0.,0.\nGRID,9,,1.,0.,0.\n",
    102: "EXTRN          9      12       5      12       3      12\nGRID,3,,7.,0.,0.\nGRID,5,,8.,0.,0.\nGRID,9,,9.,0.,0.\n",
}
K = {number: writers.symmetric_matrix(len(dofs), seed=number) for number, dofs in DOFS.items()}
CONFIG = """friction = 0.3
[model]
file = "{punch}"
[stiffness]
file = "{matrix}"
{more}
[contact]
nodes = [3, 9]
normal = [0, 1]
[[load]]
forces = [[3, 2, -1.0]]
history = 1
"""


def section(number, begin="BEGIN SUPER      {}"):
    return f"{begin.format(number)}\n{PUNCH[number]}"


@pytest.fixture
def folder(tmp_path):
    """Matrices and punch files of both superelements, apart and joined."""
    for number, dofs in DOFS.items():
        (tmp_path / f"{number}.op4").write_text(writers.nastran_op4(K[number], name="KXX"))
        dmig = writers.nastran_dmig(K[number], dofs)
        (tmp_path / f"{number}.pch").write_text(PUNCH[number])
        (tmp_path / f"{number}.dmig").write_text(dmig)
        with open(tmp_path / "both.dmig", "a") as both:
            both.write(section(number) + dmig)
        with open(tmp_path / "both.pch", "a") as both:
            both.write(section(number, "BEGIN BULK SUPER={}"))
        with open(tmp_path / "both.op4", "a") as both:
            both.write(writers.nastran_op4(K[number], name="KXX"))
    return tmp_path


def imported(folder, punch, matrix, more=""):
    (folder / "c.toml").write_text(CONFIG.format(punch=punch, matrix=matrix, more=more))
    return import_model(folder / "c.toml")


@pytest.mark.parametrize("number", DOFS)
def test_each_comes_out_as_from_files_of_its_own(folder, number):
    place = list(DOFS).index(number) + 1
    alone = imported(folder, f"{number}.pch", f"{number}.op4")
    joined = imported(folder, f"{number}.pch", "both.op4", f'matrix = "kxx({place})"\nmap = "{number}.pch"')
    cards = imported(folder, f"{number}.pch", f"{number}.dmig")
    np.testing.assert_array_equal(joined.stiffness.dofs, alone.stiffness.dofs)
    np.testing.assert_array_equal(joined.problem.kappa, alone.problem.kappa)
    np.testing.assert_array_equal(joined.problem.coordinates, alone.problem.coordinates)
    np.testing.assert_allclose(cards.problem.kappa, alone.problem.kappa, rtol=1e-8)
    np.testing.assert_array_equal(cards.problem.coordinates, alone.problem.coordinates)


@pytest.mark.parametrize(
    ("matrix", "more", "message"),
    [
        ("both.op4", "map = '101.pch'", "expected one stiffness matrix, found .*KXX.*; name the one to take"),
        ("both.op4", "map = '101.pch'\nmatrix = 'KXX(3)'", "expected one matrix 'KXX.3.', found .*KXX"),
        ("both.dmig", "", "both.dmig: expected one superelement, found 101, 102; give a file"),
    ],
)
def test_which_one_must_be_said(folder, matrix, more, message):
    with pytest.raises(ProblemError, match=message):
        imported(folder, "101.pch", matrix, more)


def test_points_of_several_superelements_are_refused(tmp_path):
    """An .asm file has no sections: its SECONCT cards say whose points they are."""
    card = "SECONCT      {}       0              NO\n               3       3{}\n"
    grids = "GRID,3,,0.,0.,0.\nGRID,9,,1.,0.,0.\n"
    (tmp_path / "one.asm").write_text(grids + card.format(102, "       9       9"))
    assert len(read_analysis_set(tmp_path / "one.asm")) == 12
    (tmp_path / "both.asm").write_text(grids + card.format(101, "") + card.format(102, "       9       9"))
    with pytest.raises(ProblemError, match=r"expected one superelement, found 101, 102"):
        read_analysis_set(tmp_path / "both.asm")


def test_two_matrices_of_one_name_without_sections_are_refused(tmp_path):
    (tmp_path / "k.pch").write_text(2 * writers.nastran_dmig(K[101], DOFS[101]))
    with pytest.raises(ProblemError, match="one DMIG header card of KAAX, and entries, found 2 of"):
        read_nastran_dmig(tmp_path / "k.pch")


MODES = """friction = 0.3
[stiffness]
file = "k.mtx"
map = "k.pch"
[contact]
nodes = [3, 11]
normal = [0.0, 0.0, 1.0]
[[load]]
reactions = [[0, 0, 50.0], [0, 0, 50.0]]
history = 1
[[load]]
reactions = [[1.0, 0, 0], [1.0, 0, 0]]
history = [1, -1]
"""


@pytest.mark.parametrize("coupled", [False, True])
def test_component_modes_are_left_out_or_condensed(tmp_path, coupled):
    """As the boundary is fixed while modes are found, or free."""
    rng = np.random.default_rng(4)
    boundary, modes = writers.symmetric_matrix(6), np.diag([9.0, 16.0, 25.0])
    between = rng.normal(size=(6, 3)) if coupled else np.zeros((6, 3))
    boundary = boundary + 10.0 * np.eye(6)
    whole = np.block([[boundary, between], [between.T, modes]])
    (tmp_path / "k.mtx").write_text(writers.matrix_market(whole))
    (tmp_path / "k.pch").write_text(
        "EXTRN          3     123      11     123     101       0     102       0\n+            103       0\n"
    )
    (tmp_path / "c.toml").write_text(MODES)
    made = import_model(tmp_path / "c.toml")
    order = [0, 1, 3, 4, 2, 5]  # slips along x and y, then gaps
    expected = boundary - between @ np.linalg.solve(modes, between.T)
    np.testing.assert_allclose(made.problem.kappa, expected[np.ix_(order, order)], rtol=1e-12)
    assert len(made.evidence.bodies) == 1
    assert any("3 row(s), first of point 101, couple with no" in n for n in made.notes) != coupled


def test_the_mass_of_a_substructure(tmp_path):
    dofs = [(3, 1), (3, 2), (11, 1)]
    text = writers.abaqus_substructure(writers.symmetric_matrix(3), dofs)
    (tmp_path / "k.mtx").write_text(text.replace("TYPE=MASS\n1.0", "TYPE=MASS\n2.0\n0.0, 3.0\n0.5, 0.0, 4.0"))
    mass = read_stiffness(tmp_path / "k.mtx", matrix="mass")
    assert mass.K.toarray().tolist() == [[2.0, 0.0, 0.5], [0.0, 3.0, 0.0], [0.5, 0.0, 4.0]]
    assert mass.dofs.tolist() == [list(row) for row in dofs]
    with pytest.raises(ProblemError, match="expected the keyword \\*MATRIX, TYPE=DAMPING, found none"):
        read_stiffness(tmp_path / "k.mtx", matrix="damping")
