"""The data of a search for long-term states in compiled code: progress, rules, answers."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.named_state import Hash, Integers, NamedState, Reals
from shakedown.long_term.plane.path_check import PathCheck
from shakedown.long_term.plane.period_map import PeriodMap
from shakedown.motion.plane.moving_state import PlaneRun


class Answers(NamedTuple):
    """The answers for each of s initial slips.

    Attributes
    ----------
    final_slip, slip_per_cycle : (s, n)
        Slips at the end of a period; Σ|Δv| in contact over it.
    dissipation, contraction : (s,)
        Per cycle.
    verdict, period, cycles_simulated : (s,)
        UNDECIDED, BROKEN, BLURRED, LEFT or an outcome; cycles of a period; cycles followed.
    signature : (s,)
        Of the contact states of a period.
    """

    final_slip: FloatArray
    slip_per_cycle: FloatArray
    dissipation: FloatArray
    contraction: FloatArray
    verdict: NDArray[np.int64]
    period: NDArray[np.int64]
    cycles_simulated: NDArray[np.int64]
    signature: NDArray[np.uint64]


class Settler(NamedState):
    """One search after the other for the long-term states of a joint.

    Attributes
    ----------
    first, cyclic, recorded
        Runs of one moving state through its first cycle, with what comes before it; through
        another one; through another one, recorded.
    map, check
        The map of a period; the friction law along a period.
    past : (capacity, 2n)
        u after the cycles followed so far.
    signatures, wanted : (2 · longest period,)
        Of the last cycles; of the period that is expected to repeat.
    goal, reached : (2n,)
        The state to be confirmed or tried; the last one found to run through the sequence.
    contact : (n,)
        Contact states of the goal.
    force, drift : (2n,)
        Scratch, reactions; what the slips gain per period for ever.
    weight : (2n,)
        By how much smaller than ``check.near`` a slip or gap must be to count as none.
    blurred
        Whether the loads that change are next to round-off.
    slip : (n,)
        Σ|Δv| since the period began.
    works : (longest period,)
        What friction and jumps took in each of its cycles.
    opened : (n,)
        1 where the node was open in it.
    row, verdict, phase
        Which initial slip, what has been found, what is being done.
    resumed, placed
        Whether the present cycle has been entered already, and whether the goal state has been set.
    from_limit
        Whether it is a limit that is to be confirmed.
    period, done
        Cycles of the period, and of these followed in the present phase.
    cycles, remembered, signed, patience, leaps
        Cycles followed; states in ``past``; entries of ``signatures``; cycles to wait before the
        next map; leaps tried.
    leap
        Periods leapt over.
    contraction, far
        Factor per cycle; how far the period misses the goal, weighted.
    friction, damping, jumps
        What friction took since the period began, and the damping in so many jumps.
    jump_friction, jump_damping, jumped
        The same of the jumps of the present cycle alone.
    events, spent
        Followed in all; effort of the present call.
    most_cycles, longest_period
        As for :func:`long_term_state`.
    capacity
        States that are remembered; of a search that needs more, the latest.
    least_force, limit, rounding
        The force scale of the loads; multiples of the largest force that count as zero and as settled.
    friction_law
        Largest relative violation of the friction law.
    stiffness
        Largest entry of κ.
    """

    first: PlaneRun
    cyclic: PlaneRun
    recorded: PlaneRun
    map: PeriodMap
    check: PathCheck
    past: Reals
    signatures: Integers
    wanted: Integers
    goal: Reals
    reached: Reals
    contact: Integers
    force: Reals
    drift: Reals
    weight: Reals
    slip: Reals
    works: Reals
    opened: Integers
    row: int
    verdict: int
    phase: int
    resumed: bool
    placed: bool
    from_limit: bool
    period: int
    done: int
    cycles: int
    remembered: int
    signed: int
    patience: int
    leaps: int
    leap: float
    signature: Hash
    contraction: float
    far: float
    friction: float
    damping: float
    jumps: int
    jump_friction: float
    jump_damping: float
    jumped: int
    events: int
    spent: int
    most_cycles: int
    longest_period: int
    capacity: int
    least_force: float
    limit: float
    rounding: float
    friction_law: float
    stiffness: float
    blurred: bool


def search(
    runs: tuple[PlaneRun, PlaneRun, PlaneRun],
    pm: PeriodMap,
    check: PathCheck,
    capacity: int,
    longest_period: int,
) -> Settler:
    """A search over three runs of one moving state: the first cycle, the others, the others recorded."""
    n = pm.contact.size
    shapes: dict[str, Any] = {"past": (capacity, 2 * n), "works": longest_period}
    shapes |= dict.fromkeys(("signatures", "wanted"), 2 * longest_period)
    shapes |= dict.fromkeys(("goal", "reached", "force", "drift"), 2 * n)
    shapes |= dict.fromkeys(("contact", "slip", "opened"), n)
    first, cyclic, recorded = runs
    new = Settler(
        shapes, weight=np.ones(2 * n), first=first, cyclic=cyclic, recorded=recorded, map=pm, check=check
    )
    new.set(capacity=capacity, longest_period=longest_period)
    return new
