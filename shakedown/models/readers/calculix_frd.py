"""CalculiX ``*NODE FILE`` and ``*NODE OUTPUT`` (``job.frd``, text and binary): displacements and reactions.

A binary block follows lines of text, which say that it is binary; no line ends it.
"""

import os
from typing import Final

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.ground.round_off import SIX_DIGITS
from shakedown.ground.tolerances import FIRST_DIGIT
from shakedown.models.readers.calculix_reactions import LETTERS, step_of
from shakedown.models.readers.nodal_vectors import NodalVectors, What
from shakedown.models.readers.text import integers, number, quoted, read_bytes, read_lines

_BLOCKS: dict[What, str] = {"displacements": "DISP", "reactions": "FORC"}
_NODE = {"0": slice(3, 8), "1": slice(3, 13)}  # columns of the node, by the format of a block
_BINARY = "2"  # the format of single precision
_SINGLE: Final = 2.0**-24 / FIRST_DIGIT  # its accuracy, as 1e-7 for seven digits: half of the last place
_WIDTH = 12  # characters per number; numbers are not separated
_BEGIN, _RESULTS = b"    1C", b"  100C"  # how a file begins, and results
_TIME, _COUNT, _FORMAT, _DERIVED = slice(12, 24), slice(24, 36), slice(73, 75), slice(33, 38)


def is_frd(lines: list[str]) -> bool:
    """Whether a file begins as a ``.frd`` file does."""
    return bool(lines) and lines[0].startswith(_BEGIN.decode())


def is_binary_frd(path: str | os.PathLike[str]) -> bool:
    """Whether a file is a ``.frd`` file with binary blocks."""
    raw = read_bytes(path)
    return raw.startswith(_BEGIN) and b"\0" in raw


def read_frd(path: str | os.PathLike[str], what: What = "displacements") -> list[NodalVectors]:
    """Read all blocks of displacements (DISP), or of reactions (FORC), in the order of the file.

    Numbers have six digits; those of a ``.dat`` file have seven.

    Raises
    ------
    ProblemError
        If there is no such block, or a line of one is malformed.
    """
    name = os.fspath(path)
    blocks: list[tuple[float, list[list[float]]]] = []
    time, layout, reading = 0.0, "1", False
    for k, line in enumerate(read_lines(path), start=1):
        where, mark = f"{name}: line {k}", line[:3]
        if line.startswith("  100C"):
            time, layout = number(line[_TIME].strip(), where), line[_FORMAT].strip()
        elif mark == " -4":
            reading = line[3:].split()[:1] == [_BLOCKS[what]]
            if reading:
                blocks.append((time, []))
        elif mark == " -3":
            reading = False
        elif reading and mark == " -1":
            blocks[-1][1].append(_row(line, layout, where))
    if not blocks:
        raise ProblemError(
            f"{name}: expected {what} (*NODE FILE, {LETTERS[what]}), found no block {_BLOCKS[what]}"
        )
    return [step_of(what, ("file",), time, rows, name, SIX_DIGITS) for time, rows in blocks]


def _row(line: str, layout: str, where: str) -> list[float]:
    """Node and three components, in fixed columns."""
    if layout not in _NODE:
        raise ProblemError(f"{where}: expected a block in text form, found the format {quoted(layout)}")
    place = _NODE[layout]
    fields = [line[place.stop + _WIDTH * k : place.stop + _WIDTH * (k + 1)] for k in range(3)]
    if not fields[-1].strip():
        raise ProblemError(f"{where}: expected a node with three numbers, found {quoted(line)}")
    return [*integers([line[place].strip()], where), *(number(field.strip(), where) for field in fields)]


def read_binary_frd(path: str | os.PathLike[str], what: What = "displacements") -> list[NodalVectors]:
    """The same of a file with binary blocks, of single precision; blocks of text may stand between them.

    Raises
    ------
    ProblemError
        If there is no such block, or one is malformed.
    """
    name, raw = os.fspath(path), read_bytes(path)
    found, place = [], raw.find(_RESULTS)
    while place >= 0:
        where = f"{name}: byte {place}"
        head, place = _line(raw, place)
        title, place = _line(raw, place)
        if title.split()[:2] == ["-4", _BLOCKS[what]]:
            time = number(head[_TIME].strip(), where)
            if head[_FORMAT].strip() == _BINARY:
                (count,) = integers([head[_COUNT].strip()], where)
                rows, digits = _records(raw, place, count, where), _SINGLE
            else:
                rows, digits = _text_rows(raw, place, head[_FORMAT].strip(), where), SIX_DIGITS
            found.append(step_of(what, ("file",), time, rows, name, digits))
        place = raw.find(_RESULTS, place)
    if not found:
        raise ProblemError(
            f"{name}: expected {what} (*NODE OUTPUT, {LETTERS[what]}), found no block {_BLOCKS[what]}"
        )
    return found


def _line(raw: bytes, place: int) -> tuple[str, int]:
    """The line that begins at a place, and where the next one begins."""
    end = raw.find(b"\n", place)
    end = len(raw) if end < 0 else end
    return raw[place:end].decode("latin-1"), end + 1


def _text_rows(raw: bytes, place: int, layout: str, where: str) -> list[list[float]]:
    """The nodes of a block of text."""
    end = raw.find(b"\n -3", place)
    if layout not in _NODE or end < 0:
        found = "no end" if layout in _NODE else f"the format {quoted(layout)}"
        raise ProblemError(
            f"{where}: expected a block of text that ends with -3 or one in single precision, found {found}"
        )
    lines = raw[place:end].decode("latin-1").split("\n")
    return [_row(line, layout, where) for line in lines if line.startswith(" -1")]


def _records(raw: bytes, place: int, count: int, where: str) -> list[list[float]]:
    """``count`` nodes with three components each; the lines before them say that there are three."""
    components = 0
    while raw.startswith(b" -5", place):
        line, place = _line(raw, place)
        components += line[_DERIVED].strip() in ("", "0")
    kind = np.dtype([("node", "<i4"), ("vector", "<f4", (components,))])
    end = place + count * kind.itemsize
    if components != 3 or count < 0 or raw[end : end + 1] != b" ":
        raise ProblemError(
            f"{where}: expected three components of {count} nodes in 16 bytes each and then a line of text, "
            f"found {components} components and {max(min(end, len(raw)) - place, 0)} bytes"
        )
    table = np.frombuffer(raw, kind, count, place)
    wrong = np.flatnonzero((table["node"] < 1) | ~np.isfinite(table["vector"]).all(axis=1))
    if wrong.size:
        node, vector = table[wrong[0]]
        raise ProblemError(
            f"{where}: expected nodes from 1 with finite numbers, found node {node} with {vector.tolist()}"
        )
    return np.column_stack([table["node"], table["vector"].astype(float)]).tolist()
