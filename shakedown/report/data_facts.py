"""What a joint is: size, loads, doubts about its data, where the data come from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from shakedown.ground.shown_values import DIGITS, count, sized
from shakedown.ground.visible_text import LONGEST_NAME, one_line
from shakedown.joint.doubtful_data import doubtful_data
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips, zero_modes
from shakedown.joint.units import loads_in_words, units_of
from shakedown.report.facts import Fact
from shakedown.report.node_words import AXES, node_in_words
from shakedown.report.notes import FLOATING, LOAD_DOMAIN

SHOWN = 5  # digits of places and loads
SOURCE = {
    "toolkit": "toolkit",
    "command": "command",
    "made_by": "made by",
    "friction": "friction",
    "gap": "gap",
}
WORDS = {"young": "Young's modulus", "poisson": "Poisson's ratio", "boundary": "on", "history": "times"}
BARE = ("kind", "value", "type", "whole body")  # written without their key


def headline(problem: Problem) -> list[str]:
    """Name, size and friction; loads at λ = 1; what is doubtful, a line each.

    Examples
    --------
    >>> import shakedown
    >>> headline(shakedown.example("two-node"))
    ['two-node system (5.3.1): 2 nodes, 50 load steps, f = 0.35']
    """
    name = one_line(problem.name, LONGEST_NAME) or "unnamed problem"
    nodes = count(problem.n, "node") + " in space" * (problem.directions > 1)
    steps = count(problem.m, "load step")
    if problem.is_domain:
        steps = f"load domain of {count(problem.m, 'corner')}"
    units = f", in {one_line(problem.units, LONGEST_NAME)}" if problem.units else ""
    lines = [f"{name}: {nodes}, {steps}, f = {friction(problem)}{units}"]
    lines += [f"loads at λ = 1: {loads_in_words(problem)}"] if problem.loads else []
    return [*lines, *(f"warning: {doubt}" for doubt in doubts(problem))]


def doubts(problem: Problem) -> list[str]:
    """What is doubtful of the model that a problem was made from, in its data, and in its stiffness."""
    stiffness = rigid_slips(problem).doubt
    return [*problem.warnings, *doubtful_data(problem), *filter(None, [stiffness and f"{stiffness}."])]


def friction(problem: Problem) -> str:
    """The friction coefficient, or the range of those of the nodes."""
    f = problem.f
    return f"{f[0]:g}" if (f == f[0]).all() else f"{f.min():g} … {f.max():g}"


def relative_to(problem: Problem, pinned: tuple[int, ...]) -> list[Fact]:
    """What slips are relative to where friction alone holds a body; nothing for a joint that is held."""
    d = problem.directions
    named = [f"{'' if d == 1 else f'{AXES[k % d]} of '}{node_in_words(problem, k // d)}" for k in pinned]
    return [Fact("slips relative to", ", ".join(named), note=FLOATING)] if named else []


def load_path(problem: Problem) -> Fact:
    """For which path of the loads the limits hold."""
    if problem.is_domain:
        return Fact("load path", "any in the domain", note=LOAD_DOMAIN)
    return Fact(
        "load path", f"these {count(problem.m, 'load step')}", note="joined by straight lines, repeated"
    )


def joint_facts(problem: Problem) -> list[Fact]:
    """What a page says of the joint besides its headline: load cases, transient, rigid motions."""
    stiffness = problem.A if problem.C is None else problem.kappa
    free = count(zero_modes(stiffness, problem.stiffness_accuracy), "rigid motion")
    held = f"{len(rigid_slips(problem).pinned)} of them held by friction alone"
    given = problem.p_mean is not None or problem.q_mean is not None
    facts = [Fact("constant part", "given" if given else "mean of the load steps")]
    if problem.load_names and not problem.loads:
        facts.append(Fact("load cases", ", ".join(problem.load_names)))
    if problem.q_transient is not None:
        facts.append(
            Fact("transient", count(len(problem.q_transient), "load step"), note="before the first period")
        )
    facts.append(Fact("without stiffness", free, note=held))
    if problem.C is None:
        facts.append(Fact("normal stiffness C", "not given", note="no node can open"))
    return facts


def source_facts(problem: Problem) -> list[Fact]:
    """Where the data come from: command, bodies, bolts, files with their SHA-256."""
    source: dict[str, Any] = json.loads(problem.source) if problem.source else {}
    unit = units_of(problem)
    lengths = {"gap": {"": unit.length}}
    facts = [
        Fact(name, _told(source[key], lengths.get(key, {}))) for key, name in SOURCE.items() if key in source
    ]
    sizes = {"young": unit.stress, "thickness": unit.length} | dict.fromkeys("xyz", unit.length)
    bodies = source.get("bodies", [])
    for k, body in enumerate(bodies if isinstance(bodies, list) else [], 1):
        for key, value in body.items() if isinstance(body, dict) else ():
            if key == "loads" and isinstance(value, list):
                of_kind = {"BodyForce": unit.density, "Force": unit.force}
                told = [
                    _told(load, {"value": of_kind.get(str(load.get("kind")), unit.stress)} | sizes)
                    for load in value
                    if isinstance(load, dict)
                ]
                facts += [Fact(f"body {k}: load {j}", text) for j, text in enumerate(told, 1)]
            elif value not in ([], {}):
                facts.append(Fact(f"body {k}: {key}", _told(value, sizes | {"": sizes.get(key, "")})))
    facts += _bolts(source.get("bolts", []), problem)
    for entry in source.get("files", []):
        facts.append(Fact(str(entry.get("name", "file")), f"SHA-256 {entry.get('sha256', '–')}"))
    return [*facts, Fact("arrays of the problem", f"SHA-256 {problem.fingerprint}")]


def _bolts(bolts: object, problem: Problem) -> list[Fact]:
    """Patches, preload and stiffness of every bolt, and the resulting force in the contact."""
    unit = units_of(problem)
    own = {"preload": unit.force, "stiffness": unit.stiffness}
    known = [bolt for bolt in bolts if isinstance(bolt, dict)] if isinstance(bolts, list) else []
    facts = [Fact(f"bolt {k}", _told(bolt, own)) for k, bolt in enumerate(known, 1)]
    if any(bolt.get("preload") and bolt.get("stiffness") for bolt in known):
        pressed = float(loading(problem).p0.sum())
        note = "on average: tightening compresses the bodies, and the bolt loses that part of its preload"
        facts.append(Fact("the contact carries", pressed, unit.force, note=note))
    return facts


def _told(value: object, units: Mapping[str, str] = MappingProxyType({})) -> str:
    """A JSON value in one line; numbers under a key that has a unit are followed by it."""
    if isinstance(value, dict):
        parts = [(key, _told(part, {**units, "": units.get(key, "")})) for key, part in value.items()]
        return ", ".join(text if key in BARE else f"{WORDS.get(key, key)} {text}" for key, text in parts)
    if isinstance(value, list):
        inner = [_told(part) for part in value]
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
