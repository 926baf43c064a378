"""Joints that the tests of this folder share, and the plain statement of the program through cvxpy."""

import warnings

import cvxpy as cp
import numpy as np

from shakedown import Problem
from shakedown.joint.constraints import loading


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


def plainly(
    problem: Problem,
    share: np.ndarray | None = None,
    *,
    start: np.ndarray | None = None,
    distance: float = 0.0,
    load_factor: float | None = None,
    end: type = cp.Maximize,
) -> float:
    """λ_E from a slip, or the radius of the largest ball at a load factor, every load step on its own.

    In the plane, below critical friction, the whole own share is taken, which costs nothing there.
    """
    n, d, loop, f = problem.n, problem.directions, loading(problem), problem.f
    stretch = np.ones(n) if d == 1 else np.sqrt(1 + f**2 * (share**2).sum(axis=1))
    spread = f * gammas(
        problem, (np.diagonal(problem.B) / np.diagonal(problem.A))[:, None] if d == 1 else share
    )
    values, vectors = np.linalg.eigh(problem.A)
    root = (vectors * np.sqrt(np.maximum(values, 0.0))).T
    v, radius, factor = cp.Variable(d * n), cp.Variable(nonneg=True), cp.Variable(nonneg=True)
    limits = [factor == load_factor] if load_factor is not None else []
    if load_factor is None:
        limits.append(
            cp.norm(root @ (v - (np.zeros(d * n) if start is None else start))) + distance <= radius
        )
    q, p = loop.q0 + problem.A @ v, loop.p0 + problem.B @ v
    for q1, p1 in zip(loop.q1, loop.p1, strict=True):
        drawn = cp.reshape(q + factor * q1, (d, n), order="F")
        limits.append(cp.SOC(cp.multiply(f, p + factor * p1) - spread * radius, drawn @ np.diag(stretch)))
    task = cp.Problem(end(factor) if load_factor is None else cp.Maximize(radius), limits)
    with warnings.catch_warnings():  # it asks itself for more digits than it reaches
        warnings.simplefilter("ignore", UserWarning)
        task.solve(solver="CLARABEL", tol_gap_abs=1e-10, tol_gap_rel=1e-10, tol_feas=1e-10)
    return float(task.value)
