"""D and P of the dual mortar method: u₁ = (slip and gap) + P u₂, one row per node of the slave.

Results are at the nodes of one surface, the slave; the other one is the master. What a facet of the slave and
one of the master have in common, seen along the slave's normal, is a segment; it is cut exactly and has Gauss
points of its own. N are the shape functions of facets, N̂ those of the changed basis (``facet_shapes``).

u₁ and u₂ are the displacements of slave and master. The contact pressure is a sum of dual functions ψ_j of
the slave's nodes, with ∫ψ_j N̂_l = δ_jl D_j over what is covered of each facet, so that D is
diagonal and P explicit, P_jk = ∫ψ_j N_k / D_j. Σψ_j = 1: constant pressures are transmitted exactly.
"""

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import KDTree

from shakedown.ground.constants import NEGLIGIBLE, ROUND_OFF, THREE_DIGITS, FloatArray, IntArray
from shakedown.models.condensation.surface_mesh import (
    CORNERS,
    ContactSurface,
    FacetBlock,
    changed_shapes,
    local_places,
    shapes,
)

OPPOSED = np.cos(np.radians(120.0))  # largest cosine between the normals of facets that face each other
SLIVER = 1e-11  # relative to a facet: smaller segments are round-off
# Gauss points along each side of a triangle. Three are exact to degree 4, which is all that occurs on
# triangles and parallelograms. On other quadrilaterals local places are no polynomials: with (departure from
# a parallelogram, relative to the size, up to which; number of points) the error is 2e-15.
_POINTS = ((1e-12, 3), (0.1, 6), (0.2, 8), (np.inf, 12))
_QUADRATIC = 6  # least number on bi-quadratic quadrilaterals


@dataclass(frozen=True, eq=False)
class DualBasis:
    """Integrals over the segments of two surfaces.

    Attributes
    ----------
    nodes : (n,)
        Nodes of the slave that are covered, as positions in its labels.
    P : (n, m)
        Weights of the nodes of the master, in columns for all of its nodes; where facets meet, zeros are
        stored.
    near : (nnz,)
        Σ |∫N̂_j N_k| / D_j in the same places: how much both nodes have in common.
    area, whole : (n,)
        ∫N̂ over what is covered, and over all facets of the slave [length²].
    share : (F,)
        How much of every facet of the slave is covered; 0 where it is left out.
    found : (F,)
        How much of it lies below facets of the master, whether it is left out or not.
    distance : tuple of float
        Least, mean and largest distance of the facets [length].
    """

    nodes: IntArray
    P: sparse.csr_array
    near: FloatArray
    area: FloatArray
    whole: FloatArray
    share: FloatArray
    found: FloatArray
    distance: tuple[float, float, float]


class Segments(NamedTuple):
    """Integrals over the segments of pairs of facets.

    Columns are the nodes of a facet, as many as a facet of the surface has at most; those beyond are 0.

    Attributes
    ----------
    facets, others : (s,)
        Facets of the slave and of the master.
    weight : (s, l)
        ∫ N̂ over the segment, for the nodes of the facet of the slave.
    mass : (s, l, l)
        ∫ N̂ N̂ᵀ.
    across : (s, l, k)
        ∫ N̂ Nᵀ, N of the master.
    area, distance : (s,)
        Area of the segment, and how far apart the facets are there (mean) [length].
    """

    facets: IntArray
    others: IntArray
    weight: FloatArray
    mass: FloatArray
    across: FloatArray
    area: FloatArray
    distance: FloatArray


def dual_basis(
    slave: ContactSurface,
    master: ContactSurface,
    pairs: tuple[IntArray, IntArray],
    reach: float,
    *,
    revolved: bool = False,
) -> DualBasis | None:
    """Integrate over all pairs of facets; None where nothing is covered."""
    met = _segments(slave, master, pairs, reach, revolved)
    if met is None or not len(met.area):
        return None
    every = np.arange(len(slave.facets))
    itself = _segments(slave, slave, (every, every), np.inf, revolved)
    assert itself is not None
    weight, mass = (_summed(met.facets, each, len(every)) for each in (met.weight, met.mass))
    whole = _summed(itself.facets, itself.weight, len(every))
    share = _summed(met.facets, met.area, len(every)) / whole.sum(axis=1)
    full = _by_node(slave, whole)
    kept = _kept(slave, weight, full, share)
    area = _by_node(slave, weight * kept[:, None])
    nodes = np.flatnonzero(area > 0)
    own = kept[met.facets]
    across, dual = met.across[own], _dual(slave, weight, mass, kept)[met.facets[own]]
    row = np.broadcast_to(slave.nodes[met.facets[own]][:, :, None], across.shape).ravel()
    column = np.broadcast_to(master.nodes[met.others[own]][:, None, :], across.shape).ravel()
    P, near = (
        sparse.coo_array(
            (each.ravel(), (row, column)), shape=(len(slave.labels) + 1, len(master.labels) + 1)
        ).tocsr()[nodes][:, : len(master.labels)]
        for each in (np.einsum("sjl,slk->sjk", dual, across, optimize=True), np.abs(across))
    )
    for each in (P, near):
        each.data /= np.repeat(area[nodes], np.diff(each.indptr))
    P.data[np.abs(P.data) < ROUND_OFF] = 0.0
    apart = met.distance
    return DualBasis(
        nodes=nodes,
        P=P,
        near=near.data,
        area=area[nodes],
        whole=full[nodes],
        share=share * kept,
        found=share,
        distance=(float(apart.min()), float(apart @ met.area / met.area.sum()), float(apart.max())),
    )


def _kept(
    slave: ContactSurface, weight: FloatArray, full: FloatArray, share: FloatArray
) -> NDArray[np.bool_]:
    """Facets that are covered so far that each of their nodes can bear a pressure, (F,).

    Where less than a thousandth of a facet is covered, or of what a node has without the edge of the master
    (``full``), ψ is not determined by what is covered: the mass matrix is singular but for round-off.
    """
    kept = share >= THREE_DIGITS
    while True:
        area = _by_node(slave, weight * kept[:, None])
        weak = np.append((area < THREE_DIGITS * full) & (area != 0), False)
        out = kept & weak[slave.nodes].any(axis=1) & (share < 1 - THREE_DIGITS)
        if not out.any():
            return kept
        kept &= ~out


def _dual(slave: ContactSurface, weight: FloatArray, mass: FloatArray, kept: NDArray[np.bool_]) -> FloatArray:
    """A with ψ = A N̂ on every facet, (F, k, k): diag(∫N̂) (∫N̂ N̂ᵀ)⁻¹; 0 for facets that are left out."""
    found = np.zeros_like(mass)
    size = mass[kept].trace(axis1=1, axis2=2)[:, None, None]
    none = np.eye(mass.shape[1]) * (slave.nodes[kept] == len(slave.labels))[:, None, :]
    found[kept] = weight[kept][:, :, None] * np.linalg.inv(mass[kept] / size + none) / size
    return found


def _summed(facets: IntArray, values: FloatArray, count: int) -> FloatArray:
    """Sums over the segments of every facet, (F, …)."""
    total = np.zeros((count, *values.shape[1:]))
    np.add.at(total, facets, values)
    return total


def _by_node(surface: ContactSurface, values: FloatArray) -> FloatArray:
    """Sums over the facets at every node, (n,), of values (F, k)."""
    total = np.zeros(len(surface.labels) + 1)
    np.add.at(total, surface.nodes, values)
    return total[:-1]


def facet_pairs(slave: ContactSurface, master: ContactSurface, reach: float) -> tuple[IntArray, IntArray]:
    """Pairs (facet of the slave, facet of the master) whose bounding circles come nearer than ``reach``."""
    tree = KDTree(master.middles)
    near = tree.query_ball_point(
        slave.middles, (1.0 + NEGLIGIBLE) * (slave.radii + master.radii.max() + reach)
    )
    count = np.array([len(found) for found in near])
    one = np.repeat(np.arange(len(near)), count)
    other = np.concatenate([np.array(found, dtype=np.intp) for found in near])
    apart = np.linalg.norm(slave.middles[one] - master.middles[other], axis=1)
    kept = apart <= (1.0 + NEGLIGIBLE) * (slave.radii[one] + master.radii[other] + reach)
    kept &= (slave.normals[one] * master.normals[other]).sum(axis=1) < OPPOSED
    return one[kept], other[kept]


def _segments(
    slave: ContactSurface,
    master: ContactSurface,
    pairs: tuple[IntArray, IntArray],
    reach: float,
    revolved: bool,
) -> Segments | None:
    """Cut pairs of facets after a projection along the normals of the slave's; None without any pair."""
    found = []
    for one, other in product(slave.blocks, master.blocks):
        own = np.isin(pairs[0], one.numbers) & np.isin(pairs[1], other.numbers)
        if own.any():
            chosen = pairs[0][own], pairs[1][own]
            found.append(_cut((slave, master), (one, other), chosen, reach, revolved))
    return Segments(*map(np.concatenate, zip(*found, strict=True))) if found else None


def _cut(
    sides: tuple[ContactSurface, ContactSurface],
    blocks: tuple[FacetBlock, FacetBlock],
    pairs: tuple[IntArray, IntArray],
    reach: float,
    revolved: bool,
) -> Segments:
    """The segments of pairs of facets of two kinds."""
    seen = [_seen(sides, blocks, pairs, k) for k in (0, 1)]
    cut = _on_lines if sides[0].dimension == 2 else _on_planes
    owner, points, weight = cut(seen[0][0], seen[1][0], _points_along(seen, blocks))
    values, heights = [], []
    for side, (corners, height) in enumerate(seen):
        place, kind = _local(corners[owner], points), blocks[side].kind
        own = (changed_shapes, shapes)[side](kind, place)
        beyond = sides[side].nodes.shape[1] - kind[1]
        values.append(np.pad(own, ((0, 0), (0, 0), (0, beyond))))
        straight = shapes((kind[0], CORNERS[kind]), place)
        heights.append(np.einsum("sgc,sc->sg", straight, height[owner]))
    if revolved:
        radius = sides[0].places[sides[0].nodes[pairs[0]][:, :2], 0][owner]
        ends = shapes((2, 2), _local(seen[0][0][owner], points))
        weight = weight * 2 * np.pi * np.einsum("sgc,sc->sg", ends, radius)
    apart = heights[0] - heights[1]
    area = weight.sum(axis=1)
    near = (area > 0) & (np.abs((weight * apart).sum(axis=1)) <= reach * area)
    of_slave, of_master = (found[near] for found in values)
    weight, owner, area = weight[near], owner[near], area[near]
    return Segments(
        facets=pairs[0][owner],
        others=pairs[1][owner],
        weight=np.einsum("sg,sgl->sl", weight, of_slave),
        mass=np.einsum("sg,sgl,sgm->slm", weight, of_slave, of_slave, optimize=True),
        across=np.einsum("sg,sgl,sgk->slk", weight, of_slave, of_master, optimize=True),
        area=area,
        distance=(weight * apart[near]).sum(axis=1) / area,
    )


def _seen(
    sides: tuple[ContactSurface, ContactSurface],
    blocks: tuple[FacetBlock, FacetBlock],
    pairs: tuple[IntArray, IntArray],
    side: int,
) -> tuple[FloatArray, FloatArray]:
    """Corners of one side's facets as places on the slave's, (p, c, d - 1), and heights above it, (p, c).

    Heights are positive towards the slave's body.
    """
    slave, nodes = sides[0], sides[side].nodes[pairs[side]][:, : CORNERS[blocks[side].kind]]
    middle, normal = slave.middles[pairs[0]], slave.normals[pairs[0]]
    arms = sides[side].places[nodes] - middle[:, None]
    if slave.dimension == 2:
        axes = np.column_stack([normal[:, 1], -normal[:, 0]])[:, None]
    else:
        start, end = slave.places[slave.nodes[pairs[0]][:, :2]].swapaxes(0, 1)
        edge = end - start
        first = edge - (edge * normal).sum(axis=1)[:, None] * normal
        first /= np.linalg.norm(first, axis=1)[:, None]
        axes = np.stack([first, np.cross(normal, first)], axis=1)
    return np.einsum("pcd,pad->pca", arms, axes), np.einsum("pcd,pd->pc", arms, normal)


def _points_along(seen: list[tuple[FloatArray, FloatArray]], blocks: tuple[FacetBlock, FacetBlock]) -> int:
    slant = 0.0
    for corners, _ in seen:
        if corners.shape[1] == 4:
            off = np.abs(corners[:, 0] - corners[:, 1] + corners[:, 2] - corners[:, 3]).max(axis=1)
            slant = max(slant, float((off / np.ptp(corners, axis=1).max(axis=1)).max(initial=0.0)))
    least = _QUADRATIC if any(block.kind in ((3, 8), (3, 9)) for block in blocks) else 0
    return max(least, next(count for most, count in _POINTS if slant <= most))


def _local(corners: FloatArray, points: FloatArray) -> FloatArray:
    if corners.shape[1] == 2:
        low, high = corners[:, :1], corners[:, 1:]
        return np.asarray((2 * points - low - high) / (high - low))
    return local_places(corners, points)


def _on_lines(slave: FloatArray, master: FloatArray, count: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Pairs that overlap, points (s, g, 1) and weights (s, g)."""
    low = np.maximum(slave.min(axis=1), master.min(axis=1))[:, 0]
    high = np.minimum(slave.max(axis=1), master.max(axis=1))[:, 0]
    owner = np.flatnonzero(high - low > SLIVER * np.ptp(slave, axis=1)[:, 0])
    place, weight = np.polynomial.legendre.leggauss(count)
    half = 0.5 * (high - low)[owner, None]
    middle = 0.5 * (high + low)[owner, None]
    return owner, (middle + half * place)[..., None], half * weight


def _on_planes(slave: FloatArray, master: FloatArray, count: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """What pairs of convex polygons have in common, in triangles: pairs, points (s, g, 2), weights (s, g)."""
    slave, master = _counter_clockwise(slave), _counter_clockwise(master)
    polygon = master
    for k in range(slave.shape[1]):
        polygon = _clipped(polygon, slave[:, k], slave[:, (k + 1) % slave.shape[1]])
    fans = np.stack(
        [np.broadcast_to(polygon[:, :1], polygon[:, 2:].shape), polygon[:, 1:-1], polygon[:, 2:]], axis=2
    )
    twice = _cross(fans[:, :, 1] - fans[:, :, 0], fans[:, :, 2] - fans[:, :, 0])
    whole = np.abs(_cross(slave[:, 2] - slave[:, 0], slave[:, -1] - slave[:, 1]))[:, None]
    owner, number = np.nonzero(twice > SLIVER * whole)
    chosen, twice = fans[owner, number], twice[owner, number]
    place, weight = np.polynomial.legendre.leggauss(count)
    s, t = (axis.ravel() for axis in np.meshgrid((1 + place) / 2, (1 + place) / 2, indexing="ij"))
    shares = np.column_stack([1 - s, s * (1 - t), s * t])  # the square, with one side drawn together
    return (
        owner,
        np.einsum("gc,scd->sgd", shares, chosen),
        twice[:, None] * (np.outer(weight, weight).ravel() / 4 * s),
    )


def _counter_clockwise(polygon: FloatArray) -> FloatArray:
    turned = _cross(polygon[:, 1] - polygon[:, 0], polygon[:, -1] - polygon[:, 0]) < 0
    return np.where(turned[:, None, None], polygon[:, ::-1], polygon)


def _clipped(polygon: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """The part of each polygon left of a line, with one corner more than before; corners may coincide."""
    after = np.roll(polygon, -1, axis=1)
    own, next_ = (_cross((end - start)[:, None], corner - start[:, None]) for corner in (polygon, after))
    crossing = (own < 0) != (next_ < 0)
    share = np.where(crossing, own, 0.0) / np.where(crossing, own - next_, 1.0)
    cut = polygon + share[..., None] * (after - polygon)
    n, v = own.shape
    corners = np.stack([polygon, cut], axis=2).reshape(n, 2 * v, 2)
    kept = np.stack([own >= 0, crossing], axis=2).reshape(n, 2 * v)
    order = np.argsort(~kept, axis=1, kind="stable")[:, : v + 1]
    last = np.maximum(np.minimum(kept.sum(axis=1), v + 1) - 1, 0)
    order = np.where(
        np.arange(v + 1) <= last[:, None], order, np.take_along_axis(order, last[:, None], axis=1)
    )
    return np.take_along_axis(corners, order[..., None], axis=1)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
