"""``[contact]``, or several ``[[contact]]`` as one contact of named patches, each with its friction."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import ProblemError
from shakedown.models.condensation.contact_frame import SPACE, patch_positions, tangent_pairs
from shakedown.models.condensation.surface_mesh import coupling_of_nodes, joined_couplings
from shakedown.models.importing.contact_section import ContactSection, Friction, check_order, contact_section
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.parsing import InputFiles, quoted, unfit
from shakedown.models.readers.toml_table import TomlTable, nodes_of, shown


def contact_of(
    tables: Sequence[TomlTable], mesh: Mesh, files: InputFiles, *, assume_plane: bool = True
) -> ContactSection:
    """The contact of one table, or of several that name its patches; ``assume_plane`` as for one.

    Raises
    ------
    ProblemError
        If a table is malformed, or two of them contradict each other: the same name, a common node, one
        and two directions of slip.
    """
    parts = [contact_section(table.copy(), mesh, files, assume_plane=assume_plane) for table in tables]
    if len(parts) == 1:
        return parts[0]
    if any(part.assumed for part in parts) and len({part.axes for part in parts}) > 1:
        return contact_of(tables, mesh, files, assume_plane=False)
    for k, (part, table) in enumerate(zip(parts, tables, strict=True)):
        if not part.name:
            raise table.missing("name", "what each of several patches is called")
        if part.name in {other.name for other in parts[:k]}:
            raise table.unfit("another name", f"{quoted(part.name)} twice")
        if part.axes != (axes := parts[0].axes):  # they are about the whole model
            raise table.wrong("axes", f"{shown(axes)}, as of {quoted(parts[0].name)}", shown(part.axes))
    _check_apart(parts, [table.where for table in tables])
    return _joined(parts)


def friction_of(given: Friction | None, contact: ContactSection, mesh: Mesh, where: str) -> FloatArray:
    """The coefficients, () or (n,): those of each patch, for the others the one of the whole contact.

    Raises
    ------
    ProblemError
        If a set is unknown or has no contact node, a contact node is in none or in several of them, or
        what stands beside the whole contact is not for one patch.
    """
    own = [part.friction for part in contact.parts]
    if given is not None and all(each is None for each in own):
        return _coefficients(given, contact, mesh, where)
    if given is not None and (isinstance(given, Mapping) or given.ndim or None not in own):
        raise ProblemError(
            f"{where}: key 'friction': expected a number, for patches that have none of their own, found "
            + ("that all of them have" if None not in own else "several")
        )
    every = [
        _coefficients(np.asarray(given) if each is None else each, part, mesh, f"{where}: contact")
        for part, each in zip(contact.parts, own, strict=True)
    ]
    return _of_nodes(every, contact.parts)


def _coefficients(given: Friction, contact: ContactSection, mesh: Mesh, where: str) -> FloatArray:
    """The coefficients of one contact; a pair has that of the set that either of its nodes is in."""
    if not isinstance(given, Mapping):
        check_order(contact, where, {"friction": given})
        count, of = len(contact.labels), f" of {quoted(contact.name)}" if contact.name else ""
        if given.ndim and len(given) != count:
            expected = f"expected one for each of {count} nodes{of}"
            raise ProblemError(f"{where}: key 'friction': {expected}, found {len(given)}")
        if (given < 0).any():
            found = f"{given.min():g}"
            raise unfit(f"{where}: key 'friction'", "coefficients >= 0", found)
        return given
    where = f"{where}: key 'friction'"
    bodies = contact.facing
    inside = {name: np.asarray(np.isin(bodies, nodes_of(mesh, name, where)).any(axis=1)) for name in given}
    for name, own in inside.items():
        if not own.any():
            raise unfit(where, f"contact nodes in the set {quoted(name)}", "none")
    times = np.sum(list(inside.values()), axis=0)
    if (times != 1).any():
        k = int(np.argmax(times != 1))
        found = " and ".join(quoted(name) for name, own in inside.items() if own[k]) or "none"
        raise unfit(where, "every contact node in one of the sets", f"{contact.names[k]} in {found}")
    return np.asarray(sum(value * inside[name] for name, value in given.items()), dtype=float)


def _check_apart(parts: Sequence[ContactSection], where: Sequence[str]) -> None:
    """Refuse a node on two patches, unless it is one of the second body that surfaces follow on both.

    A node that slips on two others, or that others follow while it slips itself, has no motion of its own.
    """
    first_on: dict[int, tuple[str, bool]] = {}
    for part, place in zip(parts, where, strict=True):
        followed = set() if part.surfaces is None else set(part.surfaces.master.tolist())
        for node in part.moved.tolist():
            before, both_follow = first_on.get(node, ("", False))
            if before and not (both_follow and node in followed):
                raise ProblemError(
                    f"{place}: expected patches without a common node, found node {node} on {quoted(before)} "
                    f"and {quoted(part.name)}; take it out of one of them"
                )
        first_on |= {node: (part.name, node in followed) for node in part.moved.tolist()}


def _joined(parts: Sequence[ContactSection]) -> ContactSection:
    """One contact of all patches, in their order; patches of different kinds become a coupling of nodes."""
    kinds = {(part.labels.ndim, part.coupling is None) for part in parts}
    coupling = None
    if len(kinds) > 1 or parts[0].coupling is not None:
        d = next((part.coupling.normals.shape[1] for part in parts if part.coupling is not None), 3)
        coupling = joined_couplings(
            [
                part.coupling or coupling_of_nodes(part.labels, part.unit_normals[:, :d], part.middle_nodes)
                for part in parts
            ]
        )
    every: dict[str, Any] = {
        key: None
        if any(getattr(part, key) is None for part in parts)
        else np.concatenate([getattr(part, key) for part in parts])
        for key in ("normals", "tied", "coordinates", "area", "middle_nodes")
    }
    first = parts[0]
    made = replace(
        first,
        labels=np.concatenate([part.labels if coupling is None else part.first for part in parts]),
        **every,
        tangent=np.concatenate([tangent_pairs(part.unit_normals, part.tangent) for part in parts])
        if first.axes == SPACE
        else None,
        assumed=all(part.assumed for part in parts),
        x=None,
        gap=_of_nodes([part.gap for part in parts], parts),
        gap_is_stated=all(part.gap_is_stated for part in parts),
        sorted_by_place=any(part.sorted_by_place for part in parts),
        surface=None,
        coupling=coupling,
        name="",
        friction=None,
        patches=tuple(parts),
    )
    return replace(made, x=_positions(made))


def _of_nodes(values: Sequence[FloatArray], parts: Sequence[ContactSection]) -> FloatArray:
    """Values of all nodes, (n,), from one number or one per node for every patch."""
    return np.concatenate(
        [np.broadcast_to(each, len(part.labels)) for each, part in zip(values, parts, strict=True)]
    )


def _positions(contact: ContactSection) -> FloatArray | None:
    """Positions on one plane, or in space; plane patches lie beside each other, each along itself."""
    if contact.axes == SPACE:
        places = contact.coordinates
        return None if places is None else patch_positions(places, contact.unit_normals, contact.tangent)
    own = [part.x for part in contact.parts]
    if any(each is None for each in own):
        return None
    found = [np.asarray(each) for each in own]
    for k, each in enumerate(found[1:], start=1):
        before = np.concatenate(found[:k])
        if each.min() <= before.max() and each.max() >= before.min():
            step = max(float(np.diff(np.sort(one)).max(initial=0.0)) for one in found) or 1.0
            # node spacings left on the axis of positions between patches that would overlap there
            found[k] = each - each.min() + before.max() + 5.0 * step
    return np.concatenate(found)
