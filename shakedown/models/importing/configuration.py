"""The sections of a configuration, and the model that it names with its contact and its stiffness."""

from typing import NamedTuple

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.ground.tolerances import DEFAULT
from shakedown.models.condensation.contact_frame import SPACE
from shakedown.models.importing.contact_section import (
    ContactSection,
    Friction,
    taken_friction,
)
from shakedown.models.importing.joined_contact import contact_of
from shakedown.models.importing.load_section import held_keys
from shakedown.models.importing.model_section import Model, model_section
from shakedown.models.importing.stiffness_section import ImportContext, stiffness_section
from shakedown.models.readers.calculix_storage import NUMBERED
from shakedown.models.readers.input_files import InputFiles
from shakedown.models.readers.mesh import CALCULIX, Mesh
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.toml_table import TomlTable


class Configuration(NamedTuple):
    """What a configuration says, section by section; the files that it names are not read yet."""

    name: str
    units: str
    steps: int | None
    friction: Friction | None
    loads: list[TomlTable]
    where: str
    stiffness_file: str
    stiffness: TomlTable
    contacts: list[TomlTable]
    bolts: list[TomlTable]
    model: TomlTable
    supports: TomlTable
    check: TomlTable


def taken_configuration(root: TomlTable) -> Configuration:
    """The sections of a configuration; ``ProblemError`` where it has other keys."""
    name, units, steps = root.text("name", ""), root.text("units", ""), root.integer("steps")
    stiffness, contacts = root.table("stiffness"), root.one_or_more("contact")
    friction = taken_friction(root, required=not all(table.has("friction") for table in contacts))
    sections = [root.table(key, required=False) for key in ("model", "supports", "check")]
    loads, bolts = root.tables("load"), root.tables("bolt") if root.has("bolt") else []
    root.done()
    file = str(stiffness.content.get("file"))
    words = name or "", units or ""
    return Configuration(
        *words, steps, friction, loads, root.where, file, stiffness, contacts, bolts, *sections
    )


def read_model(
    asked: Configuration, files: InputFiles, kept: tuple[Mesh | None, Stiffness] | None
) -> ImportContext:
    """The model, its contact and its stiffness; mesh and stiffness are not read where they were kept."""
    if kept is None:
        model = model_section(asked.model, files, asked.stiffness.copy().integer("superelement"))
    else:
        model = Model(kept[0])
    contact, where = contact_of(asked.contacts, model, files), asked.contacts[0].where
    stiffness = stiffness_section(asked.stiffness, contact, model, files) if kept is None else kept[1]
    _check_directions(contact, stiffness, model.mesh, where)
    if contact.assumed and _moves_across(contact, stiffness, held_keys(asked.supports, asked.loads, model)):
        contact = contact_of(asked.contacts, model, files, assume_plane=False)
    return ImportContext(stiffness, contact, model, files, asked.steps, bool(asked.check.content))


def keeps_stiffness(key: str) -> bool:
    """Whether a change at a key leaves the matrix, the held rows and the contact nodes as they are."""
    table, *more = key.split(".")
    if table == "load":
        return len(more) > 1 and more[1] != "displacements"
    if table == "contact":
        return bool({"gap", "friction"} & set(more[:2]))
    return table in ("friction", "steps") or (table == "bolt" and more[1:] == ["preload"])


def _check_directions(contact: ContactSection, stiffness: Stiffness, mesh: Mesh | None, where: str) -> None:
    """Refuse contact nodes whose rows are not along x, y, z.

    CalculiX stores them along x, y, z even in a ``*TRANSFORM``; but a ``*BOUNDARY`` there removes a row that
    is along none of them.
    """
    turned = [label for label in contact.moved.tolist() if mesh is not None and label in mesh.rotated]
    if not turned or mesh is None:
        return
    if mesh.matrix_by != CALCULIX or stiffness.format != NUMBERED:
        raise ProblemError(
            f"{where}: expected contact nodes with directions x, y, z (or MATRIXSTORAGE of CalculiX, which "
            f"has them), found node {turned[0]} in a *TRANSFORM"
        )
    labels, count = np.unique(stiffness.dofs[:, 0], return_counts=True)
    rows = dict(zip(labels.tolist(), count.tolist(), strict=True))
    partly = [label for label in turned if rows.get(label, 0) != len(SPACE)]
    if partly:
        raise ProblemError(
            f"{where}: expected three rows of a contact node in a *TRANSFORM, found {rows.get(partly[0], 0)} "
            f"of node {partly[0]} (a *BOUNDARY takes one away that is none of x, y, z)"
        )


def _moves_across(contact: ContactSection, stiffness: Stiffness, held: set[tuple[int, int]]) -> bool:
    """Whether a contact node can move along z, so that the plane of x and y, only assumed, does not hold."""
    rows = np.isin(stiffness.dofs[:, 0], contact.labels) & (stiffness.dofs[:, 1] == 3)
    rows &= stiffness.K.diagonal() < DEFAULT.constrained_diagonal
    return not set(map(tuple, stiffness.dofs[rows].tolist())) <= held
