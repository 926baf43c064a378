"""Look for a way in which nodes slip farther than the accumulated slip that is proved of them.

Joints from ``drawn_joints`` (floating, anisotropic, with transients, with means of their own, friction
above thresholds) at λ_S itself, from slip zero, from random slips that the first load need not admit,
and from slips off by ε. The adversary may do more than any motion: a node moves along *any* direction u
with g_i(u) ≤ 0, under any load of the hull, by any part of the way to its limit, in any order. A run in which
a node goes farther than its bound, or one is relieved of its pressure while it slips, refutes the theorem
(docs/accumulated.md). At 1.3 λ_S, the control, many do.
"""

import os

import numpy as np
from numpy.typing import NDArray

import shakedown
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading
from shakedown.report.facts import table

TITLE = "Slip in any direction and any order of the loads, against the accumulated slip that is proved"
STARTS = ("zero", "random", "off")
MOVES, RAMP = 300, 20  # how often each run may move, and load steps of the rise to the first load
ABOVE = 1.3  # times λ_S: the control
OFF = 0.01  # of the slips that the loads cause: how far nodes are from the start
BEYOND = 1e-6  # of the largest bound, that counts as farther

KEYS = ("joints", "runs", "inadmissible", "farther", "relieved", "controls", "controls_farther")


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

    def move(self, loads: FloatArray, node: NDArray[np.intp]) -> None:
        """Every run moves its node (r,) under its load (r, (d + 1) n), where that is beyond its limit."""
        problem, runs = self.problem, np.arange(len(self.slip))
        q, p = problem.layout.split(loads)
        q = problem.layout.by_node(q + self.slip @ problem.A.T)[runs, node]
        p = problem.f[node] * (p + self.slip @ problem.B.T)[runs, node]
        u = self._direction(q, p)
        slack = p + np.sum(u * q, axis=1)
        A = problem.A.reshape(problem.n, problem.directions, problem.n, problem.directions)[node, :, node]
        B = problem.layout.by_node(problem.B)[node, node]
        own = problem.f[node] * np.sum(B * u, axis=1) + np.einsum("ri,rij,rj->r", u, A, u)
        part = np.where(self.rng.random(len(u)) < 0.7, 1.0, self.rng.random(len(u)))
        beyond = slack < 0.0
        far = np.where(beyond, -slack / np.where(own > 0.0, own, 1.0) * part, 0.0)
        problem.layout.by_node(self.slip)[runs, node] += far[:, None] * u
        self.way[runs, node] += np.where(beyond & (own <= 0.0), np.inf, far)
        after = p + problem.f[node] * np.sum(B * u, axis=1) * far
        self.relieved |= beyond & (part == 1.0) & (after <= 0.0)

    def _direction(self, q: FloatArray, limit: FloatArray) -> FloatArray:
        """Some direction u with limit + u · q < 0 of reactions (r, d), where there is one."""
        size = np.linalg.norm(q, axis=1)
        u = -q / np.where(size > 0.0, size, 1.0)[:, None]
        if q.shape[1] == 1:
            return u
        widest = np.arccos(np.clip(limit / np.where(size > 0.0, size, 1.0), -1.0, 1.0))
        turn = widest * self.rng.uniform(-1.0, 1.0, len(q)) * (self.rng.random(len(q)) < 0.7)
        cosine, sine = np.cos(turn), np.sin(turn)
        return np.stack([cosine * u[:, 0] - sine * u[:, 1], sine * u[:, 0] + cosine * u[:, 1]], axis=1)


def cases(short: bool) -> list[dict]:
    """ACCUMULATED_BATCHES of each kind, 1 by default."""
    batches = 1 if short else int(os.environ.get("ACCUMULATED_BATCHES", "1"))
    joints, runs = (2, 10) if short else (40, 100)
    return [
        {"directions": d, "start": start, "joints": joints, "runs": runs, "seed": seed}
        for seed in range(batches)
        for d in (1, 2)
        for start in STARTS
    ]


def measure(case: dict) -> dict:
    """One kind of start: how many runs there were, and how they ended."""
    rng = np.random.default_rng([case["seed"], case["directions"], STARTS.index(case["start"])])
    counts, largest, number = dict.fromkeys(KEYS, 0), 0.0, 0
    while counts["joints"] < case["joints"]:
        problem = (drawn_joint, drawn_joint_in_space)[case["directions"] - 1](case["seed"], number)
        number += 1
        size = np.abs(loading(problem).q1).max() / np.abs(problem.A).max() if problem.A.any() else 0.0
        start = size * rng.normal(size=problem.layout.slip_size) * (case["start"] == "random")
        error = OFF * size * (case["start"] == "off")
        bound = shakedown.accumulated_bound(problem, start, start_error=error)
        if bound.status != "optimal" or not bound.total_slip.max() > 0.0:
            continue
        counts["joints"] += 1
        begin = started(rng, problem, start, error, case["runs"])
        ended = followed(rng, problem, bound.load_factor, begin)
        above = followed(rng, problem, ABOVE * bound.load_factor, begin)
        counts["runs"] += case["runs"]
        counts["inadmissible"] += int(inadmissible(problem, bound.load_factor, begin).sum())
        counts["farther"] += int(farther(ended, bound.total_slip).sum())
        counts["relieved"] += int(ended.relieved.sum())
        counts["controls"] += case["runs"]
        counts["controls_farther"] += int((farther(above, bound.total_slip) | above.relieved).sum())
        with np.errstate(invalid="ignore", divide="ignore"):
            largest = max(largest, float(np.nanmax(ended.way / bound.total_slip)))
    return counts | {"largest": largest}


def started(
    rng: np.random.Generator, problem: Problem, start: FloatArray, error: float, runs: int
) -> FloatArray:
    """Slips (r, dn) at a start, every node up to an error away, half of them as far as can be."""
    away = rng.normal(size=(runs, problem.n, problem.directions))
    away *= error / np.linalg.norm(away, axis=2, keepdims=True)
    away[runs // 2 :] *= rng.random((runs - runs // 2, problem.n, 1))
    return start + away.reshape(runs, -1)


def loads_in_order(problem: Problem, load_factor: float) -> FloatArray:
    """The welded reactions (k, (d + 1) n) of the transient, of the loop and of the mean load."""
    layout, loop = problem.layout, loading(problem)
    loads = np.vstack([layout.joined(*loop.at(load_factor)), layout.joined(loop.q0, loop.p0)])
    if problem.q_transient is None:
        return loads
    return np.vstack([layout.joined(problem.q_transient, problem.p_transient), loads])


def inadmissible(problem: Problem, load_factor: float, slips: FloatArray) -> FloatArray:
    """Whether the first load does not admit slips (r, dn), (r,)."""
    q, p = problem.layout.split(loads_in_order(problem, load_factor)[0])
    return np.any(problem.law.excess(q + slips @ problem.A.T, p + slips @ problem.B.T) > 0.0, axis=1)


def followed(rng: np.random.Generator, problem: Problem, load_factor: float, slips: FloatArray) -> Runs:
    """Runs from slips (r, dn): the load rises to its first step, then goes anywhere in the hull of all."""
    runs, n = Runs(rng, problem, slips), problem.n
    corners = loads_in_order(problem, load_factor)
    first, locked_p = corners[0], slips @ problem.B.T
    pressed = np.abs(problem.layout.split(first)[1] + locked_p)
    low = problem.layout.joined(-slips @ problem.A.T, pressed - locked_p)
    with np.errstate(over="ignore", invalid="ignore"):
        for s in np.linspace(0.0, 1.0, RAMP):
            for _ in range(2):
                loads = (1.0 - s) * low + s * first
                runs.move(loads, at_random(rng, runs.excess(loads)))
        for number in range(MOVES):
            if number % 2:
                excess = runs.excess(corners[None])
                if not np.any(excess > 0.0):
                    break
                step, node = np.divmod(at_random(rng, excess.reshape(len(slips), -1)), n)
                runs.move(corners[step], node)
            else:
                weight = rng.exponential(size=(len(slips), len(corners))) ** 4
                loads = weight / weight.sum(axis=1, keepdims=True) @ corners
                runs.move(loads, at_random(rng, runs.excess(loads)))
    return runs


def at_random(rng: np.random.Generator, excess: FloatArray) -> NDArray[np.intp]:
    """The number of one that is positive in every row (r, k), at random; any where none is."""
    return np.argmax(rng.random(excess.shape) + (excess > 0.0), axis=1)


def farther(runs: Runs, bound: FloatArray) -> NDArray[np.bool_]:
    """Whether some node has gone farther than it can, (r,)."""
    return ~np.all(runs.way <= bound + BEYOND * bound.max(), axis=1)


def tables(rows: list[dict]) -> str:
    """Per number of directions and kind of start."""
    lines = []
    for d, start in dict.fromkeys((row["directions"], row["start"]) for row in rows):
        chosen = [row for row in rows if (row["directions"], row["start"]) == (d, start)]
        sums = [str(sum(row[key] for row in chosen)) for key in KEYS]
        lines.append([str(d), start, *sums, f"{max(row['largest'] for row in chosen):.4f}"])
    return table(["d", "start", *(key.replace("_", " ") for key in KEYS), "largest way / bound"], lines)


def figures(rows: list[dict]) -> dict:
    return {}
