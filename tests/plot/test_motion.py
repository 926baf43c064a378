"""Instants and animations: rows touch the slip where a node slips, films have their frames."""

from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

import shakedown
from shakedown import plot

JOINT = shakedown.example("two-node")


@pytest.fixture(scope="module")
def run():
    return shakedown.simulate(JOINT, 0.72, [1.5, 1.5], record=True)


def test_thick_rows_touch_the_slip_and_thin_ones_do_not_cut_what_sticks(run):
    touched = 0
    for cycle in np.linspace(0.0, 2.0, 41):
        axes = plot.slip_space_at(run, JOINT, cycle)
        state = run.history.at(np.array([cycle])).state[0]
        thick = [line for line in axes.lines if line.get_linewidth() == 2.5]
        assert len(thick) == np.count_nonzero(state)
        slip = axes.lines[-1].get_xydata()[0]
        for line in thick:
            foot, slope = np.array(line.get_xy1()), np.subtract(line.get_xy2(), line.get_xy1())
            away = np.cross([*slope, 0.0], [*(slip - foot), 0.0])[2] / np.linalg.norm(slope)
            assert abs(away) <= 1e-9
            touched += 1
    assert touched > 5


def test_the_load_is_on_the_edge_of_its_sector_where_the_node_slips(run):
    for cycle in np.linspace(0.0, 1.0, 21):
        axes = plot.reactions_at(run, JOINT, cycle, 1)
        kind = int(run.history.at(np.array([cycle])).state[0, 1])
        apex, edge = axes.patches[0].get_xy()[:2]
        dots = [line.get_xydata()[0] for line in axes.lines[2:] if not np.isnan(line.get_xydata()).any()]
        (here,) = dots
        tangential, normal = here - apex
        use = tangential / (JOINT.f[1] * normal)
        assert abs(use) <= 1 + 1e-9
        if kind:
            assert use == pytest.approx(kind, abs=1e-9)
        assert edge[0] > apex[0]


def test_the_title_names_the_node(run):
    assert plot.reactions_at(run, JOINT, 0.5, 1).get_title() == "node 1, t = 0.50 cycles"
    named = replace(JOINT, label=["left", "right"])
    assert plot.reactions_at(run, named, 0.5, 1).get_title() == "node 1 (FE right), t = 0.50 cycles"


def test_an_open_node_has_no_sector():
    joint = shakedown.example("one-node-separation")
    run = shakedown.simulate(joint, 1.0, [0.0], record=True)
    history = run.history
    opened = history.cycle[np.flatnonzero(history.state[:, 0] == 2)[0]]
    assert len(plot.reactions_at(run, joint, float(opened) + 1e-6).patches[0].get_xy()) <= 1


@pytest.mark.parametrize("animate", [plot.animate_slip_space, plot.animate_reactions])
def test_a_film_has_its_frames_and_is_small(run, tmp_path, animate):
    path = tmp_path / "film.gif"
    animate(run, JOINT, path, frames=3, longest=1.0)
    with Image.open(path) as film:
        assert (film.format, film.n_frames, film.info["loop"]) == ("GIF", 3, 0)
    assert path.stat().st_size < 60_000


def test_misuse_is_said_in_one_line(run, tmp_path):
    with pytest.raises(shakedown.UsageError, match="2 nodes, found 3"):
        plot.slip_space_at(run, shakedown.example("three-node"), 0.0)
    with pytest.raises(shakedown.UsageError, match="node: expected a number from 0 to 1"):
        plot.reactions_at(run, JOINT, 0.0, 2)
    with pytest.raises(shakedown.UsageError, match="frames: expected at least 1"):
        plot.animate_slip_space(run, JOINT, tmp_path / "a.gif", frames=0)
    with pytest.raises(shakedown.UsageError, match="expected recorded events"):
        plot.animate_slip_space(shakedown.simulate(JOINT, 0.7), JOINT, tmp_path / "a.gif")
    assert not list(tmp_path.iterdir())
