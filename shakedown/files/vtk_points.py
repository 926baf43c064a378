"""Points with numbers as VTK XML files, an unstructured grid (.vtu) or poly data (.vtp): faces, or vertices.

The format is that of https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html, serial,
with inline binary arrays: base64 of their size in bytes (UInt64) and of the bytes. Text has no
undefined numbers there that every reader takes.
"""

import struct
from base64 import b64encode
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray

from shakedown.files.atomic_write import atomic_write, atomic_write_together
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import UsageError

GRIDS = {".vtu": "UnstructuredGrid", ".vtp": "PolyData"}
CELL_TYPES = np.array(
    [0, 1, 0, 5, 9], dtype=np.uint8
)  # VTK's: a vertex, a triangle, a quadrilateral, by corners


def write_points(
    path: str | PathLike[str],
    points: FloatArray,
    numbers: Mapping[str, NDArray[np.generic]],
    faces: NDArray[np.integer] | None = None,
) -> None:
    """Write points (n, 3) with whole or floating-point numbers (n,) or (n, 3) at each, by name.

    Faces (k, 4) have numbers of points in order around each, −1 as the last of a triangle. A point of no
    face is a vertex.

    Raises
    ------
    UsageError
        If the name of the file ends in neither .vtu nor .vtp, or it cannot be written.
    """
    text = _document(path, points, numbers, faces)
    with atomic_write(path) as file:
        file.write(text)


def write_points_series(
    path: str | PathLike[str],
    points: FloatArray,
    times: Sequence[float],
    numbers: Sequence[Mapping[str, NDArray[np.generic]]],
    faces: NDArray[np.integer] | None = None,
) -> tuple[Path, ...]:
    """Write points with numbers that change: NAME_000.vtp, …, and NAME.pvd that says when; all or none.

    Parameters
    ----------
    path
        NAME.vtp or NAME.vtu: the number of the instant stands before its ending.
    points : (n, 3)
        Where they are.
    times
        One per file, for ParaView.
    numbers
        By name, (n,) or (n, 3) at each instant.
    faces
        As for :func:`write_points`.

    Returns
    -------
    paths
        The .pvd and the files that it names.

    Raises
    ------
    UsageError
        As for :func:`write_points`.
    """
    files = series_paths(path, len(times))
    texts = [_collection(files[1:], times)]
    texts += [_document(file, points, each, faces) for file, each in zip(files[1:], numbers, strict=True)]
    with atomic_write_together(files) as parts:
        for part, text in zip(parts, texts, strict=True):
            part.write(text)
    return files


def series_paths(path: str | PathLike[str], count: int) -> tuple[Path, ...]:
    """The files for a number of instants, the .pvd first.

    Examples
    --------
    >>> [file.name for file in series_paths("nodes.vtp", 2)]
    ['nodes.pvd', 'nodes_000.vtp', 'nodes_001.vtp']
    """
    name = Path(path)
    if name.suffix.lower() not in GRIDS:
        raise UsageError(f"{path}: expected a name that ends in .vtu or .vtp")
    return name.with_suffix(".pvd"), *(name.with_stem(f"{name.stem}_{k:03d}") for k in range(count))


def _collection(files: Sequence[Path], times: Sequence[float]) -> bytes:
    """A ParaView data file: which file is of which time."""
    root = Element("VTKFile", {"type": "Collection", "version": "1.0", "byte_order": "LittleEndian"})
    collection = SubElement(root, "Collection")
    for file, time in zip(files, times, strict=True):
        SubElement(collection, "DataSet", {"timestep": repr(float(time)), "file": file.name})
    return _as_bytes(root)


def _document(
    path: str | PathLike[str],
    points: FloatArray,
    numbers: Mapping[str, NDArray[np.generic]],
    faces: NDArray[np.integer] | None,
) -> bytes:
    """One file."""
    grid = GRIDS.get(Path(path).suffix.lower())
    if grid is None:
        raise UsageError(f"{path}: expected a name that ends in .vtu or .vtp")
    n = len(points)
    root = Element(
        "VTKFile", {"type": grid, "version": "1.0", "byte_order": "LittleEndian", "header_type": "UInt64"}
    )
    piece = SubElement(SubElement(root, grid), "Piece", {"NumberOfPoints": str(n)})
    _add(SubElement(piece, "Points"), "Points", points)
    corners = np.zeros((0, 4), dtype=np.intp) if faces is None else faces
    alone = np.setdiff1d(np.arange(n), corners)[:, None]
    if grid == "PolyData":
        _add_poly_data(piece, alone, corners)
    else:
        _add_cells(piece, alone, corners)
    of_points = SubElement(piece, "PointData")
    for name, values in numbers.items():
        _add(of_points, name, values)
    return _as_bytes(root)


def _as_bytes(root: Element) -> bytes:
    indent(root)
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True))


def _add_cells(piece: Element, alone: NDArray[np.integer], faces: NDArray[np.integer]) -> None:
    """The cells of an unstructured grid: points alone, and then faces."""
    sizes = np.concatenate([_sizes(alone), _sizes(faces)])
    piece.set("NumberOfCells", str(len(sizes)))
    cells = SubElement(piece, "Cells")
    _connect(cells, alone, faces)
    _add(cells, "types", CELL_TYPES[sizes])


def _add_poly_data(piece: Element, alone: NDArray[np.integer], faces: NDArray[np.integer]) -> None:
    """The same of poly data."""
    for kind, count in (("Verts", len(alone)), ("Lines", 0), ("Strips", 0), ("Polys", len(faces))):
        piece.set(f"NumberOf{kind}", str(count))
    for kind, cells in (("Verts", alone), ("Polys", faces)):
        if len(cells):
            _connect(SubElement(piece, kind), cells)


def _connect(parent: Element, *kinds: NDArray[np.integer]) -> None:
    """The points of every cell, and where they end."""
    _add(parent, "connectivity", np.concatenate([cells[cells >= 0] for cells in kinds]))
    _add(parent, "offsets", np.concatenate([_sizes(cells) for cells in kinds]).cumsum())


def _sizes(cells: NDArray[np.integer]) -> NDArray[np.intp]:
    """How many points each cell has."""
    return np.asarray((cells >= 0).sum(axis=1))


def _add(parent: Element, name: str, values: NDArray[np.generic]) -> None:
    """A data array, its bytes in the order that the file states."""
    kind = values.dtype.kind
    dtype = np.dtype({"u": "<u1", "i": "<i8"}.get(kind, "<f8"))
    data = np.ascontiguousarray(values, dtype=dtype).tobytes()
    named = {"<u1": "UInt8", "|u1": "UInt8", "<i8": "Int64", "<f8": "Float64"}[dtype.str]
    about = {"type": named, "Name": name, "format": "binary"}
    if values.ndim == 2:
        about["NumberOfComponents"] = str(values.shape[1])
    SubElement(parent, "DataArray", about).text = b64encode(struct.pack("<Q", len(data)) + data).decode()
