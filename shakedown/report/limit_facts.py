"""Up to which load factor a joint shakes down: three claims, what decides them, every limit."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isinf, isnan, nan
from typing import TYPE_CHECKING, Any

import numpy as np

from shakedown.bounds.registry import BOUNDS, Claim
from shakedown.ground.errors import Missing, present
from shakedown.ground.shown_values import (
    DIGITS,
    FEW_DIGITS,
    certain_digits,
    count,
    down,
    few,
    plain,
    sized,
    with_unit,
)
from shakedown.ground.status import LimitsVerdict, Status
from shakedown.joint.constraints import SIDE_NAMES, loading
from shakedown.joint.rigid_slips import can_creep
from shakedown.joint.units import loads_in_words, units_of
from shakedown.report import data_facts, facts
from shakedown.report.facts import Fact, Rounding, Section, Sheet, Table, notes, number

if TYPE_CHECKING:
    from shakedown.assessment.assess import Assessment
    from shakedown.assessment.every_limit import JointLimits
    from shakedown.bounds.bound_result import Bound
    from shakedown.bounds.friction_thresholds import Threshold, Wedging
    from shakedown.joint.problem import Problem

SAME = 1e-3  # relative difference of two thresholds that is not shown
NEXT = {
    LimitsVerdict.SHAKEDOWN: ("verify {} -o report.html", "(checks it)"),
    LimitsVerdict.OPEN: ("simulate {}", "(follows it)"),
    LimitsVerdict.IMPOSSIBLE: ("nodes {}", "(where it slips)"),
}


def solve_sheet(
    found: Assessment,
    file: str = "FILE",
    *,
    details: bool = False,
    follow: bool = False,
    averaged: tuple[Assessment, float] | None = None,
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
    proved from every state | 0.6573 | −34.27 % | full contact (λ_U)
    proved from this state | 0.7315 | −26.85 % | zero slip (λ_S)
    impossible above | 0.7392 | −26.08 % | full contact (λ_max)
    """
    sections = limit_sections(found, digits, simulated=follow) if details else []
    sections += [averaged_section(*averaged, digits)] if averaged else []
    known = claims(found)
    about = [*decided_by(found)]
    about += [followed(found.details)] if follow else []
    about += without_creep(found.details) if follow and details else []
    about += next_step(found, file)
    table = claims_table(found.problem, known, digits)
    head = data_facts.headline(found.problem, limits=True)
    return Sheet(head, [nominal_load_sentence(found)], table, about, sections)


def averaged_section(found: Assessment, radius: float, digits: int = FEW_DIGITS) -> Section:
    """The claims about a joint whose slips and reactions are averaged over a radius."""
    title = f"Averaged over {sized(radius, units_of(found.problem).length)}: {count(found.problem.n, 'knot')}"
    return Section(title, (), [claims_table(found.problem, claims(found), digits)], [notes.no_proof])


def claims(found: Assessment) -> list[Fact]:
    """What is claimed of a joint: load factors, or why there is none, for which states, by which limit.

    Where nodes are open, what is not proved is unknown.
    """
    limits = found.details
    zone, here = _opened(limits.open_nodes), limits.from_state
    start = state_in_words(limits.energy, found.problem)
    every, upper = limits.universal, limits.upper
    proved = every if found.proved_from_this_state > here.load_factor else here
    everywhere = "full contact" + ", transient over" * bool(every.after_transient)
    corners = "full contact" + ", all corners passed" * found.problem.is_domain
    return [
        _claim(Claim.EVERY_STATE, found.proved_from_every_state, every, everywhere, zone),
        _claim(Claim.THIS_STATE, found.proved_from_this_state, proved, start, zone),
        _claim(Claim.IMPOSSIBLE, found.impossible_above, upper, corners, zone),
    ]


def nothing_is_known(found: Assessment) -> bool:
    """Whether every claim is unknown."""
    return all(claim.note == "–" for claim in claims(found))


def _claim(claim: Claim, load_factor: float, bound: Bound, about: str, zone: str) -> Fact:
    """A claim: a load factor with the symbol of its limit, or in words why there is none."""
    rounding: Rounding = "up" if claim == Claim.IMPOSSIBLE else "down"
    safe_at_all = isinf(load_factor) and claim == Claim.THIS_STATE
    if 0 < load_factor < inf:
        return Fact(claim, load_factor, bound.symbol, rounding, about)
    if isnan(load_factor) or (zone and not safe_at_all):
        return Fact(claim, f"unknown ({zone})" if zone else "unknown", note="–")
    if isinf(load_factor):
        return Fact(claim, f"{'no' if rounding == 'up' else 'any'} load factor", note=about)
    return Fact(claim, "0" if rounding == "up" else "not proved", note=about)


def followed(limits: JointLimits) -> Fact:
    """The one load factor that is proved by following the cycles of this history: it is no limit."""
    limit = limits.transient
    if not limit or limit.at_proved is None:
        why = limit.reason if isinstance(limit, Missing) else "no cycle followed is proved"
        return Fact("followed", "no proof", note=why)
    cycles = limit.followed["cycles"]
    when = f"after {count(cycles, 'cycle')}" if cycles else "from the start on"
    at = f"λ = {number(limit.proved, rounding='down')}"
    return Fact("followed", at, note=f"proved for this λ only, {when}")


def _opened(nodes: tuple[int, ...]) -> str:
    return f"{count(len(nodes), 'node')} open" if nodes else ""


def state_in_words(energy: Bound, problem: Problem) -> str:
    """The state that is asked about, which texts call this state."""
    closed = np.delete(energy.initial_slip, problem.layout.slips_of(energy.open_nodes))
    slip = "the given slip" if np.any(closed) else "zero slip"
    if energy.distance > 0:
        return f"within {few(energy.distance)} of {slip} (energy norm)"
    return ", ".join(filter(None, [slip, _opened(energy.open_nodes)]))


def claims_table(problem: Problem, known: list[Fact], digits: int = FEW_DIGITS) -> Table:
    """Claim, load factor, the user's loads, margin to the nominal load, where it holds: a row each."""
    sizes = [(claim.value if isinstance(claim.value, float) else nan, claim.rounding) for claim in known]
    texts = facts.limits_as_text(sizes, digits)
    claimed = "shakedown (slip ceases)"
    columns = {
        claimed: [claim.label for claim in known],
        "load factor": [
            claim.value if isinstance(claim.value, str) else text
            for claim, text in zip(known, texts, strict=True)
        ],
        "in your loads": ["" if isnan(size) else loads_at(problem, size, way) for size, way in sizes],
        "margin": [facts.margin(*each) for each in sizes],
        "valid for": [f"{each.note} ({each.unit})" if each.unit else each.note for each in known],
    }
    if not any(columns["in your loads"]):
        del columns["in your loads"]
    return Table.of(columns, (claimed, "in your loads", "valid for"))


def loads_at(problem: Problem, load_factor: float, rounding: Rounding) -> str:
    """The varying loads at a load factor; a single one without its name, empty where none are known.

    Examples
    --------
    >>> import dataclasses, shakedown
    >>> loads = {"load_names": ["shear"], "load_mean": [20], "load_amplitude": [20], "load_units": ["N"]}
    >>> loads_at(dataclasses.replace(shakedown.example("two-node"), **loads), 1.2734, "down")
    '20 ± 25.46 N'
    """
    loads = loads_in_words(problem, load_factor, rounding, constant=False)
    varying = [load for load in problem.loads if load.amplitude != 0]
    return loads.removeprefix(f"{varying[0].name} ") if len(varying) == 1 else loads


def nominal_load_sentence(found: Assessment) -> str:
    """What becomes of the joint under the nominal load, as far as the limits say.

    Examples
    --------
    >>> import shakedown
    >>> nominal_load_sentence(shakedown.assess(shakedown.example("block-9")))
    'At the nominal load (λ = 1) the joint shakes down from zero slip: proved.'
    """
    here, limits = "At the nominal load (λ = 1)", found.details
    if found.verdict == LimitsVerdict.SHAKEDOWN:
        every = found.proved_from_every_state > 1
        start = "every state" if every else state_in_words(limits.energy, found.problem)
        return f"{here} the joint shakes down from {start}: proved."
    if found.verdict == LimitsVerdict.IMPOSSIBLE:
        return f"{here} the joint cannot shake down in full contact."
    what = "which nodes open" if limits.open_nodes else "whether the joint shakes down"
    return f"{here} it is not decided {what}."


def decided_by(found: Assessment) -> Iterator[Fact]:
    """The node that a limit depends on most, or why there is none; what less is proved; the mesh."""
    limits, problem = found.details, found.problem
    upper, slip = limits.upper, limits.first_slip
    if not (loading(problem).q1.any() or loading(problem).p1.any()):  # the load factor multiplies nothing
        yield Fact("loading", "constant", note=notes.constant)
    elif upper.open_nodes:
        yield from _zone(upper, problem)
    elif upper.status != Status.OPTIMAL:
        yield Fact("no limit" if upper.status == Status.UNBOUNDED else "no safe slip", upper.reason)
    elif not limits.mesh.warning:
        yield from _deciding_node(found)
    if found.verdict == LimitsVerdict.OPEN and limits.energy.status in (Status.INFEASIBLE, Status.UNDECIDED):
        yield Fact("no proof as", limits.energy.reason)
    if problem.law.frictionless.size:
        yield Fact("first slip", 0.0, rounding="down", note="without friction")
    elif 0.0 < slip.load_factor < inf and not upper.open_nodes:
        note = f"{data_facts.node_in_words(problem, slip.node)}, from this state"
        yield Fact("first slip", slip.load_factor, rounding="down", note=note)
    if found.proved_from_this_state < found.proved_from_every_state and not limits.open_nodes:
        yield Fact("this state", "moves at once", note=notes.moves_at_once)
    if limits.mesh.warning:
        yield Fact("mesh", limits.mesh.warning)


def _deciding_node(found: Assessment) -> Iterator[Fact]:
    """The node with the largest influence on the proved limit, or on λ_max where that excludes λ = 1.

    Where neither has derivatives, the nodes that reach their friction limits.
    """
    limits, problem = found.details, found.problem
    proof_first = found.verdict != LimitsVerdict.IMPOSSIBLE and limits.from_state.kind in limits.sensitivities
    for name in sorted(limits.sensitivities, reverse=not proof_first):
        known = present(limits.sensitivities[name])
        if known is None or not known.ranked().size:
            continue
        node = int(known.ranked()[0])
        causes = {"friction": "friction", "constant": "constant load", "amplitude": "load amplitude"}
        changes = ((cause, float(getattr(known, kind).elasticity[node])) for kind, cause in causes.items())
        effects = [
            f"{cause} {facts.signed(by, 2) if abs(by) >= 5e-4 else '0 %'}"  # per cent: less is called none
            for cause, by in changes
            if not isnan(by)
        ]
        note = f"1 % more there changes “{BOUNDS[name].claim}” by: {', '.join(effects)}"
        yield Fact("decided by", data_facts.node_in_words(problem, node), note=note)
        return
    nodes = tuple(sorted({node for node, _ in limits.upper.active}))
    if nodes:
        named = "all nodes" if 1 < len(nodes) == problem.n else data_facts.open_in_words(nodes, problem)
        yield Fact("decided by", named, note="at the friction limit at λ_max")


def _zone(upper: Bound, problem: Problem) -> Iterator[Fact]:
    """Which nodes are open, and up to where that zone has a safe slip."""
    if not upper.open_nodes:
        return
    yield Fact(
        "open nodes", data_facts.open_in_words(upper.open_nodes, problem), note="assumed; all others closed"
    )
    least = upper.least_load_factor
    if least > 0:
        yield Fact("safe from", least, rounding="up", note="least load factor with a safe slip")
    if upper.status == Status.INFEASIBLE:
        yield Fact("safe slip", "none", note="not even under the mean load")
        return
    unbounded = upper.status == Status.UNBOUNDED
    at = "at every load factor" if unbounded else number(upper.load_factor, rounding="down")
    yield Fact("safe slip up to", at, note="with exactly these nodes open throughout")


def next_step(found: Assessment, file: str) -> list[Fact]:
    """The one thing to do next: a command on the file, and its purpose."""
    from_zero = not np.nan_to_num(found.details.energy.initial_slip).any()
    given = found.verdict == LimitsVerdict.OPEN and found.problem.initial_slip is not None and from_zero
    command, why = ("solve {} --initial given", "") if given else NEXT[found.verdict]
    return [Fact("next", f"shakedown-bounds {command.format(file)}", note=why)]


def limit_sections(found: Assessment, digits: int = FEW_DIGITS, *, simulated: bool = False) -> list[Section]:
    """Every limit with what it ends at; thresholds and loads; the safe slip node by node."""
    limits, problem = found.details, found.problem
    about = [data_facts.load_path(problem), *_reservations(limits), *_through_transient(limits)]
    about += [*data_facts.relative_to(problem, limits.pinned), *friction_facts(limits)]
    texts = [notes.computed] + [notes.no_sides] * bool(limits.absent)
    if problem.initial_slip is not None and not np.nan_to_num(limits.energy.initial_slip).any():
        texts.append(notes.given_states)
    return [
        Section("Limits of the load factor", (), [limits_table(limits, digits, simulated=simulated)]),
        Section("", about, (), texts),
        safe_slip_section(limits),
    ]


def _known(limits: JointLimits, *, simulated: bool = False) -> list[Bound]:
    """Every kind of limit that the joint has; the simulated ones only where they are asked for."""
    kinds = [kind for kind in BOUNDS.values() if simulated or not kind.simulated]
    kinds = [kind for kind in kinds if kind.claim != Claim.CREEP or can_creep(limits.problem)]
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


def without_creep(limits: JointLimits) -> Iterator[Fact]:
    """The load factors at which it does not come to rest, and creep is proved to be impossible."""
    creep, upper = present(limits.creep), limits.upper.load_factor
    if creep and upper < creep.proved < inf:
        ends = number(upper, rounding="up"), number(creep.proved, rounding="down")
        yield Fact("slips without creep", f"λ = {ends[0]} to {ends[1]}", note=notes.without_creep)


def limits_table(limits: JointLimits, digits: int = FEW_DIGITS, *, simulated: bool) -> Table:
    """Every kind of limit: symbol, what it is, load factor, what limits it, how exactly it is computed."""
    known = _known(limits, simulated=simulated)
    texts = facts.limits_as_text([(certain(bound), rounding_of(bound)) for bound in known], digits)
    rows = [
        [bound.symbol, _title(bound), text, _limited_by(bound, limits.problem), _computed(bound)]
        for bound, text in zip(known, texts, strict=True)
    ]
    others = ", of the nodes with friction" * bool(limits.problem.law.frictionless.size)
    for name, onset in (("first slip", limits.first_slip), ("first opening", limits.first_opening)):
        where = onset.reason or (
            data_facts.node_in_words(limits.problem, onset.node) if onset.node >= 0 else ""
        )
        alone = (", if no node slipped" if name == "first opening" else others) * (onset.node >= 0)
        rows.append(["", name, number(onset.load_factor, digits, "down"), f"{where}{alone}", IN_FLOATS])
    least = limits.upper.least_load_factor
    if least > 0:
        rows.append(["λ_lo", "safe slips from", number(least, digits, "up"), "", IN_FLOATS])
    return Table(["", "limit", "load factor", "limited by", "computed"], rows, (0, 1, 3))


IN_FLOATS = "in floating point"


def rounding_of(bound: Bound) -> Rounding:
    """To which side a limit is rounded: up where it excludes what lies above; that of a zone does not."""
    above = BOUNDS[bound.kind].claim in (Claim.IMPOSSIBLE, Claim.CREEP)
    return "up" if above and not bound.open_nodes else "down"


def certain(bound: Bound) -> float:
    """A limit; one that was bisected in as many digits as are certain, and as say what is proved there."""
    found = nan if bound.status == Status.UNDECIDED and isinf(bound.load_factor) else bound.load_factor
    if not hasattr(bound, "scanned") or bound.proved >= found or isnan(found):
        return found
    digits = range(certain_digits(found, bound.high), DIGITS + 1)
    rounded = (float(down(found, each)) for each in digits)
    return next((value for value in rounded if not bound.proved > value), found)


def _title(bound: Bound) -> str:
    kind = BOUNDS[bound.kind]
    return "safe slip of the zone" if kind.claim == Claim.IMPOSSIBLE and bound.open_nodes else kind.title


def _limited_by(bound: Bound, problem: Problem) -> str:
    """What a limit ends at, with its node and the nodes that are open, and whether it is a theorem."""
    node, remark = getattr(bound, "node", -1), bound.remark
    where = data_facts.node_in_words(problem, node) if node >= 0 and f"node {node}" not in remark else ""
    opened = f"{data_facts.open_in_words(bound.open_nodes)} open" if bound.open_nodes else ""
    theorem = str(getattr(bound, "guarantee", "")).replace("evidence", "no proof")
    return "; ".join(filter(None, [theorem, remark, where, opened]))


def _computed(bound: Bound) -> str:
    """How close a certificate encloses a limit, or that none does."""
    if isnan(bound.load_factor):
        return "–"
    if bound.certified is None:
        return "simulated" if BOUNDS[bound.kind].simulated else IN_FLOATS
    ends = bound.certified if isinstance(bound.certified, tuple) else (bound.certified, bound.load_factor)
    low, high = ends
    size = max(abs(low), abs(high))
    return "exactly" if size in (0.0, inf) or low == high else f"to {max(high - low, 0.0) / size:.0e}"


def friction_facts(limits: JointLimits) -> list[Fact]:
    """Whether the friction lies below the thresholds of uniqueness and wedging, and where these are."""
    found = present(limits.friction)
    if found is None:
        return []
    own = 1.0 if found.factor else float(limits.problem.f.max())
    what = "factors on f" if found.factor else "f"
    closed, opened = found.uniqueness_in_contact, found.uniqueness
    named: list[tuple[str, Threshold | Wedging, str]] = [("unique motion, closed", closed, notes.not_unique)]
    if opened is not None and (opened.low, opened.high) != (closed.low, closed.high):
        named.append(("unique motion, nodes open", opened, notes.not_unique))
    named.append(("no wedging", found.wedging, notes.wedging))
    known = []
    for name, each, otherwise in named:
        state = "yes" if own < each.low else "no" if own >= each.high else "not decided"
        ends = [f"for {what} below {number(each.low, rounding='down')}"] if each.low > 0 else []
        if each.high > (1 + SAME) * each.low:
            ends.append(f"lost from {what} = {number(each.high, rounding='up')} on")
        holds = "with any friction" if isinf(each.low) else ", ".join(ends)
        here = f"{holds}; here {own:g}."
        known.append(Fact(name, state, note=here if state == "yes" else f"{here} {otherwise}"))
    return known


def safe_slip_section(limits: JointLimits) -> Section:
    """Node by node: safe slip at λ_max, critical slip at λ_1, limits reached, friction threshold."""
    problem, upper = limits.problem, limits.upper
    lower, friction = present(limits.lower), present(limits.friction)
    slips = data_facts.by_direction(problem, "safe slip", upper.slip)
    slips |= {} if lower is None else {"critical slip": lower.slip.tolist()}
    unit = units_of(problem).length
    columns = data_facts.node_column(problem)
    columns |= {with_unit(name, unit): [number(x, DIGITS) for x in slip] for name, slip in slips.items()}
    columns["reached at λ_max"] = [_reached(problem, upper, node) or "–" for node in range(problem.n)]
    texts = [notes.directions, notes.reached] if problem.directions > 1 else []
    texts += [notes.zone_slip] * bool(upper.open_nodes)
    if friction is not None:
        columns["f threshold"] = [number(each, 6) for each in friction.single_node]
        texts.append(notes.f_threshold)
    return Section("Safe slip", (), [Table.of(columns)], texts)


def _reached(problem: Problem, upper: Bound, node: int) -> str:
    """The limits that a node reaches at λ_max: sides, or with two directions load steps."""
    reached = [where for at, where in upper.active if at == node]
    if node in upper.open_nodes:
        return "open; gap closes" if reached else "open"
    if problem.directions == 1:
        return "+".join(SIDE_NAMES[side] for side in reached)
    listed = data_facts.ranges(sorted(reached))
    return listed if len(listed) <= data_facts.LONGEST_ENTRY else f"{len(reached)} load steps"


def assessment_document(
    found: Assessment, averaged: tuple[Assessment, float] | None = None, *, follow: bool = False
) -> dict[str, Any]:
    """What ``shakedown-bounds solve --json`` writes; also of slips and reactions averaged over a radius."""
    limits = found.details
    limit = present(limits.transient) if follow else None
    absent = limits.absent | {"friction": limits.friction, "sensitivities": limits.sensitivities["upper"]}
    document: dict[str, Any] = {
        "problem": found.problem,
        "pinned": limits.pinned,
        "assessment": found,
        **limits.to_dict(),
        "mesh": limits.mesh,
        "friction": limits.friction,
        "sensitivities": {name: present(each) for name, each in limits.sensitivities.items()},
    }
    if follow:
        document["followed"] = None if limit is None else limit.followed
        document["creep"] = present(limits.creep)
    if missing := {word: each.reason for word, each in absent.items() if isinstance(each, Missing)}:
        document["missing"] = missing
    if averaged:
        one, radius = averaged
        document["averaged"] = {"radius": radius, "nodes": one.problem.n} | one.to_dict()
    return plain(document)
