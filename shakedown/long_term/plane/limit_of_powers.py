"""The limit of the powers of an affine map, Σ Jᵏ d, by elimination, and its rate of convergence.

It is (I − J)⁻¹ d where no eigenvalue of J is near 1, which the size of the inverse shows. Where it
does not, what drifts must be split off (:func:`shakedown.long_term.cycle_map.limit`): that is left
to the caller.
"""

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import inner, summing
from shakedown.long_term.plane.period_map import PeriodMap

LARGEST_INVERSE = 1e5  # norm of (I − J)⁻¹ up to which no eigenvalue of J is near 1 and round-off is small
DIED_OUT, GROWN = np.log(1e-13), np.log(1e6)  # of ‖Jᵏ d‖ / ‖d‖, logarithms


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
