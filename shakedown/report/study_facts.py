"""What is known of many: subsets of constraints, initial states, designs, amplitudes, meshes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from shakedown.bounds.registry import BOUNDS, Claim
from shakedown.ground.shown_values import DIGITS, count, shortened, sized, with_unit
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import DEFAULT
from shakedown.joint.constraints import SIDE_NAMES
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.joint.units import units_of
from shakedown.report.data_facts import headline, node_column, open_in_words, resolution, without_round_off
from shakedown.report.facts import Fact, Rounding, Section, Sheet, Table, notes, number
from shakedown.report.run_facts import DOES

if TYPE_CHECKING:
    from shakedown.assessment.damping import DampingCurve
    from shakedown.bounds.bound_result import Bound
    from shakedown.bounds.critical import CriticalLoadFactors
    from shakedown.ground.constants import FloatArray
    from shakedown.joint.problem import Problem
    from shakedown.studies.basin_map import InitialStateMap
    from shakedown.studies.refined import Refinement
    from shakedown.studies.sweep import Sweep


def critical_sheet(problem: Problem, found: CriticalLoadFactors) -> Sheet:
    """The smallest critical load factor, where its limits meet, and where asked for all of them."""
    from shakedown.bounds.lower import lower_bound  # loads the solvers

    facts, texts = critical_facts(found, lower_bound(problem))
    smallest, tables = found.smallest_positive, []
    if smallest.rows:
        limits = ", ".join(f"{problem.node_name(node)} {SIDE_NAMES[side]}" for node, side in smallest.rows)
        facts.append(Fact("limits that meet", limits, note="(node, limit)"))
        slips = [number(slip, DIGITS) for slip in smallest.slip]
        columns = node_column(problem) | {with_unit("slip there", units_of(problem).length): slips}
        tables.append(Table.of(columns))
    if found.load_factors is not None:
        # digits for load factors that may differ little
        rows = [[str(k), number(value, 10)] for k, value in enumerate(found.load_factors)]
        tables.append(Table(["", "critical load factors"], rows))
    return Sheet(headline(problem), (), None, facts, [Section("", (), tables, texts)])


def critical_facts(critical: CriticalLoadFactors, lower: Bound) -> tuple[list[Fact], list[str]]:
    """How many subsets there are, the smallest values, and notes on why these differ from λ_1.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = shakedown.critical_load_factors(joint)
    >>> for fact in critical_facts(found, shakedown.lower_bound(joint))[0]:
    ...     print(fact.label, fact.shown, fact.note, sep=" | ")
    subsets | 4 | 4 with a critical load factor, 0 degenerate
    smallest positive | 0.6573 |
    """
    counted = f"{critical.regular:,} with a critical load factor, {critical.degenerate:,} degenerate"
    facts, smallest = [Fact("subsets", f"{critical.total:,}", note=counted)], critical.smallest_positive
    if not critical.regular:
        return facts, [notes.degenerate] if rigid_slips(lower.problem).pinned else []
    if not smallest.rows:
        return [*facts, Fact("smallest positive", "none")], []
    facts.append(Fact("smallest positive", smallest.load_factor, rounding="down"))
    if smallest.load_factor < lower.load_factor * (1 - DEFAULT.feasibility):
        feasible = critical.smallest_feasible.load_factor
        same = "= λ_1" * bool(np.isfinite(feasible))
        facts.append(Fact("smallest feasible", feasible, rounding="down", note=same))
        return facts, [notes.infeasible_corner]
    return facts, [notes.collapsed_at_mean] if lower.load_factor == 0 else []


SAMPLED = {  # after the number of states
    "grid": "on a grid about {}",
    "sobol": "in a box about {}",
    "ball": "in a ball about the centre of the energy ball",
    "transients": "left behind by random load steps",
}
STATES = {"zero": "zero slip", "given": "the given state", "critical": "the critical state"}
REGION_TYPES = {
    "i": "a safe region and no complementary one, as below the first collapse",
    "ii": "a safe region and a complementary one: the initial state decides",
    "iii": "a complementary region and no safe one: nothing shakes down with both nodes closed",
    "iv": "no bounded safe region and no bounded complementary one",
}
KNOWN = {True: "yes", False: "no", None: "not known"}


def map_sheet(problem: Problem, found: InitialStateMap) -> Sheet:
    """All that is known of a map."""
    texts = [notes.one_path] * problem.is_domain
    texts += [notes.grid] * (found.sampling.sampler == "grid") + [notes.share]
    texts += [notes.untried] * bool(found.same_outcome)
    texts += [notes.spread] if found.limit_cycles else []
    sections = [_limit_cycles(found), Section(notes=texts)]
    return Sheet(headline(problem), [share(found)], None, map_facts(found), sections)


def share(found: InitialStateMap) -> str:
    """Of how many initial states, chosen how, which share shakes down, with its 95 % confidence interval."""
    centre, (low, high) = found.sampling.centre_is, found.interval
    where = SAMPLED[found.sampling.sampler].format(f"{'the ' * ('safe' in centre)}{centre}")
    begin = f"At λ = {found.load_factor:.10g}: of {count(found.sampling.states, 'initial state')} {where}"
    if found.undecided == found.sampling.states:
        return f"{begin} none is decided."
    known = "" if low != low else f" (95 %: {100 * low:.1f}–{100 * high:.1f} %)"
    return f"{begin} {per_cent(found.shakedown_fraction)} shake down{known}."


def per_cent(part: float) -> str:
    """A share of the states in per cent."""
    return f"{100 * part:.1f} %"


def map_facts(found: InitialStateMap) -> list[Fact]:
    """The named states, the number of states per outcome, the dissipation, whether all end alike."""
    unit, none, facts = units_of(found.problem), work_that_is_none(found), []
    for name, outcome, lost in zip(found.sampling.named, found.outcome, found.dissipation, strict=False):
        much = f"dissipation {sized(lost, unit.work)} per cycle" if lost > none else ""
        facts.append(Fact(f"from {STATES[name]}", str(outcome), note=much))
    for word, many in found.outcomes.items():
        facts.append(Fact(word, str(many), note=DOES[Outcome(word)]))
    outcome, period = found.outcome[found.sampled], found.period[found.sampled]
    leave = np.count_nonzero((outcome == "separation") & (period == 0))
    facts += [Fact("of these leave for good", str(leave))] * bool(leave)
    if found.undecided < found.sampling.states:
        least, first, median, third, most = without_round_off(found.dissipation_quartiles, none)
        size = " … ".join(dict.fromkeys(map(number, (least, most))))
        spread = f"quartiles {number(first)}, {number(median)}, {number(third)}" if "…" in size else ""
        facts.append(Fact("dissipation per cycle", f"{size} {unit.work}".rstrip(), note=spread))
        facts.append(Fact("same outcome", KNOWN[found.same_outcome], note="for all states tried"))
        facts.append(Fact("same final state", KNOWN[found.unique], note="for all states tried"))
        if found.unique is False and found.scatter.spread > 0.0:
            note = f"largest {sized(found.scatter.largest, unit.length)}"
            facts.append(Fact("slips at rest differ by", found.scatter.spread, unit.length, "up", note))
    criterion = found.slip_criterion
    if criterion is not None:
        who = "every state" if criterion["met"] else f"{per_cent(criterion['met_fraction'])} of the states"
        largest = f"largest slip range {sized(criterion['largest'], unit.length)}"
        label = f"slips below {sized(criterion['below'], unit.length)}"
        facts.append(Fact(label, f"from {who}", note=largest))
    if kind := found.region_type:
        facts.append(Fact("regions of slip space", f"type ({kind})", note=REGION_TYPES[kind]))
    return facts


def _limit_cycles(found: InitialStateMap) -> Section:
    """How many states end on each limit cycle, or motion with separation."""
    cycles, none = found.limit_cycles, work_that_is_none(found)
    if not cycles:
        return Section()
    lost = [without_round_off(cycle.dissipation, none) for cycle in cycles]
    columns = {
        "limit cycle": [str(cycle.outcome) for cycle in cycles],
        "reached": [" and ".join(f"from {STATES[name]}" for name in cycle.named) for cycle in cycles],
        "states": [str(cycle.count) for cycle in cycles],
        "period": [str(cycle.period) for cycle in cycles],
        "dissipation": [" … ".join(dict.fromkeys(map(number, ends))) for ends in lost],
        "spread": [
            number(0.0 if cycle.coincide else cycle.spread, 2) if cycle.count + len(cycle.named) > 1 else "–"
            for cycle in cycles
        ],
        "slip at": [
            shortened(open_in_words(cycle.slipping_nodes).partition(" ")[2], 16)  # characters
            for cycle in cycles
        ],
    }
    return Section("", (), [Table.of(columns, ("limit cycle", "reached", "slip at"))])


def work_that_is_none(found: InitialStateMap) -> float:
    """The work below which it counts as none."""
    return float(resolution(found.problem, found.load_factor, found.sampling.tolerances)[1].max())


REGIONS = {  # of a load factor, and what a narrow column calls them
    "proved from every state": "every state",
    "proved from this state": "this state",
    "depends on the state": "not decided",
    "never": "impossible",
    "no joint": "no joint",
}
SHOWN = 5  # digits of limits and of the points of a curve


def sweep_sheet(problem: Problem, found: Sweep, load_factor: float = 1.0) -> Sheet:
    """The region of a load factor and every limit at every point; what contradicts, where there is no joint.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = shakedown.sweep(joint, {"f": [0.2, 0.4, 0.6]})
    >>> for row in sweep_sheet(joint, found, 0.7).sections[0].tables[0].rows:
    ...     print(*row[:2], sep=" | ")
    0.2 | impossible
    0.4 | every state
    0.6 | this state
    """
    regions, here = found.regions(load_factor), f"at λ = {load_factor:g}"
    facts = [Fact("contradiction", text) for text in found.contradictions]
    missing = [point for point in found.points if not point["exists"]]
    for point in missing[:1]:
        where = f"at {len(missing)} of {len(found.points)} points"
        facts.append(Fact("no joint", where, note=point["reason"]))
    texts = [notes.at_values] * (len(found.points) > 1) + [notes.load_domain] * problem.is_domain
    texts += [notes.of_zones] * bool(found.in_zone.any())
    limits = {here: [REGIONS[str(name)] for name in regions.ravel()]}
    for name in found.bounds:
        claim = BOUNDS[name].claim
        sizes = found.from_this_state if claim == Claim.THIS_STATE else found.of_joint(name)
        heading = BOUNDS[name].symbol
        way: Rounding = "up" if claim in (Claim.IMPOSSIBLE, Claim.CREEP) else "down"
        if claim in (Claim.EVERY_STATE, Claim.THIS_STATE, Claim.IMPOSSIBLE):
            # what is not proved of a zone with open nodes may be of the whole joint
            sizes = np.where(found.in_zone & (sizes == 0.0), np.nan, sizes)
            heading = claim.removeprefix("proved from ").removesuffix(" above")
        limits[heading] = [number(size, SHOWN, way) for size in sizes.ravel()]
    sections = [Section("", (), [_table(found, limits)], texts)]
    slips = [point.get("slip_criterion", {}) for point in found.points]
    for asked in [each for each in slips if each][:1]:
        heading = f"slips below {sized(asked['below'], units_of(problem).length)} up to"
        shown = {heading: [number(each.get("load_factor"), SHOWN, "down") for each in slips]}
        sections.append(Section("Simulated from this state", (), [_table(found, shown)]))
    return Sheet(headline(problem, limits=True), (), None, facts, sections)


def _table(found: Sweep, columns: dict[str, list[str]]) -> Table:
    """The parameters of every point, and columns beside them."""
    names: dict[str, list[str]] = {}
    for axis, name in enumerate(found.parameters):
        named = name if found.meanings[axis] else with_unit(name, found.units[axis])
        own = named if len(named) <= 14 else shortened(name, 14)  # characters
        heading = f"{found.meanings[axis]} ×" if found.is_factor(axis) else own
        names[heading] = [number(point["values"][name], SHOWN) for point in found.points]
    return Table.of(names | columns, [name for name in columns if name.startswith("at ")], len(names))


def damping_sheet(problem: Problem, curve: DampingCurve) -> Sheet:
    """Dissipation and stiffness over the amplitude of a load, and up to where there is no damping."""
    name = f" ({shortened(curve.load_name, 40)})" if curve.load_name else ""
    still = "; it is constant and closes no loop: --load names another" * (not curve.force.any())
    stiffness = curve.unit.stiffness or "unit unknown"
    facts = [
        Fact("load", f"{curve.load}{name}", note=f"at {count(len(curve.amplitude), 'amplitude')}{still}"),
        Fact("displacement", curve.unit.moved(curve.problem), note=f"stiffness: {stiffness}"),
    ]
    for how, limit in (("proved", curve.proved_limit), ("simulated", curve.simulated_limit)):
        if not np.isnan(limit):
            at = "at any amplitude" if np.isinf(limit) else f"up to {number(limit, SHOWN, 'down')}"
            facts.append(Fact(f"no damping, {how}", at, note="from the initial state"))
    if len(curve.states):
        same = _numbers(curve.amplitude[curve.unique])
        facts.append(Fact("initial slips", str(len(curve.states)), note="least and largest of all"))
        note = f"amplitude {', '.join(same)}" if same else "at no amplitude"
        facts.append(Fact("the same from every state", "proved" if same else "not proved", note=note))
    texts = [notes.other_loads] * bool(np.isnan(curve.proved_limit))
    texts += [notes.no_displacement] * (problem.load_compliance is None)
    return Sheet(headline(problem), (), None, facts, [Section("", (), [_curve(problem, curve)], texts)])


def _numbers(values: Sequence[float] | FloatArray) -> list[str]:
    return [number(float(value), SHOWN) for value in values]


def _curve(problem: Problem, curve: DampingCurve) -> Table:
    columns = {
        "amplitude": curve.amplitude,
        "displacement": curve.displacement,
        with_unit("loss", units_of(problem).work): curve.dissipation,
    }
    damped = "η" if np.isnan(curve.load_frequency) else "ζ"
    if np.isnan(curve.load_frequency):
        columns |= {"stiffness": curve.secant_stiffness, "η": curve.loss_factor}
    else:
        columns |= {"ω / 2π": curve.frequency / (2 * np.pi), "ζ": curve.damping_ratio}
    if len(curve.states):
        word = "loss_factor" if damped == "η" else "damping_ratio"
        columns |= {f"{damped} least": curve.least[word], f"{damped} largest": curve.largest[word]}
    outcomes = [
        "slides away" if slides else f"{outcome}{', proved' * bool(sure)}"
        for outcome, sure, slides in zip(curve.outcome, curve.proved, curve.slides_away, strict=True)
    ]
    shown = {name: _numbers(values) for name, values in columns.items()}
    return Table.of(shown | {"outcome": outcomes}, ("outcome",))


NUMBERS = {  # first those that converge for most joints
    "work": "friction work",
    "largest_slip": "largest slip",
    "slip_limit": "slips small up to λ",
    "averaged_impossible_above": "impossible above, averaged",
    "impossible_above": "impossible above",
    "proved_from_this_state": "proved from this state",
    "proved_from_every_state": "proved from every state",
    "creep": "least seen to creep",
    "creep_proved": "no creep below",
}


def refinement_sheet(problem: Problem, found: Refinement) -> Sheet:
    """Of every number the values on the finest meshes, its verdict, limit and order.

    Examples
    --------
    >>> import shakedown
    >>> joints = {n: shakedown.example(f"block-{n}") for n in (9, 33)}
    >>> sheet = refinement_sheet(joints[33], shakedown.refine(joints, [9, 33]))
    >>> for row in sheet.sections[0].tables[0].rows:
    ...     print(*row, sep=" | ")
    friction work [N mm] | 0 | 0 | zero | – | –
    largest slip [mm] | 0 | 0 | zero | – | –
    impossible above | 4.715 | 5.008 | undecided | – | –
    proved from this state | 4.663 | 4.709 | undecided | – | –
    proved from every state | 0 | 0 | zero | – | –
    """
    units, last = units_of(problem), slice(-3, None)  # the finest meshes
    asked = {"averaged_impossible_above": found.radius, "slip_limit": found.slip_below}
    of = {"work": units.work, "largest_slip": units.length}
    rows = []
    for word, name in NUMBERS.items():
        known = not word.startswith("creep") or not np.isnan(found.numbers[word]).all()
        if known and asked.get(word, found.load_factor) is not None:
            trend = found.trends[word]
            values = [number(float(value)) for value in found.numbers[word][last]]
            slowly = " slowly" * trend.is_slow
            about = [f"{trend.verdict}{slowly}", number(trend.limit), number(trend.order, 2)]
            rows.append([with_unit(name, of.get(word, "")), *values, *about])
    heads = ["", *(f"{count} nodes" for count in found.nodes[last]), "verdict", "limit", "order"]
    table = Table(heads, rows, (0, len(heads) - 3))
    facts = [Fact("work and slip at", f"λ = {found.load_factor:g}", note="per cycle, from zero slip")]
    if found.slip_below is not None:
        facts.append(Fact("small slips", f"below {sized(found.slip_below, units.length)}"))
    if found.radius is not None:
        facts.append(Fact("averaged over", sized(found.radius, units.length)))
    verdicts = set(found.verdict.values())
    texts = [notes.trend, notes.falling] if {"falls", "grows"} & verdicts else [notes.trend]
    texts += [notes.zero_meshes] * ("zero" in verdicts)
    texts += [notes.few_meshes] * ({"undecided"} <= verdicts <= {"undecided", "zero"})
    return Sheet(headline(problem), facts=facts, sections=[Section("", (), [table], texts)])
