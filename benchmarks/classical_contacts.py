"""A press fit and a cylinder on a flat against Lamé, Hertz, Cattaneo and Mindlin: error against mesh.

And the steady state of the cylinder where normal and tangential force vary out of phase: the zone that never
slips is as wide as the contact under the force P₀ at which a line of slope f and one of slope −f meet, both
tangent to the loop of (P, Q) (Barber, Davies and Hills, Int. J. Solids Struct. 48 (2011) 1955; Andresen and
Hills, arXiv:1908.07939).
"""

import numpy as np

from benchmarks.bodies.classical import cylinder_on_flat, hertz, press_fit, press_fit_pressure
from benchmarks.display import listed
from shakedown.motion.evolution import evolve

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


TABLES = {
    "press fit": (
        "pressure against Lamé, largest relative error",
        {"nodes": "{nodes}", "error": "{pressure:.2e}"},
    ),
    "cylinder on a flat": (
        "relative errors (peak, mean pressure, mean shear); edges in elements",
        {"nodes": "{nodes}", "peak": "{peak:.1e}", "pressure": "{pressure:.1e}", "shear": "{shear:.1e}",
         "edge/h": "{contact_edge:.2f}", "stick/h": "{stick_edge:.2f}"},
    ),
    "P and Q vary": (
        "half-width of what never slips",
        {"phase": "{phase:g}", "nodes": "{nodes}", "half-planes": "{half_width:.3f}", "found": "{found:.3f}",
         "apart/h": "{apart:.2f}"},
    ),
}  # fmt: skip


def tables(rows: list[dict]) -> str:
    parts = []
    for contact, (words, columns) in TABLES.items():
        mine = [row for row in rows if row["contact"] == contact]
        parts.append(f"{contact}: {words}\n{listed(mine, columns)}")
    return "\n\n".join(parts)
