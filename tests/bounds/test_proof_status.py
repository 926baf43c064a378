"""Status of the guarantee: coupling ratio, gauge of differences, lift-off, and an attack on what is called proved."""

from dataclasses import replace
from fractions import Fraction
from itertools import combinations, product

import numpy as np
import pytest
from difficult_joints import floating_joint

import shakedown
from benchmarks.problems import in_units
from shakedown import Problem
from shakedown.bounds.coupling import (
    coupling,
    difference_gauge,
    relaxed,
    row_coupling_ratio,
    unique_in_contact,
)
from shakedown.bounds.proof_status import GuaranteeEvidence, guarantee_status, lift_off_bound


def coupled_joint(seed: int, n: int, strength: float) -> Problem:
    """Impulses on single nodes in shuffled order, coupling of a given strength."""
    rng = np.random.default_rng(seed)
    off = rng.normal(size=(n, n))
    A = np.eye(n) + strength * (off + off.T) / (4 * n)
    B = strength * rng.normal(size=(n, n)) / n
    order = rng.permutation(np.repeat(np.arange(n), 2))
    q = np.zeros((2 * n, n))
    q[np.arange(2 * n), order] = rng.choice([-1, 1], 2 * n) * rng.uniform(0.3, 2, 2 * n)
    p0 = rng.uniform(3, 6, n)
    q0 = rng.uniform(-0.4, 0.4, n) * p0
    return Problem(A=A, B=B, f=0.5, q_w=q0 + q, p_w=np.tile(p0, (2 * n, 1)), q_mean=q0, p_mean=p0)


def test_above_the_friction_thresholds_and_below_load_factor_zero_nothing_is_proved() -> None:
    problem = replace(shakedown.example("two-node"), f=0.9)
    assert not unique_in_contact(problem)
    assert guarantee_status(GuaranteeEvidence(problem, 0.5)).guarantee == "evidence"
    assert np.isnan(coupling(problem).ratio)
    status = guarantee_status(GuaranteeEvidence(shakedown.example("two-node"), 0.0))
    assert (status.guarantee, status.reason) == ("evidence", "there is no load factor below it")


@pytest.mark.parametrize("seed", range(4))
def test_no_cyclic_slip_below_a_proved_bound(seed: int) -> None:
    n = 2 + seed % 4
    problem = coupled_joint(seed, n, strength=0.6 if n == 2 else 0.3)
    lower, rng = shakedown.lower_bound(problem), np.random.default_rng(seed)
    assert lower.guarantee == "proved", lower.reason
    starts = np.vstack([lower.slip, lower.slip + 3 * rng.normal(size=(20, n))])
    found = shakedown.long_term_states(problem, 0.99 * lower.load_factor, starts)
    assert not {"cyclic-slip", "ratchetting"} & set(found.outcome)
    assert found.outcome[0] == "shakedown"


@pytest.mark.parametrize("strength", [0.2, 0.5, 1.5])
@pytest.mark.parametrize("seed", range(4))
def test_coupling_ratio_is_the_largest_spectral_radius_of_any_choice_of_sides(
    seed: int, strength: float
) -> None:
    problem = coupled_joint(seed, 4, strength)
    found, N = coupling(problem), np.abs(relaxed(problem.A, problem.law.limit_rows(problem.B)))
    choices = (N[list(sides), range(4)] for sides in product((0, 1), repeat=4))
    largest = max(np.abs(np.linalg.eigvals(chosen)).max() for chosen in choices)
    assert found.ratio == pytest.approx(largest, rel=1e-10)
    assert largest * (1 - 1e-13) <= found.bound <= found.ratio * (1 + 1e-10)


@pytest.mark.parametrize("seed", range(4))
def test_bound_of_the_coupling_ratio_holds_in_exact_arithmetic(seed: int) -> None:
    """Also where the two terms of an entry cancel, and where a node acts on no other."""
    rng, n = np.random.default_rng(seed), 4
    off = rng.normal(size=(n, n)) / 4
    A, fB = np.eye(n) + off + off.T, (off + off.T) * (1 + 1e-15 * rng.normal(size=(n, n)))
    np.fill_diagonal(fB, 0.1)
    if seed % 2:
        A[0, 1:] = A[1:, 0] = fB[0, 1:] = 0.0
    found = row_coupling_ratio(A, fB)
    d = [Fraction(x) for x in found.weights.tolist()]
    for i, sign in product(range(n), (-1, 1)):
        row = [Fraction(a) + sign * Fraction(b) for a, b in zip(A[i].tolist(), fB[i].tolist(), strict=True)]
        moved = sum(abs(row[j]) * d[j] for j in range(n) if j != i)
        assert d[i] > 0
        assert moved <= Fraction(found.bound) * row[i] * d[i]


@pytest.mark.parametrize(
    ("name", "f", "expected"),
    [("block-9", 0.1, 0.660328), ("block-33", 0.2, 0.506731), ("press-fit", None, 0.346802)],
)
def test_first_collapse_of_finite_element_joints_is_proved(name: str, f: float | None, expected: float):
    problem = shakedown.example(name)
    lower = shakedown.lower_bound(problem if f is None else replace(problem, f=f))
    assert lower.load_factor == pytest.approx(expected, abs=6e-7)
    assert lower.guarantee == "proved", lower.reason
    assert lower.coupling_ratio < 1


@pytest.mark.parametrize("seed", [2, 5, 7])
def test_load_steps_of_round_off_do_not_hide_lift_off(seed) -> None:
    joint, (q, p), found = coupled_joint(seed, 4, 1.0), np.random.default_rng(seed).normal(size=(2, 4)), []
    for steps in np.array([1.0, -1.0]), np.cos(2 * np.pi * np.arange(4) / 4), np.array([1.0, 1e-12, -1.0]):
        loads = {"q_w": joint.q_mean + np.outer(steps, q), "p_w": joint.p_mean + np.outer(steps, p)}
        found.append(lift_off_bound(replace(joint, **loads)))
    assert found[1:] == pytest.approx(found[:1] * 2, rel=1e-12)


@pytest.mark.parametrize("noise", [1e-16, 1e-13])
def test_a_pressure_that_another_node_hardly_changes_is_no_lift_off(noise) -> None:
    """Alone in its limits under a constant load, that node had its slip in units of 1/noise."""
    A, q_w, p_w = np.diag([3.5, 1.4]), [[0.5, 1.0], [0.5, -1.0]], np.full((2, 2), 2.0)
    apart, joint = (Problem(A=A, B=[[0.5, 0.0], [x, -0.5]], f=0.4, q_w=q_w, p_w=p_w) for x in (0.0, noise))
    lower, expected = shakedown.lower_bound(joint, guarantee=True), shakedown.lower_bound(apart)
    assert lower.load_factor == pytest.approx(expected.load_factor, rel=1e-8)
    assert (lower.guarantee, lower.uncertified) == ("proved", "")


def test_lift_off_takes_the_proof_away() -> None:
    """Little preload on node 1: other nodes' locked-in slip lifts it off below λ_1."""
    loads = {"q_w": [[1.0, 0.02], [-1.0, -0.02]], "p_w": [[6.0, 1.2], [6.0, 1.2]]}
    problem = Problem(A=np.eye(2), B=[[0.0, 0.2], [0.6, 0.0]], f=0.3, **loads)
    lower, bound = shakedown.lower_bound(problem), lift_off_bound(problem)
    assert lower.coupling_ratio < 1
    assert bound < lower.load_factor
    assert lower.guarantee == "evidence"
    assert "can lift a node off" in lower.proof.reason
    assert lower.lift_off_bound == pytest.approx(bound, rel=1e-12)
    proved = shakedown.universal_bound(problem)
    assert (proved.limited_by, proved.node, proved.load_factor) == ("lift-off", -1, proved.lift_off_bound)


BEYOND_ONE = [coupled_joint(*drawn) for drawn in ((8, 4, 1.62), (9, 4, 1.48), (13, 4, 1.8))]  # ρ* = 1.01


def floating(seed: int) -> Problem:
    return floating_joint(np.random.default_rng(seed), 4, "plane", "smooth")


@pytest.mark.parametrize(
    ("problem", "most"), [*((x, 4) for x in BEYOND_ONE), *((floating(k), 3) for k in range(3))]
)
def test_with_a_gauge_every_principal_minor_is_positive(problem: Problem, most: int) -> None:
    """Of a floating joint all but the determinant itself."""
    assert difference_gauge(problem) is not None
    assert coupling(problem).bound >= 1.0
    for k in range(1, most + 1):
        for chosen, signs in product(combinations(range(4), k), product((-1, 1), repeat=k)):
            A, fB = (M[np.ix_(chosen, chosen)] for M in (problem.A, problem.f[:, None] * problem.B))
            assert np.linalg.det(A + np.array(signs)[:, None] * fB) > 0


@pytest.mark.parametrize("seed", [0, 1, 5, 6])
def test_below_the_first_collapse_every_state_shakes_down(seed: int) -> None:
    problem, rng = floating(seed), np.random.default_rng(seed)
    bound = shakedown.universal_bound(problem)
    assert bound.argument == "differences"
    assert 0 < bound.load_factor <= bound.first_collapse
    assert shakedown.universal_bound(in_units(problem, 2.0**-40, 1.0)).load_factor == bound.load_factor
    slips = rng.normal(size=(60, 4))
    size = np.abs(problem.q_w).max() / np.abs(problem.A).max()
    found = shakedown.long_term_states(problem, 0.999 * bound.load_factor, size * slips)
    assert set(found.outcome) <= {"shakedown", "separation"}  # large slips may open a node at first
    assert np.mean(found.outcome == "shakedown") > 0.5


@pytest.mark.parametrize("problem", BEYOND_ONE)
def test_which_way_the_tangents_of_the_nodes_point_does_not_matter(problem: Problem) -> None:
    for signs in product([1.0], *[(1.0, -1.0)] * 3):
        turned = replace(problem, A=problem.A * signs * np.array(signs)[:, None], B=problem.B * signs)
        assert difference_gauge(turned) == pytest.approx(difference_gauge(problem), rel=1e-9)


def test_a_weakly_coupled_joint_has_one_and_the_counter_examples_none() -> None:
    assert difference_gauge(shakedown.example("block-33")) is not None
    for name in ("three-node", "pair-cycle"):
        assert difference_gauge(shakedown.example(name)) is None


def test_where_the_gauge_does_not_exist_two_nodes_cycle_together_far_below_the_first_collapse() -> None:
    """The built-in counter-example: λ_1 = 3.096, and from 1.699024 on neither of its movers waits for it."""
    problem, slip = shakedown.example("pair-cycle"), [2.12293, 2.12293, -1.12424, -0.32851]
    below, above = (shakedown.long_term_state(problem, λ, slip) for λ in (1.69902, 1.69903))
    assert (below.outcome, above.outcome) == ("shakedown", "cyclic-slip")
    assert (above.slip_per_cycle > 0).tolist() == [True, True, False, False]
    assert shakedown.lower_bound(problem).load_factor == pytest.approx(3.096, rel=1e-12)
