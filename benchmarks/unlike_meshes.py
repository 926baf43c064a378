"""Surfaces whose meshes do not match against matching ones: patch test, limits, slips, a press fit.

CalculiX has the same method (``TYPE=MORTAR``): of two blocks that stick, pressed and sheared, its nodal
forces are the welded reactions here, where its iteration holds the surfaces together; ``apart`` says by how
much it does not, as a share of the largest displacement.
"""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

import shakedown
from benchmarks import calculix_peer
from benchmarks.display import listed
from benchmarks.unlike_blocks import stuck_in_calculix
from shakedown import Problem, fem

TITLE = "Surfaces whose meshes do not match"
STEEL, FRICTION, STEPS = fem.Material(210e3, 0.3), 0.4, 16
LOAD_FACTOR = 1.6  # at which joints are simulated: 1.2 λ_max
MATCHING = (8, 16, 32, 64)
MESHES = [
    (8, 12),
    (16, 24),
    (32, 48),
    (64, 96),
    (12, 8),
    (24, 16),
    (48, 32),
    (96, 64),
]
RINGS = [(24, 24), (48, 48), (96, 96), (32, 48), (48, 32), (32, 87), (64, 96)]
PATCH = {
    "quadrilaterals 16:24": ("plane", 16, 24, 1, False),
    "quadrilaterals 16:43": ("plane", 16, 43, 1, False),
    "quadratic 8:11": ("plane", 8, 11, 2, False),
    "hexahedra 4:6": ("solid", 4, 6, 1, False),
    "hexahedra 5:4": ("solid", 5, 4, 1, False),
    "tetrahedra 4:5": ("solid", 4, 5, 1, True),
    "C3D10 2:3": ("solid", 2, 3, 2, True),
    "27-node hexahedra 2:3": ("solid", 2, 3, 2, False),
}
BLOCKS = [
    ((4, 1, 1), (6, 1, 1)),
    ((2, 2, 1), (3, 3, 1)),
    ((4, 3, 2), (4, 3, 2)),
    ((4, 3, 1), (6, 4, 1)),
    ((4, 3, 2), (6, 4, 2)),
]


def cases(short: bool) -> list[dict]:
    patches = [{"part": "patch", "mesh": name} for name in PATCH]
    limits = [{"part": "limits", "mesh": [n, n]} for n in MATCHING] + [
        {"part": "limits", "mesh": list(pair)} for pair in MESHES
    ]
    rings = [{"part": "press fit", "mesh": list(pair)} for pair in RINGS]
    blocks = [{"part": "CalculiX", "mesh": [list(side) for side in pair]} for pair in BLOCKS]
    if not calculix_peer.is_here():
        print(calculix_peer.ABSENT)
        blocks = []
    if short:
        return [patches[0], limits[0], rings[0], *blocks[:1]]
    return patches + limits + rings + blocks


def measure(case: dict) -> dict:
    parts = {"patch": _patch, "limits": _limits, "press fit": _press_fit, "CalculiX": _calculix}
    return parts[case["part"]](case["mesh"])


def _patch(name: str) -> dict:
    """A block without Poisson's ratio is pressed: how far pressures are from the one that is applied."""
    shape, upper, lower, order, tetrahedra = PATCH[name]
    found = []
    for count, above in ((upper, True), (lower, False)):
        level = 1.0 if above else 0.0
        if shape == "plane":
            mesh = fem.block_mesh(2.0, 1.0, count, 4, origin=(0.0, level))
        else:
            mesh = fem.brick_mesh(
                (2.0, 2.0, 1.0), (count, count, 1), origin=(0, 0, level), tetrahedra=tetrahedra
            )
        press, support = [fem.Pressure("top", 3.0, history=1.0)], [fem.Support("bottom")]
        more = {"loads": press} if above else {"supports": support}
        found.append(fem.ElasticBody(mesh, fem.Material(1.0, 0.0), order=order, **more))
    joint = fem.contact_problem(found[0], "bottom", 0.4, against=(found[1], "top"), coupling="mortar")
    values = np.linalg.eigvalsh(joint.kappa)
    return {
        "n": joint.n,
        "pressure": float(np.abs(joint.p_w[0] / joint.node_area / 3.0 - 1.0).max()),
        "shear": float(np.abs(joint.q_w[0]).max() / joint.p_w[0].max()),
        "least": float(values[0] / values[-1]),
    }


@cache
def sheared(upper: int, lower: int) -> Problem:
    """A block 2 × 1 on another one, pressed and sheared at its top."""
    loads = [
        fem.Pressure("top", 100.0, history=1.0),
        fem.Traction("top", (20.0, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
    ]
    above = fem.ElasticBody(fem.block_mesh(2.0, 1.0, upper, max(upper // 2, 2)), STEEL, loads=loads)
    below = fem.ElasticBody(
        fem.block_mesh(2.0, 1.0, lower, max(lower // 2, 2), origin=(0.0, -1.0)),
        STEEL,
        supports=[fem.Support("bottom")],
    )
    how = "nodes" if upper == lower else "mortar"
    return fem.contact_problem(above, "bottom", FRICTION, against=(below, "top"), coupling=how, steps=STEPS)


def _limits(mesh: list[int]) -> dict:
    joint = sheared(*mesh)
    state = shakedown.long_term_state(joint, LOAD_FACTOR)
    return {
        "n": joint.n,
        "largest": float(shakedown.upper_bound(joint, certify=False).load_factor),
        "energy": float(shakedown.energy_bound(joint).load_factor),
        "coupling": float(np.abs(joint.B).max() / np.abs(joint.A).max()),
        "outcome": str(state.outcome),
        "slip": float(np.max(state.slip_per_cycle)),
        "work": float(state.dissipation_per_cycle),
    }


def ring(inner: float, outer: float, count: int, layers: int, *, hub: bool) -> fem.ElasticBody:
    """A ring of quadrilaterals in plane strain; the hub is free, the shaft held at its bore."""
    mesh = fem.ring_mesh(inner, outer, count, layers)
    if not hub:
        return fem.ElasticBody(mesh, STEEL, supports=[fem.Support("inside")])
    return fem.ElasticBody(mesh, STEEL, loads=[fem.Force("outside", (1.0, 0.0), history=[1.0, 0.0])])


def _press_fit(mesh: list[int]) -> dict:
    """Interference 0.02 at R = 20: pressure beside Lamé's, and how it varies around the circumference."""
    a, b, c, poisson = 10.0, 20.0, 40.0, STEEL.poisson
    outer, inner = ring(b, c, mesh[0], mesh[0] // 3, hub=True), ring(a, b, mesh[1], mesh[1] // 5, hub=False)
    how = {} if mesh[0] == mesh[1] else {"coupling": "mortar", "reach": 1.0}
    joint = fem.contact_problem(outer, "inside", FRICTION, against=(inner, "outside"), gap=-0.02, **how)
    pressure = joint.p_w[1] / joint.node_area
    gives = ((1 - 2 * poisson) * b**2 + c**2) / (c**2 - b**2)
    gives += (1 - 2 * poisson) * (b**2 - a**2) / (b**2 + (1 - 2 * poisson) * a**2)
    expected = 0.02 / (gives * b * (1 + poisson) / STEEL.young)
    return {
        "n": joint.n,
        "lame": float(pressure.mean() / expected),
        "spread": float(np.ptp(pressure) / pressure.mean()),
    }


def _calculix(mesh: list[list[int]]) -> dict:
    with TemporaryDirectory() as folder:
        return stuck_in_calculix(Path(folder), *map(tuple, mesh))


TABLES = {
    "patch": (
        "constant pressure: largest relative error; least eigenvalue of κ by the largest",
        {"first : second": "{mesh}", "n": "{n}", "pressure": "{pressure:.0e}", "shear": "{shear:.0e}",
         "eigenvalue": "{least:.0e}"},
    ),
    "limits": (
        f"sheared block; slips and work per cycle at λ = {LOAD_FACTOR}",
        {"first : second": "{mesh[0]} : {mesh[1]}", "n": "{n}", "λ_max": "{largest:.4f}",
         "λ_E": "{energy:.4f}",
         "max B/A": "{coupling:.4f}", "outcome": "{outcome}", "slip": "{slip:.3e}", "work": "{work:.4e}"},
    ),
    "press fit": (
        "press fit: pressure by Lamé's, its spread around the circumference",
        {"hub : shaft": "{mesh[0]} : {mesh[1]}", "n": "{n}", "p / Lamé": "{lame:.4f}",
         "spread": "{spread:.0e}"},
    ),
    "CalculiX": (
        "CalculiX, TYPE=MORTAR, all nodes stuck: largest difference by the largest force",
        {"first : second": "{mesh[0]} : {mesh[1]}", "n": "{n}", "normal forces": "{pressure:.0e}",
         "shear forces": "{shear:.0e}", "apart": "{apart:.0e}"},
    ),
}  # fmt: skip


def tables(rows: list[dict]) -> str:
    parts = {part: [row for row in rows if row["part"] == part] for part in TABLES}
    return "\n\n".join(
        f"{TABLES[part][0]}\n{listed(found, TABLES[part][1])}" for part, found in parts.items() if found
    )
