"""λ_E and R(λ) with two tangential directions: how much the split gains, the time, a second method.

Without the split (c = 0), with half of A_ii⁻¹ B_ii, and with the best shares (``split=True``), relative to
λ_max: built-in joints, bricks on a rigid plane, random joints. The second method is the plain statement of
the program, a cone per node and load step in raw slips, by Clarabel through cvxpy; times are those of the
processor, in one process by turns.
"""

import time
import warnings
from math import isfinite

import numpy as np
from numpy.typing import ArrayLike

import shakedown
from benchmarks.display import listed
from benchmarks.refinement import brick
from benchmarks.space_verdicts import random_joint
from shakedown import Problem, energy_ball, energy_bound
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading

TITLE = "The energy ball in space: what the split gains, what it costs, and a second method"
BUILT_IN = ("one-node-3d", "two-node-3d", "four-node-3d", "block-3x3")
PLAIN_UP_TO = 121  # nodes of the second method
HALF = 0.5


def cases(short: bool) -> list[dict]:
    built_in = BUILT_IN[:2] if short else BUILT_IN
    grids = (4,) if short else (4, 6, 10, 14)
    seeds = 2 if short else 20
    return [
        *({"study": "built-in", "joint": name} for name in built_in),
        *({"study": "block", "elements": k, "friction": f} for k in grids for f in (0.3, 0.5)),
        *({"study": "random", "nodes": n, "seed": seed} for n in (2, 5, 8) for seed in range(seeds)),
    ]


def measure(case: dict) -> dict:
    if case["study"] == "random":
        return sharpness(random_joint(np.random.default_rng(case["seed"]), "held", case["nodes"]))
    if case["study"] == "block":
        return sharpness(brick(case["elements"], case["friction"]))
    return sharpness(shakedown.example(case["joint"]))


def sharpness(problem: Problem) -> dict:
    """λ_E without and with the split, and by the second method, relative to λ_max; times [s]."""
    upper = shakedown.upper_bound(problem, certify=False).load_factor
    row: dict = {"nodes": problem.n, "upper": upper if isfinite(upper) else None}
    for name, split in (("zero", False), ("split", True)):
        bound, seconds = timed(lambda split=split: energy_bound(problem, split=split, certify=False))
        row |= {
            name: _finite(bound.load_factor / upper),
            f"{name}_s": seconds,
            f"{name}_gap": _finite(bound.gap),
        }
        ball = energy_ball(problem, HALF * upper, split=split) if isfinite(upper) else None
        row[f"{name}_radius"] = None if ball is None else _finite(ball.radius)
    if problem.n <= PLAIN_UP_TO:
        for name, share in (("plain", 0.0), ("half", HALF)):
            found, seconds = timed(lambda share=share: plainly(problem, share * own_shares(problem)))
            row |= {name: _finite(found / upper), f"{name}_s": seconds}
    return row


def _finite(number: float) -> float | None:
    return number if isfinite(number) else None


def timed(work) -> tuple:
    begin = time.process_time()
    return work(), time.process_time() - begin


def plainly(
    problem: Problem,
    share: FloatArray | None = None,
    *,
    start: ArrayLike = 0.0,
    distance: float = 0.0,
    load_factor: float | None = None,
    least: bool = False,
) -> float:
    """λ_E from a slip, the largest or the least, or the largest radius at a load factor; NaN without one.

    With these shares (n, d), by default the own ones, and a cone each load step.
    """
    import cvxpy as cp

    n, d, loop, f = problem.n, problem.directions, loading(problem), problem.f
    force, stiffness = float(np.abs(problem.p_w).max()), float(np.abs(problem.A).max())
    A, B, unit = problem.A / stiffness, problem.B / stiffness, force / np.sqrt(stiffness)
    share = own_shares(problem) if share is None else share
    rest = B - np.einsum("ij,ijk->ik", share, A.reshape(n, d, -1))
    values, vectors = np.linalg.eigh(A)
    kept = values > 1e-9 * values[-1]
    root = (vectors[:, kept] * np.sqrt(values[kept])).T
    gamma = np.linalg.norm(rest @ (vectors[:, kept] / np.sqrt(values[kept])), axis=1)
    stretch = np.ones(n) if d == 1 else np.sqrt(1 + f**2 * (share**2).sum(axis=1))
    v, radius, factor = cp.Variable(d * n), cp.Variable(nonneg=True), cp.Variable(nonneg=True)
    way = v - np.asarray(start) * stiffness / force
    limits = [
        cp.norm(root @ way) + distance / unit <= radius if load_factor is None else factor == load_factor
    ]
    q, p = loop.q0 / force + A @ v, loop.p0 / force + B @ v
    for q1, p1 in zip(loop.q1 / force, loop.p1 / force, strict=True):
        drawn = cp.reshape(q + factor * q1, (d, n), order="F") @ np.diag(stretch)
        limits.append(cp.SOC(cp.multiply(f, p + factor * p1 - gamma * radius), drawn))
    aim = radius if load_factor is not None else -factor if least else factor
    task = cp.Problem(cp.Maximize(aim), limits)
    with warnings.catch_warnings():  # "may be inaccurate"
        warnings.simplefilter("ignore", UserWarning)
        try:
            task.solve(solver="CLARABEL")
        except cp.SolverError:
            return np.nan
    known = task.status in ("optimal", "optimal_inaccurate")
    return float(abs(aim.value)) * (1.0 if load_factor is None else unit) if known else np.nan


def own_shares(problem: Problem) -> FloatArray:
    """A_ii⁻¹ B_ii of every node, (n, d)."""
    n, d, nodes = problem.n, problem.directions, np.arange(problem.n)
    blocks = problem.A.reshape(n, d, n, d)[nodes, :, nodes, :]
    return np.linalg.solve(blocks, problem.B.reshape(n, n, d)[nodes, nodes][..., None])[..., 0]


def tables(rows: list[dict]) -> str:
    columns = {
        "joint": lambda row: row.get("joint") or " ".join(str(row[key]) for key in list(row)[:3]),
        "n": "{nodes}", "λ_E/λ_max: c = 0": "{zero:.4f}", "half": "{half:.4f}", "split": "{split:.4f}",
        "R: split/0": _grown, "0, s": "{zero_s:.2g}", "split, s": "{split_s:.2g}",
        "plain, s": "{plain_s:.2g}", "0 − plain": _apart,
    }  # fmt: skip
    return listed(rows, columns)


def _grown(row: dict) -> str:
    """The radius with the split, in units of that without it."""
    both = row["split_radius"], row["zero_radius"]
    return f"{both[0] / both[1]:.2f}" if all(both) else "-"


def _apart(row: dict) -> str:
    both = row["zero"], row.get("plain")
    return "-" if None in both else f"{both[0] - both[1]:.0e}"
