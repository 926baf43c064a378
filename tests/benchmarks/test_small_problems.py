"""The files of built-in problems hold what their definitions say."""

import pytest

import shakedown
from benchmarks.bodies.small_problems import small_problems

DEFINED = small_problems()


@pytest.mark.parametrize("name", DEFINED)
def test_a_built_in_problem_is_as_it_is_defined(name):
    assert shakedown.example(name) == DEFINED[name]
