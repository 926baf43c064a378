"""Joints that the tests of this folder share."""

import numpy as np

from shakedown import Problem


def strong_joint(seed: int, n: int, *, floating: bool = False, friction: float = 0.6) -> Problem:
    """A random joint with strong coupling, pressed together about a random safe slip."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(2 * n, 2 * n))
    kappa = root @ root.T / (2 * n) + 0.1 * np.eye(2 * n)
    if floating:  # a common slip costs nothing and changes no pressure
        rigid = np.append(np.ones(n), np.zeros(n)) / np.sqrt(n)
        kappa -= np.outer(rigid, rigid @ kappa)
        kappa -= np.outer(kappa @ rigid, rigid)
    A, B, C = kappa[:n, :n], kappa[n:, :n], kappa[n:, n:]
    f = friction * rng.uniform(0.5, 1.5, n)
    locked, p0 = rng.normal(size=n), rng.uniform(2, 5, n)
    q0 = 0.3 * f * p0 * rng.uniform(-1, 1, n) - A @ locked
    q = q0 + rng.normal(size=(5, n))
    return Problem(
        A=0.5 * (A + A.T), B=B, C=0.5 * (C + C.T), f=f, q_w=q, p_w=p0 - B @ locked + np.zeros((5, n))
    )


def one_node(**changes: object) -> Problem:
    """One node without coupling, pressed by 3, pulled by ±1."""
    data: dict = {"A": [[2.0]], "B": [[0.0]], "f": 0.5, "q_w": [[1.0], [-1.0]], "p_w": [[3.0], [3.0]]}
    return Problem(**(data | changes))
