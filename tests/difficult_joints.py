"""Joints that friction alone holds: drawn, strongly coupled, under separate impulses; an elastic block."""

import numpy as np

from shakedown import Problem
from shakedown.fem import ElasticBody, Material, Pressure, Traction, block_mesh, contact_problem


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
