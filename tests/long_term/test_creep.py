"""What keeps a body that friction alone holds from creeping, the theorems of docs/creep.md as laws; drifts that turn it."""

from dataclasses import replace
from math import isnan

import numpy as np
import pytest
from uncoupled_parts import joined

import shakedown
from benchmarks.bodies.bearing_ring import bearing_ring
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from benchmarks.problems import in_units
from shakedown import Outcome, Problem
from shakedown.ground.status import OPEN
from shakedown.joint.constraints import loading
from shakedown.joint.rigid_slips import can_creep
from shakedown.long_term.creep_proofs import sliding_bodies
from shakedown.motion.evolution import Evolution
from shakedown.report.html import render
from shakedown.report.limit_facts import solve_sheet
from shakedown.report.run_facts import run_sentence, verify_sheet
from tests.command import document

# Counter-examples: each shows that a condition of a theorem is needed.
WINDOW = Problem(  # creeps, and above that does not
    A=[[1.0, -1.0], [-1.0, 1.0]],
    B=np.zeros((2, 2)),
    f=1.0,
    q_w=[[0, 0], [0, 0], [-1, 1], [0, 0], [0, 0], [1, -1], [0, 0], [0, 0]],
    p_w=[[1, 1.5], *[[1.25, 1.5]] * 3, *[[2, 1.5]] * 3, [1, 1.5]],
    q_mean=[0.0, 0.0],
    p_mean=[1.0, 1.5],
)
WRONG_SIGNS = Problem(  # A has a positive entry off its diagonal, and creeps below its λ_w
    A=[[0.5, -1, 0.5], [-1, 3, -2], [0.5, -2, 1.5]],
    B=np.zeros((3, 3)),
    f=1.0,
    q_w=[[1, 1, -2], [1.5, -0.5, -1], [-1, 0.5, 0.5], [-1.5, 0, 1.5]],
    p_w=np.tile([2.0, 1.5, 1.5], (4, 1)),
    q_mean=[0, 0, 0],
)
ONE_WAY = Problem(  # irreducible both ways, but not every mixture of rows is
    A=[[1, -0.5, -0.5], [-0.5, 1, -0.5], [-0.5, -0.5, 1]],
    B=[[0, -0.5, 0.5], [0.5, 0, -0.5], [-0.5, 0.5, 0]],
    f=1.0,
    q_w=np.outer([2.0, 0.0, -2.0, 0.0], [1.0, -1.0, 0.0]),
    p_w=np.ones((4, 3)),
)
PUSHED_ON = Problem(  # slip of the first node lowers its own limit by more than it relieves the node
    A=[[1.0, -1.0], [-1.0, 1.0]], B=[[-3.0, 3.0], [0.0, 0.0]], f=0.5,
    q_w=[[1.0, 0.0], [-1.0, 0.0]], p_w=[[4.0, 9.0], [4.0, 9.0]],
)  # fmt: skip


def on_springs(springs, B, **more):
    """A joint whose nodes springs (n, n) connect and friction alone holds."""
    return Problem(A=np.diag(springs.sum(axis=1)) - springs, B=B - np.diag(B.sum(axis=1)), **more)


def drawn(seed, *, coupled=True):
    """A random monotone joint with one rigid slip."""
    rng = np.random.default_rng(seed)
    n, m = rng.integers(2, 6), rng.integers(3, 8)
    springs = rng.random((n, n)) * (rng.random((n, n)) < 0.7) + 0.2 * np.eye(n, k=1)
    springs = np.triu(springs, 1) + np.triu(springs, 1).T
    f = rng.uniform(0.2, 0.8, n)
    B = rng.uniform(-0.9, 0.9, (n, n)) * springs / f[:, None] * coupled
    q0, p0 = 0.2 * rng.normal(size=n), rng.uniform(2, 4, n)
    loads = {"q_w": q0 + rng.normal(size=(m, n)), "p_w": p0 + 0.3 * rng.normal(size=(m, n))}
    return on_springs(springs, B, f=f, q_mean=q0, p_mean=p0, **loads)


@pytest.mark.parametrize("series", [drawn_joint, drawn_joint_in_space])
def test_a_joint_without_rigid_slip_never_creeps(series):
    joints = [joint for joint in (series(3, number) for number in range(40)) if not can_creep(joint)]
    assert len(joints) > 20
    for joint in [*joints, shakedown.example("three-node")]:
        limit = shakedown.creep_limit(joint)
        assert (limit.status, limit.proved_from) == ("unbounded", "every state, any order")
        assert limit.load_factor == limit.proved == np.inf
        assert sliding_bodies(joint) == ()


@pytest.mark.parametrize("seed", range(6))
def test_nothing_creeps_below_the_wedge_bound(seed):
    joint, rng = drawn(seed, coupled=seed % 3 > 0), np.random.default_rng(seed)
    (body,) = sliding_bodies(joint)
    assert all(body.monotone)
    wedge = min(body.wedge_bounds)
    for _ in range(3):
        order = rng.permutation(joint.m)
        other = replace(joint, q_w=joint.q_w[order], p_w=joint.p_w[order])
        found = shakedown.long_term_state(other, 0.999 * wedge, rng.normal(scale=3.0, size=joint.n))
        lifted = found.stop is not None  # a node opens: nothing is said then
        assert lifted or found.outcome in (Outcome.SHAKEDOWN, Outcome.CYCLIC_SLIP)
    turned = {key: -getattr(joint, key) for key in ("B", "q_w", "q_mean")}
    (other,) = sliding_bodies(replace(joint, **turned))  # every slip counted the other way
    assert other.wedge_bounds == pytest.approx(body.wedge_bounds[::-1])


def test_the_wedge_bound_needs_its_signs():
    (body,) = sliding_bodies(WRONG_SIGNS)
    assert not any(body.monotone)
    assert all(isnan(each) for each in body.wedge_bounds)
    assert shakedown.upper_bound(WRONG_SIGNS).load_factor == pytest.approx(6 / 7)
    drift = shakedown.long_term_state(WRONG_SIGNS, 1.225).drift
    assert np.abs(drift).max() == pytest.approx(0.1097, abs=1e-4)


def test_drift_may_vanish_above_the_least_load_factor_that_creeps():
    limit = shakedown.creep_limit(WINDOW)
    assert limit.load_factor == pytest.approx(10 / 7, rel=1e-5)
    assert limit.certain == pytest.approx((10 / 7, 3 / 2))
    assert limit.proved <= limit.load_factor
    assert np.abs(shakedown.long_term_state(WINDOW, 2.0).drift).max() > 0.5
    assert shakedown.long_term_state(WINDOW, 2.01).outcome == Outcome.CYCLIC_SLIP
    assert np.abs(shakedown.long_term_state(WINDOW, 3.0).drift).max() == pytest.approx(0.5)


def test_one_cycle_encloses_the_drift_only_if_all_mixtures_are_irreducible():
    (body,) = sliding_bodies(ONE_WAY)
    assert all(body.monotone)
    assert not body.all_mixtures_irreducible
    state = shakedown.long_term_state(ONE_WAY, 1.0, [-1.0, 1.0, 0.0])
    assert all(isnan(each) for each in body.drift_enclosure(state.history))
    tied = replace(ONE_WAY, B=0.9 * ONE_WAY.B)
    assert sliding_bodies(tied)[0].all_mixtures_irreducible


@pytest.mark.parametrize("seed", range(4))
def test_one_cycle_encloses_the_drift_from_every_state(seed):
    joint, rng = drawn(seed), np.random.default_rng(seed)
    (body,) = sliding_bodies(joint)
    load_factor = 1.5 * min(body.wedge_bounds)
    states = [shakedown.long_term_state(joint, load_factor, rng.normal(size=joint.n)) for _ in range(3)]
    drifts = [state.drift / max(state.period, 1) for state in states if state.stop is None]
    for state in states:
        if state.stop is None:
            first = shakedown.simulate(joint, load_factor, state.initial_slip, record=True).history
            begin = first.cycle >= first.cycle[-1] - 1.0 - 1e-9
            low, high = body.drift_enclosure(first.rows(begin))
            for drift in drifts if low == low else []:
                assert low - 1e-9 <= drift.min() <= drift.max() <= high + 1e-9


def test_a_ring_with_clearance_goes_on_as_its_cycles_do():
    """Almost all nodes slip at once, so that the map of a period knows to ten digits what is rigid."""
    ring = bearing_ring(interference=-5e-3)
    state, motion = shakedown.long_term_state(ring, 3.0), Evolution(ring, 3.0)
    assert state.outcome == Outcome.RATCHETTING
    assert state.cycles_simulated < 30
    *_, before, last = [motion.cycle().end_slip for _ in range(12)]
    assert state.drift == pytest.approx(last - before, rel=1e-9)


def test_the_ring_of_a_bearing():
    ring = shakedown.example("bearing-ring")
    (body,) = sliding_bodies(ring)
    assert all((*body.monotone, body.all_mixtures_irreducible))
    assert not replace(body, M=body.M * (np.arange(ring.n) > 0)[:, None]).all_mixtures_irreducible
    assert body.wedge_bounds == pytest.approx([0.478545] * 2, rel=1e-5)
    state = shakedown.long_term_state(ring, 0.7)
    low, high = state.drift_bounds
    assert -1e-12 < low <= high < 1e-12
    path, passed = state.history, state.history.cycle - state.history.cycle[0]
    nothing = [path.rows(passed <= share) for share in (0.0, 0.3, 0.7)]  # less than one cycle
    jump = replace(path.joined([path, path.rows([-1])]), v=np.vstack([path.v, path.v[-1] + 1e-3]))
    nothing += [replace(path, state=np.full_like(path.state, OPEN)), jump]
    assert all(isnan(each) for path in nothing for each in body.drift_enclosure(path))


@pytest.mark.usefixtures("undrawn")
def test_the_text_says_where_slip_without_creep_is_proved():
    found = shakedown.assess(drawn(7))
    verified = shakedown.verify(drawn(7), load_factors=[0.5], random_states=0)
    for sheet in (solve_sheet(found, details=True, follow=True), verify_sheet(verified)):
        (fact,) = [fact for fact in sheet.facts if fact.label == "slips without creep"]
        assert fact.value == "λ = 0.4645 to 0.609"
    assert found.impossible_above < 0.4645 < 0.609 <= found.details.creep.proved
    page = render(verified)
    assert page.count("slips without creep") == 1
    assert "λ<sub>c</sub>" in page


def test_programs_in_the_order_of_the_loads_end_where_drift_begins():
    joint = drawn(5)
    limit = shakedown.creep_limit(joint)
    (body,), still = sliding_bodies(joint), np.zeros((joint.m, joint.n), dtype=bool)
    ends = [body.interval_proved(side, still, 0.0, 20.0) for side in (0, 1)]  # by paths that never go back
    assert ends == pytest.approx(body.wedge_bounds, rel=1e-5)
    assert limit.wedge <= limit.proved <= limit.load_factor * (1 + 1e-6)
    assert not limit.creeps[limit.grid < limit.proved].any()
    in_any_order, held = replace(joint, load_path="domain"), replace(joint, A=joint.A + np.eye(joint.n))
    for other in (in_any_order, joined([joint, held])):  # there nothing is known of what follows on what
        assert shakedown.creep_limit(other).proved == pytest.approx(limit.wedge)


def test_a_path_that_exists_only_above_what_is_proved_adds_nothing():
    """The mean load pushes the body away; an amplitude that presses it on holds it from λ = 0.31 on."""
    joint = drawn(9)
    pushed = replace(joint, q_w=joint.q_w + 5 * joint.q_mean, q_mean=6 * joint.q_mean)
    (body,), back = sliding_bodies(pushed), np.random.default_rng(9).random((joint.m, joint.n)) < 0.5
    ends = [body.interval_proved(1, back, start, 20.0) for start in (0.2, 0.4)]
    assert ends == [0.2, pytest.approx(1.0865, abs=1e-4)]


@pytest.mark.parametrize("seed", range(3))
def test_constant_forces_beyond_an_interval_make_a_joint_creep(seed):
    joint = drawn(seed, coupled=False)
    swing = replace(joint, q_w=joint.q_mean + 0.8 * (joint.q_w - joint.q_mean))
    limit, rng = shakedown.creep_limit(swing), np.random.default_rng(seed)
    low, high = limit.force_to_creep
    assert isnan(low) == (limit.load_factor <= 1)
    for end in (low, high) if limit.load_factor > 1 else ():
        for share in (0.99, 1.01):
            g = end * share * np.eye(joint.n)[seed % joint.n] + joint.A @ rng.normal(scale=0.1, size=joint.n)
            pushed = replace(swing, q_w=swing.q_w + g, q_mean=swing.q_mean + g)
            state = shakedown.long_term_state(pushed, 1.0, rng.normal(size=joint.n))
            assert (share > 1) == (state.outcome == Outcome.RATCHETTING or state.slides_away)


@pytest.mark.parametrize("seed", range(6))
def test_a_body_slides_where_the_sum_of_its_loads_exceeds_that_of_its_limits(seed):
    """Or where a node lifts off: slip, which changes no limit here, shares the loads out in any way."""
    joint = drawn(seed, coupled=False)
    loop = loading(joint)
    parts = loop.q0, loop.q1, joint.f * loop.p0, joint.f * loop.p1
    q0, q1, limit0, limit1 = (x.sum(axis=-1) for x in parts)
    ends = [(limit0 - s * q0) / np.maximum(s * q1 - limit1, 1e-300) for s in (1.0, -1.0)]
    lifted = loop.p0 / np.maximum(-loop.p1, 1e-300)
    (body,) = sliding_bodies(joint)
    assert body.gross_slip == pytest.approx(min(np.min(ends), lifted.min()))


def test_creep_is_certain_between_the_sums_and_the_swing_of_a_node():
    joints = [drawn(seed, coupled=False) for seed in range(20)]
    found = [(joint, *sliding_bodies(joint)[0].certain_creep) for joint in joints]
    certain = [each for each in found if not isnan(each[1])]
    assert certain
    for joint, low, high in certain:
        assert shakedown.upper_bound(joint).load_factor == pytest.approx(low)
        state = shakedown.long_term_state(joint, 0.5 * (low + high))
        assert state.outcome == Outcome.RATCHETTING


def test_a_node_is_held_below_the_bound_of_this_state():
    rng = np.random.default_rng(0)
    springs = np.array([[0, 1, 0.5], [1, 0, 1], [0.5, 1, 0]])
    B = rng.normal(scale=1.2, size=(3, 3))
    joint = on_springs(springs, B, f=0.6, q_w=rng.normal(size=(4, 3)), p_w=np.full((4, 3), 5.0))
    (body,) = sliding_bodies(joint)
    assert not all(body.monotone)
    held, box = body.held_bound(np.zeros(3))
    assert held > 0
    assert (box[0] == box[1]).any()
    limit = shakedown.creep_limit(joint)
    assert limit.held == held <= limit.proved
    for _ in range(5):
        order = np.append(0, 1 + rng.permutation(3))
        other = replace(joint, q_w=joint.q_w[order])
        path = shakedown.simulate(other, 0.999 * held, record=True).history
        assert (np.ptp(path.v, axis=0) <= 1e-12).any()
        assert (box[0] - 1e-9 <= path.v).all()
        assert (path.v <= box[1] + 1e-9).all()


def test_a_rigid_slip_of_the_start_moves_the_box_of_a_held_node_with_it():
    """Of a node that jumps, too: slip lowers its limit by more than it relieves the node."""
    (body,) = sliding_bodies(PUSHED_ON)
    assert body.M[0, 0, 0] < 0
    held, box = body.held_bound(np.array([0.2, 0.1]))
    moved, there = body.held_bound(np.array([5.2, 5.1]))
    assert moved == pytest.approx(held)
    assert there == pytest.approx(box + 5.0)
    sizes = np.array([2.0, 0.25])  # units of lengths; a box is in units of the rigid slip
    (body,) = sliding_bodies(in_units(PUSHED_ON, 1.0 / sizes, sizes))
    other, scaled = body.held_bound(sizes * [0.2, 0.1])
    assert other == pytest.approx(held)
    assert scaled * body.z == pytest.approx(box * sizes)


RING = shakedown.example("bearing-ring")


def test_a_ring_creeps_by_turning_about_its_middle():
    run = shakedown.simulate(RING, 1.0)
    found = run.rigid_drift
    # slip over radius; of the middle nodes of quadratic facets the radius is smaller, and so is the slip
    assert found.turn == pytest.approx([0, 0, np.degrees(run.drift.max() / 40.0)], rel=1e-6)
    assert not found.shift.any()
    assert found.cycles_per_revolution == 8
    assert f"; per revolution by {8 * found.turn[2]:.4g}°." in run_sentence(RING, run)
    turned = replace(RING, coordinates=RING.coordinates + np.array([5.0, -3.0, 0.0]))
    assert shakedown.simulate(turned, 1.0).rigid_drift.turn == pytest.approx(found.turn, rel=1e-9)
    assert shakedown.node_results(run).to_dict()["rigid_drift"] == run.to_dict()["rigid_drift"]


def test_two_cycles_in_a_period_drift_by_half_as_much_each():
    twice = {key: np.vstack([getattr(RING, key)] * 2) for key in ("q_w", "p_w")}
    loads = dict.fromkeys(("load_reactions", "load_history", "load_compliance", "load_names"))
    once, both = shakedown.simulate(RING, 1.0), shakedown.simulate(replace(RING, **twice, **loads), 1.0)
    assert both.rigid_drift.turn == pytest.approx(2 * once.rigid_drift.turn, rel=1e-6)


def test_what_does_not_creep_tells_of_no_drift():
    assert shakedown.simulate(RING, 0.6).rigid_drift is None
    for name in ("two-node", "press-fit"):
        told = document("simulate", name, "--load-factor", "1.0")
        assert "rigid_drift" not in told
