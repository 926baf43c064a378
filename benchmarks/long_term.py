"""Long-term state: effort until a verdict, and false verdicts, near the bounds where both are proved.

Below λ_1 of a two-node system or of an uncoupled one every start shakes down;
above λ_max none does. The closer λ is to the bound, the slower is the approach:
plain cycling must take "small" for "none", the closed form need not.
"""

from functools import cache

import numpy as np

import shakedown
from benchmarks.display import listed
from benchmarks.problems import random_problem
from benchmarks.timing import median_time
from shakedown import Tolerances

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
    """Of all scenes and starts, by side, distance and method."""
    found = {}
    for row in rows:
        found.setdefault((row["side"], row["exponent"], row["method"]), []).append(row)
    summed = [
        {
            "side": side,
            "distance": 10.0**-exponent,
            "method": method,
            **{word: sum(row["verdict"] == word for row in own) for word in ("right", "false", "undecided")},
            "cycles": np.median([row["cycles"] for row in own]),
            "most": max(row["cycles"] for row in own),
            "ms": 1e3 * np.median([row["seconds"] for row in own]),
        }
        for (side, exponent, method), own in sorted(found.items())
    ]
    columns = {"side": "{side}", "distance": "{distance:.0e}", "method": "{method}", "right": "{right}"}
    columns |= {"false": "{false}", "open": "{undecided}", "cycles": "{cycles:.0f}", "most": "{most}"}
    return listed(summed, columns | {"ms": "{ms:.2f}"})
