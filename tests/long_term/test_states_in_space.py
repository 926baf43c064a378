"""Long-term states with two tangential directions."""

import numpy as np
import pytest

import shakedown
from benchmarks.problems import in_units
from benchmarks.space_verdicts import random_joint
from shakedown import Outcome, Problem, Tolerances
from shakedown.joint.constraints import slip_reach
from shakedown.long_term.motion_start import MotionStart
from shakedown.long_term.space.followed_cycles import SearchRules, is_held
from shakedown.long_term.space.steady_search import SteadySearch
from shakedown.motion.evolution import Evolution

CREEPING = np.array([0.32, 0.32, -0.24, -0.24, 0.38, -0.33, 0.33, -0.07])


@pytest.mark.parametrize("name", ["one-node-3d", "two-node-3d", "four-node-3d"])
@pytest.mark.parametrize("share", [0.97, 1.1])
def test_the_error_is_that_of_a_finer_path(name, share):
    problem, rng = shakedown.example(name), np.random.default_rng(3)
    load_factor = share * shakedown.upper_bound(problem).load_factor
    start = 0.3 * rng.normal(size=2 * problem.n) * slip_reach(problem, load_factor)
    found = shakedown.long_term_state(problem, load_factor, start)
    fine = shakedown.long_term_state(problem, load_factor, start, tolerances=Tolerances(path=1e-11))
    assert found.outcome == fine.outcome
    assert np.abs(found.final_slip - fine.final_slip).max() <= 10 * found.error
    assert found.dissipation_per_cycle == pytest.approx(fine.dissipation_per_cycle, rel=1e-5, abs=1e-7)
    motion = Evolution(problem, load_factor, start)
    ends = [motion.cycle().end_slip for _ in range(found.cycles_simulated)]
    before, last = np.linalg.norm(np.diff(ends[-3:], axis=0), axis=1)
    assert last == pytest.approx(found.contraction * before, rel=1e-3, abs=1e-12)
    assert (found.contraction == 0.0) == (last == 0.0)


def test_a_motion_goes_on_from_the_cycles_that_are_stored():
    problem = shakedown.example("two-node-3d")
    state = shakedown.long_term_state(problem, 1.1 * shakedown.upper_bound(problem).load_factor)
    whole, kept = (state.origin.passed(first, 8) for first in (None, state.first_cycles[:4]))
    for one, other in zip(whole, kept, strict=True):
        np.testing.assert_array_equal(one[1], other[1])
        assert (one[0], *one[2:]) == (other[0], *other[2:])


@pytest.mark.parametrize("period", [1, 2, 3, 5])
def test_the_period_is_the_least_after_which_changes_recur(period):
    problem = shakedown.example("two-node-3d")
    motion, changes = Evolution(problem, 1.0), np.random.default_rng(1).normal(size=(period, 6))
    search = SteadySearch(motion, MotionStart.of(motion), SearchRules(100, 8, 1e-10, np.ones(2)))
    search.leaps.find_period(np.cumsum(changes[np.arange(9) % period], axis=0))
    assert search.leaps.period == period


def test_an_approach_like_a_power_of_time_is_no_drift():
    """Node 0 slips less and less, 1/k^1.5 in cycle k, while node 1 cycles."""
    problem = shakedown.example("four-node-3d")
    load_factor = 1.3 * shakedown.upper_bound(problem).load_factor
    start = CREEPING * slip_reach(problem, load_factor)
    found = shakedown.long_term_state(problem, load_factor, start, max_cycles=1000)
    assert found.outcome == Outcome.CYCLIC_SLIP
    assert found.contraction > 0.98
    later = shakedown.long_term_state(problem, load_factor, start, max_cycles=1500)
    assert np.abs(later.final_slip - found.final_slip).max() < found.error


@pytest.mark.parametrize(("load_factor", "outcome"), [(1.249625, "shakedown"), (1.24963, "cyclic-slip")])
def test_a_slow_approach_ends_where_plain_cycles_do(load_factor, outcome):
    """Next to the change from one outcome to the other 800 cycles settle what leaps settle in a fifth of them."""
    problem = shakedown.example("one-node-3d")
    found, alone = (shakedown.long_term_state(problem, load_factor, longest_period=most) for most in (8, 1))
    assert (found.cycles_simulated, found.error) == (alone.cycles_simulated, alone.error)
    plain = Evolution(problem, load_factor)
    plain.advance(800)
    last = plain.cycle()
    assert found.outcome == outcome
    assert found.cycles_simulated < 200
    assert np.abs(found.final_slip - last.end_slip).max() < min(found.error, 1e-6)
    np.testing.assert_allclose(found.slip_per_cycle, last.slip, rtol=1e-3, atol=1e-9)


def test_next_to_the_end_of_shakedown_the_slip_grows_in_proportion_to_what_the_load_exceeds():
    """Down to 5e-8 per cycle, where changes are far below the accuracy of a path: a thousand cycles told nothing."""
    problem = shakedown.example("one-node-3d")
    load_factors = 1.249627, 1.2496275, 1.249628
    found = [shakedown.long_term_state(problem, load_factor) for load_factor in load_factors]
    slips = [float(state.slip_per_cycle[0]) for state in found]
    assert {state.outcome for state in found} == {Outcome.CYCLIC_SLIP}
    assert max(state.cycles_simulated for state in found) < 400  # of two searches: the first leaves more open
    assert slips[0] == pytest.approx(2 * slips[1] - slips[2], rel=0.05)


def test_a_slow_departure_is_followed_to_its_end():
    """From slip zero two-node-3d comes near a state that it leaves again, for 10,000 cycles."""
    found = shakedown.long_term_state(shakedown.example("two-node-3d"), 0.837368621)
    assert found.outcome == Outcome.CYCLIC_SLIP
    assert found.slip_per_cycle.max() == pytest.approx(5.08883e-4, rel=1e-3)  # after 20,000 plain cycles


def test_a_departure_below_the_accuracy_is_no_rest():
    """Its slips begin at 1e-8 a cycle, below what a cycle may miss, and grow by 0.7 % from one to the next."""
    node = Problem(
        A=[[1.2167, -0.3562], [-0.3562, 0.3091]], B=[[0.286, -0.2226]], C=[[0.3952]], f=0.3366,
        q_w=[[-0.5315, 0.297], [-0.9665, -0.3876], [-0.7912, -0.2552]], p_w=[[4.0534], [3.5187], [3.9709]],
    )  # fmt: skip
    found = shakedown.long_term_state(node, 3.014891928, [-0.1021, -0.0596], max_cycles=3000)
    assert found.outcome == Outcome.CYCLIC_SLIP
    assert found.slip_per_cycle[0] == pytest.approx(0.162960, rel=1e-5)  # after 3,000 plain cycles


def test_slip_without_friction_is_a_cycle():
    joint = Problem(
        A=2 * np.eye(4) + 0.2, B=np.zeros((2, 4)), f=[0, 0.5], p_w=np.ones((3, 2)),
        q_w=[[1, 0, 0, 0], [0, 1, 0.1, 0], [-1, -1, 0, 0.1]],
    )  # fmt: skip
    found = shakedown.long_term_state(joint, 1.0)
    assert found.outcome == Outcome.CYCLIC_SLIP
    q = joint.q_w[:, :2]  # the other node sticks
    way = np.diff(np.vstack([q, q[:1]]), axis=0) @ np.linalg.inv(joint.A[:2, :2])
    np.testing.assert_allclose(found.slip_per_cycle, [np.hypot(*way.T).sum(), 0.0], atol=1e-12)
    assert found.friction_dissipation_per_cycle == pytest.approx(0.0, abs=1e-12)
    worn = shakedown.node_results(found, wear_coefficient=3.0).wear_volume  # by pressures of 1
    np.testing.assert_allclose(worn, 3.0 * found.slip_per_cycle, atol=1e-12)


def test_a_node_that_settles_slowly_does_not_hide_a_drift_beside_it():
    """A pair that walks, a soft node that slips far, and one that slides to the middle in thousands of cycles."""
    stiffer = 1e6
    turn = 2.0 * np.pi * np.arange(12) / 12
    wave, none = np.cos(turn), np.zeros(12)
    turns = np.where(np.arange(12) < 6, 1.0, -1.0)
    A, held = np.zeros((8, 8)), np.diag([1.0, 1.0, stiffer, 0.02 * stiffer])
    A[:4, :4], A[4:, 4:] = stiffer * np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(2)), held
    q_w = np.stack([0.501 * turns, none, -0.501 * turns, none, wave, none, 1.01 * wave, none], axis=1)
    p_w = np.stack([2.0 - turns, 2.0 + turns, none + 1.0, none + 1.0], axis=1)
    joint = Problem(A=A, B=np.zeros((4, 8)), f=[0.5, 0.5, 0.5, 1.0], q_w=q_w, p_w=p_w)
    found = shakedown.long_term_state(joint, 1.0, [0.0] * 7 + [0.5 / stiffer])
    assert found.outcome == Outcome.RATCHETTING, found.reason
    assert stiffer * np.abs(found.drift[:4:2]) == pytest.approx(2e-3, rel=1e-3)


def test_the_error_has_the_way_of_the_slowest_node():
    """A node slips far, two slide to the middle: the slower one still has all its way to go."""
    slower, wave, none = 1e-3, np.cos(2.0 * np.pi * np.arange(12) / 12), np.zeros(12)
    A = np.diag([1.0, 1.0, 1.0, 0.02, 1.0, 0.02])
    q_w = np.stack([10.0 * wave, none, 1.03 * wave, none, (1.0 + 0.03 * slower) * wave, none], axis=1)
    joint = Problem(A=A, B=np.zeros((3, 6)), f=1.0, q_w=q_w, p_w=np.ones((12, 3)))
    found = shakedown.long_term_state(joint, 1.0, [0.0, 0.0, 0.0, 0.2, 0.0, 0.2])
    assert found.outcome == Outcome.CYCLIC_SLIP
    assert np.abs(found.final_slip[[3, 5]]).max() < found.error


def test_the_error_of_a_state_at_rest_has_what_is_still_to_come():
    """Exactly at λ_max the way left falls like one over the number of cycles: the slip across goes to 1/7.5."""
    problem = Problem(
        A=np.eye(2), B=[[0.0, 0.5]], C=[[1.0]], f=0.5, q_w=[[1.0, 0.0], [-1.0, 0.0]], p_w=[[1.0], [1.0]],
        q_mean=[0.0, 0.0], p_mean=[1.0],
    )  # fmt: skip
    found = shakedown.long_term_state(problem, shakedown.upper_bound(problem).load_factor, [0.0, 0.2])
    assert found.outcome == Outcome.SHAKEDOWN
    assert 1e-6 < abs(found.final_slip[1] - 1 / 7.5) < found.error < 1e-3


def test_a_cycle_that_takes_next_to_no_work_is_one():
    """A node that the load carries along against hardly any friction: it slips 4 (λ q − f p) per cycle."""
    friction, q_w = 1e-12, np.zeros((4, 4))
    q_w[0, 2], q_w[2, 2], q_w[1, 0], q_w[3, 0] = 1.0, -1.0, 0.3, -0.3
    joint = Problem(A=np.eye(4), B=np.zeros((2, 4)), f=[0.5, friction], q_w=q_w, p_w=np.full((4, 2), 2.0))
    state = shakedown.long_term_state(joint, 0.5, max_cycles=20)
    assert state.outcome == "cyclic-slip"
    assert state.slip_per_cycle == pytest.approx([0.0, 4.0 * (0.5 - 2.0 * friction)])


def test_what_leaps_leave_in_doubt_is_confirmed_or_said():
    """A cycle whose slip is less than what leaps leave open: with an eighth of that it is found once more."""
    problem = random_joint(np.random.default_rng([4, 1, 3]), "stiff and soft", 4)
    state = shakedown.long_term_state(problem, 0.706005322)
    assert state.outcome == Outcome.CYCLIC_SLIP
    assert state.error < state.slip_per_cycle.max()
    short = shakedown.long_term_state(problem, 0.706005322, max_cycles=state.cycles_simulated - 5)
    assert short.outcome == Outcome.CYCLIC_SLIP
    assert "not certainly the one" in short.reason


def near(value):
    return pytest.approx(value, rel=1e-3, abs=1e-6)


REST, CYCLES, WALKS = Outcome.SHAKEDOWN, Outcome.CYCLIC_SLIP, Outcome.RATCHETTING
SLOW = {  # numbers after plain cycles: as many as are said, else of 20,000 to 400,000
    "a drift that fades by 1.1 % a cycle": ([6, 3, 3], 1.3047142828634468, CYCLES, {"slip": pytest.approx(18.0581, rel=1e-4)}),
    "two slow ways, and a thousandfold growth after 70,000 cycles": ([1, 1, 0], 0.8478724786, CYCLES, {"slip": near(2.5463e-3), "cycles": 4000}),
    "held by a node that does not slip": ([12, 3, 1], 1.0117698617, CYCLES, {"slip": near(8.488e-5)}),
    "one with an open node, which cannot slip": ([11, 3, 4], 1.4967854052, WALKS, {"slip": near(48.3239)}),
    "to a rest that is known": (
        [42, 3, 2], 1.26095238765354, REST,  # round-off decides in how many cycles
        {"cycles": 4000, "off": 1e-3, "ends_at": [1.4658962, -4.7214893, 3.4407266, -8.6290169, 1.5837352, -5.2768598]},
    ),
    "of one with 4e-4 to go after 4 million": ([22, 3, 3], 1.1621263377167997, REST, {"off": 3e-3}),
    "that ends in round-off": ([405, 3, 1], 0.696357512172074, REST, {"off": 3e-3, "most": 450}),
    "a cycle that leaps come no nearer to": (
        [35, 1, 1], 0.762250879422505, CYCLES,
        {"slip": near(2.0488e-3), "off": 1e-3, "ends_at": [-14.0671, 1.55657, 58.6272, 0.0853861, 0.67133, 0.0112912, 0.0255534, 0.113047]},
    ),
    "an open node that follows the leaps of others": (
        [44, 77], 3.4193401044142373, CYCLES,
        {
            "cycles": 2000, "opened": (0,), "near": 1e-3,
            "ends_at": [20.0258698, -1.3723793, -494.2777126, -11.5431224, 0.2191306, -0.366571],
        },
    ),
}  # fmt: skip


@pytest.mark.parametrize(("seeds", "load_factor", "outcome", "known"), SLOW.values(), ids=SLOW)
def test_a_slow_motion_comes_to_its_end(seeds, load_factor, outcome, known):
    """In units in which slips are very small or very large numbers."""
    kind = {2: "floating", 3: "floating, stiff and soft"}.get(seeds[1], "stiff and soft")
    joint, length = random_joint(np.random.default_rng(seeds), kind, 4), 2.0 ** (21 if seeds[0] % 2 else -40)
    joint, most = in_units(joint, 1.0, length), known.get("most", 1000)
    found = shakedown.long_term_state(joint, load_factor, max_cycles=most)
    ends, error, slip = found.final_slip / length, found.error / length, found.slip_per_cycle.max() / length
    assert found.outcome == outcome
    assert slip == known.get("slip", slip)
    assert found.cycles_simulated < known.get("cycles", 6000)
    assert found.open_nodes == known.get("opened", found.open_nodes)
    if "off" in known:
        assert error <= known["off"] * np.abs(ends).max()
    if "ends_at" in known:
        off = np.abs(ends[: len(known["ends_at"])] - known["ends_at"]).max()
        assert off <= min(error, known.get("near", np.inf))


def test_a_walk_is_leapt_over_alike_in_all_units():
    joint = random_joint(np.random.default_rng([17, 3, 3]), "floating, stiff and soft", 4)
    units = (2.0**-37, 2.0**21), (2.0**30, 2.0**-40)
    found, other = (shakedown.long_term_state(in_units(joint, *each), 1.7824500331) for each in units)
    assert found.outcome == other.outcome == Outcome.RATCHETTING
    assert found.cycles_simulated == other.cycles_simulated
    np.testing.assert_array_equal(found.final_slip, 2.0**61 * other.final_slip)
    assert found.slip_per_cycle.max() == pytest.approx(2.0**21 * 1.04402e-2, rel=1e-3)


@pytest.mark.parametrize(("stuck", "held"), [([0], False), ([1, 2], False), ([0, 1], True), ([0, 3], True)])
def test_a_body_that_may_turn_is_held_by_nodes_in_two_places(stuck, held):
    x = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 0.0], [1.0, 3.0]])
    rigid = np.column_stack([np.tile([1, 0], 4), np.tile([0, 1], 4), (x[:, ::-1] * [-1, 1]).ravel()])
    rigid, slip, layout = np.linalg.qr(rigid)[0], np.ones(4), shakedown.example("four-node-3d").layout
    least = 1e-6 * np.linalg.svd(rigid[layout.slips_of(stuck)])[1].min()  # moves the others by 1e-6 at most
    for slips, there in ((0.0, held), (0.99 * least, held), (1.01 * least, False)):
        slip[stuck] = slips
        assert is_held(layout, rigid, slip, np.ones(4)) == there


def test_the_error_covers_nodes_that_cease_to_slip_on_a_leap():
    problem = random_joint(np.random.default_rng([41, 0, 4]), "held", 4)
    found, plain = shakedown.long_term_state(problem, 0.9913461737), Evolution(problem, 0.9913461737)
    plain.advance(8000)
    off = np.abs(plain.state.u[problem.layout.slips] - found.final_slip).max()
    assert off < found.error


def test_a_body_that_moves_only_where_nodes_open_slips_in_a_cycle():
    """κ has a zero mode, and no rigid slip: the search took the room that no node leaves it for a number."""
    rng, t = np.random.default_rng(84), 2 * np.pi * np.arange(12)[:, None] / 12
    root, free = rng.normal(size=(6, 6)), rng.normal(size=6)
    held = np.eye(6) - np.outer(free, free) / (free @ free)
    kappa = held @ (root @ root.T / 6 + 0.3 * np.eye(6)) @ held
    kappa = 0.5 * (kappa + kappa.T)
    q_w = rng.normal(size=4) * np.cos(t) + rng.normal(size=4) * np.sin(t)
    p_w = 4.0 + 0.5 * rng.normal(size=2) * np.sin(t)
    joint = Problem(A=kappa[:4, :4], B=kappa[4:, :4], C=kappa[4:, 4:], f=0.4, q_w=q_w, p_w=p_w)
    load_factor = 1.003 * shakedown.upper_bound(joint, certify=False).load_factor
    state, motion = shakedown.long_term_state(joint, load_factor), Evolution(joint, load_factor)
    for _ in range(400):
        motion.cycle()
    assert state.outcome == Outcome.CYCLIC_SLIP
    assert np.abs(state.final_slip - motion.state.u[:4]).max() <= state.error


def test_where_rest_is_excluded_slip_is_known_to_three_digits_sooner():
    problem = shakedown.example("block-3x3")
    beyond = 1.05 * shakedown.upper_bound(problem).load_factor
    exact = shakedown.long_term_state(problem, beyond)
    found = shakedown.long_term_state(problem, beyond, tolerances=Tolerances(slip_change=1e-4))
    assert found.outcome == exact.outcome
    assert found.cycles_simulated < exact.cycles_simulated
    assert found.slip_per_cycle == pytest.approx(exact.slip_per_cycle, abs=1e-3 * exact.slip_per_cycle.max())
    assert 0.0 < np.abs(found.final_slip - exact.final_slip).max() < found.error
