"""Where the nodes of a contact in space are drawn, and what belongs to them."""

import json
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.tri import Triangulation

from shakedown.ground.constants import MINOR, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import with_unit
from shakedown.ground.status import STICK
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.arguments import once_per_problem, require_problem
from shakedown.joint.contact_surface import TURN, contact_patches
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.node_results import STICKS, statuses
from shakedown.long_term.state import LongTermState
from shakedown.plot.paths import normal_reactions, so_far, work_and_name
from shakedown.plot.style import MARGIN, axes_for, node_name


@dataclass(frozen=True, eq=False)
class Places:
    """The nodes of one patch of a joint in the plane of a picture.

    Attributes
    ----------
    nodes : (k,)
        Which nodes they are.
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
    """

    nodes: IntArray
    points: FloatArray
    tangents: FloatArray
    axes: tuple[str, str]
    name: str = ""
    unit: str = ""
    faces: IntArray | None = None

    def titled(self, title: str = "") -> str:
        """A title below the name of the patch."""
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
        """The triangles between the nodes, without holes; None where they span no area."""
        (x, y), about = self.points.T, self.points - self.points.mean(axis=0)
        if self.in_a_row:
            return None
        if self.faces is not None:
            quadrilaterals = self.faces[self.faces[:, 3] >= 0]
            return Triangulation(x, y, np.concatenate([self.faces[:, :3], quadrilaterals[:, [0, 2, 3]]]))
        if in_a_line(self.points):
            return None
        along, across = about.T / np.abs(about).max()
        found = Triangulation(along, across).triangles
        circles = _circles(about[found])
        # times the usual circumcircle of a triangle: a larger one lies across a hole
        return Triangulation(x, y, found[circles <= 2.0 * np.median(circles)])

    @cached_property
    def spacing(self) -> float:
        """The usual distance of a node from its nearest neighbour [length]."""
        from scipy.spatial import KDTree

        nearest = KDTree(self.points).query(self.points, k=2)[0][:, 1]
        apart = nearest[(nearest > 0) & (nearest < np.inf)]
        return float(np.median(apart)) if apart.size else 1.0  # about a node that has no neighbour


def in_a_line(points: FloatArray) -> bool:
    """Whether points (k, 2) or (k, 3) span no area."""
    about = points - points.mean(axis=0)
    return int(np.linalg.matrix_rank(about, SIX_DIGITS * np.abs(about).max())) < 2


def _circles(corners: FloatArray) -> FloatArray:
    """Radii of the circumscribed circles of triangles, corners (k, 3, 2); almost infinite for thin ones."""
    sides = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    doubled = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    return np.asarray(sides.prod(axis=1) / (2.0 * np.maximum(doubled, (SIX_DIGITS * sides.max(axis=1)) ** 2)))


def places_of(problem: Problem, patch: int = 0) -> Places:
    """Where the nodes of a patch of a joint with two tangential directions are drawn.

    Raises
    ------
    UsageError
        If the joint has one tangential direction, or no patch of this number.
    """
    every = _all_places(require_space("picture of a patch", problem))
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


def model_places(problem: Problem) -> FloatArray | None:
    """Where the nodes are in the model, (n, 3) [length]; None where that is not known."""
    known = problem.x if problem.coordinates is None else problem.coordinates
    if known is None:
        return None
    known = known.reshape(problem.n, -1)
    return np.column_stack([known, np.zeros((problem.n, 3 - known.shape[1]))])


@once_per_problem
def _all_places(problem: Problem) -> tuple[Places, ...]:
    known = model_places(problem)
    if known is None:
        nodes, along = np.arange(problem.n), np.arange(float(problem.n))
        row, tangents = np.column_stack([along, 0.0 * along]), np.tile(np.eye(2), (problem.n, 1, 1))
        return (Places(nodes, row, tangents, ("node", "")),)
    patches = contact_patches(known, problem.normal, problem.faces)
    found = []
    for k, (nodes, faces) in enumerate(patches):
        # the common prefix of its labels, as in ``flange: 4711``
        names = {"" if problem.label is None else problem.label[node].rpartition(": ")[0] for node in nodes}
        common = names.pop() if len(names) == 1 else ""
        name = common or f"patch {k + 1} of {len(patches)}" * (len(patches) > 1)
        found.append(_projected(problem, known[nodes], nodes, faces, name))
    return tuple(found)


def _projected(
    problem: Problem, at: FloatArray, nodes: IntArray, faces: IntArray | None, name: str
) -> Places:
    """A patch projected along its normal, with the axes of the model where it lies along them."""
    normal = patch_normal(at, None if problem.normal is None else problem.normal[nodes])
    away = int(np.abs(normal).argmax())
    kept = [axis for axis in range(3) if axis != away]
    frame, names = np.eye(3)[kept], ("xyz"[kept[0]], "xyz"[kept[1]])
    if np.abs(normal[away]) < 1.0 - MINOR:
        first = int(np.abs(normal).argmin())
        across = np.cross(normal, np.eye(3)[first])
        across /= np.linalg.norm(across)
        frame = np.stack([np.cross(across, normal), across])
        along = abs(normal[first]) < SIX_DIGITS
        names = "xyz"[first] if along else "along the patch", "across the patch"
    height, extent = np.ptp(at @ normal), np.linalg.norm(np.ptp(at, axis=0))
    # height over length from which on a patch is called curved
    title = ", ".join(filter(None, [name, "curved, projected" * bool(height > 0.05 * extent)]))
    tangents = np.tile(np.eye(2), (len(nodes), 1, 1))
    if problem.tangents is not None:
        tangents = problem.tangents[nodes] @ frame.T
    return Places(nodes, at @ frame.T, tangents, names, title, units_of(problem).length, faces)


def patch_normal(at: FloatArray, normals: FloatArray | None) -> FloatArray:
    """The normal of a patch: of its plane, unless the normals of its nodes lead elsewhere."""
    plane, mean = flattest(at), np.zeros(3) if normals is None else normals.mean(axis=0)
    size = np.linalg.norm(mean)
    if size < 0.5:  # unknown, or pointing in all directions
        return plane
    along = float(plane @ mean)
    return plane * np.sign(along) if abs(along) > TURN * size else np.asarray(mean / size)


def flattest(at: FloatArray) -> FloatArray:
    """The direction in which points extend least."""
    arms = at - at.mean(axis=0)
    arms = arms / (np.abs(arms).max() or 1.0)
    return np.asarray(np.linalg.eigh(arms.T @ arms)[1][:, 0])


def in_space(problem: Problem) -> bool:
    """Whether a joint has two tangential directions, so that its contact is an area."""
    return problem.directions > 1


def require_space(what: str, problem: Problem) -> Problem:
    """The joint; ``UsageError`` where it has one tangential direction."""
    require_problem(problem)
    if not in_space(problem):
        why = "a contact in the plane is no area"
        raise UsageError(f"{what}: expected two tangential directions, found one ({why})")
    return problem


def patch_axes(places: Places, ax: Axes | None, room: float) -> Axes:
    """Axes with equal scales, a margin around the places of the nodes, and the names of the axes."""
    axes = axes_for(ax)
    low, high = places.points.min(axis=0), places.points.max(axis=0)
    about = room + MARGIN * float((high - low).max()) or 1.0
    axes.update_datalim([low - about, high + about])
    axes.margins(0.0)
    axes.autoscale_view()
    axes.set_aspect("equal", adjustable="datalim")
    if places.in_a_row:
        axes.set(xlabel="node", yticks=[])
    else:
        axes.set(**{f"{axis}label": with_unit(places.axes[k], places.unit) for k, axis in enumerate("xy")})
    return axes


def can_be_turned(problem: Problem) -> bool:
    """Whether the places of three nodes are known and not in a line, so that a view shows something."""
    place = model_places(problem)
    return place is not None and not in_a_line(place)


def patch_data(state: LongTermState) -> str:
    """A long-term state of a joint that :func:`can_be_turned`, as JSON that ends no script element."""
    return json.dumps(_data(state), ensure_ascii=False, separators=(",", ":")).replace("<", "\\u003c")


def _data(state: LongTermState) -> dict[str, Any]:
    problem, history, place = state.problem, state.history, model_places(state.problem)
    assert place is not None
    middle = 0.5 * (place.min(axis=0) + place.max(axis=0))
    size = float(np.linalg.norm(place - middle, axis=1).max())
    # of a period including both ends: for many nodes, for few
    count = int(np.clip(24_000 // problem.n, 7, 25))  # nodes times instants, about half a MB
    times = np.linspace(max(float(history.cycle[0]), 0.0), float(history.cycle[-1]), count)
    at, (slip, work) = history.at(times), so_far(state, times)
    # a node that slips by round-off alone sticks, also where an event touches it
    status = np.where(np.array(statuses(state, DEFAULT)) == STICKS, STICK, np.abs(at.state))
    shown = [
        normal_reactions("normal reaction p", at.p, problem),
        (slip, with_unit("slip so far", units_of(problem).length)),
        work_and_name(work, problem),
    ]
    return {
        "nodes": problem.n,
        "times": [float(f"{time - times[0]:.4g}") for time in times],
        "start": int((status != STICK).sum(axis=1).argmax()),
        "places": ((place - middle) / size).T.round(4).tolist(),
        "faces": _faces(problem),
        "turn": _turn(problem, place).round(4).tolist(),
        "names": None if problem.label is None else [node_name(node, problem) for node in range(problem.n)],
        "status": "".join(map(str, status.ravel().tolist())),
        "numbers": [_numbers(*each) for each in shown],
    }


def _numbers(values: FloatArray, name: str) -> dict[str, Any]:
    """Numbers (instants, n), None where there is none, their ends and what they are called."""
    known = values[np.isfinite(values)]
    rounded = [float(f"{value:.5g}") if np.isfinite(value) else None for value in values.ravel().tolist()]
    ends = {"low": float(known.min(initial=0.0)), "high": float(known.max(initial=0.0))}
    return {"name": name.replace("friction work", "friction work so far", 1), "values": rounded, **ends}


def _faces(problem: Problem) -> list[list[int]]:
    """Corners of the surface between the nodes: the faces, or triangles of each patch; none of a line."""
    if problem.faces is not None:
        return [[node for node in face if node >= 0] for face in problem.faces.tolist()]
    patches = [places_of(problem, k) for k in range(patch_count(problem))] if in_space(problem) else []
    meshed = [(each.nodes, each.triangles) for each in patches if each.triangles is not None]
    return [corners for nodes, mesh in meshed for corners in nodes[mesh.triangles].tolist()]


def _turn(problem: Problem, place: FloatArray) -> FloatArray:
    """Rows that lead to the right, up and out of the picture at first, (3, 3)."""
    from scipy.spatial.transform import Rotation

    # initial view: rotation about the normal, then towards it
    out, tilt = patch_normal(place, problem.normal), np.array([35.0, -50.0])
    if not in_space(problem):  # in the plane of the joint
        out, tilt = flattest(place), np.zeros(2)
        out = out * np.sign(out[np.abs(out).argmax()])
    right = np.eye(3)[int(np.abs(out).argmin())]
    right = right - (right @ out) * out
    right /= np.linalg.norm(right)
    towards = Rotation.from_euler("zx", tilt, degrees=True).as_matrix()
    return np.asarray(towards @ np.stack([right, np.cross(out, right), out]))
