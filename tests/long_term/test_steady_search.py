"""Long-term states by the map from cycle to cycle: held against the exact ones of the plane."""

import numpy as np
import pytest

import shakedown
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.long_term.passage import Passage
from shakedown.long_term.space.followed_cycles import SearchRules
from shakedown.long_term.space.steady_search import SteadySearch
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import CycleRecord, State


def settled(
    problem: shakedown.Problem, load_factor: float, start: np.ndarray | None
) -> shakedown.LongTermState:
    """What the search finds."""
    motion = Evolution(problem, load_factor, start)
    length = motion.scale.length
    rules = SearchRules(1000, 8, 1e-10 * length, np.ones(problem.n))
    return SteadySearch(motion, Passage.of(motion), rules).settle()


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


class Turning:
    """A motion whose state turns by a p-th of a circle in every cycle, while its radius comes to a given one."""

    may_jump, stop, load_factor, tolerances = True, None, 1.0, Tolerances()

    def __init__(self, period: int, radius: float, rate: float) -> None:
        self.problem = shakedown.Problem(
            A=np.eye(2), B=np.zeros((2, 2)), f=0.5, q_w=np.zeros((1, 2)), p_w=np.ones((1, 2))
        )
        self.scale = scales(self.problem, 1.0)
        turn = 2.0 * np.pi / period
        self.turn = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
        self.radius, self.rate = radius, rate
        self.state = State(np.array([10.0 * radius, 0.0, 0.0, 0.0]), np.zeros(2, dtype=np.int64))

    def cycle(self) -> CycleRecord:
        x, y = self.turn @ self.state.u[:2]
        size = float(np.hypot(x, y))
        share = (self.radius + self.rate * (size - self.radius)) / size
        self.state = State(np.array([share * x, share * y, 0.0, 0.0]), self.state.contact)
        none, slip = np.zeros(2, dtype=bool), np.ones(2)
        return CycleRecord(self.state.u[:2], slip, slip, 1.0, 0.0, none, ~none, 1, 1, ())


@pytest.mark.parametrize("period", [2, 3, 4])
@pytest.mark.parametrize("rate", [0.5, 0.9])
def test_a_period_whose_states_differ_by_little_is_told(period, rate):
    motion = Turning(period, 1e-5, rate)
    found = SteadySearch(motion, Passage.of(motion), SearchRules(1000, 8, 1e-10, np.ones(2))).settle()
    assert (found.outcome, found.period) == (Outcome.CYCLIC_SLIP, period)


@pytest.mark.parametrize("rate", [-0.9, -0.999])
def test_states_that_come_together_have_no_longer_period(rate):
    motion = Turning(1, 0.0, rate)
    motion.state = State(np.array([1e-5, 0.0, 0.0, 0.0]), motion.state.contact)
    found = SteadySearch(motion, Passage.of(motion), SearchRules(20000, 8, 1e-10, np.ones(2))).settle()
    assert (found.outcome, found.period) == (Outcome.CYCLIC_SLIP, 1)
