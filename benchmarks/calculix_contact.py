"""CalculiX, with contact and friction of its own, against the toolkit on the same discrete joints.

CalculiX follows a joint through its assembly and through cycles of its load, with
node-to-surface contact whose penalty and stick slope are so high that what is left of
them vanishes with their inverse; the toolkit follows the same with neither. Compared are
slips and pressures at every pair of nodes after one cycle, slip ranges in the last one,
and whether any node still slips below and above the λ_T of the toolkit.
"""

import time
from functools import cache

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import shakedown
from benchmarks import calculix_peer
from benchmarks.calculix_cycles import follow, modelled
from benchmarks.calculix_joints import JOINTS, SIZE, YOUNG, joint
from benchmarks.display import curve, listed, panels
from shakedown import Bound
from shakedown.ground.constants import FloatArray
from shakedown.motion.evolution import evolve

TITLE = "CalculiX with contact and friction against the toolkit"
QUARTERS = 4  # steps of CalculiX in one cycle
COMPARED = {"double lap": 3.0, "shrink fit": 1.25}  # λ / λ_T, where slips and pressures are compared
BRACKET = (0.99, 0.998, 1.002, 1.01)  # λ / λ_T, where it is seen whether CalculiX comes to rest
SLOPES = (25, 250, 2500)  # penalty of gap and stick, in Young's modulus over the size of an element
AT_REST = 1e-5  # of the largest slip: what the tolerance of CalculiX's iteration lets slip in a cycle at rest


def cases(short: bool) -> list[dict]:
    if not calculix_peer.is_here():
        print(calculix_peer.ABSENT)
        return []
    if short:
        return [{"joint": name, "relative": COMPARED[name], "slope": 250, "cycles": 2} for name in JOINTS]
    bracket = [(relative, SLOPES[-1], 20) for relative in BRACKET]
    return [
        {"joint": name, "relative": relative, "slope": slope, "cycles": cycles}
        for name in JOINTS
        for relative, slope, cycles in (*((COMPARED[name], slope, 10) for slope in SLOPES), *bracket)
    ]


@cache
def limit(name: str) -> Bound:
    """λ_T of the toolkit, from slip zero as assembled."""
    return shakedown.transient_limit(modelled(name).problem)


def measure(case: dict) -> dict:
    name, cycles = case["joint"], case["cycles"]
    model, found, area = modelled(name), limit(name), joint(name).area
    load_factor = case["relative"] * found.load_factor
    begin = time.perf_counter()
    peer = follow(name, load_factor, case["slope"] * YOUNG / SIZE, cycles)
    seconds = time.perf_counter() - begin
    history = evolve(model.problem, load_factor, cycles=cycles + 1).history
    exact = history.at(np.arange(QUARTERS * cycles + 1) / QUARTERS)
    slip, pressure = exact.v * model.sense, exact.p / area
    own, theirs = ranges(slip), ranges(peer.slip)
    size = float(np.abs(slip).max())
    return {
        "n": model.problem.n,
        "limit": [float(found.low), float(found.high)],
        "upper": float(shakedown.upper_bound(model.problem, certify=False).load_factor),
        "load_factor": float(load_factor),
        "slip_apart": _apart(peer.slip[QUARTERS], slip[QUARTERS], size),
        "pressure_apart": _apart(peer.pressure[QUARTERS], pressure[QUARTERS], pressure[QUARTERS].max()),
        "range_apart": _apart(theirs[-1], own[-1], own[-1].max()) if own[-1].any() else None,
        "ranges": [float(r.max() / size) for r in theirs],
        "own_ranges": [float(r.max() / size) for r in own],
        "slip": [peer.slip[QUARTERS].tolist(), slip[QUARTERS].tolist()],
        "pressure": [peer.pressure[QUARTERS].tolist(), pressure[QUARTERS].tolist()],
        "seconds": seconds,
    }


def ranges(slip: FloatArray) -> FloatArray:
    """Slip range of every node in every cycle, (cycles, n), from slips at every quarter of them."""
    starts = range(0, len(slip) - 1, QUARTERS)
    return np.array([np.ptp(slip[k : k + QUARTERS + 1], axis=0) for k in starts])


def _apart(one: FloatArray, other: FloatArray, size: float) -> float:
    return float(np.abs(one - other).max() / size)


def is_compared(row: dict) -> bool:
    return bool(row["relative"] == COMPARED[row["joint"]])


def late(row: dict) -> list[float]:
    """Largest slip range in each cycle of the second half, relative to the largest slip."""
    return row["ranges"][len(row["ranges"]) // 2 :]


def verdict(row: dict) -> str:
    """What CalculiX does in the second half of its cycles."""
    seen = late(row)
    if max(seen) <= AT_REST:
        return "no slip"
    return "slips in every cycle" if min(seen) > AT_REST else "undecided"


def tables(rows: list[dict]) -> str:
    if not rows:
        return f"  {calculix_peer.ABSENT}"
    compared = {
        "joint": "{joint}", "λ/λ_T": "{relative:.2f}", "penalty": "{slope}",
        "slip, 1 cycle": "{slip_apart:.1e}", "pressure, 1 cycle": "{pressure_apart:.1e}",
        "range, last cycle": "{range_apart:.1e}",
    }  # fmt: skip
    bracketed = {
        "joint": "{joint}", "λ_T": "{limit[0]:.5f}", "λ_max": "{upper:.5f}", "λ/λ_T": "{relative:.3f}",
        "cycles": "{cycles}", "CalculiX": lambda row: f"{late(row)[-1]:.1e}",
        "toolkit": lambda row: f"{row['own_ranges'][-1]:.1e}", "CalculiX in the second half": verdict,
    }  # fmt: skip
    return (
        "largest difference, relative to the largest value; penalty in E / element size\n"
        f"{listed(filter(is_compared, rows), compared)}\n\n"
        "largest slip range in the last cycle, relative to the slip\n"
        f"{listed((row for row in rows if not is_compared(row)), bracketed)}"
    )


def figures(rows: list[dict]) -> dict[str, Figure]:
    names = [name for name in JOINTS if any(row["joint"] == name for row in rows)]
    if not names:
        return {}
    figure, axes = panels(4 * len(names), 4, (3.3, 3.3))
    for k, name in enumerate(names):
        mine = [row for row in rows if row["joint"] == name]
        compared = sorted(filter(is_compared, mine), key=lambda row: row["slope"])
        slip, pressure, differences, cycles = axes[4 * k : 4 * k + 4]
        _along(slip, compared[-1], "slip", "slip [nm]", 1e6)
        _along(pressure, compared[-1], "pressure", "pressure [MPa]", 1.0)
        for key, label in (("slip", "slip"), ("pressure", "pressure"), ("range", "slip range, last cycle")):
            curve(differences, compared, "slope", f"{key}_apart", label=label)
        differences.set(xlabel="penalty / (E / element size)", ylabel="difference / largest value")
        _cycles(cycles, [row for row in mine if not is_compared(row)])
        slip.set_title(f"{name}, after one cycle at {COMPARED[name]} λ_T", fontsize=9, loc="left")
        for axis in (slip, pressure, differences, cycles):
            axis.legend(fontsize=8)
    return {"calculix-contact": figure}


def _along(axes: Axes, row: dict, key: str, label: str, factor: float) -> None:
    """CalculiX and the toolkit along the (first) contact zone."""
    made = joint(row["joint"])
    zone = (made.normals == made.normals[0]).all(axis=1)
    x = SIZE * np.arange(zone.sum())
    theirs, own = (factor * np.array(values)[zone] for values in row[key])
    axes.plot(x, own, "-", color="#0072B2", label="toolkit")
    axes.plot(x, theirs, "o", color="#D55E00", ms=4, mfc="none", label="CalculiX")
    axes.set(xlabel="along the contact [mm]", ylabel=label)


def _cycles(axes: Axes, bracketed: list[dict]) -> None:
    """Whether it comes to rest: points for CalculiX, lines for the toolkit."""
    floor = AT_REST / 10
    for k, row in enumerate(bracketed):
        cycles, label = np.arange(1, row["cycles"] + 1), f"λ = {row['relative']} λ_T"
        axes.semilogy(cycles, np.maximum(row["own_ranges"], floor), "-", color=f"C{k}", lw=0.8)
        axes.semilogy(cycles, np.maximum(row["ranges"], floor), "o", color=f"C{k}", ms=3, label=label)
    axes.axhline(AT_REST, color="k", lw=0.6, ls=":", label="at rest")
    axes.set(xlabel="cycle", ylabel="slip range / largest slip")
