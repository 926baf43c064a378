"""Problems that several studies share: random ones with a unique evolution, refined loops."""

from dataclasses import replace

import numpy as np

from shakedown.problem import FloatArray, Problem


def random_problem(n: int, seed: int, *, m: int = 24, coupling: float = 0.5, f: float = 0.4) -> Problem:
    """A system with κ positive definite whose friction stays below the thresholds of uniqueness.

    The mean pressure is large enough for every node to stay in contact near the
    bounds; the loop is smooth and its tangential part has a phase per node.
    """
    generator = np.random.default_rng(seed)
    half = generator.normal(size=(n, n)) / np.sqrt(n)
    A = half @ half.T + 2.0 * np.eye(n)
    # Rows of B far below those of A keep every A ± f B diagonally safe.
    B = coupling * generator.uniform(-1.0, 1.0, (n, n)) / np.sqrt(n)
    C = 4.0 * np.eye(n) + half.T @ half
    t = np.arange(m)[:, None] / m
    phase, size = generator.uniform(0, 1, n), generator.uniform(0.5, 1.5, n)
    q_w = generator.normal(size=n) * 0.2 + size * np.cos(2 * np.pi * (t - phase))
    p_w = 5.0 + 0.5 * np.sin(2 * np.pi * (t + generator.uniform(0, 1, n)))
    return Problem(A=A, B=B, C=C, f=f, q_w=q_w, p_w=p_w, name=f"random, n = {n}, seed {seed}")


def refined(problem: Problem, parts: int) -> Problem:
    """The same piecewise linear loop with every load step split into ``parts``."""
    return replace(
        problem,
        q_w=_split(problem.q_w, parts),
        p_w=_split(problem.p_w, parts),
        q_mean=problem.q_w.mean(axis=0) if problem.q_mean is None else problem.q_mean,
        p_mean=problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean,
    )


def _split(samples: FloatArray, parts: int) -> FloatArray:
    following = np.roll(samples, -1, axis=0)
    share = np.arange(parts)[None, :, None] / parts
    split = samples[:, None] * (1 - share) + following[:, None] * share
    return split.reshape(len(samples) * parts, samples.shape[1])
