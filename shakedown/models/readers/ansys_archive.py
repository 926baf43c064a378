"""Ansys archives (``CDWRITE``, ``.cdb``; ``ds.dat`` of Workbench): nodes, elements, components of both."""

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from shakedown.models.readers.formats import OF_MODEL, Format, has
from shakedown.models.readers.mesh import CORNERS, Element, Mesh
from shakedown.models.readers.mesh_files import mesh_with_groups
from shakedown.models.readers.text import integers, number, quoted, read_lines, unfit

_BLOCK = re.compile(r"([NE]BLOCK|CMBLOCK)\s*,\s*([^,]*)(?:,\s*([A-Z]*)(?:\s*,\s*(\d{1,9}))?)?", re.IGNORECASE)
_LAYOUT = re.compile(r"\((\d{1,2})i(\d{1,2})(?:,(\d{1,2})[eg](\d{1,2}))?", re.IGNORECASE)
_TYPE = re.compile(r"ET\s*,\s*(\d{1,9})\s*,\s*(\d{1,9})", re.IGNORECASE)
_REVOLVED = re.compile(r"KEYO\w*\s*,\s*(\d{1,9})\s*,\s*3\s*,\s*1\b", re.IGNORECASE)
_MOST = 10_000_000  # nodes of a component
_KIND, _COUNT, _LABEL, _NODES = 1, 8, 10, 11  # columns of an element: type, number of nodes, label, nodes
# What an element of a type may be, and which of its nodes count then: the others coincide with these.
_BRICK = {
    "hexahedron": tuple(range(20)),
    "wedge": (0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 15, 16, 17, 18),
    "tetrahedron": (0, 1, 2, 4, 8, 9, 11, 16, 17, 18),
}
_FLAT = {"quadrilateral": tuple(range(8)), "triangle": (0, 1, 2, 4, 5, 7)}
_TETRAHEDRON = {"tetrahedron": tuple(range(10))}
_SHAPES: dict[int, dict[str, tuple[int, ...]]] = {
    **dict.fromkeys((45, 95, 185, 186), _BRICK),
    **dict.fromkeys((92, 187, 285), _TETRAHEDRON),
    **dict.fromkeys((42, 82, 182, 183), _FLAT),
}


def read_ansys_archive(path: str | os.PathLike[str]) -> Mesh:
    """Read the nodes of an archive, its solid and plane elements, and its components as sets.

    Bricks and quadrilaterals with nodes that coincide are wedges, tetrahedra, triangles. Other elements
    (shells, contact, pyramids) have no faces here.

    Raises
    ------
    ProblemError
        If a line is malformed, a node is there twice, a component or an element has nodes that are none, or
        a component is not as long as its first line says.
    """
    name, lines = os.fspath(path), read_lines(path)
    places: list[tuple[int, list[float]]] = []
    cells: list[tuple[str, int, list[int]]] = []
    sets: dict[str, dict[str, NDArray[np.intp]]] = {"NODE": {}, "ELEM": {}}
    for k, line in enumerate(lines):
        if (block := _BLOCK.match(line)) is None:
            continue
        layout = _LAYOUT.match(lines[k + 1].replace(" ", "")) if k + 1 < len(lines) else None
        if layout is None:
            raise unfit(f"{name}: line {k + 2}", "a layout like (3i9,6e21.13e3)", "none")
        width, start, each = int(layout[2]) or 1, int(layout[1]) * int(layout[2]), int(layout[4] or 0)
        rows, what, kind = _rows(lines, k + 2, name), block[1].upper(), (block[3] or "")[:4].upper()
        if what == "NBLOCK":
            for where, text in rows:
                fields = [text[start + each * i : start + each * (i + 1)].strip() for i in range(3)]
                point = [number(field, where) if field else 0.0 for field in fields]
                places.append((integers([text[:width]], where)[0], point))
        elif what == "CMBLOCK" and kind in sets:
            where = f"{name}: component {quoted(block[2])}"
            members = [label for _, text in rows for label in _labels(text, width, where)]
            if block[4] and len(members) != int(block[4]):
                raise unfit(where, f"{block[4]} numbers, as its first line says", len(members))
            sets[kind][block[2].strip().upper()] = _component(members, where)
        elif what == "EBLOCK" and kind == "SOLI":
            cells += _cells(rows, width)
    labels = np.array([label for label, _ in places], dtype=np.intp)
    mesh = Mesh.of_nodes(labels, np.array([point for _, point in places]).reshape(-1, 3), name)
    types = {found[1]: int(found[2]) for found in map(_TYPE.match, lines) if found}
    flat = {kind for kind, own in types.items() if _SHAPES.get(own) is _FLAT}
    revolved = flat & {found[1] for found in map(_REVOLVED.match, lines) if found}
    shaped = {label: _shaped(_SHAPES.get(types.get(kind, 0), {}), nodes) for kind, label, nodes in cells}
    known = {label: own for label, own in shaped.items() if own is not None}
    found = mesh_with_groups(mesh, known, sets["ELEM"], sets["NODE"])
    return replace(found, axisymmetric=any(kind in revolved for kind, _, _ in cells))


def _rows(lines: list[str], begin: int, name: str) -> Iterator[tuple[str, str]]:
    """The lines of a block up to the next command, with where each stands."""
    for k in range(begin, len(lines)):
        if lines[k][:1] not in " 0123456789" or lines[k].strip() == "-1":
            return
        yield f"{name}: line {k + 1}", lines[k].rstrip()


def _labels(text: str, width: int, where: str) -> list[int]:
    """The whole numbers of a line, each so many characters wide."""
    return integers([text[k : k + width] for k in range(0, len(text), width)], where)


def _cells(rows: Iterator[tuple[str, str]], width: int) -> Iterator[tuple[str, int, list[int]]]:
    """Type, label and nodes of every element of a block; of more than eight nodes the others follow."""
    for where, text in rows:
        found = _labels(text, width, where)
        if len(found) > _COUNT and found[_COUNT] > len(found) - _NODES:
            found += _labels(next(rows, ("", ""))[1], width, where)
        if len(found) <= _NODES or len(found) != _NODES + found[_COUNT]:
            raise unfit(where, "an element of 11 numbers and as many nodes as the ninth says", quoted(text))
        yield str(found[_KIND]), found[_LABEL], found[_NODES:]


def _shaped(shapes: Mapping[str, tuple[int, ...]], nodes: list[int]) -> Element | None:
    """An element without nodes that coincide with others; None where it has no faces here.

    Nodes between corners that are all 0 are none.
    """
    if len(nodes) == 6 and "triangle" in shapes:
        return "triangle", tuple(nodes)
    corners = {node for shape in list(shapes)[:1] for node in nodes[: CORNERS[shape]]}
    for shape, order in shapes.items():
        own = [nodes[k] for k in order if k < len(nodes)]
        if len(corners) == CORNERS[shape] and corners == set(own[: CORNERS[shape]]):
            return shape, tuple(own if all(own) else own[: CORNERS[shape]])
    return None


def _component(members: list[int], where: str) -> NDArray[np.intp]:
    """The members of a component; a negative number ends a range that the number before it begins."""
    found: list[int] = []
    for member in members:
        first = found[-1] + 1 if found else 0
        if member < 0 and not 0 <= -member - first < _MOST:
            raise unfit(where, f"the end of a range after {first - 1}", member)
        found += range(first, 1 - member) if member < 0 else [member]
    return np.array(found, dtype=np.intp)


_TITLE = f"an archive of Ansys {OF_MODEL}"
FORMATS = (
    Format(
        "archive",
        _TITLE,
        {"mesh": read_ansys_archive},
        contains=has(re.compile("NBLOCK", re.IGNORECASE)),
    ),
)
