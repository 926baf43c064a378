"""Two bodies from meshes, the one on the other: their deck, and the matrix as CalculiX stores it."""

import numpy as np
import writers
from scipy import sparse

from shakedown.fem import ElasticBody, Force, Material, Support, brick_mesh
from shakedown.fem.body import KINDS

STEEL = Material(210e3, 0.3)
LOADS = """
[[load]]
name = "press"
forces = [["TOP", 3, -10.0]]
history = 1.0
[[load]]
name = "shake"
forces = [["TOP", 1, 2.0], ["TOP", 2, 1.0]]
history = [1.0, 0.0, -1.0, 0.0]
"""


def nodes_as_in_decks(body):
    kind = "hexahedron" if body.dimension == 3 else "quadrilateral"
    cells = np.empty_like(body.mesh.t)
    cells[KINDS[kind].order] = body.mesh.t
    return cells.T


def write(folder, upper, lower, cut=None):
    """The deck of both bodies, the labels of the upper one from 1, and the matrix as CalculiX stores it.

    ``cut`` = {name: which of places (n, 3)} makes sets UPPER_name and LOWER_name of nodes of the contact.
    """
    nodes, elements, sets, start = [], [], {}, 1
    for name, body, side in (("UPPER", upper, "bottom"), ("LOWER", lower, "top")):
        places = body.positions(np.arange(body.dofs[:, 0].max() + 1))
        nodes += np.pad(places, ((0, 0), (0, 3 - places.shape[1]))).tolist()
        elements += (nodes_as_in_decks(body) + start).tolist()
        sets[name] = body.normals_on(side)[0] + start
        for part, inside in (cut or {}).items():
            own = body.normals_on(side)[0]
            sets[f"{name}_{part}"] = own[inside(body.positions(own))] + start
        if body is upper:
            sets["TOP"] = body.normals_on("top")[0] + start
        start += len(places)
    kind = "C3D8" if upper.dimension == 3 else "CPE4"
    (folder / "job.inp").write_text(writers.calculix_deck(nodes, elements, sets, kind))
    K = sparse.block_diag([upper.stiffness, lower.stiffness]).toarray()
    shift = [upper.dofs[:, 0].max() + 2, 0]
    free = ~np.isin(np.arange(len(K)), lower.held_rows() + upper.basis.N)
    dofs = np.vstack([upper.dofs + np.array([1, 0]), lower.dofs + shift])[free]
    sti, dof = writers.calculix_storage(K[np.ix_(free, free)], dofs)
    (folder / "job.sti").write_text(sti)
    (folder / "job.dof").write_text(dof)


def configuration(folder, contact, *more, loads=LOADS, job="job", friction=0.4, name="import.toml"):
    """The configuration of an import of them; ``contact`` the lines of its table or of several, ``more`` other tables."""
    text = f'friction = {friction}\nunits = "N, mm"\n[model]\nfile = "{job}.inp"\n[stiffness]\nfile = "{job}.sti"\n'
    patches = (
        [f"[contact]\n{contact}"] if isinstance(contact, str) else [f"[[contact]]\n{own}" for own in contact]
    )
    (folder / name).write_text("\n".join([text, *patches, *more, loads]))
    return folder / name


def bricks(upper=(2, 2, 1), lower=(3, 2, 1), height=1.0, size=1.0):
    count, block = (upper[0] + 1) * (upper[1] + 1), (2.0 * size, 1.5 * size, size)
    loads = [
        Force("top", (0.0, 0.0, -10.0 * count), history=1.0),
        Force("top", (2.0 * count, 1.0 * count, 0.0), history=[1.0, 0.0, -1.0, 0.0]),
    ]
    return (
        ElasticBody(brick_mesh(block, upper, origin=(0, 0, height * size)), STEEL, loads=loads),
        ElasticBody(brick_mesh(block, lower), STEEL, supports=[Support("bottom")]),
    )
