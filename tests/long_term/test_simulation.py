"""The thesis's time integration: verdicts against the bounds, the friction law, states exactly on limits."""

import dataclasses

import numpy as np
import pytest

import shakedown
from shakedown import Outcome, Problem, simulate
from shakedown.joint.constraints import loading

TWO_NODE = shakedown.example("two-node")
LOWER, UPPER = shakedown.lower_bound(TWO_NODE), shakedown.upper_bound(TWO_NODE)


METHODS = pytest.mark.parametrize("method", ["event", "gauss-seidel"])


def random_starts(count, seed):
    generator = np.random.default_rng(seed)
    return UPPER.slip + 3.0 * generator.uniform(-1, 1, (count, 2))


@METHODS
@pytest.mark.parametrize("start", random_starts(4, 1), ids=str)
def test_every_start_shakes_down_below_the_lower_bound(start, method):
    assert simulate(TWO_NODE, 0.657, start, method=method).outcome == Outcome.SHAKEDOWN


@METHODS
@pytest.mark.parametrize("start", random_starts(4, 2), ids=str)
def test_no_start_shakes_down_above_the_upper_bound(start, method):
    run = simulate(TWO_NODE, 0.7395, start, method=method)
    assert run.outcome == Outcome.CYCLIC_SLIP
    assert run.dissipation_per_cycle > 0


@METHODS
def test_between_the_bounds_the_start_decides(method):
    safe = shakedown.safe_slip(TWO_NODE, 0.70).slip
    assert simulate(TWO_NODE, 0.70, safe, method=method).slip_per_cycle.max() == 0.0
    witness = simulate(TWO_NODE, 0.70, LOWER.slip, method=method)
    assert witness.outcome == Outcome.CYCLIC_SLIP
    assert witness.slip_per_cycle[LOWER.node] > 0.1


@METHODS
@pytest.mark.parametrize(("load_factor", "slip"), [(2.44, 0.0), (2.4443, 4.073525), (2.6, 3.854489)], ids=str)
def test_the_counter_example_cycles_below_the_first_collapse(load_factor, slip, method):
    problem = shakedown.example("three-node")
    run = simulate(problem, load_factor, problem.initial_slip[0], method=method)
    assert run.outcome == (Outcome.CYCLIC_SLIP if slip else Outcome.SHAKEDOWN)
    assert run.slip_per_cycle == pytest.approx([slip, 0.0, 0.0], abs=5e-7)
    assert (run.period, run.residual <= 1e-12) == (1, True)
    assert load_factor < shakedown.lower_bound(problem).load_factor


def test_dissipation_approaches_the_work_of_the_loading():
    """In a limit cycle friction dissipates what the loading puts in, ∮ v · dq_w; fixed steps get there slowly.

    The work comes from the slips at the load steps alone, by the trapezoidal rule.
    """
    errors = []
    for m in (50, 100, 200):
        problem = sampled_two_node(m)
        run = simulate(problem, 0.8, record=True, method="gauss-seidel")
        assert run.outcome == Outcome.CYCLIC_SLIP
        v = np.vstack([run.history.v[-m - 1 :]])
        q_w = np.roll(loading(problem).at(0.8)[0], 1, axis=0)
        steps = np.diff(np.vstack([q_w, q_w[:1]]), axis=0)
        work = ((v[1:] + v[:-1]) / 2 * steps).sum()
        errors.append(abs(run.dissipation_per_cycle / work - 1))
    assert errors[0] < 0.1
    assert errors[2] < 0.35 * errors[0]


@pytest.mark.parametrize(("name", "load_factor"), [("two-node", 0.72), ("three-node", 3.0), ("block-9", 8.0)])
def test_the_friction_law_holds_at_every_load_step(name, load_factor):
    """Written apart from the package: reactions from the stiffness, slip from the change of v."""
    problem = shakedown.example(name)
    run = simulate(problem, load_factor, record=True, method="gauss-seidel")
    v, w, loop = run.history.v, run.history.w, loading(problem)
    periods = (len(v) // problem.m, 1)
    q_w, p_w = (
        np.tile(loop.q0 + load_factor * loop.q1, periods),
        np.tile(loop.p0 + load_factor * loop.p1, periods),
    )
    q, p = q_w + v @ problem.A + w @ problem.B, p_w + v @ problem.B.T + w @ problem.C
    force = max(np.abs(q_w).max(), np.abs(p_w).max())
    length = force / np.diag(problem.A).min()
    limit, moved = problem.f * p, np.diff(v, axis=0, prepend=run.initial_slip[None])
    was_open = np.vstack([np.zeros((1, problem.n)), w[:-1]]) > 0
    is_open, still = w > 1e-12 * length, was_open | (np.abs(moved) <= 1e-10 * length)
    off = np.where(still, np.maximum(np.abs(q) - limit, -p), np.abs(q + np.sign(moved) * limit))
    off = np.where(is_open, np.maximum(np.abs(q), np.abs(p)), off)
    assert run.outcome != Outcome.UNDECIDED
    assert run.residual <= 1e-12
    assert (~still).any()
    assert off.max() <= 1e-11 * force
    assert w.min() >= -1e-11 * length


def sampled_two_node(m):
    """The two-node system with m load steps, in contact."""
    t = np.arange(m) / m
    q = [15.8 + 200 * np.cos(2 * np.pi * (t - 0.05)), -400 + 700 * np.cos(2 * np.pi * (t + 0.125))]
    p = [588.5 + 150 * np.sin(2 * np.pi * t), 1300 + 300 * np.sin(2 * np.pi * t)]
    return dataclasses.replace(TWO_NODE, C=None, q_w=np.column_stack(q), p_w=np.column_stack(p))


def one_node(**changes):
    arrays = {"A": [[1.0]], "B": [[0.0]], "C": [[1.0]], "f": 0.5, "q_w": [[0.0]], "p_w": [[1.0]]}
    return Problem(**{**arrays, **changes})


@METHODS
def test_a_node_that_stays_open_is_listed(method):
    run = simulate(one_node(p_w=[[-1.0]]), 1.0, method=method)
    assert (run.outcome, run.open_nodes) == (Outcome.SHAKEDOWN, (0,))
    assert run.cycles.open_nodes[-1, 0]
    assert not run.proved


@METHODS
def test_a_node_that_opens_and_closes_is_separation(method):
    run = simulate(one_node(q_w=[[0.0], [0.0]], p_w=[[1.0], [-0.5]]), 1.0, method=method)
    assert (run.outcome, run.open_nodes) == (Outcome.SEPARATION, ())
    assert "opening and closing every cycle: node 0" in run.reason


@METHODS
def test_slip_beside_a_node_that_stays_open(method):
    problem = Problem(
        A=np.eye(2), B=np.zeros((2, 2)), C=np.eye(2), f=0.5,
        q_w=[[1.0, 0.0], [-1.0, 0.0]], p_w=[[1.0, -1.0], [1.0, -1.0]],
    )  # fmt: skip
    run = simulate(problem, 1.0, method=method)
    assert (run.outcome, run.open_nodes) == (Outcome.CYCLIC_SLIP, (1,))
    assert run.slip_per_cycle == pytest.approx([2.0, 0.0])


@METHODS
def test_without_c_a_node_that_lifts_off_leaves_the_run_undecided(method):
    run = simulate(one_node(p_w=[[-1.0]], C=None), 1.0, method=method)
    assert run.outcome == Outcome.UNDECIDED
    assert "lifts off" in run.reason


@METHODS
def test_too_few_cycles_leave_the_run_undecided(method):
    run = simulate(TWO_NODE, 0.8, LOWER.slip, cycles=1, method=method, slip_below=1.0)
    assert run.outcome == Outcome.UNDECIDED
    assert run.slip_criterion.met is None
    assert np.isnan(run.slip_criterion.largest)
    assert run.period == 0
    assert np.isnan(run.drift).all()


def test_the_transient_runs_first_and_is_not_scaled():
    problem = one_node(q_w=[[0.0], [0.0]], p_w=[[1.0], [1.0]], q_transient=[[-2.0]], p_transient=[[1.0]])
    run = simulate(problem, 7.0, record=True, method="gauss-seidel")
    assert run.history.cycle[0] < 0
    assert run.cycles.end_slip[0] == pytest.approx([1.5])
    assert run.final_slip == pytest.approx([0.5])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"load_factor": -1.0}, "load factor: expected a finite number >= 0, found -1"),
        ({"load_factor": np.nan}, "load factor"),
        ({"load_factor": 1.0, "initial_slip": [0.0]}, r"expected shape \(2,\), found \(1,\)"),
        ({"load_factor": 1.0, "initial_slip": [0.0, np.inf]}, "finite"),
        ({"load_factor": 1.0, "cycles": 0}, "cycles: expected a whole number >= 1"),
        ({"load_factor": 1.0, "cycles": 2.5}, "cycles: expected a whole number, found 2.5"),
        ({"load_factor": 1.0, "method": "euler"}, "method"),
    ],
    ids=str,
)
def test_misuse_is_refused(arguments, message):
    with pytest.raises(shakedown.UsageError, match=message):
        simulate(TWO_NODE, **arguments)
