"""The verification report: one self-contained HTML file, and the same as JSON."""

import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from shakedown.assessment.verify import Verification
from shakedown.files.atomic_write import atomic_write_together, check_target
from shakedown.ground.argument_kinds import checked
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import SUBSCRIPT, count, shortened, visible
from shakedown.ground.work_limit import on_one_thread
from shakedown.report import figures
from shakedown.report.data_facts import configuration, joint_facts, source_facts
from shakedown.report.facts import TOGETHER, Section, as_text, notes
from shakedown.report.limit_facts import limit_sections
from shakedown.report.run_facts import (
    banner_class,
    findings,
    provenance,
    remarks_of,
    runs_section,
    verify_sheet,
    worst_table,
)

STATE = "State at λ = 1"
REPORT = "shakedown-bounds verify"  # the first entry of a report's JSON


@checked
@on_one_thread
def write_report(path: str | os.PathLike[str], verification: Verification) -> None:
    """Write a verification as HTML, and as JSON beside it (same name, suffix .json).

    Parameters
    ----------
    path
        Where the page goes.
    verification
        What is reported.

    Raises
    ------
    UsageError
        If a file cannot be written.
    """
    target = report_path(path)
    document = {"report": REPORT} | verification.to_dict()
    page = render(verification)
    with atomic_write_together([target, target.with_suffix(".json")]) as (html_file, json_file):
        html_file.write(page.encode())
        json_file.write(as_text(document).encode())


@checked
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


@on_one_thread
def render(v: Verification) -> str:
    """A verification as one self-contained HTML page."""
    sheet = replace(verify_sheet(v), sections=list(_sections(v)))
    known = {
        "title": shortened(v.problem.name) or "unnamed problem",
        "sheet": sheet,
        "findings": findings(v),
        "verdict_class": banner_class(v),
        "scale": figures.scale_picture(v),
        "view": figures.contact_to_turn(v),
        "view_in": STATE,
        "configuration": configuration(v.problem),
    }
    return environment().get_template("report.html.j2").render(known)


def _sections(v: Verification) -> Iterator[Section]:
    """What follows the first page: limits, runs, the state at λ = 1, the joint, provenance."""
    problem = v.problem
    limits, rest, slips = limit_sections(v.assessment, simulated=True)
    yield limits
    yield replace(rest, notes=[*rest.notes, *remarks_of(v)], pictures=figures.limit_pictures(v))
    yield Section("Runs", pictures=figures.run_pictures(v))
    yield replace(runs_section(v), title=f"Table of {count(len(v.runs), 'run')}", folded=True)
    worst = [worst_table(problem, v.nodes)] if v.nodes.period else []
    said = [each for each in [figures.no_pictures(v)] if each]
    said += [notes.summed, notes.mesh_at_edges, notes.all_nodes] if worst else []
    yield Section(STATE, (), worst, said, figures.state_pictures(v))
    yield Section("Joint", joint_facts(problem), pictures=figures.problem_pictures(problem))
    yield replace(slips, title=f"Safe slip of {count(problem.n, 'node')}", folded=True)
    yield Section("Provenance", [*source_facts(problem), *provenance(v)], (), [notes.assumed, notes.not_said])


def environment() -> Environment:
    """The environment of the templates: texts get subscripts, and special characters are escaped."""
    found = Environment(
        loader=PackageLoader("shakedown.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        finalize=_shown,
    )
    found.filters["as_written"] = _as_written
    return found


def _shown(value: Any) -> Any:
    """A value as the page shows it: texts with subscripts, without control characters; pictures unchanged."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    together = TOGETHER.sub("\u00a0", str(_as_written(value)))
    return Markup(SUBSCRIPT.sub(r"\1<sub>\2</sub>", together))


def _as_written(value: str) -> Markup:
    """A text of the user's own, unchanged but escaped."""
    return escape(visible(value, keep="\n"))
