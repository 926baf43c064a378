"""Joints of any size for speed studies."""

import numpy as np

from shakedown import Problem


def chain(n: int, f: float = 0.2, m: int = 50, seed: int = 0) -> Problem:
    """A strip of n nodes: influence that decays with distance, antisymmetric coupling, a travelling load."""
    rng = np.random.default_rng(seed)
    x, node, t = np.linspace(0, 1, n), np.arange(n), 2 * np.pi * np.arange(m) / m
    distance = np.abs(node[:, None] - node)
    root = 2.0 * np.eye(n) - 0.15 * np.exp(-distance / 3.0)
    side = np.sign(node - node[:, None]) * (1 + 0.1 * rng.normal(size=(n, n)))
    q = np.cos(t)[:, None] * (0.5 + 0.5 * np.sin(3 * x)) + 0.2 * np.sin(2 * t)[:, None] * x
    p = 6 + np.sin(t + 0.7)[:, None] * (1 - x) + 0.5 * rng.random(n)
    return Problem(A=root @ root, B=0.3 * side * np.exp(-distance / 4.0), f=f, q_w=q, p_w=p)


def random_joint(n: int, seed: int = 0) -> Problem:
    """A random positive definite joint of moderate coupling, pressed together."""
    rng = np.random.default_rng(seed)
    root = 0.3 * rng.normal(size=(2 * n, 2 * n))
    kappa = root @ root.T / np.sqrt(2 * n) + np.eye(2 * n)
    return Problem(
        A=kappa[:n, :n],
        B=kappa[n:, :n],
        f=rng.uniform(0.1, 0.5, n),
        q_w=rng.normal(size=(6, n)),
        p_w=4.0 + rng.normal(size=(6, n)),
    )
