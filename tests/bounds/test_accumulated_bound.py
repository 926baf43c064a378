"""The bound by accumulated slip: cited values, what changes nothing, and whatever may move nodes stays within it."""

from dataclasses import replace

import numpy as np
import pytest
from difficult_joints import floating_block
from joints_in_space import random_joint
from numpy.typing import NDArray

import shakedown
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from benchmarks.problems import random_problem
from shakedown import Problem
from shakedown.bounds import accumulated_bound
from shakedown.bounds.accumulated_bound import confirmed, total_slip_bound
from shakedown.bounds.arc_search import Slacks
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading

MOVES, RAMP = 300, 20  # how often each run may move, and load steps of the rise to the first load


class Runs:
    """Many runs of one joint: slips (r, dn), how far nodes have gone (r, n), whether p ≤ 0 was met (r,)."""

    def __init__(self, rng: np.random.Generator, problem: Problem, slip: FloatArray) -> None:
        self.rng, self.problem, self.slip = rng, problem, slip.copy()
        self.way = np.zeros((len(slip), problem.n))
        self.relieved = np.zeros(len(slip), dtype=bool)

    def excess(self, loads: FloatArray) -> FloatArray:
        """|q| − f p of every node under welded reactions (r or 1, …, (d + 1) n)."""
        problem = self.problem
        q, p = problem.layout.split(loads)
        wider = (len(self.slip), *[1] * (loads.ndim - 2), -1)
        q = q + (self.slip @ problem.A.T).reshape(wider)
        return problem.law.excess(q, p + (self.slip @ problem.B.T).reshape(wider))

    def move(self, loads: FloatArray, excess: FloatArray) -> None:
        """Every run moves a node beyond its limit (r, n) under its load (r, (d + 1) n), where there is one."""
        problem, runs, node = self.problem, np.arange(len(self.slip)), self.at_random(excess)
        q, p = problem.layout.split(loads)
        q = problem.layout.by_node(q + self.slip @ problem.A.T)[runs, node]
        p = problem.f[node] * (p + self.slip @ problem.B.T)[runs, node]
        u = self._direction(q, p)
        slack = p + np.sum(u * q, axis=1)
        A = problem.A.reshape(problem.n, problem.directions, problem.n, problem.directions)[node, :, node]
        coupled = problem.f[node] * np.sum(problem.layout.by_node(problem.B)[node, node] * u, axis=1)
        own = coupled + np.einsum("ri,rij,rj->r", u, A, u)
        part = np.where(self.rng.random(len(u)) < 0.7, 1.0, self.rng.random(len(u)))
        beyond = slack < 0.0
        far = np.where(beyond, -slack / np.where(own > 0.0, own, 1.0) * part, 0.0)
        problem.layout.by_node(self.slip)[runs, node] += far[:, None] * u
        self.way[runs, node] += np.where(beyond & (own <= 0.0), np.inf, far)
        self.relieved |= beyond & (part == 1.0) & (p + coupled * far <= 0.0)

    def at_random(self, excess: FloatArray) -> NDArray[np.intp]:
        """The number of one that is positive in every row (r, k), at random; any where none is."""
        return np.argmax(self.rng.random(excess.shape) + (excess > 0.0), axis=1)

    def _direction(self, q: FloatArray, limit: FloatArray) -> FloatArray:
        """Some direction u with limit + u · q < 0 of reactions (r, d), where there is one."""
        size = np.linalg.norm(q, axis=1)
        size = np.where(size > 0.0, size, 1.0)
        u = -q / size[:, None]
        if q.shape[1] == 1:
            return u
        widest = np.arccos(np.clip(limit / size, -1.0, 1.0))
        turn = widest * self.rng.uniform(-1.0, 1.0, len(q)) * (self.rng.random(len(q)) < 0.7)
        cosine, sine = np.cos(turn), np.sin(turn)
        return np.stack([cosine * u[:, 0] - sine * u[:, 1], sine * u[:, 0] + cosine * u[:, 1]], axis=1)


def loads_in_order(problem: Problem, load_factor: float) -> FloatArray:
    """The welded reactions (k, (d + 1) n) of the transient, of the loop and of the mean load."""
    layout, loop = problem.layout, loading(problem)
    loads = np.vstack([layout.joined(*loop.at(load_factor)), layout.joined(loop.q0, loop.p0)])
    if problem.q_transient is None:
        return loads
    return np.vstack([layout.joined(problem.q_transient, problem.p_transient), loads])


def followed(rng: np.random.Generator, problem: Problem, load_factor: float, slips: FloatArray) -> Runs:
    """Runs from slips (r, dn): the load rises to its first step, then goes anywhere in the hull of all."""
    runs, corners = Runs(rng, problem, slips), loads_in_order(problem, load_factor)
    first, locked_p = corners[0], slips @ problem.B.T
    pressed = np.abs(problem.layout.split(first)[1] + locked_p)
    low = problem.layout.joined(-slips @ problem.A.T, pressed - locked_p)
    with np.errstate(over="ignore", invalid="ignore"):
        for s in np.linspace(0.0, 1.0, RAMP).repeat(2):
            loads = (1.0 - s) * low + s * first
            runs.move(loads, runs.excess(loads))
        for _ in range(MOVES // 2):
            weight = rng.exponential(size=(len(slips), len(corners))) ** 4
            loads = weight / weight.sum(axis=1, keepdims=True) @ corners
            runs.move(loads, runs.excess(loads))
            excess = runs.excess(corners[None])
            worst = runs.at_random(excess.max(axis=2))
            runs.move(corners[worst], excess[np.arange(len(slips)), worst])
    return runs


@pytest.mark.parametrize(
    ("problem", "share", "accuracy"),
    [
        (shakedown.example("three-node"), 0.540, 5e-4),
        (shakedown.example("pair-cycle"), 0.540, 5e-4),
        (replace(shakedown.example("two-node"), load_path="domain"), 0.7316 / 0.7391456, 1e-4),
        (floating_block(9, 0.3), 0.987, 1e-3),
        (floating_block(9, 0.5), 0.857, 1e-3),
        (floating_block(9, 0.8), 0.733, 1e-3),
        (shakedown.example("one-node-3d"), 0.95 * 0.998, 6e-3),
        (shakedown.example("four-node-3d"), 0.94 * 0.878, 6e-3),
    ],
)
def test_cited_values(problem: Problem, share: float, accuracy: float) -> None:
    bound = shakedown.accumulated_bound(problem)
    most = shakedown.upper_bound(problem, certify=False).load_factor
    assert bound.load_factor / most == pytest.approx(share, abs=accuracy)
    assert (bound.certified is not None) == (problem.directions == 1)


def pulled_chain(resistance: float, accuracy: float | None) -> Problem:
    """Three nodes in a row on friction alone, pulled one way: as stored a rigid slip meets a resistance."""
    A = np.array([[1.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]]) + resistance / 3.0
    q_w = 1.0 + np.outer([1.0, 0.0, -1.0, 0.0], np.ones(3))
    return Problem(
        A=A, B=np.zeros((3, 3)), f=0.3, q_w=q_w, p_w=np.full((4, 3), 10.0), stiffness_accuracy=accuracy
    )


def test_gross_slip_is_not_held_by_round_off_of_the_data() -> None:
    problem = pulled_chain(1e-4, 2e-4)
    bound = shakedown.accumulated_bound(problem)
    assert 2.0 * (1.0 - 1e-6) < bound.load_factor <= shakedown.upper_bound(problem).load_factor
    assert bound.certified
    assert total_slip_bound(problem, 2.00005).status == "infeasible"


def test_what_may_be_rigid_is_not_certified() -> None:
    unclear, clear = (shakedown.accumulated_bound(pulled_chain(1e-6, known)) for known in (None, 1e-12))
    assert clear.load_factor > 2.5  # after slips of a million: a resistance in doubt counts as none
    assert unclear.load_factor == pytest.approx(2.0, rel=1e-6)
    assert clear.certified
    assert not unclear.certified


@pytest.mark.parametrize("start", ["zero", "random", "off"])
@pytest.mark.parametrize("drawn", [drawn_joint, drawn_joint_in_space])
def test_nothing_that_may_move_a_node_moves_it_farther(drawn, start: str) -> None:
    """At 1.3 λ_S, the control, something does."""
    rng, beyond, joints = np.random.default_rng(4), 0, 0
    for number in range(20):
        problem = drawn(4, number)
        size = np.abs(loading(problem).q1).max() / np.abs(problem.A).max() if problem.A.any() else 0.0
        given = size * rng.normal(size=problem.layout.slip_size) * (start == "random")
        error = 0.01 * size * (start == "off")
        bound = shakedown.accumulated_bound(problem, given, start_error=error)
        if bound.status != "optimal" or not bound.total_slip.max() > 0.0:
            continue
        joints += 1
        away = rng.normal(size=(20, problem.n, problem.directions))
        slips = given + (error * away / np.linalg.norm(away, axis=2, keepdims=True)).reshape(20, -1)
        most = bound.total_slip + 1e-6 * bound.total_slip.max()
        runs = followed(rng, problem, bound.load_factor, slips)
        assert np.all(runs.way <= most)
        assert not runs.relieved.any()
        above = followed(rng, problem, 1.3 * bound.load_factor, slips)
        beyond += bool(np.any(above.way > most) or above.relieved.any())
        if joints == 2:
            break
    assert joints == 2
    assert beyond > 0


def test_the_check_notices_what_is_wrong() -> None:
    """A larger load, a smaller a, a smaller N, a start farther off, an arc less: none is confirmed."""
    problem = shakedown.example("three-node")
    bound = shakedown.accumulated_bound(problem)
    arcs = bound.arcs
    assert arcs is not None

    def holds(at=bound.load_factor, off=0.0, **changes) -> bool:
        return confirmed(problem, bound.initial_slip, bound.start_error + off, at, replace(arcs, **changes))

    assert holds()
    assert not holds(at=bound.load_factor * 1.01)
    assert not holds(alone=arcs.alone * 0.99)
    assert not holds(coupling=arcs.coupling * 0.99) or not arcs.coupling.any()
    assert not holds(off=0.01 * bound.total_slip.max())
    fewer = {name: getattr(arcs, name)[1:] for name in ("node", "first", "last", "alone")}
    part = arcs.coupling[1:, 1:]
    assert not holds(**fewer, coupling=part, inverse=np.linalg.inv(np.eye(len(part)) - part))


@pytest.mark.parametrize("off", [1e-8, 1e-6])
def test_what_is_not_confirmed_is_reduced_by_little_more_than_it_takes(monkeypatch, off) -> None:
    problem, bisected = shakedown.example("two-node"), accumulated_bound._bisected
    most = (1.0 + off) * shakedown.accumulated_bound(problem).load_factor
    monkeypatch.setattr(accumulated_bound, "_bisected", lambda *given: (most, *bisected(*given)[1:]))
    bound = shakedown.accumulated_bound(replace(problem))
    assert bound.certified == bound.load_factor
    assert off < 1.0 - bound.load_factor / most < 11 * off


def test_a_start_that_is_not_known_well_proves_less() -> None:
    problem, start = random_problem(3, 3), np.array([0.03, 0.0, -0.02])
    bounds = [
        shakedown.accumulated_bound(problem, start, start_error=e).load_factor for e in (0.0, 0.02, 0.05)
    ]
    assert bounds[0] > bounds[1] > bounds[2]
    for away in np.array([[1, 1, 1], [1, -1, 1], [-1, 0, 1]]):
        near = shakedown.accumulated_bound(problem, start + 0.02 * away)
        assert near.load_factor >= bounds[1] * (1 - 1e-6)


def test_what_is_not_proved_is_a_status() -> None:
    problem = shakedown.example("two-node")
    smooth = shakedown.accumulated_bound(replace(problem, f=[0.3, 0.0]))
    assert (smooth.status, smooth.limited_by, smooth.node) == ("infeasible", "frictionless", 1)
    relieved = shakedown.accumulated_bound(problem, [50.0, -40.0])
    assert (relieved.status, relieved.limited_by) == ("infeasible", "start")
    steep = shakedown.accumulated_bound(replace(shakedown.example("one-node"), f=40.0))
    assert (steep.status, steep.limited_by, steep.total_slip) == ("optimal", "own limit", [0.0])
    still = replace(problem, q_w=np.tile(problem.q_w.mean(axis=0), (4, 1)), p_w=np.full((4, 2), 1500.0))
    rest = shakedown.accumulated_bound(still)
    assert (rest.status, rest.load_factor, rest.limited_by) == ("unbounded", np.inf, "")
    assert shakedown.accumulated_bound(drawn_joint_in_space(3, 17)).status == "optimal"  # by narrower sectors
    for error in (-1.0, [0.1], np.nan):
        with pytest.raises(shakedown.UsageError, match="start error"):
            shakedown.accumulated_bound(problem, start_error=error)


@pytest.mark.parametrize("number", range(4))
def test_nothing_is_proved_above_the_bound(number: int) -> None:
    problem = random_joint(np.random.default_rng(number), 2)
    bound = shakedown.accumulated_bound(problem)
    ends = [0.0, 1.0] if bound.status == "infeasible" else [(1 + 3e-4) * bound.load_factor]
    assert all(total_slip_bound(problem, end).status == "infeasible" for end in ends)


def test_transient_load_steps_and_given_means_count() -> None:
    problem = shakedown.example("two-node")
    here = shakedown.accumulated_bound(problem)
    pushed = replace(problem, q_transient=[[-700.0, 0.0]], p_transient=[[900.0, 1500.0]])
    assert shakedown.accumulated_bound(pushed).load_factor < here.load_factor
    off = replace(problem, q_mean=problem.q_w.mean(axis=0) + 4000.0, p_mean=problem.p_w.mean(axis=0))
    assert shakedown.accumulated_bound(off).status == "infeasible"  # at λ = 0 it is the mean load alone


def test_of_a_slack_that_the_mean_load_leaves_nothing_the_first_to_be_used_up_later_is_told() -> None:
    slacks = Slacks(np.array([0.0, 2.0, 3.0, 1.0]), np.array([1.0, 4.0, 1.0, -1.0]), np.full(4, np.inf))
    assert slacks.elastic == 0.5
