"""Points with numbers as VTK XML files: an unstructured grid (.vtu) or poly data (.vtp), a vertex per point.

The format is that of https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html, serial,
with inline binary arrays: base64 of their size in bytes (UInt64) and of the bytes. Text has no
undefined numbers there that every reader takes.
"""

import struct
from base64 import b64encode
from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np
from numpy.typing import NDArray

from shakedown.files.atomic_write import atomic_write
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray

GRIDS = {".vtu": "UnstructuredGrid", ".vtp": "PolyData"}
VERTEX = 1  # VTK's number of a cell that is a point


def write_points(
    path: str | PathLike[str], points: FloatArray, numbers: Mapping[str, NDArray[np.generic]]
) -> None:
    """Write points (n, 3) with whole or floating-point numbers (n,) at each, by name.

    Raises
    ------
    UsageError
        If the name of the file ends in neither .vtu nor .vtp, or it cannot be written.
    """
    grid = GRIDS.get(Path(path).suffix.lower())
    if grid is None:
        raise UsageError(f"{path}: expected a name that ends in .vtu or .vtp")
    n = len(points)
    root = Element(
        "VTKFile", {"type": grid, "version": "1.0", "byte_order": "LittleEndian", "header_type": "UInt64"}
    )
    piece = SubElement(SubElement(root, grid), "Piece", {"NumberOfPoints": str(n)})
    _add(SubElement(piece, "Points"), "Points", points)
    piece.append(_vertices(piece, n) if grid == "PolyData" else _cells(piece, n))
    of_points = SubElement(piece, "PointData")
    for name, values in numbers.items():
        _add(of_points, name, values)
    indent(root)
    with atomic_write(path) as file:
        file.write(tostring(root, encoding="utf-8", xml_declaration=True))


def _cells(piece: Element, n: int) -> Element:
    """One vertex per point of an unstructured grid."""
    piece.set("NumberOfCells", str(n))
    cells = _connected(Element("Cells"), n)
    _add(cells, "types", np.full(n, VERTEX, dtype=np.uint8))
    return cells


def _vertices(piece: Element, n: int) -> Element:
    """One vertex per point of poly data."""
    for kind, count in (("Verts", n), ("Lines", 0), ("Strips", 0), ("Polys", 0)):
        piece.set(f"NumberOf{kind}", str(count))
    return _connected(Element("Verts"), n)


def _connected(cells: Element, n: int) -> Element:
    """Cell k has point k."""
    _add(cells, "connectivity", np.arange(n))
    _add(cells, "offsets", np.arange(1, n + 1))
    return cells


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
