"""A blade in its slot: a dovetail root in three dimensions, pulled onto two inclined flanks."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex

from benchmarks.bodies.extrusion import extruded, grid
from benchmarks.implicit_steps import ImplicitSteps
from shakedown import Problem
from shakedown.fem import BodyForce, ElasticBody, Force, Material, Support, Traction, contact_problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading

# Heights of the bottom, the flanks' ends, the slot's rim and the tip, and half of the thickness there.
HEIGHTS, HALVES = (0.0, 6.0, 14.0, 18.0, 70.0), (12.0, 12.0, 6.0, 6.0, 2.5)  # [mm]
DEPTH, OUTER, ROOM = 40.0, 26.0, 0.5  # length of the slot; half of the disc's piece; beside the flanks [mm]
YOUNG, DENSITY, RADIUS = 210e3, 7.85e-9, 300.0  # [N/mm²], [t/mm³], of the root from the shaft [mm]
LAYERS = (2, 1, 6)  # elements below the flanks, above them within the slot, along the blade
SPEED = 8000.0  # of the rotor [1/min]; the acceleration is taken at the root, all over the blade
OVERSPEED = 1.1  # largest speed before the vibration begins, in units of SPEED
SPIN = 8  # load steps from rest to the overspeed, and half as many from there to the speed
ACROSS, POST = 6, 4  # through the root, through each post of the disc


def blade_root(
    # along a flank, and along the slot. There are 2 (flank + 1) (slot + 1) node pairs, 234 by default
    elements: tuple[int, int] = (8, 12),
    steps: int = 24,  # load steps of one period
) -> Problem:
    """A blade whose dovetail root is pulled onto both flanks of its slot by its own weight in rotation.

    The flanks lean by 37° from the radius. The pull is the mean load, the vibration of the blade the cyclic
    one: a force at its tip across the slot, 200 N · sin t, and a moment about the radius, 4 N m · sin 2t.
    The flanks carry the blade; along the slot friction alone holds it, f = 0.3. The disc is held at its sides
    and below. Steel. Slips are those of the root relative to the disc, the first along the slot.

    The root slips out along both flanks until they carry it. ``initial_slip`` is the state after the rotor
    has once run faster than it does: slip zero, the welded joint, has tension at the inner ends of both.

    Examples
    --------
    >>> joint = blade_root((2, 3), steps=8)
    >>> joint.n, joint.directions, joint.load_names
    (24, 2, ('bodyforce', 'force', 'traction'))
    """
    flank, slot = elements
    steel = Material(YOUNG, 0.3)
    weight = DENSITY * (2 * np.pi * SPEED / 60) ** 2 * RADIUS
    second_moment = 2 * HALVES[-1] * DEPTH**3 / 12
    loads = [
        BodyForce((0.0, weight, 0.0), history=1.0),
        Force("tip", (200.0, 0.0, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
        Traction(
            "tip",
            (lambda x: 4e3 / second_moment * (x[2] - 0.5 * DEPTH), 0.0, 0.0),
            history=lambda t: np.sin(4 * np.pi * t),
        ),
    ]
    blade = ElasticBody(_blade(flank, slot), steel, loads=loads)
    disc = ElasticBody(_disc(flank, slot), steel, supports=[Support("outer"), Support("below")])
    joint = contact_problem(
        blade,
        "flanks",
        0.3,
        against=(disc, "flanks"),
        tangent=(0.0, 0.0, 1.0),
        steps=steps,
        name="dovetail root of a blade",
        units="N, mm",
    )
    return replace(joint, initial_slip=_spun(joint))


def _spun(joint: Problem) -> FloatArray:
    """The slips once the mean load has risen from nothing to that at the overspeed, and fallen to itself."""
    (q, p), most = loading(joint).at(0.0), OVERSPEED**2
    up = most * np.arange(SPIN + 1) / SPIN
    factors = np.concatenate([up, np.linspace(most, 1.0, SPIN // 2 + 1)[1:]])[:, None]
    steps = ImplicitSteps(joint.kappa, joint.f, 2, float(np.abs(p[0]).max()))
    nothing = np.zeros(joint.layout.slip_size), np.zeros(joint.n)
    return steps.follow(*nothing, factors * q[0], factors * p[0]).v[-1]


def _rows(layers: tuple[int, ...]) -> FloatArray:
    """Heights of the rows of nodes, so many elements between each two of :data:`HEIGHTS`."""
    parts = [np.linspace(a, b, n + 1)[1:] for a, b, n in zip(HEIGHTS, HEIGHTS[1:], layers, strict=False)]
    return np.concatenate([[HEIGHTS[0]], *parts])


def _half(y: FloatArray) -> FloatArray:
    return np.asarray(np.interp(y, HEIGHTS, HALVES))


def _blade(flank: int, slot: int) -> MeshHex:
    rows = _rows((LAYERS[0], flank, *LAYERS[1:]))
    place = np.linspace(-1.0, 1.0, ACROSS + 1)
    points = np.array([(_half(rows)[:, None] * place).ravel(), np.repeat(rows, ACROSS + 1)])
    return _drawn_out(points, grid(ACROSS, len(rows) - 1), slot).with_boundaries(
        {"flanks": _on_flanks, "tip": lambda x: np.abs(x[1] - HEIGHTS[-1]) < 1e-9 * HEIGHTS[-1]}
    )


def _disc(flank: int, slot: int) -> MeshHex:
    """Both posts of the disc beside the slot."""
    rows = _rows((LAYERS[0], flank, LAYERS[1]))
    touching = (rows > HEIGHTS[1] * (1 - 1e-9)) & (rows < HEIGHTS[2] * (1 + 1e-9))
    inner = _half(rows) + np.where(touching, 0.0, ROOM)
    place = np.linspace(0.0, 1.0, POST + 1)
    x = (inner[:, None] + place * (OUTER - inner[:, None])).ravel()
    right, quads = np.array([x, np.repeat(rows, POST + 1)]), grid(POST, len(rows) - 1)
    points = np.hstack([right, right * [[-1.0], [1.0]]])
    mesh = _drawn_out(points, np.hstack([quads, quads[::-1] + len(x)]), slot)
    return mesh.with_boundaries(
        {
            "flanks": _on_flanks,
            "outer": lambda x: np.abs(np.abs(x[0]) - OUTER) < 1e-9 * OUTER,
            "below": lambda x: np.abs(x[1]) < 1e-9 * OUTER,
        }
    )


def _drawn_out(points: FloatArray, quads: NDArray[np.intp], slot: int) -> MeshHex:
    levels = np.linspace(0.0, DEPTH, slot + 1)
    return extruded(points, quads, levels, np.ones((slot, quads.shape[1]), bool))


def _on_flanks(x: FloatArray) -> FloatArray:
    return (x[1] > HEIGHTS[1]) & (x[1] < HEIGHTS[2]) & (np.abs(np.abs(x[0]) - _half(x[1])) < 1e-9 * OUTER)
