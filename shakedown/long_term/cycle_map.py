"""The limit of the map from one cycle's start to the next, affine on a sequence of contact states."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import schur, solve_sylvester

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE


@dataclass(frozen=True)
class Limit:
    """Limit of the iterated cycle map.

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
    contraction = asymptotic_factor(rest, other)
    change = Q[:, :k] @ (Z @ total) + Q[:, k:] @ total
    return Limit(change, Q[:, :k] @ unit, contraction < 1.0, contraction)


def asymptotic_factor(matrix: FloatArray, vector: FloatArray) -> float:
    """lim ‖Mᵏ⁺¹ x‖ / ‖Mᵏ x‖, as accurately as round-off allows, by repeated squaring of M."""
    size = float(np.linalg.norm(vector))
    if size == 0.0:
        return 0.0
    vector, factor, steps, log = vector / size, 0.0, 1, 0.0
    for _ in range(40):  # vector = Mᵏ x / ‖Mᵏ x‖ with k = steps − 1; log = log ‖Mᵏ x‖
        image = matrix @ vector
        norm = float(np.linalg.norm(image))
        log += np.log(norm) if norm > 0 else -np.inf
        if log < np.log(1e-13):
            return factor
        factor = norm ** (1.0 / steps)
        if log > np.log(1e6):
            return factor
        vector, matrix, steps = image / norm, matrix @ matrix, 2 * steps
    return factor
