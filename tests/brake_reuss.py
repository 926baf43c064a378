"""A small stand-in for the public Abaqus model of the Brake-Reuß beam: two half-beams on each other, reduced.

The deck and the substructure have the form of that model's ``Job.inp`` and ``Modelmats.mtx``: coordinates behind
``*SYSTEM``, sets of paired nodes, retained displacements of these and fixed-interface modes, a load case of bolts.
"""

import numpy as np
import writers
from scipy.linalg import eigh

from shakedown.fem import ElasticBody, Material, brick_mesh
from shakedown.fem.loads import mass_of

HALF, LAP, WIDTH, HEIGHT = 0.36, 0.06, 0.0254, 0.0127  # [m]
STEEL = Material(200e9, 0.29, density=7800.0)
ORDER = [0, 4, 3, 1, 7, 5, 2, 6]  # of scikit-fem's corners in a deck
MODES = 8


def write(folder):
    """``Job.inp`` and ``Modelmats.mtx``."""
    lines, first = ["*Heading", "*Preprint, echo=NO"], 1
    tops, bottoms, bodies, loads = [], [], [], []
    for name, start, z, own in (("TOP", -HALF, -HEIGHT, tops), ("BOT", -LAP, 0.0, bottoms)):
        origin = (start, -WIDTH / 2, z)
        mesh = brick_mesh((HALF + LAP, WIDTH, HEIGHT), (14, 2, 1), origin=origin)
        body = ElasticBody(mesh, STEEL)
        x, y, height = mesh.p
        touching = np.flatnonzero((np.abs(x) < LAP + 1e-9) & (np.abs(height) < 1e-9))
        own += (touching[np.lexsort((y[touching], x[touching].round(9)))] + first).tolist()
        bolts = np.flatnonzero((np.abs(x) < 0.031) & (np.abs(height) > 1e-9))
        force = np.zeros(body.basis.N)
        force[np.isin(body.dofs[:, 0], bolts) & (body.dofs[:, 1] == 3)] = 1.0 if name == "TOP" else -1.0
        loads.append(force)
        bodies.append(body)
        lines += ["*System", f"{origin[0]!r}, {origin[1]!r}, {origin[2]!r}", "*Node"]
        places = (mesh.p.T - origin).tolist()
        lines += [f"{k}, {', '.join(map(repr, place))}" for k, place in enumerate(places, start=first)]
        lines.append("*Element, type=C3D8R")
        for k, cell in enumerate(mesh.t.T.tolist()):
            corners = dict(zip(ORDER, cell, strict=True))
            lines.append(f"{first + k}, " + ", ".join(str(first + corners[n]) for n in range(8)))
        first += mesh.nvertices
    for name, own in (("TOPS_NDS", tops), ("BOTS_NDS", bottoms)):
        lines += ["*System", f"*Nset, nset={name}", *map(str, own)]
    lines += ["*Material, name=STEEL", "*Elastic", "2e+11, 0.29", ""]
    (folder / "Job.inp").write_text("\n".join(lines))
    firsts = (1, bodies[0].mesh.nvertices + 1)
    each = zip(bodies, firsts, (tops, bottoms), loads, strict=True)
    reduced = [fixed_interface(*own) for own in each]
    (folder / "Modelmats.mtx").write_text(substructure(reduced, [*tops, *bottoms]))


def fixed_interface(body, first, retained, force):
    """K, M and f in the displacements of the retained nodes and the first modes with these held."""
    K, M = body.stiffness.toarray(), mass_of(body).toarray()
    rows = np.concatenate([np.flatnonzero(body.dofs[:, 0] == node - first) for node in retained])
    inner = np.setdiff1d(np.arange(len(K)), rows)
    modes = eigh(K[np.ix_(inner, inner)], M[np.ix_(inner, inner)])[1][:, :MODES]
    T = np.zeros((len(K), len(rows) + MODES))
    T[rows, np.arange(len(rows))] = 1.0
    T[inner, : len(rows)] = -np.linalg.solve(K[np.ix_(inner, inner)], K[np.ix_(inner, rows)])
    T[inner, len(rows) :] = modes
    return T.T @ K @ T, T.T @ M @ T, T.T @ force


def substructure(parts, nodes):
    """The matrices of both halves, retained displacements of both first, then modes with labels below 0."""
    kept = len(parts[0][0]) - MODES
    order = np.concatenate([np.arange(kept), kept + MODES + np.arange(kept)])
    order = np.concatenate([order, np.setdiff1d(np.arange(2 * (kept + MODES)), order)])
    K, M = (np.zeros((2 * (kept + MODES), 2 * (kept + MODES))) for _ in "KM")
    for k, (own, mass, _) in enumerate(parts):
        place = slice(k * (kept + MODES), (k + 1) * (kept + MODES))
        K[place, place], M[place, place] = own, mass
    K, M = (0.5 * (each + each.T)[np.ix_(order, order)] for each in (K, M))
    modal = slice(2 * kept, None)
    K[:, modal] = np.diag(np.diag(K))[:, modal]
    K[modal] = np.diag(np.diag(K))[modal]
    load = np.concatenate([force for *_, force in parts])[order]
    dofs = [(node, d) for node in nodes for d in (1, 2, 3)] + [(-k, 1) for k in range(1, 2 * MODES + 1)]
    place = {node: k for k, node in enumerate(dict.fromkeys(node for node, _ in dofs), start=1)}
    text = writers.abaqus_substructure(K, dofs).split("*MATRIX,TYPE=MASS")[0]
    text += "** SUBSTRUCTURE LOAD CASE VECTOR. SLOAD CASE LCASE\n***CLOAD\n"
    text += "".join(f"** {place[n]}, {d}, {f:.15e}\n" for (n, d), f in zip(dofs, load, strict=True))
    mass = writers.abaqus_substructure(M, dofs).split("*MATRIX,TYPE=STIFFNESS")[1].split("*MATRIX")[0]
    return f"{text}*MATRIX,TYPE=MASS{mass}"
