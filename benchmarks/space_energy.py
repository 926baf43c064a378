"""λ_E and R(λ) with two tangential directions: how much the split gains, the time, a second method, runs.

Without the split (c = 0), with half of A_ii⁻¹ B_ii, and with the best shares (``split=True``), relative to
λ_max: built-in joints, blocks of hexahedra on a rigid plane, random joints. The second method is the plain
statement of the program, a cone per node and load step in raw slips, by Clarabel through cvxpy; times are
those of the processor, in one process by turns. Motions from event to event, from the surface of the
largest ball, look for a state that leaves it.
"""

import time
import warnings
from math import isfinite

import numpy as np

import shakedown
from shakedown import EnergyBall, Problem, energy_ball, energy_bound
from shakedown.fem import ElasticBody, Material, Pressure, Traction, brick_mesh, contact_problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading
from shakedown.motion.evolution import evolve
from shakedown.report.facts import table

TITLE = "The energy ball in space: what the split gains, what it costs, and a second method"
BUILT_IN = ("one-node-3d", "two-node-3d", "four-node-3d", "block-3x3")
STEPS = 24  # of a loop of blocks
PLAIN_UP_TO = 121  # nodes of the second method
CYCLES = 30  # of a run
DIRECTIONS = 8  # from the centre of a ball
REACHES = (1.0, 1.5, 3.0)  # radii from it
STILL = 1e-6  # slip in the last cycle, relative to the largest, that counts as none
SLOWING = 0.9  # slip of the last cycle, relative to that of the one halfway: it dies away
HALF = 0.5


def cases(short: bool) -> list[dict]:
    built_in = BUILT_IN[:2] if short else BUILT_IN
    grids = (2,) if short else (2, 4, 6, 9, 15)
    seeds = 2 if short else 20
    return [
        *({"study": "built-in", "joint": name} for name in built_in),
        *({"study": "block", "elements": k, "friction": f} for k in grids for f in (0.3, 0.5)),
        *({"study": "random", "n": n, "seed": seed} for n in (2, 5, 8) for seed in range(seeds)),
        *({"study": "surface", "seed": seed} for seed in range(3 * seeds)),
    ]


def measure(case: dict) -> dict:
    if case["study"] == "surface":
        return runs(random_joint(1 + case["seed"] % 6, case["seed"]), case["seed"])
    if case["study"] == "random":
        return sharpness(random_joint(case["n"], case["seed"]))
    if case["study"] == "block":
        return sharpness(block(case["elements"], case["friction"]))
    return sharpness(shakedown.example(case["joint"]))


def block(elements: int, f: float) -> Problem:
    """A square block on a rigid plane, pressed and drawn round at its top; (elements + 1)² nodes."""
    t = 2 * np.pi * np.arange(STEPS) / STEPS
    loads = (
        Pressure("top", 1.0, history=1.0),
        Traction("top", (0.1, 0.0, 0.0), history=np.cos(t)),
        Traction("top", (0.0, 0.08, 0.0), history=np.sin(t)),
    )
    mesh = brick_mesh((1.0, 1.0, 0.5), (elements, elements, 3))
    body = ElasticBody(mesh, Material(1.0, 0.3), loads=loads)
    return contact_problem(body, "bottom", f)


def sharpness(problem: Problem) -> dict:
    """λ_E without and with the split, and by the second method, relative to λ_max; times [s]."""
    upper = shakedown.upper_bound(problem, certify=False).load_factor
    row: dict = {"nodes": problem.n, "upper": upper if isfinite(upper) else None}
    for name, split in (("zero", False), ("split", True)):
        bound, seconds = timed(lambda split=split: energy_bound(problem, split=split, certify=False))
        row |= {
            name: _finite(bound.load_factor / upper),
            f"{name}_s": seconds,
            f"{name}_gap": _finite(bound.gap),
        }
        ball = energy_ball(problem, HALF * upper, split=split) if isfinite(upper) else None
        row[f"{name}_radius"] = None if ball is None else _finite(ball.radius)
    if problem.n <= PLAIN_UP_TO:
        for name, share in (("plain", 0.0), ("half", HALF)):
            found, seconds = timed(lambda share=share: plainly(problem, share))
            row |= {name: _finite(found / upper), f"{name}_s": seconds}
    return row


def _finite(number: float) -> float | None:
    return number if isfinite(number) else None


def timed(work) -> tuple:
    begin = time.process_time()
    return work(), time.process_time() - begin


def plainly(problem: Problem, part: float) -> float:
    """λ_E from slip zero with this part of A_ii⁻¹ B_ii as share, a cone each load step; NaN: none."""
    import cvxpy as cp

    n, loop, f = problem.n, loading(problem), problem.f
    force, stiffness = float(np.abs(problem.p_w).max()), float(np.abs(problem.A).max())
    A, B = problem.A / stiffness, problem.B / stiffness
    share = part * own_shares(problem)
    rest = B - np.einsum("ij,ijk->ik", share, A.reshape(n, 2, -1))
    values, vectors = np.linalg.eigh(A)
    kept = values > 1e-9 * values[-1]
    root = (vectors[:, kept] * np.sqrt(values[kept])).T
    gamma = np.linalg.norm(rest @ (vectors[:, kept] / np.sqrt(values[kept])), axis=1)
    stretch = np.sqrt(1 + f**2 * (share**2).sum(axis=1))
    v, radius, factor = cp.Variable(2 * n), cp.Variable(nonneg=True), cp.Variable(nonneg=True)
    limits = [cp.norm(root @ v) <= radius]
    q, p = loop.q0 / force + A @ v, loop.p0 / force + B @ v
    for q1, p1 in zip(loop.q1 / force, loop.p1 / force, strict=True):
        drawn = cp.reshape(q + factor * q1, (2, n), order="F") @ np.diag(stretch)
        limits.append(cp.SOC(cp.multiply(f, p + factor * p1 - gamma * radius), drawn))
    task = cp.Problem(cp.Maximize(factor), limits)
    with warnings.catch_warnings():  # "may be inaccurate"
        warnings.simplefilter("ignore", UserWarning)
        try:
            task.solve(solver="CLARABEL")
        except cp.SolverError:
            return np.nan
    return float(task.value) if task.status in ("optimal", "optimal_inaccurate") else np.nan


def own_shares(problem: Problem) -> FloatArray:
    """A_ii⁻¹ B_ii of every node, (n, 2)."""
    n, nodes = problem.n, np.arange(problem.n)
    blocks = problem.A.reshape(n, 2, n, 2)[nodes, :, nodes, :]
    return np.linalg.solve(blocks, problem.B.reshape(n, n, 2)[nodes, nodes][..., None])[..., 0]


def random_joint(n: int, seed: int, *, friction: float = 0.5, m: int = 12) -> Problem:
    """A random joint with strong coupling, pressed together about a random slip, loads out of phase."""
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(3 * n, 3 * n))
    kappa = root @ root.T / (3 * n) + 0.1 * np.eye(3 * n)
    A, B, C = kappa[: 2 * n, : 2 * n], kappa[2 * n :, : 2 * n], kappa[2 * n :, 2 * n :]
    f, t = friction * rng.uniform(0.5, 1.5, n), 2 * np.pi * np.arange(m)[:, None] / m
    locked, p0 = 0.3 * rng.normal(size=2 * n), rng.uniform(2, 5, n)
    q0 = 0.3 * (f * p0).repeat(2) * rng.uniform(-1, 1, 2 * n) - A @ locked
    q = 0.5 * (rng.normal(size=2 * n) * np.cos(t) + rng.normal(size=2 * n) * np.sin(t))
    p = 0.3 * (rng.normal(size=n) * np.cos(2 * t) + rng.normal(size=n) * np.sin(t))
    return Problem(A=A, B=B, C=C, f=f, q_w=q0 + q, p_w=p0 - B @ locked + p)


def runs(problem: Problem, seed: int) -> dict:
    """Motions from the surface of the largest ball, from 1.5 and 3 radii: how many leave it, or slip on."""
    rng = np.random.default_rng(seed)
    found: dict = {
        f"{part}_{reach:g}": 0 for part in ("runs", "slow", "failed", "undecided") for reach in REACHES
    }
    found |= {"growth": 0.0}
    upper = shakedown.upper_bound(problem, certify=False)
    if upper.status != "optimal" or not upper.load_factor > 0:
        return found
    load_factor = rng.uniform(0.2, 0.95) * upper.load_factor
    ball = energy_ball(problem, load_factor, split=bool(seed % 2))
    if ball.status != "optimal" or not ball.radius > 0:
        return found
    for reach in REACHES:
        for direction in rng.normal(size=(DIRECTIONS, ball.metric.inverse.shape[1])):
            outcome, growth = followed(problem, ball, ball.at(direction, reach * (1.0 - 1e-9)))
            found[f"runs_{reach:g}"] += 1
            if outcome != "shakedown":
                found[f"{outcome}_{reach:g}"] += 1
            if reach == 1.0:
                found["growth"] = max(found["growth"], growth)
    return found


def followed(problem: Problem, ball: EnergyBall, start: FloatArray) -> tuple[str, float]:
    """What becomes of a motion, and by how much it moves away from the centre, relative to where it was."""
    try:
        history = evolve(problem, ball.load_factor, start, cycles=CYCLES).history
    except shakedown.SolverError:
        return "undecided", 0.0
    if history is None:
        return "undecided", 0.0
    away = ball.distance(history.v)
    least = np.minimum.accumulate(away)
    growth = float(np.max(away / least - 1.0))
    opened = float(np.abs(history.w).max()) > 0
    last = len(history.v) // CYCLES
    slips = [
        np.ptp(history.v[k * last : (k + 1) * last + 1], axis=0).max() for k in (CYCLES // 2, CYCLES - 1)
    ]
    if opened:
        return "failed", growth
    if slips[1] <= STILL * np.abs(history.v).max():
        return "shakedown", growth
    return ("slow" if slips[1] <= SLOWING * slips[0] else "failed"), growth


def tables(rows: list[dict]) -> str:
    parts = []
    for study in ("built-in", "block", "random"):
        chosen = [row for row in rows if row["study"] == study]
        headers = [
            "joint",
            "n",
            "λ_E/λ_max: c = 0",
            "half",
            "split",
            "R: split/0",
            "0, s",
            "split, s",
            "plain, s",
            "0 − plain",
        ]
        if study == "random":
            lines = [_medians(n, [row for row in chosen if row["n"] == n]) for n in _sizes(chosen)]
        else:
            lines = [_line(row) for row in chosen]
        parts += [study, table(headers, lines), ""]
    surface = [row for row in rows if row["study"] == "surface"]
    lines = [
        [
            f"{reach:g} R",
            *(
                str(sum(row[f"{part}_{reach:g}"] for row in surface))
                for part in ("runs", "slow", "failed", "undecided")
            ),
        ]
        for reach in REACHES
    ]
    parts += [
        "motions from event to event",
        table(["from", "runs", "slip dies away slowly", "goes on", "undecided"], lines),
    ]
    largest = max((row["growth"] for row in surface), default=0.0)
    return "\n".join([*parts, f"largest relative growth of the distance from the surface on: {largest:.1e}"])


def _sizes(rows: list[dict]) -> list[int]:
    return sorted({row["n"] for row in rows})


def _line(row: dict) -> list[str]:
    name = row.get("joint") or f"{row['elements']} x {row['elements']} x 3, f = {row['friction']}"
    return [str(name), str(row["nodes"]), *_numbers(row)]


def _medians(n: int, rows: list[dict]) -> list[str]:
    keys = [key for key in rows[0] if key not in ("study", "n", "seed")]
    found = {}
    for key in keys:
        # what is not proved at any load factor counts as zero
        values = [0.0 if row[key] is None and key in ("zero", "half", "split") else row[key] for row in rows]
        kept = [value for value in values if isinstance(value, int | float)]
        found[key] = float(np.median(kept)) if kept else None
    return [f"{len(rows)} random, medians", str(n), *_numbers(found)]


def _numbers(row: dict) -> list[str]:
    shares = [_shown(row.get(key), "{:.4f}") for key in ("zero", "half", "split")]
    radii = [row.get("split_radius"), row.get("zero_radius")]
    grown = "-" if not all(radii) else f"{radii[0] / radii[1]:.2f}"
    seconds = [_shown(row.get(f"{key}_s"), "{:.2g}") for key in ("zero", "split", "plain")]
    both = row.get("zero") is not None and row.get("plain") is not None
    apart = f"{row['zero'] - row['plain']:.0e}" if both else "-"
    return [*shares, grown, *seconds, apart]


def _shown(value: float | None, form: str) -> str:
    return "-" if value is None else form.format(value)


def figures(rows: list[dict]) -> dict:
    return {}
