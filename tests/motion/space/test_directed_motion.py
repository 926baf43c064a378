"""Motion with two tangential directions: closed forms, the plane, cited numbers, symmetries, implicit steps."""

from dataclasses import replace

import numpy as np
import pytest
from joints import joint_of_kind
from joints_in_space import embedded, random_joint, turned

import shakedown
from shakedown import Problem, Tolerances
from shakedown.ground.status import OPEN, SLIP, STICK
from shakedown.ground.work_limit import limited_work
from shakedown.joint.constraints import loop_path
from shakedown.motion.checked_law import Scales, law_resolution, law_violation, scales
from shakedown.motion.course import EventKind
from shakedown.motion.event_history import curved_violations, path_violation
from shakedown.motion.evolution import Evolution, evolve
from shakedown.motion.space import space_events

# The states after one implicit step from zero: there the cited cycles begin.
STARTS = {
    "one-node-3d": [-0.027015842990502244, 0.00023374092310795498],
    "two-node-3d": [0.0] * 4,
    "four-node-3d": [0.0, 0.0, -0.5290146220121489, -0.24942939227898844, 0.0, 0.0, 0.0, 0.0],
    "block-3x3": [
        0.0, 0.0, 0.0, 0.0, 0.12151110643750376, -0.034057219558963195, 0.0, 0.0, 0.0, 0.0,
        0.14727610580136372, 0.04465661504131151, 0.06729326959773704, 0.19386645725912116,
        0.11681172480520191, 0.14560591897269123, 0.22309788592368796, 0.16473528780782157,
    ],
}  # fmt: skip
# First cycle from there, the first load step at 1.15 λ_max: load factor, dissipation and the slip
# of one node at its end, from two other implementations that agree to 5e-11.
CITED = {
    "one-node-3d": (1.4394923118619076, 0.39032975764887295, (-0.07051106817218172, 0.24922507286424272)),
    "two-node-3d": (1.0132479315128424, 0.17306179534853217, (0.005409786682076903, 0.08049787181266642)),
    "four-node-3d": (1.4087059538195088, 1.2710612252120024, (-0.5380153237876973, -0.34937990369488126)),
    "block-3x3": (3.2022995910247976, 1.2694377263112977, (0.23270131072270855, 0.13863584242388285)),
}


def node(**changes) -> Problem:
    """One node under constant pressure, with its reaction dragged across the cone."""
    given = {"A": 2 * np.eye(2), "B": [[0, 0]], "f": 0.4, "q_w": [[0.4, 0], [0.4, 1]], "p_w": [[1.0], [1.0]]}
    return Problem(**(given | changes))


@pytest.mark.parametrize("name", CITED)
def test_first_cycles_are_those_of_two_other_implementations(name):
    """Begun at the first load step."""
    problem, (load_factor, dissipation, slip) = shakedown.example(name), CITED[name]
    q, p = problem.layout.split(loop_path(problem, load_factor)[:1])
    later = {key: np.roll(getattr(problem, key), -1, axis=0) for key in ("q_w", "p_w")}
    start = replace(problem, **later, q_transient=q, p_transient=p)
    (cycle,) = evolve(start, load_factor, STARTS[name], cycles=1).cycles
    assert cycle.friction_dissipation == pytest.approx(dissipation, abs=1e-8)
    there = np.abs(cycle.end_slip.reshape(-1, 2) - slip).max(axis=1)
    assert there.min() < 1e-8
    assert 0 < cycle.error < 1e-7
    assert cycle.work.sum() == cycle.friction_dissipation


def test_tractrix():
    """A = 2 I, f p = 0.4, q from (0.4, 0), load 1 across: q = f p (cos φ, sin φ), φ = 2 arctan tanh(1/(2 f p))."""
    phi = 2 * np.arctan(np.tanh(1 / 0.8))
    closed = (0.4 * np.array([np.cos(phi), np.sin(phi)]) - [0.4, 1.0]) / 2
    np.testing.assert_allclose(closed, (-0.167385753614, -0.302677140370), atol=1e-12)
    for accuracy in (1e-6, 1e-8, 1e-10):
        (cycle,) = evolve(node(), 1.0, tolerances=Tolerances(path=accuracy)).cycles
        assert np.abs(cycle.end_slip - closed).max() < 0.5 * accuracy
        assert cycle.slip[0] == pytest.approx(cycle.friction_dissipation / 0.4)


def test_circle():
    """Q (cos t, sin t), f p constant: the slip runs on a circle of radius √(Q² − (fp)²)/A, within the chords."""
    errors = []
    for m in (60, 120):
        t = 2 * np.pi * np.arange(m)[:, None] / m
        loop = node(q_w=np.hstack([np.cos(t), np.sin(t)]), p_w=np.ones((m, 1)))
        cycle = evolve(loop, 1.0, cycles=6).cycles[-1]
        radius = np.sqrt(1 - 0.16) / 2
        errors.append([np.hypot(*cycle.end_slip) - radius, cycle.friction_dissipation - 0.8 * np.pi * radius])
    assert np.abs(errors[0]).max() < 5e-3
    np.testing.assert_allclose(np.divide(*errors), 4.0, rtol=0.05)  # second order in the load step


@pytest.mark.parametrize(("angle", "unit"), [(0.0, 1.0), (0.7, 1e-9)])
def test_load_in_one_direction_is_the_plane(angle, unit):
    """Also turned and in another unit of force, and with nodes that open and close."""
    plane = joint_of_kind(np.random.default_rng(0), "loose")
    space, turn = turned(embedded(plane), np.full(plane.n, angle))
    forces = {key: getattr(space, key) for key in ["A", "B", "C", "q_w", "p_w", "q_transient", "p_transient"]}
    space = replace(space, **{key: unit * value for key, value in forces.items() if value is not None})
    one, two = evolve(plane, 1.0, cycles=2), evolve(space, 1.0, cycles=2)
    assert any(cycle.opened.any() for cycle in one.cycles)
    for flat, curved in zip(one.cycles, two.cycles, strict=True):
        np.testing.assert_allclose(curved.end_slip, turn[:, ::2] @ flat.end_slip, atol=1e-9)
        for key, size in {"slip": 1.0, "work": unit, "opened": 1.0, "closed": 1.0}.items():
            np.testing.assert_allclose(getattr(curved, key) / size, getattr(flat, key), atol=1e-9)


def test_cycles_continue_from_their_states_to_the_last_bit():
    """Nodes open and close on the way."""
    problem = opening_joint()
    motion, other = Evolution(problem, 1.0), Evolution(problem, 1.0)
    first, _ = motion.cycle(), other.cycle()
    assert first.opened.any()
    state = motion.state
    second, third = motion.cycle(), motion.cycle()
    other.state = state
    np.testing.assert_array_equal(other.cycle().end_slip, second.end_slip)
    np.testing.assert_array_equal(other.cycle().work, third.work)
    motion.begin(1.0)
    np.testing.assert_array_equal(motion.cycle().end_slip, first.end_slip)


def opening_joint() -> Problem:
    return replace(random_joint(np.random.default_rng(5), 4, pressure=0.9, m=6), f=[0.3, 0.5, 0.0, 0.4])


def test_the_law_holds_along_the_path():
    for problem in (opening_joint(), shakedown.example("four-node-3d")):
        run = evolve(problem, 1.3, cycles=2)
        assert run.stop is None
        count = len(run.history)
        twice, wrong = run.history.rows(np.tile(np.arange(count), 2)), np.repeat([0.0, 1e-4], count)
        twice = replace(twice, v=twice.v + np.outer(wrong, np.arange(2 * problem.n) == 1))
        right, moved = curved_violations(problem, 1.3, twice, np.full(2, count))
        assert right < law_resolution(problem, Tolerances())
        assert moved > 1e-5
        for key in ("v", "w"):  # a step does not end where the path goes on
            away = getattr(run.history, key).copy()
            away[-1, 0] += 0.25
            for kind, size in ((EventKind.LOAD_STEP, 0.25), (EventKind.JUMPS, 0.0)):
                path = replace(run.history, kind=np.full(count, kind), **{key: away})
                found = path_violation(problem, 1.3, Tolerances(), path) * scales(problem, 1.3).length
                assert found == pytest.approx(size, rel=1e-9, abs=1e-7)


@pytest.mark.parametrize("place", range(4))
def test_a_node_that_passes_through_the_other_body_for_a_moment_is_found(place):
    problem = shakedown.example("four-node-3d")
    path, depth = evolve(problem, 1.3).history, 1e-3 * scales(problem, 1.3).length
    shares = np.array([0.25, 0.5, 0.75, 1.0])  # at one of them, and nowhere else of these and the beginning
    bump, curve = np.linalg.inv(shares[:, None] ** np.arange(1, 5))[:, place], path.curve.copy()
    curve[path.duration > 0, :, -1] -= depth * bump
    assert path_violation(problem, 1.3, Tolerances(), replace(path, curve=curve)) >= 0.99e-3


def test_between_rows_the_path_is_curved():
    problem = shakedown.example("block-3x3")
    history = evolve(problem, 3.2, cycles=2).history
    fine = evolve(problem, 3.2, cycles=2, tolerances=Tolerances(path=1e-11)).history
    times = np.linspace(0.2, 1.7, 60)
    one, other, rows = history.at(times), fine.at(times), history.refined()
    for key in ("v", "w", "q", "p", "q_w", "p_w", "cycle"):
        np.testing.assert_allclose(getattr(one, key), getattr(other, key), atol=1e-7)
    assert set(zip([*one.kind, *rows.kind], [*one.node, *rows.node], strict=True)) == {(EventKind.CURVES, -1)}
    np.testing.assert_allclose(rows.v, history.at(rows.cycle).v, atol=1e-12)
    np.testing.assert_array_equal(one.at(times).v, one.v)
    assert len(rows) == np.where(history.duration > 0, 4, 1).sum()
    assert EventKind.REACHES_LIMIT in history.kind


@pytest.mark.parametrize("longest_path", [space_events.MOST_TAKEN, 0])
def test_a_jump_ends_in_equilibrium(monkeypatch, longest_path):
    """Above the friction threshold of the plane's jump: the same jump, in one direction of two.

    So it is where steps of the viscous motion that have long paths are solved at once.
    """
    monkeypatch.setattr(space_events, "MOST_TAKEN", longest_path)
    monkeypatch.setattr(space_events, "STEP_OPERATIONS", space_events.STEP_OPERATIONS if longest_path else 1)
    solved, solve = [], space_events.end_at_once
    monkeypatch.setattr(space_events, "end_at_once", lambda *step: solved.append(step) or solve(*step))
    plane = shakedown.example("jump")
    space, turn = turned(embedded(plane), np.full(plane.n, 0.9))
    along, start = turn[:, ::2], plane.initial_slip[0]
    one, other = evolve(plane, 1.0, start, cycles=1), evolve(space, 1.0, along @ start, cycles=1)
    jumps, history = other.cycles[0].jumps, other.history
    assert other.stop is None
    assert set(history.node[history.kind == EventKind.JUMPS]) == {-1}
    assert len(jumps) == len(one.cycles[0].jumps) > 0
    for flat, curved in zip(one.cycles[0].jumps, jumps, strict=True):
        assert curved.energy_released == pytest.approx(flat.energy_released, rel=1e-6)
        np.testing.assert_allclose(curved.v_after, along @ flat.v_after, rtol=1e-6, atol=1e-6)
    assert other.cycles[0].dissipation == pytest.approx(one.cycles[0].dissipation, rel=1e-6)
    assert bool(solved) == (longest_path == 0)


@pytest.mark.parametrize("length", [1.0, 2.0**-30])
def test_a_step_that_is_solved_at_once_obeys_the_law(length):
    joint = random_joint(np.random.default_rng(1), 4, pressure=1.0)
    law, layout = replace(joint.law, f=joint.f * [1, 0, 1, 1]), joint.layout
    kappa, load = joint.kappa / length, layout.joined(2.0 * joint.q_w[0], joint.p_w[0])
    step = kappa, law, True, Scales(1.0, length), np.zeros(12), load
    with limited_work(np.inf) as work:
        end = space_events.end_at_once(*step, 100)
    sweeps = work.taken / layout.size**2
    assert 1 < sweeps == round(sweeps) <= 100
    assert space_events.end_at_once(*step, int(sweeps) - 1) is None
    pressed = space_events.end_at_once(*step[:-1], layout.joined(np.zeros(8), np.ones(4)), 100)
    assert pressed.contact.tolist() == [STICK, SLIP, STICK, STICK]  # without friction
    (v, w), (q, p) = layout.split(end.u), layout.split(load + kappa @ end.u)
    slip = np.where(np.repeat(w > 0, 2), 0.0, v)
    assert law_violation(law.f, q, p, w, slip, step[3]).max() <= 1e-12
    assert end.contact.tolist() == [OPEN, SLIP, STICK, SLIP]
    np.testing.assert_allclose(end.slip, law.size(slip))
    np.testing.assert_allclose(end.work, -(layout.by_node(q) * layout.by_node(slip)).sum(axis=1), atol=1e-15)


@pytest.mark.parametrize("before", [0, 1])
@pytest.mark.parametrize("seed", [4, 9, 119, 138])
def test_a_joint_is_assembled_from_nothing(seed, before):
    """Loaded in proportion from zero, at once or after another load, so that nodes slip and open at once: as
    from next to nothing, and by the law."""
    rng, ends = np.random.default_rng([5, seed]), []
    joint = random_joint(rng, 4, pressure=1.0)
    (q, p), other = ((2.0 * rng.normal(size=8), rng.normal(1.0, 1.0, 4)) for _ in range(2))
    for first in (0.0, 1e-6):
        ramp = np.array([[first], [0.25], [0.5], [1.0]])
        q_path, p_path = (np.vstack([before * x, ramp * y]) for x, y in zip(other, (q, p), strict=True))
        motion = Evolution(replace(joint, q_transient=q_path, p_transient=p_path), 0.1)
        cycle = motion.cycle(record=True)
        assert cycle is not None
        ends.append((motion.state.u, cycle.work))
        broken = path_violation(motion.problem, 0.1, motion.tolerances, motion.history)
        assert broken <= law_resolution(motion.problem, motion.tolerances)
    for one, other, near in zip(*ends, (1e-6, 1e-5), strict=True):
        assert one == pytest.approx(other, abs=near * np.abs(other).max())
