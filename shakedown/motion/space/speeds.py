"""Speeds of slipping nodes, and the stiffness in which open nodes are unloaded.

Exchanged places
----------------
Of an open node the reaction is given, not the displacement. Of a free place the reaction is zero and the
displacement follows from equilibrium. With these places exchanged (a principal pivot transform of κ) the
outputs

    out = reactions of the places that are not free, displacements of those that are

are linear in the displacements of the former and the welded reactions of the latter, however the
other nodes slip: an open node costs a closed one nothing until it closes again. Opening a node exchanges
its three places, closing it the same three: the exchange is its own inverse. Where one place is free
and the other is not the matrix is antisymmetric, elsewhere symmetric, so that its rows serve as columns.

Speeds
------
Directions are those of the reactions, speeds solve linear equations. A node on its cone, |q| = f p, slips
along u = −q/|q|. It stays there where the rate of its slack f p − |q| vanishes: with v̇ = μ u, for the speeds
μ of all nodes that slip

    M μ + z = 0,    M_ij = u_i·A_ij u_j + f_i B_ij·u_j,    z_i = u_i·q̇_i + f_i ṗ_i  while nothing slips.
"""

import numpy as np

from shakedown.ground.constants import FOUR_DIGITS, ROUND_OFF, FloatArray
from shakedown.ground.named_state import Shorts, entered, inner, summing
from shakedown.ground.status import OPEN
from shakedown.ground.work_limit import BY_BLAS
from shakedown.motion.course import Course
from shakedown.motion.space.space_run import (
    CompiledJoint,
    Slipping,
    SpaceMotion,
    SpaceRates,
    Step,
    address,
    call,
)

FEW = 12  # slipping nodes up to which equations are always solved anew, and without LAPACK
TRANSPOSED = ord("T")
MOST_EXCHANGES = 60  # exchanges after which the matrix is made afresh, as each adds round-off


@summing
def exchange(joint: CompiledJoint, place: int) -> bool:
    """Exchange a place; False, and nothing changed, where nothing else holds it."""
    N, S, row, size = 3 * joint.n, joint.exchanged, 3 * joint.n * place, 0.0
    pivot = S[row + place]
    if joint.free[place] == 0:
        for j in range(N):
            size = max(size, abs(joint.kappa[row + j]))
        if pivot <= ROUND_OFF * size:
            return False
    for i in range(N):
        x = S[i * N + place] / pivot
        if i != place and x != 0.0:
            for j in range(N):
                S[i * N + j] -= x * S[row + j]
            S[i * N + place] = x
    for j in range(N):
        S[row + j] /= -pivot
    S[row + place] = 1.0 / pivot
    joint.free[place] = 1 - joint.free[place]
    joint.exchanges += 1
    return True


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
    """Exchange places until those free by their contact states are; False where nothing holds one."""
    held = True
    for place in range(3 * joint.n):
        if is_free(joint, mo, place) != (joint.free[place] == 1):
            held = exchange(joint, place) and held
    return held


@entered
def arrange_afresh(joint: CompiledJoint, mo: SpaceMotion) -> None:
    """Exchange the places that are free by the contact states in the stiffness itself."""
    for k in range(9 * joint.n * joint.n):
        joint.exchanged[k] = joint.kappa[k]
    for place in range(3 * joint.n):
        joint.free[place] = 0
    arrange(joint, mo)
    joint.exchanges = 0


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


@summing
def compute_out(joint: CompiledJoint, course: Course, mo: SpaceMotion, rates: SpaceRates) -> None:
    """Recompute the outputs from the displacements and the load at the present time."""
    N, S, out = 3 * joint.n, joint.exchanged, mo.out
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


@inner
def pack(joint: CompiledJoint, mo: SpaceMotion, rates: SpaceRates, sp: Slipping) -> None:
    """Gather the data of the nodes chosen to slip."""
    n, N, s, largest = joint.n, 3 * joint.n, 0, 0.0
    for i in range(n):
        if rates.chosen[i] == 1:
            sp.node[s] = i
            s += 1
    sp.s, sp.factored = s, False
    S, A, B = joint.exchanged, sp.A, sp.B
    for a in range(s):
        i = sp.node[a]
        sp.f[a] = joint.friction[i]
        sp.load_p[a], sp.p[a] = rates.base[2 * n + i], mo.out[2 * n + i]
        largest = max(largest, abs(sp.f[a] * sp.load_p[a]))
        for c in range(2):
            sp.load_q[2 * a + c], sp.q[2 * a + c] = rates.base[2 * i + c], mo.out[2 * i + c]
            largest = max(largest, abs(sp.load_q[2 * a + c]))
            if rates.apex[i] == 1:
                sp.q[2 * a + c] = -sp.f[a] * max(sp.p[a], 0.0) * mo.direction[2 * i + c]
        for b in range(s):
            j = sp.node[b]
            B[a * 2 * s + 2 * b] = S[(2 * n + i) * N + 2 * j]
            B[a * 2 * s + 2 * b + 1] = S[(2 * n + i) * N + 2 * j + 1]
            for c in range(2):
                A[(2 * a + c) * 2 * s + 2 * b] = S[(2 * i + c) * N + 2 * j]
                A[(2 * a + c) * 2 * s + 2 * b + 1] = S[(2 * i + c) * N + 2 * j + 1]
    sp.load_size = largest


@inner
def find_directions(course: Course, mo: SpaceMotion, sp: Slipping, q: FloatArray) -> None:
    """Directions of slip against these packed reactions, and the sizes of these."""
    for a in range(sp.s):
        x, y = q[2 * a], q[2 * a + 1]
        size = np.sqrt(x * x + y * y)
        sp.size[a] = size
        if size > course.force:
            sp.unit[2 * a], sp.unit[2 * a + 1] = -x / size, -y / size
        else:
            i = sp.node[a]
            sp.unit[2 * a], sp.unit[2 * a + 1] = mo.direction[2 * i], mo.direction[2 * i + 1]


@summing
def find_matrix(sp: Slipping, M: FloatArray) -> None:
    """M and, as ``drive``, −z in the present directions."""
    s, A, B, unit, normal = sp.s, sp.A, sp.B, sp.unit, sp.normal
    for a in range(s):
        x, y, f, row, second, last = (
            unit[2 * a],
            unit[2 * a + 1],
            sp.f[a],
            4 * a * s,
            (4 * a + 2) * s,
            2 * a * s,
        )
        for c in range(2 * s):
            normal[c] = x * A[row + c] + y * A[second + c] + f * B[last + c]
        for b in range(s):
            M[a * s + b] = normal[2 * b] * unit[2 * b] + normal[2 * b + 1] * unit[2 * b + 1]
        sp.drive[a] = -(x * sp.load_q[2 * a] + y * sp.load_q[2 * a + 1] + f * sp.load_p[a])


@inner
def factor(sp: Slipping, s: int) -> int:
    """Triangular factors of M (s, s) in place: sign of the determinant, 0 where the matrix is singular."""
    return factor_few(sp.M, sp.order, s) if s <= FEW else factor_many(sp, s)


@summing
def factor_few(M: FloatArray, order: Shorts, s: int) -> int:
    """Triangular factors, row by row."""
    sign = 1
    for k in range(s):
        best, size = k, 0.0
        for a in range(k, s):
            if abs(M[a * s + k]) > abs(M[best * s + k]):
                best = a
        for b in range(k, s):  # the eliminated columns are dimensionless multipliers
            size = max(size, abs(M[best * s + b]))
        pivot = M[best * s + k]
        if not abs(pivot) > ROUND_OFF * size:
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
def factor_many(sp: Slipping, s: int) -> int:
    """Triangular factors of the transpose by LAPACK, whose columns are our rows."""
    M, sizes, sign = sp.M, sp.sizes, 1
    sizes[0], sizes[1], sizes[2], sizes[3] = s, 1, 0, TRANSPOSED
    at = address(sizes)
    call(sp.routines[0], (at, at, address(M), at, address(sp.order), at + 8))
    for k in range(s):
        pivot, size = M[k * s + k], 0.0
        for b in range(k, s):
            size = max(size, abs(M[b * s + k]))
        if not abs(pivot) > ROUND_OFF * size:
            return 0
        if (sp.order[k] != k + 1) != (pivot < 0.0):
            sign = -sign
    return sign


@inner
def substitute(sp: Slipping, s: int, x: FloatArray) -> None:
    """Solve with the triangular factors, in place."""
    if s <= FEW:
        substitute_few(sp.M, sp.order, s, x)
    else:
        sizes = sp.sizes
        sizes[0], sizes[1], sizes[2], sizes[3] = s, 1, 0, TRANSPOSED
        at = address(sizes)
        call(
            sp.routines[1],
            (at + 12, at, at + 4, address(sp.M), at, address(sp.order), address(x), at, at + 8),
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
def find_rates(course: Course, mo: SpaceMotion, sp: Slipping, st: Step, q: FloatArray, stage: int) -> bool:
    """Rates at a stage whose packed reactions are q; False where the motion is not stable there."""
    find_directions(course, mo, sp, q)
    for a in range(sp.s):
        sp.speed[a] = st.mu[(stage - 1) * st.n + a]  # a guess
    return rates_along(sp, st, stage)


@inner
def rates_along(sp: Slipping, st: Step, stage: int) -> bool:
    """Rates at a stage in the present directions, ``speed`` a guess; False where the motion is not stable.

    Where many nodes slip, the factors of an earlier stage serve as long as a few corrections suffice.
    """
    s = sp.s
    find_matrix(sp, sp.limits)
    if not (s > FEW and sp.factored and correct_speeds(sp, st)):
        for t in range(s * s):
            sp.M[t] = sp.limits[t]
        sp.factored = factor(sp, s) > 0
        st.effort += int(BY_BLAS * s * s * s)
        if not sp.factored:
            return False
        for a in range(s):
            sp.speed[a] = sp.drive[a]
        substitute(sp, s, sp.speed)
    spread_rates(sp, st, stage)
    return True


@inner
def correct_speeds(sp: Slipping, st: Step) -> bool:
    """Correct the speeds with old factors until they solve the equations; False where they diverge."""
    # relative round-off of rates
    s, last, solved = sp.s, np.inf, max(FOUR_DIGITS * st.accuracy, ROUND_OFF / 10) * sp.load_size
    # corrections of speeds with the factors of an earlier stage
    for _ in range(9):
        left = residual_speeds(sp)
        if left <= solved:
            return True
        # share of a rate of slack that may remain after each
        if not left < 0.25 * last:
            return False
        last = left
        substitute(sp, s, sp.correction)
        for a in range(s):
            sp.speed[a] += sp.correction[a]
    return False


@summing
def residual_speeds(sp: Slipping) -> float:
    """Rates of the slacks at the present speeds, ``correction`` with the other sign: the largest."""
    s, M, largest = sp.s, sp.limits, 0.0
    for a in range(s):
        total = sp.drive[a]
        for b in range(s):
            total -= M[a * s + b] * sp.speed[b]
        sp.correction[a] = total
        largest = max(largest, abs(total))
    return largest


@summing
def spread_rates(sp: Slipping, st: Step, stage: int) -> None:
    """Rates of slips and reactions at a stage from the speeds in the present directions."""
    s, k, start = sp.s, st.k, stage * 2 * st.n
    for a in range(s):
        mu = sp.speed[a]
        st.mu[stage * st.n + a], st.dissipation[stage * st.n + a] = mu, sp.size[a] * mu
        k[start + 2 * a], k[start + 2 * a + 1] = mu * sp.unit[2 * a], mu * sp.unit[2 * a + 1]
    for c in range(2 * s):
        total = sp.load_q[c]
        for b in range(2 * s):
            total += sp.A[c * 2 * s + b] * k[start + b]
        st.k_q[start + c] = total
