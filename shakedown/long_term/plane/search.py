"""The data of a search for long-term states in compiled code, and the friction law along its path.

The law is re-checked from slips and gaps alone, event after event as the rows of a record are filled.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.named_state import Flags, Hash, Integers, NamedState, Reals, inner
from shakedown.ground.status import OPEN
from shakedown.long_term.plane.period_map import PeriodMap
from shakedown.motion.course import HASH_PRIME, Course, EventKind, code_of
from shakedown.motion.plane.active_set import ActiveSet, add_product, larger
from shakedown.motion.plane.event_loop import MOST_FOLLOWED
from shakedown.motion.plane.moving_state import PlaneRun, Record


class PathCheck(NamedState):
    """The results of the rows of a record checked so far.

    Attributes
    ----------
    u, r : (2n,)
        Slips and gaps at the last row; reactions computed from them [force].
    elastic, change : (2n,)
        κ u at the last row [force]; scratch.
    f : (n,)
        Friction coefficients.
    always_open : (n,)
        1 where the node was open at every row.
    force, length, near
        Force and length scale, and the slip or gap that counts as none [length].
    violation
        Largest relative violation of the law, without the first row.
    rows, added
        Rows seen, and since κ u was computed.
    time
        Time of the last row, in load steps.
    code, first, last
        Hash of the contact states of the last row; of those that lasted first and last.
    changes
        Sum over the changes of contact states, as a hash.
    """

    u: Reals
    r: Reals
    elastic: Reals
    change: Reals
    f: Reals
    always_open: Flags
    force: float
    length: float
    near: float
    violation: float
    rows: int
    added: int
    time: float
    code: Hash
    first: Hash
    last: Hash
    changes: Hash


def path_check(f: FloatArray) -> PathCheck:
    """Arrays for checking the path of nodes with given friction coefficients."""
    n = len(f)
    shapes = dict.fromkeys(("u", "r", "elastic", "change"), 2 * n) | {"always_open": n}
    return PathCheck(shapes, f=np.array(f, dtype=float))


@inner
def begin_check(check: PathCheck, n: int) -> None:
    """Reset the check."""
    zero = np.uint64(0)
    check.violation, check.rows, check.added, check.time = 0.0, 0, 0, 0.0
    check.code, check.first, check.last, check.changes = zero, zero, zero, zero
    for i in range(n):
        check.always_open[i] = 1


@inner
def check_rows(check: PathCheck, act: ActiveSet, rec: Record, course: Course, passes: int) -> None:
    """Check the rows of a record, a given number of passes after the first."""
    n, m, begun = act.n, 2 * act.n, passes * course.steps
    for row in range(rec.rows):
        steps = rec.time[row] - course.first
        place = min(int(steps), course.steps - 1)
        share = steps - place
        for j in range(m):
            at, to = course.path[place * m + j], course.path[(place + 1) * m + j]
            check.r[j] = at + share * (to - at)
            check.change[j] = rec.u[row * m + j]
        for i in range(n):
            if rec.state[row * n + i] != OPEN:
                check.always_open[i] = 0
        check_row(check, act, rec.kind[row] == EventKind.JUMPS)
        enter_contact(check, begun + steps, course.steps, code_of(rec.state, row * n, n))


@inner
def end_check(check: PathCheck, act: ActiveSet, course: Course, u: FloatArray, passes: int) -> np.uint64:
    """Check the end of a period of a number of passes; returns the signature of its contact states."""
    n, m = act.n, 2 * act.n
    for j in range(m):
        check.r[j], check.change[j] = course.path[course.steps * m + j], u[j]
    for i in range(n):
        if act.state[i] != OPEN:
            check.always_open[i] = 0
    check_row(check, act, False)
    enter_contact(check, float(passes * course.steps), course.steps, np.uint64(0))
    if check.first != check.last:
        enter_change(check, check.first)
    return check.changes if check.changes != np.uint64(0) else check.first


@inner
def check_row(check: PathCheck, act: ActiveSet, jumps: bool) -> None:
    """Reactions at a row from welded ones ``r`` and displacements ``change``; the law, except in jumps."""
    n, m, u, r, change = act.n, 2 * act.n, check.u, check.r, check.change
    near = check.near
    for j in range(m):
        at = change[j]
        change[j] = at - u[j]
        u[j] = at
    if check.rows == 0 or check.added >= MOST_FOLLOWED:
        for j in range(m):
            check.elastic[j] = 0.0
        add_product(act, u, check.elastic)
        check.added = 0
    else:
        add_product(act, change, check.elastic)
        check.added += 1
    for j in range(m):
        r[j] += check.elastic[j]
    check.rows += 1
    if check.rows == 1:
        return
    for i in range(n):
        w = u[n + i]
        open_at_all = w > near or w - change[n + i] > near
        slip = 0.0 if open_at_all or jumps else change[i]
        broken = broken_law(check, check.f[i], r[i], r[n + i], w, slip)
        check.violation = larger(check.violation, broken)


@inner
def broken_law(check: PathCheck, f: float, q: float, p: float, w: float, slip: float) -> float:
    """The relative violation of the contact and friction law at a node; infinite for NaN."""
    q, p, w, slip = q / check.force, p / check.force, w / check.length, slip / check.length
    worst = larger(larger(-w, -p), abs(q) - f * p)
    worst = larger(worst, smaller(w, larger(abs(p), abs(q))))
    worst = larger(worst, smaller(slip, abs(q + f * p)))
    worst = larger(worst, smaller(-slip, abs(q - f * p)))
    if worst != worst or q + p + w + slip != q + p + w + slip:
        return np.inf
    return larger(worst, 0.0)


@inner
def smaller(a: float, b: float) -> float:
    """The smaller of two numbers."""
    return a if a < b else b


@inner
def enter_contact(check: PathCheck, time: float, steps: int, code: np.uint64) -> None:
    """The contact states of the previous row lasted until now, when these take over."""
    if check.rows > 1 and time - check.time > NEGLIGIBLE * steps:
        if check.first == np.uint64(0):
            check.first = check.code
        elif check.code != check.last:
            enter_change(check, check.code)
        check.last = check.code
    check.code, check.time = code, time


@inner
def enter_change(check: PathCheck, code: np.uint64) -> None:
    """Count the change from the contact states that lasted before to these."""
    mixed = (check.last * HASH_PRIME) ^ code
    check.changes += (mixed ^ (mixed >> np.uint64(32))) * HASH_PRIME


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


class PlaneSearch(NamedState):
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
    cycles, remembered, signed, wait, leaps
        Cycles followed; states in ``past``; entries of ``signatures``; cycles to wait before the
        next map; leaps tried.
    leap
        Periods leapt over.
    contraction, far
        Factor per cycle; how far the period misses the goal, weighted.
    friction, damping, jumps
        What friction took since the period began, and the damping in so many jumps.
    jump_friction, jump_damping, jumped
        The same of the jumps of the present cycle alone, counted with instants at which the state stays.
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
    wait: int
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


def plane_search(
    runs: tuple[PlaneRun, PlaneRun, PlaneRun],
    pm: PeriodMap,
    check: PathCheck,
    capacity: int,
    longest_period: int,
) -> PlaneSearch:
    """A search over three runs of one moving state: the first cycle, the others, the others recorded."""
    n = pm.contact.size
    shapes: dict[str, Any] = {"past": (capacity, 2 * n), "works": longest_period}
    shapes |= dict.fromkeys(("signatures", "wanted"), 2 * longest_period)
    shapes |= dict.fromkeys(("goal", "reached", "force", "drift"), 2 * n)
    shapes |= dict.fromkeys(("contact", "slip", "opened"), n)
    first, cyclic, recorded = runs
    new = PlaneSearch(
        shapes, weight=np.ones(2 * n), first=first, cyclic=cyclic, recorded=recorded, map=pm, check=check
    )
    new.set(capacity=capacity, longest_period=longest_period)
    return new
