"""Press fit and line contact converge to Lamé's, Hertz's, Cattaneo's and Mindlin's solutions."""

import numpy as np
import pytest

from benchmarks.bodies.classical import hertz
from benchmarks.classical_contacts import line_contact_errors, permanent_stick, press_fit_errors


def test_the_press_fit_converges_to_lames_pressure_with_order_two():
    errors = [press_fit_errors(k)["pressure"] for k in (1, 2, 4)]
    assert errors[0] < 2e-3
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2, 2], abs=0.25)


@pytest.mark.slow
def test_the_line_contact_converges_to_hertz_and_to_cattaneo_and_mindlin():
    coarse, fine = line_contact_errors(1), line_contact_errors(4)
    assert 0.3 < fine["utilisation"] < 0.9
    assert fine["peak"] < 3e-3  # the bodies are 100 half-widths wide, not infinite
    for key, order in (("pressure", 1.3), ("shear", 1.0)):
        assert np.log2(coarse[key] / fine[key]) / 2 > order
    assert fine["contact_edge"] < 1.0
    assert fine["stick_edge"] < 1.0


def test_hertz_shear_has_the_force_it_is_given_and_no_slip_without_it():
    sheared = hertz(0.02, 0.003, 0.3)
    x = np.linspace(-1.5, 1.5, 200_001)
    assert np.trapezoid(sheared.shear(x, 0.3), x) == pytest.approx(0.003, rel=1e-5)
    assert hertz(0.02).stick == hertz(0.02).half_width


@pytest.mark.parametrize("phase", [0.25, 0.0])
def test_what_never_slips_is_the_contact_under_the_force_where_the_tangents_of_the_loop_meet(phase):
    found = permanent_stick(2, phase)
    assert 0.5 < found["half_width"] < 0.8
    assert found["apart"] < 1.0
