"""Joints for laws that hold for every joint."""

import numpy as np

from shakedown import Problem
from shakedown.joint.constraints import with_initial_gap

SPACE = (
    "regular", "singular", "floating", "whole", "uncoupled", "high friction", "frictionless", "transient",
    "domain", "gap", "open", "still", "line", "means",
)  # fmt: skip


def space_joint(rng: np.random.Generator, kind: str, most: int = 8) -> Problem:
    """One to ``most`` nodes with two tangential directions, κ positive semi-definite."""
    n, m = int(rng.integers(1, most + 1)), int(rng.integers(2, 9))
    size, whole = 3 * n, kind == "whole"
    root = rng.normal(size=(size, size)) / np.sqrt(size)
    if kind == "singular":
        root[:, : int(rng.integers(1, size))] = 0.0
    if whole:
        root = rng.integers(-2, 3, (size, size)).astype(float)
    kappa = root @ root.T
    if kind not in ("singular", "whole"):
        kappa += np.eye(size)
    if kind == "uncoupled":
        kappa[: 2 * n, 2 * n :] = kappa[2 * n :, : 2 * n] = 0.0
    if kind == "floating":  # in both directions, as a rigid body that is moved along its plane
        away = np.zeros((size, 2))
        away[: 2 * n] = np.tile(np.eye(2), (n, 1)) / np.sqrt(n)
        hold = np.eye(size) - away @ away.T
        kappa = hold @ kappa @ hold
        kappa = (kappa + kappa.T) / 2
    f = {"high friction": rng.uniform(2.0, 20.0, n), "frictionless": rng.choice([0.0, 0.5], n)}.get(
        kind, rng.uniform(0.1, 0.9, n)
    )
    q, p = rng.normal(size=(m, 2 * n)), rng.normal(size=(m, n)) + 4.0
    if kind == "still":
        q, p = np.repeat(q[:1], m, axis=0), np.repeat(p[:1], m, axis=0)
    if kind == "line":
        q = rng.normal(size=2 * n) * np.cos(2 * np.pi * np.arange(m)[:, None] / m)
    if kind == "open":
        p[:, rng.integers(n)] -= 6.0
    if whole:
        q, p = np.round(4 * q) / 4, np.round(4 * p) / 4
    more = {}
    if kind in ("means", "whole"):
        more = {"q_mean": q[0] / 4, "p_mean": np.full(n, 4.0)}
    if kind == "transient":
        k = int(rng.integers(1, 4))
        more = {"q_transient": rng.normal(size=(k, 2 * n)), "p_transient": rng.normal(size=(k, n)) + 4.0}
    if kind == "domain":
        more = {"load_path": "domain"}
    C = None if kind not in ("open", "gap") and rng.random() < 0.2 else kappa[2 * n :, 2 * n :]
    problem = Problem(
        A=kappa[: 2 * n, : 2 * n], B=kappa[2 * n :, : 2 * n], C=C, f=f, q_w=q, p_w=p, **more,
        initial_slip=0.1 * rng.normal(size=2 * n),
    )  # fmt: skip
    return with_initial_gap(problem, rng.uniform(-1.0, 0.5)) if kind == "gap" else problem
