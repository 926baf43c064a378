"""`shakedown-bounds map`: what it says, writes and draws; stopped at any instant, it goes on."""

import json
import os
import re
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET

import joints
import numpy as np
import pytest
from command import document, refused, run

import shakedown

MAP = ["map", "two-node", "--load-factor", "0.7"]


def test_the_document_is_the_one_promised():
    found = document(*MAP, "--states", "64")
    assert found["states"] == 64
    assert found["shakedown_fraction"] == found["outcomes"]["shakedown"] / 64
    assert found["named"] == {"zero": "shakedown", "given": None, "critical": "cyclic-slip"}
    low, high = found["interval"]
    assert low < found["shakedown_fraction"] < high
    (cycle,) = found["limit_cycles"]
    assert (cycle["count"], cycle["period"], cycle["slipping_nodes"]) == (
        found["outcomes"]["cyclic-slip"],
        1,
        [1],
    )
    assert cycle["dissipation"][0] < cycle["dissipation"][1]
    assert found["unique"] is False


def test_people_read_the_share_then_what_becomes_of_slip_zero_and_the_critical_state():
    code, out, err = run(*MAP, "--states", "64")
    assert (code, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    text = " ".join(out.split())  # no-break spaces too
    share = text.index(
        "of 64 initial states in a box about the safe slip 84.4 % shake down (95 %: 73.6–91.3 %)"
    )
    named = text.index(
        "from zero slip shakedown from the critical state cyclic-slip dissipation 181.8 per cycle"
    )
    assert share < named
    assert "The share is that of these states" in text
    assert "same final state no" in text
    assert "type (ii)" in text


def test_a_grid_in_two_coordinates(tmp_path):
    found = document(*MAP, "--states", "30", "--grid", "1", "0", "-o", str(tmp_path / "m.npz"))
    assert (found["states"], found["sampler"], found["interval"]) == (25, "grid", [None, None])
    with np.load(tmp_path / "m.npz") as file:
        assert len(np.unique(file["initial_slip"][2:7, 1])) == 5
        assert len(np.unique(file["initial_slip"][2:7, 0])) == 1


def test_a_picture_is_drawn(tmp_path):
    path = tmp_path / "basin.svg"
    assert run(*MAP, "--states", "16", "--grid", "0", "1", "--picture", str(path))[0] == 0
    assert ET.parse(path).getroot().tag.endswith("svg")


def test_undecided_states_are_said_and_counted():
    words = [*MAP, "--states", "16", "--cycles", "1"]
    found = document(*words, code=1)
    assert found["outcomes"]["undecided"] > 0
    assert f"undecided {found['outcomes']['undecided']} is undecided" in " ".join(run(*words)[1].split())


def test_what_slides_away_is_said_without_advice_that_cannot_help(tmp_path):
    shakedown.save_problem(tmp_path / "sliding.npz", joints.sliding())
    code, out, err = run("map", str(tmp_path / "sliding.npz"), "--load-factor", "1", "--states", "16")
    text = " ".join(out.split())
    assert (code, err) == (1, "")
    assert "none is decided" in text
    assert "undecided 16" in text
    for misleading in ("--cycles", "0.0 %", "the others agree"):
        assert misleading not in text


@pytest.fixture(scope="module")
def breathing(tmp_path_factory):
    """A node that opens and closes, and one that stays where it is put; dissipation is round-off at most."""
    path = tmp_path_factory.mktemp("joint") / "breathing.npz"
    p_w = [[1.0, 1.0], [-1.0, 1.0], [-2.0, 1.0], [-1.0, 1.0]]
    one = np.eye(2)
    problem = shakedown.Problem(A=one, B=0.0 * one, C=one, f=0.5, q_w=np.zeros((4, 2)), p_w=p_w)
    shakedown.save_problem(path, problem)
    return str(path)


def test_separation_is_no_limit_cycle_with_slip(breathing):
    code, out, err = run("map", breathing, "--load-factor", "1", "--states", "64")
    assert (code, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    text = " ".join(out.split())
    assert "cyclic-slip" not in text
    assert "separation 64 opens and closes in every cycle" in text
    assert "same outcome yes" in text
    assert "same final state no" in text
    (cycle,) = document("map", breathing, "--load-factor", "1", "--states", "64")["limit_cycles"]
    assert (cycle["outcome"], cycle["coincide"]) == ("separation", False)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--load-factor", "a"], "'a' is not a valid float"),
        (["--grid", "0", "5"], "two different nodes from 0 to 1"),
        (["--resume"], "--resume: expected -o FILE"),
        (["--picture", "basin.gif"], "expected a name that ends in .png, .svg or .pdf"),
        (["--sampler", "ball", "--load-factor", "0.8"], "expected a finite energy ball"),
        (["-o", "/missing/map.npz"], "cannot be written"),
        (["--load-factor", "1e400"], "load factor: expected a finite number"),
        (["--states", "10000000000"], "states: expected a whole number from 1 to 10,000,000, found"),
        (["--reach", "1e308"], "reach: expected slips in the range of numbers"),
    ],
)
def test_misuse_ends_in_one_line(words, said, tmp_path):
    refused(*MAP, "--states", "8", *words, cwd=tmp_path, message=said)


STATES = 60_000  # eight pieces of work


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    path = tmp_path_factory.mktemp("map") / "map.npz"
    shakedown.initial_state_map(shakedown.example("two-node"), 0.7, states=STATES, path=path)
    return path.read_bytes()


def begun(tmp_path, *words):
    command = [sys.executable, "-m", "shakedown", *MAP, "--states", str(STATES), "-o", "map.npz", *words]
    return subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def stopped(tmp_path, process, number, after):
    while not list(tmp_path.glob("map.npz.parts/*.npz")) and process.poll() is None:
        time.sleep(0.01)
    time.sleep(after)
    os.kill(process.pid, number)
    return process.communicate(timeout=60)


@pytest.mark.slow
def test_killed_and_resumed_the_file_is_that_of_an_undisturbed_run(tmp_path, undisturbed, caplog):
    process = begun(tmp_path, "--resume", "--workers", "2")
    stopped(tmp_path, process, signal.SIGKILL, 0.3)
    assert process.returncode == -signal.SIGKILL
    words = ("--states", str(STATES), "-o", "map.npz", "--resume", "--workers", "1", "--json")
    code, out, _ = run(*MAP, *words, cwd=tmp_path)
    assert code == 0
    assert re.fullmatch(r"goes on from \d of 9 pieces in \S+/map\.npz\.parts", caplog.messages[0])
    assert json.loads(out)["states"] == STATES
    assert [entry.name for entry in tmp_path.iterdir()] == ["map.npz"]
    assert (tmp_path / "map.npz").read_bytes() == undisturbed


@pytest.mark.slow
def test_an_interrupt_is_one_line_and_keeps_what_is_done(tmp_path):
    out, err = stopped(tmp_path, process := begun(tmp_path, "--workers", "2"), signal.SIGINT, 0.0)
    assert (process.returncode, out, err) == (130, "", "shakedown-bounds: interrupted\n")
    assert list(tmp_path.glob("map.npz.parts/*.npz"))
    kept = "unfinished run is kept there; resume it, or remove that folder"
    refused(*MAP, "--states", str(STATES), "-o", "map.npz", cwd=tmp_path, message=kept)
