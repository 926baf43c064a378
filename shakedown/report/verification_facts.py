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
from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, count, down, up
from shakedown.ground.status import Outcome, Said, Status
from shakedown.ground.visible_text import with_unit
from shakedown.joint.units import units_of
from shakedown.report import notes
from shakedown.report.data_facts import headline
from shakedown.report.facts import Fact, Section, Sheet, Table, number
from shakedown.report.limit_facts import (
    certain,
    claims,
    claims_table,
    decided_by,
    followed,
    limit_sections,
    said_of_nominal_load,
)
from shakedown.report.node_words import open_in_words, resolution, without_round_off
from shakedown.report.run_facts import node_facts, said_of_run, slip_limit_fact

if TYPE_CHECKING:
    from shakedown.assessment.runs import Run
    from shakedown.long_term.simulation import Simulation

BRIEF = ("λ", "initial state", "predicted", "simulated", "agree", "Σ|Δv|", "residual")


def verify_sheet(v: Verification, *, details: bool = False, digits: int = FEW_DIGITS) -> Sheet:
    """The answer for the nominal load, the claims, what supports them; with details every limit and run.

    Examples
    --------
    >>> import shakedown
    >>> v = shakedown.verify(shakedown.example("two-node"), load_factors=[1.0], random_states=0)
    >>> print(*verify_sheet(v).answer, sep="\\n")
    At the nominal load (λ = 1) the joint slips in every cycle.
    Prediction and simulation agree in all 3 runs.
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
    rest = f" with a prediction; {others} had none" if others else ""
    return f"Prediction and simulation agree in all {count(judged, 'run')}{rest}."


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
    if limit is not None:
        there = " and is proved there" * transient_is_proved(v)
        note = f"up to here the joint shakes down in the simulation{there}"
        at = number(certain(limit), rounding="down") if np.isfinite(limit.high) else "every λ simulated"
        if np.isnan(limit.load_factor):
            at, note = "no λ", "the joint shakes down at no load factor simulated"
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
    return {name: float(down(value)) for name, value in known.items()} | {
        BOUNDS["upper"].symbol: float(up(largest))
    }


def runs_section(v: Verification, *, brief: bool = True) -> Section:
    """Every simulation with its prediction; ``brief`` selects the columns that fit a terminal."""
    said = [notes.JUDGED, notes.SUMMED, notes.RESIDUAL]
    said += [notes.AFTER] * any(run.case.after_transient for run in v.runs)
    said += [notes.IN_ZONE] * any(bool(run.open_nodes) for run in v.runs)
    said += [notes.SEPARATION] * any(run.simulation.outcome == Outcome.SEPARATION for run in v.runs)
    said += [notes.ONE_PATH] * v.problem.is_domain
    return Section("Runs", (), [runs_table(v, brief=brief)], said)


def runs_table(v: Verification, *, brief: bool = False) -> Table:
    """Every simulation with its prediction."""
    unit = units_of(v.problem)
    slip, work = with_unit("Σ|Δv|", unit.length), with_unit("dissipation", unit.work)
    rows = [_run(v, run) | {slip: _largest(v, run, 0), work: _largest(v, run, 1)} for run in v.runs]
    head = [name if name != "Σ|Δv|" else slip for name in BRIEF]
    if not brief:
        head = ["λ", "region", *head[1:4], "remarks", "agree", "cycles", slip, work, "residual", "time"]
    return Table(
        head, [[row[name] for name in head] for row in rows], (1, 2, 3) if brief else (1, 2, 3, 4, 5)
    )


def _run(v: Verification, run: Run) -> dict[str, str]:
    """One run by the headings of its table."""
    found = run.simulation
    started = " (zone)" if run.open_nodes else " (after)" * run.case.after_transient
    return {
        "λ": number(found.load_factor, DIGITS),
        "region": run.region,
        "initial state": run.initial + started,
        "predicted": run.predicted,
        "simulated": str(found.outcome),
        "remarks": remarks(found),
        "agree": {True: "yes", False: "NO", None: "–"}[run.agrees],
        "cycles": str(found.cycles_simulated),
        "residual": "–" if np.isnan(found.residual) else f"{found.residual:.0e}",
        "time": f"{1e3 * run.seconds:.1f} ms",
    }


def _largest(v: Verification, run: Run, which: int) -> str:
    """The largest slip distance of a node (0), or the dissipation (1), per cycle, without round-off."""
    found, none = run.simulation, resolution(v.problem, run.simulation.load_factor)
    if which == 0:
        return number(max(without_round_off(found.slip_per_cycle, none[0])))
    return number(without_round_off([found.dissipation_per_cycle], none[1].max())[0])


def remarks(run: Simulation) -> str:
    """Remarks on a long-term state: period, jumps, open nodes, proof."""
    found = [f"period {run.period}"] if run.period > 1 else []
    found += [f"{run.jumps_per_cycle:g} jumps per cycle"] if run.jumps_per_cycle > 0 else []
    found += [f"{open_in_words(run.open_nodes)} open"] if run.open_nodes else []
    return "; ".join([*found, *["proved"] * run.proved])


def provenance(v: Verification) -> list[Fact]:
    """What is needed to make the report again: versions, date, machine, method, seed."""
    asked, problem = v.settings, v.problem
    start = "zero slip" if problem.initial_slip is None else "the first given slip"
    machine = f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors"
    random = count(asked.random_states, "state")
    return [
        Fact(
            "versions",
            f"shakedown {version('shakedown-bounds')}",
            note=f"Python {platform.python_version()}, NumPy {np.__version__}",
        ),
        Fact("made", f"{datetime.datetime.now(datetime.UTC):%Y-%m-%d %H:%M} UTC", note=machine),
        Fact("method", asked.method, note=f"at most {count(asked.cycles, 'cycle')}"),
        Fact(
            "initial states",
            start,
            note=f"the safe slip, the critical slip, {random} left by random loads (seed {asked.seed})",
        ),
    ]
