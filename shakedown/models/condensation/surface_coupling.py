"""The coupling of two surfaces whose meshes do not match, with the evidence that it was done right."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import NEGLIGIBLE, PER_CENT, ROUND_OFF, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.models.condensation.dual_basis import DualBasis, dual_basis, facet_pairs
from shakedown.models.condensation.surface_mesh import (
    ContactSurface,
    NodeCoupling,
    exact_rotations,
    own_basis,
)

REACH = 0.25  # in sizes of slave facets, or spacings of pairs: farther away another partner may be meant
UNCOVERED = 0.02  # share of the slave's area without a partner that is not worth a warning
PARTLY = 0.5  # share of a surface beside the other, beyond which its nodes are no place for results
FINER = 0.67  # size of the slave's facets relative to the master's: below it λ_E and λ_U are lower


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
    uncovered: float | None = None,
    finer: bool = False,
    revolved: bool = False,
) -> SurfaceCoupling:
    """Couple two surfaces by the dual mortar method (docs/mortar.md).

    Parameters
    ----------
    slave, master
        The surfaces of the first and the second body. Results are at the nodes of the first.
    reach
        Largest distance of facets that meet, by default a quarter of a facet of the slave [length].
    uncovered
        Share of the slave's area that may lie beside the master without a warning, by default 0.02; where it
        is given, nodes of which hardly anything is covered are no warning either.
    finer
        Whether the slave may have the finer facets without a warning.
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
    if uncovered is not None and not 0 <= uncovered <= 1:
        raise ProblemError(f"uncovered: expected a share from 0 to 1, found {uncovered:g}")
    longest = REACH * slave.size if reach is None else reach
    found = dual_basis(slave, master, facet_pairs(slave, master, longest), longest, revolved=revolved)
    if found is not None and not len(found.nodes):
        raise ProblemError(
            "surfaces: expected facets of the first with a part of the second below every node, found at "
            f"most {100 * found.found.max():.2g} % of one covered; name the second first, with finer = true"
        )
    if found is None:
        raise ProblemError(_nothing(slave, master, longest))
    if found.found.max() > 1.0 + SIX_DIGITS:  # something is covered twice
        worst = slave.facets[int(np.argmax(found.found))]
        raise ProblemError(
            f"surfaces: expected facets of the master side by side, found {found.found.max():.3g} times the "
            f"slave's facet {worst} below them: do they lie in two layers? (a smaller 'reach')"
        )
    made = _coupling(slave, master, found, longest)
    weak = made.labels[found.area < PER_CENT * found.whole]  # nodes that only a corner of the master covers
    return replace(made, warnings=tuple(_warnings(made, uncovered, weak, finer)))


def _coupling(
    slave: ContactSurface, master: ContactSurface, found: DualBasis, reach: float
) -> SurfaceCoupling:
    P, d = found.P, slave.dimension
    places = (own_basis(slave.labels, slave.middle_nodes, inverse=True) @ slave.places)[found.nodes]
    normals = slave.nodal_normals[found.nodes]
    apart = places - P @ master.places
    gap = (apart * normals).sum(axis=1)
    along = apart - gap[:, None] * normals
    every = _by_direction(P, exact_rotations(P, found.near, places, master.places))
    touched = np.unique(every.indices // d)
    flat = _is_flat(slave, found.share > 0, along)
    size = float(np.median(master.areas ** (1 / (d - 1))))
    overlap = float(found.share @ slave.areas)
    middle_nodes = slave.middle_nodes[np.isin(slave.middle_nodes[:, 0], slave.labels[found.nodes])]
    return SurfaceCoupling(
        labels=slave.labels[found.nodes],
        master=master.labels[touched],
        P=sparse.csr_array(every[:, (d * touched[:, None] + np.arange(d)).ravel()]),
        area=found.area,
        normals=normals,
        places=places,
        gap=gap,
        middle_nodes=middle_nodes,
        partner=master.labels[np.asarray(abs(P).argmax(axis=1)).ravel()],
        flat=flat,
        overlap=overlap,
        share=np.array([overlap / slave.areas.sum(), overlap / master.areas.sum()]),
        distance=np.array(found.distance),
        uncovered=np.setdiff1d(np.concatenate(slave.facets), slave.labels[found.nodes]),
        chord=float(np.linalg.norm(along if flat else apart, axis=1).max()),
        largest_weight=float(np.abs(P.data).max()),
        finer=slave.size / size,
        size=slave.size,
        reach=reach,
        warnings=(),
    )


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


def _warnings(made: SurfaceCoupling, accepted: float | None, weak: IntArray, finer: bool) -> Iterator[str]:
    """Warnings about the coupling."""
    (without, part_beside), extent = 1 - made.share, "area" if made.normals.shape[1] == 3 else "length"
    if without > (UNCOVERED if accepted is None else accepted) + NEGLIGIBLE:
        more = f", {len(made.uncovered)} node(s), first {made.uncovered[0]}" if made.uncovered.size else ""
        on_part = ""
        if without > PARTLY > part_beside:
            on_part = ", or name the second, which lies on a part of it, first"
        yield (
            f"{100 * without:.2g} % of the {extent} of the first surface lies beside the second or too far "
            f"from it{more}, and carries nothing: 'uncovered' accepts it, 'reach' is {made.reach:.3g}"
            f"{on_part}"
        )
    if made.finer < FINER and not finer:
        advice = "name the coarser first, or"
        if part_beside > PARTLY:
            advice = "most of the second lies beside it:"
        yield (
            f"the first surface has the finer facets ({made.finer:.2g} of the size): what is proved "
            "from given or every initial slip is less than with the surfaces the other way round; "
            f"{advice} say finer = true"
        )
    if weak.size and accepted is None:
        yield (
            f"{weak.size} node(s) of the first surface, first {weak[0]}, are covered by less than "
            f"{100 * PER_CENT:g} % of their {extent} at the edge of the second: tractions there are coarse; "
            "'uncovered' accepts it"
        )
