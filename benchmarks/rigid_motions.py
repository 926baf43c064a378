"""Rigid motions: the same answers whatever round-off or few printed digits leave of their stiffness.

Joints that friction alone holds, in the plane and in space, with and without the places of their nodes, are
given a stiffness against their rigid slips of ±1e-17 to ±1e-9 of the largest, or are rounded to 5 to 15
digits. λ_max and the simulations above and below it are to be those of the joint as it was, or in doubt.
"""

from collections import Counter
from dataclasses import replace

import numpy as np

import shakedown
from benchmarks.floating_joints import floating_block, rational_joint
from benchmarks.space_scenes import scene
from shakedown import Problem
from shakedown.fem import ElasticBody, Force, Material, Pressure, brick_mesh, contact_problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.report.facts import table

TITLE = "Rigid motions: stiffness of round-off, few printed digits, with and without places"
EACH = 5  # joints per case
FACTORS = (0.9, 5.0)  # of λ_max, for simulations
WRONG = 1e3  # errors of λ_max beyond which it is not right to the digits of the data
KINDS = {"matrices": 1, "block": 1, "matrices in space": 2, "solid": 2}  # directions


def floating_joint(kind: str, seed: int) -> Problem:
    """A joint that friction alone holds: of random matrices, or a body with the places of its nodes."""
    if kind == "matrices":
        return rational_joint(seed, n := 2 + seed % 11, 1 + (n > 3 and seed % 3 == 0)).rounded
    if kind == "block":
        return floating_block(seed)
    return scene("floating", seed) if kind == "matrices in space" else floating_solid(seed)


def floating_solid(seed: int) -> Problem:
    """A brick that lies on a plane, pressed and pushed to and fro, of random shape, material and loads."""
    rng = np.random.default_rng([9, seed])
    turn = 2 * np.pi * np.arange(12) / 12
    mesh = brick_mesh(tuple(rng.uniform(1, 4, 3)), (int(rng.integers(1, 4)), int(rng.integers(1, 4)), 1))
    aside = (0.0, float(rng.uniform(1, 9)), float(rng.uniform(-2, 2)))
    body = ElasticBody(
        mesh,
        Material(float(rng.choice([1.0, 210e3])), float(rng.uniform(0.0, 0.4))),
        loads=[
            Pressure("top", float(rng.uniform(5, 20)), history=1 + 0.3 * np.sin(turn + rng.uniform(0, 6))),
            Force("top", (float(rng.uniform(1, 9)), 0.0, 0.0), history=np.cos(turn)),
            Force("right", aside, history=np.sin(turn)),
        ],
    )
    return contact_problem(body, "bottom", float(rng.uniform(0.1, 0.8)), steps=12)


def printed(matrix: np.ndarray, digits: int) -> np.ndarray:
    """A matrix as it is read again where so many digits were printed."""
    return np.array([[float(f"{x:.{digits - 1}e}") for x in row] for row in matrix])


def rounded(problem: Problem, digits: int) -> Problem:
    """The joint with a stiffness of so many digits."""
    C = None if problem.C is None else printed(problem.C, digits)
    return replace(problem, A=printed(problem.A, digits), B=printed(problem.B, digits), C=C)


def without_places(problem: Problem) -> Problem:
    """The joint of matrices alone."""
    return replace(problem, coordinates=None, normal=None, tangent=None, tangents=None)


def stiffened(problem: Problem, share: float) -> Problem:
    """The joint with a stiffness against its rigid slips of a share of the largest."""
    Z = np.linalg.qr(rigid_slips(problem).motions)[0]
    return replace(problem, A=problem.A + share * np.linalg.eigvalsh(problem.A)[-1] * Z @ Z.T)


def cases(short: bool) -> list[dict]:
    return [
        {"kind": kind, "first": first, "joints": EACH}
        for first in range(0, EACH if short else 100, EACH)
        for kind in KINDS
    ]


def measure(case: dict) -> dict:
    found: Counter[str] = Counter()
    for seed in range(case["first"], case["first"] + case["joints"]):
        problem = floating_joint(case["kind"], seed)
        copies = [problem] if problem.coordinates is None else [problem, without_places(problem)]
        for copy in copies:
            found += judged_digits(problem, copy)
        found += judged_round_off(problem, np.random.default_rng([11, seed]))
    return dict(found)


def judged_digits(problem: Problem, copy: Problem) -> Counter[str]:
    """λ_max of a copy of a joint rounded to 5, 6, … 15 digits: how many are right, in doubt, wrong."""
    most, found = shakedown.upper_bound(problem, certify=False).load_factor, Counter[str]()
    for digits in range(5, 16):
        rough = rounded(copy, digits)
        known = shakedown.upper_bound(rough, certify=False).load_factor
        near = abs(known - most) <= (WRONG * 10.0**-digits + 1e-9) * most
        doubt, places = bool(rigid_slips(rough).doubt), copy.coordinates is not None
        found["digits"] += 1
        found["digits_doubtful"] += doubt
        found["doubtful_with_places"] += doubt and places
        found["digits_wrong"] += not (near or most == np.inf or np.isnan([known, most]).all())
    return found


def judged_round_off(problem: Problem, rng: np.random.Generator) -> Counter[str]:
    """Simulations of a joint with a little stiffness against its rigid slips: how many are as without it."""
    most, found = shakedown.upper_bound(problem, certify=False).load_factor, Counter[str]()
    for factor in FACTORS:
        load_factor = factor * (most if np.isfinite(most) else 1.0)
        true = shakedown.simulate(problem, load_factor)
        for power in rng.choice(np.arange(-17, -8), 3, replace=False):
            rough = stiffened(problem, float(rng.choice([-1.0, 1.0])) * 10.0**power)
            other = shakedown.simulate(rough, load_factor)
            found["runs"] += 1
            found["away"] += true.slides_away
            found["runs_unlike"] += (other.outcome, other.slides_away) != (true.outcome, true.slides_away)
    return found


COUNTS = {
    "digits": "rounded",
    "digits_wrong": "λ_max wrong",
    "digits_doubtful": "in doubt",
    "doubtful_with_places": "… with places",
    "runs": "simulations",
    "away": "slide away",
    "runs_unlike": "unlike",
}


def tables(rows: list[dict]) -> str:
    lines = []
    for kind in dict.fromkeys(row["kind"] for row in rows):
        chosen = [row for row in rows if row["kind"] == kind]
        lines.append([kind] + [str(sum(row.get(key, 0) for row in chosen)) for key in ("joints", *COUNTS)])
    return table(["joints of", "joints", *COUNTS.values()], lines)


def figures(rows: list[dict]) -> dict:
    return {}
