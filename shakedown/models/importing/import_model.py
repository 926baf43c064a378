"""From the files of a finite-element code to a problem, steered by a TOML configuration."""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.shown_values import LONGEST_NAME, plain, shortened, visible
from shakedown.ground.tolerances import DEFAULT
from shakedown.ground.work_limit import on_one_thread
from shakedown.joint.places import bearing_no_pressure
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import doubtful_data, units_in
from shakedown.models.condensation.condense import Condensation, condensed_stiffness
from shakedown.models.condensation.contact_frame import SPACE, in_space
from shakedown.models.condensation.load_case import without_closing
from shakedown.models.condensation.stiffness_checks import with_shanks
from shakedown.models.importing import bolt_section, load_evidence, load_section, model_evidence
from shakedown.models.importing.contact_section import ContactSection, faces_between, taken_friction
from shakedown.models.importing.joined_contact import contact_of, friction_of
from shakedown.models.importing.load_evidence import LoadEvidence
from shakedown.models.importing.model_evidence import ModelEvidence
from shakedown.models.importing.stiffness_section import ImportContext, circumference_notes, stiffness_section
from shakedown.models.readers.formats import read_any_mesh
from shakedown.models.readers.mapped_matrices import NUMBERED
from shakedown.models.readers.mesh import CALCULIX, Mesh
from shakedown.models.readers.parsing import InputFiles, sha256
from shakedown.models.readers.stiffness import Stiffness
from shakedown.models.readers.toml_table import TomlTable, change_number, is_list_of, read_toml, values_of


@dataclass(frozen=True, eq=False, repr=False)
class Import(Result):
    """A problem made from finite-element files, with its import checks.

    Attributes
    ----------
    problem : Problem
        What was made.
    condensation : Condensation
        The condensed stiffness, with residual, asymmetry and rigid motions.
    stiffness : Stiffness
        The matrix as it was read, with the node and direction of every row.
    contact : ContactSection
        Contact nodes or pairs, normals, positions.
    mesh : Mesh or None
        Nodes and sets of the model, where the configuration names a file of them.
    static_run : float
        Largest difference from the static run, relative to its largest reaction;
        NaN where none was given.
    evidence : ModelEvidence
        Bodies and what holds them, patches, distances of the pairs.
    loads : tuple of LoadEvidence
        Resultants of every load case.
    sources : dict
        SHA-256 of the configuration and of every file that was read.
    warnings : tuple of str
        What is doubtful, and would make numbers wrong: the problem carries it with it.
    accepted : tuple of str
        Words of warnings that the configuration accepts; these are notes.
    notes : tuple of str
        What else a user should know about the import.
    path : str
        The configuration.
    """

    problem: Problem
    condensation: Condensation
    stiffness: Stiffness
    contact: ContactSection
    mesh: Mesh | None
    static_run: float
    evidence: ModelEvidence
    loads: tuple[LoadEvidence, ...]
    sources: dict[str, str]
    warnings: tuple[str, ...]
    accepted: tuple[str, ...]
    notes: tuple[str, ...]
    path: str

    @property
    def rigid_residual(self) -> float:
        """Largest force that a rigid motion of the whole model (in its plane, where it is one) meets.

        Relative to what displacements of that size can meet: near 0 for a free model, NaN where the
        coordinates are not known.
        """
        return self.evidence.rigid_residual

    @property
    def doubts(self) -> tuple[str, ...]:
        """The warnings, and what is unusual in the data of the problem: signs, units, per cent for one."""
        return (*self.warnings, *_parted(doubtful_data(self.problem), self.accepted)[0])

    @property
    def ready(self) -> bool:
        """Whether there are no doubts, so that nothing speaks against going on."""
        return not self.doubts

    def to_dict(self) -> dict[str, Any]:
        """What ``shakedown-bounds import --check --json`` writes."""
        reduced, contact = self.condensation, self.contact
        surfaces = [part.surfaces for part in contact.parts]
        document = {
            "problem": self.problem,
            "format": self.format,
            "rows": {"contact": reduced.layout.size, "condensed": reduced.interior, "held": reduced.held},
            "zero_modes": reduced.zero_modes,
            "asymmetry": reduced.asymmetry,
            "residual": reduced.residual,
            "static_run": self.static_run,
            "ready": self.ready,
            "warnings": self.warnings,
            "doubts": self.doubts,
            "notes": self.notes,
            "nodes": contact.names,
            "normals": reduced.frame.normals,
            **({"tangents": self.problem.tangents} if self.tangents else {}),
            "coordinates": contact.coordinates,
            "node_area": self.problem.node_area,
            "gap": contact.gap,
            "pairs": self._by_patch(self.evidence.pairs),
            **({"surfaces": self._by_patch(surfaces)} if any(surfaces) else {}),
            "rigid_residual": self.rigid_residual,
            "bodies": self.evidence.bodies,
            "patches": self.evidence.patches,
            "loads": self.loads,
            "sources": self.sources,
        }
        return {word: plain(value) for word, value in document.items()}

    def _by_patch(self, values: Sequence[Any]) -> Any:
        """Values of every patch by its name; where there is only one, its value alone."""
        if len(values) == 1:
            return values[0]
        return {part.name: value for part, value in zip(self.contact.parts, values, strict=True)}

    def columns(self) -> dict[str, Any]:
        """One row per contact node."""
        contact, frame = self.contact, self.condensation.frame
        columns: dict[str, Any] = {"nodes": list(contact.names)}
        if contact.coordinates is not None:
            columns |= dict(zip("xyz", contact.coordinates.T, strict=True))
        columns |= {f"normal {'xyz'[a - 1]}": frame.normals[:, k] for k, a in enumerate(contact.axes)}
        for number, tangent in enumerate(self.tangents):
            columns |= {f"tangent {number + 1} {a}": tangent[:, k] for k, a in enumerate("xyz")}
        return columns if contact.area is None else columns | {"area": contact.area}

    @property
    def tangents(self) -> tuple[FloatArray, ...]:
        """The first and the second tangents, (n, 3) each; none of a plane contact."""
        found = self.problem.tangents
        return () if found is None else (found[:, 0], found[:, 1])

    @property
    def format(self) -> str:
        """What the stiffness file was found to be."""
        return self.stiffness.format


class Configuration:
    """What a configuration says, section by section; the files that it names are not read yet.

    Raises
    ------
    ProblemError
        If it has other keys, or one is malformed.
    """

    def __init__(self, root: TomlTable) -> None:
        self.where, self.name = root.where, root.text("name", "") or ""
        self.units, self.steps = root.text("units", "") or "", root.integer("steps")
        expected = "a list of texts, words of warnings"
        words = root.take("accept", expected, fits=lambda v: is_list_of(str, v) and all(v))
        self.accepted: tuple[str, ...] = tuple(words or ())
        self.stiffness, self.contacts = root.table("stiffness"), root.tables("contact", one=True)
        own_friction = all(table.has("friction") for table in self.contacts)
        self.friction = taken_friction(root, required=not own_friction)
        self.model, self.supports, self.check = (
            root.table(key, required=False) for key in ("model", "supports", "check")
        )
        self.loads = root.tables("load")
        self.bolts = root.tables("bolt") if root.has("bolt") else []
        self.stiffness_file = str(self.stiffness.content.get("file"))
        root.done()


@checked
def import_problem(config_path: str | os.PathLike[str]) -> Problem:
    """The problem that a configuration describes; see :func:`import_model` for its keys.

    Parameters
    ----------
    config_path
        The TOML file; paths in it are relative to its folder.

    Raises
    ------
    ProblemError
        If the configuration or a file it names is malformed, or the model is
        not one that can be condensed; the message says what and where.
    """
    return import_model(config_path).problem


@checked
@on_one_thread
def import_model(
    config_path: str | os.PathLike[str],
    *,
    command: str = "",
    changes: Mapping[str, float] | None = None,
    before: Import | None = None,
) -> Import:
    """Read and condense finite-element output as a TOML configuration describes it.

    The problem keeps what leads back to the model: labels, coordinates, normals and, where
    there are faces, areas of its nodes, the names of the loads, and as ``source`` the
    configuration, the SHA-256 of every file and the command. The same files and the same
    command give the same problem, to the byte.

    Keys of the configuration (those in brackets are optional)::

        [name], [units]            shown in reports
        [accept]                   ["words of a warning", …]: what is meant so, and no longer a warning
        friction                   a number, or one per contact node, or a table of node sets
                                   {pads = 0.3, spacer = 0.15}
        [steps]                    load steps m, where a time function is sampled; lists of factors have
                                   as many. Without it a last one that repeats the first is left out

        [model]                    coordinates, sets and normals
        file                       a deck (Abaqus, CalculiX), an archive (Ansys .cdb), Nastran bulk
                                   data (.pch, .asm), a mesh (.msh, .med, .unv, .vtu), or a list
                                   'node x y z'

        [stiffness]
        file                       any format that shakedown.models.readers knows
        [map]                      rows of Matrix Market, Harwell-Boeing, COORDINATE, OUTPUT4:
                                   'node direction' lines, Ansys' node vector or .mapping,
                                   the deck, Nastran's EXTRN or ASET cards
        [matrix]                   which matrix of a Nastran file; "KXX(2)" is the second of a name
        [scale]                    factor on the stiffness: a thickness, a unit, one over the size of unit
                                   displacements; of an axisymmetric model 360 over the degrees that the
                                   matrix stands for, where the deck does not say it
        [accuracy]                 relative, of the entries, as printed: 1e-7 of seven digits

        [contact]                  or several [[contact]], one for each patch
        [name]                     of the patch; of several every one has its own
        [friction]                 of the patch, else that above
        nodes | pairs | surfaces   node labels, or the name of a set; [body 1, body 2] for two
                                   bodies, or the names of two sets that lie on each other; or the
                                   names of two surfaces whose meshes need not match, results at
                                   the nodes of the first
        [reach]                    of surfaces: the largest distance of faces that meet, default a
                                   quarter of a face of the first
        [directions]               2: friction in two tangential directions, 1: in a plane. By default
                                   2 where normals leave the plane of x and y or contact nodes move
                                   across it, unless 'axes' say otherwise
        [normal] | [normals]       into body 1; one for all, or one per node; by default from
                                   the faces of the model, or of its surface [surface]
        [tangent] | [tangents]     with two directions: towards which the first tangent leads,
                                   [x, y, z], one for all or one per node; the second one is
                                   at right angles to it and to the normal
        [axes]                     of a plane problem: directions that span it, default [1, 2]
        [tied]                     for reactions: the node tied to each contact node, whose
                                   force CalculiX prints apart
        [x]                        positions for plots, by default from the coordinates
        [thickness]                of a plane model, for the areas of the nodes; default 1 (of an
                                   axisymmetric one the areas are 2 pi r times a length)
        [gap]                      initial gap, negative for interference: a number, a list,
                                   {file, column}, {nodes = [[node or set, gap], …]}, or
                                   "coordinates": between the nodes of the pairs as the deck
                                   places them

        [supports]                 rows that are held or have prescribed displacements
        [fixed]                    [[node or set, direction], …]

        [[load]]                   one table per load case
        history | range            a number, a list, {constant, harmonics}, {points},
                                   {file, column, time, period}; or [low, high], any value between
        [forces]                   [[node or set, direction, value at each], …] or {file, [scale]}:
                                   *CLOAD lines, a substructure with [case], OUTPUT4 with
                                   matrix, [column]
        [displacements]            [[node or set, direction, value], …]; holds those rows
        [reactions]                [[x, y], …] or {file, [step], [scale], [bodies]}: reactions at the
                                   contact nodes, all clamped, from a static run
        [open]                     {file, [step], [scale]}: displacements of the contact nodes under
                                   the load while nothing acts between the bodies
        [thermal]                  {file, [step], [scale]}: reactions to a temperature
                                   with every node held
        [mean], [transient]        as in shakedown.LoadCase
        [name]
        [unit], [value]            how reports say the load: its unit, and what factor 1 stands for
                                   in it (default 1); mean and amplitude follow from the history
        [frequency]                of forces M phi of a mode with mass one: its circular frequency

        [[bolt]]                   one table per bolt
        preload                    what it carries once tightened and nothing else acts [force]
        head, [nut]                node sets (or nodes) that the shank pulls towards each other, evenly;
                                   without a nut it is screwed into something rigid
        stiffness                  of the shank [force/length], or area, length, young
        [axis]                     from the head along the shank; default: towards the nut
        section                    instead of these: the node of a *PRE-TENSION SECTION of CalculiX
        [name], [transient]        as of a load

        [check]                    an independent static run to compare with
        displacements              [[contact node, direction, value], …], the others clamped
        reactions                  as above

    Parameters
    ----------
    config_path
        The TOML file; paths in it are relative to its folder.
    command
        What was typed, for ``source``.
    changes
        Dotted key → number that takes the place of the configuration's; tables of a list and
        entries of a list are counted from 1: ``{"load.2.history.harmonics.1.sin": 0.5}``.
    before
        The import of the same configuration as it stands: where the changes touch only
        friction, load steps, loads without prescribed displacements or the gap, the matrix is
        neither read nor condensed again.

    Raises
    ------
    ProblemError
        As :func:`import_problem`.
    """
    root, files = read_toml(config_path), InputFiles(Path(config_path).parent)
    for key, value in (changes or {}).items():
        change_number(root, key, value)
    kept = before if before is not None and all(map(keeps_stiffness, changes or {})) else None
    asked = Configuration(root)
    context = read_model(asked, files, None if kept is None else (kept.mesh, kept.stiffness))
    contact, mesh = context.contact, context.mesh
    f = friction_of(asked.friction, contact, context.mesh, root.where)
    doubts = model_evidence.check_contact(contact, mesh, f"{root.where}: contact")
    bolt_section.check_bolts(asked.bolts, [*asked.loads, asked.check], context.mesh, root.where)
    loads = [load_section.load_section(table, context) for table in asked.loads]
    with found_in(root.where):
        closed, closing = without_closing([load.case for load in loads], asked.steps)
    loads = [replace(load, case=case) for load, case in zip(loads, closed, strict=True)]
    bolts = [bolt_section.bolt_section(table, context) for table in asked.bolts]
    if kept is None:
        condensed, difference, evidence = _reduced(asked, context, loads, bolts, doubts)
    else:
        condensed, difference, evidence = kept.condensation, kept.static_run, kept.evidence
    units, force_unit = [condensed.welded(bolt.unit) for bolt in bolts], units_in(asked.units).force
    loads += [bolt.load(unit, force_unit) for bolt, unit in zip(bolts, units, strict=True)]
    welded = [condensed.welded(load.case) for load in loads]  # the interior is solved once for each
    pulls = [[bolt.pull(unit, each) for each in welded] for bolt, unit in zip(bolts, units, strict=True)]
    added = np.reshape(pulls, (len(bolts), len(loads)))  # by each load at factor 1 to the force in each bolt
    cases, stiffness, frame = [load.case for load in loads], context.stiffness, condensed.frame
    bare = condensed.problem(
        cases, f, x=contact.x, gap=contact.gap, name=asked.name, units=asked.units, welded=welded
    )
    sources = {**({} if kept is None else kept.sources), **files.sources}
    sources = {Path(config_path).name: sha256(config_path), **sources}
    plain_names = (case.name.removeprefix(f"{root.where}: ") for case in cases)  # else called by their place
    names = tuple(shortened(visible(name), LONGEST_NAME - 1) for name in plain_names)
    without = () if contact.area is None else bearing_no_pressure(contact.area, contact.names)
    normals = in_space(frame.normals, contact.axes)
    doubts = (
        *evidence.warnings,
        *without,
        *closing,
        *load_evidence.load_doubts(loads, names, welded, condensed.stiffness),
        *load_evidence.not_pressed(bare),
    )
    warnings, accepted = _parted(doubts, asked.accepted)
    typed = [*([command] if command else []), *(f"{key}={value!r}" for key, value in (changes or {}).items())]
    problem = replace(
        bare,
        label=contact.names,
        coordinates=contact.coordinates,
        normal=normals,
        tangent=None if contact.directions > 1 else in_space(frame.tangents, contact.axes),
        node_area=None if without else contact.area,
        faces=faces_between(contact, mesh),
        stiffness_accuracy=stiffness.accuracy,
        load_names=names,
        source=model_evidence.source_text(config_path, sources, " ".join(typed), warnings),
    )
    resultants = load_evidence.Resultants(stiffness, contact, frame, evidence, mesh, bolts)
    return Import(
        problem=problem,
        condensation=condensed,
        stiffness=stiffness,
        contact=contact,
        mesh=mesh if context.mesh.is_known else None,
        static_run=difference,
        evidence=evidence,
        loads=tuple(
            resultants.of(case, name, each.reactions, pull)
            for case, name, each, pull in zip(cases, names, welded, added.T, strict=True)
        ),
        sources=sources,
        warnings=warnings,
        accepted=asked.accepted,
        notes=(
            *(f"accepted: {doubt}" for doubt in accepted),
            *condensed.notes,
            *evidence.notes,
            *(
                ["pairs and normals are not checked, because [model] does not say where the nodes are"]
                if contact.labels.ndim > 1 and contact.coordinates is None
                else ()
            ),
            *circumference_notes(stiffness, mesh),
            *bolt_section.bolt_notes(bolts, names, welded, added),
        ),
        path=os.fspath(config_path),
    )


def _parted(doubts: Iterable[str], accepted: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The doubts that have none of some words, and those that have."""
    found: tuple[list[str], list[str]] = [], []
    for doubt in doubts:
        found[any(words in doubt for words in accepted)].append(doubt)
    return tuple(found[0]), tuple(found[1])


def _reduced(
    asked: Configuration,
    context: ImportContext,
    loads: list[load_section.LoadSection],
    bolts: list[bolt_section.BoltSection],
    doubts: tuple[str, ...],
) -> tuple[Condensation, float, ModelEvidence]:
    """The condensed model, its difference from a static run, and what was found of the model."""
    stiffness, contact, mesh = context.stiffness, context.contact, context.mesh
    own = load_section.held_rows(asked.supports, context, loads)
    held = np.concatenate([own, *(bolt.rows for bolt in bolts)])
    marks = np.zeros(len(stiffness.dofs), dtype=bool)
    marks[held] = True
    forces = [load.case.force for load in loads if load.case.force is not None]
    alone = (stiffness.parts < 0) & ~np.any(forces, axis=0) if forces else stiffness.parts < 0
    with found_in(asked.where):
        bolt_section.check_held(bolts, held, stiffness.dofs)
        shanks = [(bolt.stiffness, bolt.unit.force) for bolt in bolts if bolt.unit.force is not None]
        condensed = condensed_stiffness(
            with_shanks(stiffness.K, shanks),
            stiffness.dofs,
            contact.labels,
            contact.normals,
            fixed=marks | alone,
            axes=(contact.axes[0], contact.axes[1]),
            tangent=contact.tangent,
            allow_sparse=True,  # a doubt of the model
            coupling=contact.coupling,
            middle_nodes=contact.middle_nodes,
            places=mesh.places,
            rigid=model_evidence.rigid_motions_of_bodies(stiffness, marks, mesh, shanks),
        )
    difference = load_section.static_run(asked.check, condensed, context, asked.stiffness_file)
    return condensed, difference, model_evidence.model_evidence(stiffness, contact, held, mesh, doubts, alone)


def read_model(
    asked: Configuration, files: InputFiles, kept: tuple[Mesh | None, Stiffness] | None
) -> ImportContext:
    """The model, its contact and its stiffness; mesh and stiffness are not read where they were kept."""
    mesh = Mesh.unknown()
    if kept is not None:
        mesh = kept[0] or mesh
    elif asked.model.content:
        name = str(asked.model.text("file"))
        asked.model.done()
        mesh = files.read(name, read_any_mesh, asked.model.at("file"))
    contact = contact_of(asked.contacts, mesh, files)
    stiffness = stiffness_section(asked.stiffness, contact, mesh, files) if kept is None else kept[1]
    # CalculiX stores rows along x, y, z even in a *TRANSFORM; but a *BOUNDARY there removes a row that is
    # along none of them
    by_calculix = mesh.matrix_by == CALCULIX and stiffness.format == NUMBERED
    for label in contact.moved[np.isin(contact.moved, list(mesh.rotated))].tolist():
        count = np.count_nonzero(stiffness.dofs[:, 0] == label)
        if count != len(SPACE) or not by_calculix:
            raise ProblemError(
                f"{asked.contacts[0].where}: expected contact nodes with rows along x, y, z (in a *TRANSFORM "
                f"all three, from MATRIXSTORAGE of CalculiX), found {count} of node {label} in a *TRANSFORM"
            )
    if contact.assumed:  # one direction of slip; but nodes that can move along z have two
        rows = np.isin(stiffness.dofs[:, 0], contact.labels) & (stiffness.dofs[:, 1] == 3)
        rows &= stiffness.K.diagonal() < DEFAULT.constrained_diagonal
        held = set(values_of(mesh, asked.supports.copy(), "fixed", valued=False) or ())
        held.update(*(values_of(mesh, load.copy(), "displacements") or () for load in asked.loads))
        if not set(map(tuple, stiffness.dofs[rows].tolist())) <= held:
            contact = contact_of(asked.contacts, mesh, files, assume_plane=False)
    return ImportContext(stiffness, contact, mesh, files, asked.steps, bool(asked.check.content))


def keeps_stiffness(key: str) -> bool:
    """Whether a change at a key leaves the matrix, the held rows and the contact nodes as they are."""
    table, *more = key.split(".")
    if table == "load":
        return len(more) > 1 and more[1] != "displacements"
    if table == "contact":
        return bool({"gap", "friction"} & set(more[:2]))
    return table in ("friction", "steps") or (table == "bolt" and more[1:] == ["preload"])
