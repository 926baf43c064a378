"""A course, the load path that compiled loops follow in the plane and in space, and how such a loop ends."""

from enum import IntEnum

import numpy as np

from shakedown.ground.constants import FloatArray
from shakedown.ground.named_state import Hash, Integers, NamedState, Reals, inner

LoopEnd = IntEnum(
    "LoopEnd",
    "DONE NO_RATES LIFTS_OFF RECORD_FULL TOO_MANY_EVENTS NOT_HELD PAUSED OUT_OF_WORK AT_EVENT "
    "LIMIT_WANTED SINGULAR",
    start=0,
)
"""How a compiled loop ends; OUT_OF_WORK: what motions may take is spent (ground.work_limit)."""
CALL_OPERATIONS = 200_000_000  # additions and products after which a loop returns, some 0.2 s
ENUMERABLE = 10  # nodes up to which all combinations of two states are tried
RECORD_ROWS = 256  # rows of a path after which a loop returns so that they are read
HASH_PRIME = np.uint64(1099511628211)


class EventKind(IntEnum):
    """What happens: a load step begins, a node reaches a limit, opens or closes, the state jumps.

    With two tangential directions a node reaches its one limit, and stops there; between events the path
    goes on in curves.
    """

    LOAD_STEP = 0
    REACHES_BACKWARD_LIMIT = 1
    REACHES_FORWARD_LIMIT = 2
    OPENS = 3
    CLOSES = 4
    JUMPS = 5
    REACHES_LIMIT = 6
    STOPS = 7
    CURVES = 8


@inner
def code_of(states: Integers, first: int, n: int) -> Hash:
    """A hash of n contact states from this place on (Fowler, Noll and Vo's)."""
    code = np.uint64(14695981039346656037)
    for i in range(n):
        code = (code ^ np.uint64(states[first + i] + 2)) * HASH_PRIME
    return code


class Course(NamedState):
    """The load path along which the state is carried.

    Attributes
    ----------
    path : (s + 1, 2n)
        Welded reactions at the ends of s load steps [force].
    steps, first
        s, and the number of the first of them.
    separable
        Whether nodes may open.
    force, length, rate, residual
        What counts as zero: forces, gaps, rates relative to the largest; residual forces of moving nodes.
    """

    path: Reals
    steps: int
    first: int
    separable: bool
    force: float
    length: float
    rate: float
    residual: float


def course(path: FloatArray, first: int, separable: bool, known: Course) -> Course:
    """The course along welded reactions (s + 1, 2n); its first load step has number ``first``.

    ``known`` becomes it; what counts as zero stays.
    """
    known.hold(path=np.ascontiguousarray(path, dtype=float))
    known.set(steps=len(path) - 1, first=first, separable=separable)
    return known
