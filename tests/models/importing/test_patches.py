"""Several patches in one import, each by its name: as one contact, of pairs and of surfaces, with errors."""

import json
import re

import numpy as np
import pytest
from command import run
from meshed_apart import LOADS, bricks, write

from shakedown import ProblemError, import_model, load_problem
from shakedown.models.importing.templates import write_import_example
from shakedown.plot import patch_count
from shakedown.plot.patch_places import places_of

LEFT = 'name = "left"\npairs = ["UPPER_LEFT", "LOWER_LEFT"]'
RIGHT = 'name = "right"\npairs = ["UPPER_RIGHT", "LOWER_RIGHT"]\nfriction = 0.2'
BOTH = (LEFT, RIGHT)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A block that stands on another one with two feet, the outer two of five rows of elements."""
    target = tmp_path_factory.mktemp("feet")
    feet = {"LEFT": lambda place: place[:, 0] < 0.5, "RIGHT": lambda place: place[:, 0] > 1.5}
    write(target, *bricks((5, 2, 1), (5, 2, 1)), feet)
    return target


def configuration(folder, *patches, friction="friction = 0.4", loads=LOADS, name="import.toml"):
    text = f'{friction}\nunits = "N, mm"\n[model]\nfile = "job.inp"\n[stiffness]\nfile = "job.sti"\n'
    (folder / name).write_text(text + "".join(f"[[contact]]\n{patch}\n" for patch in patches) + loads)
    return folder / name


def in_order(problem, labels):
    """q and p of every node and κ, nodes in the order of their labels without names."""
    own = [label.rpartition(": ")[2] for label in problem.label]
    order = np.array([own.index(label) for label in labels])
    rows = (2 * order[:, None] + np.arange(2)).ravel()
    return problem.A[np.ix_(rows, rows)], problem.C[np.ix_(order, order)], problem.p_w[:, order]


def test_two_patches_are_one_contact(folder):
    made = import_model(configuration(folder, *BOTH))
    problem, labels = made.problem, [name.rpartition(": ")[2] for name in made.contact.names]
    assert problem.label[0].startswith("left: ")
    np.testing.assert_array_equal(problem.f, np.repeat([0.4, 0.2], 6))
    assert made.evidence.patches.tolist() == [0] * 6 + [1] * 6
    whole = ", ".join(f"[{label.replace('/', ', ')}]" for label in labels)
    alone = import_model(configuration(folder, f"pairs = [{whole}]", name="alone.toml")).problem
    for one, other in zip(in_order(problem, labels), in_order(alone, labels), strict=True):
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


def test_matching_surfaces_beside_pairs_are_pairs(folder):
    expected = import_model(configuration(folder, *BOTH)).problem
    made = import_model(configuration(folder, LEFT, RIGHT.replace("pairs", "surfaces"), name="mixed.toml"))
    labels = [label.rpartition(": ")[2].partition("/")[0] for label in made.problem.label]
    np.testing.assert_array_equal(made.problem.f, expected.f)
    firsts = [label.rpartition(": ")[2].partition("/")[0] for label in expected.label]
    order = [labels.index(label) for label in firsts]
    at = (2 * np.array(order)[:, None] + np.arange(2)).ravel()
    size = np.abs(expected.A).max()
    np.testing.assert_allclose(made.problem.A[np.ix_(at, at)], expected.A, rtol=0, atol=1e-12 * size)
    np.testing.assert_allclose(made.problem.p_w[:, order], expected.p_w, rtol=0, atol=1e-8)
    for load in made.loads:
        np.testing.assert_allclose(load.contact, -load.applied, atol=1e-9 * np.abs(load.applied).max())


def test_the_check_and_the_pictures_say_the_names(folder, tmp_path):
    path = configuration(folder, LEFT.replace("pairs", "surfaces"), RIGHT)
    code, out, _ = run("import", str(path), "--check")
    words = " ".join(out.split())
    assert code == 0
    assert "left: surfaces 6 and 6 nodes" in words
    assert "right: pairs apart, along at most 0 mm (mean 0) the surface" in words
    assert "contact, right" in words
    document = json.loads(run("import", str(path), "--check", "--json")[1])
    assert list(document["surfaces"]) == list(document["pairs"]) == ["left", "right"]
    assert document["pairs"]["left"] is None
    run("import", str(path), "-o", str(tmp_path / "feet.npz"))
    problem = load_problem(tmp_path / "feet.npz")
    assert {places_of(problem, k).name for k in range(patch_count(problem))} == {"left", "right"}


@pytest.mark.parametrize(
    ("patches", "said"),
    [
        ((LEFT, RIGHT.replace("right", "left")), "contact 2: expected another name, found 'left' twice"),
        ((LEFT, RIGHT.partition("\n")[2]), "contact 2: expected the key 'name'"),
        ((LEFT, RIGHT + "\nspacing = 1"), "contact 2: unknown key 'spacing'"),
        ((LEFT, 'name = "right"'), "contact 2: expected one of the keys 'nodes', 'pairs' and 'surfaces'"),
        ((LEFT, 'name = "all"\nsurfaces = ["UPPER", "LOWER"]'), "found node 1 on 'left' and 'all'"),
        (
            (LEFT, RIGHT + "\naxes = [1, 3]"),
            "contact 2: key 'axes': expected (1, 2, 3), as of 'left', found",
        ),
        ((LEFT, RIGHT.replace("0.2", "[0.1, 0.2]")), "one for each of 6 nodes of 'right', found 2"),
        ((LEFT + "\nfriction = 0.1", RIGHT), "key 'friction': expected a number, for patches that have none"),
    ],
)
def test_what_cannot_be_meant_is_refused(folder, patches, said):
    with pytest.raises(ProblemError) as refused:
        import_model(configuration(folder, *patches, name="refused.toml"))
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)
