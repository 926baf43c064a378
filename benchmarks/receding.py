"""Chapter III of the thesis reproduced: the receding contact of a block on a rigid plane.

A block h × 4h is pressed on a rigid plane by a pressure on the central strip 2h
of its top, f = 0.35, ν = 0.3; the pressure rises to p_max, then cycles between
p_max and p_max/3. The thesis (figs. 3.2–3.8) reports zones of stick, slip and
separation that do not change during the first loading, slip increments per cycle
that fall like N^−3.1, and a dissipation per cycle that falls to about 56 % of the
first. Its mesh is not stated: the study repeats the case on several.

Slip increment of cycle N: largest change of any node's slip from the start to
the end of the cycle. Dissipation: Σ −½ (q_old + q_new) Δv over its load steps.
A cycle leads from p_max to p_max, so the first loading is no part of the first.
"""

import argparse
import time
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.runner import run_study
from shakedown.fem import receding_block
from shakedown.problem import Problem
from shakedown.simulation import History, simulate

TITLE = "Chapter III: receding contact under cyclic loading"
THESIS_EXPONENT, THESIS_RATIO = -3.1, 0.56
FIRST_LOADING = 10
OPEN_GAP = 1e-9  # in p_max h/E, as slips below
STICKING = 1e-11
FLOOR = 1e-7  # increments below this share of the first are left out of the fits
GREY, COLOURS = "0.75", {"o": "white", "s": "0.35", "+": "tab:red", "-": "tab:blue"}
MEANING = {"o": "open", "s": "stick", "+": "slip outwards", "-": "slip inwards"}


def cases(short: bool) -> list[dict[str, Any]]:
    """Halves of the block on refined meshes and with refined load steps, and one whole block."""
    sizes = [(2, 40), (4, 40)] if short else [(2, 40), (4, 40), (6, 40), (8, 40), (12, 40), (8, 80)]
    halves = [{"refinement": r, "steps": m, "symmetric": True, "cycles": 100} for r, m in sizes]
    return [*halves, {"refinement": 4, "steps": 40, "symmetric": False, "cycles": 100}]


def measure(case: dict[str, Any]) -> dict[str, Any]:
    """Simulate one mesh and reduce the history to what the figures show."""
    block = receding_block(
        case["refinement"], symmetric=case["symmetric"], steps=case["steps"], first_loading=FIRST_LOADING
    )
    began = time.perf_counter()
    run = simulate(block, 1.0, cycles=case["cycles"], record=True)
    seconds = time.perf_counter() - began
    assert run.history is not None
    zones, dissipation = _zones(block, run.history), _dissipation(run.history)
    per_cycle = dissipation[FIRST_LOADING:].reshape(-1, case["steps"]).sum(axis=1)
    increment = np.abs(np.diff(run.cycles.end_slip, axis=0)).max(axis=1)
    loading, last = zones[:FIRST_LOADING], len(zones) - case["steps"]
    return {
        "nodes": block.n,
        "seconds": round(seconds, 2),
        "cycles_simulated": run.cycles_simulated,
        "friction_law": run.residual,
        "x": _position(block, case).tolist(),
        "first_loading": loading,
        "first_loading_changes": max(_differences(loading[0], other) for other in loading[1:]),
        "first_loading_dissipation": float(dissipation[:FIRST_LOADING].sum()),
        "first_cycle": zones[FIRST_LOADING : FIRST_LOADING + case["steps"]],
        "last_cycle": zones[last:],
        "dissipation": per_cycle.tolist(),
        "dissipation_ratio": float(per_cycle[-1] / per_cycle[0]),
        "increment": increment.tolist(),
        "exponents": _exponents(increment),
        "tractions": _tractions(block, case, run.history),
    }


def _position(block: Problem, case: dict[str, Any]) -> np.ndarray:
    """Distance of the nodes from the middle [h]."""
    assert block.x is not None
    return block.x if case["symmetric"] else block.x - 2.0


def _zones(block: Problem, history: History) -> list[str]:
    """One letter per node and load step; outwards and inwards as seen from the middle."""
    assert block.x is not None
    outward = np.where(block.x >= (2.0 if block.x[-1] > 3 else 0.0), 1.0, -1.0)
    letters = np.full(history.w.shape, "s")
    letters[history.slip * outward > STICKING] = "+"
    letters[history.slip * outward < -STICKING] = "-"
    letters[history.w > OPEN_GAP] = "o"
    return ["".join(row) for row in letters]


def _dissipation(history: History) -> np.ndarray:
    before = np.vstack([np.zeros_like(history.q[:1]), history.q[:-1]])
    return -(0.5 * (before + history.q) * history.slip).sum(axis=1)


def _differences(first: str, second: str) -> int:
    return sum(a != b for a, b in zip(first, second, strict=True))


def _exponents(increment: np.ndarray) -> dict[str, float]:
    """Slope of log increment over log N in windows of N, as far as the increments are above the floor."""
    N = np.arange(1, len(increment) + 1)
    usable = increment > FLOOR * increment[0]
    slopes = {}
    for low, high in ((2, 10), (5, 20), (10, 40)):
        inside = usable & (low <= N) & (high >= N)
        if inside.sum() == high - low + 1:
            slope = np.polyfit(np.log(N[inside]), np.log(increment[inside]), 1)[0]
            slopes[f"{low}-{high}"] = round(float(slope), 3)
    return slopes


def _tractions(block: Problem, case: dict[str, Any], history: History) -> dict[str, list[list[float]]]:
    """Normal and tangential tractions [p_max]: nodal reactions over the length they stand for."""
    length = np.full(block.n, 0.25 / case["refinement"])
    length[[0, -1]] /= 2
    half, last = case["steps"] // 2, len(history.p) - 1
    moments = {
        "p_max, first loading": FIRST_LOADING - 1,
        "p_max/3, first cycle": FIRST_LOADING - 1 + half,
        "p_max, last cycle": last,
        "p_max/3, last cycle": last - half,
    }
    return {
        label: [(history.p[k] / length).tolist(), (history.q[k] / length).tolist()]
        for label, k in moments.items()
    }


def tables(rows: list[dict[str, Any]]) -> str:
    """One line per mesh, beside the thesis."""
    lines = [
        "nodes  steps  cycles   s     zones changed    slope of the increment         dissipation",
        "                             in loading       N=2-10   5-20    10-40        last/first",
    ]
    for row in rows:
        slopes = "  ".join(f"{row['exponents'].get(key, np.nan):6.2f}" for key in ("2-10", "5-20", "10-40"))
        kind = "half" if row["symmetric"] else "whole"
        lines.append(
            f"{row['nodes']:4} {kind:5} {row['steps']:4} {row['cycles_simulated']:5} {row['seconds']:7.1f}"
            f"{row['first_loading_changes']:8}          {slopes}        {row['dissipation_ratio']:.4f}"
        )
    lines.append(f"thesis{'':26}0               {THESIS_EXPONENT:6.2f}{'':22}{THESIS_RATIO:.2f}")
    return "\n".join(lines)


def figures(rows: list[dict[str, Any]]) -> dict[str, Figure]:
    """Zones, tractions, slip increments and dissipation."""
    halves = [row for row in rows if row["symmetric"]]
    finest = max(halves, key=lambda row: (row["nodes"], row["steps"]))
    return {
        "receding-zones": _zone_figure(finest),
        "receding-tractions": _traction_figure(finest),
        "receding-increments": _increment_figure(halves),
        "receding-dissipation": _dissipation_figure(halves),
    }


def _zone_figure(row: dict[str, Any]) -> Figure:
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    panels = figure.subplots(1, 3, sharex=True)
    titles = ("first loading (thesis fig. 3.2)", "first cycle", f"cycle {row['cycles_simulated']}")
    letters = list(COLOURS)
    for axes, title, key in zip(panels, titles, ("first_loading", "first_cycle", "last_cycle"), strict=True):
        image = np.array([[letters.index(letter) for letter in zone] for zone in row[key]])
        top = len(image) / (FIRST_LOADING if key == "first_loading" else row["steps"])
        edges = row["x"], (np.arange(len(image)) + 0.5) / len(image) * top
        colours = [COLOURS[letter] for letter in letters]
        axes.pcolormesh(*edges, image, cmap=_colour_map(colours), vmin=-0.5, vmax=3.5, shading="nearest")
        axes.set(title=title, xlabel="distance from the middle [h]")
    panels[0].set_ylabel("pressure [p_max]")
    panels[1].set_ylabel("time [cycles]; p_max/3 at 0.5")
    handles = [_patch(COLOURS[letter], MEANING[letter]) for letter in letters]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    figure.suptitle(f"Zones of the receding contact, {row['nodes']} nodes on the half")
    return figure


def _colour_map(colours: list[str]) -> Any:
    from matplotlib.colors import ListedColormap

    return ListedColormap(colours)


def _patch(colour: str, label: str) -> Any:
    from matplotlib.patches import Patch

    return Patch(facecolor=colour, edgecolor="black", label=label)


def _traction_figure(row: dict[str, Any]) -> Figure:
    figure = Figure(figsize=(10, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharex=True)
    for (label, (p, q)), style in zip(row["tractions"].items(), ("-", "--", "-", "--"), strict=True):
        colour = "black" if "first" in label else "tab:orange"
        left.plot(row["x"], p, style, color=colour, label=label)
        right.plot(row["x"], q, style, color=colour, label=label)
    left.set(title="normal", xlabel="distance from the middle [h]", ylabel="traction [p_max]")
    right.set(title="tangential", xlabel="distance from the middle [h]")
    left.legend(frameon=False)
    for axes in (left, right):
        axes.axhline(0, color=GREY, linewidth=0.8, zorder=0)
    figure.suptitle(f"Tractions of the receding contact, {row['nodes']} nodes on the half")
    return figure


def _increment_figure(rows: list[dict[str, Any]]) -> Figure:
    figure = Figure(figsize=(7, 4.8), layout="constrained")
    axes = figure.subplots()
    for row in rows:
        increment = np.array(row["increment"])
        keep = increment > FLOOR * increment[0]
        N = np.arange(1, len(increment) + 1)[keep]
        axes.loglog(
            N, increment[keep] / increment[0], ".-", label=f"{row['nodes']} nodes, {row['steps']} steps"
        )
    N = np.array([3.0, 60.0])
    axes.loglog(N, 0.12 * (N / 3) ** THESIS_EXPONENT, "k--", label=f"thesis: N^{THESIS_EXPONENT}")
    axes.set(
        xlabel="cycle N",
        ylabel="largest slip increment of the cycle / that of the first",
        title="Slip increments fall like a power of N until the mesh is felt",
    )
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    return figure


def _dissipation_figure(rows: list[dict[str, Any]]) -> Figure:
    figure = Figure(figsize=(7, 4.8), layout="constrained")
    axes = figure.subplots()
    for row in rows:
        dissipation = np.array(row["dissipation"][:20])
        N = np.arange(1, len(dissipation) + 1)
        axes.plot(N, dissipation / dissipation[0], ".-", label=f"{row['nodes']} nodes, {row['steps']} steps")
    axes.axhline(THESIS_RATIO, color="black", linestyle="--", label="thesis: about 56 %")
    axes.set(
        xlabel="cycle N",
        ylabel="dissipation of the cycle / that of the first",
        title="Dissipation per cycle",
        ylim=(0.5, 1.02),
    )
    axes.legend(frameon=False)
    axes.grid(alpha=0.3)
    return figure


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m benchmarks.receding", description=TITLE)
    parser.add_argument("--short", action="store_true", help="two coarse meshes")
    parser.add_argument("--fresh", action="store_true", help="measure again what is already stored")
    options = parser.parse_args()
    run_study("receding", short=options.short, fresh=options.fresh)
