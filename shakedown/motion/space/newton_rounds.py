"""Newton's method on the slipping nodes of one load step, the same nodes open (Alart and Curnier 1991).

A closed node obeys the law where its reaction is that of the map

    F = q − f p⁺ x/|x|  if |x| > f p⁺ (it slips),   F = ρ s  otherwise (it sticks),   x = q − ρ s,

s its slip from where it touches and p⁺ = max(p, 0): a closed node in tension has no friction until
the next sweep opens it. Unknown are the slips of those that slip, and of those that were open before
the step: where they touch follows from their reactions. The others go where they stick.
"""

import numpy as np

from shakedown.ground.named_state import borrowing, inner
from shakedown.ground.round_off import FOUR_DIGITS, NEWTON_ROUNDS, PER_CENT
from shakedown.motion.space.dense_solver import factorise, solve
from shakedown.motion.space.sweeps import contact_position
from shakedown.motion.space.swept_stiffness import inverse

HALVINGS = 8  # of one step
FAR = 1e18  # change of a slip in force units, relative to ``close``: beyond it round-off exceeds ``close``


@borrowing
def misfit(body, tableau, start, contact, F, direction, work):  # type: ignore[no-untyped-def]
    """F (2n,), the directions x/|x| (2n,) and |F|², and the largest; a node that sticks has direction 0."""
    total, largest = 0.0, 0.0
    for i in range(len(body.f)):
        j, k = 2 * i, 3 * i
        F[j], F[j + 1], direction[j], direction[j + 1] = 0.0, 0.0, 0.0, 0.0
        if tableau.is_open[i]:
            continue
        if start[k + 2] > 0.0:
            contact_position(body, tableau, i, start, contact, work)
        rho = body.tangential[i]
        sx, sy = rho * (tableau.given[k] - contact[j]), rho * (tableau.given[k + 1] - contact[j + 1])
        qx, qy = tableau.r_w[k] + tableau.out[k], tableau.r_w[k + 1] + tableau.out[k + 1]
        limit = body.f[i] * max(tableau.r_w[k + 2] + tableau.out[k + 2], 0.0)
        x, y = qx - sx, qy - sy
        size = np.sqrt(x * x + y * y)
        if size > limit:
            x, y = x / size, y / size
            F[j], F[j + 1], direction[j], direction[j + 1] = qx - limit * x, qy - limit * y, x, y
        else:
            F[j], F[j + 1] = sx, sy
        total += F[j] * F[j] + F[j + 1] * F[j + 1]
        largest = max(largest, abs(F[j]), abs(F[j + 1]))
    return total, largest


@borrowing
def weigh(body, tableau, start, contact, i, direction, P):  # type: ignore[no-untyped-def]
    """How F of a node follows its own q, p and slip: a (2, 2), b (2,) and c (2, 2), as ten numbers.

    It slips: a = 1 − βT, b = −f x/|x| where it is pressed, c = ρβT, T = 1 − x xᵀ/|x|². It sticks: c = ρ.
    """
    j, k = 2 * i, 3 * i
    rho, p = body.tangential[i], tableau.r_w[k + 2] + tableau.out[k + 2]
    x, y = direction[j], direction[j + 1]
    a00, a01, a11, b0, b1, c00, c01, c11 = 0.0, 0.0, 0.0, 0.0, 0.0, rho, 0.0, rho
    if x != 0.0 or y != 0.0:
        qx, qy = tableau.r_w[k] + tableau.out[k], tableau.r_w[k + 1] + tableau.out[k + 1]
        sx, sy = rho * (tableau.given[k] - contact[j]), rho * (tableau.given[k + 1] - contact[j + 1])
        ax, ay = qx - sx, qy - sy
        share = body.f[i] * max(p, 0.0) / np.sqrt(ax * ax + ay * ay)
        xx, xy, yy = share * y * y, -share * x * y, share * x * x
        a00, a01, a11, c00, c01, c11 = 1.0 - xx, -xy, 1.0 - yy, rho * xx, rho * xy, rho * yy
        if p > 0.0:
            b0, b1 = -body.f[i] * x, -body.f[i] * y
    found = a00, a01, a01, a11, b0, b1, c00, c01, c01, c11
    return weigh_touch(body, tableau, start, i, found, P) if start[k + 2] > 0.0 else found


@borrowing
def weigh_touch(body, tableau, start, i, found, P):  # type: ignore[no-untyped-def]
    """As :func:`weigh`, of a node that was open: where it touches moves with its q, p and slip, too."""
    a00, a01, a10, a11, b0, b1, c00, c01, c10, c11 = found
    k, old = 3 * i, start[3 * i + 2]
    inverse(body.kappa, k, P)
    qx, qy = tableau.r_w[k] + tableau.out[k], tableau.r_w[k + 1] + tableau.out[k + 1]
    p = tableau.r_w[k + 2] + tableau.out[k + 2]
    gap = tableau.given[k + 2] - (P[2, 0] * qx + P[2, 1] * qy + P[2, 2] * p)
    share = 1.0 if gap >= 0.0 else old / (old - gap)
    grows = 0.0 if gap >= 0.0 else share * share / old
    for d in range(2):
        way = tableau.given[k + d] - (P[d, 0] * qx + P[d, 1] * qy + P[d, 2] * p) - start[k + d]
        for e in range(3):
            P[d, e] = -share * P[d, e] - way * grows * P[2, e]  # how it moves
    a00, a01 = a00 - (c00 * P[0, 0] + c01 * P[1, 0]), a01 - (c00 * P[0, 1] + c01 * P[1, 1])
    a10, a11 = a10 - (c10 * P[0, 0] + c11 * P[1, 0]), a11 - (c10 * P[0, 1] + c11 * P[1, 1])
    b0, b1 = b0 - (c00 * P[0, 2] + c01 * P[1, 2]), b1 - (c10 * P[0, 2] + c11 * P[1, 2])
    rest = 1.0 - share
    return a00, a01, a10, a11, b0, b1, c00 * rest, c01 * rest, c10 * rest, c11 * rest


@borrowing
def sorts(body, tableau, start, F, direction, nodes):  # type: ignore[no-untyped-def]
    """List nodes that slip or were open; returns how many, and whether another is off its stick position."""
    count, astray = 0, False
    for i in range(len(body.f)):
        touches = start[3 * i + 2] > 0.0 and not tableau.is_open[i]
        if touches or direction[2 * i] != 0.0 or direction[2 * i + 1] != 0.0:
            nodes[count] = i
            count += 1
        elif F[2 * i] != 0.0 or F[2 * i + 1] != 0.0:
            astray = True
    return count, astray


@borrowing
def are_known(tableau, factors, nodes, count):  # type: ignore[no-untyped-def]
    """Whether the factors are those of these nodes, the same others open."""
    if factors.known[0] != count or factors.known[1] != tableau.updates[1]:
        return False
    known = True
    for a in range(count):
        known = known and nodes[a] == factors.slipping[a]
    return known


@inner
def equations(body, tableau, start, contact, direction, factors, nodes, count):  # type: ignore[no-untyped-def]
    """The derivatives of F with respect to the slips, and their factors; False where they are singular."""
    fill(body, tableau, start, contact, direction, factors, nodes, count, np.empty((3, 3)))
    return count == 0 or factorise(factors, 2 * count)


@borrowing
def fill(body, tableau, start, contact, direction, factors, nodes, count, P):  # type: ignore[no-untyped-def]
    """The derivatives of F with respect to the slips of these nodes."""
    N, columns = tableau.N, factors.columns
    for m in range(count):
        i = nodes[m]
        k = 3 * i
        factors.slipping[m] = i
        a00, a01, a10, a11, b0, b1, c00, c01, c10, c11 = weigh(body, tableau, start, contact, i, direction, P)
        for other in range(count):
            for d in range(2):
                at = 3 * nodes[other] + d
                x, y, z = N[k, at], N[k + 1, at], N[k + 2, at]  # N is symmetric
                columns[2 * other + d, 2 * m] = a00 * x + a01 * y + b0 * z
                columns[2 * other + d, 2 * m + 1] = a10 * x + a11 * y + b1 * z
        columns[2 * m, 2 * m] += c00
        columns[2 * m, 2 * m + 1] += c10
        columns[2 * m + 1, 2 * m] += c01
        columns[2 * m + 1, 2 * m + 1] += c11
    factors.known[0], factors.known[1] = count, tableau.updates[1]


@borrowing
def goes_back(tableau, start, contact, F, direction, change):  # type: ignore[no-untyped-def]
    """The change of slips (2n,) that returns sticking nodes to their stick positions."""
    for i in range(len(tableau.is_open)):
        j, k = 2 * i, 3 * i
        change[j], change[j + 1] = 0.0, 0.0
        sticks = direction[j] == 0.0 and direction[j + 1] == 0.0 and not start[k + 2] > 0.0
        if sticks and (F[j] != 0.0 or F[j + 1] != 0.0):
            change[j], change[j + 1] = contact[j] - tableau.given[k], contact[j + 1] - tableau.given[k + 1]


@inner
def follow_back(body, tableau, start, contact, direction, factors, moved, right):  # type: ignore[no-untyped-def]
    """Subtract from the right side the effect of the returning nodes on F."""
    P = np.empty((3, 3))
    for m in range(factors.known[0]):
        i = factors.slipping[m]
        k = 3 * i
        a00, a01, a10, a11, b0, b1, _, _, _, _ = weigh(body, tableau, start, contact, i, direction, P)
        right[2 * m] -= a00 * moved[k] + a01 * moved[k + 1] + b0 * moved[k + 2]
        right[2 * m + 1] -= a10 * moved[k] + a11 * moved[k + 1] + b1 * moved[k + 2]


@inner
def slips_on(body, tableau, start, contact, F, direction, factors, step, close):  # type: ignore[no-untyped-def]
    """The change of the other slips, in addition to that of returning nodes; False where it is too large.

    step: (change (2n,), what those that go back change (3n,), whether any does, work (2n,)).
    """
    change, moved, astray, right = step
    count = factors.known[0]
    for m in range(count):
        i = factors.slipping[m]
        right[2 * m], right[2 * m + 1] = -F[2 * i], -F[2 * i + 1]
    if astray:
        follow_back(body, tableau, start, contact, direction, factors, moved, right)
    if count:
        solve(factors, right)
    for m in range(count):
        i, x, y = factors.slipping[m], right[2 * m], right[2 * m + 1]
        if not body.tangential[i] * max(abs(x), abs(y)) <= FAR * close:
            return False
        change[2 * i], change[2 * i + 1] = x, y
    return True


@borrowing
def move(tableau, change, moved):  # type: ignore[no-untyped-def]
    """The effect of a change (2n,) of the slips of closed nodes on the dependent quantities, (3n,)."""
    for a in range(len(moved)):
        moved[a] = 0.0
    for i in range(len(change) // 2):
        x, y = change[2 * i], change[2 * i + 1]
        if x != 0.0 or y != 0.0:
            first, second = tableau.N[3 * i], tableau.N[3 * i + 1]
            for a in range(len(moved)):
                moved[a] += x * first[a] + y * second[a]


@borrowing
def go(tableau, change, moved, share):  # type: ignore[no-untyped-def]
    """Apply a share of the step."""
    for i in range(len(change) // 2):
        tableau.given[3 * i] += share * change[2 * i]
        tableau.given[3 * i + 1] += share * change[2 * i + 1]
    for a in range(len(moved)):
        tableau.out[a] += share * moved[a]


@inner
def newton(body, tableau, start, contact, close, factors):  # type: ignore[no-untyped-def]
    """Newton's method until |F| ≤ close; returns (whether it is, steps).

    The factors of an earlier step are taken again as long as the same nodes slip and |F| falls fast with
    them; with new ones there is a line search.
    """
    n = len(body.f)
    F, direction, right, moved = np.empty(2 * n), np.empty(2 * n), np.empty(2 * n), np.empty(3 * n)
    change, nodes = np.empty(2 * n), np.empty(n, dtype=np.int64)
    work = np.empty((3, 3)), np.empty(3), np.empty(3)
    total, largest = misfit(body, tableau, start, contact, F, direction, work)
    for step in range(NEWTON_ROUNDS):
        if largest <= close:
            return True, step
        count, astray = sorts(body, tableau, start, F, direction, nodes)
        again = not astray and are_known(tableau, factors, nodes, count)
        if not again and not equations(body, tableau, start, contact, direction, factors, nodes, count):
            factors.known[0] = -1
            return False, step
        goes_back(tableau, start, contact, F, direction, change)
        move(tableau, change, moved)
        if not slips_on(
            body, tableau, start, contact, F, direction, factors, (change, moved, astray, right), close
        ):
            factors.known[0] = -1
            return False, step
        move(tableau, change, moved)
        share, before = 1.0, total
        go(tableau, change, moved, share)
        total, largest = misfit(body, tableau, start, contact, F, direction, work)
        if again and not total <= PER_CENT * before:  # unless old factors reduce |F|² to 1 %
            factors.known[0] = -1
        for _ in range(HALVINGS):
            if total <= (1.0 - FOUR_DIGITS * share) * before:
                break
            go(tableau, change, moved, -0.5 * share)
            share *= 0.5
            total, largest = misfit(body, tableau, start, contact, F, direction, work)
        if not again and not total <= (1.0 - FOUR_DIGITS * share) * before:
            return False, step
    return largest <= close, NEWTON_ROUNDS
