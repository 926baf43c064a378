"""Which load factors and initial states a verification follows, and what is predicted of them."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from shakedown.assessment.assess import AS_GIVEN
from shakedown.assessment.every_limit import JointLimits
from shakedown.bounds.energy.energy_ball import energy_ball
from shakedown.bounds.registry import BOUNDS, Claim, kinds_of, takes_long
from shakedown.bounds.upper import safe_slip
from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray
from shakedown.ground.errors import Missing, attempt, present
from shakedown.ground.shown_values import FEW_DIGITS
from shakedown.ground.status import Status
from shakedown.ground.work_limit import limited_work
from shakedown.joint.constraints import transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.motion_start import arrives_closed, slip_after_transient

UNSAFE, BELOW, BETWEEN, ABOVE = "below λ_lo", "below λ_1", "between", "above λ_max"
PROVED = "below λ_U"  # for a load domain, where λ_1 predicts nothing, and in space, where it does not exist
IN_ZONE, OUTSIDE = "zone is safe", "zone is not safe"  # between λ_lo and λ_max of a zone, and elsewhere
NO_ZONE = "no zone is safe"  # all were tried


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Case(Result):
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
    open_nodes
        The nodes that are open in it.
    after_transient
        Whether it is a state after the transient load steps, which are left out: so is one with
        open nodes, and a safe slip where the transient moves every one.
    in_ball
        Whether it lies inside the energy ball of this load factor: shakedown is proved.
    bounded
        Whether another proof from this very state, as λ_S, reaches beyond this load factor: so it is, too.
    arrives_closed
        Whether the transient leaves all nodes closed, so that limits for every closed state hold for the
        state after it.
    """

    region: str
    load_factor: float
    initial: str
    start: FloatArray
    open_nodes: tuple[int, ...] = ()
    after_transient: bool = False
    in_ball: bool = False
    bounded: bool = False
    arrives_closed: bool = True

    @property
    def proved(self) -> bool:
        """Whether shakedown is proved from this very state."""
        return self.in_ball or self.bounded

    @property
    def only_slips(self) -> bool:
        """Whether it is proved not to come to rest, at another load factor than the nominal one."""
        return self.region == ABOVE and self.load_factor != AS_GIVEN

    @property
    def predicted(self) -> str:
        """ "shakedown", "slips or opens", or "either" where the bounds predict nothing."""
        if self.region in (UNSAFE, ABOVE, NO_ZONE):
            return "slips or opens"
        below = self.region in (BELOW, PROVED) and self.arrives_closed
        certain = below or self.initial == "safe" or self.proved  # with these nodes open
        return "shakedown" if certain else "either"


def predicted_below(limits: JointLimits) -> tuple[float, str]:
    """Up to where every closed state is predicted to shake down: λ_1; for a load domain and in space λ_U."""
    lower = limits.lower
    if isinstance(lower, Missing) or limits.problem.is_domain:
        return limits.universal.load_factor, PROVED
    return lower.load_factor, BELOW


def default_load_factors(limits: JointLimits) -> list[float]:
    """One load factor slightly inside every region that is wider than four digits resolve.

    Examples
    --------
    >>> import shakedown
    >>> limits = shakedown.assess(shakedown.example("two-node")).details
    >>> [round(x, 3) for x in default_load_factors(limits)]
    [0.625, 0.682, 0.776]
    """
    upper = limits.upper
    least, last = upper.least_load_factor, upper.load_factor
    first, _ = predicted_below(limits)
    factors = [0.95 * first] if 0 < first < np.inf else []
    if upper.status in (Status.INFEASIBLE, Status.UNDECIDED):
        return [1.0]
    if upper.open_nodes:
        inside = [least + 0.5 * (last - least), least + 0.999 * (last - least)]
        return [*factors, *inside, 1.05 * last or 1.0] if last < np.inf else [*factors, 1.5 * least or 1.0]
    if least > 0:  # the mean load alone has no safe slip, and so there is no λ_1
        factors, first = [0.95 * least], least
    elif np.isinf(first):  # nothing ever collapses
        return [1.0, 10.0]
    if np.isinf(last):
        return [*factors, 1.5 * first or 1.0]
    if not first and not limits.lower:  # from every state nothing is proved
        energy = present(attempt(lambda: limits.energy))
        if energy is not None and 0.0 < energy.load_factor < last:
            first = energy.load_factor
            factors = [0.95 * first]
    # relative width below which nothing is simulated in a region
    if last > first * (1 + 10.0**-FEW_DIGITS):
        factors.append(first + 0.3 * (last - first))
    return [*factors, 1.05 * last or 1.0]


def region_of(load_factor: float, limits: JointLimits) -> str:
    """The region that a load factor lies in."""
    upper = limits.upper
    first, below = predicted_below(limits)
    if load_factor < first:  # whatever zone λ_max is about
        return below
    if upper.open_nodes:
        return IN_ZONE if upper.least_load_factor <= load_factor <= upper.load_factor else OUTSIDE
    if upper.status == Status.UNDECIDED:
        return OUTSIDE
    if upper.status == Status.INFEASIBLE:
        return NO_ZONE if limits.zone == "auto" else ABOVE
    if load_factor < upper.least_load_factor:
        return UNSAFE
    return ABOVE if load_factor > upper.load_factor else BETWEEN


def plan_steps(
    limits: JointLimits, load_factors: Sequence[float] | None, random_states: int, seed: int
) -> list[Callable[[], list[Case]]]:
    """Steps that plan all simulations but the nominal one; one per load factor, λ = 1 first.

    Where a proof from this state that is not about a ball reaches farthest, it is followed just below that.
    """
    chosen = default_load_factors(limits) if load_factors is None else load_factors
    steps: list[Callable[[], list[Case]]] = [
        partial(_cases_at, limits, each, random_states, seed)
        for each in sorted(chosen, key=lambda load_factor: load_factor != AS_GIVEN)
    ]
    here = limits.from_state
    if load_factors is None and not BOUNDS[here.kind].of_ball and here.load_factor < np.inf:
        near = (1 - SIX_DIGITS) * here.load_factor  # times the largest proof from the given state
        steps.append(lambda: [_case(limits, near, *_first_state(limits.problem))])
    return steps


def case_as_given(limits: JointLimits) -> Case:
    """The simulation of the nominal load, λ = 1, from the first given state, or from slip zero."""
    return _case(limits, AS_GIVEN, *_first_state(limits.problem))


def _given_states(problem: Problem) -> dict[str, FloatArray]:
    """The initial states that come with a problem, by name."""
    states = () if problem.initial_slip is None else problem.initial_slip
    return {f"given {k}": state for k, state in enumerate(states)}


def _first_state(problem: Problem) -> tuple[str, FloatArray]:
    """The first initial state of the problem, or slip zero, and its name."""
    states = _given_states(problem) | {"zero": np.zeros(problem.layout.slip_size)}
    return next(iter(states.items()))


def _cases_at(limits: JointLimits, load_factor: float, random_states: int, seed: int) -> list[Case]:
    """The simulations at one load factor but the nominal one, from states that loads can leave, each once."""
    problem, safe = limits.problem, _safe_start(limits, load_factor)
    states = {"zero": np.zeros(problem.layout.slip_size), "safe": safe["start"]}
    states |= {} if isinstance(limits.lower, Missing) else {"witness": limits.lower.slip}
    states |= _given_states(problem)
    for k in range(random_states):
        generator = np.random.default_rng([seed, k])
        with limited_work(2e9):  # multiplications and additions on the way there: half a second
            # within the loads of the loop few joints slip
            states[f"random {k}"] = slip_after_transient(
                problem, load_factor, generator, overload=2.0, tolerances=limits.tolerances
            )
    states |= _states_in_ball(limits, load_factor, states.values(), seed)
    nominal = _first_state(problem)[0] if load_factor == AS_GIVEN else ""
    at: dict[str, Any] = {"region": region_of(load_factor, limits), "load_factor": load_factor}
    return [
        Case(**at, initial=name, **safe)
        if name == "safe" and (safe.get("open_nodes") or safe.get("after_transient"))
        else _case(limits, load_factor, name, state)
        for name, state in _different(states).items()
        if name != nominal
    ]


def _different(states: dict[str, FloatArray]) -> dict[str, FloatArray]:
    """The states that exist; random ones only where they differ from the others."""
    kept: dict[str, FloatArray] = {}
    for name, state in states.items():
        again = name.startswith("random") and any(np.array_equal(state, other) for other in kept.values())
        if not (again or np.isnan(state).any()):
            kept[name] = state
    return kept


def _states_in_ball(
    limits: JointLimits, load_factor: float, others: Iterable[FloatArray], seed: int
) -> dict[str, FloatArray]:
    """States in the ball, by name: just inside its surface, but no farther away than any other state."""
    ball = limits.ball_at(load_factor)
    if isinstance(ball, Missing) or not 0 < ball.radius < np.inf:
        return {}
    count = 1 if takes_long(limits.problem) else 2  # initial states drawn in the energy ball per load factor
    away = np.random.default_rng(seed).normal(size=(count, ball.metric.inverse.shape[1]))
    # times its radius, as the proof is for its interior
    offsets = ball.at(away, 1 - 10 * NEGLIGIBLE) - ball.slip
    reach = max(np.nan_to_num(abs(other - ball.slip)).max() for other in others)
    farthest = abs(offsets).max(axis=1)
    return {
        f"ball {k}": ball.slip + min(1.0, reach / far) * offset
        for k, (offset, far) in enumerate(zip(offsets, farthest, strict=True))
        if reach > 0
    }


def _case(limits: JointLimits, load_factor: float, name: str, state: FloatArray) -> Case:
    """A case that begins before the transient with all nodes closed."""
    region = region_of(load_factor, limits)
    judged = region in (BELOW, PROVED)
    own = [getattr(limits, kind.name) for kind in kinds_of(Claim.THIS_STATE) if not kind.of_ball]
    return Case(
        region=region,
        load_factor=load_factor,
        initial=name,
        start=state,
        in_ball=_is_in_ball(limits, load_factor, name, state),
        bounded=any(load_factor < b.load_factor and np.array_equal(state, b.initial_slip) for b in own),
        arrives_closed=not judged or arrives_closed(limits.problem, load_factor, state, limits.tolerances),
    )


def _is_in_ball(limits: JointLimits, load_factor: float, name: str, state: FloatArray) -> bool:
    """Whether a state is proved to shake down: by the largest ball, or (zero, given) by its own."""
    ball, own = present(limits.ball_at(load_factor)), name.startswith(("zero", "given"))
    if own and ball is not None and ball.radius > 0 and not ball.contains(state):
        found = attempt(energy_ball, limits.problem, load_factor, around=state, tolerances=limits.tolerances)
        ball = present(found)
    return ball is not None and bool(ball.contains(state))


def _safe_start(limits: JointLimits, load_factor: float) -> dict[str, Any]:
    """How a case from a safe slip begins: of one safe under the transient too, else locked in after it.

    The centre of the energy ball is one.
    """
    problem, opened, tolerances = limits.problem, limits.open_nodes, limits.tolerances
    if region_of(load_factor, limits) not in (BELOW, PROVED, BETWEEN, IN_ZONE):
        return {"start": np.full(problem.layout.slip_size, np.nan) if opened else limits.upper.slip}
    ball = present(limits.ball_at(load_factor))
    if ball is not None and ball.status != Status.INFEASIBLE and not opened:
        return {"start": ball.slip}
    for lasting in (not opened, False):  # without a transient both are the same
        safe = safe_slip(problem, load_factor, open_nodes=opened, transient=lasting, tolerances=tolerances)
        if lasting and safe.status != Status.INFEASIBLE:
            return {"start": safe.slip}
    return {"start": safe.slip, "open_nodes": opened, "after_transient": len(transient_path(problem)) > 0}
