"""One sector of a pair of ring flanges, with its bolt."""

import itertools

import numpy as np
from numpy.typing import NDArray
from skfem import MeshHex

from benchmarks.bodies.extrusion import extruded
from shakedown import Problem
from shakedown.fem import Bolt, ElasticBody, Force, Material, Support, contact_problem
from shakedown.ground.constants import FloatArray

BOLTS, CIRCLE = 30, 300.0  # in the whole ring; radius of the circle on which they are [mm]
HALF = 32.0  # of the flange from the bolt inwards, and outwards to the wall of the pipe [mm]
HOLE, PAD, WASHER, SHANK = 13.0, 26.0, 22.0, 24.0  # radii; of the shank the diameter [mm]
THICK, WALL, PIPE = 40.0, 12.0, 80.0  # of the flange, of the pipe's wall; length of the pipe [mm]
YOUNG = 210e3
RINGS, THROUGH, UP = 2, 2, 4  # elements from the pad to the outline, through the wall, along the pipe


def bolted_flange(
    # around the hole (a multiple of 8), across the ring of contact, over the thickness of a flange. There
    # are around · (across + 1) node pairs, 168 by default
    elements: tuple[int, int, int] = (24, 6, 5),
    steps: int = 24,  # load steps of one period
) -> Problem:
    """One of thirty sectors of a pair of ring flanges, held together by its bolt on a ring around the hole.

    The wall of the pipe, outside the circle of bolts, is pulled and pressed as a pipe in bending does, by
    2 kN · cos t, and sheared along the circumference as in torsion, by 4 kN · sin t. The lower pipe is held,
    the sides of the sector are free, as in a test of a segment. An M24 with 150 kN; steel, f = 0.3. Slips
    are those of the upper flange relative to the lower one, along the radius through the bolt and across it.

    Examples
    --------
    >>> joint = bolted_flange((8, 2, 2), steps=8)
    >>> joint.n, joint.directions, joint.load_names
    (24, 2, ('force', 'force', 'bolt'))
    """
    steel = Material(YOUNG, 0.3)
    loads = [
        Force("end", (0.0, 0.0, 2e3), history=lambda t: np.cos(2 * np.pi * t)),
        Force("end", (0.0, 4e3, 0.0), history=lambda t: np.sin(2 * np.pi * t)),
    ]
    upper = ElasticBody(_flange(elements, 1.0), steel, loads=loads)
    lower = ElasticBody(_flange(elements, -1.0), steel, supports=[Support("end")])
    stiffness = YOUNG * 0.25 * np.pi * SHANK**2 / (2 * THICK)
    return contact_problem(
        upper,
        "ring",
        0.3,
        against=(lower, "ring"),
        bolts=[Bolt(head="washer", nut="washer", preload=150e3, stiffness=stiffness)],
        tangent=(1.0, 0.0, 0.0),
        steps=steps,
        name="sector of a bolted flange",
        units="N, mm",
    )


def _flange(elements: tuple[int, int, int], side: float) -> MeshHex:
    """One flange with its piece of pipe, above z = 0 (side 1) or below it (side −1)."""
    around, across, over = elements
    points, quads, wall = _plan(around, across)
    heights = np.concatenate([np.linspace(0.0, THICK, over + 1), THICK + PIPE * np.arange(1, UP + 1) / UP])
    there = np.vstack([np.ones((over, len(wall)), bool), np.tile(wall, (UP, 1))])
    if side < 0:
        heights, there = -heights[::-1], there[::-1]
    mesh = extruded(points, quads, heights, there)
    away = 1e-6 * THICK

    def within(x: FloatArray, radius: float) -> NDArray[np.bool_]:
        return np.asarray(np.hypot(x[0], x[1]) < radius)

    return mesh.with_boundaries(
        {
            "ring": lambda x: (np.abs(x[2]) < away) & within(x, PAD),
            "washer": lambda x: (np.abs(x[2] - side * THICK) < away) & within(x, WASHER),
            "end": lambda x: np.abs(x[2] - side * (THICK + PIPE)) < away,
        }
    )


def _plan(around: int, across: int) -> tuple[FloatArray, NDArray[np.intp], NDArray[np.bool_]]:
    """Seen along the bolt: points (2, k), elements (4, e), and which of these are the pipe's wall."""
    angle = 2 * np.pi * np.arange(around) / around
    circle = np.array([np.cos(angle), np.sin(angle)])
    outline = _sector(HALF * circle / np.abs(circle).max(axis=0))
    radii = np.linspace(HOLE, PAD, across + 1)
    share = np.arange(1, RINGS + 1)[:, None, None] / RINGS
    rings = np.concatenate([radii[:, None, None] * circle, PAD * circle * (1 - share) + outline * share])
    k, last = np.arange(around), len(rings) - 1
    after = (k + 1) % around
    quads = [np.stack([k, k + around, after + around, after]) + ring * around for ring in range(last)]
    side = np.arange(-(around // 8), around // 8 + 1) % around  # the outline's nodes at the wall
    beyond = np.linspace(0.0, WALL, THROUGH + 1)[1:]
    y = HALF * circle[1, side] / np.abs(circle).max(axis=0)[side]
    wall = [_sector(np.array([np.full(len(y), HALF + out), y])) for out in beyond]
    first = len(rings) * around
    rows = [side + last * around] + [first + len(y) * row + np.arange(len(y)) for row in range(THROUGH)]
    strips = [np.stack([a[:-1], b[:-1], b[1:], a[1:]]) for a, b in itertools.pairwise(rows)]
    of_wall = np.repeat([False, True], [around * last, THROUGH * (len(y) - 1)])
    return np.hstack([*rings, *wall]), np.hstack([*quads, *strips]), of_wall


def _sector(place: FloatArray) -> FloatArray:
    """Points of a square about the bolt, (2, k), bent to the sector of the ring."""
    radius, turn = CIRCLE + place[0], place[1] / HALF * np.pi / BOLTS
    return np.array([radius * np.cos(turn) - CIRCLE, radius * np.sin(turn)])
