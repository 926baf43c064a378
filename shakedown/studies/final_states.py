"""Whether all states of a map end in the same one, with the evidence; why some have no outcome."""

import re
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import SHORT_DIGITS, few, sized
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import units_of
from shakedown.long_term.find_state import long_term_state
from shakedown.studies.limit_cycles import LimitCycle, Scatter, same_slip
from shakedown.studies.map_pieces import MapSearch

LOOKED_AT = 8  # largest number of undecided states followed again
WHEN = re.compile(r" (at time \S+ cycles|on the way to the first period)")


class FinalStates(NamedTuple):
    """A comparison of the final states of a map.

    Attributes
    ----------
    same_outcome
        Whether all states have the same outcome; None where some are undecided and the
        others do not differ.
    unique
        Whether they end in one and the same state, slips that stay locked in included; None
        where that is not known.
    evidence
        What that rests on, in words.
    """

    same_outcome: bool | None
    unique: bool | None
    evidence: str


def final_states(
    problem: Problem,
    load_factor: float,
    outcomes: Mapping[str, int],
    cycles: tuple[LimitCycle, ...],
    at_rest: Scatter,
    tolerances: Tolerances,
) -> FinalStates:
    """What the final states have in common.

    Parameters
    ----------
    problem, load_factor
        The joint and λ.
    outcomes
        How many states have each outcome.
    cycles
        The distinct limit cycles.
    at_rest
        Scatter of the slips locked in where it shakes down.
    tolerances
        What counts as the same.
    """
    decided = [word for word, count in outcomes.items() if count and word != Outcome.UNDECIDED]
    undecided, states = outcomes.get(Outcome.UNDECIDED, 0), sum(outcomes.values())
    same_outcome = False if len(decided) > 1 else (None if undecided or not decided else True)
    rest_agrees = not at_rest.spread > same_slip(problem, load_factor, tolerances)
    words = _differences(decided, cycles, problem)
    if not rest_agrees:
        words.append(f"the slips locked in where it shakes down {_apart(at_rest, problem)}")
    if words:
        return FinalStates(same_outcome, False, "; ".join(words))
    if not decided:
        return FinalStates(None, None, "no state is decided")
    if undecided:
        verb = "is" if undecided == 1 else "are"
        return FinalStates(None, None, f"{undecided} of {states} states {verb} undecided, the others agree")
    if not cycles:
        if decided == [Outcome.SHAKEDOWN]:
            return FinalStates(True, True, f"all {states} states shake down with the same slips locked in")
        return FinalStates(True, None, "the body leaves the contact from every state")
    if sum(cycle.count + len(cycle.named) for cycle in cycles) < states:
        return FinalStates(True, None, "from some states the body leaves the contact, the others agree")
    return FinalStates(True, True, f"all {states} states end in {_the_one(cycles[0])}")


def _the_one(cycle: LimitCycle) -> str:
    """The motion that all states end in."""
    motion = "separation" if cycle.outcome == Outcome.SEPARATION else "limit cycle"
    slips = "final slips" + ", but for the drift," * (cycle.outcome == Outcome.RATCHETTING)
    return f"one and the same {motion}: {slips} and dissipation agree"


def _differences(decided: list[str], cycles: tuple[LimitCycle, ...], problem: Problem) -> list[str]:
    """The differences between final states in words, other than slips locked in at rest."""
    words = []
    if Outcome.SHAKEDOWN in decided and len(decided) > 1:
        words.append("some states shake down and others do not")
    moving = [word for word in decided if word != Outcome.SHAKEDOWN]
    if len(moving) > 1:
        words.append(f"some end in {' and others in '.join(_in_words(word) for word in moving)}")
    slipping = [cycle for cycle in cycles if cycle.outcome != Outcome.SEPARATION]
    if len(slipping) > 1:
        words.append(f"{len(slipping)} different limit cycles")
        sets = len({cycle.slipping_nodes for cycle in slipping})
        words += [f"{sets} different sets of slipping nodes"] * (sets > 1)
    if len(cycles) - len(slipping) > 1:
        words.append(f"{len(cycles) - len(slipping)} different motions with separation")
    words += [_scattered(cycle, problem) for cycle in cycles if not cycle.coincide][:1]
    return words


def _scattered(cycle: LimitCycle, problem: Problem) -> str:
    """How the states differ that end in a continuum of limit cycles."""
    spread = f"final slips differ by up to {_length(cycle.spread, problem)}"
    if cycle.outcome == Outcome.SEPARATION:
        return f"the slips locked in under separation: {spread}"
    low, high = (few(value, 6) for value in cycle.dissipation)
    dissipation = f"dissipation {low}" + (f" to {high}" if high != low else "")
    locked_in = len(cycle.slipping_nodes) < problem.n
    one = "the slip locked in selects one of a continuum" if locked_in else "limit cycles differ"
    return f"{one} ({dissipation}; {spread})"


def _apart(scatter: Scatter, problem: Problem) -> str:
    share = 100.0 * scatter.spread / scatter.largest
    largest = f"{few(share, SHORT_DIGITS)} % of the largest slip, {_length(scatter.largest, problem)}"
    return f"differ by up to {_length(scatter.spread, problem)} ({largest})"


def _length(value: float, problem: Problem) -> str:
    return sized(value, units_of(problem).length, SHORT_DIGITS)


def _in_words(outcome: str) -> str:
    return outcome.replace("-", " ")


@dataclass(frozen=True, eq=False, repr=False)
class UndecidedReason(Result):
    """A reason why states are undecided.

    Attributes
    ----------
    reason
        In words, without the time at which it occurs.
    count
        How many of the states looked at again it holds for.
    example
        Number of one of them.
    more_cycles
        Whether the cycles allowed ran out, so that more of them may decide it.
    """

    reason: str
    count: int
    example: int
    more_cycles: bool


def undecided_reasons(
    problem: Problem, load_factor: float, slips: FloatArray, rows: NDArray[np.intp], search: MapSearch
) -> tuple[UndecidedReason, ...]:
    """Reasons why these states are undecided, the most frequent first.

    Parameters
    ----------
    problem, load_factor
        The joint and λ.
    slips : (s, dn)
        Initial slips of all states [length].
    rows
        Numbers of those that are undecided; a few spread evenly over them are looked at.
    search
        How long-term states were searched for.
    """
    chosen = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), LOOKED_AT)).round().astype(int))
    found: dict[tuple[str, bool], list[int]] = defaultdict(list)
    for example in rows[chosen]:
        state = long_term_state(
            problem,
            load_factor,
            np.asarray(slips[example]),
            max_cycles=search.max_cycles,
            longest_period=search.longest_period,
            tolerances=search.tolerances,
        )
        ran_out = state.stop is None and state.cycles_simulated >= search.max_cycles
        found[_without_time(state.reason), ran_out].append(int(example))
    reasons = (
        UndecidedReason(reason, len(examples), examples[0], ran_out)
        for (reason, ran_out), examples in found.items()
    )
    return tuple(sorted(reasons, key=lambda one: (-one.count, one.example)))


def _without_time(reason: str) -> str:
    """What went wrong, without when.

    Examples
    --------
    >>> _without_time("the body slides away at time 0.158095 cycles: friction does not hold it")
    'the body slides away: friction does not hold it'
    """
    return WHEN.sub("", reason)
