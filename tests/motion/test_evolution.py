"""Exact evolution: the law between events, invariance, degenerate states, many cycles in a call, Gauss–Seidel.

Joints followed at fixed load steps: cycles, order of the error, starts, ends that are no cycle.
"""

from dataclasses import replace

import numpy as np
import pytest
from joints import joint_of_kind
from joints_in_space import embedded, random_joint

import shakedown
from shakedown import Problem
from shakedown.ground.errors import UsageError
from shakedown.joint.constraints import loading
from shakedown.joint.units import without_loads
from shakedown.motion.checked_law import law_violation, scales
from shakedown.motion.course import EventKind
from shakedown.motion.event_history import path_violation
from shakedown.motion.evolution import Evolution, evolve
from shakedown.motion.fixed_steps import FixedSteps
from shakedown.motion.method import Motion, walk


def worst_violation(problem, load_factor, history, points=20):
    """Friction law at every event and at points between, from v, w and the load alone."""
    scale, n = scales(problem, load_factor), problem.n
    k = np.flatnonzero((np.diff(history.cycle) > 0) & (history.kind[1:] != EventKind.JUMPS))
    s = np.linspace(0, 1, points + 2)[:, None, None]
    columns = history.v, history.w, history.q_w, history.p_w
    v, w, q_w, p_w = (values[k] + s * (values[k + 1] - values[k]) for values in columns)
    change = np.concatenate([v, w], axis=-1) @ problem.kappa
    q, p = q_w + change[..., :n], p_w + change[..., n:]
    closed = (history.w[k] <= 1e-13 * scale.length) & (history.w[k + 1] <= 1e-13 * scale.length)
    slip = np.where(closed, history.v[k + 1] - history.v[k], 0.0) * np.ones_like(s)
    return law_violation(problem.f, q, p, w, slip, scale).max(initial=0.0)


@pytest.mark.parametrize("seed", range(4))
def test_law_holds_at_and_between_events_of_random_problems(seed):
    rng, separated = np.random.default_rng(seed), 0
    for _ in range(50):
        problem, load_factor = joint_of_kind(rng, "loose"), rng.uniform(0.3, 2.0)
        run = evolve(problem, load_factor, cycles=2)
        assert run.stop is None
        assert worst_violation(problem, load_factor, run.history) <= 1e-12
        assert np.abs(np.diff(run.history.v, axis=0)[np.diff(run.history.cycle) == 0]).max(initial=0) == 0
        separated += any(cycle.opened.any() for cycle in run.cycles)
    assert separated >= 50 / 3


def split(problem, parts):
    """Every load step cut into equal parts; the first row stays first."""
    m = problem.m

    def cut(samples):
        before = np.roll(samples, 1, axis=0)
        steps = np.arange(1, parts + 1)[None, :, None] / parts
        rows = (before[:, None] + steps * (samples - before)[:, None]).reshape(m * parts, -1)
        return np.roll(rows, 1 - parts, axis=0)

    means = {"q_mean": loading(problem).q0, "p_mean": loading(problem).p0}
    return replace(without_loads(problem), q_w=cut(problem.q_w), p_w=cut(problem.p_w), **means)


@pytest.mark.parametrize("seed", range(4))
def test_path_does_not_depend_on_the_load_steps(seed):
    rng = np.random.default_rng(100 + seed)
    for _ in range(15):
        problem, load_factor = joint_of_kind(rng, "loose"), rng.uniform(0.3, 2.0)
        history, last = evolve(problem, load_factor, cycles=4).history, 4.0 - 1.0 / problem.m
        times = np.linspace(0.0, last, 81)
        span = f"{history.cycle[0]:g} to {last:g}"
        with pytest.raises(UsageError, match=f"^cycle: expected times from {span}, found 5$"):
            history.at([3.0, 5.0])
        np.testing.assert_array_equal(history.at(history.cycle[:1]).v, history.v[:1])
        path = history.at(times)
        finer = evolve(split(problem, 7), load_factor, cycles=4).history.at(times)
        scale = scales(problem, load_factor)
        for keys, size in (("v w", scale.length), ("q p q_w p_w", scale.force)):
            for key in keys.split():
                assert np.abs(getattr(path, key) - getattr(finer, key)).max() <= 1e-11 * size
        np.testing.assert_allclose(path.cycle, times, rtol=0.0, atol=1e-14)
        assert set(zip(path.kind, path.node, strict=True)) == {(EventKind.LOAD_STEP, -1)}


@pytest.mark.parametrize("name", ["two-node", "three-node", "block-9"])
def test_gauss_seidel_comes_nearer_with_finer_load_steps(name):
    problem = shakedown.example(name)
    problem = replace(problem, q_transient=None, p_transient=None)
    load_factor = {"two-node": 1.5, "three-node": 2.6, "block-9": 7.0}[name]
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    exact = shakedown.long_term_state(problem, load_factor, start)
    errors = []
    for parts in (1, 8):
        run = shakedown.simulate(split(problem, parts), load_factor, start, method="gauss-seidel", cycles=300)
        errors.append(np.abs(run.slip_per_cycle - exact.slip_per_cycle).max())
    size = exact.slip_per_cycle.max()
    assert errors[-1] <= max(0.35 * errors[0], 1e-7 * size)


@pytest.mark.parametrize("excess", [-1e-16, 0.0, 1e-14])
@pytest.mark.parametrize("seed", range(6))
def test_a_corner_that_is_touched_causes_no_slip(seed, excess):
    """The load brings every node to one of its limits at the same instant, and to the other, and retreats."""
    rng = np.random.default_rng(seed)
    problem = replace(joint_of_kind(rng, "loose"), q_transient=None, p_transient=None)
    n, side = problem.n, rng.choice([-1.0, 1.0], problem.n)
    start = rng.normal(size=n)
    p = rng.uniform(0.5, 2.0, n)
    inside, share = 0.5 * side * problem.f * p, 2.0 * (1.0 + excess)
    q_w = np.outer([1.0, share, 1.0, share, -1.0, -share], inside) - problem.A @ start
    corner = replace(problem, q_w=q_w, p_w=np.tile(p - problem.B @ start, (6, 1)))
    run = evolve(corner, 1.0, start, cycles=3)
    assert not any(cycle.opened.any() for cycle in run.cycles)
    assert np.abs(run.history.v - start).max() <= 1e-13 * np.abs(start).max()
    assert shakedown.long_term_state(corner, 1.0, start).outcome == "shakedown"


def test_normal_load_alone_opens_and_closes_without_slip():
    p_w = [[1.0], [-1.0], [-2.0], [-1.0]]
    problem = Problem(A=[[1.0]], B=[[0.0]], C=[[1.0]], f=0.5, q_w=[[0.0]] * 4, p_w=p_w)
    run = evolve(problem, 1.0, cycles=3)
    assert run.cycles[-1].opened.all()
    assert run.cycles[-1].slip.max() == 0.0
    assert run.history.w.max() == pytest.approx(2.0)
    state = shakedown.long_term_state(problem, 1.0)
    assert (state.outcome, state.period) == ("separation", 1)


def test_frictionless_node_follows_its_load_without_dissipation():
    q_w = [[1.0], [0.0], [-1.0], [0.0]]
    problem = Problem(A=[[1.0]], B=[[0.2]], C=[[1.0]], f=0.0, q_w=q_w, p_w=[[2.0]] * 4)
    run = evolve(problem, 1.0, cycles=2)
    assert np.abs(run.history.q).max() <= 1e-15
    assert run.cycles[-1].dissipation == pytest.approx(0.0, abs=1e-15)
    assert run.cycles[-1].slip == pytest.approx(4.0)


def test_a_path_run_backwards_breaks_the_law():
    """Its reactions are the same, and friction would push the slips on."""
    problem = shakedown.example("two-node")
    ahead = evolve(problem, 0.9, cycles=3).history
    back = ahead.rows(np.arange(len(ahead))[::-1])
    broken = [path_violation(problem, 0.9, shakedown.Tolerances(), path) for path in (ahead, back)]
    assert broken[0] <= 1e-9
    assert broken[1] > 0.01


SCENES = [("two-node", 0.8), ("two-node", 1.5), ("three-node", 2.6), ("block-9", 5.0), ("uncoupled", 1.5)]


@pytest.mark.parametrize(("name", "load_factor"), SCENES)
def test_neither_a_record_nor_many_cycles_in_one_call_change_the_path(name, load_factor):
    problem = shakedown.example(name)
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    one, recorded, many = (Evolution(problem, load_factor, start) for _ in range(3))
    for _ in range(12):
        a, b = one.cycle(), recorded.cycle(record=True)
        assert (a.events, a.dissipation, a.signature) == (b.events, b.dissipation, b.signature)
        assert np.array_equal(a.slip, b.slip)
    assert many.advance(12) == many.done == one.done == 12
    assert np.array_equal(one.state.u, many.state.u)
    assert np.array_equal(one.state.contact, many.state.contact)
    assert (recorded.history.kind == EventKind.LOAD_STEP).sum() >= 12 * problem.m
    assert len(one.history) == 1


def joint(pressure=3.0) -> Problem:
    return random_joint(np.random.default_rng(0), 4, pressure=pressure, m=24)


def test_what_a_cycle_did_is_what_its_load_steps_say():
    problem = joint(0.3)
    motion: Motion = FixedSteps(problem, 1.3)
    first, second = motion.cycle(record=True), motion.cycle(record=True)
    history = motion.history
    assert history.v.shape == (2 * problem.m, 8)
    before = np.vstack([np.zeros(8), history.v[:-1]])
    slip = np.where(np.repeat(history.w > 0, 2, axis=1), 0.0, history.v - before)
    closing = (history.w == 0) & (np.vstack([np.zeros(4), history.w[:-1]]) > 0)
    assert closing.any()
    still = ~closing.any(axis=0)
    length = problem.law.size(slip)
    np.testing.assert_allclose((first.slip + second.slip)[still], length.sum(axis=0)[still], rtol=1e-9)
    held = np.where(np.repeat(closing, 2, axis=1), 0.0, slip)
    assert law_violation(problem.f, history.q, history.p, history.w, held, motion.scale).max() < 1e-10
    assert first.opened.any()
    assert second.dissipation == pytest.approx(second.work.sum())
    assert (first.events, first.signature, first.jumps, first.error) == (0, 0, (), 0.0)
    np.testing.assert_array_equal(second.end_slip, history.v[-1])


def test_what_a_cycle_of_one_node_ends_with_stays_so():
    joint = Problem(A=np.eye(2), B=np.zeros((1, 2)), f=0.3, q_w=[[1.0, 0.0], [0.0, 1.0]], p_w=[[2.0], [2.0]])
    motion = FixedSteps(joint, 1.0)
    first = motion.cycle().end_slip
    kept = first.copy()
    motion.cycle()
    np.testing.assert_array_equal(first, kept)
    assert (motion.state.u[:2] != kept).any()


def test_loaded_in_one_direction_is_the_plane():
    plane = shakedown.example("two-node")
    one, other = walk(FixedSteps(plane, 0.9), 3), walk(FixedSteps(embedded(plane), 0.9), 3)
    size = np.abs(one.end_slip).max()
    np.testing.assert_allclose(other.end_slip[:, ::2], one.end_slip, atol=1e-11 * size)
    np.testing.assert_allclose(other.slip, one.slip, atol=1e-11 * size)
    np.testing.assert_allclose(other.dissipation, one.dissipation, rtol=1e-10)


def test_a_start_that_the_law_does_not_allow_becomes_one_that_it_does():
    problem = joint()
    motion = FixedSteps(problem, 1.0, np.full(8, 2.0))
    motion.cycle(record=True)
    first = motion.history.rows(np.arange(1))
    assert motion.problem.law.excess(problem.A @ np.full(8, 2.0) + problem.q_w[0], problem.p_w[0]).max() > 1
    excess = problem.law.excess(first.q, np.where(first.w > 0, 0.0, first.p))
    assert excess.max() < 1e-11 * motion.scale.force


def test_a_stop_tells_when_a_node_lifts_off():
    """Between loads 1 and 2 of 4 the pressure falls from 1 to -3: after a quarter of that step."""
    joint = Problem(A=[[1.0]], B=[[0.0]], f=0.5, q_w=np.zeros((4, 1)), p_w=[[1.0], [1.0], [-3.0], [1.0]])
    assert evolve(joint, 1.0).stop.cycle == pytest.approx(1.25 / 4)


def test_transient_load_steps_come_first():
    problem = joint()
    pushed = replace(problem, q_transient=np.full((3, 8), 4.0), p_transient=np.full((3, 4), 3.0))
    motion = FixedSteps(pushed, 0.2)
    assert len(motion.history) == 3
    assert motion.history.cycle[0] == -3 / 24
    assert np.abs(motion.start).max() == 0.0
    assert np.abs(motion.state.u).max() > 0.0


def test_what_cannot_be_followed_stops_with_a_reason():
    A = np.kron([[1.0, -1.0], [-1.0, 1.0]], np.eye(2))
    loop = {"q_w": [[0.0] * 4, [1.0, 0.0] * 2], "p_w": np.ones((2, 2)), "q_mean": [0.0] * 4}
    free = FixedSteps(Problem(A=A, B=np.zeros((2, 4)), f=0.5, **loop), 1.0)
    assert free.cycle() is None
    assert free.stop.slides_away
    assert walk(free, 1).slip.shape == walk(free, 1).open_nodes.shape == (0, 0)
    assert not any(len(getattr(free.history, key)) for key in free.history.__dataclass_fields__)
    assert free.stop.reason == "the body slides away at load step 1"
    pulled = {"q_w": np.zeros((2, 4)), "p_w": [[1.0, 1.0], [1.0, -1.0]]}
    held = FixedSteps(Problem(A=np.eye(4), B=np.zeros((2, 4)), f=0.5, **pulled), 1.0)
    assert held.cycle() is None
    assert held.stop.reason == "node 1 lifts off at load step 1, and the problem has no C"
    assert held.cycle() is None
