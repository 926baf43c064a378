"""States in space that a proof says shake down, followed from event to event.

Random joints with two tangential directions and up to six nodes. *Ball*: from states at 0.999 of the radius
of the largest energy ball (with the split), or, where the first load does not allow those, from its limit on
the way there, at load factors up to 0.999 λ_max. *Universal*: at 0.999 λ_U from states anywhere among those
that the first load allows, half of them at its limits. A run ends at rest, or is *slow*: after 60 cycles its
slip per cycle is less than 0.9 of that 30 cycles before, and dies away, or it rests within 20,000. It fails
if it goes on slipping, if a node opens, if the motion stops, or if in the ball the energy norm grows. At four
times the radius, and half way from λ_U to λ_max, runs must fail now and then.
"""

import os

import numpy as np

import shakedown
from benchmarks.space_adversary import LOADS, STRENGTHS, drawn
from benchmarks.space_energy import random_joint
from shakedown import Outcome, Problem
from shakedown.ground.float_array import FloatArray
from shakedown.joint.loading import loading
from shakedown.motion.evolution import Evolution
from shakedown.programs.cone_rays import leaves_cone
from shakedown.report.text_table import table

TITLE = "States in space that are proved to shake down, followed from event to event"
NODES = (1, 2, 3, 4, 5, 6)
BALL, UNIVERSAL = "ball", "universal"
SHARES = (0.5, 0.9, 0.99, 0.999)  # of λ_max, for balls
INSIDE, OUTSIDE = 0.999, 4.0  # of the radius, and of λ_U the first
RUNS, CONTROLS = 1000, 20  # per joint, and how many of them are farther out
CYCLES = 60  # then it is slow, or the long-term state is searched for
MOST_CYCLES = 20_000  # to come to rest within, where that search is undecided
SLOWING = 0.9  # slip of the last cycle, relative to that of the one half way: it dies away
QUIET = 2  # cycles without slip beyond the accuracy, one after the other: at rest
GROWTH = 1e-6  # of the energy norm, relative to the radius
KEYS = ("joints", "runs", "at the surface", "slow", "cycling", "opened", "stopped", "undecided", "grown")


def cases(short: bool) -> list[dict]:
    """One joint each; BALL_BATCHES joints of every kind (1 by default)."""
    batches = 1 if short else int(os.environ.get("BALL_BATCHES", "1"))
    nodes, runs = (NODES[1:2], 12) if short else (NODES, RUNS)
    return [
        {"against": against, "n": n, "seed": seed, "runs": runs}
        for seed in range(batches)
        for n in nodes
        for against in (BALL, UNIVERSAL)
    ]


def measure(case: dict) -> dict:
    rng = np.random.default_rng([case["seed"], case["n"], case["against"] == BALL])
    counts = dict.fromkeys((*KEYS, "controls", "controls failed"), 0) | {"growth": 0.0, "failures": []}
    attack = _ball if case["against"] == BALL else _universal
    attack(rng, case, counts)
    return counts


def _ball(rng: np.random.Generator, case: dict, counts: dict) -> None:
    """From the surface of the largest ball at one load factor."""
    problem = random_joint(case["n"], int(rng.integers(2**31)))
    upper = shakedown.upper_bound(problem, certify=False).load_factor
    load_factor = float(rng.choice(SHARES)) * min(upper, 10.0)
    ball = shakedown.energy_ball(problem, load_factor)
    if not 0.0 < ball.radius < np.inf:
        return
    counts["joints"] += 1
    followed = _Followed(problem, load_factor)
    directions = rng.normal(size=(case["runs"], ball.metric.inverse.shape[1]))
    ways = ball.at(directions) - ball.slip
    allowed = allowed_way(problem, load_factor, ball.slip, ways)
    for way, limit in zip(ways, allowed, strict=True):
        reach = min(INSIDE, limit * (1.0 - 1e-12))
        counts["at the surface"] += int(reach == INSIDE)
        start = ball.slip + reach * way
        ended, path = followed.run(start)
        growth = float(np.max(np.diff(ball.distance(np.array(path))), initial=0.0)) / ball.radius
        counts["growth"] = max(counts["growth"], growth)
        _note(counts, case, "grown" if growth > GROWTH else ended, start, load_factor)
    for way in ways[:CONTROLS]:
        _control(counts, followed.run(ball.slip + OUTSIDE * way, to_the_end=False)[0])


def _universal(rng: np.random.Generator, case: dict, counts: dict) -> None:
    """From anywhere among the states that the first load allows, just below λ_U."""
    kind = {"n": case["n"], "strength": float(rng.choice(STRENGTHS)), "loads": str(rng.choice(LOADS))}
    problem = drawn(rng, kind)
    bound = shakedown.universal_bound(problem).load_factor
    load_factor = INSIDE * bound
    counts["joints"] += 1
    followed = _Followed(problem, load_factor)
    for k, start in enumerate(allowed_states(rng, problem, load_factor, case["runs"])):
        counts["at the surface"] += k % 2
        _note(counts, case, followed.run(start)[0], start, load_factor)
    above = 0.5 * (bound + min(shakedown.upper_bound(problem, certify=False).load_factor, 10.0 * bound))
    controls = _Followed(problem, above)
    for start in allowed_states(rng, problem, above, CONTROLS):
        _control(counts, controls.run(start, to_the_end=False)[0])


def allowed_states(rng: np.random.Generator, problem: Problem, load_factor: float, count: int) -> FloatArray:
    """Slips that keep all nodes closed and within their limits at the first load, every other at a limit."""
    centre = shakedown.safe_slip(problem, load_factor).slip
    if not np.isfinite(centre).all():
        centre = shakedown.safe_slip(problem, 0.5 * load_factor).slip
    if not np.isfinite(centre).all():
        return np.empty((0, problem.layout.slip_size))
    ways = rng.normal(size=(count, len(centre))) * np.abs(problem.q_w).max() / np.diag(problem.A)
    limit = allowed_way(problem, load_factor, centre, ways)
    reach = np.where(np.isfinite(limit), limit * (1.0 - 1e-12), 30.0)
    share = np.where(np.arange(count) % 2, 1.0, rng.random(count))
    return np.asarray(centre + (reach * share)[:, None] * ways)


def allowed_way(problem: Problem, load_factor: float, centre: FloatArray, ways: FloatArray) -> FloatArray:
    """How many times each way (k, 2n) may be gone from a slip until the first load allows no more, (k,)."""
    q_w, p_w = loading(problem).at(load_factor)
    discs, law = slice(3 * problem.n), problem.law
    right = law.cone(q_w[0], p_w[0])[discs]
    G = law.stiffness(problem.A, problem.B)[discs]
    start, along = (right - G @ centre).reshape(-1, 3), (-ways @ G.T).reshape(len(ways), -1, 3)
    if (np.hypot(start[:, 1], start[:, 2]) > start[:, 0]).any():  # the centre itself is not admissible
        return np.zeros(len(ways))
    return leaves_cone(start, along).min(axis=-1)


class _Followed:
    """Motions of one joint at one load factor, one after the other."""

    def __init__(self, problem: Problem, load_factor: float) -> None:
        self.problem, self.load_factor = problem, load_factor
        self.motion = Evolution(problem, load_factor)
        self.nothing = self.motion.tolerances.path * self.motion.scale.length

    def run(self, start: FloatArray, *, to_the_end: bool = True) -> tuple[str, list[FloatArray]]:
        """How a motion from a slip ends, and the slips between cycles; a cycle is looked for, or assumed."""
        self.motion.begin(self.load_factor, start)
        path, quiet, slips = [start], 0, []
        for _ in range(CYCLES):
            record = self.motion.cycle()
            if record is None:
                return "stopped", path
            if record.opened.any():
                return "opened", path
            path.append(record.end_slip)
            slips.append(float(record.slip.max()))
            quiet = quiet + 1 if slips[-1] <= self.nothing else 0
            if quiet == QUIET:
                return "still", path
        if slips[-1] <= SLOWING * slips[CYCLES // 2]:
            return "slow", path
        if not to_the_end:
            return "cycling", path
        found = shakedown.long_term_state(self.problem, self.load_factor, start).outcome
        if found is Outcome.UNDECIDED and self._comes_to_rest():
            return "slow", path
        ends = {Outcome.SHAKEDOWN: "still", Outcome.UNDECIDED: "undecided", Outcome.SEPARATION: "opened"}
        return ends.get(found, "cycling"), path

    def _comes_to_rest(self) -> bool:
        """Whether a cycle without slip follows in the end."""
        following = (self.motion.cycle() for _ in range(MOST_CYCLES))
        return any(record is not None and record.slip.max() <= self.nothing for record in following)


def _note(counts: dict, case: dict, ended: str, start: FloatArray, load_factor: float) -> None:
    counts["runs"] += 1
    if ended != "still":
        counts[ended] += 1
    if ended not in ("still", "slow"):
        counts["failures"].append({"ended": ended, "load_factor": load_factor, "start": start.tolist()})


def _control(counts: dict, ended: str) -> None:
    counts["controls"] += 1
    counts["controls failed"] += int(ended not in ("still", "slow"))


def tables(rows: list[dict]) -> str:
    lines = []
    for against in (BALL, UNIVERSAL):
        chosen = [row for row in rows if row["against"] == against]
        sums = [str(sum(row[key] for row in chosen)) for key in (*KEYS, "controls", "controls failed")]
        lines.append([against, *sums, f"{max((row['growth'] for row in chosen), default=0.0):.1e}"])
    return table(["against", *KEYS, "controls", "controls failed", "growth"], lines)


def figures(rows: list[dict]) -> dict:
    return {}
