"""Random joints that the mean load opens at some nodes."""

import numpy as np

from shakedown import Problem
from shakedown.bounds.best_zone import opened_by_mean_load


def partly_open(seed, n=None):
    """A random joint, some nodes of which the mean load pulls open."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 8)) if n is None else n
    apart = np.abs(np.subtract.outer(np.arange(n), np.arange(n)))
    M = rng.normal(size=(2 * n, 2 * n)) * np.exp(-0.3 * np.tile(apart, (2, 2)))
    K = M @ M.T + 0.5 * np.eye(2 * n)
    p_w = rng.normal(0.6, 1.0, n) + 0.3 * rng.normal(size=(8, n))
    q_w = 0.5 * rng.normal(size=(8, n))
    return Problem(A=K[:n, :n], B=K[n:, :n], C=K[n:, n:], f=0.3, q_w=q_w, p_w=p_w)


SOME = [seed for seed in range(60) if opened_by_mean_load(partly_open(seed))][:25]
