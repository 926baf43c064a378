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


def space_joint(seed: int, n: int, *, m: int = 12, friction: float = 0.5, floating: bool = False) -> Problem:
    """A random joint with two directions, pressed together about a random safe slip."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3 * n, 3 * n))
    kappa = root @ root.T / (3 * n) + 0.1 * np.eye(3 * n)
    if floating:  # two common slips cost nothing and change no pressure
        rigid = np.vstack([np.tile(np.eye(2), (n, 1)), np.zeros((n, 2))]) / np.sqrt(n)
        kappa = (np.eye(3 * n) - rigid @ rigid.T) @ kappa @ (np.eye(3 * n) - rigid @ rigid.T)
    A, B, C = kappa[: 2 * n, : 2 * n], kappa[2 * n :, : 2 * n], kappa[2 * n :, 2 * n :]
    f = friction * rng.uniform(0.5, 1.5, n)
    locked, p0 = rng.normal(size=2 * n), rng.uniform(2, 5, n)
    q0 = 0.3 * (f * p0).repeat(2) * rng.uniform(-1, 1, 2 * n) - A @ locked
    t = 2 * np.pi * np.arange(m)[:, None] / m
    q = 0.5 * (rng.normal(size=2 * n) * np.cos(t) + rng.normal(size=2 * n) * np.sin(t))
    p = 0.3 * (rng.normal(size=n) * np.cos(2 * t) + rng.normal(size=n) * np.sin(t))
    return Problem(A=0.5 * (A + A.T), B=B, C=0.5 * (C + C.T), f=f, q_w=q0 + q, p_w=p0 - B @ locked + p)


def gammas(problem: Problem, share: np.ndarray) -> np.ndarray:
    """γ_i(c) from the inverse of A, of shares c (n, d), (n,)."""
    n, d = share.shape
    rest = problem.B - np.einsum("ij,ijk->ik", share, problem.A.reshape(n, d, -1))
    return np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", rest, np.linalg.pinv(problem.A), rest), 0.0))
