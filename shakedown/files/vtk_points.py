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
    _grid(name)
    return name.with_suffix(".pvd"), *(name.with_stem(f"{name.stem}_{k:03d}") for k in range(count))


def _grid(path: str | PathLike[str]) -> str:
    """What VTK calls the kind of file that a name stands for."""
    grid = {".vtu": "UnstructuredGrid", ".vtp": "PolyData"}.get(Path(path).suffix.lower())
    if grid is None:
        raise UsageError(f"{path}: expected a name that ends in .vtu or .vtp")
    return grid


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
    """One file: the cells of an unstructured grid, points alone and then faces; both apart in poly data."""
    grid, n = _grid(path), len(points)
    corners = np.zeros((0, 4), dtype=np.intp) if faces is None else faces
    alone = np.setdiff1d(np.arange(n), corners)[:, None]
    kinds = {"Verts": [alone], "Lines": [], "Strips": [], "Polys": [corners]}
    if grid == "UnstructuredGrid":
        kinds = {"Cells": [alone, corners]}
    root = Element(
        "VTKFile", {"type": grid, "version": "1.0", "byte_order": "LittleEndian", "header_type": "UInt64"}
    )
    piece = SubElement(SubElement(root, grid), "Piece", {"NumberOfPoints": str(n)})
    _add(SubElement(piece, "Points"), "Points", points)
    for kind, cells in kinds.items():
        sizes = np.array([(cell >= 0).sum() for each in cells for cell in each], dtype=np.intp)
        piece.set(f"NumberOf{kind}", str(len(sizes)))
        if len(sizes):
            element = SubElement(piece, kind)
            _add(element, "connectivity", np.concatenate([each[each >= 0] for each in cells]))
            _add(element, "offsets", sizes.cumsum())
            if kind == "Cells":  # VTK's types of a vertex, a triangle and a quadrilateral
                _add(element, "types", np.array([0, 1, 0, 5, 9], dtype=np.uint8)[sizes])
    of_points = SubElement(piece, "PointData")
    for name, values in numbers.items():
        _add(of_points, name, values)
    return _as_bytes(root)


def _as_bytes(root: Element) -> bytes:
    indent(root)
    return bytes(tostring(root, encoding="utf-8", xml_declaration=True))


def _add(parent: Element, name: str, values: NDArray[np.generic]) -> None:
    """A data array, its bytes in the order that the file states."""
    form, dtype = {"u": ("UInt8", "<u1"), "i": ("Int64", "<i8")}.get(values.dtype.kind, ("Float64", "<f8"))
    data = np.ascontiguousarray(values, dtype=dtype).tobytes()
    about = {"type": form, "Name": name, "format": "binary"}
    if values.ndim == 2:
        about["NumberOfComponents"] = str(values.shape[1])
    SubElement(parent, "DataArray", about).text = b64encode(struct.pack("<Q", len(data)) + data).decode()
