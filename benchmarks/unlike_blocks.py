"""Two blocks of C3D8 with meshes of their own in CalculiX, in contact of its type MORTAR, and here."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

import shakedown
from benchmarks import calculix_peer
from shakedown.fem import ElasticBody, Material, brick_mesh
from shakedown.fem.body import KINDS
from shakedown.ground.constants import FloatArray

SIZE, PRESS, SHEAR = (
    (2.0, 1.5, 1.0),
    1.0,
    0.05,
)  # sides of a block, forces in all: so small that nothing turns
FACES = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))  # of C3D8
SLOPE = "1e10"  # of gap and stick: 5e4 of E


def stuck_in_calculix(folder: Path, upper: tuple[int, ...], lower: tuple[int, ...]) -> dict:
    """Nodal forces of both where all nodes stick: largest difference; how far CalculiX's sides are apart."""
    above, below = (
        ElasticBody(brick_mesh(SIZE, (x, y, z), origin=(0, 0, level)), Material(1.0, 0.3))
        for (x, y, z), level in ((upper, SIZE[2]), (lower, 0.0))
    )
    lines, sets = deck(above, below, {"UPPER_TOP": (above, "top"), "LOWER_BOTTOM": (below, "bottom")})
    lines += ["*BOUNDARY", "LOWER_BOTTOM, 1, 3"]
    top = sets["UPPER_TOP"]
    stored = [*lines, "*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "1", "*END STEP"]
    calculix_peer.run(folder, "job", stored)
    calculix_peer.run(folder, "con", [*lines, *_contact(), *_step(len(top))])
    (folder / "import.toml").write_text(_configuration(len(top)))
    made = shakedown.import_model(folder / "import.toml")
    problem = made.problem
    u, opening, theirs = at_contact(made, displacements(folder / "con.dat")[-1])
    own = np.concatenate([problem.q_w[0], problem.p_w[0]])
    split, size = 2 * problem.n, float(np.abs(u).max())
    shear, normal = (np.abs(part).max() for part in (own[:split], own[split:]))
    return {
        "n": problem.n,
        "pressure": float(np.abs(theirs - own)[split:].max() / normal),
        "shear": float(np.abs(theirs - own)[:split].max() / shear),
        "apart": float(np.abs(opening).max() / size),
    }


def deck(
    upper: ElasticBody, lower: ElasticBody, sets: Mapping[str, tuple[ElasticBody, str]]
) -> tuple[list[str], dict[str, list[int]]]:
    """Nodes, elements and steel of a body whose "bottom" is on the "top" of another; the labels of the sets.

    Nodes of the upper body from 1, surfaces UPPER and LOWER, and the sets by body and boundary.
    """
    lines, elements, surfaces, first = ["*NODE, NSET=ALL"], [], [], 1
    named: dict[str, list[int]] = {}
    for name, body, side in (("UPPER", upper, "bottom"), ("LOWER", lower, "top")):
        places = body.positions(np.arange(body.dofs[:, 0].max() + 1))
        lines += [f"{first + k}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(places.tolist())]
        cells = np.empty_like(body.mesh.t)
        cells[KINDS["hexahedron"].order] = body.mesh.t
        on = set(body.normals_on(side)[0].tolist())
        surfaces.append(f"*SURFACE, NAME={name}, TYPE=ELEMENT")
        for nodes in cells.T.tolist():
            elements.append(f"{len(elements) + 1}, " + ", ".join(str(first + node) for node in nodes))
            for face, corners in enumerate(FACES, start=1):
                if on.issuperset(nodes[k] for k in corners):
                    surfaces.append(f"{len(elements)}, S{face}")
        own = {key: boundary for key, (each, boundary) in sets.items() if each is body}
        named |= {key: (body.normals_on(boundary)[0] + first).tolist() for key, boundary in own.items()}
        first += len(places)
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=E", *elements]
    for key, labels in named.items():
        lines += [f"*NSET, NSET={key}", *(f"{label}," for label in labels)]
    lines += [*surfaces, "*MATERIAL, NAME=M", "*ELASTIC", "210000., 0.3", "*DENSITY", "1."]
    return [*lines, "*SOLID SECTION, ELSET=E, MATERIAL=M"], named


def _contact() -> list[str]:
    return [
        "*SURFACE INTERACTION, NAME=I", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR", SLOPE,
        "*FRICTION", f"0.3, {SLOPE}", "*CONTACT PAIR, INTERACTION=I, TYPE=MORTAR", "UPPER, LOWER",
    ]  # fmt: skip


def _step(count: int) -> list[str]:
    return [
        "*STEP, INC=1000", "*STATIC", "0.25, 1.", "*CLOAD", f"UPPER_TOP, 3, {-PRESS / count:.16g}",
        "*NODE PRINT, NSET=ALL, FREQUENCY=1000", "U", "*END STEP",
        "*STEP, INC=1000", "*STATIC", "0.1, 1.", "*CLOAD", f"UPPER_TOP, 1, {SHEAR / count:.16g}",
        "*NODE PRINT, NSET=ALL, FREQUENCY=1000", "U", "*END STEP",
    ]  # fmt: skip


def _configuration(count: int) -> str:
    return (
        'friction = 0.3\n[model]\nfile = "job.inp"\n[stiffness]\nfile = "job.sti"\n'
        '[contact]\nsurfaces = ["UPPER", "LOWER"]\n[[load]]\nhistory = 1.0\n'
        f'forces = [["UPPER_TOP", 3, {-PRESS / count!r}], ["UPPER_TOP", 1, {SHEAR / count!r}]]\n'
    )


def at_contact(
    made: shakedown.Import, moved: Mapping[int, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of displacements: those of the rows of the matrix; slips and gaps, and forces, at the contact nodes."""
    frame, coupling, dofs = made.condensation.frame, made.contact.coupling, made.stiffness.dofs
    assert coupling is not None
    opening = coupling.opening(lambda nodes: np.array([moved[node] for node in nodes.tolist()]))
    u = np.array([moved[node][direction - 1] for node, direction in dofs.tolist()])
    forces = (made.stiffness.K @ u)[frame.rows]
    return u, frame.to_local(opening), frame.to_local(forces)


def displacements(path: Path) -> list[dict[int, FloatArray]]:
    """The tables of displacements of a ``.dat`` file."""
    tables: list[dict[int, FloatArray]] = []
    reading = False
    for line in path.read_text().splitlines():
        fields = line.split()
        if fields and not fields[0].isdigit():  # a heading
            reading = fields[0] == "displacements"
            tables += [{} for _ in range(reading)]
        elif len(fields) == 4 and reading:
            tables[-1][int(fields[0])] = np.array([float(field) for field in fields[1:]])
    return tables
