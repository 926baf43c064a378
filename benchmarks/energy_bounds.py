"""How sharp the energy bound is, and what it costs.

λ_E, the load factor to which shakedown from slip zero is proved, beside λ_1 (first collapse), λ_T
(where the simulated joint stops shaking down) and λ_max: against the strength of the coupling,
against friction and against the mesh. Where slip zero is far from every safe slip λ_E falls
short of λ_T; then the number of cycles counts after which a simulated state is inside
the ball. Times are those of both programs in one process, by turns.
"""

import statistics
from collections.abc import Callable
from dataclasses import replace
from math import isfinite
from time import perf_counter

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks.problems import chain, joint, random_problem
from benchmarks.refinement import block_on_plane
from shakedown import Problem, energy_ball, energy_bound, transient_limit, upper_bound
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.motion.evolution import Evolution
from shakedown.report.facts import table

TITLE = "The energy bound: how sharp, and at what cost"
SHARES = (0.9, 0.98, 0.999)  # of λ_T
MOST_CYCLES = 64
SIZES = {"random": random_problem, "chain": chain}
RUNS = 5


def cases(short: bool) -> list[dict]:
    couplings, seeds = ((0.3, 1.0), 2) if short else ((0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5), 8)
    frictions = (0.2, 0.5) if short else (0.1, 0.2, 0.3, 0.4, 0.5)
    elements = (8,) if short else (8, 16, 32, 64)
    nodes = (10, 40) if short else (10, 20, 40, 60, 125, 250, 500)
    return [
        *({"study": "coupling", "value": c, "seed": seed} for c in couplings for seed in range(seeds)),
        *({"study": "friction", "value": f, "block": b} for b in ("block-9", "block-33") for f in frictions),
        *({"study": "mesh", "value": e, "f": f} for f in (0.2, 0.4) for e in elements),
        *({"study": "cost", "value": n, "joint": name} for name in SIZES for n in nodes),
    ]


def measure(case: dict) -> dict:
    if case["study"] == "cost":
        return cost(SIZES[case["joint"]](case["value"], seed=0))
    if case["study"] == "coupling":
        return sharpness(joint(case["seed"], n=6, coupling=case["value"]))
    if case["study"] == "friction":
        return sharpness(shakedown_example(case["block"], case["value"]))
    return sharpness(block_on_plane(case["value"], case["f"]))


def shakedown_example(name: str, f: float) -> Problem:
    """A built-in joint with another friction coefficient."""
    problem = shakedown.example(name)
    return replace(problem, f=np.full(problem.n, f))


def sharpness(problem: Problem) -> dict:
    """λ_1, λ_E and λ_T relative to λ_max, and cycles until a state is in a ball; null where undefined."""
    upper = upper_bound(problem, certify=False)
    if upper.status != "optimal":
        return {"nodes": problem.n, "upper": None}
    bound, lower = energy_bound(problem), shakedown.lower_bound(problem, certify=False)
    limit = transient_limit(problem, steps=20, accuracy=1e-5).load_factor
    found = {"first_collapse": lower.load_factor, "energy": bound.load_factor, "transient": limit}
    relative = {key: x / upper.load_factor if isfinite(x) else None for key, x in found.items()}
    cycles = [cycles_to_ball(problem, share * limit) if isfinite(limit) else None for share in SHARES]
    ratio = coupling(problem).ratio
    row = {"nodes": problem.n, "upper": upper.load_factor, "cycles": cycles, "status": str(bound.status)}
    return row | relative | {"coupling_ratio": ratio if isfinite(ratio) else None}


def cycles_to_ball(problem: Problem, load_factor: float) -> int | None:
    """Cycles from slip zero until a ball holds the state; None where it takes too many."""
    evolution = Evolution(problem, load_factor)
    n, no_gap = problem.n, 1e-12 * evolution.scale.length
    for cycle in range(1, MOST_CYCLES + 1):
        if evolution.cycle() is None:
            return None
        u = evolution.state.u
        if np.abs(u[n:]).max() > no_gap:
            continue
        if energy_ball(problem, load_factor, around=u[:n], transient=False).contains(u[:n]):
            return cycle
    return None


def cost(problem: Problem) -> dict:
    """Median times [ms] of the programs, run by turns after one run that is not counted."""
    load_factor = 0.5 * upper_bound(problem, certify=False).load_factor
    tasks: dict[str, Callable[[], object]] = {
        "upper": lambda: upper_bound(problem, certify=False),
        "bound": lambda: energy_bound(problem, certify=False),
        "ball": lambda: energy_ball(problem, load_factor),
    }
    times: dict[str, list[float]] = {task: [] for task in tasks}
    for run in range(RUNS + 1):
        for task, work in tasks.items():
            began = perf_counter()
            work()
            if run:
                times[task].append(perf_counter() - began)
    row = {f"{task}_ms": 1e3 * statistics.median(seconds) for task, seconds in times.items()}
    ratios = [statistics.median(np.divide(times[task], times["upper"])) for task in ("bound", "ball")]
    return row | {"nodes": problem.n, "bound_ratio": ratios[0], "ball_ratio": ratios[1]}


def tables(rows: list[dict]) -> str:
    parts = []
    for study in ("coupling", "friction", "mesh"):
        chosen = [row for row in rows if row["study"] == study]
        lines = [_line(study, group) for group in _groups(study, chosen)]
        headers = [study, "joints", "ρ", "λ_1/λ_max", "λ_E/λ_max", "λ_T/λ_max", "λ_E/λ_T"]
        headers += [f"cycles at {share:g} λ_T" for share in SHARES]
        parts += [f"against {study}, medians", table(headers, lines), ""]
    chosen = [row for row in rows if row["study"] == "cost"]
    lines = [
        [
            row["joint"],
            str(row["nodes"]),
            *(f"{row[key]:.1f}" for key in ("upper_ms", "bound_ms", "ball_ms")),
            *(f"{row[key]:.2f}" for key in ("bound_ratio", "ball_ratio")),
        ]
        for row in chosen
    ]
    headers = ["joint", "n", "λ_max ms", "λ_E ms", "R(λ) ms", "λ_E / λ_max", "R(λ) / λ_max"]
    return "\n".join([*parts, "cost", table(headers, lines)])


def _groups(study: str, rows: list[dict]) -> list[list[dict]]:
    """Joints of one coupling; the other studies have one joint per line."""
    if study != "coupling":
        return [[row] for row in rows]
    values = dict.fromkeys(row["value"] for row in rows)
    return [[row for row in rows if row["value"] == value and row["upper"] is not None] for value in values]


def _line(study: str, group: list[dict]) -> list[str]:
    first = group[0]
    label = {"coupling": "{value:g}", "friction": "{block}, f = {value:g}", "mesh": "n = {nodes}, f = {f:g}"}
    keys = ("coupling_ratio", "first_collapse", "energy", "transient")
    medians = [_median([row[key] for row in group]) for key in keys]
    shares = [row["energy"] / row["transient"] for row in group if row["energy"] and row["transient"]]
    cycles = [_median([row["cycles"][k] for row in group], "{:g}") for k in range(len(SHARES))]
    return [label[study].format(**first), str(len(group)), *medians, _median(shares), *cycles]


def _median(values: list, form: str = "{:.4f}") -> str:
    """The median of the values that there are; a dash where there is none."""
    known = [value for value in values if value is not None]
    return form.format(statistics.median(known)) if known else "-"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    left, right = figure.subplots(1, 2)
    joints = [row for row in rows if row["study"] == "coupling" and row["upper"] is not None]
    for key, label in (("first_collapse", "λ_1"), ("energy", "λ_E"), ("transient", "λ_T")):
        known = [row for row in joints if row[key] is not None and row["coupling_ratio"] is not None]
        left.plot(
            [row["coupling_ratio"] for row in known], [row[key] for row in known], "o", ms=3, label=label
        )
    left.set(xlabel="coupling ratio ρ", ylabel="relative to λ_max", xscale="log", ylim=(0, 1.05))
    timed = [row for row in rows if row["study"] == "cost"]
    for name in SIZES:
        series = [row for row in timed if row["joint"] == name]
        for key, style in (("upper_ms", "-"), ("bound_ms", "--"), ("ball_ms", ":")):
            label = f"{name}, {key.removesuffix('_ms')}"
            right.loglog([row["nodes"] for row in series], [row[key] for row in series], style, label=label)
    right.set(xlabel="nodes n", ylabel="time (ms)")
    for axis in (left, right):
        axis.legend(fontsize="small", frameon=False)
        axis.grid(True, alpha=0.3)
    return {"energy-bounds": figure}
