"""Boundaries that move as rigid bodies: their nodes follow a translation and a rotation."""

import numpy as np
from scipy import sparse

from shakedown.fem.body import ElasticBody, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.models.mortar.exact_rotations import rigid_rows


def rigid_motion(places: FloatArray) -> FloatArray:
    """Displacements of points by unit translations and unit turns about their middle, (n, k, r).

    In a plane k = 2, r = 3; in space k = 3, r = 6. A turn of 1 moves the farthest point by 1, so that all
    unknowns are displacements.

    Examples
    --------
    >>> rigid_motion(np.array([[-2.0, 0.0], [2.0, 0.0]]))[1].tolist()
    [[1.0, 0.0, -0.0], [0.0, 1.0, 1.0]]
    """
    arm = places - places.mean(axis=0)
    return rigid_rows(arm / (np.linalg.norm(arm, axis=1).max() or 1.0))


def tied(body: ElasticBody, contact: IntArray) -> tuple[sparse.csr_array, IntArray]:
    """u = T u': the displacements of a body in terms of those that its rigid boundaries leave.

    Parameters
    ----------
    contact
        Contact nodes of the body.

    Returns
    -------
    T : (N, N')
        The unit matrix where no boundary is rigid.
    dofs : (N', 2)
        Node and direction of what is left; every rigid boundary is a node with directions 1 to 6.

    Raises
    ------
    ProblemError
        If a node of a rigid boundary is held, in contact, or on another one.
    """
    kept = np.ones(body.basis.N, dtype=bool)
    blocks, labels = [], [np.zeros((0, 2), dtype=np.intp)]
    taken = {"in contact": contact, "held or prescribed": body.dofs[body.held_rows(), 0]}
    first = int(body.dofs[:, 0].max()) + 1
    for number, name in enumerate(body.rigid):
        rows = np.column_stack([body.rows_on(name, 1 + a) for a in range(body.dimension)])
        nodes = body.dofs[rows[:, 0], 0]
        for what, others in taken.items():
            if np.isin(nodes, others).any():
                shared = int(nodes[np.argmax(np.isin(nodes, others))])
                raise ProblemError(
                    f"rigid boundary '{name}': expected free nodes, found node {shared} {what}"
                )
        taken[f"on '{name}' too"] = nodes
        motion = rigid_motion(body.positions(nodes))
        kept[rows] = False
        blocks.append((rows.ravel(), motion.reshape(rows.size, -1)))
        own = np.arange(1, motion.shape[2] + 1)
        labels.append(np.column_stack([np.full(len(own), first + number), own]))
    free = np.flatnonzero(kept)
    T = [sparse.csr_array((np.ones(len(free)), (free, np.arange(len(free)))), shape=(len(kept), len(free)))]
    for rows, motion in blocks:
        spread = sparse.csr_array((len(kept), motion.shape[1])).tolil()
        spread[rows] = motion
        T.append(spread.tocsr())
    return sparse.csr_array(sparse.hstack(T)), np.vstack([body.dofs[free], *labels])
