"""Normals of the contact nodes, and the plane or the tangents in which they slip."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import THREE_DIGITS, FloatArray
from shakedown.ground.errors import found_in
from shakedown.models.condensation.contact_frame import PLANE, SPACE
from shakedown.models.readers.mesh import Mesh
from shakedown.models.readers.text import unfit
from shakedown.models.readers.toml_table import TomlTable

Axes = tuple[int, ...]  # two directions that span a plane, or all three


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactDirections:
    """In which directions the gap opens and the nodes slip.

    Attributes
    ----------
    axes
        The two directions that span the plane, or all three where the nodes slip in two directions.
    normals : (n, d + 1)
        They point into the first body.
    tangent : (3,) or (n, 3) or None
        The direction towards which the first of two tangents points, where it is given.
    assumed : bool
        Whether one direction of slip is only assumed, as the normals lie in the plane of x and y.
    surface : str or None
        The surface of the deck whose faces gave the normals.
    normals_are_given : bool
        Whether the configuration gives the normals, not the faces.
    """

    axes: Axes
    normals: FloatArray
    tangent: FloatArray | None = None
    assumed: bool = False
    surface: str | None = None
    normals_are_given: bool = False


def contact_directions(
    table: TomlTable,
    mesh: Mesh,
    first: NDArray[np.intp],
    *,
    assume_plane: bool = True,
    faces: FloatArray | None = None,
) -> ContactDirections:
    """Take the keys ``directions``, ``axes``, ``normal(s)``, ``surface`` and ``tangent(s)``.

    There are two directions of slip where the configuration says so (``directions = 2``, ``tangent``,
    ``tangents``) or the normals do not lie in the plane of x and y; there is one where it says so
    (``directions = 1``, ``axes``), or where one is assumed.

    Parameters
    ----------
    first : (n,)
        Contact nodes of the first body.
    assume_plane
        Whether normals in the plane of x and y, where nothing else is said, mean one direction of slip.
    faces : (n, 3), optional
        Normals of the faces, where these are known already.

    Raises
    ------
    ProblemError
        If keys contradict each other, or normals are neither given nor known from the model.
    """
    said, given = _axes(table, mesh), _given(table, len(first))
    if said is None and given is not None and given.shape[-1] == 2:
        said = PLANE
    surface = table.text("surface", required=False)
    normals = _of_faces(table, mesh, first, said or SPACE, faces, surface) if given is None else given
    axes = said or (PLANE if assume_plane and _in_plane(normals, exactly=given is not None) else SPACE)
    columns = [axis - 1 for axis in axes]
    along = normals[:, columns] if given is None and said is None else normals
    along = along if given is None else _along(table, given, axes)
    return ContactDirections(
        axes=axes,
        normals=np.broadcast_to(along, (len(first), len(axes))).copy(),
        tangent=_tangent(table, len(first)) if axes == SPACE else None,
        assumed=said is None and axes == PLANE,
        surface=surface,
        normals_are_given=given is not None,
    )


def in_space(vectors: FloatArray, axes: Axes) -> FloatArray:
    """Vectors along two of the axes x, y, z (n, 2), or along all of them, as vectors (n, 3).

    Examples
    --------
    >>> in_space(np.array([[0.6, 0.8]]), (1, 3)).tolist()
    [[0.6, 0.0, 0.8]]
    """
    found = np.zeros((len(vectors), 3))
    found[:, [axis - 1 for axis in axes]] = vectors
    return found


def _in_plane(normals: FloatArray, *, exactly: bool) -> bool:
    """Whether normals (3,) or (n, 3) lie in the plane of x and y, exactly or as well as meshes have them."""
    if exactly:
        return not normals[..., 2].any()
    return bool((np.abs(np.hypot(normals[:, 0], normals[:, 1]) - 1) <= THREE_DIGITS).all())


def _axes(table: TomlTable, mesh: Mesh) -> Axes | None:
    """The axes that the configuration or an axisymmetric model says; None where neither says any."""
    number = table.integer("directions")
    if number not in (None, 1, 2):
        raise table.wrong("directions", "1 or 2", number)
    axes = table.array("axes", int, (2,), required=False)
    if axes is not None and sorted({1, 2, 3} & set(axes)) != sorted(axes):
        raise table.wrong("axes", "two of 1, 2, 3", axes)
    if mesh.axisymmetric:
        _check_axisymmetric(table, axes or list(PLANE), number, mesh)
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


def _check_axisymmetric(table: TomlTable, axes: list[int], number: int | None, mesh: Mesh) -> None:
    """Refuse an axisymmetric model that does not lie where its elements expect it: radius x >= 0, axis y."""
    if number == 2 or axes != [1, 2]:
        found = f"directions = {number}, axes = {axes}"
        raise table.unfit("one direction of slip and the axes [1, 2] of an axisymmetric model", found)
    k = int(np.argmin(mesh.coordinates[:, 0]))
    if (least := mesh.coordinates[k, 0]) < 0:
        expected = "radii x >= 0 of an axisymmetric model"
        raise unfit(mesh.name, expected, f"{least:g} at node {mesh.labels[k]}")


def _given(table: TomlTable, n: int) -> FloatArray | None:
    """Normals as the configuration gives them, (2,), (3,), (n, 2) or (n, 3)."""
    normal, normals = _vectors(table, "normal"), _vectors(table, "normals")
    named = {"normal": normal, "normals": normals, "surface": table.content.get("surface")}
    keys = [f"'{key}'" for key, value in named.items() if value is not None]
    if len(keys) > 1:
        raise table.unfit("one of the keys 'normal', 'normals' and 'surface'", " and ".join(keys))
    if normals is not None and len(normals) != n:
        raise table.wrong("normals", f"one for each of {n} nodes", len(normals))
    found = normals if normal is None else normal
    if found is None:
        return None
    with np.errstate(over="ignore"):  # of a length that is refused
        length = np.linalg.norm(np.atleast_2d(found), axis=1)
    if not (long := (length > 0) & (length < np.inf)).all():
        at = f" at node {int(np.argmin(long))}" if normal is None else ""
        wrong = f"{np.atleast_2d(found)[~long][0].tolist()}{at}"
        raise unfit(f"{table.where}: {keys[0]}", "vectors of length > 0 and < inf", wrong)
    return found


def _vectors(table: TomlTable, key: str) -> FloatArray | None:
    """Vectors of two or three components: one, or, where the key is a plural, one per node."""
    value, many = table.content.get(key), key.endswith("s")
    first = value[0] if many and isinstance(value, list) and value else value
    width = 3 if isinstance(first, list) and len(first) == 3 else 2
    given = table.array(key, float, (None, width) if many else (width,), required=False)
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


def _of_faces(
    table: TomlTable,
    mesh: Mesh,
    first: NDArray[np.intp],
    axes: Axes,
    faces: FloatArray | None,
    surface: str | None,
) -> FloatArray:
    """Normals from the faces of the model, or of a surface of it."""
    if not mesh.elements:
        raise table.unfit("one of 'normal' and 'normals', or [model] with a deck that has elements", "none")
    with found_in(table.where):
        return mesh.normals(first, axes, surface, faces)


def _tangent(table: TomlTable, n: int) -> FloatArray | None:
    """Where first tangents point to, (3,) or (n, 3); None where the configuration does not say it."""
    one = table.array("tangent", float, (3,), required=False)
    many = table.array("tangents", float, (None, 3), required=False)
    if one is not None and many is not None:
        raise table.unfit("one of the keys 'tangent' and 'tangents'", "both")
    if many is not None and len(many) != n:
        raise table.wrong("tangents", f"one for each of {n} nodes", len(many))
    given = many if one is None else one
    return None if given is None else np.array(given, dtype=float)
