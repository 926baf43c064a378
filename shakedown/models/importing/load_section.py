"""``[[load]]``, ``[supports]`` and ``[check]``: what acts and when, what is held, static runs elsewhere."""

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from shakedown.ground.constants import DIRECTIONS, MINOR, MOST_ENTRIES, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import ProblemError, found_in
from shakedown.models.condensation.condense import Condensation
from shakedown.models.condensation.load_case import LoadCase
from shakedown.models.importing.contact_section import check_order
from shakedown.models.importing.stiffness_section import HOOP, ImportContext
from shakedown.models.readers import nodal_vectors
from shakedown.models.readers.abaqus import ELEMENT, read_nodal_loads, read_substructure_load
from shakedown.models.readers.nastran import read_op4_entries
from shakedown.models.readers.nodal_vectors import NodalVectors, What
from shakedown.models.readers.parsing import InputFiles, listed, quoted, read_lines, read_table, unfit
from shakedown.models.readers.toml_table import TomlTable, Values, values_of

Factors = tuple[FloatArray, tuple[str, ...]]  # at the load steps, () or (m,); doubts about them


def time_function(table: TomlTable, steps: int | None, files: InputFiles) -> Factors:
    """The key ``history`` of a load: factors at the load steps t = k/m of one period, () or (m,), and doubts.

    A number is a constant; a list holds the factors themselves; a table holds

    - ``constant`` and ``harmonics`` = [{order, cos, sin}, …]: constant +
      Σ cos · cos 2π order t + sin · sin 2π order t;
    - or ``points`` = [[t, factor], …], 0 ≤ t ≤ 1, straight lines between, closed
      from the last to the first;
    - or ``file``: a table of numbers, with ``column`` (its heading, or its number
      from 1) where it has several. With ``time`` (a column) and ``period`` (in the
      same unit) the values are sampled at the load steps, straight lines between;
      else each row is one load step.

    Raises
    ------
    ProblemError
        If the key is missing or malformed, or a function is given without the
        number of steps.

    Examples
    --------
    >>> from pathlib import Path
    >>> load = TomlTable({"history": {"constant": 1.0, "harmonics": [{"order": 1, "sin": 0.5}]}}, "load 1")
    >>> time_function(load, 4, InputFiles(Path(".")))[0]
    array([1. , 1.5, 1. , 0.5])
    """
    given = table.content.get("history")
    if given is None:
        raise table.missing("history", "a number, a list or a table")
    if isinstance(given, list):
        return np.array(table.array("history", float, (None,)), dtype=float), ()
    if not isinstance(given, dict):
        return np.array(table.number("history")), ()
    function = table.table("history")
    kinds = [key for key in ("harmonics", "points", "file") if function.has(key)]
    if len(kinds) != 1:
        raise function.unfit("one of harmonics, points and file", len(kinds))
    if kinds[0] == "file":
        found = _from_file(function, steps, files)
    else:
        found = (_harmonics if kinds[0] == "harmonics" else _points)(function, _steps(function, steps))
    function.done()
    return found


def _steps(table: TomlTable, steps: int | None) -> FloatArray:
    """t = k/m at the load steps."""
    if steps is None or not 1 <= steps <= MOST_ENTRIES:
        found = "none" if steps is None else steps
        raise table.unfit(f"'steps' from 1 to {MOST_ENTRIES} at the top of the file", found)
    return np.arange(steps) / steps


def _harmonics(table: TomlTable, t: FloatArray) -> Factors:
    constant, terms = table.number("constant", 0.0) or 0.0, list[tuple[int, float, float]]()
    for term in table.tables("harmonics"):
        order = term.integer("order") if term.has("order") else 1
        if order is None or order < 0:
            raise term.wrong("order", "a whole number from 0", order)
        terms.append((order, term.number("cos", 0.0) or 0.0, term.number("sin", 0.0) or 0.0))
        term.done()

    def at(t: FloatArray) -> FloatArray:
        total = np.full(len(t), constant)
        for order, cos, sin in terms:
            phase = 2 * np.pi * (order * t % 1.0)
            total += cos * np.cos(phase) + sin * np.sin(phase)
        return total

    highest = max((order for order, *parts in terms if any(parts)), default=0)
    if 2 * highest > len(t):  # at the load steps it looks like one of another order
        hidden = f"its {len(t)} load step(s) do not show its harmonic of order {highest}"
        return at(t), (f"{hidden}: more than {2 * highest} 'steps' do",)
    fine = np.linspace(0.0, 1.0, DIRECTIONS * min(highest, MOST_ENTRIES // DIRECTIONS) + 1)
    return _checked(at(t), at(fine))


def _checked(sampled: FloatArray, peaks: FloatArray) -> Factors:
    """Factors, and a doubt where the function goes further at its ``peaks``, between the load steps."""
    low, high = peaks.min(), peaks.max()
    share = max(high - sampled.max(), sampled.min() - low) / (high - low) if high > low else 0.0
    if share <= MINOR:
        return sampled, ()
    return sampled, (
        f"its {len(sampled)} load step(s) miss {100 * share:.3g} % of its range: it lies between "
        f"{low:.4g} and {high:.4g}, at the load steps between {sampled.min():.4g} and {sampled.max():.4g}; "
        "more 'steps' show it",
    )


def _straight(t: FloatArray, times: FloatArray, values: FloatArray, *, whole: bool) -> Factors:
    """Straight lines between values; closed from the last to the first, unless they are ``whole`` periods."""
    return _checked(np.interp(t, times, values, period=None if whole else 1.0), values)


def _points(table: TomlTable, t: FloatArray) -> Factors:
    times, values = np.array(table.array("points", float, (None, 2)), dtype=float).T
    down = np.flatnonzero(np.diff(times) < 0)
    if times.min() < 0 or times.max() > 1 or down.size:
        found = f"t from {times.min():g} to {times.max():g}"
        if down.size:
            found = f"t = {times[down[0] + 1]:g} after {times[down[0]]:g}"
        raise table.unfit("points with 0 <= t <= 1 in ascending order", found)
    return _straight(t, times, values, whole=times[-1] == 1 and times[0] == 0)


def _from_file(table: TomlTable, steps: int | None, files: InputFiles) -> Factors:
    name, column, time = str(table.text("file")), table.key_of_column("column"), table.key_of_column("time")
    period = table.number("period")
    rows = files.read(name, read_table, table.at("file"))
    width = rows.values.shape[1]
    if column is None and width > 1 + (time is not None):
        names = listed(rows.columns) if rows.columns else f"1 to {width}"
        raise table.unfit(f"the key 'column' (one of {names})", "none")
    if column is None:
        column = 1 if width == 1 or not np.array_equal(rows.column(time or 1), rows.column(1)) else 2
    values = rows.column(column)
    if (time is None) != (period is None):
        found = "'time'" if period is None else "'period'"
        raise table.unfit("the keys 'time' and 'period' together", f"{found} alone")
    if time is None or period is None:
        return values, ()
    t, times = _steps(table, steps), rows.column(time)  # of the period that begins with the first row
    down = np.flatnonzero(np.diff(times) < 0)
    # times are printed with few digits
    if not period > 0 or down.size or times[-1] - times[0] > period * (1 + SIX_DIGITS):
        found = f"{times.min():g} to {times.max():g}"
        if down.size:
            found = f"{times[down[0] + 1]:g} after {times[down[0]]:g} in line {rows.lines[down[0] + 1]}"
        raise unfit(rows.name, f"times in ascending order within one period of {period:g}", found)
    passed = (times - times[0]) / period
    sampled, doubts = _straight(t, passed, values, whole=abs(passed[-1] - 1.0) <= SIX_DIGITS)
    unrecorded = 1.0 - passed[-1]
    # share of the period that may be missing after the last row of a record
    if unrecorded > max(0.05, 2 * np.diff(passed).max(initial=0.0)):
        doubts += (
            f"its record covers {100 * passed[-1]:.3g} % of the period of {period:g}, and goes straight back "
            "to its beginning for the rest: are 'time' and 'period' in one unit?",
        )
    return sampled, doubts


@dataclass(frozen=True)
class LoadSection:
    """A load case, the rows that it moves, and doubts."""

    case: LoadCase
    prescribed: IntArray
    doubts: tuple[str, ...] = ()


def load_section(table: TomlTable, context: ImportContext) -> LoadSection:
    """Take one load case from its table."""
    listed, moved = _forces(table, context), values_of(context.mesh, table, "displacements")
    displacement = np.zeros(len(context.stiffness.dofs))
    rows = context.rows(table.at("displacements"), moved or {})
    displacement[rows] = list((moved or {}).values())
    given = [key for key in ("reactions", "thermal") if table.has(key)]
    if given and context.mesh.axisymmetric and not context.checked:
        raise table.wrong(
            given[0],
            "'forces' (on the whole circumference) or 'open' for an axisymmetric model, or [check] "
            "with a run that moves contact nodes radially",
            f"neither; {HOOP}",
        )
    reactions, clamped = _clamped_run(table, context)
    acting = [each for each in (listed, clamped, _thermal_forces(table, context)) if each is not None]
    force = np.sum(acting, axis=0) if acting else None
    opened = _opened_run(table, context)
    limits = table.array("range", float, (2,), required=False)
    if limits is not None and table.has("history"):
        raise table.unfit("one of the keys 'history' and 'range'", "both")
    history, doubts = (None, ()) if limits is not None else time_function(table, context.steps, context.files)
    case = LoadCase(
        history=history,
        range=limits,
        force=force,
        displacement=None if moved is None else displacement,
        reactions=reactions,
        opened=opened,
        mean=table.number("mean"),
        transient=table.array("transient", float, (None,), required=False),
        value=table.number("value"),
        unit=table.text("unit", "") or "",
        frequency=table.number("frequency"),
        name=table.text("name", table.where) or table.where,
    )
    table.done()
    return LoadSection(case, rows, doubts)


def _forces(table: TomlTable, context: ImportContext) -> FloatArray | None:
    """Forces on all rows, from a list or from a file."""
    if not isinstance(table.content.get("forces"), dict):
        listed = values_of(context.mesh, table, "forces")
        return None if listed is None else _spread(table.at("forces"), listed, context)
    source = table.table("forces")
    name, scale = str(source.text("file")), source.number("scale", 1.0) or 0.0
    case, matrix = source.text("case", required=False), source.text("matrix", required=False)
    column = source.integer("column")
    source.done()
    if matrix is not None:
        read = partial(_op4_column, matrix=matrix, column=column, size=len(context.stiffness.dofs))
        return scale * context.files.read(name, read, source.at("file"))
    found = context.files.read(name, partial(_nodal_loads, case=case), source.at("file"))
    return scale * _spread(source.where, found, context)


def _nodal_loads(path: Path, case: str | None) -> Values:
    """A load case of a substructure, or ``node, dof, value`` lines."""
    if any(map(ELEMENT.match, read_lines(path))):
        return read_substructure_load(path, case)
    if case is not None:
        raise unfit(path, "no key 'case', because the file is no substructure", quoted(case))
    return read_nodal_loads(path)


def _op4_column(path: Path, matrix: str, column: int | None, size: int) -> FloatArray:
    """One column of a matrix of loads on the rows of the stiffness."""
    values = read_op4_entries(path, matrix)
    rows, count = values.shape
    if rows != size:
        raise unfit(path, f"{matrix} of {size} rows", rows)
    if (column is None and count > 1) or not 1 <= (1 if column is None else column) <= count:
        raise unfit(f"{path}: key 'column'", f"1 to {count}", "none" if column is None else column)
    found, own = np.zeros(size), values.col == (column or 1) - 1
    found[values.row[own]] = values.data[own]
    return found


def _spread(where: str, values: Values, context: ImportContext) -> FloatArray:
    """Values of (node, direction) pairs on all rows; 0 elsewhere."""
    spread = np.zeros(len(context.stiffness.dofs))
    spread[context.rows(where, values)] = list(values.values())
    return spread


def held_rows(supports: TomlTable, context: ImportContext, loads: list[LoadSection]) -> IntArray:
    """The rows that ``[supports]`` and prescribed displacements keep from moving freely."""
    fixed = values_of(context.mesh, supports, "fixed", valued=False)
    supports.done()
    own = context.rows(supports.at("fixed"), fixed or {})
    return np.concatenate([own, *(load.prescribed for load in loads)])


def _run_of(source: TomlTable, what: What, context: ImportContext) -> NodalVectors:
    """The step of a file that a table names, times a factor, along x, y, z: ``file``, ``step``, ``scale``."""
    name, step, scale = str(source.text("file")), source.integer("step"), source.number("scale", 1.0) or 0.0
    read = partial(nodal_vectors.read_nodal_vectors, what=what)
    runs = context.files.read(name, read, source.at("file"))
    step = 1 if step is None and len(runs) == 1 else step
    if step is None or not 1 <= step <= len(runs):
        raise source.wrong("step", f"1 to {len(runs)}", "none" if step is None else step)
    run = runs[step - 1]
    unknown = sorted(run.local - set(context.mesh.rotated))
    if unknown:
        raise source.unfit(
            f"{what} along x, y, z, or the *TRANSFORM of the deck in [model]",
            f"those of node {unknown[0]} in directions of its own (*NODE PRINT, GLOBAL=YES writes x, y, z)",
        )
    if context.mesh.is_known:
        run = nodal_vectors.in_model_directions(run, context.mesh.directions_of)
    return replace(run, vectors=scale * run.vectors)


def _clamped_run(table: TomlTable, context: ImportContext) -> tuple[FloatArray | None, FloatArray | None]:
    """``reactions``: at the nodes of the first body, (n, d + 1); or forces (N,) of both bodies held apart.

    Each node then carries minus its reaction.
    """
    contact = context.contact
    if not isinstance(table.content.get("reactions"), dict):
        listed = table.array("reactions", float, (None, len(contact.axes)), required=False)
        check_order(contact, table.where, {"reactions": listed})
        return (None if listed is None else np.array(listed, dtype=float)), None
    source = table.table("reactions")
    bodies = source.text("bodies", None if contact.two_bodies else "")
    known = ["tied", "clamped"][contact.coupling is not None :] if contact.two_bodies else [""]
    if bodies not in known:
        raise source.wrong(
            "bodies",
            "'clamped' (reactions of both bodies, each held by itself) for surfaces or pairs, 'tied' (of the "
            "first, the bodies tied to each other) for pairs, and none for nodes",
            f"'{bodies}'",
        )
    run = _run_of(source, "reactions", context)
    source.done()
    if bodies != "clamped":
        return run.at(contact.first, contact.axes, contact.tied), None
    forces = run.at(contact.clamped, contact.axes)
    keys = [(int(node), axis) for node in contact.clamped for axis in contact.axes]
    values = dict(zip(keys, (-forces).ravel().tolist(), strict=True))
    return None, _spread(table.at("reactions"), values, context)


def _thermal_forces(table: TomlTable, context: ImportContext) -> FloatArray | None:
    """``thermal``: minus the reactions of a run in which every node was held, on all rows.

    Raises
    ------
    ProblemError
        If a node with rows was not printed, CalculiX did not print that all were held, or
        there is nothing to hold.
    """
    if not table.has("thermal"):
        return None
    source = table.table("thermal")
    if context.stiffness.superelement:
        raise table.wrong(
            "thermal",
            "a matrix of all nodes",
            "a superelement; run the load with the contact nodes held and give their 'reactions', or with "
            "the contact open ('open')",
        )
    twin = source.copy()
    run = _run_of(source, "reactions", context)
    source.done()
    if run.by_calculix:
        _check_held(twin, context)
    dofs = context.stiffness.dofs
    moving = np.isin(dofs[:, 1], (1, 2, 3))
    force = np.zeros(len(dofs))
    with found_in(source.where):
        places = run.places(dofs[moving, 0], "node")
    force[moving] = -run.vectors[places, dofs[moving, 1] - 1]
    turned = [node for node in dofs[force != 0, 0].tolist() if node in context.mesh.rotated]
    if turned:
        raise source.unfit("nodes with directions x, y, z", f"node {turned[0]} in a *TRANSFORM")
    return force


def _check_held(source: TomlTable, context: ImportContext) -> None:
    """Refuse reactions beside displacements that are not all zero."""
    try:
        run = _run_of(source, "displacements", context)
    except ProblemError as error:
        raise ProblemError(
            f"{source.where}: expected displacements beside the reactions, which show that every node was "
            f"held (*NODE PRINT: U, RF); {error}"
        ) from None
    moved = np.flatnonzero(run.vectors.any(axis=1))
    if moved.size:
        largest = np.abs(run.vectors[moved[0]]).max()
        found = f"node {run.nodes[moved[0]]} displaced by {largest:.3g}"
        raise source.unfit("every node held (*BOUNDARY)", found)


def _opened_run(table: TomlTable, context: ImportContext) -> FloatArray | None:
    """``open``: displacements of the contact nodes with the contact open (of pairs u₁ − u₂)."""
    if not table.has("open"):
        return None
    source, contact, coupling = table.table("open"), context.contact, context.contact.coupling
    run = _run_of(source, "displacements", context)
    source.done()
    with found_in(source.where):
        if coupling is None:
            first, *second = (
                run.vectors[run.places(nodes)] for nodes in contact.labels.reshape(len(contact.labels), -1).T
            )
            apart = first - sum(second)
        else:
            d = coupling.normals.shape[1]
            apart = np.zeros((len(contact.labels), d))
            found = coupling.opening(lambda nodes: run.vectors[run.places(nodes)][:, :d])
            apart[contact.positions(coupling.labels)] = found
    if np.abs(apart).max() <= SIX_DIGITS * np.abs(run.vectors).max():  # nothing but printed digits
        raise source.unfit(
            "displacements with the contact open",
            f"contact nodes that do not move{' apart' * contact.two_bodies} (held, tied or in contact? then "
            "'reactions')",
        )
    return np.asarray(apart[:, [axis - 1 for axis in contact.axes]])


def static_run(table: TomlTable, reduced: Condensation, context: ImportContext, stiffness_file: str) -> float:
    """``[check]``: the largest difference from an independent static run, NaN where there is none.

    Raises
    ------
    ProblemError
        If it differs, or the run is the file that the stiffness was made from.
    """
    if not table.content:
        return float("nan")
    contact, source = context.contact, table.content.get("reactions")
    if contact.coupling is not None:
        raise table.unfit("no static run beside 'surfaces', which need contact to move together", "one")
    if isinstance(source, dict) and context.files.same(str(source.get("file")), stiffness_file):
        found = "the file that the stiffness was made from, which agrees with itself"
        raise table.wrong("reactions", "a run of its own", found)
    moved = values_of(context.mesh, table, "displacements")
    reactions, clamped = _clamped_run(table, context)
    table.done()
    if moved is None or reactions is None or clamped is not None:
        raise table.unfit("the keys 'displacements' and 'reactions' (of the first body)", "others")
    displacement = np.zeros((reduced.n, len(contact.axes)))
    for (node, direction), value in moved.items():
        here = contact.first == node
        if not here.any() or direction not in contact.axes:
            expected = f"contact nodes and directions {contact.axes}"
            raise table.wrong("displacements", expected, f"node {node}, direction {direction}")
        displacement[here, contact.axes.index(direction)] = value
    if context.mesh.axisymmetric and not displacement[:, 0].any():
        expected = "a contact node of an axisymmetric model that moves radially (direction 1)"
        raise table.wrong("displacements", expected, "none")
    what = f"{table.where} (on the whole circumference)" if context.mesh.axisymmetric else table.where
    return reduced.check_against_run(displacement, reactions, what=what)
