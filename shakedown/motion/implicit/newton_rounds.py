"""Newton's method on the slipping nodes of one load step, the same nodes open (Alart and Curnier 1991).

A closed node obeys the law where its reaction is that of the map

    F = q − f p⁺ x/|x|  if |x| > f p⁺ (it slips),   F = ρ s  otherwise (it sticks),   x = q − ρ s,

s its slip from where it touches and p⁺ = max(p, 0): a closed node in tension has no friction until
the next sweep opens it. Unknown are the slips of those that slip; the others go where they stick.
"""

import numpy as np

from shakedown.motion.implicit.dense_solver import solve_columns
from shakedown.motion.kernels.named_state import inner

ROUNDS = 25
HALVINGS = 8  # of one step
FAR = 1e18  # of a slip's change in forces, relative to ``close``: its round-off alone is larger than that
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
def factors(body, tableau, contact, i, direction):  # type: ignore[no-untyped-def]
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
def newton_step(body, tableau, contact, F, direction, change, close, solver):  # type: ignore[no-untyped-def]
    """The change (2n,) of the slips by one step of Newton's method; False where they are singular."""
    N, n = tableau.N, len(body.f)
    slipping = np.empty(n, dtype=np.int64)
    count = 0
    moved = np.zeros(3 * n)  # by the nodes that go back to where they stick
    for i in range(n):
        j, k = 2 * i, 3 * i
        change[j], change[j + 1] = 0.0, 0.0
        if direction[j] != 0.0 or direction[j + 1] != 0.0:
            slipping[count] = i
            count += 1
        elif F[j] != 0.0 or F[j + 1] != 0.0:
            change[j], change[j + 1] = contact[j] - tableau.given[k], contact[j + 1] - tableau.given[k + 1]
            for a in range(3 * n):
                moved[a] += N[k, a] * change[j] + N[k + 1, a] * change[j + 1]
    if count == 0:
        return True
    columns, right = np.empty((2 * count, 2 * count)), np.empty(2 * count)
    for a in range(count):
        i = slipping[a]
        j, k = 2 * i, 3 * i
        xx, xy, yy, f, rho = factors(body, tableau, contact, i, direction)
        px, py = f * direction[j], f * direction[j + 1]
        for b in range(count):
            for c in range(2):
                row = N[3 * slipping[b] + c]  # N is symmetric
                x, y, z = row[k], row[k + 1], row[k + 2]
                columns[2 * b + c, 2 * a] = (1.0 - xx) * x - xy * y - px * z
                columns[2 * b + c, 2 * a + 1] = (1.0 - yy) * y - xy * x - py * z
        columns[2 * a, 2 * a] += rho * xx
        columns[2 * a + 1, 2 * a] += rho * xy
        columns[2 * a, 2 * a + 1] += rho * xy
        columns[2 * a + 1, 2 * a + 1] += rho * yy
        x, y, z = moved[k], moved[k + 1], moved[k + 2]
        right[2 * a] = -F[j] - ((1.0 - xx) * x - xy * y - px * z)
        right[2 * a + 1] = -F[j + 1] - ((1.0 - yy) * y - xy * x - py * z)
    if not solve_columns(solver, columns, right):
        return False
    for a in range(count):
        i, x, y = slipping[a], right[2 * a], right[2 * a + 1]
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
def newton(body, tableau, contact, close, solver):  # type: ignore[no-untyped-def]
    """Newton's method with line search until |F| ≤ close; returns (whether it is, steps)."""
    n = len(body.f)
    F, direction, change, moved = np.empty(2 * n), np.empty(2 * n), np.empty(2 * n), np.empty(3 * n)
    total, largest = misfit(body, tableau, contact, F, direction)
    for step in range(ROUNDS):
        if largest <= close:
            return True, step
        if not newton_step(body, tableau, contact, F, direction, change, close, solver):
            return False, step
        move(tableau, change, moved)
        share, before = 1.0, total
        go(tableau, change, moved, share)
        total, largest = misfit(body, tableau, contact, F, direction)
        for _ in range(HALVINGS):
            if total <= (1.0 - DECREASE * share) * before:
                break
            go(tableau, change, moved, -0.5 * share)
            share *= 0.5
            total, largest = misfit(body, tableau, contact, F, direction)
        if not total <= (1.0 - DECREASE * share) * before:
            return False, step
    return largest <= close, ROUNDS
