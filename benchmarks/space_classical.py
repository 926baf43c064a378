"""A sphere on a flat, pushed to and fro in any direction, against Cattaneo, Mindlin and Deresiewicz.

The discs of ``benchmarks.bodies.sphere.sphere_on_flat`` on finer and finer meshes, followed from event to
event through two cycles of many amplitudes of the force. Errors are root mean squares over the amplitudes,
relative to the value at the largest: at one amplitude alone they rise and fall with the place of the stick
zone's edge between two rings. The classical solution is exact for Poisson's ratio 0, which these have.
"""

import time
from functools import cache

import numpy as np
from matplotlib.figure import Figure

from benchmarks.bodies.sphere import disc_compliance, disc_patches, sphere_contact, sphere_on_flat
from benchmarks.display import curve, listed, panels
from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.motion.evolution import evolve

TITLE = "A sphere on a flat under tangential forces: error against mesh"
FRICTION = 0.5
AMPLITUDES = tuple(k / 20 for k in range(1, 20))  # T / f N
RINGS, COARSE = (3, 4, 5, 6, 8, 11), (2, 3)
DIRECTIONS = (0.0, 23.0, 50.0)  # degrees; the mesh has six equal sectors
QUANTITIES = {
    "displacement": "displacement",
    "dissipation": "dissipation",
    "stick": "stick radius",
    "traction": "tractions",
}


def cases(short: bool) -> list[dict]:
    return [{"rings": rings} for rings in (COARSE if short else RINGS)]


def measure(case: dict) -> dict:
    began, rings = time.process_time(), case["rings"]
    runs = [_errors(rings, direction) for direction in DIRECTIONS]
    middles = (_edges(rings)[1:] + _edges(rings)[:-1]) / 2
    return {
        "n": len(disc_patches(rings)[0]),
        **{key: [run[key] for run in runs] for key in QUANTITIES},
        "radius": middles.tolist(),
        "held": [run["held"] for run in runs],
        "seconds": time.process_time() - began,
    }


def _errors(rings: int, direction: float) -> dict:
    """Departures from the classical solution at every amplitude, relative to the value at the largest."""
    angle, contact = np.deg2rad(direction), sphere_contact(FRICTION)
    joint = sphere_on_flat(rings, shear=1.0, direction=angle, f=FRICTION)
    along = np.array([np.cos(angle), np.sin(angle)])
    largest = FRICTION * AMPLITUDES[-1]
    scales = (contact.displacement(largest), contact.dissipation(largest), 1.0, largest)
    errors: dict[str, list[float]] = {key: [] for key in QUANTITIES}
    for amplitude in AMPLITUDES:
        force = FRICTION * amplitude
        held, moved, work = _crest(joint, rings, amplitude)
        shear = held @ along
        apart = (
            moved @ along - contact.displacement(force),
            work - contact.dissipation(force),
            _stick(joint, rings, shear) - contact.stick(force),
            np.abs(_by_ring(shear) - contact.held_back(_edges(rings), force)).sum(),
        )
        for key, value, scale in zip(QUANTITIES, apart, scales, strict=True):
            errors[key].append(float(value / scale))
    return errors | {"held": (_by_ring(shear) / (np.pi * np.diff(_edges(rings) ** 2))).tolist()}


def _crest(joint: Problem, rings: int, amplitude: float) -> tuple[FloatArray, FloatArray, float]:
    """Forces of the patches (n, 2) and displacement (2,) at the first crest, work of the second cycle."""
    run = evolve(joint, amplitude, cycles=2)
    if run.stop is not None:
        raise RuntimeError(f"{rings} rings, {amplitude} f N: {run.stop}")
    crest = int(np.argmin(np.abs(run.history.cycle - 0.25)))
    held = -run.history.q[crest]
    moved = (_disc(rings) @ held + run.history.v[crest]).reshape(-1, 2)
    return held.reshape(-1, 2), moved.mean(axis=0), run.cycles[1].friction_dissipation


_disc = cache(disc_compliance)


@cache
def _edges(rings: int) -> FloatArray:
    return disc_patches(rings)[1]


def _by_ring(values: FloatArray) -> FloatArray:
    """Sums over rings of 1, 6, 12, … patches."""
    rings = int(np.sqrt(len(values) / 3))
    return np.add.reduceat(values, [0, *(1 + 3 * k * (k - 1) for k in range(1, rings + 1))])


def _stick(joint: Problem, rings: int, shear: FloatArray) -> float:
    """Radius of the stick zone from what friction has to spare there: √(5/2 ∫ (f p − τ) r² / ∫ (f p − τ))."""
    spare = _by_ring(FRICTION * joint.p_w[0] - shear)
    square = (_edges(rings)[1:] ** 2 + _edges(rings)[:-1] ** 2) / 2
    return float(np.sqrt(max(2.5 * (spare @ square) / spare.sum(), 0.0)))


def mean(row: dict, key: str) -> float:
    """Root mean square over the amplitudes, in the first direction."""
    return float(np.sqrt(np.mean(np.square(row[key][0]))))


def spread(row: dict, key: str) -> float:
    """Largest difference between two directions."""
    return float(np.ptp(row[key], axis=0).max())


def order(rows: list[dict], key: str) -> float:
    """Slope of the error over the mean width of the rings, fitted."""
    width = [np.log(1 / (row["rings"] + 0.5)) for row in rows]
    return float(np.polyfit(width, [np.log(mean(row, key)) for row in rows], 1)[0])


def tables(rows: list[dict]) -> str:
    columns = {"rings": "{rings}", "patches": "{n}"}
    columns |= {words: lambda row, key=key: f"{mean(row, key):.2e}" for key, words in QUANTITIES.items()}
    columns["directions"] = lambda row: f"{max(spread(row, key) for key in QUANTITIES):.0e}"
    text = (
        f"error, and largest difference between directions\n{listed(rows, columns | {'s': '{seconds:.0f}'})}"
    )
    orders = (f"{words} {order(rows, key):.2f}" for key, words in QUANTITIES.items()) if len(rows) > 1 else ()
    return f"{text}\norder: {', '.join(orders)}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure, (left, right) = panels(2, 2, (4.3, 3.8))
    shown = [
        {"width": 1 / (row["rings"] + 0.5)} | {key: mean(row, key) for key in QUANTITIES} for row in rows
    ]
    for (key, label), mark in zip(QUANTITIES.items(), "os^d", strict=True):
        curve(left, shown, "width", key, f"{mark}-", label=label)
    width = np.array([row["width"] for row in shown])
    left.loglog(width, 0.5 * width**2, "k:", lw=1, label="second order")
    left.set(
        xlabel="mean width of a ring / radius of the contact",
        ylabel="relative error",
        title="error over mesh",
    )
    left.set_xticks([0.05, 0.1, 0.2, 0.4], ["0.05", "0.1", "0.2", "0.4"], minor=False)
    left.xaxis.set_minor_formatter("")
    contact, r, row = sphere_contact(FRICTION), np.linspace(0, 1, 1001), rows[-1]
    middle, ring = (r[1:] + r[:-1]) / 2, np.pi * np.diff(r**2)
    held = contact.held_back(r, FRICTION * AMPLITUDES[-1]) / ring
    right.plot(middle, FRICTION * contact.pressure(middle), "k:", lw=1, label="f p (Hertz)")
    right.plot(middle, held, "k-", lw=1, label="Cattaneo, Mindlin")
    for found, direction, mark in zip(row["held"], DIRECTIONS, "o+x", strict=True):
        right.plot(row["radius"], found, mark, ms=6, mfc="none", label=f"{row['n']} patches, {direction:g}°")
    right.set(
        xlabel="r / a", ylabel="shear traction [N/a²]", title=f"T = {AMPLITUDES[-1]:g} f N", ylim=(0, None)
    )
    for axes in (left, right):
        axes.legend(fontsize=8)
    return {"space_classical": figure}
