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
_AXES = "xyz"


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


def motions_in_words(modes: FloatArray, dofs: NDArray[np.intp], places: Places | None = None) -> list[str]:
    """The motions of one part, (N, k), in words: along axes, turning about them, other ways."""
    left, singular, _ = np.linalg.svd(modes, full_matrices=False)
    free = left[:, singular > _SAME * singular[0]]
    words, told = [], np.zeros((len(dofs), 0))
    for direction in sorted(set(dofs[:, 1].tolist()) & {1, 2, 3}):
        along = (dofs[:, 1] == direction).astype(float)
        if _inside(along, free):
            words.append(f"along {_AXES[direction - 1]}")
            told = np.column_stack([told, along])
    for axis, turned in _turns(dofs, places):
        if _inside_up_to(turned, free, dofs):
            words.append(f"turning about {_AXES[axis]}")
            told = np.column_stack([told, turned])
    rest = free - told @ np.linalg.lstsq(told, free, rcond=None)[0] if told.shape[1] else free
    more = free.shape[1] - len(words)
    if more > 0:
        node, direction = dofs[int(np.argmax(np.abs(rest).max(axis=1)))]
        also = "also " if words else ""
        words.append(f"{also}in {more} other way(s), most of all node {node} in direction {direction}")
    return words


def _inside(motion: FloatArray, free: FloatArray) -> bool:
    """Whether a motion is a combination of free ones."""
    outside = motion - free @ (free.T @ motion)
    return bool(np.linalg.norm(outside) <= _SAME * np.linalg.norm(motion))


def _inside_up_to(turned: FloatArray, free: FloatArray, dofs: NDArray[np.intp]) -> bool:
    """Whether the part turns about some point: a rotation plus what moves its centre is free."""
    shifts = np.column_stack([dofs[:, 1] == d for d in (1, 2, 3)]).astype(float)
    outside = turned - free @ (free.T @ turned)
    moved = shifts - free @ (free.T @ shifts)
    rest = outside - moved @ np.linalg.lstsq(moved, outside, rcond=1e-9)[0]
    return bool(np.linalg.norm(rest) <= _SAME * np.linalg.norm(turned))


def _turns(dofs: NDArray[np.intp], places: Places | None) -> list[tuple[int, FloatArray]]:
    """Rotations about x, y, z through the middle of a part that has a size, as (axis, motion)."""
    if places is None or not set(dofs[:, 0].tolist()) <= set(places):
        return []
    xyz = np.array([places[node] for node in dofs[:, 0].tolist()], dtype=float)
    xyz = xyz - xyz.mean(axis=0)
    size = float(np.abs(xyz).max())
    if size == 0:
        return []
    found = []
    for axis in range(3):
        shift = np.cross(np.eye(3)[axis], xyz / size)
        own = np.arange(len(dofs)), np.clip(dofs[:, 1] - 1, 0, 2)
        turned = np.where((dofs[:, 1] >= 1) & (dofs[:, 1] <= 3), shift[own], 0.0)
        turned += (dofs[:, 1] == 4 + axis) / size
        if np.linalg.norm(turned) > _SAME:
            found.append((axis, turned))
    return found


def _nodes(labels: list[int]) -> str:
    """Nodes as a message names them."""
    once = sorted(set(labels))
    shown = ", ".join(map(str, once[:EACH_SHOWN]))
    if len(once) > EACH_SHOWN:
        return f"nodes {shown}, … ({len(once)} in all)"
    return f"node {shown}" if len(once) == 1 else f"nodes {shown}"
