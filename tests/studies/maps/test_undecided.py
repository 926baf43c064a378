"""Where states are undecided nothing is said of all of them."""

import pytest
from joints import sliding

import shakedown


@pytest.mark.parametrize(
    ("problem", "load_factor", "cycles"), [(sliding(), 1.0, 1000), (shakedown.example("two-node"), 0.7, 1)]
)
def test_undecided_states_leave_it_open_what_all_states_end_in(problem, load_factor, cycles):
    found = shakedown.initial_state_map(problem, load_factor, states=16, max_cycles=cycles)
    assert found.undecided
    assert found.same_outcome is not True
    assert found.unique is not True
