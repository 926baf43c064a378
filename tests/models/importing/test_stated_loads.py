"""Loads as the user knows them: unit and value of a load case become mean and amplitude of the problem."""

import numpy as np
import pytest

import shakedown
from shakedown import LoadCase, ProblemError, UsageError
from shakedown.joint.units import loads_in_words
from shakedown.models.condensation.load_case import histories, stated_loads
from shakedown.models.importing.import_model import import_problem
from shakedown.models.importing.templates import write_import_example

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


def test_an_import_knows_what_a_unit_of_every_load_does(stated):
    """Reactions, histories, a compliance that is symmetric and positive for forces; of a mode its frequency."""
    stated.write_text(stated.read_text().replace(HISTORIES[1], f"frequency = 3.5\n{HISTORIES[1]}"))
    problem = import_problem(stated)
    welded = problem.layout.joined(problem.q_w, problem.p_w)
    np.testing.assert_allclose(
        problem.load_history @ problem.load_reactions, welded, atol=1e-12 * np.abs(welded).max()
    )
    np.testing.assert_allclose(problem.load_frequency, [np.nan, 3.5, np.nan])
    assert np.linalg.eigvalsh(problem.load_compliance)[0] > -1e-12 * np.abs(problem.load_compliance).max()
    stated.write_text(stated.read_text().replace("frequency = 3.5", "frequency = -1.0"))
    with pytest.raises(ProblemError, match="frequency: expected a number > 0, found -1"):
        import_problem(stated)


def test_the_mean_of_a_sampled_wave_is_zero_and_not_round_off():
    wave = LoadCase(history=np.cos(2 * np.pi * np.arange(48) / 48), force=[1.0], unit="N")
    assert np.cos(2 * np.pi * np.arange(48) / 48).mean() != 0
    assert stated_loads([wave], histories([wave]))["load_mean"] == [0.0]
    assert stated_loads([wave], histories([wave]))["load_amplitude"] == [1.0]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("value = nan", "load 1: key 'value': expected a finite number, found nan"),
        ("unit = 20", "load 1: key 'unit': expected text, found 20"),
    ],
)
def test_what_is_no_unit_or_value_is_said(stated, line, message):
    stated.write_text(stated.read_text().replace('unit = "kN"', line).replace("value = 0.7\n", ""))
    with pytest.raises(ProblemError, match=message):
        import_problem(stated)


def test_a_sweep_says_which_names_it_cannot_take(stated):
    problem = import_problem(stated)
    with pytest.raises(UsageError, match=r"vary: expected one of f, .*, found 'pressed down'"):
        shakedown.sweep(problem, {"pressed down": [1.0]})
