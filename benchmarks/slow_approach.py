"""Slow approach to shakedown: effort until the long-term state is known, closed form against plain cycling.

Two nodes drag each other towards shakedown; the slip of each cycle is a fixed
share of that of the cycle before. Plain cycling is the same exact evolution,
without extrapolation, until the remaining distance is below 1e-9 of the slip.
"""

import time

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.timing import median_time
from shakedown.motion.integrator import Evolution
from shakedown.report.text_table import table

TITLE = "Slow approach to shakedown: the closed form against plain cycling"
LOAD_FACTOR = 0.9
CLOSE = 1e-9


def cases(short: bool) -> list[dict]:
    ratios = (0.9, 0.99, 0.999) if short else (0.9, 0.97, 0.99, 0.997, 0.999, 0.9997, 0.9999)
    return [{"ratio": ratio} for ratio in ratios]


def problem_with(ratio: float) -> shakedown.Problem:
    """Slip shrinks by ``ratio`` per cycle: the square of the coupling of two nodes."""
    c = np.sqrt(ratio)
    q = np.zeros((8, 2))
    q[0, 0], q[2, 1], q[4, 0], q[6, 1] = 1.0, 1.0, -0.05, -0.05
    return shakedown.Problem(
        A=[[1.0, -c], [-c, 1.0]], B=np.zeros((2, 2)), f=0.5, q_w=q, p_w=np.full((8, 2), 1.0),
        q_mean=np.zeros(2), p_mean=np.ones(2),
    )  # fmt: skip


def measure(case: dict) -> dict:
    problem = problem_with(case["ratio"])
    seconds, state = median_time(lambda: shakedown.long_term_state(problem, LOAD_FACTOR))
    assert state.outcome == shakedown.Outcome.SHAKEDOWN
    plain, began, cycles = Evolution(problem, LOAD_FACTOR), time.perf_counter(), 0
    far = CLOSE * np.abs(state.final_slip).max()
    while cycles == 0 or np.abs(plain.method.u[:2] - state.final_slip).max() > far:
        plain.cycle()
        cycles += 1
    return {
        "contraction": state.contraction,
        "exact_cycles": state.cycles_simulated,
        "exact_s": seconds,
        "plain_cycles": cycles,
        "plain_s": time.perf_counter() - began,
    }


def tables(rows: list[dict]) -> str:
    lines = []
    for row in rows:
        plain, exact = row["plain_cycles"], row["exact_cycles"]
        effort = [str(exact), str(plain), f"{plain / exact:.0f}"]
        times = [f"{1e3 * row['exact_s']:.1f}", f"{1e3 * row['plain_s']:.1f}"]
        lines.append([f"{row['ratio']:g}", f"{row['contraction']:.8f}", *effort, *times])
    head = ["ratio", "contraction", "cycles", "plain", "plain/cycles", "time [ms]", "plain [ms]"]
    return table(head, lines)


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(5.2, 4.0), layout="constrained")
    axes = figure.add_subplot()
    left = [1.0 - row["ratio"] for row in rows]
    axes.loglog(left, [row["plain_cycles"] for row in rows], "o--", label="plain cycling to 1e-9")
    axes.loglog(left, [row["exact_cycles"] for row in rows], "s-", label="closed form")
    axes.set(xlabel="1 − ratio of the slips of successive cycles", ylabel="cycles followed")
    axes.legend()
    return {"slow_approach": figure}
