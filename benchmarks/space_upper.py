"""λ_max with two tangential directions: time and error against the number of nodes, beside Clarabel."""

import resource
from functools import cache

import cvxpy as cp
import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.timing import in_turn
from shakedown import Problem
from shakedown.bounds.independent_solver import conic_upper_bound
from shakedown.joint.constraints import constraints
from shakedown.report.text_table import table

TITLE = "Upper bound in space: time and error against the number of nodes"
METHODS = ("shakedown", "shakedown, enclosed", "Clarabel, v", "cvxpy + Clarabel, v")
PEERS_UP_TO = 100  # nodes; beyond, programs with a full row of slips for every disc take minutes
LARGEST_RANDOM = 256  # nodes
STEPS, POISSON, FRICTION = 20, 0.3, 0.5
MEAN_OF_INVERSE_DISTANCE = 3.5255  # over a square of side 1, from its centre


def cases(short: bool) -> list[dict]:
    grids = ((3, 3), (5, 5)) if short else ((5, 5), (10, 10), (16, 16), (28, 25))
    return [
        {"joint": joint, "grid": list(grid), "method": method}
        for grid in grids
        for joint in ("half-space", "random")
        for method in METHODS
        if grid[0] * grid[1] <= PEERS_UP_TO or method in METHODS[:2]
        if grid[0] * grid[1] <= LARGEST_RANDOM or joint == "half-space"
    ]


def measure(case: dict) -> dict:
    problem = joint_of(case["joint"], tuple(case["grid"]))
    peers = {
        "shakedown": lambda: shakedown.upper_bound(problem, certify=False).load_factor,
        "shakedown, enclosed": lambda: shakedown.upper_bound(problem).load_factor,
        "Clarabel, v": lambda: conic_upper_bound(problem).load_factor,
        "cvxpy + Clarabel, v": lambda: through_cvxpy(problem),
    }
    methods = dict.fromkeys([case["method"], "shakedown"])
    timed = in_turn(*(peers[method] for method in methods), runs=1 if problem.n > PEERS_UP_TO else 3)
    (seconds, value), own_seconds = timed[0], timed[-1][0]
    low, high = enclosure_of(case["joint"], tuple(case["grid"]))
    return {
        "n": problem.n,
        "discs": len(constraints(problem).heads) if problem.n <= PEERS_UP_TO else None,
        "seconds": seconds,
        "relative": seconds / own_seconds,
        "error": max(low - value, value - high, 0.0) / low if np.isfinite(value) else None,
        "width": (high - low) / low,
        "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
    }


def through_cvxpy(problem: Problem) -> float:
    """The program as it stands: one unknown slip, |q| ≤ f p at every extreme load step."""
    rows = constraints(problem)
    v, load_factor = cp.Variable(rows.n), cp.Variable()
    s = rows.g - rows.G @ v - load_factor * rows.d
    limits = [cp.SOC(s[::3], cp.vstack([s[1::3], s[2::3]])), load_factor >= 0]
    program = cp.Problem(cp.Maximize(load_factor), limits)
    try:
        program.solve(solver="CLARABEL")
    except cp.SolverError:
        return float("nan")
    return float(program.value) if program.status == "optimal" else float("nan")


@cache
def enclosure_of(name: str, grid: tuple[int, int]) -> tuple[float, float]:
    low, high = shakedown.upper_bound(joint_of(name, grid)).certified
    return low, high


@cache
def joint_of(name: str, grid: tuple[int, int]) -> Problem:
    return half_space(*grid) if name == "half-space" else random_joint(grid[0] * grid[1])


def half_space(columns: int, rows: int) -> Problem:
    """A rigid punch on an elastic half-space, pressed, sheared, rocked and turned; Boussinesq and Cerruti.

    One square element of side 1 and shear modulus 1 per node: point loads for all others, the mean over the
    square for its own.
    """
    x = np.stack(np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"), axis=-1).reshape(-1, 2)
    n, apart = len(x), (x[:, None] - x[None]).astype(float)
    inverse = 1.0 / np.where(np.eye(n, dtype=bool), 1.0, np.hypot(apart[..., 0], apart[..., 1]))
    own, nu = MEAN_OF_INVERSE_DISTANCE, POISSON
    along = nu * np.einsum("ijk,ijl,ij->ikjl", apart, apart, inverse**3)
    for k in range(2):
        direct = (1 - nu) * inverse
        np.fill_diagonal(direct, own * (1 - nu / 2))
        along[:, k, :, k] += direct
    normal = (1 - nu) * inverse
    np.fill_diagonal(normal, own * (1 - nu))
    coupled = -(1 - 2 * nu) / 2 * np.einsum("ijk,ij->ikj", apart, inverse**2).reshape(2 * n, n)
    compliance = np.block([[along.reshape(2 * n, 2 * n), coupled], [coupled.T, normal]]) / (2 * np.pi)
    kappa = np.linalg.inv(compliance)
    kappa = 0.5 * (kappa + kappa.T)
    t = 2 * np.pi * np.arange(STEPS) / STEPS
    cx, cy = (x - x.mean(axis=0)).T / max(columns, rows)
    turn, rock, tilt = (a[:, None] for a in (0.1 * np.sin(2 * t), 0.2 * np.sin(t), 0.1 * np.cos(t + 1.0)))
    sheared = np.stack([0.3 * np.cos(t) + 0.05 * np.cos(2 * t), 0.2 * np.sin(t + 0.3)], axis=1)
    slips = sheared[:, None, :] + np.stack([-turn * cy, turn * cx], axis=-1)
    gaps = 1.0 + 0.1 * np.cos(t)[:, None] + rock * cy - tilt * cx
    reactions = np.concatenate([slips.reshape(STEPS, -1), gaps], axis=1) @ kappa
    return _problem(kappa, reactions, np.full(n, FRICTION))


def random_joint(n: int) -> Problem:
    """Every node coupled with every other, at random."""
    rng = np.random.default_rng(n)
    root = rng.normal(size=(3 * n, 3 * n))
    t = 2 * np.pi * np.arange(STEPS)[:, None] / STEPS
    first, second = rng.normal(size=(2, 3 * n))
    reactions = first * np.cos(t) + second * np.sin(t) + np.repeat([0.0, 4.0], [2 * n, n])
    return _problem(root @ root.T / (3 * n) + 0.3 * np.eye(3 * n), reactions, rng.uniform(0.2, 0.9, n))


def _problem(kappa: np.ndarray, reactions: np.ndarray, f: np.ndarray) -> Problem:
    k = 2 * len(f)
    blocks = {"A": kappa[:k, :k], "B": kappa[k:, :k], "C": kappa[k:, k:]}
    return Problem(**blocks, f=f, q_w=reactions[:, :k], p_w=reactions[:, k:])


def tables(rows: list[dict]) -> str:
    by = {(r["joint"], r["n"], r["method"]): r for r in rows}
    lines = []
    for joint, n in dict.fromkeys((r["joint"], r["n"]) for r in rows):
        own = [by[joint, n, method] for method in METHODS if (joint, n, method) in by]
        cells = [_cell(by.get((joint, n, method))) for method in METHODS]
        memory = max(row["megabytes"] for row in own)
        lines.append([joint, str(n), *cells, f"{own[0]['width']:.0e}", f"{memory:.0f}"])
    head = ["joint", "n", *METHODS, "width", "MB"]
    return (
        "time [s] (× the toolkit without enclosure) and relative distance from the enclosure:\n"
        + table(head, lines)
        + "\n\nWidth: of the enclosure, relative. MB: the most that the process has held so far."
    )


def _cell(row: dict | None) -> str:
    if row is None:
        return "-"
    error = "no answer" if row["error"] is None else f"{row['error']:.0e}" if row["error"] else "within"
    return f"{row['seconds']:.3g} (x{row['relative']:.3g}) {error}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(6, 4))
    axes = figure.subplots()
    for method in METHODS:
        own = [r for r in rows if r["method"] == method and r["joint"] == "half-space"]
        axes.loglog([r["n"] for r in own], [r["seconds"] for r in own], "o-", label=method)
    axes.set_xticks(sorted({row["n"] for row in rows if row["joint"] == "half-space"}))
    axes.set_xticks([], minor=True)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set(xlabel="nodes", ylabel="time [s]", title=TITLE)
    axes.legend()
    return {"space_upper": figure}
