"""Joints in space: the path from event to event, implicit load steps and Siconos.

Paths: the error of the slips after one cycle against the event-driven path at its sharpest, which implicit
steps (Gauss–Seidel at fixed load steps) extrapolated to no step size must confirm. Siconos gets the same load
steps, each from the state that the implicit step before it left, so that it solves the same problems; the
residual is the law's, re-computed from the reactions. Its path has the error of implicit steps and costs what
its steps cost. Every solver has a budget: of Siconos' steps those within it are counted, and implicit steps
grow shorter as long as a cycle of them is within it; what they would need for smaller errors follows from
their first order. On a quiet core all of it takes some ten minutes.
"""

import subprocess
import time
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks import siconos_peer
from benchmarks.display import curve, listed, panels
from benchmarks.half_space import half_space
from benchmarks.implicit_steps import ImplicitSteps, Steps
from benchmarks.timing import in_turn
from shakedown import Problem, Tolerances
from shakedown.ground.constants import FloatArray
from shakedown.motion.checked_law import scales
from shakedown.motion.evolution import Evolution

TITLE = "Joints in space: the path from event to event, implicit steps and Siconos"
BLOCKS = {"25": (5, 5), "100": (10, 10), "250": (25, 10)}
LOADED = {"closed, few slip": (0.8, 0.0), "closed, most slip": (1.0, 0.0), "third open": (0.8, 3.0)}
PEERS = ("nsgs", "newton")
TOLERANCES = (1e-3, 1e-6, 1e-10)
PARTS = (1, 4, 16, 64, 256)
ACCURACIES = (1e-3, 1e-4, 1e-6, 1e-8, 1e-10)
STEPS = 20  # of a cycle of 40 that Siconos is timed on
MOST = {"nsgs": 20_000, "newton": 200}  # iterations
BUDGET = 4.0  # seconds of the processor that a peer gets for its steps, and implicit steps for a cycle
LONGEST = 60.0  # seconds on the clock, after which a peer that is within one step is ended
SLOW = 0.5  # seconds from where on a time is not taken again
SHARPEST = 1e-11


def cases(short: bool) -> list[dict]:
    sizes = ("25",) if short else tuple(BLOCKS)
    scenes = [f"{size}, {kind}" for size in sizes for kind in LOADED]
    tolerances, parts, accuracies = (
        ((1e-10,), PARTS[:2], (1e-4, 1e-8)) if short else (TOLERANCES, PARTS, ACCURACIES)
    )
    peers = PEERS if siconos_peer.is_here() else ()
    if not peers:
        print(siconos_peer.ABSENT)
    rows = []
    for scene in scenes:
        rows += [
            {"part": "steps", "scene": scene, "method": peer, "tolerance": tolerance}
            for peer in peers
            for tolerance in tolerances
        ]
        rows += [{"part": "paths", "scene": scene, "method": "implicit", "parts": k} for k in parts]
        rows += [{"part": "paths", "scene": scene, "method": "events", "accuracy": a} for a in accuracies]
    return rows


@cache
def scene(name: str) -> Problem:
    size, kind = name.split(", ", 1)
    return half_space(*BLOCKS[size], *LOADED[kind])


class _Begun:
    """A joint under the load at the end of a cycle, from where every method goes on."""

    def __init__(self, problem: Problem) -> None:
        self.problem, n = problem, problem.n
        self.joint = ImplicitSteps(problem.kappa, problem.f, 2, scales(problem, 1.0).force)
        self.v, self.w = np.zeros(2 * n), np.zeros(n)
        first = self.joint.follow(self.v, self.w, problem.q_w[[-1, -1]], problem.p_w[[-1, -1]])
        self.v, self.w = first.v[-1], first.w[-1]

    def follow(self, steps: int, parts: int = 1) -> Steps:
        rows = np.r_[-1, np.arange(steps)]
        return self.joint.follow(self.v, self.w, self.problem.q_w[rows], self.problem.p_w[rows], parts)


@cache
def begun(name: str) -> _Begun:
    return _Begun(scene(name))


def measure(case: dict) -> dict:
    return {"steps": _steps, "paths": _path}[case["part"]](case)


def _steps(case: dict) -> dict:
    """The load steps of implicit Euler by Siconos."""
    problem, start = scene(case["scene"]), begun(case["scene"])
    done = start.follow(STEPS)
    W, free = _compliances(problem, start, done)
    count = {
        "n": problem.n,
        "slipping": float((problem.law.size(done.slip) > 0).sum(axis=1).mean()),
        "open": float((done.w > 0).sum(axis=1).mean()),
    }
    how = {"solver": case["method"], "tolerance": case["tolerance"], "iterations": MOST[case["method"]]}
    try:
        found = siconos_peer.solved(W, free, problem.f, np.zeros(0), budget=BUDGET, timeout=LONGEST, **how)
    except (subprocess.TimeoutExpired, subprocess.CalledProcessError):
        return count | {"ms": -1.0, "residual": -1.0, "failures": len(free)}
    seconds, r = float(found.seconds.mean()), found.r
    residuals = [friction_residual(W, b, problem.f, each) for b, each in zip(free[: len(r)], r, strict=True)]
    failed = sum(not missed <= max(100 * case["tolerance"], 1e-8) for missed in residuals)
    finite = [missed for missed in residuals if np.isfinite(missed)]
    return count | {"ms": 1e3 * seconds, "residual": max(finite, default=-1.0), "failures": failed}


def _compliances(problem: Problem, start: _Begun, done: Steps) -> tuple[FloatArray, FloatArray]:
    """W (3n, 3n) and free displacements (k, 3n), normal first at every node, in units of the scales."""
    n, k, size = problem.n, len(done.v), scales(problem, 1.0)
    W, order = siconos_peer.compliance(problem, size)
    before = np.vstack([start.v, done.v[:-1]])
    free = -(np.hstack([problem.q_w, problem.p_w])[:k, order] / size.force) @ W
    # slip in the step counts from where a node touches
    touched = np.where(np.repeat(done.w > 0, 2, axis=1), before, done.v - done.slip) / size.length
    free[:, order < 2 * n] -= touched[:, order[order < 2 * n]]
    return W, free


def _events(name: str, accuracy: float) -> Evolution:
    """A motion from event to event whose next cycle is the one compared."""
    motion = Evolution(scene(name), 1.0, tolerances=Tolerances(path=accuracy))
    motion.cycle()
    return motion


def _cycle(motion: Evolution, name: str) -> FloatArray:
    """The slips at the end of the cycle from the common start; NaN where the motion stops."""
    start = begun(name)
    u = np.concatenate([start.v, start.w])
    motion.state = type(motion.state)(u, np.where(start.w > 0, 2, 0))
    done = motion.cycle()
    return np.full_like(start.v, np.nan) if done is None else done.end_slip


@cache
def reference(name: str) -> tuple[FloatArray, float]:
    """The slips at the end of the cycle, and the difference of extrapolated implicit steps, relative."""
    exact = _cycle(_events(name, SHARPEST), name)
    steps = scene(name).m
    done = [begun(name).follow(steps, parts) for parts in (8, 16, 32)]
    if any(len(each.v) < steps for each in done):
        return exact, float("nan")
    coarse, fine, finest = (each.v[-1] for each in done)
    extrapolated = (8 * finest - 6 * fine + coarse) / 3
    return exact, float(np.abs(extrapolated - exact).max() / np.abs(exact).max())


def _timed(function: Callable[[], Any]) -> tuple[float, Any]:
    """Processor time [s] of one call, and its result."""
    began = time.process_time()
    result = function()
    seconds = time.process_time() - began
    return (seconds, result) if seconds > SLOW else in_turn(function)[0]


SPENT: dict[str, float] = {}  # seconds that a cycle of implicit steps took last


def _path(case: dict) -> dict:
    name, problem = case["scene"], scene(case["scene"])
    exact, apart = reference(name)
    if case["method"] == "events":
        motion = _events(name, case["accuracy"])
        seconds, end = _timed(lambda: _cycle(motion, name))
    elif case["parts"] > 1 and SPENT.get(name, 0.0) > 0.5 * BUDGET:
        seconds, end = -1e-3, np.full_like(exact, np.nan)
    else:
        seconds, done = _timed(lambda: begun(name).follow(problem.m, case["parts"]))
        SPENT[name] = seconds
        end = done.v[-1] if len(done.v) == problem.m else np.full_like(exact, np.nan)
    error = float(np.abs(end - exact).max() / np.abs(exact).max())
    known = np.isfinite(error)
    return {
        "n": problem.n,
        "ms": 1e3 * seconds,
        "error": error if known else -1.0,
        "extrapolated": apart if np.isfinite(apart) else -1.0,
        "failures": int(not known and seconds > 0),
    }


def tables(rows: list[dict]) -> str:
    steps, paths = ([row for row in rows if row["part"] == part] for part in ("steps", "paths"))
    of_steps = {
        "scene": "{scene}", "slip": "{slipping:.0f}", "open": "{open:.0f}", "solver": "{method}",
        "tolerance": "{tolerance:.0e}", "ms/step": "{ms:.3f}", "residual": "{residual:.0e}",
        "failed": "{failures}",
    }  # fmt: skip
    of_paths = {
        "scene": "{scene}", "method": "{method}", "parts": "{parts}", "accuracy": "{accuracy:.0e}",
        "ms/cycle": "{ms:.2f}", "error": "{error:.1e}", "reference": "{extrapolated:.0e}",
    }  # fmt: skip
    text = f"Steps by Siconos (-1: too long)\n{listed(steps, of_steps)}\n\n" if steps else ""
    text += f"Paths: one cycle of 40 load steps (-1: over the budget)\n{listed(paths, of_paths)}\n"
    for error in (1e-4, 1e-6, 1e-8):
        for name, (own, others, siconos) in times(rows, error).items():
            text += (
                f"\n{name}: at {error:.0e} the events take {own:.1f} ms a cycle, implicit steps "
                f"{others / own:.1f} times that" + (f", Siconos {siconos / own:.0f}" if siconos else "")
            )
    return text


def times(rows: list[dict], error: float) -> dict[str, tuple[float, float, float]]:
    """Of scenes whose events reach an error: a cycle by events, implicit steps and Siconos (0: none) [ms]."""
    paths = [row for row in rows if row["part"] == "paths" and row["error"] > 0]
    found = {}
    for name in dict.fromkeys(row["scene"] for row in paths):
        euler = [row for row in paths if (row["scene"], row["method"]) == (name, "implicit")]
        events = [row for row in paths if (row["scene"], row["method"]) == (name, "events")]
        good = [row["ms"] for row in events if row["error"] <= error]
        if euler and good:
            found[name] = min(good), _needed(euler, error), _needed(_by_siconos(rows, name), error)
    return found


def _needed(euler: list[dict], error: float) -> float:
    """Time of implicit steps for an error [ms]: the shortest measured, else from the finest's first order."""
    if not euler:
        return 0.0
    good = [row["ms"] for row in euler if row["error"] <= error]
    finest = max(euler, key=lambda row: row["parts"])
    return min(good) if good else float(finest["ms"] * finest["error"] / error)


def _by_siconos(rows: list[dict], name: str) -> list[dict]:
    """The implicit paths of a scene at the time that as many steps of Siconos' quickest solver take."""
    quick = [
        row["ms"] for row in rows
        if (row["part"], row["scene"]) == ("steps", name) and 0.0 < row["tolerance"] <= 1e-6
        and row["ms"] > 0 and not row["failures"]
    ]  # fmt: skip
    return [
        row | {"ms": min(quick) * 2 * STEPS * row["parts"]}
        for row in rows
        if quick and row["part"] == "paths" and (row["scene"], row["method"]) == (name, "implicit")
        and row["error"] > 0
    ]  # fmt: skip


def figures(rows: list[dict]) -> dict[str, Figure]:
    paths = [row for row in rows if row["part"] == "paths" and row["error"] > 0]
    names = list(dict.fromkeys(row["scene"] for row in paths))
    figure, axes = panels(len(names))
    for axis, name in zip(axes, names, strict=True):
        for method, marker in (("events", "o-"), ("implicit", "s--")):
            mine = [row for row in paths if (row["scene"], row["method"]) == (name, method)]
            curve(axis, mine, "error", "ms", marker, label=method)
        curve(axis, _by_siconos(rows, name), "error", "ms", "^:", label="Siconos")
        axis.set(title=name, xlabel="error of the slips (relative)", ylabel="ms a cycle")
        axis.legend(fontsize="small")
    return {"space-peers": figure}


def friction_residual(W: FloatArray, q: FloatArray, mu: FloatArray, r: FloatArray) -> float:
    """How far reactions r (3n,) are from their projection onto the cones after a step along −(W r + q).

    Relative to the reaction that takes the largest velocity back.
    """
    reaction, velocity = r.reshape(-1, 3), (W @ r + q).reshape(-1, 3)
    softness = np.diag(W).reshape(-1, 3).mean(axis=1, keepdims=True)
    aim = reaction - velocity / softness
    pressed = np.maximum(aim[:, 0], 0.0)
    size, most = np.linalg.norm(aim[:, 1:], axis=1), mu * pressed
    slipping = aim[:, 1:] * np.minimum(1.0, most / np.where(size > 0.0, size, 1.0))[:, None]
    apart = np.abs(reaction - np.column_stack([pressed, slipping])).max()
    return float(apart / (np.abs(q).max() / np.diag(W).max()))
