"""`shakedown-bounds adversary`: the interval of the true limit, and the state that cycles."""

from dataclasses import replace

import numpy as np
import pytest
from command import document, run

import shakedown

QUICK = ("--states", "16", "--rounds", "3")


def test_the_first_sentence_is_the_interval():
    code, out, err = run("adversary", "three-node", *QUICK)
    assert (code, err) == (0, "")
    said = " ".join(out.split())
    assert "lies between λ_U = 0.3096 (proved) and λ_cycle = 2.44421" in said
    assert "In that cycle node 0 slips and returns to where it was every cycle." in said
    assert "78.9% of the first collapse λ_1 = 3.096, which is no guarantee here" in said
    assert max(map(len, out.splitlines())) <= 80


def test_the_state_found_can_be_simulated(tmp_path):
    found = document("adversary", "three-node", *QUICK, "-o", "slip.npy", cwd=tmp_path)
    words = ("--load-factor", repr(found["load_factor"]), "--initial", "slip.npy")
    run_of_it = document("simulate", "three-node", *words, cwd=tmp_path)
    assert run_of_it["outcome"] == found["outcome"] == "cyclic-slip"
    assert run_of_it["initial_slip"] == found["initial_slip"]
    assert found["interval"] == [found["universal"]["load_factor"], found["load_factor"]]
    assert found["lower"]["guarantee"] == "evidence"


def test_where_no_cycle_is_found_the_answer_is_open():
    code, out, _ = run("adversary", "jump", *QUICK)
    assert code == 1
    assert "No cycle was found in" in out
    assert document("adversary", "jump", *QUICK, code=1)["load_factor"] == "inf"


def test_a_limit_of_zero_is_said():
    out = run("adversary", "block-9", *QUICK)[1]
    assert "No load factor is proved safe from every state, nor can be" in " ".join(out.split())


def test_transient_load_steps_are_said_to_be_left_out(tmp_path):
    joint = shakedown.example("three-node")
    steps = {"q_transient": np.zeros((1, 3)), "p_transient": np.full((1, 3), 9.0)}
    shakedown.save_problem(tmp_path / "joint.npz", replace(joint, **steps))
    out = run("adversary", str(tmp_path / "joint.npz"), *QUICK)[1]
    assert "The transient load steps of the file were left out" in out
    assert "λ_cycle = 2.444211" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--states", "0"), "0 is not in the range x>=1"),
        (("--seed", "-1"), "-1 is not in the range x>=0"),
        (("--largest", "0"), "largest: expected a positive load factor"),
        (("--largest", "nan"), "largest: expected a positive load factor"),
        (("-o", "no/such/slip.npy"), "cannot be written"),
    ],
)
def test_bad_words_are_one_line(tmp_path, words, message):
    code, out, err = run("adversary", "two-node", *words, cwd=tmp_path)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
