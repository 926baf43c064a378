"""Bounds of partly open joints: what a zone promises the exact evolution keeps."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

import shakedown
from benchmarks.bodies.lap_joint import lap_joint
from shakedown import UsageError, safe_slip, upper_bound
from shakedown.bounds.best_zone import best_zone
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.loading import loading
from shakedown.motion.cycle_record import State
from shakedown.motion.integrator import Evolution
from shakedown.motion.kernels.contact_status import OPEN
from tests.partly_open import SOME, partly_open

RECEDING = shakedown.example("receding-block")


def slip_in_zone(problem, upper, load_factor, cycles=4):
    """Largest slip in contact per cycle, started at rest in the zone."""
    zone = contact_zone(problem, upper.open_nodes)
    evolution = Evolution(problem, load_factor)
    q_w, p_w = loading(problem).at(load_factor)
    u = zone.displacements(upper.slip[list(zone.closed_nodes)], q_w[-1:], p_w[-1:])[0]
    contact = np.zeros(problem.n, dtype=np.int64)
    contact[list(zone.open_nodes)] = OPEN
    evolution.done = 1
    evolution.state = State(u, contact)
    return max(float(evolution.cycle().slip.max()) for _ in range(cycles))


@pytest.mark.parametrize("seed", SOME)
def test_below_the_bound_of_the_zone_nothing_slips(seed):
    problem = partly_open(seed)
    upper = upper_bound(problem, open_nodes="auto")
    if upper.status != "optimal":
        assert np.isnan(upper.load_factor) or upper.load_factor == np.inf
        return
    assert upper.residual < 1e-9
    size = np.abs(upper.slip).max()
    least = upper.least_load_factor
    for share in (0.5, 0.999):
        assert slip_in_zone(problem, upper, least + share * (upper.load_factor - least)) < 1e-9 * size


@pytest.mark.parametrize("seed", SOME[:8])
def test_the_search_finds_the_best_of_all_zones(seed):
    problem = partly_open(seed, n=5)
    found = best_zone(problem)
    every = [
        upper_bound(problem, open_nodes=nodes)
        for count in range(problem.n)
        for nodes in combinations(range(problem.n), count)
    ]
    values = [bound.load_factor for bound in every if bound.status != "infeasible"]
    best = max(values, default=-np.inf)
    assert found.load_factor == pytest.approx(best, rel=1e-9)


def test_from_zones_without_a_safe_slip_the_search_reaches_one_that_has_it():
    """A flat bolted lap in space: its ends open under the mean load, two more nodes have to."""
    joint = lap_joint((12, 3, 1), reach=np.inf, steps=4)
    search = best_zone(joint)
    assert upper_bound(joint, open_nodes=search.opened).status == "infeasible"
    assert search.opened
    assert set(search.zone.open_nodes) > set(search.opened)
    found = upper_bound(joint, open_nodes=search.zone.open_nodes)
    assert 0 < search.load_factor == pytest.approx(found.load_factor, rel=1e-6)
    assert search.visited <= 30


def test_the_receding_block_has_a_bound():
    upper = upper_bound(RECEDING, open_nodes="auto")
    assert upper_bound(RECEDING).status == "infeasible"
    assert upper.status == "optimal"
    assert upper.open_nodes == (0, 1, 2, 3, 4, 28, 29, 30, 31, 32)
    assert slip_in_zone(RECEDING, upper, 0.999 * upper.load_factor) < 1e-12
    assert slip_in_zone(RECEDING, upper, 1.02 * upper.load_factor) > 1e-9


def test_with_all_nodes_closed_nothing_changes():
    for name in ("two-node", "block-9"):
        problem = shakedown.example(name)
        plain, searched = upper_bound(problem), upper_bound(problem, open_nodes="auto")
        assert searched.open_nodes == plain.open_nodes == ()
        assert searched.load_factor == plain.load_factor
        assert searched.certified == plain.certified


def test_the_safe_slip_of_a_zone_has_room_at_every_row():
    upper = upper_bound(RECEDING, open_nodes="auto")
    safe = safe_slip(RECEDING, 0.5 * upper.load_factor, open_nodes=upper.open_nodes)
    assert safe.open_nodes == upper.open_nodes
    assert safe.margin > 0
    zone = contact_zone(RECEDING, upper.open_nodes)
    inside = safe.slip[list(zone.closed_nodes)]
    assert (zone.constraints.excess(inside, 0.5 * upper.load_factor) < 0).all()


def test_a_wrong_zone_is_reported_not_believed():
    assert upper_bound(RECEDING, open_nodes=[16]).status == "infeasible"
    with pytest.raises(UsageError, match="from 0 to 32, found 33"):
        upper_bound(RECEDING, open_nodes=[33])
    with pytest.raises(UsageError, match="whole numbers or 'auto', found 'all'"):
        upper_bound(RECEDING, open_nodes="all")
    with pytest.raises(UsageError, match="found all 33 open"):
        upper_bound(RECEDING, open_nodes=range(33))
    with pytest.raises(shakedown.ProblemError, match="key 'C'"):
        upper_bound(replace(RECEDING, C=None), open_nodes=[0])


@pytest.mark.parametrize("power", [-60, 30])
def test_units_do_not_matter(power):
    factor = 2.0**power
    parts = {key: factor * getattr(RECEDING, key) for key in ("A", "B", "C", "q_w", "p_w")}
    parts |= {key: factor * getattr(RECEDING, key) for key in ("q_transient", "p_transient")}
    here, there = (upper_bound(one, open_nodes="auto") for one in (RECEDING, replace(RECEDING, **parts)))
    assert there.open_nodes == here.open_nodes
    assert there.load_factor == pytest.approx(here.load_factor, rel=1e-9)


@pytest.mark.parametrize("unit", [1.0, 1e6])
def test_a_closed_node_that_moves_with_open_ones_alone_is_pinned(unit):
    """A part held by friction alone, of which one node stays closed: its stiffness is round-off."""
    generator, open_nodes, free, held = np.random.default_rng(3), [0, 2], [0, 2, 3, 5], [1, 4]
    for _ in range(10):
        factor = generator.normal(size=(7, 6))
        factor[:, :2] -= factor[:, :2].mean(axis=1, keepdims=True)  # the motion (1, 1, 0 | 0, 0, 0)
        kappa = unit * factor.T @ factor
        flexibility = np.linalg.inv(kappa[np.ix_(free, free)])
        swing = generator.uniform(-0.5, 0.5, (4, 6))
        load = swing - swing.mean(axis=0)
        load[:, free] -= kappa[np.ix_(free, free)] @ [0.0, 0.0, 1e3 / unit, 1e3 / unit]  # the mean gaps
        left = kappa[np.ix_(held, free)] @ flexibility
        load[:, held] += load[:, free].mean(axis=0) @ left.T + [0.0, 10.0]
        joint = shakedown.Problem(
            A=kappa[:3, :3],
            B=kappa[3:, :3],
            C=kappa[3:, 3:],
            f=0.5,
            q_w=load[:, :3],
            p_w=load[:, 3:],
        )
        q, p = (load[:, held] - load[:, free] @ left.T - [0.0, 10.0]).T
        exact = 5.0 / np.maximum(q - 0.5 * p, -q - 0.5 * p).max()  # Coulomb's law of one node, no slip in it
        found = upper_bound(joint, open_nodes=open_nodes)
        assert found.pinned == (1,)
        assert found.load_factor == pytest.approx(exact, rel=1e-8)
        assert shakedown.energy_bound(joint, open_nodes=open_nodes).load_factor == pytest.approx(
            exact, rel=1e-8
        )
