"""What is said of a long-term state: jumps and their energy, the friction law as judge, and proof."""

from dataclasses import replace

import numpy as np
import pytest

import shakedown
from benchmarks.drawn_joints import drawn_joint
from shakedown.ground.status import OPEN, SLIP, STICK
from shakedown.motion.course import EventKind
from shakedown.motion.evolution import Evolution

# Scenarios A.6 and A.7 as loops: by hand, one node, k₁₁ = 1, k₂₁ = 1.5, k₂₂ = 4, f = 0.8.
# A.6 slips in jumps only; A.7 also between them, along the forward limit.
SEPARATION = {
    "outcome": "separation", "slip": 0.0, "between jumps": 0.0, "released": 2.0714286, "friction": 1.6666667, "jump at": (3.0, 4.0),
    "sticks at": -1.0, "states": {STICK, OPEN},
}  # fmt: skip
CYCLIC = {
    "outcome": "cyclic-slip", "slip": 1.0606061, "between jumps": 0.6749311, "released": 2.224817, "friction": 1.7900826,
    "jump at": (2.3454545, 3.0), "sticks at": -3 / 11,
    "states": {STICK, SLIP, OPEN},
}  # fmt: skip
LOOPS = {"one-node-separation": SEPARATION, "one-node-cyclic": CYCLIC}


@pytest.mark.parametrize("name", LOOPS)
def test_appendix_a_jumps_in_every_cycle_though_another_slip_is_safe(name):
    """Melan's theorem fails, as friction is above its critical value."""
    problem, expected = shakedown.example(name), LOOPS[name]
    assert problem.f[0] > shakedown.friction_thresholds(problem).single_node[0]
    assert shakedown.long_term_state(problem, 1.0, problem.initial_slip[1]).outcome == "shakedown"
    state = shakedown.long_term_state(problem, 1.0, problem.initial_slip[0])
    assert set(np.abs(state.history.state[:, 0])) == expected["states"]
    assert (state.outcome, state.period, state.jumps_per_cycle) == (expected["outcome"], 1, 1.0)
    assert "1 jump in every cycle" in state.reason
    assert state.slip_per_cycle == pytest.approx([expected["slip"]], rel=1e-6)
    assert state.final_slip == pytest.approx([expected["sticks at"]], rel=1e-6)
    friction = expected["friction"] + expected["between jumps"]
    assert state.friction_dissipation_per_cycle == pytest.approx(friction, rel=1e-6)
    run = shakedown.simulate(problem, 1.0, problem.initial_slip[0], record=True)
    jump = run.jumps[-1]
    assert jump.energy_released == pytest.approx(expected["released"], rel=1e-6)
    assert jump.friction_work == pytest.approx(expected["friction"], rel=1e-6)
    assert jump.friction_work + jump.damping_work == pytest.approx(jump.energy_released)
    at = run.history.kind == EventKind.JUMPS
    loads = np.column_stack([run.history.q_w[at], run.history.p_w[at]])
    assert loads[-1] == pytest.approx(expected["jump at"], rel=1e-6)


@pytest.mark.parametrize(("name", "load_factor"), [*((name, 1.0) for name in LOOPS), ("two-node", 1.5)])
def test_friction_and_jumps_together_take_what_the_loading_puts_in(name, load_factor):
    """∮ u · dr_w over a period of a limit cycle."""
    problem = shakedown.example(name)
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    state = shakedown.long_term_state(problem, load_factor, start)
    h = state.history
    mid_v, mid_w = (h.v[1:] + h.v[:-1]) / 2, (h.w[1:] + h.w[:-1]) / 2
    work = (mid_v * np.diff(h.q_w, axis=0)).sum() + (mid_w * np.diff(h.p_w, axis=0)).sum()
    assert state.dissipation_per_cycle == pytest.approx(work, rel=1e-7 if name in LOOPS else 1e-12)
    assert (0 < state.jump_dissipation_per_cycle < state.friction_dissipation_per_cycle) == (name in LOOPS)
    parts = state.friction_dissipation_per_cycle + state.jump_dissipation_per_cycle
    assert parts == state.dissipation_per_cycle


def test_a_path_that_breaks_the_friction_law_decides_nothing(monkeypatch):
    """Of an integrator that slips too early: its coefficient of friction is smaller than the joint's."""
    problem = replace(shakedown.example("two-node"))  # no integrator is kept for it
    honest = Evolution.__init__

    def wrong(self, *arguments, **options):
        honest(self, *arguments, **options)
        self.method.active.f[:] *= 0.9

    monkeypatch.setattr(Evolution, "__init__", wrong)
    for answer in (shakedown.long_term_state(problem, 1.0), shakedown.simulate(problem, 1.0, record=True)):
        assert answer.outcome == "undecided"
        assert "the friction law is violated" in answer.reason
        assert answer.residual > 1e-3
    report = shakedown.verify(problem, random_states=0, load_factors=[1.0])
    assert not report.agrees
    assert any("the friction law is violated" in text for text in report.open_questions)


@pytest.mark.parametrize(("name", "load_factor"), [("two-node", 0.73), ("block-9", 4.69)])
def test_a_proved_state_may_be_disturbed_by_its_distance_from_the_surface_of_the_ball(name, load_factor):
    problem = shakedown.example(name)
    state = shakedown.long_term_state(problem, load_factor)
    ball = shakedown.energy_ball(problem, load_factor, around=state.final_slip)
    assert state.energy_margin == pytest.approx(ball.radius - ball.distance(state.final_slip), rel=1e-6)
    single = np.sqrt(np.diag(problem.A)) * state.single_node_margin
    assert single.max() == pytest.approx(state.energy_margin)


def test_a_proof_is_sought_next_below_the_transient_limit():
    limit = shakedown.transient_limit(drawn_joint(3, 27))  # its start proves nothing
    assert (1.0 - 2e-6) * limit.low < limit.proved < limit.low


@pytest.mark.parametrize("name", ["two-node", "block-9", "block-33"])
def test_the_transient_limit_is_enclosed_by_proof_and_cycle(name):
    problem = shakedown.example(name)
    limit = shakedown.transient_limit(problem, steps=10, accuracy=1e-6)
    proved, cycling = limit.proved, limit.cycling
    assert proved <= limit.load_factor < cycling
    assert cycling - proved <= 1e-3 * cycling
    assert limit.at_proved.proved
    assert limit.at_proved.load_factor == proved
    assert shakedown.long_term_state(problem, cycling).outcome == "cyclic-slip"
    assert limit.low >= (1.0 - 1e-8) * shakedown.accumulated_bound(problem).load_factor


@pytest.mark.parametrize("method", ["event", "gauss-seidel"])
@pytest.mark.parametrize("directions", [1, 2])
def test_a_stiff_node_slips_little_and_is_seen(directions, method):
    """Two nodes apart, one a million times stiffer: by hand, from λ = 1 on it slips 4 (λ − 1) / A per cycle."""
    d, stiff = directions, 1e6
    q = np.zeros((4, 2 * d))
    q[0, d], q[2, d], q[1, 0], q[3, 0] = 1.0, -1.0, 0.3, -0.3
    A = np.diag(np.repeat([1.0, stiff], d))
    problem = shakedown.Problem(A=A, B=np.zeros((2, 2 * d)), f=0.5, q_w=q, p_w=np.full((4, 2), 2.0))
    for load_factor in (1.01, 1.00001):
        run = shakedown.simulate(problem, load_factor, method=method)
        assert run.outcome == "cyclic-slip"
        assert run.slip_per_cycle == pytest.approx([0.0, 4.0 * (load_factor - 1.0) / stiff], rel=1e-5)
    assert shakedown.simulate(problem, 0.99, method=method).outcome == "shakedown"


@pytest.mark.parametrize(("directions", "pressure"), [(1, 2e5), (2, 2e3)])
def test_what_slips_is_seen_beside_large_loads_that_rest(directions, pressure):
    d, q = directions, np.zeros((4, directions))
    q[0, 0], q[2, 0] = 1.0, -1.0
    joint = shakedown.Problem(A=np.eye(d), B=np.zeros((1, d)), f=1.0 / pressure, q_w=q, p_w=[[pressure]] * 4)
    state = shakedown.long_term_state(joint, 1.0001, max_cycles=20)
    assert state.outcome == "cyclic-slip"
    assert state.slip_per_cycle == pytest.approx([4e-4], rel=1e-4)
    assert shakedown.long_term_state(joint, 0.9999, max_cycles=20).outcome == "shakedown"


@pytest.mark.parametrize("name", ["two-node", "two-node-3d"])
@pytest.mark.usefixtures("no_transient_limit")
def test_slip_next_to_round_off_of_the_loads_at_rest_is_not_told(name):
    """Above λ_max of a node that has next to no friction: too little changes to say that it rests."""
    joint = shakedown.example(name)
    problem, little = (replace(joint, f=np.array([f, joint.f[1]])) for f in (1e-12, 1e-6))
    above = 1.05e-6 * shakedown.upper_bound(little).load_factor  # next to round-off λ_max itself is not known
    state = shakedown.long_term_state(problem, above)
    assert state.outcome == "undecided"
    assert "round-off" in state.reason
    assert shakedown.long_term_states(problem, above, np.zeros((1, len(problem.A)))).outcome == "undecided"
    assert shakedown.verify(problem, random_states=0, load_factors=[above]).disagreements == ()


def test_an_undecided_run_says_what_is_known_above_the_upper_bound():
    joint = shakedown.example("two-node")
    upper = shakedown.upper_bound(joint).load_factor
    for load_factor in (0.99 * upper, 1.01 * upper):
        state = shakedown.long_term_state(joint, load_factor, max_cycles=1)
        assert state.outcome == "undecided"
        assert ("cannot come to rest" in state.reason) == (load_factor > upper)


def test_in_space_what_cannot_come_to_rest_slips_before_its_cycle_is_found():
    joint = shakedown.example("two-node-3d")
    upper = shakedown.upper_bound(joint).load_factor
    state = shakedown.long_term_state(joint, 0.99 * upper, max_cycles=1)
    assert state.outcome == "undecided"
    state, found = (shakedown.long_term_state(joint, 1.01 * upper, max_cycles=most) for most in (1, 1000))
    assert state.outcome == found.outcome == "cyclic-slip"
    assert state.reason.startswith("proved, above λ_max")
    assert np.isnan(state.error)
    assert not found.reason.startswith("proved")
    lifts = shakedown.universal_bound(joint).lift_off_bound
    state = shakedown.long_term_state(joint, 1.01 * lifts, max_cycles=1)
    assert state.outcome == "undecided"


def test_no_verdict_contradicts_what_is_proved():
    """Of a node half a million times softer across its load: what it slips there takes thousands of cycles."""
    t = 2.0 * np.pi * np.arange(14)[:, None] / 14
    q_w = np.hstack([0.109 + 0.435 * np.cos(t), -0.174 + 0.1 * np.cos(t)])
    A, B = [[389.0, -0.05], [-0.05, 7e-4]], [[0.162, -1.4e-4]]
    joint = shakedown.Problem(A=A, B=B, C=[[0.0053]], f=0.3, q_w=q_w, p_w=2.1 + 0.139 * np.cos(t))
    below = 0.9999 * shakedown.energy_bound(joint).load_factor
    state = shakedown.long_term_state(joint, below, max_cycles=40)
    assert (state.outcome, state.proved) == ("shakedown", True)
    states = shakedown.long_term_states(joint, below, np.zeros((1, 2)), max_cycles=40)
    assert states.outcome.tolist() == ["shakedown"]


@pytest.mark.parametrize(("name", "load_factor"), [("two-attractors", 0.925), ("four-node-3d", 1.07)])
def test_where_no_ball_holds_a_state_the_slip_to_come_is_bounded(name, load_factor):
    """Near λ_T, of joints that λ_E and λ_S do not prove so far from their start."""
    joint = shakedown.example(name)
    for bound in (shakedown.energy_bound(joint), shakedown.accumulated_bound(joint)):
        assert bound.load_factor < load_factor
    state = shakedown.long_term_state(joint, load_factor)
    proof = state.proof_found
    assert not shakedown.energy_ball(joint, load_factor, around=state.final_slip).contains(state.final_slip)
    assert state.proved
    assert (proof.by, proof.cycles > 0) == ("λ_S", True)
    motion = Evolution(joint, load_factor)
    ways = [motion.cycle().slip.max() for _ in range(proof.cycles + 20)]
    assert 0.0 <= sum(ways[proof.cycles :]) <= proof.further < np.inf


@pytest.mark.parametrize("name", ["two-node", "four-node-3d"])
@pytest.mark.parametrize("share", [0.0, 0.95])
def test_a_known_bound_of_the_start_proves_what_a_ball_about_the_end_does(name, share):
    """With the same margin of the state at rest; from the start on, instead of after some cycles."""
    states = []
    for known in (False, True):
        joint = shakedown.example(name)
        limits = shakedown.assess(joint).details
        if known:
            limits.note_what_is_known()
        states.append(shakedown.long_term_state(joint, share * limits.energy.load_factor))
        assert states[-1].proved
    alone, known = states
    assert known.proof_found.cycles == 0 <= alone.proof_found.cycles
    assert known.energy_margin == pytest.approx(alone.energy_margin, rel=1e-9)


def test_nothing_is_proved_by_a_path_that_may_be_off_by_more_than_a_margin():
    joint = shakedown.example("four-node-3d")
    ball = shakedown.energy_ball(joint, 1.0)
    off = ball.radius / np.sqrt(np.linalg.eigvalsh(joint.A).max()) / joint.n
    assert ball.contains(ball.slip)
    assert ball.contains(ball.slip, off=0.5 * off / joint.directions)
    assert not ball.contains(ball.slip, off=2.0 * off * joint.directions)
