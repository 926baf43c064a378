"""Text files, read whole, with errors that say where."""

import os
import re
from collections.abc import Iterable
from pathlib import Path

from shakedown.errors import ProblemError


def read_lines(path: str | os.PathLike[str]) -> list[str]:
    """The lines of a text file.

    Raises
    ------
    ProblemError
        If the file is missing, unreadable, empty or binary.
    """
    name = os.fspath(path)
    try:
        raw = Path(path).read_bytes()
    except FileNotFoundError:
        raise ProblemError(f"{name}: no such file") from None
    except OSError as error:
        raise ProblemError(f"{name}: cannot be read ({error.strerror})") from None
    if b"\0" in raw[:65536]:
        raise ProblemError(
            f"{name}: expected a text file, found a binary one (write the matrix as text: Abaqus *MATRIX "
            "OUTPUT, FORMAT=MATRIX INPUT; Nastran OP4 formatted; Ansys *EXPORT with MMF)"
        )
    if not raw.strip():
        raise ProblemError(f"{name}: expected a stiffness matrix or reactions, found an empty file")
    return raw.decode("utf-8", errors="replace").splitlines()


def numbers(fields: Iterable[str], where: str) -> list[float]:
    """Real numbers in any of the spellings of Fortran codes: 1.0E+2, 1.0D+2, -.5, 1.0+2.

    Raises
    ------
    ProblemError
        If a field is not a number.

    Examples
    --------
    >>> numbers(["1.0D+02", "-.5", "2.5+10"], "line 1")
    [100.0, -0.5, 25000000000.0]
    """
    return [number(field, where) for field in fields]


def number(field: str, where: str) -> float:
    """One real number; see :func:`numbers`."""
    text = field.strip().upper().replace("D", "E")
    try:
        return float(text)
    except ValueError:
        pass
    for k in range(1, len(text)):
        if text[k] in "+-" and text[k - 1] not in "E+-":
            try:
                return float(f"{text[:k]}E{text[k:]}")
            except ValueError:
                break
    raise ProblemError(f"{where}: expected a number, found '{field.strip()}'")


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
    found = []
    for field in fields:
        text = field.strip()
        if not re.fullmatch(r"[-+]?[0-9]{1,18}", text):
            raise ProblemError(f"{where}: expected a whole number, found '{text[:60]}'")
        found.append(int(text))
    return found
