"""Two tangents at every node of a contact in space, from its normals and what else is given."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, THREE_DIGITS
from shakedown.ground.tolerances import DEFAULT

STEEP = 0.2  # sine of the angle between an axis and a normal below which the axis gives no tangent there


def tangent_pairs(normals: FloatArray, tangent: ArrayLike | None = None) -> FloatArray:
    """A pair of unit tangents for every unit normal, t₁ × t₂ = n.

    t₁ is a given direction less its part along the normal, t₂ = n × t₁. Where no direction is given, one of
    the axes x, y, z is taken for all nodes: the one that lies least along their normals (the first of several
    alike). Nodes whose normal points along that axis take the axis that lies least along their own.

    Parameters
    ----------
    normals : (n, 3)
        Unit normals [–].
    tangent : (3,) or (n, 3) or (n, 2, 3), optional
        The direction towards which t₁ points, one for all or one per node; or the pairs themselves, of which
        the second says on which side t₂ is.

    Returns
    -------
    (n, 2, 3)

    Raises
    ------
    ProblemError
        If a tangent leads along its normal, or the shape is another.

    Examples
    --------
    >>> tangent_pairs(np.array([[0.0, 0.0, 1.0]])).tolist()
    [[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]
    >>> tangent_pairs(np.array([[0.0, 0.0, 1.0]]), [0.0, 2.0, 5.0]).tolist()
    [[[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]]]
    """
    if tangent is None:
        return _completed(normals, _by_axes(normals))
    given = np.asarray(tangent, dtype=np.float64)
    n = len(normals)
    if given.shape not in ((3,), (n, 3), (n, 2, 3)):
        raise ProblemError(f"tangent: expected shape (3,), ({n}, 3) or ({n}, 2, 3), found {given.shape}")
    towards = np.broadcast_to(given, (n, 3)) if given.ndim < 3 else given[:, 0]
    size = np.linalg.norm(towards, axis=1)
    across = np.linalg.norm(np.cross(normals, towards), axis=1)
    wrong = ~(np.isfinite(size) & (across > DEFAULT.printed_digits * size))
    if wrong.any():
        j = int(np.argmax(wrong))
        raise ProblemError(
            f"tangent: expected a finite direction across the normal {normals[j].round(6).tolist()}, found "
            f"{towards[j].tolist()} at node {j}"
        )
    pairs = _completed(normals, towards)
    return pairs if given.ndim < 3 else _sided(pairs, given[:, 1])


def patch_positions(places: FloatArray, normals: FloatArray, tangent: ArrayLike | None = None) -> FloatArray:
    """Positions of nodes on the plane of a flat patch along its tangents, (n, 2); on a curved one (n, 3).

    Examples
    --------
    >>> places, up = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 3.0]]), np.array([[0.0, 0.0, 1.0]] * 2)
    >>> patch_positions(places, up).tolist()
    [[1.0, 2.0], [4.0, 5.0]]
    """
    mean = normals.mean(axis=0)
    # unit normals of a flat patch may differ from their mean by as much
    if (np.abs(normals - mean) > THREE_DIGITS).any():
        return places
    towards = None if tangent is None else np.asarray(tangent, dtype=np.float64).reshape(-1, 3)[0]
    return np.asarray(places @ tangent_pairs((mean / np.linalg.norm(mean))[None], towards)[0].T)


def guided_pairs(normals: FloatArray, pairs: FloatArray, held: NDArray[np.bool_]) -> FloatArray:
    """The pairs, with a tangent along the direction in which a node is held, (n, 3), if it had none there."""
    found = pairs.copy()
    for j in np.flatnonzero(held.any(axis=1)):
        axis = np.eye(3)[int(np.argmax(held[j]))]
        if np.abs(pairs[j] @ axis).max() < 1.0 - DEFAULT.symmetry:
            found[j] = _completed(normals[j : j + 1], axis[None])[0]
    return found


def _by_axes(normals: FloatArray) -> FloatArray:
    """The axis towards which t₁ points at every node, (n, 3)."""
    along = normals**2
    everywhere = _least(along.mean(axis=0, keepdims=True))[0]
    steep = along[:, everywhere] > 1.0 - STEEP**2
    return np.eye(3)[np.where(steep, _least(along), everywhere)]


def _least(along: FloatArray) -> NDArray[np.intp]:
    """The column with the least number of every row, the first of those that are equal to round-off."""
    return np.argmax(along <= along.min(axis=1, keepdims=True) + NEGLIGIBLE, axis=1)


def _completed(normals: FloatArray, towards: FloatArray) -> FloatArray:
    first = towards - (towards * normals).sum(axis=1)[:, None] * normals
    first /= np.linalg.norm(first, axis=1)[:, None]
    first -= (first * normals).sum(axis=1)[:, None] * normals  # what round-off has left
    first /= np.linalg.norm(first, axis=1)[:, None]
    return np.stack([first, np.cross(normals, first)], axis=1) + 0.0  # no -0.0


def _sided(pairs: FloatArray, second: FloatArray) -> FloatArray:
    """The pairs with t₂ on the side of given second tangents."""
    pairs[:, 1] *= np.where((pairs[:, 1] * second).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    return pairs
