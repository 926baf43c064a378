"""CalculiX, with contact and friction of its own in space, against the toolkit on the same two blocks.

A block of C3D8 lies on a larger one, is pressed onto it and pushed around in a circle, so that its nodes
slip in both directions. CalculiX has node-to-surface contact with a penalty for gap and stick alike, the
toolkit neither; both go through the load in small increments, backward Euler. Compared are the slips
and pressures of all pairs at every quarter of the cycles.
"""

import time
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.figure import Figure

import shakedown
from benchmarks import calculix_peer
from shakedown import Problem
from shakedown.fem import ElasticBody, Force, Material, Support, brick_mesh, contact_problem
from shakedown.ground.float_array import FloatArray
from shakedown.joint.conjugate_loads import without_loads
from shakedown.models.readers.calculix_reactions import read_calculix_output
from shakedown.motion.space.implicit_step import ImplicitJoint
from shakedown.report.text_table import table

Places = list[tuple[float, float]]
Forces = tuple[float, float]  # that presses the block on, and the radius of the circle

TITLE = "CalculiX with contact and friction in three dimensions against the toolkit"
YOUNG, POISSON, FRICTION = 210e3, 0.3, 0.3
UPPER, LOWER, LAYERS = (4, 3), (6, 5), 2  # cubes of side 1 along x and y of each block, and in height
PRESSES = (
    -600.0,
    -60.0,
)  # the smaller one at the circle above the limit: CalculiX turns its normals with the bodies
PATH = ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))  # pressed; then quarters of the circle
SLOPES = (50, 500, 5000)  # penalty, in Young's modulus over the side of an element
RELATIVE = (0.9, 1.1)  # radius of the circle over that at λ_max
QUARTERS = 12  # of the circle, after the first one, that are followed
CONTROLS = (  # as for joints in the plane: without them Newton goes round
    "*CONTROLS, PARAMETERS=FIELD", "1e-6, 1.",
    "*CONTROLS, PARAMETERS=TIME INCREMENTATION",
    "20, 40, 9, 60, 10, 4, , 20, , ", "0.1, 0.1, 0.1, 0.85, , , 10., ",
)  # fmt: skip
CORNERS = [0, 3, 6, 2, 1, 5, 7, 4]  # of C3D8, of those of scikit-fem
FACES = ((0, 1, 2, 3), (4, 7, 6, 5), (0, 4, 5, 1), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 4, 0))


def cases(short: bool) -> list[dict]:
    if not calculix_peer.is_here():
        print(calculix_peer.ABSENT)
        return []
    if short:
        return [
            {"press": PRESSES[0], "relative": RELATIVE[-1], "slope": SLOPES[1], "quarters": 1, "parts": 4}
        ]
    return [
        {"press": press, "relative": relative, "slope": slope, "quarters": QUARTERS, "parts": 20}
        for press, relative in [(PRESSES[0], relative) for relative in RELATIVE]
        + [(PRESSES[1], RELATIVE[-1])]
        for slope in SLOPES
    ]


@cache
def bodies(press: float) -> tuple[ElasticBody, ElasticBody]:
    """The block and what it lies on; the seat is where they touch."""
    steel = Material(YOUNG, POISSON)
    upper = brick_mesh((*map(float, UPPER), LAYERS), (*UPPER, LAYERS), origin=(0.0, 0.0, LAYERS))
    lower = brick_mesh((*map(float, LOWER), LAYERS), (*LOWER, LAYERS), origin=(-1.0, -1.0, 0.0))
    lower = lower.with_boundaries(
        {
            "seat": lambda p: (
                (np.abs(p[2] - LAYERS) < 1e-9)
                & (p[0] > 0)
                & (p[0] < UPPER[0])
                & (p[1] > 0)
                & (p[1] < UPPER[1])
            )
        }
    )
    loads = [Force("top", (0.0, 0.0, press), history=1.0)]
    loads += [Force("top", side, history=1.0) for side in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))]
    return (
        ElasticBody(upper, steel, loads=loads),
        ElasticBody(lower, steel, supports=[Support("bottom")]),
    )


@cache
def joint(press: float) -> Problem:
    upper, lower = bodies(press)
    return contact_problem(upper, "bottom", FRICTION, against=(lower, "seat"))


def measure(case: dict) -> dict:
    press, parts = case["press"], case["parts"]
    push = case["relative"] * limit(press)
    places = [PATH[0], *(PATH[1 + k % 4] for k in range(case["quarters"]))]
    begin = time.perf_counter()
    slip, pressure = _by_calculix((press, push), case["slope"] * YOUNG, places, parts)
    seconds = time.perf_counter() - begin
    own_slip, own_pressure = _by_toolkit((press, push), places, parts)
    size = np.abs(own_slip).max()
    return {
        "n": joint(press).n,
        "limit": limit(press),
        "slip_apart": float(np.abs(slip - own_slip).max() / size),
        "pressure_apart": float(np.abs(pressure - own_pressure).max() / own_pressure.max()),
        "last": [float(_last_cycle(found) / size) for found in (slip, own_slip)],
        "seconds": seconds,
    }


def _last_cycle(slips: FloatArray) -> float:
    """By how much a pair slips at most between two ends of quarters in the last cycle."""
    last = slips[-5:]
    return float(np.linalg.norm(last - last[-1], axis=2).max())


@cache
def limit(press: float) -> float:
    """The radius of the circle at λ_max, of the corners where its quarters end: loads lie between them."""
    layout, unit = joint(press).layout, _unit_reactions(press)
    q_w, p_w = layout.split(np.array([unit[0] + x * unit[1] + y * unit[2] for x, y in PATH[1:]]))
    found = shakedown.upper_bound(replace(without_loads(joint(press)), q_w=q_w, p_w=p_w))
    return float(found.load_factor)


def _by_toolkit(forces: Forces, places: Places, parts: int) -> tuple[FloatArray, FloatArray]:
    """Slips (s, n, 2) and pressures (s, n) after every load step, in the order of the problem's nodes."""
    (press, push), problem = forces, joint(forces[0])
    layout, unit = problem.layout, _unit_reactions(press)
    loads = np.array([unit[0] + push * (x * unit[1] + y * unit[2]) for x, y in places])
    q_w, p_w = layout.split(loads)
    path = ImplicitJoint(problem.A, problem.B, problem.C, problem.f, float(np.abs(loads).max()))
    path.begin(np.zeros(layout.slip_size), np.zeros(layout.n), np.zeros(layout.slip_size), np.zeros(layout.n))
    found = path.follow(q_w, p_w, parts)
    if found.solved < len(places):
        raise RuntimeError(f"load step {found.solved} was not solved: {found.status.name}")
    p = p_w + found.v @ problem.B.T + found.w @ problem.C
    return layout.by_node(found.v), p / problem.node_area


@cache
def _unit_reactions(press: float) -> FloatArray:
    """Welded reactions of the three loads at factor 1, (3, 3n)."""
    upper, lower = bodies(press)
    single = [
        contact_problem(
            ElasticBody(upper.mesh, upper.material, loads=[load]), "bottom", FRICTION, against=(lower, "seat")
        )
        for load in upper.loads
    ]
    return np.array([np.r_[one.q_w[0], one.p_w[0]] for one in single])


def _by_calculix(forces: Forces, slope: float, places: Places, parts: int) -> tuple[FloatArray, FloatArray]:
    """The same by CalculiX; its slips have the part in them that the penalty lets through."""
    press, push = forces
    (upper, lower), names = bodies(press), joint(press).label
    labels = [int(name.split("/")[0]) for name in names]
    under = [int(name.split("/")[1]) for name in names]
    shift = lower.mesh.nvertices
    with TemporaryDirectory() as folder:
        deck = [*_model(upper, lower), *_contact(slope), *_steps((upper, lower), push, places, parts)]
        calculix_peer.run(Path(folder), "blocks", deck)
        moved = read_calculix_output(Path(folder) / "blocks.dat", "displacements")
        pressure = calculix_peer.pressures(Path(folder) / "blocks.dat")
    slips = [
        step.vectors[step.places(np.array(labels) + shift + 1)]
        - step.vectors[step.places(np.array(under) + 1)]
        for step in moved
    ]
    pressed = [[rows.get(label + shift + 1, 0.0) for label in labels] for rows in pressure]
    return np.array(slips)[:, :, :2], np.array(pressed)


def _model(upper: ElasticBody, lower: ElasticBody) -> Iterator[str]:
    """Nodes of the lower block from 1 on, then those of the upper one; elements likewise."""
    shift, count = lower.mesh.nvertices, 0
    yield "*NODE, NSET=ALL"
    for body, first in ((lower, 1), (upper, shift + 1)):
        yield from (f"{k}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(body.mesh.p.T.tolist(), start=first))
    for name, body, first in (("LOWER", lower, 1), ("UPPER", upper, shift + 1)):
        yield f"*ELEMENT, TYPE=C3D8, ELSET={name}"
        for nodes in (body.mesh.t[CORNERS].T + first).tolist():
            count += 1
            yield ", ".join(map(str, (count, *nodes)))
    for name, body, boundary, first in (
        ("SLAVE", upper, "bottom", 1 + lower.mesh.nelements),
        ("MASTER", lower, "top", 1),
    ):
        yield f"*SURFACE, NAME={name}, TYPE=ELEMENT"
        level = body.mesh.p[2, body.mesh.facets[:, body.facets(boundary)]].mean()
        for k, corners in enumerate(body.mesh.t[CORNERS].T):
            heights = body.mesh.p[2, corners]
            yield from (
                f"{k + first}, S{side}"
                for side, face in enumerate(FACES, start=1)
                if np.allclose(heights[list(face)], level)
            )
    for name, body, boundary, first in (
        ("FOOT", lower, "bottom", 1),
        ("SEAT", lower, "top", 1),
        ("SOLE", upper, "bottom", shift + 1),
    ):
        yield f"*NSET, NSET={name}"
        yield from (f"{node + first}," for node in body.normals_on(boundary)[0].tolist())
    yield from ("*MATERIAL, NAME=STEEL", "*ELASTIC", f"{YOUNG}, {POISSON}")
    yield from (f"*SOLID SECTION, ELSET={name}, MATERIAL=STEEL" for name in ("LOWER", "UPPER"))
    yield from ("*BOUNDARY", "FOOT, 1, 3")


def _contact(slope: float) -> Iterator[str]:
    """Node-to-surface penalty contact; the tension that it lets through is next to nothing."""
    yield from ("*SURFACE INTERACTION, NAME=TOUCH", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR")
    yield from (f"{slope:.6g}, 1e-6, 1e-3", "*FRICTION", f"{FRICTION}, {slope:.6g}")
    yield from ("*CONTACT PAIR, INTERACTION=TOUCH, TYPE=NODE TO SURFACE, SMALL SLIDING", "SLAVE, MASTER")


def _steps(both: tuple[ElasticBody, ElasticBody], push: float, places: Places, parts: int) -> Iterator[str]:
    upper, first = both[0], 1 + both[1].mesh.nvertices
    shares = [load.nodal(upper)[0] for load in upper.loads]
    for x, y in places:
        total = (shares[0] + push * (x * shares[1] + y * shares[2])).reshape(-1)
        yield from (
            "*STEP, INC=1000000",
            "*STATIC",
            f"1e-3, 1., 1e-10, {1 / parts:.16g}",
            *CONTROLS,
            "*CLOAD",
        )
        loaded = np.flatnonzero(np.abs(shares).max(axis=0) > 1e-9)
        for (node, direction), force in zip(upper.dofs[loaded].tolist(), total[loaded], strict=True):
            yield f"{node + first}, {direction}, {force:.12g}"
        yield from (f"*NODE PRINT, NSET={name}, FREQUENCY=1000000" + "\nU" for name in ("SEAT", "SOLE"))
        yield from ("*CONTACT PRINT, FREQUENCY=1000000", "CSTR", "*END STEP")


def tables(rows: list[dict]) -> str:
    if not rows:
        return f"  {calculix_peer.ABSENT}"
    headers = [
        "pressed [N]", "push / limit", "penalty [E/h]", "slips apart", "pressures apart",
        "last cycle: ccx", "toolkit", "ccx [s]",
    ]  # fmt: skip
    lines = [
        [
            f"{-row['press']:.0f}", f"{row['relative']:.2f}", str(row["slope"]),
            f"{row['slip_apart']:.1e}", f"{row['pressure_apart']:.1e}",
            *(f"{last:.1e}" for last in row["last"]), f"{row['seconds']:.0f}",
        ]
        for row in rows
    ]  # fmt: skip
    about = f"Largest differences at {rows[0]['n']} pairs, relative to the largest slip and pressure:"
    return f"{about}\n{table(headers, lines)}"


def figures(rows: list[dict]) -> dict[str, Figure]:
    figure = Figure(figsize=(5.2, 4.2), layout="constrained")
    ax = figure.add_subplot()
    for press, relative in dict.fromkeys((row["press"], row["relative"]) for row in rows):
        own = [row for row in rows if (row["press"], row["relative"]) == (press, relative)]
        for key, style in (("slip_apart", "o-"), ("pressure_apart", "s--")):
            label = f"{key.split('_')[0]}s, {relative:.2f} of the limit, {-press:.0f} N"
            ax.loglog([row["slope"] for row in own], [row[key] for row in own], style, label=label)
    ax.set(xlabel="penalty [E/h]", ylabel="difference from CalculiX")
    if rows:
        figure.legend(fontsize=7, loc="outside lower center", ncols=2)
    return {"calculix_solids": figure}
