"""Motions of an elastic model without resistance: which nodes move, and how."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import eigsh

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.size_limits import EACH_SHOWN, MANY_ROWS

Places = Mapping[int, Sequence[float]]  # node → (x, y, z)
_SAME = 1e-5  # part of a motion that must lie outside the free ones for it not to be one of them
_MOST_MODES = 12
_WORDS = [f"{how} {axis}" for how in ("along", "turning about") for axis in "xyz"]


def loose_motion(K: sparse.csc_array, dofs: NDArray[np.intp], places: Places | None = None) -> str:
    """What moves without resistance, as a message says it: nodes, with directions.

    Parameters
    ----------
    K : (N, N)
        Singular stiffness [force/length].
    dofs : (N, 2)
        Node and direction of every row.
    places
        Coordinates of the nodes, without which turning cannot be told from other motions.

    Examples
    --------
    >>> spring = sparse.csc_array([[1.0, -1.0], [-1.0, 1.0]])
    >>> loose_motion(spring, np.array([(7, 1), (9, 1)]))
    'nodes 7, 9 along x'
    """
    modes = _null_space(K)
    found: dict[str, list[int]] = {}
    count, part = connected_components(K, directed=False)
    size = np.abs(modes).max(axis=1)
    for number in range(count):
        rows = np.flatnonzero(part == number)
        if size[rows].max() <= _SAME * size.max():
            continue
        own = dofs[rows]
        motion = " and ".join(motions_in_words(modes[rows], own, places))
        found.setdefault(motion, []).extend(own[:, 0].tolist())
    return "; ".join(f"{_nodes(nodes)} {motion}" for motion, nodes in found.items())


def _null_space(K: sparse.csc_array) -> FloatArray:
    """Motions without resistance, (N, k), orthonormal; at least the softest one."""
    N, largest = K.shape[0], float(K.diagonal().max())
    if N <= MANY_ROWS:
        values, modes = np.linalg.eigh(K.toarray())
    else:
        shifted = {"k": _MOST_MODES, "sigma": -NEGLIGIBLE * largest, "v0": np.ones(N)}
        values, modes = eigsh(K, **shifted)
    order = np.argsort(values)
    null = max(int((values <= NEGLIGIBLE * largest).sum()), 1)
    return np.asarray(modes[:, order[:null]])


def motions_in_words(modes: FloatArray, dofs: NDArray[np.intp], places: Places | None) -> list[str]:
    """The motions of one part, (N, k), in words: along axes, turning about them, other ways."""
    left, singular, _ = np.linalg.svd(modes, full_matrices=False)
    free = left[:, singular > _SAME * singular[0]]
    rigid = _rigid(dofs, places)
    size = np.linalg.norm(rigid, axis=0)
    outside = rigid - free @ (free.T @ rigid)
    # a rotation about some point: one about the middle, and what moves the middle
    moved = outside[:, :3] * (np.linalg.norm(outside[:, :3], axis=0) > _SAME * size[:3])
    outside[:, 3:] -= moved @ np.linalg.lstsq(moved, outside[:, 3:], rcond=_SAME)[0]
    found = np.flatnonzero((size > _SAME) & (np.linalg.norm(outside, axis=0) <= _SAME * size))
    words = [_WORDS[k] for k in found.tolist()]
    told = rigid[:, found]
    rest = free - told @ np.linalg.lstsq(told, free, rcond=None)[0] if told.shape[1] else free
    more = free.shape[1] - len(words)
    if more > 0:
        node, direction = dofs[int(np.argmax(np.abs(rest).max(axis=1)))]
        also = "also " if words else ""
        words.append(f"{also}in {more} other way(s), most of all node {node} in direction {direction}")
    return words


def _rigid(dofs: NDArray[np.intp], places: Places | None) -> FloatArray:
    """Motions along x, y, z, and where places are known turns about them, (N, 3 or 6)."""
    known = places is not None and set(dofs[:, 0].tolist()) <= set(places)
    xyz = np.zeros((len(dofs), 3))
    if places is not None and known:
        xyz = np.array([places[node] for node in dofs[:, 0].tolist()], dtype=float)
        xyz = xyz - xyz.mean(axis=0)
    size = float(np.abs(xyz).max())
    found = rigid_motions(dofs, xyz, (1, 2, 3))
    return found / np.repeat([1.0, size], 3) if size > 0 else found[:, :3]


def rigid_motions(dofs: NDArray[np.intp], xyz: FloatArray, axes: Sequence[int]) -> FloatArray:
    """Rigid motions of nodes at (N, 3), one per row: along the axes, then turned within them, (N, k).

    Turning is by one radian per length; rows of rotations (directions 4, 5, 6) turn along, internal nodes
    (labels below 0) stay.

    Examples
    --------
    >>> rigid_motions(np.array([(7, 1), (7, 2)]), np.array([[3.0, 4.0, 0.0]] * 2), (1, 2)).tolist()
    [[1.0, 0.0, -4.0], [0.0, 1.0, 3.0]]
    """
    direction = np.where(dofs[:, 0] >= 0, dofs[:, 1], 0)  # internal nodes stay as they are
    columns = [np.where(direction == axis, 1.0, 0.0) for axis in axes]
    moving = np.flatnonzero(np.isin(direction, axes))
    for about in (1, 2, 3) if len(axes) == 3 else sorted({1, 2, 3} - set(axes)) if len(axes) == 2 else ():
        turned = np.where(direction == 3 + about, 1.0, 0.0)
        turned[moving] = np.cross(np.eye(3)[about - 1], xyz[moving])[
            np.arange(len(moving)), direction[moving] - 1
        ]
        columns.append(turned)
    return np.column_stack(columns)


def _nodes(labels: list[int]) -> str:
    """Nodes as a message names them."""
    once = sorted(set(labels))
    shown = ", ".join(map(str, once[:EACH_SHOWN]))
    if len(once) > EACH_SHOWN:
        return f"nodes {shown}, … ({len(once)} in all)"
    return f"node {shown}" if len(once) == 1 else f"nodes {shown}"
