"""Why states of a map are undecided: a few of them are followed once more, and say so."""

import re
from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.long_term.find_state import long_term_state
from shakedown.studies.maps.map_pieces import MapSearch

LOOKED_AT = 8  # undecided states, at most
WHEN = re.compile(r" (at time \S+ cycles|on the way to the first period)")


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
