"""Input decks of Abaqus and CalculiX: nodes, sets, elements, surfaces and equations."""

import os
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.models.readers.deck_sets import Members, relative_displacements, resolved
from shakedown.models.readers.mesh import ABAQUS, CALCULIX, Element, Mesh, Orientation
from shakedown.models.readers.text import integers, number, quoted, read_lines

_SHAPES = {
    ("solid", 4): ("tetrahedron", 4),
    ("solid", 10): ("tetrahedron", 10),
    ("solid", 6): ("wedge", 6),
    ("solid", 15): ("wedge", 15),
    ("solid", 8): ("hexahedron", 8),
    ("solid", 20): ("hexahedron", 20),
    ("plane", 3): ("triangle", 3),
    ("plane", 6): ("triangle", 6),
    ("plane", 4): ("quadrilateral", 4),
    ("plane", 8): ("quadrilateral", 8),
}
_TYPE = re.compile(r"(C3D|CPEG|CPE|CPS|CGAX|CAX)(\d+)")
_REVOLVED = re.compile(r"(CG?|S|MG?|R|SFMG?)AX\d")  # element types of bodies of revolution
_OPENING = re.compile(r"\s*\*(NODE\s*(,|$)|INCLUDE\s*,|HEADING)", re.IGNORECASE)
_DEEPEST = 8  # depth to which files may include each other
_TAKEN = ("NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "EQUATION")
_MAKERS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")  # make nodes and elements of others

_Card = tuple[str, dict[str, str], list[tuple[str, str]]]  # keyword, parameters, (where, line) of its data


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
    for keyword, parameters, data in _cards(Path(path), 0):
        deck.take(keyword, parameters, data)
    return deck.mesh()


def _cards(path: Path, depth: int) -> Iterator[_Card]:
    if depth > _DEEPEST:
        raise ProblemError(f"{path}: expected *INCLUDE at most {_DEEPEST} deep, found more")
    card: _Card | None = None
    pending = ""
    for k, line in enumerate(read_lines(path), start=1):
        text = line.strip()
        if not text or text.startswith("**"):
            continue
        if text.startswith("*") or pending:
            pending += text
            if text.endswith(","):  # the parameters go on in the next line
                continue
            if card is not None:
                yield card
            card, pending = _keyword(pending), ""
            name = card[1].get("INPUT", "")
            if card[0] == "INCLUDE":
                if not name:
                    raise ProblemError(f"{path}: line {k}: expected *INCLUDE, INPUT=file, found none")
                yield from _cards(path.parent / name, depth + 1)
                card = None
            elif name and card[0] in _TAKEN:  # its data lines stand in a file of their own
                card[2].extend(_data_lines(path.parent / name))
        elif card is not None:
            card[2].append((f"{path}: line {k}", text))
    if card is not None:
        yield card


def _data_lines(path: Path) -> Iterator[tuple[str, str]]:
    """(where, line) of the data in the file of ``*NODE, INPUT=file`` and the like."""
    for k, line in enumerate(read_lines(path), start=1):
        if (text := line.strip()) and not text.startswith("*"):
            yield f"{path}: line {k}", text


def _keyword(line: str) -> _Card:
    head, *rest = line[1:].split(",")
    pairs = (part.partition("=") for part in rest if part.strip())
    parameters = {key.strip().upper(): value.strip().strip('"') for key, _, value in pairs}
    return " ".join(head.upper().split()), parameters, []


@dataclass
class _Deck:
    """What has been read so far; sets are resolved at the end, when all nodes are known."""

    name: str
    nodes: dict[int, FloatArray] = field(default_factory=dict)
    elements: dict[int, Element] = field(default_factory=dict)
    revolved: str = ""  # an axisymmetric element type that occurs
    flat: str = ""  # another plane or solid type that occurs
    matrix_by: str = ""
    young: list[float] = field(default_factory=list)  # 0 for a material that is not isotropic
    systems: dict[str, Orientation] = field(default_factory=dict)
    element_labels: list[int] = field(default_factory=list)  # of elements of every kind
    node_lists: dict[str, list[Members]] = field(default_factory=dict)
    nodes_of_elements: list[tuple[str, str]] = field(default_factory=list)  # (node set, element set)
    element_lists: dict[str, list[Members]] = field(default_factory=dict)
    sides: dict[str, list[tuple[str, str, int]]] = field(default_factory=dict)
    surface_nodes: dict[str, list[Members]] = field(default_factory=dict)
    sections: list[int] = field(default_factory=list)
    incompatible: int = 0  # how many elements C3D8I
    rotated: list[tuple[str, str, Orientation]] = field(default_factory=list)
    equations: list[tuple[str, list[str]]] = field(default_factory=list)
    parts: int = 0
    instances: int = 0
    shift: FloatArray = field(default_factory=lambda: np.zeros(3))

    def take(self, keyword: str, parameters: dict[str, str], data: list[tuple[str, str]]) -> None:
        """Take one keyword with its data lines; those that say nothing about the mesh are passed over."""
        match keyword:
            case "NODE":
                self._nodes(parameters, data)
            case "ELEMENT":
                self._elements(parameters, data)
            case "NSET":
                self._members(self.node_lists, parameters, "NSET", data)
                if "ELSET" in parameters:
                    self.nodes_of_elements.append(
                        (parameters.get("NSET", "").upper(), parameters["ELSET"].upper())
                    )
            case "ELSET":
                self._members(self.element_lists, parameters, "ELSET", data)
            case "SURFACE":
                self._surface(parameters, data)
            case "TRANSFORM":
                self.rotated.append((parameters.get("NSET", ""), self.name, (parameters, data)))
            case "ORIENTATION":
                self.systems[parameters.get("NAME", "").upper()] = (parameters, data)
            case "EQUATION":
                self._equation(data)
            case "PRE-TENSION SECTION":
                self.sections.append(
                    integers([parameters.get("NODE", "")], f"{self.name}: *{keyword}: NODE")[0]
                )
            case "ELASTIC" if data:
                isotropic = parameters.get("TYPE", "ISO").upper().startswith("ISO")
                self.young.append(number(data[0][1].split(",")[0], data[0][0]) if isotropic else 0.0)
            case "INSTANCE":
                self._instance(data)
            case "PART":
                self.parts += 1
                self._check_one(self.parts)
            case "SYSTEM" if data:
                raise ProblemError(
                    f"{data[0][0]}: expected coordinates x, y, z, found *SYSTEM; write a flat deck"
                )
            case _ if keyword in _MAKERS:
                raise ProblemError(
                    f"{self.name}: expected every node and element to be listed, found *{keyword}, which "
                    "makes some; let the code write a flat deck"
                )
            case "MATRIX GENERATE" | "MATRIX OUTPUT":
                self.matrix_by = ABAQUS
            case _ if parameters.get("SOLVER", "").upper() == "MATRIXSTORAGE":  # of *FREQUENCY or *STATIC
                self.matrix_by = CALCULIX

    def _instance(self, data: list[tuple[str, str]]) -> None:
        self.instances += 1
        self._check_one(self.instances)
        if len(data) > 1:
            raise ProblemError(f"{data[1][0]}: expected an instance that is moved only, found it turned")
        if data:
            self.shift = np.array([number(field, data[0][0]) for field in data[0][1].split(",")[:3]])

    def _check_one(self, count: int) -> None:
        if count > 1:
            raise ProblemError(
                f"{self.name}: expected one part instance, found several, whose labels are not those of the "
                "matrix; write a flat deck (*PREPRINT, or no parts and assemblies)"
            )

    def _nodes(self, parameters: dict[str, str], data: list[tuple[str, str]]) -> None:
        labels = []
        system = parameters.get("SYSTEM", "R").upper()
        if system not in ("R", "C") and data:
            raise ProblemError(
                f"{data[0][0]}: expected coordinates of SYSTEM=R or C, found {quoted(system)}; write x, y, z"
            )
        for where, text in data:
            fields = [field.strip() for field in text.split(",")]
            label = integers(fields[:1], where)[0]
            if label in self.nodes:
                raise ProblemError(f"{where}: expected every node once, found node {label} twice")
            point = [number(field, where) for field in fields[1:4] if field]
            if system == "C":
                radius, angle, height = [*point, 0.0, 0.0, 0.0][:3]
                point = [radius * np.cos(np.radians(angle)), radius * np.sin(np.radians(angle)), height]
            self.nodes[label] = np.array([*point, 0.0, 0.0, 0.0][:3]) + self.shift
            labels.append(fields[0])
        if "NSET" in parameters and data:
            self.node_lists.setdefault(parameters["NSET"].upper(), []).append((data[0][0], labels, False))

    def _elements(self, parameters: dict[str, str], data: list[tuple[str, str]]) -> None:
        element_type = parameters.get("TYPE", "").upper()
        match = _TYPE.match(element_type)
        kind = ("solid" if match[1] == "C3D" else "plane", int(match[2][:3])) if match else ("other", 0)
        shape, count = _SHAPES.get(kind, ("", 0))
        if _REVOLVED.match(element_type):
            self.revolved = element_type
        elif match:
            self.flat = element_type
        labels: list[str] = []
        fields: list[str] = []
        for where, text in data:
            fields += [field.strip() for field in text.split(",") if field.strip()]
            if text.endswith(",") or len(fields) < count + 1:
                continue
            if shape:
                own = integers(fields, where)
                if len(own) != count + 1:
                    raise ProblemError(f"{where}: expected {count} nodes of an element, found {len(own) - 1}")
                if own[0] in self.elements:
                    raise ProblemError(f"{where}: expected every element once, found element {own[0]} twice")
                self.elements[own[0]] = (shape, tuple(own[1:]))
            labels.append(fields[0])
            self.element_labels += integers(fields[:1], where)
            fields = []
        self.incompatible += len(labels) * element_type.startswith("C3D8I")
        if fields and shape:
            raise ProblemError(
                f"{data[-1][0]}: expected {count} nodes of an element, found {len(fields) - 1}"
            )
        if "ELSET" in parameters and data:
            self.element_lists.setdefault(parameters["ELSET"].upper(), []).append((data[0][0], labels, False))

    def _members(
        self,
        lists: dict[str, list[Members]],
        parameters: dict[str, str],
        key: str,
        data: list[tuple[str, str]],
    ) -> None:
        own = lists.setdefault(parameters.get(key, "").upper(), [])
        for where, text in data:
            fields = [field.strip() for field in text.split(",") if field.strip()]
            own.append((where, fields, "GENERATE" in parameters))

    def _surface(self, parameters: dict[str, str], data: list[tuple[str, str]]) -> None:
        name = parameters.get("NAME", "").upper()
        if parameters.get("TYPE", "ELEMENT").upper() == "NODE":
            self._members(self.surface_nodes, {"NSET": name}, "NSET", [(w, t.split(",")[0]) for w, t in data])
            return
        for where, text in data:
            fields = [field.strip() for field in text.split(",")]
            side = re.fullmatch(r"S([1-6])", fields[1].upper() if len(fields) > 1 else "")
            if side:  # shells (SPOS, SNEG) have no faces here
                self.sides.setdefault(name, []).append((where, fields[0], int(side[1])))

    def _equation(self, data: list[tuple[str, str]]) -> None:
        fields: list[str] = []
        count = 0
        for where, text in data:
            parts = [part.strip() for part in text.split(",") if part.strip()]
            if not count:
                count = integers(parts[:1], where)[0]
                continue
            fields += parts
            if len(fields) >= 3 * count:
                self.equations.append((where, fields))
                fields, count = [], 0

    def mesh(self) -> Mesh:
        """The mesh, with all sets resolved."""
        if not self.nodes:
            raise ProblemError(f"{self.name}: expected nodes (*NODE), found none")
        if self.revolved and self.flat:
            raise ProblemError(
                f"{self.name}: expected axisymmetric elements only, or none, found {quoted(self.revolved)} "
                f"and {quoted(self.flat)}"
            )
        labels = np.array(list(self.nodes), dtype=np.intp)
        element_sets = resolved(self.element_lists, np.array(self.element_labels, dtype=np.intp))
        node_sets = resolved(self.node_lists, labels)
        for name, elements in self.nodes_of_elements:
            node_sets[name] = np.union1d(node_sets[name], self._nodes_of(elements, element_sets))
        node_sets |= resolved(self.surface_nodes, labels, node_sets)
        rotated: dict[int, Orientation] = {}
        for name, where, system in self.rotated:
            if name.upper() not in node_sets:
                raise ProblemError(f"{where}: expected the node set {quoted(name)} of *TRANSFORM, found none")
            rotated |= dict.fromkeys(node_sets[name.upper()].tolist(), system)
        return Mesh(
            self.name,
            labels,
            np.array(list(self.nodes.values())),
            node_sets,
            {name: self._faces(sides, element_sets) for name, sides in self.sides.items()},
            self.elements,
            rotated,
            relative_displacements(self.equations, node_sets),
            bool(self.revolved),
            self.matrix_by,
            self.systems,
            tuple(self.young) if all(value > 0 for value in self.young) else (),
            tuple(self.sections),
            self.incompatible,
        )

    def _nodes_of(self, name: str, element_sets: dict[str, NDArray[np.intp]]) -> list[int]:
        """Nodes of the elements of a set (``*NSET, ELSET=``)."""
        if name not in element_sets:
            raise ProblemError(f"{self.name}: expected the element set {quoted(name)} of *NSET, found none")
        members = element_sets[name].tolist()
        return [node for element in members if element in self.elements for node in self.elements[element][1]]

    def _faces(
        self, sides: list[tuple[str, str, int]], element_sets: dict[str, NDArray[np.intp]]
    ) -> tuple[tuple[int, int], ...]:
        faces = []
        for where, name, side in sides:
            if name.upper() in element_sets:
                members = element_sets[name.upper()].tolist()
            else:
                members = integers([name], where)
            for element in members:
                shape = self.elements.get(element, ("", ()))[0]
                most = {"triangle": 3, "quadrilateral": 4, "tetrahedron": 4, "wedge": 5, "hexahedron": 6}
                if side > most.get(shape, 0):
                    raise ProblemError(
                        f"{where}: expected a face of element {element}, found none of number {side}"
                    )
                faces.append((element, side))
        return tuple(faces)
