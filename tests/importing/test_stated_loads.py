"""Loads as the user knows them: unit and value of a load case become mean and amplitude of the problem."""

import numpy as np
import pytest

import shakedown
from shakedown import LoadCase, ProblemError
from shakedown.condensation.load_case import histories, stated_loads
from shakedown.importing.import_model import import_problem
from shakedown.importing.templates import write_import_example
from shakedown.joint.units import loads_in_words

HISTORIES = ("history = 1.0 ", "history = { harmonics = [{ order = 1, sin = 1.0 }] }")


@pytest.fixture
def stated(tmp_path):
    """The example, its loads with units: the first is constant, the second a wave, the third plain."""
    write_import_example(tmp_path)
    text = (tmp_path / "import.toml").read_text()
    text = text.replace(HISTORIES[0], f'unit = "kN"\nvalue = 0.7\n{HISTORIES[0]}')
    text = text.replace(HISTORIES[1], f'unit = "N"\nvalue = -70\nmean = 0.5\n{HISTORIES[1]}')
    (tmp_path / "import.toml").write_text(text)
    return tmp_path / "import.toml"


def test_units_and_values_become_means_and_amplitudes(stated, tmp_path):
    problem = import_problem(stated)
    assert [load.unit for load in problem.loads] == ["kN", "N", ""]
    np.testing.assert_allclose(problem.load_mean, [0.7, -35.0, 0.0], rtol=1e-15, atol=0)
    np.testing.assert_allclose(problem.load_amplitude, [0.0, 105.0, 1.0], rtol=1e-15)
    words = "pushed to and fro -35 ± 210 N; pressed more and less ± 2; pressed down 0.7 kN, unchanged"
    assert loads_in_words(problem, 2.0) == words
    shakedown.save_problem(tmp_path / "p.npz", problem)
    assert shakedown.load_problem(tmp_path / "p.npz").loads == problem.loads


def test_a_load_that_goes_further_one_way_is_noted(stated):
    (note,) = [note for note in shakedown.import_model(stated).notes if "departs" in note]
    assert note.startswith("'pushed to and fro' departs from its mean by -35 and +105 N: its amplitude is ")


def test_an_import_without_units_says_nothing(tmp_path):
    write_import_example(tmp_path)
    made = shakedown.import_model(tmp_path / "import.toml")
    assert made.problem.loads == ()
    assert made.problem.load_mean is None
    assert not [note for note in made.notes if "departs" in note]


def test_the_corners_of_a_domain_have_a_middle():
    wind = LoadCase(range=(-1.0, 3.0), force=[1.0], value=2.0, unit="kN", name="wind")
    found = stated_loads([wind], histories([wind]))
    assert (found["load_mean"], found["load_amplitude"]) == ([2.0], [4.0])


def test_the_mean_of_a_sampled_wave_is_zero_and_not_round_off():
    wave = LoadCase(history=np.cos(2 * np.pi * np.arange(48) / 48), force=[1.0], unit="N")
    assert np.cos(2 * np.pi * np.arange(48) / 48).mean() != 0
    assert stated_loads([wave], histories([wave]))["load_mean"] == [0.0]
    assert stated_loads([wave], histories([wave]))["load_amplitude"] == [1.0]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("value = nan", "load 1: key 'value': expected a finite number, found nan"),
        ('value = "20 kN"', "load 1: key 'value': expected a finite number, found '20 kN'"),
        ("unit = 20", "load 1: key 'unit': expected text, found 20"),
        ("units = 'kN'", "load 1: unknown key 'units'"),
    ],
)
def test_what_is_no_unit_or_value_is_said(stated, line, message):
    stated.write_text(stated.read_text().replace('unit = "kN"', line).replace("value = 0.7\n", ""))
    with pytest.raises(ProblemError, match=message):
        import_problem(stated)


def test_a_value_that_is_no_number_is_refused_by_the_library():
    with pytest.raises(ProblemError, match="load case: value: expected a finite number, found inf"):
        LoadCase(history=1.0, force=[1.0], value=np.inf)
