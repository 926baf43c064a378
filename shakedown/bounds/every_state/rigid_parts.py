"""Least and largest pressures of a body that friction alone holds: multipliers with a rigid part."""

import numpy as np

from shakedown.bounds.every_state.least_pressures import LeastPressures, least_pressures, nearly_least
from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.bounds.every_state.sectors import every_direction
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE

ROUNDS = 4  # of multipliers and their rigid parts by turns; the last changes bounds by 1e-4 or less
WEIGHTINGS = 12  # of the nodes, each about a digit nearer to the least weighted sum


def pressures_of_floating(joint: ScaledJoint, *, sign: float = 1.0) -> LeastPressures:
    """The bounds p_i ≥ π_i of all nodes (``sign`` −1: −p_i ≥ −P_i) for every slip that friction admits.

    With Y any Y + Z c solves the equations of the multipliers as well, as neither A nor B know rigid slips
    (docs/universal.md, statement 6.7). The c of every node is chosen for the mean load; any is valid.
    """
    directions = every_direction(np.arange(joint.n))
    c = np.zeros((joint.n, joint.motions.shape[1]))
    for _ in range(ROUNDS):
        c = c + _best_parts(joint, nearly_least(joint, directions, c @ joint.motions.T, sign))
    return least_pressures(joint, directions, shift=c @ joint.motions.T, sign=sign)


def _best_parts(joint: ScaledJoint, Y: FloatArray) -> FloatArray:
    """The c (n, r) with the least Σ_j (f_j p_j |Y_j + Z_j c| + (Y_j + Z_j c) · q_j) under the mean load.

    By least squares again and again, with weights that make them the sum of the lengths.
    """
    n, Z = joint.n, joint.motions
    r = Z.shape[1]
    by_node = Z.reshape(n, 2, r)
    squares = np.einsum("jar,jas->jrs", by_node, by_node).reshape(n, r * r)
    limits = np.maximum(joint.f * joint.p0, NEGLIGIBLE * np.abs(joint.f * joint.p0).max())
    c = np.zeros((len(Y), r))
    if not limits.any():  # then no c costs less than another
        return c
    for _ in range(WEIGHTINGS):
        parts = (Y + c @ Z.T).reshape(len(Y), n, 2)
        sizes = np.hypot(parts[..., 0], parts[..., 1])
        largest = sizes.max(axis=1, keepdims=True)
        weights = limits / np.maximum(sizes, np.where(largest > 0, NEGLIGIBLE * largest, 1.0))
        right = (np.repeat(weights, 2, axis=1) * Y + joint.q0) @ Z
        inverse = np.linalg.pinv((weights @ squares).reshape(-1, r, r), hermitian=True)
        c = -np.einsum("irs,is->ir", inverse, right)  # of motions that no weight tells of: none
    c[np.abs(Y).max(axis=1) == 0.0] = 0.0
    return c
