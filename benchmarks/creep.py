"""Look for a drift below any load factor up to which docs/creep.md proves that there is none.

Floating joints of 2 to 20 nodes in the plane and rings of bearings, followed by the exact motion from slips
near and far, admissible or not. At 0.999 of what is proved: the wedge bound of both sides, or of one (drift
that way only), with matrices that are coupled, reducible or uncoupled, the load steps in their order, in
others with repeats, and any loads of the hull; between the wedge bound and the end of the programs, in the
order of the loads; the held node, for any coupling, jumps too. Of drifts above the wedge bound, whether they
are inside the enclosure of one cycle of another motion. A run in which a node is open in the long run says
nothing. At 1.3 times the limit, the control, many drift.

The ``steps`` rows are the least load factor seen to drift against fixed load steps of its own.
"""

import os
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import shakedown
from benchmarks.bodies.bearing_ring import bearing_ring
from benchmarks.display import listed
from benchmarks.problems import refined
from shakedown import LongTermState, Problem
from shakedown.assessment.creep_limit import is_creeping
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading
from shakedown.joint.units import without_loads
from shakedown.long_term.creep_proofs import SlidingBody, sliding_bodies
from shakedown.motion.evolution import evolve
from shakedown.motion.fixed_steps import FixedSteps

TITLE = "Drift below what is proved to exclude it, and fixed load steps on either side of λ_c"
# joints of a case, starts of each load factor and order: fewest where nodes often open, which takes long
SIZES = {"uncoupled": (20, 300), "coupled": (20, 200), "one-sided": (10, 100), "reducible": (10, 100)}
BELOW, ABOVE = 0.999, 1.3  # times what is proved: the adversary and the control
REACHES = (0.1, 1.0, 5.0, 30.0)  # starts, relative to the slips that the loads cause
WEDGES = ("coupled", "one-sided", "reducible", "uncoupled")
KINDS = (*WEDGES, "programs", "held", "enclosed", "ring")
LARGEST = {"programs": 8, "held": 6, "steps": 5}  # nodes
COUNTS = ("joints", "runs", "drifting", "opened", "undecided", "controls", "controls_drifting")
PARTS, CYCLES = 256, 200  # parts of a load step, and cycles, with fixed load steps
APART = 0.01  # relative to λ_c, of the load factors below and above


def cases(short: bool) -> list[dict]:
    """CREEP_BATCHES of each kind, 1 by default, and load factors on either side of λ_c."""
    batches = 1 if short else int(os.environ.get("CREEP_BATCHES", "1"))
    sizes = {kind: (2, 5) if short else SIZES.get(kind, (20, 100)) for kind in KINDS}
    found = [
        {"kind": kind, "seed": seed, "joints": joints, "starts": starts}
        for seed in range(batches)
        for kind, (joints, starts) in sizes.items()
    ]
    return found + [{"kind": "steps", "seed": seed} for seed in range(2 if short else 12)]


def measure(case: dict) -> dict:
    """How many runs of one kind there were, and how they ended."""
    if case["kind"] == "steps":
        return stepped_over(case["seed"])
    rng = np.random.default_rng([case["seed"], KINDS.index(case["kind"])])
    counts, wanted = dict.fromkeys(COUNTS, 0), case["joints"]
    while counts["joints"] < (wanted if case["kind"] != "ring" else 1):
        joint = drawn_ring(rng) if case["kind"] == "ring" else drawn_joint(rng, case["kind"])
        (body,) = sliding_bodies(joint)
        counts["joints"] += attacked(rng, body, case, counts)  # type: ignore[arg-type]
    return counts


def drawn_joint(rng: np.random.Generator, kind: str) -> Problem:
    """Springs between nodes, and a coupling that leaves the rigid slip free; A ± f B as the kind says."""
    n, m = int(rng.integers(2, LARGEST.get(kind, 20) + 1)), int(rng.integers(2, 9))
    springs = rng.random((n, n)) * (rng.random((n, n)) < rng.choice([0.1, 0.5, 1.0])) + 0.2 * np.eye(n, k=1)
    springs = np.triu(springs, 1) + np.triu(springs, 1).T
    share = rng.choice([0.2, 0.5, 0.95]) * rng.uniform(-1.0, 1.0, (n, n))
    share = {
        "one-sided": np.where(share < 0, 1.5 * share, share),
        "reducible": np.where(rng.random((n, n)) < 0.1, np.sign(share), share),
        "uncoupled": np.zeros((n, n)),
        "held": 3.0 * share,
    }.get(kind, share)
    f, z = rng.uniform(0.3, 0.9, n), rng.choice([-1.0, 1.0], n) * rng.uniform(0.5, 2.0, n)
    fB = share * springs
    A, fB = np.diag(springs.sum(axis=1)) - springs, fB - np.diag(fB.sum(axis=1))
    q0, p0 = 0.2 * rng.normal(size=n), rng.uniform(3.0, 9.0, n)
    swing = rng.choice([0.0, 0.3, 1.0])
    scaled = np.abs(z) * f
    return Problem(
        A=A / z / z[:, None],
        B=fB / z / scaled[:, None],
        f=f,
        q_w=q0 + rng.normal(size=(m, n)),
        p_w=p0 + swing * rng.normal(size=(m, n)),
        q_mean=q0,
        p_mean=p0,
    )


def drawn_ring(rng: np.random.Generator) -> Problem:
    """A bearing ring of 32 to 48 contact nodes, of some interference, friction and load steps."""
    return bearing_ring(
        int(rng.choice([16, 20, 24])),
        interference=float(rng.choice([1e-3, 2e-3, 4e-3])),
        f=float(rng.uniform(0.1, 0.3)),
        steps=int(rng.choice([8, 16, 24])),
    )


def attacked(rng: np.random.Generator, body: SlidingBody, case: dict, counts: dict) -> bool:
    """Runs of one joint, counted; whether something is proved of it."""
    kind, joint, starts = case["kind"], body.problem, case["starts"]
    if kind == "held":
        return held(rng, body, starts, counts)
    side = 0 if kind == "one-sided" else None
    wedge = body.wedge_bounds[0] if side == 0 else min(body.wedge_bounds)
    if not 0.0 < wedge < min(1e3, body.gross_slip):
        return False
    if kind == "programs":
        path = shakedown.creep_limit(joint, accuracy=1e-3).path
        if not path > 1.001 * wedge:
            return False
        for share in (0.3, 0.7, 0.99):
            count(body, side, (wedge + share * (path - wedge)), begun(rng, body, starts), counts)
        control(body, ABOVE * path, begun(rng, body, starts), counts)
        return True
    if kind == "enclosed":
        return enclosed(rng, body, ABOVE * wedge, starts // 10 + 1, counts)
    for other in in_orders(rng, joint):
        count(replace(body, problem=other), side, BELOW * wedge, begun(rng, body, starts), counts)
    control(body, ABOVE * wedge, begun(rng, body, starts), counts)
    return True


def in_orders(rng: np.random.Generator, joint: Problem) -> Iterator[Problem]:
    """The joint with its load steps, some of them in another order with repeats, and loads of the hull."""
    yield joint
    weight = np.eye(joint.m)[rng.integers(joint.m, size=2 * joint.m)]
    yield loaded(joint, weight)
    weight = rng.exponential(size=(2 * joint.m, joint.m)) ** 4
    yield loaded(joint, weight / weight.sum(axis=1, keepdims=True))


def loaded(joint: Problem, weight: FloatArray) -> Problem:
    """The joint under mixtures of its load steps."""
    loop = loading(joint)
    q, p = loop.q0 + weight @ loop.q1, loop.p0 + weight @ loop.p1
    return replace(without_loads(joint), q_w=q, p_w=p, q_mean=loop.q0, p_mean=loop.p0)


def begun(rng: np.random.Generator, body: SlidingBody, starts: int) -> FloatArray:
    """Slips (starts, n) near and far, with a rigid slip added."""
    joint = body.problem
    size = np.abs(joint.q_w).max() / np.diagonal(joint.A).max()
    slips = rng.normal(size=(starts, joint.n)) * size * rng.choice(REACHES, (starts, 1))
    pressed, change = np.fmax(joint.p_w.min(axis=0), 0.1), slips @ joint.B.T
    # no farther than to a tenth of the pressure
    slips *= np.fmin(1.0, 0.9 * (pressed / np.fmax(-change, 1e-9)).min(axis=1, keepdims=True))
    return slips + size * rng.normal(size=(starts, 1)) * body.z


def count(body: SlidingBody, side: int | None, load_factor: float, slips: FloatArray, counts: dict) -> None:
    """Add the runs of one load factor to the counts; each that seems to drift is followed alone."""
    found = shakedown.long_term_states(body.problem, load_factor, slips)
    counts["runs"] += len(slips)
    for k in np.flatnonzero(np.isin(found.outcome, ("ratchetting", "undecided"))):
        state = shakedown.long_term_state(body.problem, load_factor, slips[k])
        if opens(state):
            counts["opened"] += 1
        elif state.slides_away and side is not None:
            counts["undecided"] += 1
        elif is_creeping(state):
            counts["drifting"] += side is None or float(state.drift @ body.z) > 0.0
        elif state.outcome == "undecided":
            counts["undecided"] += 1


def opens(state: LongTermState) -> bool:
    """Whether a node is open in the long run, or the body leaves."""
    return bool(state.opened.any()) or "lifts off" in state.reason


def control(body: SlidingBody, load_factor: float, slips: FloatArray, counts: dict) -> None:
    """The same above what is proved."""
    found = shakedown.long_term_states(body.problem, load_factor, slips)
    counts["controls"] += len(slips)
    counts["controls_drifting"] += int(np.count_nonzero(found.outcome == "ratchetting"))


def held(rng: np.random.Generator, body: SlidingBody, starts: int, counts: dict) -> bool:
    """Every start has a limit of its own; the load steps after the first in any order."""
    joint, known = body.problem, False
    for slip in np.vstack([np.zeros(joint.n), 0.1 * begun(rng, body, starts // 10)]):
        limit = body.held_bound(slip)[0]
        if not 0.0 < limit < 1e3:
            continue
        known = True
        for _ in range(5):
            order = np.append(0, rng.integers(joint.m, size=2 * joint.m))
            other = loaded(joint, np.eye(joint.m)[order])
            count(replace(body, problem=other), None, BELOW * limit, slip[None], counts)
            control(replace(body, problem=other), ABOVE * limit, slip[None], counts)
    return known


def enclosed(
    rng: np.random.Generator, body: SlidingBody, load_factor: float, starts: int, counts: dict
) -> bool:
    """Drifts outside of what one closed cycle of another motion encloses count as drifting."""
    if not body.all_mixtures_irreducible:
        return False
    joint = body.problem
    first, *others = begun(rng, body, 1 + starts)
    path = evolve(joint, load_factor, first, cycles=2).history
    low, high = body.drift_enclosure(path.rows(path.cycle >= 1.0))
    if np.isnan(low) or path.cycle[-1] < 2.0:
        return False
    for start in others:
        state = shakedown.long_term_state(joint, load_factor, start)
        counts["runs"] += 1
        if opens(state):
            counts["opened"] += 1
        elif not state.period:
            counts["undecided"] += 1
        else:
            drift = state.drift / state.period / body.z
            near = 1e-9 * np.abs(state.final_slip).max()
            counts["drifting"] += bool(drift.min() < low - near or drift.max() > high + near)
    return True


def stepped_over(seed: int) -> dict:
    """Drift per cycle, relative to the slip per cycle, a per cent below and above λ_c at fixed load steps."""
    rng = np.random.default_rng([99, seed])
    while True:
        joint = drawn_joint(rng, "steps")
        limit = shakedown.creep_limit(joint, accuracy=1e-4)
        if (1.0 + 2.0 * APART) * limit.load_factor < sliding_bodies(joint)[0].gross_slip:
            state = shakedown.long_term_state(joint, limit.load_factor)
            if state.period and not state.opened.any():
                break
    shares = [drift_at_fixed_steps(joint, (1 + x) * limit.load_factor) for x in (-APART, APART)]
    return {"n": joint.n, "load_factor": float(limit.load_factor), "below": shares[0], "above": shares[1]}


def drift_at_fixed_steps(joint: Problem, load_factor: float) -> float:
    """The largest growth of slip in the last of some cycles from slip zero, relative to the slips in it."""
    motion = FixedSteps(refined(joint, PARTS), load_factor)
    motion.advance(CYCLES - 1)
    before, last = motion.state.u[joint.layout.slips], motion.cycle()
    assert last is not None
    return float(np.abs(last.end_slip - before).max() / (last.slip.max() or 1.0))


def tables(rows: list[dict]) -> str:
    """Per kind; and what fixed load steps do."""
    counts = dict[str, dict]()
    for row in rows:
        if row["kind"] != "steps":
            known = counts.setdefault(row["kind"], {"kind": row["kind"]} | dict.fromkeys(COUNTS, 0))
            known |= {key: known[key] + row[key] for key in COUNTS}
    steps = [row for row in rows if row["kind"] == "steps"]
    both = {"drift at 0.99 λ_c": "{below:.1e}", "at 1.01 λ_c": "{above:.1e}"}
    return "\n".join(
        [
            listed(counts.values(), {key.replace("_", " "): f"{{{key}}}" for key in ("kind", *COUNTS)}),
            "",
            listed(steps, {"n": "{n}", "λ_c": "{load_factor:.4f}"} | both),
        ]
    )
