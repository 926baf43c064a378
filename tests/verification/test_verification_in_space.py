"""Prediction against simulation with two tangential directions."""

import json
from dataclasses import replace

import numpy as np
import pytest
from command import run

import shakedown


@pytest.fixture(scope="module")
def found():
    return shakedown.verify(shakedown.example("two-node-3d"), random_states=1)


def test_bounds_and_simulations_agree(found):
    assert found.agrees
    assert not found.notes
    regions = {run.region for run in found.runs}
    assert {"below λ_U", "between", "above λ_max"} <= regions
    for each in found.runs:
        assert each.simulation.residual < 1e-7
        if each.region == "below λ_U" or each.case.in_ball:
            assert each.simulation.outcome == "shakedown"
            assert each.agrees
    assert found.second.lower is None
    assert found.second.upper.load_factor == pytest.approx(found.limits.upper.load_factor, rel=1e-7)


def test_the_simulated_limit_lies_between_the_bounds(found):
    limits = found.limits
    proved, transient = limits.energy.load_factor, found.transient
    assert proved * (1 - 1e-9) <= transient.load_factor <= limits.upper.load_factor
    assert transient.proved <= transient.load_factor
    assert transient.cycling > transient.load_factor


def test_the_document_says_what_there_is(found):
    document = json.loads(json.dumps(found.to_dict()))
    assert document["lower"] is document["box"] is document["friction"] is document["critical"] is None
    assert document["universal"]["load_factor"] == found.limits.universal.load_factor
    assert len(document["runs"]) == len(found.runs)
    assert len(document["nodes"]["slip_range_x"]) == 2
    assert np.isfinite(document["upper"]["certified"]).all()


def test_the_command_answers(tmp_path):
    code, out, err = run("verify", "one-node-3d", "--random", "0", "--load-factor", "0.5", cwd=tmp_path)
    assert code == 0, err
    assert "Prediction and time integration agree" in out
    assert max(map(len, out.splitlines())) <= 80


def test_transient_load_steps_come_first():
    problem = shakedown.example("one-node-3d")
    before = replace(problem, q_transient=0.5 * problem.q_w[:2], p_transient=problem.p_w[:2])
    found = shakedown.verify(before, random_states=0, load_factors=[0.5])
    assert found.agrees
    assert found.runs[0].simulation.outcome == "shakedown"
