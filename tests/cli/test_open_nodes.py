"""Partly open joints on the command line: which nodes are open stands in every answer."""

import re

import pytest
from command import document, refused, run
from partly_open import partly_open

import shakedown


def test_the_text_names_the_open_nodes_and_claims_no_upper_bound_of_the_joint():
    text = " ".join(run("solve", "receding-block", "--details")[1].split())
    assert "open nodes nodes 0–4, 28–32 assumed; all others closed safe slip up to 0.2281" in text
    assert "impossible above unknown (10 nodes open)" in text
    for wrong in ("upper bound", "cannot shake down", "λ_max impossible above"):
        assert wrong not in text


@pytest.mark.parametrize("d", [1, 2])
def test_the_table_says_which_nodes_are_open_and_which_gaps_close(d, tmp_path):
    """Open nodes have no friction limit to reach."""
    joint = shakedown.example("receding-block") if d == 1 else partly_open(3, 5, d=2)
    shakedown.save_problem(tmp_path / "joint.npz", joint)
    out = run("solve", str(tmp_path / "joint.npz"), "--details")[1]
    upper = shakedown.upper_bound(joint, open_nodes="auto")
    closing = {node for node, _ in upper.active} & {*upper.open_nodes}
    rows = [line for line in out.partition("reached at λ_max")[2].splitlines() if re.match(r" +\d+ ", line)]
    assert len(rows) == joint.n
    assert {i for i, row in enumerate(rows) if "open" in row} == {*upper.open_nodes}
    assert {i for i, row in enumerate(rows) if "open; gap closes" in row} == closing
    assert "open: throughout; its safe slip is the displacement" in out
    assert closing


def test_nodes_may_be_named_or_none():
    asked = "solve", "receding-block"
    assert document(*asked, "--open", "none")["upper"]["status"] == "infeasible"
    assert document(*asked, "--open", "16", code=1)["upper"]["open_nodes"] == [16]
    text = " ".join(run("solve", "receding-block", "--open", "16")[1].split())
    assert "open nodes node 16 (FE 144) assumed; all others closed safe slip none" in text
    named = ",".join(map(str, [0, 1, 2, 3, 4, 28, 29, 30, 31, 32]))
    found = document(*asked, "--open", named, code=1)["upper"]  # nothing is known of the whole joint
    assert found["load_factor"] == document(*asked, code=1)["upper"]["load_factor"]


@pytest.mark.parametrize(
    ("nodes", "message"),
    [
        ("0,x", "--open: expected auto, none or node numbers like 0,3,7, found '0,x'"),
        ("", "expected auto, none or node numbers"),
        ("-1", "expected auto, none or node numbers"),
        ("99", "open nodes: expected node numbers from 0 to 32, found 99"),
        (",".join(map(str, range(33))), "found all 33 open"),
    ],
)
def test_bad_nodes_are_one_line(nodes, message):
    refused("solve", "receding-block", f"--open={nodes}", message=message)


def test_simulate_starts_with_open_nodes(tmp_path):
    words = ["simulate", "cylinder-on-flat", "--load-factor", "0.5", "--initial", "safe", "--open"]
    found = [document(*words, nodes, cwd=tmp_path) for nodes in ("auto", "0,1,2,10,11,12")]
    assert found[0] == found[1]
    assert found[0]["outcome"] == "shakedown"
    assert found[0]["proved"]
    assert found[0]["open_nodes"] == [0, 1, 2, 10, 11, 12]
    code, _, error = run(*words, "13", cwd=tmp_path)
    assert code == 2
    assert "open nodes: expected" in error
