"""Time per subset of the critical load factors: the compiled tree against batched solves."""

from itertools import combinations, islice
from math import comb

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.display import curve, listed, panels
from benchmarks.problems import joint
from benchmarks.timing import median_time
from shakedown.bounds.intersection import scaled_rows
from shakedown.bounds.walk_kernel import Tree, pieces
from shakedown.joint.constraints import constraints

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
    by = {(row["n"], row["method"]): row for row in rows}
    sizes = sorted({row["n"] for row in rows})
    found = [
        {method: by[n, method]["nanoseconds"] for method in METHODS} | {"n": n, "total": comb(2 * n, n + 1)}
        for n in sizes
    ]
    columns = {"n": "{n}", "subsets": "{total:,}"} | {name: f"{{{name}:.0f}} ns" for name in METHODS}
    last = by[sizes[-1], "tree, all cores"]
    summary = f"n = {sizes[-1]}: {last['total']:,} subsets in {last['seconds']:.2f} s on all cores"
    return f"{listed(found, columns)}\n{summary}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure, (axes,) = panels(1, size=(6.5, 4.0))
    for method in METHODS:
        curve(axes, [row for row in rows if row["method"] == method], "n", "nanoseconds", label=method)
    axes.set(xlabel="contact nodes n", ylabel="time per subset [ns]", xscale="linear")
    axes.legend(fontsize=8)
    return {"enumeration": figure}
