"""Checks of a stiffness matrix from another program, and springs of bolts in it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT


def checked_matrix(K: Any, dofs: NDArray[np.intp]) -> tuple[sparse.csr_array, NDArray[np.bool_]]:
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
    if not np.isfinite(matrix.data).all():
        entries = matrix.tocoo()
        k = int(np.argmin(np.isfinite(entries.data)))
        (node, direction), (other, along) = dofs[entries.coords[0][k]], dofs[entries.coords[1][k]]
        raise ProblemError(
            f"K: expected finite numbers, found {entries.data[k]} at row ({node}, {direction}), column "
            f"({other}, {along})"
        )
    constrained = matrix.diagonal() >= DEFAULT.constrained_diagonal
    matrix = (matrix - sparse.diags_array(np.where(constrained, matrix.diagonal(), 0.0))).tocsr()
    matrix.eliminate_zeros()
    matrix.sort_indices()
    _check_symmetric(matrix, dofs)
    return matrix, constrained


def _check_symmetric(matrix: sparse.csr_array, dofs: NDArray[np.intp]) -> None:
    if matrix.nnz == 0:
        raise ProblemError("K: expected a stiffness matrix, found only zeros")
    error = abs(matrix - matrix.T).tocoo()
    if error.nnz == 0 or error.data.max() <= DEFAULT.symmetry * np.abs(matrix.data).max():
        return
    k = int(np.argmax(error.data))
    i, j = error.coords[0][k], error.coords[1][k]
    (node, direction), (other, other_direction) = dofs[i], dofs[j]
    raise ProblemError(
        f"K: expected a symmetric matrix, found {matrix[i, j]:.9g} at row ({node}, {direction}), column "
        f"({other}, {other_direction}) but {matrix[j, i]:.9g} at its mirror image"
    )


def check_condensed(K: sparse.csr_array, nodes: NDArray[np.intp]) -> None:
    """Refuse a matrix that is said to be condensed but is too sparse for it.

    Over one connected body the condensed matrix couples every node to every
    other; a plain sub-block of the full matrix couples neighbours only.

    Parameters
    ----------
    K : (N, N)
        Stiffness [force/length].
    nodes : (N,)
        Node label of every row.

    Raises
    ------
    ProblemError
        If two nodes that are connected through others are not coupled directly,
        or no node is coupled to another.

    Examples
    --------
    >>> chain = sparse.csr_array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]])
    >>> check_condensed(chain, np.array([1, 2, 3]))
    Traceback (most recent call last):
        ...
    shakedown.ground.errors.ProblemError: K: expected a condensed matrix, found 2 of 9 node pairs ...
    """
    labels, index = np.unique(nodes, return_inverse=True)
    entries = K.tocoo()
    diagonal = np.sqrt(np.abs(K.diagonal()))
    row, column = entries.coords
    large = np.abs(entries.data) > DEFAULT.condensed_pattern * diagonal[row] * diagonal[column]
    n = len(labels)
    pairs = sparse.coo_array((np.ones(large.sum()), (index[row[large]], index[column[large]])), shape=(n, n))
    coupled = (pairs.tocsr() + sparse.eye_array(n)).tocsr()
    count, body = connected_components(coupled, directed=False)
    size = np.bincount(body)
    absent = int((size**2).sum()) - coupled.nnz
    advice = (
        "it looks like a sub-block of the full matrix (CalculiX 2.20 writes that for *SUBSTRUCTURE "
        "GENERATE). Give the full matrix, or the reactions to unit displacements"
    )
    if absent:
        raise ProblemError(
            f"K: expected a condensed matrix, found {absent} of {(size**2).sum()} node pairs of one body "
            f"without coupling; {advice}"
        )
    if n > 1 and count == n:
        raise ProblemError(f"K: expected a condensed matrix, found {n} nodes without any coupling; {advice}")


def asymmetry(matrix: FloatArray) -> float:
    """Largest |κ − κᵀ| relative to max |κ|."""
    return float(np.abs(matrix - matrix.T).max() / max(np.abs(matrix).max(), np.finfo(float).tiny))


def check_against_run(
    stiffness: FloatArray, displacement: FloatArray, reaction: FloatArray, *, what: str = "static run"
) -> float:
    """Compare a condensed stiffness with a static run of the same model.

    Parameters
    ----------
    stiffness : ((d + 1) n, (d + 1) n)
        κ [force/length].
    displacement, reaction : ((d + 1) n,)
        Prescribed contact displacements (v, w) [length] and the reactions that
        the run gave for them, without any other load [force].

    Returns
    -------
    float
        Largest difference, relative to the largest reaction.

    Raises
    ------
    ProblemError
        If they differ by more than ``Tolerances.cross_check``.

    Examples
    --------
    >>> check_against_run(np.diag([2.0, 4.0]), np.array([0.0, 1.0]), np.array([0.0, 4.0]))
    0.0
    """
    predicted = stiffness @ displacement
    size = max(float(np.abs(reaction).max()), np.finfo(float).tiny)
    error = float(np.abs(predicted - reaction).max() / size)
    if error <= DEFAULT.cross_check:
        return error
    hint = ""
    along = float(predicted @ reaction) / float(reaction @ reaction) if reaction.any() else 0.0
    if along != 0 and np.abs(predicted - along * reaction).max() <= DEFAULT.cross_check * abs(along) * size:
        hint = f"; they differ by the factor {along:.6g}" + (" (wrong sign)" if along < 0 else "")
    raise ProblemError(
        f"{what}: expected the reactions of the condensed stiffness to {DEFAULT.cross_check:g}, found a "
        f"relative difference of {error:.2g}{hint}"
    )


def without_resistance(stiffness: FloatArray, motions: FloatArray) -> FloatArray:
    """A symmetric stiffness (k, k) without what it has against some motions (k, r), of any size.

    Examples
    --------
    >>> without_resistance(np.array([[1.0, -0.8], [-0.8, 1.0]]), np.array([[1.0], [1.0]])).round(12)
    array([[ 0.9, -0.9],
           [-0.9,  0.9]])
    """
    basis, size, _ = np.linalg.svd(motions, full_matrices=False)
    basis = basis[:, size > DEFAULT.printed_digits * size.max(initial=0.0)]
    left = stiffness - (stiffness @ basis) @ basis.T
    left = left - basis @ (basis.T @ left)
    return np.asarray(0.5 * (left + left.T))


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
