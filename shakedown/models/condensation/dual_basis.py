"""D and P of the dual mortar method: u₁ = (slip and gap) + P u₂, one row per node of the slave.

u₁ and u₂ are the displacements of slave and master (``overlaps``). The contact pressure is a sum of dual
functions ψ_j of the slave's nodes. They are chosen with ∫ψ_j N̂_l = δ_jl D_j over what is covered of each
facet, so that D is diagonal and P explicit, P_jk = ∫ψ_j N_k / D_j. Σψ_j = 1: constant pressures are
transmitted exactly.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ROUND_OFF, THREE_DIGITS
from shakedown.models.condensation.overlaps import Overlaps, overlaps
from shakedown.models.condensation.surface_mesh import ContactSurface, FacetBlock, IntArray


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


def dual_basis(
    slave: ContactSurface,
    master: ContactSurface,
    pairs: tuple[IntArray, IntArray],
    reach: float,
    *,
    revolved: bool = False,
) -> DualBasis | None:
    """Integrate over all pairs of facets; None where nothing is covered."""
    parts = [found for found in _parts(slave, master, pairs, reach, revolved) if len(found[1].area)]
    if not parts:
        return None
    weights = [np.zeros((len(block.nodes), block.kind[1])) for block in slave.blocks]
    masses = [np.zeros((*weight.shape, weight.shape[1])) for weight in weights]
    covered = [np.zeros(len(weight)) for weight in weights]
    for number, part in parts:
        np.add.at(weights[number], part.facets, part.weight)
        np.add.at(masses[number], part.facets, part.mass)
        np.add.at(covered[number], part.facets, part.area)
    whole = [_whole(slave, block, revolved) for block in slave.blocks]
    size = [own.sum(axis=1) for own in whole]
    share = [own / total for own, total in zip(covered, size, strict=True)]
    kept = _kept(slave, weights, whole, share)
    duals = [_dual(*given) for given in zip(weights, masses, kept, strict=True)]
    area = _by_node(slave, [own * use[:, None] for own, use in zip(weights, kept, strict=True)])
    nodes = np.flatnonzero(area > 0)
    P, near = (_scaled(own, nodes, area) for own in _entries(slave, master, parts, duals, kept))
    P.data[np.abs(P.data) < ROUND_OFF] = 0.0
    apart = np.concatenate([part.distance for _, part in parts])
    area_of = np.concatenate([part.area for _, part in parts])
    return DualBasis(
        nodes=nodes,
        P=P,
        near=near.data,
        area=area[nodes],
        whole=_by_node(slave, whole)[nodes],
        share=_by_facet(slave, [own * use for own, use in zip(share, kept, strict=True)]),
        found=_by_facet(slave, share),
        distance=(float(apart.min()), float(apart @ area_of / area_of.sum()), float(apart.max())),
    )


def _entries(
    slave: ContactSurface,
    master: ContactSurface,
    parts: list[tuple[int, Overlaps]],
    duals: list[FloatArray],
    kept: list[NDArray[np.bool_]],
) -> list[sparse.coo_array]:
    """∫ψ_j N_k, and Σ |∫N̂_j N_k| in the same places."""
    found: list[list[FloatArray]] = [[], []]
    rows, columns = [], []
    for number, part in parts:
        own = kept[number][part.facets]
        facets, across = part.facets[own], part.across[own]
        nodes = slave.blocks[number].nodes[facets]
        rows.append(np.broadcast_to(nodes[:, :, None], across.shape).ravel())
        columns.append(np.broadcast_to(part.nodes[own][:, None, :], across.shape).ravel())
        found[0].append(np.einsum("sjl,slk->sjk", duals[number][facets], across, optimize=True).ravel())
        found[1].append(np.abs(across).ravel())
    where, shape = (np.concatenate(rows), np.concatenate(columns)), (len(slave.labels), len(master.labels))
    return [sparse.coo_array((np.concatenate(own), where), shape=shape) for own in found]


def _scaled(entries: sparse.coo_array, nodes: IntArray, area: FloatArray) -> sparse.csr_array:
    """The rows of some nodes, each by its area; entries that are zero stay."""
    rows = sparse.csr_array(entries.tocsr()[nodes])
    rows.data /= np.repeat(area[nodes], np.diff(rows.indptr))
    return rows


def _parts(
    slave: ContactSurface,
    master: ContactSurface,
    pairs: tuple[IntArray, IntArray],
    reach: float,
    revolved: bool,
) -> list[tuple[int, Overlaps]]:
    """Integrals by kinds of facets, with the number of the slave's block."""
    found = []
    for (number, one), other in product(enumerate(slave.blocks), master.blocks):
        place = [np.full(len(side.facets), -1) for side in (slave, master)]
        for where, block in zip(place, (one, other), strict=True):
            where[block.numbers] = np.arange(len(block.numbers))
        rows = place[0][pairs[0]], place[1][pairs[1]]
        own = np.flatnonzero((rows[0] >= 0) & (rows[1] >= 0))
        if own.size:
            chosen = rows[0][own], rows[1][own]
            found.append((number, overlaps((slave, master), (one, other), chosen, reach, revolved=revolved)))
    return found


def _whole(slave: ContactSurface, block: FacetBlock, revolved: bool) -> FloatArray:
    """∫N̂ over whole facets of a block, (F, k)."""
    rows = np.arange(len(block.nodes))
    itself = overlaps((slave, slave), (block, block), (rows, rows), np.inf, revolved=revolved)
    total = np.zeros(block.nodes.shape)
    np.add.at(total, itself.facets, itself.weight)
    return total


def _kept(
    slave: ContactSurface, weights: list[FloatArray], whole: list[FloatArray], share: list[FloatArray]
) -> list[NDArray[np.bool_]]:
    """Facets that are covered so far that each of their nodes can bear a pressure.

    Where less than a thousandth of a facet is covered, or of what a node has without the edge of the master,
    ψ is not determined by what is covered: the mass matrix is singular but for round-off.
    """
    kept = [own >= THREE_DIGITS for own in share]
    full = _by_node(slave, whole)
    while True:
        area = _by_node(slave, [own * use[:, None] for own, use in zip(weights, kept, strict=True)])
        weak = (area < THREE_DIGITS * full) & (area != 0)
        out = [
            use & weak[block.nodes].any(axis=1) & (own < 1 - THREE_DIGITS)
            for use, block, own in zip(kept, slave.blocks, share, strict=True)
        ]
        if not any(each.any() for each in out):
            return kept
        kept = [use & ~each for use, each in zip(kept, out, strict=True)]


def _dual(weight: FloatArray, mass: FloatArray, kept: NDArray[np.bool_]) -> FloatArray:
    """A with ψ = A N̂ on every facet, (F, k, k): diag(∫N̂) (∫N̂ N̂ᵀ)⁻¹; 0 for facets that are left out."""
    found = np.zeros_like(mass)
    size = mass[kept].trace(axis1=1, axis2=2)[:, None, None]
    found[kept] = weight[kept][:, :, None] * np.linalg.inv(mass[kept] / size) / size
    return found


def _by_node(slave: ContactSurface, values: list[FloatArray]) -> FloatArray:
    total = np.zeros(len(slave.labels))
    for block, own in zip(slave.blocks, values, strict=True):
        np.add.at(total, block.nodes, own)
    return total


def _by_facet(slave: ContactSurface, values: list[FloatArray]) -> FloatArray:
    found = np.zeros(len(slave.facets))
    for block, own in zip(slave.blocks, values, strict=True):
        found[block.numbers] = own
    return found
