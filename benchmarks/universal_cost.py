"""What least pressures cost and prove, in the plane and in space, beside programs for the same pressures."""

import time

import numpy as np

import shakedown
from benchmarks.problems import chain, random_problem
from shakedown import Problem
from shakedown.bounds.every_state.bound_from_every_state import least_pressure_bound
from shakedown.joint.loading import loading
from shakedown.report.text_table import table

TITLE = "Least pressures: without programs, and by a program per node"
REPEATS = 3
PROGRAMS = 3  # nodes whose least pressure is asked of programs; the time is that of all nodes in proportion
BUILT_IN = ("two-node", "three-node", "one-node-3d", "two-node-3d", "four-node-3d", "block-3x3")


def cases(short: bool) -> list[dict]:
    named = [{"joint": name} for name in BUILT_IN]
    sizes = (10,) if short else (25, 100, 250)
    return [*named, *({"joint": kind, "n": n} for kind in DRAWN for n in sizes)]


def measure(case: dict) -> dict:
    name = case["joint"]
    problem = DRAWN[name](case["n"]) if name in DRAWN else shakedown.example(name)
    work = {
        "pressures": lambda: least_pressure_bound(problem),
        "whole": lambda: shakedown.universal_bound(problem),
        "programs": lambda: by_programs(problem),
    }
    times, found = {name: [] for name in work}, {}
    for _ in range(1 if problem.n > 50 else REPEATS):
        for name, each in work.items():
            begin = time.process_time()
            found[name] = each()
            times[name].append(time.process_time() - begin)
    seconds = {f"{name}_seconds": float(np.median(taken)) for name, taken in times.items()}
    by_cones = found["programs"]
    seconds["programs_seconds"] *= problem.n / len(by_cones)
    miss = np.abs(found["pressures"].pressures[: len(by_cones)] - by_cones) / np.abs(by_cones)
    return seconds | {
        "n": problem.n,
        "pressures": found["pressures"].load_factor,
        "whole": found["whole"].load_factor,
        "difference": float(miss.max()),
    }


def by_programs(problem: Problem) -> np.ndarray:
    """The least pressures of the first nodes under the mean load, each by a program with a cone per node."""
    import cvxpy as cp

    loop, d, v = loading(problem), problem.directions, cp.Variable(len(problem.A))
    q, p = loop.q0 + problem.A @ v, loop.p0 + problem.B @ v
    limits = [cp.SOC(problem.f[i] * p[i], q[d * i : d * (i + 1)]) for i in range(problem.n)]
    nodes = range(min(problem.n, PROGRAMS))
    return np.array([cp.Problem(cp.Minimize(p[i]), limits).solve(solver="CLARABEL") for i in nodes])


def in_space(n: int, seed: int = 0) -> Problem:
    """A joint whose nodes influence each other less the farther they are apart, under a loop in space."""
    rng, m = np.random.default_rng([seed, n]), 24
    place = rng.uniform(0.0, np.sqrt(n), (n, 2))
    apart = np.linalg.norm(place[:, None] - place, axis=2)
    near = np.exp(-apart)
    A = np.kron(near, np.eye(2)) + 0.5 * np.eye(2 * n)
    away = (place[:, None] - place) * np.exp(-2.0 * apart)[..., None]
    t = 2.0 * np.pi * np.arange(m)[:, None] / m
    q_w = rng.normal(size=2 * n) * np.cos(t) + rng.normal(size=2 * n) * np.sin(t + 0.4)
    p_w = rng.uniform(4.0, 6.0, n) + rng.normal(size=n) * np.cos(2.0 * t)
    return Problem(A=A, B=0.4 * away.reshape(n, 2 * n), f=0.4, q_w=q_w, p_w=p_w)


DRAWN = {"chain": chain, "random": lambda n: random_problem(n, 1), "in space": in_space}


def tables(rows: list[dict]) -> str:
    headers = ["joint", "n", "by pressures", "λ_U", "pressures, ms", "λ_U, ms", "programs, ms", "difference"]
    return table(headers, [_line(row) for row in rows])


def _line(row: dict) -> list[str]:
    times = [f"{1e3 * row[f'{key}_seconds']:.3g}" for key in ("pressures", "whole", "programs")]
    numbers = [f"{row['pressures']:.6f}", f"{row['whole']:.6f}"]
    return [row["joint"], str(row["n"]), *numbers, *times, f"{row['difference']:.0e}"]


def figures(rows: list[dict]) -> dict:
    return {}
