"""From the files of a finite-element code to a problem, steered by a TOML configuration."""

import os
from dataclasses import dataclass
from pathlib import Path

from shakedown.condensation.condense import Condensation, condensed_stiffness
from shakedown.errors import ProblemError
from shakedown.importing.sections import (
    ContactSection,
    friction,
    held_rows,
    load_section,
    static_run,
    stiffness_section,
)
from shakedown.importing.toml_table import read_toml
from shakedown.model.problem import Problem


@dataclass(frozen=True, eq=False)
class Import:
    """A problem made from finite-element files, with the evidence.

    Attributes
    ----------
    problem : Problem
        What was made.
    condensation : Condensation
        The condensed stiffness, with residual, asymmetry and rigid motions.
    format : str
        What the stiffness file was found to be.
    static_run : float
        Largest difference from the static run, relative to its largest reaction;
        NaN where none was given.
    notes : tuple of str
        What a user should know about the import.
    """

    problem: Problem
    condensation: Condensation
    format: str
    static_run: float
    notes: tuple[str, ...]


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


def import_model(config_path: str | os.PathLike[str]) -> Import:
    """Read finite-element output as a TOML configuration says, and condense it.

    Keys of the configuration (those in brackets are optional)::

        [name], [units]            shown in reports
        friction                   a number, or one per contact node
        [steps]                    load steps m, where a time function is sampled

        [stiffness]
        file                       any format that shakedown.readers knows
        [map]                      'node direction' lines: Matrix Market, OP4, COORDINATE
        [matrix]                   which matrix of a Nastran file
        [scale]                    factor on the stiffness (a thickness, a unit)
        [allow_sparse]             true: accept a superelement that couples few nodes
        [order], [amplitude]       reactions to unit displacements: "node-by-node" or
                                   "direction-by-direction"; the displacement

        [contact]
        nodes | pairs              node labels; [body 1, body 2] for two bodies
        normal | normals           into body 1; one for all, or one per node
        [axes]                     directions that span the plane, default [1, 2]
        [free_out_of_plane]        true: a third direction moves without friction
        [tied]                     for reactions: the node tied to each contact node, whose
                                   force CalculiX prints apart
        [x]                        positions for plots

        [supports]                 rows that are held or have prescribed displacements
        [fixed]                    [[node, direction], …]

        [[load]]                   one table per load case
        history                    a number, a list, {constant, harmonics}, {points}, {file}
        [reactions]                {file, [step], [scale]} or [[x, y], …]: reactions at the
                                   contact nodes, all clamped, from a static run
        [forces]                   {file} (Abaqus *CLOAD lines) or [[node, direction, value], …]
        [displacements]            [[node, direction, value], …]; holds those rows
        [mean], [transient]        as in shakedown.LoadCase
        [name]

        [check]                    a static run to compare with
        displacements              [[contact node, direction, value], …], the others clamped
        reactions                  as above

    Parameters
    ----------
    config_path
        The TOML file; paths in it are relative to its folder.

    Raises
    ------
    ProblemError
        As :func:`import_problem`.
    """
    if not isinstance(config_path, str | os.PathLike):
        raise ProblemError(f"expected the path of a TOML file, found {config_path!r}")
    root, folder = read_toml(config_path), Path(config_path).parent
    name, units, steps = root.text("name", ""), root.text("units", ""), root.integer("steps")
    f, sections = friction(root), {key: root.table(key) for key in ("stiffness", "contact")}
    supports, check = root.table("supports", required=False), root.table("check", required=False)
    tables = root.tables("load")
    root.done()
    contact = ContactSection.read(sections["contact"])
    stiffness = stiffness_section(sections["stiffness"], contact, folder)
    loads = [load_section(table, stiffness, contact, steps, folder) for table in tables]
    reduced = condensed_stiffness(
        stiffness.K,
        stiffness.dofs,
        contact.labels,
        contact.normals,
        fixed=held_rows(supports, stiffness, loads),
        axes=contact.axes,
        free_out_of_plane=contact.free_out_of_plane,
        allow_sparse=stiffness.superelement,  # checked as a whole when it was read
    )
    difference = static_run(check, reduced, contact, folder)
    cases = [load.case for load in loads]
    problem = reduced.problem(cases, f, x=contact.x, name=name or "", units=units or "")
    notes = (*reduced.notes, *_tension(problem))
    return Import(problem, reduced, stiffness.format, difference, notes)


def _tension(problem: Problem) -> tuple[str, ...]:
    """A word on loads that pull the contact open, which a wrong sign or normal makes them do."""
    p_mean = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    if p_mean.sum() < 0:
        return (
            "the mean load pulls the welded contact open: the normals must point into the (first) body and "
            "reactions must be the forces on it",
        )
    return ()
