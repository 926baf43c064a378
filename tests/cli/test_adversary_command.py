"""`shakedown-bounds adversary`: the interval of the true limit, and the state that cycles."""

import re
from dataclasses import replace

import numpy as np
import pytest
from command import document, run

import shakedown
from shakedown.ground import shown_values as words

QUICK = ("--states", "16", "--rounds", "3")


def test_the_first_sentence_is_the_interval():
    code, out, err = run("adversary", "three-node", *QUICK)
    assert (code, err) == (0, "")
    said = " ".join(out.split())
    assert re.search(
        r"lies between λ_U = 0.3(095999|096) \(proved\) and λ_cycle = 2.444211 \(a cycle was", said
    )
    assert "In that cycle node 0 slips and returns to where it was every cycle." in said
    assert "78.9% of the first collapse λ_1 = 3.096, which is no guarantee here" in said
    assert max(map(len, out.splitlines())) <= 80


def test_the_state_found_can_be_simulated(tmp_path):
    found = document("adversary", "three-node", *QUICK, "-o", "slip.npy", cwd=tmp_path)
    state = ("--load-factor", repr(found["load_factor"]), "--initial", "slip.npy")
    run_of_it = document("simulate", "three-node", *state, cwd=tmp_path)
    assert run_of_it["outcome"] == found["outcome"] == "cyclic-slip"
    assert run_of_it["initial_slip"] == found["initial_slip"]
    assert found["interval"] == [found["universal"]["load_factor"], found["load_factor"]]
    assert found["lower"]["guarantee"] == "evidence"


def test_where_no_cycle_is_found_the_answer_is_open():
    code, out, _ = run("adversary", "jump", *QUICK)
    assert code == 1
    assert "No cycle was found: 48 simulations at load factors up to λ = 1." in out
    assert "simulations 48 up to λ = 1, seed 0" in " ".join(out.split())
    assert document("adversary", "jump", *QUICK, code=1)["load_factor"] == "inf"


def test_separation_is_said_apart_from_the_cycle(tmp_path, monkeypatch):
    joint = replace(shakedown.example("press-fit"), f=np.full(9, 0.8))
    shakedown.save_problem(tmp_path / "fit.npz", joint)
    once = shakedown.smallest_cycle(joint, states=8, rounds=3, seed=4)
    monkeypatch.setattr(shakedown, "smallest_cycle", lambda *_, **__: once)
    out = run("adversary", "fit.npz", *QUICK, cwd=tmp_path)[1]
    found = document("adversary", "fit.npz", *QUICK, cwd=tmp_path)
    apart, cycle = found["separation_load_factor"], found["load_factor"]
    assert found["interval"] == [found["universal"]["load_factor"], apart]
    assert apart < cycle
    said = " ".join(out.split())
    assert f"and λ = {words.up(apart)} (separation was found)" in said
    assert "nodes open and close in every period, or contact is lost, without slip in contact" in said
    assert f"The smallest cycle was found at λ_cycle = {words.up(cycle)}." in said
    assert f"smallest separation {words.up(apart)}" in said
    assert f"λ_cycle, smallest cycle {words.up(cycle)}" in said
    assert f"λ_U, from every state {words.down(found['universal']['load_factor'])}" in said


def test_the_table_has_units_and_the_labels_of_the_model():
    out = run("adversary", "press-fit", *QUICK)[1]
    assert "node    FE  initial slip [mm]  slip per period [mm]" in out
    assert "N mm" in out
    assert "In that cycle node 4 (FE 40/4) slips" in " ".join(out.split())
    assert max(map(len, out.splitlines())) <= 80


def test_a_limit_that_does_not_exist_has_no_line():
    out = run("adversary", "cylinder-on-flat", *QUICK)[1]
    assert "nan" not in out
    assert "λ_1" not in out


def test_a_limit_of_zero_is_said():
    out = run("adversary", "block-9", "--states", "2", "--rounds", "1")[1]
    assert "No load factor is proved safe from every state, nor can be" in " ".join(out.split())


def test_transient_load_steps_are_said_to_be_left_out(tmp_path):
    joint = shakedown.example("three-node")
    steps = {"q_transient": np.zeros((1, 3)), "p_transient": np.full((1, 3), 9.0)}
    shakedown.save_problem(tmp_path / "joint.npz", replace(joint, **steps))
    out = run("adversary", str(tmp_path / "joint.npz"), *QUICK)[1]
    assert "The transient load steps of the file were left out" in out
    assert "λ_cycle = 2.444211" in out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--states", "0"), "0 is not in the range x>=1"),
        (("--seed", "-1"), "-1 is not in the range x>=0"),
        (("--largest", "0"), "largest: expected a positive load factor"),
        (("--largest", "nan"), "largest: expected a positive load factor"),
        (("-o", "no/such/slip.npy"), "cannot be written"),
    ],
)
def test_bad_words_are_one_line(tmp_path, options, message):
    code, out, err = run("adversary", "two-node", *options, cwd=tmp_path)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
