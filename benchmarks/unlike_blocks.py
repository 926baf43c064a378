"""Two blocks of C3D8 with meshes of their own in CalculiX, in contact of its type MORTAR, and here."""

from pathlib import Path

import numpy as np

import shakedown
from benchmarks import calculix_peer
from shakedown.fem import ElasticBody, Material, brick_mesh
from shakedown.fem.body import KINDS
from shakedown.ground.constants import FloatArray

SIZE = (2.0, 1.5, 1.0)  # sides of a block
PRESS, SHEAR = 1.0, 0.05  # forces in all: so small that nothing turns
FACES = ((0, 1, 2, 3), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))  # of C3D8
SLOPE = "1e10"  # of gap and stick: 5e4 of E
CONTACT = f"""*SURFACE INTERACTION, NAME=I
*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR
{SLOPE}
*FRICTION
0.3, {SLOPE}
*CONTACT PAIR, INTERACTION=I, TYPE=MORTAR
UPPER, LOWER"""
STEP = """*STEP, INC=1000
*STATIC
{increment}, 1.
*CLOAD
TOP, {direction}, {force:.16g}
*NODE PRINT, NSET=ALL, FREQUENCY=1000
U
*END STEP"""
CONFIGURATION = """friction = 0.3
[model]
file = "job.inp"
[stiffness]
file = "job.sti"
[contact]
surfaces = ["UPPER", "LOWER"]
[[load]]
history = 1.0
forces = [["TOP", 3, {press!r}], ["TOP", 1, {shear!r}]]
"""


def stuck_in_calculix(folder: Path, upper: tuple[int, ...], lower: tuple[int, ...]) -> dict:
    """Nodal forces of both where all nodes stick: largest difference; how far CalculiX's sides are apart."""
    above, below = (
        ElasticBody(brick_mesh(SIZE, cells, origin=(0, 0, level)), Material(1.0, 0.3))
        for cells, level in ((upper, SIZE[2]), (lower, 0.0))
    )
    lines, count = _deck(above, below)
    press, shear = -PRESS / count, SHEAR / count
    stored = [*lines, "*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "1", "*END STEP"]
    pressed = STEP.format(increment=0.25, direction=3, force=press)
    sheared = STEP.format(increment=0.1, direction=1, force=shear)
    calculix_peer.run(folder, "job", stored)
    calculix_peer.run(folder, "con", [*lines, CONTACT, pressed, sheared])
    (folder / "import.toml").write_text(CONFIGURATION.format(press=press, shear=shear))
    made = shakedown.import_model(folder / "import.toml")
    problem, split = made.problem, 2 * made.problem.n
    u, opening, theirs = _at_contact(made, _displacements(folder / "con.dat"))
    own = np.concatenate([problem.q_w[0], problem.p_w[0]])
    apart = np.abs(theirs - own)
    return {
        "n": problem.n,
        "pressure": float(apart[split:].max() / np.abs(own[split:]).max()),
        "shear": float(apart[:split].max() / np.abs(own[:split]).max()),
        "apart": float(np.abs(opening).max() / np.abs(u).max()),
    }


def _deck(upper: ElasticBody, lower: ElasticBody) -> tuple[list[str], int]:
    """The model with its support, and how many nodes are on its top; nodes of the upper body from 1."""
    lines, elements, surfaces, first = ["*NODE, NSET=ALL"], [], [], 1
    sets = {"TOP": (upper, "top"), "HELD": (lower, "bottom")}
    named: dict[str, list[int]] = {}
    for (name, (body, outside)), inside in zip(sets.items(), ("bottom", "top"), strict=True):
        places = body.positions(np.arange(body.dofs[:, 0].max() + 1))
        lines += [f"{first + k}, {x!r}, {y!r}, {z!r}" for k, (x, y, z) in enumerate(places.tolist())]
        cells = np.empty_like(body.mesh.t)
        cells[KINDS["hexahedron"].order] = body.mesh.t
        on = set(body.normals_on(inside)[0].tolist())
        surfaces.append(f"*SURFACE, NAME={'UPPER' if body is upper else 'LOWER'}, TYPE=ELEMENT")
        for nodes in cells.T.tolist():
            elements.append(f"{len(elements) + 1}, " + ", ".join(str(first + node) for node in nodes))
            for face, corners in enumerate(FACES, start=1):
                if on.issuperset(nodes[k] for k in corners):
                    surfaces.append(f"{len(elements)}, S{face}")
        named[name] = (body.normals_on(outside)[0] + first).tolist()
        first += len(places)
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=E", *elements]
    for name, labels in named.items():
        lines += [f"*NSET, NSET={name}", *(f"{label}," for label in labels)]
    lines += [*surfaces, "*MATERIAL, NAME=M", "*ELASTIC", "210000., 0.3", "*DENSITY", "1."]
    lines += ["*SOLID SECTION, ELSET=E, MATERIAL=M", "*BOUNDARY", "HELD, 1, 3"]
    return lines, len(named["TOP"])


def _at_contact(
    made: shakedown.Import, moved: dict[int, FloatArray]
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Of displacements: those of the rows of the matrix; slips and gaps, and forces, at the contact nodes."""
    frame, coupling, dofs = made.condensation.frame, made.contact.coupling, made.stiffness.dofs
    assert coupling is not None
    opening = coupling.opening(lambda nodes: np.array([moved[node] for node in nodes.tolist()]))
    u = np.array([moved[node][direction - 1] for node, direction in dofs.tolist()])
    forces = (made.stiffness.K @ u)[frame.rows]
    return u, frame.to_local(opening), frame.to_local(forces)


def _displacements(path: Path) -> dict[int, FloatArray]:
    """The last table of displacements of a ``.dat`` file."""
    rows = path.read_text().rpartition("displacements")[2].splitlines()[1:]
    fields = [line.split() for line in rows if line.strip()]
    return {int(node): np.array([float(x), float(y), float(z)]) for node, x, y, z in fields}
