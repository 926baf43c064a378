"""Files of Nastran: bulk data (points, sets, DMIG matrices), and OUTPUT4, read by pyYeti (extra ``nastran``).

The reader of DMIG cards, in small, large and free field, is the project's own: pyYeti's takes the last of two
entries for one place, reads a missing value as zero, and holds the matrix dense.
"""

import importlib
import os
import re
import warnings
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from io import StringIO
from itertools import pairwise
from types import ModuleType
from typing import Any

import numpy as np
from scipy import sparse

from shakedown.ground.constants import IntArray
from shakedown.ground.errors import ProblemError, not_installed
from shakedown.models.readers import parsing
from shakedown.models.readers.formats import Format, has
from shakedown.models.readers.mapped_matrices import row_map
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.parsing import listed, quoted, unfit
from shakedown.models.readers.stiffness import Rows, Stiffness, checked, from_entries

Card = tuple[int, str, list[str]]  # line number, name, data fields
_BEGIN = re.compile(r"BEGIN\b\s*(?:BULK\b\s*)?(?:SUPER\b\s*=?\s*(\d{1,18}))?", re.IGNORECASE)


def cards(lines: list[str]) -> Iterator[Card]:
    """Every card: its line, name and data fields, in small, large or free fields, continuations joined."""
    card: Card | None = None
    for k, line in enumerate(lines, start=1):
        text = line.split("$")[0].rstrip()
        if not text:
            continue
        first, fields = card_fields(text)
        if first[:1] in ("", "*", "+"):  # a continuation, named or not
            if card is not None:
                card[2].extend(fields)
            continue
        if card is not None:
            yield card
        card = k, first.rstrip("*").strip().upper(), fields
    if card is not None:
        yield card


def spans(lines: list[str]) -> Iterator[tuple[Card, int]]:
    """Every card, and the number of the last of its lines or of the remarks behind it."""
    for card, (after, _, _) in pairwise([*cards(lines), (len(lines) + 1, "", [])]):
        yield card, after - 1


def card_fields(text: str) -> tuple[str, list[str]]:
    """First field and data fields of one line, sliced by columns unless it has commas."""
    if "," in text:
        first, *rest = [field.strip() for field in text.split(",")]
        width = 4 if "*" in first else 8
        return first, [*rest, *[""] * (width - len(rest))][:width]
    text = text.expandtabs(8)
    first = text[:8].strip()
    width, count = (16, 4) if "*" in first else (8, 8)
    padded = text.ljust(8 + width * count)
    return first, [padded[8 + width * i : 8 + width * (i + 1)].strip() for i in range(count)]


def lines_of_one(path: str | os.PathLike[str]) -> list[str]:
    """The lines of a file that holds one superelement at most: by its sections, else its SECONCT cards.

    Raises
    ------
    ProblemError
        If there are several, as ``BEGIN SUPER n`` or the SECONCT cards of an ``.asm`` file say.
    """
    name, lines = os.fspath(path), parsing.read_lines(path)
    known = {int(match[1] or 0) for line in lines if (match := _BEGIN.match(line.strip()))} - {0}
    if not known:
        connected = ((k, fields) for k, card, fields in cards(lines) if card == "SECONCT")
        known = {parsing.integers(fields[:1], f"{name}: line {k}")[0] for k, fields in connected}
    if len(known) > 1:
        raise unfit(name, "one superelement", f"{listed(map(str, sorted(known)))}; give a file of one alone")
    return lines


def chosen_matrix(names: list[str], matrix: str | None, where: str, scalars: Sequence[int] = ()) -> int:
    """The place of a matrix among those of a file.

    Parameters
    ----------
    names
        Theirs, in upper case.
    matrix
        The name of the one to take, with ``(k)`` behind it for the k-th of that name; by default the only one
        whose name begins with K, or the only one at all.
    where
        The file, for messages.
    scalars
        Places of those that are no stiffness, being of size 1 × 1.

    Raises
    ------
    ProblemError
        If there is none, or several.

    Examples
    --------
    >>> chosen_matrix(["KAAX", "MAAX", "MAAX"], "maax(2)", "a file")
    2
    """
    wanted, which = (matrix or "").strip().upper(), None
    if counted := re.fullmatch(r"(.+)\((\d{1,9})\)", wanted):
        wanted, which = counted[1], int(counted[2])
    places = [k for k, own in enumerate(names) if own == wanted]
    if matrix is None:
        stiff = [k for k, own in enumerate(names) if own.startswith("K") and k not in scalars]
        places = [0] if len(names) == 1 else stiff
    if which is not None and 1 <= which <= len(places):
        return places[which - 1]
    if which is not None or len(places) != 1:
        what = "one stiffness matrix" if matrix is None else f"one matrix {quoted(matrix)}"
        raise unfit(where, what, f"{listed(names)}; name the one to take ('KXX(2)': the second of a name)")
    return places[0]


# Cards of the analysis set, those that say more first: pairs id, components; lists components, id, id, ….
_SETS = ("ASET", "BSET", "CSET", "QSET")
_ROWS = ((("EXTRN",), ()), (_SETS, tuple(f"{name}1" for name in _SETS)), (("USET",), ("USET1",)))
_CARDS = re.compile(
    r"(EXTRN|[ABCQ]SET1?|USET1?|GRID|SPOINT|CORD\d[RCS]|SECONCT|BEGIN (SUPER|BULK)|DMIG|DTI)\s*[\*, \d]"
)


def is_bulk_data(lines: list[str]) -> bool:
    """Whether a text holds bulk data cards."""
    return any(_CARDS.match(line.upper()) for line in lines)


def read_analysis_set(path: str | os.PathLike[str]) -> IntArray:
    """(point, component) of every row of a matrix of the analysis set, (N, 2).

    EXTRN gives the order itself. ASET, BSET, CSET, QSET (also ASET1 …) and, where
    there are none of these, USET and USET1 give the members, which Nastran orders
    by point and component. SECONCT (the ``.asm`` file) gives the points: six
    components for a GRID, one (0) for an SPOINT. Scalar points have component 0.

    Raises
    ------
    ProblemError
        If there is no such card, or one is malformed.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "part.pch"
    >>> _ = path.write_text("EXTRN          3      12       9       0\\n")
    >>> read_analysis_set(path).tolist()
    [[3, 1], [3, 2], [9, 0]]
    """
    name = os.fspath(path)
    found: dict[str, list[tuple[str, list[str]]]] = defaultdict(list)
    for k, card, fields in cards(lines_of_one(path)):
        found[card].append((f"{name}: line {k}", fields[1:] if card in ("USET", "USET1") else fields))
    for pairs, lists in _ROWS:
        rows = [row for card in pairs for own in found[card] for row in _of_pairs(*own)]
        rows += [row for card in lists for own in found[card] for row in _of_list(*own)]
        if rows:
            return _once(rows if pairs == ("EXTRN",) else sorted(set(rows)), name)
    if not found["SECONCT"]:
        raise unfit(
            name, "the rows of the analysis set (EXTRN, ASET, BSET, QSET, USET or SECONCT cards)", "none"
        )
    grids = {parsing.integers(fields[:1], where)[0] for where, fields in found["GRID"]}
    connected = ((where, [field for field in fields[8::2] if field]) for where, fields in found["SECONCT"])
    points = [point for where, fields in connected for point in parsing.integers(fields, where)]
    rows = [(point, component) for point in points for component in (range(1, 7) if point in grids else (0,))]
    return _once(rows, name)


def _once(rows: list[tuple[int, int]], name: str) -> IntArray:
    """The rows, none of them twice."""
    (point, component), times = Counter(rows).most_common(1)[0]
    if times > 1:
        raise unfit(name, "every point and component once", f"component {component} of point {point} twice")
    return np.array(rows, dtype=np.intp)


def _components(text: str, where: str) -> list[int]:
    if not re.fullmatch(r"[0-6]{0,6}", text):
        raise unfit(where, "components 1 to 6 (0 or blank for a scalar point)", quoted(text))
    return [int(digit) for digit in text] or [0]


def _of_pairs(where: str, fields: list[str]) -> Iterator[tuple[int, int]]:
    """Rows of id, components, id, components, …"""
    for point, text in zip(fields[::2], fields[1::2], strict=False):
        for label in parsing.integers([point] if point else [], where):
            yield from ((label, component) for component in _components(text, where))


def _of_list(where: str, fields: list[str]) -> Iterator[tuple[int, int]]:
    """Rows of components, id, id, … or components, id, THRU, id."""
    components, given = _components(fields[0], where), [field for field in fields[1:] if field]
    points: Iterable[int]
    if len(given) == 3 and given[1].upper() == "THRU":
        first, last = parsing.integers(given[::2], where)
        # largest number of points that a THRU may name
        if not 0 <= last - first < 10_000_000:
            raise unfit(where, "'first THRU last'", f"{first} THRU {last}")
        points = range(first, last + 1)
    else:
        points = parsing.integers(given, where)
    return ((point, component) for point in points for component in components)


def read_grids(path: str | os.PathLike[str]) -> Mesh:
    """Grid points in the basic system, with the output directions (``frames``) of those that have their own.

    Read by pyYeti (the extra ``nastran``): GRID with CORD2R, CORD2C and CORD2S.

    Raises
    ------
    ProblemError
        If pyYeti is not installed or cannot read the cards, or there are none.
    """
    name, lines = os.fspath(path), lines_of_one(path)
    read = ("GRID", "CORD2R", "CORD2C", "CORD2S")
    found = [(card[1], lines[card[0] - 1 : last]) for card, last in spans(lines) if card[1] in read]
    own = [line.split("$")[0].rstrip() for _, lines in found for line in lines]
    if not any(card == "GRID" for card, _ in found):
        raise unfit(name, "GRID cards", "none")
    bulk, n2p = pyyeti_module("bulk", name), pyyeti_module("n2p", name)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            uset, _ = bulk.bulk2uset(StringIO("\n".join(filter(None, own)) + "\n"))
            rigid = np.asarray(n2p.rbgeom_uset(uset), dtype=float)
            labels = uset.index.get_level_values(0).to_numpy()[::6].astype(np.intp)
            xyz = np.array(uset.iloc[::6, 1:4], dtype=float)
    except parsing.UNREADABLE as error:
        raise unfit(name, "GRID and CORD2 cards that pyYeti can read", quoted(str(error))) from None
    finite = np.isfinite(xyz).all(axis=1) & np.isfinite(rigid.reshape(len(labels), -1)).all(axis=1)
    if not finite.all():
        k = int(np.argmin(finite))
        raise unfit(name, "finite coordinates", f"{xyz[k].tolist()} of point {labels[k]}")
    frames = {int(label): rigid[6 * k : 6 * k + 3, :3] for k, label in enumerate(labels)}
    turned = {label: R for label, R in frames.items() if not np.array_equal(R, np.eye(3))}
    return replace(Mesh.of_nodes(labels, xyz, name), frames=turned)


def pyyeti_module(module: str, name: str) -> ModuleType:
    """A module of ``pyyeti.nastran``; ``ProblemError`` says how to install it."""
    try:
        with warnings.catch_warnings(), np.printoptions():  # pyYeti sets the print options of NumPy
            warnings.simplefilter("ignore")
            return importlib.import_module(f"pyyeti.nastran.{module}")
    except ImportError:
        raise ProblemError(not_installed(name, "pyYeti, which reads Nastran files", "nastran")) from None


_REAL = (1, 2)  # types: single and double precision


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
    name, lines = os.fspath(path), lines_of_one(path)
    found = [(k, fields) for k, card, fields in cards(lines) if card == "DMIG"]
    known = sorted({fields[0] for _, fields in found})
    chosen = known[chosen_matrix(known, matrix, name)]
    own = [(k, fields) for k, fields in found if fields[0] == chosen]
    header = [(k, fields) for k, fields in own if fields[1] == "0"]
    shown = listed([chosen])
    if len(header) != 1 or len(header) == len(own):
        raise unfit(name, f"one DMIG header card of {shown}, and entries", f"{len(header)} of {len(own)}")
    where = f"{name}: line {header[0][0]}"
    form, kind = parsing.integers(header[0][1][2:4], where)
    if form not in (1, 6) or kind not in _REAL:
        expected = f"{shown} square or symmetric (form 1, 6) and real (type 1, 2)"
        raise unfit(where, expected, f"form {form}, type {kind}")
    entries = []  # (node, direction) of the row and of the column, and the value
    for k, fields in (card for card in own if card not in header):
        where = f"{name}: line {k}"
        column = parsing.integers([fields[1], fields[2] or "0"], where)
        for group in range(4, len(fields), 4):
            node, direction, value = fields[group : group + 3]
            if node or value:
                entries.append(
                    (parsing.integers([node, direction or "0"], where), column, parsing.number(value, where))
                )
    rows, columns, values = map(np.array, zip(*entries, strict=True))
    return from_entries(rows, columns, values, name, "Nastran DMIG")


_HEADER = re.compile(
    rb"^([ \d-]{8}|[ \d-]{16})([ \d-]{8}|[ \d-]{16})([ \d]{8})([ \d]{8})([A-Za-z_]\S{0,7}) *(\S*)\r?$",
    re.MULTILINE,
)


def is_op4(text: str) -> bool:
    """Whether the first characters of a file, a byte each, are those of an OUTPUT4 file, binary or text."""
    raw = text.encode("latin-1")
    if b"\0" in raw[:4]:  # the length of a binary header record
        return any(int.from_bytes(raw[:4], order) in (24, 48) for order in ("little", "big"))
    return _HEADER.match(raw) is not None


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
        installed, or the file is damaged.
    """
    name, values = os.fspath(path), read_op4_entries(path, matrix)
    size, columns = values.shape
    if size != columns:
        raise unfit(name, "a square matrix", f"{size} x {columns}")
    table = row_map(rows, size, name, "Nastran OUTPUT4")
    return checked(sparse.csr_array(values), table, "Nastran OUTPUT4")


def read_op4_entries(path: str | os.PathLike[str], matrix: str | None) -> sparse.coo_matrix:
    """One real matrix of an OUTPUT4 file; see :func:`read_nastran_op4`.

    It is sparse, because a header may claim far more than a file holds.
    """
    name = os.fspath(path)
    if not is_op4(parsing.read_bytes(path, 256).decode("latin-1")):
        raise unfit(name, "an OUTPUT4 file", "no header of one")
    reader = pyyeti_module("op4", name).OP4()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            names, values, _, types = reader.load(name, into="list", sparse=True)
    except parsing.UNREADABLE as error:
        raise unfit(name, "whole matrices", quoted(str(error))) from None
    finally:
        reader._op4close()
    scalars = [k for k, own in enumerate(values) if own.shape == (1, 1)]
    k = chosen_matrix([own.upper() for own in names], matrix, name, scalars)
    found = values[k]
    if types[k] not in _REAL or not np.isfinite(found.data).all():
        raise unfit(name, f"{names[k]} to be real (type 1 or 2) and finite", f"type {types[k]}")
    return found


_BULK = "Nastran bulk data without a DMIG matrix (it may be the 'map' of an OUTPUT4 file)"
_OF_BULK: dict[str, Callable[..., Any]] = {
    "mesh": read_grids,
    "rows": lambda path, size: read_analysis_set(path),
}
_DMIG = re.compile(r"DMIG\b", re.IGNORECASE)
_OF_DMIG, _OF_OP4 = {"stiffness": read_nastran_dmig}, {"stiffness": read_nastran_op4}
FORMATS = (
    Format("op4", "Nastran OUTPUT4", _OF_OP4, ("rows", "matrix"), begins=is_op4),
    Format("dmig", "Nastran DMIG", _OF_DMIG, ("matrix",), contains=has(_DMIG)),
    Format("bulk", _BULK, _OF_BULK, contains=is_bulk_data),
)
