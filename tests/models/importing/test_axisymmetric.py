"""Axisymmetric models, heated and fitted; loads by static runs of another code: held, the contact held, open."""

import re
import shutil

import model_files
import numpy as np
import pytest
from model_files import HEAT, RING, changed, refused_with

import shakedown
from benchmarks.calculix_peer import pressures
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


def test_supports_bear_what_pulls_along_the_axis(ring):
    """Radially the stress around the circumference bears as well: what is left for supports is not known."""
    (load,) = import_model(ring / "import.toml").loads
    borne = {part.what: part.force for part in load.parts}["supports, second body"]
    np.testing.assert_allclose(borne, [np.nan, -load.applied[1]], rtol=1e-9)
    assert load.contact[1] == pytest.approx(-900.0, rel=1e-9)


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
    with pytest.raises(ProblemError, match="a contact node of an axisymmetric model that moves radially"):
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
        ("gap = -0.01", "directions = 2", r"of an axisymmetric model, found directions = 2, axes = \[1, 2\]"),
        ("gap = -0.01", "axes = [2, 1]", r"the axes \[1, 2\] of an axisymmetric model, found .*\[2, 1\]"),
    ],
)
def test_what_an_axisymmetric_model_cannot_have_is_refused(ring, place, line, message):
    refused_with(ring / "import.toml", place, f"{place}\n{line}", message)


@pytest.mark.parametrize(("young", "times"), [(1e-3 * YOUNG, "2e+03"), (1e3 * YOUNG, "0.002")])
def test_a_stiffness_in_other_units_than_the_material_is_doubted(ring, young, times):
    deck = (ring / "ring.inp").read_text()
    (ring / "ring.inp").write_text(deck.replace("210000.,", f"{young},"))
    (said,) = import_model(ring / "import.toml").warnings
    assert said.startswith(f"the stiffness is {times} times what")
    assert said.endswith("is 'scale' right?")


def test_an_entry_that_resists_a_motion_along_the_axis_is_doubted(ring):
    row = (ring / "ring.dof").read_text().split().index("107.2") + 1
    entry, text = f"\n{row} {row}  ", (ring / "ring.sti").read_text()
    (ring / "ring.sti").write_text(text.replace(entry, f"{entry}9"))
    (said,) = import_model(ring / "import.toml").warnings
    assert "at 1 of 18 nodes inside the model, most at 107: springs, or damaged entries?" in said


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


def test_where_it_lies_along_its_axis_does_not_matter(ring):
    expected, deck = import_model(ring / "import.toml"), (ring / "ring.inp").read_text().partition("*ELEMENT")
    nodes = re.sub(r"^(\d+, [\d.]+), (\d)$", r"\1, 100000\2", deck[0], flags=re.MULTILINE)
    assert nodes.count(", 100000") == 26
    (ring / "ring.inp").write_text("".join([nodes, *deck[1:]]))
    made = import_model(ring / "import.toml")
    assert made.warnings == expected.warnings == ()
    np.testing.assert_allclose(made.problem.kappa, expected.problem.kappa, rtol=1e-9)


def test_a_deck_is_axisymmetric_or_not(ring):
    deck = (ring / "ring.inp").read_text()
    (ring / "ring.inp").write_text(
        deck.replace("*NSET, NSET=SHAFT_FIT", "*ELEMENT, TYPE=CPE4\n9, 1, 2, 3, 4\n*NSET, NSET=SHAFT_FIT")
    )
    with pytest.raises(ProblemError, match="expected axisymmetric elements only, or none, found CAX8, CPE4"):
        import_model(ring / "import.toml")
    (ring / "ring.inp").write_text(deck.replace("CAX8", "CPE8"))
    assert import_model(ring / "import.toml").stiffness.circumference == 1
    (ring / "ring.inp").write_text(deck.replace("\n12, 8.5, 6\n", "\n12, -8.5, 6\n"))
    with pytest.raises(ProblemError, match=r"radii x >= 0 of an axisymmetric model, found -8\.5 at node 12"):
        import_model(ring / "import.toml")
    on_axis = re.sub(r"^(1|2|12), [\d.]+,", r"\1, 0.0,", deck, count=3, flags=re.MULTILINE)
    (ring / "ring.inp").write_text(on_axis)
    made = import_model(ring / "import.toml")
    assert (made.stiffness.circumference, made.warnings) == (180.0, ())  # most rows are as far out as before


def test_areas_of_a_cone_and_of_a_disc():
    """∫ N 2 π r dl: of a disc π R², of a cone π (r + R) l; a corner of the axis has its share."""
    labels, xyz = np.arange(1, 5), np.array([[0.0, 0, 0], [3, 0, 0], [0, 1, 0], [3, 5, 0]])
    mesh = Mesh("a deck", labels, xyz, elements={1: ("quadrilateral", (1, 2, 4, 3))}, axisymmetric=True)
    np.testing.assert_allclose(mesh.node_areas([1, 2]), np.pi * 3**2 * np.array([1, 2]) / 3)
    np.testing.assert_allclose(mesh.node_areas([3, 4]).sum(), np.pi * 3 * 5)


ENDS, INSIDE = [0, 4], [1, 2, 3]


@pytest.mark.parametrize(("step", "kelvin"), [(0, 0.0), (1, 20.0)], ids=["assembled", "heated"])
def test_pressures_are_those_of_contact_in_calculix(step, kelvin):
    made = shakedown.import_model(model_files.FIT / "import.toml", changes={"load.1.history": kelvin / 20.0})
    problem = made.problem
    assert made.contact.gap == pytest.approx(-0.012, rel=1e-9)
    assert [load.mean for load in problem.loads] == [kelvin]
    nodes = shakedown.node_results(shakedown.simulate(problem, 0.0))
    printed = pressures(model_files.FIT / "contact.dat")[step]
    theirs = np.array([printed[int(name.partition("/")[0])] for name in nodes.label])
    theirs[ENDS] *= 2
    assert nodes.units["pressure_max"] == "MPa"
    np.testing.assert_allclose(nodes.pressure_max, theirs, rtol=5e-4)
    # of the interference: the load steps are alike but for round-off
    assert nodes.slip_range.max() <= 1e-15 * 0.012
    assert theirs[INSIDE].min() > 15


THERMAL = 'thermal = { file = "held.dat", step = 1 }'
CLAMPED = 'reactions = { file = "clamped.dat", step = 1, bodies = "clamped" }'
OPEN = 'open = { file = "open.dat", step = 1 }'


@pytest.fixture
def heat(tmp_path):
    shutil.copytree(HEAT, tmp_path / "heat")
    return tmp_path / "heat"


def made(folder, *pairs):
    """The import with some things of its configuration changed."""
    return import_model(changed(folder, *pairs))


def welded(imported):
    return np.concatenate([imported.problem.q_w[0], imported.problem.p_w[0]])


@pytest.mark.parametrize(
    ("line", "digits"),
    [(CLAMPED, 2e-7), (OPEN, 1e-5), ('open = { file = "open.frd", step = 1 }', 1e-4)],
    ids=["clamped", "open", "open in a result file"],
)
def test_every_way_from_a_temperature_leads_to_the_same_reactions(heat, line, digits):
    expected = welded(made(heat))
    found = welded(made(heat, (THERMAL, line)))
    largest = np.abs(expected).max()
    assert largest > 50
    np.testing.assert_allclose(found, expected, rtol=0, atol=digits * largest)


def test_a_load_case_is_refused_where_its_file_is_not_what_the_key_says(heat):
    refused = {
        'thermal = { file = "clamped.dat", step = 1 }': "expected node 15, found it not printed",
        'thermal = { file = "open.dat", step = 1 }': "expected every node held .*found node 11 displaced by 0.0015",
        'thermal = { file = "open.frd", step = 1 }': r"expected reactions \(\*NODE FILE, RF\), found no block FORC",
        'thermal = { file = "held.dat", step = 2 }': "key 'step': expected 1 to 1, found 2",
        'open = { file = "open.dat" }': "key 'step': expected 1 to 3, found none",
        'open = { file = "open.dat", step = 4 }': "key 'step': expected 1 to 3, found 4",
        'open = { file = "blocks.sti", step = 1 }': "expected the columns step, node, ux, uy and maybe uz",
        'open = { file = "open.dat", step = 1, bodies = "tied" }': "unknown key 'bodies'",
        'open = "open.dat"': "key 'open': expected a table",
        'open = { file = "clamped.dat", step = 1 }': "found contact nodes that do not move apart .held, tied or",
    }
    for line, message in refused.items():
        with pytest.raises(ProblemError, match=message):
            made(heat, (THERMAL, line))


def test_reactions_of_held_nodes_have_no_other_directions(heat):
    deck = (heat / "blocks.inp").read_text()
    turned = "*TRANSFORM, NSET=TOP, TYPE=R\n0., 1., 0., -1., 0., 0.\n"
    (heat / "blocks.inp").write_text(deck.replace("*NSET, NSET=TOP", f"{turned}*NSET, NSET=TOP"))
    with pytest.raises(ProblemError, match=r"nodes with directions x, y, z, found node \d+ in a \*TRANSFORM"):
        made(heat)


def test_held_runs_have_to_show_that_they_are(heat):
    text = (heat / "held.dat").read_text()
    (heat / "held.dat").write_text(" forces" + text.partition(" forces")[2])
    with pytest.raises(ProblemError, match=r"which show that every node was held \(\*NODE PRINT: U, RF\)"):
        made(heat)
    shifted = text.replace("3.071250E+02", "0.000000E+00")
    zeros = re.sub(r"^( +\d+)( +[-\d.E+]+){3}$", r"\1" + 3 * "  0.000000E+00", shifted, flags=re.MULTILINE)
    (heat / "held.dat").write_text(zeros)
    assert any("reaches no contact node" in warning for warning in made(heat).warnings)


EXPANSION = 1.2e-5
COOLED = """
[[load]]
name = "hub cooled"
unit = "K"
value = -100.0
open = { file = "cooled.dat", step = 1 }
history = 1.0
"""


@pytest.mark.parametrize("file", ["cooled.dat", "cooled.frd"])
def test_a_hub_that_is_cooled_presses_as_one_that_is_too_small(tmp_path, file):
    """100 degrees less take 1.2e-5 * 100 * 10 mm of the hub's bore: an interference; slip is free."""
    shutil.copytree(RING, tmp_path / "ring")
    text = (tmp_path / "ring" / "import.toml").read_text()
    cooled = text.replace("gap = -0.01\n", "") + COOLED.replace("cooled.dat", file)
    (tmp_path / "ring" / "cooled.toml").write_text(cooled)
    problem = import_model(tmp_path / "ring" / "cooled.toml").problem
    fitted = import_model(tmp_path / "ring" / "import.toml").problem
    factor = EXPANSION * 100 * FIT / INTERFERENCE
    pressures = []
    for joint, times in ((problem, 1.0), (fitted, factor)):
        slip = -np.linalg.lstsq(joint.A, joint.q_w.mean(axis=0), rcond=1e-8)[0]
        pressures.append(times * (joint.p_w.mean(axis=0) + joint.B @ slip) / joint.node_area)
    np.testing.assert_allclose(*pressures, rtol=5e-4)  # CalculiX's wedge has straight sides
    (load,) = [load for load in problem.loads if load.name == "hub cooled"]
    assert load == ("hub cooled", -100.0, 0.0, "K")
