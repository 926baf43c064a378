"""The beginning of a search: cycles one by one, until the state returns or its contact states repeat."""

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import inner
from shakedown.ground.status import BACKWARD_SLIP, STICK
from shakedown.long_term.plane.path_check import broken_law
from shakedown.long_term.plane.period_map import begin_map, end_map
from shakedown.long_term.plane.search import BROKEN, CONFIRM, LIMIT, MAP, REPEATS, SEARCHING, WALK, Settler
from shakedown.motion.plane.active_set import add_product, factorize, larger


@inner
def begin_search(se: Settler, start: FloatArray) -> None:
    """Begin at rest with this slip: the load before the first step, and what counts as zero."""
    act, path, goal, locked = se.first.active, se.first.course.path, se.goal, se.force
    n, m, force = act.n, 2 * act.n, se.least_force
    for i in range(n):
        goal[i], goal[n + i] = start[i], 0.0
        se.contact[i] = BACKWARD_SLIP if act.f[i] == 0.0 else STICK
    for j in range(m):
        total = 0.0
        for i in range(n):
            total += abs(act.kappa[j * m + i]) * abs(goal[i])
        force = larger(force, total)
        locked[j] = 0.0
    add_product(act, goal, locked)
    for i in range(n):
        path[i] = -locked[i]
        path[n + i] = abs(path[m + n + i] + locked[n + i]) - locked[n + i]
    for course in (se.first.course, se.cyclic.course, se.recorded.course):
        course.force, course.settled = se.limit * force, se.rounding * force
    begin_walk(se)
    se.placed = False


@inner
def begin_walk(se: Settler) -> None:
    """Begin before any cycle is followed."""
    se.first.motion.parameters = 0
    se.cycles, se.events, se.remembered, se.signed, se.patience, se.resumed = 0, 0, 0, 0, 0, False
    se.phase, se.verdict, se.placed, se.from_limit = WALK, SEARCHING, True, False


@inner
def place_state(se: Settler) -> bool:
    """Continue from the goal; False where its moving nodes are not held."""
    act, mo = se.first.active, se.first.motion
    for j in range(2 * act.n):
        mo.u[j] = se.goal[j]
    for i in range(act.n):
        act.state[i] = se.contact[i]
    se.placed = factorize(act) != 0
    return se.placed


@inner
def remember(se: Settler, u: FloatArray) -> None:
    """Store a state; where there are too many, the older half is dropped."""
    m = 2 * se.first.active.n
    if se.remembered == se.capacity:
        se.remembered = se.capacity // 2
        for j in range(se.remembered * m):
            se.past[j] = se.past[(se.capacity - se.remembered) * m + j]
    for j in range(m):
        se.past[se.remembered * m + j] = u[j]
    se.remembered += 1


@inner
def keep_signature(se: Settler) -> None:
    """Append the signature of the last cycle and drop the oldest."""
    most = 2 * se.longest_period
    if se.signed == most:
        for k in range(most - 1):
            se.signatures[k] = se.signatures[k + 1]
        se.signed = most - 1
    se.signatures[se.signed] = np.int64(se.first.motion.signature)
    se.signed += 1


@inner
def after_walk(se: Settler) -> None:
    """Where the state equals that of some cycles ago, one period has to confirm it."""
    act, mo = se.first.active, se.first.motion
    remember(se, mo.u)
    keep_signature(se)
    se.period = returned_after(se)
    if se.period == 0:
        se.phase = REPEATS
        return
    if not admissible(se, mo.u):
        se.verdict = BROKEN
    se.contraction = observed_contraction(se, se.period)
    for j in range(2 * act.n):
        se.goal[j], se.drift[j] = mo.u[j], 0.0
    for i in range(act.n):
        se.contact[i] = act.state[i]
    se.phase, se.done, se.placed, se.from_limit = CONFIRM, 0, False, False


@inner
def returned_after(se: Settler) -> int:
    """The number of cycles after which the state returned, to round-off; 0 where it did not."""
    last = se.remembered - 1
    for period in range(1, min(se.longest_period, last) + 1):
        if distance(se, last - period, last) <= 1e-3 * se.check.near:
            return period
    return 0


@inner
def distance(se: Settler, one: int, other: int) -> float:
    """Largest difference of two states of the past, weighted."""
    m, far = 2 * se.first.active.n, 0.0
    for j in range(m):
        far = larger(far, se.weight[j] * abs(se.past[one * m + j] - se.past[other * m + j]))
    return far


@inner
def observed_contraction(se: Settler, period: int) -> float:
    """Factor per cycle between the last two distances to the present state that exceed round-off."""
    last, nearer = se.remembered - 1, 0.0
    for one in range(last - period, -1, -period):
        far = distance(se, one, last)
        if far > 10.0 * se.check.near:
            if nearer > 0.0:
                return (nearer / far) ** (1.0 / period)
            nearer = far
    return 0.0


@inner
def admissible(se: Settler, u: FloatArray) -> bool:
    """Whether a state between two cycles obeys the contact and friction law."""
    act, course, r = se.first.active, se.cyclic.course, se.force
    n, m, worst = act.n, 2 * act.n, 0.0
    for j in range(m):
        r[j] = course.path[course.steps * m + j]
    add_product(act, u, r)
    for i in range(n):
        worst = larger(worst, broken_law(se.check, se.check.f[i], r[i], r[n + i], u[n + i], 0.0))
    return worst <= se.friction_law


@inner
def look_for_repeats(se: Settler) -> None:
    """Where the sequence of contact states repeats, follow one more period with its derivative."""
    se.patience -= 1
    se.phase = WALK
    if se.patience > 0:
        return
    for period in range(1, se.longest_period + 1):
        if sequence_repeats(se, period):
            begin_map(se.map, se.first.active, se.first.motion)
            se.phase, se.period, se.done, se.jumps = MAP, period, 0, 0
            return


@inner
def sequence_repeats(se: Settler, period: int) -> bool:
    """Whether the last cycles have the signatures of those before, which then become ``wanted``."""
    if se.signed < 2 * period:
        return False
    for k in range(period):
        last = se.signatures[se.signed - period + k]
        if last != se.signatures[se.signed - 2 * period + k]:
            return False
        se.wanted[k] = last
    return True


@inner
def after_map(se: Settler) -> None:
    """The map of the period, if it passed through the expected sequence."""
    act, mo = se.first.active, se.first.motion
    keep_signature(se)
    if se.done < se.period:
        return
    mo.parameters = 0
    remember(se, mo.u)
    se.phase = LIMIT if se.jumps == 0 else WALK
    for k in range(se.period):
        if se.signatures[se.signed - se.period + k] != se.wanted[k]:
            se.phase = WALK
    for i in range(act.n):
        if act.state[i] != se.map.contact[i]:
            se.phase = WALK
    for j in range(2 * act.n):
        se.reached[j] = mo.u[j]
    end_map(se.map, mo)
