"""What `import` has read of a model, before anything is computed with it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.shown_values import count, few, sized
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.units import units_of
from shakedown.report.data_facts import headline
from shakedown.report.facts import Fact, Section, Sheet, Table, number

if TYPE_CHECKING:
    from shakedown.ground.float_array import FloatArray
    from shakedown.models.condensation.surface_coupling import SurfaceCoupling
    from shakedown.models.importing.import_model import Import
    from shakedown.models.importing.load_evidence import LoadEvidence, LoadPart

LONGEST_LOAD = 28  # characters of the name of a load


def import_sheet(made: Import, *, check: bool) -> Sheet:
    """Where the joint comes from; with ``check`` pairs, bodies, resultants, nodes, and whether to go on."""
    reduced = made.condensation
    doubts = count(len(made.doubts), "warning")
    go_on = "GO ON: no warnings. Compare bodies, loads and normals below with the model."
    stop = f'STOP: {doubts} to clear up, or to accept (accept = ["its words"]), before any number is trusted.'
    facts = [Fact("note", note) for note in made.notes]
    facts.append(
        Fact("read from", made.format, note=f"{reduced.interior} rows condensed, {reduced.held} held")
    )
    if made.static_run == made.static_run:
        facts.append(Fact("agrees with static run", f"to {number(made.static_run, 2)}"))
    if not check:
        return Sheet(headline(made.problem), (), None, facts)
    facts += [
        *_contact(made),
        *_bodies(made),
        Fact("rigid motions", str(reduced.zero_modes), note="of the contact nodes, without resistance"),
        Fact("asymmetry", f"{reduced.asymmetry:.1e}", note=f"forces left inside {reduced.residual:.1e}"),
    ]
    if made.rigid_residual == made.rigid_residual:
        share = f"{made.rigid_residual:.1e}"
        facts.append(
            Fact("rigid residual", share, note="share of its stiffness that rigid motions of the model meet")
        )
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
            yield Fact(f"{of}pairs apart, along", _largest(pairs.along, pairs.off, unit), note="the surface")
            yield Fact(
                f"{of}pairs apart, across",
                _largest(np.abs(pairs.across), pairs.apart, unit),
                note="the surface",
            )
    patches = int(made.evidence.patches.max()) + 1
    if patches > 1 and not made.contact.patches:
        sizes = np.bincount(made.evidence.patches).tolist()
        firsts = [made.contact.names[int(np.argmax(made.evidence.patches == k))] for k in range(patches)]
        named = ", ".join(f"{many} nodes from {name}" for many, name in zip(sizes, firsts, strict=True))
        yield Fact("patches", str(patches), note=named)


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
    size = f"{few(found.finer, 2)} times those of the second"
    yield Fact(f"{of}facets of the first", size, note=f"largest weight {few(found.largest_weight, 3)}")
    slip = f"a turn of 1 rad would slip by {few(found.chord, 2)}{length}, which is put right"
    yield Fact(f"{of}shape", "flat and parallel" if found.flat else "curved", note="" if found.flat else slip)


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
        rows.append([shortened(load.name, LONGEST_LOAD), *[""] * len(heads)])
        rows += [[f"  {part.what}", *cells] for part, cells in _cells(load, extent)]
    title = "Loads at factor 1, the contact welded"
    return Section(title, (), [Table(["", *heads], rows)], [middle] if middle else [])


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
        yield part, [number(x if not abs(x) <= NEGLIGIBLE * largest else 0.0, 5) for x, largest in sizes]


def _nodes(made: Import) -> Section:
    """The table of nodes: places, normals, tangents, areas, gaps; what is the same for all is said once."""
    reduced, contact, problem = made.condensation, made.contact, made.problem
    unit, facts = units_of(problem), list[Fact]()
    columns = {"node": list(map(str, range(reduced.n))), "label": list(contact.names)}
    if made.evidence.patches.any() and not contact.patches:
        columns["patch"] = [str(patch + 1) for patch in made.evidence.patches.tolist()]
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
