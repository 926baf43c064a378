"""Where the nodes of a patch are drawn, their tangents in the picture, and the surface between them."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator
from matplotlib.tri import Triangulation
from numpy.typing import NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE, SIX_DIGITS, THREE_DIGITS
from shakedown.ground.visible_text import with_unit
from shakedown.joint.arguments import require_problem
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.plot.flat_patch import Patch, laid_flat
from shakedown.plot.style import GREY, MARGIN, axes_for

ACROSS = 2.0  # times the usual size of a triangle: a larger one lies across a hole, or a gap between patches
COVERED = 1.0 - THREE_DIGITS  # share of the area of a contact that the drawn triangles must cover
FEWEST = 4  # nodes that span an area
MOST_NUMBERED = 16  # nodes whose numbers stand beside them


@dataclass(frozen=True, eq=False)
class Places:
    """The nodes of one patch of a joint in the plane of a picture.

    Attributes
    ----------
    nodes : (k,)
        Which nodes they are; one at the seam of an unrolled cylinder twice.
    points : (k, 2)
        Where they are [length]; in a row where the joint does not know that.
    tangents : (k, 2, 2)
        The directions x and y of each node.
    axes
        What the axes of the picture are called.
    name
        Name of the patch, where the joint has several or it is curved.
    unit
        Unit of the places.
    faces : (m, 4), optional
        Between which of them there are faces; −1 as the last of a triangle.
    area
        Area of the whole patch, where it is known [length²].
    """

    nodes: NDArray[np.intp]
    points: FloatArray
    tangents: FloatArray
    axes: tuple[str, str]
    name: str = ""
    unit: str = ""
    faces: NDArray[np.intp] | None = None
    area: float | None = None

    def titled(self, title: str) -> str:
        """A title with the name of the patch above it."""
        return "\n".join(filter(None, [self.name, title]))

    def seen(self, vectors: FloatArray) -> FloatArray:
        """Vectors of the nodes in their own tangents (…, n, 2), in the axes of the picture (…, n, 2)."""
        return np.asarray(np.einsum("...nd,ndk->...nk", vectors, self.tangents))

    @property
    def in_a_row(self) -> bool:
        """Whether the nodes are drawn in a row, so that the vertical axis has no meaning."""
        return not self.axes[1]

    @cached_property
    def triangles(self) -> Triangulation | None:
        """The triangles between the nodes, without holes and gaps; None where they span no area."""
        if self.in_a_row:
            return None
        if self.faces is not None:
            return Triangulation(self.points[:, 0], self.points[:, 1], triangles_of(self.faces))
        if len(self.points) < FEWEST:
            return None
        middle = self.points - self.points.mean(axis=0)
        long, wide = np.linalg.svd(middle, compute_uv=False)
        if not wide > SIX_DIGITS * long:
            return None
        mesh = Triangulation(
            middle[:, 0] / long, middle[:, 1] / long
        )  # scaled, as coordinates may be large numbers
        kept = mesh.triangles[_usual(self.points[mesh.triangles] - self.points[0])]
        if self.area is not None:
            kept = kept[_as_large_as(self.area, self.points[kept] - self.points[0])]
        return Triangulation(self.points[:, 0], self.points[:, 1], kept) if len(kept) else None

    @cached_property
    def spacing(self) -> float:
        """The usual distance of a node from its nearest neighbour [length]."""
        from scipy.spatial import KDTree

        nearest = KDTree(self.points).query(self.points, k=2)[0][:, 1]
        apart = nearest[(nearest > 0) & (nearest < np.inf)]
        return float(np.median(apart)) if apart.size else 1.0  # about a node that has no neighbour

    @cached_property
    def room(self) -> float:
        """The side of a square as large as a node's share of the patch, at least the spacing [length]."""
        if self.triangles is None:
            return self.spacing
        area = float(_areas(self.points[self.triangles.triangles]).sum())
        return max(self.spacing, float(np.sqrt(area / len(self.points))))


def triangles_of(faces: NDArray[np.intp]) -> NDArray[np.intp]:
    """Faces, (m, 4), as triangles, (t, 3)."""
    quadrilaterals = faces[faces[:, 3] >= 0]
    return np.concatenate([faces[:, :3], quadrilaterals[:, [0, 2, 3]]])


def _usual(corners: FloatArray) -> NDArray[np.bool_]:
    """Which triangles, corners (k, 3, 2), are not much larger than most, by sides and circumcircles.

    By both, as the rim of a hole may be one circle.
    """
    longest = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max(axis=1)
    sizes = longest, _circles(corners)
    return np.all([size <= ACROSS * np.median(size) for size in sizes], axis=0)


def _as_large_as(area: float, corners: FloatArray) -> NDArray[np.bool_]:
    """Which triangles remain once those with the largest circles, which span holes, are removed.

    As many are removed as leave the area covered.
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
    """Radii of the circumscribed circles of triangles; almost infinite for thin ones."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    area = np.maximum(_areas(corners), (SIX_DIGITS * sides.max(axis=1)) ** 2)
    return np.asarray(sides.prod(axis=1) / (4.0 * area))


def places_of(problem: Problem, patch: int = 0) -> Places:
    """Where the nodes of a patch of a joint with two tangential directions are drawn.

    Raises
    ------
    UsageError
        If the joint has no patch of this number.
    """
    every = _all_places(problem)
    if not 0 <= patch < len(every):
        raise UsageError(f"patch: expected a number from 0 to {len(every) - 1}, found {patch}")
    return every[patch]


def patch_count(problem: Problem) -> int:
    """How many patches the contact of a joint in space has, as ``patch`` of a picture numbers them.

    From the one with the most nodes on: parts along which the normal turns by no more than 40° from one face,
    or node, to the next.

    Examples
    --------
    >>> import shakedown
    >>> patch_count(shakedown.example("blade-root"))
    2
    """
    return len(_all_places(require_space("patches", problem)))


@once_per_problem
def _all_places(problem: Problem) -> tuple[Places, ...]:
    known = problem.x if problem.coordinates is None else problem.coordinates
    if known is None or known.ndim == 1:
        return (_in_a_row(problem, known),)
    if known.shape[1] == 2:
        known = np.column_stack([known, np.zeros(problem.n)])
    patches, tangents = laid_flat(known, problem.normal, problem.faces), problem.tangents
    if problem.x is not None and problem.x.ndim == 2 and problem.x.shape[1] == 2 and _alike(problem):
        axes = np.tile(np.eye(3)[:2], (problem.n, 1, 1))  # along the tangents of x
        patches = [
            replace(each, points=problem.x[each.nodes], frame=axes[each.nodes], axes=("x", "y"))
            for each in patches
        ]
        tangents = None
    names = [
        ", ".join(filter(None, [_called(problem, each) or _number(k, len(patches)), each.kind]))
        for k, each in enumerate(patches)
    ]
    return tuple(_placed(problem, tangents, *pair) for pair in zip(patches, names, strict=True))


def _alike(problem: Problem) -> bool:
    """Whether all nodes have the same normal and the same tangents."""
    known = [each for each in (problem.normal, problem.tangents) if each is not None]
    return all(bool(np.abs(each - each[0]).max() < NEGLIGIBLE) for each in known)


def _called(problem: Problem, patch: Patch) -> str:
    """The common prefix of the node labels of a patch, as in ``flange: 4711``; "" where they differ."""
    labels = [""] if problem.label is None else [problem.label[node] for node in patch.nodes]
    names = {label.rpartition(": ")[0] for label in labels}
    return names.pop() if len(names) == 1 else ""


def _number(patch: int, count: int) -> str:
    return f"patch {patch + 1} of {count}" if count > 1 else ""


def _placed(problem: Problem, tangents: FloatArray | None, patch: Patch, name: str) -> Places:
    """A patch with the tangents of its nodes, where they are not those of the picture, and its area."""
    nodes, seen = patch.nodes, np.tile(np.eye(2), (len(patch.nodes), 1, 1))
    if tangents is not None:
        seen = tangents[nodes] @ patch.frame.swapaxes(1, 2)
    area = None if problem.node_area is None else float(problem.node_area[np.unique(nodes)].sum())
    unit = units_of(problem).length
    return Places(nodes, patch.points, seen, patch.axes, name, unit, patch.faces, area)


def _in_a_row(problem: Problem, along: FloatArray | None) -> Places:
    """Nodes of a joint that does not know its patch."""
    nodes = np.arange(problem.n)
    row = np.column_stack([nodes.astype(float) if along is None else along, np.zeros(problem.n)])
    tangents = np.tile(np.eye(2), (problem.n, 1, 1))
    if along is None:
        return Places(nodes, row, tangents, ("node", ""))
    return Places(nodes, row, tangents, ("position along the contact", ""), unit=units_of(problem).length)


def in_space(problem: Problem) -> bool:
    """Whether a joint has two tangential directions, so that its contact is an area."""
    return problem.directions > 1


def require_space(what: str, problem: object) -> Problem:
    """The joint; ``UsageError`` where it has one tangential direction."""
    require_problem(problem)
    assert isinstance(problem, Problem)
    if not in_space(problem):
        raise UsageError(
            f"{what}: expected two tangential directions, found one (a contact in the plane is no area)"
        )
    return problem


def patch_axes(places: Places, ax: Axes | None, room: float) -> Axes:
    """Axes with equal scales, a margin around the places of the nodes, and the names of the axes."""
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
    """Write the numbers beside the nodes, where these are few and no axis shows them."""
    if len(places.points) > MOST_NUMBERED or places.axes[0] == "node":
        return
    for node, point in zip(places.nodes.tolist(), places.points.tolist(), strict=True):
        axes.annotate(
            str(node), (point[0], point[1]), xytext=(3, 3), textcoords="offset points", color=GREY,
            fontsize="x-small",
        )  # fmt: skip
