"""Look for cyclic slip below the first collapse where the coupling ratio is below 1.

Random joints with coupling ratios up to 0.9999 (and above 1, or floating, where the gauge of differences
applies: statement 8), among them relatives of the counter-examples
`three-node` and `pair-cycle` that are just weak enough. Below min(λ_1, λ_c) each is followed exactly
from extreme vertices of what is admissible at some load step, from points between them, and from very large
slips (which the first load step makes admissible, or which open a node: these are counted apart).
A run that starts closed and admissible and does not shake down refutes the theorem (docs/guarantee.md,
statement 3). Just above λ_1 the witness is the control.
"""

import os
from dataclasses import replace

import numpy as np

import shakedown
from benchmarks.adversary import scaled_to, symmetric
from benchmarks.universal_adversary import loaded
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.joint.loading import loading
from shakedown.report.text_table import table

TITLE = "Cyclic slip below the first collapse, for coupling ratios below 1"
BANDS = {"to 0.6": (0.3, 0.6), "to 0.9": (0.6, 0.9), "to 0.99": (0.9, 0.99), "to 0.9999": (0.99, 0.9999)}
BEYOND = {"from 1": (1.0, 1.05), "floating": (1.0, 1.0)}  # where only the gauge of differences proves it
SHAPES = ("dense", "star", "two movers", "chain")
LOADS = ("impulses", "smooth", "off centre")
FRACTIONS = (0.999, 0.97, 0.7)
JUST_ABOVE = 1.001
LARGE = 30.0  # slips in units of the largest admissible one
THREADS = 1
TRIES, PRESSED = 100, 0.2  # to draw a joint; pressure that each try adds, as most fail by lift-off

KEYS = (  # what is counted
    "joints_found",
    "runs",
    "failed",
    "undecided",
    "large",
    "large_otherwise",
    "witnesses",
    "witnesses_cycle",
)


def cases(short: bool) -> list[dict]:
    """COLLAPSE_BATCHES of each kind (1 by default; 6 make a million runs)."""
    batches = 1 if short else int(os.environ.get("COLLAPSE_BATCHES", "1"))
    joints, starts, sizes = (1, 12, (3,)) if short else (2, 300, (2, 3, 4, 6, 9))
    kinds = [(n, band, shape) for n in sizes for band in BANDS for shape in SHAPES]
    kinds += [(n, "from 1", shape) for n in sizes if n > 2 for shape in ("dense", "chain")]
    kinds += [(n, "floating", "floating") for n in sizes]
    return [
        {"n": n, "band": band, "shape": shape, "joints": joints, "starts": starts, "seed": seed}
        for seed in range(batches)
        for n, band, shape in kinds
    ]


def measure(case: dict) -> dict:
    """One kind of joint: how many runs there were, and how they ended."""
    bands, shapes = [*BANDS, *BEYOND], [*SHAPES, "floating"]
    key = [case["seed"], case["n"], bands.index(case["band"]), shapes.index(case["shape"])]
    rng = np.random.default_rng(key)
    counts = dict.fromkeys(KEYS, 0)
    ratios = []
    for number in range(case["joints"]):
        found = joint_of(rng, case, LOADS[number % len(LOADS)])
        if found is None:
            continue
        problem, limit, first = found
        counts["joints_found"] += 1
        ratios.append(coupling(problem).bound)
        for fraction in FRACTIONS:
            below(rng, turned(rng, problem), fraction * limit, case["starts"], counts)
        if first.node >= 0 and first.load_factor <= limit:
            counts["witnesses"] += 1
            state = shakedown.long_term_state(problem, JUST_ABOVE * first.load_factor, first.slip)
            counts["witnesses_cycle"] += state.outcome != "shakedown"
    return counts | {"largest_ratio": max(ratios, default=0.0)}


def joint_of(rng: np.random.Generator, case: dict, loads: str):
    """A joint, min(λ_1, λ_c) > 0, and its first collapse; None where none is found."""
    low, high = (BANDS | BEYOND)[case["band"]]
    argument = "differences" if case["band"] in BEYOND else "first collapse"
    for tried in range(TRIES):
        A, B = stiffness(rng, case["n"], case["shape"])
        if case["shape"] != "floating":
            A, B = scaled_to(A, B, rng.uniform(low, high))
        problem = pressed(loaded(rng, A, B, loads), PRESSED * tried)
        if not coupling(problem).bound >= 0.9 * low:
            continue
        first = shakedown.lower_bound(problem, certify=False)
        universal = shakedown.universal_bound(problem, first_collapse=first)
        if universal.argument == argument and 0.0 < universal.load_factor < np.inf:
            return problem, universal.load_factor, first
    return None


def pressed(problem: shakedown.Problem, more: float) -> shakedown.Problem:
    """The same joint with the mean pressure of every node raised: locked-in slip lifts it off less easily."""
    mean = None if problem.p_mean is None else problem.p_mean + more
    return replace(problem, p_w=problem.p_w + more, p_mean=mean)


def stiffness(rng: np.random.Generator, n: int, shape: str) -> tuple[np.ndarray, np.ndarray]:
    """A and B before they are scaled to a coupling ratio; those of a floating body as they are."""
    if shape == "floating":
        W = np.triu(rng.uniform(0.0, 1.0, (n, n)) ** 3, 1)
        B = rng.normal(size=(n, n)) * rng.uniform(0.05, 0.6) * (W + W.T + 0.1)
        return np.diag((W + W.T).sum(axis=1)) - W - W.T, B - np.diag(B.sum(axis=1))
    if shape == "dense" or n < 3:
        A = np.eye(n) + rng.uniform(0.05, 0.95) * symmetric(rng, n)
        size = 10.0 ** rng.uniform(-1.5, 0.5, (n, 1))  # strong ones are lifted off by locked-in slip
        return A, rng.normal(size=(n, n)) * size * (rng.random((n, n)) < 0.7)
    if shape == "chain":
        apart = np.abs(np.arange(n) - np.arange(n)[:, None])
        side = np.sign(apart - apart.T + np.arange(n) - np.arange(n)[:, None])
        A = np.eye(n) + rng.uniform(-0.6, 0.6) * (0.5**apart - np.eye(n))
        return A, rng.uniform(0.3, 3.0) * side * rng.uniform(0.5, 1.5, (n, n)) * 0.6**apart
    movers = 1 if shape == "star" or n < 4 else 2
    A, B, others = np.eye(n), np.zeros((n, n)), n - movers
    A[:movers, movers:] = rng.uniform(0.5, 1.0, others) / np.sqrt(others * movers)
    A[movers:, :movers] = A[:movers, movers:].T
    signs = rng.permutation((-1.0) ** np.arange(others)) * rng.uniform(2.0, 4.0)
    B[:movers, movers:] = signs * A[:movers, movers:] * rng.uniform(0.9, 1.1, (movers, others))
    return A, B


def turned(rng: np.random.Generator, problem: shakedown.Problem) -> shakedown.Problem:
    """The same loop, begun at another load step."""
    start = int(rng.integers(problem.m))
    loop = loading(problem)
    return replace(
        problem,
        q_w=np.roll(problem.q_w, -start, axis=0),
        p_w=np.roll(problem.p_w, -start, axis=0),
        q_mean=loop.q0,
        p_mean=loop.p0,
    )


def at_first_step(problem: shakedown.Problem, load_factor: float, shares: np.ndarray) -> np.ndarray:
    """Slips in which every node is at a share of the way from its forward to its backward limit (s, n)."""
    q, p = (welded[0] for welded in loading(problem).at(load_factor))
    fB, f = problem.f[:, None] * problem.B, problem.f
    own = np.diag(problem.A - fB), np.diag(problem.A + fB)
    upper, lower = shares / own[0], (1.0 - shares) / own[1]
    matrices = upper[:, :, None] * (problem.A - fB) + lower[:, :, None] * (problem.A + fB)
    right = upper * (f * p - q) - lower * (f * p + q)
    if np.abs(problem.A.sum(axis=1)).max() < 1e-9 * np.abs(problem.A).max():  # floating: one node anywhere
        held = int(abs(right[0, 0]) * 1e9) % problem.n
        matrices[:, held], right[:, held] = np.eye(problem.n)[held], 0.0
    return np.linalg.solve(matrices, right[:, :, None])[:, :, 0]


def admissible(problem: shakedown.Problem, load_factor: float, slips: np.ndarray) -> np.ndarray:
    q, p = (welded[0] for welded in loading(problem).at(load_factor))
    slack = problem.f * (p + slips @ problem.B.T) - np.abs(q + slips @ problem.A.T)
    return np.all(slack >= -1e-12 * np.abs(slack).max(), axis=1)


def below(
    rng: np.random.Generator, problem: shakedown.Problem, load_factor: float, starts: int, counts: dict
) -> None:
    """Corners of what is admissible, points between them, and slips that are far too large."""
    n = problem.n
    corners = rng.integers(0, 2, (starts // 2, n)).astype(float)
    slips = at_first_step(problem, load_factor, np.vstack([corners, rng.random((starts // 4, n))]))
    slips = slips[admissible(problem, load_factor, slips)]
    outcome = ends(problem, load_factor, slips)
    counts["runs"] += len(slips)
    counts["undecided"] += int(np.sum(outcome == "undecided"))
    counts["failed"] += int(np.sum((outcome != "shakedown") & (outcome != "undecided")))
    large = LARGE * np.abs(slips).max() * rng.normal(size=(starts // 4, n))
    outcome = ends(problem, load_factor, large)
    counts["large"] += len(large)
    counts["large_otherwise"] += int(np.sum(outcome != "shakedown"))


def ends(problem: shakedown.Problem, load_factor: float, slips: np.ndarray) -> np.ndarray:
    return shakedown.long_term_states(problem, load_factor, slips, threads=THREADS).outcome


def tables(rows: list[dict]) -> str:
    """Per band of coupling ratios."""
    lines = []
    for band in BANDS | BEYOND:
        chosen = [row for row in rows if row["band"] == band]
        if chosen:
            largest = max(row["largest_ratio"] for row in chosen)
            lines.append([band, f"{largest:.6f}", *_sums(chosen)])
    headers = ["coupling", "largest ρ*", *(key.replace("_", " ") for key in KEYS)]
    return table(headers, [*lines, ["all", "", *_sums(rows)]])


def _sums(rows: list[dict]) -> list[str]:
    return [str(sum(row[key] for row in rows)) for key in KEYS]


def figures(rows: list[dict]) -> dict:
    return {}
