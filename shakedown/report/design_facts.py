"""Where a joint is safe over one or two parameters, and what it does over the amplitude of a load."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.registry import BOUNDS, Claim
from shakedown.ground.shown_values import DIGITS, count, few, sized
from shakedown.ground.size_limits import EACH_SHOWN
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.units import units_of
from shakedown.report import notes
from shakedown.report.data_facts import headline
from shakedown.report.facts import Fact, Rounding, Section, Sheet, Table, number

if TYPE_CHECKING:
    from shakedown.assessment.damping import DampingCurve
    from shakedown.ground.float_array import FloatArray
    from shakedown.joint.problem import Problem
    from shakedown.studies.sweep import Sweep

SHORT = {  # regions of a design, by what is said of them
    "proved from every state": "every state",
    "proved from this state": "this state",
    "depends on the state": "not decided",
    "never": "impossible",
    "no joint": "no joint",
}
SAID = {
    "proved from every state": "proved from every state",
    "proved from this state": "proved from this state",
    "depends on the state": "not decided",
    "never": "impossible in contact",
}
COLUMNS = {Claim.EVERY_STATE: "every state", Claim.THIS_STATE: "this state", Claim.IMPOSSIBLE: "impossible"}
TIED = 10.0**-DIGITS  # as a fraction of the largest limit: differences not shown
LONGEST_HEADING = 14  # characters of the name of a parameter
SHOWN = 5  # digits of limits and of the points of a curve


def sweep_sheet(problem: Problem, found: Sweep, load_factor: float = 1.0) -> Sheet:
    """Where the joint is safe under a load factor, where it does best, every limit at every point.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = shakedown.sweep(joint, {"f": [0.2, 0.4, 0.6]})
    >>> for fact in sweep_sheet(joint, found, 0.7).facts[:3]:
    ...     print(fact.label, fact.value, sep=": ")
    at λ = 0.7 proved from every state: f = 0.4
    at λ = 0.7 proved from this state: f = 0.6
    at λ = 0.7 impossible in contact: f = 0.2
    """
    regions = found.regions(load_factor)
    facts = [Fact("contradiction", text) for text in found.contradictions]
    facts += [
        Fact(f"at λ = {load_factor:g} {text}", _places(found, regions == name))
        for name, text in SAID.items()
        if name in regions
    ]
    facts += _best(found)
    missing = [point for point in found.points if not point.exists]
    facts += (
        [Fact("no joint", f"at {len(missing)} of {len(found.points)} points", note=missing[0].reason)]
        if missing
        else []
    )
    said = [notes.AT_VALUES] * (len(found.points) > 1) + [notes.LOAD_DOMAIN] * problem.is_domain
    said += [notes.OF_ZONES] * any(bool(point.open_nodes) for point in found.points)
    sections = [Section("", (), [_limits(found, load_factor)], said), *_small_slips(problem, found)]
    if found.load_factors_simulated:
        simulated = [[str(o) if point.exists else "–" for o in point.outcomes] for point in found.points]
        heads = [*_names(found), *(f"λ = {x:g}" for x in found.load_factors_simulated)]
        rows = [[*_values(point.values), *row] for point, row in zip(found.points, simulated, strict=True)]
        keys = len(found.parameters)
        sections.append(Section("Simulated from this state", (), [Table(heads, rows, (), keys)]))
    return Sheet(headline(problem), (), None, facts, sections)


def _best(found: Sweep) -> list[Fact]:
    """Where each limit is largest."""
    limits: list[tuple[str, FloatArray, Rounding]] = [
        ("proved from every state", found.universal, "down"),
        ("proved from this state", found.from_this_state, "down"),
        ("impossible above", found.upper, "up"),
    ]
    facts = []
    for name, values, rounding in limits if len(found.points) > 1 else []:
        if np.isfinite(values).any() and not np.isinf(values).any():
            largest = float(np.nanmax(values))
            tied = values >= largest * (1.0 - TIED)
            where = "at every point" if tied.all() else f"at {_places(found, tied)}"
            facts.append(Fact(f"largest “{name}”", largest, rounding=rounding, note=where))
    return facts


def _places(found: Sweep, chosen: NDArray[np.bool_]) -> str:
    """Some of the computed points: by value, or counted where many are consecutive or two parameters vary."""
    places = np.argwhere(chosen)
    if len(places) == 1:
        return ", ".join(_valued(found, axis, [k]) for axis, k in enumerate(places[0]))
    if len(found.parameters) == 2:
        return f"{len(places)} of {chosen.size} points"
    runs = np.split(places[:, 0], np.flatnonzero(np.diff(places[:, 0]) > 1) + 1)
    listed = [int(k) for run in runs if len(run) <= EACH_SHOWN for k in run]
    ends = [(run, found.values[0][run[[0, -1]]]) for run in runs if len(run) > EACH_SHOWN]
    ranges = [
        f"{len(run)} values from {few(low, DIGITS)} to {few(high, DIGITS)}" for run, (low, high) in ends
    ]
    return ", ".join([*([_valued(found, 0, listed)] if listed else []), *ranges])


def _valued(found: Sweep, axis: int, places: list[int]) -> str:
    """A parameter with some of its values; with × where they are factors."""
    values = ", ".join(few(found.values[axis][k], DIGITS) for k in places)
    factor = found.is_factor(axis)
    return f"{found.meanings[axis]} × {values}" if factor else f"{found.parameters[axis]} = {values}"


def _values(values: tuple[float, ...]) -> list[str]:
    return [number(value, 5) for value in values]


def _names(found: Sweep) -> list[str]:
    """Headings of the parameters."""
    names = []
    for axis, name in enumerate(found.parameters):
        named = name if found.meanings[axis] else with_unit(name, found.units[axis])
        own = named if len(named) <= LONGEST_HEADING else shortened(name, LONGEST_HEADING)
        names.append(f"{found.meanings[axis]} ×" if found.is_factor(axis) else own)
    return names


def _limits(found: Sweep, load_factor: float) -> Table:
    """Every limit at every point, rounded to the safe side, and the region of a load factor."""
    limits: dict[str, tuple[FloatArray, Rounding]] = {}
    for name in found.bounds:
        kind = BOUNDS[name]
        here = kind.claim == Claim.THIS_STATE
        values = found.from_this_state if here else found.load_factors(name)
        rounding: Rounding = "up" if kind.claim == Claim.IMPOSSIBLE else "down"
        limits[COLUMNS.get(kind.claim, kind.symbol)] = values.ravel(), rounding
    regions = found.regions(load_factor).ravel()
    rows = [
        [
            *_values(point.values),
            SHORT[str(regions[k])],
            *(number(values[k], SHOWN, rounding) for values, rounding in limits.values()),
        ]
        for k, point in enumerate(found.points)
    ]
    keys = len(found.parameters)
    return Table([*_names(found), f"at λ = {load_factor:g}", *limits], rows, (keys,), keys)


def _small_slips(problem: Problem, found: Sweep) -> list[Section]:
    """Up to which load factor slips stay below a length, where the user asked for it."""
    known = [
        (point, slips)
        for point, slips in zip(found.points, found.slip_criteria, strict=True)
        if slips is not None
    ]
    if not known:
        return []
    unit = units_of(problem).length
    rows = [
        [*_values(point.values), number(slips.load_factor, SHOWN, "down"), number(slips.largest)]
        for point, slips in known
    ]
    head = [*_names(found), "λ", with_unit("largest slip range", unit)]
    title = f"Slips below {sized(known[0][1].below, unit)}, starting from this state"
    return [Section(title, (), [Table(head, rows, ())])]


def damping_sheet(problem: Problem, curve: DampingCurve) -> Sheet:
    """Dissipation and stiffness over the amplitude of a load, and up to where there is no damping."""
    name = f" ({shortened(curve.load_name, 40)})" if curve.load_name else ""
    stiffness = curve.unit.stiffness or "not said by the problem"
    facts = [
        Fact("load", f"{curve.load}{name}", note=f"at {count(len(curve.amplitude), 'amplitude')}"),
        Fact("displacement", curve.unit.moved(curve.problem), note=f"stiffness: {stiffness}"),
        *_without_damping("proved", curve.proved_limit),
        *_without_damping("simulated", curve.simulated_limit),
    ]
    said = [notes.NO_DISPLACEMENT] if np.isnan(curve.displacement).all() else []
    if curve.from_zero is not None:
        where = ", ".join(number(a, SHOWN) for a in curve.amplitude[curve.differs])
        facts += (
            [Fact("the start decides", f"at {where}", note="ends elsewhere from the first state")]
            if where
            else []
        )
        said += [] if where else [notes.SAME_FROM_START]
    return Sheet(headline(problem), (), None, facts, [Section("", (), [_curve(problem, curve)], said)])


def _without_damping(how: str, limit: float) -> list[Fact]:
    """Up to which amplitude there is no friction damping."""
    if np.isnan(limit):
        return []
    at = "at any amplitude" if np.isinf(limit) else f"up to {number(limit, SHOWN, 'down')}"
    return [Fact(f"no damping, {how}", at, note="from the first state")]


def _curve(problem: Problem, curve: DampingCurve) -> Table:
    columns = {
        "amplitude": curve.amplitude,
        "displacement": curve.displacement,
        with_unit("loss", units_of(problem).work): curve.dissipation,
    }
    if np.isnan(curve.load_frequency):
        columns |= {"stiffness": curve.secant_stiffness, "η": curve.loss_factor}
    else:
        columns |= {"ω / 2π": curve.frequency / (2 * np.pi), "ζ": curve.damping_ratio}
    outcomes = [
        "slides away" if slides else f"{outcome}{', proved' * bool(sure)}"
        for outcome, sure, slides in zip(curve.outcome, curve.proved, curve.slides_away, strict=True)
    ]
    rows = [
        [*(number(float(x), SHOWN) for x in row), outcome]
        for *row, outcome in zip(*columns.values(), outcomes, strict=True)
    ]
    return Table([*columns, "outcome"], rows, (len(columns),))
