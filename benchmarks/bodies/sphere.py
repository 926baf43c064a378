"""A sphere on a flat, pushed to and fro (Hertz, Cattaneo, Mindlin).

Two elastic half-spaces of the same material, so that pressure and shear are not coupled (B = 0). The units
are the normal force, the radius of the contact under it and Young's modulus: all three are 1.
"""

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from benchmarks.bodies.patch_compliance import mean_half_space_compliance
from shakedown import Problem
from shakedown.ground.constants import FloatArray

CHORD = np.deg2rad(12.0)  # longest arc that a straight edge stands for
SECTORS = 6  # of the first ring; the k-th has k times as many


def sphere_on_flat(
    rings: int = 4,  # rings around the middle patch: 1 + 3 rings (rings + 1) patches
    *,
    shear: float = 0.8,  # largest tangential force over f N [–]
    direction: float = 0.0,  # of the force, from the x axis [rad]
    f: float = 0.5,  # friction coefficient [–]
    poisson: float = 0.0,  # of both bodies [–]
) -> Problem:
    """A sphere pressed on a flat, then pushed to and fro along it (Cattaneo, Mindlin); similar materials.

    The contact is the disc of Hertz's solution with his pressure, cut into rings of 1, 6, 12, … patches of
    uniform traction, whose mean displacements follow (:func:`mean_half_space_compliance`). The bodies are
    moved by forces: a rigid translation along the flat meets no resistance but friction. Load steps 0, F, 0,
    -F of a tangential force F of ``shear`` · f N, which the load factor multiplies. :func:`sphere_contact`
    gives the classical solution, exact for ``poisson`` = 0: else slip is not quite opposite to the traction.

    Examples
    --------
    >>> joint = sphere_on_flat(2, shear=0.6, direction=0.4)
    >>> joint.n, joint.directions
    (19, 2)
    >>> forces = joint.q_w.reshape(4, 19, 2).sum(axis=1)  # on the sphere: the other way
    >>> (-forces[1] / 0.3).round(6)  # of f N = 0.5
    array([0.921061, 0.389418])
    """
    patches, edges = disc_patches(rings)
    along, _ = half_spaces(patches, poisson)
    share = np.diff(_within(edges))
    counts = np.array([1, *(SECTORS * k for k in range(1, rings + 1))])
    force = shear * f * np.array([np.cos(direction), np.sin(direction)])
    pressed = np.repeat(share / counts, counts)
    n = len(pressed)
    return Problem(
        A=along.stiffness, B=np.zeros((n, 2 * n)), f=f,
        q_w=np.outer([0.0, -1.0, 0.0, 1.0], along.reactions @ force), p_w=np.tile(pressed, (4, 1)),
        q_mean=np.zeros(2 * n), x=np.array([patch.mean(axis=0) for patch in patches]),
        node_area=np.repeat(np.pi * np.diff(edges**2) / counts, counts),
        name="sphere on a flat",
    )  # fmt: skip


def disc_patches(rings: int) -> tuple[list[FloatArray], FloatArray]:
    """The unit disc cut into a middle and rings of 6, 12, 18, … patches, narrower towards the edge.

    Radii are sines of equal steps: pressure and shear fall to zero with a vertical tangent there. Every arc
    is replaced by chords further out, by so much that the patch keeps its area.

    Returns
    -------
    patches : n of (c, 2)
        Corners, ring by ring from the middle.
    edges : (rings + 2,)
        Radii between the rings, from 0 to 1.
    """
    edges = np.sin(np.pi / 2 * np.concatenate([[0.0], (np.arange(rings + 1) + 0.5) / (rings + 0.5)]))
    found = []
    for k, (inner, outer) in enumerate(pairwise(edges)):
        sectors = max(SECTORS * k, 1)
        wide = 2 * np.pi / sectors
        chords = int(np.ceil(wide / CHORD))
        stretch = np.sqrt((wide / chords) / np.sin(wide / chords))
        for sector in range(sectors):
            angle = wide * (sector - 0.5 + np.arange(chords + 1) / chords)
            arc = stretch * np.column_stack([np.cos(angle), np.sin(angle)])
            found.append(np.concatenate([inner * arc[::-1], outer * arc]) if k else outer * arc[:-1])
    return found, edges


class SphereContact(NamedTuple):
    """Hertz's contact of a sphere under the normal force 1 with radius 1, and tangential forces T in turn.

    Cattaneo's and Mindlin's solution for the first push, Mindlin's and Deresiewicz's for the cycles; forces
    over the normal force, lengths over the contact's radius.
    """

    f: float  # friction coefficient [–]
    compliance: float  # of the tangential approach, both bodies: (2 − ν)/4 G a, before anything slips

    def pressure(self, r: FloatArray) -> FloatArray:
        """3/2π √(1 − r²)."""
        return 1.5 / np.pi * np.sqrt(np.maximum(1 - np.square(r), 0.0))

    def stick(self, force: float) -> float:
        """Radius (1 − T/f)^⅓ of the zone that sticks."""
        return float(np.cbrt(max(1 - force / self.f, 0.0)))

    def held_back(self, edges: FloatArray, force: float) -> FloatArray:
        """Tangential force between radii (k,): f times Hertz's, less c³ times that of radius c (k − 1,)."""
        c = self.stick(force)
        inner = c**3 * _within(np.minimum(edges / c, 1.0)) if c > 0 else np.zeros(len(edges))
        return self.f * np.diff(_within(edges) - inner)

    def displacement(self, force: float) -> float:
        """Of the bodies by a first push: 3/2 f · compliance · (1 − (1 − T/f)^⅔)."""
        return 1.5 * self.f * self.compliance * (1 - self.stick(force) ** 2)

    def dissipation(self, force: float) -> float:
        """Friction work of a cycle between ±T."""
        share, stick = force / self.f, self.stick(force)
        return 7.2 * self.f**2 * self.compliance * (1 - stick**5 - 5 / 6 * share * (1 + stick**2))


def sphere_contact(f: float = 0.5, poisson: float = 0.0) -> SphereContact:
    """The classical solution for :func:`sphere_on_flat`; exact for ``poisson`` = 0.

    Johnson, Contact Mechanics, (7.41), (7.42a) and (7.53), for two bodies of the same material.

    Examples
    --------
    >>> contact = sphere_contact(0.5)
    >>> round(contact.stick(0.4375), 6), round(contact.displacement(0.4375), 6)
    (0.5, 0.5625)
    """
    return SphereContact(f, (2 - poisson) * (1 + poisson) / 2)


class _Floating(NamedTuple):
    """Bodies that forces hold, and friction: a stiffness without resistance to rigid translations."""

    stiffness: FloatArray  # (k, k): reactions by slips or gaps; the translations follow
    reactions: FloatArray  # (k, d): by unit forces along the translations


def _floating(compliance: FloatArray, translations: FloatArray) -> _Floating:
    """Bodies with this relative compliance (k, k), free to translate (k, d)."""
    stiffness = np.linalg.inv(compliance)
    moved = stiffness @ translations
    reactions = np.linalg.solve(translations.T @ moved, moved.T).T
    found = stiffness - reactions @ moved.T
    return _Floating(np.asarray(0.5 * (found + found.T)), np.asarray(reactions))


def disc_compliance(rings: int) -> FloatArray:
    """Of the patches of a disc by tangential forces, both bodies, Poisson's ratio 0, (2n, 2n)."""
    whole = mean_half_space_compliance(disc_patches(rings)[0], poisson=0.0)
    along = np.arange(len(whole)).reshape(-1, 3)[:, :2].ravel()
    return 2 * whole[np.ix_(along, along)]


def half_spaces(patches: list[FloatArray], poisson: float) -> tuple[_Floating, _Floating]:
    """Two half-spaces of the same material, along and across the contact: not coupled, twice as compliant."""
    one = mean_half_space_compliance(patches, poisson=poisson)
    n = len(patches)
    each = np.arange(3 * n).reshape(n, 3)
    along, across = each[:, :2].ravel(), each[:, 2]
    return (
        _floating(2 * one[np.ix_(along, along)], np.tile(np.eye(2), (n, 1))),
        _floating(2 * one[np.ix_(across, across)], np.ones((n, 1))),
    )


def _within(r: FloatArray) -> FloatArray:
    """Share of Hertz's force within a radius, which is 1 at most."""
    return 1 - (1 - np.square(r)) ** 1.5
