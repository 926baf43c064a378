"""Joints for laws that hold for every joint, and what the toolkit says of one."""

from typing import NamedTuple

import numpy as np

import shakedown
from shakedown import Problem

KINDS = ("regular", "singular", "sparse", "whole", "uncoupled", "high friction")


def joint(rng: np.random.Generator, kind: str) -> Problem:
    """One to three nodes with five load steps, κ positive semi-definite."""
    n, m = int(rng.integers(1, 4)), 5
    root = rng.normal(size=(2 * n, 2 * n))
    if kind == "singular":
        root[:, : int(rng.integers(1, 2 * n))] = 0.0
    if kind == "sparse":
        root[rng.random((2 * n, 2 * n)) < 0.5] = 0.0
    if kind == "whole":
        root = rng.integers(-2, 3, (2 * n, 2 * n)).astype(float)
    kappa = root @ root.T
    if kind == "uncoupled":
        kappa[:n, n:] = kappa[n:, :n] = 0.0
    f = rng.uniform(2.0, 20.0, n) if kind == "high friction" else rng.uniform(0.1, 0.9, n)
    if kind == "whole":
        f = np.full(n, 0.5)
    q, p = rng.normal(size=(m, n)), rng.normal(size=(m, n)) + 4.0
    if kind == "whole":
        q, p = np.round(4 * q) / 4, np.round(4 * p) / 4
    C = None if rng.random() < 0.2 else kappa[n:, n:]
    return Problem(
        A=kappa[:n, :n], B=kappa[n:, :n], C=C, f=f, q_w=q, p_w=p, q_mean=q[0] / 4, p_mean=np.full(n, 4.0)
    )


class Said(NamedTuple):
    """Words that must be equal, numbers that must agree; of these some to the last digits in other units."""

    words: tuple[object, ...]
    numbers: tuple[float, ...] = ()
    exact: tuple[float, ...] = ()


def bounds_said(problem: Problem) -> Said:
    """Both bounds and the guarantee."""
    lower, upper = shakedown.lower_bound(problem), shakedown.upper_bound(problem)
    words = (str(lower.status), str(lower.guarantee), str(upper.status))
    exact = (lower.load_factor, upper.load_factor)
    return Said(words, (*exact, lower.coupling_ratio), exact)


def outcome_said(problem: Problem, load_factor: float) -> Said:
    """What becomes of the joint from zero slip."""
    run = shakedown.simulate(problem, load_factor, cycles=60)
    return Said((run.outcome.value, run.period))
