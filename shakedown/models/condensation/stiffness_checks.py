"""Checks of a stiffness before it is condensed: symmetry, definiteness, motions that nothing holds."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import eigsh

from shakedown.ground.constants import EACH_SHOWN, MANY_ROWS, NEGLIGIBLE, FloatArray, IntArray, Mask
from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.models.condensation.surface_mesh import rigid_rows

PlacesByNode = Mapping[int, Sequence[float]]  # node → (x, y, z)
_SAME = 1e-5  # part of a motion that must lie outside the free ones for it not to be one of them


def loose_motion(K: sparse.csc_array, dofs: IntArray, places: PlacesByNode | None = None) -> str:
    """What moves without resistance, as a message says it: nodes, with directions.

    Parameters
    ----------
    K : (N, N)
        Singular stiffness [force/length].
    dofs : (N, 2)
        Node and direction of every row.
    places
        Coordinates of the nodes, without which turning cannot be distinguished from other motions.

    Examples
    --------
    >>> spring = sparse.csc_array([[1.0, -1.0], [-1.0, 1.0]])
    >>> loose_motion(spring, np.array([(7, 1), (9, 1)]))
    'nodes 7, 9 along x'
    """
    # motions without resistance, (N, k), orthonormal; at least the softest one
    N, largest = K.shape[0], float(K.diagonal().max())
    if N <= MANY_ROWS:
        values, modes = np.linalg.eigh(K.toarray())
    else:
        values, modes = eigsh(K, k=12, sigma=-NEGLIGIBLE * largest, v0=np.ones(N))
    order = np.argsort(values)
    modes = np.asarray(modes[:, order[: max(int((values <= NEGLIGIBLE * largest).sum()), 1)]])
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


def motions_in_words(modes: FloatArray, dofs: IntArray, places: PlacesByNode | None) -> list[str]:
    """The motions of one part, (N, k), in words: along axes, turning about them, other ways."""
    left, singular, _ = np.linalg.svd(modes, full_matrices=False)
    free = left[:, singular > _SAME * singular[0]]
    rigid = rigid_motions(dofs, places, (1, 2, 3))
    size = np.linalg.norm(rigid, axis=0)
    outside = rigid - free @ (free.T @ rigid)
    # a rotation about some point: one about the middle, and what moves the middle
    moved = outside[:, :3] * (np.linalg.norm(outside[:, :3], axis=0) > _SAME * size[:3])
    outside[:, 3:] -= moved @ np.linalg.lstsq(moved, outside[:, 3:], rcond=_SAME)[0]
    found = np.flatnonzero((size > _SAME) & (np.linalg.norm(outside, axis=0) <= _SAME * size))
    every = [f"{how} {axis}" for how in ("along", "turning about") for axis in "xyz"]
    words = [every[k] for k in found.tolist()]
    known = rigid[:, found]
    rest = free - known @ np.linalg.lstsq(known, free, rcond=None)[0] if known.shape[1] else free
    more = free.shape[1] - len(words)
    if more > 0:
        node, direction = dofs[int(np.argmax(np.abs(rest).max(axis=1)))]
        also = "also " if words else ""
        words.append(f"{also}in {more} other way(s), most of all node {node} in direction {direction}")
    return words


def rigid_motions(dofs: IntArray, places: PlacesByNode | None, axes: Sequence[int]) -> FloatArray:
    """Rigid motions of nodes, one row per row: along the axes, then turned within them, (N, k).

    Displacements are 1 at most. Rows of rotations (directions 4, 5, 6) turn along, internal nodes (labels
    below 0) stay. There are no turns where the place of a node is not known, or all are at one place.

    Examples
    --------
    >>> rigid_motions(np.array([(7, 1), (7, 2), (8, 2)]), {7: (3, 0, 0), 8: (9, 0, 0)}, (1, 2)).tolist()
    [[1.0, 0.0, 0.0], [0.0, 1.0, -0.5], [0.0, 1.0, 1.0]]
    """
    direction = np.where(dofs[:, 0] >= 0, dofs[:, 1], 0)
    moving, turning = np.isin(direction, axes), np.flatnonzero((direction > 3) & (direction <= 6))
    labels, xyz = dofs[moving, 0].tolist(), np.zeros((np.count_nonzero(moving), 3))
    if places is not None and labels and places.keys() >= set(labels):
        xyz = np.array([places[node] for node in labels], dtype=float)
        xyz -= xyz.mean(axis=0)
    size = float(np.abs(xyz).max(initial=0.0))
    about = {3: [3, 4, 5], 2: [2 + axis for axis in {1, 2, 3}.difference(axes)]}.get(len(axes), [])
    found = np.zeros((len(dofs), 6))
    found[moving] = rigid_rows(xyz / (size or 1.0))[np.arange(len(labels)), direction[moving] - 1]
    found[turning, direction[turning] - 1] = 1.0 / (size or 1.0)
    return found[:, [*(axis - 1 for axis in axes), *(about if size else [])]]


def _nodes(labels: list[int]) -> str:
    """Nodes as a message names them."""
    once = sorted(set(labels))
    shown = ", ".join(map(str, once[:EACH_SHOWN]))
    if len(once) > EACH_SHOWN:
        return f"nodes {shown}, … ({len(once)} in all)"
    return f"node {shown}" if len(once) == 1 else f"nodes {shown}"


def checked_matrix(K: Any, dofs: IntArray) -> tuple[sparse.csr_array, Mask]:
    """A stiffness as a CSR array without stored zeros, and which rows it marks as constrained.

    Raises
    ------
    ProblemError
        If K is not square, does not have one row per entry of ``dofs``, is not
        real and finite, or is not symmetric apart from constrained rows.
    """
    matrix = sparse.csr_array(K)
    if matrix.shape != (len(dofs), len(dofs)):
        raise ProblemError(
            f"K: expected shape ({len(dofs)}, {len(dofs)}), one row per dof, found {matrix.shape}"
        )
    if matrix.dtype.kind not in "fiu":
        raise ProblemError(f"K: expected real numbers, found dtype {matrix.dtype}")
    matrix = matrix.astype(np.float64)
    if (wrong := ~np.isfinite(matrix.data)).any():
        raise ProblemError(f"K: expected finite numbers, found {matrix.data[wrong][0]}")
    constrained = matrix.diagonal() >= DEFAULT.constrained_diagonal
    matrix = (matrix - sparse.diags_array(np.where(constrained, matrix.diagonal(), 0.0))).tocsr()
    matrix.eliminate_zeros()
    matrix.sort_indices()
    if matrix.nnz == 0:
        raise ProblemError("K: expected a stiffness matrix, found only zeros")
    error = abs(matrix - matrix.T).tocoo()
    if error.data.max(initial=0.0) > DEFAULT.symmetry * np.abs(matrix.data).max():
        i, j = (int(place[np.argmax(error.data)]) for place in error.coords)
        raise ProblemError(
            f"K: expected a symmetric matrix, found {matrix[i, j]:.9g} at row {tuple(dofs[i].tolist())}, "
            f"column {tuple(dofs[j].tolist())} but {matrix[j, i]:.9g} at its mirror image"
        )
    return matrix, constrained


def uncoupled(K: sparse.csr_array, nodes: IntArray) -> str:
    """Why a matrix declared as condensed is too sparse for it, in words; "" where it is not.

    Over one connected body the condensed matrix couples every node to every
    other; a plain sub-block of the full matrix couples neighbours only.

    Parameters
    ----------
    K : (N, N)
        Stiffness [force/length].
    nodes : (N,)
        Node label of every row.

    Examples
    --------
    >>> chain = sparse.csr_array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    >>> uncoupled(chain, np.array([1, 2, 3]))[:55]
    'found 2 of 9 node pairs of one body without coupling, o'
    """
    coupled, _ = coupled_nodes(K, nodes)
    n = coupled.shape[0]
    count, body = connected_components(coupled, directed=False)
    pairs = int((np.bincount(body) ** 2).sum())
    if pairs == coupled.nnz and not count == n > 1:
        return ""
    return (
        f"found {pairs - coupled.nnz} of {pairs} node pairs of one body without coupling, or none with any; "
        "it looks like a sub-block of the full matrix (CalculiX 2.20 writes that for *SUBSTRUCTURE "
        "GENERATE). Give the full matrix, or the reactions to unit displacements"
    )


def coupled_nodes(K: sparse.csr_array, nodes: IntArray) -> tuple[sparse.csr_array, IntArray]:
    """Which nodes have entries together that are no round-off, (k, k), and themselves; the node of every row.

    Diagonals that mark held rows count as the largest of the others.
    """
    labels, index = np.unique(nodes, return_inverse=True)
    entries, diagonal = K.tocoo(), np.abs(K.diagonal())
    marked = diagonal >= DEFAULT.constrained_diagonal
    size = np.sqrt(np.where(marked, diagonal[~marked].max(initial=0.0), diagonal))
    row, column = entries.coords
    large = np.abs(entries.data) > DEFAULT.condensed_pattern * size[row] * size[column]
    one, other = (np.append(index[each[large]], range(len(labels))) for each in (row, column))
    shape = (len(labels), len(labels))
    return sparse.csr_array((np.ones(len(one)), (one, other)), shape=shape), index


def asymmetry(matrix: FloatArray) -> float:
    """Largest |κ − κᵀ| relative to max |κ|."""
    return float(np.abs(matrix - matrix.T).max() / max(np.abs(matrix).max(), np.finfo(float).tiny))


def with_shanks(K: sparse.csr_array, shanks: Sequence[tuple[float, FloatArray]]) -> sparse.csr_array:
    """K + Σ k e eᵀ, of shanks with stiffness k that get shorter by e · u.

    Examples
    --------
    >>> import numpy as np
    >>> with_shanks(sparse.csr_array((2, 2)), [(3.0, np.array([1.0, -1.0]))]).toarray().tolist()
    [[3.0, -3.0], [-3.0, 3.0]]
    """
    for stiffness, shortening in shanks:
        if stiffness:
            e = sparse.csr_array(shortening[None])
            K = K + stiffness * (e.T @ e)
    return K
