"""Contact zones of random joints that the mean load opens, against pivots, polygons and the motion.

Random joints with one and two tangential directions, some nodes of which are pulled on; of up to six nodes
every zone is compared, of larger ones that which the search ends in. By other methods: the nodes that the
mean load opens without friction, by Lemke's pivots; λ_max of every zone, by linear programs over all load
steps, of discs between inscribed and circumscribed polygons; the safe slip, by reactions and gaps at every
load step; and what becomes of the joint from it, just below and just above.
"""

import os
import time
from itertools import combinations

import numpy as np
from scipy.optimize import linprog

import shakedown
from shakedown import Outcome, Problem, UsageError
from shakedown.bounds.opened_by_mean_load import opened_by_mean_load
from shakedown.report.text_table import table

TITLE = "Contact zones of joints that the mean load opens"
KINDS = {  # tangential directions, fewest and most nodes
    "plane": (1, 2, 6),
    "plane, larger": (1, 7, 12),
    "space": (2, 2, 5),
    "space, larger": (2, 7, 9),
    "space, floating": (2, 3, 5),
}
STEPS, JOINTS = 6, 10  # load steps of a joint, joints in a batch
SIDES = 48  # of a polygon: its inscribed and circumscribed radius are 0.2 % apart
NEAR = 1e-2  # relative distance from λ_max of what is simulated
EXACT, SAFE = 1e-7, 1e-7  # relative accuracy of linear programs; excess that a safe slip may have
FAILURES = ("other nodes open", "other λ_max", "slip not safe", "better zone", "moves below", "rests above")
COUNTS = ("joints", "zones", *FAILURES, "undecided")


def cases(short: bool) -> list[dict]:
    """Batches of ten joints; ZONE_BATCHES of each kind, 7 by default."""
    batches = 1 if short else int(os.environ.get("ZONE_BATCHES", "7"))
    kinds = ("plane", "space") if short else KINDS
    joints = 1 if short else JOINTS
    return [{"kind": kind, "seed": k, "joints": joints} for k in range(batches) for kind in kinds]


def measure(case: dict) -> dict:
    counts, began, number = dict.fromkeys(COUNTS, 0), time.process_time(), 0
    while counts["joints"] < case["joints"]:
        rng = np.random.default_rng([case["seed"], list(KINDS).index(case["kind"]), number])
        problem = random_joint(rng, *KINDS[case["kind"]], floating="floating" in case["kind"])
        opened, number = opened_by_pivots(problem), number + 1
        if 0 < len(opened) < problem.n:
            counts["joints"] += 1
            _compare(problem, opened, counts)
    return counts | {"drawn": number, "seconds": time.process_time() - began}


def random_joint(rng: np.random.Generator, d: int, least: int, most: int, floating: bool) -> Problem:
    """A joint under a mean load that presses most nodes and pulls on some; floating: friction holds it."""
    n = int(rng.integers(least, most + 1))
    root = rng.normal(size=((d + 1) * n, (d + 1) * n))
    kappa, t = root @ root.T / ((d + 1) * n) + 0.3 * np.eye((d + 1) * n), d * n
    p0 = rng.uniform(0.5, 2.0, n) - (rng.random(n) < 0.3) * rng.uniform(0.5, 3.0, n)
    q_w, p_w = 0.3 * rng.normal(size=(STEPS, t)), p0 + 0.15 * rng.normal(size=(STEPS, n))
    f = rng.uniform(0.1, 0.9, n)
    if floating:  # common slips cost nothing, change no pressure, and the mean load does no work on them
        rigid = np.vstack([np.tile(np.eye(d), (n, 1)), np.zeros((n, d))]) / np.sqrt(n)
        left = np.eye(len(kappa)) - rigid @ rigid.T
        kappa = left @ kappa @ left
        kappa = 0.5 * (kappa + kappa.T)
        q_w -= q_w.mean(axis=0) @ rigid[:t] @ rigid[:t].T
    return Problem(A=kappa[:t, :t], B=kappa[t:, :t], C=kappa[t:, t:], f=f, q_w=q_w, p_w=p_w)


def opened_by_pivots(problem: Problem) -> tuple[int, ...]:
    """Nodes that open under the mean load without friction: w ≥ 0 ⟂ p = M w + r ≥ 0, by Lemke's pivots."""
    q0, p0, n = problem.q_w.mean(axis=0), problem.p_w.mean(axis=0), problem.n
    follow = np.linalg.lstsq(problem.A, np.column_stack([problem.B.T, q0]), rcond=1e-9)[0]
    M, r = problem.C - problem.B @ follow[:, :-1], p0 - problem.B @ follow[:, -1]
    if r.min() >= 0:
        return ()
    tableau = np.hstack([np.eye(n), -M, -np.ones((n, 1)), r[:, None]])  # p, w, one unknown for all rows
    basis, row, entering = np.arange(n), int(r.argmin()), 2 * n
    while True:
        tableau[row] /= tableau[row, entering]
        others = np.arange(n) != row
        tableau[others] -= np.outer(tableau[others, entering], tableau[row])
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * n:
            return tuple(sorted(int(k) - n for k in basis if k >= n))
        entering = (leaving + n) % (2 * n)
        column = tableau[:, entering]
        ratios = np.where(column > 1e-12, tableau[:, -1] / np.where(column > 1e-12, column, 1.0), np.inf)
        row = int(ratios.argmin())


def condensed(problem: Problem, opened: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What a state u = (v, w) and a load make of (q, p) of closed nodes and w of open ones: K v + L r_w."""
    n, d, kappa = problem.n, problem.directions, problem.kappa
    closed = [i for i in range(n) if i not in opened]
    free = [d * i + k for i in opened for k in range(d)] + [d * n + i for i in opened]
    slips = np.array([d * i + k for i in closed for k in range(d)])
    u_of_v, u_of_load = np.zeros((len(kappa), len(slips))), np.zeros_like(kappa)
    u_of_v[slips, np.arange(len(slips))] = 1.0
    inverse = np.linalg.inv(kappa[np.ix_(free, free)])
    u_of_v[free] = -inverse @ kappa[np.ix_(free, slips)]
    u_of_load[np.ix_(free, free)] = -inverse
    gaps = [d * n + i for i in opened]
    K, L = kappa @ u_of_v, np.eye(len(kappa)) + kappa @ u_of_load
    K[gaps], L[gaps] = u_of_v[gaps], u_of_load[gaps]
    return K, L, slips


def largest_by_programs(problem: Problem, opened: tuple[int, ...], stretch: float) -> float:
    """λ_max of a zone with |q| ≤ f p as a polygon about the disc of ``stretch`` f p; −inf if it has none."""
    n, d, (K, L, slips) = problem.n, problem.directions, condensed(problem, opened)
    load = np.hstack([problem.q_w, problem.p_w]) @ L.T
    mean, swing = load.mean(axis=0), load - load.mean(axis=0)
    angles = 2 * np.pi * np.arange(SIDES) / SIDES if d == 2 else np.array([0.0, np.pi])
    rows, right = [], []
    for i in range(n):
        pressed, along = d * n + i, [d * i + k for k in range(d)]
        gap = np.zeros((1, len(L)))
        gap[0, pressed] = -1.0
        limits = np.zeros((len(angles), len(L)))
        limits[:, along] = np.column_stack([np.cos(angles), np.sin(angles)])[:, :d]
        limits[:, pressed] = -stretch * problem.f[i]
        for T in (gap,) if i in opened else (gap, limits):
            for step in swing:
                rows.append(np.column_stack([T @ K, T @ step]))
                right.append(-T @ mean)
    bounds = [(None, None)] * len(slips) + [(0.0, None)]
    cost = np.append(np.zeros(len(slips)), -1.0)
    found = linprog(cost, np.vstack(rows), np.concatenate(right), bounds=bounds)
    return {0: -found.fun if found.status == 0 else 0.0, 3: np.inf}.get(found.status, -np.inf)


def excess(problem: Problem, opened: tuple[int, ...], slip: np.ndarray, load_factor: float) -> float:
    """By how much a slip breaks a limit at some load step, relative to the largest load."""
    n, d, (K, L, slips) = problem.n, problem.directions, condensed(problem, opened)
    load = np.hstack([problem.q_w, problem.p_w])
    r = K @ slip[slips] + (load.mean(axis=0) + load_factor * (load - load.mean(axis=0))) @ L.T
    p, q = r[:, d * n :], np.linalg.norm(r[:, : d * n].reshape(-1, n, d), axis=2)
    held = ~np.isin(np.arange(n), opened)
    return float(max(-p.min(), (q - problem.f * p)[:, held].max()) / np.abs(load).max())


def _compare(problem: Problem, opened: tuple[int, ...], counts: dict) -> None:
    """One joint by all methods."""
    upper = shakedown.upper_bound(problem, open_nodes="auto")
    zone, found = upper.open_nodes, -np.inf if np.isnan(upper.load_factor) else upper.load_factor
    zones = [zone]
    if problem.n <= max(most for _, least, most in KINDS.values() if least < 7):
        zones = [chosen for k in range(problem.n) for chosen in combinations(range(problem.n), k)]
    inner = np.cos(np.pi / SIDES) if problem.directions == 2 else 1.0
    low = {each: largest_by_programs(problem, each, inner) for each in zones}
    high = largest_by_programs(problem, zone, 1.0)
    counts["zones"] += len(zones)
    counts["other nodes open"] += opened_by_mean_load(problem, friction=False) != opened
    counts["other λ_max"] += not low[zone] * (1 - EXACT) <= found <= high * (1 + EXACT)
    counts["better zone"] += max(low.values()) > found * (1 + EXACT)
    if upper.status != "optimal":
        return
    counts["slip not safe"] += excess(problem, zone, upper.slip, found) > SAFE
    below, above = (_outcome(problem, (1 + near) * found, upper) for near in (-NEAR, NEAR))
    counts["undecided"] += (below, above).count("undecided")
    counts["moves below"] += below != "rests"
    counts["rests above"] += above == "rests"


def _outcome(problem: Problem, load_factor: float, upper: shakedown.Bound) -> str:
    """What becomes of the state of a zone: it rests with these nodes open, or what else happens."""
    try:
        state = shakedown.long_term_state(problem, load_factor, upper.slip, open_nodes=upper.open_nodes)
    except UsageError:
        return "overlaps"  # under the first load
    rests = state.outcome == Outcome.SHAKEDOWN and state.open_nodes == upper.open_nodes
    return "rests" if rests else str(state.outcome)


def tables(rows: list[dict]) -> str:
    lines = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        chosen = [row for row in rows if row["kind"] == kind]
        sums = [str(sum(row[key] for row in chosen)) for key in COUNTS]
        lines.append([kind, *sums, f"{sum(row['seconds'] for row in chosen):.0f}"])
    return table(["kind", *COUNTS, "processor [s]"], lines)


def figures(rows: list[dict]) -> dict:
    return {}
