"""Long-term states: cited values, period two, slow approach, ratchetting; plain simulation and the search in space."""

import numpy as np
import pytest
from joints import walking
from joints_in_space import embedded

import shakedown
from shakedown.ground.constants import MANY_ROWS
from shakedown.ground.status import Outcome
from shakedown.long_term.motion_start import MotionStart
from shakedown.long_term.space.followed_cycles import SearchRules, product
from shakedown.long_term.space.steady_search import SteadySearch
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import Evolution
from tests.joints import FAMILY, member, slow_problem


def plain(problem, load_factor, start, cycles):
    """Slips at the ends of cycles, followed without any extrapolation."""
    evolution, slips = Evolution(problem, load_factor, start), []
    for _ in range(cycles):
        assert evolution.cycle() is not None
        slips.append(evolution.state.u[problem.layout.slips].copy())
    return np.array(slips)


@pytest.mark.parametrize("case", FAMILY)
def test_period_two_is_recognised(case):
    *data, load_factor, start = case
    problem = member(*data)
    state = shakedown.long_term_state(problem, load_factor, start)
    assert (state.outcome, state.period) == ("cyclic-slip", 2)
    first, second = state.dissipations
    assert abs(first - second) > 0.1 * max(first, second)
    slips = plain(problem, load_factor, start, 200)
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


@pytest.mark.parametrize("put", [lambda plane: plane, embedded], ids=["plane", "space"])
def test_a_floating_body_ratchets(put):
    """By 2 (λ |q| − f p) with the smaller pressure, one node after the other."""
    problem = put(walking())
    state = shakedown.long_term_state(problem, 1.0)
    slips = plain(problem, 1.0, None, 50)
    assert state.outcome == "ratchetting"
    assert state.drift == pytest.approx(slips[-1] - slips[-2], rel=1e-6)
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


def test_a_joint_whose_moving_nodes_nothing_holds_is_undecided():
    joint = shakedown.Problem(A=[[0.0]], B=[[0.0]], f=0.0, q_w=[[1.0], [-1.0]], p_w=[[1.0], [1.0]])
    one, again = (shakedown.long_term_state(joint, 1.0) for _ in range(2))
    assert one.outcome == "undecided"
    assert "moving nodes are not held" in one.reason
    assert again.reason == one.reason
    assert shakedown.long_term_states(joint, 1.0, [[0.0], [1.0]]).outcome.tolist() == ["undecided"] * 2
    run = shakedown.simulate(joint, 1.0)
    assert run.outcome == "undecided"
    assert not run.cycles.records
    runs = shakedown.verify(joint).runs
    assert runs
    assert all(run.simulation.outcome == "undecided" for run in runs)


def settled(
    problem: shakedown.Problem, load_factor: float, start: np.ndarray | None
) -> shakedown.LongTermState:
    """What the search finds."""
    motion = Evolution(problem, load_factor, start)
    length = motion.scale.length
    rules = SearchRules(1000, 8, 1e-10 * length, np.ones(problem.n))
    return SteadySearch(motion, MotionStart.of(motion), rules).run()


@pytest.mark.parametrize("name", ["two-node", "three-node", "block-9", "press-fit", "uncoupled"])
def test_the_search_finds_the_exact_long_term_state(name):
    problem, rng = shakedown.example(name), np.random.default_rng(0)
    largest = shakedown.upper_bound(problem).load_factor
    for share in (0.7, 0.95, 0.999, 1.001, 1.05, 1.3):
        for size in (0.0, 0.03):
            scale = scales(problem, share * largest)
            start = size * scale.length * rng.normal(size=problem.n)
            exact = shakedown.long_term_state(problem, share * largest, start)
            found = settled(problem, share * largest, start)
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
    np.testing.assert_allclose(product(root, changes), changes @ root.T, rtol=0.0, atol=1e-12)
