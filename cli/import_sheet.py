"""What `shakedown-bounds import --check` shows of a model before anything is computed with it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

import shakedown
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.shown_values import few
from shakedown.ground.visible_text import shortened
from shakedown.joint.units import units_of
from shakedown.report.text_table import table

from .output import columns as shown_columns
from .output import paragraph, say

if TYPE_CHECKING:
    from shakedown.ground.float_array import FloatArray
    from shakedown.models.condensation.surface_coupling import SurfaceCoupling
    from shakedown.models.importing.load_evidence import LoadEvidence, LoadPart

LONGEST_LOAD = 28  # characters of the name of a load
SAME_SIZE = 0.05  # relative difference up to which facets of two surfaces count as equal in size


def go_or_not(made: shakedown.Import) -> str:
    """Whether to go on, in one line."""
    if made.ready:
        return "GO ON: no warnings. Compare bodies, loads and normals below with the model."
    count = len(made.doubts)
    return f"STOP: {count} warning{'s' * (count > 1)} to clear up before any number is trusted."


def echo_sheet(made: shakedown.Import) -> None:
    """Pairs, bodies, resultants of the loads, nodes, files."""
    reduced, unit = made.condensation, units_of(made.problem).length
    for line in _pairs(made, unit):
        say(paragraph(line))
    for body in made.evidence.bodies:
        held = f"free but for the contact: {', '.join(body.free)}" if body.free else "held by supports"
        say(paragraph(f"{body.name}: {len(body.nodes)} nodes, {body.contact_nodes} in contact; {held}"))
    say(f"rigid motions of the contact nodes without resistance: {reduced.zero_modes}")
    accuracy = f"asymmetry {reduced.asymmetry:.1e}, forces left inside {reduced.residual:.1e}"
    if made.rigid_residual == made.rigid_residual:
        accuracy += f"; rigid motions of the model meet {made.rigid_residual:.1e} of its stiffness"
    say(paragraph(accuracy))
    say("")
    _echo_loads(made)
    say("")
    _echo_nodes(made, unit)
    for name, digest in made.sources.items():
        say(f"read {name}  sha256 {digest[:16]}…")


def _pairs(made: shakedown.Import, unit: str) -> Iterator[str]:
    """How far apart the nodes of the pairs lie, and which patches there are."""
    patches = int(made.evidence.patches.max()) + 1
    for part, pairs in zip(made.contact.parts, made.evidence.pairs, strict=True):
        of = f"{part.name}: " if part.name else ""
        if part.surfaces is not None:
            yield from (f"{of}{line}" for line in _surfaces(part.surfaces, unit))
        if pairs is not None:
            each = (("along", pairs.along, pairs.off), ("across", np.abs(pairs.across), pairs.apart))
            told = [
                f"{_largest(*own)} {way} the surface (mean {few(own[0].mean(), 3)})" for way, *own in each
            ]
            yield f"{of}pairs lie apart by at most {' and '.join(told)}{f', in {unit}' if unit else ''}"
    if patches > 1 and not made.contact.patches:
        sizes = np.bincount(made.evidence.patches).tolist()
        firsts = [made.contact.names[int(np.argmax(made.evidence.patches == k))] for k in range(patches)]
        named = [f"{many} from {name}" for many, name in zip(sizes, firsts, strict=True)]
        yield f"{patches} patches of the contact, by nodes: {', '.join(named)}"


def _surfaces(found: SurfaceCoupling, unit: str) -> Iterator[str]:
    """How two surfaces that need not match lie on each other."""
    length = f" {unit}" if unit else ""
    in_plane = found.places.shape[1] == 2  # a profile, whatever its thickness or circumference
    extent, what = (length, "lengths") if in_plane else (f"{length}²" if unit else "", "areas")
    shares = " and ".join(f"{100 * share:.4g} %" for share in found.share)
    yield (
        f"surfaces of {len(found.labels)} and {len(found.master)} nodes lie on each other over "
        f"{few(found.overlap, 4)}{extent}, {shares} of their {what}, {few(found.distance[0], 3)} to "
        f"{few(found.distance[2], 3)}{length} apart (reach {few(found.reach, 3)})"
    )
    if found.uncovered.size:
        yield f"{found.uncovered.size} node(s) of the first have no partner, first {found.uncovered[0]}"
    size = "as large as" if abs(found.finer - 1) < SAME_SIZE else f"{few(found.finer, 2)} of"
    shape = "flat and parallel"
    if not found.flat:
        shape = f"curved: a turn of 1 rad would slip by {few(found.chord, 2)}{length}, which is put right"
    yield (
        f"facets of the first are {size} those of the second; largest weight "
        f"{few(found.largest_weight, 3)}; {shape}"
    )


def _largest(distance: FloatArray, share: FloatArray) -> str:
    """The largest distance, and the largest in terms of the spacing."""
    known = distance.any() and np.isfinite(share).any()
    return f"{few(distance.max(), 3)}{f', {few(np.nanmax(share), 2)} of the spacing,' if known else ''}"


def _echo_loads(made: shakedown.Import) -> None:
    """Forces and moments of every load, on bodies and patches."""
    axes, units, places = made.contact.axes, units_of(made.problem), made.contact.coordinates
    letters = ["xyz"[axis - 1] for axis in axes]
    about = letters if len(axes) == 3 else ["xyz"[({1, 2, 3} - set(axes)).pop() - 1]]
    unit, middle, extent = units.force, "", None
    if places is not None and not np.isnan(made.loads[0].parts[0].moment).all():
        unit = ", ".join(filter(None, (units.force, units.work)))
        extent, at = np.ptp(places, axis=0).max(), places.mean(axis=0)
        at[np.abs(at) <= NEGLIGIBLE * extent] = 0.0  # round-off
        middle = f"; moments about the middle of the contact, ({', '.join(map(few, at.tolist()))})"
    say(paragraph(f"loads at factor 1{f' [{unit}]' if unit else ''}, the contact welded{middle}"))
    columns = [f"F{a}" for a in letters] + ([f"M{a}" for a in about] if middle else [])
    rows = []
    for load in made.loads:
        rows.append([shortened(load.name, LONGEST_LOAD), *[""] * len(columns)])
        rows += [[f"  {part.what}", *cells] for part, cells in _cells(load, extent)]
    width = max(len(row[0]) for row in rows)
    whole = [["", *columns], *([row[0].ljust(width), *row[1:]] for row in rows)]
    for part in _narrow(whole, len(letters)):
        say(table(part[0], part[1:], longest=len(rows)))


def _narrow(rows: list[list[str]], forces: int) -> list[list[list[str]]]:
    """The rows as one table; where that is wider than the terminal as two: forces, and moments."""
    width = sum(max(map(len, column)) + 2 for column in zip(*rows, strict=True))
    if width <= shown_columns() or len(rows[0]) == 1 + forces:
        return [rows]
    return [[row[: 1 + forces] for row in rows], [[row[0], *row[1 + forces :]] for row in rows]]


def _cells(load: LoadEvidence, extent: float | None) -> Iterator[tuple[LoadPart, list[str]]]:
    """The parts of a load with their numbers as texts: round-off is 0, what is not known a dash.

    Moments are left out without the ``extent`` of the model, by which they are compared with forces.
    """
    force = max(float(np.nanmax(np.abs(part.force))) for part in load.parts)
    for part in load.parts:
        sizes = [*((x, force) for x in part.force.tolist())]
        if extent is not None:
            turning = max(float(np.abs(each.moment).max()) for each in load.parts)
            sizes += [(x, max(turning, force * extent)) for x in part.moment.tolist()]
        yield part, [_rounded(x, largest) for x, largest in sizes]


def _rounded(value: float, largest: float) -> str:
    """A value, shown as 0 where it is negligible beside the largest resultant of a load."""
    return "-" if value != value else f"{value if abs(value) > NEGLIGIBLE * largest else 0.0:.5g}"


def _echo_nodes(made: shakedown.Import, length: str) -> None:
    """The table of nodes: places, normals, tangents, areas, gaps; what is the same for all is said once."""
    reduced, contact, problem = made.condensation, made.contact, made.problem
    columns = {"label": list(contact.names)}
    if made.evidence.patches.any() and not made.contact.patches:
        columns["patch"] = [str(patch + 1) for patch in made.evidence.patches.tolist()]
    if contact.coordinates is not None:
        columns |= _numbers([f"{a} [{length}]" if length else a for a in "xyz"], contact.coordinates, ".6g")
    directions = {"normal": reduced.frame.normals, **({"tangent": made.tangents[0]} if made.tangents else {})}
    for name, vectors in directions.items():
        shown = [" ".join(few(x) for x in vector) for vector in (vectors.round(4) + 0.0).tolist()]
        if len(set(shown)) == 1:
            say(f"{name} of every node: {shown[0]}")
        else:
            columns[name] = shown
    if made.tangents:
        say("slip along the tangent and a second one at right angles to it: normal x tangent")
    if problem.node_area is not None:
        columns |= _numbers([f"area [{length}²]" if length else "area"], problem.node_area[:, None], ".5g")
    if contact.gap.any():
        gap = np.broadcast_to(contact.gap, reduced.n)[:, None]
        columns |= _numbers([f"gap [{length}]" if length else "gap"], gap, ".4g")
    rows = [[str(k), *cells] for k, cells in enumerate(zip(*columns.values(), strict=True))]
    say(table(["node", *columns], rows))


def _numbers(names: list[str], values: FloatArray, form: str) -> dict[str, list[str]]:
    """Columns of numbers by their headings."""
    return {name: [f"{x:{form}}" for x in column] for name, column in zip(names, values.T, strict=True)}
