"""Long-term states by the map from cycle to cycle: held against the exact ones of the plane."""

import numpy as np
import pytest

import shakedown
from shakedown.ground.status import Outcome
from shakedown.long_term.motion_start import MotionStart
from shakedown.long_term.space.followed_cycles import SearchRules
from shakedown.long_term.space.steady_search import SteadySearch
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import Evolution


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
