"""The same joint in other words: units, labels, the other direction, another start of the loop."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from shakedown import Problem

Change = Callable[[Problem, np.random.Generator], Problem]


def other_forces(problem: Problem, rng: np.random.Generator) -> Problem:
    """Stiffness and loads times a power of two: slips and load factors stay as they are."""
    return _scaled(problem, stiffness=(k := 2.0 ** int(rng.integers(-60, 61))), force=k)


def other_lengths(problem: Problem, rng: np.random.Generator) -> Problem:
    """Lengths times a power of two, forces as they are."""
    return _scaled(problem, stiffness=2.0 ** int(rng.integers(-60, 61)), force=1.0)


def other_labels(problem: Problem, rng: np.random.Generator) -> Problem:
    """The nodes in another order."""
    at = rng.permutation(problem.n)
    square = {key: getattr(problem, key)[np.ix_(at, at)] for key in _present(problem, "A", "B", "C")}
    rows = {key: getattr(problem, key)[..., at] for key in _present(problem, "f", *LOADS)}
    return replace(problem, **square, **rows)


def other_direction(problem: Problem, _: np.random.Generator) -> Problem:
    """Slip and tangential force counted the other way."""
    tangential = {key: -getattr(problem, key) for key in _present(problem, "q_w", "q_mean")}
    return replace(problem, B=-problem.B, **tangential)


def other_start(problem: Problem, rng: np.random.Generator) -> Problem:
    """The period begins at another load step."""
    k = int(rng.integers(1, problem.m))
    return replace(problem, q_w=np.roll(problem.q_w, k, axis=0), p_w=np.roll(problem.p_w, k, axis=0))


def backwards(problem: Problem, _: np.random.Generator) -> Problem:
    """The loop is run through the other way round."""
    return replace(problem, q_w=problem.q_w[::-1], p_w=problem.p_w[::-1])


LOADS = ("q_w", "p_w", "q_mean", "p_mean")
SAME_EVOLUTION: Mapping[str, Change] = {
    change.__name__: change for change in (other_forces, other_lengths, other_labels, other_direction)
}
SAME_BOUNDS: Mapping[str, Change] = SAME_EVOLUTION | {
    change.__name__: change for change in (other_start, backwards)
}
EXACT = ("other_forces", "other_lengths")  # powers of two change no mantissa


def _scaled(problem: Problem, *, stiffness: float, force: float) -> Problem:
    matrices = {key: stiffness * getattr(problem, key) for key in _present(problem, "A", "B", "C")}
    return replace(
        problem, **matrices, **{key: force * getattr(problem, key) for key in _present(problem, *LOADS)}
    )


def _present(problem: Problem, *keys: str) -> list[str]:
    return [key for key in keys if getattr(problem, key) is not None]
