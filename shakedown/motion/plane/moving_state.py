"""The moving state of an exact evolution in compiled loops, and arrays to record it.

The data of one run of the compiled loops.
"""

import numpy as np

from shakedown.ground.named_state import Flags, Hash, Integers, NamedState, Reals, entered
from shakedown.motion.course import Course, EventKind
from shakedown.motion.plane.active_set import ActiveSet, Rates


class PlaneMotion(NamedState):
    """The moving state, its derivative and what has been counted since :func:`begin`.

    Attributes
    ----------
    u, r : (2n,)
        Slips and gaps; reactions q, p.
    elastic : (2n,)
        κ u, as it was last computed and followed since [force].
    slip : (n,)
        Σ|Δv| in contact [length].
    work : (n,)
        Friction work, without jumps [force × length].
    opened, closed : (n,)
        1 where the node was open, and where it was closed.
    tangent : (2n, t)
        ∂u/∂(t ``parameters`` of the state at the start); t = 0 where it is not followed.
    delay : (t,)
        ∂(time of the last event); ``delayed`` while it is half applied.
    passes
        How often the whole course has been passed.
    step, time
        Load steps done, and share done of the next.
    node, kind
        The last event, where it is not dealt with yet.
    concerned
        The node for which the motion stopped, or −1.
    events_in_step
        Events within the present load step.
    followed
        Load steps since ``elastic`` was computed from u.
    events, dissipation
        Events other than load steps; frictional dissipation [force × length].
    signature, last_states
        Hash of the sequence of contact states, and of those entered last.
    signed
        Whether the present contact states are in the signature.
    """

    u: Reals
    r: Reals
    elastic: Reals
    slip: Reals
    work: Reals
    opened: Flags
    closed: Flags
    tangent: Reals
    delay: Reals
    n: int
    parameters: int
    delayed: bool
    passes: int
    step: int
    time: float
    node: int
    kind: int
    concerned: int
    events_in_step: int
    followed: int
    events: int
    dissipation: float
    signature: Hash
    last_states: Hash
    signed: bool


class Record(NamedState):
    """Arrays for the states at events, filled from the first row on; no capacity: nothing is recorded.

    Attributes
    ----------
    time : (s,)
        In load steps from the beginning of the period.
    u, r : (s, 2n)
        Slips and gaps; reactions.
    state : (s, n)
        Contact states from this time on.
    node, kind : (s,)
        What happened.
    rows, capacity
        Rows filled, and s.
    """

    time: Reals
    u: Reals
    r: Reals
    state: Integers
    node: Integers
    kind: Integers
    rows: int
    capacity: int


def motion_at_rest(n: int) -> PlaneMotion:
    """A state at rest at the origin, its derivative not followed."""
    shapes = {"u": 2 * n, "r": 2 * n, "elastic": 2 * n, "slip": n, "work": n, "opened": n, "closed": n}
    mo = PlaneMotion(shapes | {"tangent": (2 * n, 0), "delay": 0})
    mo.set(n=n)
    begin(mo)
    return mo


@entered
def begin(mo: PlaneMotion) -> None:
    """Put the state at the start of its course and count from zero."""
    mo.passes, mo.step, mo.time, mo.concerned, mo.events_in_step = 0, 0, 0.0, -1, 0
    mo.node, mo.kind = -1, EventKind.LOAD_STEP
    mo.events, mo.dissipation, mo.delayed = 0, 0.0, False
    mo.signature, mo.last_states, mo.signed = np.uint64(0), np.uint64(0), False
    for i in range(mo.n):
        mo.slip[i] = 0.0
        mo.work[i] = 0.0
        mo.opened[i], mo.closed[i] = 0, 0


def resume(mo: PlaneMotion, time: float) -> None:
    """Go on after a jump, from this share of the load step on."""
    mo.set(time=time, node=-1, kind=EventKind.JUMPS, delayed=False, signed=False, events=mo.events + 1)


def empty_record(rows: int, n: int) -> Record:
    """Arrays for so many states of n nodes."""
    shapes = {"time": rows, "u": (rows, 2 * n), "r": (rows, 2 * n), "state": (rows, n), "node": rows}
    record = Record(shapes | {"kind": rows})
    record.set(capacity=rows)
    return record


class PlaneRun(NamedState):
    """A moving state with the equations and rates of its nodes, its course and its record."""

    active: ActiveSet
    rates: Rates
    motion: PlaneMotion
    record: Record
    course: Course
