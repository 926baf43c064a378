"""How both bounds behave as the mesh is refined.

Four joints, each on a sequence of meshes with the number of contact elements
doubled: a block on a rigid plane whose top is pressed and sheared cyclically, at
two friction coefficients; two elastically similar blocks, which are uncoupled;
the slanted, cantilevered block of thesis chapter V.

What to expect.

- λ_max converges where the ends of the contact can stick. Where they cannot –
  the welded tractions at a corner have a shear ratio |q|/p of their own, and
  friction is below it (:func:`shakedown.fem.welded_corner`) – the corner of the
  elastic body slips at any load, and λ_max falls by a power of the element size
  for ever. It is then a statement about slip on the scale of one element: choose
  that as the radius that the real edge has.
- λ_1 asks for more, safety from *every* locked-in slip. A finer mesh admits
  rougher slips, and where slip is coupled to pressure (B ≠ 0) a rough enough one
  lifts a node off at the mean load. So λ_1 falls to zero under refinement. That is
  an answer about the question, not a fault of the mesh: ask which initial slips
  are possible. λ_1(R), the bound for initial slips within R of the safe one
  (:func:`shakedown.guarantee_curve`), still falls at a fixed R, because slips may
  jump by R from node to node. With R in proportion to the element size – slips
  whose slope along the contact differs from the safe one's by a bounded amount –
  λ_1(R)/λ_max holds its level on the rigid plane. It still falls, though slowly,
  for the cantilevered block: its sharp corner (60°) carries hardly any pressure, so
  that ever smaller slips lift the last node off.
- Without coupling (B = 0) λ_1 = λ_max on every mesh.
"""

import argparse
import time
from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks.bodies.blocks import cantilevered_block
from benchmarks.runner import run_study
from shakedown import Problem, guarantee_curve, lower_bound, upper_bound
from shakedown.fem import (
    Displacement,
    ElasticBody,
    Material,
    Support,
    block_mesh,
    contact_problem,
    welded_corner,
)

TITLE = "Both bounds under mesh refinement"
STEEL = Material(200e3, 0.3)  # N, mm


def top_moved() -> list[Displacement]:
    """The top goes down by 1 ± 0.15 µm and sideways by ± 0.25 µm, a quarter of a period apart."""
    return [
        Displacement(boundary="top", x=2.5e-4, y=0.0, history=lambda t: np.cos(2 * np.pi * t)),
        Displacement(boundary="top", x=0.0, y=-1e-3, history=lambda t: 1 + 0.15 * np.sin(2 * np.pi * t)),
    ]


def block_on_plane(elements: int, f: float) -> Problem:
    """A block 2 × 1 on a rigid plane."""
    body = ElasticBody(block_mesh(2.0, 1.0, elements, elements // 2), STEEL, loads=top_moved())
    return contact_problem(body, "bottom", f, steps=48)


def similar_blocks(elements: int, f: float) -> Problem:
    """Two blocks 2 × 1 of one material on each other, the lower one held at its bottom."""
    rows = elements // 2
    upper = ElasticBody(block_mesh(2.0, 1.0, elements, rows), STEEL, loads=top_moved())
    lower = ElasticBody(
        block_mesh(2.0, 1.0, elements, rows, origin=(0.0, -1.0)), STEEL, supports=[Support("bottom")]
    )
    return contact_problem(upper, "bottom", f, against=(lower, "top"), steps=48)


# Each joint with the slope of the box of initial slips: R = slope × element size.
JOINTS: dict[str, tuple[Callable[[int], Problem], float]] = {
    "block on a rigid plane, f = 0.5": (lambda elements: block_on_plane(elements, 0.5), 3e-4),
    "block on a rigid plane, f = 0.2": (lambda elements: block_on_plane(elements, 0.2), 3e-4),
    "two similar blocks, f = 0.3": (lambda elements: similar_blocks(elements, 0.3), 3e-4),
    "cantilevered block (chapter V), f = 0.4": (lambda elements: cantilevered_block(elements // 8), 3e-9),
}


def cases(short: bool) -> list[dict[str, Any]]:
    """Every joint on meshes of 8, 16, … contact elements."""
    sizes = (8, 16) if short else (8, 16, 32, 64, 128)
    return [{"joint": joint, "elements": elements} for joint in JOINTS for elements in sizes]


def measure(case: dict[str, Any]) -> dict[str, Any]:
    """Both bounds of one joint on one mesh."""
    began = time.perf_counter()
    make, slope = JOINTS[case["joint"]]
    problem = make(case["elements"])
    built = time.perf_counter()
    upper = upper_bound(problem)
    lower = lower_bound(problem)
    return {
        "nodes": problem.n,
        "upper_status": str(upper.status),
        "upper": upper.load_factor,
        "active_nodes": sorted({int(node) for node, _ in upper.active}),
        "lower": lower.load_factor,
        "lower_node": int(lower.node),
        "slope": slope,
        "lower_near_safe_slip": _near_safe_slip(problem, slope),
        "seconds_build": round(built - began, 2),
        "seconds_bounds": round(time.perf_counter() - built, 2),
    }


def _near_safe_slip(problem: Problem, slope: float) -> float:
    """λ_1(R) for the box |v − ṽ| ≤ R = slope × element size around the safe slip."""
    assert problem.x is not None
    weights = np.ones(problem.n)
    unit = guarantee_curve(problem, [0.0], weights=weights).unit
    radius = slope * float(np.diff(problem.x).mean())
    return float(guarantee_curve(problem, [radius / unit], weights=weights).load_factors[0])


def tables(rows: list[dict[str, Any]]) -> str:
    """λ_max and λ_1 of every mesh, and the change of λ_max from the mesh before."""
    lines = [f"{'joint':40} {'nodes':>6} {'λ_max':>9} {'change':>9} {'λ_1':>9} {'λ_1(R)':>9} {'time s':>9}"]
    before = None
    for row in rows:
        first = before is None or before["joint"] != row["joint"]
        change = "" if first else f"{row['upper'] / before['upper'] - 1:+.2%}"
        name = row["joint"] if first else ""
        seconds = row["seconds_build"] + row["seconds_bounds"]
        lines.append(
            f"{name:40} {row['nodes']:6} {row['upper']:9.4f} {change:>9} {row['lower']:9.4f}"
            f" {row['lower_near_safe_slip']:9.4f} {seconds:9.1f}"
        )
        before = row
    lines += ["", "shear ratio of a welded corner, ν = 0.3 (with less friction it slips at any load):"]
    for degrees in (60, 90, 120):
        corner = welded_corner(np.radians(degrees), STEEL.poisson)
        lines.append(
            f"{degrees:4}°: |q|/p = {corner.shear_ratio:.3f}, tractions ~ r^{corner.exponent - 1:.3f}"
        )
    return "\n".join(lines)


def figures(rows: list[dict[str, Any]]) -> dict[str, Figure]:
    """λ_max and λ_1 against the number of contact nodes."""
    figure = Figure(figsize=(12, 4.4), layout="constrained")
    left, middle, right = figure.subplots(1, 3, sharex=True)
    for joint, marker in zip(JOINTS, "osD^", strict=True):
        own = [row for row in rows if row["joint"] == joint]
        nodes = [row["nodes"] for row in own]
        left.plot(nodes, [row["upper"] for row in own], marker + "-", label=joint)
        for axes, key in ((middle, "lower"), (right, "lower_near_safe_slip")):
            axes.plot(nodes, [row[key] / row["upper"] for row in own], marker + "-")
    left.set(title="λ_max: from some initial slip", ylabel="λ_max", ylim=(0, None))
    middle.set(title="λ_1 / λ_max: from every initial slip", ylim=(-0.05, 1.05))
    right.set(title="λ_1(R) / λ_max: slips near the safe one", ylim=(-0.05, 1.05))
    ticks = sorted({row["nodes"] for row in rows})
    for axes in (left, middle, right):
        axes.set_xscale("log")
        axes.set_xticks(ticks, labels=map(str, ticks))
        axes.minorticks_off()
        axes.set_xlabel("contact nodes")
        axes.grid(alpha=0.3)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, frameon=False)
    return {"refinement": figure}


if __name__ == "__main__":
    parser = argparse.ArgumentParser(prog="python -m benchmarks.refinement", description=TITLE)
    parser.add_argument("--short", action="store_true", help="two coarse meshes of each joint")
    parser.add_argument("--fresh", action="store_true", help="measure again what is already stored")
    options = parser.parse_args()
    run_study("refinement", short=options.short, fresh=options.fresh)
