"""Which initial states a map starts from: each follows from the seed and its number alone."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property
from math import isqrt

import numpy as np

from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.bounds.named_start import named_start
from shakedown.bounds.safe_slip import safe_slip
from shakedown.bounds.upper import upper_bound
from shakedown.ground.argument_kinds import check_count, check_seed
from shakedown.ground.errors import Missing, UsageError, allowed
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import short
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import is_finite
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import slip_reach
from shakedown.joint.problem import Problem
from shakedown.long_term.passage import slip_after_transient

MOST_STATES = 100_000_000  # in one map: a day for a small joint, 2.5 GB kept for the statistics
LEFT_BEHIND = 16  # random transients of which a box contains what they leave
NAMED = {"zero": "zero", "given": "given", "critical": "witness"}  # name in a map, and of ``named_start``
BLOCK = 64  # states that share one stream of random numbers, or are recorded together


class Sampler(StrEnum):
    """How initial states are chosen.

    Attributes
    ----------
    GRID
        On a square grid in two slips, all others at the centre; no random sample.
    SOBOL
        Scrambled Sobol points in a box about the centre: evenly spread.
    LATIN
        Latin hypercubes of 64 states each in that box.
    BALL
        Independent and uniform in the energy ball, or as many times its radius as asked for.
    TRANSIENTS
        Reachable states: left behind by 1 to 12 random load steps within the loads of the loop,
        from slip zero. A node that is open then starts closed at its displacement.
    """

    GRID = "grid"
    SOBOL = "sobol"
    LATIN = "latin"
    BALL = "ball"
    TRANSIENTS = "transients"


@dataclass(frozen=True)
class Sampling:
    """The initial states of a map at one load factor: those with a name, and those that are sampled.

    Attributes
    ----------
    problem, load_factor
        The joint and λ.
    sampler, seed, states
        How they are sampled, the seed of what is random, and how many there are.
    coordinates
        Places of the two slips that a grid runs over, and a picture shows: in the plane the nodes.
    centre : (dn,)
        Middle of the box [length].
    centre_is
        What it is, in words.
    half_width : (dn,)
        Half-width of the box [length].
    reach
        Radius of the ball that states are drawn from, relative to the energy ball.
    tolerances
        For the transients, and the energy ball.
    named
        The first states of the map (:func:`named_states`).
    """

    problem: Problem = field(repr=False)
    load_factor: float
    sampler: Sampler
    seed: int
    states: int
    coordinates: tuple[int, int]
    centre: FloatArray
    centre_is: str
    half_width: FloatArray
    reach: float
    tolerances: Tolerances = field(default=DEFAULT, repr=False)
    named: dict[str, FloatArray] = field(default_factory=dict, repr=False)

    @property
    def rows(self) -> int:
        """States in all."""
        return len(self.named) + self.states

    @property
    def side(self) -> int:
        """States along one side of a grid."""
        return isqrt(self.states)

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

    def slips(self, start: int, stop: int) -> FloatArray:
        """The initial slips of the sampled states start … stop − 1, (stop − start, dn) [length]."""
        stop = min(stop, self.states)
        if self.sampler == Sampler.GRID:
            return _grid(self, start, stop)
        if self.sampler == Sampler.SOBOL:
            return _sobol(self, start, stop)
        first = start // BLOCK
        blocks = [_BLOCKS[self.sampler](self, number) for number in range(first, -(-stop // BLOCK))]
        return np.concatenate(blocks)[start - first * BLOCK : stop - first * BLOCK]


def sampling(
    problem: Problem,
    load_factor: float,
    sampler: str = Sampler.SOBOL,
    *,
    states: int = 1024,
    seed: int = 0,
    coordinates: tuple[int, int] | None = None,
    reach: float = 1.0,
    tolerances: Tolerances = DEFAULT,
) -> Sampling:
    """The initial states of a map, described; parameters as for :func:`initial_state_map`.

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> chosen = sampling(shakedown.example("two-node"), 0.7, states=1000)
    >>> chosen.slips(0, 1000).shape, bool((chosen.slips(500, 501) == chosen.slips(0, 1000)[500]).all())
    ((1000, 2), True)
    """
    check_count("states", states)
    if states > MOST_STATES:
        raise UsageError(f"states: expected at most {MOST_STATES:,}, found {short(states)}")
    if sampler not in list(Sampler):
        raise UsageError(f"sampler: expected one of {', '.join(Sampler)}, found {sampler!r}")
    seed = check_seed(seed)
    if not (is_finite(reach) and reach > 0):
        raise UsageError(f"reach: expected a number > 0, found {reach!r}")
    centre, centre_is = _centre(problem, load_factor, tolerances)
    half_width = slip_reach(problem, load_factor)
    if sampler in (Sampler.GRID, Sampler.SOBOL, Sampler.LATIN):
        contained = [*named_states(problem).values(), *_left_behind(problem, load_factor, tolerances)]
        half_width = np.maximum(half_width, np.abs(np.array(contained) - centre).max(axis=0))
    with np.errstate(over="ignore"):
        half_width = reach * half_width
    if not np.isfinite(half_width).all():
        raise UsageError(
            f"reach: expected slips in the range of numbers, found a box {reach:g} times as large"
        )
    chosen = Sampling(
        problem=problem,
        load_factor=float(load_factor),
        sampler=Sampler(sampler),
        seed=seed,
        states=states,
        coordinates=_coordinates(problem, coordinates, sampler),
        centre=centre,
        centre_is=centre_is,
        half_width=half_width,
        reach=float(reach),
        tolerances=tolerances,
        named=named_states(problem),
    )
    if sampler == Sampler.GRID:
        return replace(chosen, states=chosen.side**2)
    return chosen


@once_per_problem
def named_states(problem: Problem) -> dict[str, FloatArray]:
    """The states that every map begins with, each (dn,) [length].

    ``"zero"``: slip zero; ``"given"``: the first initial slip of the problem, where it has one;
    ``"critical"``: the critical slip state of the first collapse, where there is one, in the plane.

    Examples
    --------
    >>> import shakedown
    >>> [list(named_states(shakedown.example(name))) for name in ("two-node", "two-node-3d")]
    [['zero', 'critical'], ['zero']]
    """
    found = {name: allowed(named_start, problem, 0.0, word) for name, word in NAMED.items()}
    return {name: slip for name, slip in found.items() if not isinstance(slip, Missing)}


def _left_behind(problem: Problem, load_factor: float, tolerances: Tolerances) -> list[FloatArray]:
    """Slips that some random transients leave, as the sampler of that name draws them."""
    generator = np.random.default_rng(0)
    left = [
        slip_after_transient(problem, load_factor, generator, tolerances=tolerances)
        for _ in range(LEFT_BEHIND)
    ]
    return [slip for slip in left if np.isfinite(slip).all()]


def require_ball(chosen: Sampling) -> Sampling:
    """The sampling itself; raises ``UsageError`` if it draws from an energy ball that is not there."""
    if chosen.missing_ball:
        raise UsageError(
            f"sampler ball: expected a finite energy ball at load factor {chosen.load_factor:g}, found "
            f"{chosen.missing_ball}"
        )
    return chosen


def _centre(problem: Problem, load_factor: float, tolerances: Tolerances) -> tuple[FloatArray, str]:
    """The safe slip, or what comes nearest to one."""
    safe = safe_slip(problem, load_factor, tolerances=tolerances).slip
    if not np.isnan(safe).any():
        return safe, "safe slip"
    last = upper_bound(problem, tolerances=tolerances).slip
    if not np.isnan(last).any():
        return last, "safe slip at λ_max"
    return np.zeros(problem.layout.slip_size), "slip zero"


def _coordinates(problem: Problem, given: tuple[int, int] | None, sampler: str) -> tuple[int, int]:
    """The places of two different slips."""
    size = problem.layout.slip_size
    pair = (0, min(1, size - 1)) if given is None else tuple(given)
    if size == 1 and given is None and sampler == Sampler.GRID:
        raise UsageError("grid: expected a joint of two nodes or more, found one node")
    known = len(pair) == 2 and all(isinstance(j, int | np.integer) and 0 <= j < size for j in pair)
    if not known or (pair[0] == pair[1] and (given is not None or sampler == Sampler.GRID)):
        what = "nodes" if problem.directions == 1 else "slips (x0, y0, x1, y1, …)"
        raise UsageError(f"grid: expected two different {what} from 0 to {size - 1}, found {pair}")
    return int(pair[0]), int(pair[1])


def _grid(chosen: Sampling, start: int, stop: int) -> FloatArray:
    """Rows of the grid follow each other in the second coordinate."""
    steps = np.linspace(-1.0, 1.0, chosen.side) if chosen.side > 1 else np.zeros(1)
    number = np.arange(start, stop)
    slips = np.tile(chosen.centre, (len(number), 1))
    for slip, place in zip(chosen.coordinates, (number % chosen.side, number // chosen.side), strict=True):
        slips[:, slip] += chosen.half_width[slip] * steps[place]
    return slips


def _sobol(chosen: Sampling, start: int, stop: int) -> FloatArray:
    from scipy.stats import qmc  # loads much: only where it is drawn from

    size, d = chosen.problem.layout.slip_size, chosen.problem.directions
    if size > qmc.Sobol.MAXDIM:
        most = qmc.Sobol.MAXDIM // d
        raise UsageError(f"sampler sobol: expected at most {most} nodes, found {chosen.problem.n}")
    engine = qmc.Sobol(size, scramble=True, seed=np.random.default_rng(chosen.seed))
    if start:  # SciPy cannot skip none
        engine.fast_forward(start)
    count = 1 << max(stop - start - 1, 0).bit_length()  # SciPy wants a power of two
    return _in_box(chosen, engine.random(count)[: stop - start])


def _latin(chosen: Sampling, block: int) -> FloatArray:
    from scipy.stats import qmc

    engine = qmc.LatinHypercube(chosen.problem.layout.slip_size, seed=_generator(chosen, block))
    return _in_box(chosen, engine.random(BLOCK))


def _in_box(chosen: Sampling, unit: FloatArray) -> FloatArray:
    return np.asarray(chosen.centre + (2.0 * unit - 1.0) * chosen.half_width)


def _ball(chosen: Sampling, block: int) -> FloatArray:
    generator = _generator(chosen, block)
    rank = chosen.ball.metric.inverse.shape[1]
    directions = generator.normal(size=(BLOCK, rank))
    radii = chosen.reach * generator.random(BLOCK) ** (1.0 / rank)
    surface = chosen.ball.at(directions)
    return np.asarray(chosen.ball.slip + radii[:, None] * (surface - chosen.ball.slip))


def _transients(chosen: Sampling, block: int) -> FloatArray:
    """Slips that random loads within those of the loop leave behind."""
    generator = _generator(chosen, block)
    left = (
        slip_after_transient(chosen.problem, chosen.load_factor, generator, tolerances=chosen.tolerances)
        for _ in range(BLOCK)
    )
    return np.stack(list(left))


def _generator(chosen: Sampling, block: int) -> np.random.Generator:
    return np.random.default_rng([chosen.seed, block])


_BLOCKS: dict[Sampler, Callable[[Sampling, int], FloatArray]] = {
    Sampler.LATIN: _latin,
    Sampler.BALL: _ball,
    Sampler.TRANSIENTS: _transients,
}
