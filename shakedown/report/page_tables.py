"""The tables of a report on bounds, runs, nodes and meshes, as formatted text."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from shakedown.assessment.runs import Run
from shakedown.assessment.verify import Verification
from shakedown.ground.errors import Missing, present
from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, down, up
from shakedown.ground.status import Status, named
from shakedown.ground.visible_text import with_unit
from shakedown.joint.problem import Problem
from shakedown.joint.result import LINES
from shakedown.joint.units import units_of
from shakedown.long_term.simulation import Simulation
from shakedown.report.assessment_words import IN_CONTACT
from shakedown.report.limit_words import transient_limit_as_text
from shakedown.report.mesh_words import MESH_NUMBERS, told_of_meshes
from shakedown.report.node_words import (
    bound_columns,
    node_columns,
    open_in_words,
    resolution,
    without_round_off,
    worst_first,
)
from shakedown.report.run_words import start_remark
from shakedown.studies.refined import Refinement

WORST = 10  # nodes shown where there are many


@dataclass(frozen=True)
class PageTable:
    """A table: heading, rows, the columns that hold words, and the rows to print where not all are."""

    head: Sequence[str]
    rows: Sequence[Sequence[str]]
    words: tuple[int, ...] = (0,)
    printed: frozenset[int] | None = None


def bounds_table(v: Verification) -> PageTable:
    """Every limit of the load factor; λ_1 and λ_max by both solvers."""
    upper, transient = v.limits.upper.load_factor, v.transient
    scale = upper if np.isfinite(upper) else 1.0  # the nominal load; a bound may be zero
    begins = v.limits.energy.least_load_factor
    least = f" from {up(begins)} on" if begins > 0 else ""
    pairs = [(_name_of_largest(v), upper, v.second.upper.load_factor)]
    lower, again = v.limits.lower, v.second.lower
    if not isinstance(lower, Missing) and again is not None:
        pairs.insert(0, (named("λ_1"), lower.load_factor, again.load_factor))
    proved = [
        (f"{named('λ_U')}, {IN_CONTACT}{_over(v)}", _bound(v.limits.universal.load_factor)),
        (f"{named('λ_E')}{least}", _bound(v.limits.energy.load_factor)),
        (named("λ_S"), _bound(v.limits.accumulated.load_factor)),
        (
            named("λ_T") + ", proved there" * transient_is_proved(v),
            "–" if transient is None else _bound(float(transient_limit_as_text(transient))),
        ),
    ]
    rows = [[*row, "–", "–"] for row in proved]
    for name, one, two in pairs:
        rounded = up if name.startswith("λ_max") else down
        rows.append([name, _bound(one, rounded), _bound(two, rounded), _difference(one, two, scale)])
    return PageTable(["", "load factor", "independent solver (Clarabel)", "relative difference"], rows)


def _over(v: Verification) -> str:
    """The additional condition of λ_U where there are transient load steps."""
    return ", transient over" * v.limits.universal.after_transient


def _bound(value: float, rounded: Callable[[float, int], str] = down) -> str:
    """A limit of the load factor, rounded to the safe side."""
    return rounded(value, DIGITS) if np.isfinite(value) else number(value)


def _name_of_largest(v: Verification) -> str:
    opened = v.limits.upper.open_nodes
    if opened:
        return f"λ_max of the zone: a safe slip exists with {open_in_words(opened, v.problem)} open"
    return named("λ_max")


def _difference(one: float, two: float, scale: float) -> str:
    if not (np.isfinite(one) and np.isfinite(two)):
        return "–"
    size = max(abs(one), abs(two), scale)
    return f"{abs(one - two) / size:.1e}" if size else "0"


def number(value: float, digits: int = 6) -> str:
    """A number as the page shows it: a dash where there is none."""
    if np.isnan(value):
        return "–"
    return f"{value:.{digits}g}" if np.isfinite(value) else ("∞" if value > 0 else "−∞")


def limits_on_page(v: Verification) -> dict[str, float]:
    """Limits by name, rounded to the safe side; NaN where there is none.

    Only the larger of λ_E and λ_S is included.
    """
    upper = v.limits.upper  # without a safe slip nothing is possible above 0
    nothing_safe = upper.status == Status.INFEASIBLE
    largest = {"λ_max": v.assessment.impossible_above if nothing_safe else upper.load_factor}
    others = {
        v.limits.from_state.symbol: v.limits.from_state.load_factor,
        "λ_T": np.nan if v.transient is None else float(transient_limit_as_text(v.transient)),
        "λ_U": v.limits.universal.load_factor,
    }
    if not isinstance(v.limits.lower, Missing):
        others["λ_1"] = v.limits.lower.load_factor
    down_to = {name: float(down(value)) for name, value in others.items()}
    return down_to | {name: float(up(value)) for name, value in largest.items()}


def transient_is_proved(v: Verification) -> bool:
    """Whether shakedown is proved at λ_T itself, not only simulated."""
    return v.transient is not None and v.transient.proved == v.transient.load_factor


def runs_table(v: Verification, *, brief: bool = False) -> PageTable:
    """Every simulation with its prediction; ``brief`` selects the columns that fit a terminal."""
    units = units_of(v.problem)
    rows = [_run_row(v.problem, run) for run in v.runs]
    slip, work = with_unit("slip per period", units.length), with_unit("dissipation per cycle", units.work)
    head = ["λ", "region", "initial state", "predicted", "simulated", "", "agree", "cycles", slip, work]
    table = [[*head, "law residual", "time"], *rows]
    if brief:
        chosen = [[row[k] for k in (0, 2, 3, 4, 6, 8, 10)] for row in table]
    else:  # remarks follow the outcome
        chosen = [[*row[:4], row[4] + row[5], *row[6:]] for row in table]
    return PageTable(chosen[0], chosen[1:], words=(1, 2, 3, 4, 5))


def _run_row(problem: Problem, run: Run) -> list[str]:
    s = run.simulation
    slip, work = resolution(problem, s.load_factor)
    return [
        number(s.load_factor),
        run.region,
        run.initial + start_remark(run),
        run.predicted,
        str(s.outcome),
        remarks(s),
        {True: "yes", False: "NO", None: "–"}[run.agrees],
        str(s.cycles_simulated),
        number(max(without_round_off(s.slip_per_cycle, slip)), FEW_DIGITS),
        number(without_round_off([s.dissipation_per_cycle], work.max())[0], FEW_DIGITS),
        "–" if np.isnan(s.residual) else f"{s.residual:.0e}",
        f"{1e3 * run.seconds:.1f} ms",
    ]


def remarks(run: Simulation) -> str:
    """Remarks on a long-term state: period, jumps, open nodes, proof."""
    found = [f"period {run.period}"] if run.period > 1 else []
    if run.jumps_per_cycle > 0:
        lost = number(run.jump_dissipation_per_cycle, FEW_DIGITS)
        found.append(f"jumps per cycle: {run.jumps_per_cycle:g}, damping dissipates {lost}")
    if run.open_nodes:
        found.append(f"open throughout: {open_in_words(run.open_nodes)}")
    if run.proved:
        found.append("proved")
    return f" ({'; '.join(found)})" if found else ""


def nodes_table(v: Verification) -> PageTable:
    """Node by node: slips of the bounds, limits reached, friction threshold, results at λ = 1."""
    problem, limits, units = v.problem, v.limits, units_of(v.problem)
    run, none = v.as_given.simulation, resolution(problem, 1.0)
    slips = without_round_off(run.slip_per_cycle, none[0])
    works = without_round_off(run.period * run.settled.work_per_cycle, none[1])
    columns: dict[str, Sequence[str]] = {"node": list(map(str, range(problem.n)))}
    columns |= {} if problem.label is None else {"FE label": problem.label}
    evidence = present(limits.lower), present(limits.friction)
    columns |= bound_columns(problem, limits.upper, number, *evidence)
    columns[with_unit("slip per period at λ = 1", units.length)] = [
        number(slip, FEW_DIGITS) for slip in slips
    ]
    work = with_unit("friction work per period at λ = 1", units.work)
    columns[work] = [number(each, FEW_DIGITS) for each in works]
    if not np.isnan(v.nodes.total_slip_bound).all():
        slip_bound = with_unit("slip in all at most at λ = 1", units.length)
        columns[slip_bound] = [up(each, FEW_DIGITS) for each in v.nodes.total_slip_bound]
    words = [k for k, name in enumerate(columns) if name in ("FE label", "reached at λ_max")]
    return PageTable(list(columns), list(zip(*columns.values(), strict=True)), tuple(words), printed_nodes(v))


def printed_nodes(v: Verification) -> frozenset[int] | None:
    """The nodes printed where there are too many for paper: the worst; None where all are printed."""
    return None if v.problem.n <= LINES else frozenset(worst_nodes(v))


def worst_nodes(v: Verification) -> list[int]:
    """The nodes with the largest slip range in the long term at λ = 1, then with the largest pressure."""
    return worst_first(v.nodes, v.problem)[:WORST]


def worst_table(v: Verification) -> PageTable | None:
    """Results of the worst nodes in the long term under the nominal load; None where that is not known."""
    problem, nodes = v.problem, v.nodes
    if not nodes.period:
        return None
    labels = {} if problem.label is None else {"FE label": problem.label}
    columns = node_columns(nodes, problem)
    names = {word: with_unit(word.replace("_", " "), nodes.units[word]) for word in columns}
    shown = {"node": [str(j) for j in range(problem.n)], **labels, "status": nodes.status}
    shown |= {names[word]: [number(value) for value in values] for word, values in columns.items()}
    rows = [[column[j] for column in shown.values()] for j in worst_nodes(v)]
    return PageTable(list(shown), rows, words=tuple(range(1, 2 + len(labels))))


def no_state_in_words(v: Verification) -> str:
    """Why there are no results per node."""
    return f"no long-term state at λ = 1: {v.nodes.reason}"


def nodes_note(v: Verification) -> str:
    """Which nodes the first table of nodes shows, and where to find all of them."""
    if not v.nodes.period:
        return f"There are no results per node: {no_state_in_words(v)}."
    shown = "Every node" if v.problem.n <= WORST else f"The {WORST} worst nodes of {v.problem.n}"
    return (
        f"{shown} over one period of the long-term state at λ = 1, the largest slip range first, then the "
        "largest p. At a sharp edge pressure, wear and τ δ of the last node depend on the mesh, however fine "
        "it is; slips do not. All nodes with all digits are in the JSON beside this page (“nodes”), and as a "
        "table or for ParaView: shakedown-bounds nodes FILE --load-factor 1 -o nodes.csv (or .vtu)."
    )


def refinement_table(found: Refinement, problem: Problem, meshes: int = 3) -> PageTable:
    """For each number its values on the finest meshes, its trend, limit and order."""
    units, last = units_of(problem), slice(max(0, len(found.nodes) - meshes), None)
    unit = {"work": units.work, "largest_slip": units.length}
    rows = []
    for name in told_of_meshes(found):
        trend = found.trends[name]
        values = [number(float(value), FEW_DIGITS) for value in found.numbers[name][last]]
        about = [str(trend.verdict), number(trend.limit, FEW_DIGITS), number(trend.order, 2)]
        rows.append([with_unit(MESH_NUMBERS[name][0], unit.get(name, "")), *values, *about])
    nodes = [f"{count} nodes" for count in found.nodes[last]]
    return PageTable(["", *nodes, "verdict", "limit", "order"], rows, words=(0, len(nodes) + 1))
