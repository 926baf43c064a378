"""Nastran DMIG punch files: small, large and free field.

The reader is the project's own: pyYeti's takes the last of two entries for one
place, reads a missing value as zero, and holds the matrix dense.
"""

import os
import re
from collections.abc import Iterator

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format, has
from shakedown.models.readers.nastran_bulk import cards, chosen_matrix, of_superelement
from shakedown.models.readers.stiffness import Stiffness, from_entries
from shakedown.models.readers.text import integers, listed, number, read_lines

_LINE = re.compile(r"DMIG\b", re.IGNORECASE)
_FORMS = (1, 6)  # square, symmetric
_REAL = (1, 2)


def read_nastran_dmig(
    path: str | os.PathLike[str], matrix: str | None = None, superelement: int | None = None
) -> Stiffness:
    """Read one matrix of a punch file.

    Parameters
    ----------
    path
        The file.
    matrix
        Its name, for instance ``KAAX``; by default the only one, or the only one
        whose name starts with K.
    superelement
        Which one of a file with several (``BEGIN SUPER n``).

    Raises
    ------
    ProblemError
        If there is no such matrix, it is complex or rectangular, or a card is malformed.
    """
    name = os.fspath(path)
    lines = of_superelement(read_lines(path), superelement, name)
    found = [(k, fields) for k, card, fields in cards(lines) if card == "DMIG"]
    known = sorted({fields[0] for _, fields in found})
    chosen = known[chosen_matrix(known, matrix, name)]
    own = [(k, fields) for k, fields in found if fields[0] == chosen]
    header = [(k, fields) for k, fields in own if fields[1] == "0"]
    if len(header) != 1:
        where = f" (lines {', '.join(str(k) for k, _ in header[:4])})" if header else ""
        raise ProblemError(
            f"{name}: expected one DMIG header card for {listed([chosen])}, found {len(header)}{where}"
        )
    shown = listed([chosen])
    form, kind = integers(header[0][1][2:4], f"{name}: line {header[0][0]}")
    if form not in _FORMS or kind not in _REAL:
        raise ProblemError(
            f"{name}: line {header[0][0]}: expected {shown} square or symmetric (form 1, 6) and real "
            f"(type 1, 2), found form {form}, type {kind}"
        )
    entries = list(_entries([card for card in own if card not in header], name))
    if not entries:
        raise ProblemError(f"{name}: expected entries of {shown}, found none")
    rows, columns, values = map(np.array, zip(*entries, strict=True))
    return from_entries(rows, columns, values, name, "Nastran DMIG")


def _entries(own: list[tuple[int, list[str]]], name: str) -> Iterator[tuple[list[int], list[int], float]]:
    """(node, direction) of the row and of the column, and the value, of all entries on cards of columns."""
    for k, fields in own:
        where = f"{name}: line {k}"
        column, entries = integers([fields[1], fields[2] or "0"], where), fields[4:]
        for group in range(0, len(entries), 4):
            node, direction, value = entries[group : group + 3]
            if node or value:
                yield integers([node, direction or "0"], where), column, number(value, where)


_TAKES = ("matrix", "superelement")
FORMATS = (Format("dmig", "Nastran DMIG", has(_LINE), {"stiffness": read_nastran_dmig}, _TAKES),)
