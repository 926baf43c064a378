"""How sharp is the bound by accumulated slip, beside that by energy, and what does it cost?

From slip zero, relative to λ_T, up to which the history in the order given shakes down (to 10⁻⁴ of λ_max):
random joints of weak and of strong coupling, counter-examples, floating blocks, joints in space.
"""

import time
from collections.abc import Iterator
from itertools import count, islice

import numpy as np
from matplotlib.figure import Figure
from threadpoolctl import threadpool_limits

import shakedown
from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from benchmarks.half_space import half_space
from shakedown import Problem
from shakedown.bounds.uniqueness.coupling import coupling
from shakedown.fem import ElasticBody, Material, Pressure, Traction, block_mesh, contact_problem
from shakedown.report.text_table import table

TITLE = "The bound by accumulated slip beside energy: how sharp, at what cost"
PLANE = ("three-node", "pair-cycle", "two-node", "two-attractors", "press-fit", "block-9", "block-33")
SPACE = ("one-node-3d", "two-node-3d", "four-node-3d", "block-3x3", "bolted-flange")
ACCURACY = 1e-4


def cases(short: bool) -> list[dict]:
    joints = 2 if short else 40
    named = [{"joint": name} for name in (*PLANE, *SPACE)]
    drawn = [{"joint": name, "joints": joints} for name in ("random, ρ* < 1", "random, ρ* ≥ 1")]
    in_space = [{"joint": "random in space", "joints": 2 if short else 20}]
    blocks = [{"joint": "floating block", "n": n, "f": f} for n in (9, 33) for f in (0.2, 0.3, 0.5, 0.8)]
    patches = [{"joint": "half-space", "n": 16, "f": f} for f in (0.2, 0.4, 0.7)]
    return [*drawn, *in_space, *blocks[:: 8 if short else 1], *([] if short else patches), *named]


def measure(case: dict) -> dict:
    """Medians and least values over the joints of a case, of each bound by λ_T; seconds in all."""
    with threadpool_limits(limits=1, user_api="blas"):
        found = [shares for problem in joints_of(case) if (shares := measured(problem)) is not None]
    words = ("energy", "accumulated", "ratio", "seconds", "seconds_energy")
    rows = {word: [each[word] for each in found if each[word] is not None] for word in words}
    return {
        "counted": len(found),
        "above_energy": sum(each["accumulated"] > (each["energy"] or 0.0) for each in found),
        **{word: float(np.median(values)) if values else None for word, values in rows.items()},
        "least": min(rows["accumulated"], default=None),
    }


def joints_of(case: dict) -> Iterator[Problem]:
    if case["joint"] == "random in space":
        yield from filter(is_pressed, (drawn_joint_in_space(1, number) for number in range(case["joints"])))
    elif "joints" in case:
        drawn = filter(is_pressed, (drawn_joint(1, number) for number in count()))
        strong = case["joint"].endswith("≥ 1")
        yield from islice((each for each in drawn if (coupling(each).bound >= 1.0) == strong), case["joints"])
    elif case["joint"] == "floating block":
        yield floating_block(case["n"], case["f"])
    elif case["joint"] == "half-space":
        yield half_space(4, 4, f=case["f"])
    else:
        yield shakedown.example(case["joint"])


def is_pressed(problem: Problem) -> bool:
    """Whether every node has friction, and something may be proved from slip zero."""
    return bool(np.all(problem.f > 0.0)) and shakedown.energy_bound(problem, certify=False).load_factor > 0.0


def floating_block(n: int, f: float) -> Problem:
    """An elastic block that friction alone holds, pressed on a plane and drawn to and fro."""
    loads = [
        Pressure("top", 10.0, history=np.ones(24)),
        Traction("top", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
    ]
    mesh = block_mesh(2.0, 1.0, n - 1, (n - 1) // 2)
    body = ElasticBody(mesh, Material(young=200e3, poisson=0.3), loads=loads)
    return contact_problem(body, "bottom", f=f, steps=24)


def measured(problem: Problem) -> dict | None:
    """The bounds of one joint from slip zero by its λ_T; None where that is no positive number."""
    upper = shakedown.upper_bound(problem, certify=False)
    if upper.status != "optimal" or not upper.load_factor > 0.0:
        return None
    begun = time.perf_counter()
    slip = shakedown.accumulated_bound(problem)
    between = time.perf_counter()
    energy = shakedown.energy_bound(problem, certify=False)
    ended = time.perf_counter()
    end = 1.05 * upper.load_factor
    reached = shakedown.transient_limit(problem, largest=end, accuracy=ACCURACY).load_factor
    if not reached > 0.0:
        return None
    plane = problem.directions == 1
    return {
        "energy": share(energy.load_factor, reached),
        "accumulated": share(slip.load_factor, reached) or 0.0,
        "ratio": share(coupling(problem).bound, 1.0) if plane else None,
        "seconds": between - begun,
        "seconds_energy": ended - between,
    }


def share(bound: float, reached: float) -> float | None:
    """A bound by λ_T; None where there is none."""
    return float(bound / reached) if np.isfinite(bound) else None


def tables(rows: list[dict]) -> str:
    words = ("energy", "accumulated", "least")
    lines = [
        [
            row["joint"] + "".join(f", {key} = {row[key]:g}" for key in ("n", "f") if key in row),
            str(row["counted"]),
            *(_number(row[word]) for word in ("ratio", *words)),
            str(row["above_energy"]),
            *(_number(row[word]) for word in ("seconds", "seconds_energy")),
        ]
        for row in rows
    ]
    headers = [
        "joint",
        "joints",
        "ρ*",
        "λ_E / λ_T",
        "λ_S / λ_T",
        "least λ_S / λ_T",
        "λ_S > λ_E",
    ]
    return table([*headers, "s", "s of λ_E"], lines)


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    """Of every kind of joint each bound by λ_T: the median, where there are several."""
    figure = Figure(figsize=(8, 0.3 * len(rows) + 1.2), layout="constrained")
    axes = figure.subplots()
    names = [
        row["joint"] + "".join(f", {key} = {row[key]:g}" for key in ("n", "f") if key in row) for row in rows
    ]
    for word, name, mark in (("energy", "λ_E", "o"), ("accumulated", "λ_S", "D")):
        known = [(row[word], place) for place, row in enumerate(rows) if row[word] is not None]
        if known:
            axes.plot(*zip(*known, strict=True), mark, label=name, alpha=0.8)
    axes.set_yticks(range(len(rows)), names)
    axes.invert_yaxis()
    axes.set(xlim=(0.0, 1.05), xlabel="proved from slip zero, by λ_T (median)")
    axes.grid(alpha=0.3)
    axes.legend(loc="lower left")
    return {"accumulated": figure}
