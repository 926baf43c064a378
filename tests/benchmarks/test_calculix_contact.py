"""CalculiX with contact and friction of its own comes to what the toolkit says of the same joints."""

import numpy as np
import pytest

from benchmarks import calculix_peer
from benchmarks.calculix_contact import COMPARED, measure, ranges, verdict

needs_calculix = pytest.mark.needs(calculix_peer)


@needs_calculix
def test_slips_and_pressures_after_one_cycle_are_those_of_the_toolkit_as_the_penalty_grows() -> None:
    case = {"joint": "double lap", "relative": COMPARED["double lap"], "cycles": 1}
    soft, stiff = (measure(case | {"slope": slope}) for slope in (25, 250))
    for key, largest in (("slip_apart", 2e-3), ("pressure_apart", 5e-4)):
        assert stiff[key] < largest
        assert stiff[key] < soft[key] / 5  # in proportion to 1 / penalty
    assert np.count_nonzero(stiff["slip"][1]) >= 10  # of 26 nodes


@needs_calculix
@pytest.mark.parametrize(("relative", "said"), [(0.99, "no slip"), (1.01, "slips in every cycle")])
def test_calculix_comes_to_rest_below_the_transient_limit_only(relative: float, said: str) -> None:
    assert verdict(measure({"joint": "shrink fit", "relative": relative, "slope": 2500, "cycles": 2})) == said


def test_a_range_is_that_of_one_cycle() -> None:
    slip = np.array([[0.0], [3.0], [1.0], [1.0], [2.0], [2.0], [2.0], [2.0], [2.0]])
    assert ranges(slip).tolist() == [[3.0], [0.0]]
