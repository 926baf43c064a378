"""A plane of two slips: safe region, admissible slips, energy ball; for two nodes what the rows say.

All other slips are those of the centre. With two nodes the rows of node j at their extreme load
steps allow it an interval of slips for every slip of the other node; at the apex, where both are
active, the interval has shrunk to a point. Beyond it they contradict each other, and node j slips
to and fro for ever (thesis §4.4, figs 4.11–4.15).
"""

from dataclasses import dataclass

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import CONE
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Side, constraints
from shakedown.joint.loading import first_load
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.programs.cone_rays import way_to_limits
from shakedown.programs.polygon import corners
from shakedown.studies.samplers import Sampling

OUTLINE = 181  # points of an ellipse
ROUND = 4 * OUTLINE - 3  # points about the centre of an outline with corners that are not known

REGION_TYPES = {
    "i": "a safe region and no complementary one, as below the first collapse",
    "ii": "a safe region and a complementary one: the initial state decides",
    "iii": "a complementary region and no safe one: nothing shakes down with both nodes closed",
    "iv": "no bounded safe region and no bounded complementary one",
}


@dataclass(frozen=True, eq=False, repr=False)
class SlipPlane(Result):
    """Outlines in the plane of two slips, each (k, 2) [length]; empty where there is none.

    Attributes
    ----------
    coordinates
        The places of the two slips: in the plane their nodes.
    safe
        Slips at which no row is violated.
    admissible
        Slips that the first load of the motion allows.
    ball
        The energy ball.
    apexes : (2, 2)
        With two nodes: where both rows of node 0, and of node 1, are active; NaN where
        they are parallel. The apex line of node j is that of the other node's slip there.
    complementary
        With two nodes: the regions, node by node, where both rows of that node are violated
        and those of the other one hold.
    region_type
        With two nodes: a key of ``REGION_TYPES``; else empty.
    """

    coordinates: tuple[int, int]
    safe: FloatArray
    admissible: FloatArray
    ball: FloatArray
    apexes: FloatArray
    complementary: tuple[FloatArray, ...]
    region_type: str

    @property
    def region(self) -> str:
        """What the region type means, in words."""
        return REGION_TYPES.get(self.region_type, "")


def slip_plane(chosen: Sampling) -> SlipPlane:
    """The plane of the two coordinates of a sampling, through its centre.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown.studies.samplers import sampling
    >>> plane = slip_plane(sampling(shakedown.example("two-node"), 0.7))
    >>> plane.region_type, plane.apexes.round(5).tolist()[1], len(plane.complementary[1])
    ('ii', [0.65407, 1.43418], 3)
    """
    problem, rows, pair = chosen.problem, constraints(chosen.problem), list(chosen.coordinates)
    empty = np.empty((0, 2))
    if problem.layout.slip_size < 2:
        return SlipPlane(chosen.coordinates, empty, empty, empty, np.full((2, 2), np.nan), (), "")
    if problem.directions > 1:
        return _of_discs(chosen)
    rest = chosen.centre.copy()
    rest[pair] = 0.0
    sides, limit = rows.G[:, pair], rows.g - chosen.load_factor * rows.d - rows.G @ rest
    first = first_limits(problem, chosen.load_factor) - rows.G @ rest
    plane = SlipPlane(
        coordinates=chosen.coordinates,
        safe=corners(sides, limit),
        admissible=corners(sides, first),
        ball=_section(chosen),
        apexes=np.full((2, 2), np.nan),
        complementary=(),
        region_type="",
    )
    return plane if problem.n > 2 else _of_two_nodes(plane, chosen.load_factor, problem, chosen.tolerances)


def _of_discs(chosen: Sampling) -> SlipPlane:
    """The plane with two tangential directions: outlines as far as they go round the centre."""
    problem, pair = chosen.problem, chosen.coordinates
    rows = constraints(problem)
    right, discs = rows.g - chosen.load_factor * rows.d, rows.side == Side.DISC
    every = problem.law.stiffness(problem.A, problem.B)[: CONE * problem.n]
    at_first = first_limits(problem, chosen.load_factor)[: CONE * problem.n]
    return SlipPlane(
        coordinates=pair,
        safe=_about(chosen, rows.G[discs], right[discs]),
        admissible=_about(chosen, every, at_first),
        ball=_section(chosen),
        apexes=np.full((2, 2), np.nan),
        complementary=(),
        region_type="",
    )


def _about(chosen: Sampling, G: FloatArray, right: FloatArray) -> FloatArray:
    """Outline, about the centre, of the slips that keep every cone of three rows; empty without end."""
    pair = list(chosen.coordinates)
    angle = np.linspace(0.0, 2.0 * np.pi, ROUND)
    around = np.zeros((ROUND, len(chosen.centre)))
    around[:, pair] = np.stack([np.cos(angle), np.sin(angle)], axis=1) * chosen.half_width[pair]
    way = way_to_limits(G, right, chosen.centre, around)
    if not (np.isfinite(way).all() and way.any()):
        return np.empty((0, 2))
    return np.asarray((chosen.centre + way[:, None] * around)[:, pair])


def first_limits(problem: Problem, load_factor: float) -> FloatArray:
    """Right-hand sides of the rows G v ≤ … at the first load step of the motion, (r,) [force]."""
    return problem.law.cone(*problem.layout.split(first_load(problem, load_factor)))


def _section(chosen: Sampling) -> FloatArray:
    """Outline of the energy ball in the plane of two slips through the centre."""
    ball, pair, A = chosen.ball, list(chosen.coordinates), chosen.problem.A
    if not 0 < ball.radius < np.inf:
        return np.empty((0, 2))
    away = chosen.centre - ball.slip
    away[pair] = 0.0
    try:
        root = np.linalg.cholesky(A[np.ix_(pair, pair)])
    except np.linalg.LinAlgError:  # a slip of both nodes that costs no energy: the section has no end
        return np.empty((0, 2))
    pull = np.linalg.solve(root, (A @ away)[pair])
    left = ball.radius**2 - away @ A @ away + pull @ pull
    if left <= 0:
        return np.empty((0, 2))
    angle = np.linspace(0.0, 2.0 * np.pi, OUTLINE)
    circle = np.sqrt(left) * np.stack([np.cos(angle), np.sin(angle)]) - pull[:, None]
    return np.asarray(ball.slip[pair] + np.linalg.solve(root.T, circle).T)


def _of_two_nodes(
    plane: SlipPlane, load_factor: float, problem: Problem, tolerances: Tolerances
) -> SlipPlane:
    """Apexes, complementary regions and type of the regions of a joint of two nodes."""
    rows = constraints(problem)
    limit = rows.g - load_factor * rows.d
    apexes, beyond = [], []
    for node in (0, 1):
        own = rows.limits_of(node)
        pair = rows.G[own]
        parallel = abs(np.linalg.det(pair)) <= tolerances.degeneracy * np.prod(np.linalg.norm(pair, axis=1))
        apex = np.full(2, np.nan) if parallel else np.linalg.solve(pair, limit[own])
        apexes.append(apex[list(plane.coordinates)])
        sign = np.where(own, -1.0, 1.0)
        region = corners(sign[:, None] * rows.G[:, list(plane.coordinates)], sign * limit)
        beyond.append(region)
    found = any(len(region) for region in beyond)
    kind = ("ii" if found else "i") if len(plane.safe) else ("iii" if found else "iv")
    return SlipPlane(
        plane.coordinates, plane.safe, plane.admissible, plane.ball, np.array(apexes), tuple(beyond), kind
    )
