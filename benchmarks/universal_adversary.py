"""Look for cyclic slip below a load factor that is proved from every initial state.

Random joints, made to be difficult: separate impulses in shuffled order, smooth loops, loops whose
mean is given apart, strong and unsymmetric coupling. Each is followed from very large initial slips at
load factors up to just below the one that is proved, in small implicit steps. A start that is
admissible under the first load and goes on slipping, or is lifted off, refutes the proof.
"""

import os
from dataclasses import replace
from functools import cache

import numpy as np
from numba import njit

import shakedown
from benchmarks.adversary import scaled_to, symmetric
from shakedown.bounds.every_state.bound_from_every_state import least_pressure_bound
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.bounds.uniqueness.in_contact import unique_in_contact
from shakedown.joint.constraints import constraints
from shakedown.joint.loading import loading
from shakedown.report.text_table import table

TITLE = "Cyclic slip below the load factor proved from every initial state"
CYCLES, SUBSTEPS = 400, 4
FRACTIONS = (0.999, 0.97, 0.8, 0.4)
REACHES = (0.3, 1.0, 5.0, 30.0)
SETTLED, CYCLING, LIFTED, LOST, INADMISSIBLE = range(5)
BANDS = {"weak": (0.1, 1 / 3), "middle": (1 / 3, 0.6), "below one": (0.6, 0.999), "strong": (1.0, 2.0)}
LOADS = ("impulses", "smooth", "off centre")
DENSE_UP_TO = 4  # nodes: of larger ones that are strongly coupled hardly any has a first collapse above zero
TRIES = 5000  # to draw a joint with a unique motion and a first collapse above zero: one in 100 is, or more
SWEEPS, TRIED_UP_TO = 2000, 6
BLOCK_FRICTION = (0.1, 0.2, 0.3)


def cases(short: bool) -> list[dict]:
    """Batches of joints; UNIVERSAL_BATCHES of each kind (1 by default) make some million runs."""
    batches = 1 if short else int(os.environ.get("UNIVERSAL_BATCHES", "1"))
    joints, starts = (1, 8) if short else (2, 2500)
    kinds = [(n, band, loads) for n in (2, 3, 4, 5, 6) for band in BANDS for loads in LOADS]
    random = [
        {"n": n, "coupling": band, "loads": loads, "joints": joints, "starts": starts, "seed": seed}
        for seed in range(batches)
        for n, band, loads in kinds
    ]
    blocks = [
        {"n": 9, "coupling": "block-9", "friction": f, "joints": 1, "starts": starts, "seed": seed}
        for seed in range(batches)
        for f in BLOCK_FRICTION
    ]
    return random + blocks


def measure(case: dict) -> dict:
    rng = np.random.default_rng([case["seed"], case["n"], *case["coupling"].encode()])
    counts = dict.fromkeys(("runs", "cycling", "lifted", "lost", "inadmissible", "joints_proved"), 0)
    counts |= {"searched_between": 0, "cycling_between": 0, "cycling_above": 0}
    shares = []
    for _ in range(case["joints"]):
        problem, first, limit = _joint(rng, case)
        if not 0.0 < limit < np.inf:
            continue
        counts["joints_proved"] += 1
        shares.append(limit / first)
        for fraction in FRACTIONS:
            ended = attacked(rng, problem, fraction * limit, case["starts"])
            counts["runs"] += int(ended[SETTLED] + ended[CYCLING] + ended[LIFTED])
            for name, number in (("cycling", CYCLING), ("lifted", LIFTED), ("lost", LOST)):
                counts[name] += int(ended[number])
            counts["inadmissible"] += int(ended[INADMISSIBLE])
        if limit < 0.98 * first:
            between = attacked(rng, problem, 0.5 * (limit + first), case["starts"])
            counts["searched_between"] += 1
            counts["cycling_between"] += int(between[CYCLING] > 0)
        above = attacked(rng, problem, 1.1 * first, case["starts"] // 4)
        counts["cycling_above"] += int(above[CYCLING] > 0)
    return counts | {"share": float(np.median(shares)) if shares else None}


def _joint(rng: np.random.Generator, case: dict) -> tuple[shakedown.Problem, float, float]:
    if "friction" in case:
        return _block(case["friction"])
    return proved(difficult(rng, case["n"], case["coupling"], case["loads"]))


@cache
def _block(friction: float) -> tuple[shakedown.Problem, float, float]:
    return proved(replace(shakedown.example("block-9"), f=friction))


def proved(problem: shakedown.Problem) -> tuple[shakedown.Problem, float, float]:
    """A joint, its first collapse, and what least pressures prove of it.

    The arguments that reach λ_1 are left out here: they have a study of their own (``collapse_adversary``).
    """
    lower = shakedown.lower_bound(problem, certify=False)
    if lower.status != "optimal" or lower.load_factor <= 0:
        return problem, np.nan, np.nan
    lift = shakedown.universal_bound(problem, first_collapse=lower).lift_off_bound
    pressures = least_pressure_bound(problem, unique=True).load_factor
    return problem, lower.load_factor, min(pressures, lower.load_factor, lift)


def difficult(rng: np.random.Generator, n: int, band: str, loads: str) -> shakedown.Problem:
    """A joint with a coupling ratio in a band, a unique motion and a first collapse above zero."""
    low, high = BANDS[band]
    star = band == "strong" and n > DENSE_UP_TO
    for _ in range(TRIES):
        A, B = scaled_to(*(_star(rng, n) if star else _dense(rng, n)), rng.uniform(low, high))
        problem = loaded(rng, A, B, loads)
        if star:
            problem = _held_down(rng, problem)
        ratio = coupling(problem).ratio
        if not low <= ratio <= high or (high > 1.0 and not unique_in_contact(problem)):
            continue
        if 0.0 < shakedown.lower_bound(problem, certify=False).load_factor < np.inf:
            return problem
    raise ValueError(f"none of {TRIES} joints of {n} nodes is {band}, unique and without collapse")


def _dense(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Everything coupled to everything."""
    A = np.eye(n) + rng.uniform(0.05, 0.95) * symmetric(rng, n)
    return A, rng.normal(size=(n, n)) * rng.uniform(0.2, 3.0, (n, 1)) * (rng.random((n, n)) < 0.7)


def _star(rng: np.random.Generator, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Everything coupled to node 0 alone, half of it pressing, half relieving: motion is unique."""
    A, B = np.eye(n), np.zeros((n, n))
    A[0, 1:] = A[1:, 0] = rng.uniform(0.5, 1.0, n - 1) / np.sqrt(n - 1)
    B[0, 1:] = 2.0 * rng.permutation((-1.0) ** np.arange(n - 1)) * rng.uniform(0.6, 1.4) * A[0, 1:] * (n - 1)
    return A, B


def _held_down(rng: np.random.Generator, problem: shakedown.Problem) -> shakedown.Problem:
    """A star whose node 0 is pressed on by more than any slip of the others can relieve."""
    a, b, f = problem.A[0, 1:], problem.B[0, 1:], problem.f
    p0 = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    slip = f[1:] * p0[1:] + np.abs(problem.q_w[:, 1:]).max(axis=0)
    own = (np.abs(problem.q_w[:, 0]).max() + np.abs(a) @ slip) / (1.0 - a @ a)
    more = rng.uniform(0.2, 0.8) * (np.abs(b) @ slip + abs(a @ b) * own)
    p_w, p_mean = problem.p_w.copy(), None if problem.p_mean is None else problem.p_mean.copy()
    p_w[:, 0] += more
    if p_mean is not None:
        p_mean[0] += more
    return replace(problem, p_w=p_w, p_mean=p_mean)


def loaded(rng: np.random.Generator, A: np.ndarray, B: np.ndarray, loads: str) -> shakedown.Problem:
    """A joint pressed together, under separate impulses, a smooth loop, or one whose mean lies elsewhere."""
    n = len(A)
    p0 = rng.uniform(2, 8, n)
    q0 = rng.uniform(-0.2, 0.2, n) * p0
    if loads == "smooth":
        m = 12
        turn = 2 * np.pi * (np.arange(m)[:, None] / m + rng.random(n))
        q1, p1 = rng.uniform(0.2, 2, n) * np.cos(turn), rng.uniform(0, 1.5, n) * np.sin(turn + rng.random(n))
        return shakedown.Problem(A=A, B=B, f=0.5, q_w=q0 + q1, p_w=p0 + p1)
    m = int(rng.integers(2 * n, 4 * n + 1))
    q1 = np.zeros((m, n))
    order = rng.permutation(np.repeat(np.arange(n), 2))
    q1[np.arange(2 * n), order] = rng.choice([-1, 1], 2 * n) * rng.uniform(0.2, 2, 2 * n)
    p1 = (rng.random() < 0.3) * 0.5 * rng.normal(size=(m, n))
    if loads == "off centre":
        q1, p1 = q1 + 0.3 * rng.normal(size=n), p1 + 0.3 * rng.normal(size=n)
    return shakedown.Problem(A=A, B=B, f=0.5, q_w=q0 + q1, p_w=p0 + p1, q_mean=q0, p_mean=p0)


def attacked(
    rng: np.random.Generator, problem: shakedown.Problem, load_factor: float, starts: int
) -> np.ndarray:
    """How many starts ended in which way."""
    rows, f = constraints(problem), problem.f
    loop = loading(problem)
    steps = np.stack([loop.q1 - f * loop.p1, -loop.q1 - f * loop.p1], axis=2).reshape(problem.m, -1)
    corners = np.concatenate([steps, steps[:1]])
    share = np.arange(SUBSTEPS * problem.m) / SUBSTEPS
    fine = np.stack([np.interp(share, np.arange(problem.m + 1), column) for column in corners.T], axis=1)
    allowed = rows.g - load_factor * fine
    size = np.abs(allowed).max() / np.abs(np.diag(problem.A)).min()
    centre = shakedown.safe_slip(problem, load_factor).slip
    if not np.all(np.isfinite(centre)):  # beyond λ_max
        centre = shakedown.safe_slip(problem, 0.5 * load_factor).slip
    reach = rng.choice(REACHES, starts)[:, None]
    slips = centre + size * reach * rng.normal(size=(starts, problem.n))
    return ends(rows.G, allowed, slips, CYCLES, size)


@njit(cache=True)
def ends(G, allowed, starts, cycles, size):
    counts = np.zeros(5, dtype=np.int64)
    for s in range(len(starts)):
        counts[end_of(G, allowed, starts[s].copy(), cycles, size)] += 1
    return counts


@njit(cache=True)
def end_of(G, allowed, v, cycles, size):
    """How one start ends. The first load step puts the slips within their limits, wherever they were."""
    m, late = allowed.shape[0], 0.0
    if not step(G, allowed[0], v) or collapsed(G, allowed[0], v, size):
        return INADMISSIBLE
    for cycle in range(cycles):
        slipped = 0.0
        for k in range(1, m + 1):
            before = v.copy()
            if not step(G, allowed[k % m], v):
                return LOST
            if collapsed(G, allowed[k % m], v, size):
                return LIFTED
            slipped += np.abs(v - before).sum()
        if slipped <= 1e-12 * size:
            return SETTLED
        if cycle == cycles // 2:
            late = slipped
    return CYCLING if slipped > 1e-7 * size and slipped > 0.5 * late else SETTLED


@njit(cache=True)
def limits(G, allowed, v, j):
    upper, lower = allowed[2 * j], -allowed[2 * j + 1]
    for i in range(len(v)):
        if i != j:
            upper -= G[2 * j, i] * v[i]
            lower += G[2 * j + 1, i] * v[i]
    return lower / -G[2 * j + 1, j], upper / G[2 * j, j]


@njit(cache=True)
def step(G, allowed, v):
    """One implicit load step of nodes that stay closed, by Gauss–Seidel sweeps; false if it does not end.

    Above ρ = 1 they need not settle; then, in joints of few nodes, the one combination of sticking and
    slipping nodes that holds is looked for.
    """
    before = v.copy()
    for _ in range(SWEEPS):
        change = 0.0
        for j in range(len(v)):
            lower, upper = limits(G, allowed, v, j)
            target = min(max(before[j], lower), upper) if lower <= upper else 0.5 * (lower + upper)
            change = max(change, abs(target - v[j]))
            v[j] = target
        if not np.all(np.isfinite(v)):
            break
        if change < 1e-13 * (1.0 + np.abs(v).max()):
            return True
    return len(v) <= TRIED_UP_TO and by_trial(G, allowed, before, v)


@njit(cache=True)
def by_trial(G, allowed, before, v):
    """The load step by trial: every node sticks (0) or is at its upper (1) or lower (2) limit."""
    n = len(v)
    size = np.abs(allowed).max() + np.abs(G).max() * np.abs(before).max()
    for number in range(3**n):
        matrix, right, rest = np.zeros((n, n)), np.zeros(n), number
        for j in range(n):
            state, rest = rest % 3, rest // 3
            if state == 0:
                matrix[j, j], right[j] = 1.0, before[j]
            else:
                matrix[j], right[j] = G[2 * j + state - 1], allowed[2 * j + state - 1]
        if abs(np.linalg.det(matrix)) < 1e-12:
            continue
        found, rest, holds = np.linalg.solve(matrix, right), number, True
        excess = G @ found - allowed
        for j in range(n):
            state, rest = rest % 3, rest // 3
            moved = (found[j] - before[j]) * (2 * state - 3) if state else 0.0
            holds = holds and moved >= 0.0 and max(excess[2 * j], excess[2 * j + 1]) <= 1e-12 * size
        if holds:
            v[:] = found
            return True
    return False


@njit(cache=True)
def collapsed(G, allowed, v, size):
    """Whether the two limits of some node have crossed: it would lift off."""
    for j in range(len(v)):
        lower, upper = limits(G, allowed, v, j)
        if lower > upper + 1e-9 * (size + np.abs(v).max()):
            return True
    return False


KEYS = (
    "joints_proved",
    "runs",
    "cycling",
    "lifted",
    "lost",
    "inadmissible",
    "searched_between",
    "cycling_between",
    "cycling_above",
)


def tables(rows: list[dict]) -> str:
    """Per kind of joint; the last four columns count joints, at half way to λ_1 and at 1.1 λ_1."""
    lines = []
    for band, n in sorted({(r["coupling"], r["n"]) for r in rows}):
        chosen = [r for r in rows if (r["coupling"], r["n"]) == (band, n)]
        shares = [r["share"] for r in chosen if r["share"] is not None]
        lines.append([band, str(n), *_sums(chosen), f"{np.median(shares):.3f}" if shares else "-"])
    headers = ["coupling", "n", *(key.replace("_", " ") for key in KEYS), "λ_U / λ_1"]
    return table(headers, [*lines, ["all", "", *_sums(rows), ""]])


def _sums(rows: list[dict]) -> list[str]:
    return [str(sum(row[key] for row in rows)) for key in KEYS]


def figures(rows: list[dict]) -> dict:
    return {}
