"""The corner of chapter VI and its printed numbers, and chapter III on meshes small enough for a test.

The study of chapter III is ``benchmarks.receding``.
"""

from operator import attrgetter

import numpy as np
import pytest

import shakedown
from benchmarks.bodies.blocks import receding_block
from benchmarks.corner_report import SIDES, corner_report, pair_thresholds
from benchmarks.receding import cycles, first_loading
from shakedown.motion.checked_law import reactions
from shakedown.motion.evolution import evolve

JUMP = shakedown.example("jump")
PRINTED = {  # (6.50)–(6.60); the thesis's matrices had more digits than it prints
    "H": ([[-0.3881, -0.1668], [-0.1961, -0.0794]], 2e-4),
    "eigenvalues": ([-0.4716, 0.0039], 1.5e-4),
    "eigenvectors": ([[-0.8943, -0.4472], [0.3914, -0.9201]], 2e-4),
    "coefficients": ([[0.4218, 0.0015], [0.2109, -0.0036]], 1e-4),
    "slip": ([-20.7296, 30.9087], 5e-3),
    "end.G": ([[0.3881, 0.1668, -0.0525], [0.1754, 0.1216, 0.1082], [-0.0530, 0.1082, 0.5522]], 1e-4),
    "end.P": ([0.0, -2.1236, -5.4453], 3e-3),
    "end.eigenvalues": ([-0.0112, -0.4718, -0.5790], 1e-4),
    "end.slip": ([3.5459, -24.5192], 0.05),
    "end.gap": ([0.0, 3.345], 2e-3),
}
FROM_PRINTED_MATRICES = {"slip": [3.5639831, -24.56392242], "gap": [0.0, 3.34427293]}


@pytest.fixture
def report():
    return corner_report(JUMP, JUMP.q_w[0], JUMP.p_w[0])


@pytest.mark.parametrize("key", PRINTED)
def test_printed_numbers_at_the_corner_and_of_the_end(report, key):
    expected, digits = PRINTED[key]
    assert np.asarray(attrgetter(key)(report)).real == pytest.approx(np.array(expected), abs=digits)


def test_all_eight_thresholds_of_the_pair():
    printed = [0.3557, -0.3557, 0.4079, -0.4079, 4.3009, -4.3009, 4.9314, -4.9314]
    recomputed = np.repeat([0.35567569, 0.40778783, 4.30101229, 4.93117885], 2) * np.tile([1, -1], 4)
    assert pair_thresholds(JUMP) == pytest.approx(np.array(printed), rel=4e-4)
    assert pair_thresholds(JUMP) == pytest.approx(recomputed, abs=5e-9)
    found = shakedown.friction_thresholds(JUMP)
    assert found.single_node == pytest.approx([4.2295, 1.1238], abs=1e-4)
    assert found.uniqueness_in_contact.value == pytest.approx(pair_thresholds(JUMP)[0])


def test_the_corner_leads_where_the_evolution_jumps(report):
    run = evolve(JUMP, 1.0, JUMP.initial_slip[0], damping=np.ones(4))
    assert report.grows
    assert report.opening_node == report.end.node == 1
    assert report.end.possible
    assert run.history.v[-1] == pytest.approx(report.end.slip, abs=1e-7)
    assert run.history.w[-1] == pytest.approx(report.end.gap, abs=1e-7)
    assert tuple(run.history.state[-1]) == report.end.contact == (-1, 2)
    for key, expected in FROM_PRINTED_MATRICES.items():
        assert getattr(report.end, key) == pytest.approx(expected, abs=1e-7)


def test_the_state_at_the_corner_is_on_both_limits(report):
    q, p = reactions(JUMP, JUMP.q_w[0], JUMP.p_w[0], report.slip, np.zeros(2))
    assert report.q == pytest.approx(q)
    assert report.p == pytest.approx(p)
    assert q == pytest.approx(np.array(SIDES) * 0.39 * p)


def test_perturbations_are_those_of_the_linear_system(report):
    """exp(H t) by its modes, and the two inequalities of (6.54) by trying."""
    for amplitudes in np.random.default_rng(0).normal(size=(50, 2)):
        start = amplitudes @ report.eigenvectors
        velocity = (report.H @ start).real
        assert report.admissible(amplitudes) == bool(velocity[0] > 0 and velocity[1] < 0)


def test_zones_do_not_change_during_the_first_loading():
    """Thesis fig. 3.2: a receding contact takes its extent with the first load and keeps it."""
    zones = first_loading(8).state
    assert set(zones[0].tolist()) == {0, -1, 2}  # stick, slip outwards, open
    assert (zones == zones[0]).all()


def test_slip_and_dissipation_fall_as_in_the_thesis():
    """Increments like N^−3.1, read off before the mesh makes the fall geometric; work to 56 %, monotonically."""
    found = cycles(8)
    assert found["exponents"]["5-20"] == pytest.approx(-3.1, abs=0.2)
    assert (np.diff(found["dissipation"]) < 1e-12).all()
    assert found["dissipation_ratio"] == pytest.approx(0.56, abs=0.01)


def test_the_whole_block_does_twice_what_its_half_does():
    whole = shakedown.simulate(receding_block(2), 1.0, record=True)
    half = shakedown.simulate(receding_block(2, symmetric=True), 1.0, record=True)
    assert whole.dissipation_per_cycle == pytest.approx(2 * half.dissipation_per_cycle, rel=1e-9)
    slip, round_off = whole.final_slip, 1e-9 * np.abs(half.final_slip).max()
    np.testing.assert_allclose(slip[16:], half.final_slip, rtol=0, atol=round_off)
    np.testing.assert_allclose(slip, -slip[::-1], rtol=0, atol=round_off)


@pytest.mark.slow
def test_fixed_load_steps_approach_the_exact_dissipation():
    """The thesis's time integration against the exact path: the error halves with the load step."""
    exact = shakedown.simulate(receding_block(2, symmetric=True), 1.0).dissipation_per_cycle
    error = []
    for steps in (10, 20, 40):
        coarse = receding_block(2, symmetric=True, steps=steps, first_loading=10)
        stepped = shakedown.simulate(coarse, 1.0, method="gauss-seidel")
        error.append(abs(stepped.dissipation_per_cycle / exact - 1))
    assert error[0] > error[1] > error[2]
    assert error[2] < 0.02
