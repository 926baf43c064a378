"""What a simulation finds: the long-term state, its proof and its margin, what every node goes through."""

from __future__ import annotations

from math import inf
from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import DIGITS, count, few, sized
from shakedown.ground.status import Outcome
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.doubtful_data import is_pulled_everywhere
from shakedown.joint.units import loads_in_words, units_of
from shakedown.report import notes
from shakedown.report.data_facts import headline
from shakedown.report.facts import Fact, Section, Sheet, Table, number
from shakedown.report.node_names import (
    by_direction,
    node_column,
    node_columns,
    node_in_words,
    open_in_words,
    resolution,
    without_round_off,
    worst_first,
)

if TYPE_CHECKING:
    from shakedown.assessment.slip_limit import SlipLimit
    from shakedown.joint.problem import Problem
    from shakedown.long_term.node_table import NodeResults
    from shakedown.long_term.simulation import Simulation
    from shakedown.long_term.slip_criterion import SlipCriterion
    from shakedown.long_term.state import EnergyProof

WORST = 10  # nodes shown where there are many
SHORT = 3  # digits in a table of many columns
DOES = {
    Outcome.SHAKEDOWN: "shakes down",
    Outcome.CYCLIC_SLIP: "slips in every cycle",
    Outcome.RATCHETTING: "slips on and on in every cycle",
    Outcome.SEPARATION: "opens and closes in every cycle",
    Outcome.UNDECIDED: "is undecided",
}


def run_sheet(problem: Problem, run: Simulation, initial: str, *, transient_moves: bool) -> Sheet:
    """The long-term state of one run, with the initial and final slip of every node.

    ``transient_moves``: whether the transient load steps move every slip that is safe in the loop.
    """
    unit = units_of(problem)
    none_of_slip, none_of_work = resolution(problem, run.load_factor)
    (lost,) = without_round_off([run.dissipation_per_cycle], none_of_work.max())
    facts = [
        *outcome_facts(problem, run, initial),
        Fact("cycles simulated", str(run.cycles_simulated)),
        Fact("period", count(run.period, "cycle") if run.period else "–"),
        Fact("dissipation per cycle", f"{number(lost, DIGITS)} {unit.work}".rstrip()),
        *_jumps(run, unit.work),
        *slip_facts(run.slip_criterion, unit.length),
        Fact("friction law residual", number(run.residual, 2), note="relative"),
        Fact("method", run.method, note="" if run.events is None else f"{run.events} events"),
    ]
    slips = without_round_off(run.slip_per_cycle, none_of_slip)
    table = _slips(problem, {"initial": run.initial_slip, "final": run.final_slip}, slips)
    said = [notes.ONE_PATH] * problem.is_domain + [notes.TRANSIENT_MOVES] * transient_moves
    said += [notes.DIRECTIONS] * (problem.directions > 1) + [notes.SUMMED]
    return Sheet(
        headline(problem), [said_of_run(problem, run)], None, facts, [Section("", (), [table], said)]
    )


def said_of_run(problem: Problem, run: Simulation, proved: str = "") -> str:
    """What the joint does at a load factor, in one sentence.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> said_of_run(joint, shakedown.simulate(joint, 0.7))
    'At λ = 0.7 the joint shakes down: proved.'
    >>> said_of_run(joint, shakedown.simulate(joint, 1.0))
    'At the nominal load (λ = 1) the joint slips in every cycle: simulated.'
    """
    at = "the nominal load (λ = 1)" if run.load_factor == 1 else f"λ = {run.load_factor:.10g}"
    here = f"At {at}"
    if run.separated:
        return separated(problem)
    if run.slides_away:
        return f"{here} {notes.SLIDES_AWAY[0].lower()}{notes.SLIDES_AWAY[1:]}"
    if run.outcome == Outcome.UNDECIDED:
        return f"{here} it is undecided what the joint does."
    if run.outcome == Outcome.SHAKEDOWN:
        how = "proved" if run.proved else "simulated, not proved"
        opened = f" with {open_in_words(run.open_nodes, problem)} open" if run.open_nodes else ""
        return f"{here} the joint shakes down{opened}: {proved or how}."
    return f"{here} the joint {DOES[run.outcome]}: simulated."


def separated(problem: Problem) -> str:
    """That the bodies separate; asks for the sign of the load unless the doubts about the data do."""
    return notes.APART if is_pulled_everywhere(problem) else f"{notes.APART} {notes.SIGN}"


def outcome_facts(problem: Problem, run: Simulation, initial: str) -> list[Fact]:
    """The outcome with its reason, the initial state, open nodes, and how far the state at rest holds."""
    why = (
        f"{run.reason}. {notes.SEPARATION}"
        if run.outcome == Outcome.SEPARATION and run.period
        else run.reason
    )
    facts = [
        *loads_fact(problem, run.load_factor),
        Fact("outcome", str(run.outcome), note=why),
        Fact("initial state", shortened(initial)),
    ]
    if run.open_nodes and not run.separated:
        facts.append(Fact("open throughout", open_in_words(run.open_nodes, problem)))
    if run.outcome == Outcome.SHAKEDOWN:
        facts.append(Fact("shakedown proved", "yes" if run.proved else "no"))
    return [*facts, *(rest_facts(problem, run) if run.proved and not run.separated else [])]


def loads_fact(problem: Problem, load_factor: float) -> list[Fact]:
    """What a load factor means in the user's loads, where they are known and it is not the nominal load."""
    loads = "" if load_factor == 1 else loads_in_words(problem, load_factor)
    return [Fact("loads", loads)] if loads else []


def rest_facts(problem: Problem, run: Simulation) -> list[Fact]:
    """How far slips may deviate from those at rest, one node at a time or together."""
    from shakedown.long_term.state import held_by_friction  # loads compiled code

    found, unit = run.long_term, units_of(problem)
    if found is None:
        return []
    one, most = found.single_node_margin, inf
    if np.isnan(one):
        return _without_margin(found.proof_found, unit.length)
    if np.isinf(one):
        return [Fact("holds", "however far the nodes are displaced")]
    if not found.open_nodes:
        most = held_by_friction(found.problem, found.load_factor, found.final_slip)
    if one >= most:
        note = "as far as friction can hold it there, all others in place"
        return [Fact("one node displaced by", most, unit.length, "up", note)]
    together = f"√({unit.work})" if unit.work else ""
    return [
        Fact("one node displaced by", one, unit.length, "down", "all others in place: it still shakes down"),
        Fact("several nodes by", found.energy_margin, together, "down", "in the energy norm"),
    ]


def _without_margin(proof: EnergyProof, unit: str) -> list[Fact]:
    """What proves shakedown where no energy ball does."""
    if proof.further == proof.further:
        start = f"after {count(proof.cycles, 'cycle')}" if proof.cycles else "from the start on"
        return [
            Fact(
                "slip still to come",
                proof.further,
                unit,
                "up",
                f"at most, {start}, in any order of the loads",
            )
        ]
    if proof.by:
        return [Fact("proof", f"the load lies below {proof.by} of its initial state")]
    return [Fact("proof", "each uncoupled part is proved to shake down by itself")]


def _jumps(run: Simulation, work: str) -> list[Fact]:
    """Jumps of the long-term state, and those on the way there."""
    facts = []
    if run.jumps_per_cycle > 0:
        facts = [
            Fact("by friction", run.friction_dissipation_per_cycle, work),
            Fact("by damping in jumps", run.jump_dissipation_per_cycle, work),
            Fact("jumps per cycle", run.jumps_per_cycle),
        ]
    released = [
        Fact(f"jump at {few(jump.cycle)} cycles", jump.energy_released, work, note="released")
        for jump in run.jumps
    ]
    return facts + released


def slip_facts(criterion: SlipCriterion | None, length: str) -> list[Fact]:
    """The largest slip range, and whether it is below the limit, where there is one."""
    if criterion is None:
        return []
    met = {True: "yes", False: "no", None: "undecided"}[criterion.met]
    where = f"at node {criterion.node}" if criterion.node >= 0 else ""
    return [
        Fact("largest slip range", criterion.largest, length, note=where),
        Fact(f"below {sized(criterion.below, length)}", met),
    ]


def slip_limit_fact(limit: SlipLimit | None, problem: Problem) -> list[Fact]:
    """Up to which load factor slips stay below a length."""
    if limit is None:
        return []
    unit = units_of(problem).length
    label = f"slips below {sized(limit.below, unit)}"
    if np.isnan(limit.load_factor):
        return [Fact(label, "at no load factor")]
    if np.isinf(limit.exceeded_at):
        return [Fact(label, "at every load factor simulated")]
    where = (
        f"largest {sized(limit.largest, unit)}, {node_in_words(problem, limit.node)}"
        if limit.node >= 0
        else ""
    )
    again = "" if limit.monotone else "above it there are load factors at which they are again"
    note = "; ".join(filter(None, [where, again]))
    return [Fact(label, f"up to λ = {number(limit.load_factor, rounding='down')}", note=note)]


def _slips(problem: Problem, slips: dict[str, FloatArray], per_cycle: list[float]) -> Table:
    """Initial and final slip and the slip distance per cycle, a row per node."""
    unit, digits = units_of(problem).length, DIGITS if problem.directions == 1 else 5
    columns = node_column(problem)
    parts = {
        name: values
        for word, slip in slips.items()
        for name, values in by_direction(problem, word, slip).items()
    }
    for name, values in (parts | {"Σ|Δv|": per_cycle}).items():
        columns[with_unit(name, unit)] = [number(x, digits) for x in values]
    return Table.of(columns)


def nodes_sheet(problem: Problem, found: NodeResults, initial: str) -> Sheet:
    """What the nodes that move farthest go through in a period of the long-term state."""
    separate = set(found.status) == {"open"}
    does = notes.APART if separate else f"The joint {DOES[found.outcome]} at λ = {found.load_factor:.10g}."
    facts = [
        *loads_fact(problem, found.load_factor),
        Fact("outcome", str(found.outcome), note=found.reason),
        Fact("initial state", shortened(initial)),
    ]
    if not found.period:
        return Sheet(headline(problem), [does], None, facts, [Section("", (), (), [notes.NO_PERIOD])])
    facts += node_facts(problem, found)
    known, which = worst_table(problem, found), "All nodes"
    if problem.n > WORST:
        which = f"The {WORST} nodes with the largest {'slip range' if found.slip_range.any() else 'pressure'}"
    said = [notes.SUMMED, notes.FORCES] + [notes.MIXED] * ("mixed" in found.status)
    said += [notes.ONE_PATH] * problem.is_domain
    return Sheet(headline(problem), [does], None, facts, [Section(which, (), [known], said)])


def node_facts(problem: Problem, found: NodeResults) -> list[Fact]:
    """The largest slip range, slip, work and pressure of a node, the sum of the work, how many nodes slip."""
    unit, columns = units_of(problem), node_columns(found, problem)
    counts = ", ".join(f"{found.status.count(word)} {word}" for word in dict.fromkeys(found.status))
    facts = [Fact("nodes", str(problem.n), note=counts)]
    named = {
        "largest slip range": ("slip_range", unit.length),
        "largest slip distance": ("accumulated_slip", unit.length),
        "largest friction work": ("work", unit.work),
        "largest pressure": ("pressure_max", unit.stress),
        "largest normal force": ("p_max", unit.force),
    }
    if "pressure_max" in columns:
        del named["largest normal force"]
    for label, (word, of) in named.items():
        values = columns.get(word)
        if values is not None and np.nanmax(values) > 0:
            most = int(np.nanargmax(values))
            facts.append(Fact(label, values[most], of, note=node_in_words(problem, most)))
    if not columns["slip_range"].any():
        facts.append(Fact("slip", "none", note="proved: no node ever slips" if never_slips(found) else ""))
    facts.append(Fact("friction work, all nodes", float(columns["work"].sum()), unit.work, note="per cycle"))
    return [*facts, *total_slip(found, unit.length)]


def never_slips(found: NodeResults) -> bool:
    """Whether it is proved that no node slips at all, from the initial state on."""
    return float(found.total_slip_bound.max()) == 0.0


def total_slip(found: NodeResults, unit: str) -> list[Fact]:
    """The proved bound on the total slip of any node; nothing where there is none, or no slip at all."""
    most = float(found.total_slip_bound.max())
    if np.isnan(most) or most == 0:
        return []
    return [Fact("total slip of any node", most, unit, "up", "proved, from this initial state on, at most")]


def worst_table(problem: Problem, found: NodeResults) -> Table:
    """Everything known of the nodes that move farthest, with units."""
    columns, worst = node_columns(found, problem), worst_first(found, problem)[:WORST]
    shown = node_column(problem) | {"status": list(found.status)}
    keys = len(shown) - 1
    for word, values in columns.items():
        name = "Σ|Δv|" if word == "accumulated_slip" else word.replace("_", " ")
        shown[with_unit(name, found.units[word])] = [number(value, SHORT) for value in values]
    ranked = {name: [column[node] for node in worst] for name, column in shown.items()}
    return Table.of(ranked, ("FE", "status"), keys)
