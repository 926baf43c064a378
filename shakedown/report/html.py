"""The verification report: one self-contained HTML file, and the same as JSON."""

import datetime
import io
import os
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup
from matplotlib.figure import Figure

from shakedown.errors import UsageError
from shakedown.files.atomic_write import atomic_write_together, check_target
from shakedown.long_term.outcome import Outcome, nodes_in_words
from shakedown.long_term.simulation import Simulation
from shakedown.model.constraints import SIDE_NAMES
from shakedown.model.units import units_of
from shakedown.report.json_documents import as_text, verification_document
from shakedown.report.verification_figures import (
    guarantee_curve_figure,
    slip_along_contact_figure,
    slip_per_cycle_figure,
    slip_space_figure,
)
from shakedown.report.words import (
    as_given_in_words,
    bounds_in_words,
    certain_in_words,
    critical_in_words,
    friction_in_words,
    hints_in_words,
    transient_in_words,
)
from shakedown.report.zone_words import open_in_words
from shakedown.verification.verify import Run, Verification
from shakedown.visible_text import shortened, visible

REPORT = "shakedown-bounds verify"  # what a report's JSON begins with


def write_report(path: str | os.PathLike[str], verification: Verification) -> None:
    """Write a verification as HTML, and as JSON beside it (same name, suffix .json).

    Raises
    ------
    UsageError
        If a file cannot be written.
    """
    if not isinstance(verification, Verification):
        raise UsageError(f"verification: expected a Verification, found {type(verification).__name__}")
    target = report_path(path)
    document = {"report": REPORT} | verification_document(verification)
    page = render(verification)
    with atomic_write_together([target, target.with_suffix(".json")]) as (html_file, json_file):
        html_file.write(page.encode())
        json_file.write(as_text(document).encode())


def report_path(path: str | os.PathLike[str]) -> Path:
    """Where a report goes, after a check that it and its JSON can be written there.

    Raises
    ------
    UsageError
        If one of the two files cannot be written, if the JSON would go to the
        same file, or if a file of its name is there that is not a report's JSON.
    """
    check_target(path)
    target = Path(path)
    beside = target.with_suffix(".json")
    if target.suffix.lower() not in (".html", ".htm"):
        raise UsageError(f"{target}: expected the name of an HTML file (.html); the JSON goes beside it")
    if check_target(beside).exists() and not _is_a_reports(beside):
        raise UsageError(
            f"{beside}: the JSON of the report {target.name} goes there; expected none or that of an older "
            "report, found another file"
        )
    return target


def _is_a_reports(path: Path) -> bool:
    """Whether a file begins as what :func:`write_report` puts beside a report."""
    start = as_text({"report": REPORT}).removesuffix("\n}").encode()
    try:
        with path.open("rb") as file:
            return file.read(len(start)) == start
    except OSError as error:
        raise UsageError(f"{path}: cannot be read ({error.strerror})") from None


def render(verification: Verification) -> str:
    """A verification as one self-contained HTML page."""
    environment = Environment(
        loader=PackageLoader("shakedown.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        finalize=_shown,
    )
    return environment.get_template("report.html.j2").render(_context(verification))


def _shown(value: Any) -> Any:
    """What the page shows of a value: texts without control characters, pictures as they are."""
    return visible(value) if isinstance(value, str) and not isinstance(value, Markup) else value


def _context(v: Verification) -> dict[str, Any]:
    problem = v.problem
    return {
        "title": shortened(problem.name) or "unnamed problem",
        "subtitle": f"{problem.n} contact nodes, {problem.m} load steps, friction {_friction(problem.f)}"
        + (f", units {shortened(problem.units)}" if problem.units else ""),
        "headline": as_given_in_words(v.as_given, units_of(problem)[1]),
        "certain": certain_in_words(v.energy, v.universal, v.bounds.upper),
        "verdict": _verdict(v),
        "verdict_class": _verdict_class(v),
        "problems": [*v.disagreements, *v.open_questions],
        "notes": [*hints_in_words(problem), *v.notes],
        "bounds": _bounds_rows(v),
        "meaning": [
            *bounds_in_words(v.bounds),
            *([] if v.transient is None else [transient_in_words(v.transient)]),
        ],
        "friction": friction_in_words(v.problem, v.friction),
        "runs": [_run_row(run) for run in v.runs],
        "runs_note": RUNS_NOTE,
        "figures": _figures(v),
        "unit": f" ({shortened(problem.units.split(',')[-1].strip())})" if "," in problem.units else "",
        "nodes": _node_rows(v),
        "critical": critical_in_words(v.critical, v.subsets, v.bounds),
        "provenance": f"shakedown {version('shakedown-bounds')}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, {datetime.datetime.now(datetime.UTC):%Y-%m-%d %H:%M} UTC",
    }


RUNS_NOTE = (
    "Agreement is judged only where the bounds predict something: below λ_1 every initial state must shake "
    "down, above λ_max none can with all nodes in contact, the safe slip shakes down up to λ_max, and so "
    "does every state inside the energy ball (“ball”: drawn just inside its surface); with nodes open the "
    "safe slip of the zone, those nodes open and the transient left out, stays at rest up to its λ_max. "
    "Slip per period: Σ|Δv| of the "
    "node that slips most, over one period of the long-term state. The law residual is the largest "
    "violation of the contact and friction law over that period (with fixed load steps: over all of them), "
    "re-computed from slips and gaps alone."
)


def _verdict_class(v: Verification) -> str:
    """The colour of the banner: green only where the joint shakes down and nothing contradicts."""
    outcome = v.as_given.simulation.outcome
    if v.disagreements or outcome in (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING):
        return "disagree"
    return "agree" if outcome == Outcome.SHAKEDOWN and not v.open_questions else "open"


def _verdict(v: Verification) -> str:
    judged = sum(run.agrees is not None for run in v.runs)
    if v.disagreements:
        return f"DISAGREEMENT: {_count(len(v.disagreements), 'finding')}."
    if v.open_questions:
        return f"Open: {_count(len(v.open_questions), 'question')}."
    return (
        f"Prediction and time integration agree in all {judged} runs for which the bounds predict "
        f"an outcome ({len(v.runs)} runs in all)."
    )


def _count(number: int, noun: str) -> str:
    return f"{number} {noun}{'s' * (number != 1)}"


def _friction(f: np.ndarray) -> str:
    return f"{f[0]:g}" if (f == f[0]).all() else f"{f.min():g} … {f.max():g} (per node)"


def _bounds_rows(v: Verification) -> list[tuple[str, str, str, str]]:
    pairs = (
        ("lower bound λ_1 (first collapse)", v.bounds.lower.load_factor, v.second_lower.load_factor),
        (_name_of_largest(v), v.bounds.upper.load_factor, v.second_upper.load_factor),
    )
    upper = v.bounds.upper.load_factor
    scale = upper if np.isfinite(upper) else 0.0  # a bound may be zero
    return [
        (name, _number(one, 10), _number(two, 10), _difference(one, two, scale)) for name, one, two in pairs
    ]


def _name_of_largest(v: Verification) -> str:
    opened = v.bounds.upper.open_nodes
    if opened:
        return f"λ_max of the zone (a safe slip exists with {open_in_words(opened)} open)"
    return "upper bound λ_max (a safe slip exists)"


def _difference(one: float, two: float, scale: float) -> str:
    if not (np.isfinite(one) and np.isfinite(two)):
        return "–"
    size = max(abs(one), abs(two), scale)
    return f"{abs(one - two) / size:.1e}" if size else "0"


def _number(value: float, digits: int = 6) -> str:
    if np.isnan(value):
        return "–"
    return f"{value:.{digits}g}" if np.isfinite(value) else ("∞" if value > 0 else "−∞")


def _run_row(run: Run) -> dict[str, str]:
    s = run.simulation
    words = {True: ("yes", "yes"), False: ("no", "NO"), None: ("none", "–")}
    mark, agree = words[run.agrees]
    return {
        "load_factor": _number(s.load_factor),
        "region": run.region,
        "initial": run.initial + " (zone)" * bool(run.open_nodes),
        "predicted": run.predicted,
        "outcome": s.outcome + _remarks(s),
        "mark": mark,
        "agree": agree,
        "cycles": str(s.cycles_simulated),
        "slip": _number(float(np.max(s.slip_per_cycle)), 4),
        "dissipation": _number(s.dissipation_per_cycle, 4),
        "residual": "–" if np.isnan(s.residual) else f"{s.residual:.0e}",
        "time": f"{1e3 * run.seconds:.1f} ms",
    }


def _remarks(run: Simulation) -> str:
    """Period, jumps and open nodes of a long-term state, where there is something to say."""
    remarks = [f"period {run.period}"] if run.period > 1 else []
    if run.jumps_per_cycle > 0:
        lost = _number(run.jump_dissipation_per_cycle, 4)
        remarks.append(f"jumps per cycle: {run.jumps_per_cycle:g}, damping takes {lost}")
    if run.open_nodes:
        remarks.append(f"open throughout: {nodes_in_words(run.open_nodes)}")
    if run.proved:
        remarks.append("proved")
    return f" ({'; '.join(remarks)})" if remarks else ""


def _node_rows(v: Verification) -> list[tuple[str, str, str, str, str]]:
    upper, lower = v.bounds.upper, v.bounds.lower
    rows = []
    for j in range(v.problem.n):
        active = " and ".join(SIDE_NAMES[side] for node, side in upper.active if node == j) or "–"
        threshold = _number(v.friction.single_node[j], 5)
        rows.append((str(j), _number(upper.slip[j]), _number(lower.slip[j]), active, threshold))
    return rows


def _figures(v: Verification) -> list[dict[str, str]]:
    figures = [
        (
            slip_per_cycle_figure(v),
            "Slip per cycle of the node that slips most, against the cycle number. A line that falls to "
            "the floor has shaken down; a level line is cyclic slip or ratchetting.",
        )
    ]
    if v.problem.n == 2:
        figures.append(
            (
                slip_space_figure(v),
                "Slip space: the limits of both nodes at their extreme load steps, the safe region between "
                "them, and the paths from the initial states (circle: start, square: end).",
            )
        )
    if v.problem.n > 2:
        figures.append((slip_along_contact_figure(v), "Slip along the contact at the end of each run."))
    if v.curve is not None:
        stays = (
            "No slip leads out of such a box, so that a joint that starts inside stays inside."
            if v.curve.invariant
            else "Slip may lead out of such a box: the coupling is too strong for it to be invariant."
        )
        caption = f"First collapse when every other slip keeps within R of the safe slip. {stays}"
        figures.append((guarantee_curve_figure(v), caption))
    return [{"svg": _svg(figure), "caption": caption} for figure, caption in figures]


def _svg(figure: Figure) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg", metadata={"Date": None})
    text = buffer.getvalue()
    return text[text.index("<svg") :]
