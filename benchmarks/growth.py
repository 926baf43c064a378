"""Cost growth: time and memory against the numbers of nodes, load steps and cycles."""

import contextlib
import json
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

import shakedown
from benchmarks.problems import random_problem
from shakedown.report.text_table import table

TITLE = "Cost growth: time and peak memory, with fitted exponents"
# (task, what grows, values short, values full, expected exponent of the time)
SERIES = [
    (
        "critical load factors",
        "n",
        [6, 8, 10],
        [6, 8, 10, 11, 12, 13, 14],
        "4^n: each node four times the work",
    ),
    ("lower bound", "n", [8, 16, 32], [8, 16, 32, 64, 128, 250], "n LPs of size n: 3 to 4"),
    ("upper bound", "n", [8, 16, 32], [8, 16, 32, 64, 128, 250], "one LP of size n: 2 to 3"),
    ("event-driven cycles", "n", [8, 16, 32], [8, 16, 32, 64, 128], "events × n²: 3"),
    ("Gauss-Seidel cycles", "n", [8, 16, 32], [8, 16, 32, 64, 128], "sweeps × n²: 2 to 3"),
    (
        "upper bound",
        "m",
        [24, 96, 384],
        [24, 96, 384, 1536, 6144],
        "only extreme samples enter the LP: 0 to 1",
    ),
    ("event-driven cycles", "m", [24, 96, 384], [24, 96, 384, 1536, 6144], "one event per load step: 1"),
    ("event-driven cycles", "cycles", [10, 40, 160], [10, 40, 160, 640, 2560, 10240], "1"),
]


def cases(short: bool) -> list[dict]:
    return [
        {"task": task, "grows": grows, "value": value, "expected": expected}
        for task, grows, few, many, expected in SERIES
        for value in (few if short else many)
    ]


def measure(case: dict) -> dict:
    """One case in a process of its own, so that its peak memory is its own."""
    words = [sys.executable, "-m", "benchmarks.growth", json.dumps(case)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def work(task: str, grows: str, value: int, expected: str) -> dict:
    size = {"n": 6, "m": 24, "cycles": 5} | {grows: value}
    problem = random_problem(size["n"], seed=0, m=size["m"])
    load_factor = 2.0 * shakedown.upper_bound(problem, certify=False).load_factor
    small = random_problem(10 if task == "critical load factors" else 3, seed=0)
    _do(task, small, 1.0, 1)  # compiles and imports; not counted
    _forget_peak()
    before = _peak()
    began = time.perf_counter()
    _do(task, problem, load_factor, size["cycles"])
    return {"seconds": time.perf_counter() - began, "megabytes": _peak() - before}


def _do(task: str, problem: shakedown.Problem, load_factor: float, cycles: int) -> None:
    if task == "critical load factors":
        shakedown.critical_load_factors(problem, budget=10**12)
    elif task == "lower bound":
        shakedown.lower_bound(problem, certify=False)
    elif task == "upper bound":
        shakedown.upper_bound(problem, certify=False)
    elif task == "event-driven cycles":
        from shakedown.motion.integrator import Evolution

        evolution = Evolution(problem, load_factor)
        for _ in range(cycles):
            assert evolution.cycle() is not None
    else:
        shakedown.simulate(problem, load_factor, method="gauss-seidel", cycles=cycles)


def _peak() -> float:
    """Largest memory of this process so far [MiB], of itself alone (Linux) or as the system counts it."""
    status = Path("/proc/self/status")
    if status.exists():
        line = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _forget_peak() -> None:
    """Start counting anew: compilation has taken more memory than the work will."""
    with contextlib.suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def exponent(rows: list[dict]) -> float:
    """Slope of log time against log size over the larger half of the sizes."""
    upper = rows[len(rows) // 2 - (len(rows) < 4) :]
    x, y = (np.log([row[key] for row in upper]) for key in ("value", "seconds"))
    return float(np.polyfit(x, y, 1)[0])


def _series(rows: list[dict]) -> list[tuple[str, list[dict]]]:
    names = dict.fromkeys((row["task"], row["grows"]) for row in rows)
    return [
        (f"{task}, growing {grows}", [r for r in rows if (r["task"], r["grows"]) == (task, grows)])
        for task, grows in names
    ]


def tables(rows: list[dict]) -> str:
    parts = []
    for name, series in _series(rows):
        body = [[str(r["value"]), f"{1e3 * r['seconds']:.2f}", f"{r['megabytes']:.1f}"] for r in series]
        growth = f"fitted exponent of the time {exponent(series):.1f}; expected {series[0]['expected']}"
        if series[0]["task"] == "critical load factors":
            steps = series[-1]["value"] - series[-2]["value"]
            factor = (series[-1]["seconds"] / series[-2]["seconds"]) ** (1 / steps)
            growth = f"factor per node {factor:.1f}; expected {series[0]['expected']}"
        parts += [name, table([series[0]["grows"], "ms", "MiB more"], body), f"  {growth}", ""]
    return "\n".join(parts)


def figures(rows: list[dict]) -> dict:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 3.8), layout="constrained")
    axes = figure.subplots(1, 3)
    for axis, grows in zip(axes, ("n", "m", "cycles"), strict=True):
        for _, series in _series(rows):
            if series[0]["grows"] == grows:
                label = f"{series[0]['task']} ({exponent(series):.1f})"
                axis.loglog(
                    [r["value"] for r in series], [r["seconds"] for r in series], "o-", ms=4, label=label
                )
        what = {"n": "nodes n", "m": "load steps m", "cycles": "cycles"}[grows]
        axis.set(xlabel=what, ylabel="time (s)", title=f"growing {what} (fitted exponent)")
        axis.grid(True, alpha=0.3)
        if axis.has_data():
            axis.legend(fontsize="small", frameon=False)
    return {"growth": figure}


if __name__ == "__main__":
    print(json.dumps(work(**json.loads(sys.argv[1]))))
