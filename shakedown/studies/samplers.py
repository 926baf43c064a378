"""Which initial states a map starts from: each follows from the seed and its number alone."""

from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from math import isqrt
from typing import Any

import numpy as np

from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.bounds.named_start import named_start
from shakedown.bounds.upper import safe_slip, upper_bound
from shakedown.ground.argument_kinds import check_count, check_seed
from shakedown.ground.constants import CYCLES, MOST_ENTRIES, FloatArray
from shakedown.ground.errors import Missing, UsageError, attempt_any
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import is_finite, once_per_problem
from shakedown.joint.constraints import slip_reach
from shakedown.joint.problem import Problem
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.limit_search import LONGEST_PERIOD
from shakedown.long_term.motion_start import slip_after_transient
from shakedown.long_term.state import LongTermState

NAMED = {"zero": "zero", "given": "given", "critical": "witness"}  # name in a map, and of ``named_start``
FIRST_TWO = (0, 1)  # slips of a picture
BLOCK = 64  # states that share one stream of random numbers, or are recorded together


class Sampler(StrEnum):
    """How initial states are chosen.

    Attributes
    ----------
    GRID
        On a square grid in two slips, all others at the centre; no random sample.
    SOBOL
        Scrambled Sobol points in a box about the centre: evenly spread.
    BALL
        Independent and uniform in the energy ball, or as many times its radius as asked for.
    TRANSIENTS
        Reachable states: left behind by 1 to 12 random load steps within the loads of the loop,
        from slip zero. A node that is open then starts closed at its displacement.
    """

    GRID = "grid"
    SOBOL = "sobol"
    BALL = "ball"
    TRANSIENTS = "transients"


@dataclass(frozen=True)
class Sampling:
    """The states of a map at one load factor: those with a name, those that are sampled, what follows.

    Attributes
    ----------
    problem, load_factor
        The joint and λ.
    sampler, states, seed
        How they are sampled, how many there are, and the seed of what is random.
    coordinates
        Places of the two slips that a grid runs over, and a picture shows: in the plane the nodes.
    reach
        Size of the box, or radius of the ball, that states are drawn from, relative to its own.
    max_cycles, longest_period, tolerances
        How long the state that follows is searched for, and what decides (:func:`long_term_state`).

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> chosen = Sampling(shakedown.example("two-node"), 0.7, states=1000)
    >>> chosen.slips(0, 1000).shape, bool((chosen.slips(500, 501) == chosen.slips(0, 1000)[500]).all())
    ((1000, 2), True)
    """

    problem: Problem = field(repr=False)
    load_factor: float
    sampler: str = Sampler.SOBOL
    states: int = 1024
    seed: int = 0
    coordinates: tuple[int, int] = FIRST_TWO
    reach: float = 1.0
    max_cycles: int = CYCLES
    longest_period: int = LONGEST_PERIOD
    tolerances: Tolerances = field(default=DEFAULT, repr=False)

    def __post_init__(self) -> None:
        check_count("states", self.states, 10_000_000)  # in one map: hours for a small joint, some gigabytes
        if self.sampler not in list(Sampler):
            raise UsageError(f"sampler: expected one of {', '.join(Sampler)}, found {self.sampler!r}")
        if not (is_finite(self.reach) and self.reach > 0):
            raise UsageError(f"reach: expected a number > 0, found {self.reach!r}")
        check_count("max_cycles", self.max_cycles)
        check_count("longest_period", self.longest_period, MOST_ENTRIES)
        grid = self.sampler == Sampler.GRID
        read = {
            "load_factor": float(self.load_factor),
            "sampler": Sampler(self.sampler),
            "states": isqrt(self.states) ** 2 if grid else self.states,
            "seed": check_seed(self.seed),
            "coordinates": _coordinates(self.problem, self.coordinates, grid),
            "reach": float(self.reach),
        }
        self.__dict__.update(read)
        if not np.isfinite(self.half_width).all():
            raise UsageError(
                f"reach: expected slips in the range of numbers, found a box {self.reach:g} times as large"
            )

    @cached_property
    def named(self) -> dict[str, FloatArray]:
        """The states that every map begins with, each (dn,) [length].

        ``"zero"``: slip zero; ``"given"``: the first initial slip of the problem, where it has one;
        ``"critical"``: the critical slip state of the first collapse, where there is one, in the plane.
        """
        return _named_states(self.problem)

    @property
    def rows(self) -> int:
        """States in all."""
        return len(self.named) + self.states

    @property
    def side(self) -> int:
        """States along one side of a grid."""
        return isqrt(self.states)

    @property
    def centre(self) -> FloatArray:
        """Middle of the box, (dn,) [length]: the safe slip, or what comes nearest to one."""
        return self._centre[1]

    @property
    def centre_is(self) -> str:
        """What it is, in words."""
        return self._centre[0]

    @cached_property
    def _centre(self) -> tuple[str, FloatArray]:
        safe = safe_slip(self.problem, self.load_factor, tolerances=self.tolerances).slip
        if not np.isnan(safe).any():
            return "safe slip", safe
        last = upper_bound(self.problem, tolerances=self.tolerances).slip
        if not np.isnan(last).any():
            return "safe slip at λ_max", last
        return "slip zero", np.zeros(self.problem.layout.slip_size)

    @cached_property
    def half_width(self) -> FloatArray:
        """Half-width of the box, (dn,) [length]."""
        width = slip_reach(self.problem, self.load_factor)
        if self.sampler in (Sampler.GRID, Sampler.SOBOL):
            # random transients of which a box contains what they leave
            left = self._left_behind(np.random.default_rng(0), 16)
            contained = [*self.named.values(), *left[np.isfinite(left).all(axis=1)]]
            width = np.maximum(width, np.abs(np.array(contained) - self.centre).max(axis=0))
        with np.errstate(over="ignore"):
            return np.asarray(self.reach * width)

    @cached_property
    def ball(self) -> EnergyBall:
        """The energy ball of this load factor, for the sampler of that name."""
        return energy_ball(self.problem, self.load_factor, tolerances=self.tolerances)

    @property
    def missing_ball(self) -> str:
        """Why states cannot be drawn from the energy ball, where that is asked for; else empty."""
        if self.sampler != Sampler.BALL or 0 < self.ball.radius < np.inf:
            return ""
        return f"radius {self.ball.radius:g} ({self.ball.reason})"

    @property
    def search_limits(self) -> dict[str, Any]:
        """The arguments of :func:`long_term_state` that say how long it searches, and what decides."""
        return {
            "max_cycles": self.max_cycles,
            "longest_period": self.longest_period,
            "tolerances": self.tolerances,
        }

    def state(self, slip: FloatArray) -> LongTermState:
        """The long-term state from one initial slip."""
        return long_term_state(self.problem, self.load_factor, np.asarray(slip), **self.search_limits)

    def slips(self, start: int, stop: int) -> FloatArray:
        """The initial slips of the sampled states start … stop − 1, (stop − start, dn) [length]."""
        stop = min(stop, self.states)
        if self.sampler == Sampler.GRID:
            return self._in_box(self._grid(start, stop))
        if self.sampler == Sampler.SOBOL:
            return self._in_box(self._sobol(start, stop))
        draw = self._in_ball if self.sampler == Sampler.BALL else self._left_behind
        first = start // BLOCK
        generators = (np.random.default_rng([self.seed, k]) for k in range(first, -(-stop // BLOCK)))
        blocks = [draw(generator, BLOCK) for generator in generators]
        return np.concatenate(blocks)[start - first * BLOCK : stop - first * BLOCK]

    def _in_box(self, places: FloatArray) -> FloatArray:
        """Slips at places from −1 to 1 in every direction."""
        return np.asarray(self.centre + places * self.half_width)

    def _grid(self, start: int, stop: int) -> FloatArray:
        """Rows of the grid follow each other in the second coordinate."""
        steps = np.linspace(-1.0, 1.0, self.side) if self.side > 1 else np.zeros(1)
        places = np.zeros((stop - start, len(self.centre)))
        second, first = np.divmod(np.arange(start, stop), self.side)
        places[:, self.coordinates] = np.column_stack([steps[first], steps[second]])
        return places

    def _sobol(self, start: int, stop: int) -> FloatArray:
        from scipy.stats import qmc  # loads much: only where it is drawn from

        size, problem = len(self.centre), self.problem
        if size > qmc.Sobol.MAXDIM:
            most = qmc.Sobol.MAXDIM // problem.directions
            raise UsageError(f"sampler sobol: expected at most {most} nodes, found {problem.n}")
        engine = qmc.Sobol(size, scramble=True, seed=np.random.default_rng(self.seed))
        if start:  # SciPy cannot skip none
            engine.fast_forward(start)
        count = 1 << max(stop - start - 1, 0).bit_length()  # SciPy wants a power of two
        return np.asarray(2.0 * engine.random(count)[: stop - start] - 1.0)

    def _in_ball(self, generator: np.random.Generator, count: int) -> FloatArray:
        rank = self.ball.metric.inverse.shape[1]
        surface = self.ball.at(generator.normal(size=(count, rank)))
        radii = self.reach * generator.random(count) ** (1.0 / rank)
        return np.asarray(self.ball.slip + radii[:, None] * (surface - self.ball.slip))

    def _left_behind(self, generator: np.random.Generator, count: int) -> FloatArray:
        """Slips that random loads within those of the loop leave behind."""
        problem, load_factor, tolerances = self.problem, self.load_factor, self.tolerances
        left = [
            slip_after_transient(problem, load_factor, generator, tolerances=tolerances) for _ in range(count)
        ]
        return np.stack(left)


@once_per_problem
def _named_states(problem: Problem) -> dict[str, FloatArray]:
    found = {name: attempt_any(named_start, problem, 0.0, word) for name, word in NAMED.items()}
    return {name: slip for name, slip in found.items() if not isinstance(slip, Missing)}


def _coordinates(problem: Problem, given: tuple[int, int], grid: bool) -> tuple[int, int]:
    """The places of two different slips; of a joint with one slip alone there is no picture."""
    size, pair = problem.layout.slip_size, tuple(given)
    if size == 1 and pair == FIRST_TWO:
        if grid:
            raise UsageError("grid: expected a joint of two nodes or more, found one node")
        return 0, 0
    known = len(pair) == 2 and all(isinstance(j, int | np.integer) and 0 <= j < size for j in pair)
    if not known or pair[0] == pair[1]:
        what = "nodes" if problem.directions == 1 else "slips (x0, y0, x1, y1, …)"
        raise UsageError(f"grid: expected two different {what} from 0 to {size - 1}, found {pair}")
    return int(pair[0]), int(pair[1])
