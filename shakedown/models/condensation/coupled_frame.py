"""Contact nodes that face a surface with another mesh, not a node, and facets whose basis is changed."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.models.condensation.contact_frame import SPACE, ContactFrame
from shakedown.models.condensation.facet_shapes import ALPHA
from shakedown.models.condensation.node_coupling import NodeCoupling

IntArray = NDArray[np.intp]


def coupled_frame(
    frame: ContactFrame,
    table: IntArray,
    axes: tuple[int, ...],
    coupling: NodeCoupling | None,
    middle_nodes: ArrayLike | None,
) -> ContactFrame:
    """The frame with what its nodes follow on the second body, and nodes between corners with another basis.

    Parameters
    ----------
    table : (N, 2)
        Node and direction of every row.
    axes
        The directions of a plane contact.
    coupling
        The coupling, whose contact nodes are on the first body; None where nodes face nodes, or an obstacle.
    middle_nodes : (t, 3), optional
        (node between two corners, these corners) of faces whose corners would carry no pressure otherwise; a
        coupling brings its own.

    Raises
    ------
    ProblemError
        If the contact nodes are not those of the coupling, or none of its master's has a row.
    """
    index = {(int(node), int(direction)): k for k, (node, direction) in enumerate(table)}
    own = {len(axes): axes, len(SPACE): SPACE}[frame.normals.shape[1]]
    first = frame.labels.reshape(frame.n, -1)[:, 0]
    followed = None if coupling is None else _followed(coupling, frame, index, own, len(table))
    given = np.zeros((0, 3), np.intp) if middle_nodes is None else np.asarray(middle_nodes, dtype=np.intp)
    if coupling is not None:
        given = coupling.middle_nodes
    given = given.reshape(-1, 3)
    given = given[np.isin(given[:, 0], first)]
    if coupling is None:  # the other side is a basis of its own: nothing but contact nodes may be mixed
        given = given[np.isin(given[:, 1:], first).all(axis=1)]
    rows = np.array([[[index.get((int(k), a), -1) for a in own] for k in three] for three in given])
    return replace(
        frame,
        followed=followed,
        between=rows.astype(np.intp).reshape(-1, 3, len(own)),
    )


def _followed(
    coupling: NodeCoupling,
    frame: ContactFrame,
    index: Mapping[tuple[int, int], int],
    own: tuple[int, ...],
    size: int,
) -> sparse.csr_array:
    """P by rows of the model, (n (d + 1), N): the motion of the contact nodes without slip and gap."""
    d = coupling.normals.shape[1]
    place = {label: k for k, label in enumerate(coupling.labels.tolist())}
    alien = [label for label in frame.labels.ravel().tolist() if label not in place]
    if alien or frame.labels.ndim != 1 or max(own) > d:
        found = "pairs" if frame.labels.ndim != 1 else f"node {alien[0]}" if alien else f"directions {own}"
        raise ProblemError(
            f"coupling: expected contact nodes of its first surface in {d} dimensions, found {found}"
        )
    rows = [d * place[label] + axis - 1 for label in frame.labels.tolist() for axis in own]
    target = np.array(
        [[index.get((int(k), a), -1) for a in range(1, d + 1)] for k in coupling.master]
    ).ravel()
    if (target < 0).all():
        raise ProblemError(
            f"coupling: expected rows of the nodes of the second surface, "
            f"first {coupling.master[0]}, found none"
        )
    there = target >= 0  # a missing row is held
    chosen = sparse.csr_array(
        (np.ones(there.sum()), (np.flatnonzero(there), target[there])), shape=(len(target), size)
    )
    return sparse.csr_array(coupling.P[rows] @ chosen)


def hat_areas(area: FloatArray, labels: IntArray, middle_nodes: IntArray) -> FloatArray:
    """∫N̂ of nodes (n,) from their ∫N: nodes between corners pass on a part of theirs to the corners."""
    found, place = area.copy(), {label: k for k, label in enumerate(labels.tolist())}
    for node, *corners in middle_nodes.tolist():
        if node in place and all(corner in place for corner in corners):
            found[place[node]] *= 1 - 2 * ALPHA
            for corner in corners:
                found[place[corner]] += ALPHA * area[place[node]]
    return found
