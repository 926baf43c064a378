"""Nastran DMIG punch files: small, large and free field."""

import os
from collections.abc import Iterator

import numpy as np

from shakedown.errors import ProblemError
from shakedown.readers.stiffness import Stiffness, from_entries
from shakedown.readers.text import integers, number, read_lines

_Card = tuple[int, list[str]]
_SYMMETRIC, _SQUARE = 6, 1
_REAL = (1, 2)


def read_nastran_dmig(path: str | os.PathLike[str], matrix: str | None = None) -> Stiffness:
    """Read one matrix of a punch file.

    Parameters
    ----------
    path
        The file.
    matrix
        Its name, for instance ``KAAX``; by default the only one, or the only one
        whose name starts with K.

    Raises
    ------
    ProblemError
        If there is no such matrix, it is complex or rectangular, or a card is malformed.
    """
    name = os.fspath(path)
    cards = list(_cards(read_lines(path)))
    chosen = _chosen({fields[0] for _, fields in cards}, matrix, name)
    own = [(k, fields) for k, fields in cards if fields[0] == chosen]
    header = [(k, fields) for k, fields in own if fields[1] == "0"]
    if len(header) != 1:
        raise ProblemError(f"{name}: expected one DMIG header card for {chosen}, found {len(header)}")
    form, kind = integers(header[0][1][2:4], f"{name}: line {header[0][0]}")
    if form not in (_SYMMETRIC, _SQUARE) or kind not in _REAL:
        raise ProblemError(
            f"{name}: line {header[0][0]}: expected {chosen} square or symmetric (form 1, 6) and real "
            f"(type 1, 2), found form {form}, type {kind}"
        )
    rows, columns, values = [], [], []
    for k, fields in own:
        if fields[1] == "0":
            continue
        where = f"{name}: line {k}"
        column = integers([fields[1], fields[2] or "0"], where)
        entries = fields[4:]
        for group in range(0, len(entries), 4):
            node, direction, value = entries[group : group + 3]
            if node or value:
                rows.append(integers([node, direction or "0"], where))
                columns.append(column)
                values.append(number(value, where))
    if not values:
        raise ProblemError(f"{name}: expected entries of {chosen}, found none")
    return from_entries(
        np.array(rows, dtype=np.intp),
        np.array(columns, dtype=np.intp),
        np.array(values),
        name,
        "Nastran DMIG",
    )


def _chosen(found: set[str], matrix: str | None, name: str) -> str:
    if matrix is not None:
        if matrix not in found:
            raise ProblemError(f"{name}: expected the matrix {matrix}, found {', '.join(sorted(found))}")
        return matrix
    candidates = [one for one in found if one.startswith("K")] if len(found) > 1 else list(found)
    if len(candidates) != 1:
        raise ProblemError(
            f"{name}: expected one matrix, found {', '.join(sorted(found)) or 'none'}; name the one to take"
        )
    return candidates[0]


def _cards(lines: list[str]) -> Iterator[_Card]:
    """Line number and data fields (name, GJ, CJ, blank, then G, C, A, B groups) of every DMIG card."""
    card: _Card | None = None
    for k, line in enumerate(lines, start=1):
        text = line.split("$")[0].rstrip()
        if not text:
            continue
        first, fields = _fields(text)
        if first.rstrip("*").upper() == "DMIG":
            if card is not None:
                yield card
            card = k, fields
        elif card is not None and first[:1] in ("", "*", "+"):  # a continuation, named or not
            card[1].extend(fields)
        elif card is not None:  # another bulk data card
            yield card
            card = None
    if card is not None:
        yield card


def _fields(text: str) -> tuple[str, list[str]]:
    """First field and data fields of one line, sliced by columns unless it has commas."""
    if "," in text:
        first, *rest = [field.strip() for field in text.split(",")]
        width = 4 if "*" in first else 8
        return first, [*rest, *[""] * (width - len(rest))][:width]
    first = text[:8].strip()
    width, count = (16, 4) if "*" in first else (8, 8)
    padded = text.ljust(8 + width * count)
    return first, [padded[8 + width * i : 8 + width * (i + 1)].strip() for i in range(count)]
