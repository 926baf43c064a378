"""Random joints that the mean load opens at some nodes."""

from functools import cache

import numpy as np

from shakedown import Problem, upper_bound
from shakedown.bounds.largest_load_factor import opened_by_mean_load


def partly_open(seed, n=None, d=1):
    """A random joint of d tangential directions, some nodes of which the mean load pulls open."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(3, 8)) if n is None else n
    place = np.append(np.repeat(np.arange(n), d), np.arange(n))
    M = rng.normal(size=(len(place), len(place))) * np.exp(-0.3 * np.abs(np.subtract.outer(place, place)))
    K = M @ M.T + 0.5 * np.eye(len(place))
    p_w = rng.normal(0.6, 1.0, n) + 0.3 * rng.normal(size=(8, n))
    q_w = 0.5 * rng.normal(size=(8, d * n))
    t = d * n  # tangential displacements
    return Problem(A=K[:t, :t], B=K[t:, :t], C=K[t:, t:], f=0.3, q_w=q_w, p_w=p_w)


@cache
def zone_bound(seed):
    """λ_max of such a joint in the best zone that the search finds."""
    return upper_bound(partly_open(seed), open_nodes="auto")


SOME = [seed for seed in range(60) if opened_by_mean_load(partly_open(seed))][:25]
