"""Elastic blocks above λ_max: one exact cycle against one Gauss–Seidel pass over the same load steps."""

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, ScalarFormatter

import shakedown
from benchmarks.refinement import block_on_plane
from benchmarks.timing import in_turn
from shakedown.joint.loading import loading
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import Evolution
from shakedown.motion.plane.gauss_seidel import PlaneStiffness, load_steps
from shakedown.report.text_table import table

TITLE = "Elastic blocks above the upper bound: one exact cycle against one Gauss–Seidel pass"
CYCLES = 3  # before the timed one
FRICTION = 0.5
TOLERANCE = 1e-10
MAX_SWEEPS = 100_000


def cases(short: bool) -> list[dict]:
    sizes = (32, 64) if short else (32, 48, 64, 80, 98)
    return [{"elements": k, "above": above} for above in (1.2, 2.0) for k in sizes]


def measure(case: dict) -> dict:
    problem = block_on_plane(case["elements"], FRICTION)
    load_factor = case["above"] * shakedown.upper_bound(problem).load_factor
    exact = Evolution(problem, load_factor)
    for _ in range(CYCLES):
        exact.cycle()
    start = exact.state

    def cycle():
        exact.state = start
        return exact.cycle()

    steps = _gauss_seidel(problem, load_factor, start.u)
    (seconds, record), (pass_seconds, (sweeps, v)) = in_turn(cycle, steps, runs=5)
    end = exact.state.u[: problem.n]
    return {
        "n": problem.n,
        "m": problem.m,
        "load_factor": load_factor,
        "events": record.events,
        "open_nodes": int(record.opened.sum()),
        "event_s": seconds,
        "gauss_seidel_s": pass_seconds,
        "sweeps": sweeps,
        "difference": float(np.abs(v - end).max() / record.slip.max()),
    }


def _gauss_seidel(
    problem: shakedown.Problem, load_factor: float, u: np.ndarray
) -> Callable[[], tuple[int, np.ndarray]]:
    """One pass from the state u = (v, w), which gives its sweeps and the slip at its end."""
    scale, n = scales(problem, load_factor), problem.n
    tension = 16 * np.finfo(float).eps * scale.force
    stiffness = PlaneStiffness(problem.A, problem.B, problem.C, problem.f, True, tension).compact()
    q_w, p_w = loading(problem).at(load_factor)
    rows = [np.empty_like(q_w) for _ in range(3)]

    def run() -> tuple[int, np.ndarray]:
        v, w = u[:n].copy(), u[n:].copy()
        sweeps, *_ = load_steps(stiffness, q_w, p_w, v, w, TOLERANCE * scale.length, MAX_SWEEPS, *rows)
        return int(sweeps), v

    return run


def tables(rows: list[dict]) -> str:
    lines = [
        [
            str(row["n"]), f"{row['above']:.1f}", str(row["events"]), str(row["open_nodes"]),
            f"{1e3 * row['event_s']:.2f}", f"{1e3 * row['gauss_seidel_s']:.2f}",
            f"{row['gauss_seidel_s'] / row['event_s']:.1f}",
        ]
        for row in rows
    ]  # fmt: skip
    head = ["nodes", "λ/λ_max", "events", "open", "exact cycle [ms]", "Gauss–Seidel pass [ms]", "ratio"]
    return table(head, lines)


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(5.6, 4.2), layout="constrained")
    axes = figure.add_subplot()
    for above, marker in ((1.2, "o"), (2.0, "s")):
        chosen = [row for row in rows if row["above"] == above]
        n = [row["n"] for row in chosen]
        axes.loglog(
            n, [1e3 * row["event_s"] for row in chosen], marker + "-", label=f"exact, λ = {above} λ_max"
        )
        times = [1e3 * row["gauss_seidel_s"] for row in chosen]
        axes.loglog(n, times, marker + "--", label=f"Gauss–Seidel, λ = {above} λ_max")
    axes.set(xlabel="contact nodes", ylabel="time of one cycle of 48 load steps [ms]")
    axes.set_xticks(sorted({row["n"] for row in rows}))
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.legend(fontsize=8)
    return {"block_cycle": figure}
