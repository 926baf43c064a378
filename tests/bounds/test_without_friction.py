"""Nodes without friction: |q| <= f p says nothing of their pressure, which has a row of its own."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

import shakedown
from shakedown import Outcome, Problem, Status
from shakedown.bounds.critical import subset_count
from shakedown.bounds.independent_solver import conic_lower_bound, conic_upper_bound
from shakedown.bounds.proof_status import lift_off_bound
from shakedown.joint.constraints import constraints, loading
from tests.joints_in_space import embedded


def two_nodes(d: int, *, swing: float = 1.0) -> Problem:
    """f = (0.5, 0); the pressure of the second swings by so much about 1, the first allows λ = 10."""
    t = np.array([0.0, 1.0, 0.0, -1.0])
    q_w, p_w = np.zeros((4, 2 * d)), np.ones((4, 2))
    q_w[:, 0], p_w[:, 1] = 0.05 * t, 1.0 + swing * t
    return Problem(
        A=2.0 * np.eye(2 * d), B=np.zeros((2, 2 * d)), C=3.0 * np.eye(2), f=[0.5, 0.0], q_w=q_w, p_w=p_w
    )


@pytest.mark.parametrize("d", [1, 2])
def test_a_node_without_friction_may_not_pull(d):
    joint = two_nodes(d)
    upper = shakedown.upper_bound(joint)
    low, high = upper.certified
    assert low <= upper.load_factor <= high
    assert (low, high) == (pytest.approx(1.0, rel=1e-12), pytest.approx(1.0, rel=1e-12))
    assert [node for node, _ in upper.active] == [1]
    assert upper.multipliers @ constraints(joint).g == pytest.approx(1.0)
    assert conic_upper_bound(joint).load_factor == pytest.approx(1.0, rel=1e-8)
    assert shakedown.safe_slip(joint, 3.0).status == Status.INFEASIBLE
    assert shakedown.safe_slip(joint, 0.9).residual <= 0.0
    assert shakedown.energy_bound(joint).status == Status.INFEASIBLE
    assert shakedown.universal_bound(joint).load_factor <= 1.0


@pytest.mark.parametrize("d", [1, 2])
def test_no_slip_is_safe_where_a_node_without_friction_is_drawn_to_and_fro(d):
    """Its pressure is constant: that at any load step is the least."""
    joint = two_nodes(d, swing=0.0)
    assert shakedown.upper_bound(replace(joint, q_w=np.tile(joint.q_w[:, :d], 2))).load_factor == 0.0


@pytest.mark.parametrize("size", [1e-16, 1e-14])
@pytest.mark.parametrize("d", [1, 2])
def test_round_off_of_the_loads_draws_no_node_to_and_fro(d, size):
    joint, rng = two_nodes(d, swing=0.5), np.random.default_rng(d)
    q_w, p_w = (loads + size * rng.uniform(-1, 1, loads.shape) for loads in (joint.q_w, joint.p_w))
    noisy = replace(joint, q_w=q_w, p_w=p_w)
    for bound in (shakedown.upper_bound, shakedown.universal_bound, shakedown.energy_bound):
        assert bound(noisy).load_factor == pytest.approx(bound(joint).load_factor, rel=1e-12, nan_ok=True)
    assert shakedown.upper_bound(noisy).certified == pytest.approx((2.0, 2.0), rel=1e-12)


@pytest.mark.parametrize("d", [1, 2])
@pytest.mark.parametrize(
    ("swing", "outcome"), [(0.9, "shakedown"), (1.0, "shakedown"), (1.001, "separation"), (3.0, "separation")]
)
def test_the_motion_agrees_in_the_plane_and_in_space(d, swing, outcome):
    assert shakedown.assess(two_nodes(d, swing=swing)).as_given == Outcome(outcome)


@pytest.mark.parametrize("d", [1, 2])
def test_without_a_closed_state_there_is_no_bound(d):
    joint = two_nodes(d)
    pulled = replace(joint, p_w=joint.p_w - [0.0, 1.5])
    upper = shakedown.upper_bound(pulled, open_nodes=())
    assert (upper.status, upper.exact) == (Status.INFEASIBLE, True)
    if d == 1:
        assert shakedown.lower_bound(pulled, certify=True).status == Status.INFEASIBLE
        assert conic_lower_bound(pulled).status == Status.INFEASIBLE
    assert shakedown.universal_bound(pulled).status == Status.INFEASIBLE


def drawn(seed: int) -> Problem:
    """A joint in the plane of which some nodes have no friction, and a constant tangential load."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    root = rng.normal(size=(2 * n, 2 * n))
    kappa, f = root @ root.T + 0.3 * np.eye(2 * n), rng.choice([0.0, 0.3, 0.7], n)
    q_w, p_w = rng.normal(size=(6, n)), 2.0 + rng.choice([0.3, 1.0]) * rng.normal(size=(6, n))
    q_w[:, f == 0.0] = q_w[0, f == 0.0] * rng.choice([0.0, 1.0])
    return Problem(
        A=kappa[:n, :n], B=kappa[n:, :n], C=kappa[n:, n:], f=f, q_w=q_w, p_w=p_w - rng.choice([0.0, 1.5])
    )


def by_every_row(joint: Problem) -> float:
    """λ_max of |q| <= f p and p >= 0 at every node and load step; NaN without, inf without end."""
    loop, n, f = loading(joint), joint.n, joint.f
    rows, right = [], []
    for q1, p1 in zip(loop.q1, loop.p1, strict=True):
        rows += [np.column_stack([s * joint.A - f[:, None] * joint.B, s * q1 - f * p1]) for s in (1.0, -1.0)]
        right += [f * loop.p0 - s * loop.q0 for s in (1.0, -1.0)]
        rows.append(np.column_stack([-joint.B, -p1]))
        right.append(loop.p0)
    cost, bounds = np.append(np.zeros(n), -1.0), [(None, None)] * n + [(0.0, None)]
    end = linprog(cost, np.vstack(rows), np.concatenate(right), bounds=bounds, method="highs")
    return {0: -end.fun if end.status == 0 else 0.0, 2: np.nan, 3: np.inf}[end.status]


@pytest.mark.parametrize("seed", [*range(8), 33])  # the last: the pressure of a second node without friction
def test_every_method_knows_the_pressures(seed):
    joint = drawn(seed)
    known = by_every_row(joint)
    for each in (joint, embedded(joint)):
        upper = shakedown.upper_bound(each)
        assert upper.load_factor == pytest.approx(known, rel=1e-8, abs=1e-9, nan_ok=True)
        assert upper.exact
        assert conic_upper_bound(each).load_factor == pytest.approx(known, rel=1e-6, abs=1e-9, nan_ok=True)
        if 0.0 < known < np.inf:
            slip = shakedown.safe_slip(each, 0.7 * known).slip
            q, p = loading(each).at(0.7 * known)
            assert (p + each.B @ slip).min() >= -1e-9
            assert each.law.excess(q + each.A @ slip, p + each.B @ slip).max() <= 1e-9
    assert np.isnan(shakedown.lower_bound(joint, certify=True).load_factor) == np.isnan(known)


def test_pressures_have_rows_of_their_own_in_every_search():
    joint = two_nodes(1)
    assert lift_off_bound(joint) == pytest.approx(1.0)
    found = shakedown.critical_load_factors(joint, values=True)
    assert found.total == subset_count(2, 1) == 10
    assert found.smallest_feasible.load_factor == pytest.approx(1.0)


@pytest.mark.parametrize("seed", [1, 8])
def test_round_off_of_distant_nodes_balances_no_multiplier(seed):
    """Of a banded stiffness in space, whose entries between distant nodes are round-off."""
    n, rng = 20, np.random.default_rng(seed)
    near = np.exp(-np.abs(np.subtract.outer(np.arange(n), np.arange(n))) / 3) + 0.1 * np.eye(n)
    q_w, p_w = rng.normal(size=(8, 2 * n)), rng.uniform(1.0, 3.0, (8, n))
    q_w[:, :2] = 0.0
    joint = shakedown.Problem(
        A=np.kron(np.linalg.inv(near), np.eye(2)), B=np.zeros((n, 2 * n)), f=np.append(0.0, np.full(n - 1, 0.4)),
        q_w=q_w, p_w=p_w,
    )  # fmt: skip
    floats, (low, high) = shakedown.upper_bound(joint, certify=False), shakedown.upper_bound(joint).certified
    assert (1.0 - 1e-9) * low <= floats.load_factor <= (1.0 + 1e-9) * high


def test_a_node_without_friction_that_is_loaded_and_pulled_has_no_safe_slip():
    """Its load is balanced at λ = 0 alone; that it pulls there no slip changes, and so none was found: NaN."""
    joint = two_nodes(2)
    q_w = joint.q_w.copy()
    q_w[:, 2] = q_w[:, 0]
    pulled = replace(joint, q_w=q_w, p_w=joint.p_w - [0.0, 1.5])
    assert shakedown.upper_bound(pulled).status == Status.INFEASIBLE
    assert shakedown.safe_slip(pulled, 0.0).status == Status.INFEASIBLE
    lifted = shakedown.upper_bound(pulled, open_nodes="auto")
    assert (lifted.status, lifted.open_nodes) == (Status.OPTIMAL, (1,))


def lifted_where_nothing_couples(seed: int, d: int, noise: float) -> tuple[Problem, int]:
    """A banded joint, most nodes without friction, one pulled on; B is round-off, or exactly zero."""
    n, rng = (20 if d == 1 else 8), np.random.default_rng(seed)
    near = np.exp(-np.abs(np.subtract.outer(np.arange(n), np.arange(n))) / 3) + 0.1 * np.eye(n)
    f = np.where(rng.random(n) < 0.8, 0.0, 0.4)
    q_w, p_w = rng.normal(size=(8, d * n)), rng.uniform(1.0, 3.0, (8, n))
    q_w[:, np.repeat(f == 0.0, d)] = 0.0
    lifted = n - 5
    p_w[:, lifted] -= 5.0
    B = noise * rng.normal(size=(n, d * n))
    A = np.kron(np.linalg.inv(near), np.eye(d))
    return Problem(A=A, B=B, C=4.0 * np.eye(n), f=f, q_w=q_w, p_w=p_w), lifted


@pytest.mark.parametrize("d", [1, 2])
@pytest.mark.parametrize("seed", range(2))
def test_a_stiffness_that_is_round_off_presses_no_node(seed, d):
    """HiGHS refused programs with rows of 1e-17, or they ended "unbounded", as loads of 1e-17 were loads."""
    joint, lifted = lifted_where_nothing_couples(seed, d, noise=1e-17)
    same, _ = lifted_where_nothing_couples(seed, d, noise=0.0)
    for nodes in ((), (lifted,)):
        found, known = (shakedown.upper_bound(each, open_nodes=nodes) for each in (joint, same))
        assert found.status == known.status
        assert found.load_factor == pytest.approx(known.load_factor, rel=1e-9, nan_ok=True)
        for at in (0.5, 5.0):
            slips = [shakedown.safe_slip(each, at, open_nodes=nodes).status for each in (joint, same)]
            assert slips[0] == slips[1]
    assert known.status == Status.OPTIMAL


@pytest.mark.parametrize("seed", [13, 66, 72])
def test_without_any_friction_a_moving_load_is_safe_from_zero_to_zero(seed):
    """In space λ_max = 0 leaves λ_lo nothing but 0: its own program, whose discs have no room, may fail."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 5))
    root = rng.normal(size=(3 * n, 3 * n))
    kappa, m = root @ root.T + 0.2 * np.eye(3 * n), int(rng.integers(2, 10))
    loads = {"q_w": rng.normal(size=(m, 2 * n)), "p_w": 4.0 + 0.7 * rng.normal(size=(m, n))}
    loads |= {"q_mean": 0.5 * rng.normal(size=2 * n), "p_mean": np.full(n, 4.0)}
    upper = shakedown.upper_bound(
        Problem(A=kappa[: 2 * n, : 2 * n], B=kappa[2 * n :, : 2 * n], f=0.0, **loads)
    )
    assert (upper.load_factor, upper.least_load_factor, upper.missing) == (0.0, 0.0, ())
