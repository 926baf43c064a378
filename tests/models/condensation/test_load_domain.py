"""Loads that vary independently within limits become the corners of a load domain."""

import numpy as np
import pytest

from shakedown import LoadCase, ProblemError
from shakedown.models.condensation.load_case import LARGEST_DOMAIN, histories

ONE = [1.0]


def ranged(low, high, **more):
    return LoadCase(range=(low, high), force=ONE, **more)


def test_three_ranges_give_every_corner_once_along_the_edges():
    found = histories([ranged(-1, 2), LoadCase(history=5.0, force=ONE), ranged(0, 1), ranged(3, 4)]).period
    assert found.shape == (8, 4)
    assert {tuple(row) for row in found} == {(a, 5.0, b, c) for a in (-1, 2) for b in (0, 1) for c in (3, 4)}
    steps = np.vstack([found, found[:1]])
    assert (np.count_nonzero(np.diff(steps, axis=0), axis=1) == 1).all()


def test_the_mean_is_the_middle_of_the_domain_unless_given():
    assert histories([ranged(-1, 2), ranged(0, 1)]).period.mean(axis=0) == pytest.approx([0.5, 0.5])
    assert histories([ranged(-1, 2, mean=0.0), ranged(0, 1)]).mean == pytest.approx([0.0, 0.5])


def test_what_does_not_make_a_domain_is_refused():
    with pytest.raises(ProblemError, match="a history or a range, found neither"):
        LoadCase(force=ONE)
    with pytest.raises(ProblemError, match="a history or a range, found both"):
        LoadCase(history=1.0, range=(0, 1), force=ONE)
    for wrong in ((1, 0), (1,), (0, 1, 2)):
        with pytest.raises(ProblemError, match=r"expected \[low, high\], found"):
            LoadCase(range=wrong, force=ONE)
    with pytest.raises(ProblemError, match="found a history of 'live'"):
        histories([ranged(0, 1), LoadCase(history=[0.0, 1.0], force=ONE, name="live")])
    with pytest.raises(ProblemError, match=f"at most {LARGEST_DOMAIN} ranges"):
        histories([ranged(0, 1)] * (LARGEST_DOMAIN + 1))
