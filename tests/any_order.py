"""Joints whose nodes slip in any direction, by any part of the way, under any loads in any order."""

import numpy as np
from numpy.typing import NDArray

from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading

MOVES, RAMP = 300, 20  # how often each run may move, and load steps of the rise to the first load


class Runs:
    """Many runs of one joint: slips (r, dn), how far nodes have gone (r, n), whether p ≤ 0 was met (r,)."""

    def __init__(self, rng: np.random.Generator, problem: Problem, slip: FloatArray) -> None:
        self.rng, self.problem, self.slip = rng, problem, slip.copy()
        self.way = np.zeros((len(slip), problem.n))
        self.relieved = np.zeros(len(slip), dtype=bool)

    def excess(self, loads: FloatArray) -> FloatArray:
        """|q| − f p of every node under welded reactions (r or 1, …, (d + 1) n)."""
        problem = self.problem
        q, p = problem.layout.split(loads)
        wider = (len(self.slip), *[1] * (loads.ndim - 2), -1)
        q = q + (self.slip @ problem.A.T).reshape(wider)
        return problem.law.excess(q, p + (self.slip @ problem.B.T).reshape(wider))

    def move(self, loads: FloatArray, excess: FloatArray) -> None:
        """Every run moves a node beyond its limit (r, n) under its load (r, (d + 1) n), where there is one."""
        problem, runs, node = self.problem, np.arange(len(self.slip)), self.at_random(excess)
        q, p = problem.layout.split(loads)
        q = problem.layout.by_node(q + self.slip @ problem.A.T)[runs, node]
        p = problem.f[node] * (p + self.slip @ problem.B.T)[runs, node]
        u = self._direction(q, p)
        slack = p + np.sum(u * q, axis=1)
        A = problem.A.reshape(problem.n, problem.directions, problem.n, problem.directions)[node, :, node]
        coupled = problem.f[node] * np.sum(problem.layout.by_node(problem.B)[node, node] * u, axis=1)
        own = coupled + np.einsum("ri,rij,rj->r", u, A, u)
        part = np.where(self.rng.random(len(u)) < 0.7, 1.0, self.rng.random(len(u)))
        beyond = slack < 0.0
        far = np.where(beyond, -slack / np.where(own > 0.0, own, 1.0) * part, 0.0)
        problem.layout.by_node(self.slip)[runs, node] += far[:, None] * u
        self.way[runs, node] += np.where(beyond & (own <= 0.0), np.inf, far)
        self.relieved |= beyond & (part == 1.0) & (p + coupled * far <= 0.0)

    def at_random(self, excess: FloatArray) -> NDArray[np.intp]:
        """The number of one that is positive in every row (r, k), at random; any where none is."""
        return np.argmax(self.rng.random(excess.shape) + (excess > 0.0), axis=1)

    def _direction(self, q: FloatArray, limit: FloatArray) -> FloatArray:
        """Some direction u with limit + u · q < 0 of reactions (r, d), where there is one."""
        size = np.linalg.norm(q, axis=1)
        size = np.where(size > 0.0, size, 1.0)
        u = -q / size[:, None]
        if q.shape[1] == 1:
            return u
        widest = np.arccos(np.clip(limit / size, -1.0, 1.0))
        turn = widest * self.rng.uniform(-1.0, 1.0, len(q)) * (self.rng.random(len(q)) < 0.7)
        cosine, sine = np.cos(turn), np.sin(turn)
        return np.stack([cosine * u[:, 0] - sine * u[:, 1], sine * u[:, 0] + cosine * u[:, 1]], axis=1)


def loads_in_order(problem: Problem, load_factor: float) -> FloatArray:
    """The welded reactions (k, (d + 1) n) of the transient, of the loop and of the mean load."""
    layout, loop = problem.layout, loading(problem)
    loads = np.vstack([layout.joined(*loop.at(load_factor)), layout.joined(loop.q0, loop.p0)])
    if problem.q_transient is None:
        return loads
    return np.vstack([layout.joined(problem.q_transient, problem.p_transient), loads])


def followed(rng: np.random.Generator, problem: Problem, load_factor: float, slips: FloatArray) -> Runs:
    """Runs from slips (r, dn): the load rises to its first step, then goes anywhere in the hull of all."""
    runs, corners = Runs(rng, problem, slips), loads_in_order(problem, load_factor)
    first, locked_p = corners[0], slips @ problem.B.T
    pressed = np.abs(problem.layout.split(first)[1] + locked_p)
    low = problem.layout.joined(-slips @ problem.A.T, pressed - locked_p)
    with np.errstate(over="ignore", invalid="ignore"):
        for s in np.linspace(0.0, 1.0, RAMP).repeat(2):
            loads = (1.0 - s) * low + s * first
            runs.move(loads, runs.excess(loads))
        for _ in range(MOVES // 2):
            weight = rng.exponential(size=(len(slips), len(corners))) ** 4
            loads = weight / weight.sum(axis=1, keepdims=True) @ corners
            runs.move(loads, runs.excess(loads))
            excess = runs.excess(corners[None])
            worst = runs.at_random(excess.max(axis=2))
            runs.move(corners[worst], excess[np.arange(len(slips)), worst])
    return runs
