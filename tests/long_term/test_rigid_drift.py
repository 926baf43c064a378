"""A drift is told as the rigid motion that it is; what does not drift tells of none."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown.report.run_facts import run_sentence
from tests.command import document

RING = shakedown.example("bearing-ring")


def test_a_ring_creeps_by_turning_about_its_middle():
    run = shakedown.simulate(RING, 1.0)
    found = run.rigid_drift
    # slip over radius; of the middle nodes of quadratic facets the radius is smaller, and so is the slip
    assert found.turn == pytest.approx([0, 0, np.degrees(run.drift.max() / 40.0)], rel=1e-6)
    assert not found.shift.any()
    assert found.cycles_per_revolution == 8
    assert f"; per revolution by {8 * found.turn[2]:.4g}°." in run_sentence(RING, run)
    turned = replace(RING, coordinates=RING.coordinates + np.array([5.0, -3.0, 0.0]))
    assert shakedown.simulate(turned, 1.0).rigid_drift.turn == pytest.approx(found.turn, rel=1e-9)
    assert shakedown.node_results(run).to_dict()["rigid_drift"] == run.to_dict()["rigid_drift"]


def test_two_cycles_in_a_period_drift_by_half_as_much_each():
    twice = {key: np.vstack([getattr(RING, key)] * 2) for key in ("q_w", "p_w")}
    loads = dict.fromkeys(("load_reactions", "load_history", "load_compliance", "load_names"))
    once, both = shakedown.simulate(RING, 1.0), shakedown.simulate(replace(RING, **twice, **loads), 1.0)
    assert both.rigid_drift.turn == pytest.approx(2 * once.rigid_drift.turn, rel=1e-6)


def test_what_does_not_creep_tells_of_no_drift():
    assert shakedown.simulate(RING, 0.6).rigid_drift is None
    for name in ("two-node", "press-fit"):
        told = document("simulate", name, "--load-factor", "1.0")
        assert "rigid_drift" not in told
