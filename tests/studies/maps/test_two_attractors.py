"""The limit cycle need not be unique: two stable ones of period 1, found by a search and kept."""

import numpy as np
import pytest

import shakedown
from shakedown.motion.evolution import Evolution

JOINT = shakedown.example("two-attractors")
DISSIPATIONS = (1.876905, 2.135192)


@pytest.fixture(scope="module")
def found():
    return shakedown.initial_state_map(JOINT, 1.0, states=512, reach=2.0)


def test_both_are_there(found):
    assert found.outcomes == {"cyclic-slip": 512}
    cycles = sorted(found.limit_cycles, key=lambda cycle: cycle.dissipation)
    assert [cycle.period for cycle in cycles] == [1, 1]
    assert [cycle.slipping_nodes for cycle in cycles] == [(0, 1), (0, 1)]
    assert min(cycle.count for cycle in cycles) > 100
    for cycle, expected in zip(cycles, DISSIPATIONS, strict=True):
        low, high = cycle.dissipation
        assert high - low <= 1e-9 * high
        assert low == pytest.approx(expected, abs=5e-7)
    assert found.unique is False


@pytest.mark.parametrize("which", [0, 1])
def test_both_are_stable_and_a_disturbance_shrinks_by_the_contraction(found, which):
    """Second method for the contraction: the slips of two neighbours, cycle by cycle."""
    cycle = sorted(found.limit_cycles, key=lambda cycle: cycle.dissipation)[which]
    ends = []
    for away in (0.0, 1e-6):
        evolution = Evolution(JOINT, 1.0, cycle.final_slip[0] + away)
        slips = []
        for _ in range(12):
            evolution.cycle()
            slips.append(evolution.method.u[:2].copy())
        ends.append(slips)
    apart = np.abs(np.subtract(*ends)).max(axis=1)
    assert apart[-1] / apart[-2] == pytest.approx(found.contraction[cycle.example], rel=1e-3)
    assert 0 < found.contraction[cycle.example] < 1
