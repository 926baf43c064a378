"""What the commands say is proved: from this state, from every state, at the nominal load."""

import numpy as np
import pytest
from command import document, refused, run

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


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--require", "proved=1"), "--require: expected proved-from-state=X or proved-from-every-state=X"),
        (("--require", "proved-from-state=nan"), "with X > 0, found 'proved-from-state=nan'"),
        (("--require", "proved-from-state"), "with X > 0, found 'proved-from-state'"),
        (("--distance", "-1"), "distance: expected a number >= 0, found -1"),
        (("--distance", "nan"), "distance: expected a number >= 0, found nan"),
        (("--initial", "safe"), "expected zero, given, given:K or PATH.npy"),
        (("--initial", "none.npy"), "found none.npy, which is no file"),
        (("--initial", "given"), "found given, of a problem with 0 given states"),
    ],
)
def test_bad_states_and_distances_are_one_line(words, message):
    refused("solve", "two-node", *words, message=message)


def test_simulate_takes_the_nominal_load():
    assert document("simulate", "two-node") == document("simulate", "two-node", "--load-factor", "1")
