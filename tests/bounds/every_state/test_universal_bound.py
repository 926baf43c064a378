"""What is proved from every state: least pressures against second methods, complete arguments, what limits them."""

from dataclasses import replace

import numpy as np
import pytest
from joints_in_space import embedded
from scipy.linalg import block_diag
from scipy.optimize import linprog

import shakedown
from benchmarks.problems import random_problem
from shakedown import Problem
from shakedown.bounds.every_state import bound_of_floating
from shakedown.bounds.every_state.bound_of_floating import unique_rates
from shakedown.bounds.every_state.least_pressures import least_pressures, scaled_joint
from shakedown.bounds.every_state.universal_bound import least_pressure_bound, universal_bound
from shakedown.joint.constraints import loading

BUILT_IN = [  # f if not the joint's own, load factor that least pressures prove, argument up to the first collapse
    ("one-node", None, 0.9305240, "first collapse"),
    ("two-node", None, 0.6035788, "first collapse"),
    ("uncoupled", None, 0.6465540, "Melan"),
    ("three-node", None, 0.3096, None),
    ("block-9", 0.1, 0.5722084, "first collapse"),
    ("block-9", 0.2, 0.8491080, None),
    ("block-9", 0.3, 0.8428534, None),
    ("block-33", 0.2, 0.3209723, "first collapse"),
    ("press-fit", None, None, "first collapse"),
]


@pytest.mark.parametrize(("name", "f", "expected", "argument"), BUILT_IN)
def test_built_in_joints_by_least_pressures_and_by_complete_arguments(name, f, expected, argument):
    problem = shakedown.example(name)
    problem = problem if f is None else replace(problem, f=f)
    if expected is not None:
        assert least_pressure_bound(problem).load_factor == pytest.approx(expected, abs=6e-8)
    if argument is not None:
        bound = universal_bound(problem)
        assert (bound.argument, bound.load_factor) == (argument, bound.first_collapse)


@pytest.mark.parametrize(("n", "floating"), [(1, False), (2, False), (4, False), (2, True), (4, True)])
def test_without_coupling_it_is_the_largest_load_factor(n, floating):
    rng = np.random.default_rng(n)
    root = rng.normal(size=(n, n))
    A = root @ root.T + np.eye(n)
    if floating:
        rigid = np.ones(n) / np.sqrt(n)
        A = (np.eye(n) - np.outer(rigid, rigid)) @ A @ (np.eye(n) - np.outer(rigid, rigid))
    problem = Problem(
        A=A, B=np.zeros((n, n)), f=0.5, q_w=rng.normal(size=(6, n)), p_w=4 + rng.normal(size=(6, n))
    )
    upper = shakedown.upper_bound(problem).load_factor
    assert least_pressure_bound(problem).load_factor == pytest.approx(upper, rel=1e-8)
    bound = universal_bound(problem)
    assert (bound.argument, bound.limited_by) == ("Melan", "first collapse")
    assert bound.load_factor == pytest.approx(upper, rel=1e-12)


@pytest.mark.parametrize("name", ["one-node", "two-node", "two-node-3d"])
def test_at_the_lift_off_bound_a_load_that_lasts_leaves_a_node_no_pressure(name):
    joint = shakedown.example(name)
    found, loop = least_pressure_bound(joint).lift_off_bound, loading(joint)
    for share in (0.999, 1.001):
        loads = zip(*loop.at(share * found), strict=True)
        least = [least_pressure_bound(replace(joint, q_mean=q, p_mean=p)).pressures.min() for q, p in loads]
        assert (min(least) > 0) == (share < 1)


def test_rigid_motion_limits_a_floating_body():
    """Each node alone could bear λ = 1; both together slide where 1.6 + 2 λ exceeds the friction 2 + 1."""
    A = np.array([[1.0, -1.0], [-1.0, 1.0]])
    q = 0.8 + np.array([[1.0, 1.0], [-1.0, -1.0]])
    problem = Problem(A=A, B=np.zeros((2, 2)), f=[0.5, 0.25], q_w=q, p_w=np.full((2, 2), 4.0))
    assert least_pressure_bound(problem).load_factor == pytest.approx(0.7)


def test_lifted_nodes_and_missing_safe_states_leave_nothing():
    lifted = universal_bound(replace(shakedown.example("block-9"), f=0.5))
    assert (lifted.status, lifted.load_factor, lifted.limited_by) == ("optimal", 0.0, "first collapse")
    assert "some locked-in slip lifts node " in lifted.reason
    for pulled in (shakedown.example("receding-block"), joint(p_w=np.full((12, 3), -1.0), coupling=0.1)):
        none = universal_bound(pulled)
        assert (none.status, none.limited_by) == ("infeasible", "mean load")
        assert np.isnan(none.load_factor)
    loads = {"q_w": [[0.1, 0.0], [-0.1, 0.0]], "p_w": np.full((2, 2), 5.0)}
    # A (1, −1) = 0, but that is no rigid motion
    found = least_pressure_bound(Problem(A=np.ones((2, 2)), B=0.1 * np.eye(2), f=0.3, **loads))
    assert (found.load_factor, found.node, found.lift_off_bound, found.floats) == (0.0, -1, 0.0, False)
    assert np.isnan([*found.pressures, *found.reactions, *found.mean_reactions]).all()


def test_nothing_is_proved_where_the_motion_may_jump():
    """Friction between the thresholds of the set of both nodes and of each alone; λ_1 > 0 all the same."""
    loads = {"q_w": [[0.1, 0.0, 0.0], [-0.1, 0.0, 0.1]], "p_w": np.full((2, 3), 2.0)}
    A, B = block_diag([[1.0, 0.9], [0.9, 1.0]], 1.0), block_diag([[0.0, 0.4], [-0.4, 0.0]], 0.0)
    problem = Problem(A=A, B=B, f=0.9, **loads)
    bound = universal_bound(problem)
    assert (bound.load_factor, bound.argument) == (0.0, "none")
    assert bound.limited_by in ("uniqueness", "first collapse")


BY_DIRECTIONS = {  # by cone programs, one direction of slip after the other, 192 of them; the node
    "one-node-3d": (1.2472612089337152, 0),
    "two-node-3d": (0.7434164617513364, 1),
    "four-node-3d": (0.7684404665437738, 1),
    "block-3x3": (1.253667702840135, 0),
}
AT_MEAN = {  # least pressures under the mean load, likewise
    "two-node-3d": [1.3230552678160996, 1.186262816134283],
    "four-node-3d": [1.4702001630971742, 1.2607659578085704, 0.9296000289626579, 1.2061619902902714],
}


def joint(n: int = 3, m: int = 12, seed: int = 0, coupling: float = 0.4, **changes) -> Problem:
    """A random joint that is pressed together."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3 * n, 3 * n))
    kappa = root @ root.T / n + np.eye(3 * n)
    t = 2 * np.pi * np.arange(m)[:, None] / m
    arrays = {
        "A": kappa[: 2 * n, : 2 * n],
        "B": coupling * kappa[2 * n :, : 2 * n],
        "f": rng.uniform(0.2, 0.5, n),
        "q_w": rng.normal(size=2 * n) * np.cos(t) + rng.normal(size=2 * n) * np.sin(t + 0.4),
        "p_w": 6.0 + rng.normal(size=n) * np.cos(2 * t),
    }
    return Problem(**(arrays | changes))


@pytest.mark.parametrize("name", BY_DIRECTIONS)
def test_reference_joints(name):
    by_directions, node = BY_DIRECTIONS[name]
    found = universal_bound(shakedown.example(name))
    assert (found.node, found.argument, found.limited_by) == (node, "least pressures", "swing")
    assert (1 - 1e-4) * by_directions < found.load_factor < by_directions  # the directions are samples
    assert found.lift_off_bound >= found.load_factor
    np.testing.assert_allclose(
        found.pressures.pressures, AT_MEAN.get(name, found.pressures.pressures), rtol=1e-9
    )


@pytest.mark.parametrize("seed", range(2))
def test_round_off_takes_nothing_away_from_many_nodes(seed):
    """Multipliers are proved for every node: the weights exceed them by more than what round-off could do."""
    problem = joint(n=24, seed=seed, coupling=0.2)
    least = least_pressures(scaled_joint(problem))
    assert least.proved.all()
    assert np.all(least.error < 1e-11)
    V = np.linalg.qr(np.random.default_rng(seed).normal(size=(6, 6)))[0]
    A = V @ np.diag([1e-7, 1.0, 1.0, 1.0, 1.0, 1.0]) @ V.T  # error in proportion to the softness of one mode
    soft = joint(A=0.5 * (A + A.T), B=0.1 * V[:3] @ A, stiffness_accuracy=1e-14)
    assert np.all(least_pressures(scaled_joint(soft)).error < 1e-7)


def test_no_admissible_slip_presses_less():
    """Weak duality at states of every kind, under loads that the multipliers have never seen."""
    problem, rng = joint(seed=3), np.random.default_rng(7)
    scaled, law = scaled_joint(problem), problem.law
    least, tried = least_pressures(scaled), 0
    for _ in range(4000):
        v, q, p = 0.2 * rng.normal(size=6), rng.normal(size=6), rng.uniform(2.0, 6.0, 3)
        if np.any(law.excess(q + problem.A @ v, p + problem.B @ v) > 0):
            continue
        tried += 1
        bound = least.at(scaled, (q * np.repeat(scaled.lengths, 2))[None], (p * scaled.lengths)[None])[0]
        assert np.all(p + problem.B @ v >= bound / scaled.lengths)
    assert tried > 50


def test_one_node_on_a_circle_has_a_closed_form():
    """q = λ q₁ (cos t, sin t), p = p₀ + λ p₁ cos t, B = 0: λ_max = λ_U = f p₀ / √(q₁² + f² p₁²)."""
    m, f, p0, p1, q1 = 256, 0.4, 2.0, 1.3, 0.9
    t = 2 * np.pi * np.arange(m) / m
    loop = {"q_w": q1 * np.stack([np.cos(t), np.sin(t)], axis=1), "p_w": p0 + p1 * np.cos(t)[:, None]}
    node = Problem(A=np.eye(2), B=np.zeros((1, 2)), f=f, **loop, q_mean=[0.0, 0.0], p_mean=[p0])
    closed = f * p0 / np.hypot(q1, f * p1)
    for bound in (shakedown.upper_bound(node), universal_bound(node)):
        assert closed * (1 - 1e-12) <= bound.load_factor <= closed * (1 + (np.pi / m) ** 2)


def test_load_in_one_direction_is_no_more_than_in_the_plane():
    """In space a node may slip aside, too: less is proved, but not much less where the coupling is weak."""
    plane = shakedown.example("two-node")
    most, found = least_pressure_bound(plane).load_factor, universal_bound(embedded(plane)).load_factor
    assert 0.9 * most < found <= most * (1 + 1e-12)
    uncoupled = shakedown.example("uncoupled")
    known = least_pressure_bound(uncoupled).load_factor
    assert universal_bound(embedded(uncoupled)).load_factor == pytest.approx(known, rel=1e-12)


def by_directions(problem: Problem, node: int, count: int) -> float:
    """What one node allows, as a linear program with one limit for each of so many directions of slip.

    Its multipliers by plain iteration, with the weight 0 of its own, as any weight does.
    """
    loop, f, d = loading(problem), problem.f, problem.directions
    place, angle = slice(d * node, d * (node + 1)), 2 * np.pi * np.arange(count) / count
    fB, inverse, h = f[:, None] * problem.B, np.linalg.inv(problem.A), np.zeros(problem.n)
    for _ in range(200):
        Y = inverse @ (problem.B[node] - fB.T @ h)
        h = np.linalg.norm(Y.reshape(-1, d), axis=1)
        h[node] = 0.0
    u = np.stack([np.cos(angle), np.sin(angle)], axis=1) if d == 2 else np.array([[1.0], [-1.0]])
    points = (1.0 + f[node] * u @ Y[place])[:, None] * u

    def least(q, p):
        return f[node] * (p[node] - (f * h) @ p - q @ Y)

    rows = [
        np.column_stack([-points, -points @ q[place] - least(q, p)])
        for q, p in zip(loop.q1, loop.p1, strict=True)
    ]
    right = np.full(len(points) * problem.m, least(loop.q0, loop.p0))
    cost = np.append(np.zeros(d), -1.0)
    end = linprog(cost, np.vstack(rows), right, bounds=[(None, None)] * d + [(0, None)])
    return float(end.x[-1])


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("strength", [0.4, 1.0])
def test_every_direction_of_slip_by_linear_programs(seed, strength):
    problem = joint(seed=seed, coupling=strength)
    found = least_pressure_bound(problem)
    assert (found.load_factor > 0) == (found.pressures > 0).all()
    if found.load_factor > 0:
        sampled = min(by_directions(problem, i, 720) for i in range(problem.n))
        assert sampled * (1 - 1e-4) < found.load_factor <= sampled * (1 + 1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_in_the_plane_there_are_two_directions(seed):
    problem = random_problem(5, seed, coupling=0.9)
    found = least_pressure_bound(problem)
    assert found.load_factor > 0
    both = [by_directions(problem, i, 2) for i in range(problem.n)]
    assert found.load_factor == pytest.approx(min(both), rel=1e-9)
    assert found.node == int(np.argmin(both))


@pytest.mark.parametrize("node", range(3))
def test_locked_in_slip_that_lifts_off_under_the_mean_load(node):
    found = universal_bound(joint(p_w=np.where(np.arange(3) == node, 0.1, 6.0) * np.ones((12, 1))))
    assert (found.load_factor, found.argument, found.limited_by) == (0.0, "none", "lift-off")
    assert (found.node, found.lift_off_bound) == (node, 0.0)
    assert found.reason == f"some locked-in slip may lift node {node} off, under the mean load alone"


def test_where_the_pressure_alone_varies_lift_off_is_the_limit():
    """p = 3 + λ cos t, no shear: friction under the least pressure ends where the node lifts off, at λ = 3."""
    loop = {"q_w": np.zeros((4, 2)), "p_w": 3.0 + np.array([[1.0], [0.0], [-1.0], [0.0]])}
    found = universal_bound(Problem(A=2 * np.eye(2), B=[[0.1, 0.0]], f=0.4, **loop))
    assert (found.limited_by, found.node) == ("lift-off", 0)
    assert (found.load_factor, found.lift_off_bound) == (pytest.approx(3.0), pytest.approx(3.0))


def test_a_loop_without_amplitude_is_unbounded():
    loop = {"q_w": np.tile([0.3, 0.1] * 3, (4, 1)), "p_w": np.full((4, 3), 5.0)}
    found = universal_bound(joint(**loop))
    assert (found.status, found.load_factor, found.node) == ("unbounded", np.inf, -1)
    assert (found.limited_by, found.lift_off_bound) == ("swing", np.inf)
    assert found.reason == "least pressures: no load factor ends the proof"


def test_a_node_without_friction():
    problem = joint()
    f = np.array([0.3, 0.0, 0.4])
    moved = universal_bound(replace(problem, f=f))
    assert (moved.load_factor, moved.node) == (0.0, 1)
    assert moved.reason == "node 1 has no friction, and its load varies"
    still = problem.q_w.copy()
    still[:, 2:4] = 0.1
    assert 0.0 < universal_bound(replace(problem, f=f, q_w=still)).load_factor < np.inf


def test_a_body_that_friction_alone_holds_has_no_unique_rates(monkeypatch):
    A = np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(2))
    B = 0.1 * np.kron([[1.0, -1.0], [0.0, 0.0]], np.ones((1, 2)))
    q_w = np.tile([0.1, 0.0], (4, 2)) * np.array([1.0, -1.0, 0.5, -0.5])[:, None]
    problem = Problem(A=A, B=B, f=0.5, q_w=q_w, p_w=np.full((4, 2), 1.0))
    assert "only friction holds the body" in unique_rates(scaled_joint(problem)).argument
    found = universal_bound(problem)
    assert (found.limited_by, found.argument) == ("rates", "least pressures, rigid motions apart")
    assert 0.0 < found.load_factor < 0.9 * shakedown.upper_bound(problem).load_factor
    assert "is not proved to slip without a jump" in found.reason
    for halvings in range(1, 6):  # with each what is left open is halved
        monkeypatch.setattr(bound_of_floating, "HALVINGS", halvings)
        below = found.load_factor - universal_bound(replace(problem)).load_factor
        assert 0.0 <= below <= 0.5**halvings * shakedown.upper_bound(problem).load_factor


def test_friction_above_which_a_node_runs_away():
    """Node with A = 1, B = 2, f = 1: least pressures are positive, but backward slip runs away."""
    loop = {"q_w": [[1.1, 0.0], [0.9, 0.0]], "p_w": [[10.0], [10.0]]}
    problem = Problem(A=np.eye(2), B=[[2.0, 0.0]], f=1.0, **loop)
    assert not unique_rates(scaled_joint(problem))
    found = universal_bound(problem)
    assert (found.load_factor, found.limited_by) == (0.0, "uniqueness")
