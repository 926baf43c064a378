"""Import of two surfaces whose meshes do not match: against the same bodies from meshes, and what is refused."""

import json

import meshed_apart
import numpy as np
import pytest
from command import run
from meshed_apart import LOADS, STEEL, bricks, write

from shakedown import ProblemError, import_model
from shakedown.fem import ElasticBody, Support, brick_mesh, contact_problem

SURFACES = 'surfaces = ["UPPER", "LOWER"]'


def configuration(folder, contact=SURFACES, loads=LOADS):
    return meshed_apart.configuration(folder, contact, loads=loads)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    target = tmp_path_factory.mktemp("surfaces")
    write(target, *bricks())
    return target


def test_it_is_the_joint_of_the_same_bodies(folder):
    made = import_model(configuration(folder))
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
    said = import_model(configuration(tmp_path)).warnings
    assert said[0].startswith("the surfaces are drawn so that they lie apart by 0.01 on average")
    with pytest.raises(ProblemError, match=r"lie on each other within 'reach' = 0.005, found"):
        import_model(configuration(tmp_path, f"{SURFACES}\nreach = 0.005"))


def test_the_check_says_how_the_surfaces_lie(folder):
    code, out, _ = run("import", str(configuration(folder)), "--check")
    assert code == 0
    words = " ".join(out.split())
    assert "surfaces 9 and 12 nodes overlap 3 mm² 100 % and 100 % of their areas" in words
    document = json.loads(run("import", str(configuration(folder)), "--check", "--json")[1])
    assert document["surfaces"]["overlap"] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("contact", "said"),
    [
        ('surfaces = ["UPPER"]', "expected two names, of the first body and of the second"),
        ('surfaces = ["UPPER", "UPPER"]', "expected bodies with nodes of their own, found node 1 on both"),
        ('surfaces = ["UPPER", "NOWHERE"]', "expected the node set or surface 'NOWHERE'"),
        (f'{SURFACES}\nnodes = "TOP"', "expected no key 'nodes' beside 'surfaces', found both"),
        ('nodes = "UPPER"\nreach = 1.0', "expected the key 'surfaces' (beside 'reach'"),
        (f"{SURFACES}\nreach = -1.0", "reach: expected a length > 0, found -1"),
    ],
)
def test_what_cannot_be_meant_is_refused(folder, contact, said):
    with pytest.raises(ProblemError) as refused:
        import_model(configuration(folder, contact))
    assert said in str(refused.value)


def test_a_fine_pad_on_one_coarse_element_may_be_named_either_way(tmp_path):
    upper = ElasticBody(brick_mesh((0.5, 0.5, 1.0), (4, 4, 1), origin=(1.7, 1.8, 1.0)), STEEL)
    lower = ElasticBody(brick_mesh((4.0, 4.0, 1.0), (1, 1, 1)), STEEL, supports=[Support("bottom")])
    write(tmp_path, upper, lower)
    (said,) = import_model(configuration(tmp_path)).warnings
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
    (said,) = import_model(configuration(tmp_path)).warnings
    assert "has the finer facets" in said
    assert said.endswith("name the coarser first")
    path = configuration(tmp_path)
    path.write_text(f'accept = ["the finer facets"]\n{path.read_text()}')
    meant = import_model(path)
    assert meant.warnings == ()
    assert f"accepted: {said}" in meant.notes
