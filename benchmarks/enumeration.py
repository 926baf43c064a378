"""Time per subset of the critical load factors: the compiled tree against batched solves."""

from itertools import combinations, islice
from math import comb

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.problems import joint
from benchmarks.timing import median_time
from shakedown.bounds.enumeration.critical import scaled_rows
from shakedown.bounds.enumeration.walk_kernel import Tree, pieces
from shakedown.joint.constraints import constraints
from shakedown.report.facts import table

TITLE = "Critical load factors: time per subset"
SAMPLE = 20_000

METHODS = (
    "tree, one core",
    "tree, all cores",
    "tree with search of the safe region",
    "numpy batches",
)


def cases(short: bool) -> list[dict]:
    sizes = (6, 9, 11) if short else (6, 8, 9, 10, 11, 12, 13, 14)
    return [{"n": n, "method": method} for n in sizes for method in METHODS]


def measure(case: dict) -> dict:
    n, method = case["n"], case["method"]
    problem, total = joint(0, n), comb(2 * n, n + 1)
    rows = scaled_rows(constraints(problem))
    if method == "numpy batches":
        seconds, subsets = batched(rows.matrix, rows.right, min(total, SAMPLE))
    else:
        threads = None if method == "tree, all cores" else 1
        below = shakedown.lower_bound(problem, certify=False).load_factor if "search" in method else 0.0
        tree = Tree(rows, feasible_below=below)
        seconds, subsets = median_time(lambda: sum(piece.subsets for piece in pieces(tree, threads)))
        assert subsets == total
    return {"subsets": subsets, "total": total, "seconds": seconds, "nanoseconds": 1e9 * seconds / subsets}


def batched(matrix: np.ndarray, right: np.ndarray, count: int) -> tuple[float, int]:
    """``numpy.linalg.solve`` on stacks of 4096 subsets, the subsets listed beforehand."""
    every = np.array(list(islice(combinations(range(len(matrix)), matrix.shape[1]), count)))
    stacks = [every[i : i + 4096] for i in range(0, count, 4096)]

    def solve() -> float:
        return min(float(np.linalg.solve(matrix[s], right[s][..., None])[:, -1, 0].min()) for s in stacks)

    return median_time(solve)[0], count


def tables(rows: list[dict]) -> str:
    by = {(r["n"], r["method"]): r for r in rows}
    sizes = sorted({r["n"] for r in rows})
    headers = ["n", "subsets", *METHODS, "numpy / tree"]
    lines = []
    for n in sizes:
        times = {method: by[n, method]["nanoseconds"] for method in METHODS}
        ratio = times["numpy batches"] / times["tree, one core"]
        shown = [f"{times[method]:.0f} ns" for method in METHODS]
        lines.append([str(n), f"{by[n, 'tree, one core']['total']:,}", *shown, f"{ratio:.0f}"])
    last = by[sizes[-1], "tree, all cores"]
    summary = f"n = {sizes[-1]}: {last['total']:,} subsets in {last['seconds']:.2f} s on all cores"
    return f"{table(headers, lines)}\n{summary}"


def figures(rows: list[dict]) -> dict:
    figure = Figure(figsize=(6.5, 4), layout="constrained")
    axes = figure.subplots()
    for method in METHODS:
        mine = sorted((r["n"], r["nanoseconds"]) for r in rows if r["method"] == method)
        axes.semilogy(*zip(*mine, strict=True), "o-", ms=4, label=method)
    axes.set_xlabel("contact nodes n")
    axes.set_ylabel("time per subset [ns]")
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3)
    return {"enumeration": figure}
