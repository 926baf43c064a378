"""Long-term states: cited values, period two, slow approach, ratchetting; plain simulation and the search in space.

The thesis's time integration: verdicts against the bounds, the friction law, states exactly on limits.
"""

import numpy as np
import pytest
from joints import FAMILY, member, slow_problem, walking
from joints_in_space import embedded

import shakedown
from shakedown import Outcome, Problem, simulate
from shakedown.ground.constants import MANY_ROWS
from shakedown.long_term.motion_start import MotionStart
from shakedown.long_term.simulation import recorded_verdict
from shakedown.long_term.space.followed_cycles import SearchRules, product
from shakedown.long_term.space.steady_search import SteadySearch
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import Evolution, evolve


def plain(problem, load_factor, start, cycles):
    """Slips at the ends of cycles, followed without any extrapolation."""
    evolution, slips = Evolution(problem, load_factor, start), []
    for _ in range(cycles):
        assert evolution.cycle() is not None
        slips.append(evolution.state.u[problem.layout.slips].copy())
    return np.array(slips)


SIDES = pytest.mark.parametrize("put", [lambda plane: plane, embedded], ids=["plane", "space"])


@SIDES
@pytest.mark.parametrize("case", FAMILY)
def test_period_two_is_recognised(case, put):
    *data, load_factor, start = case
    problem = put(member(*data))
    start = np.kron(start, [1.0, 0.0][: problem.directions])
    state = shakedown.long_term_state(problem, load_factor, start)
    assert (state.outcome, state.period) == ("cyclic-slip", 2)
    first, second = state.dissipations
    assert abs(first - second) > 0.1 * max(first, second)
    slips = plain(problem, load_factor, start, 200)
    steps = np.linalg.norm(slips[2:] - slips[:-2], axis=1)
    assert state.contraction == pytest.approx(np.sqrt(steps[8] / steps[6]), rel=1e-3)
    assert np.abs(slips[-1] - slips[-3]).max() <= 1e-9
    assert np.abs(slips[-1] - slips[-2]).max() > 0.01
    distance = np.abs(slips[-2:] - state.final_slip).max(axis=1).min()
    assert distance <= 1e-9


@pytest.mark.parametrize("ratio", [0.9, 0.992, 0.9999])
def test_slow_approach_is_decided_in_a_handful_of_cycles(ratio):
    problem = slow_problem(ratio)
    state = shakedown.long_term_state(problem, 0.9)
    assert state.outcome == "shakedown"
    assert state.contraction == pytest.approx(ratio, rel=1e-9)
    assert state.cycles_simulated <= 60
    if ratio < 0.95:
        assert plain(problem, 0.9, None, 400)[-1] == pytest.approx(state.final_slip, rel=1e-9)


@SIDES
def test_a_floating_body_ratchets(put):
    """By 2 (λ |q| − f p) with the smaller pressure, one node after the other."""
    problem = put(walking())
    state = shakedown.long_term_state(problem, 1.0)
    slips = plain(problem, 1.0, None, 50)
    assert state.outcome == "ratchetting"
    assert state.drift == pytest.approx(slips[-1] - slips[-2], rel=1e-6)
    assert state.return_error <= 1e-9
    accuracy = 1e-12 if problem.directions == 1 else 1e-9
    assert np.ptp(state.drift[:: problem.directions]) == pytest.approx(0.0, abs=accuracy)
    assert np.abs(state.drift[:: problem.directions]) == pytest.approx(0.8)


@pytest.mark.parametrize("name", ["two-node", "one-node", "block-9", "block-33"])
@pytest.mark.parametrize("load_factor", [0.4, 1.1, 3.0, 8.0])
def test_agrees_with_plain_simulation(name, load_factor):
    problem = shakedown.example(name)
    state = shakedown.long_term_state(problem, load_factor)
    slips = plain(problem, load_factor, None, 60)
    scale = np.abs(slips).max(initial=1e-300)
    assert np.abs(slips[-1] - state.final_slip).max() <= 1e-9 * scale
    assert state.residual <= 1e-12
    assert state.return_error <= 1e-10
    first = 2 + np.flatnonzero(np.abs(np.diff(slips, axis=0)).max(axis=1) <= 1e-9 * scale)[0]
    assert state.reason.startswith(f"cycle {first} repeats cycle {first - 1}")


def test_a_joint_whose_moving_nodes_nothing_holds_is_undecided():
    joint = shakedown.Problem(A=[[0.0]], B=[[0.0]], f=0.0, q_w=[[1.0], [-1.0]], p_w=[[1.0], [1.0]])
    one, again = (shakedown.long_term_state(joint, 1.0) for _ in range(2))
    assert one.outcome == "undecided"
    assert "moving nodes are not held" in one.reason
    assert again.reason == one.reason
    assert shakedown.long_term_states(joint, 1.0, [[0.0], [1.0]]).outcome.tolist() == ["undecided"] * 2
    run = shakedown.simulate(joint, 1.0, record=True)
    assert run.outcome == "undecided"
    assert not run.cycles.records
    assert not len(run.history)
    runs = shakedown.verify(joint).runs
    assert runs
    assert all(run.simulation.outcome == "undecided" for run in runs)


@pytest.mark.parametrize("name", ["two-node", "three-node", "block-9", "press-fit", "uncoupled"])
def test_the_search_finds_the_exact_long_term_state(name):
    problem, rng = shakedown.example(name), np.random.default_rng(0)
    largest = shakedown.upper_bound(problem).load_factor
    for share in (0.7, 0.95, 0.999, 1.001, 1.05, 1.3):
        for size in (0.0, 0.03):
            scale = scales(problem, share * largest)
            start = size * scale.length * rng.normal(size=problem.n)
            exact = shakedown.long_term_state(problem, share * largest, start)
            motion = Evolution(problem, share * largest, start)
            rules = SearchRules(1000, 8, 1e-10 * scale.length, np.ones(problem.n))
            found = SteadySearch(motion, MotionStart.of(motion), rules).run()
            assert found.outcome == exact.outcome, found.reason
            apart = np.abs(found.final_slip - exact.final_slip).max()
            assert apart <= min(3 * found.error, 1e-7 * scale.length)
            if exact.outcome == Outcome.CYCLIC_SLIP:
                assert found.period == exact.period
                off = 8 * problem.n * scale.force * found.error
                assert found.dissipation_per_cycle == pytest.approx(exact.dissipation_per_cycle, abs=off)


@pytest.mark.parametrize("moved", [[], [3], [3, 90], range(40, 90), range(10, 118)])
def test_products_of_the_places_that_change_are_whole_products(moved):
    rng, changes = np.random.default_rng(0), np.zeros((3, 120))
    root, places = rng.normal(size=(MANY_ROWS + 1, 120)), list(moved)
    changes[:, places] = rng.normal(size=(3, len(places)))
    for change in (changes, changes[0]):
        np.testing.assert_allclose(product(root, change), change @ root.T, rtol=0.0, atol=1e-12)


TWO_NODE = shakedown.example("two-node")
LOWER, UPPER = shakedown.lower_bound(TWO_NODE), shakedown.upper_bound(TWO_NODE)
METHODS = pytest.mark.parametrize("method", ["event", "gauss-seidel"])
STARTS = UPPER.slip + 3.0 * np.random.default_rng(1).uniform(-1, 1, (8, 2))


@METHODS
@pytest.mark.parametrize("start", STARTS, ids=str)
def test_every_start_shakes_down_below_the_lower_bound_and_none_above_the_upper(start, method):
    below, above = (simulate(TWO_NODE, load_factor, start, method=method) for load_factor in (0.657, 0.7395))
    assert below.outcome == Outcome.SHAKEDOWN
    assert above.outcome == Outcome.CYCLIC_SLIP
    assert above.dissipation_per_cycle > 0


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
    ({"q_w": [[0.0]] * 2, "p_w": [[1.0], [-0.5]]}, Outcome.SEPARATION, (), [0.0], "closing every cycle: node 0"),
    (BESIDE, Outcome.CYCLIC_SLIP, (1,), [2.0, 0.0], ""),
    ({"p_w": [[-1.0]], "C": None}, Outcome.UNDECIDED, (), [np.nan], "lifts off"),
]  # fmt: skip


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
