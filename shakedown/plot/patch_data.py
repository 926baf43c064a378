"""The contact of a joint in space for the page's view in three dimensions: states at instants, as short text.

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
from shakedown.plot.drawn_path import so_far
from shakedown.plot.flat_patch import flattest
from shakedown.plot.over_contact import normal_reactions, per_area
from shakedown.plot.patch_places import patch_count, places_of
from shakedown.plot.style import node_name

DIGITS = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/"
LEVELS = len(DIGITS) ** 2 - 2  # of a number coded in two digits; the last pair means “no number”
MOST_NUMBERS = 24_000  # nodes times instants, about 0.16 MB
INSTANTS = (7, 25)  # of a period including both ends: for many nodes, for few
TILT = np.radians([35.0, -50.0])  # initial view: rotation about the normal, then towards it


def patch_data(state: LongTermState) -> str:
    """A long-term state of a joint in space whose nodes have places, as JSON that ends no script element."""
    text = json.dumps(_data(state, state.problem), ensure_ascii=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


def _data(state: LongTermState, problem: Problem) -> dict[str, Any]:
    history = state.history
    count = int(np.clip(MOST_NUMBERS // problem.n, *INSTANTS))
    times = np.linspace(max(float(history.cycle[0]), 0.0), float(history.cycle[-1]), count)
    at, (slip, work) = history.at(times), so_far(state, times)
    shown = [
        normal_reactions("normal reaction p", at.p, problem),
        (slip, with_unit("slip so far", units_of(problem).length)),
        per_area(work, problem),
    ]
    place, middle, size = _places(problem)
    return {
        "nodes": problem.n,
        "times": [float(f"{time - times[0]:.4g}") for time in times],
        "start": int((at.state != STICK).sum(axis=1).argmax()),
        "places": [digits(axis, -1.0, 1.0) for axis in ((place - middle) / size).T],
        "faces": _faces(problem),
        "turn": _turn(problem, place).round(4).tolist(),
        "names": None if problem.label is None else [node_name(node, problem) for node in range(problem.n)],
        "status": "".join(map(str, np.abs(at.state).ravel().tolist())),
        "numbers": [_coded(*each) for each in shown],
    }


def digits(values: FloatArray, low: float, high: float) -> str:
    """Numbers between two ends, each as two digits; ``//`` where there is none.

    Examples
    --------
    >>> digits(np.array([0.0, 1.0, np.nan]), 0.0, 1.0)
    'AA/+//'
    """
    share = (np.asarray(values, dtype=float).ravel() - low) / ((high - low) or 1.0)
    level = np.where(np.isfinite(share), np.clip(share, 0.0, 1.0) * LEVELS, LEVELS + 1).round().astype(int)
    letters = np.array(list(DIGITS))
    return "".join(letters[np.stack(np.divmod(level, len(DIGITS)), axis=1)].ravel().tolist())


def _coded(values: FloatArray, name: str) -> dict[str, Any]:
    """Numbers (instants, n) in digits, their ends and what they are called."""
    known = values[np.isfinite(values)]
    low, high = min(float(known.min(initial=0.0)), 0.0), float(known.max(initial=0.0))
    name = name.replace("friction work", "friction work so far", 1)
    return {"name": name, "low": low, "high": high, "digits": digits(values, low, high)}


def _places(problem: Problem) -> tuple[FloatArray, FloatArray, float]:
    """Where the nodes are (n, 3), the centre of their bounding box, and the largest distance from it."""
    place = problem.coordinates
    if place is None:
        assert problem.x is not None
        place = np.column_stack([problem.x, np.zeros((problem.n, 3 - problem.x.shape[1]))])
    middle = 0.5 * (place.min(axis=0) + place.max(axis=0))
    return place, middle, float(np.linalg.norm(place - middle, axis=1).max()) or 1.0


def _faces(problem: Problem) -> list[list[int]]:
    """Corners of the surface between the nodes: the faces, or triangles of each patch."""
    if problem.faces is not None:
        return [[node for node in face if node >= 0] for face in problem.faces.tolist()]
    found: list[list[int]] = []
    for patch in range(patch_count(problem)):
        places = places_of(problem, patch)
        if places.triangles is not None:
            found += places.nodes[places.triangles.triangles].tolist()
    return found


def _turn(problem: Problem, place: FloatArray) -> FloatArray:
    """Rows that lead to the right, up and out of the picture at first, (3, 3)."""
    out = np.zeros(3) if problem.normal is None else problem.normal.mean(axis=0)
    if np.linalg.norm(out) < 0.5:  # unknown, or pointing in all directions
        out = flattest(place) if problem.normal is None else np.eye(3)[2]
    out = out / np.linalg.norm(out)
    right = np.eye(3)[int(np.abs(out).argmin())]
    right = right - (right @ out) * out
    right /= np.linalg.norm(right)
    (c, s), (tc, ts) = ((np.cos(angle), np.sin(angle)) for angle in TILT)
    about = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    towards = np.array([[1.0, 0.0, 0.0], [0.0, tc, -ts], [0.0, ts, tc]])
    return np.asarray(towards @ about @ np.stack([right, np.cross(out, right), out]))
