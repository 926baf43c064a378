"""λ_max and safe slips with two tangential directions: cited numbers, closed forms, two methods, what is proved."""

from dataclasses import replace
from fractions import Fraction
from itertools import islice

import numpy as np
import pytest
from flint import fmpq, fmpq_mat
from joints_in_space import embedded, in_last_bits, random_joint

import shakedown
from shakedown import Problem, Status
from shakedown.bounds import enclosure
from shakedown.bounds.disc_rows import disc_rows
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.bounds.scaled_solution import scaled_discs, solve_scaled
from shakedown.joint.constraints import constraints, loading

CITED = {
    "one-node-3d": (1.2517324450972993, 1.251732445097317),
    "two-node-3d": (0.8810851578372411, 0.8810851578372628),
    "four-node-3d": (1.22496169897345, 1.2249616989735457),
    "block-3x3": (2.7846083400213213, 2.7846083400225528),
}


def slack(problem: Problem, slip: np.ndarray, load_factor: float) -> float:
    """The least f p − |q| over all load steps, relative to the largest force."""
    loop = loading(problem)
    q = loop.q0 + load_factor * loop.q1 + problem.A @ slip
    p = loop.p0 + load_factor * loop.p1 + problem.B @ slip
    left = problem.f * p - np.linalg.norm(q.reshape(len(q), -1, 2), axis=-1)
    return float(left.min() / max(np.abs(q).max(), np.abs(p).max()))


@pytest.mark.parametrize("name", CITED)
def test_cited(name):
    problem, (low, high) = shakedown.example(name), CITED[name]
    upper = shakedown.upper_bound(problem)
    assert upper.load_factor == pytest.approx(0.5 * (low + high), rel=1e-12)
    assert upper.certified[0] <= high
    assert low <= upper.certified[1]
    assert upper.certified[1] - upper.certified[0] <= 1e-9 * low
    assert upper.exact
    rough = shakedown.Tolerances(agreement=1e-18)  # as if the floats had to agree to all digits and more
    assert shakedown.upper_bound(problem, certify=False, tolerances=rough).reduced_accuracy
    assert abs(slack(problem, upper.slip, upper.load_factor)) < 1e-14
    y, rows = upper.multipliers, constraints(problem)
    terms = np.abs(y) @ np.abs(rows.G)
    assert np.all(np.abs(y @ rows.G) <= 1e-13 * terms)
    assert y @ rows.d == pytest.approx(1.0, rel=1e-12)
    assert y @ rows.g == pytest.approx(upper.load_factor, rel=1e-12)
    weights = y.reshape(-1, 3)
    assert np.all(weights[:, 0] >= np.hypot(*weights[:, 1:].T) * (1 - 1e-12))
    bears = weights[:, 0] > 1e-9 * weights.max()
    assert set(upper.active) == set(zip(rows.node[::3][bears], rows.step[::3][bears], strict=True))
    assert conic_upper_bound(problem).load_factor == pytest.approx(upper.load_factor, rel=1e-9)


@pytest.mark.parametrize("name", ["two-node", "block-9", "press-fit"])
def test_load_in_one_direction_is_the_plane(name):
    plane = shakedown.example(name)
    one, two = shakedown.upper_bound(plane), shakedown.upper_bound(embedded(plane))
    assert two.load_factor == pytest.approx(one.load_factor, rel=1e-12)
    assert two.certified[0] <= one.load_factor <= two.certified[1]


@pytest.mark.parametrize("exponent", [6, 30])
@pytest.mark.parametrize("name", ["one-node-3d", "four-node-3d", "two-node"])
def test_small_friction_bears_a_load_in_proportion(name, exponent):
    """λ_max / f, as f vanishes: slip takes the mean load, and friction under the pressures left the rest."""
    problem = shakedown.example(name)
    loop, small = loading(problem), 10.0**-exponent
    p = loop.p0 - problem.B @ np.linalg.solve(problem.A, loop.q0)
    steady = {"q_w": loop.q1, "p_w": np.tile(p, (len(loop.p1), 1))}
    limit = shakedown.upper_bound(Problem(A=problem.A, B=0.0 * problem.B, f=problem.f, **steady))
    found = shakedown.upper_bound(replace(problem, f=small * problem.f))
    assert found.load_factor == pytest.approx(small * limit.load_factor, rel=1e-7 + small, abs=0.0)
    if found.certified is not None:
        assert found.certified[0] <= found.load_factor <= found.certified[1]
    np.testing.assert_allclose(problem.A @ found.slip, -loop.q0, rtol=1e-3, atol=1e-3 * np.abs(loop.q1).max())


@pytest.mark.parametrize("seed", range(6))
def test_two_methods(seed):
    """Interior points of one's own, and Clarabel on the program as it stands; both statuses, and the proof."""
    rng = np.random.default_rng(100 + seed)
    problem = random_joint(rng, int(rng.integers(1, 7)), pressure=rng.choice([0.0, 1.0, 4.0]))
    upper, second = shakedown.upper_bound(problem), conic_upper_bound(problem)
    assert upper.status == second.status
    assert upper.exact
    if upper.status == Status.OPTIMAL:
        low, high = upper.certified
        assert upper.load_factor == pytest.approx(second.load_factor, rel=1e-7)
        assert low <= upper.load_factor <= high <= low * (1 + 1e-9)


def exact_slack(problem: Problem, slip: np.ndarray, load_factor: float) -> bool:
    """Whether a slip is safe at every load step, in rational arithmetic."""
    exact = np.vectorize(lambda x: Fraction(float(x)), otypes=[object])
    A, B, q, p = (exact(each) for each in (problem.A, problem.B, problem.q_w, problem.p_w))
    v, at, f = exact(slip), Fraction(load_factor), exact(problem.f)
    q0, p0 = q.sum(axis=0) / Fraction(len(q)), p.sum(axis=0) / Fraction(len(p))
    limit = f * (p0 + at * (p - p0) + B @ v)
    parts = (q0 + at * (q - q0) + A @ v).reshape(len(q), -1, 2)
    return bool(np.all(limit >= 0) and np.all((parts**2).sum(axis=-1) <= limit**2))


@pytest.mark.parametrize("seed", range(4))
def test_what_is_proved_holds_in_rational_arithmetic(seed):
    """The slip next to the low end is safe exactly; above the high end the program of Clarabel has none."""
    problem = random_joint(np.random.default_rng(seed), 3)
    rows = disc_rows(problem)
    best = solve_scaled(scaled_discs(rows, -1.0))
    proof, (slips, _) = enclosure.proof_of(problem, rows), enclosure.inner_points(rows, best)
    low, slip = enclosure.proved_low(proof, best.x, best.load_factor, slips)
    assert low == pytest.approx(best.load_factor, rel=1e-10)
    assert exact_slack(problem, slip, low)
    assert not exact_slack(problem, slip, low * (1 + 1e-9))


@pytest.mark.parametrize("seed", range(3))
def test_the_high_end_is_that_of_multipliers_that_balance_exactly(seed):
    """What U3 says is there, found in rational arithmetic: within its bound, in the cones, no higher."""

    def exact(values):
        return [fmpq(*float(x).as_integer_ratio()) for x in np.ravel(values)]

    problem = random_joint(np.random.default_rng(40 + seed), 2)
    rows, k = disc_rows(problem), 2 * problem.n
    best = solve_scaled(scaled_discs(rows, -1.0))
    proof, inner = enclosure.proof_of(problem, rows), enclosure.inner_points(rows, best)[1]
    assert enclosure.fitting(proof, best.y, inner, most=0.0) is None  # to balance them costs something
    balance = enclosure.fitting(proof, best.y, inner)
    totals = [[sum(exact(balance.y[rows.node == i, c]), fmpq(0)) for c in range(3)] for i in range(problem.n)]
    A, B = (fmpq_mat(len(M), k, exact(M)) for M in (problem.A, problem.B))
    Y = fmpq_mat(k, 1, [part for total in totals for part in total[1:]])
    S = fmpq_mat(problem.n, 1, [f * total[0] for f, total in zip(exact(problem.f), totals, strict=True)])
    delta = np.array([-float(x) for x in A.solve(A * Y + B.transpose() * S).entries()]).reshape(-1, 2)
    assert np.all(np.abs(delta) <= balance.correction)
    y = balance.y.copy()
    y[balance.disc, 1:] += delta
    assert np.all(y[:, 0] >= np.hypot(y[:, 1], y[:, 2]))
    value = np.vdot(y, proof.c[rows.node]) / -np.vdot(y, proof.e[rows.step, rows.node])
    high = enclosure.proved_high(proof, best.y, inner, shakedown.Tolerances())
    assert best.load_factor <= value * (1 + 1e-13)
    assert value <= high <= value * (1 + 1e-10)


def test_a_rough_inverse_bounds_the_exact_one():
    rough = enclosure.Inverse(np.eye(1))
    rough.approximate, rough.norm = 0.8 * rough.approximate, 0.2
    assert rough.bound(np.ones(1)) >= 1.0


def test_of_an_inner_point_twice_as_much_is_taken_each_time_up_to_all():
    shares = [list(islice(enclosure.doubled(needed), 9)) for needed in (0.0, 0.3, 0.5, 1.0)]
    assert shares == [[], [0.6, 1.0], [1.0], []]


@pytest.mark.parametrize("seed", range(3))
def test_what_is_proved_of_tiny_multipliers_does_not_hang_on_last_bits(seed):
    """Two nodes of the flange determine its optimum, the others have multipliers of 1e-9 that must balance."""
    flange = in_last_bits(shakedown.example("bolted-flange"), np.random.default_rng(seed))
    upper = shakedown.upper_bound(flange)
    low, high = upper.certified
    assert low <= upper.load_factor <= high <= low * (1 + 1e-9)


@pytest.mark.parametrize("directions", [1, 2])
@pytest.mark.parametrize("seed", range(3))
def test_a_joint_that_nothing_presses_has_no_load_factor(directions, seed):
    rng, size = np.random.default_rng(seed), 2 * directions
    joint = random_joint(rng, 2)
    q_w = rng.normal(size=(12, size))
    q_w -= q_w.mean(axis=0)  # which leaves the round-off of a mean
    loop = {"q_w": q_w, "p_w": np.zeros((12, 2))}
    upper = shakedown.upper_bound(Problem(A=joint.A[:size, :size], B=joint.B[:, :size], f=0.1, **loop))
    assert (upper.load_factor, upper.certified, upper.disputed) == (0.0, (0.0, 0.0), False)


def test_a_stiffness_that_is_nearly_singular_has_the_safe_slips_of_its_limits():
    """Without coupling λ_max = f p / |q₁|; a slip of 1e6 makes the mean loads alike, as friction asks for."""
    A, swing = 1.0 - 1e-7 * (1.0 - np.eye(2)), np.outer([1.0, -1.0], [0.2, -0.1, 0.0, 0.2])
    loads = {"q_w": swing + 5.0 + 0.2 * np.eye(1, 4, 1), "p_w": [[2.0] * 2] * 2, "stiffness_accuracy": 1e-12}
    joint = Problem(A=np.kron(A, np.eye(2)), B=np.zeros((2, 4)), f=0.5, **loads)
    upper = shakedown.upper_bound(joint)
    assert upper.load_factor == pytest.approx(1.0 / np.hypot(0.2, 0.1), rel=1e-9)
    assert abs(slack(joint, upper.slip, upper.load_factor)) < 1e-9


def test_wedging_is_proved():
    problem = Problem(A=np.eye(2), B=[[3.0, 0.0]], f=0.8, q_w=[[1.0, 0.2], [-1.0, 0.1]], p_w=[[3.0], [2.5]])
    upper = shakedown.upper_bound(problem)
    assert upper.status == Status.UNBOUNDED
    assert upper.certified == (np.inf, np.inf)
    assert "wedging" in upper.reason
    loop, means = loading(problem), {"q_mean": [0.0, 0.15], "p_mean": [2.75]}
    eightfold = replace(problem, q_w=loop.q0 + 8 * loop.q1, p_w=loop.p0 + 8 * loop.p1, **means)
    assert shakedown.upper_bound(eightfold).direction == pytest.approx(8 * upper.direction, rel=1e-6)
    assert upper.residual < 0
    assert slack(problem, 1e6 * upper.direction, 1e6) > 0


def test_zero_amplitude_and_relief():
    still = {"A": np.eye(2), "B": [[0.1, 0.0]], "f": 0.5}
    upper = shakedown.upper_bound(Problem(q_w=[[0.5, 0.2]] * 2, p_w=[[3.0]] * 2, **still))
    assert (upper.status, upper.certified) == (Status.UNBOUNDED, (np.inf, np.inf))
    assert "zero-amplitude" in upper.reason
    relief = Problem(q_w=[[0.1, 0.0]] * 2, p_w=[[3.0]] * 2, q_mean=[0.0, 0.0], p_mean=[1.0], **still)
    assert "brings no node nearer" in shakedown.upper_bound(relief).reason


@pytest.mark.parametrize("d", [1, 2])
@pytest.mark.parametrize("certify", [True, False])
def test_infeasible_with_multipliers_that_prove_it(d, certify):
    B, q_w = np.array([[0.1, 0.0]]), np.array([[1.0, 0.0], [-1.0, 0.0]])
    problem = Problem(A=np.eye(d), B=B[:, :d], f=0.5, q_w=q_w[:, :d], p_w=[[-3.0], [-3.0]])
    upper, rows = shakedown.upper_bound(problem, certify=certify), constraints(problem)
    assert (upper.status, repr(upper.exact)) == (Status.INFEASIBLE, repr(certify))  # as JSON takes it
    y = upper.multipliers
    assert np.abs(y @ rows.G).max() < 1e-9
    assert y @ rows.g < 0 < y @ rows.d + 1e-12
    assert np.isnan(upper.load_factor)


def test_a_floating_body_is_pinned():
    joint = random_joint(np.random.default_rng(5), 4)
    Z = np.zeros((12, 2))
    Z[0:8:2, 0], Z[1:8:2, 1] = 1.0, 1.0
    P = np.eye(12) - Z @ np.linalg.pinv(Z)
    kappa = P @ joint.kappa @ P
    kappa = 0.5 * (kappa + kappa.T)
    floating = replace(joint, A=kappa[:8, :8], B=kappa[8:, :8], C=kappa[8:, 8:])
    upper = shakedown.upper_bound(floating)
    assert len(upper.pinned) == 2
    np.testing.assert_array_equal(upper.slip[list(upper.pinned)], 0.0)
    assert upper.certified[1] - upper.certified[0] < 1e-9
    assert slack(floating, upper.slip, upper.load_factor) > -1e-13
    moved = upper.slip + Z[:8] @ [3.0, -2.0]
    assert slack(floating, moved, upper.load_factor) > -1e-12


@pytest.mark.parametrize("seed", range(4))
def test_the_safest_slip_has_a_ball_of_safe_slips(seed):
    rng = np.random.default_rng(seed)
    problem = random_joint(rng, 3)
    most = shakedown.upper_bound(problem).load_factor
    safe = shakedown.safe_slip(problem, 0.9 * most)
    assert safe.status == Status.OPTIMAL
    assert safe.margin > 0
    assert safe.active
    for way in rng.normal(size=(50, 6)):
        away = safe.slip + safe.margin * way / np.linalg.norm(way)
        assert slack(problem, away, 0.9 * most) > -1e-12
    assert shakedown.safe_slip(problem, 1.001 * most).status == Status.INFEASIBLE


@pytest.mark.parametrize("noise", [1e-15, 1e-13, 1e-11])
def test_loads_that_vary_by_round_off_at_most_nodes_are_constant(noise):
    joint, rng = random_joint(np.random.default_rng(4), 5), np.random.default_rng(0)
    swing = np.zeros_like(joint.q_w)
    swing[:, :2] = np.cos(2 * np.pi * np.arange(len(swing)) / len(swing))[:, None]
    still = {"q_mean": joint.q_w[0], "p_mean": joint.p_w[0], "p_w": np.tile(joint.p_w[0], (len(swing), 1))}
    loads = joint.q_w[0] + swing, joint.q_w[0] + swing + noise * rng.normal(size=swing.shape)
    exact, off = (shakedown.upper_bound(replace(joint, q_w=q_w, **still)) for q_w in loads)
    assert off.load_factor == pytest.approx(exact.load_factor, rel=1e-9)


def test_a_node_that_is_pressed_ever_more_limits_nothing_at_last():
    """A chain held by a soft spring at one end; the programs had no end from 1e9 on."""
    rng, n = np.random.default_rng(0), 5
    stretch = np.kron(np.vstack([np.eye(1, n), np.diff(np.eye(n), axis=0)]), np.eye(2))
    A = stretch.T @ (np.repeat([1e-8, 1.0, 1.0, 1.0, 1.0], 2)[:, None] * stretch)
    B, q, p = 0.1 * rng.normal(size=(n, 2 * n)) @ A, rng.normal(size=(12, 2 * n)), rng.normal(size=(12, n))
    found = []
    for more in (1e8, 1e10, 1e12):
        loads = (4.0 + 0.7 * p) * np.append(more, np.ones(n - 1))
        joint = shakedown.Problem(A=A, B=B, f=np.full(n, 0.4), q_w=q, p_w=loads)
        found.append(shakedown.upper_bound(joint, certify=False).load_factor)
    assert found[1] == pytest.approx(found[2], rel=1e-6)
    assert abs(found[2] - found[1]) <= 0.1 * abs(found[1] - found[0]) + 1e-9 * found[0]
