"""Abaqus ``*SUBSTRUCTURE MATRIX OUTPUT`` with load cases, and what CalculiX writes under that keyword."""

import itertools
import os
import re
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.models.condensation.contact_frame import checked_dofs
from shakedown.models.readers.abaqus_matrix import NodalLoads
from shakedown.models.readers.formats import Format, register
from shakedown.models.readers.stiffness import Stiffness, printed_accuracy
from shakedown.models.readers.text import integers, listed, number, quoted, read_lines

ELEMENT = re.compile(r"\s*\*USER ELEMENT\b", re.IGNORECASE)
_LOAD = re.compile(r"\*\*\s*SUBSTRUCTURE LOAD\b(?:.*?(?:CASE|VECTOR)\W+(?=\w+\s*$))?(.*)$", re.IGNORECASE)


def read_abaqus_substructure(path: str | os.PathLike[str]) -> Stiffness:
    """Read a ``*USER ELEMENT`` block: node labels from comments, dof lists, ``*MATRIX,TYPE=STIFFNESS``.

    Raises
    ------
    ProblemError
        If the block is incomplete, or the count of numbers is neither that of
        the lower triangle nor (UNSYM) that of the full matrix.
    """
    name, lines = os.fspath(path), read_lines(path)
    start, stop, labels = _block(lines, name)
    dofs = _dofs(lines, start, stop, labels, name)
    N, full = len(dofs), ",UNSYM" in _header(lines, start)
    rows = itertools.takewhile(lambda row: not row[1].startswith("*"), _stripped(lines, stop + 1))
    fields = [(field, f"{name}: line {k}") for k, text in rows for field in text.split(",") if field.strip()]
    data = np.array([number(*field) for field in fields])
    expected = N * N if full else N * (N + 1) // 2
    if len(data) != expected:
        raise ProblemError(
            f"{name}: expected {expected} numbers for {N} dofs "
            f"({'full matrix' if full else 'lower triangle'}), found {len(data)}"
        )
    K = data.reshape(N, N).T if full else np.zeros((N, N))
    if not full:
        lower = np.tril_indices(N)
        K[lower] = K.T[lower] = data
    format, accuracy = "substructure matrix", printed_accuracy(data)
    return Stiffness(sparse.csr_array(K), checked_dofs(dofs), format, superelement=True, accuracy=accuracy)


def read_substructure_load(path: str | os.PathLike[str], case: str | None = None) -> NodalLoads:
    """Read a load case vector (``SLOAD=YES``): forces on the retained degrees of freedom.

    The vectors stand in comment lines behind the matrices, one line ``position,
    dof, value`` per entry; the position counts in the node list, as in the dof
    lists.

    Parameters
    ----------
    path
        The ``.mtx`` file.
    case
        Name of the ``*SUBSTRUCTURE LOAD CASE``; by default the only one.

    Raises
    ------
    ProblemError
        If there is no such case, or a line of it is malformed.
    """
    name, lines = os.fspath(path), read_lines(path)
    _, _, labels = _block(lines, name)
    found = {
        (match[1] or "").strip().upper(): k for k, line in enumerate(lines) if (match := _LOAD.match(line))
    }
    if case is None and len(found) == 1:
        case = next(iter(found))
    if case is None or case.strip().upper() not in found:
        raise ProblemError(f"{name}: expected one load case of SLOAD=YES (key 'case'), found {listed(found)}")
    loads: NodalLoads = {}
    for k in range(found[case.strip().upper()] + 1, len(lines)):
        text, where = lines[k].strip(), f"{name}: line {k + 1}"
        fields = text.lstrip("*").replace(",", " ").split()
        if not text.startswith("**") or (loads and (len(fields) < 3 or not fields[-2].isdigit())):
            break
        if len(fields) < 3 or not fields[-2].isdigit():
            continue  # a heading
        position, direction = integers(fields[-3:-1], where)
        if not 1 <= position <= len(labels):
            raise ProblemError(f"{where}: expected a position from 1 to {len(labels)}, found {position}")
        key = (labels[position - 1], direction)
        if key in loads:
            raise ProblemError(
                f"{where}: expected every position and dof once, found {position}, {direction} twice"
            )
        loads[key] = number(fields[-1], where)
    if not loads:
        raise ProblemError(f"{name}: expected entries of the load case {quoted(case)}, found none")
    return loads


def _stripped(lines: list[str], start: int, stop: int | None = None) -> Iterator[tuple[int, str]]:
    """Numbers, from 1, and texts of lines."""
    return ((k, line.strip()) for k, line in enumerate(lines[start:stop], start=start + 1))


def _header(lines: list[str], start: int) -> str:
    return lines[start].upper().replace(" ", "")


def _block(lines: list[str], name: str) -> tuple[int, int, list[int]]:
    """Where the element and its stiffness begin, and the labels of its nodes, which stand in comments."""
    start = _find(lines, r"\*USER ELEMENT\b", name)
    count = re.search(r"NODES=(\d+)", _header(lines, start))
    if count is None:
        raise ProblemError(f"{name}: line {start + 1}: expected NODES=<number>, found {quoted(lines[start])}")
    labels: list[int] = []
    for k, text in _stripped(lines, _find(lines, r"\*\*\s*ELEMENT NODES", name, start) + 1):
        fields = [field.strip() for field in text.lstrip("*").split(",") if field.strip()]
        if not text.startswith("**") or not all(re.fullmatch(r"-?\d+", field) for field in fields):
            break
        labels += integers(fields, f"{name}: line {k}")
    if str(len(labels)) != count[1].lstrip("0"):
        raise ProblemError(
            f"{name}: expected {quoted(count[1])[1:-1]} node labels in the comments after '** ELEMENT "
            f"NODES', found {len(labels)}"
        )
    return start, _find(lines, r"\*MATRIX\s*,.*TYPE\s*=\s*STIFFNESS", name, start), labels


def _find(lines: list[str], pattern: str, name: str, start: int = 0) -> int:
    for k in range(start, len(lines)):
        if re.match(pattern, lines[k].strip(), re.IGNORECASE):
            return k
    keyword = pattern.split("\\b")[0].replace("\\s*", "").replace(".*", " ").replace("\\", "")
    raise ProblemError(f"{name}: expected the keyword {keyword}, found none")


def _dofs(lines: list[str], start: int, stop: int, labels: list[int], name: str) -> NDArray[np.intp]:
    """(node, direction) of every row; a dof list holds from its node on, up to that of the next list."""
    lists: list[list[int]] = [[] for _ in labels]
    position, seen = 1, False
    for k, text in _stripped(lines, start + 1, stop):
        if not text or text.startswith("*"):
            continue
        where = f"{name}: line {k}"
        fields = integers([field for field in text.split(",") if field.strip()], where)
        if seen:
            position, fields = fields[0], fields[1:]
        if not 1 <= position <= len(labels) or not fields:
            raise ProblemError(
                f"{where}: expected 'position, dof, …' with position 1 to {len(labels)}, found {quoted(text)}"
            )
        lists[position - 1 :] = [fields] * (len(labels) - position + 1)
        seen = True
    if not seen:
        raise ProblemError(f"{name}: expected dof lists after *USER ELEMENT, found none")
    rows = [(label, d) for label, own in zip(labels, lists, strict=True) for d in own]
    return np.array(rows, dtype=np.intp)


register(Format("substructure", "Abaqus substructure", read_abaqus_substructure, line=ELEMENT))
