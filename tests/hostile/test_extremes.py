"""Numbers from the ends of what floating-point numbers hold: an answer, a status or one line."""

import dataclasses

import numpy as np
import pytest
from hostile.campaign import judge, numbers
from hostile.extreme_problems import extreme, joint_arrays

import shakedown
from shakedown import Problem, ProblemError, UsageError
from shakedown.motion.evolution import evolve

SIZES = {  # (largest size of every array that is read, message)
    "stiffness denormal": (("A", "B", "C"), 5e-324, "largest magnitude"),
    "stiffness huge": (("A", "B", "C"), 1e300, "largest magnitude"),
    "stiffness beyond": (("A", "B", "C"), 1e308, "found inf"),
    "loads denormal": (("q_w", "p_w"), 1e-310, "largest magnitude"),
    "loads huge": (("q_w", "p_w"), 1e200, "largest magnitude"),
    "loads tiny for the stiffness": (("q_w", "p_w"), 1e-90, "forces over stiffness"),
    "friction": (("f",), 1e300, "largest magnitude"),
    "friction beyond its limit": (("f",), 1e20, "friction coefficients up to"),
}


@pytest.mark.parametrize("case", SIZES)
def test_what_cannot_be_calculated_with_is_refused_in_one_line(case):
    keys, size, message = SIZES[case]
    problem = shakedown.example("two-node")
    with np.errstate(over="ignore"):
        changes = {key: size * getattr(problem, key) for key in keys}
    with pytest.raises(ProblemError, match=message) as caught:
        dataclasses.replace(problem, **changes)
    assert "\n" not in str(caught.value)


def test_negligible_entries_are_zero():
    A = np.array([[2.0, 5e-324], [5e-324, 1.0]])
    problem = Problem(
        A=A, B=1e-300 * np.eye(2) + np.eye(2)[::-1], f=0.3, q_w=[[1.0, 1e-310]], p_w=[[2.0, 2.0]]
    )
    assert problem.A.tolist() == [[2.0, 0.0], [0.0, 1.0]]
    assert problem.B.tolist() == [[0.0, 1.0], [1.0, 0.0]]
    assert problem.q_w.tolist() == [[1.0, 0.0]]


@pytest.mark.parametrize("slip", [1e200, -1e300])
def test_an_initial_slip_without_reactions_is_refused(slip):
    problem = shakedown.example("two-node")
    for call in (shakedown.simulate, shakedown.long_term_state, evolve):
        with pytest.raises(UsageError, match="initial slip"):
            call(problem, 0.5, [slip, 0.0])


def test_extreme_joints_in_space_at_the_command_line(tmp_path):
    for number in numbers(3):
        rng = np.random.default_rng([6, number])
        np.savez(tmp_path / "p.npz", **extreme(joint_arrays(rng, 2), rng))
        judge(
            number, ["solve", "p.npz", *rng.choice(["--json", "--details", "-q"], 1).tolist()], str(tmp_path)
        )


def test_extreme_joints_at_the_command_line(tmp_path):
    for number in numbers(8):
        rng = np.random.default_rng([5, number])
        arrays = extreme(joint_arrays(rng), rng)
        np.savez(tmp_path / "p.npz", **arrays)
        judge(number, ["critical", "p.npz", "-q"], str(tmp_path))
        if np.any(arrays["A"]):  # zero stiffness has no rates of its own
            words = [
                "simulate",
                "p.npz",
                "--load-factor",
                str(rng.choice([0.0, 0.5, 1.0, 1e6, 1e300])),
                "--cycles",
                "20",
            ]
            judge(number, words, str(tmp_path))
