"""A linear elastic body in two or three dimensions, and boundaries of it that move as rigid bodies."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Literal, NamedTuple, Protocol

import numpy as np
import skfem
from scipy import sparse
from skfem.models.elasticity import lame_parameters, linear_elasticity

from shakedown.ground.argument_kinds import check_fields
from shakedown.ground.constants import FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.joint.places import strips
from shakedown.models.condensation.load_case import LoadCase
from shakedown.models.condensation.surface_mesh import ContactSurface, rigid_rows

AXES = "xyz"


class ElementKind(NamedTuple):
    """What an element shape is in scikit-fem, by the order of the element where there are two of a thing.

    Attributes
    ----------
    mesh
        The class of the mesh.
    order
        Places of its corners among those of the shape as decks number them.
    elements
        The elements.
    degrees
        The degree of polynomials that is integrated exactly; None: what scikit-fem takes. In solids it takes
        two or three Gauss points along each side of a hexahedron (two are those of C3D8), and as many as the
        constant Jacobian of a tetrahedron needs; scikit-fem takes 64 points where 8 are enough.
    """

    mesh: type[skfem.Mesh]
    order: list[int]
    elements: tuple[type, type]
    degrees: tuple[int | None, int | None] = (None, None)


KINDS = {
    "hexahedron": ElementKind(
        skfem.MeshHex, [0, 4, 3, 1, 7, 5, 2, 6], (skfem.ElementHex1, skfem.ElementHex2), (3, 5)
    ),
    "tetrahedron": ElementKind(skfem.MeshTet, [0, 1, 2, 3], (skfem.ElementTetP1, skfem.ElementTetP2), (2, 3)),
    "triangle": ElementKind(skfem.MeshTri, [0, 1, 2], (skfem.ElementTriP1, skfem.ElementTriP2)),
    "quadrilateral": ElementKind(skfem.MeshQuad, [0, 1, 2, 3], (skfem.ElementQuad1, skfem.ElementQuad2)),
}


@dataclass(frozen=True)
class Material:
    """Isotropic linear elasticity: Young's modulus [force/length²] and Poisson's ratio [–].

    A density [mass/length³], in units in which force = mass · length / time², is needed for modes only.

    Raises
    ------
    ProblemError
        Unless young > 0, −1 < poisson < 0.5 and density > 0, all finite.

    Examples
    --------
    >>> Material(200e9, 0.3).young
    200000000000.0
    """

    young: float
    poisson: float
    density: float | None = None

    def __post_init__(self) -> None:
        check_fields(self, ProblemError)
        if not (0 < self.young < inf and -1 < self.poisson < 0.5):
            raise ProblemError(
                "material: expected a finite Young's modulus > 0 and -1 < Poisson's ratio < 0.5, "
                f"found {self.young}, {self.poisson}"
            )
        if self.density is not None and not 0 < self.density < inf:
            raise ProblemError(f"material: expected a finite density > 0, found {self.density}")

    def lame(self, plane: str) -> tuple[float, float]:
        """Lamé parameters (λ, μ) [force/length²]; a solid has those of plane strain."""
        lam, mu = lame_parameters(self.young, self.poisson)
        return (lam, mu) if plane == "strain" else (2 * mu * lam / (lam + 2 * mu), mu)


@dataclass(frozen=True)
class Support:
    """A boundary that cannot move in x, in y, in z (of a solid), or in several of them."""

    boundary: str
    x: bool = True
    y: bool = True
    z: bool = True

    def __post_init__(self) -> None:
        check_fields(self, ProblemError)

    def holds(self, dimension: int) -> list[int]:
        """The directions (1, 2, 3) in which it holds a body of two or three dimensions."""
        return [k for k, held in enumerate((self.x, self.y, self.z)[:dimension], start=1) if held]


class BodyLoad(Protocol):
    """What a body asks of its loads (:class:`shakedown.fem.Load`)."""

    def support(self) -> Support | None:
        """What the load holds in place, if anything."""

    def cases(self, body: "ElasticBody", steps: int | None, rows: slice, size: int) -> list[LoadCase]:
        """The load cases in a model of ``size`` rows where the body has ``rows``."""


@dataclass(frozen=True, eq=False)
class ElasticBody:
    """An elastic body with its supports and loads, discretised by scikit-fem.

    Parameters
    ----------
    mesh
        Triangles or quadrilaterals, tetrahedra or hexahedra with named boundaries (and subdomains).
    material
        One material, or a material for each named subdomain.
    supports, loads
        What holds the body and what acts on it, on named boundaries.
    plane
        ``"strain"`` or ``"stress"``, for a plane body.
    thickness
        Thickness of a plane body [length].
    order
        1 (bilinear, linear) or 2 (biquadratic, quadratic) elements. Slips and forces at nodes between the
        corners of quadratic tetrahedra in contact are weighted ones (docs/mortar.md).
    rigid
        Boundaries that move as rigid bodies: a bolt's head, a clamp, a patch that a load acts on.
        They have no nodes in common with each other, the supports or the contact.

    Raises
    ------
    ProblemError
        If a boundary or subdomain is not in the mesh, the mesh has elements of another kind, some of them
        have no material, or a solid is given a thickness.

    Examples
    --------
    >>> from shakedown.fem import block_mesh
    >>> body = ElasticBody(block_mesh(2.0, 1.0, 4, 2), Material(1.0, 0.3))
    >>> body.stiffness.shape, body.dofs[:3].tolist()
    ((30, 30), [[0, 1], [0, 2], [1, 1]])
    """

    mesh: skfem.Mesh
    material: Material | Mapping[str, Material]
    supports: Sequence[Support] = ()
    loads: "Sequence[BodyLoad]" = ()
    plane: Literal["strain", "stress"] = "strain"
    thickness: float = 1.0
    order: int = 1
    rigid: Sequence[str] = ()

    def __post_init__(self) -> None:
        check_fields(self, ProblemError)
        if self.order not in (1, 2):
            raise ProblemError(f"order: expected 1 or 2, found {self.order}")
        if not 0 < self.thickness < inf:
            raise ProblemError(f"thickness: expected a finite one > 0, found {self.thickness}")
        if not any(isinstance(self.mesh, kind.mesh) for kind in KINDS.values()):
            known = ", ".join(kind.mesh.__name__ for kind in KINDS.values())
            raise ProblemError(f"mesh: expected one of {known}, found {type(self.mesh).__name__}")
        if self.dimension == 3 and (self.plane != "strain" or self.thickness != 1.0):
            raise ProblemError("plane, thickness: expected of a plane body only, found a solid one")
        for name in self.rigid:
            self.facets(name)
        for support in self.supports:
            self.facets(support.boundary)
        self.parts()

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.mesh.dim())

    @cached_property
    def shape(self) -> str:
        """The shape of its elements."""
        return next(name for name, kind in KINDS.items() if isinstance(self.mesh, kind.mesh))

    @cached_property
    def basis(self) -> skfem.Basis:
        """scikit-fem's basis of the displacements."""
        return skfem.Basis(self.mesh, self.element, intorder=KINDS[self.shape].degrees[self.order - 1])

    @cached_property
    def element(self) -> skfem.ElementVector:
        """scikit-fem's vector element."""
        return skfem.ElementVector(KINDS[self.shape].elements[self.order - 1]())

    @cached_property
    def stiffness(self) -> sparse.csr_array:
        """Stiffness of the unsupported body, (N, N) [force/length]."""
        return self.integrated(lambda material: linear_elasticity(*material.lame(self.plane)))

    def integrated(self, form: Callable[[Material], skfem.BilinearForm]) -> sparse.csr_array:
        """The matrix (N, N) of a form of each material, integrated over the body."""
        found = sparse.csr_array((self.basis.N, self.basis.N))
        for material, elements in self.parts():
            basis = self.basis if elements is None else self.basis.with_elements(elements)
            found = found + sparse.csr_array(form(material).assemble(basis))
        return self.thickness * found

    @cached_property
    def dofs(self) -> IntArray:
        """Node label and direction (1, 2 or 1, 2, 3) of every row, (N, 2).

        Vertices keep their numbers. With second-order elements the nodes on edges come next, then those on
        facets, then the centres of the elements, each in the order of the mesh.
        """
        table, first = np.zeros((self.basis.N, 2), dtype=np.intp), 0
        for rows in (getattr(self.basis, f"{kind}_dofs") for kind in ("nodal", "edge", "facet", "interior")):
            if rows is not None and len(rows):
                labels = first + np.arange(rows.shape[1])
                for direction in range(self.dimension):
                    table[rows[direction], 0], table[rows[direction], 1] = labels, direction + 1
                first += rows.shape[1]
        return table

    def facets(self, boundary: str) -> IntArray:
        """Facets of a named boundary; ``ProblemError`` if there is none of that name, or it has no facets."""
        named = self.mesh.boundaries or {}
        if boundary not in named:
            listed = ", ".join(sorted(named)) or "none"
            raise ProblemError(f"boundary '{boundary}': not in the mesh; its boundaries are {listed}")
        if not len(named[boundary]):
            raise ProblemError(f"boundary '{boundary}': expected at least one facet, found none")
        return np.asarray(named[boundary])

    def facet_basis(self, boundary: str) -> skfem.FacetBasis:
        """scikit-fem's basis on a named boundary, for loads."""
        return skfem.FacetBasis(self.mesh, self.element, facets=self.facets(boundary))

    def rows_on(self, boundary: str, direction: int) -> IntArray:
        """Rows of K of all nodes on a named boundary in one direction (1, 2, 3)."""
        rows = self.basis.get_dofs(self.facets(boundary)).flatten()
        return np.sort(rows[self.dofs[rows, 1] == direction])

    def held_rows(self) -> IntArray:
        """Rows of K that the supports hold or that a load prescribes."""
        rows = [np.zeros(0, dtype=np.intp)]
        for held in (*self.supports, *(load.support() for load in self.loads)):
            if held is not None:
                rows += [self.rows_on(held.boundary, direction) for direction in held.holds(self.dimension)]
        return np.unique(np.concatenate(rows))

    def surface(self, boundary: str, shift: int = 0) -> ContactSurface:
        """Nodes and facets of a named boundary; labels are the numbers of the nodes plus ``shift``."""
        mesh, facets, inside = self.mesh, [], []
        for facet in self.facets(boundary):
            corners = np.asarray(mesh.facets[:, facet])
            if self.dimension == 3:
                arms = self.positions(corners) - self.positions(corners).mean(axis=0)
                first, second = np.linalg.svd(arms)[2][:2]
                corners = corners[np.argsort(np.arctan2(arms @ second, arms @ first))]  # in order around it
            between = self._between(int(facet), corners) if self.order == 2 else ()
            facets.append(np.array([*corners.tolist(), *between]))
            inside.append(mesh.p[:, mesh.t[:, mesh.f2t[0, facet]]].mean(axis=1))
        labels = np.unique(np.concatenate(facets))
        shifted = [(nodes + shift).tolist() for nodes in facets]
        return ContactSurface(labels + shift, self.positions(labels), shifted, np.array(inside))

    def _between(self, facet: int, corners: IntArray) -> list[int]:
        """Nodes on the sides of a second-order facet, in order around it, then one in its middle, if any."""
        every = np.unique(self.dofs[self.basis.get_dofs(np.array([facet])).flatten(), 0])
        others = every[~np.isin(every, corners)]
        if self.dimension == 2:
            return [int(node) for node in others]
        at = self.positions(corners)
        middles = np.vstack([0.5 * (at + np.roll(at, -1, axis=0)), at.mean(axis=0)])
        apart = np.linalg.norm(self.positions(others)[None] - middles[:, None], axis=2)
        return [int(others[k]) for k in apart[: len(others)].argmin(axis=1)]

    def normals_on(self, boundary: str) -> tuple[IntArray, FloatArray]:
        """Nodes of a named boundary, (n,), and unit normals into the body there, (n, 2) or (n, 3).

        The nodes of a plane body are in order along the boundary, from edge to edge with the body on the
        left, those of a solid in the order of their numbers. Where facets meet, the normal is the mean of
        theirs, weighted by length (of a solid by area).
        """
        surface = self.surface(boundary)
        nodes, normals = surface.labels, surface.nodal_normals
        if self.dimension == 3:
            return nodes, normals
        order = np.concatenate(self.strips(boundary, nodes, normals))
        return nodes[order], normals[order]

    def strips(self, boundary: str, nodes: IntArray, normals: FloatArray) -> list[IntArray]:
        """Some nodes of a plane body's boundary, in order, as :func:`~shakedown.joint.places.strips`."""
        position = dict(zip(nodes.tolist(), range(len(nodes)), strict=True))
        edges = [
            [position[label] for label in set(self.dofs[rows, 0].tolist()) if label in position]
            for rows in (self.basis.get_dofs(np.array([facet])).flatten() for facet in self.facets(boundary))
        ]
        # normals times it are tangents with the body on their left
        return strips(self.positions(nodes), normals @ np.array([[0.0, -1.0], [1.0, 0.0]]), edges)

    def extent_of(self, boundary: str) -> float:
        """The length of a named boundary of a plane body [length], the area of one of a solid [length²]."""
        return float(self.surface(boundary).areas.sum())

    def positions(self, nodes: IntArray) -> FloatArray:
        """Coordinates of nodes by label, (n, 2) or (n, 3) [length]."""
        return self._places[nodes]

    @cached_property
    def _places(self) -> FloatArray:
        """Coordinates of all nodes in the order of their labels."""
        place = np.zeros((self.dofs[:, 0].max() + 1, self.dimension))
        place[self.dofs[:, 0]] = self.basis.doflocs.T
        return place

    def parts(self) -> list[tuple[Material, IntArray | None]]:
        """Every material with its elements; with None where one material is that of all elements."""
        if isinstance(self.material, Material):
            return [(self.material, None)]
        named = self.mesh.subdomains or {}
        for key in self.material:
            if key not in named:
                listed = ", ".join(sorted(named)) or "none"
                raise ProblemError(f"material '{key}': no such subdomain in the mesh; there are {listed}")
        parts = [(material, np.asarray(named[key])) for key, material in self.material.items()]
        covered = np.bincount(np.concatenate([e for _, e in parts]), minlength=self.mesh.nelements)
        if (covered != 1).any():
            raise ProblemError(
                f"material: expected one for every element, found {(covered != 1).sum()} of "
                f"{self.mesh.nelements} elements with none or several"
            )
        return list(parts)


def rigid_motion(places: FloatArray) -> FloatArray:
    """Displacements of points by unit translations and unit turns about their middle, (n, k, r).

    In a plane k = 2, r = 3; in space k = 3, r = 6. A turn of 1 moves the farthest point by 1, so that all
    unknowns are displacements.

    Examples
    --------
    >>> rigid_motion(np.array([[-2.0, 0.0], [2.0, 0.0]]))[1].tolist()
    [[1.0, 0.0, -0.0], [0.0, 1.0, 1.0]]
    """
    arm = places - places.mean(axis=0)
    return rigid_rows(arm / (np.linalg.norm(arm, axis=1).max() or 1.0))


def tied(body: ElasticBody, contact: IntArray) -> tuple[sparse.csr_array, IntArray]:
    """T of u = T u': unknowns u' of a body whose rigid boundaries only move as rigid bodies.

    Parameters
    ----------
    contact
        Contact nodes of the body.

    Returns
    -------
    T : (N, N')
        The unit matrix where no boundary is rigid.
    dofs : (N', 2)
        Node and direction of every unknown u'. A rigid boundary counts as one node, with directions 1 to 6
        (in the plane 1 to 3).

    Raises
    ------
    ProblemError
        If a node of a rigid boundary is held, in contact, or on another one.
    """
    kept = np.ones(body.basis.N, dtype=bool)
    unit, moved, labels = sparse.eye_array(body.basis.N, format="csc"), [], [np.zeros((0, 2), dtype=np.intp)]
    taken = {"in contact": contact, "held or prescribed": body.dofs[body.held_rows(), 0]}
    first = int(body.dofs[:, 0].max()) + 1
    for number, name in enumerate(body.rigid):
        rows = np.column_stack([body.rows_on(name, 1 + a) for a in range(body.dimension)])
        nodes = body.dofs[rows[:, 0], 0]
        for what, others in taken.items():
            if (shared := np.intersect1d(nodes, others)).size:
                raise ProblemError(
                    f"rigid boundary '{name}': expected free nodes, found node {shared[0]} {what}"
                )
        taken[f"on '{name}' too"] = nodes
        motion = rigid_motion(body.positions(nodes))
        kept[rows] = False
        moved.append(unit[:, rows.ravel()] @ sparse.csr_array(motion.reshape(rows.size, -1)))
        own = np.arange(1, motion.shape[2] + 1)
        labels.append(np.column_stack([np.full(len(own), first + number), own]))
    free = np.flatnonzero(kept)
    return sparse.csr_array(sparse.hstack([unit[:, free], *moved])), np.vstack([body.dofs[free], *labels])
