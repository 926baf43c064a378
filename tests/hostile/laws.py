"""The same joint in other words: units, labels, the other direction, another start of the loop."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from benchmarks.problems import in_units
from shakedown import Problem
from shakedown.joint.units import without_loads

Change = Callable[[Problem, np.random.Generator], Problem]


def other_units(problem: Problem, rng: np.random.Generator) -> Problem:
    """Forces and lengths times powers of two, and energies, whose roots are taken, times an even one."""
    one, other = rng.integers(-30, 31, 2)
    return in_units(problem, 2.0 ** (one + other), 2.0 ** (one - other))


def other_labels(problem: Problem, rng: np.random.Generator) -> Problem:
    """The nodes in another order."""
    at = rng.permutation(problem.n)
    slips = problem.layout.slips_of(at)
    places = {"A": (slips, slips), "B": (at, slips), "C": (at, at)}
    square = {key: getattr(problem, key)[np.ix_(*places[key])] for key in _present(problem, *places)}
    rows = {key: getattr(problem, key)[..., at] for key in _present(problem, "f", *NORMAL)}
    slipping = {key: getattr(problem, key)[..., slips] for key in _present(problem, *TANGENTIAL)}
    return replace(problem, **square, **rows, **slipping)


def other_direction(problem: Problem, _: np.random.Generator) -> Problem:
    """Slip and tangential force counted the other way."""
    return replace(
        problem, B=-problem.B, **{key: -getattr(problem, key) for key in _present(problem, *TANGENTIAL)}
    )


def other_tangents(problem: Problem, rng: np.random.Generator) -> Problem:
    """The two tangents of every node turned by an angle of its own, and one in two mirrored."""
    turn = np.zeros((2 * problem.n, 2 * problem.n))
    for node in range(problem.n):
        angle, side = rng.uniform(0, 2 * np.pi), rng.choice([-1.0, 1.0])
        place = problem.layout.slips_of([node])
        turn[np.ix_(place, place)] = [
            [np.cos(angle), np.sin(angle)],
            [-side * np.sin(angle), side * np.cos(angle)],
        ]
    slipping = {key: getattr(problem, key) @ turn.T for key in _present(problem, *TANGENTIAL)}
    A = turn @ problem.A @ turn.T
    return replace(problem, A=(A + A.T) / 2, B=problem.B @ turn.T, tangents=None, **slipping)


def other_origin(problem: Problem, rng: np.random.Generator) -> Problem:
    """Slips counted from another state, whose reactions are in the loads."""
    size = np.abs(problem.q_w).max() / np.abs(problem.A).max()
    slip = size * rng.normal(size=problem.layout.slip_size)
    moved = {key: getattr(problem, key) - problem.A @ slip for key in _present(problem, *TANGENTIAL[:3])}
    moved |= {key: getattr(problem, key) - problem.B @ slip for key in _present(problem, *NORMAL)}
    if problem.initial_slip is not None:
        moved["initial_slip"] = problem.initial_slip + slip
    return replace(without_loads(problem), **moved)


def other_start(problem: Problem, rng: np.random.Generator) -> Problem:
    """The period begins at another load step."""
    k = int(rng.integers(1, problem.m))
    return replace(problem, q_w=np.roll(problem.q_w, k, axis=0), p_w=np.roll(problem.p_w, k, axis=0))


def backwards(problem: Problem, _: np.random.Generator) -> Problem:
    """The loop is run through the other way round."""
    return replace(problem, q_w=problem.q_w[::-1], p_w=problem.p_w[::-1])


TANGENTIAL = ("q_w", "q_mean", "q_transient", "initial_slip")
NORMAL = ("p_w", "p_mean", "p_transient")
SAME_EVOLUTION: Mapping[str, Change] = {
    change.__name__: change for change in (other_units, other_labels, other_direction)
}
SAME_BOUNDS: Mapping[str, Change] = SAME_EVOLUTION | {
    change.__name__: change for change in (other_origin, other_start, backwards)
}
EXACT = "other_units"  # powers of two change no mantissa
SAME_IN_SPACE: Mapping[str, Change] = {
    change.__name__: change for change in (other_units, other_labels, other_tangents, other_origin, backwards)
}


def _present(problem: Problem, *keys: str) -> list[str]:
    return [key for key in keys if getattr(problem, key) is not None]
