"""Long-term state: effort until a verdict, and false verdicts, near the bounds where both are proved.

Below λ_1 of a two-node system or of an uncoupled one every start shakes down;
above λ_max none does. The closer λ is to the bound, the slower is the approach:
plain cycling must take "small" for "none", the closed form need not.
"""

from functools import cache

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.problems import random_problem
from benchmarks.timing import median_time
from shakedown import Tolerances
from shakedown.report.facts import table

TITLE = "Long-term state: effort until the verdict, and false verdicts"
SCENES = ("two-node", "random 2", "uncoupled 5")
LIMIT = 3000  # cycles
METHODS = {"event": None, "cycling 1e-06": 1e-6, "cycling 1e-09": 1e-9, "cycling 1e-12": 1e-12}


def cases(short: bool) -> list[dict]:
    exponents = (1, 3, 5) if short else (1, 2, 3, 4, 5, 6, 7, 8)
    starts = 3 if short else 6  # the witness, the safe slip, random ones
    return [
        {"scene": scene, "side": side, "exponent": k, "start": start, "method": method}
        for scene in SCENES
        for side in ("below", "above")
        for k in exponents
        for start in range(starts)
        for method in METHODS
    ]


@cache
def scene(name: str) -> tuple[shakedown.Problem, shakedown.ShakedownBounds]:
    word, _, size = name.partition(" ")
    if word == "two-node":
        problem = shakedown.example(word)
    else:
        problem = random_problem(int(size), seed=4, coupling=0.0 if word == "uncoupled" else 0.8)
    bounds = shakedown.shakedown_bounds(problem)
    assert bounds.lower.guarantee == "proved"
    return problem, bounds


def measure(case: dict) -> dict:
    problem, bounds = scene(case["scene"])
    below = case["side"] == "below"
    distance = 10.0 ** -case["exponent"]
    load_factor = (
        bounds.lower.load_factor * (1 - distance) if below else bounds.upper.load_factor * (1 + distance)
    )
    generator = np.random.default_rng(case["start"])
    size = np.abs(bounds.lower.slip - bounds.upper.slip).max() or np.abs(bounds.upper.slip).max()
    start = {0: bounds.lower.slip, 1: bounds.upper.slip}.get(
        case["start"], bounds.upper.slip + size * generator.uniform(-1, 1, problem.n)
    )
    steadiness = METHODS[case["method"]]
    if steadiness is None:
        seconds, state = median_time(lambda: shakedown.long_term_state(problem, load_factor, start), runs=1)
    else:
        tolerances = Tolerances(steadiness=steadiness)
        seconds, state = median_time(
            lambda: shakedown.simulate(
                problem, load_factor, start, method="gauss-seidel", cycles=LIMIT, tolerances=tolerances
            ),
            runs=1,
        )
    right = state.outcome != shakedown.Outcome.UNDECIDED and below == (
        state.outcome == shakedown.Outcome.SHAKEDOWN
    )
    verdict = "undecided" if state.outcome == shakedown.Outcome.UNDECIDED else "right" if right else "false"
    return {
        "load_factor": load_factor,
        "outcome": state.outcome.value,
        "verdict": verdict,
        "cycles": state.cycles_simulated,
        "seconds": seconds,
    }


def tables(rows: list[dict]) -> str:
    body = []
    for side in ("below", "above"):
        for exponent in sorted({row["exponent"] for row in rows}):
            for method in METHODS:
                chosen = [
                    r for r in rows if (r["side"], r["exponent"], r["method"]) == (side, exponent, method)
                ]
                counts = [
                    sum(r["verdict"] == word for r in chosen) for word in ("right", "false", "undecided")
                ]
                body.append(
                    [
                        side,
                        f"1e-{exponent}",
                        method,
                        *map(str, counts),
                        f"{np.median([r['cycles'] for r in chosen]):.0f}",
                        str(max(r["cycles"] for r in chosen)),
                        f"{1e3 * np.median([r['seconds'] for r in chosen]):.2f}",
                    ]
                )
    headers = ["side", "distance", "method", "right", "false", "open", "cycles", "most", "ms"]
    return table(headers, body, longest=10_000)


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(9.0, 3.8), layout="constrained")
    axes = figure.subplots(1, 2, sharey=True)
    styles = {"event": ("o", "#000000"), "cycling 1e-06": ("s", "#E69F00"), "cycling 1e-09": ("^", "#0072B2")}
    styles["cycling 1e-12"] = ("v", "#D55E00")
    for axis, side in zip(axes, ("below", "above"), strict=True):
        for method, (marker, colour) in styles.items():
            chosen = [r for r in rows if (r["side"], r["method"]) == (side, method)]
            for verdict, fill in (("right", colour), ("false", "none"), ("undecided", "none")):
                some = [r for r in chosen if r["verdict"] == verdict]
                axis.loglog(
                    [10.0 ** -r["exponent"] for r in some],
                    [r["cycles"] for r in some],
                    marker if verdict != "false" else "x",
                    color=colour,
                    mfc=fill,
                    ms=5,
                    label=method if verdict == "right" else None,
                )
        bound = "λ_1, true outcome: shakedown" if side == "below" else "λ_max, true outcome: cyclic slip"
        axis.set(title=f"{side} {bound}", xlabel="relative distance from the bound")
        axis.grid(True, alpha=0.3)
    axes[0].set_ylabel("cycles followed until the verdict")
    handles, labels = axes[1].get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=4,
        frameon=False,
        title="hollow: undecided; ×: false",
    )
    return {"long-term": figure}
