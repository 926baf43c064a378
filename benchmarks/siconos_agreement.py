"""Siconos against the event-driven path at the same load steps; each difference explained.

Every load step is also solved on its own, from the exact state before it. The
exact state after it then either satisfies the one-step equations that Siconos
solves (closed nodes slip in one direction only, by v − v_old; open ones are
free) or it does not, because of what a node did within the step:

    closes      it was open before; the step counts its slip from the slip
                that it had while open, not from where it closed;
    opens, closes
                it was closed before and after, and open in between;
    stops       it slipped, and has left that limit again;
    reverses    it slipped both ways.

Where the exact state satisfies the equations, Siconos must agree, unless it
failed (its own state violates them) or they have two solutions.
"""

from dataclasses import replace
from functools import cache

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks import siconos_peer
from benchmarks.problems import random_problem
from shakedown import Problem
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import OPEN
from shakedown.joint.loading import loading
from shakedown.motion.checked_law import law_violation, reactions, scales
from shakedown.motion.event_history import EventHistory
from shakedown.motion.evolve import evolve
from shakedown.report.text_table import table

TITLE = "Siconos against the event-driven path: agreements, and why the others differ"
CYCLES = 2
TOLERANCE = {"nsgs": 1e-12, "lemke": 1e-12}
AGREES = 1e-8  # largest difference of slips and gaps, relative to the length scale
HOLDS = 1e-9  # violation of the one-step equations that counts as none
WHYS = ("closes", "opens, closes", "stops", "reverses")
CLASSES = ("agrees", *WHYS, "solver failed", "two solutions", "unexplained")


def cases(short: bool) -> list[dict]:
    if not siconos_peer.is_here():
        print(siconos_peer.ABSENT)
        return []
    seeds = 10 if short else 100
    return [
        {"seed": seed, "n": 1 + seed // 2 % 12, "separation": seed % 2 == 1, "solver": solver}
        for seed in range(seeds)
        for solver in TOLERANCE
    ]


@cache
def scene(seed: int, n: int, separation: bool) -> tuple[Problem, float, EventHistory]:
    """A problem, its load factor and its exact path; for separation the pressure is lowered."""
    problem = random_problem(n, seed=seed)
    load_factor = 1.3 * shakedown.upper_bound(problem, certify=False).load_factor
    if separation:
        q_w, p_w = loading(problem).at(load_factor)
        least = p_w.min(axis=0)
        problem = replace(problem, q_w=q_w, p_w=p_w - least - 0.15 * np.ptp(p_w, axis=0).max())
        load_factor = 1.0
    run = evolve(problem, load_factor, cycles=CYCLES)
    if run.stop is not None or any(cycle.jumps for cycle in run.cycles):
        raise RuntimeError(f"seed {seed}: the path is not unique, choose another problem")
    return problem, load_factor, run.history


def measure(case: dict) -> dict:
    problem, load_factor, history = scene(case["seed"], case["n"], case["separation"])
    size, m = scales(problem, load_factor), problem.m
    q_w, p_w = (np.tile(part, (CYCLES, 1)) for part in loading(problem).at(load_factor))
    exact = history.at(np.arange(CYCLES * m) / m)
    solver = case["solver"]

    def solve(q: FloatArray, p: FloatArray, slip: FloatArray) -> siconos_peer.Steps:
        return siconos_peer.solve_steps(problem, q, p, slip, solver, TOLERANCE[solver], size)

    free = solve(q_w[1:], p_w[1:], exact.v[0])
    each = solve(q_w[1:], p_w[1:], exact.v[:-1])
    apart = _difference(free, exact.v[1:], exact.w[1:]) / size.length
    words = [
        _explained(problem, load_factor, history, exact, each, k, q_w[k], p_w[k])
        for k in range(1, CYCLES * m)
    ]
    return {
        "opened": bool(history.w.max() > 0),
        "steps": len(words),
        "counts": {word: words.count(word) for word in CLASSES},
        "path_agrees": bool(apart.max() <= AGREES),
        "path_difference": float(apart.max()),
        "failures": each.failures,
        "seconds": each.seconds,
    }


def _difference(steps: siconos_peer.Steps, v: FloatArray, w: FloatArray) -> FloatArray:
    return np.maximum(np.abs(steps.v - v).max(axis=-1), np.abs(steps.w - w).max(axis=-1))


def _explained(problem, load_factor, history, exact, each, k: int, q_w, p_w) -> str:
    """The class of load step k, which leads from the exact state k − 1 to the exact state k."""
    size = scales(problem, load_factor)
    v, w = each.v[k - 1], each.w[k - 1]
    if max(np.abs(v - exact.v[k]).max(), np.abs(w - exact.w[k]).max()) <= AGREES * size.length:
        return "agrees"
    missed = one_step_violation(problem, q_w, p_w, exact.v[k], exact.w[k], exact.v[k - 1], size)
    if missed.max() > HOLDS:
        return _why(problem, history, exact, k, int(missed.argmax()))
    if one_step_violation(problem, q_w, p_w, v, w, exact.v[k - 1], size).max() > HOLDS:
        return "solver failed"
    return "two solutions"


def one_step_violation(problem, q_w, p_w, v, w, v_old, size) -> FloatArray:
    """By how much each node of a state breaks the equations of one load step, (n,)."""
    q, p = reactions(problem, q_w, p_w, v, w)
    slip = np.where(w > 1e-12 * size.length, 0.0, v - v_old)
    return law_violation(problem.f, q, p, w, slip, size)


def _why(problem: Problem, history: EventHistory, exact: EventHistory, k: int, node: int) -> str:
    """What the node did within the load step that its two ends do not show."""
    m = problem.m
    inside = (history.cycle > (k - 1) / m - 1e-12) & (history.cycle < k / m - 1e-12)
    states = history.state[inside, node]
    if exact.w[k - 1, node] > 0:
        return "closes"
    if (states == OPEN).any():
        return "opens, closes"
    slipping = states[states != 0]
    if len(set(slipping.tolist())) == 2:
        return "reverses"
    return "stops" if len(slipping) and states[-1] == 0 else "unexplained"


def tables(rows: list[dict]) -> str:
    if not rows:
        return f"  {siconos_peer.ABSENT}"
    body = []
    for solver in TOLERANCE:
        for separation in (False, True):
            mine = [r for r in rows if (r["solver"], r["separation"]) == (solver, separation)]
            if not mine:
                continue
            counts = [sum(r["counts"][word] for r in mine) for word in CLASSES]
            whole = sum(r["path_agrees"] for r in mine)
            where = "some nodes open" if separation else "closed"
            problems = f"{whole}/{len(mine)}"
            steps, reported = (str(sum(r[key] for r in mine)) for key in ("steps", "failures"))
            body.append([solver, where, problems, steps, *map(str, counts), reported])
    short = {"opens, closes": "open/close", "solver failed": "failed", "two solutions": "two"}
    names = [short.get(word, word) for word in CLASSES]
    headers = ["solver", "joints", "paths", "steps", *names, "reported"]
    differ = [r["path_difference"] for r in rows if r["path_agrees"]]
    notes = [
        "",
        f"  paths: problems whose whole path of {CYCLES} cycles agrees to {AGREES:.0e} of the length scale"
        + (f" (at most {max(differ):.0e})" if differ else ""),
        "  steps: each from the exact state before it; columns after 'agrees': why the others differ",
        "  failed: its own state breaks the equations of the step by more than 1e-9; two: two solutions",
        "  reported: steps on which the solver itself reported a failure",
    ]
    return "\n".join([table(headers, body, longest=10_000), *notes])


COLOURS = {
    "agrees": "#009E73",
    "closes": "#56B4E9",
    "opens, closes": "#0072B2",
    "stops": "#E69F00",
    "reverses": "#F0E442",
    "solver failed": "#D55E00",
    "two solutions": "#CC79A7",
    "unexplained": "#000000",
}


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(8.0, 3.2), layout="constrained")
    axes = figure.subplots()
    bars = [(solver, separation) for solver in TOLERANCE for separation in (False, True)]
    for y, (solver, separation) in enumerate(bars):
        mine = [r for r in rows if (r["solver"], r["separation"]) == (solver, separation)]
        total, left = sum(r["steps"] for r in mine) or 1, 0.0
        for word in CLASSES:
            share = 100 * sum(r["counts"][word] for r in mine) / total
            axes.barh(y, share, left=left, color=COLOURS[word], label=word if y == 0 else None)
            left += share
    names = [f"{solver}, {'some nodes open' if opened else 'in contact'}" for solver, opened in bars]
    axes.set_yticks(range(len(bars)), names)
    axes.invert_yaxis()
    axes.set(xlabel="load steps (%), each from the exact state before it")
    figure.legend(loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    return {"siconos-agreement": figure}
