"""Is the box bound still worth its lines beside λ_E and λ_S?

From slip zero, on joints in the plane that something is proved of: drawn ones of every kind (floating, with
transients, load domains), and dense ones of two to eight nodes with weak and strong coupling. Counted are
those where λ_box exists (ρ* < 1), and where it is larger than both others by more than ``MORE``.
"""

from collections.abc import Iterator
from itertools import count

import numpy as np

import shakedown
from benchmarks.accumulated import is_pressed
from benchmarks.drawn_joints import drawn_joint
from benchmarks.problems import random_problem
from shakedown import Problem
from shakedown.report.text_table import table

TITLE = "The box bound beside those by energy and by accumulated slip, in the plane"
MORE = 0.004  # of the larger of λ_E and λ_S


def cases(short: bool) -> list[dict]:
    return [{"joints": 10 if short else 500, "kind": kind} for kind in ("drawn", "dense")]


def measure(case: dict) -> dict:
    """How many joints have a box, in how many it is the largest by more than a little, and by how much."""
    shares, transients = list[float](), list[bool]()
    found = filter(is_pressed, joints(case["kind"]))
    for problem, _ in zip(found, range(case["joints"]), strict=False):
        box = shakedown.box_bound(problem).load_factor
        if np.isfinite(box):
            slip = shakedown.accumulated_bound(problem).load_factor
            energy = shakedown.energy_bound(problem, certify=False).load_factor
            shares.append(box / np.nanmax([slip, energy]))
            transients.append(problem.q_transient is not None)
    larger = np.array(shares) > 1.0 + MORE
    return {
        "boxes": len(shares),
        "larger": int(larger.sum()),
        "larger, with a transient": int(np.sum(larger & transients)),
        "largest share": float(max(shares, default=1.0)),
        "median share": float(np.median(shares)) if shares else 1.0,
    }


def joints(kind: str) -> Iterator[Problem]:
    """Joint after joint of a kind."""
    rng = np.random.default_rng(5)
    for number in count():
        if kind == "drawn":
            yield drawn_joint(3, number)
        else:
            n, coupling = int(rng.integers(2, 9)), float(rng.choice([0.15, 0.3, 0.5, 0.8, 1.2]))
            yield random_problem(n, number, coupling=coupling, f=float(rng.choice([0.3, 0.5, 0.8])))


def tables(rows: list[dict]) -> str:
    words = ("boxes", "larger", "larger, with a transient")
    lines = [
        [row["kind"], str(row["joints"]), *(str(row[word]) for word in words)]
        + [f"{row[word]:.4f}" for word in ("median share", "largest share")]
        for row in rows
    ]
    head = ["joints", "how many", "with λ_box", f"λ_box larger by {MORE:.1%}", "… with a transient"]
    return table([*head, "median λ_box / larger of λ_E, λ_S", "largest"], lines)


def figures(rows: list[dict]) -> dict:
    return {}
