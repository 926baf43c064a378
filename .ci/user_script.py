"""What a user writes, read by ``mypy --strict`` against the installed package (``.ci/package``)."""

import numpy as np

import shakedown
from shakedown import Outcome, Problem, Status, UsageError


def answer(problem: Problem) -> tuple[float, float]:
    """Bounds with their evidence."""
    upper = shakedown.upper_bound(problem, certify=False)
    lower = shakedown.lower_bound(problem)
    assert upper.status == Status.OPTIMAL
    active: tuple[tuple[int, int], ...] = upper.active
    return lower.load_factor, upper.load_factor + 0.0 * len(active)


def outcome(problem: Problem, load_factor: float) -> Outcome:
    """What becomes of it."""
    safe = shakedown.safe_slip(problem, load_factor)
    run = shakedown.simulate(problem, load_factor, safe.slip)
    state = shakedown.long_term_state(problem, load_factor, np.zeros(problem.n))
    slips: float = float(np.abs(state.slip_per_cycle).max())
    return run.outcome if slips >= 0.0 else state.outcome


def main() -> None:
    """Every kind of public name once."""
    problem = shakedown.example("two-node")
    found = shakedown.assess(problem)
    energy = shakedown.energy_bound(problem, distance=0.1)
    swept = shakedown.sweep(problem, {"f": [0.3, 0.4]}, bounds=("upper",))
    checked = shakedown.verify(problem, random_states=0)
    print(found.impossible_above, energy.radius, swept.upper, checked.agrees, answer(problem))
    try:
        print(outcome(problem, -1.0))
    except UsageError as error:
        print(error)


if __name__ == "__main__":
    main()
