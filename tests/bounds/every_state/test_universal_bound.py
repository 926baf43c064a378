"""The load factor up to which shakedown from every initial state is proved."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

import shakedown
from benchmarks.problems import joint
from shakedown.bounds.every_state.universal_bound import least_pressure_bound
from shakedown.joint.constraints import loading

PRESSURES = [  # load factors up to which least pressures prove it
    ("one-node", None, 0.9305240),
    ("two-node", None, 0.6035788),
    ("uncoupled", None, 0.6465540),
    ("three-node", None, 0.3096),
    ("block-9", 0.1, 0.5722084),
    ("block-9", 0.2, 0.8491080),
    ("block-9", 0.3, 0.8428534),
    ("block-33", 0.2, 0.3209723),
]


def built_in(name: str, f: float | None = None) -> shakedown.Problem:
    problem = shakedown.example(name)
    return problem if f is None else replace(problem, f=f)


def rows_of(problem: shakedown.Problem):
    """Rows and loads written out again from the friction law, for a second method."""
    loop, f = loading(problem), problem.f
    G = np.vstack([problem.A - f[:, None] * problem.B, -problem.A - f[:, None] * problem.B])
    g = np.concatenate([f * loop.p0 - loop.q0, f * loop.p0 + loop.q0])
    S = np.vstack([(loop.q1 - f * loop.p1).T, (-loop.q1 - f * loop.p1).T])
    return G, g, S


def greatest(problem, load_factor, direction, active, box=None, nested=True):
    """Greatest direction · v over admissible states with one limit active, by SciPy; None where there is none."""
    (G, g, S), n = rows_of(problem), problem.n
    k = S.shape[1]
    share = np.append(np.zeros(n), np.ones(k))
    matrix, right = np.column_stack([G, S]), g
    equal, equal_to = matrix[[active]], g[[active]]
    if nested:
        matrix, right = np.vstack([matrix, share]), np.append(g, load_factor)
    else:
        equal, equal_to = np.vstack([equal, share]), np.append(equal_to, load_factor)
    sides = [(None, None)] * n if box is None else list(zip(*box, strict=True))
    found = linprog(
        -np.append(direction, np.zeros(k)), matrix, right, equal, equal_to, bounds=sides + [(0, None)] * k
    )
    assert found.status in (0, 2, 3)
    return {2: None, 3: np.inf}[found.status] if found.status else -found.fun


@pytest.mark.parametrize(("name", "f", "expected"), PRESSURES)
def test_least_pressures_of_built_in_joints(name, f, expected):
    assert least_pressure_bound(built_in(name, f)).load_factor == pytest.approx(expected, abs=6e-8)


@pytest.mark.parametrize("n", [1, 2, 4])
@pytest.mark.parametrize("floating", [False, True])
def test_without_coupling_it_is_the_largest_load_factor(n, floating):
    if n == 1 and floating:
        return
    rng = np.random.default_rng(n)
    root = rng.normal(size=(n, n))
    A = root @ root.T + np.eye(n)
    if floating:
        rigid = np.ones(n) / np.sqrt(n)
        A = (np.eye(n) - np.outer(rigid, rigid)) @ A @ (np.eye(n) - np.outer(rigid, rigid))
    problem = shakedown.Problem(
        A=A, B=np.zeros((n, n)), f=0.5, q_w=rng.normal(size=(6, n)), p_w=4 + rng.normal(size=(6, n))
    )
    upper = shakedown.upper_bound(problem).load_factor
    assert least_pressure_bound(problem).load_factor == pytest.approx(upper, rel=1e-8)
    bound = shakedown.universal_bound(problem)
    assert (bound.argument, bound.limited_by) == ("Melan", "first collapse")
    assert bound.load_factor == pytest.approx(upper, rel=1e-12)


def test_rigid_motion_limits_a_floating_body():
    """Each node alone could bear λ = 1; both together slide where 1.6 + 2 λ exceeds the friction 2 + 1."""
    A = np.array([[1.0, -1.0], [-1.0, 1.0]])
    q = 0.8 + np.array([[1.0, 1.0], [-1.0, -1.0]])
    problem = shakedown.Problem(A=A, B=np.zeros((2, 2)), f=[0.5, 0.25], q_w=q, p_w=np.full((2, 2), 4.0))
    assert least_pressure_bound(problem).load_factor == pytest.approx(0.7)


@pytest.mark.parametrize(
    ("name", "f", "argument"),
    [
        ("one-node", None, "first collapse"),
        ("two-node", None, "first collapse"),
        ("uncoupled", None, "Melan"),
        ("block-9", 0.1, "first collapse"),
        ("block-33", 0.2, "first collapse"),
        ("press-fit", None, "first collapse"),
    ],
)
def test_complete_arguments_reach_the_first_collapse(name, f, argument):
    bound = shakedown.universal_bound(built_in(name, f))
    assert (bound.argument, bound.load_factor) == (argument, bound.first_collapse)


def test_lifted_nodes_and_missing_safe_states_leave_nothing():
    lifted = shakedown.universal_bound(built_in("block-9", 0.5))
    assert (lifted.status, lifted.load_factor, lifted.limited_by) == ("optimal", 0.0, "first collapse")
    assert "some locked-in slip lifts node " in lifted.reason
    none = shakedown.universal_bound(shakedown.example("receding-block"))
    assert none.status == "infeasible"
    assert np.isnan(none.load_factor)


def test_nothing_is_proved_where_the_motion_may_jump():
    """Friction between the thresholds of the set of both nodes and of each alone; λ_1 > 0 all the same."""
    problem = shakedown.Problem(
        A=[[1.0, 0.9, 0.0], [0.9, 1.0, 0.0], [0.0, 0.0, 1.0]],
        B=[[0.0, 0.4, 0.0], [-0.4, 0.0, 0.0], [0.0, 0.0, 0.0]],
        f=0.9,
        q_w=[[0.1, 0.0, 0.0], [-0.1, 0.0, 0.1]],
        p_w=np.full((2, 3), 2.0),
    )
    bound = shakedown.universal_bound(problem)
    assert (bound.load_factor, bound.argument) == (0.0, "none")
    assert bound.limited_by in ("uniqueness", "first collapse")


def first_swing(problem: shakedown.Problem) -> float:
    """The least load factor of two states, the one that slips forward at no smaller (A v)_i, by SciPy."""
    (G, g, S), n = rows_of(problem), problem.n
    k = S.shape[1]
    half, empty, share = np.hstack([G, S]), np.zeros((2 * n, n + k)), np.append(np.zeros(n), np.ones(k))
    limits = [np.hstack([half, empty]), np.hstack([empty, half])]
    shares = [np.append(share, 0 * share), np.append(0 * share, share)]
    least = [np.inf]
    for i in range(n):
        swing = np.concatenate([-problem.A[i], np.zeros(k), problem.A[i], np.zeros(k)])
        matrix = np.column_stack([np.vstack([*limits, *shares, swing]), np.zeros(4 * n + 3)])
        matrix[4 * n : 4 * n + 2, -1] = -1.0
        right = np.concatenate([g, g, np.zeros(3)])
        equal = [n + i, 2 * n + i]
        end = linprog(
            np.append(np.zeros(2 * (n + k)), 1.0),
            matrix,
            right,
            matrix[equal],
            right[equal],
            bounds=2 * ([(None, None)] * n + [(0, None)] * k) + [(0, None)],
        )
        assert end.status in (0, 2)
        least.append(end.fun if end.status == 0 else np.inf)
    return min(least)


def holds_rigidly(problem: shakedown.Problem, load_factor: float) -> bool:
    """Whether some z = A w lies between (A v)_i of forward and of backward slip at every node, by SciPy."""
    n = problem.n
    highest = [greatest(problem, load_factor, problem.A[i], n + i) for i in range(n)]
    lowest = [greatest(problem, load_factor, -problem.A[i], i) for i in range(n)]
    rows = [-problem.A[i] for i in range(n) if highest[i] is not None]
    rows += [problem.A[i] for i in range(n) if lowest[i] is not None]
    right = [-x for x in highest + lowest if x is not None]
    if not rows:
        return True
    return linprog(np.zeros(n), np.array(rows), right, bounds=[(None, None)] * n).status == 0


RIGID = {
    "A": [[1.0, -1.0], [-1.0, 1.0]],
    "B": [[-0.2, 0.2], [0.35, -0.35]],
    "C": 20 * np.eye(2),
    "f": 0.5,
    "q_w": [[0.1, 0.0], [-0.1, 0.2], [0.3, -0.2], [0.0, 0.1]],
    "p_w": [[1.0, 1.2], [1.2, 0.8], [0.9, 1.0], [1.0, 1.1]],
}


LIFTED = ("cyclic", "separation")  # forward and backward slip of their only node are no states at all


def hard_joints():
    """Nodes that may lift off, rigid motions, and stiffnesses that are nearly singular."""
    yield "cyclic", shakedown.example("one-node-cyclic")
    yield "separation", shakedown.example("one-node-separation")
    yield "rigid", shakedown.Problem(**RIGID)
    for seed in range(6):
        problem = joint(seed, n=3, m=5)
        values, vectors = np.linalg.eigh(problem.A)
        for name, least in (("floating", 0.0), ("nearly floating", 1e-4 * values[-1])):
            rigid = vectors[:, 0]
            A = (vectors[:, 1:] * values[1:]) @ vectors[:, 1:].T + least * np.outer(rigid, rigid)
            B = problem.B - np.outer(problem.B @ rigid, rigid)
            size = 20 * np.abs(problem.A).max() * np.eye(3)
            yield f"{name} {seed}", replace(problem, A=(A + A.T) / 2, B=B, C=size)


@pytest.mark.parametrize(
    ("name", "problem"), list(hard_joints()), ids=lambda x: x if isinstance(x, str) else ""
)
def test_never_beyond_two_states_that_slip_both_ways(name, problem):
    """Nor is anything lost of a body that is held; of one that floats some z = A w lies between all of them."""
    found, expected = least_pressure_bound(problem, unique=True), first_swing(problem)
    assert found.load_factor <= expected * (1 + 1e-9)
    if found.floats:
        assert holds_rigidly(problem, (1 - 1e-6) * found.load_factor)
    elif name not in LIFTED:
        assert found.load_factor == pytest.approx(expected, rel=1e-6)
