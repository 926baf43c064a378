"""Friction up to which the energy keeps the evolution unique."""

import numpy as np

from shakedown.ground.golden_section import least_value
from shakedown.planar.uniqueness.scaled_stiffness import ScaledStiffness, held

WIDTH = 10.0  # largest distance of the best log c from the middle: e²⁰ in c²; any c is valid


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
    return 2.0 / least_value(largest, middle - WIDTH, middle + WIDTH)
