"""Uniqueness and friction thresholds against cited values, principal minors one by one, witnesses, and hard searches."""

from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pytest

import shakedown
from benchmarks.problems import chain, joint
from shakedown import Problem
from shakedown.bounds import coupling as uniqueness
from shakedown.bounds import friction_thresholds
from shakedown.bounds.coupling import coupling, first_loss, scaled_stiffness, unique_in_contact
from shakedown.bounds.friction_thresholds import PROGRAMS, friction_used, wedged_slip
from shakedown.ground.constants import SIX_DIGITS


def scaled(problem):
    return scaled_stiffness(problem, np.ones(problem.n), shakedown.Tolerances())


def lost_by(problem, slipping, separated=()):
    """Friction and sides at which one moving set loses uniqueness."""
    stiffness = scaled(problem)
    rest = [i for i in range(problem.n) if i not in separated]
    lost = first_loss(stiffness.opened(separated), [tuple(rest.index(i) for i in slipping)])
    return lost.factor / stiffness.friction_unit, lost.sides


def test_cited_thresholds_of_the_jump():
    problem = shakedown.example("jump")
    limits = shakedown.friction_thresholds(problem)
    assert limits.single_node == pytest.approx([4.2295, 1.1238], abs=5e-5)
    assert limits.uniqueness_in_contact.value == pytest.approx(0.35568, abs=5e-6)
    assert limits.uniqueness.value == limits.uniqueness_in_contact.value
    assert lost_by(problem, (1,), (0,))[0] == pytest.approx(0.36929, abs=5e-6)


def unloaded(A, B, C=None, f=0.3):
    """A joint whose loads do not matter."""
    n = len(A)
    return Problem(A=A, B=B, C=C, f=f, q_w=np.zeros((1, n)), p_w=np.ones((1, n)))


def random_stiffness(rng, n, normal=1.0):
    """A joint in which a unit of the gap is so many of the slip."""
    G = rng.normal(size=(2 * n, 2 * n)) * np.repeat([1.0, normal], n)[:, None]
    kappa = G @ G.T / (2 * n) + 0.3 * np.diag(np.repeat([1.0, normal**2], n))
    return unloaded(kappa[:n, :n], kappa[n:, :n], kappa[n:, n:])


def all_minors_positive(problem, f, separated=()):
    """Principal minors of A' + f S B' over all S, the separated nodes eliminated from κ; those of 1e-9 are none."""
    A, B, rest = problem.A, problem.B, [i for i in range(problem.n) if i not in separated]
    if separated:
        keep, free = ([*nodes, *(problem.n + i for i in nodes)] for nodes in (rest, separated))
        kappa = problem.kappa
        moved = np.linalg.solve(kappa[np.ix_(free, free)], kappa[np.ix_(free, keep)])
        left = kappa[np.ix_(keep, keep)] - kappa[np.ix_(keep, free)] @ moved
        A, B = left[: len(rest), : len(rest)], left[len(rest) :, : len(rest)]
    matrices = [A + np.array(s)[:, None] * (f * B.T).T for s in product((1, -1), repeat=len(A))]
    chosen = [J for k in range(1, len(A) + 1) for J in combinations(range(len(A)), k)]
    return all(np.linalg.det(M[np.ix_(J, J)]) > 1e-9 for M in matrices for J in chosen)


def test_a_set_whose_stiffness_counts_as_singular_says_nothing():
    """det(A + S f B) = 1 − (c − 0.4 f)²; eigenvalues 1 ± c of A: (1 − c) / (1 + c) is a tenth at c = 0.818."""
    B, rough = [[0.0, 0.4], [-0.4, 0.0]], shakedown.Tolerances(zero_mode=0.1)
    for c, expected in ((0.815, 0.4625), (0.821, np.inf)):
        found = shakedown.friction_thresholds(unloaded([[1.0, c], [c, 1.0]], B), tolerances=rough)
        assert found.uniqueness_in_contact.value == pytest.approx(expected)


@pytest.mark.parametrize("seed", range(3))
def test_uniqueness_is_the_first_principal_minor_to_vanish(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    problem = random_stiffness(rng, n)
    limits = shakedown.friction_thresholds(problem)
    f = limits.uniqueness_in_contact.value
    assert all_minors_positive(problem, 0.9999 * f)
    assert not all_minors_positive(problem, 1.0001 * f)
    f = limits.uniqueness.value
    sets = [o for k in range(n) for o in combinations(range(n), k)]
    assert all(all_minors_positive(problem, 0.9999 * f, o) for o in sets)
    assert not all(all_minors_positive(problem, 1.0001 * f, o) for o in sets)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_said_of_many_nodes_encloses_what_all_sets_say(monkeypatch, seed):
    rng, found = np.random.default_rng(100 + seed), []
    problem = replace(random_stiffness(rng, 4, normal=1e16), f=rng.uniform(0.1, 1.0, 4))
    for most in (3, 4):
        monkeypatch.setattr(friction_thresholds, "ALL_SUBSETS_UP_TO", most)
        monkeypatch.setattr(friction_thresholds, "LARGEST_SET", most)
        found.append(shakedown.friction_thresholds(problem))
    few, whole = found
    for name in ("uniqueness_in_contact", "uniqueness"):
        interval, exact = getattr(few, name), getattr(whole, name).value
        assert 0.0 < interval.low <= exact <= interval.high * (1 + 1e-12)


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
    limits, halved, alike = (
        shakedown.friction_thresholds(replace(problem, f=f))
        for f in ([0.35, 0.7], [0.175, 0.35], [0.3, 3 * 0.1])
    )
    assert limits.factor
    assert not alike.factor
    assert [*limits.single_node, *alike.single_node] == pytest.approx([0.7608, 2.0225] * 2, abs=5e-5)
    value, side = lost_by(problem, (0,), (1,))
    assert (round(value, 4), side) == (0.6380, (1,))
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
    assert np.abs(v).max() == 1.0
    unit = stiffness.friction_unit
    assert friction_used(stiffness, v) <= f * unit * (1 + 1e-9)
    assert wedged_slip(stiffness, 0.999 * f * unit, np.ones(problem.n), np.eye(problem.n))[1] > 1e-9
    assert wedged.low >= f * (1 - 1e-8)


@pytest.mark.parametrize("name", ["uncoupled", "receding-block"])
def test_neither_without_coupling_nor_by_a_rigid_motion_a_joint_wedges(name):
    assert shakedown.friction_thresholds(shakedown.example(name)).wedging.value == np.inf


def sparse_joint(seed: int) -> Problem:
    """Whole numbers and empty rows: witnesses with idle nodes, where what is to spare vanishes."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 9))
    if seed % 3 == 0:
        off = np.triu(rng.integers(-1, 2, (n, n)) * (n < 5), 1)
        A, B = off + off.T + 4.0 * np.eye(n), rng.integers(-1, 2, (n, n)).astype(float)
    elif seed % 3 == 1:
        A = np.diag(1.0 + rng.integers(0, 3, n))
        B = rng.normal(size=(n, n)) * (rng.random((n, n)) < 0.3)
    else:  # κ singular
        root = rng.integers(-2, 3, (2 * n, max(1, n - 1))).astype(float)
        kappa = root @ root.T
        A, B = kappa[:n, :n], kappa[n:, :n]
    return unloaded(A, B)


def test_the_smallest_hard_case_ends_at_once() -> None:
    """Only v = (1, 0) is wedged at f = 4, and node 1 is idle there."""
    hard = unloaded(4 * np.eye(2), [[1.0, -1.0], [0.0, 1.0]], 4 * np.eye(2))
    wedged = shakedown.friction_thresholds(hard).wedging
    assert wedged.value == pytest.approx(4.0, rel=1e-8)
    assert wedged.programs <= PROGRAMS
    one = shakedown.friction_thresholds(unloaded([[2.0]], [[1.0]])).wedging
    assert (one.value, one.programs) == (2.0, 1)  # there is one slip to be tried


def test_sparse_and_integer_joints_end_with_a_bracket() -> None:
    known = 0
    for seed in range(12):
        problem = sparse_joint(seed)
        limits = shakedown.friction_thresholds(problem)
        wedged = limits.wedging
        assert wedged.programs <= PROGRAMS
        assert wedged.low <= wedged.high
        assert bool(wedged.reason) == np.isnan(wedged.value)
        known += not wedged.reason
        if np.isfinite(wedged.high):
            v = wedged.slip
            terms = np.abs(problem.A) @ np.abs(v) + wedged.high * np.abs(problem.B) @ np.abs(v)
            excess = np.abs(problem.A @ v) - wedged.high * (problem.B @ v)
            assert np.all(excess <= 1e-9 * terms)
            assert np.any(problem.B @ v > 0)
            if not wedged.reason:
                assert wedged.low >= wedged.high * (1 - SIX_DIGITS)
    assert known >= 10  # of 12


def test_a_node_whose_pressure_no_slip_changes_bears_none() -> None:
    """(A v)_2 = 0 leaves a plane of slips, which is scanned; as an inequality of a program it hid the threshold."""
    A = np.array([[0.959, -0.1595, -0.105], [-0.1595, 0.957, -0.0775], [-0.105, -0.0775, 0.926]])
    B = np.array([[-0.362, 0.032, 0.009], [0.054, -0.305, 0.032], [0.0, 0.0, 0.0]])
    plane = np.linalg.svd(A[2:])[2][1:]
    angles = np.linspace(0.0, 2 * np.pi, 200_001)
    q, p = (matrix[:2] @ plane.T @ [np.cos(angles), np.sin(angles)] for matrix in (A, B))
    needed = np.max(np.abs(q) / np.where(p > 0, p, np.nan), axis=0)
    wedged = shakedown.friction_thresholds(unloaded(A, B)).wedging
    assert wedged.value == pytest.approx(np.nanmin(needed), rel=1e-4)
    assert not wedged.reason


def test_many_nodes_are_not_searched_and_say_so() -> None:
    limits = shakedown.friction_thresholds(joint(0, 101, coupling=0.1))
    wedged = limits.wedging
    assert (wedged.low, wedged.high, wedged.programs) == (limits.uniqueness_in_contact.low, np.inf, 0)
    assert np.isnan(wedged.value)
    assert "100 nodes" in wedged.reason


def test_coupling_of_the_size_of_round_off_is_none() -> None:
    """A condensation leaves 1e-16 where symmetry has 0."""
    joint = unloaded(2 * np.eye(2) + 0.5, [[1e-16, -3e-16], [0.0, 2e-16]], np.eye(2))
    limits = shakedown.friction_thresholds(joint)
    assert (limits.uniqueness.value, limits.uniqueness.separated) == (np.inf, ())
    assert np.all(np.isinf(limits.single_node))
    assert np.isinf(limits.uniqueness_in_contact.value)
    assert np.isinf(limits.wedging.value)


def integer_joint(seed: int) -> Problem:
    """Small whole numbers: thresholds that are hit exactly, minors that vanish exactly."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    off = np.triu(rng.integers(-1, 2, (n, n)), 1)
    A = off + off.T + 4.0 * np.eye(n)
    B = rng.integers(-1, 2, (n, n)) * (rng.random((n, n)) < 0.6)
    return unloaded(A, B, f=rng.choice([0.25, 0.5, 1.0, 2.0, 4.0]))


@pytest.mark.parametrize("block", range(2))
def test_the_answer_is_that_of_exact_principal_minors(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(uniqueness, "LARGEST_SET", 4)  # all sets of so many nodes are tried
    for seed in range(40 * block, 40 * block + 40):
        problem = integer_joint(seed)
        answer = unique_in_contact(problem)
        assert answer.unique is all_minors_positive(problem, problem.f), (seed, answer)
        assert bool(answer) is answer.unique


@pytest.mark.parametrize("n", [9, 40, 250])
def test_many_nodes_by_a_cheap_proof(n: int) -> None:
    weak = replace(chain(n), f=0.05)
    assert unique_in_contact(weak).unique is True
    strong = replace(weak, f=1e3)
    assert unique_in_contact(strong).unique is not True


@pytest.mark.parametrize("seed", range(2))
def test_energy_proves_what_dominance_cannot(seed: int) -> None:
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(60, 60))
    kappa = root @ root.T / 60 + 0.3 * np.eye(60)
    dense = unloaded(kappa[:30, :30], kappa[30:, :30], f=0.1)
    assert coupling(dense).ratio > 1
    assert unique_in_contact(dense).argument == "every motion stores more energy than friction can feed it"


def test_friction_at_the_threshold_counts_as_above() -> None:
    problem, rough = unloaded([[2.0]], [[1.0]], f=2.0), shakedown.Tolerances(feasibility=0.2)
    assert unique_in_contact(problem).unique is False
    assert unique_in_contact(replace(problem, f=2.0 * (1 - 1e-8))).unique is True
    assert unique_in_contact(problem, tolerances=rough).unique is False
    assert unique_in_contact(replace(problem, f=1.8), tolerances=rough).unique is False


def test_a_double_root_ends_uniqueness() -> None:
    """det(A + t S B) = (1 − t/2)² touches zero: a defective double eigenvalue, parted by round-off."""
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s], [s, c]])
    B = turn @ np.array([[-0.5, 1.0], [0.0, -0.5]]) @ turn.T
    stiffness = scaled(unloaded(np.eye(2), B, f=1.0))
    same = first_loss(stiffness, [(0, 1)])
    assert same.factor / stiffness.friction_unit <= 2.0 * (1 + 1e-6)
