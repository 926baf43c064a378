"""Look for cyclic slip, drift or lift-off of bodies that friction alone holds, below λ_U.

Random joints in the plane and in space in which rigid slips change nothing: translations, or translations
and rotation; with a given normal force or without; one friction coefficient or many. Each is followed in
small implicit steps from locked-in slips up to thirty times too large, pressed onto their friction limits.
A start that is admissible and goes on slipping, drifts or is lifted off refutes the proof.
"""

import os

import numpy as np

import shakedown
from benchmarks.space_adversary import (
    CYCLING,
    INADMISSIBLE,
    LIFTED,
    LOADS,
    LOST,
    REACHES,
    SETTLED,
    ends,
    loop,
    refined,
)
from shakedown import Problem
from shakedown.joint.loading import loading
from shakedown.report.text_table import table

TITLE = "Cyclic slip of floating bodies below the load factor proved from every state"
KINDS = ("plane", "translations", "rotation")
FRACTIONS = (0.999, 0.9, 0.5)
TRIES = 300


def cases(short: bool) -> list[dict]:
    """Batches of joints; FLOATING_BATCHES of each kind, 1 by default."""
    batches = 1 if short else int(os.environ.get("FLOATING_BATCHES", "1"))
    joints, starts = (1, 6) if short else (4, 60)
    return [
        {"n": n, "kind": kind, "loads": loads, "joints": joints, "starts": starts, "seed": seed}
        for seed in range(batches)
        for n in (2, 3, 4, 5)
        for kind in KINDS
        for loads in LOADS
    ]


def measure(case: dict) -> dict:
    rng = np.random.default_rng([case["seed"], case["n"], *case["kind"].encode(), *case["loads"].encode()])
    names = {"cycling": CYCLING, "lifted": LIFTED, "lost": LOST, "inadmissible": INADMISSIBLE}
    counts = dict.fromkeys(("joints", "runs", *names, "failing_above"), 0)
    growth, shares = 0.0, []
    for _ in range(case["joints"]):
        problem, bound = drawn(rng, case)
        counts["joints"] += 1
        shares.append(bound.load_factor / shakedown.upper_bound(problem, certify=False).load_factor)
        for fraction in FRACTIONS:
            ended, grown = attacked(rng, problem, bound, fraction, case["starts"])
            growth = max(growth, grown)
            counts["runs"] += int(ended[SETTLED] + ended[CYCLING] + ended[LIFTED])
            for name, number in names.items():
                counts[name] += int(ended[number])
        above, _ = attacked(rng, problem, bound, 3.0, case["starts"] // 4 + 1)
        counts["failing_above"] += int(above[CYCLING] + above[LIFTED] > 0)
    return counts | {"growth": growth, "share": float(np.median(shares))}


def drawn(rng: np.random.Generator, case: dict) -> tuple[Problem, shakedown.Bound]:
    """A random joint of which something is proved."""
    for _ in range(TRIES):
        problem = floating_joint(rng, case["n"], case["kind"], case["loads"])
        bound = shakedown.universal_bound(problem)
        if 0.0 < bound.load_factor < np.inf:
            return problem, bound
    raise ValueError(f"none of {TRIES} joints of {case['n']} nodes has a bound")


def floating_joint(rng: np.random.Generator, n: int, kind: str, loads: str) -> Problem:
    """Everything coupled to everything, but for rigid motions."""
    d = 1 if kind == "plane" else 2
    x = rng.normal(size=(n, 2))
    Z = np.kron(np.ones((n, 1)), np.eye(d))
    if kind == "rotation":
        Z = np.column_stack([Z, np.stack([-x[:, 1], x[:, 0]], axis=1).ravel()])
    away = np.eye(d * n) - Z @ np.linalg.pinv(Z)
    root = rng.normal(size=(d * n, d * n))
    A = away @ (np.eye(d * n) + rng.uniform(0.1, 1.5) * root @ root.T / (d * n)) @ away
    B = rng.normal(size=(n, d * n)) @ away
    if rng.random() < 0.5:  # a given normal force
        B -= B.mean(axis=0)
    f = rng.uniform(0.2, 0.8, n)
    f = f if rng.random() < 0.5 else np.full(n, f[0])
    B *= rng.uniform(0.05, 0.6) / np.linalg.norm(np.linalg.pinv(A) @ (f[:, None] * B).T, 2)
    return Problem(A=0.5 * (A + A.T), B=B, f=f, **loop(rng, n, f, loads, d))


def attacked(
    rng: np.random.Generator, problem: Problem, bound: shakedown.Bound, fraction: float, starts: int
) -> tuple[np.ndarray, float]:
    """How many starts ended in which way, and by how much a known potential grew in a step at most."""
    q_w, p_w = loading(problem).at(fraction * bound.load_factor)
    size = float(np.abs(p_w).max() * problem.f.max() / np.diag(problem.A).min())
    slips = size * rng.choice(REACHES, starts)[:, None] * rng.normal(size=(starts, len(problem.A)))
    slips = slips @ np.linalg.pinv(problem.A) @ problem.A  # a rigid part would be round-off of the potential
    A, B, q_w, slips = in_space(problem, q_w, slips)
    centre, known = np.zeros(len(A)), bound.pressures
    if known is not None:
        z = known.mean_reactions + fraction * (known.reactions - known.mean_reactions)
        centre = np.linalg.pinv(A) @ in_space(problem, z)[2]
    ended, growth = ends(A, B, problem.f, refined(q_w), refined(p_w), slips, centre, size)
    return ended, growth if known is not None else 0.0


def in_space(problem: Problem, *slips: np.ndarray) -> list[np.ndarray]:
    """A, B and slips of a joint in the plane with a second direction in which nothing happens."""
    if problem.directions == 2:
        return [problem.A, problem.B, *slips]
    n = problem.n
    A, B = np.eye(2 * n), np.zeros((n, 2 * n))
    A[::2, ::2], B[:, ::2] = problem.A, problem.B
    spread = np.kron(np.eye(n), [1.0, 0.0])
    return [A, B, *(each @ spread for each in slips)]


def tables(rows: list[dict]) -> str:
    keys = ("joints", "runs", "cycling", "lifted", "lost", "inadmissible", "failing_above")
    lines = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        group = [row for row in rows if row["kind"] == kind]
        sums = [str(sum(row[key] for row in group)) for key in keys]
        growth, share = max(row["growth"] for row in group), np.median([row["share"] for row in group])
        lines.append([kind, *sums, f"{growth:.1e}", f"{share:.3f}"])
    headers = ["kind", "joints", "runs", "go on slipping", "lifted off", "lost", "no admissible start"]
    return table([*headers, "fail at 3 λ_U", "growth of V", "λ_U / λ_max"], lines)


def figures(rows: list[dict]) -> dict:
    return {}
