"""A press fit and a cylinder on a flat against Lamé, Hertz, Cattaneo and Mindlin: error against mesh.

And the steady state of the cylinder where normal and tangential force vary out of phase: the zone that never
slips is as wide as the contact under the force P₀ at which a line of slope f and one of slope −f meet, both
tangent to the loop of (P, Q) (Barber, Davies and Hills, Int. J. Solids Struct. 48 (2011) 1955; Andresen and
Hills, arXiv:1908.07939).
"""

from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullFormatter, ScalarFormatter

from benchmarks.bodies.classical import cylinder_on_flat, hertz, press_fit, press_fit_pressure
from shakedown.motion.evolution import evolve
from shakedown.report.facts import table

TITLE = "Classical contacts: error against element size"
INTERFERENCE, FRICTION, HALF = 1e-3, 0.3, 1.5
PHASES = (0.25, 0.1, 0.0)  # of the normal force before the tangential one, in periods
CYCLES = 6  # until the state is steady


def cases(short: bool) -> list[dict]:
    levels = (1, 2, 4) if short else (1, 2, 4, 8)
    pressed = [
        {"contact": name, "refinement": k} for name in ("press fit", "cylinder on a flat") for k in levels
    ]
    return pressed + [
        {"contact": "P and Q vary", "refinement": k, "phase": phase} for phase in PHASES for k in levels
    ]


def measure(case: dict) -> dict:
    if case["contact"] == "press fit":
        return press_fit_errors(case["refinement"])
    if case["contact"] == "P and Q vary":
        return permanent_stick(case["refinement"], case["phase"])
    return line_contact_errors(case["refinement"])


def press_fit_errors(refinement: int) -> dict:
    """Largest relative error of the pressure along the fit."""
    problem = press_fit(refinement, interference=INTERFERENCE)
    length = np.full(problem.n, (np.pi / 2) / (problem.n - 1))
    length[[0, -1]] /= 2
    pressure = problem.p_w.mean(axis=0) / length
    return {
        "nodes": problem.n,
        "pressure": float(np.abs(pressure / press_fit_pressure(INTERFERENCE) - 1).max()),
    }


def line_contact_errors(refinement: int) -> dict:
    """Errors after pressing (pressure) and at the first crest of the shear (shear, stick zone)."""
    problem = cylinder_on_flat(refinement, f=FRICTION)
    history = evolve(problem, 1.0, cycles=1).history
    assert problem.x is not None
    x, size = problem.x - HALF, 2 * HALF / (problem.n - 1)
    pressed, crest = (int(np.argmin(np.abs(history.cycle - time))) for time in (0.0, 0.25))
    normal = float(history.p[pressed].sum())
    alone = hertz(normal)
    normal_at_crest, shear = float(history.p[crest].sum()), float(abs(history.q[crest].sum()))
    sheared = hertz(normal_at_crest, shear, FRICTION)
    q, p = np.abs(history.q[crest]), history.p[crest]
    closed = history.state[crest] != 2
    stick = closed & (q < FRICTION * p * (1 - 1e-9))
    return {
        "nodes": problem.n,
        "half_width": alone.half_width,
        "stick_half_width": sheared.stick,
        "utilisation": shear / (FRICTION * normal_at_crest),
        "peak": abs(float(history.p[pressed].max()) / size / alone.peak - 1),
        "pressure": float(np.abs(history.p[pressed] - alone.pressure(x) * size).sum() / normal),
        "shear": float(np.abs(q - sheared.shear(x, FRICTION) * size).sum() / shear),
        "contact_edge": abs(closed.sum() * size / 2 - alone.half_width) / size,
        "stick_edge": abs(stick.sum() * size / 2 - sheared.stick) / size,
    }


def permanent_stick(refinement: int, phase: float) -> dict:
    """Half-width of what never slips in the steady state, beside that of the contact under P₀."""
    problem = cylinder_on_flat(refinement, shift=0.012, f=FRICTION, steps=48, swing=0.25, phase=phase)
    history = evolve(problem, 1.0, cycles=CYCLES).history
    last = history.rows(history.cycle > CYCLES - 1 - 1e-9)
    normal, shear = last.p.sum(axis=1), last.q.sum(axis=1)
    least = (np.min(shear + FRICTION * normal) - np.max(shear - FRICTION * normal)) / (2 * FRICTION)
    slip = np.ptp(last.v, axis=0)
    stick = np.all(last.state != 2, axis=0) & (slip < 1e-9 * slip.max())
    size, width = 2 * HALF / (problem.n - 1), hertz(least).half_width
    found = float(stick.sum() * size / 2)
    return {
        "nodes": problem.n,
        "P0": float(least),
        "half_width": width,
        "found": found,
        "apart": abs(found - width) / size,
    }


def rates(errors: list[float]) -> list[str]:
    """Order of convergence between each mesh and the next."""
    return ["-" for _ in errors[:1]] + [f"{np.log2(a / b):.2f}" for a, b in pairwise(errors)]


def tables(rows: list[dict]) -> str:
    fit = [row for row in rows if row["contact"] == "press fit"]
    flat = [row for row in rows if row["contact"] == "cylinder on a flat"]
    first = [
        [str(row["nodes"]), f"{row['pressure']:.2e}", rate]
        for row, rate in zip(fit, rates([row["pressure"] for row in fit]), strict=True)
    ]
    second = [
        [
            str(row["nodes"]), f"{row['peak']:.1e}", f"{row['pressure']:.1e}", pressure_rate,
            f"{row['shear']:.1e}", shear_rate, f"{row['contact_edge']:.2f}", f"{row['stick_edge']:.2f}",
        ]
        for row, pressure_rate, shear_rate in zip(
            flat, rates([row["pressure"] for row in flat]), rates([row["shear"] for row in flat]), strict=True
        )
    ]  # fmt: skip
    varied = [
        [
            f"{row['phase']:g}",
            str(row["nodes"]),
            f"{row['half_width']:.3f}",
            f"{row['found']:.3f}",
            f"{row['apart']:.2f}",
        ]
        for row in rows
        if row["contact"] == "P and Q vary"
    ]
    heads = ["nodes", "peak", "pressure", "order", "shear", "order", "edge/h", "stick/h"]
    return (
        "press fit, pressure against Lamé (largest relative error)\n"
        + table(["nodes", "error", "order"], first)
        + "\n\ncylinder on a flat: relative errors (peak, mean pressure, mean shear); edges in elements\n"
        + table(heads, second)
        + "\n\nP and Q vary: half-width of what never slips\n"
        + table(["phase", "nodes", "half-planes", "found", "apart/h"], varied)
    )


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(6.5, 4), layout="constrained")
    axes = figure.subplots()
    shown = (
        ("press fit", "pressure", "press fit, pressure (Lamé)"),
        ("cylinder on a flat", "pressure", "cylinder, pressure (Hertz)"),
        ("cylinder on a flat", "shear", "cylinder, shear (Cattaneo, Mindlin)"),
    )
    for contact, key, label in shown:
        mine = sorted((row["refinement"], row[key]) for row in rows if row["contact"] == contact)
        if mine:
            axes.loglog(*zip(*mine, strict=True), "o-", ms=4, label=label)
    axes.set(xlabel="elements multiplied by", ylabel="relative error")
    axes.set_xticks(sorted({row["refinement"] for row in rows}), minor=False)
    axes.xaxis.set_major_formatter(ScalarFormatter())
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.legend(fontsize=8)
    axes.grid(alpha=0.3, which="both")
    return {"classical-contacts": figure}
