"""Friction up to which weak coupling keeps the evolution unique."""

import numpy as np

from shakedown.model.problem import FloatArray
from shakedown.uniqueness.scaled_stiffness import ScaledStiffness

DOUBLINGS = 40  # of the factor 1, after which a coupling ratio of 1 counts as never reached
CLOSE = 1e-9  # distance from a node's own critical friction, where N is infinite
STEPS = 40  # of bisection


def coupling_limit(stiffness: ScaledStiffness) -> float:
    """The factor t on φ where the coupling ratio ρ reaches 1.

    Below it every A − t S φ B is an H-matrix with a positive diagonal, so that all its
    principal minors are positive. ρ never falls with t: every entry of the influence N
    is a quasi-convex, even function of t.
    """
    a, b = np.diag(stiffness.A), np.abs(np.diag(stiffness.weighted))
    own = float(np.min(a / np.where(b > 0, b, 1.0), where=b > 0, initial=np.inf))
    if distance_from_one(stiffness, 0.0) <= 0:
        return 0.0
    high = own * (1 - CLOSE)
    if np.isinf(own):
        high = next((t for t in 2.0 ** np.arange(DOUBLINGS) if distance_from_one(stiffness, t) <= 0), np.inf)
    if np.isinf(high) or distance_from_one(stiffness, high) > 0:
        return float(high)
    low = 0.0
    for _ in range(STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if distance_from_one(stiffness, middle) > 0 else (low, middle)
    return float(low)


def distance_from_one(stiffness: ScaledStiffness, factor: float) -> float:
    """Positive where ρ(N) < 1, vanishing at ρ = 1: the smallest 1/x_i of (I − N) x = 1.

    If x > 0 then N x < x, which proves ρ < 1 (Collatz–Wielandt); if ρ < 1 then x = Σ Nᵏ 1 ≥ 1.
    """
    N = influence(stiffness.A, factor * stiffness.weighted)
    if N is None:
        return -1.0
    try:
        x = np.linalg.solve(np.eye(len(N)) - N, np.ones(len(N)))
    except np.linalg.LinAlgError:
        return 0.0
    if np.all(x > 0) and not np.all(N @ x < x):  # ρ is 1 to round-off
        return 0.0
    return float((1.0 / np.where(x == 0, -1.0, x)).min())


def influence(A: FloatArray, fB: FloatArray) -> FloatArray | None:
    """N_ij = max over both sides of |A_ij ∓ (fB)_ij| / (A_ii ∓ (fB)_ii), N_ii = 0.

    None where a node is at or above its own critical friction, A_ii / |B_ii|.
    """
    sides = np.stack([A - fB, A + fB])
    own = np.diagonal(sides, axis1=1, axis2=2)
    if np.any(own <= 0):
        return None
    N = np.max(np.abs(sides) / own[:, :, None], axis=0)
    np.fill_diagonal(N, 0.0)
    return np.asarray(N)
