"""What a joint is: size, loads, doubts, nodes by name, where its data come from; what an import has read."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import TYPE_CHECKING, Any

import numpy as np

from shakedown.ground.constants import EACH_SHOWN, NEGLIGIBLE
from shakedown.ground.shown_values import LONGEST_NAME, count, few, one_line, shortened, sized, with_unit
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import loading
from shakedown.joint.contact_zone import coupled_parts, of_nodes
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips, zero_modes
from shakedown.joint.units import doubtful_data, loads_in_words, units_of
from shakedown.motion.checked_law import path_resolution, scales
from shakedown.report.facts import Fact, Section, Sheet, Table, notes, number

if TYPE_CHECKING:
    from shakedown.ground.constants import FloatArray
    from shakedown.long_term.node_results import NodeResults
    from shakedown.models.condensation.surface_coupling import SurfaceCoupling
    from shakedown.models.importing.import_model import Import


AXES = "xy"  # of the two tangential directions of a node
COLUMNS = (  # of a table of results per node; the first ones are kept where the table is narrow
    "slip_range", "accumulated_slip", "work", "p_max", "p_min", "q_max",
    "pressure_max", "shear_max", "tau_delta", "wear_depth", "total_slip_bound",
)  # fmt: skip
LONGEST_ENTRY = 24  # characters of a label in a table


def node_in_words(problem: Problem | None, node: int) -> str:
    """One node, with its label in the model where it has one.

    Examples
    --------
    >>> import shakedown
    >>> node_in_words(shakedown.example("press-fit"), 1), node_in_words(None, 1)
    ('node 1 (FE 37/1)', 'node 1')
    """
    return f"node {node if problem is None else problem.node_name(node)}"


def open_in_words(nodes: tuple[int, ...], problem: Problem | None = None) -> str:
    """Nodes by number, consecutive ones as ranges, with labels where they are few.

    Examples
    --------
    >>> import shakedown
    >>> open_in_words((3,)), open_in_words((0, 1, 2, 3, 7, 8))
    ('node 3', 'nodes 0–3, 7, 8')
    >>> open_in_words((0, 1, 8), shakedown.example("press-fit"))
    'nodes 0, 1, 8 (FE 36/0, 37/1, 44/8)'
    """
    if len(nodes) == 1:
        return node_in_words(problem, nodes[0])
    text, labels = f"nodes {ranges(nodes)}", None if problem is None else problem.label
    if labels is None or len(nodes) > EACH_SHOWN:
        return text
    return f"{text} (FE {', '.join(labels[i] for i in nodes)})"


def node_column(problem: Problem) -> dict[str, list[str]]:
    """The columns that say which node a row is about: its number, and its label where it has one.

    Examples
    --------
    >>> import shakedown
    >>> list(node_column(shakedown.example("press-fit"))), list(node_column(shakedown.example("two-node")))
    (['node', 'FE'], ['node'])
    """
    columns = {"node": list(map(str, range(problem.n)))}
    if problem.label is not None:
        columns["FE"] = [shortened(label, LONGEST_ENTRY) for label in problem.label]
    return columns


def without_round_off(values: Sequence[float] | FloatArray, resolution: float | FloatArray) -> list[float]:
    """Values for display: those within the resolution of a result, or of each, become zero.

    Examples
    --------
    >>> without_round_off([5.6e-15, 2.0, float("nan")], 1e-10)
    [0.0, 2.0, nan]
    """
    none = np.broadcast_to(resolution, len(values))
    return [0.0 if abs(value) <= least else float(value) for value, least in zip(values, none, strict=True)]


def resolution(
    problem: Problem, load_factor: float, tolerances: Tolerances = DEFAULT
) -> tuple[FloatArray, FloatArray]:
    """The slip [length] and the work [force × length] of each node per period that count as none, (n,).

    They are the resolution of a path (:func:`path_resolution`) times the scales of the joint there, of the
    part of it that the node is coupled with.
    """
    parts, share = coupled_parts(problem), path_resolution(problem, tolerances)
    known = [(part.joint.n, scales(part.joint, load_factor)) for part in parts]
    slip = of_nodes(parts, (np.full(n, share * each.length) for n, each in known))
    return slip, of_nodes(parts, (np.full(n, share * each.length * each.force) for n, each in known))


def node_columns(nodes: NodeResults, problem: Problem) -> dict[str, FloatArray]:
    """Results per node, round-off as 0, by their names in a file; without columns that are all unknown."""
    none = resolution(problem, nodes.load_factor)
    opens = np.where(np.isin(nodes.status, ("open", "mixed")), np.inf, 0.0)  # no force while it is open
    resolved = {"slip_range": none[0], "accumulated_slip": none[0], "work": none[1]}
    resolved |= {"p_min": opens, "pressure_min": opens}
    columns = {
        word: np.array(without_round_off(getattr(nodes, word), resolved.get(word, 0.0))) for word in COLUMNS
    }
    return {word: values for word, values in columns.items() if not np.isnan(values).all()}


def by_direction(problem: Problem, name: str, slips: FloatArray) -> dict[str, list[float]]:
    """A column of slips, or with two tangential directions one column for each.

    Examples
    --------
    >>> import shakedown
    >>> by_direction(shakedown.example("one-node-3d"), "slip", np.array([1.0, 2.0]))
    {'slip x': [1.0], 'slip y': [2.0]}
    """
    names = [name] if problem.directions == 1 else [f"{name} {axis}" for axis in AXES]
    return dict(zip(names, problem.layout.by_node(slips).T.tolist(), strict=True))


def ranges(numbers: Sequence[int]) -> str:
    """Increasing numbers, consecutive ones as ``first–last``."""
    runs = [
        [number for _, number in run]
        for _, run in groupby(enumerate(numbers), key=lambda pair: pair[1] - pair[0])
    ]
    return ", ".join(f"{run[0]}–{run[-1]}" if len(run) > 2 else ", ".join(map(str, run)) for run in runs)


def headline(problem: Problem, *, limits: bool = False) -> list[str]:
    """Name, size and friction; loads at λ = 1; what is doubtful, a line each.

    Above limits also what λ does not scale.

    Examples
    --------
    >>> import shakedown
    >>> headline(shakedown.example("two-node"))
    ['two-node system (5.3.1): 2 nodes, 50 load steps, f = 0.35']
    """
    name = one_line(problem.name, LONGEST_NAME) or "unnamed problem"
    nodes = count(problem.n, "node") + " (3-D)" * (problem.directions > 1)
    steps = count(problem.m, "load step")
    if problem.is_domain:
        steps = f"load domain of {count(problem.m, 'corner')}"
    units = f", in {one_line(problem.units, LONGEST_NAME)}" if problem.units else ""
    lines = [f"{name}: {nodes}, {steps}, f = {friction(problem)}{units}"]
    lines += [f"loads at λ = 1: {loads_in_words(problem)}"] if problem.loads else []
    lines += [f"warning: {doubt}" for doubt in doubts(problem)]
    return lines + constant_load(problem) * (limits and not problem.loads)


def constant_load(problem: Problem) -> list[str]:
    """What λ does not scale; that it is an assumption where the problem does not say it.

    Examples
    --------
    >>> import shakedown
    >>> constant_load(shakedown.example("two-node"))
    ['constant load: mean of steps, assumed (no q_mean, p_mean); λ scales the rest']
    """
    varying = {"q_mean": loading(problem).q1, "p_mean": loading(problem).p1}
    unsaid = [name for name, part in varying.items() if part.any() and getattr(problem, name) is None]
    if not any(part.any() for part in varying.values()):
        return []
    known = f"mean of steps, assumed (no {', '.join(unsaid)})" if unsaid else "as given"
    return [f"constant load: {known}; λ scales the rest"]


def examples_sheet(known: dict[str, Problem]) -> Sheet:
    """Some problems, a row each."""
    columns = {
        "name": list(known),
        "nodes": [str(problem.n) for problem in known.values()],
        "load steps": [str(problem.m) for problem in known.values()],
        "": [problem.name for problem in known.values()],
    }
    return Sheet([], sections=[Section(tables=[Table.of(columns, ("name", ""))])])


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
    return [Fact("slips relative to", ", ".join(named), note=notes.floating)] if named else []


def load_path(problem: Problem) -> Fact:
    """For which path of the loads the limits hold."""
    if problem.is_domain:
        return Fact("load path", "any in the domain", note=notes.load_domain)
    steps = f"these {count(problem.m, 'load step')}"
    return Fact("load path", steps, note="joined by straight lines, repeated")


def joint_facts(problem: Problem) -> list[Fact]:
    """What a page says of the joint besides its headline: load cases, transient, rigid motions."""
    stiffness = problem.A if problem.C is None else problem.kappa
    free = count(zero_modes(stiffness, problem.stiffness_accuracy), "rigid motion")
    held = f"{len(rigid_slips(problem).pinned)} of them held by friction alone"
    facts = []
    if problem.load_names and not problem.loads:
        facts.append(Fact("load cases", ", ".join(problem.load_names)))
    if problem.q_transient is not None:
        before = count(len(problem.q_transient), "load step")
        facts.append(Fact("transient", before, note="before the first period"))
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
    if not isinstance(found, dict):
        return "", str(found)
    return str(found.get("name", "")), str(found.get("text", notes.too_long))


def import_sheet(made: Import, *, written: str | None = None) -> Sheet:
    """Where the joint comes from, and the file that it was written to.

    Where none was, pairs, bodies, resultants, nodes, and whether to go on.
    """
    reduced = made.condensation
    doubts = count(len(made.doubts), "warning")
    go_on = "GO ON: no warnings. Compare bodies, loads and normals below with the model."
    stop = f'STOP: {doubts} to clear up, or to accept (accept = ["its words"]), before any number is trusted.'
    rows = f"{reduced.interior} rows condensed, {reduced.held} held"
    facts = [*(Fact("note", note) for note in made.notes), Fact("read from", made.format, note=rows)]
    if made.static_run == made.static_run:
        facts.append(Fact("agrees with static run", f"to {number(made.static_run, 2)}"))
    if written is not None:
        return Sheet([f"wrote {written}", *headline(made.problem)], (), None, facts)
    facts += [
        *_contact(made),
        *_bodies(made),
        Fact("rigid motions", str(reduced.zero_modes), note="of the contact nodes, without resistance"),
        Fact("asymmetry", f"{reduced.asymmetry:.1e}", note=f"forces left inside {reduced.residual:.1e}"),
    ]
    if made.rigid_residual == made.rigid_residual:
        held = " and ".join(body.name for body in made.evidence.bodies if not body.free)
        why = f"as supports hold {held}" if held else "of a model that nothing holds about 0"
        facts.append(Fact("resists rigid motion", f"{made.rigid_residual:.1e}", note=f"of max |K|; {why}"))
    files = [Fact(f"read {name}", f"sha256 {digest[:16]}…") for name, digest in made.sources.items()]
    sections = [_loads(made), _nodes(made), Section("", files)]
    return Sheet(headline(made.problem), [go_on if made.ready else stop], None, facts, sections)


def _contact(made: Import) -> Iterator[Fact]:
    """How far apart the nodes of the pairs lie, and which patches there are."""
    unit = units_of(made.problem).length
    for part, pairs in zip(made.contact.parts, made.evidence.pairs, strict=True):
        of = f"{part.name}: " if part.name else ""
        if part.surfaces is not None:
            yield from _surfaces(part.surfaces, of, unit)
        if pairs is not None:
            along, across = pairs.along, np.abs(pairs.across)
            yield Fact(f"{of}pairs apart, along", _largest(along, pairs.off, unit), note="the surface")
            yield Fact(f"{of}pairs apart, across", _largest(across, pairs.apart, unit), note="the surface")


def _largest(distance: FloatArray, share: FloatArray, unit: str) -> str:
    """The largest distance, the mean, and the largest in terms of the spacing."""
    known = distance.any() and np.isfinite(share).any()
    spacing = f", {few(np.nanmax(share), 2)} of the spacing" if known else ""
    return f"at most {sized(distance.max(), unit, 3)}{spacing} (mean {few(distance.mean(), 3)})"


def _surfaces(found: SurfaceCoupling, of: str, unit: str) -> Iterator[Fact]:
    """How two surfaces that need not match lie on each other."""
    length = f" {unit}" if unit else ""
    in_plane = found.places.shape[1] == 2  # a profile, whatever its thickness or circumference
    extent, what = (length, "lengths") if in_plane else (f"{length}²" if unit else "", "areas")
    shares = " and ".join(f"{100 * share:.4g} %" for share in found.share)
    yield Fact(f"{of}surfaces", f"{len(found.labels)} and {len(found.master)} nodes")
    yield Fact(f"{of}overlap", f"{few(found.overlap, 4)}{extent}", note=f"{shares} of their {what}")
    apart = f"{few(found.distance[0], 3)} to {few(found.distance[2], 3)}{length}"
    yield Fact(f"{of}surfaces apart", apart, note=f"reach {few(found.reach, 3)}")
    if found.uncovered.size:
        yield Fact(
            f"{of}without partner", count(found.uncovered.size, "node"), note=f"first {found.uncovered[0]}"
        )


def _bodies(made: Import) -> Iterator[Fact]:
    for body in made.evidence.bodies:
        held = f"free but for the contact: {', '.join(body.free)}" if body.free else "held by supports"
        yield Fact(body.name, count(len(body.nodes), "node"), note=f"{body.contact_nodes} in contact; {held}")


def _loads(made: Import) -> Section:
    """Forces and moments of every load, on bodies and patches."""
    axes, unit, places = made.contact.axes, units_of(made.problem), made.contact.coordinates
    letters = ["xyz"[axis - 1] for axis in axes]
    about = letters if len(axes) == 3 else ["xyz"[({1, 2, 3} - set(axes)).pop() - 1]]
    heads, middle, extent = [with_unit(f"F{a}", unit.force) for a in letters], "", None
    if places is not None and not np.isnan(made.loads[0].parts[0].moment).all():
        heads += [with_unit(f"M{a}", unit.work) for a in about]
        extent, at = np.ptp(places, axis=0).max(), places.mean(axis=0)
        at[np.abs(at) <= NEGLIGIBLE * extent] = 0.0  # round-off
        middle = f"Moments about the middle of the contact, ({', '.join(map(few, at.tolist()))})."
    rows = []
    for load in made.loads:
        cells, moments = (np.array([getattr(part, of) for part in load.parts]) for of in ("force", "moment"))
        force = float(np.nanmax(np.abs(cells)))
        cells[np.abs(cells) <= NEGLIGIBLE * force] = 0.0
        if extent is not None:
            moments[np.abs(moments) <= NEGLIGIBLE * max(float(np.abs(moments).max()), force * extent)] = 0.0
            cells = np.hstack([cells, moments])
        rows.append([shortened(load.name, 28), *[""] * len(heads)])  # characters
        for part, numbers in zip(load.parts, cells.tolist(), strict=True):
            rows.append([f"  {part.what}", *(number(x, 5) for x in numbers)])
    title = "Loads at factor 1, the contact welded"
    return Section(title, (), [Table(["", *heads], rows)], [middle] if middle else [])


def _nodes(made: Import) -> Section:
    """The table of nodes: places, normals, tangents, areas, gaps; common values stand above it."""
    reduced, contact, problem = made.condensation, made.contact, made.problem
    unit, facts = units_of(problem), list[Fact]()
    columns = {"node": list(map(str, range(reduced.n))), "label": list(contact.names)}
    if contact.coordinates is not None:
        for axis, place in zip("xyz", contact.coordinates.T, strict=False):
            columns[with_unit(axis, unit.length)] = [f"{x:.6g}" for x in place]
    directions = {"normal": reduced.frame.normals, **({"tangent": made.tangents[0]} if made.tangents else {})}
    for name, vectors in directions.items():
        shown = [" ".join(few(x) for x in vector) for vector in (vectors.round(4) + 0.0).tolist()]
        if len(set(shown)) == 1:
            facts.append(Fact(f"{name} of every node", shown[0]))
        else:
            columns[name] = shown
    if made.tangents:
        facts.append(Fact("second tangent", "normal × tangent"))
    if problem.node_area is not None:
        columns[with_unit("area", unit.area)] = [f"{x:.5g}" for x in problem.node_area]
    if contact.gap.any():
        gap = np.broadcast_to(contact.gap, reduced.n)
        columns[with_unit("gap", unit.length)] = [f"{x:.4g}" for x in gap]
    return Section("Nodes", facts, [Table.of(columns, ("label", *directions), 2)])
