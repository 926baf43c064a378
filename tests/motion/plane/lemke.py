"""A third method for the rates: the linear complementarity problem of all nodes at their limits, by Lemke's method.

Independent of the compiled loops: numpy only.
"""

import numpy as np

from shakedown.ground.status import BACKWARD_SLIP, FORWARD_SLIP, OPEN
from shakedown.motion.plane.active_set import AIR, APEX, FRICTIONLESS, ON_BACKWARD, ON_FORWARD


def lemke(M, b, max_pivots):
    """z ≥ 0 with y = M z + b ≥ 0, zᵀ y = 0 (Cottle, Pang & Stone, algorithms 4.4.5, 4.9.3); None on a ray.

    >>> lemke(np.array([[2.0, 1.0], [0.0, 1.0]]), np.array([-3.0, -1.0]), 100)
    array([1., 1.])
    """
    k = len(b)
    if k == 0 or b.min() >= 0.0:
        return np.zeros(k)
    # Columns: right-hand side, y (k), z (k), covering variable. y − M z − z0 = b.
    table = np.hstack([b[:, None], np.eye(k), -M, -np.ones((k, 1))])
    basis = np.arange(k)
    row, entering = int(np.flatnonzero(b == b.min())[-1]), 2 * k
    for _ in range(max_pivots):
        table[row] /= table[row, 1 + entering]
        others = np.arange(k) != row
        table[others] -= np.outer(table[others, 1 + entering], table[row])
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * k:
            z = np.zeros(2 * k)
            z[basis] = np.maximum(table[:, 0], 0.0)
            return z[k:]
        entering = leaving + k if leaving < k else leaving - k
        column = table[:, 1 + entering]
        rows = np.flatnonzero(column > 1e-11 * np.abs(column).max())
        if not len(rows):
            return None
        row = _leaving_row(table[:, : 1 + k], column, rows, basis)
    return None


def _leaving_row(table, column, rows, basis):
    """Row of the lexicographically smallest ratio; the covering variable leaves whenever it may."""
    ratios = {i: table[i] / column[i] for i in rows}
    best = min(ratio[0] for ratio in ratios.values())
    tied = [i for i in rows if ratios[i][0] <= best + 1e-13 * abs(best)]
    cover = [i for i in tied if basis[i] == 2 * len(basis)]
    return cover[0] if cover else min(tied, key=lambda i: tuple(ratios[i]))


def rates_by_lemke(kappa, f, place, welded):
    """Rates (2n,) of v and w from the places of the nodes and the rates of the welded reactions, or None.

    Unknowns z ≥ 0: the slip rate −s v̇ of a node on limit s; v̇⁺, v̇⁻ and ẇ at an
    apex. Their complements: f ṗ − s q̇; f ṗ + q̇, f ṗ − q̇ and ṗ.
    """
    n = len(f)
    free = [i for i in range(n) if place[i] in (AIR, FRICTIONLESS)]
    free += [n + i for i in range(n) if place[i] == AIR]
    unknowns = []
    for i in range(n):
        if place[i] in (ON_BACKWARD, ON_FORWARD):
            unknowns.append((i, int(place[i])))
        elif place[i] == APEX:
            unknowns += [(i, FORWARD_SLIP), (i, BACKWARD_SLIP)] if f[i] > 0 else []
            unknowns.append((i, OPEN))
    directions = np.zeros((2 * n, len(unknowns)))
    guards = np.zeros((len(unknowns), 2 * n))
    for k, (i, kind) in enumerate(unknowns):
        directions[n + i if kind == OPEN else i, k] = 1.0 if kind == OPEN else -kind
        guards[k, n + i] = 1.0 if kind == OPEN else f[i]
        guards[k, i] = 0.0 if kind == OPEN else -kind

    def with_free(motion):
        """The displacements that move freely follow the others."""
        moved = np.array(motion, dtype=float)
        moved[free] -= np.linalg.solve(kappa[np.ix_(free, free)], (kappa @ motion)[free])
        return moved

    still = np.zeros(2 * n)
    still[free] = -np.linalg.solve(kappa[np.ix_(free, free)], welded[free])
    columns = np.array([with_free(column) for column in directions.T]).reshape(-1, 2 * n).T
    M, b = guards @ kappa @ columns, guards @ (welded + kappa @ still)
    z = lemke(M, b, 50 * len(b) + 100)
    return None if z is None else still + columns @ z
