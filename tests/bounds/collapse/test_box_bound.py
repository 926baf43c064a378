"""The box bound: known values, the box and the collapse by second methods, and motions that stay inside."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import linprog

import shakedown
from benchmarks.problems import in_units, random_problem
from shakedown import Problem
from shakedown.bounds.collapse.box_bound import box_proves
from shakedown.bounds.collapse.least_box import BoxMap
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.constraints import constraints
from shakedown.joint.loading import loading
from shakedown.motion.evolution import Evolution

KNOWN = [
    ("two-node", None, 0.73159),
    ("press-fit", None, 0.35199),
    ("block-9", 0.2, 1.6827),
    ("block-9", 0.5, 4.6998),
    ("block-33", 0.2, 1.4222),
    ("block-33", 0.6, 4.7088),
]


def built_in(name: str, f: float | None = None) -> Problem:
    problem = shakedown.example(name)
    return problem if f is None else replace(problem, f=f)


def weakly_coupled(seed: int, n: int = 4) -> Problem:
    return next(
        problem
        for problem in (random_problem(n, 100 * seed + k, coupling=0.5) for k in range(100))
        if coupling(problem).bound < 0.98 and shakedown.lower_bound(problem).load_factor > 0
    )


def limits(problem: Problem, load_factor: float, low: np.ndarray, high: np.ndarray):
    """Largest forward and smallest backward limit of every node over a box, corner by corner of each sum."""
    rows, n = constraints(problem), problem.n
    forward, backward = np.empty(n), np.empty(n)
    for i in range(n):
        for side, ends in ((0, backward), (1, forward)):
            row, own = rows.G[2 * i + side], rows.G[2 * i + side, i]
            ends[i] = (rows.g[2 * i + side] - load_factor * rows.d[2 * i + side]) / own
            for j in set(range(n)) - {i}:
                parts = -row[j] / own * low[j], -row[j] / own * high[j]
                ends[i] += max(parts) if side else min(parts)
    return forward, backward


@pytest.mark.parametrize(("name", "f", "expected"), KNOWN)
def test_values_from_slip_zero(name: str, f: float | None, expected: float) -> None:
    problem = built_in(name, f)
    bound = shakedown.box_bound(problem)
    assert bound.status == "optimal"
    assert bound.load_factor == pytest.approx(expected, abs=1e-4)
    assert bound.load_factor >= expected - 5e-6
    assert shakedown.lower_bound(problem).load_factor <= bound.load_factor
    assert bound.load_factor <= shakedown.upper_bound(problem).load_factor
    state = shakedown.long_term_state(problem, bound.load_factor * (1 - 1e-6), np.zeros(problem.n))
    assert state.outcome == "shakedown"


@pytest.mark.parametrize("seed", range(2))
def test_the_box_is_the_limit_of_widening_it(seed: int) -> None:
    problem, rng = weakly_coupled(seed), np.random.default_rng(seed)
    for load_factor in (0.0, 0.3, 1.0):
        start = 2 * rng.normal(size=problem.n)
        box = BoxMap(problem, transient=False).around(start, load_factor)
        low, high = start.copy(), start.copy()
        for _ in range(2000):
            forward, backward = limits(problem, load_factor, low, high)
            low, high = np.minimum(low, backward), np.maximum(high, forward)
        size = np.abs(high - low).max()
        np.testing.assert_allclose(box.low, low, atol=1e-9 * size)
        np.testing.assert_allclose(box.high, high, atol=1e-9 * size)
        forward, backward = limits(problem, load_factor, box.low, box.high)
        assert np.all(forward <= box.high + 1e-14 * size)
        assert np.all(backward >= box.low - 1e-14 * size)


@pytest.mark.parametrize("seed", range(4))
def test_the_first_collapse_in_the_box_by_a_second_method(seed: int) -> None:
    problem = weakly_coupled(seed)
    bound, rows = shakedown.box_bound(problem), constraints(problem)
    assert bound.limited_by == "first collapse"
    for share, expected in ((1 - 1e-6, False), (1 + 1e-6, True)):
        load_factor = share * bound.load_factor
        box = BoxMap(problem, transient=False).around(bound.initial_slip, load_factor)
        collapsed = False
        for node in range(problem.n):
            sign = np.where(rows.node == node, -1.0, 1.0)
            found = linprog(
                np.append(np.zeros(problem.n), 1.0),
                sign[:, None] * np.column_stack([rows.G, rows.d]),
                sign * rows.g,
                bounds=[*zip(box.low, box.high, strict=True), (0, None)],
            )
            assert found.status in (0, 2)
            collapsed |= found.status == 0 and found.fun < load_factor
        assert collapsed == expected


@pytest.mark.parametrize("seed", range(3))
def test_motions_stay_in_the_box_and_come_to_rest(seed: int) -> None:
    """From admissible corners and points of the box, just below the bound; above it the witness cycles."""
    problem, rng = weakly_coupled(seed, n=3), np.random.default_rng(seed)
    bound = shakedown.box_bound(problem, 0.3 * rng.normal(size=3))
    load_factor = 0.999 * bound.load_factor
    box = BoxMap(problem, transient=False).around(bound.initial_slip, load_factor)
    q, p = loading(problem).at(load_factor)
    tried = 0
    for share in [*np.ndindex(2, 2, 2), *rng.random((60, 3))]:
        slip = box.low + np.asarray(share) * (box.high - box.low)
        if np.any(np.abs(q[0] + problem.A @ slip) > problem.f * (p[0] + problem.B @ slip)):
            continue
        tried += 1
        state = shakedown.long_term_state(problem, load_factor, slip)
        assert state.outcome == "shakedown"
        assert np.all(state.final_slip >= box.low - 1e-9)
        assert np.all(state.final_slip <= box.high + 1e-9)
    assert tried > 5
    witness = shakedown.long_term_state(problem, 1.001 * bound.load_factor, bound.slip)
    assert witness.outcome == "cyclic-slip"


@pytest.mark.parametrize("name", ["two-node", "block-9", "press-fit"])
def test_about_a_safe_slip_the_box_is_a_point(name: str) -> None:
    problem = shakedown.example(name)
    upper = shakedown.upper_bound(problem)
    bound = shakedown.box_bound(problem, upper.slip)
    assert bound.load_factor == pytest.approx(upper.load_factor, rel=1e-8)
    np.testing.assert_allclose(bound.low, bound.high, atol=1e-6 * np.abs(upper.slip).max())


@pytest.mark.parametrize(
    ("name", "f", "limit", "cycles"),
    [("block-9", 0.2, 1.708735, 1), ("block-9", 0.5, 4.702985, 1), ("two-node", None, 0.731593, 1)],
)
def test_the_state_after_few_cycles_proves_almost_up_to_the_transient_limit(
    name: str, f: float | None, limit: float, cycles: int
) -> None:
    problem = built_in(name, f)
    load_factor = limit * (1 - 5e-4)
    motion = Evolution(problem, load_factor, np.zeros(problem.n), DEFAULT)
    for _ in range(cycles):
        motion.cycle()
    assert box_proves(problem, motion.method.u[: problem.n].copy(), load_factor, DEFAULT)
    beyond = shakedown.long_term_state(problem, limit * (1 + 1e-5))
    assert beyond.outcome != "shakedown"
    assert not box_proves(problem, beyond.final_slip, beyond.load_factor, DEFAULT)


@pytest.mark.parametrize(("force", "length"), [(2.0**20, 1.0), (1.0, 2.0**-15), (2.0**-30, 2.0**12)])
def test_units_and_directions_do_not_matter(force: float, length: float) -> None:
    problem, start = weakly_coupled(1), np.array([0.2, -0.1, 0.3, 0.0])
    here = shakedown.box_bound(problem, start)
    there = shakedown.box_bound(in_units(problem, force, length), start * length)
    assert there.load_factor == pytest.approx(here.load_factor, rel=1e-12)
    np.testing.assert_allclose(there.high, here.high * length, rtol=1e-9)
    mirrored = replace(problem, B=-problem.B, q_w=-problem.q_w)
    back = shakedown.box_bound(mirrored, -start)
    assert back.load_factor == pytest.approx(here.load_factor, rel=1e-9)
    np.testing.assert_allclose(back.low, -here.high, rtol=1e-6, atol=1e-9)


def test_what_is_not_proved_is_a_status() -> None:
    strong = shakedown.box_bound(shakedown.example("three-node"))
    assert (strong.status, strong.limited_by) == ("infeasible", "coupling")
    assert np.isnan(strong.load_factor)
    problem = shakedown.example("two-node")
    unsafe = shakedown.box_bound(replace(problem, p_w=problem.p_w - 9000.0))
    assert (unsafe.status, unsafe.limited_by) == ("infeasible", "mean load")
    still = replace(problem, q_w=np.tile(problem.q_w.mean(axis=0), (4, 1)), p_w=np.full((4, 2), 1500.0))
    assert shakedown.box_bound(still).status == "unbounded"
    with pytest.raises(shakedown.UsageError, match="slip"):
        shakedown.box_bound(problem, [0.0])


def test_transient_load_steps_widen_the_box() -> None:
    problem = shakedown.example("two-node")
    pushed = replace(problem, q_transient=[[-700.0, 0.0]], p_transient=[[900.0, 1500.0]])
    here, there = shakedown.box_bound(problem), shakedown.box_bound(pushed)
    assert there.load_factor < here.load_factor
    state = shakedown.long_term_state(pushed, 0.999 * there.load_factor, np.zeros(2))
    assert state.outcome == "shakedown"
    lifted = replace(problem, q_transient=[[0.0, 0.0]], p_transient=[[-900.0, 1500.0]])
    assert shakedown.box_bound(lifted).limited_by == "transient"


def test_a_slip_that_the_first_load_does_not_admit_must_leave_every_node_pressed() -> None:
    """The load rises to its first step on a path of its own: there only pressure all over the box is a proof."""
    problem, relieved = shakedown.example("two-node"), np.array([50.0, -40.0])
    assert np.min(problem.p_w[0] + problem.B @ relieved) < 0
    bound = shakedown.box_bound(problem, relieved)
    assert (bound.status, bound.limited_by) == ("infeasible", "start")
    pressed = shakedown.box_bound(problem, [2.0, -1.0])  # at neither of the limits that it violates
    assert pressed.load_factor > 0
    state = shakedown.long_term_state(problem, 0.999 * pressed.load_factor, [2.0, -1.0])
    assert state.outcome == "shakedown"


def test_a_search_cut_short_proves_what_it_has_reached(monkeypatch) -> None:
    joint = replace(shakedown.example("block-33"), f=np.full(33, 0.2))
    whole = shakedown.box_bound(joint)
    monkeypatch.setattr("shakedown.bounds.collapse.box_bound.WORK", 0)
    short = shakedown.box_bound(joint)
    assert short.limited_by == "search cut short"
    assert shakedown.lower_bound(joint).load_factor * (1 - 1e-9) <= short.load_factor <= whole.load_factor
