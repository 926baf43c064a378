"""Chapter III of the thesis reproduced: the receding contact of a block on a rigid plane.

A block h × 4h is pressed on a rigid plane by a pressure on the central strip 2h
of its top, f = 0.35, ν = 0.3; the pressure rises to p_max, then cycles between
p_max and p_max/3. The thesis (figs. 3.2–3.8) reports zones of stick, slip and
separation that do not change during the first loading, slip increments per cycle
that fall like N^−3.1, and a dissipation per cycle that falls to about 56 % of the
first. Its mesh is not stated: the study repeats the case on several. Nor does it say
which plane it means: plane strain is our choice.

A cycle leads from p_max to p_max, so the first loading is no part of the first.
Slip increment of cycle N: largest change of any node's slip from the start to
the end of the cycle. The path is followed from event to event, so neither it nor
the dissipation −∫ q dv depends on a load step; one mesh is repeated with the
thesis's fixed load steps.

What comes out (``results/receding.json``): on every mesh the zones of the first
loading do not change at all. On the finest mesh the exponent is −3.09, −3.11, −3.06
over N = 5–20, 10–40, 20–80; over 5–20 it is −2.95 to −3.14 on coarser ones, and over
2–10, where the power law is not reached yet, −2.65 to −2.77 on all. The dissipation
falls to 0.553–0.557 of the first cycle's from 33 nodes on the half upwards (0.547
with 17), the upper end on the coarser meshes: the thesis's "about 56 %".

On a mesh the power law must end: as soon as the sequence of contact states
repeats, the map from cycle to cycle is affine and the increments fall
geometrically. The finer the mesh, the later that happens; the exponent is read
off before it does.
"""

import argparse
import time
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.bodies.blocks import receding_block
from benchmarks.runner import run_study
from shakedown import Problem, simulate
from shakedown.ground.constants import FloatArray
from shakedown.motion.event_history import EventHistory

TITLE = "Chapter III: receding contact under cyclic loading"
THESIS_EXPONENT, THESIS_RATIO = -3.1, 0.56
STEPS = 2  # of one cycle: the loading is piecewise linear, and the path between is exact
LOADING_ROWS, CYCLE_ROWS = 10, 80  # rows of the zone pictures
FLOOR = 1e-7  # increments below this share of the first are left out
GREY, COLOURS = "0.75", {"o": "white", "s": "0.35", "+": "tab:red", "-": "tab:blue"}
MEANING = {"o": "open", "s": "stick", "+": "slip outwards", "-": "slip inwards"}
LETTERS = {0: "s", 1: "-", -1: "+", 2: "o"}  # of a node right of the middle; forward slip leads outwards


def cases(short: bool) -> list[dict[str, Any]]:
    """Halves of the block on refined meshes, one whole block, one mesh with fixed load steps."""
    sizes = (2, 4, 8) if short else (2, 4, 6, 8, 12, 16, 24)
    exact = [{"refinement": r, "symmetric": True, "method": "event", "steps": STEPS} for r in sizes]
    whole = {"refinement": 4, "symmetric": False, "method": "event", "steps": STEPS}
    fixed = [{"refinement": 8, "symmetric": True, "method": "gauss-seidel", "steps": m} for m in (40, 80)]
    return [*exact, whole, *([] if short else fixed)]


def measure(case: dict[str, Any]) -> dict[str, Any]:
    """Simulate one mesh and reduce the path to what the figures show."""
    block = receding_block(
        case["refinement"], symmetric=case["symmetric"], steps=case["steps"], first_loading=1
    )
    began = time.perf_counter()
    run = simulate(block, 1.0, cycles=100 if case["steps"] > 2 else 1000, method=case["method"], record=True)
    seconds = time.perf_counter() - began
    assert run.history is not None
    path = run.history
    ends = np.arange(run.cycles_simulated + 1) - 1 / case["steps"]  # p_max, where cycles begin and end
    slips, dissipated = _at(path.cycle, path.v, ends), _at(path.cycle, _dissipated(path), ends)
    increment, dissipation = np.abs(np.diff(slips, axis=0)).max(axis=1), np.diff(dissipated)
    exact = isinstance(path, EventHistory)  # then the limit is known, else the last cycle stands for it
    limit = run.dissipation_per_cycle if exact else dissipation[-1]
    row = {
        "nodes": block.n,
        "outcome": str(run.outcome),
        "cycles_simulated": run.cycles_simulated,
        "events": run.events,
        "seconds": round(seconds, 2),
        "friction_law": run.residual,
        "first_loading_dissipation": float(dissipated[0]),
        "dissipation": dissipation.tolist(),
        "dissipation_ratio": float(limit / dissipation[0]),
        "increment": increment.tolist(),
        "exponents": _exponents(increment),
    }
    if not isinstance(path, EventHistory):
        return row
    return row | _pictures(block, case, path, ends)


def _at(times: FloatArray, values: FloatArray, wanted: FloatArray) -> FloatArray:
    """Rows of ``values`` at load steps, which are among the times; the last row of each."""
    return values[np.searchsorted(times, wanted + 1e-9, side="right") - 1]


def _dissipated(path: Any) -> FloatArray:
    """Work of friction up to every row, −∫ q dv: reactions and slips are linear between rows."""
    work = -(0.5 * (path.q[1:] + path.q[:-1]) * np.diff(path.v, axis=0)).sum(axis=1)
    return np.concatenate([[0.0], np.cumsum(work)])


def _exponents(increment: FloatArray) -> dict[str, float]:
    """Slope of log increment over log N in windows of N, as far as the increments are above the floor."""
    N = np.arange(1, len(increment) + 1)
    usable = increment > FLOOR * increment[0]
    slopes = {}
    for low, high in ((2, 10), (5, 20), (10, 40), (20, 80)):
        inside = usable & (low <= N) & (high >= N)
        if inside.sum() == high - low + 1:
            slope = np.polyfit(np.log(N[inside]), np.log(increment[inside]), 1)[0]
            slopes[f"{low}-{high}"] = round(float(slope), 3)
    return slopes


def _pictures(block: Problem, case: dict[str, Any], path: EventHistory, ends: FloatArray) -> dict[str, Any]:
    """Zones during the first loading, the first cycle and the last; tractions at their turning points."""
    assert block.x is not None
    x = block.x if case["symmetric"] else block.x - 2.0
    first, last = ends[0], ends[-2]
    loading = _zones(path, x, first - 1 / case["steps"], first, LOADING_ROWS)
    length = np.full(block.n, 0.25 / case["refinement"])
    length[[0, -1]] /= 2
    moments = {
        "p_max, first loading": first,
        "p_max/3, first cycle": first + 0.5,
        "p_max, last cycle": last,
        "p_max/3, last cycle": last + 0.5,
    }
    return {
        "x": x.tolist(),
        "first_loading": loading,
        "first_loading_changes": max(_differences(loading[0], other) for other in loading[1:]),
        "first_cycle": _zones(path, x, first, first + 1, CYCLE_ROWS),
        "last_cycle": _zones(path, x, last, last + 1, CYCLE_ROWS),
        "tractions": {
            label: [(_at(path.cycle, side, np.array([t]))[0] / length).tolist() for side in (path.p, path.q)]
            for label, t in moments.items()
        },
    }


def _zones(path: EventHistory, x: FloatArray, begin: float, end: float, rows: int) -> list[str]:
    """One letter per node at evenly spread times; outwards and inwards as seen from the middle."""
    times = begin + (np.arange(rows) + 0.5) / rows * (end - begin)
    states = path.state[np.searchsorted(path.cycle, times, side="right") - 1]
    outward = np.where((x < 0) & (np.abs(states) == 1), -states, states)
    return ["".join(LETTERS[int(state)] for state in row) for row in outward]


def _differences(first: str, second: str) -> int:
    return sum(a != b for a, b in zip(first, second, strict=True))


def tables(rows: list[dict[str, Any]]) -> str:
    """One line per mesh, beside the thesis."""
    windows = ("2-10", "5-20", "10-40", "20-80")
    lines = [
        f"{'nodes':>5} {'':5} {'method':12} {'steps':>5} {'cycles':>6} {'events':>6} {'s':>6} "
        f"{'zones':>6} {'slope of the increment over N':^31} {'dissipation':>12}",
        f"{'':51}{'change':>6} " + " ".join(f"{window:>7}" for window in windows) + f" {'last/first':>12}",
    ]
    for row in rows:
        slopes = " ".join(f"{row['exponents'].get(window, np.nan):7.2f}" for window in windows)
        lines.append(
            f"{row['nodes']:5} {'half' if row['symmetric'] else 'whole':5} {row['method']:12} "
            f"{row['steps']:5} {row['cycles_simulated']:6} {row['events'] or '-':>6} {row['seconds']:6.1f} "
            f"{row.get('first_loading_changes', '-'):>6} {slopes} {row['dissipation_ratio']:12.4f}"
        )
    lines.append(f"{'thesis':51}{0:6} {THESIS_EXPONENT:^31} {THESIS_RATIO:12.2f}")
    return "\n".join(lines)


def figures(rows: list[dict[str, Any]]) -> dict[str, Figure]:
    """Zones, tractions, slip increments and dissipation."""
    halves = [row for row in rows if row["symmetric"] and row["method"] == "event"]
    finest = max(halves, key=lambda row: row["nodes"])
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
        edges = row["x"], (np.arange(len(image)) + 0.5) / len(image)
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
        axes.loglog(N, increment[keep] / increment[0], ".-", label=f"{row['nodes']} nodes on the half")
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
        axes.plot(N, dissipation / dissipation[0], ".-", label=f"{row['nodes']} nodes on the half")
    axes.axhline(THESIS_RATIO, color="black", linestyle="--", label="thesis: about 56 %")
    axes.set(
        xlabel="cycle N",
        ylabel="dissipation of the cycle / that of the first",
        title="Dissipation per cycle",
        ylim=(0.5, 1.02),
        xticks=range(0, 21, 5),
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
