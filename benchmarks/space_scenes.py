"""Hard scenes with two tangential directions: the path from event to event against implicit steps."""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.implicit_joint import ImplicitJoint
from shakedown import Problem, Tolerances
from shakedown.ground.constants import FloatArray
from shakedown.motion.checked_law import scales
from shakedown.motion.event_history import path_violation
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import beginning, cycles_of
from shakedown.report.facts import table

TITLE = "Hard scenes in space: the path from event to event against implicit steps that grow shorter"
SEEDS = 10  # of every kind
CYCLES = 2
PARTS = (32, 64, 128)  # of a load step
FINER = (512, 2048)  # where these do not converge yet
CLOSER = 1.5  # ratio of errors when steps are halved, at least, where the steps converge to the path
SAME = 1e-7  # difference, relative to the length scale, that is round-off of both
CLOSE = 1e-2  # error of the shortest steps, at most
VERDICTS = ("agrees", "undecided", "no reference", "another solution", "differs", "wrong")
EXPLAINED = 100.0 * Tolerances().path  # violation within a step, where a polynomial stands for the path
LAWFUL = 1e-9  # violation of the law beyond what the accuracy of a path explains


def joint(rng: np.random.Generator, n: int, coupling: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Blocks of a definite stiffness, its coupling taken by a factor."""
    root = rng.normal(size=(3 * n, 3 * n))
    kappa = root @ root.T / (3 * n) + rng.uniform(0.1, 1.0) * np.eye(3 * n)
    return kappa[: 2 * n, : 2 * n], coupling * kappa[2 * n :, : 2 * n], kappa[2 * n :, 2 * n :]


def random_loop(rng: np.random.Generator, n: int, mean: float, amplitude: float) -> dict[str, Any]:
    """A few load steps, at random; normal ones about a mean."""
    m = int(rng.integers(3, 8))
    return {
        "q_w": 0.6 * rng.normal(size=(m, 2 * n)),
        "p_w": mean * rng.uniform(0.5, 1.5, n) + amplitude * rng.normal(size=(m, n)),
    }


def strong_coupling(rng: np.random.Generator) -> dict[str, Any]:
    n = int(rng.integers(2, 7))
    A, B, C = joint(rng, n, 1.0)
    return {"A": A, "B": B, "C": C, "f": rng.uniform(0.3, 0.9, n), **random_loop(rng, n, 1.5, 0.4)}


def lift_off(rng: np.random.Generator) -> dict[str, Any]:
    n = int(rng.integers(1, 6))
    A, B, C = joint(rng, n, rng.uniform(0, 0.7))
    return {"A": A, "B": B, "C": C, "f": rng.uniform(0.1, 0.6, n), **random_loop(rng, n, 0.6, 1.0)}


def near_apex(rng: np.random.Generator) -> dict[str, Any]:
    """Pressures that stay small, or just touch zero."""
    n = int(rng.integers(1, 5))
    A, B, C = joint(rng, n, rng.uniform(0, 0.5))
    loop = random_loop(rng, n, 1.0, 0.3)
    loop["p_w"] *= rng.uniform(1e-3, 3e-2)
    return {"A": A, "B": B, "C": C, "f": rng.uniform(0.2, 0.6, n), **loop}


def above_thresholds(rng: np.random.Generator) -> dict[str, Any]:
    n = int(rng.integers(1, 4))
    A, B, C = joint(rng, n, 1.0)
    return {"A": A, "B": B, "C": C, "f": rng.uniform(2.0, 10.0, n), **random_loop(rng, n, 2.0, 0.8)}


def ties(rng: np.random.Generator) -> dict[str, Any]:
    """Four nodes that a quarter turn exchanges, loaded alike: what happens to one happens to all."""
    a, b, c, d = rng.uniform(1.0, 2.0), rng.uniform(-0.3, 0.3), rng.uniform(-0.2, 0.2), rng.uniform(-0.3, 0.3)
    ring = a * np.eye(4) + b * np.roll(np.eye(4), 1, axis=0) + b * np.roll(np.eye(4), -1, axis=0)
    A = np.kron(ring + c * np.roll(np.eye(4), 2, axis=0), np.eye(2))
    B = np.kron(d * np.eye(4), [[1.0, 0.5]])
    m = int(rng.integers(3, 8))
    q_w = np.tile(0.8 * rng.normal(size=(m, 2)), 4)
    p_w = np.repeat(1.0 + rng.uniform(0.2, 1.2) * rng.normal(size=(m, 1)), 4, axis=1)
    return {"A": A, "B": B, "C": 2.0 * np.eye(4), "f": 0.4, "q_w": q_w, "p_w": p_w}


def inadmissible_start(rng: np.random.Generator) -> dict[str, Any]:
    given = lift_off(rng) if rng.random() < 0.5 else strong_coupling(rng)
    return given | {"initial_slip": rng.normal(size=given["A"].shape[0]) * rng.uniform(0.5, 3.0)}


def floating(rng: np.random.Generator) -> dict[str, Any]:
    """A body that friction alone holds: every common slip is free."""
    n = int(rng.integers(2, 6))
    A, B, C = joint(rng, n, rng.uniform(0, 0.3))
    rigid = np.kron(np.ones((n, 1)), np.eye(2)) / np.sqrt(n)
    away = np.eye(2 * n) - rigid @ rigid.T
    loop = random_loop(rng, n, 3.0, 0.5)
    q_w = loop["q_w"] @ away + 0.3 * rng.normal(size=(len(loop["q_w"]), 2)) @ rigid.T
    return {"A": away @ A @ away, "B": B @ away, "C": C, "f": rng.uniform(0.3, 0.7, n), **loop, "q_w": q_w}


def apex_exactly(rng: np.random.Generator) -> dict[str, Any]:
    """A node without tangential load or coupling whose pressure vanishes: it comes to the apex as it is."""
    n = int(rng.integers(2, 5))
    A, B, C = joint(rng, n, 0.0)
    A[:2, 2:], A[2:, :2], C[0, 1:], C[1:, 0] = 0.0, 0.0, 0.0, 0.0
    loop = random_loop(rng, n, 0.8, 0.9)
    loop["q_w"][:, :2] = 0.0
    return {"A": A, "B": B, "C": C, "f": rng.uniform(0.2, 0.6, n), **loop}


def without_friction(rng: np.random.Generator) -> dict[str, Any]:
    given = lift_off(rng)
    f = np.array(given["f"])
    f[rng.integers(len(f))] = 0.0
    return given | {"f": f}


def shapes_of_circles(rng: np.random.Generator) -> dict[str, Any]:
    """Many small load steps around, with rests and reversals: nodes stop and start again."""
    n, m = int(rng.integers(1, 5)), 24
    A, B, C = joint(rng, n, rng.uniform(0, 0.6))
    t = 2 * np.pi * np.arange(m)[:, None] / m
    t = np.where(t > np.pi, 2 * np.pi - t, t) if rng.random() < 0.5 else t
    q_w = rng.normal(size=2 * n) * np.cos(t) + rng.normal(size=2 * n) * np.sin(2 * t)
    return {"A": A, "B": B, "C": C, "f": 0.4, "q_w": q_w, "p_w": 1.5 + 0.4 * rng.normal(size=n) * np.sin(t)}


KINDS = {
    "strong coupling": strong_coupling,
    "lift-off": lift_off,
    "near the apex": near_apex,
    "above thresholds": above_thresholds,
    "ties": ties,
    "inadmissible start": inadmissible_start,
    "floating": floating,
    "at the apex": apex_exactly,
    "a node without friction": without_friction,
    "circles": shapes_of_circles,
}


def scene(kind: str, seed: int) -> Problem:
    """One scene of a kind."""
    rng = np.random.default_rng([list(KINDS).index(kind), seed])
    return Problem(**KINDS[kind](rng), name=f"{kind} {seed}")


def unique(problem: Problem) -> bool:
    """Whether the speeds are unique in contact for certain: the coupling is weaker than the stiffness."""
    coupling = np.linalg.norm(problem.f[:, None] * problem.B, 2)
    return bool(np.linalg.eigvalsh(problem.A)[0] > coupling)


def cases(short: bool) -> list[dict[str, Any]]:
    seeds = 1 if short else SEEDS
    return [{"kind": kind, "seed": seed} for kind in KINDS for seed in range(seeds)]


def measure(case: dict[str, Any]) -> dict[str, Any]:
    problem = scene(case["kind"], case["seed"])
    start = None if problem.initial_slip is None else problem.initial_slip[0]
    motion = Evolution(problem, 1.0, start)
    done = list(cycles_of(motion, CYCLES, record=True))
    row = {
        "n": problem.n,
        "unique": unique(problem),
        "stop": motion.stop.reason if motion.stop else "",
        "events": sum(cycle.events for cycle in done),
        "jumps": sum(len(cycle.jumps) for cycle in done),
        "opens": any(bool(cycle.opened.any()) for cycle in done),
        "estimate": max((cycle.error for cycle in done), default=0.0) / motion.scale.length,
        "violation": max(path_violation(problem, 1.0, Tolerances(), motion.history) - EXPLAINED, 0.0),
        "errors": [],
    }
    if motion.stop is None:
        row["errors"] = [distance(problem, start, motion, parts) for parts in PARTS]
        if verdict(row) in ("differs", "another solution"):
            row["errors"] = [distance(problem, start, motion, parts) for parts in (PARTS[-1], *FINER)]
    return row | {"verdict": verdict(row)}


def distance(problem: Problem, start: FloatArray | None, motion: Evolution, parts: int) -> float | None:
    """Of the state that implicit steps come to from that of the path, relative to the length scale."""
    end = implicit_end(problem, start, parts)
    return None if end is None else float(np.abs(end - motion.state.u).max() / motion.scale.length)


def implicit_end(problem: Problem, start: FloatArray | None, parts: int) -> FloatArray | None:
    """The state after the cycles by implicit steps, on the same course and ramp; None where they stop."""
    begun, split = beginning(problem, 1.0, start), problem.layout.split
    joint = ImplicitJoint(problem.A, problem.B, problem.C, problem.f, scales(problem, 1.0).force)
    joint.begin(*split(begun.state.u), *split(begun.load))
    for _ in range(CYCLES):
        if joint.follow(problem.q_w, problem.p_w, parts).solved < problem.m:
            return None
    return problem.layout.joined(joint.v, joint.w)


def verdict(row: dict[str, Any]) -> str:
    """What the implicit steps say of the path."""
    if row["stop"]:
        return "undecided"
    if row["violation"] > LAWFUL:
        return "wrong"
    if None in row["errors"]:
        return "no reference"
    first, *_, last = row["errors"]
    if last <= SAME or (last <= CLOSE and first >= CLOSER ** (len(PARTS) - 1) * last):
        return "agrees"
    return "differs" if row["unique"] and not row["jumps"] else "another solution"


def tables(rows: list[dict[str, Any]]) -> str:
    found = []
    for kind in KINDS:
        of_kind = [row for row in rows if row["kind"] == kind]
        if of_kind:
            counts = [sum(row["verdict"] == word for row in of_kind) for word in VERDICTS]
            last = [row["errors"][-1] for row in of_kind if row["verdict"] == "agrees"]
            opens, jumps = sum(row["opens"] for row in of_kind), sum(row["jumps"] > 0 for row in of_kind)
            numbers = map(str, (len(of_kind), *counts, opens, jumps))
            found.append([kind, *numbers, f"{max(last, default=np.nan):.1e}"])
    head = ["kind", "scenes", *VERDICTS, "open", "jump", f"error of {PARTS[-1]} steps"]
    return table(head, found)


def figures(rows: list[dict[str, Any]]) -> dict[str, Figure]:
    figure = Figure(figsize=(5.0, 3.5), layout="constrained")
    axes = figure.add_subplot()
    for row in rows:
        if row["errors"] and None not in row["errors"]:
            axes.loglog(PARTS, np.maximum(row["errors"], 1e-16), color="0.4", lw=0.6, alpha=0.6)
    axes.set_xlabel("implicit steps per load step")
    axes.set_ylabel("distance from the event-driven path,\nover the length scale")
    return {"space-scenes": figure}
