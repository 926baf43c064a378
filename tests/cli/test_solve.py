"""`solve`, in the plane and in space: what it says is proved, which nodes are open."""

import re

import numpy as np
import pytest
from command import document, refused, run
from partly_open import partly_open

import shakedown


def test_solve_says_first_what_is_certain():
    lines = [" ".join(line.split()) for line in run("solve", "block-9")[1].splitlines()]
    assert lines[1] == "constant load: mean of steps, assumed (no q_mean, p_mean); λ scales the rest"
    assert "the joint shakes down from zero slip:" in lines[2]
    assert lines[4:8] == [
        "shakedown (slip ceases) load factor margin valid for",
        "proved from every state not proved – full contact",
        "proved from this state 4.663 +366.3 % zero slip (λ_E)",
        "impossible above 4.716 +371.6 % full contact (λ_max)",
    ]
    assert lines[-1].startswith("next shakedown-bounds verify block-9 -o report.html")


def test_details_have_every_limit_once():
    out = run("solve", "block-9", "--details")[1]
    for symbol, name in (
        ("λ_1", "first collapse"),
        ("λ_U", "from every state"),
        ("λ_max", "impossible above"),
    ):
        assert out.count(f"  {symbol} ") == 1
        assert name in out
    assert run("solve", "block-9", "--details", "--digits", "7")[1].count("4.663390") == 2


def test_what_is_proved_by_following_stands_below_the_three_numbers():
    out = run("solve", "two-attractors", "--follow")[1]
    told = document("solve", "two-attractors", "--follow")
    followed, numbers = told["followed"], told["assessment"]
    assert numbers["proved_from_this_state"] < followed["load_factor"] <= numbers["impossible_above"]
    assert (followed["cycles"], followed["proved"]) == (1, True)
    (row,) = (line.split() for line in out.splitlines() if line.startswith("  followed"))
    assert 0 <= followed["load_factor"] - float(row[3]) < 1e-3
    assert " ".join(row[4:]) == "proved for this λ only, after 1 cycle"


def test_initial_state_and_distance_are_the_energy_bounds(tmp_path):
    joint = shakedown.example("three-node")
    given = document("solve", "three-node", "--initial", "given", "--distance", "0.1")["energy"]
    expected = shakedown.energy_bound(joint, joint.initial_slip[0], 0.1)
    assert given["status"] == expected.status
    assert given["distance"] == 0.1
    np.save(tmp_path / "state.npy", [0.1, 0.0, 0.0])
    read = document("solve", "three-node", "--initial", str(tmp_path / "state.npy"))["energy"]
    assert read["load_factor"] == pytest.approx(shakedown.energy_bound(joint, [0.1, 0, 0]).load_factor)


@pytest.mark.parametrize(
    ("required", "code"),
    [
        (["proved-from-state=0.73"], 0),
        (["proved-from-state=0.732"], 1),
        (["proved-from-every-state=0.65", "proved-from-state=0.73"], 0),
        (["proved-from-every-state=0.66", "proved-from-state=0.8"], 1),
    ],
)
def test_what_is_required_is_proved_or_the_exit_code_is_1(required, code):
    options = [word for claim in required for word in ("--require", claim)]
    found, out, err = run("solve", "two-node", "--json", *options)
    assert (found, err.count("\n")) == (code, len(required) * code)
    assert "assessment" in out
    if code:
        name, least = required[-1].split("=")
        assert f"--require {name}={least}: not met, proved is up to λ = 0.7315934\n" in err


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize(
    ("name", "colour", "answer"),
    [
        ("two-node", "slips", "the joint slips in every cycle: simulated."),
        ("block-9", "agree", "the joint shakes down from zero slip: proved."),
    ],
)
def test_the_report_begins_with_the_answer_for_the_loading_as_given(tmp_path, name, colour, answer):
    code, out, _ = run("verify", name, "--random", "0", "--details", "-o", "r.html", cwd=tmp_path)
    assert code == 0
    assert answer in " ".join(out.split())
    page = (tmp_path / "r.html").read_text()
    banner = page[page.index('<div class="verdict') : page.index("<h2")]
    assert f'class="verdict {colour}"' in banner
    assert answer in banner.replace("\N{NO-BREAK SPACE}", " ")


def test_simulate_takes_the_nominal_load():
    assert document("simulate", "two-node") == document("simulate", "two-node", "--load-factor", "1")


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


def test_simulate_starts_with_open_nodes(tmp_path):
    words = ["simulate", "cylinder-on-flat", "--load-factor", "0.5", "--initial", "safe", "--open"]
    found = [document(*words, nodes, cwd=tmp_path) for nodes in ("auto", "0,1,2,10,11,12")]
    assert found[0] == found[1]
    assert found[0]["outcome"] == "shakedown"
    assert found[0]["proved"]
    assert found[0]["open_nodes"] == [0, 1, 2, 10, 11, 12]
    refused(*words, "13", cwd=tmp_path, message="open nodes: expected")


BLOCK = "block-3x3"


def test_text_begins_with_the_three_numbers_and_ends_with_both_slips_of_every_node():
    code, out, err = run("solve", BLOCK, "--details")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[0] == "elastic block in space: 9 nodes (3-D), 40 load steps, f = 0.4"
    assert "λ_1, sensitivities and friction thresholds exist for plane joints" in " ".join(out.split())
    (head,) = (k for k, line in enumerate(lines) if "safe slip x  safe slip y  reached at λ_max" in line)
    safe = shakedown.upper_bound(shakedown.example(BLOCK)).slip
    for node, line in enumerate(lines[head + 1 : head + 10]):
        number, x, y, *steps = line.split()
        assert int(number) == node
        np.testing.assert_allclose([float(x), float(y)], safe[2 * node : 2 * node + 2], rtol=1e-6)
        assert all(0 <= int(step) < 40 for run in steps if run != "–" for step in run.rstrip(",").split("–"))
    assert "x, y: the two tangential directions of a node" in out
