"""Where the nodes of a patch are drawn, which way their tangents lead there, what lies between them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, SIX_DIGITS
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import require_problem
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.plot.style import GREY, MARGIN, axes_for

FLAT = 0.99  # of a normal along an axis of the model: then the other two axes are those of the picture
# Of the usual longest side and circle about a triangle: larger ones lie across a hole (whose rim may be one
# circle) or between two patches.
LARGEST_TRIANGLE = 2.0
COVERED = 0.999  # of the area of a contact, by the triangles that are drawn
FACING = 0.5  # cosine of the angle between two normals below which their nodes are of two patches
FEWEST = 4  # nodes that span an area
MOST_NUMBERED = 16  # nodes whose numbers stand beside them
ALONE = 1.0  # the room about a node that has no neighbour


@dataclass(frozen=True, eq=False)
class Places:
    """The nodes of a joint in the plane of a picture.

    Attributes
    ----------
    points : (n, 2)
        Where they are [length]; in a row where the joint does not know that.
    tangents : (n, 2, 2)
        Where the x and the y of each node lead.
    axes
        What the axes of the picture are called.
    unit
        Of the places.
    normals : (n, 3), optional
        Where they are known: nodes that face each other are of two patches.
    area
        Of the whole contact, where it is known [length²].
    """

    points: FloatArray
    tangents: FloatArray
    axes: tuple[str, str]
    unit: str = ""
    normals: FloatArray | None = None
    area: float | None = None

    def seen(self, vectors: FloatArray) -> FloatArray:
        """Vectors of the nodes (…, n, 2), in their tangents, as they are drawn (…, n, 2)."""
        return np.asarray(np.einsum("...nd,ndk->...nk", vectors, self.tangents))

    @property
    def in_a_row(self) -> bool:
        """Whether the heights of the picture mean nothing."""
        return not self.axes[1]

    @cached_property
    def triangles(self) -> Triangulation | None:
        """What lies between the nodes, holes and gaps left out; None where they span no area."""
        if len(self.points) < FEWEST or self.in_a_row:
            return None
        middle = self.points - self.points.mean(axis=0)
        long, wide = np.linalg.svd(middle, compute_uv=False)
        if not wide > SIX_DIGITS * long:
            return None
        mesh = Triangulation(
            middle[:, 0] / long, middle[:, 1] / long
        )  # of a size of its own: coordinates may be large numbers
        within = mesh.triangles[self._of_one_patch(mesh.triangles)]
        kept = within[_usual(self.points[within] - self.points[0])] if len(within) else within
        if self.area is not None:
            kept = kept[_as_large_as(self.area, self.points[kept] - self.points[0])]
        return Triangulation(self.points[:, 0], self.points[:, 1], kept) if len(kept) else None

    def _of_one_patch(self, triangles: NDArray[np.intp]) -> NDArray[np.bool_]:
        """Whether the nodes of each triangle look the same way, rather than at each other."""
        if self.normals is None:
            return np.ones(len(triangles), dtype=np.bool_)
        of_corner = self.normals[triangles]
        return np.asarray((of_corner * np.roll(of_corner, 1, axis=1)).sum(axis=2).min(axis=1) > FACING)

    @cached_property
    def spacing(self) -> float:
        """The usual distance of a node from its nearest neighbour [length]."""
        from scipy.spatial import KDTree

        if len(self.points) < 2:
            return ALONE
        nearest = KDTree(self.points).query(self.points, k=2)[0][:, 1]
        apart = nearest[nearest > 0]
        return float(np.median(apart)) if apart.size else ALONE

    @cached_property
    def room(self) -> float:
        """The side of a square as large as a node's share of the patch, at least the spacing [length]."""
        if self.triangles is None:
            return self.spacing
        area = float(_areas(self.points[self.triangles.triangles]).sum())
        return max(self.spacing, float(np.sqrt(area / len(self.points))))


def _usual(corners: FloatArray) -> NDArray[np.bool_]:
    """Which triangles, corners (k, 3, 2), are not much larger than most: sides, and circles about them."""
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    sizes = longest, _circles(corners)
    return np.all([size <= LARGEST_TRIANGLE * np.median(size) for size in sizes], axis=0)


def _as_large_as(area: float, corners: FloatArray) -> NDArray[np.bool_]:
    """Which triangles are left once those with the largest circles, which lie across holes, are taken out.

    So many go that the others still cover the area.
    """
    each, order = _areas(corners), np.argsort(-_circles(corners), kind="stable")
    left = each.sum() - np.cumsum(each[order])
    found = np.ones(len(corners), dtype=np.bool_)
    found[order[left >= COVERED * area]] = False
    return found


def _areas(corners: FloatArray) -> FloatArray:
    first, second = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.asarray(0.5 * np.abs(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]))


def _circles(corners: FloatArray) -> FloatArray:
    """Radii of the circles through the corners of triangles; of thin ones next to infinite."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    area = np.maximum(_areas(corners), (SIX_DIGITS * sides.max(axis=1)) ** 2)
    return np.asarray(sides.prod(axis=1) / (4.0 * area))


def places_of(problem: Problem) -> Places:
    """Where the nodes of a joint with two tangential directions are drawn."""
    axes, place = np.tile(np.eye(2), (problem.n, 1, 1)), problem.x
    unit = units_of(problem).length
    area = None if problem.node_area is None else float(problem.node_area.sum())
    tangents = problem.tangents
    same = tangents is None or bool(np.abs(tangents - tangents[0]).max() < NEGLIGIBLE)
    if place is not None and place.ndim == 2 and place.shape[1] == 2 and same:
        return Places(place, axes, ("x", "y"), unit, problem.normal, area)
    if problem.coordinates is not None:
        place = problem.coordinates
    if place is None:
        return Places(_row(np.arange(problem.n, dtype=float)), axes, ("node", ""))
    if place.ndim == 1:
        return Places(_row(place), axes, ("position along the contact", ""), unit)
    if place.shape[1] == 2:
        return Places(place, axes, ("x", "y"), unit, problem.normal, area)
    frame, names = _plane(problem, place)
    shown = axes if tangents is None else tangents @ frame.T
    return Places(place @ frame.T, shown, names, unit, problem.normal, area)


def _row(along: FloatArray) -> FloatArray:
    return np.column_stack([along, np.zeros(len(along))])


def _plane(problem: Problem, place: FloatArray) -> tuple[FloatArray, tuple[str, str]]:
    """The axes of the picture in the model, (2, 3), and their names: along the patch as a whole."""
    normal = np.zeros(3) if problem.normal is None else problem.normal.mean(axis=0)
    if np.linalg.norm(normal) < 0.5:  # unknown, or of faces that look at each other
        normal = np.linalg.svd(place - place.mean(axis=0), full_matrices=True)[2][-1]
    normal = normal / np.linalg.norm(normal)
    most = int(np.abs(normal).argmax())
    if abs(normal[most]) > FLAT:
        kept = [k for k in range(3) if k != most]
        return np.eye(3)[kept], ("xyz"[kept[0]], "xyz"[kept[1]])
    first = np.eye(3)[int(np.abs(normal).argmin())]
    first = first - (first @ normal) * normal
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)]), ("along the patch", "across the patch")


def require_space(what: str, problem: object) -> Problem:
    """The joint; ``UsageError`` where it has one tangential direction."""
    require_problem(problem)
    assert isinstance(problem, Problem)
    if problem.directions == 1:
        raise UsageError(
            f"{what}: expected two tangential directions, found one (a contact in the plane is no area)"
        )
    return problem


def patch_axes(places: Places, ax: Axes | None, room: float) -> Axes:
    """Axes with the places of the nodes at one scale, so much room about them, and their names."""
    axes = axes_for(ax)
    low, high = places.points.min(axis=0), places.points.max(axis=0)
    about = room + MARGIN * float((high - low).max())
    axes.update_datalim([low - about, high + about])
    axes.margins(0.0)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel(with_unit(places.axes[0], places.unit))
    axes.set_ylabel(with_unit(places.axes[1], places.unit) if places.axes[1] else "")
    if places.in_a_row:
        axes.set_yticks([])
    if places.axes[0] == "node":
        axes.xaxis.set_major_locator(MaxNLocator(9, integer=True, min_n_ticks=1))
    return axes


def numbered(axes: Axes, places: Places) -> None:
    """The numbers of the nodes beside them, where there are few and no axis says them."""
    if len(places.points) > MOST_NUMBERED or places.axes[0] == "node":
        return
    for node, point in enumerate(places.points):
        axes.annotate(
            str(node), (point[0], point[1]), xytext=(3, 3), textcoords="offset points", color=GREY,
            fontsize="x-small",
        )  # fmt: skip
