"""Bolts: a preload that pulls two patches of a joint together, and a shank that stretches."""

from dataclasses import dataclass

import numpy as np
from skfem import LinearForm
from skfem.helpers import dot

from shakedown.fem.body import ElasticBody
from shakedown.fem.loads import History
from shakedown.ground.argument_kinds import check_fields
from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray


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
        Boundary of the second body; none where the bolt is screwed into something rigid.
    preload
        The force before anything else acts [force].
    stiffness
        Of the shank, ≥ 0 [force/length]; 0: the force stays what it is.
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

    def shortening(self, bodies: tuple[ElasticBody, ...], starts: tuple[int, ...], size: int) -> FloatArray:
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
