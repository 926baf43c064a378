"""Time of both bounds against the number of nodes, beside general-purpose solvers on the same programs."""

from collections.abc import Callable, Iterable
from time import perf_counter

import cvxpy as cp
import highspy
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import linprog

import shakedown
from benchmarks.problems import chain
from benchmarks.timing import median_time
from shakedown.constraints import Constraints, constraints

TITLE = "Upper and lower bound: time against the number of nodes"
NODES_SAMPLED = 6  # a peer's n programs of the lower bound are timed on so many nodes, and scaled up

Value = float


def highspy_raw(matrix: np.ndarray, right: np.ndarray, cost: np.ndarray) -> Value:
    """HiGHS as it comes, on the same arrays."""
    rows, columns = matrix.shape
    model = highspy.HighsLp()
    model.num_row_, model.num_col_ = rows, columns
    model.col_cost_, model.row_upper_ = cost, right
    model.row_lower_ = np.full(rows, -highspy.kHighsInf)
    model.col_lower_ = np.append(np.full(columns - 1, -highspy.kHighsInf), 0.0)
    model.col_upper_ = np.full(columns, highspy.kHighsInf)
    model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    model.a_matrix_.start_ = columns * np.arange(rows + 1)
    model.a_matrix_.index_ = np.tile(np.arange(columns), rows)
    model.a_matrix_.value_ = matrix.ravel()
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.passModel(model)
    solver.run()
    return solver.getObjectiveValue() if solver.getModelStatus().name == "kOptimal" else np.nan


def scipy_linprog(matrix: np.ndarray, right: np.ndarray, cost: np.ndarray) -> Value:
    bounds = [(None, None)] * (len(cost) - 1) + [(0, None)]
    end = linprog(cost, A_ub=matrix, b_ub=right, bounds=bounds)
    return float(end.fun) if end.status == 0 else np.nan


def through_cvxpy(solver: str) -> Callable[[np.ndarray, np.ndarray, np.ndarray], Value]:
    def solve(matrix: np.ndarray, right: np.ndarray, cost: np.ndarray) -> Value:
        x = cp.Variable(len(cost))
        program = cp.Problem(cp.Minimize(cost @ x), [matrix @ x <= right, x[-1] >= 0])
        try:
            program.solve(solver=solver)
        except (cp.SolverError, ValueError):  # HiGHS ended without a verdict; cvxpy cannot unpack that
            return np.nan
        return float(program.value) if program.status == "optimal" else np.nan

    return solve


PEERS = {
    "highspy": highspy_raw,
    "scipy linprog": scipy_linprog,
    "cvxpy + HiGHS": through_cvxpy("HIGHS"),
    "cvxpy + Clarabel": through_cvxpy("CLARABEL"),
}
ROADS = ("shakedown", "shakedown, certified", *PEERS)


def cases(short: bool) -> list[dict]:
    sizes = (10, 30) if short else (10, 30, 60, 125, 250)
    return [
        {"n": n, "bound": bound, "road": road}
        for n in sizes
        for bound in ("upper", "lower")
        for road in ROADS
        if road != "shakedown, certified" or n <= 60
    ]


def measure(case: dict) -> dict:
    problem = chain(case["n"])
    solve = shakedown.upper_bound if case["bound"] == "upper" else shakedown.lower_bound
    reference = solve(problem, certify=False).load_factor
    if case["road"].startswith("shakedown"):
        certify = case["road"].endswith("certified")
        seconds, found = median_time(lambda: solve(problem, certify=certify))
        return {"seconds": seconds, "load_factor": found.load_factor, "solved": 1.0, "error": 0.0}
    rows, peer = constraints(problem), PEERS[case["road"]]
    if case["bound"] == "upper":
        seconds, value = median_time(lambda: -peer(*upper_program(rows)))
        solved, share = float(np.isfinite(value)), 1.0
    else:
        nodes = [shakedown.lower_bound(problem, certify=False).node]
        nodes += [
            int(j) for j in np.linspace(0, case["n"] - 1, min(case["n"], NODES_SAMPLED)) if j not in nodes
        ]
        start = perf_counter()
        values = [peer(*collapse_program(rows, node)) for node in nodes]
        seconds, share = perf_counter() - start, case["n"] / len(nodes)
        value, solved = values[0], float(np.isfinite(values[0]))
    error = abs(value - reference) / reference if solved else None
    return {
        "seconds": seconds * share,
        "load_factor": value if solved else None,
        "solved": solved,
        "error": error,
    }


def upper_program(rows: Constraints) -> Iterable[np.ndarray]:
    return np.column_stack([rows.G, rows.d]), rows.g, np.append(np.zeros(rows.n), -1.0)


def collapse_program(rows: Constraints, node: int) -> Iterable[np.ndarray]:
    sign = np.where(rows.node == node, -1.0, 1.0)
    matrix = np.column_stack([rows.G, rows.d]) * sign[:, None]
    return matrix, rows.g * sign, np.append(np.zeros(rows.n), 1.0)


def tables(rows: list[dict]) -> str:
    by = {(r["n"], r["bound"], r["road"]): r for r in rows}
    lines = []
    for bound in ("upper", "lower"):
        lines.append(f"{bound} bound [s]".ljust(18) + "".join(road.rjust(22) for road in ROADS))
        for n in sorted({r["n"] for r in rows}):
            own = by[n, bound, "shakedown"]["seconds"]
            cells = [by.get((n, bound, road)) for road in ROADS]
            shown = [f"{c['seconds']:.3g} (x{c['seconds'] / own:.3g})" if c else "-" for c in cells]
            lines.append(f"n = {n}".ljust(18) + "".join(text.rjust(22) for text in shown))
    lines.append(f"A peer's lower bound is timed on {NODES_SAMPLED} of the n programs and scaled up.")
    return "\n".join(lines)


def figures(rows: list[dict]) -> dict:
    figure, axes = plt.subplots(1, 2, figsize=(9.5, 4), layout="constrained", sharey=True)
    for panel, bound in zip(axes, ("upper", "lower"), strict=True):
        for road in ROADS:
            mine = sorted((r["n"], r["seconds"]) for r in rows if r["bound"] == bound and r["road"] == road)
            panel.loglog(*zip(*mine, strict=True), "o-", ms=4, label=road)
        panel.set_title(f"{bound} bound")
        panel.set_xlabel("contact nodes n")
        panel.grid(alpha=0.3)
    axes[0].set_ylabel("time [s]")
    axes[0].legend(fontsize=8)
    return {"bounds": figure}
