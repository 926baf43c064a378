"""Chapter III in words, as numbers, on a mesh small enough for a test (``benchmarks.receding_zones``)."""

import pytest

from benchmarks import receding_zones


@pytest.fixture(scope="module")
def row():
    return receding_zones.measure({"refinement": 6})


def test_at_zero_load_all_slip_reverts_and_all_gaps_close(row):
    """Thesis fig. 3.3."""
    assert row["slip_left"] <= 1e-12
    assert row["gap_left"] <= 1e-12
    assert row["contact_grows"] == 0


def test_while_unloading_stick_begins_outside_and_two_slip_regions_remain(row):
    """Fig. 3.3: of the right half, stick, slip outwards, stick, slip inwards at the edge, open."""
    assert row["unloading_zones"] == "s+s-o"
    assert row["sticks_at_once"] > 0.7 * row["in_contact_at_p_max"]


def test_the_inner_slip_of_the_ninth_cycle_stays_stuck_during_reloading(row):
    """Fig. 3.5: so slip still accumulates; the outermost node may slip again just before p_max."""
    assert row["ninth_zones"] == "s+s-o"
    assert row["ninth_inner"] >= 5
    assert row["ninth_inner_slipping_early"] == 0
    assert row["ninth_inner_slipping_again"] <= 1


def test_in_the_steady_state_fewer_nodes_slip_and_some_only_reach_their_limit(row):
    """Fig. 3.7."""
    assert row["steady_slipping"] < 0.7 * row["first_slipping"]
    assert row["steady_at_limit"] >= 5
