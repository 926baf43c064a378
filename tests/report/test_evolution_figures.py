"""Figures of an evolution show what happened."""

import pytest

import shakedown
from shakedown.report.evolution_figures import load_plane, slip_space


def texts(figure):
    return [text.get_text() for text in figure.axes[0].get_legend().get_texts()]


def test_load_plane_shows_states_and_sectors():
    problem = shakedown.example("one-node-separation")
    run = shakedown.evolve(problem, 1.0, problem.initial_slip[0], cycles=3)
    shown = texts(load_plane(problem, run.history))
    assert {"stick", "open"} <= set(shown)
    assert "v = -1" in shown
    assert "backward slip" not in shown


def test_slip_space_shows_the_jump_and_the_rows():
    problem = shakedown.example("jump")
    figure = slip_space(problem, shakedown.evolve(problem, 1.0, problem.initial_slip[0]).history)
    assert sum(name.endswith("ward") for name in texts(figure)) == 4
    assert any(line.get_linestyle() == ":" for line in figure.axes[0].lines)


def test_slip_space_wants_two_nodes():
    problem = shakedown.example("one-node")
    with pytest.raises(shakedown.UsageError, match="2 nodes"):
        slip_space(problem, shakedown.evolve(problem, 1.0).history)
