"""Nastran OUTPUT4 files, text and binary, read by pyYeti once their structure has been checked.

pyYeti reads every variant, but trusts what the file says about itself: a
damaged length can make it walk in circles, allocate what a header claims, or
put numbers into the wrong rows. So every record is followed here first.
"""

import os
import re
import struct
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import TIMES_A_FILE
from shakedown.models.readers.nastran_bulk import UNREADABLE, pyyeti_module
from shakedown.models.readers.row_map import Rows, row_map
from shakedown.models.readers.stiffness import Stiffness, checked
from shakedown.models.readers.text import integers, listed, quoted, read_bytes, read_lines

HEADER = re.compile(
    r"^([ \d-]{8}|[ \d-]{16})([ \d-]{8}|[ \d-]{16})([ \d]{8})([ \d]{8})([A-Za-z]\S{0,7}) *(\S*)$"
)
_FORMAT = re.compile(r"(?:1P,)?(\d{1,3})[ED](\d{1,3})\.\d+(?:E\d+)?(?:\|I16)?$", re.IGNORECASE)
_HEADS = {24: 4, 48: 8}  # bytes of a binary header record: width of its integers
_BIGMAT = 65536  # matrices of so many rows are stored as BIGMAT even where the header does not say so


@dataclass(frozen=True)
class Heading:
    """What the header of one matrix says, and which of the matrices of its name it is, from 1."""

    name: str
    rows: int
    columns: int
    form: int
    type: int
    place: int = 1


def is_op4(raw: bytes) -> bool:
    """Whether a file begins as OUTPUT4 files do, binary or text."""
    sizes = {int.from_bytes(raw[:4], order) for order in ("little", "big")} if len(raw) >= 32 else set()
    if b"\0" in raw[:4]:
        return bool(sizes & set(_HEADS))
    return HEADER.match(raw[:256].decode("ascii", "replace").split("\n")[0].rstrip("\r")) is not None


def op4_headings(path: str | os.PathLike[str]) -> list[Heading]:
    """The headings of all matrices of an OUTPUT4 file, whose records are all checked to be whole.

    Raises
    ------
    ProblemError
        If a record is cut off, or the length of one or the number of a row is wrong.
    """
    raw, name = read_bytes(path), os.fspath(path)
    if not is_op4(raw):
        raise ProblemError(f"{name}: expected an OUTPUT4 file, found no header of one")
    walk = _binary(raw, name) if b"\0" in raw[:4] else _text(read_lines(path), name)
    found: list[Heading] = []
    seen: Counter[str] = Counter()
    for heading in walk:
        seen[heading.name.lower()] += 1
        found.append(replace(heading, place=seen[heading.name.lower()]))
    return found


def read_nastran_op4(path: str | os.PathLike[str], rows: Rows = None, matrix: str | None = None) -> Stiffness:
    """Read one real square matrix of an OUTPUT4 file.

    Parameters
    ----------
    path
        The file.
    rows
        The map: the order of the analysis set is not in the file, but on the
        EXTRN or ASET cards of the punch file beside it.
    matrix
        Its name; by default the only one larger than 1 × 1 whose name begins
        with K, or the only one at all. ``"KXX(2)"`` is the second of a name that
        occurs several times, as of several superelements.

    Raises
    ------
    ProblemError
        If there is no such matrix, it is complex or not square, pyYeti is not
        installed, or a record is damaged.
    """
    name, found = os.fspath(path), op4_headings(path)
    chosen = _chosen(found, matrix, name)
    if chosen.rows != chosen.columns:
        raise ProblemError(
            f"{name}: expected {chosen.name} to be square, found {chosen.rows} x {chosen.columns}"
        )
    table = row_map(rows, chosen.rows, name, "Nastran OUTPUT4")
    return checked(sparse.csr_array(_loaded(path, chosen, name)), table, "Nastran OUTPUT4")


def read_op4_columns(path: str | os.PathLike[str], matrix: str) -> FloatArray:
    """One real matrix of an OUTPUT4 file as a dense array, for load vectors; see :func:`read_nastran_op4`."""
    name = os.fspath(path)
    loaded = _loaded(path, _chosen(op4_headings(path), matrix, name), name)
    if not isinstance(loaded, np.ndarray):
        raise ProblemError(
            f"{name}: expected at most {TIMES_A_FILE} times the size of the file in loads, found a header "
            f"that claims {loaded.shape[0]} x {loaded.shape[1]}"
        )
    return loaded


def _chosen(found: list[Heading], matrix: str | None, name: str) -> Heading:
    if matrix is None:
        stiff = [h for h in found if h.name.upper().startswith("K") and (h.rows, h.columns) != (1, 1)]
        candidates = found if len(found) == 1 else stiff
    else:
        candidates = _of_name(found, matrix, name)
    if len({heading.name.lower() for heading in candidates}) < len(candidates):
        (repeated, count), *_ = Counter(heading.name for heading in candidates).most_common(1)
        ways = " or ".join(f"'{repeated}({k})'" for k in range(1, min(count, 3) + 1))
        raise ProblemError(
            f"{name}: expected every matrix once, found {repeated} {count} times (several superelements?); "
            f"name the one to take: matrix = {ways}"
        )
    if len(candidates) != 1:
        what = "one stiffness matrix" if matrix is None else f"the matrix {quoted(matrix)}"
        raise ProblemError(
            f"{name}: expected {what}, found {listed(h.name for h in found)}; name the one to take"
        )
    chosen = candidates[0]
    if chosen.type not in (1, 2):
        raise ProblemError(
            f"{name}: expected {chosen.name} to be real (type 1 or 2), found type {chosen.type}"
        )
    return chosen


def _of_name(found: list[Heading], matrix: str, name: str) -> list[Heading]:
    """The matrices of a name, or the k-th of them where the name ends in (k)."""
    wanted = matrix.strip().lower()
    counted = re.fullmatch(r"(.+)\((\d{1,9})\)", wanted)
    same = [heading for heading in found if heading.name.lower() == (counted[1] if counted else wanted)]
    if counted is None or not same:
        return same
    place = int(counted[2])
    if not 1 <= place <= len(same):
        raise ProblemError(
            f"{name}: expected {same[0].name}(1) to {same[0].name}({len(same)}), found {quoted(matrix)}"
        )
    return [same[place - 1]]


def _loaded(path: str | os.PathLike[str], chosen: Heading, name: str) -> FloatArray | sparse.coo_array:
    """The numbers, by pyYeti; sparse where the header claims far more than the file holds."""
    op4 = pyyeti_module("op4", name)
    large = 8 * chosen.rows * chosen.columns > TIMES_A_FILE * max(os.stat(path).st_size, 1 << 16)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            reader = op4.OP4()
            try:
                _, same, _, _ = reader.load(
                    os.fspath(path), namelist=[chosen.name.lower()], into="list", sparse=large
                )
                values = same[chosen.place - 1]
            finally:
                reader._op4close()
    except UNREADABLE as error:
        raise ProblemError(f"{name}: expected {chosen.name} whole, found {quoted(str(error))}") from None
    if values.shape != (chosen.rows, chosen.columns):
        raise ProblemError(
            f"{name}: expected {chosen.name} of {chosen.rows} rows, found shape {values.shape}"
        )
    data = values.data if sparse.issparse(values) else values
    if not np.isfinite(data).all():
        raise ProblemError(
            f"{name}: expected finite numbers in {chosen.name}, found {data[~np.isfinite(data)][0]}"
        )
    if large:
        return sparse.coo_array(values)
    return np.asarray(values, dtype=float)


def _heading(name: str, rows: int, columns: int, form: int, kind: int, where: str) -> Heading:
    if not re.fullmatch(r"[A-Za-z_]\w{0,7}", name, re.ASCII):
        raise ProblemError(f"{where}: expected the name of a matrix, found {quoted(name)}")
    if not (1 <= abs(rows) < 2**31 and 1 <= columns < 2**31 and kind in (1, 2, 3, 4)):
        raise ProblemError(
            f"{where}: expected the size and type of a matrix, found {rows} x {columns}, type {kind}"
        )
    return Heading(name, abs(rows), columns, form, kind)


def _words(kind: int, wide: bool) -> int:
    """Words per number, as lengths count them: one, two in double precision, twice that if complex."""
    return (1 if kind in (1, 3) or wide else 2) * (1 if kind < 3 else 2)


def _check_run(heading: Heading, row: int, length: int, words: int, where: str) -> None:
    if length < 0 or length % words or row < 1 or row - 1 + length // words > heading.rows:
        raise ProblemError(
            f"{where}: expected rows 1 to {heading.rows} of {heading.name}, found {length} words "
            f"from row {row} on"
        )


class _Records:
    """Fortran records of a binary file: a length, the content, the length again."""

    def __init__(self, raw: bytes, name: str) -> None:
        self.raw, self.name, self.at = raw, name, 0
        self.order = "<" if int.from_bytes(raw[:4], "little") in _HEADS else ">"
        self.width = _HEADS[struct.unpack_from(f"{self.order}i", raw)[0]]
        self.integer = "i" if self.width == 4 else "q"

    def next(self) -> tuple[int, int]:
        """Where the content of the next record begins, and its length."""
        start, most = self.at + 4, len(self.raw)
        length = struct.unpack_from(f"{self.order}i", self.raw, self.at)[0] if start <= most else -1
        end = start + length
        if length < 3 * self.width or end + 4 > most:
            raise ProblemError(
                f"{self.name}: byte {self.at}: expected a whole record, found it cut off or damaged"
            )
        if struct.unpack_from(f"{self.order}i", self.raw, end)[0] != length:
            again = struct.unpack_from(f"{self.order}i", self.raw, end)[0]
            raise ProblemError(f"{self.name}: byte {end}: expected the length {length} again, found {again}")
        self.at = end + 4
        return start, length

    def integers(self, at: int, count: int) -> tuple[int, ...]:
        return struct.unpack_from(f"{self.order}{count}{self.integer}", self.raw, at)


def _binary(raw: bytes, name: str) -> Iterator[Heading]:
    records = _Records(raw, name)
    while records.at < len(raw):
        at, length = records.next()
        where = f"{name}: byte {at}"
        if length != 6 * records.width:
            raise ProblemError(f"{where}: expected the header of a matrix, found a record of {length} bytes")
        columns, rows, form, kind = records.integers(at, 4)
        text = raw[at + 4 * records.width : at + 6 * records.width].decode("ascii", "replace")
        heading = _heading(text.replace("\0", " ").replace(" ", ""), rows, columns, form, kind, where)
        yield heading
        big = rows < 0 or rows >= _BIGMAT
        previous = 0
        while previous <= columns:
            at, length = records.next()
            column, row, words = records.integers(at, 3)
            if not previous < column <= columns + 1:
                raise ProblemError(
                    f"{name}: byte {at}: expected a column up to {columns + 1}, found {column}"
                )
            previous = column
            if column <= columns:
                if length != (3 + words) * records.width:
                    raise ProblemError(f"{name}: byte {at}: expected {words} words, found {length} bytes")
                _check_column(records, heading, at, row, words, big)


def _check_column(records: _Records, heading: Heading, at: int, row: int, words: int, big: bool) -> None:
    """Check the runs of numbers of one binary column."""
    each, where = _words(heading.type, records.width == 8), f"{records.name}: byte {at}"
    if row > 0:
        _check_run(heading, row, words, each, where)
        return
    at, left = at + 3 * records.width, words
    while left > 0:
        if big:
            long, row = records.integers(at, 2) if left > 1 else (0, 0)
            used, long, skip = long + 1, long - 1, 2
        else:
            code = records.integers(at, 1)[0]
            long, row, skip = (code >> 16) - 1, code & 0xFFFF, 1
            used = long + 1
        if long < 1 or used > left:
            raise ProblemError(f"{where}: expected the header of a string, found length {long}")
        _check_run(heading, row, long, each, where)
        left -= used
        at += (skip + long) * records.width


class _Lines:
    """The lines of a text file and the next one to read."""

    def __init__(self, lines: list[str], name: str) -> None:
        self.lines, self.name, self.at = lines, name, 0

    @property
    def where(self) -> str:
        return f"{self.name}: line {self.at + 1}"

    def next(self, count: int = 1) -> str:
        """Pass over lines and return the first of them."""
        if self.at + count > len(self.lines):
            raise ProblemError(f"{self.where}: expected {count} more lines, found the end of the file")
        self.at += count
        return self.lines[self.at - count]

    def numbers(self, count: int, per_line: int, width: int) -> None:
        """Pass over a run of numbers in fields of fixed width."""
        where = self.where
        lines = -(-count // per_line)
        first = self.at
        self.next(lines)
        for k in range(lines):
            here = per_line if k < lines - 1 else count - per_line * (lines - 1)
            text = self.lines[first + k].rstrip()
            if not width * (here - 1) < len(text) <= width * here or re.search(r"[^0-9EeDd.+\- ]", text):
                raise ProblemError(f"{where}: expected {here} numbers of width {width}, found {quoted(text)}")


def _text(lines: list[str], name: str) -> Iterator[Heading]:
    text = _Lines(lines, name)
    while text.at < len(lines) and lines[text.at].strip():
        where, line = text.where, text.next().rstrip()
        match = HEADER.match(line)
        layout = _FORMAT.match(match[6] or "1P,5E16.9") if match else None
        if match is None or layout is None:
            raise ProblemError(f"{where}: expected an OUTPUT4 header, found {quoted(line)}")
        per_line, width = int(layout[1]), int(layout[2])
        if not 1 <= per_line <= 132 or not 6 <= width <= 132:
            raise ProblemError(f"{where}: expected a Fortran format like 1P,5E16.9, found {quoted(match[6])}")
        columns, rows, form, kind = integers(match.groups()[:4], where)
        heading = _heading(match[5], rows, columns, form, kind, where)
        yield heading
        previous = 0
        while True:  # ends: every round reads a line
            where, head = text.where, text.next().ljust(24)
            column, row, words = integers([head[:8], head[8:16], head[16:24]], where)
            if not previous < column <= columns + 1:
                raise ProblemError(f"{where}: expected a column up to {columns + 1}, found {column}")
            previous = column
            if column > columns:
                text.next()
                break
            _check_text_column(text, heading, row, words, rows < 0 or rows >= _BIGMAT, (per_line, width))


def _check_text_column(
    text: _Lines, heading: Heading, row: int, words: int, big: bool, layout: tuple[int, int]
) -> None:
    """Check the runs of numbers of one column in text; a dense one counts numbers, a sparse one words."""
    each, parts = _words(heading.type, False), 1 if heading.type < 3 else 2
    if row > 0:
        _check_run(heading, row, words, parts, text.where)
        text.numbers(words, *layout)
        return
    while words > 0:
        where, line = text.where, text.next()
        if big:
            long, row = integers([line[:8], line[8:16]], where)
            used, long = long + 1, long - 1
        else:
            code = integers([line], where)[0]
            long, row = (code >> 16) - 1, code & 0xFFFF
            used = long + 1
        if long < 1 or used > words:
            raise ProblemError(f"{where}: expected the header of a string, found length {long}")
        _check_run(heading, row, long, each, where)
        text.numbers(long // (each // parts), *layout)
        words -= used
