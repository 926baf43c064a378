"""What a verification simulates: load factors in every region, several initial states, predictions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from shakedown.bounds.lower import LowerBound
from shakedown.bounds.safe_slip import safe_slip
from shakedown.bounds.upper import UpperBound
from shakedown.model.loading import loading
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.status import Status
from shakedown.tolerances import DEFAULT, Tolerances

UNSAFE, BELOW, BETWEEN, ABOVE = "below λ_lo", "below λ_1", "between", "above λ_max"


@dataclass(frozen=True)
class Case:
    """One simulation to be made.

    Attributes
    ----------
    region
        Where the load factor lies: below λ_1, between the bounds, above λ_max; below
        λ_lo where safe slips exist only from there on.
    load_factor
        λ.
    initial, start
        Name of the initial state, and its slip (n,) [length].
    """

    region: str
    load_factor: float
    initial: str
    start: FloatArray

    @property
    def predicted(self) -> str:
        """ "shakedown", "no shakedown", or "either" where the bounds predict nothing."""
        if self.region in (UNSAFE, ABOVE):
            return "no shakedown"
        return "shakedown" if self.region == BELOW or self.initial == "safe" else "either"


def planned_cases(
    problem: Problem,
    lower: LowerBound,
    upper: UpperBound,
    load_factors: Sequence[float] | None,
    random_states: int,
    seed: int,
    tolerances: Tolerances = DEFAULT,
) -> Iterator[Case]:
    """Every simulation that a verification asks for, load factor by load factor."""
    generator = np.random.default_rng(seed)
    randoms = generator.uniform(-1.0, 1.0, (random_states, problem.n))
    centre = np.zeros(problem.n) if np.isnan(upper.slip).any() else upper.slip
    given = problem.initial_slip if problem.initial_slip is not None else np.empty((0, problem.n))
    for load_factor in (
        default_load_factors(lower, upper, tolerances) if load_factors is None else load_factors
    ):
        region = region_of(load_factor, lower, upper)
        safe = upper.slip
        if region in (BELOW, BETWEEN):
            safe = safe_slip(problem, load_factor, tolerances=tolerances).slip
        states = {"zero": np.zeros(problem.n), "safe": safe, "witness": lower.slip}
        states |= {f"given {k}": state for k, state in enumerate(given)}
        half_width = random_half_width(problem, load_factor)
        states |= {f"random {k}": centre + unit * half_width for k, unit in enumerate(randoms)}
        for name, state in states.items():
            if not np.isnan(state).any():
                yield Case(region, load_factor, name, state)


def default_load_factors(
    lower: LowerBound, upper: UpperBound, tolerances: Tolerances = DEFAULT
) -> list[float]:
    """One load factor a little inside every region that exists."""
    least, first, last = upper.least_load_factor, lower.load_factor, upper.load_factor
    if upper.status == Status.INFEASIBLE:
        return [1.0]
    if least > 0:  # the mean load alone has no safe slip, and so there is no λ_1
        factors, first = [0.95 * least], least
    elif np.isinf(first):  # nothing ever collapses
        return [1.0, 10.0]
    else:
        factors = [0.95 * first] if first > 0 else []
    if np.isinf(last):
        return [*factors, 1.5 * first or 1.0]
    if last > first * (1 + tolerances.second_road):
        factors.append(first + 0.3 * (last - first))
    return [*factors, 1.05 * last or 1.0]


def region_of(load_factor: float, lower: LowerBound, upper: UpperBound) -> str:
    """The region that a load factor lies in."""
    if upper.status == Status.INFEASIBLE or load_factor > upper.load_factor:
        return ABOVE
    if load_factor < upper.least_load_factor:
        return UNSAFE
    return BELOW if load_factor < lower.load_factor else BETWEEN


def random_half_width(problem: Problem, load_factor: float) -> FloatArray:
    """Half-width of the box of random initial states: slips that a load step could cause, (n,) [length]."""
    q_w, p_w = loading(problem).at(load_factor)
    force = (np.abs(q_w) + problem.f * np.abs(p_w)).max(axis=0)
    stiffness = np.diag(problem.A)
    return force / np.where(stiffness > 0, stiffness, np.inf)
