"""Surfaces whose meshes do not match, several patches by name; bolts, as in Python, as sections of the deck and as CalculiX has them."""

import re
from dataclasses import replace

import numpy as np
import pytest
import writers
from calculix import ccx, needs_ccx
from command import document, run
from meshed_apart import STEEL, bricks, configuration, write

import shakedown
from benchmarks.calculix_peer import pressures
from shakedown import ProblemError, import_model, load_problem
from shakedown.fem import Bolt, ElasticBody, Support, block_mesh, brick_mesh, contact_problem
from shakedown.models.importing.templates import write_import_example
from shakedown.plot import patch_count
from shakedown.plot.patch_places import places_of

SURFACES = 'surfaces = ["UPPER", "LOWER"]'


def refused(path, said):
    with pytest.raises(ProblemError) as refused:
        import_model(path)
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    target = tmp_path_factory.mktemp("surfaces")
    write(target, *bricks())
    return target


def test_it_is_the_joint_of_the_same_bodies(folder):
    made = import_model(configuration(folder, SURFACES))
    upper, lower = bricks()
    expected = contact_problem(upper, "bottom", 0.4, against=(lower, "top"), coupling="mortar")
    size = np.abs(expected.kappa).max()
    np.testing.assert_allclose(made.problem.kappa, expected.kappa, rtol=0, atol=1e-10 * size)
    np.testing.assert_allclose(made.problem.node_area, expected.node_area, rtol=1e-12)
    assert made.problem.p_w[0].sum() == pytest.approx(90.0)
    assert (made.problem.n, made.condensation.zero_modes, made.warnings) == (9, 6, ())
    assert made.contact.names[0] == "1"
    for load in made.loads:
        np.testing.assert_allclose(load.contact, -load.applied, atol=1e-9 * np.abs(load.applied).max())
    below = {part.what: part for part in made.loads[0].parts}["supports, second body"]
    np.testing.assert_allclose(below.force, [0.0, 0.0, 90.0], atol=1e-7)
    np.testing.assert_allclose(below.moment, 0.0, atol=1e-6)


def test_a_gap_is_what_the_deck_draws(tmp_path):
    write(tmp_path, *bricks(height=1.01))
    drawn = import_model(configuration(tmp_path, f'{SURFACES}\ngap = "coordinates"'))
    np.testing.assert_allclose(drawn.contact.gap, 0.01, rtol=1e-9)
    said = import_model(configuration(tmp_path, SURFACES)).warnings
    assert said[0].startswith("the surfaces are drawn so that they lie apart by 0.01 on average")
    with pytest.raises(ProblemError, match=r"lie on each other within 'reach' = 0.005, found"):
        import_model(configuration(tmp_path, f"{SURFACES}\nreach = 0.005"))


def test_a_wedge_between_surfaces_is_named_by_its_mean(tmp_path):
    upper, lower = bricks()
    places = upper.mesh.p
    mesh = replace(upper.mesh, doflocs=places + np.outer([0, 0, 0.04], places[0]))
    write(tmp_path, ElasticBody(mesh, STEEL, loads=upper.loads), lower)
    assert "lie apart by 0.04 on average" in import_model(configuration(tmp_path, SURFACES)).warnings[0]


def test_the_check_says_how_the_surfaces_lie(folder):
    code, out, _ = run("import", str(configuration(folder, SURFACES)), "--check")
    assert code == 0
    words = " ".join(out.split())
    assert "surfaces 9 and 12 nodes overlap 3 mm² 100 % and 100 % of their areas" in words
    told = document("import", str(configuration(folder, SURFACES)), "--check")
    assert told["surfaces"]["overlap"] == pytest.approx(3.0)


def test_a_fine_pad_on_one_coarse_element_may_be_named_either_way(tmp_path):
    upper = ElasticBody(brick_mesh((0.5, 0.5, 1.0), (4, 4, 1), origin=(1.7, 1.8, 1.0)), STEEL)
    lower = ElasticBody(brick_mesh((4.0, 4.0, 1.0), (1, 1, 1)), STEEL, supports=[Support("bottom")])
    write(tmp_path, upper, lower)
    (said,) = import_model(configuration(tmp_path, SURFACES)).warnings
    assert said.endswith("most of the second lies beside it")
    turned = 'surfaces = ["LOWER", "UPPER"]'
    said = import_model(configuration(tmp_path, turned)).warnings
    assert "or name the second, which lies on a part of it, first" in said[0]
    upper = ElasticBody(brick_mesh((0.5, 0.5, 1.0), (4, 4, 1), origin=(0.1, 0.1, 1.0)), STEEL)
    write(tmp_path, upper, lower)
    with pytest.raises(ProblemError, match=r"1.6 % of one covered; name the second first"):
        import_model(configuration(tmp_path, turned))


def test_a_finer_first_surface_is_said_and_may_be_meant(tmp_path):
    write(tmp_path, *bricks(lower=(1, 1, 1)))
    (said,) = import_model(configuration(tmp_path, SURFACES)).warnings
    assert "has the finer facets" in said
    assert said.endswith("name the coarser first")
    path = configuration(tmp_path, SURFACES)
    path.write_text(f'accept = ["the finer facets"]\n{path.read_text()}')
    meant = import_model(path)
    assert meant.warnings == ()
    assert f"accepted: {said}" in meant.notes


LEFT = 'name = "left"\npairs = ["UPPER_LEFT", "LOWER_LEFT"]'
RIGHT = 'name = "right"\npairs = ["UPPER_RIGHT", "LOWER_RIGHT"]\nfriction = 0.2'
BOTH = (LEFT, RIGHT)


@pytest.fixture(scope="module")
def feet(tmp_path_factory):
    """A block that stands on another one with two feet, the outer two of five rows of elements."""
    target = tmp_path_factory.mktemp("feet")
    feet = {"LEFT": lambda place: place[:, 0] < 0.5, "RIGHT": lambda place: place[:, 0] > 1.5}
    write(target, *bricks((5, 2, 1), (5, 2, 1)), feet)
    return target


def first_node(label):
    return label.rpartition(": ")[2].partition("/")[0]


def in_order(problem, nodes):
    """A, C and p, contact nodes in the order of these nodes of the first body."""
    own = [first_node(label) for label in problem.label]
    order = np.array([own.index(node) for node in nodes])
    rows = (2 * order[:, None] + np.arange(2)).ravel()
    return problem.A[np.ix_(rows, rows)], problem.C[np.ix_(order, order)], problem.p_w[:, order]


def test_two_patches_are_one_contact(feet):
    made = import_model(configuration(feet, BOTH))
    problem, labels = made.problem, [name.rpartition(": ")[2] for name in made.contact.names]
    assert problem.label[0].startswith("left: ")
    np.testing.assert_array_equal(problem.f, np.repeat([0.4, 0.2], 6))
    assert made.evidence.patches.tolist() == [0] * 6 + [1] * 6
    whole = ", ".join(f"[{label.replace('/', ', ')}]" for label in labels)
    alone = import_model(configuration(feet, f"pairs = [{whole}]")).problem
    firsts = [first_node(label) for label in labels]
    for one, other in zip(in_order(problem, firsts), in_order(alone, firsts), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * np.abs(other).max())
    assert problem.node_area.sum() == pytest.approx(2 * 0.4 * 1.5)
    assert len(problem.faces) == 4  # none between the feet
    carried = [part for part in made.loads[0].parts if part.what.startswith("contact, ")]
    assert [part.what for part in carried] == ["contact, left", "contact, right"]
    np.testing.assert_allclose(sum(part.force for part in carried), [0, 0, 180.0], atol=1e-7)


def test_patches_between_each_other_are_drawn_five_spacings_apart(tmp_path):
    write_import_example(tmp_path)
    text = (tmp_path / "import.toml").read_text()
    patches = "".join(
        f'[[contact]]\nname = "{name}"\npairs = {[[k, k + 1072] for k in nodes]}\nnormal = [0, 1]\n'
        for name, nodes in (("odd", range(1, 10, 2)), ("even", range(2, 9, 2)))
    )
    (tmp_path / "two.toml").write_text(re.sub(r"\[contact\]\n.*\n", patches, text))
    spaces = np.diff(import_model(tmp_path / "two.toml").problem.x)
    np.testing.assert_allclose(spaces, [0.5] * 4 + [2.5] + [0.5] * 3)


def test_matching_surfaces_beside_pairs_are_pairs(feet):
    expected = import_model(configuration(feet, BOTH)).problem
    made = import_model(configuration(feet, [LEFT, RIGHT.replace("pairs", "surfaces")]))
    np.testing.assert_array_equal(made.problem.f, expected.f)
    firsts = [first_node(label) for label in expected.label]
    for one, other in zip(in_order(made.problem, firsts), in_order(expected, firsts), strict=True):
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-12 * np.abs(other).max())
    for load in made.loads:
        np.testing.assert_allclose(load.contact, -load.applied, atol=1e-9 * np.abs(load.applied).max())


def test_the_check_and_the_pictures_say_the_names(feet, tmp_path):
    path = configuration(feet, [LEFT.replace("pairs", "surfaces"), RIGHT])
    code, out, _ = run("import", str(path), "--check")
    words = " ".join(out.split())
    assert code == 0
    assert "left: surfaces 6 and 6 nodes" in words
    assert "right: pairs apart, along at most 0 mm (mean 0) the surface" in words
    assert "contact, right" in words
    told = document("import", str(path), "--check")
    assert list(told["surfaces"]) == list(told["pairs"]) == ["left", "right"]
    assert told["pairs"]["left"] is None
    run("import", str(path), "-o", str(tmp_path / "feet.npz"))
    problem = load_problem(tmp_path / "feet.npz")
    assert {places_of(problem, k).name for k in range(patch_count(problem))} == {"left", "right"}


@pytest.mark.parametrize(
    ("contact", "said"),
    [
        ('surfaces = ["UPPER"]', "expected two names, of the first body and of the second"),
        ('surfaces = ["UPPER", "UPPER"]', "expected bodies with nodes of their own, found node 1 on both"),
        ('surfaces = ["UPPER", "NOWHERE"]', "expected the node set or surface 'NOWHERE'"),
        (f'{SURFACES}\nnodes = "TOP"', "expected no key 'nodes' beside 'surfaces', found both"),
        ('nodes = "UPPER"\nreach = 1.0', "expected the key 'surfaces' (beside 'reach'"),
        (f"{SURFACES}\nreach = -1.0", "reach: expected a length > 0, found -1"),
        ((LEFT, RIGHT.replace("right", "left")), "contact 2: expected another name, found 'left' twice"),
        ((LEFT, RIGHT.partition("\n")[2]), "contact 2: expected the key 'name'"),
        ((LEFT, RIGHT + "\nspacing = 1"), "contact 2: unknown key 'spacing'"),
        ((LEFT, 'name = "right"'), "contact 2: expected one of the keys 'nodes', 'pairs' and 'surfaces'"),
        ((LEFT, 'name = "all"\nsurfaces = ["UPPER", "LOWER"]'), "found node 1 on 'left' and 'all'"),
        ((LEFT, RIGHT + "\naxes = [1, 3]"), "contact 2: key 'axes': expected (1, 2, 3), as of 'left', found"),
        ((LEFT, RIGHT + "\nnormal = [0, 1, 0]"), "expected normals into the first body, found [0, 1, 0] at"),
        ((LEFT, RIGHT.replace("0.2", "[0.1, 0.2]")), "one for each of 6 nodes of 'right', found 2"),
        ((LEFT + "\nfriction = 0.1", RIGHT), "key 'friction': expected a number, for patches that have none"),
    ],
)
def test_what_cannot_be_meant_is_refused(feet, contact, said):
    refused(configuration(feet, contact), said)


def test_a_list_of_coefficients_is_of_one_patch(feet):
    said = "expected a number, for patches that have none of their own, found several"
    refused(configuration(feet, BOTH, friction=[0.1, 0.2]), said)


HEAD = 'name = "M8"\npreload = 50.0\nhead = "TOP"\naxis = [0, 0, -1]'
SHANK = f"{HEAD}\nstiffness = 4e5"
MADE = "area = 0.5\nlength = 0.25\nyoung = 2e5"
PRESSED = '[[load]]\nforces = [["TOP", 2, -10.0]]\nhistory = 1.0'
SECTION = 'name = "M8"\npreload = 50.0\nsection = 900'
PLATES = 'pairs = ["UPPER", "LOWER"]'


def with_bolts(bolted, *bolts, **more):
    return configuration(bolted, PLATES, *(f"[[bolt]]\n{bolt}" for bolt in bolts), **more)


@pytest.fixture(scope="module")
def bolted(tmp_path_factory):
    """Two blocks; ``cut`` is the same model with a shank that has a row of its own, as a section makes it."""
    target = tmp_path_factory.mktemp("blocks")
    write(target, *bricks((2, 2, 1), (2, 2, 1)))
    plain = import_model(with_bolts(target)).stiffness
    top = import_model(with_bolts(target)).mesh.nodes("TOP")
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


def test_a_shank_is_that_of_a_joint_from_meshes(bolted):
    made = import_model(with_bolts(bolted, SHANK))
    upper, lower = bricks((2, 2, 1), (2, 2, 1))
    bolt = Bolt(head="top", preload=1.0, stiffness=4e5)
    expected = contact_problem(upper, "bottom", 0.4, against=(lower, "top"), bolts=[bolt])
    size = np.abs(expected.kappa).max()
    np.testing.assert_allclose(made.problem.kappa, expected.kappa, rtol=0, atol=1e-10 * size)
    own, theirs = made.problem.load_reactions, expected.load_reactions
    slack = import_model(with_bolts(bolted, f"{HEAD}\nstiffness = 0".replace("0, -1]", "2e-4, -1]")))
    assert "carries 50 along (0, 0, -1) once tightened" in slack.notes[-1]
    alone = contact_problem(upper, "bottom", 0.4, against=(lower, "top"))
    np.testing.assert_allclose(slack.problem.kappa, alone.kappa, rtol=0, atol=1e-10 * size)
    ratio = own[2] @ theirs[2] / (theirs[2] @ theirs[2])
    assert ratio > 50.0  # tightened against a contact that gives way
    np.testing.assert_allclose(own[2], ratio * theirs[2], rtol=0, atol=1e-9 * np.abs(own[2]).max())
    np.testing.assert_allclose(made.loads[2].contact, [0.0, 0.0, 50.0], atol=1e-8)  # what is asked for
    assert "bolt 'M8' carries 50 along (0, 0, -1) once tightened" in made.notes[-1]
    assert "'press' adds -" in made.notes[-1]


def test_head_and_nut_of_two_meshes_make_no_couple(tmp_path):
    """The middle of the nut is beside that of the head: the shank stands on its head all the same."""
    write(tmp_path, *bricks((2, 2, 1), (3, 2, 1), size=1e3), {"NUT": lambda x: x[:, 0] > 0.5e3})
    path = with_bolts(tmp_path, SHANK.replace("axis = [0, 0, -1]", 'nut = "LOWER_NUT"'))
    text = path.read_text().replace("pairs = [", "surfaces = [")
    path.write_text(text)
    made = import_model(path)
    assert "carries 50 along (0, 0, -1) once tightened" in made.notes[-1]
    upper, lower = (part for part in made.loads[2].parts if part.what.startswith("applied"))
    np.testing.assert_allclose(upper.force, [0.0, 0.0, -50.0], atol=1e-9)
    np.testing.assert_allclose(upper.force + lower.force, 0.0, atol=1e-10)
    np.testing.assert_allclose(upper.moment + lower.moment, 0.0, atol=1e-10)
    assert not any("bolt" in said for said in made.warnings)
    assert (made.problem.load_mean[2], made.problem.load_units[2]) == (50.0, "N")
    head, nut = int(made.mesh.nodes("TOP")[0]), int(made.mesh.nodes("LOWER_NUT")[-1])
    path.write_text(text.replace('head = "TOP"', f"head = {head}").replace('"LOWER_NUT"', str(nut)))
    way = made.mesh.at([nut])[0] - made.mesh.at([head])[0]  # from node to node it leans
    shown = re.search(r"carries 50 along \((.*)\) once", import_model(path).notes[-1])[1].split(", ")
    np.testing.assert_allclose(np.array(shown, dtype=float), way / np.linalg.norm(way), atol=6e-4)
    path.write_text(f'{text}[supports]\nfixed = [["TOP", 3]]\n')
    with pytest.raises(ProblemError, match=f"under head and nut, found direction 3 of node {head} held"):
        import_model(path)
    path.write_text(text.replace("LOWER_NUT", "LOWER_RIM"))
    write(tmp_path, *bricks((2, 2, 1), (3, 2, 1)), {"RIM": lambda x: x[:, 0] > 1.5})
    with pytest.raises(ProblemError, match=r"found their middle 1 beside it"):
        import_model(path)


def test_in_the_plane_a_shank_stands_across_the_line_of_its_head(tmp_path):
    """The middle of the nut lies beside that of the head."""
    upper = ElasticBody(block_mesh(2.0, 1.0, 2, 1, origin=(0.0, 1.0)), STEEL)
    lower = ElasticBody(block_mesh(2.0, 1.0, 3, 1), STEEL, supports=[Support("bottom")])
    write(tmp_path, upper, lower, {"NUT": lambda x: x[:, 0] > 0.5})
    bolt = "[[bolt]]\n" + SHANK.replace("axis = [0, 0, -1]", 'nut = "LOWER_NUT"').replace("50.0", "51.23456")
    made = import_model(configuration(tmp_path, SURFACES, bolt, loads=PRESSED))
    assert made.notes[-1] == (
        "bolt 'M8' carries 51.23 along (0, -1, 0) once tightened; while the contact stays closed and sticks, "
        "'load 1' adds -13.8 at factor 1"
    )
    np.testing.assert_allclose(made.loads[1].contact, [0.0, 51.23456], atol=1e-10)


def test_a_section_of_the_deck_is_a_shank(bolted):
    shank = import_model(with_bolts(bolted, SHANK))
    section = import_model(with_bolts(bolted, SECTION, job="cut"))
    size = np.abs(shank.problem.kappa).max()
    np.testing.assert_allclose(section.problem.kappa, shank.problem.kappa, rtol=0, atol=1e-9 * size)
    expected = shank.problem.load_reactions
    np.testing.assert_allclose(
        section.problem.load_reactions, expected, rtol=0, atol=1e-8 * np.abs(expected).max()
    )
    assert section.notes[-1] == shank.notes[-1].replace(" along (0, 0, -1)", "")


def test_preload_comes_at_assembly_and_can_be_varied(bolted):
    path = with_bolts(bolted, f"{SHANK}\ntransient = [0.0, 0.5, 1.0]")
    made = import_model(path)
    assert made.problem.q_transient.shape[0] == 3
    more = import_model(path, changes={"bolt.1.preload": 100.0}, before=made)
    assert more.condensation is made.condensation
    np.testing.assert_allclose(more.problem.load_reactions[2], 2 * made.problem.load_reactions[2])
    given = SHANK.replace("stiffness = 4e5", MADE)
    other = import_model(with_bolts(bolted, given)).problem
    np.testing.assert_allclose(other.kappa, made.problem.kappa, atol=1e-9 * np.abs(other.kappa).max())


@pytest.mark.parametrize(
    ("bolts", "job", "said"),
    [
        ((SHANK + "\narea = 1.0",), "job", "found 'stiffness', 'area'"),
        ((SHANK.replace("4e5", "-1"),), "job", "key 'stiffness': expected a number > 0, found -1"),
        ((f"{HEAD}\n{MADE.replace('0.5', '0')}",), "job", "key 'area': expected a number > 0, found 0"),
        ((SHANK.replace("preload = 50.0", ""),), "job", "key 'preload': expected a force >= 0, found none"),
        ((SHANK.replace("axis = [0, 0, -1]", ""),), "job", "a nut apart from the head, or an 'axis' from"),
        ((SHANK + "\ntorque = 3",), "job", "bolt 1: unknown key 'torque'"),
        *(((SECTION,), job, "of a *PRE-TENSION SECTION of the deck, with a row") for job in ("job", "held")),
        ((), "cut", "expected a [[bolt]] with section = 900 and its preload"),
        ((SHANK + '\nnut = "LID"',), "job", "expected the node set or surface 'LID'"),
        ((SHANK.replace("-1]", '1]\nnut = "LOWER"'),), "job", "a direction from the head towards the nut"),
    ],
)
def test_bolts_that_cannot_be_meant_are_refused(bolted, bolts, job, said):
    refused(with_bolts(bolted, *bolts, job=job), said)


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


@pytest.mark.slow
@needs_ccx
def test_tightened_and_pulled_open_plates_are_those_of_calculix(plates):
    """The force of the section is printed per node: CalculiX divides by the four that it has."""
    rows = [line.split() for line in (plates / "contact.dat").read_text().splitlines()]
    forces = [float(row[1]) for row in rows if row[:1] == ["900"]][1::2]  # U and RF in turn
    pull = '[[load]]\nname = "pull"\nforces = [["PULLED", 3, 40.0]]\nhistory = 0.0\n'
    bolt = 'name = "M1"\npreload = 1000.0\nsection = 900'
    path = with_bolts(plates, bolt, loads=pull, friction=0.0)
    tightened = import_model(path)
    assert tightened.notes[-1].endswith("'pull' adds 1.33 at factor 1")
    assert [warning for warning in tightened.warnings if "varies" not in warning] == []
    pulled = import_model(path, changes={"load.1.history": 1.0}, before=tightened)
    for made, applied, force, pressure in zip(
        (tightened, pulled), (0.0, 800.0), forces, pressures(plates / "contact.dat"), strict=True
    ):
        nodes = shakedown.node_results(shakedown.simulate(made.problem, 0.0))
        theirs = np.array([max(pressure.get(int(name.partition("/")[0]), 0.0), 0.0) for name in nodes.label])
        np.testing.assert_allclose(nodes.pressure_max, theirs, atol=1.5e-3 * theirs.max())
        carried = nodes.pressure_max @ made.problem.node_area + applied  # what the bolt holds of it
        assert carried == pytest.approx(4 * force, rel=5e-5)
    # the shank stretches as the plates open: nine times the welded 1.33
    assert 4 * (forces[1] - forces[0]) > 11.0
