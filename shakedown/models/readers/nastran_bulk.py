"""Nastran bulk data: the analysis set, grid points and their directions."""

import importlib
import os
import re
import struct
import warnings
from collections import Counter
from collections.abc import Iterator
from io import StringIO
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.nastran_cards import Card, card_fields, cards, of_superelement
from shakedown.models.readers.text import integers, quoted, read_lines

_PAIRS = ("ASET", "BSET", "CSET", "QSET")  # id, components, id, components, …
_LISTS = tuple(f"{name}1" for name in _PAIRS)  # components, id, id, … or id THRU id
_ROWS = (*_PAIRS, *_LISTS, "EXTRN", "USET", "USET1", "SECONCT")
_CARD = re.compile(
    r"(EXTRN|[ABCQ]SET1?|USET1?|GRID|SPOINT|CORD\d[RCS]|SECONCT|BEGIN (SUPER|BULK)|DMIG|DTI)\s*[\*, \d]"
)
# What pyYeti raises on a damaged file; anything else is an error of the program.
UNREADABLE = (
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    RuntimeError,
    MemoryError,
    Warning,
    struct.error,
    EOFError,
)
_MOST_POINTS = 10_000_000  # largest number of points that a THRU may name


def is_bulk_data(lines: list[str]) -> bool:
    """Whether a text holds bulk data cards."""
    return any(_CARD.match(line.upper()) for line in lines)


def read_analysis_set(path: str | os.PathLike[str], superelement: int | None = None) -> NDArray[np.intp]:
    """(point, component) of every row of a matrix of the analysis set, (N, 2).

    EXTRN gives the order itself. ASET, BSET, CSET, QSET (also ASET1 …) and, where
    there are none of these, USET and USET1 give the members, which Nastran orders
    by point and component. SECONCT (the ``.asm`` file) gives the points: six
    components for a GRID, one (0) for an SPOINT. Scalar points have component 0. Of a
    file with several superelements the one to take must be named.

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
    lines = of_superelement(read_lines(path), superelement, name)
    found = [card for card in cards(lines) if card[1] in (*_ROWS, "GRID", "SPOINT")]
    by_name: dict[str, list[Card]] = {}
    for card in found:
        by_name.setdefault(card[1], []).append(card)
    if "EXTRN" in by_name:
        return _unique([row for card in by_name["EXTRN"] for row in _pairs(card, name)], name)
    rows = [row for key in _PAIRS for card in by_name.get(key, []) for row in _pairs(card, name)]
    rows += [row for key in _LISTS for card in by_name.get(key, []) for row in _list(card, name)]
    if not rows:
        for key, read in (("USET", _pairs), ("USET1", _list)):
            for k, own, fields in by_name.get(key, []):
                rows += read((k, own, fields[1:]), name)
    if rows:
        return _unique([list(row) for row in sorted({tuple(row) for row in rows})], name)
    if "SECONCT" in by_name:
        return _connected(by_name, name)
    raise ProblemError(
        f"{name}: expected the rows of the analysis set (EXTRN, ASET, BSET, QSET, USET or SECONCT "
        "cards), found none"
    )


def _unique(rows: list[list[int]], name: str) -> NDArray[np.intp]:
    if len({tuple(row) for row in rows}) < len(rows):
        (point, component), _ = Counter(map(tuple, rows)).most_common(1)[0]
        raise ProblemError(
            f"{name}: expected every point and component once, found component {component} of point {point} "
            "twice"
        )
    return np.array(rows, dtype=np.intp)


def _components(text: str, where: str) -> list[int]:
    if not re.fullmatch(r"[0-6]{0,6}", text):
        raise ProblemError(
            f"{where}: expected components 1 to 6 (0 or blank for a scalar point), found {quoted(text)}"
        )
    return [int(digit) for digit in text] or [0]


def _pairs(card: Card, name: str) -> list[list[int]]:
    """id, components, id, components, …"""
    k, _, fields = card
    where, rows = f"{name}: line {k}", []
    for point, text in zip(fields[::2], fields[1::2], strict=False):
        if point:
            label = integers([point], where)[0]
            rows += [[label, component] for component in _components(text, where)]
    return rows


def _list(card: Card, name: str) -> list[list[int]]:
    """components, id, id, … or components, id, THRU, id."""
    k, _, (text, *fields) = card
    components = _components(text, f"{name}: line {k}")
    return [[point, component] for point in _points(fields, f"{name}: line {k}") for component in components]


def _points(fields: list[str], where: str) -> list[int]:
    fields = [field for field in fields if field]
    if len(fields) == 3 and fields[1].upper() == "THRU":
        first, last = integers([fields[0], fields[2]], where)
        if not 0 <= last - first < _MOST_POINTS:
            raise ProblemError(f"{where}: expected 'first THRU last', found {first} THRU {last}")
        return list(range(first, last + 1))
    return integers(fields, where)


def _connected(by_name: dict[str, list[Card]], name: str) -> NDArray[np.intp]:
    """Rows of the points that SECONCT pairs with those of the superelement."""
    grids = {int(integers(fields[:1], f"{name}: line {k}")[0]) for k, _, fields in by_name.get("GRID", [])}
    rows: list[list[int]] = []
    for k, _, fields in by_name["SECONCT"]:
        points = integers([field for field in fields[8::2] if field], f"{name}: line {k}")
        rows += [
            [point, component] for point in points for component in (range(1, 7) if point in grids else (0,))
        ]
    return _unique(rows, name)


def read_grids(
    path: str | os.PathLike[str], superelement: int | None = None
) -> tuple[Mesh, dict[int, FloatArray]]:
    """Grid points in the basic system, and the output directions of those that have their own.

    Read by pyYeti (the extra ``nastran``): GRID with CORD2R, CORD2C and CORD2S. Of a file
    with several superelements the one to take must be named.

    Returns
    -------
    mesh : Mesh
        The grid points.
    frames : dict
        For each grid point whose directions are not the basic ones, the (3, 3)
        matrix R with u_own = R u_basic.

    Raises
    ------
    ProblemError
        If pyYeti is not installed or cannot read the cards, or there are none.
    """
    name = os.fspath(path)
    lines = of_superelement(read_lines(path), superelement, name)
    own = [line for _, line in _lines_of(lines, ("GRID", "CORD2R", "CORD2C", "CORD2S"))]
    if not any(line.upper().startswith("GRID") for line in own):
        raise ProblemError(f"{name}: expected GRID cards, found none")
    bulk, n2p = pyyeti_module("bulk", name), pyyeti_module("n2p", name)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            uset, _ = bulk.bulk2uset(StringIO("\n".join(own) + "\n"))
            rigid = np.asarray(n2p.rbgeom_uset(uset), dtype=float)
            labels = uset.index.get_level_values(0).to_numpy()[::6].astype(np.intp)
            xyz = np.array(uset.iloc[::6, 1:4], dtype=float)
    except UNREADABLE as error:
        raise ProblemError(
            f"{name}: expected GRID and CORD2 cards that pyYeti can read, found {quoted(str(error))}"
        ) from None
    finite = np.isfinite(xyz).all(axis=1) & np.isfinite(rigid.reshape(len(labels), -1)).all(axis=1)
    if not finite.all():
        k = int(np.argmin(finite))
        raise ProblemError(
            f"{name}: expected finite coordinates, found {xyz[k].tolist()} of point {labels[k]}"
        )
    frames = {int(label): rigid[6 * k : 6 * k + 3, :3] for k, label in enumerate(labels)}
    turned = {label: R for label, R in frames.items() if not np.array_equal(R, np.eye(3))}
    return Mesh.of_nodes(labels, xyz, name), turned


def _lines_of(lines: list[str], names: tuple[str, ...]) -> Iterator[tuple[int, str]]:
    """Lines of the named cards, their continuations included."""
    inside = False
    for k, line in enumerate(lines, start=1):
        text = line.split("$")[0].rstrip()
        if not text:
            continue
        first = card_fields(text)[0]
        if first[:1] not in ("", "*", "+"):
            inside = first.rstrip("*").strip().upper() in names
        if inside:
            yield k, text


def pyyeti_module(module: str, name: str) -> ModuleType:
    """A module of ``pyyeti.nastran``; ``ProblemError`` says how to install it."""
    try:
        with warnings.catch_warnings(), np.printoptions():  # pyYeti sets the print options of NumPy
            warnings.simplefilter("ignore")
            return importlib.import_module(f"pyyeti.nastran.{module}")
    except ImportError:
        raise ProblemError(
            f"{name}: expected pyYeti, which reads Nastran files, found it not installed "
            "(pip install 'shakedown-bounds[nastran]')"
        ) from None
