"""Motions that begin with some nodes open, through the public functions."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from shakedown import UsageError, long_term_state, simulate, upper_bound
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.units import without_loads
from shakedown.motion.evolution import evolve
from tests.partly_open import SOME, partly_open, zone_bound

# without its transient: that begins without load, where the safe slip is not admissible
RECEDING = replace(without_loads(shakedown.example("receding-block")), q_transient=None, p_transient=None)
UPPER = upper_bound(RECEDING, open_nodes="auto")


def at_a_share(seed, share):
    """Upper bound of the best zone, and a load factor between its ends."""
    upper = zone_bound(seed)
    if upper.status != "optimal":
        assert np.isnan(upper.load_factor) or upper.load_factor == np.inf
        return upper, np.nan
    assert upper.residual < 1e-9
    return upper, upper.least_load_factor + share * (upper.load_factor - upper.least_load_factor)


def with_transient(problem, load_factor, seed):
    """The same joint, brought to its loop through load steps in between those of the loop."""
    q_w, p_w = loading(problem).at(load_factor)
    weights = np.random.default_rng(seed).dirichlet(np.ones(problem.m), size=3)
    return replace(problem, q_transient=weights @ q_w, p_transient=weights @ p_w)


@pytest.mark.parametrize("transient", [False, True])
@pytest.mark.parametrize("seed", [*SOME[:3], *SOME[12:18]])
def test_below_the_bound_of_the_zone_nothing_slips(seed, transient):
    """Between the ends of its bound, started at rest in it."""
    for share in (0.5, 0.999):
        problem, (upper, load_factor) = partly_open(seed), at_a_share(seed, share)
        if upper.status != "optimal":
            return
        if transient:
            problem = with_transient(problem, load_factor, seed)
        run = evolve(problem, load_factor, upper.slip, open_nodes=upper.open_nodes, cycles=3)
        size = np.abs(upper.slip).max()
        assert run.stop is None
        assert max(cycle.slip.max() for cycle in run.cycles) < 1e-9 * size
        state = long_term_state(problem, load_factor, upper.slip, open_nodes=upper.open_nodes)
        assert state.outcome == "shakedown"
        assert state.open_nodes == upper.open_nodes


@pytest.mark.parametrize("method", ["event", "gauss-seidel"])
def test_the_receding_block_rests_in_its_zone_and_slips_above(method):
    closed = list(contact_zone(RECEDING, UPPER.open_nodes).closed_nodes)
    for share, rests in ((0.99, True), (1.02, False)):
        load_factor = share * UPPER.load_factor
        run = simulate(
            RECEDING, load_factor, UPPER.slip, open_nodes=UPPER.open_nodes, method=method, cycles=3
        )
        assert (run.cycles.slip[0][closed].max() < 1e-12) == rests
        assert not rests or (run.outcome, run.open_nodes) == ("shakedown", UPPER.open_nodes)


def test_slips_given_for_open_nodes_do_not_matter():
    other = UPPER.slip.copy()
    other[list(UPPER.open_nodes)] = 17.0
    one, two = (
        evolve(RECEDING, 0.9 * UPPER.load_factor, slip, open_nodes=UPPER.open_nodes, cycles=2)
        for slip in (UPPER.slip, other)
    )
    assert (one.initial_slip == two.initial_slip).all()
    assert (one.cycles[-1].end_slip == two.cycles[-1].end_slip).all()


def test_what_cannot_be_a_start_is_refused_in_one_line():
    with pytest.raises(UsageError, match="node 16 would overlap by"):
        evolve(RECEDING, 0.5 * UPPER.load_factor, UPPER.slip, open_nodes=[16])
