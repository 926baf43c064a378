"""The coupling of two surfaces whose meshes do not match, by the dual mortar method: u₁ = (slip, gap) + P u₂.

Results are at the nodes of one surface, the slave; the other one is the master. What a facet of the slave and
one of the master have in common, seen along the slave's normal, is a segment; it is cut exactly and has Gauss
points of its own. N are the shape functions of facets, N̂ those of the changed basis (``surface_mesh``).

u₁ and u₂ are the displacements of slave and master. The contact pressure is a sum of dual functions ψ_j of
the slave's nodes, with ∫ψ_j N̂_l = δ_jl D_j over what is covered of each facet, so that D is
diagonal and P explicit, P_jk = ∫ψ_j N_k / D_j. Σψ_j = 1: constant pressures are transmitted exactly.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.spatial import KDTree

from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import NEGLIGIBLE, ROUND_OFF, SIX_DIGITS, THREE_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.models.condensation import surface_mesh
from shakedown.models.condensation.surface_mesh import ContactSurface, NodeCoupling

Kind = tuple[int, int]  # of facets: dimension, count of nodes


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
    slave: ContactSurface, met: Segments, *, revolved: bool = False
) -> tuple[IntArray, FloatArray, FloatArray, FloatArray]:
    """What the segments make of the slave, by the dual basis ψ on its facets.

    Returns
    -------
    nodes : (n,)
        Nodes of the slave that are covered, as positions in its labels.
    area : (n,)
        ∫N̂ over what is covered [length²].
    share : (F,)
        How much of every facet is covered; 0 where it is left out.
    dual : (F, k, k)
        A with ψ = A N̂; 0 for facets that are left out.

    Raises
    ------
    ProblemError
        If nothing is left, or something is covered twice.
    """
    every = np.arange(len(slave.facets))
    itself = _segments(slave, slave, (every, every), np.inf, revolved)
    assert itself is not None
    weight, mass = (_summed(met.facets, each, len(every)) for each in (met.weight, met.mass))
    whole = _summed(itself.facets, itself.weight, len(every))
    share = _summed(met.facets, met.area, len(every)) / whole.sum(axis=1)
    kept = _kept(slave, weight, _by_node(slave, whole), share)
    area = _by_node(slave, weight * kept[:, None])
    nodes = np.flatnonzero(area > 0)
    if not len(nodes):
        raise ProblemError(
            "surfaces: expected facets of the first with a part of the second below every node, found at "
            f"most {100 * share.max():.2g} % of one covered; name the second first"
        )
    if share.max() > 1.0 + SIX_DIGITS:
        worst = slave.facets[int(np.argmax(share))]
        raise ProblemError(
            f"surfaces: expected facets of the master side by side, found {share.max():.3g} times the "
            f"slave's facet {worst} below them: do they lie in two layers? (a smaller 'reach')"
        )
    dual = np.zeros_like(mass)  # diag(∫N̂) (∫N̂ N̂ᵀ)⁻¹
    size = mass[kept].trace(axis1=1, axis2=2)[:, None, None]
    none = np.eye(mass.shape[1]) * (slave.nodes[kept] == len(slave.labels))[:, None, :]
    dual[kept] = weight[kept][:, :, None] * np.linalg.inv(mass[kept] / size + none) / size
    return nodes, area[nodes], share * kept, dual


def weights(
    sides: tuple[ContactSurface, ContactSurface],
    met: Segments,
    nodes: IntArray,
    area: FloatArray,
    dual: FloatArray,
) -> tuple[sparse.csr_array, FloatArray]:
    """Weights ∫ψ_j N_k / D_j of covered nodes of the slave and all of the master, (n, m).

    Where facets meet, zeros are stored. And in the same places, (nnz,), how much both nodes have in common,
    Σ |∫N̂_j N_k| / D_j.
    """
    own, (slave, master) = dual[met.facets].any(axis=(1, 2)), sides
    across = met.across[own]
    row = np.broadcast_to(slave.nodes[met.facets[own]][:, :, None], across.shape).ravel()
    column = np.broadcast_to(master.nodes[met.others[own]][:, None, :], across.shape).ravel()
    shape = len(slave.labels) + 1, len(master.labels) + 1
    every = np.einsum("sjl,slk->sjk", dual[met.facets[own]], across, optimize=True), np.abs(across)
    P, near = (
        sparse.coo_array((each.ravel(), (row, column)), shape=shape).tocsr()[nodes][:, : len(master.labels)]
        for each in every
    )
    for each in (P, near):
        each.data /= np.repeat(area, np.diff(each.indptr))
    P.data[np.abs(P.data) < ROUND_OFF] = 0.0
    return P, near.data


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
    kept &= (slave.normals[one] * master.normals[other]).sum(axis=1) < np.cos(np.radians(120.0))
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
    for (one, _, of_one), (other, _, of_other) in product(slave.blocks, master.blocks):
        own = np.isin(pairs[0], of_one) & np.isin(pairs[1], of_other)
        if own.any():
            chosen = pairs[0][own], pairs[1][own]
            found.append(_cut((slave, master), (one, other), chosen, reach, revolved))
    return Segments(*map(np.concatenate, zip(*found, strict=True))) if found else None


def _cut(
    sides: tuple[ContactSurface, ContactSurface],
    kinds: tuple[Kind, Kind],
    pairs: tuple[IntArray, IntArray],
    reach: float,
    revolved: bool,
) -> Segments:
    """The segments of pairs of facets of two kinds."""
    seen = [_seen(sides, kinds, pairs, k) for k in (0, 1)]
    cut = _on_lines if sides[0].dimension == 2 else _on_planes
    owner, points, weight = cut(seen[0][0], seen[1][0], _points_along(seen, kinds))
    values, heights = [], []
    for side, (corners, height) in enumerate(seen):
        place, kind = surface_mesh.local_places(corners[owner], points), kinds[side]
        own = (surface_mesh.changed_shapes, surface_mesh.shapes)[side](kind, place)
        beyond = sides[side].nodes.shape[1] - kind[1]
        values.append(np.pad(own, ((0, 0), (0, 0), (0, beyond))))
        straight = surface_mesh.shapes((kind[0], surface_mesh.CORNERS[kind]), place)
        heights.append(np.einsum("sgc,sc->sg", straight, height[owner]))
    if revolved:
        radius = sides[0].places[sides[0].nodes[pairs[0]][:, :2], 0][owner]
        ends = surface_mesh.shapes((2, 2), surface_mesh.local_places(seen[0][0][owner], points))
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
    kinds: tuple[Kind, Kind],
    pairs: tuple[IntArray, IntArray],
    side: int,
) -> tuple[FloatArray, FloatArray]:
    """Corners of one side's facets as places on the slave's, (p, c, d - 1), and heights above it, (p, c).

    Heights are positive towards the slave's body.
    """
    slave, nodes = sides[0], sides[side].nodes[pairs[side]][:, : surface_mesh.CORNERS[kinds[side]]]
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


def _points_along(seen: list[tuple[FloatArray, FloatArray]], kinds: tuple[Kind, Kind]) -> int:
    """Gauss points along each side of a triangle.

    Three are exact to degree 4, which is all that occurs on triangles and parallelograms. On other
    quadrilaterals local places are no polynomials: with (departure from a parallelogram, relative to the
    size, up to which; number of points) the error is 2e-15.
    """
    slant = 0.0
    for corners, _ in seen:
        if corners.shape[1] == 4:
            off = np.abs(corners[:, 0] - corners[:, 1] + corners[:, 2] - corners[:, 3]).max(axis=1)
            slant = max(slant, float((off / np.ptp(corners, axis=1).max(axis=1)).max(initial=0.0)))
    enough = ((1e-12, 3), (0.1, 6), (0.2, 8), (np.inf, 12))
    least = 6 if any(kind in ((3, 8), (3, 9)) for kind in kinds) else 0  # bi-quadratic quadrilaterals
    return max(least, next(count for most, count in enough if slant <= most))


def _on_lines(slave: FloatArray, master: FloatArray, count: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """Pairs that overlap, points (s, g, 1) and weights (s, g)."""
    low = np.maximum(slave.min(axis=1), master.min(axis=1))[:, 0]
    high = np.minimum(slave.max(axis=1), master.max(axis=1))[:, 0]
    owner = np.flatnonzero(high - low > 1e-11 * np.ptp(slave, axis=1)[:, 0])  # smaller ones are round-off
    place, weight = np.polynomial.legendre.leggauss(count)
    half = 0.5 * (high - low)[owner, None]
    middle = 0.5 * (high + low)[owner, None]
    return owner, (middle + half * place)[..., None], half * weight


def _on_planes(slave: FloatArray, master: FloatArray, count: int) -> tuple[IntArray, FloatArray, FloatArray]:
    """What pairs of convex polygons have in common, in triangles: pairs, points (s, g, 2), weights (s, g)."""
    slave, master = surface_mesh.counter_clockwise(slave), surface_mesh.counter_clockwise(master)
    polygon = master
    for k in range(slave.shape[1]):
        polygon = surface_mesh.clipped(polygon, slave[:, k], slave[:, (k + 1) % slave.shape[1]])
    fans = np.stack(
        [np.broadcast_to(polygon[:, :1], polygon[:, 2:].shape), polygon[:, 1:-1], polygon[:, 2:]], axis=2
    )
    twice = surface_mesh.cross(fans[:, :, 1] - fans[:, :, 0], fans[:, :, 2] - fans[:, :, 0])
    whole = np.abs(surface_mesh.cross(slave[:, 2] - slave[:, 0], slave[:, -1] - slave[:, 1]))[:, None]
    owner, number = np.nonzero(twice > 1e-11 * whole)  # smaller ones are round-off
    chosen, twice = fans[owner, number], twice[owner, number]
    place, weight = np.polynomial.legendre.leggauss(count)
    s, t = (axis.ravel() for axis in np.meshgrid((1 + place) / 2, (1 + place) / 2, indexing="ij"))
    shares = np.column_stack([1 - s, s * (1 - t), s * t])  # the square, with one side drawn together
    return (
        owner,
        np.einsum("gc,scd->sgd", shares, chosen),
        twice[:, None] * (np.outer(weight, weight).ravel() / 4 * s),
    )


REACH = 0.25  # in sizes of slave facets, or spacings of pairs: farther away another partner may be meant


@dataclass(frozen=True, eq=False, repr=False)
class SurfaceCoupling(NodeCoupling):
    """The coupling of a slave surface (its nodes) to a master surface, with how they lie on each other.

    Attributes
    ----------
    labels, master, P, normals, middle_nodes, partner
        As :class:`~shakedown.models.condensation.surface_mesh.NodeCoupling` has them; the contact nodes are
        those of the slave that are covered.
    area : (n,)
        Area D_j = ∫N_j over what is covered: nodal forces over it are tractions [length²]; in a plane
        lengths, of a body of revolution 2π r times these.
    places : (n, d)
        Positions of the nodes; of those between corners of quadratic facets the position that belongs to
        their unknown [length].
    gap : (n,)
        How far apart the surfaces are drawn, by the nodes of both, negative where they overlap [length]. Of
        curved faces, whose facets are chords, it says nothing (``flat``).
    flat : bool
        Whether the facets are flat and parallel, so that the gap is the distance that is drawn.
    overlap : float
        Area that is covered [length²].
    share : (2,)
        The same as a share of the area of either surface.
    distance : (3,)
        Least, mean and largest distance of the facets [length].
    uncovered : (u,)
        Nodes of the slave without a partner.
    chord : float
        Largest distance of P x₂ from x₁ (on flat faces along them), which the correction makes up for:
        without it a rigid turn by one radian would slip by so much [length].
    largest_weight : float
        max |P|.
    finer : float
        Size of the slave's facets relative to the master's.
    size : float
        Median size of the slave's facets [length].
    reach : float
        Largest distance at which facets were taken to meet [length].
    warnings : tuple of str
        What is doubtful.
    """

    area: FloatArray
    places: FloatArray
    gap: FloatArray
    flat: bool
    overlap: float
    share: FloatArray
    distance: FloatArray
    uncovered: IntArray
    chord: float
    largest_weight: float
    finer: float
    size: float
    reach: float
    warnings: tuple[str, ...]

    def to_dict(self) -> dict[str, object]:
        """What ``shakedown-bounds import --check --json`` writes of it."""
        keys = ("overlap", "chord", "largest_weight", "finer", "reach", "flat")
        return {
            "nodes": [len(self.labels), len(self.master)],
            **{key: getattr(self, key) for key in keys},
            "share": self.share.tolist(),
            "distance": dict(zip(("least", "mean", "largest"), self.distance.tolist(), strict=True)),
            "uncovered": self.uncovered.tolist(),
        }


@checked
def surface_coupling(
    slave: ContactSurface,
    master: ContactSurface,
    *,
    reach: float | None = None,
    revolved: bool = False,
) -> SurfaceCoupling:
    """Couple two surfaces by the dual mortar method (docs/mortar.md).

    Parameters
    ----------
    slave, master
        The surfaces of the first and the second body. Results are at the nodes of the first.
    reach
        Largest distance of facets that meet, by default a quarter of a facet of the slave [length].
    revolved
        Whether the facets are edges of bodies of revolution about the axis x = 0.

    Raises
    ------
    ProblemError
        If the surfaces share a node, none of their facets lie on each other or look at each other, or
        facets of the master lie in two layers.

    Examples
    --------
    Two edges on three:

    >>> three, two = np.linspace(0, 6, 4), np.linspace(0, 6, 3)
    >>> upper = ContactSurface([1, 2, 3], [[x, 0] for x in two], [(1, 2), (2, 3)], [[3, 1]] * 2)
    >>> lower = ContactSurface([4, 5, 6, 7], [[x, 0] for x in three], [(4, 5), (5, 6), (6, 7)], [[3, -1]] * 3)
    >>> found = surface_coupling(upper, lower)
    >>> found.area.round(12).tolist(), found.P.toarray()[::2].sum(axis=1).round(12).tolist()
    ([1.5, 3.0, 1.5], [1.0, 1.0, 1.0])
    """
    if slave.dimension != master.dimension:
        raise ProblemError("surfaces: expected two in the plane or two in space, found one of each")
    shared = np.intersect1d(slave.labels, master.labels)
    if shared.size:
        raise ProblemError(
            f"surfaces: expected bodies with nodes of their own, found node {shared[0]} on both "
            "(tied already, or one surface named twice)"
        )
    if reach is not None and not 0 < reach < np.inf:
        raise ProblemError(f"reach: expected a length > 0, found {reach:g}")
    longest = REACH * slave.size if reach is None else reach
    met = _segments(slave, master, facet_pairs(slave, master, longest), longest, revolved)
    if met is None or not len(met.area):
        raise ProblemError(_nothing(slave, master, longest))
    nodes, area, share, dual = dual_basis(slave, met, revolved=revolved)
    P, near = weights((slave, master), met, nodes, area, dual)
    d, labels = slave.dimension, slave.labels[nodes]
    places = (surface_mesh.own_basis(slave.labels, slave.middle_nodes, inverse=True) @ slave.places)[nodes]
    normals = slave.nodal_normals[nodes]
    apart = places - P @ master.places
    gap = (apart * normals).sum(axis=1)
    along = apart - gap[:, None] * normals
    every = _by_direction(P, surface_mesh.exact_rotations(P, near, places, master.places))
    touched = np.unique(every.indices // d)
    flat = _is_flat(slave, share > 0, along)
    overlap = float(share @ slave.areas)
    made = SurfaceCoupling(
        labels=labels,
        master=master.labels[touched],
        P=sparse.csr_array(every[:, (d * touched[:, None] + np.arange(d)).ravel()]),
        area=area,
        normals=normals,
        places=places,
        gap=gap,
        middle_nodes=slave.middle_nodes[np.isin(slave.middle_nodes[:, 0], labels)],
        partner=master.labels[np.asarray(abs(P).argmax(axis=1)).ravel()],
        flat=flat,
        overlap=overlap,
        share=np.array([overlap / slave.areas.sum(), overlap / master.areas.sum()]),
        distance=np.array([met.distance.min(), met.distance @ met.area / met.area.sum(), met.distance.max()]),
        uncovered=np.setdiff1d(np.concatenate(slave.facets), labels),
        chord=float(np.linalg.norm(along if flat else apart, axis=1).max()),
        largest_weight=float(np.abs(P.data).max()),
        finer=slave.size / float(np.median(master.areas ** (1 / (d - 1)))),
        size=slave.size,
        reach=longest,
        warnings=(),
    )
    return replace(made, warnings=tuple(_warnings(made)))


def _by_direction(P: sparse.csr_array, blocks: FloatArray) -> sparse.csr_array:
    """Blocks (nnz, d, d) in the places of P as one matrix (d n, d m), without what is round-off."""
    d = blocks.shape[1]
    found = sparse.csr_array(
        sparse.bsr_array((blocks, P.indices, P.indptr), shape=(d * P.shape[0], d * P.shape[1]))
    )
    found.data[np.abs(found.data) <= ROUND_OFF] = 0.0
    found.eliminate_zeros()
    return found


def _is_flat(slave: ContactSurface, used: NDArray[np.bool_], along: FloatArray) -> bool:
    """Whether facets that meet are parallel and P x₂ lies straight across from x₁."""
    size = max(float(np.ptp(slave.places, axis=0).max()), np.finfo(float).tiny)
    if np.abs(along).max() > SIX_DIGITS * size:
        return False
    facet, column = np.nonzero((slave.nodes < len(slave.labels)) & used[:, None])
    turned = slave.nodal_normals[slave.nodes[facet, column]] - slave.normals[facet]
    return bool(np.abs(turned).max(initial=0.0) <= SIX_DIGITS)


def _nothing(slave: ContactSurface, master: ContactSurface, reach: float) -> str:
    """The reason why no facets overlap."""
    every = np.ptp(np.vstack([slave.places, master.places]), axis=0)
    one, other = facet_pairs(slave, master, 10 * reach + float(np.linalg.norm(every)))
    found = "normals that are not opposed (the same side twice, or the wrong one)"
    if one.size:
        apart = np.abs(((slave.middles[one] - master.middles[other]) * slave.normals[one]).sum(axis=1)).min()
        found = f"them beside each other, or at least {apart:.3g} apart"
    return f"surfaces: expected facets that lie on each other within 'reach' = {reach:.3g}, found {found}"


def _warnings(made: SurfaceCoupling) -> Iterator[str]:
    """Warnings about the coupling."""
    partly = 0.5  # share of a surface beside the other, beyond which its nodes are no place for results
    (without, part_beside), extent = 1 - made.share, "area" if made.normals.shape[1] == 3 else "length"
    if without > 0.02 + NEGLIGIBLE:  # so much of an edge of a curved surface is beside its chords
        more = f", {len(made.uncovered)} node(s), first {made.uncovered[0]}" if made.uncovered.size else ""
        on_part = ""
        if without > partly > part_beside:
            on_part = ", or name the second, which lies on a part of it, first"
        yield (
            f"{100 * without:.2g} % of the {extent} of the first surface lies beside the second or too far "
            f"from it{more}, and carries nothing: 'reach' is {made.reach:.3g}{on_part}"
        )
    if made.finer < 0.67:  # λ_E and λ_U are lower then
        advice = "most of the second lies beside it" if part_beside > partly else "name the coarser first"
        yield (
            f"the first surface has the finer facets ({made.finer:.2g} of the size): what is proved "
            "from given or every initial slip is less than with the surfaces the other way round; "
            f"{advice}"
        )
