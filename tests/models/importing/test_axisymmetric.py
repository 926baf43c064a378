"""Axisymmetric models: what stands for which part of the circumference."""

import shutil

import numpy as np
import pytest
from model_files import RING, changed, refused_with

from shakedown import ProblemError, import_model
from shakedown.models.readers.mesh import Mesh

YOUNG = 210e3
BORE, FIT, RIM, LENGTH, INTERFERENCE = 4.0, 10.0, 20.0, 6.0, 0.01


@pytest.fixture
def ring(tmp_path):
    shutil.copytree(RING, tmp_path / "ring")
    return tmp_path / "ring"


def test_the_pressure_of_a_press_fit_is_lame_s(ring):
    """A frictionless fit of equally long rings: one pressure, in MPa, from the interference alone."""
    problem = import_model(ring / "import.toml").problem
    closed = np.full(problem.n, INTERFERENCE)
    slip = -np.linalg.lstsq(problem.A, problem.B.T @ closed, rcond=1e-10)[0]
    pressure = (problem.C @ closed + problem.B @ slip) / problem.node_area
    np.testing.assert_allclose(problem.node_area.sum(), 2 * np.pi * FIT * LENGTH, rtol=1e-14)
    hub = (RIM**2 + FIT**2) / (RIM**2 - FIT**2)
    shaft = (FIT**2 + BORE**2) / (FIT**2 - BORE**2)
    lame = INTERFERENCE * YOUNG / FIT / (hub + shaft)
    np.testing.assert_allclose(pressure, lame, rtol=7e-3)  # of the mesh
    np.testing.assert_allclose(pressure @ problem.node_area, lame * problem.node_area.sum(), rtol=1e-3)


PUSHED = (
    '\n[[load]]\nreactions = { file = "pushed.dat", step = 1, scale = 180, bodies = "tied" }\nhistory = 1\n'
)
CHECK = """
[check]
displacements = [[101, 1, 0.01], [106, 1, 0.01], [109, 1, 0.01]]
reactions = { file = "pushed.dat", step = 2, scale = 180, bodies = "tied" }
"""


def test_reactions_that_calculix_prints_are_refused(ring):
    """Even times 180 they lack what the stress around the circumference carries; a check finds it."""
    reason = "of the radial ones not what the stress around the circumference carries"
    with pytest.raises(ProblemError, match=f"load 2: key 'reactions': expected 'forces'.*{reason}"):
        import_model(changed(ring, extra=PUSHED))
    with pytest.raises(ProblemError, match=r"check \(on the whole circumference\).*relative difference of 0"):
        import_model(changed(ring, extra=PUSHED + CHECK))
    axial = CHECK.replace(", 1, 0.01]", ", 2, 0.01]")
    with pytest.raises(
        ProblemError, match="expected a contact node of an axisymmetric model that moves radially"
    ):
        import_model(changed(ring, extra=PUSHED + axial))


def test_reactions_that_a_check_proves_are_taken(ring):
    """As a code would print them that prints all of the force on the whole circumference."""
    made = import_model(ring / "import.toml")
    frame, labels = made.condensation.frame, made.contact.first
    moved = made.condensation.stiffness @ frame.to_local(np.tile([0.01, 0.0], (3, 1)))
    rows = np.zeros((3, 2))
    rows += moved[:3, None] * frame.tangents + moved[3:, None] * frame.normals
    table = ["step;node;fx;fy"]
    for step, factor in ((1, 2.0), (2, 1.0)):
        table += [
            f"{step};{n};{factor * x!r};{factor * y!r}"
            for n, (x, y) in zip(labels, rows.tolist(), strict=True)
        ]
    (ring / "rf.csv").write_text("\n".join(table) + "\n")
    extra = (PUSHED + CHECK).replace("pushed.dat", "rf.csv").replace("scale = 180, ", "")
    found = import_model(changed(ring, extra=extra))
    assert found.static_run < 1e-9
    np.testing.assert_allclose(found.problem.p_w[0] - made.problem.p_w[0], 2 * moved[3:], rtol=1e-9)


@pytest.mark.parametrize(
    ("place", "line", "message"),
    [
        ('file = "ring.sti"', "scale = 180", "'scale': expected no factor for the circ"),
        ('file = "ring.sti"', "scale = 0", "'scale': expected a number > 0, found 0"),
        ("gap = -0.01", "thickness = 2", "'thickness': expected a number > 0 .none"),
        ("gap = -0.01", "axes = [2, 1]", r"the axes \[1, 2\] of an axisymmetric model, found .*\[2, 1\]"),
    ],
)
def test_what_an_axisymmetric_model_cannot_have_is_refused(ring, place, line, message):
    refused_with(ring / "import.toml", place, f"{place}\n{line}", message)


@pytest.mark.parametrize("young", [1e-3 * YOUNG, 1e3 * YOUNG])
def test_a_stiffness_in_other_units_than_the_material_is_doubted(ring, young):
    deck = (ring / "ring.inp").read_text()
    (ring / "ring.inp").write_text(deck.replace("210000.,", f"{young},"))
    assert any("is 'scale' right?" in warning for warning in import_model(ring / "import.toml").warnings)


@pytest.mark.parametrize(
    ("line", "factor"),
    [
        ("*FREQUENCY, SOLVER=MATRIXSTORAGE", 180),
        ("*STATIC, solver=MatrixStorage", 180),
        ("*MATRIX GENERATE, STIFFNESS", 1),
        ("*STATIC", None),
    ],
)
def test_the_deck_says_which_code_wrote_the_matrix(ring, line, factor):
    deck = (ring / "ring.inp").read_text()
    (ring / "ring.inp").write_text(deck.replace("*FREQUENCY, SOLVER=MATRIXSTORAGE", line))
    if factor is None:
        with pytest.raises(ProblemError, match=r"key 'scale': expected 360 over the degrees .*, found none"):
            import_model(ring / "import.toml")
        named = changed(ring, ('file = "ring.sti"', 'file = "ring.sti"\nscale = 180.0'))
        made = import_model(named)
        (ring / "ring.inp").write_text(deck)
        expected = import_model(ring / "import.toml")
        np.testing.assert_array_equal(made.condensation.stiffness, expected.condensation.stiffness)
        assert "2 degrees, taken 180 times" in " ".join(made.notes)
    else:
        assert import_model(ring / "import.toml").stiffness.circumference == factor


def test_a_deck_is_axisymmetric_or_not(ring):
    deck = (ring / "ring.inp").read_text()
    (ring / "ring.inp").write_text(
        deck.replace("*NSET, NSET=SHAFT_FIT", "*ELEMENT, TYPE=CPE4\n9, 1, 2, 3, 4\n*NSET, NSET=SHAFT_FIT")
    )
    with pytest.raises(ProblemError, match="expected axisymmetric elements only, or none, found CAX8, CPE4"):
        import_model(ring / "import.toml")
    (ring / "ring.inp").write_text(deck.replace("CAX8", "CPE8"))
    assert import_model(ring / "import.toml").stiffness.circumference == 1
    (ring / "ring.inp").write_text(deck.replace("\n1, 4, 0\n", "\n1, -4, 0\n"))
    with pytest.raises(
        ProblemError, match="expected radii x >= 0 of an axisymmetric model, found -4 at node 1"
    ):
        import_model(ring / "import.toml")


def test_areas_of_a_cone_and_of_a_disc():
    """∫ N 2 π r dl: of a disc π R², of a cone π (r + R) l; a corner of the axis has its share."""
    labels, xyz = np.arange(1, 5), np.array([[0.0, 0, 0], [3, 0, 0], [0, 1, 0], [3, 5, 0]])
    mesh = Mesh("a deck", labels, xyz, elements={1: ("quadrilateral", (1, 2, 4, 3))}, axisymmetric=True)
    np.testing.assert_allclose(mesh.node_areas([1, 2]), np.pi * 3**2 * np.array([1, 2]) / 3)
    np.testing.assert_allclose(mesh.node_areas([3, 4]).sum(), np.pi * 3 * 5)
