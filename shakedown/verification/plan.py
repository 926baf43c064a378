"""What a verification simulates: load factors in every region, several initial states, predictions."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from shakedown.assessment.shakedown_bounds import ShakedownBounds
from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.bounds.energy.energy_bound import EnergyBound
from shakedown.bounds.safe_slip import safe_slip
from shakedown.bounds.upper import UpperBound
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.loading import slip_reach, transient_path
from shakedown.joint.problem import Problem
from shakedown.planar.collapse.box_bound import BoxBound
from shakedown.planar.collapse.lower import LowerBound
from shakedown.planar.universal.universal_bound import UniversalBound
from shakedown.verification.arrival import arrives_closed
from shakedown.verification.from_state import box_proves_more

AS_GIVEN = 1.0  # the load factor of the loading as given: always simulated
ON_SURFACE = 2  # initial states on the surface of the energy ball, per load factor
JUST_INSIDE = 1 - 1e-8  # of its radius: the proof is for less than all of it
JUST_BELOW = 1 - 1e-6  # of the box bound, where it proves most from the state given
UNSAFE, BELOW, BETWEEN, ABOVE = "below λ_lo", "below λ_1", "between", "above λ_max"
PROVED = "below λ_U"  # of a load domain, of whose λ_1 nothing is predicted
IN_ZONE, OUTSIDE = "zone is safe", "zone is not safe"  # between λ_lo and λ_max of a zone, and elsewhere


@dataclass(frozen=True)
class Case:
    """One simulation to be made.

    Attributes
    ----------
    region
        Where the load factor lies: below λ_1 (of a load domain: below λ_U), between the
        bounds, above λ_max; below λ_lo where safe slips exist only from there on. Where nodes
        are open: whether the zone has safe slips.
    load_factor
        λ.
    initial, start
        Name of the initial state, and its slip (n,) [length].
    in_ball
        Whether it lies inside the energy ball of this load factor: shakedown is proved.
    in_box
        Whether the box bound of this state is larger than this load factor: so it is, too.
    open_nodes
        The nodes that are open in it.
    after_transient
        Whether it is a state after the transient load steps, which are left out: so is one with
        open nodes, and a safe slip where the transient moves every one.
    arrives_closed
        Whether the transient leaves all nodes closed, so that what is said of every closed
        state is said of what has become of this one.
    """

    region: str
    load_factor: float
    initial: str
    start: FloatArray
    in_ball: bool = False
    in_box: bool = False
    open_nodes: tuple[int, ...] = ()
    after_transient: bool = False
    arrives_closed: bool = True

    @property
    def proved(self) -> bool:
        """Whether shakedown is proved from this very state."""
        return self.in_ball or self.in_box

    @property
    def predicted(self) -> str:
        """ "shakedown", "slips or opens", or "either" where the bounds predict nothing."""
        if self.region in (UNSAFE, ABOVE):
            return "slips or opens"
        below = self.region in (BELOW, PROVED) and self.arrives_closed
        certain = below or self.initial == "safe" or self.proved  # with these nodes open
        return "shakedown" if certain else "either"


class Known(NamedTuple):
    """The bounds that the predictions rest on; energy and box are those of the state asked about."""

    bounds: ShakedownBounds
    universal: UniversalBound
    energy: EnergyBound
    box: BoxBound


def planned_cases(
    problem: Problem,
    known: Known,
    load_factors: Sequence[float] | None,
    random_states: int,
    seed: int,
    tolerances: Tolerances = DEFAULT,
) -> Iterator[Case]:
    """Every simulation that a verification asks for, load factor by load factor."""
    for case in _cases(problem, known, load_factors, random_states, seed, tolerances):
        yield replace(case, in_box=_in_box(case, known.box))


def _cases(
    problem: Problem,
    known: Known,
    load_factors: Sequence[float] | None,
    random_states: int,
    seed: int,
    tolerances: Tolerances,
) -> Iterator[Case]:
    (lower, upper), universal = (known.bounds.lower, known.bounds.upper), known.universal
    generator = np.random.default_rng(seed)
    randoms = generator.uniform(-1.0, 1.0, (random_states, problem.n))
    centre = np.zeros(problem.n) if np.isnan(upper.slip).any() else upper.slip
    chosen = load_factors
    if chosen is None:
        chosen = default_load_factors(lower, upper, tolerances, universal=universal)
    for load_factor in chosen:
        region = region_of(load_factor, lower, upper, universal)
        safe = _safe_start(problem, load_factor, region, upper, tolerances)
        states = {"zero": np.zeros(problem.n), "safe": safe.slip, "witness": lower.slip}
        states |= given_states(problem)
        half_width = slip_reach(problem, load_factor)
        states |= {f"random {k}": centre + unit * half_width for k, unit in enumerate(randoms)}
        ball = sought(energy_ball, problem, load_factor, tolerances=tolerances)
        if not isinstance(ball, Missing) and 0 < ball.radius < np.inf:
            away = np.random.default_rng(seed).normal(size=(ON_SURFACE, ball.metric.inverse.shape[1]))
            states |= {f"ball {k}": state for k, state in enumerate(ball.at(away, JUST_INSIDE))}
        for name, state in states.items():
            if np.isnan(state).any():
                continue
            if name == "safe" and (safe.open_nodes or safe.after_transient):
                opened, later = safe.open_nodes, safe.after_transient
                yield Case(region, load_factor, name, state, open_nodes=opened, after_transient=later)
            else:
                yield _case(problem, load_factor, region, ball, name, state, tolerances)
    from_one_state = [AS_GIVEN] if AS_GIVEN not in chosen else []
    if load_factors is None and box_proves_more(known.box, known.energy) and known.box.load_factor < np.inf:
        from_one_state.append(JUST_BELOW * known.box.load_factor)
    for load_factor in from_one_state:
        ball = sought(energy_ball, problem, load_factor, tolerances=tolerances)
        name, state = next(iter(({**given_states(problem), "zero": np.zeros(problem.n)}).items()))
        region = region_of(load_factor, lower, upper, universal)
        yield _case(problem, load_factor, region, ball, name, state, tolerances)


def _in_box(case: Case, box: BoxBound) -> bool:
    """Whether a case begins at the state of the box, below what that proves."""
    here = not case.after_transient and np.array_equal(case.start, box.initial_slip)
    return here and not case.open_nodes and case.load_factor < box.load_factor


class _SafeStart(NamedTuple):
    """A safe slip, the nodes that are open in it, and whether it is one after the transient only."""

    slip: FloatArray
    open_nodes: tuple[int, ...]
    after_transient: bool


def _safe_start(
    problem: Problem, load_factor: float, region: str, upper: UpperBound, tolerances: Tolerances
) -> _SafeStart:
    """A slip that is safe under the transient too; where there is none, one to be locked in after it."""
    opened = upper.open_nodes
    if region not in (BELOW, PROVED, BETWEEN, IN_ZONE):
        return _SafeStart(np.full(problem.n, np.nan) if opened else upper.slip, (), False)
    before = len(transient_path(problem)) > 0
    if before and not opened:
        lasting = safe_slip(problem, load_factor, transient=True, tolerances=tolerances)
        if lasting.status != Status.INFEASIBLE:
            return _SafeStart(lasting.slip, (), False)
    safe = safe_slip(problem, load_factor, open_nodes=opened, tolerances=tolerances)
    return _SafeStart(safe.slip, opened, before)


def _case(
    problem: Problem,
    load_factor: float,
    region: str,
    ball: EnergyBall | Missing,
    name: str,
    state: FloatArray,
    tolerances: Tolerances,
) -> Case:
    """A case that begins before the transient, with all nodes closed."""
    judged = region in (BELOW, PROVED)
    return Case(
        region=region,
        load_factor=load_factor,
        initial=name,
        start=state,
        in_ball=not isinstance(ball, Missing) and _in_ball(problem, ball, name, state, tolerances),
        arrives_closed=not judged or arrives_closed(problem, load_factor, state, tolerances),
    )


def _in_ball(
    problem: Problem, ball: EnergyBall, name: str, state: FloatArray, tolerances: Tolerances
) -> bool:
    """Whether a state is proved to shake down: in the largest ball, or (zero, given) in one about itself."""
    if ball.contains(state) or ball.radius == 0:
        return bool(ball.contains(state))
    if not name.startswith(("zero", "given")):
        return False
    own = sought(energy_ball, problem, ball.load_factor, around=state, tolerances=tolerances)
    return not isinstance(own, Missing) and bool(own.contains(state))


def given_states(problem: Problem) -> dict[str, FloatArray]:
    """The initial states that come with a problem, by name."""
    states = () if problem.initial_slip is None else problem.initial_slip
    return {f"given {k}": state for k, state in enumerate(states)}


def _predicted_below(lower: LowerBound, universal: UniversalBound | None) -> tuple[float, str]:
    """Up to where every closed state is expected to shake down: λ_1, of a load domain λ_U."""
    if not lower.problem.is_domain:
        return lower.load_factor, BELOW
    return 0.0 if universal is None else universal.load_factor, PROVED


def default_load_factors(
    lower: LowerBound,
    upper: UpperBound,
    tolerances: Tolerances = DEFAULT,
    *,
    universal: UniversalBound | None = None,
) -> list[float]:
    """One load factor a little inside every region that exists."""
    least, last = upper.least_load_factor, upper.load_factor
    first, _ = _predicted_below(lower, universal)
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


def region_of(
    load_factor: float, lower: LowerBound, upper: UpperBound, universal: UniversalBound | None = None
) -> str:
    """The region that a load factor lies in."""
    first, below = _predicted_below(lower, universal)
    if upper.open_nodes and not load_factor < first:
        return IN_ZONE if upper.least_load_factor <= load_factor <= upper.load_factor else OUTSIDE
    if upper.status == Status.INFEASIBLE or load_factor > upper.load_factor:
        return ABOVE
    if load_factor < upper.least_load_factor:
        return UNSAFE
    return below if load_factor < first else BETWEEN
