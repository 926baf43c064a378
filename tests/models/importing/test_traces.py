"""What an imported problem keeps of the model it came from."""

import hashlib
import json

import numpy as np
import pytest
import writers

import shakedown
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.templates import write_import_example
from shakedown.models.readers.formats import read_any_mesh


@pytest.fixture
def example(tmp_path):
    write_import_example(tmp_path)
    return tmp_path / "import.toml"


def test_the_example_says_where_it_comes_from(example):
    problem = shakedown.import_model(example, command="shakedown-bounds import import.toml").problem
    assert problem.label[:2] == ("1/1073", "2/1074")
    assert problem.load_names == ("pressed down", "pushed to and fro", "pressed more and less")
    assert problem.node_area.sum() == pytest.approx(np.ptp(problem.coordinates[:, 0]))
    assert problem.node_area[[0, -1]] == pytest.approx(0.5 * problem.node_area[1])
    assert problem.normal.tolist() == [[0.0, 1.0, 0.0]] * 9
    source = json.loads(problem.source)
    assert source["command"] == "shakedown-bounds import import.toml"
    assert source["configuration"] == {"name": "import.toml", "text": example.read_text()}
    for file in source["files"]:
        assert file["sha256"] == hashlib.sha256((example.parent / file["name"]).read_bytes()).hexdigest()
    assert {file["name"] for file in source["files"]} == {
        "import.toml",
        "punch.inp",
        "punch.sti",
        "punch.dof",
    }


def test_the_same_import_twice_gives_the_same_bytes(example, tmp_path):
    for name in "ab":
        shakedown.save_problem(tmp_path / name, import_problem(example))
    assert (tmp_path / "a").read_bytes() == (tmp_path / "b").read_bytes()
    assert import_problem(example) == shakedown.load_problem(tmp_path / "a")


def test_an_archive_of_ansys_gives_the_normals_and_areas_of_the_deck(example, tmp_path):
    of_deck, mesh = import_problem(example), read_any_mesh(tmp_path / "punch.inp")
    cells = {label: (1, list(nodes)) for label, (_, nodes) in mesh.elements.items()}
    sets = {name: ("NODE", own.tolist()) for name, own in mesh.node_sets.items()}
    (tmp_path / "punch.cdb").write_text(writers.ansys_archive(mesh.places, cells, sets))
    example.write_text(example.read_text().replace('"punch.inp"', '"punch.cdb"'))
    made = import_problem(example)
    for key in ("A", "B", "C", "q_w", "p_w", "normal", "node_area", "coordinates"):
        np.testing.assert_array_equal(getattr(made, key), getattr(of_deck, key))
