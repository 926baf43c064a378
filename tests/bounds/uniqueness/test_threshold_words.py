"""What is said about friction and critical load factors: one of a thing, and what was not looked for."""

from dataclasses import replace

import numpy as np
from joints import free_pair

import shakedown
from benchmarks.problems import joint
from shakedown.report.limit_facts import friction_facts
from shakedown.report.study_facts import critical_facts


def test_one_subset_is_singular() -> None:
    problem = shakedown.example("one-node")
    critical, lower = shakedown.critical_load_factors(problem), shakedown.lower_bound(problem)
    facts, said = critical_facts(critical, lower)
    assert (facts[0].value, facts[0].note) == ("1", "1 with a critical load factor, 0 degenerate")
    assert said == []


def test_a_free_body_is_told_why_no_subset_is_regular() -> None:
    free = free_pair([-2.0, 2.0], C=np.eye(2))
    found, lower = shakedown.critical_load_factors(free), shakedown.lower_bound(free)
    (why,) = critical_facts(found, lower)[1]
    assert "no subset meets in a point" in why


def test_wedging_that_was_not_looked_for_is_open_where_it_matters() -> None:
    problem = joint(0, 101, coupling=0.1)
    limits = shakedown.assess(problem).details
    thresholds = replace(shakedown.friction_thresholds(problem), factor=False)
    for friction, state in (
        (0.1 * problem.f, "yes"),
        (float(np.ceil(thresholds.wedging.low + 1)), "not decided"),
    ):
        own = replace(limits, problem=replace(problem, f=friction))
        vars(own)["friction"] = thresholds
        assert friction_facts(own)[-1].value == state
