"""Results of a static run of another code: a load case by its reactions or displacements, and ``[check]``."""

import numpy as np

from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import SIX_DIGITS
from shakedown.models.condensation.condense import Condensation
from shakedown.models.condensation.node_coupling import NodeCoupling
from shakedown.models.importing.contact_section import ContactSection, check_order
from shakedown.models.importing.model_section import Values
from shakedown.models.importing.stiffness_section import ImportContext
from shakedown.models.readers.circumference import HOOP
from shakedown.models.readers.input_files import InputFiles
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.nodal_vectors import NodalVectors, What, combined, in_model_directions
from shakedown.models.readers.reactions_table import read_nodal_vectors
from shakedown.models.readers.toml_table import TomlTable


def run_of(source: TomlTable, what: What, files: InputFiles, mesh: Mesh | None) -> NodalVectors:
    """The step of a file that a table names, or the sum of some steps, each times a factor; along x, y, z.

    Keys: ``file``; ``step`` (from 1) or ``steps`` = [[step, factor], …]; ``scale``.
    """
    name, step, scale = str(source.text("file")), source.integer("step"), source.number("scale", 1.0) or 0.0
    pairs = source.array("steps", float, (None, 2), required=False)
    if step is not None and pairs is not None:
        raise source.unfit("one of the keys 'step' and 'steps'", "both")
    runs = files.read(name, lambda path: read_nodal_vectors(path, what))
    if pairs is None:
        if not 1 <= (step or 1) <= len(runs) or (step is None and len(runs) > 1) or step == 0:
            found = "none" if step is None else step
            raise source.wrong("step", f"1 to {len(runs)}", found)
        pairs = [[step or 1, 1.0]]
    for number, _ in pairs:
        if number != int(number) or not 1 <= number <= len(runs):
            raise source.wrong("steps", f"[step, factor] with steps 1 to {len(runs)}", f"{number:g}")
    chosen = [_along_axes(runs[int(number) - 1], mesh, source.where) for number, _ in pairs]
    return combined(chosen, [scale * factor for _, factor in pairs])


def _along_axes(run: NodalVectors, mesh: Mesh | None, where: str) -> NodalVectors:
    """The vectors in components along x, y, z; the deck says the directions of their nodes."""
    unknown = sorted(run.local if mesh is None else run.local - set(mesh.rotated))
    if unknown:
        raise ProblemError(
            f"{where}: expected {run.what} along x, y, z, or the *TRANSFORM of the deck in [model], found "
            f"those of node {unknown[0]} in directions of its own (*NODE PRINT, GLOBAL=YES writes x, y, z)"
        )
    return run if mesh is None else in_model_directions(run, mesh.directions_of)


def clamped_run(
    table: TomlTable, contact: ContactSection, files: InputFiles, mesh: Mesh | None
) -> tuple[FloatArray | None, Values | None]:
    """``reactions``: at the nodes of the first body, (n, d + 1), or at those of both bodies held apart."""
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
            "'tied' (reactions of the first body, the bodies tied to each other) or 'clamped' (of "
            "both, each held by itself) for pairs, and none for nodes",
            f"'{bodies}'",
        )
    run = run_of(source, "reactions", files, mesh)
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
            "a superelement; run the load with the contact nodes held and give their 'reactions', or "
            "with the contact open ('open')",
        )
    twin = TomlTable(dict(source.content), source.where)
    run = run_of(source, "reactions", context.files, context.model.mesh)
    source.done()
    if run.by_calculix:
        _check_held(twin, context.files, context.model.mesh)
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


def _check_held(source: TomlTable, files: InputFiles, mesh: Mesh | None) -> None:
    """Refuse reactions beside displacements that are not all zero."""
    where = source.where
    try:
        run = run_of(source, "displacements", files, mesh)
    except ProblemError as error:
        raise ProblemError(
            f"{where}: expected displacements beside the reactions, which show that every node was held "
            f"(*NODE PRINT: U, RF); {error}"
        ) from None
    moved = np.flatnonzero(run.vectors.any(axis=1))
    if moved.size:
        raise ProblemError(
            f"{where}: expected every node held (*BOUNDARY), found node {run.nodes[moved[0]]} displaced by "
            f"{np.abs(run.vectors[moved[0]]).max():.3g}"
        )


def opened_run(
    table: TomlTable, contact: ContactSection, files: InputFiles, mesh: Mesh | None
) -> FloatArray | None:
    """``open``: displacements of the contact nodes with the contact open (of pairs u₁ − u₂)."""
    if not table.has("open"):
        return None
    source = table.table("open")
    run = run_of(source, "displacements", files, mesh)
    source.done()
    columns = [axis - 1 for axis in contact.axes]
    with found_in(source.where):
        if contact.coupling is not None:
            return _moved(source, run, _opened_surfaces(run, contact, contact.coupling), " apart")
        bodies = [run.places(nodes) for nodes in contact.labels.reshape(len(contact.labels), -1).T]
    first, *second = (run.vectors[places][:, columns] for places in bodies)
    return _moved(source, run, first - sum(second), " apart" if second else "")


def _opened_surfaces(run: NodalVectors, contact: ContactSection, coupling: NodeCoupling) -> FloatArray:
    """The same for coupled surfaces, all of whose nodes were printed."""
    d = coupling.normals.shape[1]
    apart = coupling.opening(lambda nodes: run.vectors[run.places(nodes)][:, :d])
    order = np.argsort(coupling.labels)[np.searchsorted(np.sort(coupling.labels), contact.labels)]
    return apart[order][:, [axis - 1 for axis in contact.axes]]


def _moved(source: TomlTable, run: NodalVectors, apart: FloatArray, word: str) -> FloatArray:
    """Displacements that are not all zero, but for the digits that are printed."""
    if np.abs(apart).max() <= SIX_DIGITS * np.abs(run.vectors).max():
        raise source.unfit(
            "displacements with the contact open",
            f"contact nodes that do not move{word} (held, tied or in contact? then 'reactions')",
        )
    return apart


def _check_independent(
    table: TomlTable, contact: ContactSection, files: InputFiles, stiffness_file: str
) -> None:
    """Check that a run is independent evidence on the stiffness."""
    if contact.coupling is not None:
        raise table.unfit(
            "none beside 'surfaces', because no static run moves the one against the other without contact",
            "one",
        )
    source = table.content.get("reactions")
    if isinstance(source, dict) and files.same(str(source.get("file")), stiffness_file):
        raise table.wrong(
            "reactions",
            "a run of its own",
            "the file that the stiffness was made from, which agrees with itself",
        )


def static_run(table: TomlTable, reduced: Condensation, context: ImportContext, stiffness_file: str) -> float:
    """``[check]``: the largest difference from an independent static run, NaN where there is none.

    Raises
    ------
    ProblemError
        If it differs, or the run is the file that the stiffness was made from.
    """
    if not table.content:
        return float("nan")
    contact, files = context.contact, context.files
    _check_independent(table, contact, files, stiffness_file)
    moved = context.model.values(table, "displacements")
    reactions, clamped = clamped_run(table, contact, files, context.model.mesh)
    table.done()
    if moved is None or reactions is None or clamped is not None:
        given = {
            "'displacements'": moved,
            "'reactions'": reactions,
            "reactions of both bodies, clamped": clamped,
        }
        found = " and ".join(key for key, value in given.items() if value is not None)
        raise table.unfit("the keys 'displacements' and 'reactions' (of the first body)", found)
    labels = contact.first.tolist()
    displacement = np.zeros((reduced.n, len(contact.axes)))
    for (node, direction), value in moved.items():
        if node not in labels or direction not in contact.axes:
            raise table.wrong(
                "displacements",
                f"contact nodes and directions {contact.axes}",
                f"node {node}, direction {direction}",
            )
        displacement[labels.index(node), contact.axes.index(direction)] = value
    if not context.model.axisymmetric:
        return reduced.check_against_run(displacement, reactions, what=table.where)
    if not displacement[:, 0].any():
        raise table.wrong(
            "displacements",
            "a contact node that moves radially (direction 1), because an axisymmetric model is checked",
            "none",
        )
    try:
        return reduced.check_against_run(displacement, reactions, what=table.where)
    except ProblemError as error:
        raise ProblemError(
            f"{error}; they must be those on the whole circumference of the axisymmetric model ({HOOP})"
        ) from None
