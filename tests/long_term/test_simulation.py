"""The thesis's time integration: verdicts against the bounds, the friction law, states exactly on limits."""

import numpy as np
import pytest
from joints import FAMILY, member

import shakedown
from shakedown import Outcome, Problem, simulate
from shakedown.long_term.simulation import recorded_verdict
from shakedown.motion.evolution import evolve

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


def one_node(**changes):
    arrays = {"A": [[1.0]], "B": [[0.0]], "C": [[1.0]], "f": 0.5, "q_w": [[0.0]], "p_w": [[1.0]]}
    return Problem(**{**arrays, **changes})


BESIDE = {
    "A": np.eye(2), "B": np.zeros((2, 2)), "C": np.eye(2),
    "q_w": [[1.0, 0.0], [-1.0, 0.0]], "p_w": [[1.0, -1.0], [1.0, -1.0]],
}  # fmt: skip
LIFTED = [  # changes of the node, outcome, nodes that stay open, slip per cycle, what is said
    ({"p_w": [[-1.0]]}, Outcome.SHAKEDOWN, (0,), [0.0], ""),
    (
        {"q_w": [[0.0]] * 2, "p_w": [[1.0], [-0.5]]},
        Outcome.SEPARATION,
        (),
        [0.0],
        "closing every cycle: node 0",
    ),
    (BESIDE, Outcome.CYCLIC_SLIP, (1,), [2.0, 0.0], ""),
    ({"p_w": [[-1.0]], "C": None}, Outcome.UNDECIDED, (), [np.nan], "lifts off"),
]


@METHODS
@pytest.mark.parametrize(("changes", "outcome", "stays_open", "slip", "said"), LIFTED, ids=str)
def test_what_nodes_that_open_are_called(changes, outcome, stays_open, slip, said, method):
    run = simulate(one_node(**changes), 1.0, method=method)
    assert (run.outcome, run.open_nodes) == (outcome, stays_open)
    assert run.slip_per_cycle == pytest.approx(slip, nan_ok=True)
    assert said in run.reason
    if stays_open:
        assert run.cycles.open_nodes[-1].nonzero()[0].tolist() == list(stays_open)
        assert not run.proved


def test_what_is_over_decides_nothing():
    still, breathing = (
        evolve(one_node(q_w=[[0.0]] * 2, p_w=[[1.0], [last]]), 1.0, cycles=2).cycles for last in (0.5, -0.5)
    )
    assert recorded_verdict([*breathing, *still], np.ones(1))[0] == Outcome.SHAKEDOWN
    assert recorded_verdict([*still, *breathing], np.ones(1))[0] == Outcome.SEPARATION


@METHODS
@pytest.mark.parametrize("case", FAMILY)
def test_a_period_of_two_cycles_is_that_of_the_long_term_state(case, method):
    *data, load_factor, start = case
    run = simulate(member(*data), load_factor, start, method=method)
    state = shakedown.long_term_state(member(*data), load_factor, start)
    assert (run.outcome, run.period) == (state.outcome, 2)
    assert run.slip_per_cycle == pytest.approx(state.slip_per_cycle, rel=1e-6)
    near = 1e-9 if method == "event" else 0.03  # a load step that begins to slip has the reaction of its end
    assert run.dissipation_per_cycle == pytest.approx(state.dissipation_per_cycle, rel=near)
    assert shakedown.node_results(run).work.sum() == pytest.approx(run.dissipation_per_cycle, rel=1e-9)


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
