"""The files of built-in problems hold what their definitions say."""

from dataclasses import fields

import numpy as np
import pytest

import shakedown
from benchmarks.bodies.small_problems import small_problems

DEFINED = small_problems()


@pytest.mark.parametrize("name", DEFINED)
def test_a_built_in_problem_is_as_it_is_defined(name):
    """To the round-off of the processor that wrote the file."""
    stored, defined = shakedown.example(name), DEFINED[name]
    for field in fields(defined):
        one, other = getattr(stored, field.name), getattr(defined, field.name)
        if isinstance(other, np.ndarray) and other.dtype == float:
            np.testing.assert_allclose(one, other, rtol=1e-13, atol=1e-13 * np.abs(other).max(initial=0.0))
        else:
            assert np.all(one == other)
