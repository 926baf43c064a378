"""How near the proof from every initial state comes to the first collapse, argument by argument.

Random joints drawn in bands of the coupling ratio ρ, under a smooth loop about its mean, and the built-in
blocks: λ_U over λ_1 by the swing bound alone and with the box of the long run and the best metric.
Where locked-in slip can lift a node off before λ_1, nothing is proved from there on: medians with and
without these joints.
"""

import time
from dataclasses import replace

import numpy as np

import shakedown
from benchmarks.problems import random_problem
from benchmarks.universal_adversary import BANDS, difficult, scaled_to
from shakedown.report.text_table import table

TITLE = "Proved from every initial state, relative to the first collapse"
SIZES = (3, 4, 6, 8)
BLOCKS = [("block-9", f) for f in (0.1, 0.2, 0.3)] + [("block-33", f) for f in (0.1, 0.2, 0.3)]
FAMILIES = ("smooth", "impulses", "off centre", "two-sided")


def cases(short: bool) -> list[dict]:
    joints = 3 if short else 20
    bands = [
        (band, family) for band in BANDS for family in FAMILIES if (band, family) != ("strong", "two-sided")
    ]
    random = [{"band": band, "loads": family, "joints": joints, "seed": 3} for band, family in bands]
    blocks = (
        [] if short else [{"block": name, "f": f, "intervals": k} for name, f in BLOCKS for k in (None, 6)]
    )
    return random + blocks


def measure(case: dict) -> dict:
    if "block" in case:
        problem = shakedown.example(case["block"])
        return {"rows": [shares(replace(problem, f=np.full(problem.n, case["f"])), case["intervals"])]}
    rng = np.random.default_rng([case["seed"], *case["band"].encode(), *case["loads"].encode()])
    joints = (drawn(rng, SIZES[k % len(SIZES)], case) for k in range(case["joints"]))
    return {"rows": [shares(joint, None) for joint in joints]}


def drawn(rng: np.random.Generator, n: int, case: dict) -> shakedown.Problem:
    """A joint of a band of coupling ratios: made difficult, or (two-sided) with a positive definite κ."""
    low, high = BANDS[case["band"]]
    if case["loads"] != "two-sided":
        return difficult(rng, n, case["band"], case["loads"])
    while True:
        problem = random_problem(n, int(rng.integers(2**31)), m=12, coupling=1.0)
        A, B = scaled_to(problem.A, problem.B * rng.uniform(0.5, 2.5), rng.uniform(low, high))
        problem = replace(problem, A=A, B=B, C=None)
        if low <= shakedown.coupling(problem).ratio <= high:
            return problem


def shares(problem: shakedown.Problem, intervals: int | None) -> dict:
    """λ_S, λ_U and the lift-off bound relative to λ_1, and the time that λ_U takes."""
    lower = shakedown.lower_bound(problem, certify=False)
    begin = time.process_time()
    bound = shakedown.universal_bound(problem, first_collapse=lower, intervals=intervals, certify=False)
    seconds = time.process_time() - begin
    first = lower.load_factor
    if not 0.0 < first < np.inf:
        return {"universal": None, "swing": None, "lift_off": None, "argument": "none", "seconds": seconds}
    swing = shakedown.swing_bound(problem, certify=False).load_factor
    lift = bound.lift_off_bound
    return {
        "universal": bound.load_factor / first,
        "swing": min(swing, first) / first,
        "lift_off": lift / first if np.isfinite(lift) else None,
        "argument": bound.argument,
        "seconds": seconds,
    }


def tables(rows: list[dict]) -> str:
    """Medians by family and band, all with ρ < 1 together, and the blocks."""
    random = [row for row in rows if "band" in row]
    lines = [_line(row["band"], row["loads"], row["rows"]) for row in random]
    for family in ("smooth", "two-sided"):
        chosen = [
            r for row in random if row["band"] != "strong" and row["loads"] == family for r in row["rows"]
        ]
        lines.append(_line("all ρ < 1", family, chosen))
    chosen = [r for row in random if row["band"] != "strong" for r in row["rows"]]
    lines.append(_line("all ρ < 1", "all", chosen))
    for row in rows:
        if "block" in row:
            effort = "default" if row["intervals"] is None else f"{row['intervals']} intervals"
            lines.append(_line(f"{row['block']}, f = {row['f']}", effort, row["rows"]))
    return table(
        ["coupling", "loads", "joints", "lifted first", "λ_S / λ_1", "λ_U / λ_1", "not lifted", "λ_U, s"],
        lines,
    )


def _line(label: str, loads: str, found: list[dict]) -> list[str]:
    free = [
        r for r in found if r["universal"] is not None and (r["lift_off"] is None or r["lift_off"] >= 1.0)
    ]
    all_of_them = [r for r in found if r["universal"] is not None]
    wanted = [(all_of_them, "swing"), (all_of_them, "universal"), (free, "universal")]
    medians = [f"{np.median([r[key] for r in group]):.3f}" if group else "-" for group, key in wanted]
    seconds = f"{np.median([r['seconds'] for r in found]):.2g}" if found else "-"
    return [label, loads, str(len(found)), str(len(found) - len(free)), *medians, seconds]


def figures(rows: list[dict]) -> dict:
    return {}
