"""Time of both bounds against the number of nodes, beside general-purpose solvers on the same programs."""

import warnings
from collections.abc import Callable, Iterable
from functools import cache

import highspy
import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import linprog

import shakedown
from benchmarks.display import curve, lines, panels, shown
from benchmarks.problems import chain
from benchmarks.timing import in_turn
from shakedown import Problem
from shakedown.joint.constraints import Constraints, constraints

TITLE = "Upper and lower bound: time against the number of nodes"
CERTIFIED_UP_TO = {"upper": 125, "lower": 60}  # nodes; beyond, exact arithmetic takes minutes
INTERIOR = (1e-11, 1e-10, 1e-9)  # tolerances of the interior points, the tightest that ends counts
NODES_SAMPLED = 6  # a peer's n programs of the lower bound are timed on so many nodes, and scaled up

Answer = tuple[str, float]  # a status; the objective where it is optimal, else NaN
Peer = Callable[
    [np.ndarray, np.ndarray, np.ndarray], Answer
]  # of M x ≤ right and the cost of x, the last one ≥ 0
STATUS = {  # of HiGHS, scipy.optimize.linprog and cvxpy
    "kOptimal": "optimal", "kInfeasible": "infeasible", "kUnbounded": "unbounded",
    0: "optimal", 2: "infeasible", 3: "unbounded",
    "optimal": "optimal", "infeasible": "infeasible", "unbounded": "unbounded",
}  # fmt: skip


def highs_model(matrix: np.ndarray, right: np.ndarray, cost: np.ndarray) -> highspy.Highs:
    """HiGHS as it comes, given these arrays: free slips, and a load factor that is not negative."""
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
    return solver


def _answer(status: str | int, value: float | None) -> Answer:
    said = STATUS.get(status, "undecided")
    return said, float(value) if said == "optimal" else np.nan


def by_highs(matrix: np.ndarray, right: np.ndarray, cost: np.ndarray) -> Answer:
    solver = highs_model(matrix, right, cost)
    solver.run()
    return _answer(solver.getModelStatus().name, solver.getObjectiveValue())


def by_scipy(matrix: np.ndarray, right: np.ndarray, cost: np.ndarray) -> Answer:
    bounds = [(None, None)] * (len(cost) - 1) + [(0, None)]
    end = linprog(cost, A_ub=matrix, b_ub=right, bounds=bounds)
    return _answer(end.status, end.fun)


def by_cvxpy(solver: str | None, **settings: float) -> Peer:
    """Through cvxpy, "undecided" where the solver ends without a verdict."""

    def solve(matrix: np.ndarray, right: np.ndarray, cost: np.ndarray) -> Answer:
        import cvxpy as cp  # slow, for those who only want the programs

        x = cp.Variable(len(cost))
        program = cp.Problem(cp.Minimize(cost @ x), [matrix @ x <= right, x[-1] >= 0])
        try:
            with warnings.catch_warnings():  # of an inaccurate end, which its status says, too
                warnings.filterwarnings("ignore", "Solution may be inaccurate", UserWarning)
                program.solve(solver=solver, **settings)
        except (cp.SolverError, ValueError):  # HiGHS ended without a verdict; cvxpy cannot unpack that
            return "undecided", np.nan
        return _answer(program.status, program.value)

    return solve


PEERS = {
    "highspy": by_highs,
    "scipy linprog": by_scipy,
    "cvxpy + HiGHS": by_cvxpy("HIGHS"),
    "cvxpy + Clarabel": by_cvxpy("CLARABEL"),
}
METHODS = ("shakedown", "shakedown, certified", *PEERS)


def cases(short: bool) -> list[dict]:
    sizes = (10, 30) if short else (10, 30, 60, 125, 250)
    return [
        {"n": n, "bound": bound, "method": method}
        for n in sizes
        for bound in ("upper", "lower")
        for method in METHODS
        if method != "shakedown, certified" or n <= 60
    ]


def measure(case: dict) -> dict:
    n, bound, method = case["n"], case["bound"], case["method"]
    problem, programs = chain(n), 1 if bound == "upper" else n
    solve = shakedown.upper_bound if bound == "upper" else shakedown.lower_bound

    def own() -> float:
        return float(solve(problem, certify=False).load_factor)

    if method in PEERS:
        peer, timed = _by_peer(problem, bound, PEERS[method])
    else:
        certify, timed = method == "shakedown, certified", programs
        peer = lambda: float(solve(problem, certify=certify).load_factor)  # noqa: E731
    (seconds, value), (own_seconds, _) = in_turn(peer, own, runs=3)
    low, high, against = reference(n, bound)
    solved = bool(np.isfinite(value))
    return {
        "seconds": seconds * programs / timed,
        "relative": seconds * programs / timed / own_seconds,
        "error": max(abs(value - low) / low, abs(value - high) / high) if solved and low == low else None,
        "against": against,
    }


def _by_peer(problem: Problem, bound: str, peer: Peer) -> tuple[Callable[[], float], int]:
    """The load factor from the programs that are timed, and how many they are."""
    rows = constraints(problem)
    if bound == "upper":
        return lambda: -peer(*upper_program(rows))[1], 1
    nodes = [shakedown.lower_bound(problem, certify=False).node]
    sample = np.linspace(0, problem.n - 1, min(problem.n, NODES_SAMPLED))
    nodes += [int(j) for j in sample if j not in nodes]

    def collapses() -> float:
        values = [peer(*collapse_program(rows, node))[1] for node in nodes]
        return values[0]

    return collapses, len(nodes)


@cache
def reference(n: int, bound: str) -> tuple[float, float, str]:
    """(low, high) around the load factor, and from where.

    Exact arithmetic where it takes seconds; else interior points, which are no better
    than their tolerance. For the lower bound these solve the program of the node that
    collapses first, which checks the number, not the choice of the node. NaN where
    they do not end.
    """
    problem, solve = chain(n), shakedown.upper_bound if bound == "upper" else shakedown.lower_bound
    if n <= CERTIFIED_UP_TO[bound]:
        low, high = solve(problem, certify=True).certified
        return low, high, "certified"
    rows, sign, program = constraints(problem), -1.0, upper_program
    if bound == "lower":
        node = solve(problem, certify=False).node
        sign, program = 1.0, lambda rows: collapse_program(rows, node)
    for tolerance in INTERIOR:
        sharp = dict.fromkeys(("tol_gap_abs", "tol_gap_rel", "tol_feas"), tolerance)
        value = sign * by_cvxpy("CLARABEL", **sharp)(*program(rows))[1]
        if np.isfinite(value):
            return value, value, f"interior {tolerance:.0e}"
    return np.nan, np.nan, "none"


def upper_program(rows: Constraints) -> Iterable[np.ndarray]:
    return np.column_stack([rows.G, rows.d]), rows.g, np.append(np.zeros(rows.n), -1.0)


def collapse_program(rows: Constraints, node: int) -> Iterable[np.ndarray]:
    sign = np.where(rows.node == node, -1.0, 1.0)
    matrix = np.column_stack([rows.G, rows.d]) * sign[:, None]
    return matrix, rows.g * sign, np.append(np.zeros(rows.n), 1.0)


def tables(rows: list[dict]) -> str:
    by = {(r["n"], r["bound"], r["method"]): r for r in rows}
    parts = []
    for bound in ("upper", "lower"):
        times, errors = [], []
        for n in sorted({r["n"] for r in rows}):
            cells = [by.get((n, bound, method), {}) for method in METHODS]
            times.append([str(n), *(shown(cell, "{seconds:.3g} (x{relative:.3g})") for cell in cells)])
            errors.append([str(n), cells[0]["against"], *(shown(cell, "{error:.1e}") for cell in cells)])
        parts.append(f"{bound} bound: time [s]\n" + lines(["n", *METHODS], times))
        parts.append(f"{bound} bound: relative error\n" + lines(["n", "against", *METHODS], errors))
    parts.append(
        f"A peer's lower bound is timed on up to {NODES_SAMPLED + 1} of the n programs and scaled up;\n"
        "its error is that of the program of the node that collapses first. The error of\n"
        "the certified method is the width of its enclosure."
    )
    return "\n\n".join(parts)


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure, axes = panels(2, 2, (4.8, 4.0))
    for panel, bound in zip(axes, ("upper", "lower"), strict=True):
        for method in METHODS:
            mine = [r for r in rows if (r["bound"], r["method"]) == (bound, method)]
            curve(panel, mine, "n", "seconds", label=method)
        panel.set(title=f"{bound} bound", xlabel="contact nodes n")
    axes[0].set_ylabel("time [s]")
    axes[0].legend(fontsize=8)
    return {"bounds": figure}
