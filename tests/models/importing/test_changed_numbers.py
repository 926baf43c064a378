"""Numbers of a configuration changed on the way in: the same joint as from an edited file."""

import numpy as np
import pytest

import shakedown
from shakedown.ground.errors import ProblemError
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.templates import write_import_example


@pytest.fixture(scope="module")
def config(tmp_path_factory):
    folder = tmp_path_factory.mktemp("import") / "punch"
    write_import_example(folder)
    return folder / "import.toml"


@pytest.fixture(scope="module")
def as_given(config):
    return shakedown.import_model(config)


EDITS = [
    ({"friction": 0.5}, "friction = 0.3", "friction = 0.5"),
    ({"steps": 96.0}, "steps = 48", "steps = 96"),
    ({"load.2.forces.1.3": 7.5}, '"PUNCH_TOP", 1, 10.0', '"PUNCH_TOP", 1, 7.5'),
    ({"load.2.history.harmonics.1.sin": 2.0}, "sin = 1.0", "sin = 2.0"),
    ({"load.1.history": 3}, "history = 1.0 ", "history = 3 "),
    ({"contact.gap": -1e-4}, "[contact]", "[contact]\ngap = -1e-4"),
    ({"stiffness.scale": 2.0}, "[stiffness]", "[stiffness]\nscale = 2.0"),
]


@pytest.mark.parametrize(("changes", "old", "new"), EDITS, ids=[next(iter(edit[0])) for edit in EDITS])
def test_a_changed_number_is_an_edited_file(config, as_given, changes, old, new):
    text = config.read_text()
    assert text.count(old) == 1
    edited = config.with_name("edited.toml")
    edited.write_text(text.replace(old, new))
    expected = import_problem(edited)
    for before in (None, as_given):
        made = shakedown.import_model(config, changes=changes, before=before)
        for key in ("A", "B", "C", "f", "q_w", "p_w"):
            assert np.array_equal(getattr(made.problem, key), getattr(expected, key)), key
        assert made.sources == as_given.sources
        assert next(iter(changes)) in made.problem.source


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("load.x.history", "expected a number from 1 to 3, found 'x'"),
        ("lod.1", "expected one of 'name', .* found 'lod'"),
        ("friction.2", "expected a table or a list before '2', found 0.3"),
        ("load.1.forces", "expected the key of a number, found"),
        ("load.1.hystory", "unknown key 'hystory'"),
    ],
)
def test_a_key_without_a_number_is_said(config, as_given, key, message):
    with pytest.raises(ProblemError, match=message) as caught:
        shakedown.import_model(config, changes={key: 1.0}, before=as_given)
    assert "\n" not in str(caught.value)
