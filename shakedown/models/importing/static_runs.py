"""Results of a static run of another code: a load case by its reactions or displacements, and ``[check]``."""

import numpy as np

from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import SIX_DIGITS
from shakedown.models.condensation.condense import Condensation
from shakedown.models.importing.contact_section import check_order
from shakedown.models.importing.model_section import Values
from shakedown.models.importing.stiffness_section import ImportContext
from shakedown.models.readers.circumference import HOOP
from shakedown.models.readers.nodal_vectors import NodalVectors, What, combined, in_model_directions
from shakedown.models.readers.reactions_table import read_nodal_vectors
from shakedown.models.readers.toml_table import TomlTable


def run_of(source: TomlTable, what: What, context: ImportContext) -> NodalVectors:
    """The step of a file that a table names, or the sum of some steps, each times a factor; along x, y, z.

    Keys: ``file``; ``step`` (from 1) or ``steps`` = [[step, factor], …]; ``scale``.
    """
    name, step, scale = str(source.text("file")), source.integer("step"), source.number("scale", 1.0) or 0.0
    pairs = source.array("steps", float, (None, 2), required=False)
    if step is not None and pairs is not None:
        raise source.unfit("one of the keys 'step' and 'steps'", "both")
    runs = context.files.read(name, lambda path: read_nodal_vectors(path, what))
    if pairs is None:
        only = 1 if step is None and len(runs) == 1 else step
        if only is None or not 1 <= only <= len(runs):
            raise source.wrong("step", f"1 to {len(runs)}", "none" if step is None else step)
        pairs = [[only, 1.0]]
    for number, _ in pairs:
        if number != int(number) or not 1 <= number <= len(runs):
            raise source.wrong("steps", f"[step, factor] with steps 1 to {len(runs)}", f"{number:g}")
    chosen, mesh = [runs[int(number) - 1] for number, _ in pairs], context.model.mesh
    local = frozenset().union(*(run.local for run in chosen))
    unknown = sorted(local if mesh is None else local - set(mesh.rotated))
    if unknown:
        raise source.unfit(
            f"{what} along x, y, z, or the *TRANSFORM of the deck in [model]",
            f"those of node {unknown[0]} in directions of its own (*NODE PRINT, GLOBAL=YES writes x, y, z)",
        )
    if mesh is not None:
        chosen = [in_model_directions(run, mesh.directions_of) for run in chosen]
    return combined(chosen, [scale * factor for _, factor in pairs])


def clamped_run(table: TomlTable, context: ImportContext) -> tuple[FloatArray | None, Values | None]:
    """``reactions``: at the nodes of the first body, (n, d + 1), or at those of both bodies held apart."""
    contact = context.contact
    if not isinstance(table.content.get("reactions"), dict):
        listed = table.array("reactions", float, (None, len(contact.axes)), required=False)
        check_order(contact, table.where, {"reactions": listed})
        return (None if listed is None else np.array(listed, dtype=float)), None
    source = table.table("reactions")
    bodies = source.text("bodies", None if contact.two_bodies else "")
    if contact.coupling is not None and bodies != "clamped":
        raise source.wrong(
            "bodies",
            "'clamped' (reactions of both bodies, each held by itself) of surfaces that need not match",
            f"'{bodies}'",
        )
    if bodies not in ("", "tied", "clamped") or (not contact.two_bodies and bodies):
        raise source.wrong(
            "bodies",
            "'tied' (reactions of the first body, the bodies tied to each other) or 'clamped' (of both, "
            "each held by itself) for pairs, and none for nodes",
            f"'{bodies}'",
        )
    run = run_of(source, "reactions", context)
    source.done()
    if bodies != "clamped":
        return run.at(contact.first, contact.axes, contact.tied), None
    forces = run.at(contact.clamped, contact.axes)
    keys = [(int(node), axis) for node in contact.clamped for axis in contact.axes]
    return None, dict(zip(keys, forces.ravel().tolist(), strict=True))


def thermal_forces(table: TomlTable, context: ImportContext) -> FloatArray | None:
    """``thermal``: minus the reactions of a run in which every node was held, on all rows.

    Raises
    ------
    ProblemError
        If a node with rows was not printed, CalculiX did not print that all were held, or
        there is nothing to hold.
    """
    if not table.has("thermal"):
        return None
    source = table.table("thermal")
    if context.stiffness.superelement:
        raise table.wrong(
            "thermal",
            "a matrix of all nodes",
            "a superelement; run the load with the contact nodes held and give their 'reactions', or with "
            "the contact open ('open')",
        )
    twin = source.copy()
    run = run_of(source, "reactions", context)
    source.done()
    if run.by_calculix:
        _check_held(twin, context)
    dofs = context.stiffness.dofs
    moving = np.isin(dofs[:, 1], (1, 2, 3))
    force = np.zeros(len(dofs))
    with found_in(source.where):
        places = run.places(dofs[moving, 0], "node")
    force[moving] = -run.vectors[places, dofs[moving, 1] - 1]
    if not force.any():
        raise source.unfit(
            "the reactions of nodes that a temperature pushes",
            "zeros (weight, pressure and forces leave none in CalculiX where every node is held: use "
            "'forces' or 'open')",
        )
    rotated = () if context.model.mesh is None else context.model.mesh.rotated
    turned = [node for node in dofs[force != 0, 0].tolist() if node in rotated]
    if turned:
        raise source.unfit("nodes with directions x, y, z", f"node {turned[0]} in a *TRANSFORM")
    return force


def _check_held(source: TomlTable, context: ImportContext) -> None:
    """Refuse reactions beside displacements that are not all zero."""
    try:
        run = run_of(source, "displacements", context)
    except ProblemError as error:
        raise ProblemError(
            f"{source.where}: expected displacements beside the reactions, which show that every node was "
            f"held (*NODE PRINT: U, RF); {error}"
        ) from None
    moved = np.flatnonzero(run.vectors.any(axis=1))
    if moved.size:
        largest = np.abs(run.vectors[moved[0]]).max()
        found = f"node {run.nodes[moved[0]]} displaced by {largest:.3g}"
        raise source.unfit("every node held (*BOUNDARY)", found)


def opened_run(table: TomlTable, context: ImportContext) -> FloatArray | None:
    """``open``: displacements of the contact nodes with the contact open (of pairs u₁ − u₂)."""
    if not table.has("open"):
        return None
    source, contact, coupling = table.table("open"), context.contact, context.contact.coupling
    run = run_of(source, "displacements", context)
    source.done()
    with found_in(source.where):
        if coupling is None:
            bodies = contact.labels.reshape(len(contact.labels), -1).T
            first, *second = (run.vectors[run.places(nodes)] for nodes in bodies)
            apart = first - sum(second)
        else:
            d = coupling.normals.shape[1]
            apart = coupling.opening(lambda nodes: run.vectors[run.places(nodes)][:, :d])
            place = {node: k for k, node in enumerate(coupling.labels.tolist())}
            apart = apart[[place[node] for node in contact.labels.tolist()]]
    if np.abs(apart).max() <= SIX_DIGITS * np.abs(run.vectors).max():  # nothing but printed digits
        raise source.unfit(
            "displacements with the contact open",
            f"contact nodes that do not move{' apart' * contact.two_bodies} (held, tied or in contact? then "
            "'reactions')",
        )
    return np.asarray(apart[:, [axis - 1 for axis in contact.axes]])


def static_run(table: TomlTable, reduced: Condensation, context: ImportContext, stiffness_file: str) -> float:
    """``[check]``: the largest difference from an independent static run, NaN where there is none.

    Raises
    ------
    ProblemError
        If it differs, or the run is the file that the stiffness was made from.
    """
    if not table.content:
        return float("nan")
    contact, source = context.contact, table.content.get("reactions")
    if contact.coupling is not None:
        expected = "none beside 'surfaces', because no static run moves the one against the other without "
        raise table.unfit(f"{expected}contact", "one")
    if isinstance(source, dict) and context.files.same(str(source.get("file")), stiffness_file):
        found = "the file that the stiffness was made from, which agrees with itself"
        raise table.wrong("reactions", "a run of its own", found)
    moved = context.model.values(table, "displacements")
    reactions, clamped = clamped_run(table, context)
    table.done()
    if moved is None or reactions is None or clamped is not None:
        both = (("'displacements' alone", moved), ("'reactions' alone", reactions))
        alone = [what for what, value in both if value is not None]
        found = "reactions of both bodies, clamped" if clamped is not None else [*alone, "neither"][0]
        raise table.unfit("the keys 'displacements' and 'reactions' (of the first body)", found)
    labels = contact.first.tolist()
    displacement = np.zeros((reduced.n, len(contact.axes)))
    for (node, direction), value in moved.items():
        if node not in labels or direction not in contact.axes:
            expected = f"contact nodes and directions {contact.axes}"
            raise table.wrong("displacements", expected, f"node {node}, direction {direction}")
        displacement[labels.index(node), contact.axes.index(direction)] = value
    if context.model.axisymmetric and not displacement[:, 0].any():
        expected = (
            "a contact node that moves radially (direction 1), because an axisymmetric model is checked"
        )
        raise table.wrong("displacements", expected, "none")
    try:
        return reduced.check_against_run(displacement, reactions, what=table.where)
    except ProblemError as error:
        if not context.model.axisymmetric:
            raise
        raise ProblemError(
            f"{error}; they must be those on the whole circumference of the axisymmetric model ({HOOP})"
        ) from None
