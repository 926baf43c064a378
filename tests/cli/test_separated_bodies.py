"""Pressure of the wrong sign: every command says that the bodies separate, and verification does not disagree."""

import numpy as np
import pytest
from command import run

import shakedown
from shakedown.report.facts import notes

A = np.array([[4.0, -1.0, 0.0], [-1.0, 4.0, -1.0], [0.0, -1.0, 4.0]])


@pytest.fixture(scope="module")
def apart(tmp_path_factory):
    path = tmp_path_factory.mktemp("apart") / "apart.npz"
    q_w = 100.0 * np.outer(np.sin(2 * np.pi * np.arange(8) / 8), np.ones(3))
    p_w = np.full((8, 3), -300.0)
    shakedown.save_problem(path, shakedown.Problem(A=A, B=0.3 * np.eye(3), C=A, f=0.4, q_w=q_w, p_w=p_w))
    return str(path)


@pytest.mark.parametrize("words", ["simulate", "nodes"])
def test_the_sign_or_a_gap_is_asked_for_once_before_the_first_sentence(apart, words):
    code, out, _ = run(words, apart, "--load-factor", "1")
    assert code == 0
    before, _, after = out.partition(notes.apart)
    assert "Is its sign right? Or does an initial gap stay open?" in " ".join(before.split())
    assert "Is the sign" not in after


def test_verification_asks_once_for_the_sign_and_says_why(apart):
    code, out, _ = run("verify", apart, "--details")
    assert code == 0
    assert notes.apart in out
    assert " ".join(out.split()).count("Is its sign right?") == 1
    assert "Is the sign" not in out
