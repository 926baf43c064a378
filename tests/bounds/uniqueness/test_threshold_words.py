"""What is said about friction and critical load factors: one of a thing, and what was not looked for."""

from dataclasses import replace

import numpy as np

import shakedown
from benchmarks.problems import joint
from shakedown.report.friction_words import critical_in_words, friction_in_words


def test_one_subset_is_not_many() -> None:
    problem = shakedown.example("one-node")
    critical, bounds = shakedown.critical_load_factors(problem), shakedown.shakedown_bounds(problem)
    said = critical_in_words(critical, critical.total, bounds)[0]
    assert said.startswith("1 subset of n + 1 constraints: 1 critical load factor.")


def test_wedging_that_was_not_looked_for_is_said_where_it_matters() -> None:
    problem = joint(0, 101, coupling=0.1)
    limits = shakedown.friction_thresholds(problem)
    weak = replace(problem, f=0.1 * problem.f)
    assert not any(
        "hold the joint" in line for line in friction_in_words(weak, replace(limits, factor=False))
    )
    high = replace(limits, factor=False)
    said = friction_in_words(replace(problem, f=float(np.ceil(limits.wedging.low + 1))), high)
    assert "It is open whether locked-in slip can hold the joint without any load (a wedged state" in said[-1]
