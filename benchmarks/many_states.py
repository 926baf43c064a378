"""Long-term states by the thousand: a batch in compiled code against a loop over the single search."""

import time
from functools import cache

import numpy as np
from matplotlib.figure import Figure

import shakedown
from shakedown import Outcome
from shakedown.fem import ElasticBody, Material, Pressure, Traction, block_mesh, contact_problem
from shakedown.motion.contact_law import scales
from shakedown.report.text_table import table

TITLE = "Many long-term states: a batch against a loop, CPU time per state"
SPREAD = 0.3  # half the width of the box of initial slips, in length scales of the joint
ROUNDS = 5  # batch and loop take turns, so that whatever else the machine does meets both
COMPARED = 20  # states of a round that are also found one by one
# Joint, load factor over λ_max, states, threads; the first is that of the thesis, λ = 0.70.
CASES = (
    ("two-node", None, 1_000_000, 1),
    ("block-9", 0.5, 10_000, 1),
    ("block-9", 1.2, 10_000, 1),
    ("block 250", 0.5, 1_000, 2),
    ("block 250", 0.9, 1_000, 2),
    ("block 250", 1.2, 1_000, 2),
)
SHORT = (("two-node", None, 10_000, 1), ("block-9", 1.2, 1_000, 1), ("block 33", 1.2, 100, 2))


def cases(short: bool) -> list[dict]:
    return [
        {"joint": joint, "above": above, "states": states, "threads": threads}
        for joint, above, states, threads in (SHORT if short else CASES)
    ]


@cache
def joint_of(name: str) -> tuple[shakedown.Problem, float]:
    """A joint and its λ_max."""
    nodes = name.partition(" ")[2]
    if not nodes:
        problem = shakedown.example(name)
    else:
        elements = int(nodes) - 1
        body = ElasticBody(
            block_mesh(2.0, 1.0, elements, elements // 2),
            Material(young=200e3, poisson=0.3),
            loads=[
                Pressure("top", 10.0, history=np.ones(24)),
                Traction("top", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
            ],
        )
        problem = contact_problem(body, "bottom", f=0.4, steps=24)
    return problem, shakedown.upper_bound(problem).load_factor


def measure(case: dict) -> dict:
    problem, limit = joint_of(case["joint"])
    load_factor = 0.70 if case["above"] is None else case["above"] * limit
    scale = scales(problem, load_factor)
    slips = np.random.default_rng(0).uniform(-1, 1, (case["states"], problem.n)) * SPREAD * scale.length
    shakedown.long_term_states(problem, load_factor, slips[:1])  # compiles
    shakedown.long_term_state(problem, load_factor, slips[0])
    found, batch, alone, differ, far = [], 0.0, 0.0, 0, 0.0
    began = time.perf_counter()
    for rows in np.array_split(slips, ROUNDS):
        cpu = time.process_time()
        states = shakedown.long_term_states(problem, load_factor, rows, threads=case["threads"])
        batch += time.process_time() - cpu
        found.append(states)
        cpu = time.process_time()
        singles = [shakedown.long_term_state(problem, load_factor, slip) for slip in rows[:COMPARED]]
        alone += time.process_time() - cpu
        for row, one in enumerate(singles):
            differ += (states.outcome[row], states.period[row]) != (one.outcome, one.period)
            far = max(far, float(np.abs(states.final_slip[row] - one.final_slip).max()) / scale.length)
    per_state, per_single = batch / case["states"], alone / (ROUNDS * COMPARED)
    outcomes = np.concatenate([states.outcome for states in found])
    return {
        "n": problem.n,
        "m": problem.m,
        "load_factor": load_factor,
        "outcomes": {outcome.value: int((outcomes == outcome.value).sum()) for outcome in Outcome},
        "cycles": float(np.mean(np.concatenate([states.cycles_simulated for states in found]))),
        "cpu_s": batch,
        "per_state_s": per_state,
        "loop_per_state_s": per_single,
        "ratio": per_single / per_state,
        "elapsed_s": time.perf_counter() - began,
        "compared": ROUNDS * COMPARED,
        "differ": int(differ),
        "largest_difference": far,
    }


def tables(rows: list[dict]) -> str:
    lines = [
        [
            row["joint"], f"{row['load_factor']:.3g}", f"{row['states']:,}", f"{row['cpu_s']:.1f}",
            _time(row["per_state_s"]), _time(row["loop_per_state_s"]), f"{row['ratio']:.1f}",
            f"{row['differ']} of {row['compared']}",
            f"{row['largest_difference']:.0e}",
        ]
        for row in rows
    ]  # fmt: skip
    head = ["joint", "λ", "states", "CPU [s]", "per state", "in a loop", "ratio", "differ", "Δv"]
    return table(head, lines)


def _time(seconds: float) -> str:
    return f"{1e6 * seconds:.0f} µs" if seconds < 1e-3 else f"{1e3 * seconds:.2f} ms"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(5.6, 3.6), layout="constrained")
    axes = figure.add_subplot()
    names = [f"{row['joint']}\nλ = {row['load_factor']:.3g}" for row in rows]
    places = np.arange(len(rows))
    axes.bar(places - 0.2, [1e3 * row["per_state_s"] for row in rows], 0.4, label="batch")
    axes.bar(places + 0.2, [1e3 * row["loop_per_state_s"] for row in rows], 0.4, label="one by one")
    axes.set(yscale="log", ylabel="CPU time per state [ms]")
    axes.set_xticks(places, names, fontsize=7)
    axes.legend()
    return {"many_states": figure}
