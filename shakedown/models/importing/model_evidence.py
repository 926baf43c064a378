"""What an import finds of the model itself, whatever loads it: bodies, patches, pairs, warnings."""

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shakedown import __version__
from shakedown.ground.size_limits import BLOCK
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.result import Result
from shakedown.models.importing.bodies import (
    ModelBody,
    bodies_of,
    contact_patches,
    rigid_residual,
)
from shakedown.models.importing.contact_faces import contact_doubts
from shakedown.models.importing.contact_section import ContactSection
from shakedown.models.importing.model_fit import model_doubts
from shakedown.models.importing.pair_distances import (
    PairDistances,
    check_distances,
    check_gap,
    distances_of,
    drawn_apart,
)
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.text import quoted


@dataclass(frozen=True, eq=False, repr=False)
class ModelEvidence(Result):
    """What an import finds of a model, for it and against it.

    Attributes
    ----------
    held : (N,)
        Which rows of the matrix are held: by the configuration, or marked so in the matrix.
    bodies : tuple of ModelBody
        The connected parts of the model, with the rigid motions that nothing but the contact resists.
    patches : (n,)
        Which patch of the contact every node belongs to, from 0.
    pairs : tuple of PairDistances or None
        For every patch of the configuration: how far apart the nodes of its pairs lie, where that is known.
    rigid_residual : float
        As :class:`~shakedown.models.importing.import_model.Import` has it.
    alone : (k, 2)
        (node, direction) of the rows that couple with no displacement, as component modes of a superelement.
    warnings : tuple of str
        What is doubtful.
    """

    held: NDArray[np.bool_]
    bodies: tuple[ModelBody, ...]
    patches: NDArray[np.intp]
    pairs: tuple[PairDistances | None, ...]
    rigid_residual: float
    alone: NDArray[np.intp]
    warnings: tuple[str, ...]

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes on parts of the model that the contact does not touch, and rows that are left out."""
        apart, notes = [body.nodes for body in self.bodies if not body.contact_nodes], []
        if apart:
            size, first = len(apart[0]), apart[0][0]
            notes.append(
                f"{len(apart)} part(s) of the model have no contact node, one of {size} node(s) from {first}"
            )
        if len(self.alone):
            notes.append(
                f"{len(self.alone)} row(s), first of point {self.alone[0, 0]}, couple with no displacement "
                "(component modes of a fixed boundary) and are left out"
            )
        return tuple(notes)


def check_contact(contact: ContactSection, mesh: Mesh | None, where: str) -> tuple[str, ...]:
    """Warnings about every patch of a contact in its model, from the positions of its nodes alone.

    Raises
    ------
    ProblemError
        If it cannot be meant so: pairs too far apart, normals out of the body.
    """
    if contact.patches:
        every = (
            (part.name, check_contact(part, mesh, f"{where}: {quoted(part.name)}")) for part in contact.parts
        )
        return tuple(f"{name}: {doubt}" for name, doubts in every for doubt in doubts)
    pairs = distances_of(contact, mesh)
    apart = () if pairs is None else check_distances(pairs, where, gap_is_stated=contact.gap_is_stated)
    coupled = () if contact.surfaces is None else (*contact.surfaces.warnings, *drawn_apart(contact))
    return (*apart, *coupled, *check_gap(contact), *contact_doubts(contact, mesh, where))


def model_evidence(
    stiffness: Stiffness,
    contact: ContactSection,
    rows: NDArray[np.intp],
    mesh: Mesh | None,
    warnings: tuple[str, ...],
) -> ModelEvidence:
    """What is found of a model with held ``rows``, beside ``warnings`` of its contact."""
    held = np.asarray(stiffness.K.diagonal() >= DEFAULT.constrained_diagonal)
    held[rows] = True
    return ModelEvidence(
        held=held,
        bodies=bodies_of(stiffness, held, contact, mesh),
        patches=contact_patches(contact, stiffness, mesh),
        pairs=tuple(distances_of(part, mesh) for part in contact.parts),
        rigid_residual=rigid_residual(stiffness, mesh, contact.axes),
        alone=stiffness.dofs[stiffness.parts < 0],
        warnings=(*warnings, *model_doubts(stiffness, contact, mesh)),
    )


def source_text(
    config_path: str | os.PathLike[str],
    sources: Mapping[str, str],
    command: str,
    warnings: Sequence[str] = (),
) -> str:
    """``source`` of a problem as JSON: toolkit, command, configuration, files, warnings; no date."""
    raw = Path(config_path).read_bytes()
    text = raw.decode() if len(raw) <= BLOCK else None  # of a longer one only its SHA-256 is kept
    about = {
        "toolkit": f"shakedown-bounds {__version__}",
        "command": command,
        "configuration": {"name": Path(config_path).name, "text": text},
        "files": [{"name": name, "sha256": digest} for name, digest in sources.items()],
        "warnings": list(warnings),
    }
    return json.dumps({key: value for key, value in about.items() if value})
