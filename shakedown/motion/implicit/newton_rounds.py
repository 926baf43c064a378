"""Newton's method on the slipping nodes of one load step, the same nodes open (Alart and Curnier 1991).

A closed node obeys the law where its reaction is that of the map

    F = q − f p⁺ x/|x|  if |x| > f p⁺ (it slips),   F = ρ s  otherwise (it sticks),   x = q − ρ s,

s its slip from where it touches and p⁺ = max(p, 0): a closed node in tension has no friction until
the next sweep opens it. Unknown are the slips of those that slip; the others go where they stick.
"""

import numpy as np

from shakedown.motion.implicit.dense_solver import factorise, solve
from shakedown.motion.kernels.named_state import inner

ROUNDS = 25
HALVINGS = 8  # of one step
FAR = 1e18  # of a slip's change in forces, relative to ``close``: its round-off alone is larger than that
FAST = 1e-2  # what a step with old factors leaves of |F|² at most
DECREASE = 1e-4  # of the sum of squares, relative to what Newton's method foresees


@inner
def misfit(body, tableau, contact, F, direction):  # type: ignore[no-untyped-def]
    """F (2n,), the directions x/|x| (2n,) and |F|², and the largest; a node that sticks has direction 0."""
    total, largest = 0.0, 0.0
    for i in range(len(body.f)):
        j, k = 2 * i, 3 * i
        F[j], F[j + 1], direction[j], direction[j + 1] = 0.0, 0.0, 0.0, 0.0
        if tableau.is_open[i]:
            continue
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


@inner
def weights(body, tableau, contact, i, direction):  # type: ignore[no-untyped-def]
    """Of a slipping node: I − βT (its three entries), f where it is pressed, ρβT; T = 1 − x xᵀ/|x|²."""
    j, k = 2 * i, 3 * i
    rho, p = body.tangential[i], tableau.r_w[k + 2] + tableau.out[k + 2]
    qx, qy = tableau.r_w[k] + tableau.out[k], tableau.r_w[k + 1] + tableau.out[k + 1]
    sx, sy = rho * (tableau.given[k] - contact[j]), rho * (tableau.given[k + 1] - contact[j + 1])
    x, y = direction[j], direction[j + 1]
    reach = np.sqrt((qx - sx) ** 2 + (qy - sy) ** 2)
    share = body.f[i] * max(p, 0.0) / reach
    xx, xy, yy = share * y * y, -share * x * y, share * x * x
    return xx, xy, yy, (body.f[i] if p > 0.0 else 0.0), rho


@inner
def sorts(body, F, direction, nodes):  # type: ignore[no-untyped-def]
    """The nodes that slip; returns how many, and whether one that sticks is not where it sticks."""
    count, astray = 0, False
    for i in range(len(body.f)):
        if direction[2 * i] != 0.0 or direction[2 * i + 1] != 0.0:
            nodes[count] = i
            count += 1
        elif F[2 * i] != 0.0 or F[2 * i + 1] != 0.0:
            astray = True
    return count, astray


@inner
def are_known(tableau, factors, nodes, count):  # type: ignore[no-untyped-def]
    """Whether the factors are those of these nodes, the same others open."""
    if factors.known[0] != count or factors.known[1] != tableau.updates[1]:
        return False
    known = True
    for a in range(count):
        known = known and nodes[a] == factors.slipping[a]
    return known


@inner
def equations(body, tableau, contact, direction, factors, nodes, count):  # type: ignore[no-untyped-def]
    """The derivatives of F with respect to the slips, and their factors; False where they are singular."""
    N, columns = tableau.N, factors.columns
    for a in range(count):
        i = nodes[a]
        k = 3 * i
        factors.slipping[a] = i
        xx, xy, yy, f, rho = weights(body, tableau, contact, i, direction)
        px, py = f * direction[2 * i], f * direction[2 * i + 1]
        for b in range(count):
            for c in range(2):
                row = N[3 * nodes[b] + c]  # N is symmetric
                x, y, z = row[k], row[k + 1], row[k + 2]
                columns[2 * b + c, 2 * a] = (1.0 - xx) * x - xy * y - px * z
                columns[2 * b + c, 2 * a + 1] = (1.0 - yy) * y - xy * x - py * z
        columns[2 * a, 2 * a] += rho * xx
        columns[2 * a + 1, 2 * a] += rho * xy
        columns[2 * a, 2 * a + 1] += rho * xy
        columns[2 * a + 1, 2 * a + 1] += rho * yy
    factors.known[0], factors.known[1] = count, tableau.updates[1]
    return count == 0 or factorise(factors, 2 * count)


@inner
def goes_back(body, tableau, contact, F, direction, change, moved):  # type: ignore[no-untyped-def]
    """The change of the slips (2n,) of nodes that stick, to where they do, and what it changes, (3n,)."""
    for i in range(len(body.f)):
        j, k = 2 * i, 3 * i
        change[j], change[j + 1] = 0.0, 0.0
        if direction[j] == 0.0 and direction[j + 1] == 0.0 and (F[j] != 0.0 or F[j + 1] != 0.0):
            change[j], change[j + 1] = contact[j] - tableau.given[k], contact[j + 1] - tableau.given[k + 1]
    move(tableau, change, moved)


@inner
def slips_on(body, tableau, contact, F, direction, factors, step, close):  # type: ignore[no-untyped-def]
    """The change of the slips of those that slip, beside that of those that stick; False where it is too far.

    step: (change (2n,), what the sticking nodes change (3n,), whether they do, room (2n,)).
    """
    change, moved, astray, right = step
    count = factors.known[0]
    for a in range(count):
        i = factors.slipping[a]
        j, k = 2 * i, 3 * i
        right[2 * a], right[2 * a + 1] = -F[j], -F[j + 1]
        if astray:
            xx, xy, yy, f, _ = weights(body, tableau, contact, i, direction)
            x, y, z = moved[k], moved[k + 1], moved[k + 2]
            right[2 * a] -= (1.0 - xx) * x - xy * y - f * direction[j] * z
            right[2 * a + 1] -= (1.0 - yy) * y - xy * x - f * direction[j + 1] * z
    if count:
        solve(factors, right)
    for a in range(count):
        i, x, y = factors.slipping[a], right[2 * a], right[2 * a + 1]
        if not body.tangential[i] * max(abs(x), abs(y)) <= FAR * close:
            return False
        change[2 * i], change[2 * i + 1] = x, y
    return True


@inner
def move(tableau, change, moved):  # type: ignore[no-untyped-def]
    """What a change (2n,) of the slips of closed nodes changes of what follows, (3n,)."""
    for a in range(len(moved)):
        moved[a] = 0.0
    for i in range(len(change) // 2):
        x, y = change[2 * i], change[2 * i + 1]
        if x != 0.0 or y != 0.0:
            first, second = tableau.N[3 * i], tableau.N[3 * i + 1]
            for a in range(len(moved)):
                moved[a] += x * first[a] + y * second[a]


@inner
def go(tableau, change, moved, share):  # type: ignore[no-untyped-def]
    """Go a share of the way."""
    for i in range(len(change) // 2):
        tableau.given[3 * i] += share * change[2 * i]
        tableau.given[3 * i + 1] += share * change[2 * i + 1]
    for a in range(len(moved)):
        tableau.out[a] += share * moved[a]


@inner
def newton(body, tableau, contact, close, factors):  # type: ignore[no-untyped-def]
    """Newton's method until |F| ≤ close; returns (whether it is, steps).

    The factors of an earlier step are taken again as long as the same nodes slip and |F| falls fast with
    them; with new ones there is a line search.
    """
    n = len(body.f)
    F, direction, right, moved = np.empty(2 * n), np.empty(2 * n), np.empty(2 * n), np.empty(3 * n)
    change, nodes = np.empty(2 * n), np.empty(n, dtype=np.int64)
    total, largest = misfit(body, tableau, contact, F, direction)
    for step in range(ROUNDS):
        if largest <= close:
            return True, step
        count, astray = sorts(body, F, direction, nodes)
        again = not astray and are_known(tableau, factors, nodes, count)
        if not again and not equations(body, tableau, contact, direction, factors, nodes, count):
            factors.known[0] = -1
            return False, step
        goes_back(body, tableau, contact, F, direction, change, moved)
        if not slips_on(body, tableau, contact, F, direction, factors, (change, moved, astray, right), close):
            factors.known[0] = -1
            return False, step
        move(tableau, change, moved)
        share, before = 1.0, total
        go(tableau, change, moved, share)
        total, largest = misfit(body, tableau, contact, F, direction)
        if again and not total <= FAST * before:
            factors.known[0] = -1
        for _ in range(HALVINGS):
            if total <= (1.0 - DECREASE * share) * before:
                break
            go(tableau, change, moved, -0.5 * share)
            share *= 0.5
            total, largest = misfit(body, tableau, contact, F, direction)
        if not again and not total <= (1.0 - DECREASE * share) * before:
            return False, step
    return largest <= close, ROUNDS
