"""Loads on an elastic body, each with its own time function, and bolts between two bodies."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from skfem import LinearForm
from skfem.helpers import dot

from shakedown.fem.body import ElasticBody, Support
from shakedown.ground.argument_kinds import check_fields
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.models.condensation.load_case import LoadCase

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

    def sampled(self, steps: int | None) -> ArrayLike | None:
        """The factor at the load steps, if there is a history; ``steps`` is needed where it is a function."""
        return sampled(self.history, steps, type(self).__name__)

    def case(self, body: ElasticBody, steps: int | None, rows: slice, size: int) -> LoadCase:
        """The load case in a model of ``size`` rows where the body has ``rows``."""
        force, displacement = np.zeros(size), np.zeros(size)
        force[rows], displacement[rows] = self.nodal(body)
        return LoadCase(
            history=self.sampled(steps),
            force=force,
            displacement=displacement,
            mean=self.mean,
            transient=self.transient,
            range=self.range,
            name=type(self).__name__.lower(),
        )


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
