"""A sphere on a flat, pushed to and fro in any direction, against Cattaneo, Mindlin and Deresiewicz.

The discs of ``benchmarks.bodies.sphere.sphere_on_flat`` on finer and finer meshes, followed from event to
event through two cycles of many amplitudes of the force. Errors are root mean squares over the amplitudes,
relative to the value at the largest: at one amplitude alone they rise and fall with the place of the stick
zone's edge between two rings. The classical solution is exact for Poisson's ratio 0. With 0.3 displacements
are not quite along the force, so that slip is not quite opposite to the traction, which it neglects: the
difference that stays is physics.
"""

import time
from functools import cache

import numpy as np
from matplotlib.figure import Figure

from benchmarks.bodies.patch_compliance import mean_half_space_compliance
from benchmarks.bodies.sphere import disc_patches, sphere_contact, sphere_on_flat
from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.motion.evolution import evolve
from shakedown.report.facts import table

TITLE = "A sphere on a flat under tangential forces: error against mesh"
FRICTION = 0.5
AMPLITUDES = tuple(k / 20 for k in range(1, 20))  # T / f N
ALSO = (0.3, 0.6, 0.9)  # the same for Poisson's ratio 0.3
RINGS, FEW_RINGS, COARSE = (3, 4, 5, 6, 8, 11), (3, 5, 8), (2, 3)
DIRECTIONS = (0.0, 23.0, 50.0)  # degrees; the mesh has six equal sectors
QUANTITIES = {
    "displacement": "displacement",
    "dissipation": "dissipation",
    "stick": "stick radius",
    "traction": "tractions",
}


def cases(short: bool) -> list[dict]:
    exact = [{"poisson": 0.0, "rings": rings} for rings in (COARSE if short else RINGS)]
    return exact + ([] if short else [{"poisson": 0.3, "rings": rings} for rings in FEW_RINGS])


def measure(case: dict) -> dict:
    began, rings, poisson = time.process_time(), case["rings"], case["poisson"]
    amplitudes = AMPLITUDES if poisson == 0 else ALSO
    runs = [_errors(rings, poisson, direction, amplitudes) for direction in DIRECTIONS]
    return {
        "n": runs[0]["n"],
        "amplitudes": list(amplitudes),
        **{key: [run[key] for run in runs] for key in (*QUANTITIES, "aside")},
        "radius": runs[0]["radius"],
        "held": [run["held"] for run in runs],
        "seconds": time.process_time() - began,
    }


def _errors(rings: int, poisson: float, direction: float, amplitudes: tuple[float, ...]) -> dict:
    """Departures from the classical solution at every amplitude, relative to the value at the largest."""
    angle, contact = np.deg2rad(direction), sphere_contact(FRICTION, poisson)
    joint = sphere_on_flat(rings, shear=1.0, direction=angle, f=FRICTION, poisson=poisson)
    along = np.array([np.cos(angle), np.sin(angle)])
    largest = FRICTION * amplitudes[-1]
    scales = (contact.displacement(largest), contact.dissipation(largest), 1.0, largest)
    errors: dict[str, list[float]] = {key: [] for key in (*QUANTITIES, "aside")}
    held = np.zeros(0)
    for amplitude in amplitudes:
        force = FRICTION * amplitude
        held, moved, work = _crest(joint, rings, poisson, amplitude)
        exact = (contact.displacement(force), contact.dissipation(force), contact.stick(force))
        shear = held @ along
        found = (moved @ along, work, _stick(joint, rings, shear))
        apart = [one - other for one, other in zip(found, exact, strict=True)]
        apart.append(float(np.abs(_by_ring(shear) - contact.held_back(_edges(rings), force)).sum()))
        for key, value, scale in zip(QUANTITIES, apart, scales, strict=True):
            errors[key].append(float(value / scale))
        errors["aside"].append(float(abs(moved @ [-along[1], along[0]]) / scales[0]))
    middles = (_edges(rings)[1:] + _edges(rings)[:-1]) / 2
    areas = np.pi * np.diff(_edges(rings) ** 2)
    return errors | {
        "n": joint.n,
        "radius": middles.tolist(),
        "held": (_by_ring(held @ along) / areas).tolist(),
    }


def _crest(
    joint: Problem, rings: int, poisson: float, amplitude: float
) -> tuple[FloatArray, FloatArray, float]:
    """Forces of the patches (n, 2) and displacement (2,) at the first crest, work of the second cycle."""
    run = evolve(joint, amplitude, cycles=2)
    if run.stop is not None:
        raise RuntimeError(f"{rings} rings, {amplitude} f N: {run.stop}")
    crest = int(np.argmin(np.abs(run.history.cycle - 0.25)))
    held = -run.history.q[crest]
    moved = (_compliance(rings, poisson) @ held + run.history.v[crest]).reshape(-1, 2)
    return held.reshape(-1, 2), moved.mean(axis=0), run.cycles[1].friction_dissipation


@cache
def _edges(rings: int) -> FloatArray:
    return disc_patches(rings)[1]


@cache
def _compliance(rings: int, poisson: float) -> FloatArray:
    """Tangential, of both bodies (2n, 2n)."""
    whole = mean_half_space_compliance(disc_patches(rings)[0], poisson=poisson)
    along = np.arange(len(whole)).reshape(-1, 3)[:, :2].ravel()
    return 2 * whole[np.ix_(along, along)]


def _by_ring(values: FloatArray) -> FloatArray:
    """Sums over rings of 1, 6, 12, … patches."""
    begins, count = [0, 1], 1
    while begins[-1] < len(values):
        begins.append(begins[-1] + 6 * count)
        count += 1
    return np.add.reduceat(values, begins[:-1])


def _stick(joint: Problem, rings: int, shear: FloatArray) -> float:
    """Radius of the stick zone from what friction has to spare there: √(5/2 ∫ (f p − τ) r² / ∫ (f p − τ))."""
    spare = _by_ring(FRICTION * joint.p_w[0] - shear)
    square = (_edges(rings)[1:] ** 2 + _edges(rings)[:-1] ** 2) / 2
    return float(np.sqrt(max(2.5 * (spare @ square) / spare.sum(), 0.0)))


def mean(row: dict, key: str, direction: int = 0) -> float:
    """Root mean square over the amplitudes."""
    return float(np.sqrt(np.mean(np.square(row[key][direction]))))


def spread(row: dict, key: str) -> float:
    """Largest difference between two directions."""
    return float(np.ptp(row[key], axis=0).max())


def order(rows: list[dict], key: str, direction: int = 0) -> float:
    """Slope of the error over the mean width of the rings, fitted."""
    width = [np.log(1 / (row["rings"] + 0.5)) for row in rows]
    return float(np.polyfit(width, [np.log(mean(row, key, direction)) for row in rows], 1)[0])


def exact_rows(rows: list[dict]) -> list[dict]:
    return [row for row in rows if row["poisson"] == 0]


def neglected(rows: list[dict], row: dict, key: str) -> list[float]:
    """What Poisson's ratio adds to the departure on the same mesh; at every amplitude, mean of directions."""
    same = next(other for other in exact_rows(rows) if other["rings"] == row["rings"])
    forces = [FRICTION * part["amplitudes"][-1] for part in (same, row)]
    contact = sphere_contact(FRICTION)
    scale = {
        "displacement": contact.displacement(forces[0]) / contact.displacement(forces[1]),
        "dissipation": contact.dissipation(forces[0]) / contact.dissipation(forces[1]),
    }[key]
    at = [same["amplitudes"].index(amplitude) for amplitude in row["amplitudes"]]
    found, without = np.mean(row[key], axis=0), np.mean(same[key], axis=0)[at]
    return (found - scale * without).tolist()


def tables(rows: list[dict]) -> str:
    exact, others = exact_rows(rows), [row for row in rows if row["poisson"] > 0]
    text = ""
    if exact:
        lines = [
            [str(row["rings"]), str(row["n"]), *(f"{mean(row, key):.2e}" for key in QUANTITIES),
             f"{max(spread(row, key) for key in QUANTITIES):.0e}", f"{row['seconds']:.0f}"]
            for row in exact
        ]  # fmt: skip
        fitted = [f"{order(exact, key):.2f}" if len(exact) > 1 else "-" for key in QUANTITIES]
        lines.append(["order", "", *fitted, "", ""])
        heads = ["rings", "patches", *QUANTITIES.values(), "directions", "s"]
        text += f"Poisson's ratio 0: error, and largest difference between directions\n{table(heads, lines)}"
    if others:
        words = ("displacement", "dissipation")
        lines = [
            [str(row["rings"]), f"{amplitude:g}",
             *(f"{100 * np.mean([part[k] for part in row[key]]):.2f}" for key in words),
             *(f"{100 * neglected(rows, row, key)[k]:.2f}" for key in words),
             *(f"{np.ptp([part[k] for part in row[key]]):.0e}" for key in words),
             f"{max(part[k] for part in row['aside']):.0e}"]
            for row in others for k, amplitude in enumerate(row["amplitudes"])
        ]  # fmt: skip
        heads = ["rings", "T/fN", "displ. [%]", "diss. [%]", "less mesh [%]", "less mesh [%]"]
        heads += ["displ. by direction", "diss. by direction", "aside"]
        text += (
            "\n\nPoisson's ratio 0.3: departure from the classical solution, and less that with 0 there\n"
            f"{table(heads, lines)}"
        )
    return text.strip()


def figures(rows: list[dict]) -> dict[str, Figure]:
    exact = exact_rows(rows)
    figure = Figure(figsize=(8.6, 3.8), layout="constrained")
    left, right = figure.subplots(1, 2)
    width = np.array([1 / (row["rings"] + 0.5) for row in exact])
    for (key, label), mark in zip(QUANTITIES.items(), "os^d", strict=True):
        left.loglog(width, [mean(row, key) for row in exact], f"{mark}-", ms=4, label=label)
    left.loglog(width, 0.5 * width**2, "k:", lw=1, label="second order")
    left.set(
        xlabel="mean width of a ring / radius of the contact",
        ylabel="relative error",
        title="error over mesh",
    )
    left.set_xticks([0.05, 0.1, 0.2, 0.4], ["0.05", "0.1", "0.2", "0.4"], minor=False)
    left.xaxis.set_minor_formatter("")
    left.legend(fontsize=8)
    left.grid(alpha=0.3, which="both")
    force = FRICTION * AMPLITUDES[-1]
    contact, r = sphere_contact(FRICTION), np.linspace(0, 1, 1001)
    middle, ring = (r[1:] + r[:-1]) / 2, np.pi * np.diff(r**2)
    right.plot(middle, FRICTION * contact.pressure(middle), "k:", lw=1, label="f p (Hertz)")
    right.plot(middle, contact.held_back(r, force) / ring, "k-", lw=1, label="Cattaneo, Mindlin")
    row = exact[-1]
    for held, direction, mark in zip(row["held"], DIRECTIONS, "o+x", strict=True):
        right.plot(row["radius"], held, mark, ms=6, mfc="none", label=f"{row['n']} patches, {direction:g}°")
    right.set(
        xlabel="r / a", ylabel="shear traction [N/a²]", title=f"T = {AMPLITUDES[-1]:g} f N", ylim=(0, None)
    )
    right.legend(fontsize=8)
    return {"space_classical": figure}
