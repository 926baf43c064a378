"""Text files line by line, numbers and tables of numbers in them; limits on their size."""

import hashlib
import math
import os
import re
import struct
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from io import BufferedReader
from pathlib import Path
from typing import TypeVar

import numpy as np

from shakedown.ground.constants import LARGEST_LABEL, FloatArray, IntArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.regular_file import open_regular
from shakedown.ground.shown_values import LONGEST_VALUE

LARGEST_WHOLE = 2.0**53  # of whole numbers that are read as real ones
_FORTRAN = re.compile(r"([-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+))(?:[DdEe]([-+]?[0-9]{1,6})|([-+][0-9]{1,6}))\Z")
_PLAIN = frozenset("0123456789+-.eE")
REAL = r"[-+]?(\d+\.?\d*|\.\d+)([EeDd][-+]?\d+)?"  # in regular expressions
# What libraries raise on a damaged file; anything else is an error of the program.
UNREADABLE = (
    *(ValueError, TypeError, LookupError, ArithmeticError, struct.error),
    *(RuntimeError, MemoryError, EOFError, Warning),
)


def quoted(text: str) -> str:
    """The beginning of a text as a message shows it: one line, no control characters.

    Examples
    --------
    >>> quoted("a\\tb"), len(quoted("x" * 100))
    ("'a\\\\tb'", 59)
    """
    shown = text.strip()[:LONGEST_VALUE]
    printable = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in shown)
    return f"'{printable[:LONGEST_VALUE]}{'…' if len(text.strip()) > LONGEST_VALUE else ''}'"


def unfit(where: object, expected: str, found: object) -> ProblemError:
    """The refusal of data, in one line: where, what was expected, and what was found.

    Examples
    --------
    >>> str(unfit("k.mtx: line 3", "a number", "'x'"))
    "k.mtx: line 3: expected a number, found 'x'"
    """
    return ProblemError(f"{where}: expected {expected}, found {found}")


def listed(names: Iterable[str]) -> str:
    """Names as a message lists them: the first dozen, shortened; "none" where there are none.

    Examples
    --------
    >>> listed(["KAAX", "MAAX"]), listed([])
    ('KAAX, MAAX', 'none')
    """
    shown = [quoted(name)[1:-1] for name in names]
    return ", ".join(shown[:12]) + (", …" if len(shown) > 12 else "") or "none"


def open_input(path: str | os.PathLike[str]) -> BufferedReader:
    """A file, open for reading bytes from its beginning to its end.

    Raises
    ------
    ProblemError
        If there is none, it is not a regular file (a folder, a pipe, a device), cannot be read, or is larger
        than 4 GiB.
    """
    with found_in(path):
        file = open_regular(path)
        size = os.fstat(file.fileno()).st_size
        if size > (most := 4 << 30):
            file.close()
            raise ProblemError(f"expected at most {most >> 30} GiB, found {size} bytes")
    return file


def read_bytes(path: str | os.PathLike[str], most: int = -1) -> bytes:
    """The content of a file, or its first bytes; see :func:`open_input`."""
    with open_input(path) as file:
        try:
            return file.read(most)
        except OSError as error:
            raise ProblemError(f"{os.fspath(path)}: cannot be read ({error.strerror})") from None


def read_lines(path: str | os.PathLike[str]) -> list[str]:
    """The lines of a text file.

    Raises
    ------
    ProblemError
        If the file is missing, not a regular file, unreadable, empty or binary.
    """
    name = os.fspath(path)
    raw = read_bytes(path)
    if b"\0" in raw[:65536]:
        raise ProblemError(
            f"{name}: expected a text file, found a binary one (of the binary formats, Nastran OUTPUT4 can "
            "be read; Abaqus: *MATRIX OUTPUT, FORMAT=MATRIX INPUT; Ansys: *EXPORT with MMF; CalculiX: *NODE "
            "FILE)"
        )
    text = raw.decode("utf-8-sig", errors="replace")
    if not text.strip():
        raise unfit(name, "a text with numbers", "an empty file")
    return text.splitlines()


def numbers(fields: Iterable[str], where: str) -> list[float]:
    """Real numbers in any of the spellings of Fortran codes: 1.0E+2, 1.0D+2, -.5, 1.0+2.

    Raises
    ------
    ProblemError
        If a field is not a finite number.

    Examples
    --------
    >>> numbers(["1.0D+02", "-.5", "2.5+10"], "line 1")
    [100.0, -0.5, 25000000000.0]
    """
    return [number(field, where) for field in fields]


def rows_of_numbers(
    lines: Iterable[tuple[int, str]], width: int, name: str, expected: str
) -> tuple[list[int], FloatArray]:
    """Numbers in any of these spellings, so many in every line, (k, width), of large files; and their lines.

    Commas between them are blanks, blank lines are passed over.

    Raises
    ------
    ProblemError
        If a line of ``name`` has more or fewer of them than ``expected``, or one is not a finite number.

    Examples
    --------
    >>> rows_of_numbers([(1, "1 1 2.0D+02"), (2, "2, 1, -.5")], 3, "a file", "three numbers")[1].tolist()
    [[1.0, 1.0, 200.0], [2.0, 1.0, -0.5]]
    """
    every = [(k, text.replace(",", " ")) for k, text in lines if text.strip()]
    places = [k for k, _ in every]
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # of no lines
            found = np.loadtxt([text for _, text in every], comments=None, ndmin=2)
        if found.shape[1] == width and np.isfinite(found).all():
            return places, found
    except (ValueError, Warning):
        pass
    rows = []
    for k, text in every:
        fields = text.split()
        if len(fields) != width:
            raise unfit(f"{name}: line {k}", expected, quoted(text))
        rows.append(numbers(fields, f"{name}: line {k}"))
    return places, np.array(rows).reshape(-1, width)


def whole_numbers(table: FloatArray, places: Sequence[int], name: str, which: str = "") -> IntArray:
    """Columns of whole numbers; ``ProblemError`` names the line (``places``) of the first that is none."""
    wrong = (table != np.round(table)) | (np.abs(table) >= LARGEST_WHOLE)
    if wrong.any():
        k = int(np.argmax(wrong.any(axis=1)))
        raise unfit(f"{name}: line {places[k]}", f"a whole number{which}", f"{table[k][wrong[k]][0]:g}")
    return table.astype(np.intp)


def number(field: str, where: str) -> float:
    """One real number; see :func:`numbers`."""
    text = field.strip()
    try:
        value = float(text) if _PLAIN.issuperset(text) else None
    except ValueError:
        value = None
    if value is None:
        match = _FORTRAN.match(text)
        if match is None:
            raise unfit(where, "a number", quoted(field))
        value = float(f"{match[1]}E{match[2] or match[3]}")
    if not math.isfinite(value):
        raise unfit(where, "a finite number", quoted(field))
    return value


def integers(fields: Iterable[str], where: str) -> list[int]:
    """Whole numbers.

    Raises
    ------
    ProblemError
        If a field is not a whole number.

    Examples
    --------
    >>> integers([" 12", "-3"], "line 1")
    [12, -3]
    """
    found = [field.strip() for field in fields]
    for text in found:
        if not re.fullmatch(r"[-+]?[0-9]{1,18}", text):
            raise unfit(where, "a whole number", quoted(text))
    return list(map(int, found))


def whole_number(field: str, where: str) -> int:
    """A whole number, which may be written as a real one: 7.0E+00.

    Raises
    ------
    ProblemError
        If it is none.

    Examples
    --------
    >>> whole_number("7", "line 1"), whole_number("1.2e+01", "line 1")
    (7, 12)
    """
    text = field.strip()
    if "." in text and re.fullmatch(REAL, text):
        value = number(text, where)
        text = str(int(value)) if value.is_integer() and abs(value) < LARGEST_LABEL else text
    return integers([text], where)[0]


Result = TypeVar("Result")


@dataclass
class InputFiles:
    """Paths relative to the folder of the configuration.

    Attributes
    ----------
    folder : Path
        Where the configuration stands.
    sources : dict
        SHA-256 of every file that was read, by the name that the configuration gives it.
    """

    folder: Path
    sources: dict[str, str] = field(default_factory=dict)

    def path(self, name: str) -> Path:
        """The path of a file that the configuration names."""
        return self.folder / name

    def read(self, name: str, reader: Callable[[Path], Result], key: str) -> Result:
        """What a reader returns for a file that the configuration names, at a key that messages name.

        A file outside the folder may be read like any other, but no message
        repeats anything of its content.

        Raises
        ------
        ProblemError
            As the reader raises it.
        """
        path = self.path(name)
        with found_in(key):
            open_input(path).close()
        try:
            found = reader(path)
        except ProblemError as error:
            if self._inside(path):
                raise
            message = str(error).partition(", found ")[0]
            raise ProblemError(
                f"{message} (what was found is not shown: the file lies outside the folder)"
            ) from None
        if name not in self.sources:
            self.sources[name] = sha256(path)
        return found

    def _inside(self, path: Path) -> bool:
        try:
            return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(self.folder))
        except (OSError, ValueError):  # a name that no file can have
            return True

    def same(self, first: str, second: str) -> bool:
        """Whether two names lead to one file."""
        try:
            return os.path.samefile(self.path(first), self.path(second))
        except (OSError, ValueError):
            return False


def sha256(path: str | os.PathLike[str]) -> str:
    """SHA-256 of a regular file, in hexadecimal digits."""
    with open_input(path) as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


@dataclass(frozen=True, eq=False)
class NumberTable:
    """Rows of numbers.

    Attributes
    ----------
    name : str
        The file, for messages.
    columns : tuple of str
        Headings, empty where the file has none.
    lines : tuple of int
        Line of the file of every row.
    values : (k, c)
        The numbers.
    """

    name: str
    columns: tuple[str, ...]
    lines: tuple[int, ...]
    values: FloatArray

    def column(self, key: str | int) -> FloatArray:
        """One column, by its heading or its number from 1.

        Raises
        ------
        ProblemError
            If there is none, or the heading occurs twice.
        """
        width = self.values.shape[1]
        if isinstance(key, int):
            if not 1 <= key <= width:
                raise unfit(self.name, f"a column from 1 to {width}", key)
            return self.values[:, key - 1]
        places = [k for k, own in enumerate(self.columns) if own.casefold() == key.strip().casefold()]
        if len(places) != 1:
            raise ProblemError(
                f"{self.name}: expected one column {quoted(key)}, found {len(places)} of that name; columns "
                f"are {listed(self.columns)}"
            )
        return self.values[:, places[0]]

    def whole(self, key: str | int) -> list[int]:
        """A column of whole numbers."""
        which = f" in column {quoted(str(key))}"
        return whole_numbers(self.column(key)[:, None], self.lines, self.name, which).ravel().tolist()


def read_table(path: str | os.PathLike[str]) -> NumberTable:
    """Read a table of numbers; see :func:`number_table`."""
    return number_table(read_lines(path), os.fspath(path))


def number_table(lines: Sequence[str], name: str, *, marks: Sequence[str] = "\t;, ") -> NumberTable:
    """A table of numbers from its lines; ``name`` is the file, for messages.

    The delimiter is the first of some marks (a tab, a semicolon, a comma, blanks) that splits all
    rows into the same number of numbers. Between tabs, semicolons and blanks a
    comma is a decimal comma.
    Blank lines and lines that start with ``#``, ``%``, ``!``, ``$``, ``**`` or
    ``//`` are skipped; the first other line is a header if it holds a word.

    Raises
    ------
    ProblemError
        If there is no row, or no delimiter makes a table of the lines; the
        message says where the most promising one fails.

    Examples
    --------
    >>> table = number_table(["time;factor", "0,0;1,5", "0,5;-2,0"], "a file")
    >>> table.columns, table.column("factor").tolist()
    (('time', 'factor'), [1.5, -2.0])
    """
    stripped = enumerate(map(str.strip, lines), start=1)
    remarks = ("#", "%", "!", "$", "**", "//")
    rows = [(k, text) for k, text in stripped if text and not text.startswith(remarks)]
    if not rows:
        raise unfit(name, "rows of numbers", "none")
    failures = []
    for mark in marks:
        if mark != " " and not any(mark in text for _, text in rows):
            continue
        try:
            found = _split(rows, name, mark)
        except ProblemError as error:
            failures.append(error)
            continue
        if not failures or found.values.shape[1] > 1:  # one column where a comma failed: a damaged row
            return found
    raise failures[0] from None


def _split(rows: list[tuple[int, str]], name: str, mark: str) -> NumberTable:
    header: tuple[str, ...] = ()
    (_, first), split = rows[0], None if mark == " " else mark
    fields = [field.strip().strip('"') for field in first.split(split)]
    if not all(re.match(r"[-+]?[.,]?\d", field) for field in fields if field):  # as numbers begin
        header, rows = tuple(field for field in fields if field), rows[1:]
    if not rows:
        raise unfit(name, "rows of numbers below the header", "none")
    values = []
    for k, text in rows:
        fields = text.rstrip("\t;, " if split else None).split(split)
        where = f"{name}: line {k}"
        values.append([number(field if mark == "," else field.replace(",", "."), where) for field in fields])
        if len(fields) != len(values[0]) or (header and len(fields) != len(header)):
            expected = len(header) if header else len(values[0])
            raise unfit(where, f"{expected} columns", len(fields))
    return NumberTable(name, header, tuple(k for k, _ in rows), np.array(values))
