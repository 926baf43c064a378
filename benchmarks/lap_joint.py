"""A bolted lap joint after the Brake–Reuß beam: what is proved of it, and what it dissipates above that.

Two half beams touch on three pads under their bolts, the load at the tip turns about the beam's axis. On
some meshes: λ_max and λ_E, and the friction work of a cycle over the amplitude, after two cycles from
slip zero. Micro-slip has a power law: its exponent is that between the two largest amplitudes.
"""

import time
from functools import cache

import numpy as np
from matplotlib.figure import Figure

import shakedown
from shakedown import Problem
from shakedown.fem import lap_joint
from shakedown.joint.loading import loading
from shakedown.motion.implicit.implicit_step import ImplicitJoint
from shakedown.report.text_table import table

TITLE = "A bolted lap joint in space: limits, and friction work over the amplitude"
MESHES = ((12, 4, 2), (24, 6, 3), (36, 8, 4))  # elements along the lap, across it, over half of the height
RELATIVE = (0.9, 1.1, 1.25, 1.5, 2.0, 3.0, 4.5)  # λ / λ_max
TIP = 10.0  # amplitude of the load at λ = 1 [N]
CYCLES, PARTS = 3, 4  # followed from slip zero; equal parts of every load step
SLIPS = 1e-6  # of the longest way: what counts as slip


def cases(short: bool) -> list[dict]:
    meshes = [(12, 2, 1)] if short else MESHES
    return [{"elements": list(mesh)} for mesh in meshes]


@cache
def joint(elements: tuple[int, int, int]) -> Problem:
    return lap_joint(elements)


def measure(case: dict) -> dict:
    began = time.process_time()
    problem = joint(tuple(case["elements"]))
    made = time.process_time()
    upper, energy = shakedown.upper_bound(problem), shakedown.energy_bound(problem)
    bounded = time.process_time()
    runs = [_cycle(problem, relative * upper.load_factor) for relative in RELATIVE]
    way = runs[-1]["way"]
    return {
        "n": problem.n,
        "upper": float(upper.load_factor),
        "energy": float(energy.load_factor),
        "work": [float(run["work"].sum()) for run in runs],
        "slipping": [int((run["way"] > SLIPS * way.max()).sum()) for run in runs],
        "open": [run["open"] for run in runs],
        "x": np.asarray(problem.x).tolist(),
        "pressure": (problem.p_w.mean(axis=0) / problem.node_area).tolist(),
        "way": way.tolist(),
        "seconds": [made - began, bounded - made, time.process_time() - bounded],
    }


def _cycle(problem: Problem, load_factor: float) -> dict:
    """Friction work [N mm] and way [mm] of every node in the last cycle, and how many of them open."""
    q_w, p_w = loading(problem).at(load_factor)
    path = ImplicitJoint(problem.A, problem.B, problem.C, problem.f, float(np.abs(p_w).max()))
    slips, nodes = np.zeros(2 * problem.n), np.zeros(problem.n)
    path.begin(slips, nodes, slips, p_w[0])
    for _ in range(CYCLES):
        found = path.follow(q_w, p_w, PARTS)
        if found.solved < problem.m:
            raise RuntimeError(f"load step {found.solved} at {load_factor:g}: {found.status.name}")
    return {
        "work": found.work.sum(axis=0),
        "way": found.length.sum(axis=0),
        "open": int((found.w > 0).any(axis=0).sum()),
    }


def exponent(row: dict) -> float:
    """Of the power law of friction work over the amplitude, between the two largest amplitudes."""
    return float(np.log(row["work"][-1] / row["work"][-2]) / np.log(RELATIVE[-1] / RELATIVE[-2]))


def tables(rows: list[dict]) -> str:
    lines = [
        [
            " x ".join(map(str, row["elements"])), str(row["n"]), f"{TIP * row['upper']:.4g}",
            f"{row['energy'] / row['upper']:.4f}",
            *(f"{work:.2e} ({count})" for work, count in zip(row["work"], row["slipping"], strict=True)),
            f"{exponent(row):.2f}", f"{sum(row['seconds']):.0f}",
        ]
        for row in rows
    ]  # fmt: skip
    headers = [
        "elements", "pairs", "P_max [N]", "λ_E/λ_max", *(f"{r:g} λ_max" for r in RELATIVE), "exponent", "s",
    ]  # fmt: skip
    return f"Friction work per cycle [N mm], and how many pairs slip, over the load:\n{table(headers, lines)}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(7.2, 5.4), layout="constrained")
    above, below = figure.subplots(2, 1)
    for row in rows:
        kept = [k for k, work in enumerate(row["work"]) if work > 0]
        amplitude = [TIP * row["upper"] * RELATIVE[k] for k in kept]
        above.loglog(amplitude, [row["work"][k] for k in kept], "o-", label=f"{row['n']} pairs")
    above.set(xlabel="amplitude of the load at the tip [N]", ylabel="friction work per cycle [N mm]")
    above.legend(fontsize=8)
    row = rows[-1]
    x, y = np.array(row["x"]).T
    shown = below.scatter(x, y, c=row["pressure"], s=14, cmap="viridis")
    figure.colorbar(shown, ax=below, label="mean pressure [MPa]")
    way = np.array(row["way"])
    slips = way > SLIPS * way.max()
    below.scatter(x[slips], y[slips], s=60, facecolors="none", edgecolors="tab:red")
    below.set(xlabel="x [mm]", ylabel="y [mm]", title=f"pairs that slip at {RELATIVE[-1]:g} λ_max (circles)")
    below.set_aspect("equal")
    return {"lap_joint": figure}
