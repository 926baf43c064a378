"""The stiffness with the places of open nodes exchanged: there the reaction is given, not the displacement.

Of a free place the reaction is zero and the displacement follows from equilibrium. With these places
exchanged (a principal pivot transform of κ) the outputs

    out = reactions of the places that are not free, displacements of those that are

are linear in the displacements of the former and the welded reactions of the latter, however the
other nodes slip: an open node costs a closed one nothing until it closes again. Opening a node exchanges
its three places, closing it the same three: the exchange is its own inverse. Where one place is free
and the other is not the matrix is antisymmetric, elsewhere symmetric, so that its rows serve as columns.
"""

from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.ground.named_state import Flags, Reals, inner, summing
from shakedown.ground.status import OPEN
from shakedown.motion.course import Course
from shakedown.motion.space.space_run import TOGETHER, CompiledJoint, Slipping, SpaceMotion, SpaceRates

MOST_EXCHANGES = 60  # exchanges after which the matrix is recomputed, as each adds round-off


@inner
def exchange(joint: CompiledJoint, count: int) -> bool:
    """Exchange so many ``changing`` places, in increasing order; False where nothing else holds one of them.

    That one stays as it is.
    """
    held = True
    for k in range(count):
        held = exchange_row(joint, count, k) and held
    pass_rows(joint, count)
    return held


@summing
def exchange_row(joint: CompiledJoint, count: int, k: int) -> bool:
    """Exchange one of the changing places in their rows; False where nothing else holds it."""
    N, S, place, start = 3 * joint.n, joint.exchanged, joint.changing[k], k * 3 * joint.n
    row, old, size = place * N, joint.old_rows, 0.0
    pivot = S[row + place]
    joint.pivots[k] = 0.0
    if joint.free[place] == 0:
        for j in range(N):
            size = max(size, abs(joint.kappa[row + j]))
        if pivot <= ROUND_OFF * size:
            return False
    joint.pivots[k] = pivot
    for j in range(N):
        old[start + j] = S[row + j]
    for other in range(count):
        if other != k:
            pass_row(S, joint.changing[other] * N, old, start, N, place, pivot)
    for j in range(N):
        S[row + j] /= -pivot
    S[row + place] = 1.0 / pivot
    joint.free[place] = 1 - joint.free[place]
    joint.exchanges += 1
    return True


@summing
def pass_row(S: FloatArray, row: int, old: FloatArray, start: int, N: int, place: int, pivot: float) -> None:
    """What the exchange of a place makes of a row, from the place's row before it."""
    x = S[row + place] / pivot
    if x != 0.0:
        for j in range(N):
            S[row + j] -= x * old[start + j]
        S[row + place] = x


@inner
def pass_rows(joint: CompiledJoint, count: int) -> None:
    """What the exchanges make of all other rows, row by row, each of which stays in the cache meanwhile."""
    N, S, changing, t = 3 * joint.n, joint.exchanged, joint.changing, 0
    for i in range(N):
        if t < count and changing[t] == i:
            t += 1
            continue
        for k in range(count):
            if joint.pivots[k] != 0.0:
                pass_row(S, i * N, joint.old_rows, k * N, N, changing[k], joint.pivots[k])


@inner
def is_free(joint: CompiledJoint, mo: SpaceMotion, place: int) -> bool:
    """Whether a place is free in the present contact states."""
    n = joint.n
    if place >= 2 * n:
        return mo.contact[place - 2 * n] == OPEN
    node = place // 2
    return mo.contact[node] == OPEN or joint.friction[node] == 0.0


@inner
def arrange(joint: CompiledJoint, mo: SpaceMotion) -> bool:
    """Exchange places until those free by their contact states are; False where nothing holds one.

    What a cycle begins with is kept, as most begin with the same places free as the last.
    """
    N, held, count, before = 3 * joint.n, True, 0, joint.exchanges
    afresh = before > MOST_EXCHANGES
    if afresh and is_kept(joint, mo):
        recall(joint)
        return True
    if afresh:
        for k in range(N * N):
            joint.exchanged[k] = joint.kappa[k]
        for place in range(N):
            joint.free[place] = 0
    for place in range(N):
        if is_free(joint, mo, place) != (joint.free[place] == 1):
            joint.changing[count] = place
            count += 1
        if count == TOGETHER or (place == N - 1 and count > 0):
            held, count = exchange(joint, count) and held, 0
    if afresh:
        if held and joint.exchanges > before and mo.step == 0 and mo.time == 0.0:
            keep(joint)
        # Exchanges of the recomputation do not count, or many open nodes would trigger it every time.
        joint.exchanges = 0
    return held


@inner
def is_kept(joint: CompiledJoint, mo: SpaceMotion) -> bool:
    """Whether the matrix made afresh for the present contact states is at hand."""
    kept = joint.keeps
    for place in range(3 * joint.n):
        kept = kept and is_free(joint, mo, place) == (joint.kept_free[place] == 1)
    return kept


@inner
def keep(joint: CompiledJoint) -> None:
    """Keep the matrix that has been made afresh."""
    copy(joint.exchanged, joint.free, joint.kept, joint.kept_free, 3 * joint.n)
    joint.keeps = True


@inner
def recall(joint: CompiledJoint) -> None:
    """Go back to the matrix that is kept."""
    copy(joint.kept, joint.kept_free, joint.exchanged, joint.free, 3 * joint.n)
    joint.exchanges = 0


@inner
def copy(matrix: Reals, free: Flags, other: Reals, free_there: Flags, N: int) -> None:
    """Copy a matrix (N, N), and which places are free in it."""
    for k in range(N * N):
        other[k] = matrix[k]
    for place in range(N):
        free_there[place] = free[place]


@summing
def compute_base(joint: CompiledJoint, rates: SpaceRates) -> None:
    """Rates of the outputs while nothing slips."""
    N, S, base = 3 * joint.n, joint.exchanged, rates.base
    for i in range(N):
        base[i] = 0.0
    for j in range(N):
        x = rates.welded[j]
        if joint.free[j] == 1 and x != 0.0:
            for i in range(N):
                base[i] += x * S[j * N + i]
    for i in range(N):
        base[i] = -base[i] if joint.free[i] == 1 else base[i] + rates.welded[i]


@inner
def is_welded(joint: CompiledJoint) -> bool:
    """Whether nothing is free, and nothing has been since ``exchanged`` was made afresh."""
    for place in range(3 * joint.n):
        if joint.free[place] == 1:
            return False
    return joint.exchanges == 0


@summing
def press(joint: CompiledJoint, mo: SpaceMotion) -> None:
    """κ u, part by part, of which only those are worked out again in which a displacement has changed."""
    N, S, parts, size, u, known = 3 * joint.n, joint.kappa, joint.parts, joint.part, mo.u, joint.known
    count, new = (N + size - 1) // size, not known
    for part in range(count):
        first, end, same = part * size, min((part + 1) * size, N), known
        for j in range(first, end):
            same = same and joint.displaced[j] == u[j]
        if same:
            continue
        new, start = True, part * N
        for i in range(N):
            parts[start + i] = 0.0
        for j in range(first, end):
            x = u[j]
            joint.displaced[j] = x
            if x != 0.0:
                for i in range(N):
                    parts[start + i] += x * S[j * N + i]
    joint.known = True
    if not new:
        return
    for i in range(N):
        joint.pressed[i] = parts[i]
    for part in range(1, count):
        for i in range(N):
            joint.pressed[i] += parts[part * N + i]


@summing
def compute_out(joint: CompiledJoint, course: Course, mo: SpaceMotion, rates: SpaceRates) -> None:
    """Recompute the outputs from the displacements and the load at the present time."""
    N, S, out = 3 * joint.n, joint.exchanged, mo.out
    if is_welded(joint):
        press(joint, mo)
        for i in range(N):
            out[i] = joint.pressed[i] + (course.path[mo.step * N + i] + mo.time * rates.welded[i])
        return
    for i in range(N):
        out[i] = 0.0
    for j in range(N):
        x = course.path[mo.step * N + j] + mo.time * rates.welded[j] if joint.free[j] == 1 else mo.u[j]
        if x != 0.0:
            for i in range(N):
                out[i] += x * S[j * N + i]
    for i in range(N):
        if joint.free[i] == 1:
            out[i] = -out[i]
            mo.u[i] = out[i]
        else:
            out[i] += course.path[mo.step * N + i] + mo.time * rates.welded[i]


@summing
def move(joint: CompiledJoint, sp: Slipping, slip: FloatArray, start: int, target: FloatArray) -> None:
    """The change of the outputs due to packed slips (from ``start`` on)."""
    N, S = 3 * joint.n, joint.exchanged
    for i in range(N):
        target[i] = 0.0
    for a in range(sp.s):
        first, x, y = 2 * sp.node[a] * N, slip[start + 2 * a], slip[start + 2 * a + 1]
        for i in range(N):
            along = target[i] + x * S[first + i]
            target[i] = along + y * S[first + N + i]
    for i in range(N):
        if joint.free[i] == 1:
            target[i] = -target[i]


@summing
def move_twice(
    joint: CompiledJoint,
    sp: Slipping,
    slip: FloatArray,
    out: FloatArray,
    k: FloatArray,
    start: int,
    rate: FloatArray,
) -> None:
    """As :func:`move`, what packed slips and, from ``start`` on, their rates change, in one pass."""
    N, S = 3 * joint.n, joint.exchanged
    for i in range(N):
        out[i], rate[i] = 0.0, 0.0
    for a in range(sp.s):
        first = 2 * sp.node[a] * N
        x, y, dx, dy = slip[2 * a], slip[2 * a + 1], k[start + 2 * a], k[start + 2 * a + 1]
        for i in range(N):
            one, other = S[first + i], S[first + N + i]
            out[i] += x * one + y * other
            rate[i] += dx * one + dy * other
    for i in range(N):
        if joint.free[i] == 1:
            out[i], rate[i] = -out[i], -rate[i]
