"""What the swing bound costs beside the first collapse, and how sharp it is, both in one process by turns."""

import time

import numpy as np

import shakedown
from benchmarks.problems import chain, random_problem
from shakedown.bounds.every_state.swing_bound import swing_bound
from shakedown.report.text_table import table

TITLE = "Swing bound beside first collapse: time by turns, and what is proved"
REPEATS = 3
KINDS = {"chain": chain, "random": lambda n: random_problem(n, 1)}


def cases(short: bool) -> list[dict]:
    sizes = (10, 20) if short else (10, 40, 100, 250)
    return [{"n": n, "joint": joint, "repeats": 1 if n > 100 else REPEATS} for joint in KINDS for n in sizes]


def measure(case: dict) -> dict:
    problem = KINDS[case["joint"]](case["n"])
    times = {"first_collapse": [], "swing": []}
    for _ in range(case["repeats"]):
        lower, taken = timed(lambda: shakedown.lower_bound(problem, certify=False))
        times["first_collapse"].append(taken)
        swing, taken = timed(lambda: swing_bound(problem, certify=False))
        times["swing"].append(taken)
    seconds = {f"{name}_seconds": float(np.median(taken)) for name, taken in times.items()}
    ratios = np.array(times["swing"]) / np.array(times["first_collapse"])
    return seconds | {
        "ratio": float(np.median(ratios)),
        "programs": swing.programs,
        "share": swing.load_factor / lower.load_factor if lower.load_factor > 0 else None,
    }


def timed(work) -> tuple:
    begin = time.process_time()
    return work(), time.process_time() - begin


def tables(rows: list[dict]) -> str:
    headers = [
        "joint",
        "n",
        "λ_1, s",
        "λ_swing, s",
        "λ_swing : λ_1",
        "pairs",
        "λ_swing / λ_1",
    ]
    return table(headers, [_line(row) for row in rows])


def _line(row: dict) -> list[str]:
    seconds = [f"{row[key]:.3g}" for key in ("first_collapse_seconds", "swing_seconds")]
    share = "-" if row["share"] is None else f"{row['share']:.3f}"
    return [row["joint"], str(row["n"]), *seconds, f"{row['ratio']:.2f}", str(row["programs"]), share]


def figures(rows: list[dict]) -> dict:
    return {}
