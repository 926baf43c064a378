"""The verification report: one self-contained HTML file with its pictures, and the same as JSON."""

import os
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from itertools import groupby
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from shakedown import plot
from shakedown.assessment.verify import Verification
from shakedown.files.atomic_write import atomic_write_together, check_target
from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import EACH_SHOWN, SIX_DIGITS
from shakedown.ground.errors import UsageError, present
from shakedown.ground.shown_values import SUBSCRIPT, at_lambda, count, shortened, sized, visible
from shakedown.ground.status import OPEN, STICK, Outcome
from shakedown.ground.work_limit import on_one_thread
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.conjugate_displacement import load_loops
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory
from shakedown.plot import patch_places
from shakedown.plot.inline_svg import PANEL, SIDE_BY_SIDE, Drawing, Picture, picture
from shakedown.plot.patch_places import in_space
from shakedown.plot.paths import extreme_rows, work_of_nodes
from shakedown.plot.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, RED
from shakedown.report import run_facts
from shakedown.report.data_facts import configuration, joint_facts, open_in_words, resolution, source_facts
from shakedown.report.facts import TOGETHER, Section, as_text, notes
from shakedown.report.limit_facts import limit_sections

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
    sheet = replace(run_facts.verify_sheet(v), sections=list(_sections(v)))
    known = {
        "title": shortened(v.problem.name) or "unnamed problem",
        "sheet": sheet,
        "findings": run_facts.findings(v),
        "verdict_class": run_facts.banner_class(v),
        "scale": scale_picture(v),
        "view": contact_to_turn(v),
        "view_in": STATE,
        "configuration": configuration(v.problem),
    }
    return environment().get_template("report.html.j2").render(known)


def _sections(v: Verification) -> Iterator[Section]:
    """What follows the first page: limits, runs, the state at λ = 1, the joint, provenance."""
    problem = v.problem
    limits, rest, slips = limit_sections(v.assessment, simulated=True)
    yield limits
    yield replace(rest, notes=[*rest.notes, *run_facts.remarks_of(v)], pictures=limit_pictures(v))
    yield Section("Runs", pictures=[run_picture(v)])
    yield replace(run_facts.runs_section(v), title=f"Table of {count(len(v.runs), 'run')}", folded=True)
    worst = [run_facts.worst_table(problem, v.nodes)] if v.nodes.period else []
    texts = [each for each in [no_pictures(v)] if each]
    texts += [notes.summed, notes.mesh_at_edges, notes.all_nodes] if worst else []
    yield Section(STATE, (), worst, texts, state_pictures(v))
    yield Section("Joint", joint_facts(problem), pictures=problem_pictures(problem))
    yield replace(slips, title=f"Safe slip of {count(problem.n, 'node')}", folded=True)
    yield Section(
        "Provenance", [*source_facts(problem), *run_facts.provenance(v)], (), [notes.assumed, notes.not_said]
    )


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


MOVING = (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING)
COLOURS = {"zero": BLACK, "safe": GREEN, "witness": RED, "given": PURPLE, "random": BLUE, "ball": ORANGE}
DASHES = ("-", "--", ":", "-.")
THICK = 3.0  # width of the first line, in points


def scale_picture(v: Verification) -> Picture:
    """Every limit of the load factor on one scale, with λ = 1; in two sizes, of which the page shows one."""
    marks, known, opened = run_facts.limits_on_page(v), v.limits.from_state, v.limits.open_nodes
    here, everywhere = np.nan_to_num([known.load_factor, v.limits.universal.load_factor], posinf=np.inf)
    bands = {"proved": (0.0 if everywhere >= here else known.least_load_factor, max(here, everywhere))}
    state = f"with {open_in_words(opened, v.problem)} open" if opened else "from this state"
    caption = f"Green: proved to shake down {state}." * bool(bands["proved"][1] > 0)
    never = v.assessment.impossible_above
    if not opened and np.isfinite(never):
        bands["impossible"] = (never, np.inf)
        caption += " Orange: shakedown is impossible while all nodes stay in contact. White: not decided."
    draw = partial(plot.load_factor_scale, marks, bands=bands)
    wide, narrow = (8.0, 1.8), (3.4, 2.6)  # inches
    return picture(caption.strip(), Drawing(draw, size=wide), Drawing(draw, size=narrow))


def run_picture(v: Verification) -> Picture:
    """Slip per cycle of the runs, a panel per load factor."""
    drawings, resting = list[Drawing](), list[str]()
    for (factor, region), group in groupby(v.runs, key=lambda run: (run.simulation.load_factor, run.region)):
        title, runs = f"{at_lambda(factor)}, {region}", {run.initial: run.simulation for run in group}
        styles: dict[str, dict[str, Any]] = {}
        for name in runs:
            kind, _, index = name.partition(" ")  # as in "random 2"
            dashes = DASHES[int(index or 0) % len(DASHES)]
            width = THICK - (THICK - 1.0) * len(styles) / len(runs)  # none hides those below it
            styles[name] = {"color": COLOURS[kind], "ls": dashes, "lw": width, "label": name}
        none = float(resolution(v.problem, factor)[0].max())  # up to this there is no slip
        if any(run.cycles.slip.max(initial=0.0) > none for run in runs.values()):
            draw = partial(plot.slip_per_cycle, runs, v.problem, styles=styles, resolution=none)
            drawings.append(Drawing(draw, title))
        else:
            resting.append(title)
    still = f"Not drawn, as nothing slips or no cycle ends: {', '.join(resting)}." * bool(resting)
    caption = f"{notes.slip_per_cycle * bool(drawings)} {still}".strip()
    return picture(caption, *drawings, alike=len(drawings), one_legend=True)


def limit_pictures(v: Verification) -> list[Picture]:
    """What limits the joint, a panel for each limit with derivatives; the slip over the load if asked for."""
    found = [each for each in map(present, v.limits.sensitivities.values()) if each is not None]
    known = [each for each in found if each.ranked().size]
    pictures = []
    if known:
        caption = notes.changes + f" {notes.kinks}" * any(not each.smooth for each in known)
        panels = [Drawing(partial(plot.sensitivity, each, v.problem), each.symbol) for each in known]
        pictures.append(picture(caption, *panels, one_legend=True))
    if v.slip_limit is not None:
        draw = partial(plot.slip_over_load, v.slip_limit, v.problem)
        pictures.append(picture(notes.slip_over_load, Drawing(draw)))
    return pictures


def as_given_state(v: Verification) -> LongTermState | None:
    """The long-term state at λ = 1; None where it was not followed from event to event."""
    state = v.as_given.simulation.long_term
    return None if state is None or not len(state.history) else state


def cycling_state(v: Verification) -> LongTermState | None:
    """A state in which nodes slip: at λ = 1, or at the nearest simulated load factor above."""
    if v.as_given.simulation.outcome in MOVING:
        return as_given_state(v)
    states = [run.simulation.long_term for run in v.runs if run.initial == v.as_given.initial]
    states.sort(key=lambda state: inf if state is None else state.load_factor)
    for state in [*states, None if v.transient is None else v.transient.at_high]:
        if state is not None and state.outcome in MOVING and state.load_factor > 1 and len(state.history):
            return state
    return None


def which_state(state: LongTermState) -> str:
    """Words that identify one of these states."""
    if state.load_factor == 1:
        return "at λ = 1, the nominal load"
    return f"at {at_lambda(state.load_factor)}, the nearest simulated load that slips"


def _of_state(state: LongTermState, caption: str, *drawings: Drawing, one_legend: bool = False) -> Picture:
    """Panels of a state under one caption, with the load factor above them."""
    name = at_lambda(state.load_factor)
    whole = f"{caption} ({which_state(state)}).{_left_out(state.problem)}"
    return picture(whole, *(each._replace(name=name) for each in drawings), one_legend=one_legend)


def state_pictures(v: Verification) -> list[Picture]:
    """Loops of the nodes that dissipate most, slips and friction work, reactions, zones."""
    given, cycling, problem, pictures = as_given_state(v), cycling_state(v), v.problem, list[Picture]()
    if cycling is not None:
        pictures += [_loops(cycling), *_load_loops(cycling)]
        pictures += [_slips(cycling)] if problem.n > SIDE_BY_SIDE else []
    if given is not None:
        pictures.append(_reactions(given))
    shown = cycling or given
    if shown is not None and shown.history.state.any():
        pictures.append(_zones(shown))
    return pictures


def contact_to_turn(v: Verification) -> dict[str, str] | None:
    """Data for the script of the view: a state in which nodes slip, or else that at λ = 1; and which."""
    state = cycling_state(v) or as_given_state(v)
    if state is None or not patch_places.can_be_turned(v.problem):
        return None
    data = Markup(patch_places.patch_data(state))
    return {"data": data, "which": which_state(state), "name": at_lambda(state.load_factor)}


def no_pictures(v: Verification) -> str:
    """Why some pictures are missing; empty where none are."""
    if v.as_given.simulation.long_term is None:
        return notes.stepped
    absent = notes.no_loops if as_given_state(v) is not None else notes.no_state
    unplaced = in_space(v.problem) and patch_places.model_places(v.problem) is None
    return f"{absent * (cycling_state(v) is None)} {notes.no_view * unplaced}".strip()


def _loops(state: LongTermState) -> Picture:
    """Hysteresis loops, or orbits of slips and reactions, of the nodes that dissipate most."""
    problem, work = state.problem, work_of_nodes(state)
    most = np.argsort(-work, kind="stable")[:EACH_SHOWN].tolist()
    worst = [node for node in most if work[node] > SIX_DIGITS * work.max()] or [0]
    if in_space(problem):
        what, draw = "Slip orbits", plot.slip_orbits
        beside: Callable[..., object] = partial(plot.reaction_orbits, nodes=worst)
    else:
        what, draw = "Hysteresis loops", plot.hysteresis
        beside = partial(plot.reactions_in_time, node=worst[0])
    total = sized(state.dissipation_per_cycle, units_of(problem).work)
    caption = f"{what} of the nodes that dissipate most, and their reactions; {total} per cycle in all"
    draws = partial(draw, state, problem, nodes=worst), partial(beside, state, problem)
    return _of_state(state, caption, *(Drawing(draw) for draw in draws))


def _load_loops(state: LongTermState) -> Iterator[Picture]:
    """Loops of the loads that vary most, where the joint knows how far its loads move."""
    problem = state.problem
    if problem.load_compliance is None or problem.load_history is None:
        return
    areas = np.abs(load_loops(problem, state).areas)
    varying = np.flatnonzero(np.ptp(problem.load_history, axis=0) > 0)
    chosen = varying[np.argsort(-areas[varying], kind="stable")][:SIDE_BY_SIDE].tolist()
    if chosen:
        drawings = [Drawing(partial(plot.loop, state, load=j)) for j in chosen]
        caption = "Loops of the loads: together their areas are what is dissipated in one period"
        yield _of_state(state, caption, *drawings)


def _reactions(state: LongTermState) -> Picture:
    """Reactions of a few nodes over time; of more, pressure and use of friction at instants."""
    path, problem = state.history, state.problem
    caption = "Normal reactions, and use of friction: {} a node is at its limit"
    if in_space(problem):  # where reactions are largest, and where the total pressure is smallest
        times = [float(path.cycle[row]) for row in extreme_rows(path)[:0:-1]]
        times = times[: 1 + (abs(times[1] - times[0]) > 0.5 / SIDE_BY_SIDE)]  # near in time they look alike
        drawn = plot.pressure_over_patch, plot.friction_use_at
        draws = [partial(draw, path, problem, time) for time in times for draw in drawn]
        return _of_state(state, caption.format("at the rim"), *_panels(problem, *draws))
    if problem.n <= SIDE_BY_SIDE:
        each = [partial(plot.reactions_in_time, path, problem, node) for node in range(problem.n)]
        return _of_state(state, "Tangential reactions between their limits", *map(Drawing, each))
    times = path.cycle[0] + np.arange(EACH_SHOWN) / EACH_SHOWN * (path.cycle[-1] - path.cycle[0])
    along = [
        partial(draw, path.at(times), problem, cycles=times) for draw in (plot.pressure, plot.friction_use)
    ]
    return _of_state(state, caption.format("at ±1"), *map(Drawing, along))


def _slips(state: LongTermState) -> Picture:
    """How far each node slips, and what friction dissipates there."""
    problem, caption = state.problem, "Slip range of each node"
    draws = plot.slip_range, plot.dissipation_along
    if in_space(problem):
        caption, draws = "Slip Σ|Δv| of each node", (plot.slip_over_patch, plot.work_over_patch)
    panels = _panels(problem, *(partial(draw, state, problem) for draw in draws))
    return _of_state(state, f"{caption}, and its friction work in one period", *panels)


def _zones(state: LongTermState) -> Picture:
    """Stick, slip and open zones: over position and time, or at instants of the period."""
    path, problem, caption = state.history, state.problem, "What sticks, slips and is open in one period"
    if not in_space(problem):
        return _of_state(state, caption, Drawing(partial(plot.zones, path, problem)))
    draws = [partial(plot.zones_at, path, problem, time) for time in instants(path)]
    return _of_state(state, caption, *_panels(problem, *draws), one_legend=True)


def instants(path: EventHistory) -> list[float]:
    """Times in each third of a path at which the fewest nodes stick, for longer than round-off."""
    lasting = np.diff(path.cycle) > SIX_DIGITS
    middles, state = 0.5 * (path.cycle[:-1] + path.cycle[1:])[lasting], path.state[:-1][lasting]
    moving = (state != STICK).sum(axis=1) + 0.5 * (state == OPEN).any(axis=1)
    thirds = np.array_split(np.arange(len(middles)), SIDE_BY_SIDE)
    return [float(middles[third[moving[third].argmax()]]) for third in thirds if len(third)]


def problem_pictures(problem: Problem) -> list[Picture]:
    """Nodes and the loads on them; in the plane the loads of a few nodes within their limits; their sums."""
    space = in_space(problem)
    drawings = _panels(problem, partial(plot.welded_pressure_over_patch if space else plot.contact, problem))
    if problem.n <= SIDE_BY_SIDE and not space:
        drawings.append(Drawing(partial(plot.load_loop, problem, range(problem.n))))
    drawings.append(Drawing(partial(plot.loads_in_time, problem)))
    return [picture(f"{notes.loads}{_left_out(problem)}", *drawings)]


def _panels(problem: Problem, *draws: Callable[..., object]) -> list[Drawing]:
    """Panels of a joint in the plane; of one in space for every patch, as high as the patch needs."""
    if not in_space(problem):
        return [*map(Drawing, draws)]
    panels = []
    for patch in range(min(patch_places.patch_count(problem), EACH_SHOWN)):
        places, (width, highest) = patch_places.places_of(problem, patch), PANEL
        wide, high = np.ptp(places.points, axis=0) + places.spacing
        # inches: 1.3 of room about a patch for labels; 2.1 is the least height of a picture of one
        size = width, float(np.clip((width - 1.3) * high / wide + 1.3, 2.1, highest))
        panels += [Drawing(partial(draw, patch=patch), size=size) for draw in draws]
    return panels


def _left_out(problem: Problem) -> str:
    """A sentence on patches that are not drawn."""
    count = patch_places.patch_count(problem) if in_space(problem) else 0
    return f" The {EACH_SHOWN} patches with the most nodes, of {count}." * (count > EACH_SHOWN)
