"""Complete enumeration of contact states at an instant where pivoting finds no rates."""

from collections.abc import Iterator
from itertools import product
from math import prod

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.named_state import entered
from shakedown.ground.status import BACKWARD_SLIP, FORWARD_SLIP, OPEN, STICK
from shakedown.motion.course import ENUMERABLE
from shakedown.motion.plane.active_set import ActiveSet, factorize, reach_states
from shakedown.motion.plane.rate_problem import (
    AIR,
    APEX,
    FRICTIONLESS,
    ON_BACKWARD,
    ON_FORWARD,
    WORN,
    Rates,
    broken_conditions,
)


def choices(place: int, f: float) -> tuple[int, ...]:
    """States that a place leaves open."""
    if place == APEX:
        return (STICK, BACKWARD_SLIP, FORWARD_SLIP, OPEN) if f > 0.0 else (BACKWARD_SLIP, OPEN)
    if place in (ON_BACKWARD, ON_FORWARD):
        return (STICK, place)
    return {AIR: (OPEN,), FRICTIONLESS: (BACKWARD_SLIP,)}.get(place, (STICK,))


def enumerate_states(act: ActiveSet, rate: Rates, rate_tol: float) -> bool:
    """Take the first combination of states that is a stable solution; False, and nothing changed, if none is.

    Places and rates of the load are those at which pivoting has failed. None is
    tried where there are more than 2 ** ``ENUMERABLE`` combinations.
    """
    before = act.state.copy()
    for states in combinations(act, rate):
        rate.wanted[:] = states
        if try_wanted(act, rate, rate_tol):
            return True
    rate.wanted[:] = before
    take_wanted(act, rate)
    return False


@entered
def try_wanted(act: ActiveSet, rate: Rates, rate_tol: float) -> bool:
    """Take the wanted states: whether the motion in them satisfies its conditions and is stable."""
    if not reach_states(act, rate.wanted):
        return False
    count = broken_conditions(act, rate, rate_tol)
    if count == WORN and factorize(act) != 0:
        count = broken_conditions(act, rate, rate_tol)
    return count == 0 and act.sign > 0


@entered
def take_wanted(act: ActiveSet, rate: Rates) -> bool:
    """Take the wanted states; False where the matrix of their equations is singular."""
    return reach_states(act, rate.wanted)


def combinations(act: ActiveSet, rate: Rates) -> Iterator[NDArray[np.int64]]:
    """All combinations of states that the places leave open, the first node's changing first."""
    open_to = [choices(int(place), float(f)) for place, f in zip(rate.place, act.f, strict=True)]
    if prod(len(states) for states in open_to) <= 1 << ENUMERABLE:
        for states in product(*reversed(open_to)):
            yield np.array(states[::-1], dtype=np.int64)
