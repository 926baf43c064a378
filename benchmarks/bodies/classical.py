"""Contacts with a classical solution: a press fit (Lamé), a cylinder on a flat (Hertz, Cattaneo, Mindlin)."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from skfem import MeshQuad

from shakedown import Problem
from shakedown.fem import Displacement, ElasticBody, Material, Support, Traction, block_mesh, contact_problem
from shakedown.ground.constants import FloatArray

HOLE, FIT, OUTSIDE = 0.4, 1.0, 2.0  # radii of the press fit [mm]
YOUNG, POISSON = 200e3, 0.3  # of the press fit [MPa]; of all bodies [–]


def press_fit(
    refinement: int = 1,  # multiplies the elements; the contact has 8 · refinement + 1 nodes
    *,
    interference: float = 1e-3,  # radial interference [mm]
) -> Problem:
    """A hollow shaft pressed into a hub, pulled to and fro: one quarter, plane strain, f = 0.2.

    Radii 0.4, 1 and 2 mm; the shaft is larger than the bore by ``interference`` (on the
    radius). Tractions ±60 MPa · (cos θ, 0) on the outside of the hub ovalise it; the
    pressure of the fit alone is that of Lamé (:func:`press_fit_pressure`).

    Examples
    --------
    >>> press_fit().n
    9
    """
    material, along = Material(YOUNG, POISSON), 8 * refinement
    traction = Traction(
        "outside",
        (lambda x: x[0] / np.hypot(x[0], x[1]), 0.0),
        history=lambda t: 60.0 * np.cos(2 * np.pi * t),
    )
    planes = [Support("floor", x=False, y=True), Support("wall", x=True, y=False)]
    shaft = ElasticBody(_ring(HOLE, FIT, 4 * refinement, along), material, supports=planes)
    hub = ElasticBody(_ring(FIT, OUTSIDE, 6 * refinement, along), material, supports=planes, loads=[traction])
    return contact_problem(
        shaft, "outside", 0.2, against=(hub, "inside"), gap=-interference, steps=24,
        name="press fit, one quarter", units="N, mm",
    )  # fmt: skip


def press_fit_pressure(interference: float) -> float:
    """Lamé's pressure between the shaft and the hub of :func:`press_fit` [MPa].

    Both expand by p a / E′ (k ± ν′) with E′ = E/(1 − ν²), ν′ = ν/(1 − ν) in plane strain;
    the two expansions make up the interference.
    """
    plane = YOUNG / (1 - POISSON**2)
    hub = (OUTSIDE**2 + FIT**2) / (OUTSIDE**2 - FIT**2)
    shaft = (FIT**2 + HOLE**2) / (FIT**2 - HOLE**2)
    return interference * plane / (FIT * (hub + shaft))


def _ring(inside: float, outside: float, across: int, along: int) -> MeshQuad:
    """A quarter ring with boundaries inside, outside, floor (θ = 0) and wall (θ = π/2)."""
    block = block_mesh(outside - inside, np.pi / 2, across, along)
    named = {"inside": "left", "outside": "right", "floor": "bottom", "wall": "top"}
    r, angle = block.p[0] + inside, block.p[1]
    points = np.vstack([r * np.cos(angle), r * np.sin(angle)])
    points[0, np.isclose(angle, np.pi / 2)] = 0.0  # on the plane of symmetry, exactly
    facets = block.boundaries or {}
    return replace(
        block,
        doflocs=np.ascontiguousarray(points),
        _boundaries={name: facets[side] for name, side in named.items()},
    )


RADIUS, APPROACH = 20.0, 0.105  # of the cylinder [length]
CANDIDATE, FAR = 1.5, 100.0  # half-widths of the candidate contact, of the bodies


def cylinder_on_flat(
    refinement: int = 1,  # multiplies the elements in the contact, 12 · refinement of them
    *,
    shift: float = 0.028,  # displacement of the far side [length]; the half-width of the contact is about 1
    f: float = 0.3,  # friction coefficient [–]
    steps: int = 24,  # load steps of one period
    # swing, phase: the approach varies by this share, as sin 2π(t + phase), t in periods [–]
    swing: float = 0.0,
    phase: float = 0.0,
) -> Problem:
    """A cylinder pressed onto a flat, then moved to and fro along it; similar materials, plane strain.

    Both bodies are blocks, many times wider than the contact, with the initial gap
    x²/2R between them (Hertz). The far side of the upper one comes nearer in twelve
    transient load steps, then moves sideways by ``shift`` · sin over the period.
    Young's modulus is 1.

    Examples
    --------
    >>> cylinder_on_flat().n
    13
    """
    side, depth = _graded(refinement), _graded(refinement, start=0.0)
    across = np.concatenate(
        [-side[::-1], np.linspace(-CANDIDATE, CANDIDATE, 12 * refinement + 1)[1:-1], side]
    )
    pressed = 1 + swing * np.sin(2 * np.pi * phase)
    loads = [
        Displacement("far", x=0.0, y=-APPROACH, history=lambda t: 1 + swing * np.sin(2 * np.pi * (t + phase)),
                     transient=pressed * np.arange(1, 13) / 12),
        Displacement("far", x=shift, y=0.0, history=lambda t: np.sin(2 * np.pi * t),
                     transient=np.zeros(12)),
    ]  # fmt: skip
    material = Material(1.0, POISSON)
    upper = ElasticBody(_half_plane(across, depth), material, loads=loads)
    lower = ElasticBody(_half_plane(across, -depth[::-1]), material, supports=[Support("far")])
    return contact_problem(
        upper, "contact", f, against=(lower, "contact"), gap=lambda x: x[0] ** 2 / (2 * RADIUS),
        steps=steps, name="cylinder on a flat",
    )  # fmt: skip


def _graded(refinement: int, start: float = CANDIDATE) -> FloatArray:
    """Grid from ``start`` to FAR whose steps grow from the size in the contact."""
    step, growth, points = 0.25 / refinement, 1.0 + 0.3 / refinement, [start]
    while points[-1] < FAR:  # ends: the steps grow
        points.append(points[-1] + step)
        step *= growth
    return start + (np.array(points) - start) * (FAR - start) / (points[-1] - start)


def _half_plane(x: FloatArray, y: FloatArray) -> MeshQuad:
    """A block with boundaries contact (y = 0, |x| ≤ CANDIDATE) and far."""
    return MeshQuad.init_tensor(x, y).with_boundaries(
        {
            "contact": lambda p: (np.abs(p[1]) < 1e-9) & (np.abs(p[0]) < CANDIDATE),
            "far": lambda p: np.abs(p[1]) > FAR - 1e-9,
        }
    )


class Hertz(NamedTuple):
    """Line contact of a cylinder on a flat under the normal force P per length, and a first shear Q."""

    half_width: float  # a = √(4 P R / π E*) [length]
    peak: float  # p₀ = 2 P / π a [force/length²]
    stick: float  # half-width c = a √(1 − Q / f P) of the zone that sticks (Cattaneo, Mindlin) [length]

    def pressure(self, x: FloatArray) -> FloatArray:
        """p₀ √(1 − x²/a²) [force/length²]."""
        return self.peak * np.sqrt(np.maximum(1 - (x / self.half_width) ** 2, 0.0))

    def shear(self, x: FloatArray, f: float) -> FloatArray:
        """Shear traction f p − f p₀ (c/a) √(1 − x²/c²) [force/length²]."""
        inner = np.sqrt(np.maximum(1 - (x / self.stick) ** 2, 0.0)) if self.stick > 0 else 0.0
        return f * (self.pressure(x) - self.peak * self.stick / self.half_width * inner)


def hertz(normal: float, shear: float = 0.0, f: float = 0.3) -> Hertz:
    """The classical solution for :func:`cylinder_on_flat`, E* = E / 2(1 − ν²)."""
    modulus = 1.0 / (2 * (1 - POISSON**2))
    a = float(np.sqrt(4 * normal * RADIUS / (np.pi * modulus)))
    return Hertz(a, 2 * normal / (np.pi * a), a * float(np.sqrt(max(1 - shear / (f * normal), 0.0))))
