"""Joints in CalculiX: their matrices, of which problems are made, and cycles with contact and friction."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from benchmarks import calculix_peer
from benchmarks.calculix_joints import FRICTION, PERIOD, Joint, Values, joint
from shakedown import LoadCase, Problem
from shakedown.ground.constants import FloatArray
from shakedown.models.condensation.condense import condensed_stiffness
from shakedown.models.readers.formats import read_stiffness
from shakedown.models.readers.stiffness import Stiffness


class Modelled(NamedTuple):
    """The problem of a joint, and the sense of its slips: +1 along the axis of the contact, or −1, (n,)."""

    problem: Problem
    sense: FloatArray


@cache
def modelled(name: str) -> Modelled:
    """The joint with the matrix that CalculiX makes of its deck, for the toolkit."""
    made = joint(name)
    with TemporaryDirectory() as folder:
        stored = [*made.model, "*STEP", "*FREQUENCY, SOLVER=MATRIXSTORAGE", "*END STEP"]
        calculix_peer.run(Path(folder), "stored", stored)
        matrix = read_stiffness(Path(folder) / "stored.sti")
    K = made.wedges * matrix.K
    # what cools shrinks by the forces that would shrink it so if it were free
    assembly = _on_rows(matrix, made.forces) + K @ _on_rows(matrix, made.shrinkage)
    loads = [
        LoadCase(history=1.0, force=assembly, transient=[0.0, 1.0]),
        LoadCase(history=PERIOD, force=_on_rows(matrix, made.moved), transient=[0.0, 0.0]),
    ]
    reduced = condensed_stiffness(K, matrix.dofs, made.pairs, made.normals)
    problem = reduced.problem(loads, FRICTION, name=name, units="N, mm")
    return Modelled(problem, reduced.frame.tangents.sum(axis=1))  # the contact lies along x or y


def _on_rows(matrix: Stiffness, values: Values) -> FloatArray:
    total = np.zeros(len(matrix.dofs))
    total[matrix.rows(list(values))] = list(values.values())
    return total


class Followed(NamedTuple):
    """What CalculiX finds at the end of the assembly and of every quarter of every cycle."""

    slip: FloatArray  # (s, n): of the free body along the contact, without what the stick slope lets through
    pressure: FloatArray  # (s, n) [force / length²]


def follow(name: str, load_factor: float, slope: float, cycles: int) -> Followed:
    """The joint in CalculiX, with a penalty ``slope`` [force / length³] for gap and stick alike."""
    made = joint(name)
    with TemporaryDirectory() as folder:
        deck = [*made.model, *_contact(made, slope), *_steps(made, load_factor, cycles)]
        calculix_peer.run(Path(folder), "followed", deck)
        out = calculix_peer.printed(Path(folder), "followed", made.places)
    column, sense = made.tangent
    return Followed(sense * (out.motion[..., column] - out.stress[..., column] / slope), out.stress[..., 0])


def _contact(made: Joint, slope: float) -> Iterator[str]:
    """Node-to-surface penalty contact; the tension that it lets through is next to nothing."""
    for k, (slave, master) in enumerate(made.faces):
        yield from (f"*SURFACE, NAME=SLAVE{k}, TYPE=ELEMENT", *slave)
        yield from (f"*SURFACE, NAME=MASTER{k}, TYPE=ELEMENT", *master)
    yield from ("*SURFACE INTERACTION, NAME=TOUCH", "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR")
    yield from (f"{slope:.6g}, 1e-6, 1e-3", "*FRICTION", f"{FRICTION}, {slope:.6g}")
    yield "*CONTACT PAIR, INTERACTION=TOUCH, TYPE=NODE TO SURFACE, SMALL SLIDING"
    yield from (f"SLAVE{k}, MASTER{k}" for k in range(len(made.faces)))


def _steps(made: Joint, load_factor: float, cycles: int) -> Iterator[str]:
    """The assembly, then a step per quarter cycle; its first increment is small, else Newton goes round."""
    controls = (
        "*CONTROLS, PARAMETERS=FIELD", "1e-6, 1.",
        "*CONTROLS, PARAMETERS=TIME INCREMENTATION",
        "20, 40, 9, 60, 10, 4, , 20, , ", "0.1, 0.1, 0.1, 0.85, , , 10., ",
    )  # fmt: skip
    yield from ("*STEP, INC=1000000", "*STATIC", "0.1, 1.", *made.assembly, *controls)
    yield from ("*NODE FILE, OUTPUT=3D, FREQUENCY=1000000", "U")
    yield from ("*CONTACT PRINT, FREQUENCY=1000000", "CDIS, CSTR", "*END STEP")
    for _ in range(cycles):
        for factor in (*PERIOD[1:], PERIOD[0]):
            yield from ("*STEP, INC=1000000", "*STATIC", "1e-5, 1., 1e-10, 1.", "*CLOAD")
            for (node, direction), force in made.moved.items():
                yield f"{node}, {direction}, {load_factor * factor * force:.16g}"
            yield "*END STEP"
