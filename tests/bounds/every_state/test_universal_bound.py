"""The load factor up to which shakedown from every initial state is proved."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
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
