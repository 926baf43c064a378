"""The exact long-term state of a joint under periodic loading."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.argument_kinds import check_count
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.shown_values import count, cycles_in_words, nodes_in_words
from shakedown.ground.size_limits import CYCLES, MANY
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_arguments, checked, checked_initial_slip
from shakedown.joint.coupled_parts import coupled_parts
from shakedown.joint.derived import lent
from shakedown.joint.problem import Problem
from shakedown.long_term.limit_search import LONGEST_PERIOD, OUTCOMES, LimitSearch, empty_answers
from shakedown.long_term.part_by_part import joined_state
from shakedown.long_term.passage import Passage
from shakedown.long_term.plane.search import BLURRED, BROKEN, LEFT, SHAKEDOWN, UNDECIDED, SearchState
from shakedown.long_term.space.proved_verdict import heeding_proofs
from shakedown.long_term.space.returned_state import returned_state
from shakedown.long_term.space.settled import VARIES_LITTLE
from shakedown.long_term.state import LongTermState
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import State, beginning


@checked
def long_term_state(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None = None,
    *,
    open_nodes: Iterable[int] = (),
    max_cycles: int = CYCLES,
    longest_period: int = LONGEST_PERIOD,
    tolerances: Tolerances = DEFAULT,
) -> LongTermState:
    """The long-term state of a joint under its loading loop, decided exactly rather than by waiting.

    As soon as the cycles of a period (1, 2, … ``longest_period`` cycles) pass
    through the same sequence of contact states as those before them, the map
    from the start of a period to the next is affine there, v ↦ J v + c. Its
    limit follows from the geometric series. It is accepted when the states
    2, 4, 8, … periods ahead still pass through that sequence, and when one more
    exact period from the limit returns to it.

    Parameters
    ----------
    problem
        The joint and its loading.
    load_factor
        λ ≥ 0, multiplies the periodic part of the loading.
    initial_slip : (n,), optional
        Slip at the start [length]; zero by default. Transient load steps, where the
        problem has them, come before the first period.
    open_nodes
        Nodes that are open at the start, as for :func:`evolve`.
    max_cycles
        Give up after so many cycles, with the outcome "undecided". In space up to three times as many
        besides may be followed from states next to those of a slow motion, which show where it goes.
    longest_period
        Longest period looked for, in cycles.
    tolerances
        What counts as zero, as reached and as periodic (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("three-node")
    >>> state = long_term_state(joint, 2.6, joint.initial_slip[0])
    >>> state.outcome.value, state.slip_per_cycle.round(6)
    ('cyclic-slip', array([3.854489, 0.      , 0.      ]))
    """
    check_arguments(load_factor, max_cycles, problem)
    check_count("longest_period", longest_period, MANY)
    opened, patience = tuple(open_nodes), Patience(max_cycles, longest_period)
    return settled_state(problem, load_factor, initial_slip, opened, patience, tolerances)


class Patience(NamedTuple):
    """How long a long-term state is sought."""

    most_cycles: int
    longest_period: int


@on_one_thread
def settled_state(
    problem: Problem,
    load_factor: float,
    initial_slip: ArrayLike | None,
    open_nodes: tuple[int, ...],
    patience: Patience,
    tolerances: Tolerances,
) -> LongTermState:
    """As :func:`long_term_state`, reusing the last search on the problem where its settings are the same."""
    most_cycles, longest_period = patience
    parts = coupled_parts(problem, open_nodes)
    if len(parts) > 1:
        start = beginning(problem, load_factor, initial_slip, open_nodes, tolerances).state.u

        of_parts = [(part.joint, start[part.slips], part.among(open_nodes)) for part in parts]
        found = [
            settled_state(joint, load_factor, slip, opened, patience, tolerances)
            for joint, slip, opened in of_parts
        ]
        return joined_state(problem, open_nodes, parts, found)
    if problem.directions > 1:
        start = checked_initial_slip(problem, initial_slip)
        begun = Passage(problem, float(load_factor), tolerances, start, open_nodes)
        return heeding_proofs(returned_state(begun, most_cycles, longest_period))

    def build() -> LimitSearch:
        evolution = Evolution(problem, load_factor, initial_slip, tolerances, open_nodes=open_nodes)
        return LimitSearch(evolution, most_cycles, longest_period)

    with lent(problem, "search", (tolerances, most_cycles, longest_period), build) as search:
        search.begin(load_factor, initial_slip, open_nodes)
        return heeding_proofs(_found(search, open_nodes, most_cycles))


def _found(search: LimitSearch, open_nodes: tuple[int, ...], most_cycles: int) -> LongTermState:
    """The long-term state of a motion from its start, with the given nodes open there."""
    evolution = search.evolution
    n, slips = evolution.problem.n, evolution.problem.layout.slips
    start, answers = evolution.state.u[slips].copy(), empty_answers(1, evolution.problem.layout)
    search.from_here(answers)
    seen, at, length = search.compiled, search.search_state, evolution.scale.length
    verdict, known = int(answers.verdict[0]), answers.verdict[0] >= SHAKEDOWN
    left, nan, cycles = verdict == LEFT, np.full(n, np.nan), max(at.done, 1)
    always_open = seen.check.always_open == 1 if known else np.full(n, left)
    opened = seen.opened == 1 if known else np.full(n, left)
    reason, met = _reason(search, at, verdict)
    return LongTermState(
        problem=evolution.problem,
        load_factor=evolution.load_factor,
        initial_slip=start,
        outcome=OUTCOMES[verdict],
        reason=reason + _events_in_words(at, opened & ~always_open) if known else reason,
        period=at.done if known else 0,
        final_slip=answers.final_slip[0],
        drift=at.done / at.period * seen.drift[slips] if known else nan,
        slip_per_cycle=answers.slip[0],
        friction_dissipation_per_cycle=at.friction / cycles if known else np.nan,
        jump_dissipation_per_cycle=at.damping / cycles if known else np.nan,
        jumps_per_cycle=at.jumps / cycles if known else np.nan,
        open_nodes=tuple(np.flatnonzero(always_open).tolist()),
        cycles_simulated=at.cycles,
        slides_away=evolution.stop is not None and evolution.stop.slides_away,
        dissipations=seen.works[: at.done].copy() if known else np.array([]),
        opened=opened,
        events=at.events,
        contraction=at.contraction if known else np.nan,
        return_error=at.far / length if known else np.nan,
        signature=int(at.signature) if known else 0,
        stop=evolution.stop,
        met=met,
        most_cycles=most_cycles,
        begun=Passage(evolution.problem, evolution.load_factor, evolution.tolerances, start, open_nodes),
        goal=State(seen.goal.copy(), seen.contact.copy()) if known else evolution.state,
    )


def _reason(search: LimitSearch, at: SearchState, verdict: int) -> tuple[str, float]:
    """The basis of the verdict in words, and the violation of the friction law, NaN where there is none."""
    evolution = search.evolution
    if verdict in (UNDECIDED, LEFT):
        stop = evolution.stop
        return stop.reason if stop else f"no periodic state within {count(at.cycles, 'cycle')}", np.nan
    text = f"limit of the cycles, whose contact states repeat every {cycles_in_words(at.period)}"
    if not at.from_limit:
        cycle, before = at.cycles - at.done, at.cycles - at.done - at.period
        text = f"cycle {cycle} repeats cycle {before}" if before else f"the start is back after cycle {cycle}"
    if verdict == BLURRED:
        return f"{VARIES_LITTLE} ({text})", np.nan
    if verdict != BROKEN:
        return text, np.nan
    if at.done == 0:
        residual = evolution.violation(evolution.state)
        return f"the friction law is violated by {residual:.1e} between two cycles ({text})", residual
    broken = f"the friction law is violated by {at.violation:.1e} in the period found ({text})"
    return broken, at.violation


def _events_in_words(at: SearchState, breathing: NDArray[np.bool_]) -> str:
    """The nodes that open and close in a period, and its jumps, in words."""
    every, text = cycles_in_words(at.done), ""
    if breathing.any():
        text += f"; opening and closing every {every}: {nodes_in_words(np.flatnonzero(breathing))}"
    if at.jumps:
        text += f"; {at.jumps} jump{'s' if at.jumps > 1 else ''} in every {every}"
    return text
