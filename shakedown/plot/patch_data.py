"""The contact for the page's view in three dimensions: states at instants, as short text.

The script of the report (``view.js.j2`` among its templates) draws it.
"""

import json
from typing import Any

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import STICK
from shakedown.ground.visible_text import with_unit
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.state import LongTermState
from shakedown.plot.patch_places import (
    flattest,
    in_a_line,
    in_space,
    model_places,
    patch_count,
    patch_normal,
    places_of,
)
from shakedown.plot.paths import normal_reactions, so_far, work_and_name
from shakedown.plot.style import node_name

MOST_NUMBERS = 24_000  # nodes times instants, about half a MB
INSTANTS = (7, 25)  # of a period including both ends: for many nodes, for few
TILT = np.array([35.0, -50.0])  # initial view: rotation about the normal, then towards it


def can_be_turned(problem: Problem) -> bool:
    """Whether the places of three nodes are known and not in a line, so that a view shows something."""
    place = model_places(problem)
    return place is not None and not in_a_line(place)


def patch_data(state: LongTermState) -> str:
    """A long-term state of a joint that :func:`can_be_turned`, as JSON that ends no script element."""
    text = json.dumps(_data(state, state.problem), ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _data(state: LongTermState, problem: Problem) -> dict[str, Any]:
    history, place = state.history, model_places(problem)
    assert place is not None
    middle = 0.5 * (place.min(axis=0) + place.max(axis=0))
    size = float(np.linalg.norm(place - middle, axis=1).max())
    count = int(np.clip(MOST_NUMBERS // problem.n, *INSTANTS))
    times = np.linspace(max(float(history.cycle[0]), 0.0), float(history.cycle[-1]), count)
    at, (slip, work) = history.at(times), so_far(state, times)
    shown = [
        normal_reactions("normal reaction p", at.p, problem),
        (slip, with_unit("slip so far", units_of(problem).length)),
        work_and_name(work, problem),
    ]
    return {
        "nodes": problem.n,
        "times": [float(f"{time - times[0]:.4g}") for time in times],
        "start": int((at.state != STICK).sum(axis=1).argmax()),
        "places": ((place - middle) / size).T.round(4).tolist(),
        "faces": _faces(problem),
        "turn": _turn(problem, place).round(4).tolist(),
        "names": None if problem.label is None else [node_name(node, problem) for node in range(problem.n)],
        "status": "".join(map(str, np.abs(at.state).ravel().tolist())),
        "numbers": [_numbers(*each) for each in shown],
    }


def _numbers(values: FloatArray, name: str) -> dict[str, Any]:
    """Numbers (instants, n), None where there is none, their ends and what they are called."""
    known = values[np.isfinite(values)]
    rounded = [float(f"{value:.5g}") if np.isfinite(value) else None for value in values.ravel().tolist()]
    ends = {"low": float(known.min(initial=0.0)), "high": float(known.max(initial=0.0))}
    return {"name": name.replace("friction work", "friction work so far", 1), "values": rounded, **ends}


def _faces(problem: Problem) -> list[list[int]]:
    """Corners of the surface between the nodes: the faces, or triangles of each patch; none of a line."""
    if problem.faces is not None:
        return [[node for node in face if node >= 0] for face in problem.faces.tolist()]
    patches = [places_of(problem, k) for k in range(patch_count(problem))] if in_space(problem) else []
    meshed = [(each.nodes, each.triangles) for each in patches if each.triangles is not None]
    return [corners for nodes, mesh in meshed for corners in nodes[mesh.triangles].tolist()]


def _turn(problem: Problem, place: FloatArray) -> FloatArray:
    """Rows that lead to the right, up and out of the picture at first, (3, 3)."""
    from scipy.spatial.transform import Rotation

    out, tilt = patch_normal(place, problem.normal), TILT
    if not in_space(problem):  # in the plane of the joint
        out, tilt = flattest(place), np.zeros(2)
        out = out * np.sign(out[np.abs(out).argmax()])
    right = np.eye(3)[int(np.abs(out).argmin())]
    right = right - (right @ out) * out
    right /= np.linalg.norm(right)
    towards = Rotation.from_euler("zx", tilt, degrees=True).as_matrix()
    return np.asarray(towards @ np.stack([right, np.cross(out, right), out]))
