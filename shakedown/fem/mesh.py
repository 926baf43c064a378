"""Meshes with named boundaries, and what a problem made from meshes was made of (``Problem.source``)."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import is_dataclass, replace
from math import inf, isfinite
from pathlib import Path
from typing import Any

import numpy as np
from skfem import Mesh, MeshHex, MeshQuad

from shakedown import __version__
from shakedown.fem.body import AXES, KINDS, ElasticBody, Material
from shakedown.ground.constants import EACH_SHOWN, FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.joint.arguments import checked
from shakedown.models.readers.formats import format_of, read_any_mesh
from shakedown.models.readers.mesh import CORNERS, SOLIDS
from shakedown.models.readers.mesh import Mesh as MeshOfFile
from shakedown.models.readers.mesh_files import read_by_meshlane
from shakedown.models.readers.parsing import sha256

FILE = "read_from"  # attribute of a mesh: name and SHA-256 of the file that it was read from
REACH = 1e-9  # of a boundary, relative to the size of the mesh
SIDES = {"x": ("left", "right"), "y": ("front", "back"), "z": ("bottom", "top")}  # of a block, across an axis


@checked
def block_mesh(
    width: float,
    height: float,
    nx: int,
    ny: int,
    *,
    origin: tuple[float, float] = (0.0, 0.0),
    angle: float = 0.0,
) -> MeshQuad:
    """A rectangular block of nx × ny quadrilaterals with boundaries left, right, bottom and top.

    Parameters
    ----------
    width, height
        Sides of the block [length].
    nx, ny
        Elements along them.
    origin
        Where the lower left corner is [length].
    angle
        Rotation about that corner, counter-clockwise [rad]; an inclined block
        gives an inclined contact plane.

    Examples
    --------
    >>> mesh = block_mesh(4.0, 1.0, 8, 2)
    >>> int(mesh.nvertices), sorted(mesh.boundaries)
    (27, ['bottom', 'left', 'right', 'top'])
    """
    mesh = _with_sides(_block(MeshQuad, (width, height), (nx, ny), (*origin, angle)), "xz")
    cos, sin = np.cos(angle), np.sin(angle)
    return _moved(mesh, np.array([[cos, -sin], [sin, cos]]) @ mesh.p, origin)


@checked
def brick_mesh(
    sides: tuple[float, float, float],
    elements: tuple[int, int, int],
    *,
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0),
    tetrahedra: bool = False,
) -> Mesh:
    """A rectangular brick of hexahedra with boundaries left, right (x), front, back (y), bottom and top (z).

    Parameters
    ----------
    sides
        Along x, y and z [length].
    elements
        How many along each.
    origin
        Where the corner of the smallest x, y and z is [length].
    tetrahedra
        Six tetrahedra instead of each hexahedron.

    Examples
    --------
    >>> mesh = brick_mesh((4.0, 2.0, 1.0), (4, 2, 1))
    >>> int(mesh.nvertices), sorted(mesh.boundaries)
    (30, ['back', 'bottom', 'front', 'left', 'right', 'top'])
    """
    mesh = _block(MeshHex, sides, elements, origin)
    named = _with_sides(mesh.to_meshtet() if tetrahedra else mesh, "xyz")
    return _moved(named, named.p, origin)


@checked
def ring_mesh(inside: float, outside: float, around: int, through: int) -> MeshQuad:
    """A ring about the origin of around × through quadrilaterals with boundaries inside and outside.

    Parameters
    ----------
    inside, outside
        Radii [length].
    around, through
        Elements round the ring, at least three, and through it. Node 0 is at angle 0.

    Examples
    --------
    >>> mesh = ring_mesh(35.0, 40.0, 64, 3)
    >>> int(mesh.nvertices), {name: len(facets) for name, facets in sorted(mesh.boundaries.items())}
    (256, {'inside': 64, 'outside': 64})
    """
    if around < 3 or through < 1 or not 0 < inside < outside < inf:
        raise ProblemError(
            "ring: expected radii 0 < inside < outside, at least three elements round and one through it, "
            f"found {inside}, {outside}, {around}, {through}"
        )
    angle, radius = 2 * np.pi * np.arange(around) / around, np.linspace(inside, outside, through + 1)
    points = np.array([np.outer(radius, np.cos(angle)).ravel(), np.outer(radius, np.sin(angle)).ravel()])
    row, here = around * np.arange(through)[:, None], np.arange(around)
    first, second = row + here, row + (here + 1) % around
    corners = np.array([first.ravel(), first.ravel() + around, second.ravel() + around, second.ravel()])
    mesh = MeshQuad(points, corners)
    facets = mesh.boundary_facets()
    inner = (mesh.facets[:, facets] < around).all(axis=0)
    return mesh.with_boundaries({"inside": facets[inner], "outside": facets[~inner]})


def _block(kind: type[Mesh], sides: Sequence[float], elements: Sequence[int], place: Sequence[float]) -> Mesh:
    """A block from the origin on; ``ProblemError`` unless its sides, elements and place make one."""
    if min(elements) < 1 or not all(0 < side < inf for side in sides) or not all(map(isfinite, place)):
        raise ProblemError(
            "block: expected finite sides > 0, at least one element along each and a finite origin and "
            f"angle, found {' x '.join(map(str, sides))}, {' x '.join(map(str, elements))} at {tuple(place)}"
        )
    return kind.init_tensor(*map(np.linspace, [0] * len(sides), sides, [n + 1 for n in elements]))


def _with_sides(mesh: Mesh, named: str) -> Mesh:
    """A block with its sides as boundaries, named as those across x, y or z."""
    boundaries = {}
    for axis, name in enumerate(named):
        for side, end in zip(SIDES[name], (0.0, mesh.p[axis].max()), strict=True):
            middle = mesh.p[axis, mesh.facets].mean(axis=0)
            boundaries[side] = np.flatnonzero(np.abs(middle - end) <= REACH * mesh.p[axis].max())
    return mesh.with_boundaries(boundaries)


def _moved(mesh: Mesh, points: FloatArray, origin: Sequence[float]) -> Mesh:
    return replace(mesh, doflocs=np.ascontiguousarray(points + np.array(origin)[:, None]))


@checked
def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """A plane or solid mesh from a file, with its named sets.

    A file with tetrahedra or hexahedra is a solid; its triangles and quadrilaterals are boundaries.
    Groups of elements become subdomains, groups of their sides boundaries; a group of nodes becomes the
    boundary of all facets whose nodes it holds. Decks of Abaqus and CalculiX are
    read as :func:`shakedown.import_model` reads them: included files, sets of sets, surfaces of faces.
    A problem made with the mesh tells the file's name and SHA-256, unless the mesh is
    changed in between, as scikit-fem then makes a new one.

    Parameters
    ----------
    path
        Gmsh ``.msh``, Salome and Code_Aster ``.med``, ``.vtu``, ``.unv``, Abaqus or CalculiX ``.inp``, Ansys
        ``.cdb``, by their content; others that meshlane reads (Nastran bulk ``.bdf`` …), by their names.

    Raises
    ------
    ProblemError
        If the file cannot be read, or holds no first-order tetrahedra or hexahedra, nor
        triangles or quadrilaterals in one plane.
    """
    name, found = os.fspath(path), format_of(path, "mesh")
    # formats of which an import takes the nodes alone
    raw = read_by_meshlane(path) if found.name in ("bulk", "coordinates") else read_any_mesh(path)
    there = {(shape, len(nodes) == CORNERS[shape]) for shape, nodes in raw.elements.values()}
    shapes = {shape for shape, _ in there}
    shapes = shapes.intersection(SOLIDS) or shapes
    second_order = {shape for shape, linear in there if not linear}
    if len(shapes) != 1 or not shapes <= KINDS.keys() - second_order:
        known = ", ".join(sorted(f"{shape} of order {2 - linear}" for shape, linear in there))
        raise ProblemError(
            f"{name}: expected first-order tetrahedra, hexahedra, triangles or quadrilaterals, "
            f"found {known or 'no cells'}"
        )
    mesh = _named(raw, *shapes)
    setattr(mesh, FILE, {"name": Path(path).name, "sha256": sha256(path)})
    return mesh


def _named(raw: MeshOfFile, shape: str) -> Mesh:
    """The mesh of all elements of a shape, without other nodes, and its sets."""
    own = {label: nodes for label, (kind, nodes) in raw.elements.items() if kind == shape}
    used, flat = np.unique(np.array(list(own.values())).T[KINDS[shape].order], return_inverse=True)
    points = raw.at(used).T
    dimension = 3 if shape in SOLIDS else 2
    if dimension == 2 and np.ptp(points[2]) > REACH * np.ptp(points, axis=1).max():
        raise ProblemError(f"{raw.name}: expected a mesh in the plane z = constant, found z varying")
    mesh = KINDS[shape].mesh(
        np.ascontiguousarray(points[:dimension]), flat.reshape(len(KINDS[shape].order), -1)
    )
    ends, outside = used[np.sort(mesh.facets, axis=0)], mesh.boundary_facets()
    facet_of = {tuple(corners): k for k, corners in enumerate(ends.T.tolist())}
    boundaries = {
        name: outside[np.isin(ends[:, outside], nodes).all(axis=0)] for name, nodes in raw.node_sets.items()
    }
    for name in raw.surfaces:
        corners = [tuple(sorted(facet.corners)) for facet in raw.facets(name) if facet.element in own]
        boundaries[name] = np.array([facet_of[ends] for ends in corners], dtype=int)
    place = {label: k for k, label in enumerate(own)}
    subdomains = {
        name: np.array([place[label] for label in labels.tolist() if label in place], dtype=int)
        for name, labels in raw.element_sets.items()
    }
    boundaries, subdomains = (
        {raw.spelled.get(name, name): members for name, members in sets.items() if len(members)}
        for sets in (boundaries, subdomains)
    )
    return mesh.with_boundaries(boundaries).with_subdomains(subdomains)


def origin_text(
    bodies: Sequence[tuple[ElasticBody, str]],
    steps: int | None,
    contact: Mapping[str, object],
    warnings: Sequence[str] = (),
) -> str:
    """``source`` of a problem as JSON: no date, no machine, the same text for the same joint.

    Parameters
    ----------
    bodies
        Each body with its contact boundary.
    steps
        Load steps at which functions of time are sampled.
    contact
        What else was given: friction, initial gap, bolts, how two bodies are coupled.
    warnings
        What is doubtful of the joint.

    Examples
    --------
    >>> from shakedown.fem import Material, Pressure, block_mesh
    >>> press = Pressure("top", 2.0, history=1.0)
    >>> body = ElasticBody(block_mesh(2.0, 1.0, 4, 2), Material(210e3, 0.3), loads=[press])
    >>> found = json.loads(origin_text([(body, "bottom")], 8, {"friction": 0.5}))
    >>> found["bodies"][0]["loads"]
    [{'kind': 'Pressure', 'history': 1.0, 'boundary': 'top', 'value': 2.0}]
    """
    about: dict[str, Any] = {
        "toolkit": f"shakedown-bounds {__version__}",
        "made_by": "shakedown.fem.contact_problem",
        "steps": steps,
        **{key: _told(value) for key, value in contact.items()},
        "bodies": [_body(body, boundary) for body, boundary in bodies],
        "files": [getattr(body.mesh, FILE) for body, _ in bodies if hasattr(body.mesh, FILE)],
        "warnings": list(warnings),
    }
    return json.dumps({key: value for key, value in about.items() if value not in (None, [])})


def _body(body: ElasticBody, boundary: str) -> dict[str, Any]:
    parts = {"whole body": body.material} if isinstance(body.material, Material) else body.material
    low, high = body.mesh.p.min(axis=1).tolist(), body.mesh.p.max(axis=1).tolist()
    mesh = {
        "elements": int(body.mesh.nelements),
        "nodes": int(body.dofs[:, 0].max()) + 1,
        "type": KINDS[body.shape].elements[body.order - 1].__name__,
        **{axis: [low[k], high[k]] for k, axis in enumerate(AXES[: body.dimension])},
    }
    held = [(each.boundary, each.holds(body.dimension)) for each in body.supports]
    return {
        "contact": boundary,
        **({"plane": body.plane, "thickness": float(body.thickness)} if body.dimension == 2 else {}),
        **({"rigid": list(body.rigid)} if body.rigid else {}),
        "materials": {name: _told(material) for name, material in parts.items()},
        "mesh": mesh,
        "supports": [{"boundary": name, "holds": [AXES[k - 1] for k in along]} for name, along in held],
        "loads": [{"kind": type(load).__name__, **_told(load)} for load in body.loads],
    }


def _told(value: Any) -> Any:
    """A value for JSON: numbers, texts and short lists as they are, a longer list as its size and range."""
    if value is None or isinstance(value, str | int):
        return value
    if is_dataclass(value) or isinstance(value, Mapping):
        given = value if isinstance(value, Mapping) else vars(value)
        return {name: _told(part) for name, part in given.items() if part is not None}
    if callable(value):
        return "a function"
    if isinstance(value, tuple):
        return [_told(part) for part in value]
    values = np.asarray(value, dtype=float)
    if values.size <= EACH_SHOWN:
        return values.tolist()
    return f"{values.size} values, {values.min():.6g} … {values.max():.6g}"
