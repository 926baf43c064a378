"""The limits below which no node collapses, from one multiplier per node."""

import numpy as np
import pytest

import shakedown
from benchmarks.problems import chain, joint
from shakedown.bounds.certificate import load_factor_program
from shakedown.bounds.collapse.lower import collapse_limits, collapse_values, collapses
from shakedown.joint.constraints import constraints
from shakedown.programs.simplex import Simplex


def every_program(problem):
    """λ of every node, each program solved by the simplex from where the last one ended."""
    rows = constraints(problem)
    nothing = collapse_limits(rows)
    unknown = type(nothing)(np.zeros(rows.n), nothing.rows, np.zeros(rows.n, dtype=bool))
    program = Simplex(load_factor_program(rows, towards=+1.0))
    return collapse_values(rows.n, collapses(rows, program, unknown, all_nodes=True))


JOINTS = {
    f"{n}-{coupling}": joint(n=n, coupling=coupling, seed=n)
    for n in (1, 2, 5, 14)
    for coupling in (0.1, 0.5, 1.5)
}
JOINTS |= {
    "chain": chain(20),
    "three-node": shakedown.example("three-node"),
    "two-node": shakedown.example("two-node"),
}


@pytest.mark.parametrize("name", JOINTS)
def test_no_node_collapses_below_its_limit_and_the_first_at_it(name):
    problem = JOINTS[name]
    values, limits = every_program(problem), collapse_limits(constraints(problem))
    assert np.all(limits.load_factors <= values * (1 + 1e-9))
    first = int(np.argmin(values))
    if limits.known[first] and np.isfinite(values[first]):
        assert limits.load_factors[first] == pytest.approx(values[first], rel=1e-9)
    lower = shakedown.lower_bound(problem)
    assert lower.load_factor == pytest.approx(values.min(), rel=1e-9)
    np.testing.assert_allclose(lower.per_node, values, rtol=1e-8)
