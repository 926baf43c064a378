"""Two blocks of hexahedra on each other, C3D8 of CalculiX in full: a deck, and the stiffness as it stores it."""

from itertools import product

import numpy as np
import writers

STEEL = (210e3, 0.3)
CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
TETRAHEDRA = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))
COUNTS, SIZE = (3, 2, 1), (2.0, 1.5, 1.0)  # elements along x, y, z and sides of one block


def places():
    """Nodes of the lower block, then of the upper one: label - 1 → (x, y, z)."""
    steps = [np.linspace(0, side, count + 1) for side, count in zip(SIZE, COUNTS, strict=True)]
    block = np.array([(x, y, z) for z, y, x in product(*steps[::-1])])
    return np.vstack([block, block + np.array([0, 0, SIZE[2]])])


def hexahedra():
    """Node labels of every element, corners in the order of C3D8."""
    nx, ny, nz = COUNTS
    first = np.array([(i, j, k) for k, j, i in product(range(nz), range(ny), range(nx))])
    corner = first[:, None] + CORNERS
    number = 1 + corner[..., 0] + (nx + 1) * (corner[..., 1] + (ny + 1) * corner[..., 2])
    return np.vstack([number, number + (nx + 1) * (ny + 1) * (nz + 1)])


def node_sets():
    xyz, half = places(), len(places()) // 2
    label = np.arange(1, 2 * half + 1)
    upper = label > half
    return {
        "FOOT": label[xyz[:, 2] == 0],
        "LOWER_TOP": label[~upper & (xyz[:, 2] == SIZE[2])],
        "UPPER_FOOT": label[upper & (xyz[:, 2] == SIZE[2])],
        "TOP": label[xyz[:, 2] == 2 * SIZE[2]],
        "SIDE": label[xyz[:, 1] == 0],
    }


def deck(xyz, *, kind="C3D8", more=()):
    """The deck of both blocks, the foot of the lower one held; ``more`` (node set, direction) too."""
    elements = hexahedra()
    if kind == "C3D4":
        elements = elements[:, TETRAHEDRA].reshape(-1, 4)
    held = ["*BOUNDARY", "FOOT, 1, 3", *(f"{name}, {direction}, {direction}" for name, direction in more)]
    return writers.calculix_deck(xyz.tolist(), elements.tolist(), node_sets(), kind, more=held)


def element_stiffness(corners):
    """(24, 24) of one hexahedron with 2 x 2 x 2 Gauss points."""
    young, poisson = STEEL
    shear = young / 2 / (1 + poisson)
    law = np.diag([2 * shear] * 3 + [shear] * 3)
    law[:3, :3] += young * poisson / (1 + poisson) / (1 - 2 * poisson)
    K, signs = np.zeros((24, 24)), 2 * CORNERS - 1
    for point in product((-1 / np.sqrt(3), 1 / np.sqrt(3)), repeat=3):
        parts = 1 + signs * point
        slopes = [signs[:, a] * np.prod(np.delete(parts, a, axis=1), axis=1) / 8 for a in range(3)]
        jacobian = np.array(slopes) @ corners
        d = np.linalg.solve(jacobian, np.array(slopes))
        B = np.zeros((6, 24))
        for a in range(3):
            B[a, a::3] = d[a]
        for row, (a, b) in enumerate(((0, 1), (1, 2), (2, 0)), start=3):
            B[row, a::3], B[row, b::3] = d[b], d[a]
        K += B.T @ law @ B * np.linalg.det(jacobian)
    return K


def stiffness(xyz, held=("FOOT",)):
    """(K, dofs) of both blocks, without the rows of nodes that are held."""
    K, sets = np.zeros((3 * len(xyz), 3 * len(xyz))), node_sets()
    for nodes in hexahedra() - 1:
        rows = (3 * nodes[:, None] + np.arange(3)).ravel()
        K[np.ix_(rows, rows)] += element_stiffness(xyz[nodes])
    dofs = np.array([(node, d) for node in range(1, len(xyz) + 1) for d in (1, 2, 3)])
    free = ~np.isin(dofs[:, 0], [node for name in held for node in sets[name]])
    return K[np.ix_(free, free)], dofs[free]


def with_modes(xyz, seed=0):
    """(K, dofs) as :func:`stiffness`, each element with nine unknowns of its own that no rigid motion moves."""
    K, dofs = stiffness(xyz)
    rows = {key: k for k, key in enumerate(map(tuple, dofs.tolist()))}
    rng, columns, stiff = np.random.default_rng(seed), [], []
    for nodes in hexahedra():
        own = element_stiffness(xyz[nodes - 1])
        for forces in (own @ rng.normal(size=(24, 9))).T:
            column = np.zeros(len(K))
            for key, force in zip(product(nodes.tolist(), (1, 2, 3)), forces, strict=True):
                if key in rows:
                    column[rows[key]] = force
            columns.append(column)
            stiff.append(1e3 * np.abs(own).max())
    K_cm, labels = np.array(columns).T, len(xyz) + 1 + np.arange(len(columns)) // 3
    made = np.column_stack([labels, np.arange(len(columns)) % 3 + 1])
    return np.block([[K, K_cm], [K_cm.T, np.diag(stiff)]]), np.vstack([dofs, made])


def write_model(folder, xyz):
    """The deck and what CalculiX would store."""
    (folder / "job.inp").write_text(deck(xyz))
    sti, dof = writers.calculix_storage(*stiffness(xyz))
    (folder / "job.sti").write_text(sti)
    (folder / "job.dof").write_text(dof)
