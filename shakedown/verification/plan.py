"""What a verification simulates: load factors in every region, several initial states, predictions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from shakedown.bounds.lower import LowerBound
from shakedown.bounds.safe_slip import safe_slip
from shakedown.bounds.upper import UpperBound
from shakedown.energy.energy_ball import EnergyBall, energy_ball
from shakedown.model.loading import slip_reach
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.status import Status
from shakedown.tolerances import DEFAULT, Tolerances

AS_GIVEN = 1.0  # the load factor of the loading as given: always simulated
ON_SURFACE = 2  # initial states on the surface of the energy ball, per load factor
JUST_INSIDE = 1 - 1e-8  # of its radius: the proof is for less than all of it
UNSAFE, BELOW, BETWEEN, ABOVE = "below λ_lo", "below λ_1", "between", "above λ_max"
IN_ZONE, OUTSIDE = "zone is safe", "zone is not safe"  # between λ_lo and λ_max of a zone, and elsewhere


@dataclass(frozen=True)
class Case:
    """One simulation to be made.

    Attributes
    ----------
    region
        Where the load factor lies: below λ_1, between the bounds, above λ_max; below
        λ_lo where safe slips exist only from there on. Where nodes are open: whether
        the zone has safe slips.
    load_factor
        λ.
    initial, start
        Name of the initial state, and its slip (n,) [length].
    in_ball
        Whether it lies inside the energy ball of this load factor: shakedown is proved.
    open_nodes
        The nodes that are open in it. Such a state is one after the transient load steps,
        which are left out.
    """

    region: str
    load_factor: float
    initial: str
    start: FloatArray
    in_ball: bool = False
    open_nodes: tuple[int, ...] = ()

    @property
    def predicted(self) -> str:
        """ "shakedown", "slips or opens", or "either" where the bounds predict nothing."""
        if self.region in (UNSAFE, ABOVE):
            return "slips or opens"
        certain = self.region == BELOW or self.initial == "safe" or self.in_ball  # with these nodes open
        return "shakedown" if certain else "either"


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
    chosen = default_load_factors(lower, upper, tolerances) if load_factors is None else load_factors
    for load_factor in chosen:
        region = region_of(load_factor, lower, upper)
        safe, opened = upper.slip, upper.open_nodes
        if region in (BELOW, BETWEEN, IN_ZONE):
            safe = safe_slip(problem, load_factor, open_nodes=opened, tolerances=tolerances).slip
        elif region == OUTSIDE:
            safe = np.full(problem.n, np.nan)
        states = {"zero": np.zeros(problem.n), "safe": safe, "witness": lower.slip} | given_states(problem)
        half_width = slip_reach(problem, load_factor)
        states |= {f"random {k}": centre + unit * half_width for k, unit in enumerate(randoms)}
        ball = energy_ball(problem, load_factor, tolerances=tolerances)
        if 0 < ball.radius < np.inf:
            away = np.random.default_rng(seed).normal(size=(ON_SURFACE, ball.metric.inverse.shape[1]))
            states |= {f"ball {k}": state for k, state in enumerate(ball.at(away, JUST_INSIDE))}
        for name, state in states.items():
            if np.isnan(state).any():
                continue
            nodes = opened if name == "safe" else ()
            inside = not nodes and _in_ball(problem, ball, name, state, tolerances)
            yield Case(region, load_factor, name, state, inside, nodes)
    if AS_GIVEN not in chosen:
        ball = energy_ball(problem, AS_GIVEN, tolerances=tolerances)
        name, state = next(iter(({**given_states(problem), "zero": np.zeros(problem.n)}).items()))
        inside = _in_ball(problem, ball, name, state, tolerances)
        yield Case(region_of(AS_GIVEN, lower, upper), AS_GIVEN, name, state, inside)


def _in_ball(
    problem: Problem, ball: EnergyBall, name: str, state: FloatArray, tolerances: Tolerances
) -> bool:
    """Whether a state is proved to shake down: in the largest ball, or (zero, given) in one about itself."""
    if ball.contains(state) or ball.radius == 0:
        return bool(ball.contains(state))
    if not name.startswith(("zero", "given")):
        return False
    return bool(energy_ball(problem, ball.load_factor, around=state, tolerances=tolerances).contains(state))


def given_states(problem: Problem) -> dict[str, FloatArray]:
    """The initial states that come with a problem, by name."""
    states = () if problem.initial_slip is None else problem.initial_slip
    return {f"given {k}": state for k, state in enumerate(states)}


def default_load_factors(
    lower: LowerBound, upper: UpperBound, tolerances: Tolerances = DEFAULT
) -> list[float]:
    """One load factor a little inside every region that exists."""
    least, first, last = upper.least_load_factor, lower.load_factor, upper.load_factor
    if upper.status == Status.INFEASIBLE:
        return [1.0]
    if upper.open_nodes:
        below = [0.95 * first] if 0 < first < np.inf else []
        inside = [least + 0.5 * (last - least), least + 0.999 * (last - least)]
        return [*below, *inside, 1.05 * last or 1.0] if last < np.inf else [*below, 1.5 * least or 1.0]
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
    if upper.open_nodes and not load_factor < lower.load_factor:
        return IN_ZONE if upper.least_load_factor <= load_factor <= upper.load_factor else OUTSIDE
    if upper.status == Status.INFEASIBLE or load_factor > upper.load_factor:
        return ABOVE
    if load_factor < upper.least_load_factor:
        return UNSAFE
    return BELOW if load_factor < lower.load_factor else BETWEEN
