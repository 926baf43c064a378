"""A surface of a body: its nodes, its facets, and on which side the body is."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.joint.arguments import real_array
from shakedown.joint.result import Result
from shakedown.models.condensation.facet_shapes import CHANGED, CORNERS

IntArray = NDArray[np.intp]


class FacetBlock(NamedTuple):
    """Facets of one kind (dimension, count of nodes): positions of their nodes, (F, k), and their numbers."""

    kind: tuple[int, int]
    nodes: IntArray
    numbers: IntArray


@dataclass(frozen=True, eq=False, repr=False)
class ContactSurface(Result):
    """Nodes and facets of one side of a contact.

    Parameters
    ----------
    labels : (k,) int
        Labels of the nodes.
    places : (k, 2) or (k, 3)
        Where they are [length]. Facets of a plane model are edges.
    facets : sequence of F tuples of labels
        Corners in order, then the nodes between them, then one in the middle: 2 or 3 of an edge; 3, 6, 4, 8
        or 9 of a facet in space.
    inside : (F, 2) or (F, 3)
        A place inside the body behind every facet [length].

    Raises
    ------
    ProblemError
        If there is no facet, a facet is of another kind or has a node without a place, or has no area.
    """

    labels: IntArray
    places: FloatArray
    facets: Sequence[tuple[int, ...]]
    inside: FloatArray

    if TYPE_CHECKING:  # whatever NumPy can turn into an array is accepted

        def __init__(
            self, labels: ArrayLike, places: ArrayLike, facets: Sequence[Sequence[int]], inside: ArrayLike
        ) -> None: ...

    def __post_init__(self) -> None:
        labels = real_array("labels", self.labels)
        for name, value in (
            ("labels", labels.astype(np.intp)),
            ("places", real_array("places", self.places)),
            ("facets", [tuple(int(node) for node in facet) for facet in self.facets]),
            ("inside", real_array("inside", self.inside)),
        ):
            object.__setattr__(self, name, value)
        super().__post_init__()
        if not self.facets:
            raise ProblemError("surface: expected facets, found none")
        if labels.ndim != 1 or (labels % 1).any() or len(np.unique(labels)) < len(labels):
            raise ProblemError("labels: expected one whole number for each node, no two the same")
        for name, count in (("places", len(labels)), ("inside", len(self.facets))):
            if (shape := getattr(self, name).shape) not in [(count, 2), (count, 3)]:
                raise ProblemError(f"{name}: expected shape ({count}, 2) or ({count}, 3), found {shape}")
        if self.inside.shape[1] != self.dimension:
            raise ProblemError("inside: expected places of as many coordinates as the nodes have")
        known = set(self.labels.tolist())
        for facet in self.facets:
            if (self.dimension, len(facet)) not in CORNERS or not known.issuperset(facet):
                raise ProblemError(
                    f"surface: expected facets of 2 or 3 nodes in the plane, 3, 6, 4, 8 or 9 in space, all "
                    f"of them with places, found {facet} in {self.dimension} dimensions"
                )
        if not (self.areas > 0).all():
            flat = self.facets[int(np.argmin(self.areas))]
            raise ProblemError(f"surface: expected facets with an area, found none of {flat}")

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.places.shape[1])

    @cached_property
    def blocks(self) -> tuple[FacetBlock, ...]:
        """The facets by their kinds."""
        position = dict(zip(self.labels.tolist(), range(len(self.labels)), strict=True))
        found: dict[int, list[int]] = {}
        for number, facet in enumerate(self.facets):
            found.setdefault(len(facet), []).append(number)
        return tuple(
            FacetBlock(
                (self.dimension, count),
                np.array([[position[node] for node in self.facets[number]] for number in numbers]),
                np.array(numbers),
            )
            for count, numbers in sorted(found.items())
        )

    @cached_property
    def nodes(self) -> IntArray:
        """The nodes of every facet, (F, k), as positions in the labels; beyond its own their number."""
        found = np.full((len(self.facets), max(map(len, self.facets))), len(self.labels))
        for kind, nodes, numbers in self.blocks:
            found[numbers, : kind[1]] = nodes
        return found

    @cached_property
    def frames(self) -> FloatArray:
        """Middle, unit normal into the body and radius of every facet, (F, 2 d + 1)."""
        d, found = self.dimension, np.zeros((len(self.facets), 2 * self.dimension + 2))
        for kind, nodes, numbers in self.blocks:
            corners = self.places[nodes[:, : CORNERS[kind]]]
            middle = corners.mean(axis=1)
            if d == 2:
                along = corners[:, 1] - corners[:, 0]
                normal = np.column_stack([-along[:, 1], along[:, 0]])
            else:
                arms = corners - middle[:, None]
                normal = 0.5 * np.cross(arms, np.roll(arms, -1, axis=1)).sum(axis=1)
            area = np.linalg.norm(normal, axis=1)
            into = np.where(((self.inside[numbers] - middle) * normal).sum(axis=1) < 0, -1.0, 1.0)
            unit = normal * (into / np.maximum(area, np.finfo(float).tiny))[:, None]
            radius = np.linalg.norm(corners - middle[:, None], axis=2).max(axis=1)
            found[numbers] = np.column_stack([middle, unit, radius, area])
        return found

    @property
    def middles(self) -> FloatArray:
        """Middle of every facet, (F, d) [length]."""
        return self.frames[:, : self.dimension]

    @property
    def normals(self) -> FloatArray:
        """Unit normals into the body, (F, d)."""
        return self.frames[:, self.dimension : 2 * self.dimension]

    @property
    def radii(self) -> FloatArray:
        """Distance of every facet's middle from its farthest corner, (F,) [length]."""
        return self.frames[:, -2]

    @property
    def areas(self) -> FloatArray:
        """Areas (in the plane lengths) of the facets, their sides taken as straight, (F,)."""
        return self.frames[:, -1]

    @property
    def size(self) -> float:
        """Median size of the facets [length]."""
        return float(np.median(self.areas ** (1.0 / (self.dimension - 1))))

    @cached_property
    def middle_nodes(self) -> IntArray:
        """(node between two corners, these corners) of facets whose basis is changed, (t, 3) labels."""
        return np.unique(np.array(list(self._between()), dtype=np.intp).reshape(-1, 3), axis=0)

    def _between(self) -> Iterator[tuple[int, int, int]]:
        for facet in self.facets:
            kind = (self.dimension, len(facet))
            if kind in CHANGED:
                corners = CORNERS[kind]
                for k in range(corners):
                    low, high = sorted((facet[k], facet[(k + 1) % corners]))
                    yield facet[corners + k], low, high
