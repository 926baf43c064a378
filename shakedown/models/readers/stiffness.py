"""A stiffness matrix with the node and direction of each of its rows."""

import itertools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from shakedown.ground.constants import ROUND_OFF, FloatArray, IntArray, Mask
from shakedown.ground.errors import ProblemError
from shakedown.models.condensation.contact_frame import checked_dofs
from shakedown.models.condensation.stiffness_checks import coupled_nodes
from shakedown.models.readers.parsing import rows_of_numbers, unfit, whole_numbers

Rows = str | os.PathLike[str] | IntArray | None  # a map file, its content, or none


@dataclass(frozen=True, eq=False)
class Stiffness:
    """What a reader returns.

    Attributes
    ----------
    K : (N, N) sparse
        Stiffness, both triangles [force/length].
    dofs : (N, 2)
        Node label and direction of every row.
    format : str
        What the file was found to be.
    superelement : bool
        Whether the format says that the matrix is already condensed.
    circumference : float
        What the matrix of an axisymmetric model was multiplied by, so that it stands for the
        whole circumference.
    accuracy : float, optional
        Relative accuracy of the entries where the format prints few digits: 1e-7 for seven.
    """

    K: sparse.csr_array
    dofs: IntArray
    format: str
    superelement: bool = False
    circumference: float = 1.0
    accuracy: float | None = None

    @property
    def are_displacements(self) -> Mask:
        """Which rows are displacements or rotations of a node, (N,); others are modes, pressures …"""
        return (self.dofs[:, 0] > 0) & np.isin(self.dofs[:, 1], range(1, 7))

    def rows(self, keys: ArrayLike) -> IntArray:
        """Rows of (node, direction) pairs, (k,); ``ProblemError`` names the first that has none."""
        index, found = self._row_of, []
        for node, direction in np.asarray(keys, dtype=np.intp).reshape(-1, 2).tolist():
            if (node, direction) not in index:
                raise ProblemError(f"expected a row for direction {direction} of node {node}, found none")
            found.append(index[node, direction])
        return np.array(found, dtype=np.intp)

    @cached_property
    def _row_of(self) -> dict[tuple[int, int], int]:
        """The row of every (node, direction)."""
        return {(node, direction): k for k, (node, direction) in enumerate(self.dofs.tolist())}

    @cached_property
    def parts(self) -> IntArray:
        """The number of the connected part that every row belongs to, (N,); the rows of a node stay together.

        It is −1 for rows that couple with no displacement, as component modes do not in a superelement with a
        fixed boundary.
        """
        coupled, node = coupled_nodes(self.K, self.dofs[:, 0])
        part = np.asarray(connected_components(coupled, directed=False)[1])[node]
        return np.where(np.isin(part, part[self.are_displacements]), part, -1)

    @cached_property
    def part_of(self) -> dict[int, int]:
        """The part (:attr:`parts`) that every node belongs to, by its label."""
        return dict(zip(self.dofs[:, 0].tolist(), self.parts.tolist(), strict=True))

    def in_basic_directions(self, frames: Mapping[int, FloatArray]) -> "Stiffness":
        """The stiffness with all displacements in the directions x, y, z of the model.

        Parameters
        ----------
        frames
            For nodes whose rows belong to directions of their own, the (3, 3)
            matrix R with u_own = R u; rotations turn alike.

        Raises
        ------
        ProblemError
            If such a node lacks a row, so that it cannot be turned.
        """
        turned = [int(node) for node in dict.fromkeys(self.dofs[:, 0].tolist()) if node in frames]
        if not turned:
            return self
        T = sparse.eye_array(len(self.dofs), format="lil")
        for node, first in itertools.product(turned, (1, 4)):
            own = (self.dofs[:, 0] == node) & np.isin(self.dofs[:, 1], range(first, first + 3))
            rows = np.flatnonzero(own)[np.argsort(self.dofs[own, 1])]
            if len(rows) in (1, 2):
                raise ProblemError(
                    f"expected all rows of node {node}, whose directions are not those of the model, "
                    f"found {len(rows)} of 3 from direction {first} on"
                )
            if len(rows):
                T[np.ix_(rows, rows)] = frames[node]
        T = T.tocsr()
        return replace(self, K=(T.T @ self.K @ T).tocsr())


def from_entries(rows: IntArray, columns: IntArray, values: FloatArray, where: str, format: str) -> Stiffness:
    """A stiffness from labelled entries of one triangle or of both.

    Parameters
    ----------
    rows, columns : (k, 2)
        (node, direction) of the row and of the column of every entry.
    values : (k,)
        Entries [force/length].
    where
        The file, for messages.

    Raises
    ------
    ProblemError
        If an entry occurs twice.

    Examples
    --------
    >>> import numpy as np
    >>> lower = np.array([(1, 1), (2, 1), (2, 1)]), np.array([(1, 1), (1, 1), (2, 1)])
    >>> from_entries(*lower, np.array([2.0, -1.0, 3.0]), "a file", "labelled entries").K.toarray()
    array([[ 2., -1.],
           [-1.,  3.]])
    """
    dofs, index = np.unique(np.vstack([rows, columns]), axis=0, return_inverse=True)
    i, j = np.split(index.ravel(), 2)
    N = len(dofs)
    check_entries_once(i, j, where, list(map(tuple, dofs.tolist())))
    K = completed(sparse.coo_array((values, (i, j)), shape=(N, N)))
    return Stiffness(K, checked_dofs(dofs), format, accuracy=printed_accuracy(values))


def check_entries_once(i: IntArray, j: IntArray, where: str, names: Sequence[object] | None = None) -> None:
    """Raise ``ProblemError`` if an entry (i, j), counted from 0, occurs twice; the message counts from 1.

    With ``names`` of the rows it names them.
    """
    width = int(j.max(initial=0)) + 1
    place, count = np.unique(i * width + j, return_counts=True)
    if len(place) < len(i):
        twice = divmod(int(place[np.argmax(count > 1)]), width)
        row, column = (k + 1 if names is None else names[k] for k in twice)
        raise unfit(where, "every entry once", f"row {row}, column {column} twice")


def numbered_entries(
    lines: Iterable[tuple[int, str]], size: Callable[[int], int], name: str, hint: str = ""
) -> sparse.coo_array:
    """The matrix of lines 'row column value', numbered from 1, of ``size(largest number)`` rows.

    Raises
    ------
    ProblemError
        If a line is malformed, a number lies outside, or an entry occurs twice.
    """
    places, table = rows_of_numbers(lines, 3, name, f"'row column value'{hint}")
    index = whole_numbers(table[:, :2], places, name)
    N = size(max(int(index.max(initial=1)), 1))
    wrong = (index < 1) | (index > N)
    if wrong.any():
        k = int(np.argmax(wrong.any(axis=1)))
        found = index[k][wrong[k]][0]
        raise unfit(f"{name}: line {places[k]}", f"row and column numbers 1 to {N}", found)
    i, j = index.T - 1
    check_entries_once(i, j, name)
    return sparse.coo_array((table[:, 2], (i, j)), shape=(N, N))


def completed(half: sparse.coo_array) -> sparse.csr_array:
    """Both triangles of a symmetric matrix of which one entry of each mirrored pair is stored.

    A matrix in which some off-diagonal entry has its mirror image stored is
    taken as it is.
    """
    i, j = half.coords
    off = i != j
    one_triangle = (i >= j).all() or (i <= j).all()
    size = half.shape[0]
    if not one_triangle and np.isin(i[off] * size + j[off], j[off] * size + i[off]).any():
        return half.tocsr()
    mirror = sparse.coo_array((half.data[off], (j[off], i[off])), shape=half.shape)
    return (half + mirror).tocsr()


def checked(matrix: sparse.sparray, dofs: IntArray, format: str) -> Stiffness:
    """A stiffness of a matrix and its map, which must have as many rows and none of them twice."""
    K = sparse.csr_array(matrix, dtype=float)
    return Stiffness(K, checked_dofs(dofs), format, accuracy=printed_accuracy(K.data))


def printed_accuracy(values: FloatArray) -> float | None:
    """10⁻ᵈ where numbers were printed with d significant digits, and d is less than what floats have.

    None where so few digits are enough for all of them that they are round numbers, exact as they are.

    Examples
    --------
    >>> printed_accuracy(np.array([1.234567, -0.07654321, 4.2e5])), printed_accuracy(np.array([1 / 3, 2.0]))
    (1e-07, None)
    """
    fewest, most = 5, 10  # digits: of fewer numbers are round, and exact; of more as good as floats
    size = np.abs(values[values != 0][:20000])  # so many are examined
    if not size.size:
        return None
    mantissa = size / 10.0 ** np.floor(np.log10(size))
    for digits in range(1, most + 1):
        printed = np.round(mantissa, digits - 1)
        # round-off of a decimal number between 1 and 10, scaled
        if np.all(np.abs(printed - mantissa) <= ROUND_OFF):
            return 10.0**-digits if digits >= fewest else None
    return None
