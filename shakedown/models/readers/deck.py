"""Input decks of Abaqus and CalculiX: nodes, sets, elements, surfaces and equations."""

import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import FloatArray, IntArray
from shakedown.ground.errors import ProblemError
from shakedown.models.readers.formats import Format, has
from shakedown.models.readers.mapped_matrices import implied_rows
from shakedown.models.readers.mesh import ABAQUS, CALCULIX, FACES, Element, Line, Mesh, Orientation, axes_at
from shakedown.models.readers.parsing import integers, listed, number, quoted, read_lines, unfit

_TYPE = re.compile(r"(C3D|CPEG|CPE|CPS|CGAX|CAX)(\d{1,3})")
# shapes by the count of nodes; others have no faces here
_SOLID = {4: "tetrahedron", 10: "tetrahedron", 6: "wedge", 15: "wedge", 8: "hexahedron", 20: "hexahedron"}
_FLAT = {3: "triangle", 6: "triangle", 4: "quadrilateral", 8: "quadrilateral"}
_REVOLVED = re.compile(r"(CG?|S|MG?|R|SFMG?)AX\d")  # element types of bodies of revolution
_OPENING = re.compile(r"\s*\*(NODE\s*(,|$)|INCLUDE\s*,|HEADING)", re.IGNORECASE)
_INCLUDE = re.compile(r"\*INCLUDE\s*(?:,\s*INPUT\s*=\s*\"?([^\",]+))?", re.IGNORECASE)
_IN_A_FILE = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "EQUATION")  # may stand in a file of their own
_READ = (*_IN_A_FILE, "TRANSFORM", "ELASTIC", "PART", "INSTANCE", "SYSTEM")  # whose lines count

Labels = IntArray
Sets = dict[str, Labels]
Members = tuple[str, list[str], bool]  # of a set: where they are said, and whether they are first, last, step


class Card(NamedTuple):
    """A keyword with its parameters and data lines."""

    keyword: str
    parameters: dict[str, str]
    data: list[Line]

    def name(self, key: str) -> str:
        """A parameter that names a set, in upper case; "" where there is none."""
        return self.parameters.get(key, "").upper()


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
    return _Deck(os.fspath(path), list(_Text().cards(Path(path)))).mesh()


@dataclass
class _Text:
    """The text of a deck with the files that it includes, of which there are not too many."""

    files: int = 0
    lines: int = 0

    def cards(self, path: Path) -> Iterator[Card]:
        """Every keyword with its data lines, which may stand in a file of their own (INPUT=)."""
        card = Card("", {}, [])
        for where, text in self.of(path):
            if not text.startswith("*"):
                if card.keyword in _READ:
                    card.data.append((where, _fields(text)))
                continue
            yield card
            head, *rest = text[1:].split(",")
            pairs = (part.partition("=") for part in rest if part.strip())
            parameters = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
            card = Card(" ".join(head.upper().split()), parameters, [])
            if card.keyword in _IN_A_FILE and (beside := parameters.get("INPUT")):
                own = self.of(path.parent / beside)
                card.data.extend((place, _fields(line)) for place, line in own if not line.startswith("*"))
        yield card

    def of(self, path: Path, depth: int = 0) -> Iterator[tuple[str, str]]:
        """(where, line) without remarks and blank lines; keywords on one line, included files in place."""
        lines = read_lines(path)
        self.files, self.lines = self.files + 1, self.lines + len(lines)
        if depth > 8 or self.files > 1000 or self.lines > 1 << 24:
            raise unfit(path, f"*INCLUDE at most 8 deep, of 1000 files and {1 << 24} lines in all", "more")
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
                    raise unfit(f"{path}: line {k}", "*INCLUDE, INPUT=file", "none")
                yield from self.of(path.parent / found[1].strip(), depth + 1)
            else:
                yield f"{path}: line {k}", text


def _fields(text: str) -> list[str]:
    return [part.strip() for part in text.split(",")]


def _point(fields: list[str], where: str) -> FloatArray:
    """Three numbers, those that are blank or missing 0."""
    return np.array([*(number(text, where) if text else 0.0 for text in fields[:3]), 0.0, 0.0, 0.0][:3])


class _Deck:
    """The keywords of a deck."""

    def __init__(self, name: str, cards: list[Card]) -> None:
        self.name, self.cards = name, cards
        for card in cards:
            if card.keyword in ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY"):
                raise ProblemError(
                    f"{name}: expected every node and element to be listed, found *{card.keyword}, which "
                    "makes some; let the code write a flat deck"
                )

    def of(self, *keywords: str) -> list[Card]:
        """The cards of some keywords."""
        return [card for card in self.cards if card.keyword in keywords]

    def mesh(self) -> Mesh:
        """The mesh, with all sets resolved when the nodes and elements are known."""
        nodes, made = self._nodes()
        if not nodes:
            raise unfit(self.name, "nodes (*NODE)", "none")
        elements, own = self._elements()
        labels = np.array(list(nodes), dtype=np.intp)
        known = np.array(list(chain(*own.values())), dtype=np.intp)
        element_sets = resolved(self._lists("ELSET", own), known)
        node_sets = resolved(self._lists("NSET", made), labels)
        for card in self.of("NSET"):
            if "ELSET" in card.parameters:
                found = self._named(card.name("ELSET"), element_sets, "element set", "*NSET").tolist()
                more = [node for element in found if element in elements for node in elements[element][1]]
                node_sets[card.name("NSET")] = np.union1d(node_sets[card.name("NSET")], more).astype(np.intp)
        of_nodes: dict[str, list[Members]] = {}
        for card in self.of("SURFACE"):
            if card.name("TYPE") == "NODE":
                of_nodes.setdefault(card.name("NAME"), []).extend(_members(card, 1))
        node_sets |= resolved(of_nodes, labels, node_sets)
        rotated: dict[int, Orientation] = {}
        for card in self.of("TRANSFORM"):
            turned = self._named(card.name("NSET"), node_sets, "node set", "*TRANSFORM")
            rotated |= dict.fromkeys(turned.tolist(), (card.parameters, card.data))
        surfaces, unusable = self._surfaces(elements, element_sets)
        young = [self._young(card) for card in self.of("ELASTIC") if card.data]
        return Mesh(
            self.name,
            labels,
            np.array(list(nodes.values())),
            node_sets,
            surfaces,
            elements,
            rotated=rotated,
            equations=bool(self.of("EQUATION")),
            axisymmetric=self._axisymmetric(),
            matrix_by=self._matrix_by(),
            young=tuple(young) if all(young) else (),
            sections=tuple(self._section(card, node_sets) for card in self.of("PRE-TENSION SECTION")),
            incompatible=sum(len(own[k]) for k in own if self.cards[k].name("TYPE").startswith("C3D8I")),
            unusable=unusable,
            element_sets=element_sets,
            spelled={
                card.name(key): card.parameters[key]
                for card in reversed(self.cards)
                for key in ("NSET", "ELSET", "NAME")
                if key in card.parameters
            },
        )

    def _named(self, name: str, sets: Sets, what: str, by: str) -> Labels:
        if name not in sets:
            raise unfit(self.name, f"the {what} {quoted(name)} of {by}", "none")
        return sets[name]

    def _lists(self, key: str, made: Mapping[int, list[int]]) -> dict[str, list[Members]]:
        """Members of the sets of a keyword, and of those that the nodes and elements of a card make up."""
        found: dict[str, list[Members]] = {}
        for k, card in enumerate(self.cards):
            if card.keyword == key:
                found.setdefault(card.name(key), []).extend(_members(card))
            elif made.get(k) and key in card.parameters:
                labels = card.data[0][0], [str(label) for label in made[k]], False
                found.setdefault(card.name(key), []).append(labels)
        return found

    def _nodes(self) -> tuple[dict[int, FloatArray], dict[int, list[int]]]:
        """Where every node is, those of a part moved with its instance; and the labels of every card."""
        nodes: dict[int, FloatArray] = {}
        made: dict[int, list[int]] = {}
        shift, inside = self._shift()
        origin, axes = np.zeros(3), np.eye(3)
        for k, card in enumerate(self.cards):
            if card.keyword == "SYSTEM":
                origin, axes = self._system(card)
            if card.keyword != "NODE":
                continue
            made[k], system = [], card.name("SYSTEM") or "R"
            if system not in ("R", "C") and card.data:
                raise unfit(
                    card.data[0][0], "coordinates of SYSTEM=R or C", f"{quoted(system)}; write x, y, z"
                )
            for where, fields in card.data:
                label = integers(fields[:1], where)[0]
                if label in nodes:
                    raise unfit(where, "every node once", f"node {label} twice")
                point = _point(fields[1:], where)
                if system == "C":
                    angle = np.radians(point[1])
                    point = np.array([point[0] * np.cos(angle), point[0] * np.sin(angle), point[2]])
                nodes[label] = origin + point @ axes + (shift if k in inside else 0.0)
                made[k].append(label)
        return nodes, made

    @staticmethod
    def _system(card: Card) -> tuple[FloatArray, FloatArray]:
        """Origin and axes behind ``*SYSTEM``: a point, one on the new x, one in the plane of the new x, y."""
        lines = [(where, fields[k : k + 3]) for where, fields in card.data for k in (0, 3)]
        points = [_point(fields, where) for where, fields in lines if any(fields)]
        origin, *others = points or [np.zeros(3)]
        if not others:
            return origin, np.eye(3)
        first = others[0] - origin
        second = others[1] - origin if len(others) > 1 else np.cross([0.0, 0.0, 1.0], first)
        return origin, axes_at(origin[None], first, second, "R", f"{card.data[0][0]}: *SYSTEM")[0]

    def _shift(self) -> tuple[FloatArray, set[int]]:
        """What moves the part's nodes, and the places of the cards inside of the part and its instance."""
        shift, inside, within = np.zeros(3), set[int](), False
        if max(len(self.of("PART")), len(self.of("INSTANCE"))) > 1:
            raise ProblemError(
                f"{self.name}: expected one part instance, found several, whose labels are not those of "
                "the matrix; write a flat deck (*PREPRINT, or no parts and assemblies)"
            )
        for k, card in enumerate(self.cards):
            within = card.keyword in ("PART", "INSTANCE") or (within and not card.keyword.startswith("END "))
            if within:
                inside.add(k)
            if card.keyword in ("PART", "INSTANCE") and any([*chain(*(own for _, own in card.data))][3:]):
                raise unfit(card.data[-1][0], "an instance that is moved only", "it turned")
            if card.keyword == "INSTANCE" and card.data:
                shift = _point(card.data[0][1], card.data[0][0])
        return shift, inside

    def _elements(self) -> tuple[dict[int, Element], dict[int, list[int]]]:
        """Every solid or plane element, and the labels of the elements of every card, whatever they are."""
        elements: dict[int, Element] = {}
        made: dict[int, list[int]] = {}
        for k, card in enumerate(self.cards):
            if card.keyword != "ELEMENT":
                continue
            match, made[k] = _TYPE.match(card.name("TYPE")), []
            count = int(match[2]) if match else 0
            shape = (_SOLID if match is not None and match[1] == "C3D" else _FLAT).get(count, "")
            read: list[str] = []
            for where, fields in card.data:
                read += [text for text in fields if text]
                if not read or (len(read) <= count if shape else not fields[-1]):
                    continue  # goes on in the next line
                label, *nodes = integers(read if shape else read[:1], where)
                if shape and len(nodes) != count:
                    raise unfit(where, f"{count} nodes of an element", len(nodes))
                if label in elements:
                    raise unfit(where, "every element once", f"element {label} twice")
                if shape:
                    elements[label] = (shape, tuple(nodes))
                made[k].append(label)
                read = []
            if read and shape:
                raise unfit(card.data[-1][0], f"{count} nodes of an element", len(read) - 1)
        return elements, made

    def _surfaces(
        self, elements: Mapping[int, Element], element_sets: Sets
    ) -> tuple[dict[str, tuple[tuple[int, int], ...]], dict[str, str]]:
        """The faces of every surface of faces, and why others are none, which matters if one is asked for."""
        sides: dict[str, list[tuple[str, str, int]]] = {}
        for card in self.of("SURFACE"):
            for where, fields in card.data if card.name("TYPE") != "NODE" else ():
                side = re.fullmatch(r"S([1-6])", fields[1].upper() if len(fields) > 1 else "")
                if side:  # shells (SPOS, SNEG) have no faces here
                    sides.setdefault(card.name("NAME"), []).append((where, fields[0], int(side[1])))
        surfaces: dict[str, tuple[tuple[int, int], ...]] = {}
        unusable: dict[str, str] = {}
        for name, own in sides.items():
            try:
                surfaces[name] = tuple(face for side in own for face in _faces(*side, elements, element_sets))
            except ProblemError as error:
                unusable[name] = str(error)
        return surfaces, unusable

    def _axisymmetric(self) -> bool:
        """Whether the elements are axisymmetric."""
        kinds = [card.name("TYPE") for card in self.of("ELEMENT")]
        revolved = {
            bool(_REVOLVED.match(kind)): kind for kind in kinds if _TYPE.match(kind) or _REVOLVED.match(kind)
        }
        if len(revolved) > 1:
            raise unfit(self.name, "axisymmetric elements only, or none", listed(revolved.values()))
        return True in revolved

    def _matrix_by(self) -> str:
        """The code that the last keyword for a matrix belongs to; SOLVER is one of *FREQUENCY or *STATIC."""
        writers = {"MATRIX GENERATE": ABAQUS, "MATRIX OUTPUT": ABAQUS}
        asked = [
            card for card in self.cards if card.keyword in writers or card.name("SOLVER") == "MATRIXSTORAGE"
        ]
        return next((writers.get(card.keyword, CALCULIX) for card in reversed(asked)), "")

    @staticmethod
    def _young(card: Card) -> float:
        """Young's modulus; 0 for a material that is not isotropic."""
        where, fields = card.data[0]
        isotropic = card.parameters.get("TYPE", "ISO").upper().startswith("ISO")
        return max(number(fields[0], where), 0.0) if isotropic else 0.0

    def _section(self, card: Card, node_sets: Sets) -> int:
        """The node of a ``*PRE-TENSION SECTION``, which may be a set of one."""
        name = card.name("NODE")
        own = node_sets.get(name)
        if name.isdigit() or own is None:
            return integers([name], f"{self.name}: *PRE-TENSION SECTION: NODE")[0]
        if len(own) != 1:
            raise unfit(f"{self.name}: *PRE-TENSION SECTION", f"one node in the set {quoted(name)}", len(own))
        return int(own[0])


def _members(card: Card, most: int | None = None) -> list[Members]:
    """The members on the data lines of a card, the first ``most`` of each line."""
    generate = "GENERATE" in card.parameters
    return [(where, [text for text in fields[:most] if text], generate) for where, fields in card.data]


def _faces(
    where: str, name: str, side: int, elements: Mapping[int, Element], element_sets: Sets
) -> Iterator[tuple[int, int]]:
    """(element, face) of a line of a surface."""
    named = name.upper() in element_sets and not _is_label(name, elements)
    for element in element_sets[name.upper()].tolist() if named else integers([name], where):
        if side > len(FACES.get(elements.get(element, ("", ()))[0], ())):
            raise unfit(where, f"a face of element {element}", f"none of number {side}")
        yield element, side


def _is_label(text: str, known: Mapping[int, object]) -> bool:
    """Whether a text is the label of what there is; CalculiX takes a number for one beside such a set."""
    return text.isascii() and text.isdigit() and int(text[:18]) in known


def resolved(lists: Mapping[str, list[Members]], known: Labels, others: Sets | None = None) -> Sets:
    """Members of every set; a set may name earlier ones."""
    found: Sets = dict(others or {})
    there = dict.fromkeys(known.tolist())
    for name, entries in lists.items():
        members: list[int] = []
        for where, fields, generate in entries:
            if generate:
                first, last, stride = [*integers(fields[:3], where), 1][:3] if len(fields) > 1 else (0, -1, 1)
                if stride < 1 or last < first:
                    raise unfit(where, "'first, last, step' of a set", quoted(",".join(fields)))
                inside = (known >= first) & (known <= last) & ((known - first) % stride == 0)
                members += np.sort(known[inside]).tolist()
                continue
            for text in fields:
                instance, _, own = text.rpartition(".")
                if text.upper() in found and not _is_label(text, there):
                    members += found[text.upper()].tolist()
                elif instance.isdigit() or not own.isdigit():  # 1.5 is no label
                    raise unfit(where, f"labels or earlier sets as members of {quoted(name)}", quoted(text))
                elif (label := integers([own], where)[0]) not in there:
                    raise unfit(where, f"a member of {quoted(name)}", f"{label}, which is none")
                else:
                    members.append(label)
        found[name] = np.array(members, dtype=np.intp)
    return found


def _rows(path: str | os.PathLike[str], size: int | None) -> Labels:
    """The map of a matrix that has the nodes of a deck in their order."""
    return implied_rows(read_deck(path).labels, size, os.fspath(path))


_TITLE = "an input deck (it may be the 'map' of a matrix, or the file of [model])"
FORMATS = (Format("deck", _TITLE, {"mesh": read_deck, "rows": _rows}, contains=has(_OPENING, "*")),)
