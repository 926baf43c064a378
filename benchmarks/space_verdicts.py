"""Verdicts in space next to what is proved: no one may contradict it.

Random joints with two tangential directions, held or floating, alike or up to a million times stiffer in one
slip than in another, from full to no coupling, from slip zero at load factors next to λ_E, λ_T and λ_max. A
verdict contradicts a proof where it is not shakedown below λ_E, shakedown with all nodes closed above the
certified λ_max, or ratchetting of a joint without a motion that meets no resistance; so does a λ_T below λ_E.
Runs at the largest of these distances are held against plain cycles, up to 20,000, where these settle
in a slip above the accuracy of the path.
"""

import os
import time

import numpy as np

import shakedown
from benchmarks.display import listed
from shakedown import Outcome, Problem, ShakedownError
from shakedown.joint.rigid_slips import can_drift
from shakedown.motion.evolution import Evolution

TITLE = "Verdicts in space next to λ_E, λ_T and λ_max"
NEXT_TO = (1e-2, 1e-3, 1e-4, 1e-5)  # relative distance of a load factor from a limit
JOINTS, NODES = 5, 4  # in a batch, and at most in a joint
KINDS = ("held", "stiff and soft", "floating", "floating, stiff and soft")
COUPLINGS = (1.0, 0.3, 0.03, 0.0)
DECADES = 3.0  # of a slip, whose square is in its stiffness
BELOW, ABOVE = 1.0 - 1e-8, 1.0 + 1e-8  # round-off of the limits themselves
CONTRADICTIONS = ("not at rest below λ_E", "at rest above λ_max", "drifts though held", "λ_T below λ_E")
BEYOND = 10.0  # times λ_E: how far λ_T is looked for where the joint wedges and λ_max is unbounded
PLAIN, EVERY = 20_000, 100  # cycles without leaps, and how often they are looked at
# Of the slip of a cycle, what changes where it repeats; of the displacement of a node, slip that is none.
SETTLED = 1e-10
COUNTS = (
    "joints", "runs", *CONTRADICTIONS, "told by plain cycles", "unlike plain cycles", "stops", "undecided",
    "cycles", "most_cycles",
)  # fmt: skip


def cases(short: bool) -> list[dict]:
    """Batches of five joints; VERDICT_BATCHES of each kind, 1 by default, 25 for 500 joints."""
    batches = 1 if short else int(os.environ.get("VERDICT_BATCHES", "1"))
    joints, nodes, near, accuracy = (1, 1, 1, 0.1) if short else (JOINTS, NODES, len(NEXT_TO), 1e-5)
    size = {"joints": joints, "nodes": nodes, "distances": near, "accuracy": accuracy}
    return [{"kind": kind, "seed": seed} | size for seed in range(batches) for kind in KINDS]


def measure(case: dict) -> dict:
    counts, began = dict.fromkeys(COUNTS, 0), time.process_time()
    for number in range(case["joints"]):
        rng = np.random.default_rng([case["seed"], KINDS.index(case["kind"]), number])
        problem = random_joint(rng, case["kind"], case["nodes"])
        try:
            _at_every_limit(problem, NEXT_TO[: case["distances"]], case["accuracy"], counts)
        except ShakedownError as error:
            raise RuntimeError(f"{case}, joint {number}: {error}") from error
    return counts | {"seconds": time.process_time() - began}


def random_joint(rng: np.random.Generator, kind: str, nodes: int) -> Problem:
    """A joint of so many nodes at most, under a constant load and one that goes round."""
    n, m = int(rng.integers(1, nodes + 1)), 12
    root = rng.normal(size=(3 * n, 3 * n))
    kappa = root @ root.T / (3 * n) + 0.1 * np.eye(3 * n)
    if "stiff" in kind:
        size = np.append(10.0 ** rng.uniform(-DECADES / 2, DECADES / 2, 2 * n), np.ones(n))
        kappa = kappa * size * size[:, None]
    if "floating" in kind and n > 1:  # two common slips cost nothing and change no pressure
        rigid = np.vstack([np.tile(np.eye(2), (n, 1)), np.zeros((n, 2))]) / np.sqrt(n)
        left = np.eye(3 * n) - rigid @ rigid.T
        kappa = left @ kappa @ left.T
        kappa = 0.5 * (kappa + kappa.T)
    A, C = kappa[: 2 * n, : 2 * n], kappa[2 * n :, 2 * n :]
    B = float(rng.choice(COUPLINGS)) * kappa[2 * n :, : 2 * n]
    f, p0 = 0.5 * rng.uniform(0.3, 1.5, n), rng.uniform(2.0, 5.0, n)
    q0 = 0.5 * (f * p0).repeat(2) * rng.uniform(-1.0, 1.0, 2 * n)
    t = 2.0 * np.pi * np.arange(m)[:, None] / m
    q = 0.5 * (rng.normal(size=2 * n) * np.cos(t) + rng.normal(size=2 * n) * np.sin(t))
    p = 0.3 * (rng.normal(size=n) * np.cos(2 * t) + rng.normal(size=n) * np.sin(t))
    return Problem(A=A, B=B, C=C, f=f, q_w=q0 + q, p_w=p0 + p)


def _at_every_limit(problem: Problem, distances: tuple[float, ...], accuracy: float, counts: dict) -> None:
    """The verdicts of one joint on both sides of its limits."""
    proved = shakedown.energy_bound(problem, certify=False).load_factor
    upper = shakedown.upper_bound(problem)
    certain = upper.certified[1] if upper.certified is not None else np.inf
    if not (np.isfinite(upper.load_factor) or 0.0 < proved < np.inf):
        return  # nothing to stand next to
    largest = None if np.isfinite(upper.load_factor) else BEYOND * proved
    limit = shakedown.transient_limit(problem, steps=10, accuracy=accuracy, largest=largest)
    counts["joints"] += 1
    counts["λ_T below λ_E"] += bool(limit.low < BELOW * proved)
    for around in (proved, limit.low, upper.load_factor):
        if not 0.0 < around < np.inf:
            continue
        for near in distances:
            for load_factor in ((1.0 - near) * around, (1.0 + near) * around):
                state = shakedown.long_term_state(problem, load_factor)
                rests = state.outcome == Outcome.SHAKEDOWN
                counts["runs"] += 1
                counts["not at rest below λ_E"] += load_factor < BELOW * proved and not rests
                counts["at rest above λ_max"] += (
                    load_factor > ABOVE * certain and rests and not state.open_nodes
                )
                counts["drifts though held"] += state.outcome == Outcome.RATCHETTING and not can_drift(
                    problem
                )
                open_end = state.outcome == Outcome.UNDECIDED
                counts["stops" if state.stop is not None else "undecided"] += open_end
                told = plainly(problem, load_factor) if near == distances[0] and not open_end else None
                counts["told by plain cycles"] += told is not None
                counts["unlike plain cycles"] += told not in (None, state.outcome)
                counts["cycles"] += state.cycles_simulated
                counts["most_cycles"] = max(counts["most_cycles"], state.cycles_simulated)


def plainly(problem: Problem, load_factor: float) -> Outcome | None:
    """What cycle after cycle settles into; None where it does not within those allowed."""
    motion, before = Evolution(problem, load_factor), np.zeros(problem.layout.size)
    layout, farthest = problem.layout, np.zeros(problem.n)  # how far from zero each node has been
    while motion.done < PLAIN and motion.advance(EVERY) == EVERY:
        start, record = motion.state.u, motion.cycle()
        if record is None:
            return None
        change, slip = motion.state.u - start, float(record.slip.max())
        slips = layout.by_node(motion.state.u[layout.slips])
        farthest = np.maximum(farthest, np.linalg.norm(slips, axis=1))
        if (record.slip <= SETTLED * farthest).all():  # round-off of the path, node by node
            return Outcome.SHAKEDOWN
        if (record.slip > motion.tolerances.path * farthest).any():  # what repeats below that tells nothing
            if np.abs(change).max() <= SETTLED * slip:
                return Outcome.CYCLIC_SLIP
            if np.abs(change - before).max() <= SETTLED * np.abs(change).max():
                return Outcome.RATCHETTING
        before = change
    return None


def tables(rows: list[dict]) -> str:
    found = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        chosen = [row for row in rows if row["kind"] == kind]
        sums = {key: sum(row[key] for row in chosen) for key in (*COUNTS, "seconds")}
        found.append(sums | {"kind": kind, "most_cycles": max(row["most_cycles"] for row in chosen)})
    columns = {"kind": "{kind}"} | {key.replace("_", " "): f"{{{key}}}" for key in COUNTS}
    return listed(found, columns | {"processor [s]": "{seconds:.0f}"})
