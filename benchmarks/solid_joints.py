"""From a mesh to limits and a cycle: joints of solids with up to about 700 contact pairs.

Two blocks, pressed onto each other and pushed around in a circle, and the bolted lap joint: the model, its
condensation, λ_max, λ_E, and one cycle at 0.9 λ_max from event to event. Each case but the smallest
runs in a process of its own, whose largest memory is told. Asked for are five minutes and 8 GiB in all.
"""

import multiprocessing
import resource
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np
from matplotlib.figure import Figure
from threadpoolctl import threadpool_limits

import shakedown
from benchmarks.bodies.blade_root import blade_root
from benchmarks.bodies.bolted_flange import bolted_flange
from benchmarks.bodies.lap_joint import lap_joint
from benchmarks.solid_condensation import SIDES, UNIT
from shakedown import Problem
from shakedown.fem import ElasticBody, Force, Material, Support, brick_mesh, contact_problem
from shakedown.motion.evolve import evolve
from shakedown.report.text_table import table

TITLE = "From a mesh to limits and a cycle: up to 700 contact pairs"
SIZES = {  # elements of each case; of blocks along x, y, z of each
    "blocks": ((3, 2, 3), (13, 12, 13), (27, 24, 27)),
    "lap joint": ((36, 8, 4), (84, 14, 6)),
    "flange": ((40, 10, 8),),
    "blade root": ((12, 18),),
}
RELATIVE = 0.9  # of λ_max: where a cycle is followed
STEPS = 24
GOAL = 300.0  # seconds


def cases(short: bool) -> list[dict]:
    every = [{"joint": name, "elements": list(size)} for name, sizes in SIZES.items() for size in sizes]
    return every[:1] if short else every


def measure(case: dict) -> dict:
    name, elements = case["joint"], tuple(case["elements"])
    if elements == SIZES["blocks"][0]:
        return _measured(name, elements)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as alone:
        return alone.submit(_measured, name, elements).result()


def _measured(name: str, elements: tuple[int, ...]) -> dict:
    _compile()
    times, clock = [time.process_time()], [time.perf_counter()]

    def done() -> None:
        times.append(time.process_time())
        clock.append(time.perf_counter())

    with threadpool_limits(limits=1, user_api="blas"):
        joint = _joint(name, elements)
        done()
        upper = shakedown.upper_bound(joint)
        done()
        start = None if joint.initial_slip is None else joint.initial_slip[0]
        energy = shakedown.energy_bound(joint, start)
        done()
        cycle = evolve(joint, RELATIVE * upper.load_factor, start, cycles=1)
        done()
    low, high = upper.certified or (0.0, np.inf)
    return {
        "pairs": joint.n,
        "upper": float(upper.load_factor),
        "width": float(high / low - 1.0) if low > 0 and np.isfinite(high) else None,
        "energy": float(energy.load_factor),
        "dissipation": float(cycle.cycles[0].dissipation),
        "events": len(cycle.history.kind),
        "seconds": np.diff(times).tolist(),
        "elapsed": clock[-1] - clock[0],
        "memory": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / UNIT,
    }


def _compile() -> None:
    """Every compiled loop once, on a small joint: what it takes is paid once per installation."""
    small = shakedown.example("block-3x3")
    evolve(small, RELATIVE * shakedown.upper_bound(small).load_factor, cycles=1)
    shakedown.energy_bound(small)


def _joint(name: str, elements: tuple[int, ...]) -> Problem:
    build = {"lap joint": lap_joint, "flange": bolted_flange, "blade root": blade_root}
    return build[name](elements) if name in build else _blocks(elements)


def _blocks(elements: tuple[int, ...]) -> Problem:
    steel, top = Material(210e3, 0.3), (0.0, 0.0, SIDES[2])
    loads = [
        Force("top", (0.0, 0.0, -10e3), history=1.0),
        Force("top", (100.0, 0.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
        Force("top", (0.0, 100.0, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
    ]
    upper = ElasticBody(brick_mesh(SIDES, elements, origin=top), steel, loads=loads)
    lower = ElasticBody(brick_mesh(SIDES, elements), steel, supports=[Support("bottom")])
    return contact_problem(upper, "bottom", 0.4, against=(lower, "top"), steps=STEPS)


def tables(rows: list[dict]) -> str:
    headers = [
        "joint", "elements", "pairs", "λ_max", "enclosed to", "λ_E/λ_max", "model [s]", "λ_max [s]",
        "λ_E [s]", "cycle [s]", "in all [s]", "by the clock", "memory [MiB]",
    ]  # fmt: skip
    lines = [
        [
            row["joint"], " x ".join(map(str, row["elements"])), str(row["pairs"]), f"{row['upper']:.4g}",
            "-" if row["width"] is None else f"{row['width']:.0e}", f"{row['energy'] / row['upper']:.4f}",
            *(f"{seconds:.1f}" for seconds in row["seconds"]), f"{sum(row['seconds']):.1f}",
            f"{row['elapsed']:.0f}", f"{row['memory']:.0f}",
        ]
        for row in rows
    ]  # fmt: skip
    return f"Seconds of one processor, largest memory of the process:\n{table(headers, lines)}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(5.6, 3.6), layout="constrained")
    ax = figure.add_subplot()
    for k, what in enumerate(("model and condensation", "λ_max", "λ_E", f"a cycle at {RELATIVE:g} λ_max")):
        ax.loglog([row["pairs"] for row in rows], [row["seconds"][k] for row in rows], "os^d"[k], label=what)
    ax.axhline(GOAL, color="grey", lw=0.8, ls=":")
    ax.set(xlabel="contact pairs", ylabel="seconds of one processor")
    ax.legend(fontsize="small")
    return {"solid_joints": figure}
