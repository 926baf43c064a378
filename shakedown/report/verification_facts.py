"""Prediction against simulation: the answer, whether both agree, every run, and the sections of a page."""

from __future__ import annotations

import datetime
import os
import platform
from importlib.metadata import version
from typing import TYPE_CHECKING

import numpy as np

from shakedown.assessment.verify import Verification
from shakedown.bounds.registry import BOUNDS
from shakedown.ground.errors import present
from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, count
from shakedown.ground.status import Outcome, Said, Status
from shakedown.ground.visible_text import with_unit
from shakedown.joint.units import units_of
from shakedown.report import notes
from shakedown.report.data_facts import headline
from shakedown.report.facts import Fact, Section, Sheet, Table, limits_as_text, number
from shakedown.report.limit_facts import (
    certain,
    claims,
    claims_table,
    decided_by,
    followed,
    limit_sections,
    said_of_nominal_load,
)
from shakedown.report.node_names import open_in_words, resolution, without_round_off
from shakedown.report.run_facts import node_facts, said_of_run, slip_limit_fact

if TYPE_CHECKING:
    from shakedown.assessment.verify import Run
    from shakedown.long_term.simulation import Simulation


def verify_sheet(v: Verification, *, details: bool = False, digits: int = FEW_DIGITS) -> Sheet:
    """The answer for the nominal load, the claims, what supports them; with details every limit and run.

    Examples
    --------
    >>> import shakedown
    >>> v = shakedown.verify(shakedown.example("two-node"), load_factors=[1.0], random_states=0)
    >>> print(*verify_sheet(v).answer, sep="\\n")
    At the nominal load (λ = 1) the joint slips in every cycle: simulated.
    Simulation confirms the limits in all 3 runs.
    """
    known = claims(v.assessment)
    if v.transient is not None and v.transient.at_proved is not None:
        known.insert(2, followed(v.limits))
    facts = [*decided_by(v.assessment), *state_facts(v)]
    sections = [Section("Findings", found)] if (found := findings(v)) else []
    if details:
        said = [f"Note: {note.rstrip('.')}." for note in v.notes]
        sections += [
            *limit_sections(v.assessment, digits, simulated=True),
            Section("", (), (), said),
            runs_section(v),
        ]
    table = claims_table(v.problem, known, digits)
    return Sheet(headline(v.problem), [answer(v), verdict(v)], table, facts, sections)


def findings(v: Verification) -> list[Fact]:
    """What disagrees, and what is left open."""
    wrong = [Fact("disagreement", text) for text in v.disagreements]
    return [*wrong, *(Fact("open question", text) for text in v.open_questions)]


def answer(v: Verification) -> str:
    """What becomes of the joint under the nominal load: proved by the limits, else by simulation."""
    run = v.as_given.simulation
    if v.assessment.said_as_given == Said.SHAKEDOWN and run.outcome == Outcome.SHAKEDOWN:
        return said_of_nominal_load(v.assessment)
    return said_of_run(v.problem, run, "proved by following its cycles" if run.proved else "")


def verdict(v: Verification) -> str:
    """Whether prediction and simulation agree, in how many runs; every finding is counted."""
    judged = sum(run.agrees is not None for run in v.runs)
    if v.disagreements:
        return f"DISAGREEMENT: {count(len(v.disagreements), 'finding')}."
    if v.open_questions:
        return f"Open: {count(len(v.open_questions), 'question')}."
    if not judged:
        return (
            f"The limits predict no outcome of {count(len(v.runs), 'run')}: there is nothing to agree with."
        )
    others = len(v.runs) - judged
    rest = f" that they predict; of {others} they say nothing" if others else ""
    return f"Simulation confirms the limits in all {count(judged, 'run')}{rest}."


def banner_class(v: Verification) -> str:
    """The colour of the banner: green only where the joint shakes down, red where it slips for ever.

    Runs at other load factors that are left open do not colour the answer for the nominal one.
    """
    run = v.as_given.simulation
    elsewhere = sum(
        each.simulation.outcome == Outcome.UNDECIDED and each.simulation.load_factor != run.load_factor
        for each in v.runs
    )
    if run.separated and not v.disagreements:
        return "open"
    if v.disagreements or run.slides_away or run.outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING):
        return "disagree"
    exact = run.proved or run.long_term is not None  # at fixed load steps slow slip may look like none
    rests = run.outcome == Outcome.SHAKEDOWN and exact and len(v.open_questions) == elsewhere
    return "agree" if rests else "open"


def state_facts(v: Verification) -> list[Fact]:
    """The long-term state under the nominal load, λ_T, and up to where slips stay small."""
    facts = (
        node_facts(v.problem, v.nodes)
        if v.nodes.period
        else [Fact("results per node", "none", note=v.nodes.reason)]
    )
    limit = v.transient
    if limit is not None and not transient_is_proved(v):
        at, note = (
            number(certain(limit), rounding="down"),
            "up to here the joint shakes down in the simulation",
        )
        if np.isnan(limit.load_factor):
            at, note = "no λ", "the joint shakes down at no load factor simulated"
        elif not np.isfinite(limit.high):
            at = "every λ simulated"
        if not limit.monotone:
            note += "; below there are load factors at which it does not"
        facts.append(Fact("simulated limit λ_T", at, note=note))
    return [*facts, *slip_limit_fact(v.slip_limit, v.problem)]


def transient_is_proved(v: Verification) -> bool:
    """Whether shakedown is proved at λ_T itself, not only simulated."""
    return v.transient is not None and v.transient.proved == v.transient.load_factor


def limits_on_page(v: Verification) -> dict[str, float]:
    """Limits by symbol, rounded to the safe side; NaN where there is none.

    Of those proved from one state only the largest is included.
    """
    nothing_safe = v.limits.upper.status == Status.INFEASIBLE  # nothing is possible above 0
    here = v.limits.from_state
    known = {here.symbol: here.load_factor}
    for word in ("transient", "universal", "lower"):
        result = present(getattr(v.limits, word))
        value = np.nan if result is None else certain(result)
        known |= {BOUNDS[word].symbol: value} if result is not None or word == "transient" else {}
    largest = v.assessment.impossible_above if nothing_safe else v.limits.upper.load_factor
    known["zone" if v.limits.open_nodes else BOUNDS["upper"].symbol] = float(largest)
    texts = limits_as_text([(value, "down") for value in [*known.values()][:-1]] + [(float(largest), "up")])
    pairs = zip(known.items(), texts, strict=True)
    return {name: float(text) if np.isfinite(value) else value for (name, value), text in pairs}


def runs_section(v: Verification) -> Section:
    """Every simulation with its prediction."""
    unit, found = units_of(v.problem).length, [run.simulation for run in v.runs]
    none = [resolution(v.problem, each.load_factor)[0] for each in found]
    slips = [max(without_round_off(each.slip_per_cycle, own)) for each, own in zip(found, none, strict=True)]
    columns = {
        "λ": [number(each.load_factor, DIGITS) for each in found],
        "initial state": [run.initial + started(run) for run in v.runs],
        "predicted": [run.predicted for run in v.runs],
        "simulated": ["; ".join([str(each.outcome), *remarks(each)]) for each in found],
        "agree": [{True: "yes", False: "NO", None: "–"}[run.agrees] for run in v.runs],
        with_unit("Σ|Δv|", unit): [number(slip) for slip in slips],
        "residual": ["–" if np.isnan(each.residual) else f"{each.residual:.0e}" for each in found],
    }
    said = [notes.JUDGED, notes.SUMMED, notes.RESIDUAL]
    said += [notes.AFTER] * any(run.after_transient for run in v.runs)
    said += [notes.IN_ZONE] * any(bool(run.open_nodes) for run in v.runs)
    said += [notes.SEPARATION] * any(each.outcome == Outcome.SEPARATION for each in found)
    said += [notes.ONE_PATH] * v.problem.is_domain
    words = ("initial state", "predicted", "simulated")
    return Section("Runs", (), [Table.of(columns, words, keys=2)], said)


def started(run: Run) -> str:
    """A remark on an initial state: whether nodes are open in it, or whether it follows the transient."""
    return " (zone)" if run.open_nodes else " (after)" * run.after_transient


def remarks(run: Simulation) -> list[str]:
    """Remarks on a long-term state: its period, its jumps, its open nodes."""
    found = [f"period {run.period}"] if run.period > 1 else []
    found += [f"{run.jumps_per_cycle:g} jumps per cycle"] if run.jumps_per_cycle > 0 else []
    return found + ([f"{open_in_words(run.open_nodes)} open"] if run.open_nodes else [])


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
