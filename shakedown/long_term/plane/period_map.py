"""The affine map of one period, carried in compiled code, its powers, and their limit.

v ↦ v + d + J (v − v_start) for the slips v of the nodes alone that are stuck at the start and move within
the period. The others keep their slips exactly, so that the map leaves the space of
these nodes as it is: there lie all its powers of the increment, and their limit.

That is (I − J)⁻¹ d by elimination where no eigenvalue of J is near 1, which the size of the inverse shows.
Where one is, what drifts must be split off (:func:`limit`): that is left to the caller.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg import schur, solve_sylvester

from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.named_state import Integers, NamedState, Reals, inner, summing
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.plane.active_set import ActiveSet, larger
from shakedown.motion.plane.moving_state import PlaneMotion

LARGEST_INVERSE = 1e5  # norm of (I − J)⁻¹ up to which no eigenvalue of J is near 1 and round-off is small
DIED_OUT, GROWN = np.log(1e-13), np.log(1e6)  # of ‖Jᵏ d‖ / ‖d‖, logarithms


class PeriodMap(NamedState):
    """v ↦ v + d + J (v − v_start) of k nodes, its powers and its limit.

    Attributes
    ----------
    start : (2n,)
        u before the period.
    contact : (n,)
        Contact states there.
    stuck : (t,)
        Nodes stuck there, whose slips are the parameters of the state.
    moves : (k,)
        Which of the stuck nodes, by place in ``stuck``, move within the period.
    basis, tangent : (2n, t)
        ∂u/∂v_stuck before and after the period.
    delay : (t,)
        As in :class:`PlaneMotion`.
    power : (k, k)
        J, or J^leap.
    change : (k,)
        d, or Σ_{i < leap} Jⁱ d [length].
    limit, drift : (k,)
        Σ Jⁱ d without what drifts; what the slips gain per period for ever [length].
    image, work, inverse
        Scratch (n,), (n, n), (n, n).
    n, t, k
        Numbers of nodes.
    contraction, decaying
        As in :class:`Limit`.
    """

    start: Reals
    contact: Integers
    stuck: Integers
    moves: Integers
    basis: Reals
    tangent: Reals
    delay: Reals
    power: Reals
    change: Reals
    limit: Reals
    drift: Reals
    image: Reals
    work: Reals
    inverse: Reals
    n: int
    t: int
    k: int
    contraction: float
    decaying: bool


def period_map(n: int) -> PeriodMap:
    """Arrays for the map of n nodes."""
    shapes = {"start": 2 * n, "basis": (2 * n, n), "tangent": (2 * n, n)}
    shapes |= dict.fromkeys(("contact", "stuck", "moves", "delay", "change", "limit", "drift", "image"), n)
    new = PeriodMap(shapes | dict.fromkeys(("power", "work", "inverse"), (n, n)))
    new.set(n=n, decaying=True)
    return new


@inner
def begin_map(pm: PeriodMap, act: ActiveSet, mo: PlaneMotion) -> None:
    """Take the present state as the start of a period and follow its derivative from here.

    Every moving node that is not stuck follows the stuck ones through its equations.
    """
    n, m, t, size = act.n, 2 * act.n, 0, act.size
    kappa, cols, coefs, inverse = act.kappa, act.col, act.coef, act.inverse
    for j in range(m):
        pm.start[j] = mo.u[j]
    for i in range(n):
        pm.contact[i] = act.state[i]
        if act.state[i] == STICK:
            pm.stuck[t] = i
            t += 1
    pm.t = t
    basis, rows = pm.basis, pm.tangent
    for j in range(m * t):
        basis[j] = 0.0
    for c in range(t):
        basis[pm.stuck[c] * t + c] = 1.0
    for b in range(size):
        for c in range(t):
            x = kappa[cols[b] * m + pm.stuck[c]]
            if coefs[b] != 0.0:
                x -= coefs[b] * kappa[(n + cols[b]) * m + pm.stuck[c]]
            rows[b * t + c] = x
    for b in range(size):
        for d in range(size):
            x = inverse[b * m + d]
            for c in range(t):
                basis[cols[b] * t + c] -= x * rows[d * t + c]
    for j in range(m * t):
        rows[j] = basis[j]
    mo.tangent, mo.delay, mo.parameters = pm.tangent, pm.delay, t


@inner
def end_map(pm: PeriodMap, mo: PlaneMotion) -> None:
    """J and d of the nodes that moved within the period that ends here."""
    t, k, stuck, tangent = pm.t, 0, pm.stuck, pm.tangent
    for a in range(t):
        node = stuck[a]
        moved = mo.u[node] != pm.start[node]
        for b in range(t):
            moved = moved or tangent[node * t + b] != (1.0 if a == b else 0.0)
        if moved:
            pm.moves[k] = a
            pm.change[k] = mo.u[node] - pm.start[node]
            k += 1
    pm.k = k
    for a in range(k):
        row = stuck[pm.moves[a]] * t
        for b in range(k):
            pm.power[a * k + b] = tangent[row + pm.moves[b]]


@inner
def distance_to_limit(pm: PeriodMap, leap: float, weight: FloatArray) -> float:
    """Largest weighted slip that remains to the limit after a number of periods, without drift."""
    far = 0.0
    for a in range(pm.k):
        left = abs(pm.change[a] - leap * pm.drift[a] - pm.limit[a])
        far = larger(far, weight[pm.stuck[pm.moves[a]]] * left)
    return far


@inner
def displace(pm: PeriodMap, change: FloatArray, u: FloatArray) -> None:
    """The start with the slips of the k nodes changed and the others in equilibrium, as ``u`` (2n,)."""
    n = pm.n
    for j in range(2 * n):
        if j >= n and pm.contact[j - n] != OPEN:
            u[j] = 0.0
        else:
            u[j] = pm.start[j] + along_basis(pm, change, j)


@inner
def along_basis(pm: PeriodMap, change: FloatArray, j: int) -> float:
    """Change of a displacement due to the slips of the k nodes."""
    total = 0.0
    for a in range(pm.k):
        total += pm.basis[j * pm.t + pm.moves[a]] * change[a]
    return total


@inner
def find_limit(pm: PeriodMap) -> bool:
    """Limit of the powers; False where an eigenvalue may be near 1."""
    k, J, d, limit, rest = pm.k, pm.power, pm.change, pm.limit, pm.image
    for a in range(k):
        pm.drift[a] = 0.0
        limit[a] = 0.0
        rest[a] = d[a]
    if not invert_difference(pm):
        return False
    for _ in range(2):  # the second pass corrects round-off
        for a in range(k):
            for b in range(k):
                limit[a] += pm.inverse[a * k + b] * rest[b]
        for a in range(k):
            rest[a] = d[a] - limit[a]
            for b in range(k):
                rest[a] += J[a * k + b] * limit[b]
    pm.contraction = asymptotic_factor(pm)
    pm.decaying = pm.contraction < 1.0
    return True


@inner
def invert_difference(pm: PeriodMap) -> bool:
    """(I − J)⁻¹ by elimination; False where it is larger than ``LARGEST_INVERSE``."""
    k, matrix, inverse = pm.k, pm.work, pm.inverse
    for a in range(k):
        for b in range(k):
            inverse[a * k + b] = 1.0 if a == b else 0.0
            matrix[a * k + b] = inverse[a * k + b] - pm.power[a * k + b]
    for c in range(k):
        best = c
        for a in range(c + 1, k):
            if abs(matrix[a * k + c]) > abs(matrix[best * k + c]):
                best = a
        pivot = matrix[best * k + c]
        if pivot == 0.0:
            return False
        for b in range(k):
            matrix[best * k + b], matrix[c * k + b] = matrix[c * k + b], matrix[best * k + b] / pivot
            inverse[best * k + b], inverse[c * k + b] = inverse[c * k + b], inverse[best * k + b] / pivot
        for a in range(k):
            x = matrix[a * k + c]
            if a != c and x != 0.0:
                for b in range(k):
                    matrix[a * k + b] -= x * matrix[c * k + b]
                    inverse[a * k + b] -= x * inverse[c * k + b]
    for a in range(k):
        total = 0.0
        for b in range(k):
            total += abs(inverse[a * k + b])
        if not total <= LARGEST_INVERSE:
            return False
    return True


@inner
def asymptotic_factor(pm: PeriodMap) -> float:
    """lim ‖Jⁱ⁺¹ d‖ / ‖Jⁱ d‖, as accurately as round-off allows, by repeated squaring of J."""
    k, matrix, vector, image = pm.k, pm.work, pm.image, pm.delay
    for a in range(k * k):
        matrix[a] = pm.power[a]
    for a in range(k):
        vector[a] = pm.change[a]
    size = norm(vector, k)
    factor, steps, log = 0.0, 1.0, 0.0
    for _ in range(40):
        if size == 0.0:
            return factor
        for a in range(k):
            vector[a] /= size
        multiply(matrix, vector, image, k)
        size = norm(image, k)
        log += np.log(size) if size > 0.0 else -np.inf
        if log < DIED_OUT:
            return factor
        factor = size ** (1.0 / steps)
        if log > GROWN:
            return factor
        for a in range(k):
            vector[a] = image[a]
        square(matrix, pm.inverse, k)
        steps *= 2.0
    return factor


@inner
def double_leap(pm: PeriodMap) -> None:
    """Double the leap: Σ_{i < leap} Jⁱ d and J^leap become those of twice its length."""
    k, image = pm.k, pm.image
    multiply(pm.power, pm.change, image, k)
    for a in range(k):
        pm.change[a] += image[a]
    square(pm.power, pm.work, k)


@inner
def norm(vector: FloatArray, k: int) -> float:
    """Euclidean norm."""
    total = 0.0
    for a in range(k):
        total += vector[a] * vector[a]
    return np.sqrt(total)


@summing
def multiply(matrix: FloatArray, vector: FloatArray, image: FloatArray, k: int) -> None:
    """image = matrix · vector."""
    for a in range(k):
        total = 0.0
        for b in range(k):
            total += matrix[a * k + b] * vector[b]
        image[a] = total


@inner
def square(matrix: FloatArray, work: FloatArray, k: int) -> None:
    """matrix · matrix in its place."""
    for a in range(k * k):
        work[a] = matrix[a]
        matrix[a] = 0.0
    for a in range(k):
        for b in range(k):
            x = work[a * k + b]
            if x != 0.0:
                for c in range(k):
                    matrix[a * k + c] += x * work[b * k + c]


class Limit(NamedTuple):
    """Limit of the iterated map of a period.

    Attributes
    ----------
    change : (t,)
        Slip from the start state to the limit, drift left out [length].
    drift : (t,)
        What the slips gain per period for ever [length].
    decaying
        Whether what remains dies out.
    contraction
        Factor by which it shrinks per period in the end; 0 where it ends after finitely many.
    """

    change: FloatArray
    drift: FloatArray
    decaying: bool
    contraction: float


def limit(J: FloatArray, d: FloatArray) -> Limit:
    """Sum of the geometric series Σ Jᵏ d, split into what decays and what drifts.

    The invariant subspace of the eigenvalue 1 (nodes that never move; drifts) is
    separated by an ordered Schur form, which stays accurate where J is defective.
    """
    if not len(d):
        return Limit(d, d, True, 0.0)
    T, Q, k = schur(J, output="real", sort=lambda re, im=0.0: (re - 1.0) ** 2 + im**2 <= NEGLIGIBLE**2)
    rest = T[k:, k:]
    Z = np.zeros((k, len(d) - k))
    if 0 < k < len(d):
        Z = solve_sylvester(T[:k, :k], -rest, -T[:k, k:])
    c = Q.T @ d
    unit, other = c[:k] - Z @ c[k:], c[k:]
    total = np.linalg.solve(np.eye(len(other)) - rest, other)
    contraction = shrinking_factor(rest, other)
    change = Q[:, :k] @ (Z @ total) + Q[:, k:] @ total
    return Limit(change, Q[:, :k] @ unit, contraction < 1.0, contraction)


def shrinking_factor(matrix: FloatArray, vector: FloatArray) -> float:
    """lim ‖Mᵏ⁺¹ x‖ / ‖Mᵏ x‖, as accurately as round-off allows, by repeated squaring of M."""
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return 0.0
    vector, factor, steps, log = vector / size, 0.0, 1, 0.0
    for _ in range(40):  # vector = Mᵏ x / ‖Mᵏ x‖ with k = steps − 1; log = log ‖Mᵏ x‖
        image = matrix @ vector
        norm = float(np.linalg.norm(image))
        log += np.log(norm) if norm > 0 else -np.inf
        if log < DIED_OUT:
            return factor
        factor = norm ** (1.0 / steps)
        if log > GROWN:
            return factor
        vector, matrix, steps = image / norm, matrix @ matrix, 2 * steps
    return factor
