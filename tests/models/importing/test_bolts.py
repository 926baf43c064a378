"""Bolts in an import: as in Python, as a section of the deck, and as CalculiX with its own contact has them."""

import meshed_apart
import numpy as np
import pytest
import writers
from calculix import ccx, needs_ccx
from meshed_apart import STEEL, bricks, write

import shakedown
from shakedown import ProblemError, import_model
from shakedown.fem import Bolt, ElasticBody, Support, block_mesh, contact_problem

HEAD = 'name = "M8"\npreload = 50.0\nhead = "TOP"\naxis = [0, 0, -1]'
SHANK = f"{HEAD}\nstiffness = 4e5"
MADE = "area = 1.0\nlength = 0.5\nyoung = 2e5"
PRESSED = '[[load]]\nforces = [["TOP", 2, -10.0]]\nhistory = 1.0'
SECTION = 'name = "M8"\npreload = 50.0\nsection = 900'
PLATES = 'pairs = ["UPPER", "LOWER"]'


def configuration(folder, *bolts, **more):
    return meshed_apart.configuration(folder, PLATES, *(f"[[bolt]]\n{bolt}" for bolt in bolts), **more)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two blocks; ``cut`` is the same model with a shank that has a row of its own, as a section makes it."""
    target = tmp_path_factory.mktemp("blocks")
    write(target, *bricks((2, 2, 1), (2, 2, 1)))
    plain = import_model(configuration(target)).stiffness
    top = import_model(configuration(target)).mesh.nodes("TOP")
    area = np.array([0.25, 0.5, 0.25, 0.5, 1.0, 0.5, 0.25, 0.5, 0.25]) / 4
    e = np.zeros(len(plain.dofs))
    e[plain.rows([(int(node), 3) for node in np.sort(top)])] = -area
    K = np.block(
        [[plain.K.toarray() + 4e5 * np.outer(e, e), -4e5 * e[:, None]], [-4e5 * e, np.array([[4e5]])]]
    )
    sti, dof = writers.calculix_storage(K, np.vstack([plain.dofs, [(900, 1)]]))
    (target / "cut.sti").write_text(sti)
    (target / "cut.dof").write_text(dof)
    more = "*NODE\n900, 0., 0., 9.\n*PRE-TENSION SECTION, SURFACE=CUT, NODE=900\n*MATERIAL"
    (target / "cut.inp").write_text((target / "job.inp").read_text().replace("*MATERIAL", more, 1))
    for name, model in (("inp", "cut"), ("sti", "job"), ("dof", "job")):  # the node of the section has no row
        (target / f"held.{name}").write_text((target / f"{model}.{name}").read_text())
    return target


def test_a_shank_is_that_of_a_joint_from_meshes(folder):
    made = import_model(configuration(folder, SHANK))
    upper, lower = bricks((2, 2, 1), (2, 2, 1))
    bolt = Bolt(head="top", preload=1.0, stiffness=4e5)
    expected = contact_problem(upper, "bottom", 0.4, against=(lower, "top"), bolts=[bolt])
    size = np.abs(expected.kappa).max()
    np.testing.assert_allclose(made.problem.kappa, expected.kappa, rtol=0, atol=1e-10 * size)
    own, theirs = made.problem.load_reactions, expected.load_reactions
    slack = import_model(configuration(folder, f"{HEAD}\nstiffness = 0")).problem
    alone = contact_problem(upper, "bottom", 0.4, against=(lower, "top"))
    np.testing.assert_allclose(slack.kappa, alone.kappa, rtol=0, atol=1e-10 * size)
    ratio = own[2] @ theirs[2] / (theirs[2] @ theirs[2])
    assert ratio > 50.0  # tightened against a contact that gives way
    np.testing.assert_allclose(own[2], ratio * theirs[2], rtol=0, atol=1e-9 * np.abs(own[2]).max())
    np.testing.assert_allclose(made.loads[2].contact, [0.0, 0.0, 50.0], atol=1e-8)  # what is asked for
    assert "bolt 'M8' carries 50 along (0, 0, -1) once tightened" in made.notes[-1]
    assert "'press' adds -" in made.notes[-1]


def test_head_and_nut_of_two_meshes_make_no_couple(tmp_path):
    """The middle of the nut is beside that of the head: the shank stands on its head all the same."""
    write(tmp_path, *bricks((2, 2, 1), (3, 2, 1)), {"NUT": lambda x: x[:, 0] > 0.5})
    text = configuration(tmp_path, SHANK.replace("axis = [0, 0, -1]", 'nut = "LOWER_NUT"')).read_text()
    (tmp_path / "import.toml").write_text(text.replace("pairs = [", "surfaces = ["))
    made = import_model(tmp_path / "import.toml")
    assert "carries 50 along (0, 0, -1) once tightened" in made.notes[-1]
    upper, lower = (part for part in made.loads[2].parts if part.what.startswith("applied"))
    size = np.abs(upper.force).max()
    np.testing.assert_allclose(upper.force + lower.force, 0.0, atol=1e-12 * size)
    np.testing.assert_allclose(upper.moment + lower.moment, 0.0, atol=1e-12 * size)
    assert not any("bolt" in said for said in made.warnings)
    assert made.problem.load_mean[2] == 50.0
    assert made.problem.load_units[2] == "N"
    (tmp_path / "import.toml").write_text(
        text.replace("pairs = [", "surfaces = [") + '[supports]\nfixed = [["TOP", 3]]\n'
    )
    with pytest.raises(ProblemError, match="free nodes under head and nut, found direction 3 of node"):
        import_model(tmp_path / "import.toml")
    aside = text.replace("pairs = [", "surfaces = [").replace("LOWER_NUT", "LOWER_RIM")
    write(tmp_path, *bricks((2, 2, 1), (3, 2, 1)), {"RIM": lambda x: x[:, 0] > 1.5})
    (tmp_path / "import.toml").write_text(aside)
    with pytest.raises(ProblemError, match=r"found their middle 1 beside it"):
        import_model(tmp_path / "import.toml")


def test_in_the_plane_a_shank_stands_across_the_line_of_its_head(tmp_path):
    """The middle of the nut lies beside that of the head."""
    upper = ElasticBody(block_mesh(2.0, 1.0, 2, 1, origin=(0.0, 1.0)), STEEL)
    lower = ElasticBody(block_mesh(2.0, 1.0, 3, 1), STEEL, supports=[Support("bottom")])
    write(tmp_path, upper, lower, {"NUT": lambda x: x[:, 0] > 0.5})
    bolt = "[[bolt]]\n" + SHANK.replace("axis = [0, 0, -1]", 'nut = "LOWER_NUT"').replace("50.0", "51.23456")
    made = import_model(
        meshed_apart.configuration(tmp_path, 'surfaces = ["UPPER", "LOWER"]', bolt, loads=PRESSED)
    )
    assert made.notes[-1] == (
        "bolt 'M8' carries 51.23 along (0, -1, 0) once tightened; while the contact stays closed and sticks, "
        "'load 1' adds -13.8 at factor 1"
    )
    np.testing.assert_allclose(made.loads[1].contact, [0.0, 51.23456], atol=1e-10)


def test_a_section_of_the_deck_is_a_shank(folder):
    shank = import_model(configuration(folder, SHANK))
    section = import_model(configuration(folder, SECTION, job="cut"))
    size = np.abs(shank.problem.kappa).max()
    np.testing.assert_allclose(section.problem.kappa, shank.problem.kappa, rtol=0, atol=1e-9 * size)
    expected = shank.problem.load_reactions
    np.testing.assert_allclose(
        section.problem.load_reactions, expected, rtol=0, atol=1e-8 * np.abs(expected).max()
    )
    assert section.notes[-1] == shank.notes[-1].replace(" along (0, 0, -1)", "")


def test_preload_comes_at_assembly_and_can_be_varied(folder):
    path = configuration(folder, f"{SHANK}\ntransient = [0.0, 0.5, 1.0]")
    made = import_model(path)
    assert made.problem.q_transient.shape[0] == 3
    more = import_model(path, changes={"bolt.1.preload": 100.0}, before=made)
    assert more.condensation is made.condensation
    np.testing.assert_allclose(more.problem.load_reactions[2], 2 * made.problem.load_reactions[2])
    given = SHANK.replace("stiffness = 4e5", MADE)
    other = import_model(configuration(folder, given)).problem
    np.testing.assert_allclose(other.kappa, made.problem.kappa, atol=1e-9 * np.abs(other.kappa).max())


@pytest.mark.parametrize(
    ("bolts", "job", "said"),
    [
        ((SHANK + "\narea = 1.0",), "job", "found 'stiffness', 'area'"),
        ((SHANK.replace("4e5", "-1"),), "job", "key 'stiffness': expected a number > 0, found -1"),
        ((f"{HEAD}\n{MADE.replace('1.0', '0')}",), "job", "key 'area': expected a number > 0, found 0"),
        ((SHANK.replace("preload = 50.0", ""),), "job", "key 'preload': expected a force >= 0, found none"),
        (
            (SHANK.replace("axis = [0, 0, -1]", ""),),
            "job",
            "expected a nut apart from the head, or an 'axis'",
        ),
        ((SHANK + "\ntorque = 3",), "job", "bolt 1: unknown key 'torque'"),
        *(((SECTION,), job, "of a *PRE-TENSION SECTION of the deck, with a row") for job in ("job", "held")),
        ((), "cut", "expected a [[bolt]] with section = 900 and its preload"),
        ((SHANK + '\nnut = "LID"',), "job", "expected the node set or surface 'LID'"),
        (
            (SHANK.replace("-1]", '1]\nnut = "LOWER"'),),
            "job",
            "expected a direction from the head towards the nut",
        ),
    ],
)
def test_what_cannot_be_meant_is_refused(folder, bolts, job, said):
    with pytest.raises(ProblemError) as refused:
        import_model(configuration(folder, *bolts, job=job))
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def bolted_plates():
    """Two plates of 5 x 5 elements with a square hole, in it a bolt with head and nut, cut in the middle."""
    nodes, elements = {}, []

    def node(*key):
        return nodes.setdefault(key, len(nodes) + 1)

    def brick(part, i, j, z0, z1):
        corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
        elements.append([node(part(x, y, z), x, y, z) for z in (z0, z1) for x, y in corners])
        return len(elements)

    ring = [(i, j) for i in range(5) for j in range(5) if (i, j) != (2, 2)]
    for i, j in ring:
        for z in (0, 1):
            brick(lambda x, y, z: "upper", i, j, z, z + 1)
    faces = {"UPPER": [2 * k + 1 for k in range(24)]}
    for i, j in ring:
        for z in (-1, -2):
            brick(lambda x, y, z: "lower", i, j, z, z + 1)
    faces["LOWER"] = [48 + 2 * k + 1 for k in range(24)]
    for i in (1, 2, 3):
        for j in (1, 2, 3):
            brick(lambda x, y, z: "upper", i, j, 2, 3)
            brick(lambda x, y, z: "lower", i, j, -3, -2)

    def shank(x, y, z):
        return {2: "upper", -2: "lower"}.get(z, "shank")

    cut = [brick(shank, 2, 2, z, z + 1) for z in (-2, -1, 0, 1)][1]
    return nodes, elements, faces, cut


def deck(steps=None, more=()):
    nodes, elements, faces, cut = bolted_plates()
    sets = {
        "UPPER": [k for (part, _, _, z), k in nodes.items() if part == "upper" and z == 0],
        "LOWER": [k for (part, _, _, z), k in nodes.items() if part == "lower" and z == 0],
        "EDGE": [k for (_, x, y, z), k in nodes.items() if z == -2 and {x, y} & {0, 5}],
        "PULLED": [k for (_, x, y, z), k in nodes.items() if z == 2 and {x, y} & {0, 5}],
    }
    surfaces = {"CUT": [f"{cut}, S2"], "ABOVE": [f"{k}, S1" for k in faces["UPPER"]]}
    surfaces["BELOW"] = [f"{k}, S2" for k in faces["LOWER"]]
    lines = ["*NODE", "900, 0., 0., 9."]
    for name, own in surfaces.items():
        lines += [f"*SURFACE, NAME={name}", *own]
    lines += ["*PRE-TENSION SECTION, SURFACE=CUT, NODE=900", "0., 0., 1.", "*BOUNDARY", "EDGE, 1, 3", *more]
    places = [tuple(map(float, place)) for _, *place in nodes]
    return writers.calculix_deck(places, elements, sets, "C3D8", more=lines, steps=steps)


CONTACT = [
    "*SURFACE INTERACTION, NAME=HARD",
    "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR",
    "1e8, 1e-3",
    "*CONTACT PAIR, INTERACTION=HARD, TYPE=NODE TO SURFACE",
    "ABOVE, BELOW",
]
PRINT = ["*NODE PRINT, NSET=SECTION", "U, RF", "*CONTACT PRINT", "CSTR", "*END STEP"]


@pytest.fixture(scope="module")
def plates(tmp_path_factory):
    """What CalculiX makes of the plates: the matrix, and tightening then pulling with contact of its own."""
    target = tmp_path_factory.mktemp("plates")
    (target / "job.inp").write_text(deck())
    ccx(target, "job")
    steps = ["*NSET, NSET=SECTION", "900", *CONTACT]
    steps += ["*STEP, INC=100", "*STATIC", "1., 1.", "*CLOAD", "900, 1, 1000.", *PRINT]
    steps += ["*STEP, INC=100", "*STATIC", "1., 1.", "*BOUNDARY, FIXED", "900, 1, 1"]
    steps += ["*CLOAD", "PULLED, 3, 40.", *PRINT]
    (target / "contact.inp").write_text(deck(steps))
    ccx(target, "contact")
    return target


def printed(path):
    """Force in the section and contact pressures by node at the end of both steps."""
    forces, pressures = [], []
    for line in path.read_text().splitlines():
        fields = line.split()
        if "contact stress" in line:
            pressures.append({})
        elif fields[:1] == ["900"]:
            forces.append(float(fields[1]))
        elif len(fields) == 4 and fields[0].isdigit():
            pressures[-1][int(fields[0])] = max(float(fields[1]), 0.0)
    return forces[1::2], pressures  # U and RF in turn


@pytest.mark.slow
@needs_ccx
def test_tightened_and_pulled_open_plates_are_those_of_calculix(plates):
    """The force of the section is printed per node: CalculiX divides by the four that it has."""
    forces, pressures = printed(plates / "contact.dat")
    pull = '[[load]]\nname = "pull"\nforces = [["PULLED", 3, 40.0]]\nhistory = 0.0\n'
    bolt = 'name = "M1"\npreload = 1000.0\nsection = 900'
    path = configuration(plates, bolt, loads=pull, friction=0.0)
    tightened = import_model(path)
    assert tightened.notes[-1].endswith("'pull' adds 1.33 at factor 1")
    assert [warning for warning in tightened.warnings if "varies" not in warning] == []
    pulled = import_model(path, changes={"load.1.history": 1.0}, before=tightened)
    for made, applied, force, pressure in zip(
        (tightened, pulled), (0.0, 800.0), forces, pressures, strict=True
    ):
        nodes = shakedown.node_results(shakedown.simulate(made.problem, 0.0))
        theirs = np.array([pressure.get(int(name.partition("/")[0]), 0.0) for name in nodes.label])
        np.testing.assert_allclose(nodes.pressure_max, theirs, atol=1.5e-3 * theirs.max())
        carried = nodes.pressure_max @ made.problem.node_area + applied  # what the bolt holds of it
        assert carried == pytest.approx(4 * force, rel=5e-5)
    assert (
        4 * (forces[1] - forces[0]) > 11.0
    )  # the shank stretches as the plates open: nine times the welded 1.33
