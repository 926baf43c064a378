"""What a verification simulates: load factors in every region, several initial states, predictions."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from shakedown.assessment.assess import AS_GIVEN
from shakedown.assessment.every_limit import JointLimits
from shakedown.assessment.load_regions import (
    ABOVE,
    BELOW,
    BETWEEN,
    IN_ZONE,
    NO_ZONE,
    PROVED,
    UNSAFE,
    default_load_factors,
    region_of,
)
from shakedown.bounds.energy.energy_ball import energy_ball
from shakedown.bounds.plane_or_space import takes_long
from shakedown.bounds.registry import Claim, kinds_of
from shakedown.bounds.safe_slip import safe_slip
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, SIX_DIGITS
from shakedown.ground.status import Status
from shakedown.joint.loading import transient_path
from shakedown.joint.problem import Problem
from shakedown.long_term.passage import arrives_closed, slip_after_transient

OVERLOAD = (
    2.0  # of the random loads that leave initial states behind: within those of the loop few joints slip
)
IN_BALL = 2  # initial states drawn in the energy ball per load factor
JUST_INSIDE = 1 - 10 * NEGLIGIBLE  # times its radius, as the proof is for its interior
JUST_BELOW = 1 - SIX_DIGITS  # times λ_S, where that proves most from the given state


@dataclass(frozen=True)
class Case:
    """One simulation to be made.

    Attributes
    ----------
    region
        Where the load factor lies: below λ_1 (of a load domain: below λ_U), between the
        bounds, above λ_max; below λ_lo where safe slips exist only from there on. Where nodes
        are open: whether the zone has safe slips; that no zone has any.
    load_factor
        λ.
    initial, start
        Name of the initial state, and its slip (n,) [length].
    in_ball
        Whether it lies inside the energy ball of this load factor: shakedown is proved.
    bounded
        Whether λ_S of this state is larger than this load factor: so it is, too.
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
    bounded: bool = False
    open_nodes: tuple[int, ...] = ()
    after_transient: bool = False
    arrives_closed: bool = True

    @property
    def proved(self) -> bool:
        """Whether shakedown is proved from this very state."""
        return self.in_ball or self.bounded

    @property
    def predicted(self) -> str:
        """ "shakedown", "slips or opens", or "either" where the bounds predict nothing."""
        if self.region in (UNSAFE, ABOVE, NO_ZONE):
            return "slips or opens"
        below = self.region in (BELOW, PROVED) and self.arrives_closed
        certain = below or self.initial == "safe" or self.proved  # with these nodes open
        return "shakedown" if certain else "either"


class _SafeStart(NamedTuple):
    """A safe slip, the nodes open in it, and whether it is safe only after the transient."""

    slip: FloatArray
    open_nodes: tuple[int, ...]
    after_transient: bool


def case_as_given(limits: JointLimits) -> Case:
    """The simulation of the nominal load, λ = 1, from the first given state, or from slip zero."""
    return _bounded(limits, _case_at(limits, AS_GIVEN, *_first_state(limits)))


def plan_steps(
    limits: JointLimits, load_factors: Sequence[float] | None, random_states: int, seed: int
) -> list[Callable[[], list[Case]]]:
    """Steps that plan all simulations of a verification, λ = 1 first; one step per load factor."""
    chosen = default_load_factors(limits) if load_factors is None else load_factors
    name, state = _first_state(limits)
    steps: list[Callable[[], list[Case]]] = [
        partial(_cases_at, limits, each, random_states, seed)
        for each in sorted(chosen, key=lambda load_factor: load_factor != AS_GIVEN)
    ]
    here = limits.from_state
    if load_factors is None and here.kind != "energy" and here.load_factor < np.inf:
        near = JUST_BELOW * here.load_factor
        steps.append(lambda: [_case_at(limits, near, name, state)])
    return steps


def planned_cases(limits: JointLimits, found: Iterable[Case]) -> list[Case]:
    """The simulations that such a step has found, except the nominal one."""
    name, _ = _first_state(limits)
    return [_bounded(limits, case) for case in found if (case.load_factor, case.initial) != (AS_GIVEN, name)]


def _first_state(limits: JointLimits) -> tuple[str, FloatArray]:
    """The first initial state of the problem, or slip zero, and its name."""
    return next(iter((given_states(limits.problem) | {"zero": _at_zero(limits)}).items()))


def _cases_at(limits: JointLimits, load_factor: float, random_states: int, seed: int) -> list[Case]:
    """The simulations at one load factor, from states that loads of this joint can leave, each once."""
    problem, at = limits.problem, _At(limits, load_factor)
    states = {"zero": _at_zero(limits), "safe": at.safe.slip}
    states |= {} if isinstance(limits.lower, Missing) else {"witness": limits.lower.slip}
    states |= given_states(problem)
    for k in range(random_states):
        generator = np.random.default_rng([seed, k])
        states[f"random {k}"] = slip_after_transient(
            problem, load_factor, generator, overload=OVERLOAD, tolerances=limits.tolerances
        )
    states |= at.in_ball(states.values(), seed)
    return [at.case(name, state) for name, state in _different(states).items()]


def _different(states: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """The states that exist; random ones only where they differ from the others."""
    kept: dict[str, FloatArray] = {}
    for name, state in states.items():
        again = name.startswith("random") and any(np.array_equal(state, other) for other in kept.values())
        if not (again or np.isnan(state).any()):
            kept[name] = state
    return kept


def _case_at(limits: JointLimits, load_factor: float, name: str, state: FloatArray) -> Case:
    return _At(limits, load_factor).case(name, state)


def _at_zero(limits: JointLimits) -> FloatArray:
    """Slip zero."""
    return np.zeros(limits.problem.layout.slip_size)


class _At:
    """The known facts at one load factor: its region, a safe slip, the largest energy ball."""

    def __init__(self, limits: JointLimits, load_factor: float) -> None:
        self.limits, self.load_factor = limits, load_factor
        self.region = region_of(load_factor, limits)
        self.ball = limits.ball_at(load_factor)

    def in_ball(self, others: Iterable[FloatArray], seed: int) -> dict[str, FloatArray]:
        """States in the ball, by name: just inside its surface, but no farther away than any other state."""
        ball = self.ball
        if isinstance(ball, Missing) or not 0 < ball.radius < np.inf:
            return {}
        count = 1 if takes_long(self.limits.problem) else IN_BALL
        away = np.random.default_rng(seed).normal(size=(count, ball.metric.inverse.shape[1]))
        offsets = ball.at(away, JUST_INSIDE) - ball.slip
        reach = max(np.nan_to_num(abs(other - ball.slip)).max() for other in others)
        farthest = abs(offsets).max(axis=1)
        return {
            f"ball {k}": ball.slip + min(1.0, reach / far) * offset
            for k, (offset, far) in enumerate(zip(offsets, farthest, strict=True))
            if reach > 0
        }

    def case(self, name: str, state: FloatArray) -> Case:
        """A case that begins before the transient with all nodes closed, but for some safe slips."""
        if name == "safe" and (self.safe.open_nodes or self.safe.after_transient):
            opened, later = self.safe.open_nodes, self.safe.after_transient
            return Case(self.region, self.load_factor, name, state, open_nodes=opened, after_transient=later)
        limits, judged = self.limits, self.region in (BELOW, PROVED)
        return Case(
            region=self.region,
            load_factor=self.load_factor,
            initial=name,
            start=state,
            in_ball=self._in_ball(name, state),
            arrives_closed=not judged
            or arrives_closed(limits.problem, self.load_factor, state, limits.tolerances),
        )

    def _in_ball(self, name: str, state: FloatArray) -> bool:
        """Whether a state is proved to shake down: by the largest ball, or (zero, given) by its own."""
        ball, limits = self.ball, self.limits
        if isinstance(ball, Missing):
            return False
        if ball.contains(state) or ball.radius == 0:
            return bool(ball.contains(state))
        if not name.startswith(("zero", "given")):
            return False
        own = sought(
            energy_ball, limits.problem, ball.load_factor, around=state, tolerances=limits.tolerances
        )
        return not isinstance(own, Missing) and bool(own.contains(state))

    @cached_property
    def safe(self) -> _SafeStart:
        """A slip that is safe under the transient too; where there is none, one locked in after it."""
        problem, upper, tolerances = self.limits.problem, self.limits.upper, self.limits.tolerances
        opened = upper.open_nodes
        if self.region not in (BELOW, PROVED, BETWEEN, IN_ZONE):
            return _SafeStart(np.full(problem.layout.slip_size, np.nan) if opened else upper.slip, (), False)
        before = len(transient_path(problem)) > 0
        if before and not opened:
            lasting = safe_slip(problem, self.load_factor, transient=True, tolerances=tolerances)
            if lasting.status != Status.INFEASIBLE:
                return _SafeStart(lasting.slip, (), False)
        safe = safe_slip(problem, self.load_factor, open_nodes=opened, tolerances=tolerances)
        return _SafeStart(safe.slip, opened, before)


def _bounded(limits: JointLimits, case: Case) -> Case:
    """The case, marked where it begins at the state of λ_S and below that limit."""
    if case.after_transient or case.open_nodes:
        return case
    bounds = [getattr(limits, kind.name) for kind in kinds_of(Claim.THIS_STATE)[1:]]
    below = [case.load_factor < b.load_factor and np.array_equal(case.start, b.initial_slip) for b in bounds]
    return replace(case, bounded=any(below))


def given_states(problem: Problem) -> dict[str, FloatArray]:
    """The initial states that come with a problem, by name."""
    states = () if problem.initial_slip is None else problem.initial_slip
    return {f"given {k}": state for k, state in enumerate(states)}
