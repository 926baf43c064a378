"""CalculiX as a peer: decks are run, and what they print of a contact is read."""

import os
import shutil
import subprocess
from collections.abc import Iterable
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from shakedown.ground.constants import FloatArray

PROGRAM = "ccx"
ABSENT = "CalculiX is left out: there is no program ccx (Debian package calculix-ccx)"
PRINTED = {"relative contact displacement": "motion", "contact stress": "stress"}
_COORDINATE = 12  # characters of a number in the result file


@cache
def is_here() -> bool:
    return shutil.which(PROGRAM) is not None


def run(folder: Path, name: str, deck: Iterable[str]) -> None:
    """Write a deck into a folder and run it there; an error of CalculiX is raised with its last lines."""
    (folder / f"{name}.inp").write_text("\n".join(deck) + "\n")
    alone = os.environ | {"OMP_NUM_THREADS": "1"}  # contact of type MORTAR may hang with several threads
    done = subprocess.run([PROGRAM, name], cwd=folder, env=alone, capture_output=True, text=True, check=False)
    if done.returncode != 0 or "*ERROR" in done.stdout:
        said = " / ".join(line.strip() for line in done.stdout.splitlines() if line.strip())
        raise RuntimeError(f"{name}.inp: ccx ended with {done.returncode}: … {said[-400:]}")


class Printed(NamedTuple):
    """What CalculiX prints at the end of every step, at given places of the contact."""

    motion: FloatArray  # (s, k, 3): relative displacement, normal and in two tangential directions [length]
    stress: FloatArray  # (s, k, 3): contact pressure and two shear stresses [force / length²]


def printed(folder: Path, name: str, places: FloatArray) -> Printed:
    """The contact tables of a run at places (k, 2) in the plane.

    A plane node is two nodes of the solid that CalculiX makes of it: their mean is taken. A
    node that has left the contact is not printed, and an error here.
    """
    solid = _solid_nodes(folder / f"{name}.frd")
    tables: dict[str, list[FloatArray]] = {what: [] for what in PRINTED.values()}
    for what, rows in _tables(folder / f"{name}.dat"):
        values = np.full((len(places), 2, 3), np.nan)
        for node, row in rows.items():
            place = int(np.abs(places - solid[node][:2]).sum(axis=1).argmin())
            values[place, int(solid[node][2] > 0)] = row
        tables[what].append(values.mean(axis=1))
    found = Printed(*(np.array(tables[what]) for what in ("motion", "stress")))
    if not (np.isfinite(found.motion).all() and np.isfinite(found.stress).all()):
        raise RuntimeError(f"{name}.dat: expected every contact node in contact, found some open")
    return found


def pressures(path: Path) -> list[dict[int, float]]:
    """The contact pressure of every node that is printed, for each step of a ``.dat`` file."""
    return [{node: row[0] for node, row in rows.items()} for what, rows in _tables(path) if what == "stress"]


def _solid_nodes(path: Path) -> dict[int, FloatArray]:
    """Coordinates of the nodes of the solid, from a result file."""
    nodes = {}
    with path.open() as file:
        for line in file:
            if line.startswith(" -1"):
                ends = [13 + _COORDINATE * k for k in range(4)]
                nodes[int(line[3:13])] = np.array([float(line[a:b]) for a, b in pairwise(ends)])
            elif line.startswith(" -3"):
                break
    return nodes


def _tables(path: Path) -> list[tuple[str, dict[int, list[float]]]]:
    """The contact tables of a ``.dat`` file in their order: what, {node of the solid: three numbers}."""
    tables: list[tuple[str, dict[int, list[float]]]] = []
    reading = False
    for line in path.read_text().splitlines():
        heading = next((what for words, what in PRINTED.items() if line.strip().startswith(words)), None)
        fields = line.split()
        if heading is not None:
            tables.append((heading, {}))
            reading = True
        elif fields and not fields[0].isdigit():  # another kind of table begins
            reading = False
        elif len(fields) == 4 and reading:
            tables[-1][1][int(fields[0])] = [float(field) for field in fields[1:]]
    return tables
