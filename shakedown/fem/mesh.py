"""Meshes with named boundaries: rectangular blocks and bricks, decks, and whatever meshio reads."""

import io
import os
from collections.abc import Sequence
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import partial
from math import inf, isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from skfem import Mesh, MeshHex, MeshQuad, MeshTet, MeshTri

from shakedown.fem.origin import remember_file
from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.joint.arguments import checked
from shakedown.models.readers.cells import cells_of
from shakedown.models.readers.deck import read_deck


class ElementKind(NamedTuple):
    """What a cell type of meshio is in scikit-fem: the class of its mesh and the order of its corners.

    And what meshio calls its facets, and whether it is a solid.
    """

    mesh: type[Mesh]
    order: list[int]
    facet: str
    solid: bool


CORNERS = {"line": 2, "triangle": 3, "quad": 4}
KINDS = {  # solids first, as the other cells are boundaries beside them
    "hexahedron": ElementKind(MeshHex, [0, 4, 3, 1, 7, 5, 2, 6], "quad", True),
    "tetra": ElementKind(MeshTet, [0, 1, 2, 3], "triangle", True),
    "triangle": ElementKind(MeshTri, [0, 1, 2], "line", False),
    "quad": ElementKind(MeshQuad, [0, 1, 2, 3], "line", False),
}


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
    _check_block("block_mesh", (width, height), (nx, ny), (*origin, angle))
    x, y = np.linspace(0, width, nx + 1), np.linspace(0, height, ny + 1)
    mesh = MeshQuad.init_tensor(x, y).with_boundaries(
        {
            "left": lambda p: np.isclose(p[0], 0.0, atol=1e-9 * width),
            "right": lambda p: np.isclose(p[0], width, atol=1e-9 * width),
            "bottom": lambda p: np.isclose(p[1], 0.0, atol=1e-9 * height),
            "top": lambda p: np.isclose(p[1], height, atol=1e-9 * height),
        }
    )
    cos, sin = np.cos(angle), np.sin(angle)
    rotated = np.array([[cos, -sin], [sin, cos]]) @ mesh.p + np.array(origin)[:, None]
    return replace(mesh, doflocs=np.ascontiguousarray(rotated))


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
    _check_block("brick_mesh", sides, elements, origin)
    points = [
        start + np.linspace(0, side, count + 1)
        for start, side, count in zip(origin, sides, elements, strict=True)
    ]
    mesh = MeshHex.init_tensor(*points)
    if tetrahedra:
        mesh = mesh.to_meshtet()
    names = (("left", "right"), ("front", "back"), ("bottom", "top"))
    where = {
        name: partial(_at, axis, points[axis][end], 1e-9 * sides[axis])
        for axis, pair in enumerate(names)
        for name, end in zip(pair, (0, -1), strict=True)
    }
    return mesh.with_boundaries(where)


def _check_block(what: str, sides: Sequence[float], elements: Sequence[int], place: Sequence[float]) -> None:
    """Raise ``ProblemError`` unless a block has finite sides, elements along each, and a finite place."""
    if min(elements) < 1 or not all(0 < side < inf for side in sides) or not all(map(isfinite, place)):
        raise ProblemError(
            f"{what}: expected finite sides > 0, at least one element along each and a finite origin and "
            f"angle, found {' x '.join(map(str, sides))}, {' x '.join(map(str, elements))} at {tuple(place)}"
        )


def _at(axis: int, place: float, reach: float, p: FloatArray) -> FloatArray:
    return np.abs(p[axis] - place) <= reach


@checked
def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """A plane or solid mesh from a file that meshio reads, with its named sets.

    A file with tetrahedra or hexahedra is a solid; its triangles and quadrilaterals are boundaries.
    Gmsh physical groups and cell sets become boundaries and subdomains; a node
    set (Abaqus, CalculiX) becomes the boundary of all facets whose nodes it holds. Decks of these codes are
    read as :func:`shakedown.import_model` reads them: included files, sets of sets, surfaces of faces.
    A problem made with the mesh tells the file's name and SHA-256, unless the mesh is
    changed in between, as scikit-fem then makes a new one.

    Parameters
    ----------
    path
        Gmsh ``.msh``, Abaqus or CalculiX ``.inp``, Nastran bulk ``.bdf``, …

    Raises
    ------
    ProblemError
        If the file cannot be read, or holds no first-order tetrahedra or hexahedra, nor
        triangles or quadrilaterals in one plane.
    """
    name = os.fspath(path)
    raw = _raw(Path(path), name)
    there = {block.type for block in raw.cells}
    solids = [kind for kind in KINDS if kind in there and KINDS[kind].solid]
    found = solids or [kind for kind in KINDS if kind in there]
    if len(found) != 1:
        raise ProblemError(
            f"{name}: expected first-order tetrahedra, hexahedra, triangles or quadrilaterals, "
            f"found {', '.join(sorted(there)) or 'no cells'}"
        )
    points = np.ascontiguousarray(raw.points.T) if solids else _plane_points(name, raw.points)
    return remember_file(_named(raw, found[0], points), path)


def _raw(path: Path, name: str) -> Any:
    """What meshio reads, or an import of a deck; what meshio prints becomes part of the message."""
    import meshio

    if path.suffix.lower() == ".inp":
        return meshio.Mesh(**cells_of(read_deck(path))._asdict())
    said = io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            return meshio.read(path)
    except (OSError, ValueError, KeyError, IndexError, meshio.ReadError) as error:
        raise ProblemError(f"{name}: cannot be read as a mesh ({error or type(error).__name__})") from None
    except SystemExit:  # meshio ends the program where no reader takes the file
        reason = " ".join(said.getvalue().split())
        raise ProblemError(f"{name}: cannot be read as a mesh ({reason})") from None


def _plane_points(name: str, points: FloatArray) -> FloatArray:
    if points.shape[1] == 3 and np.ptp(points[:, 2]) > 1e-9 * np.ptp(points, axis=0).max():
        raise ProblemError(f"{name}: expected a mesh in the plane z = constant, found z varying")
    return np.ascontiguousarray(points[:, :2].T)


def _named(raw: Any, kind: str, points: FloatArray) -> Mesh:
    """Build the mesh without the nodes that no cell uses, and translate its sets."""
    mesh_class, order = KINDS[kind].mesh, KINDS[kind].order
    cells = np.vstack([block.data for block in raw.cells if block.type == kind]).T[order]
    used, flat = np.unique(cells, return_inverse=True)
    number = np.full(points.shape[1], -1)
    number[used] = np.arange(len(used))
    mesh = mesh_class(points[:, used], flat.reshape(cells.shape))
    boundaries = {key: _facets(mesh, number[np.asarray(ids)]) for key, ids in raw.point_sets.items()}
    subdomains: dict[str, FloatArray] = {}
    for key, parts in _cell_sets(raw).items():
        cells_in, lines = _members(raw, kind, parts)
        if len(lines):
            boundaries[key] = _facets_of(mesh, number[lines])
        if len(cells_in):
            subdomains[key] = cells_in
    boundaries = {key: facets for key, facets in boundaries.items() if len(facets)}
    return mesh.with_boundaries(boundaries).with_subdomains(subdomains)


def _cell_sets(raw: Any) -> dict[str, list[Any]]:
    """Named cell sets, per block of cells; Gmsh's physical groups among them."""
    sets = {key: list(parts) for key, parts in raw.cell_sets.items() if not key.startswith("gmsh:")}
    tags = raw.cell_data.get("gmsh:physical")
    if tags is not None:
        for key, (tag, _) in raw.field_data.items():
            sets[key] = [np.flatnonzero(np.asarray(t) == tag) for t in tags]
    return sets


def _members(raw: Any, kind: str, parts: list[Any]) -> tuple[Any, Any]:
    facet = KINDS[kind].facet
    cells, lines, offset = [np.zeros(0, int)], [np.zeros((0, CORNERS[facet]), int)], 0
    for block, part in zip(raw.cells, parts, strict=True):
        chosen = np.zeros(0, int) if part is None else np.asarray(part, dtype=int)
        if block.type == kind:
            cells.append(chosen + offset)
            offset += len(block.data)
        elif block.type == facet:
            lines.append(block.data[chosen])
    return np.concatenate(cells), np.concatenate(lines)


def _facets(mesh: Mesh, nodes: Any) -> Any:
    """Boundary facets all of whose nodes are in a node set."""
    facets = mesh.boundary_facets()
    return facets[np.isin(mesh.facets[:, facets], nodes).all(axis=0)]


def _facets_of(mesh: Mesh, lines: Any) -> Any:
    """Facets that coincide with cells of one dimension less."""
    wanted = {tuple(sorted(line)) for line in lines.tolist()}
    return np.array(
        [k for k, ends in enumerate(mesh.facets.T.tolist()) if tuple(sorted(ends)) in wanted], int
    )
