"""Nastran OUTPUT4 files in ASCII, with a map file: dense, sparse and BIGMAT columns."""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from shakedown.errors import ProblemError
from shakedown.readers.stiffness import Stiffness, with_map
from shakedown.readers.text import integers, numbers, read_lines

HEADER = re.compile(r"^([ \d-]{8})([ \d-]{8})([ \d-]{8})([ \d-]{8})([A-Za-z]\S{0,7}) *(.*)$")


def read_nastran_op4(
    path: str | os.PathLike[str], dofs: NDArray[np.intp] | None = None, matrix: str | None = None
) -> Stiffness:
    """Read one real matrix of an ASCII OUTPUT4 file.

    Parameters
    ----------
    path
        The file.
    dofs : (N, 2)
        The map: the order of the analysis set is not in the file.
    matrix
        Its name; by default the only one in the file.

    Raises
    ------
    ProblemError
        If there is no such matrix, it is complex, the file ends early or a line is malformed.
    """
    name = os.fspath(path)
    text = _Cursor(read_lines(path), name)
    found: dict[str, sparse.coo_array] = {}
    while text.more():
        head = _head(text)
        found[head.name] = _matrix(text, head)
    if matrix is None and len(found) != 1:
        raise ProblemError(f"{name}: expected one matrix, found {', '.join(found)}; name the one to take")
    chosen = next(iter(found)) if matrix is None else matrix
    if chosen not in found:
        raise ProblemError(f"{name}: expected the matrix {chosen}, found {', '.join(found)}")
    return with_map(found[chosen], dofs, name, "Nastran OUTPUT4")


@dataclass(frozen=True)
class _Head:
    name: str
    rows: int
    columns: int
    bigmat: bool
    words: int  # Fortran words per number, which the lengths of sparse strings count
    width: int  # characters per number


@dataclass
class _Cursor:
    """The lines of the file and the next one to read."""

    lines: list[str]
    name: str
    k: int = 0

    @property
    def where(self) -> str:
        return f"{self.name}: line {self.k + 1}"

    def more(self) -> bool:
        while self.k < len(self.lines) and not self.lines[self.k].strip():
            self.k += 1
        return self.k < len(self.lines)

    def line(self) -> str:
        if self.k >= len(self.lines):
            raise ProblemError(f"{self.name}: expected more columns, found the end of the file")
        self.k += 1
        return self.lines[self.k - 1]

    def record(self, count: int) -> list[int]:
        """Integers in fields of eight characters."""
        where, line = self.where, self.line().ljust(8 * count)
        return integers([line[8 * i : 8 * (i + 1)] for i in range(count)], where)

    def run(self, count: int, width: int) -> list[float]:
        """Numbers of fixed width, which may touch."""
        values: list[float] = []
        while len(values) < count:
            where, line = self.where, self.line().rstrip()
            fields = [line[i : i + width] for i in range(0, len(line), width)]
            values += numbers([field for field in fields if field.strip()], where)
            if len(values) > count:
                raise ProblemError(f"{where}: expected {count} numbers in this run, found {len(values)}")
        return values


def _head(text: _Cursor) -> _Head:
    where, line = text.where, text.line()
    match = HEADER.match(line)
    if match is None:
        raise ProblemError(f"{where}: expected an OUTPUT4 header, found '{line.strip()[:60]}'")
    columns, rows, _, kind = integers(match.groups()[:4], where)
    if kind not in (1, 2):
        raise ProblemError(f"{where}: expected a real matrix (type 1 or 2), found type {kind}")
    layout = re.search(r"[EDG](\d+)\.", match[6].upper())
    return _Head(match[5], abs(rows), columns, rows < 0, kind, int(layout[1]) if layout else 16)


def _matrix(text: _Cursor, head: _Head) -> sparse.coo_array:
    """Columns up to the closing dummy column."""
    i: list[int] = []
    j: list[int] = []
    data: list[float] = []
    while True:
        where = text.where
        column, start, length = text.record(3)
        if column > head.columns:
            text.run(1, head.width)
            return sparse.coo_array((data, (i, j)), shape=(head.rows, head.columns), dtype=float)
        runs = [(start, text.run(length, head.width))] if start > 0 else _strings(text, head, length)
        for row, values in runs:
            if column < 1 or row < 1 or row - 1 + len(values) > head.rows:
                raise ProblemError(
                    f"{where}: expected rows 1 to {head.rows}, found {len(values)} numbers from row {row} on"
                )
            i += range(row - 1, row - 1 + len(values))
            j += [column - 1] * len(values)
            data += values


def _strings(text: _Cursor, head: _Head, length: int) -> Iterator[tuple[int, list[float]]]:
    """First row and numbers of each string of a sparse column of ``length`` words, headers included."""
    while length > 0:
        where = text.where
        if head.bigmat:
            long, row = text.record(2)
            length -= long + 1
        else:
            long, row = divmod(int(integers([text.line()], where)[0]), 65536)
            length -= long
        if long < 1:
            raise ProblemError(f"{where}: expected the header of a string, found length {long}")
        yield row, text.run((long - 1) // head.words, head.width)
