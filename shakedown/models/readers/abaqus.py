"""Matrices of Abaqus: labelled entries (``*MATRIX OUTPUT``), substructures, and their load cases."""

import os
import re
from collections.abc import Iterator

import numpy as np
from scipy import sparse

from shakedown.ground.errors import ProblemError
from shakedown.models.condensation.contact_frame import checked_dofs
from shakedown.models.readers import parsing
from shakedown.models.readers.formats import Format, has
from shakedown.models.readers.parsing import quoted, unfit
from shakedown.models.readers.stiffness import Stiffness, from_entries, printed_accuracy

NodalLoads = dict[tuple[int, int], float]
ABAQUS_MATRIX = "Abaqus matrix input"
_ENTRY = re.compile(rf"^\s*-?\d+\s*,\s*\d+\s*,\s*-?\d+\s*,\s*\d+\s*,\s*{parsing.REAL}\s*,?\s*$")


def read_abaqus_matrix(path: str | os.PathLike[str]) -> Stiffness:
    """Read ``node,dof, node,dof, value`` lines: either triangle, or both.

    Negative labels are internal nodes of Abaqus; they stay, to be condensed with
    the interior. 1e36 on the diagonal marks constrained rows; it stays too.

    Raises
    ------
    ProblemError
        If a line is malformed or an entry occurs twice.
    """
    name = os.fspath(path)
    lines = [(k, text.rstrip(",")) for k, text in _data_lines(path)]
    expected = "'node,dof, node,dof, value' (*MATRIX OUTPUT, FORMAT=MATRIX INPUT)"
    places, table = parsing.rows_of_numbers(lines, 5, name, expected)
    if not places:
        raise unfit(name, "matrix entries", "none")
    keys = parsing.whole_numbers(table[:, :4], places, name)
    return from_entries(keys[:, :2], keys[:, 2:], table[:, 4], name, ABAQUS_MATRIX)


def read_nodal_loads(path: str | os.PathLike[str]) -> NodalLoads:
    """Read ``node, dof, value`` lines (Abaqus ``*CLOAD``): {(node, direction): force}.

    Raises
    ------
    ProblemError
        If a line is malformed or a degree of freedom occurs twice.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "job_LOAD1.mtx"
    >>> _ = path.write_text("** Assembled nodal loads\\n*CLOAD, REAL\\n12,2, -5.0e+01\\n")
    >>> read_nodal_loads(path)
    {(12, 2): -50.0}
    """
    loads: NodalLoads = {}
    for k, text in _data_lines(path):
        where, fields = f"{os.fspath(path)}: line {k}", text.rstrip(",").split(",")
        if len(fields) != 3:
            raise unfit(where, "'node, dof, value'", quoted(text))
        if fields[0].strip()[:1].isalpha():
            raise ProblemError(
                f"{where}: expected a node label, found the set {quoted(fields[0])} (list sets in the "
                "configuration: forces = [[set, direction, value]])"
            )
        node, direction = parsing.integers(fields[:2], where)
        if (node, direction) in loads:
            raise unfit(where, "every (node, dof) once", f"({node}, {direction}) twice")
        loads[node, direction] = parsing.number(fields[2], where)
    return loads


def _data_lines(path: str | os.PathLike[str]) -> Iterator[tuple[int, str]]:
    """Number and text of every line that is neither a keyword nor a remark."""
    for k, line in enumerate(parsing.read_lines(path), start=1):
        text = line.strip()
        if text and not text.startswith("*"):
            yield k, text


ELEMENT = re.compile(r"\s*\*USER ELEMENT\b", re.IGNORECASE)
_NODES = re.compile(r"\*\*\s*ELEMENT NODES", re.IGNORECASE)
_LOAD = re.compile(r"\*\*\s*SUBSTRUCTURE LOAD\b(?:.*?(?:CASE|VECTOR)\W+(?=\w+\s*$))?(.*)$", re.IGNORECASE)


def read_abaqus_substructure(path: str | os.PathLike[str], matrix: str | None = None) -> Stiffness:
    """Read a ``*USER ELEMENT`` block: node labels from comments, dof lists, ``*MATRIX,TYPE=STIFFNESS``.

    ``matrix`` names another type, ``"MASS"``.

    Raises
    ------
    ProblemError
        If the block is incomplete, or the count of numbers is neither that of
        the lower triangle nor (UNSYM) that of the full matrix.
    """
    element = _Element(path, (matrix or "STIFFNESS").upper())
    N, full = len(element.dofs), ",UNSYM" in element.header and matrix is None  # a mass is symmetric
    fields = [(field, where) for where, own in element.matrix for field in own]
    data = np.array([parsing.number(*field) for field in fields])
    expected = N * N if full else N * (N + 1) // 2
    if len(data) != expected:
        raise ProblemError(
            f"{element.name}: expected {expected} numbers for {N} dofs "
            f"({'full matrix' if full else 'lower triangle'}), found {len(data)}"
        )
    K = data.reshape(N, N).T if full else np.zeros((N, N))
    if not full:
        lower = np.tril_indices(N)
        K[lower] = K.T[lower] = data
    dofs, accuracy = checked_dofs(np.array(element.dofs, dtype=np.intp)), printed_accuracy(data)
    return Stiffness(sparse.csr_array(K), dofs, "substructure matrix", superelement=True, accuracy=accuracy)


def read_substructure_load(path: str | os.PathLike[str], case: str | None = None) -> NodalLoads:
    """Read a load case vector (``SLOAD=YES``): forces on the retained degrees of freedom.

    The vectors stand in comment lines behind the matrices, one line ``position,
    dof, value`` per entry; the position counts in the node list, as in the dof
    lists.

    Parameters
    ----------
    path
        The ``.mtx`` file.
    case
        Name of the ``*SUBSTRUCTURE LOAD CASE``; by default the only one.

    Raises
    ------
    ProblemError
        If there is no such case, or a line of it is malformed.
    """
    name, lines, labels = os.fspath(path), parsing.read_lines(path), _Element(path).labels
    found = {
        (match[1] or "").strip().upper(): k for k, line in enumerate(lines) if (match := _LOAD.match(line))
    }
    if case is None and len(found) == 1:
        case = next(iter(found))
    if case is None or case.strip().upper() not in found:
        raise unfit(name, "one load case of SLOAD=YES (key 'case')", parsing.listed(found))
    loads: NodalLoads = {}
    for k in range(found[case.strip().upper()] + 1, len(lines)):
        text, where = lines[k].strip(), f"{name}: line {k + 1}"
        fields = text.lstrip("*").replace(",", " ").split()
        if not text.startswith("**") or (loads and (len(fields) < 3 or not fields[-2].isdigit())):
            break
        if len(fields) < 3 or not fields[-2].isdigit():
            continue  # a heading
        position, direction = parsing.integers(fields[-3:-1], where)
        if not 1 <= position <= len(labels):
            raise unfit(where, f"a position from 1 to {len(labels)}", position)
        key = (labels[position - 1], direction)
        if key in loads:
            raise unfit(where, "every position and dof once", f"{position}, {direction} twice")
        loads[key] = parsing.number(fields[-1], where)
    if not loads:
        raise unfit(name, f"entries of the load case {quoted(case)}", "none")
    return loads


class _Element:
    """A ``*USER ELEMENT`` with its stiffness, or another matrix.

    Attributes
    ----------
    name, header
        The file, and the line of the keyword in upper case without blanks.
    labels
        The labels of its nodes, which stand in comments.
    dofs
        (node, direction) of every row; a dof list holds from its node on, up to that of the next list.
    matrix
        The fields of the data lines of its matrix of some kind, and where each line stands.
    """

    def __init__(self, path: str | os.PathLike[str], kind: str = "STIFFNESS") -> None:
        self.name, self.labels = os.fspath(path), list[int]()
        lists: list[tuple[str, list[str]]] = []
        self.matrix: list[tuple[str, list[str]]] = []
        self.header, into, listed_nodes = "", None, False
        wanted = re.compile(rf"\*MATRIX\s*,.*TYPE\s*=\s*{re.escape(kind)}\b", re.IGNORECASE)
        for k, line in enumerate(parsing.read_lines(path), start=1):
            text, where = line.strip(), f"{self.name}: line {k}"
            fields = [field.strip() for field in text.lstrip("*").split(",") if field.strip()]
            if text.startswith("**"):
                if listed_nodes and all(re.fullmatch(r"-?\d+", field) for field in fields):
                    self.labels += parsing.integers(fields, where)
                else:
                    listed_nodes = bool(self.header) and not self.labels and _NODES.match(text) is not None
                continue
            listed_nodes = False
            if text.startswith("*"):
                into = None
                if ELEMENT.match(text) and not self.header:
                    self.header, into = text.upper().replace(" ", ""), lists
                elif wanted.match(text) and self.header and not self.matrix:
                    into = self.matrix
            elif into is not None and fields:
                into.append((where, fields))
        self._check(kind)
        self.dofs = self._dofs(lists)

    def _check(self, kind: str) -> None:
        for keyword, there in (("*USER ELEMENT", self.header), (f"*MATRIX, TYPE={kind}", self.matrix)):
            if not there:
                raise unfit(self.name, f"the keyword {keyword}", "none")
        count = re.search(r"NODES=0*(\d*)", self.header)
        if count is None or str(len(self.labels)) != count[1]:
            expected = "as many node labels in the comments after '** ELEMENT NODES' as NODES= says"
            raise unfit(self.name, expected, len(self.labels))

    def _dofs(self, lists: list[tuple[str, list[str]]]) -> list[tuple[int, int]]:
        own: list[list[int]] = [[] for _ in self.labels]
        for number_of, (where, fields) in enumerate(lists):
            position, *directions = parsing.integers(fields if number_of else ["1", *fields], where)
            if not 1 <= position <= len(own) or not directions:
                raise unfit(
                    where, f"'position, dof, …' with position 1 to {len(own)}", quoted(", ".join(fields))
                )
            own[position - 1 :] = [directions] * (len(own) - position + 1)
        if not lists:
            raise unfit(self.name, "dof lists after *USER ELEMENT", "none")
        return [(label, d) for label, every in zip(self.labels, own, strict=True) for d in every]


_SUBSTRUCTURE = {"stiffness": read_abaqus_substructure}
FORMATS = (
    Format("substructure", "Abaqus substructure", _SUBSTRUCTURE, ("matrix",), contains=has(ELEMENT, "*")),
    Format("abaqus-matrix", "Abaqus MATRIX INPUT", {"stiffness": read_abaqus_matrix}, contains=has(_ENTRY)),
)
