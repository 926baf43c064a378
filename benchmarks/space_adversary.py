"""Look for cyclic slip or lift-off in space below the load factor that least pressures prove.

Random joints with two tangential directions, under separate impulses, smooth loops and loops whose mean is
given apart, from weak coupling to as strong as the rates stay unique. Each is followed in small implicit
steps from locked-in slips up to thirty times too large, pressed onto their discs. A start that is admissible
and goes on slipping, is lifted off, or gains in the potential that should fall refutes the proof.
"""

import os

import numpy as np
from numba import njit

import shakedown
from shakedown import Problem
from shakedown.joint.loading import loading
from shakedown.report.text_table import table

TITLE = "Cyclic slip in space below the load factor proved from every state"
CYCLES, SUBSTEPS, SWEEPS = 600, 4, 3000
FADING = 0.7  # slip of the last cycle, by that of the one half way: it ceases, however slowly
FRACTIONS = (0.999, 0.9, 0.5)
REACHES = (0.3, 1.0, 5.0, 30.0)
SETTLED, CYCLING, LIFTED, LOST, INADMISSIBLE = range(5)
LOADS = ("impulses", "smooth", "off centre")
STRENGTHS = (0.3, 0.6, 0.95)  # of the coupling, relative to where the energy alone keeps the rates unique
TRIES = 400
BLOCK = "block-3x3"


def cases(short: bool) -> list[dict]:
    """Batches of joints; SPACE_BATCHES of each kind, 1 by default."""
    batches = 1 if short else int(os.environ.get("SPACE_BATCHES", "1"))
    joints, starts = (1, 6) if short else (3, 60)
    random = [
        {"n": n, "strength": strength, "loads": loads, "joints": joints, "starts": starts, "seed": seed}
        for seed in range(batches)
        for n in (1, 2, 3, 4, 6)
        for strength in STRENGTHS
        for loads in LOADS
    ]
    block = {"n": 9, "strength": 0.0, "loads": BLOCK, "joints": 1, "starts": starts, "seed": 0}
    return [*random, block]


def measure(case: dict) -> dict:
    rng = np.random.default_rng(
        [case["seed"], case["n"], *case["loads"].encode(), int(100 * case["strength"])]
    )
    counts = dict.fromkeys(
        ("runs", "cycling", "lifted", "lost", "inadmissible", "joints_proved", "cycling_above"), 0
    )
    growth = 0.0
    for _ in range(case["joints"]):
        problem = shakedown.example(BLOCK) if case["loads"] == BLOCK else drawn(rng, case)
        bound = shakedown.universal_bound(problem)
        counts["joints_proved"] += 1
        for fraction in FRACTIONS:
            ended, grown = attacked(rng, problem, bound, fraction, case["starts"])
            growth = max(growth, grown)
            counts["runs"] += int(ended[SETTLED] + ended[CYCLING] + ended[LIFTED])
            for name, number in (
                ("cycling", CYCLING),
                ("lifted", LIFTED),
                ("lost", LOST),
                ("inadmissible", INADMISSIBLE),
            ):
                counts[name] += int(ended[number])
        above, _ = attacked(rng, problem, bound, 3.0, case["starts"] // 4 + 1)
        counts["cycling_above"] += int(above[CYCLING] + above[LIFTED] > 0)
    return counts | {"growth": growth}


def drawn(rng: np.random.Generator, case: dict) -> Problem:
    """A random joint of a kind for which least pressures prove something."""
    for _ in range(TRIES):
        problem = random_joint(rng, case["n"], case["strength"], case["loads"])
        bound = shakedown.universal_bound(problem)
        if 0.0 < bound.load_factor < np.inf:
            return problem
    raise ValueError(f"none of {TRIES} joints of {case['n']} nodes has a bound")


def random_joint(rng: np.random.Generator, n: int, strength: float, loads: str) -> Problem:
    """Everything coupled to everything, B so large that the energy feeds a share of what slip stores."""
    root = rng.normal(size=(2 * n, 2 * n))
    A = np.eye(2 * n) + rng.uniform(0.1, 1.5) * root @ root.T / (2 * n)
    f, B = rng.uniform(0.2, 0.8, n), rng.normal(size=(n, 2 * n)) * rng.uniform(0.1, 1.0, (n, 1))
    half = np.linalg.inv(np.linalg.cholesky(A))
    F = np.repeat(f, 2)[:, None]
    eaten = 0.5 * (half @ (F * half.T)), 0.5 * (half @ (B.T * f) @ B @ half.T)
    c = np.sqrt(np.trace(eaten[1]) / np.trace(eaten[0]))
    B *= strength / np.linalg.eigvalsh(c * eaten[0] + eaten[1] / c)[-1]
    return Problem(A=A, B=B, f=f, **loop(rng, n, f, loads))


def loop(rng: np.random.Generator, n: int, f: np.ndarray, loads: str, d: int = 2) -> dict[str, np.ndarray]:
    """Separate impulses in random order, smooth, or impulses with a mean of their own."""
    p0 = rng.uniform(2.0, 8.0, n)
    q0 = 0.3 * rng.normal(size=d * n) * np.repeat(f * p0, d)
    if loads == "smooth":
        turn = 2.0 * np.pi * (np.arange(16)[:, None] / 16 + rng.random(d * n))
        q1, p1 = rng.uniform(0.2, 2.0, d * n) * np.cos(turn), rng.uniform(0, 1.5, n) * np.sin(turn[:, ::d])
        return {"q_w": q0 + q1, "p_w": p0 + p1}
    q1 = np.zeros((6 * n, d * n))
    for k, node in enumerate(rng.permutation(np.repeat(np.arange(n), 3))):
        angle = rng.uniform(0.0, 2.0 * np.pi)
        along = np.array([np.cos(angle), np.sin(angle)])[:d]
        q1[2 * k, d * node : d * (node + 1)] = rng.uniform(0.3, 2.0) * along
    p1 = (rng.random() < 0.3) * 0.5 * rng.normal(size=(6 * n, n))
    if loads == "off centre":
        q1, p1 = q1 + 0.3 * rng.normal(size=d * n), p1 + 0.3 * rng.normal(size=n)
        return {"q_w": q0 + q1, "p_w": p0 + p1, "q_mean": q0, "p_mean": p0}
    return {"q_w": q0 + q1, "p_w": p0 + p1}


def attacked(
    rng, problem: Problem, bound: shakedown.Bound, fraction: float, starts: int
) -> tuple[np.ndarray, float]:
    """How many starts ended in which way, and the relative growth of the potential in a step."""
    q_w, p_w = loading(problem).at(fraction * bound.load_factor)
    z = fraction * bound.pressures.reactions - (1.0 - fraction) * loading(problem).q0
    size = float(np.abs(p_w).max() * problem.f.max() / np.diag(problem.A).min())
    slips = size * rng.choice(REACHES, starts)[:, None] * rng.normal(size=(starts, 2 * problem.n))
    centre = np.linalg.solve(problem.A, z)
    return ends(problem.A, problem.B, problem.f, refined(q_w), refined(p_w), slips, centre, size)


def refined(path: np.ndarray) -> np.ndarray:
    """A closed path of loads in parts of its steps."""
    share, steps = np.arange(SUBSTEPS * len(path)) / SUBSTEPS, np.arange(len(path) + 1)
    closed = np.vstack([path, path[:1]])
    return np.stack([np.interp(share, steps, column) for column in closed.T], axis=1)


@njit(cache=True)
def ends(A, B, f, q_w, p_w, starts, centre, size):
    counts, growth = np.zeros(5, dtype=np.int64), 0.0
    for s in range(len(starts)):
        end, grown = end_of(A, B, f, q_w, p_w, starts[s].copy(), centre, size)
        counts[end] += 1
        growth = max(growth, grown)
    return counts, growth


@njit(cache=True)
def end_of(A, B, f, q_w, p_w, v, centre, size):
    """How a motion from a slip ends; and the largest relative growth of ½ (v − v*)ᵀA(v − v*) in a step."""
    status = step(A, B, f, q_w[0], p_w[0], v, size)  # onto the discs of the first load
    if status != SETTLED:
        return INADMISSIBLE, 0.0
    growth = 0.0
    e = v - centre
    energy = 0.5 * e @ (A @ e)
    half_way = np.inf
    for cycle in range(CYCLES):
        slipped = 0.0
        for k in range(1, len(q_w) + 1):
            before = v.copy()
            status = step(A, B, f, q_w[k % len(q_w)], p_w[k % len(q_w)], v, size)
            if status != SETTLED:
                return status, growth
            slipped += np.abs(v - before).max()
            e = v - centre
            now = 0.5 * e @ (A @ e)
            growth = max(growth, (now - energy) / (now + energy + 1e-300))
            energy = now
        if slipped <= 1e-10 * size:
            return SETTLED, growth
        if cycle == CYCLES // 2:
            half_way = slipped
    return (CYCLING if slipped > FADING * half_way else SETTLED), growth


@njit(cache=True)
def step(A, B, f, q_w, p_w, v, size):
    """One implicit step from v, in place: sweeps over the nodes, each solved alone."""
    n, old = len(f), v.copy()
    for _ in range(SWEEPS):
        change = 0.0
        for i in range(n):
            x, y = 2 * i, 2 * i + 1
            dx, dy = old[x] - v[x], old[y] - v[y]
            rx = q_w[x] + A[x] @ v + A[x, x] * dx + A[x, y] * dy
            ry = q_w[y] + A[y] @ v + A[y, x] * dx + A[y, y] * dy
            p = p_w[i] + B[i] @ v + B[i, x] * dx + B[i, y] * dy
            ok, sx, sy = alone(A[x, x], A[x, y], A[y, y], f[i] * B[i, x], f[i] * B[i, y], rx, ry, f[i] * p)
            if not ok:
                return LOST
            change = max(change, abs(old[x] + sx - v[x]), abs(old[y] + sy - v[y]))
            v[x], v[y] = old[x] + sx, old[y] + sy
        if change <= 1e-14 * size + 1e-15 * np.abs(v).max():
            p = p_w + B @ v
            return SETTLED if p.min() > 0 else LIFTED
    return LOST


@njit(cache=True)
def alone(axx, axy, ayy, bx, by, rx, ry, limit):
    """The slip of one node: none within its disc, else m u with r + m A u = −(limit + m b·u) u, by Newton."""
    r = np.sqrt(rx * rx + ry * ry)
    if r <= limit:
        return True, 0.0, 0.0
    angle, m = np.arctan2(-ry, -rx), 0.0
    for _ in range(60):
        c, s = np.cos(angle), np.sin(angle)
        hold = limit + m * (bx * c + by * s)
        fx = rx + m * (axx * c + axy * s) + hold * c
        fy = ry + m * (axy * c + ayy * s) + hold * s
        if abs(fx) + abs(fy) <= 1e-15 * (r + abs(limit)):
            return m >= 0.0, m * c, m * s
        turn = m * (-bx * s + by * c)
        tx, ty = (
            m * (-axx * s + axy * c) - hold * s + turn * c,
            m * (-axy * s + ayy * c) + hold * c + turn * s,
        )
        mx, my = axx * c + axy * s + (bx * c + by * s) * c, axy * c + ayy * s + (bx * c + by * s) * s
        det = tx * my - ty * mx
        if det == 0.0:
            return False, 0.0, 0.0
        da, dm = -(fx * my - fy * mx) / det, -(tx * fy - ty * fx) / det
        angle, m = angle + min(max(da, -1.0), 1.0), max(m + dm, 0.0)
    return abs(fx) + abs(fy) <= 1e-12 * (r + abs(limit)), m * c, m * s


def tables(rows: list[dict]) -> str:
    keys = ("joints_proved", "runs", "cycling", "lifted", "lost", "inadmissible")
    lines = []
    for loads in dict.fromkeys(row["loads"] for row in rows):
        group = [row for row in rows if row["loads"] == loads]
        sums = [str(sum(row[key] for row in group)) for key in keys]
        growth = max(row["growth"] for row in group)
        above = f"{sum(row['cycling_above'] for row in group)}"
        lines.append([loads, *sums, f"{growth:.1e}", above])
    headers = ["loads", "joints", "runs", "go on slipping", "lifted off", "lost", "no admissible start"]
    return table([*headers, "growth of V", "slip on at 3 λ_U"], lines)


def figures(rows: list[dict]) -> dict:
    return {}
