"""Normals of the contact nodes, and the plane or the tangents in which they slip."""

import numpy as np

from shakedown.ground.constants import THREE_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import found_in
from shakedown.models.condensation.contact_frame import PLANE, SPACE, Axes
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.parsing import unfit
from shakedown.models.readers.toml_table import TomlTable


def contact_directions(
    table: TomlTable,
    mesh: Mesh,
    first: IntArray,
    *,
    assume_plane: bool = True,
    faces: FloatArray | None = None,
) -> tuple[Axes, FloatArray, bool]:
    """Take the keys ``directions``, ``axes``, ``normal(s)`` and ``surface``: axes, normals, what is assumed.

    There are two directions of slip where the configuration says so (``directions = 2``, ``tangent``,
    ``tangents``) or the normals do not lie in the plane of x and y; there is one where it says so
    (``directions = 1``, ``axes``), or where one is assumed.

    Parameters
    ----------
    first : (n,)
        Contact nodes of the first body.
    assume_plane
        Whether normals in the plane of x and y, without other keys, mean one direction of slip.
    faces : (n, 3), optional
        Normals of the faces, where these are known already.

    Returns
    -------
    axes
        The two directions that span the plane, or all three where the nodes slip in two directions.
    normals : (n, d + 1)
        They point into the first body.
    assumed : bool
        Whether one direction of slip is only assumed, as the normals lie in the plane of x and y.

    Raises
    ------
    ProblemError
        If keys contradict each other, or normals are neither given nor known from the model.
    """
    stated, given = _axes(table, mesh), _given(table, len(first))
    if stated is None and given is not None and given.shape[-1] == 2:
        stated = PLANE
    surface = table.text("surface", required=False)
    if given is not None:
        axes = stated or (PLANE if assume_plane and not given[..., 2].any() else SPACE)
        along = _along(table, given, axes)
    elif not mesh.elements:
        raise table.unfit("one of 'normal' and 'normals', or [model] with a deck that has elements", "none")
    else:
        with found_in(table.where):
            along = mesh.normals(first, stated or SPACE, surface, faces)
        flat = (
            stated is None and (np.abs(np.hypot(*along.T[:2]) - 1) <= THREE_DIGITS).all()
        )  # but for the mesh
        axes = stated or (PLANE if assume_plane and flat else SPACE)
        along = along if stated else along[:, [axis - 1 for axis in axes]]
    normals = np.broadcast_to(along, (len(first), len(axes))).copy()
    return axes, normals, stated is None and axes == PLANE


def _axes(table: TomlTable, mesh: Mesh) -> Axes | None:
    """The axes that the configuration or an axisymmetric model says; None where neither says any."""
    number = table.integer("directions")
    if number not in (None, 1, 2):
        raise table.wrong("directions", "1 or 2", number)
    axes = table.array("axes", int, (2,), required=False)
    if axes is not None and sorted({1, 2, 3} & set(axes)) != sorted(axes):
        raise table.wrong("axes", "two of 1, 2, 3", axes)
    if mesh.axisymmetric:
        if number == 2 or axes not in (None, [1, 2]):
            found = f"directions = {number}, axes = {axes or [1, 2]}"
            raise table.unfit("one direction of slip and the axes [1, 2] of an axisymmetric model", found)
        if (least := mesh.coordinates[:, 0].min()) < 0:
            node = mesh.labels[int(np.argmin(mesh.coordinates[:, 0]))]
            raise unfit(mesh.name, "radii x >= 0 of an axisymmetric model", f"{least:g} at node {node}")
        return PLANE
    tangents = [key for key in ("tangent", "tangents") if table.has(key)]
    if axes and (number == 2 or tangents):
        other = f"'{tangents[0]}'" if tangents else "directions = 2"
        raise table.wrong("axes", "of a plane problem only", f"it beside {other}")
    if number == 2 or (tangents and number is None):
        return SPACE
    if tangents:
        raise table.wrong(tangents[0], "beside directions = 2 only", "directions = 1")
    return tuple(axes or PLANE) if axes or number == 1 else None


def _given(table: TomlTable, n: int) -> FloatArray | None:
    """Normals as the configuration gives them, (2,), (3,), (n, 2) or (n, 3)."""
    key = "normals" if table.has("normals") else "normal"
    value = table.content.get(key)
    first = value[0] if key == "normals" and isinstance(value, list) and value else value
    found = one_or_each(table, "normal", n, 3 if isinstance(first, list) and len(first) == 3 else 2)
    if found is None:
        return None
    if table.has("surface"):
        raise table.unfit("one of the keys 'normal', 'normals' and 'surface'", f"'{key}' and 'surface'")
    with np.errstate(over="ignore"):  # of a length that is refused
        length = np.linalg.norm(np.atleast_2d(found), axis=1)
    if not (long := (length > 0) & (length < np.inf)).all():
        at = f" at node {int(np.argmin(long))}" if key == "normals" else ""
        wrong = f"{np.atleast_2d(found)[~long][0].tolist()}{at}"
        raise unfit(f"{table.where}: '{key}'", "vectors of length > 0 and < inf", wrong)
    return found


def one_or_each(table: TomlTable, key: str, n: int, width: int) -> FloatArray | None:
    """The vector of a key, (width,), or those of its plural, one per node, (n, width); None without them."""
    one = table.array(key, float, (width,), required=False)
    each = table.array(f"{key}s", float, (None, width), required=False)
    if one is not None and each is not None:
        raise table.unfit(f"one of the keys '{key}' and '{key}s'", "both")
    if each is not None and len(each) != n:
        raise table.wrong(f"{key}s", f"one for each of {n} nodes", len(each))
    given = each if one is None else one
    return None if given is None else np.array(given, dtype=float)


def _along(table: TomlTable, vectors: FloatArray, axes: Axes) -> FloatArray:
    """Normals in components along the axes, from components along these or along x, y, z."""
    key = "normal" if vectors.ndim == 1 else "normals"
    if len(axes) == 3:
        if vectors.shape[-1] != 3:
            raise table.wrong(key, "3 numbers beside directions = 2", vectors.shape[-1])
        return vectors
    if vectors.shape[-1] == 2:
        return vectors
    (across,) = {1, 2, 3} - set(axes)
    wrong = vectors.reshape(-1, 3)[vectors.reshape(-1, 3)[:, across - 1] != 0]
    if len(wrong):
        raise table.wrong(
            key,
            f"2 numbers, along directions {axes[0]} and {axes[1]}, or 3 of which that in direction "
            f"{across} is 0 (of a solid model say 'axes', or directions = 2)",
            wrong[0].tolist(),
        )
    return vectors[..., [axis - 1 for axis in axes]]
