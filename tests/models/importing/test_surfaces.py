"""Two surfaces whose meshes do not match, and several patches by name: against the same bodies from meshes."""

import re

import numpy as np
import pytest
from command import document, run
from meshed_apart import STEEL, bricks, configuration, write

from shakedown import ProblemError, import_model, load_problem
from shakedown.fem import ElasticBody, Support, brick_mesh, contact_problem
from shakedown.models.importing.templates import write_import_example
from shakedown.plot import patch_count
from shakedown.plot.patch_places import places_of

SURFACES = 'surfaces = ["UPPER", "LOWER"]'


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
        ((LEFT, RIGHT.replace("0.2", "[0.1, 0.2]")), "one for each of 6 nodes of 'right', found 2"),
        ((LEFT + "\nfriction = 0.1", RIGHT), "key 'friction': expected a number, for patches that have none"),
    ],
)
def test_what_cannot_be_meant_is_refused(feet, contact, said):
    with pytest.raises(ProblemError) as refused:
        import_model(configuration(feet, contact))
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_list_of_coefficients_is_of_one_patch(feet):
    with pytest.raises(
        ProblemError, match="expected a number, for patches that have none of their own, found several"
    ):
        import_model(configuration(feet, BOTH, friction=[0.1, 0.2]))
