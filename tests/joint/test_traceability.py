"""What leads from a node back to the model it came from: kept, checked, and taken along."""

import dataclasses
import json

import numpy as np
import pytest

import shakedown
from shakedown import Problem, ProblemError, save_problem
from shakedown.joint.constraints import with_initial_gap
from shakedown.joint.contact_zone import contact_zone
from shakedown.studies.design_point import with_parameter

SOURCE = json.dumps(
    {"command": "shakedown-bounds import c.toml", "files": [{"name": "k.mtx", "sha256": "0" * 64}]}
)


def traced(**changes) -> Problem:
    """Two nodes of which everything is known."""
    more = {
        "label": ["4711/12", "4712/13"],
        "coordinates": [[0.0, 1.0, 0.0], [2.0, 1.0, 0.0]],
        "normal": [[0.0, 1.0, 0.0], [0.6, 0.8, 0.0]],
        "tangent": [[1.0, 0.0, 0.0], [0.8, -0.6, 0.0]],
        "node_area": [0.5, 0.0],
        "load_names": ["bolt", "traction"],
        "load_mean": [12.0, 20.0],
        "load_amplitude": [0.0, 20.0],
        "load_units": ["kN", "MPa"],
        "source": SOURCE,
        "x": [0.0, 2.0],
    }
    return dataclasses.replace(shakedown.example("two-node"), **(more | changes))


def test_a_file_without_a_source_has_no_key_that_earlier_versions_refuse(tmp_path):
    save_problem(tmp_path / "p.npz", shakedown.example("two-node"))
    with np.load(tmp_path / "p.npz", allow_pickle=False) as file:
        assert not {"source", "label", "node_area", "load_names", "load_mean", "load_units"} & set(file.files)


DAMAGED = {
    "too few labels": ({"label": ["a"]}, "key 'label': expected shape (2,), found (1,)"),
    "labels that are no text": ({"label": [1.5, 2.5]}, "key 'label': expected one text each"),
    "one label": ({"label": "a"}, "key 'label': expected one text each, found 'a'"),
    "a label that a terminal obeys": ({"label": ["a", "\x1b[2J"]}, "found '\\x1b[2J' at label[1]"),
    "a label too long": ({"label": ["a", "7" * 201]}, "text of at most 200 characters that can be shown"),
    "a label of two lines": ({"label": ["a", "b\nc"]}, "text of at most 200 characters that can be shown"),
    "a load without a showable name": ({"load_names": ["\x00b"]}, "key 'load_names': expected text of at most 200 characters"),
    "no load": ({"load_names": []}, "key 'load_names': expected one text each"),
    "a load of negative amplitude": ({"load_amplitude": [0.0, -20.0]}, "key 'load_amplitude': expected amplitudes >= 0, found -20 at load 1"),
    "a load whose mean is no number": ({"load_mean": [1.0, np.nan]}, "key 'load_mean': expected finite numbers, found nan at load_mean[1]"),
    "a mean without an amplitude": ({"load_amplitude": None}, "key 'load_amplitude': required because 'load_mean' is given"),
    "units without loads": ({"load_mean": None, "load_amplitude": None}, "key 'load_mean': required because 'load_units' is given"),
    "loads without names": ({"load_names": None}, "key 'load_names': required because 'load_mean' is given"),
    "a negative area": ({"node_area": [0.5, -1e-9]}, "key 'node_area': expected areas >= 0, found -1e-09 at node 1"),
    "places in the plane": ({"coordinates": np.zeros((2, 2))}, "key 'coordinates': expected shape (2, 3), found (2, 2)"),
    "a normal of length 2": ({"normal": [[0, 2, 0], [0, 1, 0]]}, "key 'normal': expected vectors of length 1, found the length 2 at node 0"),
    "a source that is no JSON": ({"source": "import c.toml"}, "key 'source': expected JSON text"),
    "a source with NaN": ({"source": '{"a": NaN}'}, "key 'source': expected JSON text"),
    "a source too deep": ({"source": '{"a":' + "[" * 100_000 + "]" * 100_000 + "}"}, "key 'source': expected JSON text"),
    "warnings that are none": ({"source": '{"warnings": [1]}'}, "key 'source': expected JSON text, an object"),
}  # fmt: skip


@pytest.mark.parametrize("kind", DAMAGED)
def test_damaged_values_are_refused_in_one_line(kind):
    changes, message = DAMAGED[kind]
    with pytest.raises(ProblemError) as caught:
        traced(**changes)
    assert message in str(caught.value)
    assert len(str(caught.value)) < 400
    assert str(caught.value).isprintable()


def test_a_problem_of_some_of_the_nodes_knows_which():
    problem = traced()
    zone = contact_zone(problem, [0]).joint
    assert zone.label == ("4712/13",)
    assert zone.coordinates.tolist() == [[2.0, 1.0, 0.0]]
    assert zone.node_area.tolist() == [0.0]
    assert zone.source == SOURCE
    assert zone.loads == problem.loads == (("bolt", 12.0, 0.0, "kN"), ("traction", 20.0, 20.0, "MPa"))
    tight = with_initial_gap(problem, -1e-3)
    assert tight.label == problem.label
    assert np.array_equal(tight.normal, problem.normal)


def test_a_factor_on_the_loading_is_one_on_the_loads():
    problem = traced()
    for name, factor, expected in (
        ("amplitude", 0.5, [(12, 0), (20, 10)]),
        ("mean", 2.0, [(24, 0), (40, 20)]),
    ):
        changed = with_parameter(problem, name, factor)
        assert [load[1:3] for load in changed.loads] == expected


@pytest.mark.parametrize("key", ["label", "coordinates", "node_area", "load_units", "source", "x"])
def test_equality_sees_every_field_and_never_raises(key):
    other = dataclasses.replace(traced(), **{key: "" if key == "source" else None})
    assert traced() == traced()
    assert traced() != other
    assert other != traced()
    assert traced() != "two-node"
