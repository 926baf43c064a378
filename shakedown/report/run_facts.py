"""What simulations find: one run, what its nodes go through; prediction against simulation."""

from __future__ import annotations

import datetime
import os
import platform
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from shakedown.ground.constants import FloatArray
from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, count, few, shortened, sized, with_unit
from shakedown.ground.status import LimitsVerdict, Outcome
from shakedown.joint.units import is_pulled_everywhere, loads_in_words, units_of
from shakedown.report import data_facts, limit_facts
from shakedown.report.facts import Fact, Rounding, Section, Sheet, Table, limits_as_text, notes, number

if TYPE_CHECKING:
    from shakedown.assessment.transient_limit import SlipLimit
    from shakedown.assessment.verify import Run, Verification
    from shakedown.joint.problem import Problem
    from shakedown.long_term.node_results import NodeResults
    from shakedown.long_term.simulation import Simulation, SlipCriterion

WORST = 10  # nodes shown where there are many
HEADINGS = {"accumulated_slip": "Σ|Δv|", "tau_delta": "τ δ", "total_slip_bound": "total slip ≤"}
DOES = {
    Outcome.SHAKEDOWN: "shakes down",
    Outcome.CYCLIC_SLIP: "slips in every cycle",
    Outcome.RATCHETTING: "slips on and on in every cycle",
    Outcome.SEPARATION: "opens and closes in every cycle",
    Outcome.UNDECIDED: "is undecided",
}


def run_sheet(problem: Problem, run: Simulation, initial: str) -> Sheet:
    """The long-term state of one run, with the initial and final slip of every node."""
    from shakedown.bounds.named_start import moved_by_transient  # loads what it was made with

    unit = units_of(problem)
    none_of_slip, none_of_work = data_facts.resolution(problem, run.load_factor)
    (lost,) = data_facts.without_round_off([run.dissipation_per_cycle], none_of_work.max())
    facts = [
        *_outcome(problem, run, initial),
        *(_rest(problem, run) if run.proved and not run.separated else []),
        Fact("cycles simulated", str(run.cycles_simulated)),
        Fact("period", count(run.period, "cycle") if run.period else "–"),
        Fact("dissipation per cycle", f"{number(lost, DIGITS)} {unit.work}".rstrip()),
        *_jumps(run, unit.work),
        *_slip_criterion(run.slip_criterion, unit.length),
        Fact("friction law residual", number(run.residual, 2), note="relative"),
        Fact("method", run.method, note="" if run.events is None else f"{run.events} events"),
    ]
    slips = data_facts.without_round_off(run.slip_per_cycle, none_of_slip)
    table = _slips(problem, {"initial": run.initial_slip, "final": run.final_slip}, slips)
    safe = initial == "safe" and not run.open_nodes
    texts = [notes.one_path] * problem.is_domain
    texts += [notes.transient_moves] * (safe and moved_by_transient(problem, run.load_factor))
    texts += [notes.directions] * (problem.directions > 1) + [notes.summed]
    return Sheet(
        data_facts.headline(problem),
        [run_sentence(problem, run)],
        None,
        facts,
        [Section("", (), [table], texts)],
    )


def run_sentence(problem: Problem, run: Simulation, proved: str = "") -> str:
    """What the joint does at a load factor, in one sentence.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> run_sentence(joint, shakedown.simulate(joint, 0.7))
    'At λ = 0.7 the joint shakes down: proved.'
    >>> run_sentence(joint, shakedown.simulate(joint, 1.0))
    'At the nominal load (λ = 1) the joint slips in every cycle: simulated.'
    """
    here = f"At {'the nominal load (λ = 1)' if run.load_factor == 1 else f'λ = {run.load_factor:.10g}'}"
    if run.separated:
        return separated(problem)
    if run.slides_away:
        return f"{here} {notes.slides_away[0].lower()}{notes.slides_away[1:]}"
    if run.outcome == Outcome.UNDECIDED:
        return f"{here} it is undecided what the joint does."
    opened = f" with {data_facts.open_in_words(run.open_nodes, problem)} open" if run.open_nodes else ""
    if run.outcome != Outcome.SHAKEDOWN:
        return f"{here} the joint {DOES[run.outcome]}: simulated.{_drift(problem, run)}"
    how = proved or ("proved" if run.proved else "simulated, not proved")
    return f"{here} the joint {DOES[run.outcome]}{opened}: {how}."


def _drift(problem: Problem, found: Simulation | NodeResults) -> str:
    """The rigid motion in which a body drifts, as a further sentence; empty where there is none."""
    drift = found.rigid_drift
    return "" if drift is None else f" {drift.in_words(units_of(problem).length)}"


def separated(problem: Problem) -> str:
    """That the bodies separate; asks for the sign of the load unless the doubts about the data do."""
    return notes.apart if is_pulled_everywhere(problem) else f"{notes.apart} {notes.sign}"


def _outcome(problem: Problem, found: Simulation | NodeResults, initial: str) -> list[Fact]:
    """The loads, the outcome with its reason, and the initial state."""
    loads = "" if found.load_factor == 1 else loads_in_words(problem, found.load_factor)
    steady = found.outcome == Outcome.SEPARATION and found.period
    why = f"{found.reason}. {notes.separation}" if steady else found.reason
    facts = [Fact("loads", loads)] if loads else []
    return [*facts, Fact("outcome", str(found.outcome), note=why), Fact("initial state", shortened(initial))]


def _rest(problem: Problem, run: Simulation) -> Iterator[Fact]:
    """What proves that the joint rests."""
    found, unit = run.long_term, units_of(problem)
    if found is None:
        return
    one, proof = found.single_node_margin, found.proof_found
    if np.isnan(one) and not np.isnan(proof.further):
        start = f"after {count(proof.cycles, 'cycle')}" if proof.cycles else "from the start on"
        note = f"at most, {start}, in any order of the loads"
        yield Fact("slip still to come", proof.further, unit.length, "up", note)
    elif np.isnan(one):
        by = f"the load lies below {proof.by} of its initial state"
        yield Fact("proof", by if proof.by else "each uncoupled part is proved to shake down by itself")
    else:
        yield Fact("proof", "an energy ball about the state at rest holds it")


def _jumps(run: Simulation, work: str) -> Iterator[Fact]:
    """Jumps of the long-term state, and those on the way there."""
    if run.jumps_per_cycle > 0:
        yield Fact("by friction", run.friction_dissipation_per_cycle, work)
        yield Fact("by damping in jumps", run.jump_dissipation_per_cycle, work)
        yield Fact("jumps per cycle", run.jumps_per_cycle)
    for jump in run.jumps:
        yield Fact(f"jump at {few(jump.cycle)} cycles", jump.energy_released, work, note="released")


def _slip_criterion(criterion: SlipCriterion | None, length: str) -> list[Fact]:
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
    remarks = ["above it there are load factors at which they are again"] * (not limit.monotone)
    if limit.node >= 0:
        remarks.insert(
            0, f"largest {sized(limit.largest, unit)}, {data_facts.node_in_words(problem, limit.node)}"
        )
    note = "; ".join(remarks)
    return [Fact(label, f"up to λ = {number(limit.load_factor, rounding='down')}", note=note)]


def _slips(problem: Problem, slips: dict[str, FloatArray], per_cycle: list[float]) -> Table:
    """Initial and final slip and the slip distance per cycle, a row per node."""
    unit, digits = units_of(problem).length, DIGITS if problem.directions == 1 else 5
    columns, parts = data_facts.node_column(problem), dict[str, list[float]]()
    for word, slip in slips.items():
        parts |= data_facts.by_direction(problem, word, slip)
    for name, values in (parts | {"Σ|Δv|": per_cycle}).items():
        columns[with_unit(name, unit)] = [number(x, digits) for x in values]
    return Table.of(columns)


def nodes_sheet(problem: Problem, found: NodeResults, initial: str) -> Sheet:
    """What the nodes that move farthest go through in a period of the long-term state."""
    separate = set(found.status) == {"open"}
    does = f"The joint {DOES[found.outcome]} at λ = {found.load_factor:.10g}.{_drift(problem, found)}"
    does = notes.apart if separate else does
    facts = _outcome(problem, found, initial)
    if not found.period:
        return Sheet(
            data_facts.headline(problem), [does], None, facts, [Section("", (), (), [notes.no_period])]
        )
    facts += node_facts(problem, found)
    known, which = worst_table(problem, found), "All nodes"
    if problem.n > WORST:
        which = f"The {WORST} nodes with the largest {'slip range' if found.slip_range.any() else 'pressure'}"
    texts = [notes.summed, notes.forces] + [notes.mixed] * ("mixed" in found.status)
    texts += [notes.one_path] * problem.is_domain
    return Sheet(data_facts.headline(problem), [does], None, facts, [Section(which, (), [known], texts)])


def node_facts(problem: Problem, found: NodeResults) -> list[Fact]:
    """The largest slip range, slip, work and pressure of a node, the sum of the work, how many nodes slip."""
    unit, columns = units_of(problem), data_facts.node_columns(found, problem)
    counted = (
        f"{found.status.count(word)} {'open at times' if word == 'mixed' else word}"
        for word in dict.fromkeys(found.status)
    )
    facts = [Fact("nodes, simulated", str(problem.n), note=", ".join(counted))]
    pressure = ("pressure", "pressure_max", unit.stress)
    for label, word, of in (
        ("slip range", "slip_range", unit.length),
        ("slip distance", "accumulated_slip", unit.length),
        ("friction work", "work", unit.work),
        pressure if "pressure_max" in columns else ("normal force", "p_max", unit.force),
    ):
        if np.nanmax(columns[word]) > 0:
            most = int(np.nanargmax(columns[word]))
            facts.append(
                Fact(
                    f"largest {label}", columns[word][most], of, note=data_facts.node_in_words(problem, most)
                )
            )
    bound = float(found.total_slip_bound.max())  # of the slip of any node, from the initial state on
    if not columns["slip_range"].any():
        facts.append(Fact("slip", "none", note="proved: no node ever slips" if bound == 0 else ""))
    facts.append(Fact("friction work, all nodes", float(columns["work"].sum()), unit.work, note="per cycle"))
    if bound > 0:
        note = "proved, from this initial state on, at most"
        facts.append(Fact("total slip of any node", bound, unit.length, "up", note))
    return facts


def worst_table(problem: Problem, found: NodeResults) -> Table:
    """Everything known of the nodes that move farthest, with units."""
    columns = data_facts.node_columns(found, problem)
    order = found.p_max, columns.get("slip_range", np.zeros(problem.n))  # equal slips by decreasing pressure
    worst = np.lexsort([-np.nan_to_num(part, nan=-1.0) for part in order])[:WORST].tolist()
    shown = data_facts.node_column(problem) | {"status": list(found.status)}
    keys = len(shown) - 1
    for word, values in columns.items():
        name = HEADINGS.get(word, word.replace("_", " "))
        # few digits, as there are many columns
        shown[with_unit(name, found.units[word])] = [number(value, 3) for value in values]
    ranked = {name: [column[node] for node in worst] for name, column in shown.items()}
    return Table.of(ranked, ("FE", "status"), keys)


def verify_sheet(
    v: Verification,
    file: str = "",
    *,
    page: Path | None = None,
    details: bool = False,
    digits: int = FEW_DIGITS,
) -> Sheet:
    """The answer for the nominal load, the claims, what supports them; with details every limit and run.

    Examples
    --------
    >>> import shakedown
    >>> v = shakedown.verify(shakedown.example("two-node"), load_factors=[1.0], random_states=0)
    >>> print(*verify_sheet(v).answer, sep="\\n")
    At the nominal load (λ = 1) the joint slips in every cycle: simulated.
    Simulation agrees with the limits in all 3 runs.
    """
    known = limit_facts.claims(v.assessment)
    table = limit_facts.claims_table(v.problem, known, digits)
    facts = [
        *limit_facts.decided_by(v.assessment),
        *([limit_facts.followed(v.limits)] if _reaches_farther(v) else []),
        *limit_facts.without_creep(v.limits),
        *state_facts(v),
        *(_next(v, file, page) if file else []),
    ]
    sections = [Section("Findings", found)] if (found := findings(v)) else []
    if details:
        sections += limit_facts.limit_sections(v.assessment, digits, simulated=True)
        sections += [Section("", (), (), remarks_of(v)), runs_section(v)]
    return Sheet(data_facts.headline(v.problem, limits=True), [answer(v), verdict(v)], table, facts, sections)


def _reaches_farther(v: Verification) -> bool:
    """Whether following the cycles proves noticeably more than what is proved from this state anyway."""
    limit, most = v.transient, v.assessment.proved_from_this_state * (1.0 + limit_facts.SAME)
    return limit is not None and limit.at_proved is not None and not limit.proved <= most


def _next(v: Verification, file: str, page: Path | None) -> Iterator[Fact]:
    """The report that was written, and the one thing to do next."""
    if page is None:
        command, why = f"verify {file} -o report.html", "(limits, runs and pictures on a page)"
    elif v.as_given.simulation.outcome == Outcome.SHAKEDOWN:
        command, why = f"sweep {file} --vary amplitude=0.5:1.5:5", "(how the limits move)"
    else:
        command, why = f"nodes {file} -o nodes.csv", "(every node, or .vtu for ParaView)"
    if page is not None:
        yield Fact("report", str(page), note=f"and {page.with_suffix('.json').name}")
    yield Fact("next", f"shakedown-bounds {command}", note=why)


def remarks_of(v: Verification) -> list[str]:
    """What else is to be known of a verification."""
    return [f"Note: {note.rstrip('.')}." for note in v.notes]


def findings(v: Verification) -> list[Fact]:
    """What disagrees, and what is left open."""
    wrong = [Fact("disagreement", text) for text in v.disagreements]
    return [*wrong, *(Fact("open question", text) for text in v.open_questions)]


def answer(v: Verification) -> str:
    """What becomes of the joint under the nominal load: proved by the limits, else by simulation."""
    run = v.as_given.simulation
    if v.assessment.verdict == LimitsVerdict.SHAKEDOWN and run.outcome == Outcome.SHAKEDOWN:
        return limit_facts.nominal_load_sentence(v.assessment)
    return run_sentence(v.problem, run, "proved by following its cycles" if run.proved else "")


def verdict(v: Verification) -> str:
    """Whether prediction and simulation agree, in how many runs; every finding is counted."""
    judged = sum(run.agrees is not None for run in v.runs)
    if v.disagreements:
        return f"DISAGREEMENT: {count(len(v.disagreements), 'finding')}."
    if v.open_questions:
        return f"Open: {count(len(v.open_questions), 'question')}."
    if not judged:
        return f"The limits predict no outcome of {count(len(v.runs), 'run')}: nothing to agree with."
    rest = f" with a predicted outcome; {len(v.runs) - judged} without one" if judged < len(v.runs) else ""
    return f"Simulation agrees with the limits in {'all ' * (judged > 1)}{count(judged, 'run')}{rest}."


def banner_class(v: Verification) -> str:
    """The colour of the banner: green where the joint shakes down, red where it slips for ever.

    The ground is red, too, where simulation and limits disagree, and there only.
    Runs at other load factors that are left open do not colour the answer for the nominal one.
    """
    run = v.as_given.simulation
    elsewhere = sum(
        each.simulation.outcome == Outcome.UNDECIDED and each.simulation.load_factor != run.load_factor
        for each in v.runs
    )
    if v.disagreements:
        return "disagree"
    if run.separated:
        return "open"
    if run.slides_away or run.outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING):
        return "slips"
    exact = run.proved or run.long_term is not None  # at fixed load steps slow slip may look like none
    rests = run.outcome == Outcome.SHAKEDOWN and exact and len(v.open_questions) == elsewhere
    return "agree" if rests else "open"


def state_facts(v: Verification) -> list[Fact]:
    """The long-term state under the nominal load, λ_T, and up to where slips stay small."""
    limit, nothing = v.transient, [Fact("results per node", "none", note=v.nodes.reason)]
    facts = node_facts(v.problem, v.nodes) if v.nodes.period else nothing
    if limit is not None and limit.proved != limit.load_factor:  # at λ_T itself it is only simulated
        note = "up to here the joint shakes down in the simulation"
        at = number(limit_facts.certain(limit), rounding="down")
        if np.isnan(limit.load_factor):
            at, note = "no λ", "the joint shakes down at no load factor simulated"
        elif not np.isfinite(limit.high):
            at = "every λ simulated"
        note += "" if limit.monotone else "; below there are load factors at which it does not"
        facts.append(Fact("simulated limit λ_T", at, note=note))
    return [*facts, *slip_limit_fact(v.slip_limit, v.problem)]


def limits_on_page(v: Verification) -> dict[str, float]:
    """The limits that the claims go by, the zone's and λ_T, by symbol, rounded to the safe side."""
    known: dict[str, tuple[float, Rounding]] = {
        claim.unit: (claim.value, claim.rounding)
        for claim in limit_facts.claims(v.assessment)
        if isinstance(claim.value, float)
    }
    if v.limits.open_nodes:
        known["zone"] = v.limits.upper.load_factor, "down"
    if v.transient is not None:
        known[v.transient.symbol] = limit_facts.certain(v.transient), "down"
    finite = {name: limit for name, limit in known.items() if np.isfinite(limit[0])}
    return dict(zip(finite, map(float, limits_as_text([*finite.values()])), strict=True))


def runs_section(v: Verification) -> Section:
    """Every simulation with its prediction."""
    unit, found = units_of(v.problem).length, [run.simulation for run in v.runs]
    none = [data_facts.resolution(v.problem, each.load_factor)[0] for each in found]
    slips = [
        max(data_facts.without_round_off(each.slip_per_cycle, own))
        for each, own in zip(found, none, strict=True)
    ]
    columns = {
        "λ": [number(each.load_factor, DIGITS) for each in found],
        "initial state": [run.initial + started(run) for run in v.runs],
        "predicted": [run.predicted for run in v.runs],
        "simulated": ["; ".join([str(each.outcome), *remarks(each)]) for each in found],
        "agree": [{True: "yes", False: "NO", None: "–"}[run.agrees] for run in v.runs],
        with_unit("Σ|Δv|", unit): [number(slip) for slip in slips],
        "residual": ["–" if np.isnan(each.residual) else f"{each.residual:.0e}" for each in found],
    }
    texts = [notes.judged, notes.summed, notes.residual]
    texts += [notes.after] * any(run.after_transient for run in v.runs)
    texts += [notes.in_zone] * any(bool(run.open_nodes) for run in v.runs)
    texts += [notes.separation] * any(each.outcome == Outcome.SEPARATION for each in found)
    texts += [notes.one_path] * v.problem.is_domain
    table = Table.of(columns, ("initial state", "predicted", "simulated"), keys=2)
    return Section("Runs", (), [table], texts)


def started(run: Run) -> str:
    """A remark on an initial state: whether nodes are open in it, or whether it follows the transient."""
    return " (zone)" if run.open_nodes else " (after)" * run.after_transient


def remarks(run: Simulation) -> list[str]:
    """Remarks on a long-term state: its period, its jumps, its open nodes."""
    found = [f"period {run.period}"] if run.period > 1 else []
    found += [f"{run.jumps_per_cycle:g} jumps per cycle"] if run.jumps_per_cycle > 0 else []
    return found + ([f"{data_facts.open_in_words(run.open_nodes)} open"] if run.open_nodes else [])


def provenance(v: Verification) -> list[Fact]:
    """What is needed to make the report again: versions, date, machine, method, seed."""
    asked, problem = v.settings, v.problem
    start = "zero slip" if problem.initial_slip is None else "the first given slip"
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors"
    random = f"{count(asked.random_states, 'state')} left by random loads (seed {asked.seed})"
    python = f"Python {platform.python_version()}, NumPy {np.__version__}"
    return [
        Fact("versions", f"shakedown {version('shakedown-bounds')}", note=python),
        Fact("made", f"{datetime.datetime.now(datetime.UTC):%Y-%m-%d %H:%M} UTC", note=machine),
        Fact("method", asked.method, note=f"at most {count(asked.cycles, 'cycle')}"),
        Fact("initial states", start, note=f"the safe slip, the critical slip, {random}"),
    ]
