"""`damping`: numbers of the library, table, picture, exit codes."""

import csv

import numpy as np
import pytest
from command import document, refused, run

from shakedown import Problem, damping, long_term_state, save_problem
from shakedown.long_term.conjugate_displacement import load_loops


@pytest.fixture
def joint(tmp_path):
    """A Jenkins element as a file."""
    found = Problem(
        A=[[2.0]], B=[[0.0]], f=0.5, q_w=[[-1.0], [1.0]], p_w=[[2.0], [2.0]], units="N, mm",
        load_reactions=[[-1.0, 0.0]], load_history=[[1.0], [-1.0]], load_compliance=[[0.1]], load_names=["push"],
    )  # fmt: skip
    save_problem(tmp_path / "joint.npz", found)
    return str(tmp_path / "joint.npz"), found


def test_the_document_the_table_and_the_file_tell_the_curve(joint, tmp_path):
    path, problem = joint
    asked = ("damping", path, "--amplitudes", "0.5:2.5:5", "--load", "push")
    found = document(*asked)
    curve = damping(problem, np.linspace(0.5, 2.5, 5))
    assert found["dissipation"] == curve.dissipation.tolist()
    assert found["secant_stiffness"] == curve.secant_stiffness.tolist()
    assert found["frequency"] == [None] * 5
    code, out, err = run(*asked, "-o", str(tmp_path / "x.csv"), "--picture", str(tmp_path / "x.svg"))
    assert (code, err) == (0, "")
    assert "no damping, proved up to 1 from the initial state" in " ".join(out.split())
    assert "at 5 amplitudes" in out
    assert max(map(len, out.splitlines())) <= 80
    rows = list(csv.DictReader((tmp_path / "x.csv").read_text().splitlines()))
    assert [float(row["dissipation"]) for row in rows] == found["dissipation"]
    assert (tmp_path / "x.svg").read_text().startswith("<?xml")


WRONG = [
    (["--amplitudes", "1:2"], "--amplitudes: expected LOW:HIGH:COUNT"),
    (["--amplitudes", "1:2:inf"], "--amplitudes: expected LOW:HIGH:COUNT"),
    (["--amplitudes=-1e308:1e308:3"], "--amplitudes: expected LOW:HIGH:COUNT"),
    (["--amplitudes", "1,x"], "--amplitudes: expected LOW:HIGH:COUNT"),
    (["--amplitudes", "2,1"], "amplitudes: expected numbers >= 0 that rise, at least one, found [2, 1]"),
    (["--amplitudes", "1,2", "--load", "pull"], "load: expected one of 0 to 0, 'push', found 'pull'"),
    (["--amplitudes", "1,2", "--initial", "safe"], "--initial: expected zero, given"),
]


@pytest.mark.parametrize(("options", "line"), WRONG)
def test_bad_usage_is_one_line(joint, options, line):
    refused("damping", joint[0], *options, message=line)


def test_a_joint_that_does_not_know_its_loads_says_so():
    code, _, err = run("damping", "two-node", "--amplitudes", "1,2")
    assert code == 2
    assert "key 'load_reactions': needed" in err


def test_a_loop_is_written(joint, tmp_path):
    path = tmp_path / "loop.csv"
    load_loops(joint[1], long_term_state(joint[1], 2.0)).save(path, joint[1])
    rows = list(csv.DictReader(path.read_text().splitlines()))
    x, c = (np.array([float(row[key]) for row in rows]) for key in ("displacement", "load"))
    assert (0.5 * (c[1:] + c[:-1]) * np.diff(x)).sum() == pytest.approx(2.0, rel=1e-12)
    assert {(row["load_name"], row["load_number"]) for row in rows} == {("push", "0")}
    assert {(row["load_unit"], row["displacement_unit"]) for row in rows} == {("", "N mm per unit of load")}
