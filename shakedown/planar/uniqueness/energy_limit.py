"""Friction up to which the energy keeps the evolution unique."""

from collections.abc import Callable

import numpy as np

from shakedown.planar.uniqueness.scaled_stiffness import ScaledStiffness, held

WIDTH = 10.0  # largest distance of the best log c from the middle: a factor e²⁰ in c²
STEPS = 24  # of a golden section: log c to 2e-4, and the limit at worst; any c gives a valid one


def energy_limit(stiffness: ScaledStiffness, *, separation: bool) -> float:
    """The factor t on φ where uᵀκu + t Σ s φ v p could first vanish for some motion; 0 for a floating body.

    Below it all moving sets are unique. With p = G u the sum is at most
    ½ uᵀ (c φ + Gᵀφ G / c) u for any c > 0; the best c is searched for. The logarithm
    of the largest eigenvalue changes by no more than log c does, and is convex in it.
    """
    K = stiffness.kappa if separation else stiffness.A
    G = K[stiffness.layout.gaps] if separation else stiffness.B
    if not held(K, stiffness.tolerances):
        return 0.0
    try:
        root = np.linalg.inv(np.linalg.cholesky(K))
    except np.linalg.LinAlgError:  # indefinite by round-off
        return 0.0
    slip = root[:, stiffness.layout.slips] * np.sqrt(stiffness.weights)
    pressure = root @ G.T * np.sqrt(stiffness.weights)
    first, second = slip @ slip.T, pressure @ pressure.T
    sizes = np.trace(first), np.trace(second)
    if sizes[0] == 0.0 or sizes[1] == 0.0:
        return np.inf

    def largest(log_c: float) -> float:
        c = np.exp(log_c)
        return float(np.linalg.eigvalsh(c * first + second / c)[-1])

    middle = 0.5 * np.log(sizes[1] / sizes[0])
    return 2.0 / _least(largest, middle - WIDTH, middle + WIDTH)


def _least(convex: Callable[[float], float], low: float, high: float) -> float:
    """The least value of a convex function that a golden section finds: one value a step.

    By hand, because to load scipy.optimize takes longer than all the rest for a hundred nodes.
    """
    ratio = 0.5 * (5**0.5 - 1)
    a, b = high - ratio * (high - low), low + ratio * (high - low)
    at_a, at_b = convex(a), convex(b)
    for _ in range(STEPS):
        if at_a < at_b:
            high, b, at_b = b, a, at_a
            a = high - ratio * (high - low)
            at_a = convex(a)
        else:
            low, a, at_a = a, b, at_b
            b = low + ratio * (high - low)
            at_b = convex(b)
    return min(at_a, at_b)
