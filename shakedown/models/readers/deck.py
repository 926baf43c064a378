"""Input decks of Abaqus and CalculiX: nodes, sets, elements, surfaces and equations."""

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.models.readers.coordinate_system import Line
from shakedown.models.readers.mesh import ABAQUS, CALCULIX, FACES, Element, Mesh, Orientation
from shakedown.models.readers.text import integers, number, quoted, read_lines

_SHAPES = {  # of elements with so many nodes
    "solid": dict.fromkeys((4, 10), "tetrahedron")
    | dict.fromkeys((6, 15), "wedge")
    | dict.fromkeys((8, 20), "hexahedron"),
    "plane": dict.fromkeys((3, 6), "triangle") | dict.fromkeys((4, 8), "quadrilateral"),
}
_TYPE = re.compile(r"(C3D|CPEG|CPE|CPS|CGAX|CAX)(\d{1,3})")
_REVOLVED = re.compile(r"(CG?|S|MG?|R|SFMG?)AX\d")  # element types of bodies of revolution
_OPENING = re.compile(r"\s*\*(NODE\s*(,|$)|INCLUDE\s*,|HEADING)", re.IGNORECASE)
_INCLUDE = re.compile(r"\*INCLUDE\s*(?:,\s*INPUT\s*=\s*\"?([^\",]+))?", re.IGNORECASE)
_DEEPEST, _MOST_FILES, _MOST_LINES = 8, 1000, 1 << 24  # of the files that a deck includes, in all
_TAKEN = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "EQUATION")
_MAKERS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")  # make nodes and elements of others

Labels = NDArray[np.intp]
Sets = dict[str, Labels]


class Card(NamedTuple):
    """A keyword with its parameters and data lines."""

    keyword: str
    parameters: dict[str, str]
    data: list[Line]

    def name(self, key: str) -> str:
        """A parameter that names a set, in upper case; "" where there is none."""
        return self.parameters.get(key, "").upper()


class _Members(NamedTuple):
    """One line of members of a set; ``generate``: first, last, step."""

    where: str
    fields: list[str]
    generate: bool = False


def is_deck(lines: list[str]) -> bool:
    """Whether a text is an input deck: it has a keyword line ``*NODE`` or ``*INCLUDE``."""
    return any(_OPENING.match(line) for line in lines if "*" in line)


def read_deck(path: str | os.PathLike[str]) -> Mesh:
    """Read the nodes of an input deck, with its sets, surfaces and equations.

    A deck may hold one part instance; its labels are then those that Abaqus
    writes. ``*INCLUDE`` is followed. Elements other than solids and plane ones
    carry no faces.

    Raises
    ------
    ProblemError
        If a line is malformed, a node is defined twice, a set names what is not
        there, or several instances share their labels.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "job.inp"
    >>> _ = path.write_text("*NODE\\n7, 0., 1.\\n9, 2., 1.\\n*NSET, NSET=top, GENERATE\\n7, 9, 2\\n")
    >>> mesh = read_deck(path)
    >>> mesh.nodes("TOP").tolist(), mesh.at([9]).tolist()
    ([7, 9], [[2.0, 1.0, 0.0]])
    """
    deck = _Deck(os.fspath(path))
    for card in _Text().cards(Path(path)):
        deck.take(card)
    return deck.mesh()


@dataclass
class _Text:
    """The text of a deck with the files that it includes, of which there are not too many."""

    files: int = 0
    lines: int = 0

    def cards(self, path: Path) -> Iterator[Card]:
        """Every keyword with its data lines, which may stand in a file of their own (INPUT=)."""
        card: Card | None = None
        for where, text in self.of(path):
            if not text.startswith("*"):
                if card is not None:
                    card.data.append((where, _fields(text)))
                continue
            if card is not None:
                yield card
            head, *rest = text[1:].split(",")
            pairs = (part.partition("=") for part in rest if part.strip())
            parameters = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
            card = Card(" ".join(head.upper().split()), parameters, [])
            if card.keyword in _TAKEN and (beside := parameters.get("INPUT")):
                own = self.of(path.parent / beside)
                card.data.extend((place, _fields(line)) for place, line in own if not line.startswith("*"))
        if card is not None:
            yield card

    def of(self, path: Path, depth: int = 0) -> Iterator[tuple[str, str]]:
        """(where, line) without remarks and blank lines; keywords on one line, included files in place."""
        lines = read_lines(path)
        self.files, self.lines = self.files + 1, self.lines + len(lines)
        if depth > _DEEPEST or self.files > _MOST_FILES or self.lines > _MOST_LINES:
            raise ProblemError(
                f"{path}: expected *INCLUDE at most {_DEEPEST} deep, of {_MOST_FILES} files and "
                f"{_MOST_LINES} lines in all, found more"
            )
        begun = ""
        for k, line in enumerate(lines, start=1):
            text = line.strip()
            if not text or text.startswith("**"):
                continue
            text, begun = begun + text, ""
            if text.startswith("*") and text.endswith(","):  # the parameters go on in the next line
                begun = text
            elif found := _INCLUDE.match(text):
                if not found[1]:
                    raise ProblemError(f"{path}: line {k}: expected *INCLUDE, INPUT=file, found none")
                yield from self.of(path.parent / found[1].strip(), depth + 1)
            else:
                yield f"{path}: line {k}", text


def _fields(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _point(fields: list[str], where: str) -> FloatArray:
    """Three numbers, those that are blank or missing 0."""
    found = [number(text, where) if text else 0.0 for text in fields[:3]]
    return np.array([*found, 0.0, 0.0, 0.0][:3])


@dataclass
class _Deck:
    """What has been read so far; sets are resolved at the end, when all nodes are known."""

    name: str
    nodes: dict[int, FloatArray] = field(default_factory=dict)
    moved: list[int] = field(default_factory=list)  # nodes of the part, which its instance moves
    shift: FloatArray = field(default_factory=lambda: np.zeros(3))
    inside: bool = False  # a part or an instance
    count: dict[str, int] = field(default_factory=lambda: {"PART": 0, "INSTANCE": 0})
    elements: dict[int, Element] = field(default_factory=dict)
    others: list[int] = field(default_factory=list)  # labels of elements without faces
    revolved: str = ""  # an axisymmetric element type that occurs
    flat: str = ""  # another plane or solid type that occurs
    matrix_by: str = ""
    young: list[float] = field(default_factory=list)  # 0 for a material that is not isotropic
    systems: dict[str, Orientation] = field(default_factory=dict)
    node_lists: dict[str, list[_Members]] = field(default_factory=dict)
    nodes_of_elements: list[tuple[str, str]] = field(default_factory=list)  # (node set, element set)
    element_lists: dict[str, list[_Members]] = field(default_factory=dict)
    sides: dict[str, list[tuple[str, str, int]]] = field(default_factory=dict)
    surface_nodes: dict[str, list[_Members]] = field(default_factory=dict)
    sections: list[str] = field(default_factory=list)
    incompatible: int = 0  # how many elements C3D8I
    rotated: list[Card] = field(default_factory=list)
    equations: list[Line] = field(default_factory=list)
    spelled: dict[str, str] = field(default_factory=dict)

    def take(self, card: Card) -> None:
        """Take one keyword with its data lines; those that say nothing about the mesh are passed over."""
        parameters, data = card.parameters, card.data
        for key in ("NSET", "ELSET", "NAME"):
            self.spelled.setdefault(card.name(key), parameters.get(key, ""))
        match card.keyword:
            case "NODE":
                self._nodes(card)
            case "ELEMENT":
                self._elements(card)
            case "NSET":
                _add(self.node_lists, card.name("NSET"), card)
                if "ELSET" in parameters:
                    self.nodes_of_elements.append((card.name("NSET"), card.name("ELSET")))
            case "ELSET":
                _add(self.element_lists, card.name("ELSET"), card)
            case "SURFACE":
                self._surface(card)
            case "TRANSFORM":
                self.rotated.append(card)
            case "ORIENTATION":
                self.systems[card.name("NAME")] = (parameters, data)
            case "EQUATION" if "REMOVE" not in parameters:
                self._equations(data)
            case "PRE-TENSION SECTION":
                self.sections.append(card.name("NODE"))
            case "ELASTIC" if data:
                isotropic = parameters.get("TYPE", "ISO").upper().startswith("ISO")
                self.young.append(number(data[0][1][0], data[0][0]) if isotropic else 0.0)
            case "PART" | "INSTANCE":
                self._begin(card)
            case "END PART" | "END INSTANCE":
                self.inside = False
            case "SYSTEM" if data:
                raise ProblemError(
                    f"{data[0][0]}: expected coordinates x, y, z, found *SYSTEM; write a flat deck"
                )
            case keyword if keyword in _MAKERS:
                raise ProblemError(
                    f"{self.name}: expected every node and element to be listed, found *{keyword}, which "
                    "makes some; let the code write a flat deck"
                )
            case "MATRIX GENERATE" | "MATRIX OUTPUT":
                self.matrix_by = ABAQUS
            case _ if card.name("SOLVER") == "MATRIXSTORAGE":  # of *FREQUENCY or *STATIC
                self.matrix_by = CALCULIX

    def _begin(self, card: Card) -> None:
        """A part, or an instance with what moves it."""
        self.inside = True
        self.count[card.keyword] += 1
        if self.count[card.keyword] > 1:
            raise ProblemError(
                f"{self.name}: expected one part instance, found several, whose labels are not those of the "
                "matrix; write a flat deck (*PREPRINT, or no parts and assemblies)"
            )
        if len(card.data) > 1:
            raise ProblemError(f"{card.data[1][0]}: expected an instance that is moved only, found it turned")
        if card.keyword == "INSTANCE" and card.data:
            where, fields = card.data[0]
            self.shift = _point(fields, where)

    def _nodes(self, card: Card) -> None:
        system, labels = card.name("SYSTEM") or "R", []
        if system not in ("R", "C") and card.data:
            raise ProblemError(
                f"{card.data[0][0]}: expected coordinates of SYSTEM=R or C, found {quoted(system)}; write x, "
                "y, z"
            )
        for where, fields in card.data:
            label = integers(fields[:1], where)[0]
            if label in self.nodes:
                raise ProblemError(f"{where}: expected every node once, found node {label} twice")
            point = _point(fields[1:], where)
            if system == "C":
                angle = np.radians(point[1])
                point = np.array([point[0] * np.cos(angle), point[0] * np.sin(angle), point[2]])
            self.nodes[label] = point
            labels.append(fields[0])
            if self.inside:
                self.moved.append(label)
        if "NSET" in card.parameters and card.data:
            self.node_lists.setdefault(card.name("NSET"), []).append(_Members(card.data[0][0], labels))

    def _elements(self, card: Card) -> None:
        kind, labels = card.name("TYPE"), []
        match = _TYPE.match(kind)
        count = int(match[2]) if match else 0
        shape = _SHAPES["solid" if match and match[1] == "C3D" else "plane"].get(count, "")
        if _REVOLVED.match(kind):
            self.revolved = kind
        elif match:
            self.flat = kind
        read: list[str] = []
        for where, fields in card.data:
            read += [text for text in fields if text]
            if (shape and len(read) <= count) or (not shape and not fields[-1]):
                continue  # goes on in the next line
            if not read:
                continue
            own = integers(read if shape else read[:1], where)
            if shape and len(own) != count + 1:
                raise ProblemError(f"{where}: expected {count} nodes of an element, found {len(own) - 1}")
            if own[0] in self.elements:
                raise ProblemError(f"{where}: expected every element once, found element {own[0]} twice")
            if shape:
                self.elements[own[0]] = (shape, tuple(own[1:]))
            else:
                self.others.append(own[0])
            labels.append(read[0])
            read = []
        self.incompatible += len(labels) * kind.startswith("C3D8I")
        if read and shape:
            raise ProblemError(
                f"{card.data[-1][0]}: expected {count} nodes of an element, found {len(read) - 1}"
            )
        if "ELSET" in card.parameters and card.data:
            self.element_lists.setdefault(card.name("ELSET"), []).append(_Members(card.data[0][0], labels))

    def _surface(self, card: Card) -> None:
        name = card.name("NAME")
        if card.name("TYPE") == "NODE":
            _add(self.surface_nodes, name, card._replace(data=[(w, f[:1]) for w, f in card.data]))
            return
        for where, fields in card.data:
            side = re.fullmatch(r"S([1-6])", fields[1].upper() if len(fields) > 1 else "")
            if side:  # shells (SPOS, SNEG) have no faces here
                self.sides.setdefault(name, []).append((where, fields[0], int(side[1])))

    def _equations(self, data: list[Line]) -> None:
        read: list[str] = []
        count = 0
        for where, fields in data:
            own = [text for text in fields if text]
            if not count:
                count = integers(own[:1] or [""], where)[0]
                continue
            read += own
            if len(read) >= 3 * count:
                self.equations.append((where, read))
                read, count = [], 0

    def mesh(self) -> Mesh:
        """The mesh, with all sets resolved."""
        if not self.nodes:
            raise ProblemError(f"{self.name}: expected nodes (*NODE), found none")
        if self.revolved and self.flat:
            raise ProblemError(
                f"{self.name}: expected axisymmetric elements only, or none, found {quoted(self.revolved)} "
                f"and {quoted(self.flat)}"
            )
        for label in self.moved:
            self.nodes[label] = self.nodes[label] + self.shift
        labels = np.array(list(self.nodes), dtype=np.intp)
        element_sets = resolved(self.element_lists, np.array([*self.elements, *self.others], dtype=np.intp))
        node_sets = resolved(self.node_lists, labels)
        for name, elements in self.nodes_of_elements:
            node_sets[name] = np.union1d(node_sets[name], self._nodes_of(elements, element_sets))
        node_sets |= resolved(self.surface_nodes, labels, node_sets)
        rotated: dict[int, Orientation] = {}
        for card in self.rotated:
            name = card.name("NSET")
            if name not in node_sets:
                raise ProblemError(
                    f"{self.name}: expected the node set {quoted(name)} of *TRANSFORM, found none"
                )
            rotated |= dict.fromkeys(node_sets[name].tolist(), (card.parameters, card.data))
        surfaces, unusable = {}, {}
        for name, sides in self.sides.items():
            try:
                surfaces[name] = self._faces(sides, element_sets)
            except ProblemError as error:  # it matters only if somebody asks for it
                unusable[name] = str(error)
        return Mesh(
            self.name,
            labels,
            np.array(list(self.nodes.values())),
            node_sets,
            surfaces,
            self.elements,
            rotated,
            relative_displacements(self.equations, node_sets),
            bool(self.revolved),
            self.matrix_by,
            self.systems,
            tuple(self.young) if all(value > 0 for value in self.young) else (),
            tuple(self._section(name, node_sets) for name in self.sections),
            self.incompatible,
            unusable,
            element_sets,
            self.spelled,
        )

    def _section(self, name: str, node_sets: Sets) -> int:
        """The node of a ``*PRE-TENSION SECTION``, which may be a set of one."""
        own = node_sets.get(name)
        if name.isdigit() or own is None:
            return integers([name], f"{self.name}: *PRE-TENSION SECTION: NODE")[0]
        if len(own) != 1:
            raise ProblemError(
                f"{self.name}: *PRE-TENSION SECTION: expected one node in the set {quoted(name)}, found "
                f"{len(own)}"
            )
        return int(own[0])

    def _nodes_of(self, name: str, element_sets: Sets) -> list[int]:
        """Nodes of the elements of a set (``*NSET, ELSET=``)."""
        if name not in element_sets:
            raise ProblemError(f"{self.name}: expected the element set {quoted(name)} of *NSET, found none")
        members = element_sets[name].tolist()
        return [node for element in members if element in self.elements for node in self.elements[element][1]]

    def _faces(self, sides: list[tuple[str, str, int]], element_sets: Sets) -> tuple[tuple[int, int], ...]:
        faces = []
        for where, name, side in sides:
            named = name.upper() in element_sets and not _is_label(name, self.elements)
            for element in element_sets[name.upper()].tolist() if named else integers([name], where):
                if side > len(FACES.get(self.elements.get(element, ("", ()))[0], ())):
                    raise ProblemError(
                        f"{where}: expected a face of element {element}, found none of number {side}"
                    )
                faces.append((element, side))
        return tuple(faces)


def _is_label(text: str, known: Mapping[int, object]) -> bool:
    """Whether a text is the label of what there is; CalculiX takes a number for one beside such a set."""
    return text.isascii() and text.isdigit() and int(text[:18]) in known


def _add(lists: dict[str, list[_Members]], name: str, card: Card) -> None:
    """Append the members on the data lines of a card to a list."""
    generate = "GENERATE" in card.parameters
    own = lists.setdefault(name, [])
    own += [_Members(where, [text for text in fields if text], generate) for where, fields in card.data]


def resolved(lists: Mapping[str, list[_Members]], known: Labels, others: Sets | None = None) -> Sets:
    """Members of every set; a set may name earlier ones."""
    found: Sets = dict(others or {})
    there = dict.fromkeys(known.tolist())
    for name, entries in lists.items():
        members: list[int] = []
        for where, fields, generate in entries:
            if generate:
                members += _generated(fields, known, where)
                continue
            for text in fields:
                own = text.split(".")[-1]  # 'instance.label'
                if text.upper() in found and not _is_label(text, there):
                    members += found[text.upper()].tolist()
                elif not own.isdigit():
                    raise ProblemError(
                        f"{where}: expected labels or earlier sets as members of {quoted(name)}, found "
                        f"{quoted(text)}"
                    )
                elif (label := integers([own], where)[0]) not in there:
                    raise ProblemError(
                        f"{where}: expected a member of {quoted(name)}, found {label}, which is none"
                    )
                else:
                    members.append(label)
        found[name] = np.array(members, dtype=np.intp)
    return found


def _generated(fields: list[str], known: Labels, where: str) -> list[int]:
    """The existing labels among those that 'first, last, step' stands for."""
    first, last, stride = [*integers(fields[:3], where), 1][:3] if len(fields) > 1 else (0, -1, 1)
    if stride < 1 or last < first:
        raise ProblemError(
            f"{where}: expected 'first, last, step' of a set, found {quoted(','.join(fields))}"
        )
    inside = known[(known >= first) & (known <= last) & ((known - first) % stride == 0)]
    return [int(label) for label in np.sort(inside)]


def relative_displacements(
    equations: list[Line], node_sets: Mapping[str, Labels]
) -> dict[tuple[int, int], tuple[int, int]]:
    """Which two nodes an equation of three terms subtracts, by (node, direction) of the result."""
    relative: dict[tuple[int, int], tuple[int, int]] = {}
    for where, fields in equations:
        found = [_term(fields[k : k + 3], where, node_sets) for k in range(0, len(fields), 3)]
        terms = [term for term in found if term is not None]
        if len(found) != 3 or len(terms) != 3 or len({direction for _, direction, _ in terms}) != 1:
            continue
        for k, (node, direction, factor) in enumerate(terms):
            others = terms[:k] + terms[k + 1 :]
            minus = [own for own, _, weight in others if weight == factor]
            plus = [own for own, _, weight in others if weight == -factor]
            if len(minus) == len(plus) == 1:
                relative[node, direction] = (plus[0], minus[0])
    return relative


def _term(fields: list[str], where: str, node_sets: Mapping[str, Labels]) -> tuple[int, int, float] | None:
    """Node, direction and factor of one term; None for a term of several nodes."""
    name = fields[0].split(".")[-1]
    own = None if name.isdigit() else node_sets.get(name.upper())
    if len(fields) != 3 or (own is None and not name.isdigit()) or (own is not None and len(own) != 1):
        return None
    node = integers([name], where)[0] if own is None else int(own[0])
    return node, integers(fields[1:2], where)[0], number(fields[2], where)
