"""`shakedown-bounds map`: what it says, writes and draws; stopped at any instant, it goes on."""

import json
import os
import signal
import subprocess
import sys
import time
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from command import document, run

import shakedown

MAP = ["map", "two-node", "--load-factor", "0.7"]


def test_the_document_is_the_one_promised():
    found = document(*MAP, "--states", "64")
    assert found["states"] == 64
    assert found["shakedown_fraction"] == 0.859375
    low, high = found["interval"]
    assert low < found["shakedown_fraction"] < high
    (cycle,) = found["limit_cycles"]
    assert (cycle["count"], cycle["period"], cycle["slipping_nodes"]) == (9, 1, [1])
    assert cycle["dissipation"][0] < cycle["dissipation"][1]
    assert found["unique"] is False


def test_people_read_the_share_first():
    code, out, err = run(*MAP, "--states", "64")
    assert (code, err) == (0, "")
    assert max(map(len, out.splitlines())) <= 80
    text = " ".join(out.split())  # no-break spaces too
    assert "of 64 initial states in a box about the safe slip, 85.9 % shake down (95 %: 75.4–92.4 %)" in text
    assert "The final state is not unique" in text
    assert "type (ii)" in text


def test_a_grid_in_two_coordinates(tmp_path):
    found = document(*MAP, "--states", "30", "--grid", "1", "0", "-o", str(tmp_path / "m.npz"))
    assert (found["states"], found["sampler"], found["interval"]) == (25, "grid", [None, None])
    with np.load(tmp_path / "m.npz") as file:
        assert len(np.unique(file["initial_slip"][:5, 1])) == 5
        assert len(np.unique(file["initial_slip"][:5, 0])) == 1


@pytest.mark.parametrize("kind", ["png", "pdf", "svg"])
def test_a_picture_is_drawn(tmp_path, kind):
    path = tmp_path / f"basin.{kind}"
    assert run(*MAP, "--states", "16", "--grid", "0", "1", "--picture", str(path))[0] == 0
    start = {"png": b"\x89PNG", "pdf": b"%PDF", "svg": b"<?xml"}[kind]
    assert path.read_bytes().startswith(start)
    if kind == "svg":
        assert ET.parse(path).getroot().tag.endswith("svg")


def test_a_range_of_load_factors(tmp_path):
    words = ["map", "two-node", "--load-factor", "0.6:0.8:3", "--states", "16"]
    found = document(*words)["maps"]
    assert [one["load_factor"] for one in found] == [0.6, 0.7, 0.8]
    assert [found[0]["shakedown_fraction"], found[2]["shakedown_fraction"]] == [1.0, 0.0]
    code, out, _ = run(*words, "--picture", str(tmp_path / "share.png"))
    assert code == 0
    assert max(map(len, out.splitlines())) <= 80
    assert (tmp_path / "share.png").stat().st_size > 5000


def test_undecided_states_are_said_and_counted():
    words = [*MAP, "--states", "16", "--cycles", "1"]
    found = document(*words, code=1)
    assert found["outcomes"]["undecided"] > 0
    assert "are undecided: see --cycles" in " ".join(run(*words)[1].split())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--load-factor", "a"], "FIRST:LAST:COUNT"),
        (["--load-factor", "1:2"], "FIRST:LAST:COUNT"),
        (["--load-factor", "1:2:0"], "load factor: expected at least one"),
        (["--load-factor", "-1"], "load factor: expected a number >= 0"),
        (["--grid", "0", "5"], "two different nodes from 0 to 1"),
        (["--resume"], "--resume: expected -o FILE"),
        (["--picture", "basin.gif"], "expected a name that ends in .png, .svg or .pdf"),
        (["--sampler", "ball", "--load-factor", "0.8"], "expected a finite energy ball"),
        (["--reach", "nan"], "reach: expected a number > 0"),
        (["-o", "/missing/map.npz"], "cannot be written"),
    ],
)
def test_misuse_ends_in_one_line(words, said, tmp_path):
    code, out, err = run(*MAP, "--states", "8", *words, cwd=tmp_path)
    assert (code, out) == (2, "")
    assert said in err
    assert err.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_the_problem_is_not_written_over(tmp_path):
    path = tmp_path / "joint.npz"
    shakedown.save_problem(path, shakedown.example("two-node"))
    code, _, err = run("map", str(path), "--load-factor", "0.7", "--states", "8", "-o", str(path))
    assert code == 2
    assert "expected another file than the problem" in err


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
    while not (tmp_path / "map.npz.partial").exists() and process.poll() is None:
        time.sleep(0.01)
    time.sleep(after)
    os.kill(process.pid, number)
    return process.communicate(timeout=60)


def test_killed_and_resumed_the_file_is_that_of_an_undisturbed_run(tmp_path, undisturbed):
    generator, killed = np.random.default_rng(0), 0
    for workers in ("1", "2"):
        process = begun(tmp_path, "--resume", "--workers", workers)
        stopped(tmp_path, process, signal.SIGKILL, generator.uniform(0.2, 0.8))
        killed += process.returncode == -signal.SIGKILL
    assert killed
    out, err = begun(tmp_path, "--resume", "--workers", "1", "--json").communicate(timeout=300)
    assert err == ""
    assert json.loads(out)["states"] == STATES
    assert [entry.name for entry in tmp_path.iterdir()] == ["map.npz"]
    assert (tmp_path / "map.npz").read_bytes() == undisturbed


def test_ctrl_c_is_one_line_and_keeps_what_is_done(tmp_path):
    out, err = stopped(tmp_path, process := begun(tmp_path, "--workers", "2"), signal.SIGINT, 0.3)
    assert (process.returncode, out, err) == (130, "", "shakedown-bounds: interrupted\n")
    assert (tmp_path / "map.npz.partial").exists()
    code, out, err = run(*MAP, "--states", str(STATES), "-o", "map.npz", cwd=tmp_path)
    assert (code, out) == (2, "")
    assert "unfinished run is recorded there; resume it, or remove that file" in err


def test_a_film_of_a_simulation(tmp_path):
    path, words = tmp_path / "film.gif", ["simulate", "one-node", "--load-factor", "1", "--animation"]
    code, _, err = run(*words, str(path))
    assert (code, err) == (0, "")
    assert path.read_bytes()[:6] == b"GIF89a"
    code, _, err = run(*words, str(tmp_path / "film.png"))
    assert code == 2
    assert "expected a name that ends in .gif" in err
