"""Ansys archives (``CDWRITE``, ``.cdb``): nodes and components of nodes."""

import os
import re

import numpy as np

from shakedown.models.readers.formats import OF_MODEL, Format, has
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.text import integers, number, quoted, read_lines, unfit

_BLOCK = re.compile(r"(NBLOCK|CMBLOCK)\s*,\s*([^,]*)(?:,\s*([A-Z]*))?", re.IGNORECASE)
_LAYOUT = re.compile(r"\((\d{1,2})i(\d{1,2})(?:,(\d{1,2})[eg](\d{1,2}))?", re.IGNORECASE)
_MOST = 10_000_000  # nodes of a component


def read_ansys_archive(path: str | os.PathLike[str]) -> Mesh:
    """Read the nodes of an archive, with its components of nodes as sets; elements are passed over.

    Raises
    ------
    ProblemError
        If a line is malformed, a node is there twice, or a component names nodes that are none.
    """
    name, lines = os.fspath(path), read_lines(path)
    labels: list[int] = []
    places: list[list[float]] = []
    sets: dict[str, list[int]] = {}
    for k, line in enumerate(lines):
        if (block := _BLOCK.match(line)) is None:
            continue
        layout = _LAYOUT.match(lines[k + 1].replace(" ", "")) if k + 1 < len(lines) else None
        if layout is None:
            raise unfit(f"{name}: line {k + 2}", "a layout like (3i9,6e21.13e3)", "none")
        count, width = int(layout[1]), int(layout[2])
        start, each = count * width, int(layout[4] or 0)
        members = sets.setdefault(block[2].strip().upper(), [])
        for number_of, text in enumerate(lines[k + 2 :], start=k + 3):
            where = f"{name}: line {number_of}"
            if text[:1] not in " 0123456789":  # the next command
                break
            if block[1].upper() == "NBLOCK":
                labels += integers([text[:width]], where)
                fields = [text[start + each * i : start + each * (i + 1)].strip() for i in range(3)]
                places.append([number(field, where) if field else 0.0 for field in fields])
            elif (block[3] or "").upper() == "NODE":
                members += integers(re.findall(rf".{{1,{max(width, 1)}}}", text.rstrip()), where)
    found = Mesh.of_nodes(np.array(labels, dtype=np.intp), np.array(places).reshape(-1, 3), name)
    known = set(labels)
    for key, members in sets.items():
        if members:
            found.node_sets[key] = _component(members, known, f"{name}: component {quoted(key)}")
    return found


def _component(members: list[int], known: set[int], where: str) -> np.ndarray:
    """The nodes of a component; a negative number ends a range that the number before it begins."""
    nodes: list[int] = []
    for member in members:
        first = nodes[-1] + 1 if nodes else 0
        if member < 0 and not 0 <= -member - first < _MOST:
            raise unfit(where, f"the end of a range after {first - 1}", member)
        nodes += range(first, 1 - member) if member < 0 else [member]
    absent = [node for node in nodes if node not in known]
    if absent:
        raise unfit(where, "nodes", f"{absent[0]}, which is none")
    return np.array(nodes, dtype=np.intp)


_NODES = re.compile("NBLOCK", re.IGNORECASE)
_TITLE = f"an archive of Ansys {OF_MODEL}"
FORMATS = (Format("archive", _TITLE, {"mesh": read_ansys_archive}, contains=has(_NODES)),)
