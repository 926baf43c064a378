"""Loads on an elastic body, each with its own time function; rolling elements; bolts; modes of a joint.

A mode is one of the joint whose contact sticks; its inertia forces are a load.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy import sparse
from scipy.linalg import qr
from scipy.sparse.linalg import ArpackNoConvergence, eigsh
from skfem import BilinearForm, LinearForm
from skfem.helpers import dot

from shakedown.fem.body import ElasticBody, Support, rigid_motion
from shakedown.ground.argument_kinds import check_fields
from shakedown.ground.constants import NEGLIGIBLE, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import ProblemError, SolverError
from shakedown.joint.result import Result
from shakedown.models.condensation.load_case import LoadCase, histories
from shakedown.models.condensation.surface_mesh import shapes

Field = float | Callable[[FloatArray], FloatArray]
History = ArrayLike | Callable[[FloatArray], FloatArray]


@dataclass(frozen=True, kw_only=True, eq=False)
class Load(ABC):
    """What all loads share: their time function.

    Parameters
    ----------
    history : (m,), a number (constant) or a function of t
        Factor of the load; a function is called with the times t = k/m of the
        load steps, in periods.
    mean, transient, range
        As in :class:`shakedown.LoadCase`; a range stands instead of a history.
    """

    history: History | None = None
    mean: float | None = None
    transient: ArrayLike | None = None
    range: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        check_fields(self, ProblemError)

    @abstractmethod
    def nodal(self, body: ElasticBody) -> tuple[FloatArray, FloatArray]:
        """Nodal forces [force] and prescribed displacements [length] at factor 1, (N,) each."""

    def support(self) -> Support | None:
        """What the load holds in place: a prescribed displacement does, a force does not."""
        return None

    def cases(self, body: ElasticBody, steps: int | None, rows: slice, size: int) -> list[LoadCase]:
        """The load case in a model of ``size`` rows where the body has ``rows``."""
        force, displacement = np.zeros(size), np.zeros(size)
        force[rows], displacement[rows] = self.nodal(body)
        return [
            LoadCase(
                history=sampled(self.history, steps, type(self).__name__),
                force=force,
                displacement=displacement,
                mean=self.mean,
                transient=self.transient,
                range=self.range,
                name=type(self).__name__.lower(),
            )
        ]


@dataclass(frozen=True, eq=False)
class Pressure(Load):
    """Pressure on a boundary, positive into the body [force/length²]; a number or a function of x."""

    boundary: str
    value: Field = 1.0

    def nodal(self, body: ElasticBody) -> tuple[FloatArray, FloatArray]:
        """Consistent nodal forces of −p n."""
        form = LinearForm(lambda v, w: -_field(self.value, w.x) * dot(w.n, v))
        return _assembled(form, body, self.boundary)


@dataclass(frozen=True, eq=False)
class Traction(Load):
    """Traction (x, y[, z]) on a boundary [force/length²]."""

    boundary: str
    value: tuple[Field, ...] = (0.0, 0.0)

    def nodal(self, body: ElasticBody) -> tuple[FloatArray, FloatArray]:
        """Consistent nodal forces."""
        _check_components("Traction", self.value, body)
        form = LinearForm(lambda v, w: sum(_field(t, w.x) * v[a] for a, t in enumerate(self.value)))
        return _assembled(form, body, self.boundary)


@dataclass(frozen=True, eq=False)
class Force(Load):
    """A total force (x, y[, z]), spread evenly over a boundary [force]."""

    boundary: str
    value: tuple[float, ...] = (0.0, 0.0)

    def nodal(self, body: ElasticBody) -> tuple[FloatArray, FloatArray]:
        """Consistent nodal forces of an even traction."""
        _check_components("Force", self.value, body)
        extent = body.thickness * body.extent_of(self.boundary)
        return Traction(self.boundary, tuple(t / extent for t in self.value)).nodal(body)


@dataclass(frozen=True, eq=False)
class BodyForce(Load):
    """Body force (x, y[, z]) [force/length³], on the whole body or on one subdomain."""

    value: tuple[float, ...] = (0.0, 0.0)
    subdomain: str | None = None

    def nodal(self, body: ElasticBody) -> tuple[FloatArray, FloatArray]:
        """Consistent nodal forces."""
        if self.subdomain is not None and self.subdomain not in (body.mesh.subdomains or {}):
            raise ProblemError(f"subdomain '{self.subdomain}': not in the mesh")
        _check_components("BodyForce", self.value, body)
        form = LinearForm(lambda v, w: sum(value * v[a] for a, value in enumerate(self.value)))
        basis = body.basis if self.subdomain is None else body.basis.with_elements(self.subdomain)
        return body.thickness * form.assemble(basis), np.zeros(body.basis.N)


@dataclass(frozen=True, eq=False)
class Displacement(Load):
    """Prescribed displacement of a boundary [length]; ``None`` leaves a direction free."""

    boundary: str
    x: Field | None = None
    y: Field | None = None
    z: Field | None = None

    def nodal(self, body: ElasticBody) -> tuple[FloatArray, FloatArray]:
        """The prescribed values at the nodes of the boundary."""
        displacement = np.zeros(body.basis.N)
        given = (self.x, self.y, self.z)
        if self.z is not None and body.dimension == 2:
            raise ProblemError("Displacement: expected z of a solid only, found a plane body")
        for direction, value in enumerate(given[: body.dimension], start=1):
            if value is not None:
                rows = body.rows_on(self.boundary, direction)
                displacement[rows] = _field(value, body.basis.doflocs[:, rows])
        return np.zeros(body.basis.N), displacement

    def support(self) -> Support:
        """The directions that are prescribed."""
        return Support(self.boundary, self.x is not None, self.y is not None, self.z is not None)


@dataclass(frozen=True, eq=False)
class RollingLoad:
    """Rolling elements, evenly spaced, that run round on a circular boundary of a plane body.

    Each presses with Hertz's half ellipse of pressure over an arc. A period of the loading is the time in
    which every element takes the place of the one in front of it: ``elements`` periods are one revolution
    of the cage.

    Parameters
    ----------
    boundary
        A circle about ``centre``, or an arc of it: the raceway.
    force
        Load of an element in the middle of the load zone, from where it falls as cos^3/2 to nothing at a
        right angle (point contacts without play); or a function of the angle from that middle [force].
    elements
        How many there are.
    half_width
        Of the arc on which an element presses, along the raceway [length].
    direction
        The angle at which the middle of the load zone is, counter-clockwise from the x axis [rad]; below
        the centre by default.
    backwards
        Whether the elements run clockwise.
    centre
        Of the raceway [length].

    Raises
    ------
    ProblemError
        If a size is not positive, or the boundary is no circle about the centre in the plane.

    Notes
    -----
    Nodal forces are ∫ p N ds over the circle, integrated between the ends of facets, where N is smooth: they
    converge with the mesh however narrow the arc is. N is taken at the same share of the facet as of its arc.

    Examples
    --------
    >>> from shakedown.fem import ElasticBody, Material, ring_mesh
    >>> ring = ElasticBody(ring_mesh(35.0, 40.0, 32, 2), Material(206e3, 0.3), thickness=18.0)
    >>> force = RollingLoad("inside", force=3e3, elements=8, half_width=0.3).nodal(ring, 0.0)
    >>> round(float(force.reshape(-1, 2).sum(axis=0)[1]), 2)  # about 3000 (1 + 2 cos^5/2 45°)
    -5522.64
    """

    boundary: str
    force: float | Callable[[FloatArray], FloatArray]
    elements: int
    half_width: float
    direction: float = -np.pi / 2
    backwards: bool = False
    centre: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        check_fields(self, ProblemError)
        if self.elements < 1 or not 0 < self.half_width < np.inf:
            raise ProblemError(
                "RollingLoad: expected elements >= 1 and a finite half_width > 0, found "
                f"{self.elements}, {self.half_width}"
            )

    def support(self) -> None:
        """It holds nothing in place."""

    def cases(self, body: ElasticBody, steps: int | None, rows: slice, size: int) -> list[LoadCase]:
        """One load case for each load step, which acts at this step alone."""
        if steps is None:
            raise ProblemError("RollingLoad: steps: needed to place the elements, found none")
        found = []
        for k, history in enumerate(np.eye(steps)):
            force = np.zeros(size)
            force[rows] = self.nodal(body, k / steps)
            found.append(LoadCase(history=history, force=force, name=f"rolling elements at load step {k}"))
        return found

    def nodal(self, body: ElasticBody, t: float) -> FloatArray:
        """Consistent nodal forces (N,) at a time t, in periods."""
        radius, outwards, facets = self._raceway(body)
        arc = self.half_width / radius  # half the angle that is loaded
        if not arc < np.pi / self.elements:
            raise ProblemError(
                f"RollingLoad: half_width: expected less than {np.pi * radius / self.elements:.3g}, where "
                f"the elements' arcs meet, found {self.half_width}"
            )
        row = np.full((int(body.dofs[:, 0].max()) + 1, 3), -1)
        row[body.dofs[:, 0], body.dofs[:, 1]] = np.arange(body.basis.N)
        points, weights = np.polynomial.legendre.leggauss(12)  # on each piece of a facet
        found, sense = np.zeros(body.basis.N), -1.0 if self.backwards else 1.0
        from_middle = sense * 2 * np.pi * (np.arange(self.elements) + t) / self.elements
        from_middle = _within_half_a_turn(from_middle)
        if callable(self.force):
            forces = np.asarray(self.force(from_middle), dtype=float)
        else:
            forces = self.force * np.clip(np.cos(from_middle), 0.0, None) ** 1.5
        for angle, force in zip(from_middle.tolist(), forces.tolist(), strict=True):
            for start, extent, nodes in facets:
                low = _within_half_a_turn(start + 0.5 * extent - self.direction - angle) - 0.5 * extent
                # s = b sin φ turns the half ellipse 2 F / (π b) √(1 − s²/b²) ds into 2 F / π cos² φ dφ
                ends = np.arcsin(np.clip([low / arc, (low + extent) / arc], -1.0, 1.0))
                if not force or ends[1] <= ends[0]:
                    continue
                phi = ends.mean() + 0.5 * np.ptp(ends) * points
                pressing = force / np.pi * np.ptp(ends) * weights * np.cos(phi) ** 2
                turn, share = arc * np.sin(phi), (arc * np.sin(phi) - low) / extent
                at = self.direction + angle + turn
                towards = outwards * np.array([np.cos(at), np.sin(at)])
                for node, shape in zip(nodes, shapes((2, len(nodes)), 2 * share[:, None] - 1).T, strict=True):
                    found[row[node, 1:]] += towards @ (pressing * shape)
        return found

    def _raceway(self, body: ElasticBody) -> tuple[float, float, list[tuple[float, float, list[int]]]]:
        """Radius; 1 where the body is outside of the circle, else −1; start, extent, nodes of each facet."""
        if body.dimension != 2:
            raise ProblemError("RollingLoad: expected a plane body, found a solid one")
        surface = body.surface(self.boundary)
        ends = [facet[:2] for facet in surface.facets]
        arm = body.positions(np.unique(ends)) - self.centre
        radii = np.hypot(*arm.T)
        radius = float(radii.mean())
        if np.ptp(radii) > SIX_DIGITS * radius:
            raise ProblemError(
                f"RollingLoad: boundary '{self.boundary}': expected a circle about {self.centre}, found "
                f"radii from {radii.min():.6g} to {radii.max():.6g}"
            )
        facets = []
        for nodes in surface.facets:
            angles = np.arctan2(*(body.positions(np.array(nodes[:2])) - self.centre).T[::-1])
            extent = float(_within_half_a_turn(angles[1] - angles[0]))
            if extent < 0:
                nodes, angles, extent = [nodes[1], nodes[0], *nodes[2:]], angles[::-1], -extent
            facets.append((float(angles[0]), extent, nodes))
        outside = np.hypot(*(surface.inside - self.centre).T)
        return radius, 1.0 if outside.mean() > radius else -1.0, facets


def _within_half_a_turn(angle: Any) -> Any:
    """Angles brought into [−π, π)."""
    return (np.asarray(angle) + np.pi) % (2 * np.pi) - np.pi


def sampled(history: History | None, steps: int | None, what: str) -> ArrayLike | None:
    """A time function at t = k/m, in periods; anything else is returned unchanged."""
    if not callable(history):
        return history
    if steps is None:
        raise ProblemError(f"{what}: steps: needed to sample a time function, found none")
    return history(np.arange(steps) / steps)


def _check_components(kind: str, value: tuple[object, ...], body: ElasticBody) -> None:
    if len(value) != body.dimension:
        raise ProblemError(
            f"{kind}: expected one component for each of {body.dimension} directions, found {len(value)}"
        )


def _field(value: Field, x: FloatArray) -> FloatArray | float:
    return value(x) if callable(value) else value


def _assembled(form: LinearForm, body: ElasticBody, boundary: str) -> tuple[FloatArray, FloatArray]:
    return body.thickness * form.assemble(body.facet_basis(boundary)), np.zeros(body.basis.N)


@dataclass(frozen=True, kw_only=True, eq=False)
class Bolt:
    """A pair of patches that a bolt pulls towards each other.

    The force F = preload + stiffness · elongation acts as an even pressure on both patches; the elongation
    is by how much the bodies push the patches apart on average, along the patches' normals.

    Parameters
    ----------
    head
        Boundary of the first body, under the bolt's head.
    nut
        Boundary of the second body; None where the bolt is screwed into something rigid.
    preload
        The force before anything else acts [force].
    stiffness
        Stiffness of the shank, ≥ 0 [force/length]; with 0 the force stays what it is.
    history
        Time function of the preload, as for :class:`~shakedown.fem.Load`; constant by default.

    Examples
    --------
    >>> Bolt(head="washer", nut="thread", preload=12e3).stiffness
    0.0
    """

    head: str
    nut: str | None = None
    preload: float = 0.0
    stiffness: float = 0.0
    history: History = 1.0

    def __post_init__(self) -> None:
        check_fields(self, ProblemError)
        if not (np.isfinite(self.preload) and np.isfinite(self.stiffness) and self.stiffness >= 0):
            raise ProblemError(
                f"Bolt: expected a finite preload and a stiffness >= 0, found {self.preload}, "
                f"{self.stiffness}"
            )

    def shortening(self, bodies: Sequence[ElasticBody], starts: Sequence[int], size: int) -> FloatArray:
        """e of the shortening e · u of the bolt, (size,): the mean motion of both patches inwards.

        Raises
        ------
        ProblemError
            If there is a nut and no second body, or a patch is not on its body.
        """
        patches = [name for name in (self.head, self.nut) if name is not None]
        if len(patches) > len(bodies):
            raise ProblemError(f"bolt '{self.head}': expected no nut on a rigid obstacle, found '{self.nut}'")
        found, inwards = np.zeros(size), LinearForm(lambda v, w: -dot(w.n, v))
        for body, start, name in zip(bodies, starts, patches, strict=False):
            pull = inwards.assemble(body.facet_basis(name)) / body.extent_of(name)
            found[start : start + body.basis.N] += pull
        return found


@dataclass(frozen=True, eq=False, repr=False)
class ModalLoad(Result):
    """The inertia forces M φ of a mode, as a load (:func:`modal_load`).

    Attributes
    ----------
    mode
        Its number, from 0; rigid motions of a free structure are left out.
    frequency
        Circular frequency ω of the mode with the contact stuck [1/time].
    shape : (N,)
        φ, the displacements of all bodies, φᵀ M φ = 1 [1/√mass].
    force : (N,)
        M φ [√mass].
    free
        Whether nothing supports the structure.
    history
        Time function of the modal force α; one sine in a period by default.
    """

    mode: int
    frequency: float
    shape: FloatArray
    force: FloatArray
    free: bool
    history: History


def sine(t: FloatArray) -> FloatArray:
    """One sine in a period."""
    return np.sin(2.0 * np.pi * t)


def mass_of(body: ElasticBody) -> sparse.csr_array:
    """The consistent mass matrix of a body, (N, N) [mass].

    Raises
    ------
    ProblemError
        If a material has no density.
    """
    if any(material.density is None for material, _ in body.parts()):
        raise ProblemError("material: expected a density for a mode, found none")
    return body.integrated(lambda material: BilinearForm(lambda u, v, w: material.density * dot(u, v)))


def stuck_mode(
    K: sparse.csr_array, M: sparse.csr_array, motions: sparse.csr_array, number: int, rigid: int
) -> tuple[float, FloatArray]:
    """Circular frequency and shape φ (N,), φᵀ M φ = 1, of a mode; the first ``rigid`` ones do not count.

    The shape is a combination of the columns of ``motions``, (N, k).

    Raises
    ------
    ProblemError
        If there are not so many modes.
    SolverError
        If it is not found.
    """
    K, M = sparse.csc_array(motions.T @ K @ motions), sparse.csc_array(motions.T @ M @ motions)
    count = number + rigid + 1
    if number < 0 or count >= K.shape[0]:
        raise ProblemError(f"mode: expected a number from 0 to {K.shape[0] - rigid - 2}, found {number}")
    shift = -NEGLIGIBLE * K.trace() / M.trace() if rigid else 0.0  # makes K of a free structure regular
    start = np.random.default_rng(0).random(K.shape[0])  # of no symmetry, and the same every time
    try:
        values, vectors = eigsh(K, count, M, sigma=shift, v0=start)
    except ArpackNoConvergence as error:
        raise SolverError(f"mode {number}: not found ({error})") from None
    chosen = np.argsort(values)[-1]
    shape = motions @ vectors[:, chosen]
    largest = shape[np.abs(shape).argmax()]
    return float(np.sqrt(values[chosen])), np.asarray(shape * np.sign(largest))


def determinate_rows(dofs: IntArray, places: Mapping[int, Sequence[float]], candidates: IntArray) -> IntArray:
    """Rows far apart that hold a free structure, statically determinate: three in a plane, six in space.

    Loads in equilibrium cause no force there, so that the choice does not change any result.
    """
    where = np.array([places[node] for node in dofs[candidates, 0].tolist()])
    motion = rigid_motion(where)[np.arange(len(candidates)), dofs[candidates, 1] - 1]
    *_, order = qr(motion.T, mode="economic", pivoting=True)
    return np.sort(candidates[order[: motion.shape[1]]])


def check_balanced(cases: Sequence[LoadCase], places: FloatArray, direction: IntArray) -> None:
    """Raise ``ProblemError`` unless the loads of a free structure are together in equilibrium at every step.

    ``places`` (N, 2) or (N, 3) and ``direction`` (N,) of the rows of the forces.
    """
    motion, factors = rigid_motion(places)[np.arange(len(places)), direction - 1], histories(cases)
    forces = np.array([case.force for case in cases])
    known = [part for part in (factors.period, factors.mean, factors.transient) if part is not None]
    steps = np.vstack(known)
    left = np.abs(steps @ (forces @ motion)).max(axis=1)
    # what may be left of a resultant, relative to the forces
    if (left > SIX_DIGITS * (np.abs(steps) @ np.abs(forces).sum(axis=1))).any():
        raise ProblemError(
            "loads: expected loads in equilibrium, as nothing supports the bodies, found a resultant of "
            f"{left.max():.3g} (add a Support, or a load that balances the others)"
        )
