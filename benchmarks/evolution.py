"""Time integration: time per cycle against error, Gauss–Seidel and Siconos against the event-driven path."""

from dataclasses import replace
from functools import cache
from statistics import median

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks import siconos_peer
from benchmarks.display import curve, listed, panels
from benchmarks.problems import random_problem, refined
from benchmarks.timing import in_turn
from shakedown import Problem, Tolerances
from shakedown.joint.constraints import loading
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import EvolutionResult, evolve
from shakedown.motion.fixed_steps import FixedSteps

TITLE = "Time integration: time per cycle against error of the path"
CYCLES = 3
SHARP = (None, 1e-12, 1e-13)  # tolerances
TURNS = 3  # of a method and the event-driven path
UNCHECKED = 1e9  # a violation of the friction law is no reason to stop: loose steps are measured
SCENES = {
    "two-node": 0.8,
    "three-node": 2.6,
    "random 5": 1.3,
    "random 12": 1.3,
    "block-9": 5.0,
    "block-33": 5.5,
}


def cases(short: bool) -> list[dict]:
    scenes = ["two-node", "random 5", "block-9"] if short else list(SCENES)
    parts = [1, 4, 16] if short else [1, 2, 4, 8, 16, 32, 64]
    rows = []
    for scene in scenes:
        rows.append({"scene": scene, "method": "event", "parts": 1, "tolerance": None})
        rows += [{"scene": scene, "method": "gauss-seidel", "parts": k, "tolerance": 1e-13} for k in parts]
        rows += [
            {"scene": scene, "method": "gauss-seidel", "parts": 1, "tolerance": t}
            for t in (1e-4, 1e-8, 1e-10)
        ]
        if siconos_peer.is_here():
            rows += [{"scene": scene, "method": "nsgs", "parts": k, "tolerance": 1e-12} for k in parts[:5:2]]
            rows += [{"scene": scene, "method": "lemke", "parts": k, "tolerance": 1e-12} for k in parts[:3:2]]
    if not siconos_peer.is_here():
        print(siconos_peer.ABSENT)
    return rows


@cache
def scene(name: str) -> tuple[Problem, float, np.ndarray]:
    """Problem, load factor and an initial slip that is an equilibrium at the first load step."""
    word, _, size = name.partition(" ")
    problem = random_problem(int(size), seed=1) if word == "random" else shakedown.example(name)
    load_factor = SCENES[name]
    if word == "random":
        load_factor *= shakedown.upper_bound(problem).load_factor
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    first = replace(refined(problem, 1), q_w=problem.q_w[:1], p_w=problem.p_w[:1])
    return (
        problem,
        load_factor,
        shakedown.simulate(first, load_factor, start, cycles=1, method="gauss-seidel").final_slip,
    )


@cache
def reference(name: str) -> np.ndarray:
    """Slips of the event-driven path at the load steps of all cycles, (CYCLES * m, n)."""
    problem, load_factor, start = scene(name)
    run = evolve(problem, load_factor, start, cycles=CYCLES)
    assert run.stop is None
    return run.history.at(np.arange(CYCLES * problem.m) / problem.m).v


def measure(case: dict) -> dict:
    problem, load_factor, start = scene(case["scene"])
    parts = case["parts"]
    fine = refined(problem, parts)

    def event() -> EvolutionResult:
        return evolve(problem, load_factor, start, cycles=CYCLES)

    if case["method"] == "event":
        ((seconds, _),) = in_turn(event, runs=TURNS)
        own = seconds
        slips = (
            evolve(refined(problem, 7), load_factor, start, cycles=CYCLES)
            .history.at(np.arange(CYCLES * problem.m) / problem.m)
            .v
        )  # every load step split into 7: the path must not change
    elif case["method"] == "gauss-seidel":
        tolerances = Tolerances(convergence=case["tolerance"], friction_law=UNCHECKED)

        def steps() -> FixedSteps:
            motion = FixedSteps(fine, load_factor, start, tolerances)
            for _ in range(CYCLES):
                motion.cycle(record=True)
            return motion

        (seconds, motion), (own, _) = in_turn(steps, event, runs=TURNS)
        slips = motion.history.v[::parts]
    else:
        turns = [
            (_siconos(fine, load_factor, start, case), in_turn(event, runs=1)[0][0]) for _ in range(TURNS)
        ]
        seconds, own = median(peer.seconds for peer, _ in turns), median(own for _, own in turns)
        slips = turns[-1][0].v[::parts]
    path = reference(case["scene"])[: len(slips)]
    error = float(np.abs(slips - path).max() / np.ptp(reference(case["scene"]), axis=0).max())
    return {
        "n": problem.n,
        "seconds_per_cycle": seconds / CYCLES,
        "relative": seconds / own,
        "error": error,
    }


def _siconos(problem: Problem, load_factor: float, start: np.ndarray, case: dict) -> siconos_peer.Steps:
    q_w, p_w = (np.tile(part, (CYCLES, 1)) for part in loading(problem).at(load_factor))
    size = scales(problem, load_factor)
    return siconos_peer.solve_steps(problem, q_w, p_w, start, case["method"], case["tolerance"], size)


def tables(rows: list[dict]) -> str:
    columns = {
        "scene": "{scene}", "method": "{method}", "parts": "{parts}", "tol": "{tolerance:.0e}",
        "ms/cycle": lambda row: f"{1e3 * row['seconds_per_cycle']:.3f}", "time/event": "{relative:.2f}",
        "error": "{error:.1e}",
    }  # fmt: skip
    orders = [f"{name} {order:.2f}" for name, order in fitted_orders(rows).items()]
    return (
        f"{listed(rows, columns)}\n\nFitted order of Gauss–Seidel in the load step (theory: 1): "
        f"{', '.join(orders) or 'none'}.\nWhere it is not listed its load steps are exact: no node reverses "
        "or separates within one."
    )


def fitted_orders(rows: list[dict]) -> dict[str, float]:
    """Order of convergence of sharply solved Gauss–Seidel steps, where they are not exact already."""
    orders = {}
    for name in dict.fromkeys(row["scene"] for row in rows):
        steps = [row for row in rows if (row["scene"], row["method"]) == (name, "gauss-seidel")]
        parts, errors = np.array([[r["parts"], r["error"]] for r in steps if r["tolerance"] == 1e-13]).T
        if len(parts) > 2 and min(errors) > 1e-10:
            orders[name] = float(-np.polyfit(np.log(parts), np.log(errors), 1)[0])
    return orders


STYLES = {
    "event": ("o", "#000000", "event"),
    "gauss-seidel": ("s", "#0072B2", "Gauss–Seidel (hollow: loose)"),
    "nsgs": ("^", "#D55E00", "Siconos NSGS"),
    "lemke": ("v", "#CC79A7", "Siconos Lemke"),
}


def figures(rows: list[dict]) -> dict[str, Figure]:
    names = list(dict.fromkeys(row["scene"] for row in rows))
    figure, axes = panels(len(names))
    for axis, name in zip(axes, names, strict=True):
        for method, (marker, colour, label) in STYLES.items():
            chosen = [r for r in rows if (r["scene"], r["method"]) == (name, method)]
            sharp = [r | {"error": max(r["error"], 1e-17)} for r in chosen if r["tolerance"] in SHARP]
            loose = [r for r in chosen if r["tolerance"] not in SHARP]
            curve(axis, sharp, "error", "relative", marker, color=colour, ls=":", label=label)
            curve(axis, loose, "error", "relative", marker, color=colour, mfc="none", ls="")
        axis.set(title=name, xlabel="error of the slip path (relative)", ylabel="time / event-driven")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False)
    return {"evolution": figure}
