"""Whether all states of a map end in the same one, with the evidence; why some have no outcome."""

import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import SHORT_DIGITS, few, sized
from shakedown.ground.status import Outcome
from shakedown.joint.result import Result
from shakedown.joint.units import units_of
from shakedown.studies.limit_cycles import LimitCycle, Scatter, same_slip
from shakedown.studies.samplers import Sampling

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
    sampling: Sampling, outcomes: Mapping[str, int], cycles: Sequence[LimitCycle], at_rest: Scatter
) -> FinalStates:
    """What the final states have in common.

    Parameters
    ----------
    sampling
        The joint, λ, and the initial states.
    outcomes
        How many states have each outcome.
    cycles
        The distinct limit cycles.
    at_rest
        Scatter of the slips locked in where it shakes down.
    """
    decided = [word for word, count in outcomes.items() if count and word != Outcome.UNDECIDED]
    undecided, states = outcomes.get(Outcome.UNDECIDED, 0), sum(outcomes.values())
    same_outcome = False if len(decided) > 1 else (None if undecided or not decided else True)
    if words := [*_differences(sampling, decided, cycles, at_rest)]:
        return FinalStates(same_outcome, False, "; ".join(words))
    if not decided:
        return FinalStates(None, None, "no state is decided")
    if undecided:
        verb = "is" if undecided == 1 else "are"
        return FinalStates(None, None, f"{undecided} of {states} states {verb} undecided, the others agree")
    if decided == [Outcome.SHAKEDOWN]:
        return FinalStates(True, True, f"all {states} states shake down with the same slips locked in")
    if not cycles:
        return FinalStates(True, None, "the body leaves the contact from every state")
    if sum(cycle.count + len(cycle.named) for cycle in cycles) < states:
        return FinalStates(True, None, "from some states the body leaves the contact, the others agree")
    motion = "separation" if decided == [Outcome.SEPARATION] else "limit cycle"
    slips = "final slips" + ", but for the drift," * (decided == [Outcome.RATCHETTING])
    agree = f"one and the same {motion}: {slips} and dissipation agree"
    return FinalStates(True, True, f"all {states} states end in {agree}")


def _differences(
    sampling: Sampling, decided: Sequence[str], cycles: Sequence[LimitCycle], at_rest: Scatter
) -> Iterator[str]:
    """The differences between final states in words."""
    if Outcome.SHAKEDOWN in decided and len(decided) > 1:
        yield "some states shake down and others do not"
    moving = [word.replace("-", " ") for word in decided if word != Outcome.SHAKEDOWN]
    if len(moving) > 1:
        yield f"some end in {' and others in '.join(moving)}"
    slipping = [cycle for cycle in cycles if cycle.outcome != Outcome.SEPARATION]
    if len(slipping) > 1:
        yield f"{len(slipping)} different limit cycles"
    if (sets := len({cycle.slipping_nodes for cycle in slipping})) > 1:
        yield f"{sets} different sets of slipping nodes"
    if (others := len(cycles) - len(slipping)) > 1:
        yield f"{others} different motions with separation"
    length = units_of(sampling.problem).length
    for cycle in [cycle for cycle in cycles if not cycle.coincide][:1]:
        yield _scattered(cycle, sampling.problem.n, sized(cycle.spread, length, SHORT_DIGITS))
    if at_rest.spread > same_slip(sampling):
        spread, largest = (sized(slip, length, SHORT_DIGITS) for slip in at_rest)
        share = few(100.0 * at_rest.spread / at_rest.largest, SHORT_DIGITS)
        much = f"{spread} ({share} % of the largest slip, {largest})"
        yield f"the slips locked in where it shakes down differ by up to {much}"


def _scattered(cycle: LimitCycle, n: int, spread: str) -> str:
    """How the states differ that end in a continuum of limit cycles."""
    differ = f"final slips differ by up to {spread}"
    if cycle.outcome == Outcome.SEPARATION:
        return f"the slips locked in under separation: {differ}"
    low, high = (few(value, 6) for value in cycle.dissipation)
    much = f"(dissipation {low}{f' to {high}' * (high != low)}; {differ})"
    if len(cycle.slipping_nodes) < n:
        return f"the slip locked in selects one of a continuum {much}"
    return f"limit cycles differ {much}"


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
    sampling: Sampling, slips: FloatArray, rows: NDArray[np.intp]
) -> tuple[UndecidedReason, ...]:
    """Reasons why these states are undecided, the most frequent first.

    Parameters
    ----------
    sampling
        The joint, λ, and how long states are searched for.
    slips : (s, dn)
        Initial slips of all states [length].
    rows
        Numbers of those that are undecided; a few spread evenly over them are looked at.
    """
    chosen = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), LOOKED_AT)).round().astype(int))
    found = defaultdict[tuple[str, bool], list[int]](list)
    for example in rows[chosen].tolist():
        state = sampling.state(slips[example])
        ran_out = state.stop is None and state.cycles_simulated >= sampling.max_cycles
        found[WHEN.sub("", state.reason), ran_out].append(example)
    reasons = (UndecidedReason(why, len(of), of[0], ran_out) for (why, ran_out), of in found.items())
    return tuple(sorted(reasons, key=lambda one: (-one.count, one.example)))
