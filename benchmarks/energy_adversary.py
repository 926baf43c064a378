"""Look for a state inside the energy ball that does not shake down.

Random joints, made to be difficult: strong and unsymmetric coupling, friction below and
above the thresholds of single nodes and of uniqueness, floating bodies, separate impulses
in shuffled order, loops with a mean of their own, transient load steps. Every run is
an exact evolution from the surface of the largest ball: from the points where it touches
a friction limit, and from points drawn at random. A run fails if it goes on slipping, if a
node opens, or if the energy norm grows. Farther out runs must fail now and then:
otherwise the ball would be idle.
"""

from collections import Counter

import numpy as np

import shakedown
from shakedown import EnergyBall, Outcome, Problem, energy_ball
from shakedown.joint.constraints import constraints
from shakedown.joint.loading import loading
from shakedown.motion.evolution import Evolution
from shakedown.report.text_table import table

TITLE = "States inside the energy ball, and outside, that do not shake down"
KINDS = ("below", "above", "floating")  # friction of single nodes against A_ii / |B_ii|
REACHES = (1.0, 1.5, 3.0, 10.0)  # times the radius
STARTS = {1.0: 24, 1.5: 2, 3.0: 2, 10.0: 2}
CYCLES = 40
STILL = 1e-13  # slip per cycle that counts as none, relative to the length scale of the joint
WIDE = 1e6  # radius, relative to the slips of the joint, from which it counts as infinite
GROWTH = 1e-8  # of the energy norm, relative, that counts as growth


def cases(short: bool) -> list[dict]:
    sizes, seeds, joints = ((1, 2, 3, 6), 1, 4) if short else (range(1, 21), 12, 60)
    return [
        {"n": n, "kind": kind, "joints": joints, "seed": seed}
        for seed in range(seeds)
        for n in sizes
        for kind in KINDS
        if n > 1 or kind != "floating"
    ]


def measure(case: dict) -> dict:
    rng = np.random.default_rng([case["seed"], case["n"], KINDS.index(case["kind"])])
    counts: Counter[str] = Counter()
    growth, failures = 0.0, []
    while counts["joints"] < case["joints"]:
        problem = difficult_joint(rng, case["n"], case["kind"])
        found = ball_of(rng, problem)
        if found is None:
            counts["without"] += 1
            continue
        counts["joints"] += 1
        load_factor, ball = found
        for reach in REACHES:
            for start in starts(rng, problem, ball, reach):
                admissible = is_admissible(problem, load_factor, start)
                ended, grown = outcome(problem, load_factor, ball, start)
                if reach == 1.0 and grown > GROWTH:
                    ended = "grown"
                counts[f"runs {reach:g}"] += 1
                counts[f"inadmissible {reach:g}"] += not admissible
                counts[f"{ended} {reach:g}"] += 1
                counts[f"{ended} inadmissible {reach:g}"] += not admissible
                if reach == 1.0:
                    growth = max(growth, grown)
                    if ended != "still":
                        failures.append({"joint": counts["joints"], "ended": ended, "start": start.tolist()})
    return {"counts": dict(counts), "growth": growth, "failures": failures}


def difficult_joint(rng: np.random.Generator, n: int, kind: str) -> Problem:
    """A joint with strong coupling whose safe slip is anywhere, loaded by impulses in shuffled order."""
    kappa = stiffness(rng, n, floating=kind == "floating")
    A, B, C = kappa[:n, :n], kappa[n:, :n], kappa[n:, n:]
    own = np.diagonal(A) / np.maximum(np.abs(np.diagonal(B)), 1e-3)
    share = rng.uniform(0.4, 3.0, n) if kind == "above" else rng.uniform(0.1, 0.98, n)
    f = np.minimum(share * own, rng.uniform(0.3, 3.0, n))
    m = int(rng.integers(2, 2 * n + 3))
    q = np.where(rng.random((m, n)) < 2.0 / m, rng.normal(size=(m, n)), 0.0)
    p = (rng.random() < 0.5) * 0.5 * rng.normal(size=(m, n))
    p0, locked = rng.uniform(1, 6, n), rng.normal(size=n)
    q0 = rng.uniform(-0.6, 0.6, n) * f * p0 - A @ locked
    own_mean = {"q_mean": q0, "p_mean": p0 - B @ locked} if rng.random() < 0.5 else {}
    before = {}
    if rng.random() < 0.2:
        before = {
            "q_transient": q0 + 0.5 * rng.normal(size=(2, n)),
            "p_transient": p0 - B @ locked + 0.3 * rng.normal(size=(2, n)),
        }
    loop = {"q_w": q0 + q, "p_w": p0 - B @ locked + p}
    return Problem(A=A, B=B, C=C, f=f, **loop, **own_mean, **before)


def stiffness(rng: np.random.Generator, n: int, *, floating: bool) -> np.ndarray:
    """κ (2n, 2n), nearly singular as often as not; floating: without resistance to a common slip."""
    root = rng.normal(size=(2 * n, 2 * n))
    if rng.random() < 0.5:  # pressure and slip of the same or of one other node go together
        partner = rng.permutation(n) if rng.random() < 0.5 else np.arange(n)
        root[n:] += rng.uniform(0, 4) * rng.choice([-1, 1], (n, 1)) * root[partner]
    kappa = root @ root.T / (2 * n) + 10.0 ** rng.uniform(-3, 0) * np.eye(2 * n)
    if floating:
        rigid = np.append(np.ones(n), np.zeros(n)) / np.sqrt(n)
        kappa -= np.outer(rigid, rigid @ kappa)
        kappa -= np.outer(kappa @ rigid, rigid)
    return 0.5 * (kappa + kappa.T)


def ball_of(rng: np.random.Generator, problem: Problem) -> tuple[float, EnergyBall] | None:
    """A load factor between those that a safe slip allows, mostly near the largest, and the ball there."""
    upper = shakedown.upper_bound(problem, certify=False)
    if upper.status == "infeasible":
        return None
    least, most = upper.least_load_factor, min(upper.load_factor, upper.least_load_factor + 5.0)
    load_factor = least + rng.choice([rng.random(), 0.9, 0.99]) * (most - least)
    ball = energy_ball(problem, load_factor)
    return None if ball.status == "infeasible" else (load_factor, ball)


def starts(rng: np.random.Generator, problem: Problem, ball: EnergyBall, reach: float) -> list[np.ndarray]:
    """States on a surface: half of them where it is nearest to a limit, or nearly, half at random."""
    count, rank = STARTS[reach], ball.metric.root.shape[0]
    size = 1.0 + np.abs(ball.slip).max()
    if not ball.radius < WIDE * ball.metric.unit * size:  # every admissible state
        size *= reach
        return [ball.slip + size * rng.normal(size=problem.n) for _ in range(count)]
    G = constraints(problem).G @ ball.metric.inverse
    limits = G[rng.integers(0, len(G), count)] + 0.05 * rng.normal(size=(count, 1)) * rng.normal(
        size=(count, rank)
    )
    own = np.diagonal(problem.B) / np.diagonal(problem.A)
    rest = (problem.B - own[:, None] * problem.A) @ ball.metric.inverse
    touching = -rest[rng.integers(0, problem.n, count)]
    anywhere = rng.normal(size=(count, rank))
    kind = rng.integers(0, 4, count)[:, None]
    directions = np.where(kind == 0, limits, np.where(kind == 1, touching, anywhere))
    still = np.linalg.norm(directions, axis=1) == 0
    directions[still] = anywhere[still]
    return list(ball.at(directions, reach * (1.0 - 1e-9)))


def is_admissible(problem: Problem, load_factor: float, start: np.ndarray) -> bool:
    """Whether the first load leaves every node within its friction limits at this slip."""
    loop = loading(problem)
    q_w, p_w = (part[0] for part in loop.at(load_factor))
    if problem.q_transient is not None and problem.p_transient is not None:
        q_w, p_w = problem.q_transient[0], problem.p_transient[0]
    q, p = q_w + problem.A @ start, p_w + problem.B @ start
    return bool(np.all(np.abs(q) <= problem.f * p))


def outcome(problem: Problem, load_factor: float, ball: EnergyBall, start: np.ndarray) -> tuple[str, float]:
    """How a run ends, and the largest growth of the energy norm over a cycle, relative to the first."""
    evolution = Evolution(problem, load_factor, start)
    size, grown = evolution.scale.length, 0.0
    first = before = max(float(ball.distance(start)), STILL * size * ball.metric.unit)
    for _ in range(CYCLES):
        record = evolution.cycle()
        if record is None:
            return "left" if evolution.left else "lost", grown
        if record.opened.any():
            return "opened", grown
        now = float(ball.distance(evolution.state.u[: problem.n]))
        grown, before = max(grown, (now - before) / first), now
        if record.slip.max() <= STILL * size:
            return "still", grown
    state = shakedown.long_term_state(problem, load_factor, evolution.state.u[: problem.n])
    if state.outcome == Outcome.SHAKEDOWN:
        return "still", grown
    return ("lost" if state.outcome == Outcome.UNDECIDED else "cycling"), grown


def tables(rows: list[dict]) -> str:
    parts = []
    for kind in KINDS:
        lines = []
        for reach in REACHES:
            chosen = [row for row in rows if row["kind"] == kind]
            total = sum((Counter(row["counts"]) for row in chosen), Counter())
            keys = ("runs", "cycling", "opened", "grown", "left", "lost", "inadmissible")
            body = [str(total[f"{key} {reach:g}"]) for key in keys]
            bad = ("cycling", "opened", "grown", "left", "lost")
            body.append(str(sum(total[f"{key} inadmissible {reach:g}"] for key in bad)))
            lines.append([f"{reach:g} R", *body])
        headers = [
            "from",
            "runs",
            "cycling",
            "opened",
            "grown",
            "left",
            "lost",
            "inadmissible",
            "of these bad",
        ]
        most = max((row["growth"] for row in rows if row["kind"] == kind), default=0.0)
        parts += [f"friction {kind}", table(headers, lines), f"  largest growth inside {most:.1e}", ""]
    return "\n".join(parts)


def figures(rows: list[dict]) -> dict:
    return {}
