"""The same degenerate joints with two tangential directions, held against answers that know nothing of cones.

A joint in the plane, loaded along one direction only, has the same λ_max in space: sideways slip changes no
pressure there and only adds to a reaction. So the exact rational answer of every hard case of the plane is
that of a joint in space, with the directions of every node given quarter turns, which round nothing, or any.
Of one node without coupling λ_max is f p over the radius of the least circle around its reactions.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from itertools import combinations
from math import inf, nan

import cvxpy as cp
import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks import hard_cases
from benchmarks.hard_cases import HARD_CASES, VERDICTS, Answer, Reference, reference_upper
from shakedown import Problem
from shakedown.joint.loading import loading
from shakedown.report.text_table import table

TITLE = "Hard cases with two directions: error of each method against exact answers of joints in the plane"

TURNED = ("plain", "parallel rows", "symmetric block", "silent node", "block-9")  # by any angles, too
SEED = 5


def lifted(name: str, turned: bool = False) -> Problem:
    """A hard case of the plane in space: loaded along one direction of each node, held as much sideways."""
    plane = HARD_CASES[name]()
    n, rng = plane.n, np.random.default_rng(SEED)
    quarter = np.array([[0.0, -1.0], [1.0, 0.0]])
    turn = np.zeros((2 * n, 2 * n))
    for node in range(n):
        angle = rng.uniform(0, 2 * np.pi)
        own = np.linalg.matrix_power(quarter, int(rng.integers(4)))
        place = slice(2 * node, 2 * node + 2)
        turn[place, place] = np.cos(angle) * np.eye(2) + np.sin(angle) * quarter if turned else own
    along = turn[:, ::2]  # the loaded direction of each node, (2n, n)
    sideways = turn[:, 1::2]
    A = along @ plane.A @ along.T + sideways @ plane.A @ sideways.T
    means = {} if plane.q_mean is None else {"q_mean": plane.q_mean @ along.T, "p_mean": plane.p_mean}
    loads = {"q_w": plane.q_w @ along.T, "p_w": plane.p_w} | means
    return Problem(A=(A + A.T) / 2, B=plane.B @ along.T, C=plane.C, f=plane.f, **loads)


def circle(steps: int) -> Problem:
    """One node whose reaction runs round a circle: λ_max = f p / q, all bounds alike."""
    t = 2 * np.pi * np.arange(steps)[:, None] / steps
    q_w = 0.75 * np.hstack([np.cos(t), np.sin(t)])
    return Problem(A=np.eye(2), B=np.zeros((1, 2)), f=0.5, q_w=q_w, p_w=np.full((steps, 1), 3.0))


def scattered(steps: int, far: float = 0.0) -> Problem:
    """One node whose reaction takes any values, far from a mean that is no sample mean."""
    rng = np.random.default_rng(SEED)
    q_w = far + rng.normal(size=(steps, 2))
    means = {"q_mean": np.array([far, far]), "p_mean": np.array([2.0])}
    return Problem(A=np.eye(2), B=np.zeros((1, 2)), f=0.4, q_w=q_w, p_w=np.full((steps, 1), 2.0), **means)


def least_circle(points: np.ndarray) -> float:
    """Radius of the least circle around points in the plane, whose centre is that of two or three of them."""
    best = inf
    for chosen in (c for k in (2, 3) for c in combinations(range(len(points)), k)):
        first, *others = points[list(chosen)]
        sides = np.array(others) - first
        centre = first + np.linalg.lstsq(2 * sides, (sides**2).sum(axis=1), rcond=None)[0]
        best = min(best, float(np.linalg.norm(points - centre, axis=1).max()))
    return best


def of_circle(problem: Problem) -> Reference:
    """λ_max of one node without coupling under a constant pressure."""
    loop = loading(problem)
    return Reference("least circle", "optimal", float(problem.f[0] * loop.p0[0] / least_circle(loop.q1)))


@dataclass(frozen=True)
class Case:
    """A joint in space and where its answer comes from."""

    problem: Callable[[], Problem]
    reference: Callable[[], Reference]


CIRCLES = {
    "circle of 4 steps": partial(circle, 4),
    "circle of 16 steps": partial(circle, 16),
    "20 scattered steps": partial(scattered, 20),
    "20 steps far away": partial(scattered, 20, 1e6),
}
CASES = {
    **{name: Case(partial(lifted, name), partial(reference_upper, name)) for name in HARD_CASES},
    **{
        f"{name}, turned": Case(partial(lifted, name, True), partial(reference_upper, name))
        for name in TURNED
    },
    **{
        name: Case(made, lambda made=made: of_circle(made()))  # type: ignore[misc]
        for name, made in CIRCLES.items()
    },
}


def by_cvxpy(problem: Problem) -> Answer:
    """Clarabel through cvxpy at its default tolerances: a cone for every node and load step, as they are."""
    loop, v, load_factor = loading(problem), cp.Variable(2 * problem.n), cp.Variable(nonneg=True)
    limits = []
    for q1, p1 in zip(loop.q1, loop.p1, strict=True):
        q = cp.reshape(loop.q0 + load_factor * q1 + problem.A @ v, (problem.n, 2), order="C")
        p = loop.p0 + load_factor * p1 + problem.B @ v
        limits.append(cp.norm(q, 2, axis=1) <= cp.multiply(problem.f, p))
    program = cp.Problem(cp.Maximize(load_factor), limits)
    try:
        program.solve(solver=cp.CLARABEL)
    except cp.SolverError:
        return "undecided", nan
    status = str(program.status) if program.status in ("optimal", "infeasible", "unbounded") else "undecided"
    return status, float(load_factor.value) if status == "optimal" else inf if status == "unbounded" else nan


OWN = hard_cases.OWN
METHODS: dict[str, Callable[[Problem], Answer]] = {
    OWN: hard_cases.default_upper,
    "shakedown, floats only": hard_cases.plain_upper,
    "cvxpy Clarabel": by_cvxpy,
}


def cases(short: bool) -> list[dict]:
    return [{"problem": name, "method": method} for name in CASES for method in METHODS]


def measure(case: dict) -> dict:
    problem, reference = CASES[case["problem"]].problem(), reference_of(case["problem"])
    status, found = METHODS[case["method"]](problem)
    verdict, error = hard_cases.judged("", reference, status, found)
    return {
        "exact_status": reference.status,
        "exact": hard_cases.as_number(reference.load_factor),
        "reference": reference.kind,
        "status": status,
        "value": hard_cases.as_number(found),
        "error": hard_cases.as_number(error),
        "verdict": verdict,
        **(proved(problem, reference) if case["method"] == OWN else {}),
    }


@cache
def reference_of(name: str) -> Reference:
    return CASES[name].reference()


def proved(problem: Problem, reference: Reference) -> dict:
    """What is proved, relative to the exact λ_max: the enclosure, λ_E from slip zero, λ_U."""
    exact = reference.load_factor if reference.status == "optimal" else nan
    limits = shakedown.assess(problem, open_nodes=()).details
    low, high = limits.upper.certified or (nan, nan)
    numbers = {"low": low, "high": high, "energy": limits.energy.load_factor}
    numbers["universal"] = limits.universal.load_factor
    return {key: hard_cases.as_number(x / exact if exact > 0 else nan) for key, x in numbers.items()}


def tables(rows: list[dict]) -> str:
    names = list(dict.fromkeys(r["problem"] for r in rows))
    cell = {(r["problem"], r["method"]): r for r in rows}
    methods = [method for method in METHODS if any(r["method"] == method for r in rows)]
    headers = ["", "reference", "exact", *(method.replace("shakedown", "sd") for method in methods)]
    lines = []
    for name in names:
        first = next(cell[name, method] for method in methods if (name, method) in cell)
        exact = f"{first['exact']:.5g}" if first["exact_status"] == "optimal" else first["exact_status"]
        shown = [
            hard_cases.cell_text(cell[name, method]) if (name, method) in cell else "" for method in methods
        ]
        own = cell.get((name, OWN), {})
        lines.append([name, first["reference"], exact, *shown, *_beside(own)])
    for verdict in VERDICTS[:-1]:
        counts = [sum(r["verdict"] == verdict for r in rows if r["method"] == method) for method in methods]
        lines.append([f"{verdict}, of {len(names)}", "", "", *map(str, counts), "", "", ""])
    return table([*headers, "enclosed to", "λ_E", "λ_U"], lines, longest=len(lines))


def _beside(row: dict) -> list[str]:
    """The enclosure and what is proved, relative to the exact λ_max."""
    low, high = row.get("low"), row.get("high")
    width = "" if low is None or high is None or "inf" in (low, high) else f"{high - low:.0e}"
    if width and not low <= 1.0 + 1e-15 <= high + 2e-15:
        width = f"! {width}"
    return [width, *("" if row.get(key) is None else f"{row[key]:.4f}" for key in ("energy", "universal"))]


def figures(rows: list[dict]) -> dict:
    figure = Figure(figsize=(8, 3), layout="constrained")
    axes = figure.subplots()
    for k, method in enumerate(METHODS):
        errors = [
            max(r["error"], 1e-17) for r in rows if r["method"] == method and isinstance(r["error"], float)
        ]
        heights = np.full(len(errors), k) + np.linspace(-0.25, 0.25, len(errors))
        axes.semilogx(errors, heights, "o", ms=4, alpha=0.6)
    axes.axvline(hard_cases.RIGHT, color="k", lw=0.8, ls="--")
    axes.set_yticks(range(len(METHODS)), list(METHODS))
    axes.set_xlim(3e-18, 10)
    axes.set_xlabel("relative error of the upper bound (0 drawn at 1e-17)")
    axes.invert_yaxis()
    return {"space_hard_cases": figure}
