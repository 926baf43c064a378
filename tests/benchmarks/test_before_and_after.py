"""The times of two checkouts, held against each other."""

import sys

import pytest

from benchmarks import before_and_after


@pytest.mark.slow
def test_every_call_is_timed_by_the_worker():
    """A checkout beside itself; the names that have moved are found."""
    found = dict(before_and_after.measured((sys.executable, sys.executable), "lower_bound chain", 2))
    assert list(found) == ["lower_bound chain-10", "conic_lower_bound chain-5"]
    assert all(seconds > 0 for turns in found.values() for turn in turns for seconds in turn)
