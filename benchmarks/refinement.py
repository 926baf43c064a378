"""Which numbers converge as a mesh is refined, joint by joint: the numbers behind docs/mesh.md.

Every joint on a sequence of meshes with the number of contact elements doubled: blocks and a pad with
sharp corners, below and above the critical friction of these (docs/mesh.md);
elastically similar blocks and a press fit, which have no such corner; a cylinder on a flat, whose pressure
ends like a root; the slanted block of thesis chapter V. In space a brick, a sphere on a flat and a bolted
lap joint. Of each :func:`shakedown.refine` tells which of the limits, of λ_max averaged over a length, of
friction work and of the largest slip at one load have a limit, and which one.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from matplotlib.artist import Artist
from matplotlib.figure import Figure

from benchmarks.bodies.blocks import cantilevered_block
from benchmarks.bodies.classical import cylinder_on_flat, press_fit
from benchmarks.bodies.lap_joint import WIDTH, lap_joint
from benchmarks.bodies.sphere import sphere_on_flat
from benchmarks.display import lines, panels
from shakedown import Problem, fem, plot, refine
from shakedown.studies.refined import Refinement

TITLE = "What converges under mesh refinement"
STEEL = fem.Material(200e3, 0.3)  # N, mm


def top_moved() -> list[fem.Displacement]:
    """The top goes down by 1 ± 0.15 µm and sideways by ± 0.25 µm, a quarter of a period apart."""
    return [
        fem.Displacement(boundary="top", x=2.5e-4, y=0.0, history=lambda t: np.cos(2 * np.pi * t)),
        fem.Displacement(boundary="top", x=0.0, y=-1e-3, history=lambda t: 1 + 0.15 * np.sin(2 * np.pi * t)),
    ]


def block_on_plane(elements: int, f: float) -> Problem:
    """A block 2 × 1 on a rigid plane."""
    body = fem.ElasticBody(fem.block_mesh(2.0, 1.0, elements, elements // 2), STEEL, loads=top_moved())
    return fem.contact_problem(body, "bottom", f, steps=48)


def similar_blocks(elements: int, f: float) -> Problem:
    """Two blocks 2 × 1 of one material on each other, the lower one held at its bottom."""
    rows = elements // 2
    upper = fem.ElasticBody(fem.block_mesh(2.0, 1.0, elements, rows), STEEL, loads=top_moved())
    lower = fem.ElasticBody(
        fem.block_mesh(2.0, 1.0, elements, rows, origin=(0.0, -1.0)), STEEL, supports=[fem.Support("bottom")]
    )
    return fem.contact_problem(upper, "bottom", f, against=(lower, "top"), steps=48)


def pressed_and_pushed() -> list[fem.Load]:
    """10 MPa on the top all the time, and 1 MPa to and fro along it."""
    return [
        fem.Pressure("top", 10.0, history=np.ones(24)),
        fem.Traction("top", (1.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
    ]


def pushed_block(elements: int, f: float) -> Problem:
    """A block 2 × 1 on a rigid plane, by forces: that of the tutorial."""
    mesh = fem.block_mesh(2.0, 1.0, elements, elements // 2)
    return fem.contact_problem(
        fem.ElasticBody(mesh, STEEL, loads=pressed_and_pushed()), "bottom", f, steps=24
    )


def pad(elements: int, f: float) -> Problem:
    """The same block on a larger one of its material, 6 × 3, in the middle of its top."""
    upper = fem.ElasticBody(
        fem.block_mesh(2.0, 1.0, elements, elements // 2, origin=(-1.0, 0.0)),
        STEEL,
        loads=pressed_and_pushed(),
    )
    mesh = fem.block_mesh(6.0, 3.0, 3 * elements, 3 * elements // 2, origin=(-3.0, -3.0))
    size = 2.0 / elements
    mesh = mesh.with_boundaries(
        {"contact": lambda x: (np.abs(x[1]) < 0.1 * size) & (np.abs(x[0]) < 1.0)}, boundaries_only=True
    )
    lower = fem.ElasticBody(mesh, STEEL, supports=[fem.Support("bottom")])
    return fem.contact_problem(upper, "bottom", f, against=(lower, "contact"), steps=24)


def brick(elements: int, f: float) -> Problem:
    """A brick 2 × 2 × 1 on a rigid plane, moved as the block is."""
    loads = [
        fem.Displacement("top", x=2.5e-4, y=0.0, z=0.0, history=lambda t: np.cos(2 * np.pi * t)),
        fem.Displacement("top", x=0.0, y=0.0, z=-1e-3, history=lambda t: 1 + 0.15 * np.sin(2 * np.pi * t)),
    ]
    mesh = fem.brick_mesh((2.0, 2.0, 1.0), (elements, elements, elements // 2))
    return fem.contact_problem(fem.ElasticBody(mesh, STEEL, loads=loads), "bottom", f, steps=24)


def bolted_lap(elements: int) -> Problem:
    """Washers with edges on lines of all meshes, where all sizes fall by one factor."""
    return lap_joint((elements, elements // 4, elements // 6), washer=(10.0, WIDTH / 6))


class Joint(NamedTuple):
    """From contact elements to a joint, the load factor of its simulation, and how many elements there are.

    And the length that slips are to stay below, and the radius over which they are averaged [length]; by
    default an eighth of the contact.
    """

    make: Callable[[int], Problem]
    load_factor: float
    slip_below: float | None
    sizes: tuple[int, ...] = (8, 16, 32, 64)
    radius: float | None = None


JOINTS = {
    "block on a rigid plane, moved, f = 0.2": Joint(lambda k: block_on_plane(k, 0.2), 4.0, 1e-4),
    "block on a rigid plane, pushed, f = 0.4": Joint(lambda k: pushed_block(k, 0.4), 3.8, 1e-5),
    "pad on a block, f = 0.3": Joint(lambda k: pad(k, 0.3), 2.8, None, (8, 16, 32, 64, 128)),
    "pad on a block, f = 0.7": Joint(lambda k: pad(k, 0.7), 6.5, 3e-5),
    "two similar blocks, f = 0.3": Joint(lambda k: similar_blocks(k, 0.3), 4.0, 1e-4, (8, 16, 32)),
    "press fit, f = 0.2": Joint(lambda k: press_fit(k // 8), 1.0, 3e-4),
    "cylinder on a flat, f = 0.3": Joint(lambda k: cylinder_on_flat(k // 8), 1.0, 2e-3, (8, 16, 32)),
    "cantilevered block (chapter V), f = 0.4": Joint(
        lambda k: cantilevered_block(k // 8), 3.0, 1e-9, (8, 16, 32)
    ),
    "brick on a rigid plane, moved, f = 0.2": Joint(lambda k: brick(k, 0.2), 4.0, None, (4, 8, 12, 16), 0.5),
    "sphere on a flat, f = 0.5": Joint(sphere_on_flat, 1.0, None, (3, 6, 12), 0.25),
    "bolted lap joint, f = 0.5": Joint(bolted_lap, 4.0, None, (12, 24, 36, 48, 60), 8.4),
}
SHARE = 8  # of the contact: the radius over which slips are averaged


def cases(short: bool) -> list[dict[str, Any]]:
    """Every joint on its meshes, or on the two coarsest."""
    return [
        {"joint": joint, "elements": elements}
        for joint, each in JOINTS.items()
        for elements in (each.sizes[:2] if short else each.sizes)
    ]


def measure(case: dict[str, Any]) -> dict[str, Any]:
    """All numbers of one joint on one mesh."""
    make, load_factor, slip_below, _, radius = JOINTS[case["joint"]]
    problem, size = make(case["elements"]), case["elements"]
    assert problem.x is not None
    radius = float(np.ptp(problem.x)) / SHARE if radius is None else radius
    asked: dict[str, Any] = {"load_factor": load_factor, "radius": radius, "slip_below": slip_below}
    found = refine({size: problem}, [size], **asked)
    row = {name: values[0] for name, values in found.to_dict()["table"].items() if name != "fingerprint"}
    return row | {"contact_elements": row.pop("elements")}


def refinements(rows: list[dict[str, Any]]) -> dict[str, Refinement]:
    """The table of meshes of every joint that was measured."""
    found = {}
    for joint in JOINTS:
        own = [row for row in rows if row["joint"] == joint]
        if own:
            names = list(own[0])
            columns = {
                name: np.array([np.nan if row[name] is None else float(row[name]) for row in own])
                for name in names[names.index("nodes") + 1 : names.index("directions")]
            }
            words = "elements", "nodes", "contact_elements"
            size, nodes, elements = (np.array([row[name] for row in own]) for name in words)
            about = (own[-1][name] for name in ("load_factor", "radius", "slip_below"))
            found[joint] = Refinement(*about, size, nodes, own[-1]["directions"], columns, elements)
    return found


def tables(rows: list[dict[str, Any]]) -> str:
    """Every number of every joint over its meshes, with what it does."""
    parts = []
    for joint, found in refinements(rows).items():
        head = [f"{joint} (λ = {found.load_factor:g})", *map(str, found.nodes), "limit", "order", "verdict"]
        cells = [
            [
                name,
                *(f"{x:.4g}" for x in (*found.numbers[name], each.limit, each.order)),
                str(each.verdict),
            ]
            for name, each in found.trends.items()
        ]
        parts.append(lines(head, cells))
    return "\n\n".join(parts)


def figures(rows: list[dict[str, Any]]) -> dict[str, Figure]:
    """Every number over the nodes of the mesh, joint by joint."""
    found, named = refinements(rows), dict[str, Artist]()
    figure, drawn = panels(len(found), 3, (4.3, 3.2))
    for axes, (joint, each) in zip(drawn, found.items(), strict=True):
        plot.refinement(each, ax=axes)
        axes.set_title(joint, fontsize="medium")
        axes.set_ylabel("")
        for line, label in zip(*axes.get_legend_handles_labels(), strict=True):
            named[label.partition(":")[0]] = line
        axes.get_legend().remove()
    figure.supylabel("value, by that on the finest mesh; dashed: limit, where it converges")
    figure.legend(list(named.values()), list(named), loc="outside lower center", ncols=4)
    return {"refinement": figure}
