"""The bounds of joints of up to a thousand nodes beside HiGHS and Clarabel, given the same programs."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from statistics import median

import clarabel
import highspy
import numpy as np
from scipy import sparse
from scipy.linalg import cholesky, solve_triangular
from threadpoolctl import threadpool_limits

import shakedown
from benchmarks.bounds import by_highs, highs_model, upper_program
from benchmarks.display import listed
from benchmarks.problems import chain, random_problem
from shakedown import Problem
from shakedown.fem import ElasticBody, Material, Pressure, Support, Traction, block_mesh, contact_problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import constraints

TITLE = "Large joints: the bounds and what HiGHS and Clarabel need for the same programs"
INFINITE = highspy.kHighsInf
MOST_NODES = {"HiGHS, λ_max": 1000, "Clarabel, λ_max": 250, "HiGHS, λ_1": 100, "Clarabel, λ_E": 250}
REPEATED_UP_TO = 100  # nodes: more are timed once


def block(n: int) -> Problem:
    """An elastic block with n contact nodes, held at one end, pressed on a plane and drawn to and fro."""
    body = ElasticBody(
        block_mesh(2.0, 1.0, n - 1, max(8, n // 8)),
        Material(young=200e3, poisson=0.3),
        supports=[Support("left")],
        loads=[
            Pressure("top", 10.0, history=np.ones(24)),
            Traction("right", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
        ],
    )
    return contact_problem(body, "bottom", f=0.4, steps=24)


KINDS: dict[str, Callable[[int], Problem]] = {
    "random": lambda n: random_problem(n, seed=0),
    "chain": chain,
    "block": block,
}


def cases(short: bool) -> list[dict]:
    sizes = (2, 10, 30) if short else (2, 10, 30, 100, 250, 500, 1000)
    return [
        {"joint": kind, "n": n} for kind in KINDS for n in sizes if not (kind == "block" and n in (2, 1000))
    ]


def measure(case: dict) -> dict:
    with threadpool_limits(limits=1, user_api="blas"):
        return _measured(case)


def _measured(case: dict) -> dict:
    problem = KINDS[case["joint"]](case["n"])
    methods = {
        "λ_max": lambda p: shakedown.upper_bound(p, certify=False).load_factor,
        "λ_1": lambda p: shakedown.lower_bound(p, certify=False).load_factor,
        "λ_E": lambda p: shakedown.energy_bound(p, certify=False).load_factor,
        "HiGHS, λ_max": _highs_upper,
        "Clarabel, λ_max": _clarabel_upper,
        "HiGHS, λ_1": _highs_lower,
        "Clarabel, λ_E": _clarabel_energy,
    }
    found: dict[str, dict] = {}
    for _ in range(5 if case["n"] <= REPEATED_UP_TO else 1):
        for name, method in methods.items():
            if case["n"] > MOST_NODES.get(name, 1000):
                continue
            fresh = replace(problem)  # knows no rows yet
            began = time.process_time()
            value = method(fresh)
            found.setdefault(name, {"seconds": [], "value": value})["seconds"].append(
                time.process_time() - began
            )
    return {name: {"seconds": median(end["seconds"]), "value": end["value"]} for name, end in found.items()}


def _value(solver: highspy.Highs) -> float:
    solver.run()
    optimal = solver.getModelStatus() == highspy.HighsModelStatus.kOptimal
    return abs(solver.getInfo().objective_function_value) if optimal else np.inf


def _highs_upper(problem: Problem) -> float:
    """The rows of a joint in HiGHS with its own options, scaled by it."""
    return -by_highs(*upper_program(constraints(problem)))[1]


def _highs_lower(problem: Problem) -> float:
    """The n programs of the first collapse in one model, each from where the last one ended."""
    matrix, right, cost = upper_program(constraints(problem))
    solver, values = highs_model(matrix, right, -cost), []
    for node in range(problem.n):
        for row in (2 * node, 2 * node + 1):
            solver.changeRowBounds(row, right[row], INFINITE)
        values.append(_value(solver))
        for row in (2 * node, 2 * node + 1):
            solver.changeRowBounds(row, -INFINITE, right[row])
    return min(values)


def _clarabel(matrix: FloatArray, right: FloatArray, cones: list) -> FloatArray:
    """Maximise the last column, to Clarabel's own tolerances."""
    columns, settings = matrix.shape[1], clarabel.DefaultSettings()
    settings.verbose, settings.max_threads = False, 1
    cost, nothing = np.append(np.zeros(columns - 1), -1.0), sparse.csc_matrix((columns, columns))
    return np.array(
        clarabel.DefaultSolver(nothing, cost, sparse.csc_matrix(matrix), right, cones, settings).solve().x
    )


def _clarabel_upper(problem: Problem) -> float:
    rows = constraints(problem)
    matrix = np.vstack([np.column_stack([rows.G, rows.d]), np.append(np.zeros(rows.n), -1.0)])
    right = np.append(rows.g, 0.0)
    return float(_clarabel(matrix, right, [clarabel.NonnegativeConeT(len(right))])[-1])


def _clarabel_energy(problem: Problem) -> float:
    """The cone program of λ_E from slip zero with every row, in the energy metric y = L^T v, A = L L^T."""
    rows, root = constraints(problem), cholesky(problem.A, lower=True)
    tied = np.diagonal(problem.B) / np.diagonal(problem.A)  # no friction here is above a node's own threshold
    spread = np.linalg.norm(
        solve_triangular(root, (problem.B - tied[:, None] * problem.A).T, lower=True), axis=0
    )
    slopes, rank = solve_triangular(root, rows.G.T, lower=True).T, problem.n
    cone = np.zeros((rank + 1, rank + 2))
    cone[0, rank] = -1.0
    cone[np.arange(1, rank + 1), np.arange(rank)] = -1.0
    matrix = np.vstack([np.column_stack([slopes, np.repeat(problem.f * spread, 2), rows.d]), cone])
    right = np.append(rows.g, np.zeros(rank + 1))
    cones = [clarabel.NonnegativeConeT(len(rows.g)), clarabel.SecondOrderConeT(rank + 1)]
    return float(_clarabel(matrix, right, cones)[-1])


PEERS = (
    ("λ_max", "HiGHS, λ_max"),
    ("λ_max", "Clarabel, λ_max"),
    ("λ_1", "HiGHS, λ_1"),
    ("λ_E", "Clarabel, λ_E"),
)


def tables(rows: list[dict]) -> str:
    own = {f"{name}, s": f"{{{name}[seconds]:.3g}}" for name in ("λ_max", "λ_1", "λ_E")}
    peers = {f"{peer} : ours": partial(_ratio, name, peer) for name, peer in PEERS}
    return listed(rows, {"joint": "{joint}", "n": "{n}"} | own | peers | {"largest gap": _gap})


def _ratio(name: str, peer: str, row: dict) -> str:
    return f"{row[peer]['seconds'] / row[name]['seconds']:.2f}" if peer in row else "-"


def _gap(row: dict) -> str:
    """The largest relative difference between us and a peer."""
    pairs = [(row[name]["value"], row[peer]["value"]) for name, peer in PEERS if peer in row]
    return f"{max(abs(one - two) / max(abs(one), 1e-300) for one, two in pairs):.1e}" if pairs else "-"
