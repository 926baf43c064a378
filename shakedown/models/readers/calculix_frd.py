"""CalculiX ``*NODE FILE`` and ``*NODE OUTPUT`` (``job.frd``, text and binary): displacements and reactions.

A binary block follows lines of text, which say that it is binary; no line ends it.
"""

import os

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.models.readers.calculix_reactions import LETTERS, step_of
from shakedown.models.readers.formats import Format, begins
from shakedown.models.readers.nodal_vectors import NodalVectors, What
from shakedown.models.readers.text import integers, number, numbers, quoted, read_bytes

_BLOCKS: dict[What, str] = {"displacements": "DISP", "reactions": "FORC"}
_NODE = {"0": slice(3, 8), "1": slice(3, 13)}  # columns of the node, by the format of a block
_BINARY = "2"  # the format of single precision
_WIDTH = 12  # characters per number; numbers are not separated
_BEGIN, _RESULTS = "    1C", b"  100C"  # how a file begins, and results
_TIME, _COUNT, _FORMAT, _DERIVED = slice(12, 24), slice(24, 36), slice(73, 75), slice(33, 38)


def read_frd(path: str | os.PathLike[str], what: What = "displacements") -> list[NodalVectors]:
    """Read all blocks of displacements (DISP), or of reactions (FORC), in the order of the file.

    Blocks of text have six digits, binary ones single precision.

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
            time, layout = number(head[_TIME].strip(), where), head[_FORMAT].strip()
            if layout == _BINARY:
                (count,) = integers([head[_COUNT].strip()], where)
                rows = _records(raw, place, count, where)
            else:
                rows = _text_rows(raw, place, layout, where)
            found.append(step_of(what, ("file",), time, rows, name))
        place = raw.find(_RESULTS, place)
    if not found:
        raise ProblemError(
            f"{name}: expected {what} (*NODE FILE, {LETTERS[what]}), found no block {_BLOCKS[what]}"
        )
    return found


def _line(raw: bytes, place: int) -> tuple[str, int]:
    """The line that begins at a place, and where the next one begins."""
    end = raw.find(b"\n", place)
    end = len(raw) if end < 0 else end
    return raw[place:end].decode("latin-1"), end + 1


def _text_rows(raw: bytes, place: int, layout: str, where: str) -> list[list[float]]:
    """Node and three components, in fixed columns, of a block of text."""
    end = raw.find(b"\n -3", place)
    if layout not in _NODE or end < 0:
        found = "no end" if layout in _NODE else f"the format {quoted(layout)}"
        raise ProblemError(f"{where}: expected a block in text form that ends with -3, found {found}")
    node, rows, name = _NODE[layout], [], where.partition(": byte")[0]
    lines = raw[place:end].decode("latin-1").split("\n")
    for k, line in enumerate(lines, start=raw.count(b"\n", 0, place) + 1):
        where = f"{name}: line {k}"
        if line.startswith(" -1"):
            fields = [line[node.stop + _WIDTH * k : node.stop + _WIDTH * (k + 1)].strip() for k in range(3)]
            if not fields[-1]:
                raise ProblemError(f"{where}: expected a node with three numbers, found {quoted(line)}")
            rows.append([*integers([line[node].strip()], where), *numbers(fields, where)])
    return rows


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


_TITLE = "the results of a CalculiX run (.frd); they are of a load: its key 'open', 'reactions' or 'thermal'"
FORMATS = (Format("frd", _TITLE, begins(lambda text: text.startswith(_BEGIN)), {"vectors": read_frd}),)
