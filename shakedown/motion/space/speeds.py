"""Rates of the nodes that slip: the direction is that of the reaction, the speeds solve linear equations.

A node on its cone, |q| = f p, slips along u = −q/|q|. It stays there where the rate of its room f p − |q|
vanishes: with v̇ = μ u, for the speeds μ of all nodes that slip

    M μ + z = 0,    M_ij = u_i·A_ij u_j + f_i B_ij·u_j,    z_i = u_i·q̇_i + f_i ṗ_i  while nothing slips.
"""

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import Shorts, inner, summing
from shakedown.motion.implicit.dense_solver import address, call
from shakedown.motion.space.sliding import STAGES, Sliding

SINGULAR = 1e-13  # pivot, relative to the largest entry of its row, that counts as zero
FEW = 12  # slipping nodes up to which equations are always solved afresh, and without LAPACK
MOST_CORRECTIONS = 9  # of speeds, with the factors of an earlier stage
CONTRACTS = 0.25  # of a rate of room that is left, by each
SOLVED = 1e-4  # rate of room that is left, relative to the load and to the accuracy that is asked for
ROUND_OFF = 1e-14  # of it
TRANSPOSED = ord("T")
SHARES = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0)  # of a step, of its first stages


def _guesses() -> FloatArray:
    """Weights of the speeds of earlier stages in the polynomial through them, at each stage."""
    found = np.zeros((STAGES, STAGES))
    for k in range(1, STAGES - 1):
        for j in range(k):
            others = [SHARES[i] for i in range(k) if i != j]
            found[k, j] = np.prod([(SHARES[k] - at) / (SHARES[j] - at) for at in others])
    found[STAGES - 1, STAGES - 2] = 1.0
    return found


GUESS = _guesses()


@inner
def pack(sl: Sliding) -> None:
    """Gather what belongs to the nodes that are chosen to slip."""
    n, N, s, largest = sl.n, 3 * sl.n, 0, 0.0
    for i in range(n):
        if sl.chosen[i] == 1:
            sl.node[s] = i
            s += 1
    sl.s, sl.factored = s, False
    S, A, B = sl.exchanged, sl.A, sl.B
    for a in range(s):
        i = sl.node[a]
        sl.f[a] = sl.friction[i]
        sl.load_p[a], sl.p[a] = sl.base[2 * n + i], sl.out[2 * n + i]
        largest = max(largest, abs(sl.f[a] * sl.load_p[a]))
        for c in range(2):
            sl.load_q[2 * a + c], sl.q[2 * a + c] = sl.base[2 * i + c], sl.out[2 * i + c]
            largest = max(largest, abs(sl.load_q[2 * a + c]))
            if sl.apex[i] == 1:
                sl.q[2 * a + c] = -sl.f[a] * max(sl.p[a], 0.0) * sl.direction[2 * i + c]
        for b in range(s):
            j = sl.node[b]
            B[a * 2 * s + 2 * b] = S[(2 * n + i) * N + 2 * j]
            B[a * 2 * s + 2 * b + 1] = S[(2 * n + i) * N + 2 * j + 1]
            for c in range(2):
                A[(2 * a + c) * 2 * s + 2 * b] = S[(2 * i + c) * N + 2 * j]
                A[(2 * a + c) * 2 * s + 2 * b + 1] = S[(2 * i + c) * N + 2 * j + 1]
    sl.load_size = largest


@inner
def find_directions(sl: Sliding, q: FloatArray) -> None:
    """Directions of slip against these packed reactions, and the sizes of these."""
    for a in range(sl.s):
        x, y = q[2 * a], q[2 * a + 1]
        size = np.sqrt(x * x + y * y)
        sl.size[a] = size
        if size > sl.force:
            sl.unit[2 * a], sl.unit[2 * a + 1] = -x / size, -y / size
        else:
            i = sl.node[a]
            sl.unit[2 * a], sl.unit[2 * a + 1] = sl.direction[2 * i], sl.direction[2 * i + 1]


@summing
def find_matrix(sl: Sliding, M: FloatArray) -> None:
    """M and, as ``drive``, −z in the present directions."""
    s, A, B, unit, normal = sl.s, sl.A, sl.B, sl.unit, sl.normal
    for a in range(s):
        x, y, f, row, second, last = (
            unit[2 * a],
            unit[2 * a + 1],
            sl.f[a],
            4 * a * s,
            (4 * a + 2) * s,
            2 * a * s,
        )
        for c in range(2 * s):
            normal[c] = x * A[row + c] + y * A[second + c] + f * B[last + c]
        for b in range(s):
            M[a * s + b] = normal[2 * b] * unit[2 * b] + normal[2 * b + 1] * unit[2 * b + 1]
        sl.drive[a] = -(x * sl.load_q[2 * a] + y * sl.load_q[2 * a + 1] + f * sl.load_p[a])


@inner
def factor(sl: Sliding, s: int) -> int:
    """Triangular factors of M (s, s) in place: sign of the determinant, 0 where the matrix is singular."""
    return factor_few(sl.M, sl.order, s) if s <= FEW else factor_many(sl, s)


@summing
def factor_few(M: FloatArray, order: Shorts, s: int) -> int:
    """Triangular factors, row by row."""
    sign = 1
    for k in range(s):
        best, size = k, 0.0
        for a in range(k, s):
            if abs(M[a * s + k]) > abs(M[best * s + k]):
                best = a
        for b in range(s):
            size = max(size, abs(M[best * s + b]))
        pivot = M[best * s + k]
        if not abs(pivot) > SINGULAR * size:
            return 0
        order[k] = best
        if best != k:
            for b in range(s):
                x = M[k * s + b]
                M[k * s + b] = M[best * s + b]
                M[best * s + b] = x
        if (best != k) != (pivot < 0.0):
            sign = -sign
        for a in range(k + 1, s):
            x = M[a * s + k] / pivot
            M[a * s + k] = x
            if x != 0.0:
                for b in range(k + 1, s):
                    M[a * s + b] -= x * M[k * s + b]
    return sign


@inner
def factor_many(sl: Sliding, s: int) -> int:
    """Triangular factors of the transpose by LAPACK, whose columns are our rows."""
    M, sizes, sign = sl.M, sl.sizes, 1
    sizes[0], sizes[1], sizes[2], sizes[3] = s, 1, 0, TRANSPOSED
    at = address(sizes)
    call(sl.routines[0], (at, at, address(M), at, address(sl.order), at + 8))
    for k in range(s):
        pivot, size = M[k * s + k], 0.0
        for b in range(k, s):
            size = max(size, abs(M[b * s + k]))
        if not abs(pivot) > SINGULAR * size:
            return 0
        if (sl.order[k] != k + 1) != (pivot < 0.0):
            sign = -sign
    return sign


@inner
def substitute(sl: Sliding, s: int, x: FloatArray) -> None:
    """Solve with the triangular factors, in place."""
    if s <= FEW:
        substitute_few(sl.M, sl.order, s, x)
    else:
        sizes = sl.sizes
        sizes[0], sizes[1], sizes[2], sizes[3] = s, 1, 0, TRANSPOSED
        at = address(sizes)
        call(
            sl.routines[1],
            (at + 12, at, at + 4, address(sl.M), at, address(sl.order), address(x), at, at + 8),
        )


@summing
def substitute_few(M: FloatArray, order: Shorts, s: int, x: FloatArray) -> None:
    """Solve with the triangular factors, row by row."""
    for k in range(s):
        y = x[order[k]]
        x[order[k]] = x[k]
        x[k] = y
    for a in range(s):
        total = x[a]
        for b in range(a):
            total -= M[a * s + b] * x[b]
        x[a] = total
    for r in range(s):
        a = s - 1 - r
        total = x[a]
        for b in range(a + 1, s):
            total -= M[a * s + b] * x[b]
        x[a] = total / M[a * s + a]


@inner
def find_rates(sl: Sliding, q: FloatArray, stage: int) -> bool:
    """Rates at a stage whose packed reactions are q; False where the motion is not stable there."""
    find_directions(sl, q)
    for a in range(sl.s):
        total = 0.0
        for j in range(stage):
            total += GUESS[stage, j] * sl.mu[j * sl.n + a]
        sl.speed[a] = total
    return rates_along(sl, stage)


@inner
def rates_along(sl: Sliding, stage: int) -> bool:
    """Rates at a stage in the present directions, ``speed`` a guess; False where the motion is not stable.

    Where many nodes slip, the factors of an earlier stage serve as long as a few corrections suffice.
    """
    s = sl.s
    find_matrix(sl, sl.limits)
    if not (s > FEW and sl.factored and correct_speeds(sl)):
        for t in range(s * s):
            sl.M[t] = sl.limits[t]
        sl.factored = factor(sl, s) > 0
        if not sl.factored:
            return False
        for a in range(s):
            sl.speed[a] = sl.drive[a]
        substitute(sl, s, sl.speed)
    spread_rates(sl, stage)
    return True


@inner
def correct_speeds(sl: Sliding) -> bool:
    """Correct the speeds with old factors until they solve the equations; False where they diverge."""
    s, last, solved = sl.s, np.inf, max(SOLVED * sl.accuracy, ROUND_OFF) * sl.load_size
    for _ in range(MOST_CORRECTIONS):
        left = residual_speeds(sl)
        if left <= solved:
            return True
        if not left < CONTRACTS * last:
            return False
        last = left
        substitute(sl, s, sl.correction)
        for a in range(s):
            sl.speed[a] += sl.correction[a]
    return False


@summing
def residual_speeds(sl: Sliding) -> float:
    """Rates of the rooms at the present speeds, ``correction`` with the other sign: the largest."""
    s, M, largest = sl.s, sl.limits, 0.0
    for a in range(s):
        total = sl.drive[a]
        for b in range(s):
            total -= M[a * s + b] * sl.speed[b]
        sl.correction[a] = total
        largest = max(largest, abs(total))
    return largest


@summing
def spread_rates(sl: Sliding, stage: int) -> None:
    """Rates of slips and reactions at a stage from the speeds in the present directions."""
    s, k, start = sl.s, sl.k, stage * 2 * sl.n
    for a in range(s):
        mu = sl.speed[a]
        sl.mu[stage * sl.n + a], sl.heat[stage * sl.n + a] = mu, sl.size[a] * mu
        k[start + 2 * a], k[start + 2 * a + 1] = mu * sl.unit[2 * a], mu * sl.unit[2 * a + 1]
    for c in range(2 * s):
        total = sl.load_q[c]
        for b in range(2 * s):
            total += sl.A[c * 2 * s + b] * k[start + b]
        sl.k_q[start + c] = total
