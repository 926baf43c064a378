"""After the three numbers: by how much the amplitude may grow, what decides, and the one thing to do next."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from shakedown.assessment.from_state import ENERGY
from shakedown.ground.evidence import Missing
from shakedown.ground.shown_values import down, up
from shakedown.ground.status import Said, Status
from shakedown.report.assessment_words import percent
from shakedown.report.bound_words import above_in_words, is_constant
from shakedown.report.limit_words import limited_in_words
from shakedown.report.node_words import open_in_words
from shakedown.report.zone_words import without_safe_slip_in_words, zone_in_words

if TYPE_CHECKING:
    from shakedown.assessment.assess import Assessment

NEXT = {
    Said.SHAKEDOWN: "Next: shakedown-bounds verify FILE -o report.html (checks it by simulation).",
    Said.OPEN: "Next: shakedown-bounds simulate FILE (what becomes of it under this load).",
    Said.IMPOSSIBLE: "Next: shakedown-bounds nodes FILE (where and how far it slips).",
}
GIVEN = "Next: shakedown-bounds solve FILE --initial given (the file has initial slips)."


def margin_of_bounds(found: Assessment) -> str:
    """By how much the amplitude may grow, or how much less is enough, as far as that is proved.

    Examples
    --------
    >>> import shakedown
    >>> margin_of_bounds(shakedown.assess(shakedown.example("two-node")))
    'Reduce the amplitude by 26.85 %: then it is proved to shake down.'
    """
    every, here = np.nan_to_num([found.proved_from_every_state, found.proved_from_this_state], posinf=np.inf)
    proved = max(every, here)
    if found.details.open_nodes:
        return ""
    if found.said_as_given == Said.SHAKEDOWN:
        margins = [f"{percent(value, down)} proved" for value in (every, here) if value > 1]
        if len(set(margins)) > 1:
            margins = [f"{margins[0]} from every state", f"{margins[1]} from this one"]
        return f"Margin on the amplitude: {', '.join(dict.fromkeys(margins))}." if margins else ""
    if not 0 < proved < 1:
        return ""
    less = percent(proved, up)
    if found.said_as_given == Said.IMPOSSIBLE:
        return f"Reduce the amplitude by {less}: then it is proved to shake down."
    return f"With the amplitude reduced by {less} it is proved to shake down."


def decides_in_words(found: Assessment) -> str:
    """What decides: the node that limits what is proved, or λ_max, most, or why there is no limit.

    Examples
    --------
    >>> import shakedown
    >>> print(decides_in_words(shakedown.assess(shakedown.example("one-node-3d"))))
    λ_max is decided at node 0, which reaches its friction limit there.
    """
    limits = found.details
    upper, problem = limits.upper, limits.problem
    if upper.open_nodes:
        return zone_in_words(upper, problem)[0]
    if nothing_safe := without_safe_slip_in_words(upper):
        return nothing_safe
    if is_constant(problem):
        return "The loading does not change over the period, so the load factor makes no difference."
    if found.said_as_given == Said.OPEN and limits.energy.status == Status.INFEASIBLE:
        return f"From this state no load factor is proved at once: {limits.energy.reason}."
    order = ["energy", "upper"]
    if found.said_as_given == Said.IMPOSSIBLE or limits.from_state.symbol != ENERGY:
        order.reverse()
    for sensitivities in (limits.sensitivities.get(name) for name in order):
        if not isinstance(sensitivities, Missing | None):
            sentence = limited_in_words(sensitivities, problem)
            if sentence:
                return sentence
    if upper.status == Status.UNBOUNDED:
        return above_in_words(upper, problem)
    nodes = tuple(sorted({node for node, _ in upper.active}))
    if not nodes or limits.mesh.names_what_decides:
        return ""
    named = "all nodes" if 1 < len(nodes) == problem.n else open_in_words(nodes, problem)
    verb, whose = ("reach", "their friction limits") if len(nodes) > 1 else ("reaches", "its friction limit")
    return f"λ_max is decided at {named}, which {verb} {whose} there."


def next_in_words(found: Assessment) -> str:
    """The one thing to do next, a command.

    Examples
    --------
    >>> import shakedown
    >>> next_in_words(shakedown.assess(shakedown.example("block-9")))
    'Next: shakedown-bounds verify FILE -o report.html (checks it by simulation).'
    """
    from_zero = not np.nan_to_num(found.details.energy.initial_slip).any()
    if found.said_as_given == Said.OPEN and found.problem.initial_slip is not None and from_zero:
        return GIVEN
    return NEXT[found.said_as_given]
