"""The nodes of a problem in the model it was made from: areas, directions, faces."""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import wrong_key
from shakedown.ground.tolerances import DEFAULT

NONE = -1  # in the last column of a triangle


def checked_faces(numbers: FloatArray, n: int) -> IntArray | None:
    """Corners of faces (k, 4) as whole numbers; None where there is no face.

    Raises
    ------
    ProblemError
        If a corner is no node, or a face has one twice.

    Examples
    --------
    >>> checked_faces(np.array([[0.0, 1.0, 2.0, -1.0]]), 3)
    array([[ 0,  1,  2, -1]])
    """
    least = np.array([0, 0, 0, NONE])
    wrong = np.argwhere(~((numbers >= least) & (numbers < n) & (numbers == np.round(numbers))))
    if wrong.size:
        k, corner = wrong[0]
        expected = f"numbers of nodes from 0 to {n - 1} (−1 as the last of a triangle)"
        raise wrong_key("faces", expected, f"{numbers[k, corner]:g} at faces[{k}][{corner}]")
    faces = numbers.astype(np.intp)
    ordered = np.sort(faces, axis=1)
    twice = np.flatnonzero((ordered[:, 1:] == ordered[:, :-1]).any(axis=1))
    if twice.size:
        raise wrong_key("faces", "corners that differ", f"{faces[twice[0]].tolist()} as face {twice[0]}")
    return faces if len(faces) else None


def faces_among(faces: NDArray[np.integer], nodes: Sequence[int]) -> IntArray | None:
    """The faces that have all their corners among some nodes, with the numbers of these in their order.

    Examples
    --------
    >>> faces_among(np.array([[0, 1, 2, -1], [1, 2, 3, -1]]), [3, 2, 1])
    array([[ 2,  1,  0, -1]])
    """
    number = np.full(max(int(faces.max()), *nodes, 0) + 2, NONE - 1)
    number[list(nodes)] = np.arange(len(nodes))
    number[NONE] = NONE
    found = number[faces]
    kept = found[(found >= NONE).all(axis=1)]
    return kept if len(kept) else None


def wound(faces: NDArray[np.integer], places: FloatArray, normals: FloatArray) -> IntArray:
    """Faces, each with its corners in the order in which they go around the normals there, (n, 3).

    Examples
    --------
    >>> places, up = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0]]), np.tile([0.0, 0, 1], (3, 1))
    >>> wound(np.array([[0, 2, 1, -1]]), places, up)
    array([[ 0,  1,  2, -1]])
    """
    first, second, third = (places[corner] for corner in faces.T[:3])
    across = np.cross(second - first, third - first)
    against = (across * normals[faces[:, 0]]).sum(axis=1) < 0
    turned = np.where(faces[:, 3:] == NONE, faces[:, [0, 2, 1, 3]], faces[:, [0, 3, 2, 1]])
    return np.where(against[:, None], turned, faces)


def split_face(corners: Sequence[int], others: Sequence[int], place: FloatArray) -> list[tuple[int, ...]]:
    """A face of an element as faces without nodes between their corners, four numbers each.

    Parameters
    ----------
    corners
        Three or four, in order around it.
    others
        Nodes on its sides, one each, and in its middle; or none.
    place : (c, 3)
        Where the corners and then the others are.

    Examples
    --------
    >>> square = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    >>> sides = np.array([[1.0, 0, 0], [2, 1, 0], [1, 2, 0], [0, 1, 0]])
    >>> split_face([3, 5, 7, 9], [4, 6, 8, 10], np.concatenate([square, sides]))[0]
    (3, 4, 10, -1)
    >>> split_face([3, 5, 7], [], square[:3])
    [(3, 5, 7, -1)]
    """
    c = len(corners)
    if len(others) < c:
        return [(*corners, NONE)[:4]]
    at, beside = place[:c], place[c:]
    middles = 0.5 * (at + np.roll(at, -1, axis=0))
    nearest = [int(np.linalg.norm(beside - middle, axis=1).argmin()) for middle in middles]
    sides = [others[k] for k in nearest]
    within = [node for node in others if node not in sides]
    if within:
        return [(corners[k], sides[k], within[0], sides[k - 1]) for k in range(c)]
    tips = [(corners[k], sides[k], sides[k - 1], NONE) for k in range(c)]
    return [*tips, (*sides, NONE)[:4]]


def strips(
    places: FloatArray, tangents: FloatArray, edges: Iterable[Sequence[int]] | None = None
) -> list[IntArray]:
    """The nodes of a plane contact, strip by strip, in order along it.

    Parameters
    ----------
    places, tangents : (n, 2) or (n, 3)
        Positions, and unit vectors towards which the order leads. A strip may turn by any angle.
    edges
        Nodes of every edge of the contact, in any order. Where they are not known, nodes are sorted along the
        mean tangent if all tangents lead that way, else each is followed by the nearest one ahead of it.

    Returns
    -------
    list of arrays
        A closed strip begins with its lowest number. Strips are sorted along the mean tangent, where there
        is one, else by their lowest numbers.

    Examples
    --------
    >>> around = np.array([[1.0, 0.0], [-0.5, -0.8], [-0.5, 0.8]])
    >>> ahead = np.array([[0.0, 1.0], [0.8, -0.5], [-0.8, -0.5]])
    >>> strips(around, ahead, [(0, 1), (1, 2), (2, 0)])[0].tolist()
    [0, 2, 1]
    """
    mean = tangents.sum(axis=0)
    if edges is None and (tangents @ mean > 0).all():
        return [np.argsort(places @ mean, kind="stable")]
    after = dict(_nearest_ahead(places, tangents)) if edges is None else dict[int, int]()
    for edge in (np.array(nodes, dtype=np.intp) for nodes in edges or ()):
        after |= pairwise(edge[np.argsort(places[edge] @ tangents[edge].sum(axis=0))].tolist())
    begins = sorted(set(range(len(places))).difference(after.values()))
    found, left = list[IntArray](), dict.fromkeys([*begins, *range(len(places))])
    while left:
        strip, node = [], next(iter(left))
        while node in left:
            del left[node]
            strip.append(node)
            node = after.get(node, node)
        found.append(np.array(strip))
    if np.linalg.norm(mean) <= SIX_DIGITS * len(places):
        return found
    at = np.array([places[strip].mean(axis=0) @ mean for strip in found])
    unit = float(np.linalg.norm(mean) * np.ptp(places, axis=0).max()) or 1.0
    return [found[k] for k in np.argsort(np.round(at / unit, 6), kind="stable")]


def _nearest_ahead(places: FloatArray, tangents: FloatArray) -> Iterable[tuple[int, int]]:
    """Pairs of nodes: the second is the nearest ahead of the first, the first the nearest behind it."""
    apart = places[None] - places[:, None]
    distance = np.linalg.norm(apart, axis=2)
    alike = tangents @ tangents.T > 0
    ahead, behind = (
        np.where(alike & (sign * np.einsum("ijc,ic->ij", apart, tangents) > distance / 2), distance, np.inf)
        for sign in (1, -1)
    )
    for node, (after, far) in enumerate(zip(ahead.argmin(axis=1), ahead.min(axis=1), strict=True)):
        if np.isfinite(far) and behind[after].argmin() == node:
            yield node, int(after)


def arc_lengths(places: FloatArray, tangents: FloatArray, found: Sequence[IntArray]) -> FloatArray:
    """Distances along strips from the first node, (n,) [length]; where they turn, strips lie well apart.

    Examples
    --------
    >>> arc_lengths(np.array([[0.0, 0.0], [3.0, 4.0], [3.0, 5.0]]), np.eye(3, 2), [np.arange(3)]).tolist()
    [0.0, 5.0, 6.0]
    """
    order, ends = np.concatenate(found), np.cumsum([len(strip) for strip in found])[:-1] - 1
    steps = np.linalg.norm(np.diff(places[order], axis=0), axis=1)
    if (np.ptp(tangents, axis=0) > SIX_DIGITS).any():
        # longest steps between strips: far enough to be told from the steps within one
        steps[ends] = np.maximum(steps[ends], 3.0 * np.delete(steps, ends).max(initial=0.0))
    x = np.empty(len(places))
    x[order] = np.append(0.0, np.cumsum(steps))
    return x


def without_cancelled(area: FloatArray) -> FloatArray:
    """Areas of nodes, (n,): 0 where shares of faces cancel and leave round-off, as at quadratic triangles.

    Examples
    --------
    >>> without_cancelled(np.array([-2e-18, 0.5, 1e-17])).tolist()
    [0.0, 0.5, 0.0]
    """
    # shares of a face that cancel leave round-off
    return np.where(np.abs(area) <= NEGLIGIBLE * np.abs(area).max(initial=0.0), 0.0, area)


def bearing_no_pressure(area: FloatArray, names: Sequence[str]) -> tuple[str, ...]:
    """A warning where nodes have no positive share of a pressure: corners of quadratic faces of solids.

    Examples
    --------
    >>> bearing_no_pressure(np.array([0.5, 0.5]), ["7", "8"])
    ()
    >>> bearing_no_pressure(np.array([0.5, 0.0, -0.1]), ["7", "8", "9"])[0][:61]
    'quadratic faces at the contact give 2 of 3 nodes, first 8, no'
    """
    without = np.flatnonzero(area <= 0)
    if not without.size:
        return ()
    return (
        f"quadratic faces at the contact give {without.size} of {len(area)} nodes, first "
        f"{names[without[0]]}, no or a negative share of a pressure, so that these open or slide at once: "
        "use linear elements there",
    )


def check_places(arrays: Mapping[str, FloatArray]) -> None:
    """Raise ``ProblemError`` unless areas and amplitudes are >= 0, directions perpendicular unit vectors."""
    for key, what, where in (("node_area", "areas", "node"), ("load_amplitude", "amplitudes", "load")):
        for j in np.flatnonzero(arrays.get(key, np.zeros(0)) < 0):
            raise wrong_key(key, f"{what} >= 0", f"{arrays[key][j]:.9g} at {where} {j}")
    given = [key for key in ("tangent", "tangents", "normal") if key in arrays]
    for key in given:
        length = np.linalg.norm(arrays[key], axis=-1)
        for place in map(tuple, np.argwhere(np.abs(length - 1) > DEFAULT.printed_digits)):
            raise wrong_key(key, "vectors of length 1", f"the length {length[place]:.9g} at node {place[0]}")
    if not given:
        return
    directions = np.concatenate([arrays[key].reshape(len(arrays["B"]), -1, 3) for key in given], axis=1)
    for first, second in combinations(np.moveaxis(directions, 1, 0), 2):
        slanted = np.abs(np.einsum("ij,ij->i", first, second))
        for j in np.flatnonzero(slanted > DEFAULT.printed_digits):
            expected = "directions at right angles to each other and to 'normal'"
            raise wrong_key(given[0], expected, f"the scalar product {slanted[j]:.9g} at node {j}")


def corners_of_hull(places: FloatArray) -> FloatArray:
    """Corners of the convex hull of points (k, 2); both ends where they lie on a line."""
    from scipy.spatial import ConvexHull, QhullError  # imported late, as it is only needed in space

    scaled = places - places[0]
    scaled /= np.abs(scaled).max() or 1.0
    try:
        return np.asarray(places[ConvexHull(scaled).vertices])
    except QhullError:
        along = scaled @ scaled[np.abs(scaled).sum(axis=1).argmax()]
        return np.array([places[along.argmin()], places[along.argmax()]])
