"""What the first page shows below its answer: three large numbers and one table."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from shakedown.assessment.verify import Verification
from shakedown.ground.errors import Missing
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import down, sized
from shakedown.joint.units import units_of
from shakedown.long_term.node_table import STATUSES
from shakedown.report.assessment_words import at_load_factor, loads_of_numbers, numbers_in_words
from shakedown.report.limit_words import digits_of_transient_limit, onsets_in_words
from shakedown.report.node_words import no_node_ever_slips, node_columns, node_in_words
from shakedown.report.page_tables import PageTable, no_state_in_words, transient_is_proved

HOW = {
    "stick": "stick",
    "slip": "slip",
    "open": "open",
    "mixed": "open at times",
    "undecided": "undecided",
}


class LargeNumber(NamedTuple):
    """One of the three numbers: its name, its value in the user's loads or as a load factor, a remark."""

    name: str
    value: str
    remark: str


def large_numbers(v: Verification) -> list[LargeNumber]:
    """Proved from every state, proved from this state, impossible above: in the user's loads where said."""
    every, *others = numbers_in_words(v.assessment)
    numbers = [(*every[:2], f"whatever slip is locked in, {every[2]}"), *others]
    return [
        LargeNumber(name, loads or factor, f"{factor}, {remark}" if loads else remark)
        for (name, factor, remark), loads in zip(numbers, loads_of_numbers(v.assessment), strict=True)
    ]


def rest_table(v: Verification) -> PageTable:
    """The largest results per node at λ = 1, and the other limits, rounded down."""
    return PageTable(
        ["long-term state at λ = 1, and limits", "value", "where, and what it is"],
        [*_node_rows(v), *_limit_rows(v)],
        words=(0, 2),
    )


def _node_rows(v: Verification) -> list[list[str]]:
    """The largest results per node for the nominal load, each with its node."""
    nodes = v.nodes
    if not nodes.period:
        return [["results per node", "–", no_state_in_words(v)]]
    units = units_of(v.problem)
    columns = node_columns(nodes, v.problem)
    slip, path, taken = (columns[word] for word in ("slip_range", "accumulated_slip", "work"))
    rows = [
        _largest(v, "largest slip range", slip, units.length, "distance between its extreme slips"),
        _largest(v, "largest slip per cycle", path, units.length, "the length of its way to and fro, Σ|Δv|"),
        _largest(v, "largest friction work per cycle", taken, units.work, "of one node"),
        ["friction work per cycle, all nodes", sized(float(taken.sum()), units.work), ""],
    ]
    if not (slip > 0).any() and not (path > 0).any():
        rows = [
            [
                "slip and friction work per cycle",
                "0",
                "no node ever slips, proved" if no_node_ever_slips(nodes) else "no node slips",
            ]
        ]
    if np.isnan(nodes.area).all():
        rows.append(_largest(v, "largest normal force", nodes.p_max, units.force, "over the cycle"))
    else:
        over = "its normal force over its area"
        rows.append(_largest(v, "largest pressure", nodes.pressure_max, units.stress, over))
    counts = [(nodes.status.count(status), HOW[status]) for status in STATUSES]
    there = [f"{'all' if many == v.problem.n else many} {how}" for many, how in counts if many]
    rows.append(["nodes", str(v.problem.n), ", ".join(there)])
    return rows


def _largest(v: Verification, name: str, values: FloatArray, unit: str, what: str) -> list[str]:
    """A row with the largest of the values per node, and its node."""
    if np.isnan(values).all():
        return [name, "–", what]
    most = int(np.nanargmax(values))
    if not values[most] > 0:
        return [name, sized(0.0, unit), "at no node"]
    return [name, sized(values[most], unit), f"{node_in_words(v.problem, most)}: {what}"]


def _limit_rows(v: Verification) -> list[Sequence[str]]:
    """First slip and opening, and limits that are no guarantee: λ_T, λ_1, that of small slips."""
    rows, problem = list[Sequence[str]](), v.problem
    for name, load_factor, remark in onsets_in_words(v.limits):
        number = at_load_factor(problem, load_factor, down) if 0 < load_factor < np.inf else "–"
        rows.append([name, number, remark])
    limit = v.transient
    if limit is not None and np.isfinite(limit.load_factor):
        proved = " (proved there)" * transient_is_proved(v)
        digits = digits_of_transient_limit(limit)
        what = f"λ_T: largest load factor at which the simulation shakes down{proved}"
        rows.append(["simulated limit", at_load_factor(problem, limit.load_factor, down, digits), what])
    collapse = v.limits.lower
    if not isinstance(collapse, Missing) and np.isfinite(collapse.load_factor):
        where = f"; {node_in_words(problem, collapse.node)} loses it there" if collapse.node >= 0 else ""
        what = f"λ_1: below it every node keeps a range of slips between its friction limits{where}"
        rows.append(["first collapse", at_load_factor(problem, collapse.load_factor, down), what])
    small = v.slip_limit
    if small is not None and np.isfinite(small.load_factor):
        what = f"simulated: every slip range stays below {sized(small.below, units_of(problem).length)}"
        rows.append(["small slips", at_load_factor(problem, small.load_factor, down), what])
    return rows
