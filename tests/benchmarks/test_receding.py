"""Chapter III of the thesis on meshes small enough for a test; the study is ``benchmarks.receding``."""

import numpy as np
import pytest

import shakedown
from benchmarks.bodies.blocks import receding_block
from benchmarks.receding import cycles, first_loading


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
