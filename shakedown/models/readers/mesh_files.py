"""Meshes with groups: Gmsh, MED (Salome, Code_Aster), VTU, UNV, archives of Ansys; lists of nodes.

All but UNV and lists are read by meshlane (the extra ``fem``), the kept-up fork of meshio: meshio has had no
release since January 2024 and drops the groups of MED files. UNV has a reader of its own, because meshlane
has none and that of pyuff takes an element of more than eight nodes for two.
"""

import io
import os
import re
import warnings
from collections.abc import Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from functools import partial
from itertools import chain
from typing import Any

import numpy as np

from shakedown.ground.constants import IntArray
from shakedown.ground.errors import ProblemError, not_installed
from shakedown.models.readers import parsing
from shakedown.models.readers.formats import OF_MODEL, Format, has
from shakedown.models.readers.mesh import CORNERS, SOLIDS, Element, Mesh
from shakedown.models.readers.parsing import quoted, unfit

# Descriptors of UNV: the shape, and the places of the corners and then of the nodes between them.
_UNIVERSAL: dict[int, tuple[str, tuple[int, ...]]] = {
    **dict.fromkeys((11, 21), ("line", (0, 1))),
    **dict.fromkeys((22, 24), ("line", (0, 2, 1))),
    **dict.fromkeys((41, 51, 81, 91), ("triangle", (0, 1, 2))),
    **dict.fromkeys((42, 52, 82, 92), ("triangle", (0, 2, 4, 1, 3, 5))),
    **dict.fromkeys((44, 54, 84, 94), ("quadrilateral", (0, 1, 2, 3))),
    **dict.fromkeys((45, 55, 85, 95), ("quadrilateral", (0, 2, 4, 6, 1, 3, 5, 7))),
    111: ("tetrahedron", (0, 1, 2, 3)),
    112: ("wedge", (0, 1, 2, 3, 4, 5)),
    113: ("wedge", (0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8)),
    115: ("hexahedron", (0, 1, 2, 3, 4, 5, 6, 7)),
    116: ("hexahedron", (0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11)),
    118: ("tetrahedron", (0, 2, 4, 9, 1, 3, 5, 6, 7, 8)),
}


def read_by_meshlane(path: str | os.PathLike[str], kind: str | None = None) -> Mesh:
    """Read a mesh with its groups of nodes, of elements and of their sides.

    Nodes have the numbers that a Gmsh file gives them; those of other files are numbered from 1 in their
    order. A file without groups, as VTU is, has a set for each value of the whole numbers on its cells and
    points.

    Parameters
    ----------
    path
        The file.
    kind
        What meshlane calls its format; by default its name says it.

    Raises
    ------
    ProblemError
        If meshlane is not installed, or cannot read the file.
    """
    name = os.fspath(path)
    parsing.open_input(path).close()
    try:
        import meshlane
    except ImportError:
        raise ProblemError(not_installed(name, "meshlane, which reads meshes", "fem")) from None
    printed = io.StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(printed), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            raw = meshlane.read(path, kind)
            labels = (
                _gmsh_labels(path, len(raw.points)) if kind == "gmsh" else np.arange(1, len(raw.points) + 1)
            )
            return _of_cells(raw, labels, name)
    except Exception as error:  # whatever a reader of meshlane raises on a damaged file
        reason = str(error) or type(error).__name__
    except SystemExit:  # meshlane ends the program where no reader takes the file
        reason = " ".join(printed.getvalue().split())
    raise ProblemError(f"{name}: cannot be read as a mesh ({quoted(reason)[1:-1]})") from None


def _gmsh_labels(path: str | os.PathLike[str], count: int) -> IntArray:
    """The numbers of the nodes of a Gmsh file, which meshlane drops.

    Raises
    ------
    ProblemError
        If a binary file numbers its nodes otherwise than 1 ... n; Mesh.Binary = 0 makes Gmsh write text.
    """
    head, _, rest = parsing.read_bytes(path).partition(b"$Nodes")
    version, binary = head.partition(b"$MeshFormat")[2].split()[:2]
    if binary != b"0":  # meshlane takes no other numbers than 1 to n in files of version 2
        least, most = np.frombuffer(rest[17:33], np.uint64).tolist() if version == b"4.1" else (1, count)
        if (least, most) != (1, count):
            raise unfit("binary file", f"nodes 1 to {count}", f"{least} to {most}")
        return np.arange(1, count + 1)
    words = rest.partition(b"$EndNodes")[0].split()
    if version[:1] == b"2":
        return np.array(words[1::4], dtype=np.intp)
    labels: list[bytes] = []
    at = 2 if version == b"4.0" else 4
    while at < len(words):
        own = int(words[at + 3])
        block = words[at + 4 : at + 4 * (own + 1)]
        labels += block[::4] if version == b"4.0" else block[:own]
        at += 4 * (own + 1)
    return np.array(labels, dtype=np.intp)


def _of_cells(raw: Any, labels: IntArray, name: str) -> Mesh:
    """The mesh of what meshlane has read."""
    xyz = np.zeros((len(raw.points), 3))
    xyz[:, : raw.points.shape[1]] = raw.points
    shapes = {  # where meshlane has another name
        **dict.fromkeys(("tetra", "tetra10"), "tetrahedron"),
        **dict.fromkeys(("quad", "quad8"), "quadrilateral"),
        "wedge15": "wedge",
        "hexahedron20": "hexahedron",
        "triangle6": "triangle",
    }
    blocks = [(shapes.get(block.type, block.type), block.data) for block in raw.cells]
    elements = [(shape, tuple(labels[own].tolist())) for shape, data in blocks for own in data]
    first = np.cumsum([1, *(len(data) for _, data in blocks)])
    if not raw.cell_sets and not raw.point_sets:
        _sets_of_numbers(raw)
    members: dict[str, IntArray] = {}
    for key, parts in raw.cell_sets.items():
        own = [start + part for start, part in zip(first, parts, strict=False) if part is not None]
        if not key.startswith("gmsh:"):
            members[key] = np.concatenate(own)
    mesh = Mesh.of_nodes(labels, xyz, name)
    of_nodes = {key: labels[own] for key, own in raw.point_sets.items()}
    return mesh_with_groups(mesh, dict(enumerate(elements, start=1)), members, of_nodes)


def _sets_of_numbers(raw: Any) -> None:
    """Name sets by the whole numbers on cells; Gmsh's physical groups by their names."""
    numbered = [key for key, own in raw.cell_data.items() if all(tags.dtype.kind in "iu" for tags in own)]
    physical = list(zip(raw.cell_data.get("gmsh:physical", ()), raw.cells, strict=False))
    for key, (tag, d) in raw.field_data.items() if physical else ():
        raw.cell_sets[key] = [np.flatnonzero((own == tag) & (block.dim == d)) for own, block in physical]
    for key in numbered if not raw.cell_sets else ():
        raw.cell_data_to_sets(key)


def mesh_with_groups(
    mesh: Mesh,
    cells: Mapping[int, Element],
    groups: Mapping[str, IntArray],
    node_groups: Mapping[str, IntArray],
) -> Mesh:
    """Nodes with cells and groups of cells and of nodes, by their labels.

    Solids are elements where there are any, else cells in the plane. A group of cells that are sides of
    elements is a surface; one of other cells, as of points, is a set of their nodes.

    Raises
    ------
    ProblemError
        If a cell or a group has nodes that are none, or names of groups differ in their case alone.
    """
    names = sorted({*groups, *node_groups})
    spelled = {key.upper(): key for key in names}
    if alike := set(names).difference(spelled.values()):
        raise unfit("groups", "names unlike in any case", quoted(min(alike)))
    named = {key.upper(): np.asarray(own, dtype=np.intp) for key, own in node_groups.items()}
    mesh.at(np.array(list({*chain(*(nodes for _, nodes in cells.values()), *named.values())}), dtype=np.intp))
    solid = any(shape in SOLIDS for shape, _ in cells.values())
    kept = SOLIDS if solid else ("triangle", "quadrilateral")
    elements = {label: cell for label, cell in cells.items() if cell[0] in kept}
    mesh.node_sets.update(named)
    mesh = replace(mesh, elements=elements, spelled=spelled)
    count = {"line": 2, "line3": 2, "triangle": 3, "quadrilateral": 4}  # corners of what may be a side
    corners = {
        label: frozenset(nodes[: count[shape]])
        for label, (shape, nodes) in cells.items()
        if label not in elements and shape in count
    }
    face_of = mesh.faces_with(set(corners.values()))
    surfaces, element_sets = {}, {}
    for key, members in groups.items():
        labels = [int(label) for label in members if int(label) in cells]
        sides = [label for label in labels if label not in elements]
        faces = [face_of.get(corners.get(label, frozenset())) for label in sides]
        if faces and all(faces):
            surfaces[key.upper()] = tuple(face for face in faces if face)
        elif sides:
            nodes = dict.fromkeys(node for label in sides for node in cells[label][1])
            mesh.node_sets.setdefault(key.upper(), np.array(list(nodes), dtype=np.intp))
        if len(sides) < len(labels):
            element_sets[key.upper()] = np.array(sorted({*labels} - {*sides}), dtype=np.intp)
    return replace(mesh, surfaces=surfaces, element_sets=element_sets)


def read_universal(path: str | os.PathLike[str]) -> Mesh:
    """Read a mesh of a universal file (UNV): nodes, elements and permanent groups.

    Raises
    ------
    ProblemError
        If a dataset is cut off or malformed, or an element is there twice.
    """
    of_nodes, of_elements, of_groups = ("2411", "781"), "2412", ("2435", "2452", "2467", "2477")  # datasets
    name, lines = os.fspath(path), parsing.read_lines(path)
    marks = [k for k, line in enumerate(lines) if line.strip() == "-1"]
    if len(marks) % 2:
        raise unfit(f"{name}: line {marks[-1] + 1}", "the end of a dataset (-1)", "none")
    places: dict[int, list[float]] = {}
    cells: dict[int, Element] = {}
    groups: dict[str, list[int]] = {}
    node_groups: dict[str, list[int]] = {}
    for begin, end in zip(marks[::2], marks[1::2], strict=True):
        kind = lines[begin + 1].strip()
        rows = ((f"{name}: line {k + 1}", lines[k]) for k in range(begin + 2, end))
        for where, line in rows if kind in (*of_nodes, of_elements, *of_groups) else ():
            head = parsing.integers(line.split(), where)
            if len(head) < (1 if kind in of_nodes else 6):
                raise unfit(where, "the head of a record", quoted(line))
            if (head[0] in places and kind in of_nodes) or (head[0] in cells and kind == of_elements):
                raise unfit(where, "every node and element once", f"{head[0]} twice")
            if kind in of_nodes:
                places[head[0]] = parsing.numbers(_fields(rows, 3, where), where)
            elif kind == of_elements:
                if head[1] in (11, 21, 22, 23, 24):  # beams have a line more
                    next(rows, None)
                own = parsing.integers(_fields(rows, head[5], where), where)
                shape, order = _UNIVERSAL.get(head[1], ("", tuple(range(len(own)))))
                if len(order) != len(own):
                    raise unfit(where, f"{len(order)} nodes of an element", len(own))
                cells[head[0]] = shape, tuple(own[k] for k in order)
            else:
                group = next(rows, ("", ""))[1].strip()
                own = parsing.integers(_fields(rows, 4 * head[-1], where), where)  # kind, tag, two more
                for code, into in ((7, node_groups), (8, groups)):
                    tags = [tag for each, tag in zip(own[::4], own[1::4], strict=True) if each == code]
                    if tags:
                        into[group] = tags
    xyz = np.array(list(places.values())).reshape(-1, 3)
    mesh = Mesh.of_nodes(np.array(list(places), dtype=np.intp), xyz, name)
    arrays = ({key: np.array(own) for key, own in of.items()} for of in (groups, node_groups))
    return mesh_with_groups(mesh, cells, *arrays)


def _fields(rows: Iterator[tuple[str, str]], count: int, where: str) -> list[str]:
    """So many numbers from the next lines of a dataset."""
    found: list[str] = []
    while len(found) < count:
        line = next(rows, None)
        if line is None:
            raise unfit(where, f"{count} numbers behind this line", len(found))
        found += line[1].split()
    return found[:count]


def read_coordinates(path: str | os.PathLike[str]) -> Mesh:
    """Read a list of nodes, as Ansys and most other codes write one.

    Columns are node, x, y and where given z; the header, the delimiter and a
    decimal comma are found out (see :func:`shakedown.models.readers.parsing.number_table`). Of what NLIST of
    Ansys prints, with its headings, the angles are passed over.

    Raises
    ------
    ProblemError
        If there are not three or four columns, a node number is not whole or
        occurs twice.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "nodes.txt"
    >>> _ = path.write_text("Node\\tX (m)\\tY (m)\\tZ (m)\\t\\n7\\t0,5\\t-1,e-001\\t0\\n")
    >>> read_coordinates(path).coordinates.tolist()
    [[0.5, -0.1, 0.0]]
    """
    lines, name = parsing.read_lines(path), os.fspath(path)
    if heading := next((line for line in lines if re.match(r"\s*NODE\s+X\s+Y\s+Z\b", line)), None):
        rows = [line if line.strip()[:1].isdigit() else "" for line in lines]
        table = parsing.number_table(rows, name, marks=" ")
    else:
        table = parsing.number_table(lines, name)
    count = table.values.shape[1]
    if count not in ((4, 7) if heading else (3, 4)):
        raise unfit(name, "the columns node, x, y and maybe z", count)
    xyz = np.zeros((len(table.values), 3))
    xyz[:, : min(count - 1, 3)] = table.values[:, 1:4]
    return Mesh.of_nodes(np.array(table.whole(1), dtype=np.intp), xyz, name)


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
    name, lines = os.fspath(path), parsing.read_lines(path)
    places: list[tuple[int, list[float]]] = []
    cells: list[tuple[str, int, list[int]]] = []
    sets: dict[str, dict[str, IntArray]] = {"NODE": {}, "ELEM": {}}
    begins = re.compile(
        r"([NE]BLOCK|CMBLOCK)\s*,\s*([^,]*)(?:,\s*([A-Z]*)(?:\s*,\s*(\d{1,9}))?)?", re.IGNORECASE
    )
    for k, line in enumerate(lines):
        if (block := begins.match(line)) is None:
            continue
        form = r"\((\d{1,2})i(\d{1,2})(?:,(\d{1,2})[eg](\d{1,2}))?"
        layout = re.match(form, "".join(lines[k + 1 : k + 2]).replace(" ", ""), re.IGNORECASE)
        if layout is None:
            raise unfit(f"{name}: line {k + 2}", "a layout like (3i9,6e21.13e3)", "none")
        width, start, each = int(layout[2]) or 1, int(layout[1]) * int(layout[2]), int(layout[4] or 0)
        rows, what, kind = _rows(lines, k + 2, name), block[1].upper(), (block[3] or "")[:4].upper()
        if what == "NBLOCK":
            for where, text in rows:
                fields = [text[start + each * i : start + each * (i + 1)].strip() for i in range(3)]
                point = [parsing.number(field, where) if field else 0.0 for field in fields]
                places.append((parsing.integers([text[:width]], where)[0], point))
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
    of_type = re.compile(r"ET\s*,\s*(\d{1,9})\s*,\s*(\d{1,9})", re.IGNORECASE)
    around = re.compile(r"KEYO\w*\s*,\s*(\d{1,9})\s*,\s*3\s*,\s*1\b", re.IGNORECASE)
    shapes = {found[1]: _shapes_of(int(found[2])) for found in map(of_type.match, lines) if found}
    flat = {kind for kind, own in shapes.items() if "triangle" in own}
    revolved = flat & {found[1] for found in map(around.match, lines) if found}
    shaped = {label: _shaped(shapes.get(kind, {}), nodes) for kind, label, nodes in cells}
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
    return parsing.integers([text[k : k + width] for k in range(0, len(text), width)], where)


def _cells(rows: Iterator[tuple[str, str]], width: int) -> Iterator[tuple[str, int, list[int]]]:
    """Type, label and nodes of every element of a block; of more than eight nodes the others follow."""
    for where, text in rows:
        found = _labels(text, width, where)
        if len(found) > 8 and found[8] > len(found) - 11:
            found += _labels(next(rows, ("", ""))[1], width, where)
        if len(found) <= 11 or len(found) != 11 + found[8]:
            raise unfit(where, "an element of 11 numbers and as many nodes as the ninth says", quoted(text))
        yield str(found[1]), found[10], found[11:]


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


def _shapes_of(kind: int) -> dict[str, tuple[int, ...]]:
    """What an element of a type may be, and which of its nodes count then: the others coincide with these."""
    if kind in (45, 95, 185, 186):
        return {
            "hexahedron": tuple(range(20)),
            "wedge": (0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 15, 16, 17, 18),
            "tetrahedron": (0, 1, 2, 4, 8, 9, 11, 16, 17, 18),
        }
    if kind in (92, 187, 285):
        return {"tetrahedron": tuple(range(10))}
    if kind in (42, 82, 182, 183):
        return {"quadrilateral": tuple(range(8)), "triangle": (0, 1, 2, 4, 5, 7)}
    return {}


def _component(members: list[int], where: str) -> IntArray:
    """The members of a component; a negative number ends a range that the number before it begins."""
    found: list[int] = []
    for member in members:
        first = found[-1] + 1 if found else 0
        if member < 0 and not 0 <= -member - first < 10_000_000:  # nodes of a component
            raise unfit(where, f"the end of a range after {first - 1}", member)
        found += range(first, 1 - member) if member < 0 else [member]
    return np.array(found, dtype=np.intp)


FORMATS = (
    *(
        Format(
            kind,
            f"a mesh, {kind.upper()} {OF_MODEL}",
            {"mesh": read_universal if kind == "unv" else partial(read_by_meshlane, kind=kind)},
            begins=re.compile(pattern, re.DOTALL).match,
        )
        for kind, pattern in {
            "gmsh": r"\$MeshFormat",
            "med": r"\x89HDF",
            "vtu": r"\s*(<\?xml[^>]*>\s*)?(<!--.*?-->\s*)?<VTKFile[^>]*UnstructuredGrid",
            "unv": r"\s*-1\s*\n\s*\d{2,5}\s*\n",
        }.items()
    ),
    Format(
        "archive",
        f"an archive of Ansys {OF_MODEL}",
        {"mesh": read_ansys_archive},
        contains=has(re.compile("NBLOCK", re.IGNORECASE)),
    ),
    Format("coordinates", "a list of nodes", {"mesh": read_coordinates}),
)
