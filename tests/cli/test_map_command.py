"""`shakedown-bounds map`: what it says, writes and draws; stopped at any instant, it goes on."""

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
    assert document(*MAP)["states"] == 1024
    assert document(*MAP, "--states", "1")["states"] == 1


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
        (["--states", "0"], "0 is not in the range"),
        (["--states", "10000000000"], "states: expected a whole number from 1 to 10,000,000, found"),
        (["--reach", "1e308"], "reach: expected slips in the range of numbers"),
    ],
)
def test_misuse_ends_in_one_line(words, said, tmp_path):
    refused(*MAP, "--states", "8", *words, cwd=tmp_path, message=said)
