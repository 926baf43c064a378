"""A bolted lap joint of two half beams, after the Brake–Reuß beam."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from skfem import Mesh, MeshHex

from shakedown import Problem
from shakedown.fem import Bolt, ElasticBody, Force, Material, Support, contact_problem
from shakedown.ground.constants import FloatArray

LENGTH, LAP, WIDTH, HEIGHT = 720.0, 120.0, 25.4, 25.4  # of both half beams in all [mm]
BOLTS = (330.0, 360.0, 390.0)  # where their axes are along the beam [mm]
WASHER, SHANK = 8.5, 8.0  # radius of a washer, diameter of a shank [mm]
YOUNG = 210e3
ARM = 8  # elements along an arm, finer towards the lap
STEP = LAP / 12  # of the smallest of them [mm]


def lap_joint(
    # along the lap (a multiple of 12 has bolts and pads between elements), across it, and over half of the
    # height. There are (along + 1) (across + 1) node pairs on a flat lap, 105 with the default pads
    elements: tuple[int, int, int] = (24, 6, 3),
    *,
    reach: float = 10.0,  # how far a pad goes from the axis of its bolt, along the beam [mm]
    # how far a rectangular washer goes from the axis, along the beam and across it [mm], to lines of the
    # mesh. By default washers are round, and stepped: another patch on every mesh
    washer: tuple[float, float] | None = None,
    steps: int = 24,  # load steps of one period
) -> Problem:
    """Two half beams, 720 × 25.4 × 25.4 mm in all, that lap over 120 mm under three bolts of 12 kN.

    The left end is held; the load at the right one turns about the beam's axis, 10 N · (0, cos t, sin t), so
    that the lap is bent in both planes, a quarter of a period apart. Steel, f = 0.5. Bolts pull patches of
    about the area of a washer together, through shanks of 8 mm, by which a tenth of the preload is lost;
    there are no holes. By default the half beams touch on three pads below the bolts, where the preload keeps
    all pairs closed; of a flat lap (``reach=math.inf``) the ends and edges open.
    Slips are those of the left half beam relative to the right one, along and across the beam.

    Examples
    --------
    >>> joint = lap_joint((12, 2, 1), steps=8)
    >>> joint.n, joint.directions, joint.load_names
    (27, 2, ('force', 'force', 'bolt', 'bolt', 'bolt'))
    """
    steel = Material(YOUNG, 0.3)
    first, second = 0.5 * (LENGTH - LAP), 0.5 * (LENGTH + LAP)
    left = ElasticBody(
        _half(elements, reach, washer, lambda x: (x[0] < first) | (x[2] > 0.5 * HEIGHT), (0.0, second)),
        steel,
        supports=[Support("clamp")],
    )
    loads = [
        Force("tip", (0.0, 10.0, 0.0), history=lambda t: np.cos(2 * np.pi * t)),
        Force("tip", (0.0, 0.0, 10.0), history=lambda t: np.sin(2 * np.pi * t)),
    ]
    right = ElasticBody(
        _half(elements, reach, washer, lambda x: (x[0] > second) | (x[2] < 0.5 * HEIGHT), (first, LENGTH)),
        steel,
        loads=loads,
    )
    stiffness = YOUNG * 0.25 * np.pi * SHANK**2 / HEIGHT
    bolts = [
        Bolt(head=f"washer {k}", nut=f"washer {k}", preload=12e3, stiffness=stiffness)
        for k in range(1, len(BOLTS) + 1)
    ]
    return contact_problem(
        left,
        "lap",
        0.5,
        against=(right, "lap"),
        bolts=bolts,
        tangent=(1.0, 0.0, 0.0),
        steps=steps,
        name="bolted lap joint",
        units="N, mm",
    )


def _half(
    elements: tuple[int, int, int],
    reach: float,
    washer: tuple[float, float] | None,
    there: Callable[[FloatArray], NDArray[np.bool_]],
    ends: tuple[float, float],
) -> Mesh:
    """One half beam between two ends: a full bar without the part that the other half takes."""
    (along, across, over), (start, end) = elements, ends
    first, second = 0.5 * (LENGTH - LAP), 0.5 * (LENGTH + LAP)
    lap = np.linspace(first, second, along + 1)
    growing = np.geomspace(1.0, 1.0 + first / STEP, ARM + 1) - 1.0
    arm = first * growing / growing[-1]
    x = np.concatenate([first - arm[:0:-1], lap]) if start == 0.0 else np.concatenate([lap, second + arm[1:]])
    bar = MeshHex.init_tensor(x, np.linspace(0, WIDTH, across + 1), np.linspace(0, HEIGHT, 2 * over + 1))
    middle = bar.p[:, bar.t].mean(axis=1)
    mesh = bar.restrict(np.flatnonzero(there(middle)))
    left = start == 0.0
    name, far, outer = ("clamp", start, HEIGHT) if left else ("tip", end, 0.0)
    washers = {f"washer {k}": _washer(mesh, place, outer, washer) for k, place in enumerate(BOLTS, start=1)}
    faces = {
        "lap": lambda p: (
            (np.abs(p[2] - 0.5 * HEIGHT) < 1e-9)
            & (p[0] > first)
            & (p[0] < second)
            & (np.abs(p[0] - np.array(BOLTS)[:, None]).min(axis=0) < reach)
        ),
        name: lambda p: np.abs(p[0] - far) < 1e-9,
    }
    return mesh.with_boundaries(faces | washers)


def _washer(mesh: Mesh, place: float, outer: float, half: tuple[float, float] | None) -> NDArray[np.intp]:
    """The faces whose middles a washer covers; the nearest ones where a round one covers none."""
    facets = mesh.boundary_facets()
    corners = mesh.p[:, mesh.facets[:, facets]]
    x, y, z = corners.mean(axis=1) - np.array([[place], [0.5 * WIDTH], [outer]])
    above = np.abs(z) < 1e-9
    if half is None:
        away = np.where(above, np.hypot(x, y), np.inf)
        return np.asarray(facets[away <= max(WASHER, away.min() * (1 + 1e-9))])
    found = above & (np.abs(x) < half[0]) & (np.abs(y) < half[1])
    return np.asarray(facets[found])
