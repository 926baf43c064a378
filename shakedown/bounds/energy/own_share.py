"""The share of a node's own tangential reaction in its pressure that leaves a ball the most slack."""

import numpy as np

from shakedown.bounds.energy.ball_limits import DiscLimits
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import HALVINGS, NEGLIGIBLE, PER_CENT

MOST = 1 - PER_CENT  # largest f |c|: the proof needs less than 1


def best_share(limits: DiscLimits, slip: FloatArray, load_factor: float, radius: float) -> FloatArray:
    """c of every node at which the least slack over its load steps is largest, (n, 2) [1].

    With A_ii = U diag(α) Uᵀ and c_i = A_ii⁻¹ B_ii the best lies on the curve
    c(t) = (t A_ii + (1 − t) α_max)⁻¹ t A_ii c_i, 0 ≤ t ≤ 1, from 0 to c_i: for any length |c| the least γ is
    there. The slack falls with a(c) |q*| at the load step with the least slack, and grows as γ falls; where
    the two balance the slack is largest, as it is concave in c. Found by bisection, for all nodes at once.

    Parameters
    ----------
    limits
        The limits; their own shares do not matter.
    slip, load_factor
        The centre of the ball [length], and the load factor.
    radius
        Its radius in units of ``metric.unit``.
    """
    u = limits.reactions(slip, load_factor)
    pressed, drawn, node = u[:, 0], np.hypot(u[:, 1], u[:, 2]), limits.node
    first = np.flatnonzero(np.append(True, np.diff(node) > 0))
    values, vectors = np.linalg.eigh(limits.stiffness)
    values = np.maximum(values, 0.0)  # eigenvalues of a singular stiffness are round-off
    largest = values[:, -1]
    turned = np.einsum("ijk,ij->ik", vectors, limits.own)

    def on_curve(t: FloatArray) -> FloatArray:
        """c(t) along the eigenvectors of A_ii, (n, 2)."""
        weights = t[:, None] * values
        whole = weights + ((1.0 - t) * largest)[:, None]
        return np.divide(weights * turned, whole, out=np.zeros_like(whole), where=whole > 0)

    def too_far(t: FloatArray) -> np.ndarray:
        """Whether the slack already decreases with t, or f |c| is too large."""
        c = on_curve(t)
        size = limits.f * np.hypot(c[:, 0], c[:, 1])
        a = np.sqrt(1.0 + size**2)
        # c(t) − c_i is 1 − t times a vector, of which this is the length in the metric of γ.
        whole = t[:, None] * values + ((1.0 - t) * largest)[:, None]
        away = np.divide(largest[:, None] * turned, whole, out=np.zeros_like(whole), where=whole > 0)
        steep = np.sqrt(np.einsum("ij,ij->i", away**2, values))
        taken = a[node] * drawn - pressed
        worst = np.maximum.reduceat(taken, first)
        tied = taken >= worst[node] - NEGLIGIBLE * (np.abs(pressed) + a[node] * drawn)
        at = np.maximum.reduceat(np.where(tied, drawn, 0.0), first)
        left = np.where(limits.least > 0, 1.0 - t, 1.0)  # where γ vanishes, 1 − t is divided out
        gamma = np.where(limits.least > 0, np.hypot(limits.least, left * steep), steep)
        balance = limits.f * at * gamma * t - radius * largest * left * a
        return np.asarray((balance > 0) | (size > MOST))

    low, high = np.zeros(len(largest)), np.ones(len(largest))
    whole = ~too_far(high)
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        beyond = too_far(middle)
        low, high = np.where(beyond, low, middle), np.where(beyond, middle, high)
    c = on_curve(np.where(whole, 1.0, low))
    return np.asarray(np.einsum("ijk,ik->ij", vectors, c))
