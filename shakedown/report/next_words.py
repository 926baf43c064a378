"""After the three numbers: the margin of the amplitude, what determines the limit, and the next step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.assessment.three_numbers import admitted_up_to, first_to_leave
from shakedown.ground.errors import Missing
from shakedown.ground.shown_values import down, up
from shakedown.ground.status import Said, Status
from shakedown.report.assessment_words import percent, start_in_words
from shakedown.report.bound_words import is_constant
from shakedown.report.limit_words import limited_in_words
from shakedown.report.node_words import node_in_words, open_in_words
from shakedown.report.zone_words import without_safe_slip_in_words, zone_in_words

if TYPE_CHECKING:
    from shakedown.assessment.assess import Assessment

NEXT = {
    Said.SHAKEDOWN: ("verify {} -o report.html", "by simulation"),
    Said.OPEN: ("simulate {}", "follows the nominal load"),
    Said.IMPOSSIBLE: ("nodes {}", "where and how far it slips"),
}
GIVEN = ("solve {} --initial given", "the slip in the file")


def margin_in_words(found: Assessment, simulated: float = np.nan) -> str:
    """By how much the amplitude may grow or must shrink; with λ_T also by simulation.

    Examples
    --------
    >>> import shakedown
    >>> print(margin_in_words(shakedown.assess(shakedown.example("two-node"))))
    With the varying part of the load 34.27 % smaller it is proved to shake down from every state, 26.85 %
    starting without slip.
    """
    every, here = np.nan_to_num([found.proved_from_every_state, found.proved_from_this_state], posinf=np.inf)
    proved = max(every, here)
    if found.details.open_nodes:
        return ""
    less = _why_less(found, every)
    if proved > 1:
        return _larger(found, every, here, simulated) + less
    known = _smaller(found, every, here)
    if 0 < simulated < 1 and percent(simulated, up) != percent(proved, up):
        shakes_down = "it does so" if known else "it shakes down"
        known.append(f"{percent(simulated, up)} smaller {shakes_down} in the simulation")
    return f"With the varying part of the load {', '.join(known)}.{less}" if known else ""


def _why_less(found: Assessment, every: float) -> str:
    """Why less is proved of the state that is asked about than of every state; empty where it is not so."""
    limits = found.details
    if not found.proved_from_this_state < every:
        return ""
    slip = limits.energy.initial_slip
    state = "the given slip" if slip.any() else "zero slip"
    if limits.universal.after_transient:
        return f" Every state means each that the transient load steps may leave; {state} is one before them."
    if limits.distance > 0:
        return f" Every state means each within its friction limits; not every slip near {state} is."
    admitted = admitted_up_to(limits.problem, slip, limits.tolerances)
    above = f"Above λ = {down(admitted)} the" if admitted > 0 else "The"
    node, event = first_to_leave(limits.problem, slip, admitted)
    where = node_in_words(limits.problem, node)
    return f" {above} first load step makes {where} {event}, so {state} is not one of these states."


def starting_in_words(found: Assessment) -> str:
    """The state that is asked about, as it ends a sentence."""
    return f"starting {start_in_words(np.nan_to_num(found.details.energy.initial_slip))}"


def _margins(found: Assessment, every: float, here: float, *, larger: bool) -> dict[str, str]:
    """By how much the load may grow, or must shrink, each with the states for which that is proved.

    Where both margins are the same in the digits shown, it is that of every state.
    """
    margins = dict[str, str]()
    for load_factor, states in ((every, "from every state"), (here, starting_in_words(found))):
        if load_factor > 1 if larger else 0 < load_factor < 1:
            margins.setdefault(percent(load_factor, down if larger else up), states)
    return margins


def _smaller(found: Assessment, every: float, here: float) -> list[str]:
    """By how much the varying part of the load must shrink, and for which states it is proved then."""
    margins, said = _margins(found, every, here, larger=False), "smaller it is proved to shake down "  # once
    return [f"{margin} {said * (k == 0)}{state}" for k, (margin, state) in enumerate(margins.items())]


def _larger(found: Assessment, every: float, here: float, simulated: float) -> str:
    """By how much the varying part of the load may grow."""
    margins = _margins(found, every, here, larger=True)
    mesh = " for this mesh" * bool(found.details.mesh.warning)
    known = " and ".join(f"{margin} larger {states}" for margin, states in margins.items())
    if len(margins) == 1:  # the sentence before says for which states
        known = f"{next(iter(margins))} larger"
    more = ""
    if simulated > 1 and percent(simulated, down) not in margins:
        more = f", {percent(simulated, down)} in the simulation"
    return f"The varying part of the load alone may be {known}, proved{mesh}{more}."


def decides_in_words(found: Assessment) -> str:
    """The node that λ_max or the proved limit depends on most, or why there is no limit.

    Examples
    --------
    >>> import shakedown
    >>> print(decides_in_words(shakedown.assess(shakedown.example("one-node-3d"))))
    λ_max is determined by node 0, which reaches its friction limit there.
    """
    limits = found.details
    upper, problem = limits.upper, limits.problem
    if upper.open_nodes:
        return zone_in_words(upper, problem)[0]
    if nothing_safe := without_safe_slip_in_words(upper):
        return nothing_safe
    if is_constant(problem):
        return "The loading does not change over the period, so the load factor makes no difference."
    if limits.mesh.warning:
        return ""
    order = ["energy", "upper"]
    if found.said_as_given == Said.IMPOSSIBLE or limits.from_state.kind != "energy":
        order.reverse()
    known = {"energy": "The proved limit", "upper": "λ_max"}
    for name in order:
        sensitivities = limits.sensitivities.get(name)
        if not isinstance(sensitivities, Missing | None):
            sentence = limited_in_words(sensitivities, problem, known[name])
            if sentence:
                return sentence
    if upper.status == Status.UNBOUNDED:
        return f"{upper.reason[:1].upper()}{upper.reason[1:]}."
    nodes = tuple(sorted({node for node, _ in upper.active}))
    if not nodes:
        return ""
    named = "all nodes" if 1 < len(nodes) == problem.n else open_in_words(nodes, problem)
    verb, whose = ("reach", "their friction limits") if len(nodes) > 1 else ("reaches", "its friction limit")
    return f"λ_max is determined by {named}, which {verb} {whose} there."


def next_in_words(found: Assessment, file: str = "FILE") -> str:
    """The next step: a command on the file, and its purpose.

    Examples
    --------
    >>> import shakedown
    >>> next_in_words(shakedown.assess(shakedown.example("block-9")))
    'Next: shakedown-bounds verify FILE -o report.html (by simulation).'
    """
    from_zero = not np.nan_to_num(found.details.energy.initial_slip).any()
    if found.said_as_given == Said.OPEN and found.problem.initial_slip is not None and from_zero:
        command, why = GIVEN
    else:
        command, why = NEXT[found.said_as_given]
    return f"Next: shakedown-bounds {command.format(file)} ({why})."
