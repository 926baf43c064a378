"""Friction thresholds against cited values, complete enumeration and states that really lose uniqueness."""

from itertools import combinations, product

import numpy as np
import pytest

import shakedown
from shakedown.bounds.coupling import (
    coupling_limit,
    energy_limit,
    first_loss,
    scaled_stiffness,
    slipping_sets,
)
from shakedown.bounds.friction_thresholds import first_with_open_nodes, friction_used, wedged_slip


def scaled(problem):
    return scaled_stiffness(problem, np.ones(problem.n), shakedown.Tolerances())


def lost_by(problem, slipping, separated=()):
    """Friction and sides at which one moving set loses uniqueness."""
    stiffness = scaled(problem)
    rest = [i for i in range(problem.n) if i not in separated]
    lost = first_loss(stiffness.opened(separated), [tuple(rest.index(i) for i in slipping)])
    return lost.factor / stiffness.friction_unit, lost.sides


def test_cited_thresholds_of_the_two_node_system():
    limits = shakedown.friction_thresholds(shakedown.example("two-node"))
    assert limits.single_node == pytest.approx([0.7608, 2.0225], abs=5e-5)
    value, side = lost_by(shakedown.example("two-node"), (0,), (1,))
    assert (round(value, 4), side) == (0.6380, (1,))


def test_cited_thresholds_of_the_jump():
    problem = shakedown.example("jump")
    limits = shakedown.friction_thresholds(problem)
    assert limits.single_node == pytest.approx([4.2295, 1.1238], abs=5e-5)
    assert limits.uniqueness_in_contact.value == pytest.approx(0.35568, abs=5e-6)
    assert limits.uniqueness.value == limits.uniqueness_in_contact.value
    assert lost_by(problem, (1,), (0,))[0] == pytest.approx(0.36929, abs=5e-6)
    roots = []
    for signs in product((1, -1), repeat=2):
        for f in np.roots(determinant_in_f(problem, signs)):
            roots.append(abs(f))
    expected = np.repeat([0.35568, 0.40779, 4.30101, 4.93118], 2)
    assert np.sort(roots) == pytest.approx(expected, abs=2e-5)


def determinant_in_f(problem, signs):
    """Coefficients of det[A + S f B], thesis (4.23), by three evaluations."""

    def det(f):
        return np.linalg.det(problem.A + f * np.array(signs)[:, None] * problem.B)

    return np.polyfit([-1.0, 0.0, 1.0], [det(-1.0), det(0.0), det(1.0)], 2)


def random_stiffness(rng, n):
    G = rng.normal(size=(2 * n, 2 * n))
    kappa = G @ G.T / (2 * n) + 0.3 * np.eye(2 * n)
    return shakedown.Problem(
        A=kappa[:n, :n], B=kappa[n:, :n], C=kappa[n:, n:], f=0.3, q_w=np.zeros((1, n)), p_w=np.ones((1, n))
    )


def all_minors_positive(problem, f, separated):
    """Principal minors of A' + f S B' over all S, the separated nodes eliminated from κ."""
    n, kappa = problem.n, problem.kappa
    free = [*separated, *(n + i for i in separated)]
    rest = [i for i in range(n) if i not in separated]
    keep = [*rest, *(n + i for i in rest)]
    S = kappa[np.ix_(keep, keep)]
    if free:
        S = (
            S
            - kappa[np.ix_(keep, free)] @ np.linalg.inv(kappa[np.ix_(free, free)]) @ kappa[np.ix_(free, keep)]
        )
    r = len(rest)
    for signs in product((1, -1), repeat=r):
        M = S[:r, :r] + f * np.array(signs)[:, None] * S[r:, :r]
        for k in range(1, r + 1):
            for J in combinations(range(r), k):
                if np.linalg.det(M[np.ix_(J, J)]) <= 0:
                    return False
    return True


@pytest.mark.parametrize("seed", range(3))
def test_uniqueness_is_the_first_principal_minor_to_vanish(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    problem = random_stiffness(rng, n)
    limits = shakedown.friction_thresholds(problem)
    f = limits.uniqueness_in_contact.value
    assert all_minors_positive(problem, 0.9999 * f, ())
    assert not all_minors_positive(problem, 1.0001 * f, ())
    f = limits.uniqueness.value
    sets = [o for k in range(n) for o in combinations(range(n), k)]
    assert all(all_minors_positive(problem, 0.9999 * f, o) for o in sets)
    assert not all(all_minors_positive(problem, 1.0001 * f, o) for o in sets)


@pytest.mark.parametrize("seed", range(6))
def test_intervals_enclose_the_exact_threshold(seed):
    rng = np.random.default_rng(100 + seed)
    problem = random_stiffness(rng, 4)
    stiffness = scaled(problem)
    contact = first_loss(stiffness, slipping_sets(4)).factor
    everywhere = first_with_open_nodes(stiffness).factor
    assert coupling_limit(stiffness) <= contact
    assert energy_limit(stiffness, separation=False) <= contact
    assert 0 < energy_limit(stiffness, separation=True) <= everywhere
    few = first_loss(stiffness, slipping_sets(4, 2)).factor
    assert few >= max(contact, everywhere) * (1 - 1e-12)


def test_block_gets_an_interval():
    limits = shakedown.friction_thresholds(shakedown.example("block-9"))
    interval = limits.uniqueness_in_contact
    assert 0 < interval.low < interval.high < np.inf
    assert np.isnan(interval.value)
    value, sides = lost_by(shakedown.example("block-9"), interval.slipping)
    assert (value, sides) == (interval.high, interval.sides)
    assert limits.uniqueness.high <= interval.high
    assert limits.uniqueness.low <= interval.low


def test_individual_coefficients_give_a_common_factor():
    problem = shakedown.example("two-node")
    values = {key: getattr(problem, key) for key in ("A", "B", "C", "q_w", "p_w")}
    limits = shakedown.friction_thresholds(shakedown.Problem(f=[0.35, 0.7], **values))
    halved = shakedown.friction_thresholds(shakedown.Problem(f=[0.175, 0.35], **values))
    assert limits.factor
    assert limits.single_node == pytest.approx([0.7608, 2.0225], abs=5e-5)
    assert halved.uniqueness.value == pytest.approx(2 * limits.uniqueness.value)
    assert halved.wedging.value == pytest.approx(2 * limits.wedging.value)


@pytest.mark.parametrize("seed", range(4))
def test_wedging_witness_is_a_wedged_state_and_none_exists_below(seed):
    rng = np.random.default_rng(seed)
    problem = random_stiffness(rng, int(rng.integers(1, 6)))
    stiffness = scaled(problem)
    wedged = shakedown.friction_thresholds(problem).wedging
    v, f = wedged.slip, wedged.high
    assert np.all(np.abs(problem.A @ v) <= f * (problem.B @ v) + 1e-9)
    assert np.any(v != 0)
    unit = stiffness.friction_unit
    assert friction_used(stiffness, v) <= f * unit * (1 + 1e-9)
    assert wedged_slip(stiffness, 0.999 * f * unit, np.ones(problem.n), np.eye(problem.n))[1] > 1e-9
    assert wedged.low >= f * (1 - 1e-8)


def test_no_wedging_without_coupling():
    assert shakedown.friction_thresholds(shakedown.example("uncoupled")).wedging.value == np.inf


def test_a_rigid_motion_is_no_wedging():
    assert np.isinf(shakedown.friction_thresholds(shakedown.example("receding-block")).wedging.low)
