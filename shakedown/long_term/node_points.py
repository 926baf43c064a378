"""Nodes as points in space for ParaView: places, faces, directions, and names as numbers."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import LARGEST_LABEL
from shakedown.joint.places import wound
from shakedown.joint.problem import Problem

LONGEST_NUMBER = len(str(LARGEST_LABEL)) - 1  # digits of a label that can be written as an integer


def labels_of(problem: Problem) -> tuple[str, ...]:
    """The name of each node in the model; its number where it has none."""
    return problem.label or tuple(map(str, range(problem.n)))


def coordinates_of(problem: Problem) -> FloatArray:
    """Where the nodes are, (n, 3); only x where the joint knows no more."""
    if problem.coordinates is not None:
        return problem.coordinates
    places = np.full((problem.n, 3), np.nan)
    if problem.x is not None:
        known = problem.x.reshape(problem.n, -1)  # one, two or three coordinates
        places[:, : known.shape[1]] = known
    return places


def points_of(coordinates: FloatArray) -> FloatArray:
    """Where nodes are drawn, (n, 3) [length]: in a row where their places are unknown."""
    points = coordinates.copy()
    if np.isnan(points).all():
        points[:, 0] = np.arange(len(points))
    return np.nan_to_num(points)


def faces_of(problem: Problem) -> NDArray[np.intp] | None:
    """The faces (k, 4), around the normals where known; None where corners have no place."""
    places, normals = coordinates_of(problem), normals_of(problem)
    if problem.faces is None or not np.isfinite(places[:, :2]).all():
        return None
    return problem.faces if normals is None else wound(problem.faces, np.nan_to_num(places), normals)


def axes_of(problem: Problem) -> FloatArray | None:
    """The directions of slip in the model, (n, d, 3), where they are known."""
    if problem.directions == 2:
        return problem.tangents
    return None if problem.tangent is None else problem.tangent[:, None]


def normals_of(problem: Problem) -> FloatArray | None:
    """Unit vectors into the first body, (n, 3): given, or from both tangents, t₁ × t₂."""
    if problem.normal is None and problem.tangents is not None:
        return np.cross(problem.tangents[:, 0], problem.tangents[:, 1])
    return problem.normal


def fixed_numbers(label: Sequence[str], normal: FloatArray | None) -> dict[str, NDArray[np.generic]]:
    """Numbers at points that no load changes: ``node``, names as far as they are numbers, normals.

    Examples
    --------
    >>> {name: values.tolist() for name, values in fixed_numbers(["12/3", "7/41"], None).items()}
    {'node': [0, 1], 'node_1': [12, 7], 'node_2': [3, 41]}
    """
    found: dict[str, NDArray[np.generic]] = {"node": np.arange(len(label))}
    parts = [text.split("/") for text in label]
    names = {1: ("label",), 2: ("node_1", "node_2")}.get(len(parts[0]), ())
    if all(len(own) == len(names) and all(map(_is_whole, own)) for own in parts):
        numbers = np.array([list(map(int, own)) for own in parts])
        found |= dict(zip(names, numbers.T, strict=True))
    return found if normal is None else found | {"normal": normal}


def _is_whole(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) <= LONGEST_NUMBER
