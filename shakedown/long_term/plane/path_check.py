"""The friction law along a recorded path, re-checked in compiled code from slips and gaps alone.

As :func:`shakedown.motion.event_history.path_violation` and
:func:`shakedown.motion.checked_law.law_violation`, event after event as the rows of a record are
filled, together with what else one period says: nodes open throughout, and the signature of its
contact states and the changes between them, wherever it is cut: neither instants nor load steps count.
"""

import numpy as np

from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.named_state import Flags, Hash, NamedState, Reals, inner
from shakedown.ground.status import OPEN
from shakedown.motion.course import JUMPS, Course
from shakedown.motion.plane.active_set import ActiveSet, add_product, larger
from shakedown.motion.plane.event_loop import MOST_FOLLOWED
from shakedown.motion.plane.moving_state import Record


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
        code = np.uint64(14695981039346656037)
        for i in range(n):
            code = (code ^ np.uint64(rec.state[row * n + i] + 2)) * np.uint64(1099511628211)
            if rec.state[row * n + i] != OPEN:
                check.always_open[i] = 0
        check_row(check, act, rec.kind[row] == JUMPS)
        enter_contact(check, begun + steps, course.steps, code)


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
    prime = np.uint64(1099511628211)
    mixed = (check.last * prime) ^ code
    check.changes += (mixed ^ (mixed >> np.uint64(32))) * prime
