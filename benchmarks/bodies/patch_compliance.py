"""An elastic half-space under uniform tractions on polygons: forces of Boussinesq and Cerruti, integrated."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.constants import BLOCK, FloatArray

RULE = (1 / 6, 2 / 3)  # barycentric coordinates of the three points of a triangle that are exact for degree 2


def half_space_compliance(
    points: ArrayLike,  # (k, 2): where the displacements are asked for, on edges and corners too [length]
    # n of (c, 2): the corners of each polygon in turn, in either sense [length]
    patches: Sequence[ArrayLike],
    *,
    young: float = 1.0,  # young, poisson: of the half-space [force/length²], [–]
    poisson: float = 0.3,
) -> FloatArray:
    """Surface displacements of an elastic half-space by forces spread uniformly over polygons (3k, 3n).

    Love's problem with all three tractions, for any simple polygon and in closed form: the point forces of
    Boussinesq and Cerruti (Johnson, Contact Mechanics, 3.2 and 3.6) are powers of the distance, whose
    integrals over a polygon about a point are sums over its edges. x and y lie in the surface, z points
    into the half-space.

    Two bodies: their compliances add, where the second one's z, mirrored, changes the sign of what couples
    z to x and y. Bodies of the same material so have twice the compliance and no coupling.

    Returns
    -------
    (3k, 3n)
        Displacements (u_x, u_y, u_z) of every point by a unit force (x, y, z) on every patch [length/force].

    Examples
    --------
    Love's square: the centre of a unit square sinks by 4 ln(1 + √2) (1 − ν²) / π E under a unit force.

    >>> square = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
    >>> half_space_compliance([[0, 0]], [square], young=1.0, poisson=0.3).diagonal().round(5)
    array([1.24003, 1.24003, 1.0212 ])
    """
    where = np.asarray(points, dtype=float)
    corners, areas = _polygons(patches)
    first = np.concatenate(corners)
    last = np.concatenate([np.roll(polygon, -1, axis=0) for polygon in corners])
    begins = np.cumsum([0, *map(len, corners)])[:-1]
    rows = max(BLOCK // len(first), 1)  # a block of pairs of a point and an edge takes some 100 MB
    pieces = [
        _displacements(where[k : k + rows], first, last, begins, poisson) for k in range(0, len(where), rows)
    ]
    found = np.concatenate(pieces) * ((1 + poisson) / (np.pi * young)) / areas[:, None]
    return np.asarray(found.reshape(3 * len(where), -1))


def mean_half_space_compliance(
    patches: Sequence[ArrayLike],  # patches, young, poisson: as for :func:`half_space_compliance`
    *,
    young: float = 1.0,
    poisson: float = 0.3,
) -> FloatArray:
    """Mean displacements of polygons on an elastic half-space by forces spread uniformly over them (3n, 3n).

    What :func:`half_space_compliance` gives at points, averaged over every patch (three points in each
    triangle from its mean corner to an edge) and made reciprocal, that is, symmetric: forces times these
    displacements are the work of the tractions. A patch's own mean is up to 1 % too large, most of which its
    neighbours' make up for where they touch. Polygons are to be star-shaped about the mean of their corners.

    Examples
    --------
    >>> square = [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]]
    >>> beside = [[x + 1.0, y] for x, y in square]
    >>> mean_half_space_compliance([square, beside], poisson=0.5).shape
    (6, 6)
    """
    corners, _ = _polygons(patches)
    places = [_inside(polygon) for polygon in corners]
    at_points = half_space_compliance(
        np.concatenate([points for points, _ in places]), patches, young=young, poisson=poisson
    ).reshape(-1, 3, 3 * len(corners))
    weights = np.concatenate([weights for _, weights in places])
    begins = np.cumsum([0, *(len(points) for points, _ in places)])[:-1]
    found = np.add.reduceat(weights[:, None, None] * at_points, begins)
    whole = found.reshape(3 * len(corners), -1)
    return np.asarray(0.5 * (whole + whole.T))


def _polygons(patches: Sequence[ArrayLike]) -> tuple[list[FloatArray], FloatArray]:
    """Corners of every patch, counter-clockwise, and their areas (the shoelace formula)."""
    corners, areas = [], []
    for patch in patches:
        polygon = np.asarray(patch, dtype=float)
        x, y = (polygon - polygon[0]).T
        area = float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))
        corners.append(polygon if area > 0 else polygon[::-1])
        areas.append(abs(area))
    return corners, np.array(areas)


def _displacements(
    points: FloatArray, first: FloatArray, last: FloatArray, begins: NDArray[np.intp], poisson: float
) -> FloatArray:
    """2π G times the displacements by unit tractions (k, 3, n, 3)."""
    inverse, squared, toward = (np.add.reduceat(part, begins, axis=1) for part in _edges(points, first, last))
    found = np.zeros((len(points), 3, len(begins), 3))
    for a in range(2):
        found[:, a, :, a] = (1 - poisson) * inverse
        for b in range(2):
            found[:, a, :, b] += poisson * squared[..., a, b]
        found[:, a, :, 2] = (0.5 - poisson) * toward[..., a]
        found[:, 2, :, a] = -(0.5 - poisson) * toward[..., a]
    found[:, 2, :, 2] = (1 - poisson) * inverse
    return found


def _edges(points: FloatArray, first: FloatArray, last: FloatArray) -> tuple[FloatArray, ...]:
    """Each edge's share in the integrals of 1/r, r_a r_b/r³ and r_a/r², r from a point to the polygon.

    With r = d n + s t, d the distance of the edge's line and s the way along it, the area that ds subtends is
    d ds / 2: what is homogeneous of degree −1 leaves d ∫ ds of itself.
    """
    along = last - first
    t = along / np.hypot(*along.T)[:, None]
    n = np.column_stack([t[:, 1], -t[:, 0]])
    here, there = first - points[:, None], last - points[:, None]
    d = np.sum(here * n, axis=2)
    ends = [(np.sum(at * t, axis=2), np.hypot(at[..., 0], at[..., 1])) for at in (here, there)]
    (s0, r0), (s1, r1) = ends
    beside = d != 0  # an edge whose line runs through the point subtends nothing
    safe = np.where(beside, np.abs(d), 1.0)
    log = np.arcsinh(s1 / safe) - np.arcsinh(s0 / safe)
    r0, r1 = np.where(beside, r0, 1.0), np.where(beside, r1, 1.0)
    sine, cosine = s1 / r1 - s0 / r0, d / r1 - d / r0
    angle = np.arctan(s1 / safe) - np.arctan(s0 / safe)
    nn, tt, nt = (n[:, :, None] * n[:, None], t[:, :, None] * t[:, None], n[:, :, None] * t[:, None])
    nt = nt + np.swapaxes(nt, 1, 2)
    inverse = d * log
    squared = d[..., None, None] * (
        sine[..., None, None] * nn - cosine[..., None, None] * nt + (log - sine)[..., None, None] * tt
    )
    toward = np.abs(d)[..., None] * angle[..., None] * n + (d * np.log(r1 / r0))[..., None] * t
    return inverse, squared, toward


def _inside(polygon: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Points in a polygon and their weights, exact for means of quadratic functions."""
    centre, near, far = polygon.mean(axis=0), polygon, np.roll(polygon, -1, axis=0)
    a, b = near - centre, far - centre
    share = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    little, much = RULE
    points = [little * u + little * v + much * w for u, v, w in ((a, b, 0 * a), (0 * a, a, b), (b, 0 * a, a))]
    return centre + np.concatenate(points), np.tile(share / (3 * share.sum()), 3)
