"""What a joint is: size, loads, doubts about its data, where the data come from."""

from __future__ import annotations

import json
from typing import Any

from shakedown.ground.shown_values import count
from shakedown.ground.visible_text import LONGEST_NAME, one_line
from shakedown.joint.doubtful_data import doubtful_data
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips, zero_modes
from shakedown.joint.units import loads_in_words
from shakedown.report.facts import Fact
from shakedown.report.node_names import AXES, node_in_words
from shakedown.report.notes import FLOATING, LOAD_DOMAIN

SHOWN = 5  # digits of places and loads


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
    steps = f"these {count(problem.m, 'load step')}"
    return Fact("load path", steps, note="joined by straight lines, repeated")


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
    """Where the data come from: command, bodies with their loads, bolts, files with their SHA-256."""
    source: dict[str, Any] = json.loads(problem.source) if problem.source else {}
    facts = []
    for key, value in source.items():
        if key == "files":
            for each in value:
                facts.append(Fact(str(each.get("name", "file")), f"SHA-256 {each.get('sha256', '–')}"))
        elif key not in ("configuration", "warnings"):
            parts = value if key in ("bodies", "bolts") and isinstance(value, list) else [value]
            for k, part in enumerate(parts, 1):
                facts.append(Fact(f"{key}{f' {k}' * (len(parts) > 1)}".replace("_", " "), _told(part)))
    return [*facts, Fact("arrays of the problem", f"SHA-256 {problem.fingerprint}")]


def _told(value: object) -> str:
    """A JSON value in one line."""
    if isinstance(value, dict):
        return ", ".join(f"{key} {_told(part)}" for key, part in value.items() if part not in ([], {}, None))
    if isinstance(value, list):
        return f"({', '.join(map(_told, value))})"
    return f"{value:.7g}" if isinstance(value, float) else str(value)


def configuration(problem: Problem) -> tuple[str, str]:
    """The configuration of the import, its name and its text; empty where none is stored."""
    source: dict[str, Any] = json.loads(problem.source) if problem.source else {}
    found = source.get("configuration", "")
    if isinstance(found, dict) and isinstance(found.get("text"), str):
        return str(found.get("name", "")), found["text"]
    if isinstance(found, dict) and "name" in found:
        return str(found["name"]), "Too long to be kept with the problem; its SHA-256 is among the sources."
    return "", found if isinstance(found, str) else json.dumps(found, indent=1, ensure_ascii=False)
