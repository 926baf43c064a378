"""The moving state of an exact evolution as the compiled loops take it, and room to record it."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.model.problem import FloatArray

LOAD_STEP, REACHES_BACKWARD_LIMIT, REACHES_FORWARD_LIMIT, OPENS, CLOSES, JUMPS = range(6)  # kinds of event


class Precision(NamedTuple):
    """What counts as zero: forces, gaps, and rates relative to the largest; forces in settled equations."""

    force: float
    length: float
    rate: float
    settled: float


class Motion(NamedTuple):
    """The moving state, its derivative and what has been counted since the last reset."""

    u: FloatArray  # (2n,) slips and gaps
    r: FloatArray  # (2n,) reactions q, p
    time: FloatArray  # (2,) share of the load step done; 1 while ``delay`` is half applied
    slip: FloatArray  # (n,) Σ|Δv| in contact
    work: FloatArray  # (2,) dissipation; largest correction of a settled equation [force]
    opened: NDArray[np.bool_]  # (n,) whether the node was open
    # (5,) events; node concerned when stopped; node and kind of the last event; load steps done
    counts: NDArray[np.int64]
    signature: NDArray[np.uint64]  # (2,) of the sequence of states; of the last state in it
    tangent: FloatArray  # (2n, t) ∂u/∂(state at the start); t = 0 where it is not followed
    delay: FloatArray  # (t,) ∂(time of the last event)


class Record(NamedTuple):
    """Room for the states at events; ``rows[0]`` of them are filled. No room: nothing is recorded."""

    time: FloatArray
    u: FloatArray
    r: FloatArray
    state: NDArray[np.int64]
    node: NDArray[np.int64]
    kind: NDArray[np.int64]
    rows: NDArray[np.int64]


def motion_at_rest(n: int, tangent: FloatArray | None = None) -> Motion:
    """A state at rest at the origin."""
    tangent = np.zeros((2 * n, 0)) if tangent is None else np.ascontiguousarray(tangent, dtype=float)
    return Motion(
        u=np.zeros(2 * n),
        r=np.zeros(2 * n),
        time=np.zeros(2),
        slip=np.zeros(n),
        work=np.zeros(2),
        opened=np.zeros(n, dtype=np.bool_),
        counts=np.array([0, -1, -1, LOAD_STEP, 0], dtype=np.int64),
        signature=np.zeros(2, dtype=np.uint64),
        tangent=tangent,
        delay=np.zeros(tangent.shape[1]),
    )


def room_for(rows: int, n: int) -> Record:
    """Room for so many states of n nodes."""
    return Record(
        time=np.zeros(rows),
        u=np.zeros((rows, 2 * n)),
        r=np.zeros((rows, 2 * n)),
        state=np.zeros((rows, n), dtype=np.int64),
        node=np.full(rows, -1, dtype=np.int64),
        kind=np.zeros(rows, dtype=np.int64),
        rows=np.zeros(1, dtype=np.int64),
    )
