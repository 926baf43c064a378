"""The verification report: one self-contained HTML file, and the same as JSON."""

import datetime
import os
import platform
import re
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from shakedown.assessment.verify import Verification
from shakedown.files.atomic_write import atomic_write_together, check_target
from shakedown.ground.argument_kinds import checked
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import count
from shakedown.ground.visible_text import SUBSCRIPT, shortened, visible
from shakedown.joint.doubtful_data import doubtful_data
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.report.answer_words import (
    answer_in_words,
    banner_class,
    limits_in_words,
    margin_of_answer,
    verdict_in_words,
)
from shakedown.report.assessment_words import HEADING, certain_in_words, load_steps_in_words
from shakedown.report.bound_words import bounds_in_words
from shakedown.report.data_page import (
    configuration,
    friction,
    loading_rows,
    node_load_head,
    node_load_rows,
    source_rows,
    stiffness_rows,
)
from shakedown.report.first_page import large_numbers, rest_table
from shakedown.report.friction_words import critical_in_words, friction_in_words
from shakedown.report.hint_words import relative_in_words
from shakedown.report.json_documents import as_text, verification_document
from shakedown.report.limit_words import sensitivities_in_words, transient_beside_in_words
from shakedown.report.load_figures import problem_pictures
from shakedown.report.mesh_words import averaged_in_words, refinement_in_words, refinement_notes
from shakedown.report.node_words import no_node_ever_slips, slip_limit_in_words, total_slip_in_words
from shakedown.report.page_tables import (
    PageTable,
    bounds_table,
    nodes_note,
    nodes_table,
    printed_nodes,
    refinement_table,
    runs_table,
    worst_table,
)
from shakedown.report.period_figures import contact_to_turn, no_pictures, state_pictures
from shakedown.report.run_words import SEPARATION, as_given_in_words
from shakedown.report.verification_figures import (
    refinement_picture,
    run_pictures,
    scale_picture,
    sensitivity_picture,
    slip_picture,
)
from shakedown.studies.refined import Refinement

LOAD_FACTOR = re.compile(r"(λ(?:_\w+)?) = (?=\d)")  # no line ends between a load factor and its number
REPORT = "shakedown-bounds verify"  # the first entry of a report's JSON


@checked
@on_one_thread
def write_report(
    path: str | os.PathLike[str],
    verification: Verification,
    *,
    average: float | None = None,
    refinement: Refinement | None = None,
) -> None:
    """Write a verification as HTML, and as JSON beside it (same name, suffix .json).

    Parameters
    ----------
    path
        Where the page goes.
    verification
        What is reported.
    average
        Also the three numbers of slips averaged over this length (:func:`averaged`) [length].
    refinement
        Also which numbers of the joint converge with its mesh (:func:`refine`), of which it is one.

    Raises
    ------
    UsageError
        If a file cannot be written, or the joint is on none of the meshes of the refinement.
    """
    if not isinstance(verification, Verification):
        raise UsageError(f"verification: expected a Verification, found {type(verification).__name__}")
    target = report_path(path)
    document = {"report": REPORT} | verification_document(verification, average, refinement)
    page = render(verification, average, refinement)
    with atomic_write_together([target, target.with_suffix(".json")]) as (html_file, json_file):
        html_file.write(page.encode())
        json_file.write(as_text(document).encode())


def check_refinement(refinement: Refinement | None, problem: Problem) -> None:
    """Raise ``UsageError`` where a refinement belongs to other joints."""
    if refinement is not None and problem.fingerprint not in refinement.fingerprints:
        raise UsageError(
            "refinement: expected meshes of which the joint has one, found only others "
            f"({shortened(str(refinement.nodes.tolist()))} contact nodes)"
        )


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
def render(
    verification: Verification, average: float | None = None, refinement: Refinement | None = None
) -> str:
    """A verification as one self-contained HTML page."""
    check_refinement(refinement, verification.problem)
    known = _context(verification) | _meshes(verification.problem, refinement)
    known["reservations"] += _beside(verification, average, refinement)
    return environment().get_template("report.html.j2").render(known)


def _beside(v: Verification, average: float | None, refinement: Refinement | None) -> list[str]:
    """Sentences on averaged slips and on other meshes, below the answer."""
    averaged = [] if average is None else [averaged_in_words(v.assessment.averaged(average), average)]
    others = [] if refinement is None else [f"{refinement_in_words(refinement)} See “Meshes”."]
    return averaged + others


def _meshes(problem: Problem, refinement: Refinement | None) -> dict[str, Any]:
    """The section about meshes; None where there is none."""
    if refinement is None:
        return {"meshes": None}
    notes = refinement_in_words(refinement), *refinement_notes(refinement, problem)
    return {
        "meshes": {
            "table": refinement_table(refinement, problem, len(refinement.nodes)),
            "picture": refinement_picture(refinement),
            "notes": notes,
        }
    }


def environment() -> Environment:
    """The environment of the templates: texts get subscripts, and special characters are escaped."""
    found = Environment(
        loader=PackageLoader("shakedown.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        finalize=_shown,
    )
    found.filters |= {"as_written": _as_written, "attribute": _attribute}
    return found


def _shown(value: Any) -> Any:
    """A value as the page shows it: texts with subscripts, without control characters; pictures unchanged."""
    if not isinstance(value, str) or isinstance(value, Markup):
        return value
    together = LOAD_FACTOR.sub("\\1\u00a0=\u00a0", str(_as_written(value)))
    return Markup(SUBSCRIPT.sub(r"\1<sub>\2</sub>", together))


def _as_written(value: str) -> Markup:
    """A text of the user's own, unchanged but escaped."""
    return escape(visible(value, keep="\n"))


def _attribute(value: str) -> Markup:
    """A text where there can be no subscripts, as in an attribute."""
    return _as_written(SUBSCRIPT.sub(r"\1\2", value))


def _context(v: Verification) -> dict[str, Any]:
    problem, in_space = v.problem, v.problem.directions > 1
    certain, *reservations = certain_in_words(v.limits)
    return {
        "title": shortened(problem.name) or "unnamed problem",
        "space": in_space,
        "subtitle": f"{count(problem.n, 'contact node')}{' in space' * in_space}, {_steps(problem)}, "
        f"friction {friction(problem)}" + (f", units {shortened(problem.units)}" if problem.units else ""),
        "answer": answer_in_words(v),
        "margin_of_answer": margin_of_answer(v),
        "mesh_warning": v.limits.mesh.warning,
        "total_slip": "" if no_node_ever_slips(v.nodes) else total_slip_in_words(v.nodes, problem),
        "headline": as_given_in_words(v.as_given, units_of(problem).length, problem, v.limits.universal),
        "reservations": [
            *(f"Warning: {warning}." for warning in problem.warnings),
            *reservations,
            *doubtful_data(problem),
        ],
        "verdict": verdict_in_words(v),
        "verdict_class": banner_class(v),
        "problems": [*v.disagreements, *v.open_questions],
        "tiles_name": " ".join([HEADING.removesuffix(" is"), *_through(problem), "is"]),
        "tiles": large_numbers(v),
        "rest": rest_table(v),
        "scale": scale_picture(v),
        "problem_pictures": problem_pictures(problem),
        "stiffness": PageTable(
            ["checked", "found", "result"], stiffness_rows(problem, _coupling_ratio(v)), (0, 1, 2)
        ),
        "loading": PageTable(["loading", ""], loading_rows(problem), (0, 1)),
        "loads": PageTable(node_load_head(problem), node_load_rows(problem), (), printed_nodes(v)),
        "sources": PageTable(["source", ""], source_rows(problem), (0, 1)),
        "configuration": configuration(problem),
        "notes": v.notes,
        "bounds": bounds_table(v),
        "meaning": [
            certain,
            *bounds_in_words(v.limits),
            *transient_beside_in_words(v),
            *([] if v.slip_limit is None else [slip_limit_in_words(v.slip_limit, problem)]),
        ],
        "slips": slip_picture(v),
        "limited": sensitivities_in_words(v.limits),
        "sensitivity": sensitivity_picture(v),
        "friction": friction_in_words(problem, v.limits.friction),
        "runs": runs_table(v),
        "runs_note": _runs_note(not in_space),
        "run_pictures": run_pictures(v),
        "state_pictures": state_pictures(v),
        "no_pictures": no_pictures(v),
        "view": contact_to_turn(v),
        "nodes": nodes_table(v),
        "worst": worst_table(v),
        "nodes_note": nodes_note(v),
        "relative": relative_in_words(problem, v.limits.open_nodes),
        "critical": critical_in_words(v.critical, v.limits.subsets, v.limits.bounds),
        "limits": limits_in_words(v),
        "provenance": _provenance(v),
    }


def _through(problem: Problem) -> list[str]:
    """For which path of the loads the three numbers hold, where they are not about every path."""
    steps = load_steps_in_words(problem)
    return [f"{steps},"] if steps else []


def _coupling_ratio(v: Verification) -> float:
    """ρ*, where there is one."""
    lower = v.limits.lower
    return lower.coupling_ratio if lower else np.nan


def _steps(problem: Problem) -> str:
    """How many load steps, or corners, the loading has."""
    if problem.is_domain:
        return f"load domain of {count(problem.m, 'corner')}"
    return count(problem.m, "load step")


def _runs_note(plane: bool) -> str:
    """What the columns of the table of runs mean; some sentences are for joints in the plane only."""
    return RUNS_NOTE.format(
        predicted="up to λ_1 that is predicted, and proved only where the guarantee of λ_1 says so; " * plane,
        box=", and the state asked about below its λ_S",
        domain="Of a load domain λ_1 predicts nothing; its" if plane else "Of a load domain the",
    )


RUNS_NOTE = (
    "Agreement is judged only where the bounds predict something: below λ_U every initial state, closed and "
    "admissible, is proved to shake down; {predicted}"
    "above λ_max none can while all nodes stay in contact; the safe slip shakes down below λ_max, "
    "and so does every state inside the energy ball (“ball”: drawn just inside its surface, but no farther "
    "from its centre than the other states){box}. "
    "Transient load steps come first: "
    "then the safe slip is one that they do not move, or else one locked in after them "
    "(“after”), and what is said of every state is said of those that they leave closed. "
    "{domain} corners are followed in the order given. With nodes "
    "open the safe slip of the zone, those nodes open and the transient left out, stays at rest up to its "
    "λ_max. Slip per period: Σ|Δv| of the "
    "node that slips most, over one period of the long-term state. The law residual is the largest "
    "violation of the contact and friction law over that period (with fixed load steps: over all of them), "
    "re-computed from slips and gaps alone. " + SEPARATION
)


def _provenance(v: Verification) -> str:
    """Version, date, machine, seed: what is needed to reproduce the report."""
    asked = v.settings
    return (
        f"shakedown {version('shakedown-bounds')}, Python {platform.python_version()}, "
        f"NumPy {np.__version__}, {datetime.datetime.now(datetime.UTC):%Y-%m-%d %H:%M} UTC, "
        f"{platform.system()} {platform.machine()}, {os.cpu_count()} processors; method {asked.method}, "
        f"at most {asked.cycles} cycles, {count(asked.random_states, 'random transient')} with seed "
        f"{asked.seed}."
    )
