"""The affine map of one period, carried in compiled code, its powers, and their limit.

v ↦ v + d + J (v − v_start) for the slips v of the nodes alone that are stuck at the start and move within
the period. The others keep their slips exactly, so that the map leaves the space of
these nodes as it is: there lie all its powers of the increment, and their limit.

That is (I − J)⁻¹ d where no eigenvalue of J is near 1, which the size of the inverse shows.
Where one is, what drifts must be split off (:func:`limit`): that is left to the caller.
"""

from typing import Any

import numpy as np
from scipy.linalg import schur, solve_sylvester

from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.named_state import Integers, NamedState, Reals, entered, inner, summing
from shakedown.ground.status import OPEN, STICK
from shakedown.motion.plane.active_set import ActiveSet, larger
from shakedown.motion.plane.moving_state import PlaneMotion

DIED_OUT, GROWN = 1e-13, 1e6  # of ‖Jᵏ d‖ / ‖d‖, between which it stands out of round-off


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
    image, work
        Scratch (n,), (n, n).
    n, t, k
        Numbers of nodes.
    contraction, decaying
        Factor by which the increment shrinks per period in the end, and whether it dies out.
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
    n: int
    t: int
    k: int
    contraction: float
    decaying: bool


def period_map(n: int) -> PeriodMap:
    """Arrays for the map of n nodes."""
    shapes = {"start": 2 * n, "basis": (2 * n, n), "tangent": (2 * n, n)}
    shapes |= dict.fromkeys(("contact", "stuck", "moves", "delay", "change", "limit", "drift", "image"), n)
    new = PeriodMap(shapes | dict.fromkeys(("power", "work"), (n, n)))
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
def inverse_or_nan(matrix: FloatArray) -> Any:
    """The inverse of a matrix; NaN where it is singular."""
    try:
        return np.linalg.inv(matrix)
    except Exception:  # compiled code knows no other
        return np.full_like(matrix, np.nan).T  # by columns, as inverses are


@inner
def find_limit(pm: PeriodMap) -> bool:
    """Limit of the powers; False where an eigenvalue may be near 1."""
    k, J, d, limit = pm.k, pm.power, pm.change, pm.limit
    difference, rest = np.empty((k, k)), np.empty(k)
    for a in range(k):
        limit[a], pm.drift[a], rest[a] = 0.0, 0.0, d[a]
        for b in range(k):
            difference[a, b] = (1.0 if a == b else 0.0) - J[a * k + b]
    inverse = inverse_or_nan(difference)
    # norm of (I − J)⁻¹ up to which no eigenvalue of J is near 1 and round-off is small
    if not np.linalg.norm(inverse) <= 1e5:
        return False
    for _ in range(2):  # the second pass corrects round-off
        for a in range(k):
            for b in range(k):
                limit[a] += inverse[a, b] * rest[b]
        for a in range(k):
            rest[a] = d[a]
            for b in range(k):
                rest[a] -= difference[a, b] * limit[b]
    pm.contraction = shrinking_factor(J, d, k)
    pm.decaying = pm.contraction < 1.0
    return True


@entered
def shrinking_factor(matrix, vector, k):  # type: ignore[no-untyped-def]
    """lim ‖Mʲ⁺¹ x‖ / ‖Mʲ x‖, as accurately as round-off allows, by repeated squaring of M, (k · k,)."""
    power, square, x, image = np.empty(k * k), np.empty(k * k), np.empty(k), np.empty(k)
    for a in range(k):
        x[a] = vector[a]
    for a in range(k * k):
        power[a] = matrix[a]
    first = size = norm(x, k)
    factor, steps = 0.0, 1
    for _ in range(40):  # x = Mʲ · vector with j = steps − 1
        multiply(power, x, image, k, 1)
        before, size = size, norm(image, k)
        if not size > DIED_OUT * first:
            break
        factor = (size / before) ** (1.0 / steps)
        if size > GROWN * first:
            break
        multiply(power, power, square, k, k)
        power, square, x, image, steps = square, power, image, x, 2 * steps
    return factor


@inner
def double_leap(pm: PeriodMap) -> None:
    """Double the leap: Σ_{i < leap} Jⁱ d and J^leap become those of twice its length."""
    k, power, change = pm.k, pm.power, pm.change
    multiply(power, change, pm.image, k, 1)
    for a in range(k):
        change[a] += pm.image[a]
    multiply(power, power, pm.work, k, k)
    for a in range(k * k):
        power[a] = pm.work[a]


@inner
def norm(vector: FloatArray, k: int) -> float:
    """Euclidean norm."""
    total = 0.0
    for a in range(k):
        total += vector[a] * vector[a]
    return np.sqrt(total)


@summing
def multiply(matrix: FloatArray, other: FloatArray, image: FloatArray, k: int, columns: int) -> None:
    """image = matrix · other, of (k, k) and (k, columns)."""
    for a in range(k):
        for c in range(columns):
            total = 0.0
            for b in range(k):
                total += matrix[a * k + b] * other[b * columns + c]
            image[a * columns + c] = total


def limit(J: FloatArray, d: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Sum of the geometric series Σ Jᵏ d, split into what decays and what drifts.

    The invariant subspace of the eigenvalue 1 (nodes that never move; drifts) is
    separated by an ordered Schur form, which stays accurate where J is defective.

    Returns
    -------
    change : (t,)
        Slip from the start state to the limit, drift left out [length].
    drift : (t,)
        What the slips gain per period for ever [length].
    contraction
        Factor by which what remains shrinks per period in the end; 0 where it ends after finitely many. From
        1 on it does not die out.
    """
    T, Q, k = schur(J, output="real", sort=lambda re, im=0.0: (re - 1.0) ** 2 + im**2 <= NEGLIGIBLE**2)
    rest = T[k:, k:]
    Z = np.zeros((k, len(d) - k))
    if 0 < k < len(d):
        Z = solve_sylvester(T[:k, :k], -rest, -T[:k, k:])
    c = Q.T @ d
    unit, other = c[:k] - Z @ c[k:], c[k:]
    total = np.linalg.solve(np.eye(len(other)) - rest, other)
    change = Q[:, :k] @ (Z @ total) + Q[:, k:] @ total
    contraction = shrinking_factor(np.ascontiguousarray(rest).ravel(), other, len(other))
    return np.asarray(change), np.asarray(Q[:, :k] @ unit), contraction
