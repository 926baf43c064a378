"""Does an answer contradict another one about the same joint?

``tangents``: λ_S and the total slips of joints in space, and of the same joints with the tangents of every
node turned, and of some nodes mirrored. ``friction``: the three numbers of joints in the plane and in space
with less and less friction, down to 10⁻³⁰ times their own, at some nodes less than at others: nothing that
is proved may lie above what is impossible.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import shakedown
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import Missing, sought
from shakedown.report.facts import table

TITLE = "Answers about one joint that would contradict each other: other tangents, less and less friction"
EXPONENTS = (0, 3, 6, 9, 12, 16, 21, 30)


def cases(short: bool) -> list[dict]:
    tangents, friction = (2, 1) if short else (700, 50)
    return [{"of": "tangents", "joints": tangents}, {"of": "friction", "joints": friction}]


def measure(case: dict) -> dict:
    """How many pairs of answers were compared, how many contradict each other, and by how much."""
    found = list((_of_tangents if case["of"] == "tangents" else _of_friction)(case["joints"]))
    apart = np.array([each for each in found if np.isfinite(each)])
    return {
        "compared": len(apart),
        "contradictions": int(np.sum(apart > (1e-5 if case["of"] == "tangents" else 0.0))),
        "largest": float(apart.max(initial=0.0)),
    }


def _of_tangents(joints: int) -> Iterator[float]:
    """By how much λ_S or a total slip differs, relative to itself; NaN where nothing is proved."""
    rng = np.random.default_rng(0)
    for number in range(joints):
        problem = drawn_joint_in_space(11, number)
        here = shakedown.accumulated_bound(problem)
        there = shakedown.accumulated_bound(_turned(rng, problem))
        numbers = (np.append(each.total_slip, each.load_factor) for each in (here, there))
        yield _apart(*numbers) if here.status == there.status else np.inf


def _apart(here: FloatArray, there: FloatArray) -> float:
    known = np.isfinite(here) & (here != there)
    if not np.isfinite(here).any():
        return np.nan
    return float(np.max(np.abs(there[known] / here[known] - 1.0), initial=0.0))


def _turned(rng: np.random.Generator, problem: Problem) -> Problem:
    T = np.zeros((2 * problem.n, 2 * problem.n))
    for i, angle in enumerate(rng.uniform(0.0, 2.0 * np.pi, problem.n)):
        cosine, sine, side = np.cos(angle), np.sin(angle), rng.choice([-1.0, 1.0])
        T[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[cosine, sine], [-side * sine, side * cosine]]
    vectors = {key: getattr(problem, key) for key in ("q_w", "q_mean", "q_transient", "initial_slip")}
    there = {key: value @ T.T for key, value in vectors.items() if value is not None}
    return replace(problem, A=T @ problem.A @ T.T, B=problem.B @ T.T, **there)


def _of_friction(joints: int) -> Iterator[float]:
    """By how much something proved is above what is impossible; 0 where nothing is."""
    rng = np.random.default_rng(0)
    for number in range(joints):
        for drawn in (drawn_joint, drawn_joint_in_space):
            problem = drawn(11, number)
            spread = 10.0 ** -(rng.uniform(0.0, 6.0, problem.n) * (rng.random() < 0.3))
            for exponent in EXPONENTS:
                little = replace(problem, f=10.0**-exponent * spread * problem.f)
                found = shakedown.assess(little, open_nodes=())
                limits, above = found.details, sought(lambda found=found: found.impossible_above)
                if isinstance(above, Missing):
                    yield np.nan
                    continue
                proved = [found.proved_from_every_state, found.proved_from_this_state]
                proved += [limits.energy.load_factor, limits.accumulated.load_factor]
                most = float(np.nanmax([0.0, *proved]))
                yield (most / above - 1.0 if above > 0.0 else np.inf) if most > above else 0.0


def tables(rows: list[dict]) -> str:
    lines = [
        [row["of"], *(f"{row[key]:.3g}" for key in ("compared", "contradictions", "largest"))] for row in rows
    ]
    return table(["of", "compared", "contradictions", "largest"], lines)


def figures(rows: list[dict]) -> dict:
    return {}
