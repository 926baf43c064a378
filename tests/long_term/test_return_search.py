"""Long-term states by the map from cycle to cycle: held against the exact ones of the plane."""

import numpy as np
import pytest

import shakedown
from shakedown.ground.status import Outcome
from shakedown.long_term.returning.extrapolation import course_of
from shakedown.long_term.returning.return_search import ReturnSearch, Rules, Settled
from shakedown.motion.contact_law import scales
from shakedown.motion.integrator import Evolution

GOAL = 1e-8


def settled(
    problem: shakedown.Problem, load_factor: float, start: np.ndarray | None
) -> tuple[Settled, float]:
    """What the search finds, and the length scale."""
    motion = Evolution(problem, load_factor, start)
    length = motion.scale.length
    rules = Rules(1000, 8, 1e-10 * length, np.ones(problem.n))
    return ReturnSearch(motion, rules).settle()


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
            apart = np.abs(found.state.u[: problem.n] - exact.final_slip).max()
            assert apart <= min(3 * found.error, 1e-7 * scale.length)
            if exact.outcome == Outcome.CYCLIC_SLIP:
                assert found.period == exact.period
                work = np.mean([record.dissipation for record in found.records])
                off = 8 * problem.n * scale.force * found.error
                assert work == pytest.approx(exact.dissipation_per_cycle, abs=off)


def test_an_affine_map_is_at_its_limit_at_once():
    rng = np.random.default_rng(1)
    J = 0.9 * np.linalg.qr(rng.normal(size=(5, 5)))[0]
    J[0], c = np.eye(5)[0], np.append(0.0, rng.normal(size=4))  # the first entry is left alone
    states = [rng.normal(size=5)]
    for _ in range(6):
        states.append(J @ states[-1] + c)
    course = course_of(np.array(states), np.eye(5))
    state = states[-1]
    for _ in range(4):
        state = J @ state + c
    np.testing.assert_allclose(course.ahead(4)[0], state, rtol=1e-9)
    np.testing.assert_allclose(course.ahead(4)[1], J @ state + c - state, rtol=1e-8)
