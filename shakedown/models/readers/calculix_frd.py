"""CalculiX ``*NODE FILE`` output (``job.frd``) in text form: displacements and reactions of every step."""

import os

from shakedown.ground.errors import ProblemError
from shakedown.ground.round_off import SIX_DIGITS
from shakedown.models.readers.calculix_reactions import LETTERS, step_of
from shakedown.models.readers.nodal_vectors import NodalVectors, What
from shakedown.models.readers.text import integers, number, quoted, read_lines

_BLOCKS: dict[What, str] = {"displacements": "DISP", "reactions": "FORC"}
_NODE = {"0": slice(3, 8), "1": slice(3, 13)}  # by the format of a block; others are binary
_WIDTH = 12  # of a number; numbers touch
_TIME, _FORMAT = slice(12, 24), slice(73, 75)


def is_frd(lines: list[str]) -> bool:
    """Whether a file begins as a ``.frd`` file does."""
    return bool(lines) and lines[0].startswith("    1C")


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
