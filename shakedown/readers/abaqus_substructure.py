"""Abaqus ``*SUBSTRUCTURE MATRIX OUTPUT``, and what CalculiX writes under the same keyword."""

import os
import re

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.condensation.contact_frame import checked_dofs
from shakedown.errors import ProblemError
from shakedown.readers.stiffness import Stiffness
from shakedown.readers.text import integers, numbers, read_lines


def read_abaqus_substructure(path: str | os.PathLike[str]) -> Stiffness:
    """Read a ``*USER ELEMENT`` block: node labels from comments, dof lists, ``*MATRIX,TYPE=STIFFNESS``.

    Raises
    ------
    ProblemError
        If the block is incomplete, or the count of numbers is neither that of
        the lower triangle nor (UNSYM) that of the full matrix.
    """
    name = os.fspath(path)
    lines = read_lines(path)
    start = _find(lines, r"\*USER ELEMENT\b", name)
    header = lines[start].upper().replace(" ", "")
    count = re.search(r"NODES=(\d+)", header)
    if count is None:
        raise ProblemError(
            f"{name}: line {start + 1}: expected NODES=<number>, found '{lines[start].strip()}'"
        )
    labels = _labels(lines, start, name)
    if len(labels) != int(count[1]):
        raise ProblemError(
            f"{name}: expected {count[1]} node labels in the comments after '** ELEMENT NODES', "
            f"found {len(labels)}"
        )
    stop = _find(lines, r"\*MATRIX\s*,.*TYPE\s*=\s*STIFFNESS", name, start)
    dofs = _dofs(lines, start, stop, labels, name)
    data = _values(lines, stop, name)
    return Stiffness(
        _matrix(data, len(dofs), ",UNSYM" in header, name),
        checked_dofs(dofs),
        "substructure matrix",
        superelement=True,
    )


def _find(lines: list[str], pattern: str, name: str, start: int = 0) -> int:
    for k in range(start, len(lines)):
        if re.match(pattern, lines[k].strip(), re.IGNORECASE):
            return k
    keyword = pattern.split("\\b")[0].replace("\\s*", "").replace(".*", " ").replace("\\", "")
    raise ProblemError(f"{name}: expected the keyword {keyword}, found none")


def _labels(lines: list[str], start: int, name: str) -> list[int]:
    """Node labels, which live in the comment lines after ``** ELEMENT NODES`` only."""
    first = _find(lines, r"\*\*\s*ELEMENT NODES", name, start)
    labels: list[int] = []
    for k in range(first + 1, len(lines)):
        text = lines[k].strip()
        fields = [field.strip() for field in text.lstrip("*").split(",") if field.strip()]
        if not text.startswith("**") or not all(re.fullmatch(r"-?\d+", field) for field in fields):
            break
        labels += integers(fields, f"{name}: line {k + 1}")
    return labels


def _dofs(lines: list[str], start: int, stop: int, labels: list[int], name: str) -> NDArray[np.intp]:
    """(node, direction) of every row: a dof list holds from its node position on."""
    lists: list[list[int]] = [[] for _ in labels]
    position, seen = 1, False
    for k in range(start + 1, stop):
        text, where = lines[k].strip(), f"{name}: line {k + 1}"
        if not text or text.startswith("*"):
            continue
        fields = integers([field for field in text.split(",") if field.strip()], where)
        if seen:
            position, fields = fields[0], fields[1:]
        if not 1 <= position <= len(labels) or not fields:
            raise ProblemError(
                f"{where}: expected 'position, dof, …' with position 1 to {len(labels)}, found '{text}'"
            )
        lists[position - 1 :] = [fields] * (len(labels) - position + 1)
        seen = True
    if not seen:
        raise ProblemError(f"{name}: expected dof lists after *USER ELEMENT, found none")
    return np.array(
        [(label, d) for label, own in zip(labels, lists, strict=True) for d in own], dtype=np.intp
    )


def _values(lines: list[str], stop: int, name: str) -> list[float]:
    values: list[float] = []
    for k in range(stop + 1, len(lines)):
        text = lines[k].strip()
        if text.startswith("*"):
            break
        values += numbers([field for field in text.split(",") if field.strip()], f"{name}: line {k + 1}")
    return values


def _matrix(values: list[float], N: int, full: bool, name: str) -> sparse.csr_array:
    data = np.array(values)
    expected = N * N if full else N * (N + 1) // 2
    if len(data) != expected:
        raise ProblemError(
            f"{name}: expected {expected} numbers for {N} dofs "
            f"({'full matrix' if full else 'lower triangle'}), found {len(data)}"
        )
    if full:
        return sparse.csr_array(data.reshape(N, N).T)
    lower = np.zeros((N, N))
    lower[np.tril_indices(N)] = data
    return sparse.csr_array(lower + np.tril(lower, -1).T)
