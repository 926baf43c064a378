"""Up to which load factor a joint shakes down: three claims, what decides them, every limit."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isinf, isnan, nan
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from shakedown.assessment.three_numbers import admitted_up_to, first_to_leave
from shakedown.bounds.registry import BOUNDS, Claim
from shakedown.ground.errors import Missing, present
from shakedown.ground.shown_values import DIGITS, FEW_DIGITS, certain_digits, count, down, few, sized
from shakedown.ground.status import Said, Status
from shakedown.ground.visible_text import with_unit
from shakedown.joint.constraints import SIDE_NAMES
from shakedown.joint.loading import loading
from shakedown.joint.units import units_of, varying_loads_in_words
from shakedown.report import notes
from shakedown.report.data_facts import headline, load_path, relative_to
from shakedown.report.facts import (
    Fact,
    Rounding,
    Section,
    Sheet,
    Table,
    limits_as_text,
    margin,
    number,
    signed,
)
from shakedown.report.node_names import by_direction, node_column, node_in_words, open_in_words, ranges

if TYPE_CHECKING:
    from shakedown.assessment.assess import Assessment
    from shakedown.assessment.every_limit import JointLimits
    from shakedown.bounds.bound_result import Bound
    from shakedown.bounds.uniqueness.friction_thresholds import Threshold
    from shakedown.bounds.uniqueness.wedging import Wedging
    from shakedown.joint.problem import Problem

EVERY, HERE, NEVER = Claim.EVERY_STATE.value, Claim.THIS_STATE.value, Claim.IMPOSSIBLE.value
CLOSED = "full contact"
CAUSES = {"friction": "friction", "constant": "constant load", "amplitude": "load amplitude"}
SLIGHT = 5e-4  # per cent: a smaller change is called none
SAME = 1e-3  # relative difference of two thresholds that is not shown
LONGEST_ENTRY = 24  # characters in a column
NEXT = {
    Said.SHAKEDOWN: ("verify {} -o report.html", "checks it"),
    Said.OPEN: ("simulate {}", "follows it"),
    Said.IMPOSSIBLE: ("nodes {}", "where it slips"),
}
GIVEN = ("solve {} --initial given", "")
MEANING = "scales the cyclic load; “shakes down”: slip ceases in time"


class Claimed(NamedTuple):
    """What is said of load factors below or above a limit.

    Attributes
    ----------
    name, load_factor, rounding
        The claim; NaN where the limit is not known.
    valid
        Where it holds.
    unknown
        Why the limit is not known, where it is not.
    """

    name: str
    load_factor: float
    rounding: Rounding
    valid: str
    unknown: str = ""


def solve_sheet(
    found: Assessment,
    file: str = "FILE",
    *,
    details: bool = False,
    follow: bool = False,
    digits: int = FEW_DIGITS,
) -> Sheet:
    """The answer for the nominal load, the claims, what decides them, the next step; with details all limits.

    Examples
    --------
    >>> import shakedown
    >>> sheet = solve_sheet(shakedown.assess(shakedown.example("two-node")))
    >>> print(*sheet.answer)
    At the nominal load (λ = 1) the joint cannot shake down in full contact.
    >>> for row in sheet.claims.rows:
    ...     print(*row, sep=" | ")
    proved from every state | 0.6573 | −34.27 % | full contact
    proved from this state | 0.7315 | −26.85 % | from zero slip
    impossible above | 0.7392 | −26.08 % | full contact
    """
    limits, problem = found.details, found.problem
    known = claims(found)
    if follow:
        known.insert(2, followed(limits))
    sections = limit_sections(found, digits, simulated=follow) if details else []
    return Sheet(
        headline(problem),
        [said_of_nominal_load(found)],
        claims_table(problem, known, digits),
        [*decided_by(found), *next_step(found, file), Fact("λ", MEANING)],
        sections,
    )


def quick_sheet(
    problem: Problem,
    energy: Bound,
    upper: Bound,
    *,
    details: bool = False,
    digits: int = FEW_DIGITS,
) -> Sheet:
    """What one linear and one cone program tell."""
    never = nan if upper.open_nodes else _above(upper)
    known = [
        Claimed(HERE, energy.load_factor, "down", start_of(energy, problem)),
        Claimed(NEVER, never, "up", CLOSED, _opened(upper.open_nodes)),
    ]
    facts = [*_zone(upper, problem), *_not_proved(energy)]
    facts += [Fact("reason", upper.status, note=upper.reason)] if upper.reason else []
    facts += [Fact("begins at", energy.least_load_factor, rounding="up")] * (energy.least_load_factor > 0)
    sections = [safe_slip_section(problem, upper)] if details else []
    return Sheet(headline(problem), [], claims_table(problem, known, digits), facts, sections)


def averaged_section(found: Assessment, radius: float, digits: int = FEW_DIGITS) -> Section:
    """The claims about a joint whose slips and reactions are averaged over a radius."""
    length = sized(radius, units_of(found.problem).length)
    return Section(
        f"Averaged over {length}: {count(found.problem.n, 'knot')}",
        tables=[claims_table(found.problem, claims(found), digits)],
        notes=[notes.NO_PROOF],
    )


def claims(found: Assessment) -> list[Claimed]:
    """The three claims about a joint; where nodes are open, what is not proved is unknown."""
    limits = found.details
    zone = _opened(limits.open_nodes)
    every, here, never = (
        nan if zone and not 0 < value < inf else value
        for value in (found.proved_from_every_state, found.proved_from_this_state, found.impossible_above)
    )
    if zone and isinf(found.proved_from_this_state):
        here = inf
    everywhere = f"{CLOSED}, transient over" if limits.universal.after_transient else CLOSED
    return [
        Claimed(EVERY, every, "down", everywhere, zone),
        Claimed(HERE, here, "down", start_of(limits.energy, found.problem), zone),
        Claimed(
            NEVER, never, "up", f"{CLOSED}, all corners passed" if found.problem.is_domain else CLOSED, zone
        ),
    ]


def _opened(nodes: tuple[int, ...]) -> str:
    return f"{count(len(nodes), 'node')} open" if nodes else ""


def start_of(energy: Bound, problem: Problem) -> str:
    """The state that is asked about."""
    closed = np.delete(energy.initial_slip, problem.layout.slips_of(energy.open_nodes))
    slip = "the given slip" if np.any(closed) else "zero slip"
    if energy.distance > 0:
        return f"from within {few(energy.distance)} of {slip} (energy norm)"
    return ", ".join(filter(None, [f"from {slip}", _opened(energy.open_nodes)]))


def followed(limits: JointLimits) -> Claimed:
    """What is proved once the cycles of this history are followed."""
    limit = limits.transient
    if not limit or limit.at_proved is None:
        why = limit.reason if isinstance(limit, Missing) else "no cycle followed is proved"
        return Claimed("proved by following", nan, "down", why)
    cycles = limit.followed["cycles"]
    return Claimed(
        "proved by following", limit.proved, "down", f"this λ only, after {count(cycles, 'cycle')}"
    )


def claims_table(problem: Problem, known: list[Claimed], digits: int = FEW_DIGITS) -> Table:
    """Claim, load factor, the user's loads, margin to the nominal load, where it holds: a row each."""
    texts = limits_as_text([(claim.load_factor, claim.rounding) for claim in known], digits)
    head = ["claim", "load factor", "in your loads", "margin", "valid for"]
    rows = []
    for claim, text in zip(known, texts, strict=True):
        if 0 < claim.load_factor < inf:
            loads = loads_at(problem, claim.load_factor, claim.rounding)
            apart = margin(claim.load_factor, claim.rounding)
            rows.append([claim.name, text, loads, apart, claim.valid])
        else:
            valid = "–" if isnan(claim.load_factor) else claim.valid
            rows.append([claim.name, _in_a_word(claim), "", "–", valid])
    if not any(row[2] for row in rows):
        return Table([*head[:2], *head[3:]], [[*row[:2], *row[3:]] for row in rows], (0, 3))
    return Table(head, rows, (0, 2, 4))


def _in_a_word(claim: Claimed) -> str:
    """A claim that has no positive finite load factor."""
    if isnan(claim.load_factor):
        return f"unknown ({claim.unknown})" if claim.unknown else "unknown"
    if isinf(claim.load_factor):
        return "no load factor" if claim.rounding == "up" else "any load factor"
    return "not proved" if claim.rounding == "down" else "0"


def loads_at(problem: Problem, load_factor: float, rounding: Rounding) -> str:
    """The varying loads at a load factor; a single one without its name, empty where none are known.

    Examples
    --------
    >>> import dataclasses, shakedown
    >>> loads = {"load_names": ["shear"], "load_mean": [20], "load_amplitude": [20], "load_units": ["N"]}
    >>> loads_at(dataclasses.replace(shakedown.example("two-node"), **loads), 1.2734, "down")
    '20 ± 25.46 N'
    """
    loads = varying_loads_in_words(problem, load_factor, rounding)
    varying = [load for load in problem.loads if load.amplitude != 0]
    return loads.removeprefix(f"{varying[0].name} ") if len(varying) == 1 else loads


def said_of_nominal_load(found: Assessment) -> str:
    """What becomes of the joint under the nominal load, as far as the limits say.

    Examples
    --------
    >>> import shakedown
    >>> said_of_nominal_load(shakedown.assess(shakedown.example("block-9")))
    'At the nominal load (λ = 1) the joint shakes down from zero slip: proved.'
    """
    here = "At the nominal load (λ = 1)"
    if found.said_as_given == Said.SHAKEDOWN and found.proved_from_every_state > 1:
        return f"{here} the joint shakes down from every state: proved."
    if found.said_as_given == Said.SHAKEDOWN:
        start = start_of(found.details.energy, found.problem)
        return f"{here} the joint shakes down {start}: proved."
    if found.said_as_given == Said.IMPOSSIBLE:
        return f"{here} the joint cannot shake down in full contact."
    if found.details.open_nodes:
        return f"{here} it is not decided which nodes open."
    return f"{here} it is not decided whether the joint shakes down."


def decided_by(found: Assessment) -> Iterator[Fact]:
    """The node that a limit depends on most, or why there is none; what less is proved; the mesh."""
    limits, problem = found.details, found.problem
    upper, energy = limits.upper, limits.energy
    if is_constant(problem):
        yield Fact("loading", "constant", note=notes.CONSTANT)
    elif upper.open_nodes:
        yield from _zone(upper, problem)
    elif upper.status in (Status.UNBOUNDED, Status.UNDECIDED, Status.INFEASIBLE):
        yield Fact("no limit" if upper.status == Status.UNBOUNDED else "no safe slip", upper.reason)
    elif not limits.mesh.warning:
        yield from _deciding_nodes(found)
    if found.said_as_given == Said.OPEN:
        yield from _not_proved(energy)
    slip = limits.first_slip
    if 0.0 < slip.load_factor < inf and not upper.open_nodes:
        where = f"{node_in_words(problem, slip.node)}; below it no node slips"
        yield Fact("first slip", slip.load_factor, rounding="down", note=where)
    if found.proved_from_this_state < found.proved_from_every_state:
        yield from _why_less(found)
    if limits.mesh.warning:
        yield Fact("mesh", limits.mesh.warning)


def _not_proved(energy: Bound) -> list[Fact]:
    """Why nothing is proved of this state."""
    none = energy.status in (Status.INFEASIBLE, Status.UNDECIDED)
    return [Fact("no proof as", energy.reason)] if none else []


def _deciding_nodes(found: Assessment) -> Iterator[Fact]:
    """The node with the largest influence on the proved limit, or on λ_max where that excludes λ = 1.

    Where neither has derivatives, the nodes that reach their friction limits.
    """
    limits, problem = found.details, found.problem
    upper_first = found.said_as_given == Said.IMPOSSIBLE or limits.from_state.kind != "energy"
    names = ["upper", "energy"] if upper_first else ["energy", "upper"]
    if known := next(filter(None, (sensitivity(limits, name) for name in names)), None):
        yield known
        return
    nodes = tuple(sorted({node for node, _ in limits.upper.active}))
    if nodes:
        named = "all nodes" if 1 < len(nodes) == problem.n else open_in_words(nodes, problem)
        yield Fact("decided by", named, note="at the friction limit at λ_max")


def sensitivity(limits: JointLimits, name: str) -> Fact | None:
    """The node on which one limit depends most, and how; None where there is no derivative."""
    found = present(limits.sensitivities.get(name))
    if found is None or not found.ranked().size:
        return None
    node = int(found.ranked()[0])
    changes = {cause: float(getattr(found, kind).elasticity[node, 1]) for kind, cause in CAUSES.items()}
    known = {cause: by for cause, by in changes.items() if not isnan(by)}
    effects = [f"{cause} {signed(by, 2) if abs(by) >= SLIGHT else '0 %'}" for cause, by in known.items()]
    note = f"1 % more there changes “{BOUNDS[name].claim}” by: {', '.join(effects)}"
    return Fact("decided by", node_in_words(limits.problem, node), note=note)


def _zone(upper: Bound, problem: Problem) -> Iterator[Fact]:
    """Which nodes are open, and up to where that zone has a safe slip."""
    if not upper.open_nodes:
        return
    yield Fact("open nodes", open_in_words(upper.open_nodes, problem), note="all others closed")
    if upper.least_load_factor > 0:
        yield Fact(
            "safe from", upper.least_load_factor, rounding="up", note="least load factor with a safe slip"
        )
    if upper.status == Status.INFEASIBLE:
        yield Fact("safe slip", "none", note="not even under the mean load")
        return
    at = (
        "at every load factor"
        if upper.status == Status.UNBOUNDED
        else number(upper.load_factor, rounding="down")
    )
    yield Fact("at rest up to", at, note="with exactly these nodes open throughout")


def _why_less(found: Assessment) -> Iterator[Fact]:
    """Why less is proved of the state that is asked about than of every state."""
    limits = found.details
    if limits.open_nodes:
        return
    slip = limits.energy.initial_slip
    state = "the given slip" if slip.any() else "zero slip"
    if limits.universal.after_transient:
        yield Fact("this state", f"{state} is one before the transient load steps")
    elif limits.distance > 0:
        yield Fact("this state", f"not every slip near {state} is within the friction limits")
    else:
        admitted = admitted_up_to(limits.problem, slip, limits.tolerances)
        node, event = first_to_leave(limits.problem, slip, admitted)
        where = node_in_words(limits.problem, node)
        above = f"above λ = {number(admitted, rounding='down')} " if admitted > 0 else ""
        yield Fact(
            "this state", f"{above}the first load step makes {where} {event}, so {state} is not one of all"
        )


def is_constant(problem: Problem) -> bool:
    """Whether the loading does not change over the period, so that the load factor multiplies nothing."""
    loop = loading(problem)
    return not (loop.q1.any() or loop.p1.any())


def next_step(found: Assessment, file: str) -> list[Fact]:
    """The one thing to do next: a command on the file, and its purpose."""
    from_zero = not np.nan_to_num(found.details.energy.initial_slip).any()
    given = found.said_as_given == Said.OPEN and found.problem.initial_slip is not None and from_zero
    command, why = GIVEN if given else NEXT[found.said_as_given]
    return [Fact("next", f"shakedown-bounds {command.format(file)}", note=f"({why})" * bool(why))]


def limit_sections(found: Assessment, digits: int = FEW_DIGITS, *, simulated: bool = False) -> list[Section]:
    """Every limit with what it ends at; thresholds and loads; the safe slip node by node."""
    limits, problem = found.details, found.problem
    facts = [load_path(problem), *_reservations(limits), *_through_transient(limits)]
    facts += [
        *relative_to(problem, limits.pinned),
        *friction_facts(limits),
    ]
    said = [notes.NO_SIDES] if limits.absent else []
    if problem.initial_slip is not None and not np.nan_to_num(limits.energy.initial_slip).any():
        said.append(notes.GIVEN_STATES)
    return [
        Section("Limits of the load factor", tables=[limits_table(limits, digits, simulated=simulated)]),
        Section("", facts=facts, notes=said),
        safe_slip_section(problem, limits.upper, limits),
    ]


def _known(limits: JointLimits, *, simulated: bool = False) -> list[Bound]:
    """Every kind of limit that the joint has; the simulated ones only where they are asked for."""
    kinds = [kind for kind in BOUNDS.values() if simulated or kind.claim != Claim.FOLLOWED]
    return [bound for kind in kinds if (bound := getattr(limits, kind.name))]


def _reservations(limits: JointLimits) -> Iterator[Fact]:
    """Why a limit is not certified or not fully accurate, and what evidence is missing."""
    for bound in _known(limits):
        if bound.uncertified:
            yield Fact(bound.symbol, "not certified", note=bound.uncertified)
        for missing in getattr(bound, "missing", ()):
            yield Fact(bound.symbol, "no evidence", note=missing)
        if bound.reduced_accuracy:
            yield Fact(bound.symbol, "to 1e-7", note="limited by floating-point precision")


def _through_transient(limits: JointLimits) -> list[Fact]:
    """Up to where a safe slip exists that the transient load steps do not move either."""
    before = limits.through_transient
    if before is None:
        return []
    none = before.status == Status.INFEASIBLE
    at = "none" if none else f"up to λ = {number(before.load_factor, rounding='down')}"
    return [Fact("safe in the transient", at, note="slip that the transient load steps do not move either")]


def limits_table(limits: JointLimits, digits: int = FEW_DIGITS, *, simulated: bool) -> Table:
    """Every kind of limit: symbol, what it is, load factor, what limits it, how it is certified."""
    known = _known(limits, simulated=simulated)
    texts = limits_as_text([(certain(bound), rounding_of(bound)) for bound in known], digits)
    rows = [
        [bound.symbol, _title(bound), text, ends_at(bound, limits.problem), _certified(bound)]
        for bound, text in zip(known, texts, strict=True)
    ]
    for name, onset in (("first slip", limits.first_slip), ("first opening", limits.first_opening)):
        where = onset.reason or (node_in_words(limits.problem, onset.node) if onset.node >= 0 else "")
        alone = ", if no node slipped" if name == "first opening" and onset.node >= 0 else ""
        rows.append(["", name, number(onset.load_factor, digits, "down"), f"{where}{alone}", "–"])
    least = limits.upper.least_load_factor
    if least > 0:
        rows.append(["λ_lo", "safe slips from", number(least, digits, "up"), "", "–"])
    return Table(["", "limit", "load factor", "limited by", "certified"], rows, (0, 1, 3))


def _excludes(bound: Bound) -> bool:
    """Whether shakedown is impossible above a limit; that of a zone says nothing of other zones."""
    return BOUNDS[bound.kind].claim == Claim.IMPOSSIBLE and not bound.open_nodes


def rounding_of(bound: Bound) -> Rounding:
    """To which side a limit is rounded: up only where it excludes what lies above."""
    return "up" if _excludes(bound) else "down"


def certain(bound: Bound) -> float:
    """A limit; one that was bisected in as many digits as are certain, and as say what is proved there."""
    found = bound.load_factor
    if not hasattr(bound, "scanned") or bound.proved >= found or isnan(found):
        return found
    digits = range(certain_digits(found, bound.high), DIGITS + 1)
    texts = (float(down(found, each)) for each in digits)
    return next((value for value in texts if not bound.proved > value), found)


def _title(bound: Bound) -> str:
    kind = BOUNDS[bound.kind]
    return "safe slip of the zone" if kind.claim == Claim.IMPOSSIBLE and bound.open_nodes else kind.title


def ends_at(bound: Bound, problem: Problem) -> str:
    """What a limit ends at, with its node and the nodes that are open, and whether it is a theorem."""
    node, said = getattr(bound, "node", -1), bound.remark
    where = node_in_words(problem, node) if node >= 0 and f"node {node}" not in said else ""
    opened = f"{open_in_words(bound.open_nodes)} open" if bound.open_nodes else ""
    theorem = str(getattr(bound, "guarantee", "")).replace("evidence", "no proof")
    return "; ".join(filter(None, [theorem, said, where, opened]))


def _certified(bound: Bound) -> str:
    """How close a certificate encloses a limit; a dash where there is none."""
    if bound.certified is None:
        return "–"
    ends = bound.certified if isinstance(bound.certified, tuple) else (bound.certified, bound.load_factor)
    low, high = ends
    size = max(abs(low), abs(high))
    return "exact" if size in (0.0, inf) or low == high else f"to {max(high - low, 0.0) / size:.0e}"


def _above(upper: Bound) -> float:
    if upper.status == Status.INFEASIBLE:
        return 0.0
    return upper.load_factor if upper.certified is None else max(upper.load_factor, upper.certified[1])


def friction_facts(limits: JointLimits) -> list[Fact]:
    """The friction of the joint beside the thresholds of uniqueness and wedging."""
    found = present(limits.friction)
    if found is None:
        return []
    friction = 1.0 if found.factor else float(limits.problem.f.max())
    closed, opened = found.uniqueness_in_contact, found.uniqueness
    named: dict[str, tuple[Threshold | Wedging, str]] = {"unique in contact": (closed, notes.NOT_UNIQUE)}
    if opened is not None and (opened.low, opened.high) != (closed.low, closed.high):
        named["unique, nodes open"] = (opened, notes.NOT_UNIQUE)
    named["no wedging"] = (found.wedging, notes.WEDGING)
    facts = []
    for name, (each, otherwise) in named.items():
        until = "any friction" if isinf(each.low) else f"below {number(each.low, rounding='down')}"
        wide = each.high > (1 + SAME) * each.low
        until += f", not above {number(each.high, rounding='up')}" if wide else ""
        state = "holds" if friction < each.low else "lost" if friction >= each.high else "open"
        own = f"{'factor 1' if found.factor else f'f = {friction:g}'}: {state}"
        facts.append(Fact(name, until, note=own if state == "holds" else f"{own}. {otherwise}"))
    return facts


def safe_slip_section(problem: Problem, upper: Bound, limits: JointLimits | None = None) -> Section:
    """Node by node: safe slip at λ_max, critical slip at λ_1, limits reached, friction threshold."""
    lower = None if limits is None else present(limits.lower)
    friction = None if limits is None else present(limits.friction)
    slips = by_direction(problem, "safe slip", upper.slip)
    slips |= {} if lower is None else {"critical slip": lower.slip.tolist()}
    unit = units_of(problem).length
    columns = node_column(problem)
    columns |= {with_unit(name, unit): [number(x, DIGITS) for x in slip] for name, slip in slips.items()}
    columns["reached at λ_max"] = [_reached(problem, upper, node) or "–" for node in range(problem.n)]
    said = [notes.DIRECTIONS, notes.REACHED] if problem.directions > 1 else []
    said += [notes.ZONE_SLIP] * bool(upper.open_nodes)
    if friction is not None:
        columns["f threshold"] = [number(each, 6) for each in friction.single_node]
        said.append(notes.F_THRESHOLD)
    return Section("Safe slip", tables=[Table.of(columns)], notes=said)


def _reached(problem: Problem, upper: Bound, node: int) -> str:
    """The limits that a node reaches at λ_max: sides, or with two directions load steps."""
    reached = [where for at, where in upper.active if at == node]
    if node in upper.open_nodes:
        return "open; gap closes" if reached else "open"
    if problem.directions == 1:
        return "+".join(SIDE_NAMES[side] for side in reached)
    said = ranges(sorted(reached))
    return said if len(said) <= LONGEST_ENTRY else f"{len(reached)} load steps"
