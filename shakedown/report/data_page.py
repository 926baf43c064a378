"""The page about the joint itself: loads, what was checked, where the data come from."""

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.shown_values import DIGITS, count, few, sized
from shakedown.ground.tolerances import DEFAULT
from shakedown.ground.visible_text import with_unit
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips, zero_modes
from shakedown.joint.units import loads_in_words, units_of
from shakedown.report.limit_words import coupling_in_words
from shakedown.report.node_words import of_directions

SHOWN = 5  # digits of places and loads
SOURCE = {
    "toolkit": "toolkit",
    "command": "command",
    "made_by": "made by",
    "friction": "friction coefficient f",
    "gap": "initial gap",
}
WORDS = {
    "young": "Young's modulus",
    "poisson": "Poisson's ratio",
    "extent": "extent in x, y",
    "boundary": "on",
    "history": "times",
}
ROWS = {"contact": "contact boundary", "plane": "plane stress or strain", "materials": "material"}
BARE = ("kind", "value", "type", "whole body")  # written without their key
ORDER = ("kind", "value", "boundary")  # of a load, in this order before the other keys
LEFT_OF_PRELOAD = (
    "on average (sum of the mean p_w under all constant loads); tightening compresses the bodies, the shank "
    "shortens by as much, and the bolt loses that part of its preload"
)


def stiffness_rows(problem: Problem, coupling_ratio: float) -> list[tuple[str, str, str]]:
    """(what was checked, what was found, what it means)."""
    whole, name = (problem.A, "A") if problem.C is None else (problem.kappa, "κ = [[A, Bᵀ], [B, C]]")
    values = np.linalg.eigvalsh(whole)
    free = zero_modes(whole, problem.stiffness_accuracy)
    unit = units_of(problem).stiffness
    rows = [
        (
            "A and C symmetric" if problem.C is not None else "A symmetric",
            "yes, as stored",
            f"passed: differences of up to {DEFAULT.symmetry:g} of the largest entry are averaged",
        ),
        (
            f"{name} positive semi-definite",
            f"eigenvalues {few(values[0])} … {sized(values[-1], unit)}",
            f"passed; {_free_motions(free, len(rigid_slips(problem).pinned))}",
        ),
        ("friction coefficients", friction(problem), "passed: none is negative"),
    ]
    if problem.C is None:
        rows.append(("C, normal stiffness", "not given", "nodes cannot separate in the simulations"))
    if np.isfinite(coupling_ratio):
        rows.append(("coupling ratio ρ*", few(coupling_ratio), coupling_in_words(coupling_ratio)))
    if problem.normal is not None:
        rows.append(("normals", "unit vectors", "passed"))
    return rows


def _free_motions(free: int, sliding: int) -> str:
    """How many rigid motions are resisted by no stiffness, and what resists them.

    Examples
    --------
    >>> print(_free_motions(5, 3))
    no stiffness against 5 rigid motions of one body on the other, as in a bolted joint: friction alone
    resists 3, pressure and preload resist the 2 that change gaps
    """
    if not free:
        return "every motion is resisted"
    none = (
        f"no stiffness against {count(free, 'rigid motion')} of one body on the other, as in a bolted joint"
    )
    gaps = f", pressure and preload resist the {free - sliding} that change gaps" * (free > sliding)
    return f"{none}: friction alone resists {sliding or 'none'}{gaps}"


def friction(problem: Problem) -> str:
    """The friction coefficient, or the range of those of the nodes."""
    f = problem.f
    return f"{f[0]:g}" if (f == f[0]).all() else f"{f.min():g} … {f.max():g} (per node)"


def loading_rows(problem: Problem) -> list[tuple[str, str]]:
    """What the loading is made of."""
    given = "given" if problem.p_mean is not None or problem.q_mean is not None else "mean of the load steps"
    before = 0 if problem.q_transient is None else len(problem.q_transient)
    rows = [
        ("load steps per period", str(problem.m)),
        (
            "load path",
            "any inside the domain of these corners" if problem.is_domain else "a loop in this order",
        ),
        ("constant part r⁰", given),
        ("load steps before the first period", str(before)),
        ("initial states given", "none" if problem.initial_slip is None else str(len(problem.initial_slip))),
    ]
    if problem.load_names:
        rows.append(("load cases", loads_in_words(problem) or ", ".join(problem.load_names)))
    return rows


def source_rows(problem: Problem) -> list[tuple[str, str]]:
    """Where the data come from: command, bodies and files with their SHA-256, and the problem's own."""
    source: dict[str, Any] = json.loads(problem.source) if problem.source else {}
    in_length = {"": units_of(problem).length}
    rows = [
        (name, _in_words(source[key], in_length if key == "gap" else {}))
        for key, name in SOURCE.items()
        if key in source
    ]
    bodies = source.get("bodies", [])
    if isinstance(bodies, list):
        for k, body in enumerate(bodies, 1):
            of = f"body {k}: " if len(bodies) > 1 else ""
            rows += [(of + name, text) for name, text in _body_rows(body, problem)]
    rows += _bolt_rows(source.get("bolts", []), problem)
    for entry in source.get("files", []):
        rows.append((str(entry.get("name", "file")), f"SHA-256 {entry.get('sha256', '–')}"))
    if not source:
        rows.append(("origin", "not stored with the problem"))
    rows += [("warning", warning) for warning in problem.warnings]
    return [*rows, ("arrays of the problem", f"SHA-256 {problem.fingerprint}")]


def _body_rows(body: object, problem: Problem) -> list[tuple[str, str]]:
    """Material, supports and loads of a body, with units."""
    if not isinstance(body, dict):
        return []
    known = units_of(problem)
    stress, lengths = known.stress, dict.fromkeys("xyz", known.length)
    units = {"young": stress, "thickness": known.length} | lengths
    rows = []
    for key, value in body.items():
        if key == "loads" and isinstance(value, list):
            for k, load in enumerate(value, 1):
                loaded = _over_time(load) if isinstance(load, dict) else {"kind": load}
                of_kind = {"BodyForce": known.density, "Force": known.force}
                unit = of_kind.get(str(loaded.get("kind")), stress)
                told = {key: loaded[key] for key in ORDER if key in loaded} | loaded
                rows.append((f"load {k}", _in_words(told, {"value": unit} | lengths)))
        elif value not in ([], {}):
            rows.append((ROWS.get(key, str(key)), _in_words(value, units | {"": units.get(key, "")})))
    return rows


def _over_time(load: dict[str, Any]) -> dict[str, Any]:
    """A load or bolt; a history of 1 is replaced by a word for “constant”."""
    return load | {"history": "1, constant"} if load.get("history") == 1 else load


def _bolt_rows(bolts: object, problem: Problem) -> list[tuple[str, str]]:
    """Patches, preload and stiffness of every bolt, and the resulting force in the contact."""
    known = units_of(problem)
    own = {"preload": known.force, "stiffness": known.stiffness}
    told = [_over_time(bolt) for bolt in bolts if isinstance(bolt, dict)] if isinstance(bolts, list) else []
    rows = [(f"bolt {k}", _in_words(bolt, own)) for k, bolt in enumerate(told, 1)]
    if any(bolt.get("preload") and bolt.get("stiffness") for bolt in told):
        pressed = sized(float(loading(problem).p0.sum()), known.force)
        rows.append(("the contact carries", f"{pressed} {LEFT_OF_PRELOAD}"))
    return rows


def _in_words(value: object, units: Mapping[str, str] = MappingProxyType({})) -> str:
    """A JSON value in one line; numbers under a key that has a unit are followed by it."""
    if isinstance(value, dict):
        parts = [(key, _in_words(part, {**units, "": units.get(key, "")})) for key, part in value.items()]
        return ", ".join(text if key in BARE else f"{WORDS.get(key, key)} {text}" for key, text in parts)
    if isinstance(value, list):
        inner = [_in_words(part) for part in value]
        if all(isinstance(part, dict) for part in value):
            return "; ".join(inner)
        text = ", ".join(inner) if all(isinstance(part, str) for part in value) else f"({', '.join(inner)})"
        return f"{text} {units.get('', '')}".rstrip()
    if isinstance(value, int | float) and not isinstance(value, bool):
        return sized(value + 0.0, units.get("", ""), DIGITS)
    return str(value)


def configuration(problem: Problem) -> tuple[str, str]:
    """The configuration of the import, its name and its text; empty where none is stored."""
    source: dict[str, Any] = json.loads(problem.source) if problem.source else {}
    found = source.get("configuration", "")
    if isinstance(found, dict) and isinstance(found.get("text"), str):
        return str(found.get("name", "")), found["text"]
    if isinstance(found, dict) and "name" in found:
        return str(found["name"]), "Too long to be kept with the problem; its SHA-256 is among the sources."
    return "", found if isinstance(found, str) else json.dumps(found, indent=1, ensure_ascii=False)


def node_load_rows(problem: Problem) -> list[list[str]]:
    """Node by node: name, place, area, friction, mean and amplitude of the loads."""
    mean = loading(problem)
    by_node, place = problem.layout.by_node, node_places(problem)
    swing_p, swing_q = 0.5 * np.ptp(mean.p1, axis=0), by_node(0.5 * np.ptp(mean.q1, axis=0))
    tangential = np.stack([by_node(mean.q0), swing_q], axis=-1).reshape(problem.n, -1)
    loads = _without_round_off(np.column_stack([mean.p0, swing_p, tangential]))
    return [
        [
            str(j),
            *([problem.label[j]] if problem.label is not None else []),
            *place[j],
            *([few(problem.node_area[j], SHOWN)] if problem.node_area is not None else []),
            f"{problem.f[j]:g}",
            *(few(value, SHOWN) for value in loads[j]),
        ]
        for j in range(problem.n)
    ]


def node_load_head(problem: Problem) -> list[str]:
    """The heading of the table of node loads, with units."""
    units = units_of(problem)
    places = ["x", "y", "z"][: len(node_places(problem)[0])]
    return [
        "node",
        *(["FE label"] if problem.label is not None else []),
        *(with_unit(name, units.length) for name in places),
        *([with_unit("area", units.area)] if problem.node_area is not None else []),
        "f",
        *(
            with_unit(name, units.force)
            for part in ("p_w", *of_directions(problem, "q_w", ","))
            for name in (f"{part} mean", f"{part} amplitude")
        ),
    ]


def node_places(problem: Problem) -> list[list[str]]:
    """Coordinates of each node: of the model, along the contact, or none."""
    known = problem.x if problem.coordinates is None else problem.coordinates
    if known is None:
        return [[] for _ in range(problem.n)]
    return [
        [few(value, SHOWN) for value in place] for place in _without_round_off(known.reshape(problem.n, -1))
    ]


def _without_round_off(values: FloatArray) -> FloatArray:
    """Numbers of one kind for display: those negligible beside the largest become zero."""
    return np.where(np.abs(values) > NEGLIGIBLE * np.abs(values).max(), values, 0.0)
