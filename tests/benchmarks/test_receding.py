"""Chapter III of the thesis on meshes small enough for a test; the study is ``benchmarks.receding``."""

import numpy as np
import pytest

import shakedown
from benchmarks.bodies.blocks import receding_block


def at_p_max(run, steps):
    """Rows of the path at the ends of cycles, p = p_max: the last row of each."""
    ends = np.arange(run.cycles_simulated + 1) - 1 / steps
    return np.searchsorted(run.history.cycle, ends + 1e-9, side="right") - 1


def dissipated(path):
    work = -(0.5 * (path.q[1:] + path.q[:-1]) * np.diff(path.v, axis=0)).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(work)])


@pytest.fixture(scope="module")
def half():
    return shakedown.simulate(receding_block(8, symmetric=True), 1.0, record=True)


def test_zones_do_not_change_during_the_first_loading(half):
    """Thesis fig. 3.2: a receding contact takes its extent with the first load and keeps it."""
    path = half.history
    times = np.linspace(-0.99, -0.51, 25)  # no load at −1, p_max at −0.5
    zones = path.state[np.searchsorted(path.cycle, times, side="right") - 1]
    assert set(zones[0].tolist()) == {0, -1, 2}  # stick, slip outwards, open
    assert (zones == zones[0]).all()


def test_slip_increments_fall_like_a_power_of_the_cycle(half):
    """Thesis: N^−3.1; read off before the mesh makes the fall geometric."""
    v = half.history.v[at_p_max(half, 2)]
    increment = np.abs(np.diff(v, axis=0)).max(axis=1)
    N = np.arange(1, len(increment) + 1)
    slope = np.polyfit(np.log(N[4:20]), np.log(increment[4:20]), 1)[0]
    assert slope == pytest.approx(-3.1, abs=0.2)


def test_dissipation_falls_monotonically_to_the_thesis_s_share(half):
    work = np.diff(dissipated(half.history)[at_p_max(half, 2)])
    assert (np.diff(work) < 1e-12).all()
    assert half.dissipation_per_cycle / work[0] == pytest.approx(0.56, abs=0.01)
    assert half.outcome == "cyclic-slip"


def test_the_whole_block_does_twice_what_its_half_does():
    whole = shakedown.simulate(receding_block(2), 1.0, record=True)
    half = shakedown.simulate(receding_block(2, symmetric=True), 1.0, record=True)
    assert whole.dissipation_per_cycle == pytest.approx(2 * half.dissipation_per_cycle, rel=1e-9)
    np.testing.assert_allclose(
        whole.final_slip[16:], half.final_slip, rtol=0, atol=1e-9 * np.abs(half.final_slip).max()
    )
    np.testing.assert_allclose(
        whole.final_slip, -whole.final_slip[::-1], rtol=0, atol=1e-9 * np.abs(half.final_slip).max()
    )


@pytest.mark.slow
def test_fixed_load_steps_approach_the_exact_dissipation():
    """The thesis's time integration against the exact path: the error halves with the load step."""
    exact = shakedown.simulate(receding_block(2, symmetric=True), 1.0).dissipation_per_cycle
    error = []
    for steps in (10, 20, 40):
        stepped = shakedown.simulate(
            receding_block(2, symmetric=True, steps=steps, first_loading=10), 1.0, method="gauss-seidel"
        )
        error.append(abs(stepped.dissipation_per_cycle / exact - 1))
    assert error[0] > error[1] > error[2]
    assert error[2] < 0.02
