"""Joints in space that several tests share: random ones, joints of the plane, other units and tangents."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from benchmarks import space_verdicts
from shakedown import Problem
from shakedown.joint.units import without_loads


def random_joint(rng: np.random.Generator, n: int, *, pressure: float = 4.0, m: int = 12) -> Problem:
    """A joint of n nodes with a full stiffness, loaded out of phase in both directions."""
    root = rng.normal(size=(3 * n, 3 * n))
    kappa = root @ root.T / (3 * n) + 0.3 * np.eye(3 * n)
    t = 2 * np.pi * np.arange(m)[:, None] / m
    q_w = (
        rng.normal(size=2 * n) * np.cos(t) + rng.normal(size=2 * n) * np.sin(t) + 0.5 * rng.normal(size=2 * n)
    )
    p_w = pressure + rng.normal(size=n) * np.cos(2 * t) + rng.normal(size=n) * np.sin(t)
    A, B, C = kappa[: 2 * n, : 2 * n], kappa[2 * n :, : 2 * n], kappa[2 * n :, 2 * n :]
    return Problem(A=A, B=B, C=C, f=rng.uniform(0.2, 0.9, n), q_w=q_w, p_w=p_w)


def of_verdicts(kind: str, seed: int, number: int) -> Problem:
    """A joint of the study of verdicts in space: "held", "floating", "stiff and soft" or both."""
    rng = np.random.default_rng([seed, space_verdicts.KINDS.index(kind), number])
    return space_verdicts.random_joint(rng, kind, 4)


def embedded(plane: Problem) -> Problem:
    """A joint of the plane as one in space: nothing happens in the second direction, as stiff as the first."""
    given = {key: getattr(plane, key) for key in ("q_w", "q_mean", "q_transient")}
    along = {key: None if value is None else np.kron(value, [1.0, 0.0]) for key, value in given.items()}
    A, B, transient = np.kron(plane.A, np.eye(2)), np.kron(plane.B, [1.0, 0.0]), plane.p_transient
    pressed = {"p_w": plane.p_w, "p_mean": plane.p_mean, "p_transient": transient}
    return Problem(A=A, B=B, C=plane.C, f=plane.f, **along, **pressed)


def turned(problem: Problem, angles: np.ndarray, mirrored: Iterable[int] = ()) -> tuple[Problem, np.ndarray]:
    """The joint with the tangents of all nodes turned, of some also mirrored, and what turns its slips."""
    T = np.zeros((2 * problem.n, 2 * problem.n))
    for i, angle in enumerate(angles):
        place = slice(2 * i, 2 * i + 2)
        T[place, place] = [[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]
    T[[2 * i + 1 for i in mirrored]] *= -1.0
    vectors = {key: getattr(problem, key) for key in ("q_w", "q_mean", "q_transient", "initial_slip")}
    there = {key: value @ T.T for key, value in vectors.items() if value is not None}
    return replace(without_loads(problem), A=T @ problem.A @ T.T, B=problem.B @ T.T, **there), T


def in_last_bits(problem: Problem, rng: np.random.Generator, size: float = 3e-15) -> Problem:
    """The joint with its numbers changed by random relative amounts of at most this size; A stays symmetric."""
    factors = {
        key: 1.0 + size * rng.uniform(-1.0, 1.0, np.shape(getattr(problem, key)))
        for key in ("A", "B", "f", "q_w", "p_w")
    }
    factors["A"] = 0.5 * (factors["A"] + factors["A"].T)
    return replace(problem, **{key: getattr(problem, key) * factor for key, factor in factors.items()})
