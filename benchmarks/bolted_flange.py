"""A sector of a bolted flange: what is proved of it, and what it dissipates above that.

Two flanges touch on a ring around the hole of their bolt; the pipe's wall is pulled and sheared, a quarter of
a period apart. On some meshes: λ_max, λ_E and λ_U, and the friction work of a cycle over the amplitude. Loads
are those of the joint, the same on every mesh: λ_max may be about one of its elements.
"""

import time

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

import shakedown
from benchmarks.bodies.bolted_flange import bolted_flange
from benchmarks.display import listed
from shakedown import Problem
from shakedown.joint.constraints import loading
from shakedown.motion.evolution import evolve
from shakedown.plot.patch_places import Places, patch_axes, places_of

TITLE = "A sector of a bolted flange: limits, and friction work over the amplitude"
# Elements around the hole, across the ring and over the thickness.
MESHES = ((8, 2, 2), (16, 4, 3), (24, 6, 5), (32, 8, 6))
LOADS = (4.0, 5.0, 6.0, 7.0, 8.0, 10.0)  # amplitude of the shear [kN], on all meshes
SHEAR = 4.0  # amplitude along the circumference at λ = 1 [kN]
CYCLES = 6  # followed from slip zero
SLIPS = 1e-6  # of the longest way: what counts as slip
MARKED = 25.0  # area of a mark on the patch [points²]


def cases(short: bool) -> list[dict]:
    return [{"elements": list(mesh)} for mesh in (MESHES[:1] if short else MESHES)]


def measure(case: dict) -> dict:
    """Limits; work, slipping and open pairs in the last cycle, load by load.

    The patch is that at the first load factor above λ_max, and at the last.
    """
    began = time.process_time()
    problem = bolted_flange(tuple(case["elements"]))
    made = time.process_time()
    upper, energy = shakedown.upper_bound(problem), shakedown.energy_bound(problem)
    universal = shakedown.universal_bound(problem)
    bounded = time.process_time()
    load_factors = [load / SHEAR for load in LOADS]
    runs = [_last_cycle(problem, factor) for factor in load_factors]
    shown = [next(k for k, factor in enumerate(load_factors) if factor > upper.load_factor), -1]
    places = places_of(problem)
    return {
        "n": problem.n,
        "upper": float(upper.load_factor),
        "energy": float(energy.load_factor),
        "universal": float(universal.load_factor),
        "work": [run.friction_dissipation for run in runs],
        "slipping": [int(_slips(run.slip, runs[-1].slip).sum()) for run in runs],
        "open": [int(run.opened.sum()) for run in runs],
        "x": places.points.tolist(),
        "axes": [*places.axes, places.unit],
        "pressure": (loading(problem).at(0.0)[1].mean(axis=0) / problem.node_area).tolist(),
        "shown": [load_factors[k] for k in shown],
        "way": [runs[k].slip.tolist() for k in shown],
        "seconds": [made - began, bounded - made, time.process_time() - bounded],
    }


def _last_cycle(problem: Problem, load_factor: float):
    """The record of the last cycle."""
    run = evolve(problem, load_factor, cycles=CYCLES)
    if run.stop is not None:
        raise RuntimeError(f"at {load_factor:g}: {run.stop.reason}")
    return run.cycles[-1]


def _slips(way: np.ndarray, longest: np.ndarray) -> np.ndarray:
    return way > SLIPS * longest.max()


def tables(rows: list[dict]) -> str:
    """Limits, friction work and slipping pairs of every mesh."""
    of_loads = {f"{load:g} kN": f"{{work[{k}]:.2e}} ({{slipping[{k}]}})" for k, load in enumerate(LOADS)}
    columns = {
        "elements": lambda row: " x ".join(map(str, row["elements"])), "pairs": "{n}",
        "λ_max [kN]": lambda row: f"{SHEAR * row['upper']:.4g}",
        "λ_E/λ_max": lambda row: f"{row['energy'] / row['upper']:.4f}",
        "λ_U/λ_max": lambda row: f"{row['universal'] / row['upper']:.2g}", **of_loads,
        "s": lambda row: f"{sum(row['seconds']):.1f}",
    }  # fmt: skip
    about = "Friction work per cycle [N mm], and how many pairs slip, over the load:"
    return f"{about}\n{listed(rows, columns)}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    """Friction work over the amplitude; pressure and slip over the patch of the finest mesh."""
    figure = Figure(figsize=(8.4, 6.8), layout="constrained")
    panels = figure.subplots(2, 2)
    row = rows[-1]
    _work_curves(panels[0, 0], rows)
    _patch(panels[0, 1], row, np.array(row["pressure"]), "mean pressure [MPa]", None)
    for axes, factor, way in zip(panels[1], row["shown"], row["way"], strict=True):
        slips = _slips(np.array(way), np.array(row["way"][-1]))
        _patch(axes, row, 1e3 * np.array(way), "sliding distance per cycle [µm]", slips)
        axes.set_title(f"{SHEAR * factor:g} kN: {slips.sum()} of {row['n']} pairs slip", fontsize="medium")
    panels[0, 1].set_title("constant load alone", fontsize="medium")
    return {"bolted_flange": figure}


def _work_curves(axes: Axes, rows: list[dict]) -> None:
    for row in rows:
        kept = [k for k, count in enumerate(row["slipping"]) if count]
        axes.loglog([LOADS[k] for k in kept], [row["work"][k] for k in kept], "o-", label=f"{row['n']} pairs")
    axes.xaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set(xlabel="shear force amplitude [kN]", ylabel="friction work per cycle [N mm]")
    axes.legend(fontsize="small")


def _patch(axes: Axes, row: dict, values: np.ndarray, label: str, slips: np.ndarray | None) -> None:
    """Values in colours; where slipping nodes are given they are marked, and so are those that stick."""
    *names, unit = row["axes"]
    points, count = np.array(row["x"]), row["n"]
    places = Places(np.arange(count), points, np.tile(np.eye(2), (count, 1, 1)), tuple(names), unit=unit)
    patch_axes(places, axes, 0.5 * places.spacing)
    shown = (
        axes.scatter(*points.T, c=values, s=MARKED)
        if places.triangles is None
        else axes.tripcolor(places.triangles, values, shading="gouraud", rasterized=True)
    )
    axes.figure.colorbar(shown, ax=axes, label=label)
    if slips is not None:
        axes.scatter(*points[slips].T, s=0.25 * MARKED, c="tab:red", label="slips")
        axes.scatter(*points[~slips].T, s=0.25 * MARKED, fc="none", ec="white", lw=0.6, label="sticks")
