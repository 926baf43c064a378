"""What is proved of finite-element joints, and the interval in which the limit λ_T of their history lies.

Blocks assembled without slip: up to λ_E shakedown is proved without a simulation; up to the lower end of
the interval because the simulated motion comes into an energy ball; from its upper end on a cycle is
found.
"""

import time
from collections.abc import Callable

import numpy as np

import shakedown
from benchmarks.refinement import block_on_plane
from shakedown.fem import ElasticBody, Material, Pressure, Traction, block_mesh, contact_problem
from shakedown.report.text_table import table

TITLE = "Proved and simulated limits of finite-element joints"
ACCURACY = 1e-5  # of the bisection, relative to λ_max
SCANNED = 20


def block_of_the_readme(elements: int) -> shakedown.Problem:
    """A block pressed on a rigid plane under a shear traction that goes to and fro."""
    block = ElasticBody(
        block_mesh(2.0, 1.0, elements, elements // 2),
        Material(young=200e3, poisson=0.3),
        loads=[
            Pressure("top", 10.0, history=np.ones(24)),
            Traction("top", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
        ],
    )
    return contact_problem(block, "bottom", f=0.4, steps=24)


JOINTS: dict[str, Callable[[], shakedown.Problem]] = {
    "block-9 (CalculiX)": lambda: shakedown.example("block-9"),
    "block-33": lambda: shakedown.example("block-33"),
    "cantilevered-block": lambda: shakedown.example("cantilevered-block"),
    "moved block, 65 nodes": lambda: block_on_plane(64, 0.5),
    "pressed block, 17 nodes": lambda: block_of_the_readme(16),
    "pressed block, 65 nodes": lambda: block_of_the_readme(64),
    "pressed block, 129 nodes": lambda: block_of_the_readme(128),
    "pressed block, 251 nodes": lambda: block_of_the_readme(250),
}


def cases(short: bool) -> list[dict]:
    return [{"joint": name} for name in (list(JOINTS)[:2] if short else JOINTS)]


def measure(case: dict) -> dict:
    problem = JOINTS[case["joint"]]()
    begin = time.process_time()
    upper = shakedown.upper_bound(problem, certify=False).load_factor
    energy = shakedown.energy_bound(problem, certify=False).load_factor
    between = time.process_time()
    limit = shakedown.transient_limit(problem, steps=SCANNED, accuracy=ACCURACY)
    seconds = time.process_time() - between
    return {
        "nodes": problem.n,
        "upper": upper,
        "energy": _known(energy),
        "proved": _known(limit.proved),
        "cycling": _known(limit.cycling),
        "bounds_seconds": between - begin,
        "seconds": seconds,
    }


def _known(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def tables(rows: list[dict]) -> str:
    headers = ["joint", "n", "λ_max", "λ_E / λ_max", "λ_T from", "to", "relative width", "λ_E, s", "λ_T, s"]
    return table(headers, [_line(row) for row in rows])


def _line(row: dict) -> list[str]:
    energy = "-" if row["energy"] is None else f"{row['energy'] / row['upper']:.4f}"
    ends = ["-" if row[key] is None else f"{row[key]:.7f}" for key in ("proved", "cycling")]
    width = "-"
    if row["proved"] is not None and row["cycling"] is not None:
        width = f"{(row['cycling'] - row['proved']) / row['cycling']:.1e}"
    seconds = [f"{row[key]:.2g}" for key in ("bounds_seconds", "seconds")]
    return [row["joint"], str(row["nodes"]), f"{row['upper']:.6f}", energy, *ends, width, *seconds]


def figures(rows: list[dict]) -> dict:
    return {}
