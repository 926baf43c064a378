"""Joints drawn to be difficult: strongly coupled, floating, under separate impulses."""

import numpy as np

import shakedown
from shakedown import Problem
from shakedown.bounds.coupling import row_coupling_ratio
from shakedown.fem import ElasticBody, Material, Pressure, Traction, block_mesh, contact_problem


def symmetric(rng: np.random.Generator, n: int) -> np.ndarray:
    root = rng.normal(size=(n, n))
    root = 0.5 * (root + root.T)
    np.fill_diagonal(root, 0.0)
    return root / max(1.0, np.abs(np.linalg.eigvalsh(root)).max())


def scaled_to(A: np.ndarray, B: np.ndarray, ratio: float) -> tuple[np.ndarray, np.ndarray]:
    """The same joint with all coupling scaled so that its coupling ratio is just below a number."""
    low, high = 0.0, 1.0
    for _ in range(30):
        middle = 0.5 * (low + high)
        found = row_coupling_ratio(middle * A + (1 - middle) * np.eye(len(A)), 0.5 * middle * B)
        low, high = (middle, high) if found is not None and found.ratio < ratio else (low, middle)
    return low * A + (1 - low) * np.eye(len(A)), low * B


def stiffness(rng: np.random.Generator, n: int, shape: str) -> tuple[np.ndarray, np.ndarray]:
    """A and B before they are scaled to a coupling ratio; those of a floating body as they are."""
    if shape == "floating":
        W = np.triu(rng.uniform(0.0, 1.0, (n, n)) ** 3, 1)
        B = rng.normal(size=(n, n)) * rng.uniform(0.05, 0.6) * (W + W.T + 0.1)
        return np.diag((W + W.T).sum(axis=1)) - W - W.T, B - np.diag(B.sum(axis=1))
    if shape == "dense" or n < 3:
        A = np.eye(n) + rng.uniform(0.05, 0.95) * symmetric(rng, n)
        size = 10.0 ** rng.uniform(-1.5, 0.5, (n, 1))  # strong ones are lifted off by locked-in slip
        return A, rng.normal(size=(n, n)) * size * (rng.random((n, n)) < 0.7)
    apart = np.abs(np.arange(n) - np.arange(n)[:, None])
    side = np.sign(apart - apart.T + np.arange(n) - np.arange(n)[:, None])
    A = np.eye(n) + rng.uniform(-0.6, 0.6) * (0.5**apart - np.eye(n))
    return A, rng.uniform(0.3, 3.0) * side * rng.uniform(0.5, 1.5, (n, n)) * 0.6**apart


def loaded(rng: np.random.Generator, A: np.ndarray, B: np.ndarray, loads: str) -> shakedown.Problem:
    """A joint pressed together, under separate impulses, a smooth loop, or one whose mean lies elsewhere."""
    n = len(A)
    p0 = rng.uniform(2, 8, n)
    q0 = rng.uniform(-0.2, 0.2, n) * p0
    if loads == "smooth":
        m = 12
        turn = 2 * np.pi * (np.arange(m)[:, None] / m + rng.random(n))
        q1, p1 = rng.uniform(0.2, 2, n) * np.cos(turn), rng.uniform(0, 1.5, n) * np.sin(turn + rng.random(n))
        return shakedown.Problem(A=A, B=B, f=0.5, q_w=q0 + q1, p_w=p0 + p1)
    m = int(rng.integers(2 * n, 4 * n + 1))
    q1 = np.zeros((m, n))
    order = rng.permutation(np.repeat(np.arange(n), 2))
    q1[np.arange(2 * n), order] = rng.choice([-1, 1], 2 * n) * rng.uniform(0.2, 2, 2 * n)
    p1 = (rng.random() < 0.3) * 0.5 * rng.normal(size=(m, n))
    if loads == "off centre":
        q1, p1 = q1 + 0.3 * rng.normal(size=n), p1 + 0.3 * rng.normal(size=n)
    return shakedown.Problem(A=A, B=B, f=0.5, q_w=q0 + q1, p_w=p0 + p1, q_mean=q0, p_mean=p0)


def floating_joint(rng: np.random.Generator, n: int, kind: str, loads: str) -> Problem:
    """Everything coupled to everything, but for rigid motions."""
    d = 1 if kind == "plane" else 2
    x = rng.normal(size=(n, 2))
    Z = np.kron(np.ones((n, 1)), np.eye(d))
    if kind == "rotation":
        Z = np.column_stack([Z, np.stack([-x[:, 1], x[:, 0]], axis=1).ravel()])
    away = np.eye(d * n) - Z @ np.linalg.pinv(Z)
    root = rng.normal(size=(d * n, d * n))
    A = away @ (np.eye(d * n) + rng.uniform(0.1, 1.5) * root @ root.T / (d * n)) @ away
    B = rng.normal(size=(n, d * n)) @ away
    if rng.random() < 0.5:  # a given normal force
        B -= B.mean(axis=0)
    f = rng.uniform(0.2, 0.8, n)
    f = f if rng.random() < 0.5 else np.full(n, f[0])
    B *= rng.uniform(0.05, 0.6) / np.linalg.norm(np.linalg.pinv(A) @ (f[:, None] * B).T, 2)
    return Problem(A=0.5 * (A + A.T), B=B, f=f, **loop(rng, n, f, loads, d))


def loop(rng: np.random.Generator, n: int, f: np.ndarray, loads: str, d: int = 2) -> dict[str, np.ndarray]:
    """Separate impulses in random order, smooth, or impulses with a mean of their own."""
    p0 = rng.uniform(2.0, 8.0, n)
    q0 = 0.3 * rng.normal(size=d * n) * np.repeat(f * p0, d)
    if loads == "smooth":
        turn = 2.0 * np.pi * (np.arange(16)[:, None] / 16 + rng.random(d * n))
        q1, p1 = rng.uniform(0.2, 2.0, d * n) * np.cos(turn), rng.uniform(0, 1.5, n) * np.sin(turn[:, ::d])
        return {"q_w": q0 + q1, "p_w": p0 + p1}
    q1 = np.zeros((6 * n, d * n))
    for k, node in enumerate(rng.permutation(np.repeat(np.arange(n), 3))):
        angle = rng.uniform(0.0, 2.0 * np.pi)
        along = np.array([np.cos(angle), np.sin(angle)])[:d]
        q1[2 * k, d * node : d * (node + 1)] = rng.uniform(0.3, 2.0) * along
    p1 = (rng.random() < 0.3) * 0.5 * rng.normal(size=(6 * n, n))
    if loads == "off centre":
        q1, p1 = q1 + 0.3 * rng.normal(size=d * n), p1 + 0.3 * rng.normal(size=n)
        return {"q_w": q0 + q1, "p_w": p0 + p1, "q_mean": q0, "p_mean": p0}
    return {"q_w": q0 + q1, "p_w": p0 + p1}


def floating_block(n: int, f: float) -> Problem:
    """An elastic block that friction alone holds, pressed on a plane and drawn to and fro."""
    loads = [
        Pressure("top", 10.0, history=np.ones(24)),
        Traction("top", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
    ]
    mesh = block_mesh(2.0, 1.0, n - 1, (n - 1) // 2)
    body = ElasticBody(mesh, Material(young=200e3, poisson=0.3), loads=loads)
    return contact_problem(body, "bottom", f=f, steps=24)
