"""Axisymmetric models: what stands for which part of the circumference."""

import shutil

import numpy as np
import pytest
import writers
from model_files import RING, changed
from skfem import Basis, BilinearForm, ElementQuadS2, ElementVector, MeshQuad
from skfem.helpers import ddot, sym_grad, trace

from shakedown import ProblemError, import_model
from shakedown.models.readers.mapped_matrices import read_calculix_storage
from shakedown.models.readers.mesh import Mesh

YOUNG, POISSON = 210e3, 0.3
BORE, FIT, RIM, LENGTH, INTERFERENCE = 4.0, 10.0, 20.0, 6.0, 0.01


@pytest.fixture
def ring(tmp_path):
    shutil.copytree(RING, tmp_path / "ring")
    return tmp_path / "ring"


@BilinearForm
def revolved(u, v, w):
    """Virtual work of an axisymmetric displacement (radial, axial) over the whole circumference."""
    lame = YOUNG * POISSON / (1 + POISSON) / (1 - 2 * POISSON)
    shear = YOUNG / 2 / (1 + POISSON)
    r = w.x[0]
    e, d = sym_grad(u), sym_grad(v)
    hoop, virtual_hoop = u[0] / r, v[0] / r
    spread = (trace(e) + hoop) * (trace(d) + virtual_hoop)
    return 2 * np.pi * r * (lame * spread + 2 * shear * (ddot(e, d) + hoop * virtual_hoop))


def condensed_ring(inner, outer, at, hold):
    """Stiffness of the nodes at one radius, by height: (axial…, radial…), a point held along the axis."""
    mesh = MeshQuad.init_tensor(np.linspace(inner, outer, 3), np.array([0.0, LENGTH]))
    basis = Basis(mesh, ElementVector(ElementQuadS2()), intorder=8)
    K = revolved.assemble(basis).toarray()
    place, direction = basis.doflocs, np.empty(basis.N, dtype=int)
    for dofs in (basis.nodal_dofs, basis.facet_dofs):
        direction[dofs[0]], direction[dofs[1]] = 0, 1
    near = np.abs(place[0] - at) < 1e-9
    axes = [sorted(np.flatnonzero(near & (direction == axis)), key=lambda k: -place[1, k]) for axis in (1, 0)]
    contact = np.concatenate(axes)
    held = np.flatnonzero((direction == 1) & (np.abs(place - [[inner], [0]]).max(axis=0) < 1e-9) & hold)
    rest = np.setdiff1d(np.arange(basis.N), np.concatenate([contact, held]))
    across = np.linalg.solve(K[np.ix_(rest, rest)], K[np.ix_(rest, contact)])
    return K[np.ix_(contact, contact)] - K[np.ix_(contact, rest)] @ across


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


def test_the_stiffness_is_that_of_the_whole_circumference(ring):
    """Against scikit-fem on the same mesh: the wedge of CalculiX has straight sides, which cost 2e-4."""
    hub = condensed_ring(FIT, RIM, FIT, hold=False)
    shaft = condensed_ring(BORE, FIT, FIT, hold=True)
    expected = hub - hub @ np.linalg.solve(hub + shaft, hub)
    made = import_model(ring / "import.toml")
    signs = np.repeat([-1.0, 1.0], 3)  # the tangent of a normal along the radius points down
    found = made.condensation.stiffness * np.outer(signs, signs)
    np.testing.assert_allclose(found, expected, rtol=0, atol=3e-4 * np.abs(expected).max())
    assert made.stiffness.circumference == 180
    assert made.condensation.zero_modes == 1  # along the axis
    assert any("taken 180 times" in note for note in made.notes)


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
    ("pairs", "message"),
    [
        (
            [('file = "ring.sti"', 'file = "ring.sti"\nscale = 180')],
            r"'scale': expected no factor for the circ",
        ),
        ([('file = "ring.sti"', 'file = "ring.sti"\nscale = 0')], "'scale': expected a number > 0, found 0"),
        ([("gap = -0.01", "gap = -0.01\nthickness = 2")], "'thickness': expected a number > 0 .none"),
        (
            [("gap = -0.01", "gap = -0.01\naxes = [2, 1]")],
            r"the axes \[1, 2\] of an axisymmetric model, found .*\[2, 1\]",
        ),
    ],
    ids=lambda value: "" if isinstance(value, str) else value[0][1].partition("\n")[2],
)
def test_what_an_axisymmetric_model_cannot_have_is_refused(ring, pairs, message):
    with pytest.raises(ProblemError, match=message):
        import_model(changed(ring, *pairs))


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


def test_abaqus_writes_the_whole_circumference(ring):
    """Labelled entries are Abaqus'; what stands in them is taken as it is, and a note says so."""
    stored = read_calculix_storage(ring / "ring.sti")
    text = writers.abaqus_matrix(180 * stored.K.toarray(), stored.dofs.tolist())
    (ring / "job_STIF1.mtx").write_text(text)
    made = import_model(changed(ring, ('file = "ring.sti"', 'file = "job_STIF1.mtx"')))
    expected = import_model(ring / "import.toml")
    assert made.stiffness.circumference == 1
    np.testing.assert_allclose(made.problem.C, expected.problem.C, rtol=1e-9)
    assert any("the matrix is that of 360 degrees" in note for note in made.notes)


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
