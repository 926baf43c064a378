"""The moving state in two tangential directions as compiled loops take it, and room to record its path."""

from typing import NamedTuple

import numpy as np
from numba import types
from numba.experimental import structref

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import (
    Flags,
    Hash,
    Integers,
    NamedState,
    Reals,
    Shorts,
    entered,
    fields,
    made,
)
from shakedown.motion.implicit.dense_solver import solver_routines
from shakedown.motion.plane.moving_state import JUMPS, LOAD_STEP

SLIP = 1  # as STICK and OPEN of ground.contact_status: the direction is that of the reaction
REACHES_LIMIT, STOPS, CURVES = 6, 7, 8  # kinds of event, after those of motion.plane.moving_state
EXPLICIT, RADAU = 0, 1  # steps
MOST_FAST = 8  # nodes whose angles are unknown in a step of Radau's
STAGES, DEGREE = 7, 4  # of a step, and of the polynomial between its ends


@structref.register
class SlidingType(types.StructRef):
    """Compiled type of :class:`Sliding`."""


class Sliding(NamedState):
    """The moving state of n nodes, everything that it is computed with, and what has been counted.

    A *place* is a displacement with its reaction: those of slip, node by node, then those of the gaps,
    N = 3n in all. Of a place that is *free* (an open node's, the slip of a frictionless one) the reaction is
    given, zero, and the displacement follows; of any other place it is the other way round.
    *Packed* arrays hold the s nodes that slip one after the other.

    Attributes
    ----------
    kappa : (N, N)
        Contact stiffness [force / length].
    exchanged : (N, N)
        Outputs from inputs: κ with the free places exchanged (:mod:`.exchange`).
    friction : (n,)
        Friction coefficients.
    free : (N,)
        1 where a place is free.
    contact : (n,)
        STICK, SLIP or OPEN.
    resting : (n,)
        1 where a node has come to rest on its cone and has not left it since: neither speed nor room.
    apex : (n,)
        1 where the reaction of a node vanishes at the present instant.
    path : (steps + 1, N)
        Welded reactions at the ends of the load steps [force].
    u : (N,)
        Slips and gaps [length].
    out : (N,)
        Reactions [force]; displacements of free places [length].
    welded, base : (N,)
        Rates of the load, and of ``out`` while nothing slips, per load step.
    rate, next_rate, next_out : (N,)
        Rates of ``out`` at both ends of a step, and ``out`` at its end.
    direction : (2n,)
        Unit vectors along which nodes at the apex slip.
    slipped, work : (n,)
        Path length in contact [length]; what friction dissipates [force × length].
    opened, closed : (n,)
        1 where the node was open, and where it was closed.
    node, s
        Nodes that slip, (s,), and their number.
    A, B, f : (2s, 2s), (s, 2s), (s,)
        Packed stiffness, coupling and friction.
    load_q, load_p : (2s,), (s,)
        Packed ``base``.
    q, p, stage_q : (2s,), (s,), (2s,)
        Packed reactions at the beginning of the step and at a stage.
    unit, size : (2s,), (s,)
        Directions of slip there, and |q|.
    normal : (2s,)
        Scratch: how a limit moves with the slips.
    M, order, factored
        Triangular factors of the matrix of the speeds, (s, s), and their row exchanges, (s,); whether they
        are those of the packed nodes.
    sizes, routines : (4,), (2,)
        Of LAPACK: unknowns, right sides, what went wrong, "N"; addresses of what factorises and what solves.
    drive, speed, correction : (s,)
        Right-hand side −z, solution, and what is taken from it; ``load_size`` the largest load in it.
    k, k_q, mu, heat : (7, 2s), (7, 2s), (7, s), (7, s)
        Rates of slip and reaction, speeds and dissipation at the stages.
    slip : (2s,)
        Packed slip of the step [length].
    curve : (4, 2s)
        Packed: slip at the share x of the step is Σ x^(k+1) curve_k.
    limits, room_rate : (n, n), (n,)
        Matrix of the speeds in the present directions, that of the rate problem too, and its constants.
    candidate, arrived, chosen : (n,)
        1 where a node is on its cone, has just reached it, is to be packed.
    active, wanted, at_zero : (n,)
        Packed: 1 where a node slips, is to slip, sticks without a rate of room.
    before, held, scratch : (n,), (N,), (N,)
        Contact states and displacements before the instant; scratch.
    bend : (3, 4)
        ``out`` of one node within the step, as ``curve``.
    fast, angle, reactions, bends : (8,), (3, 8), (3, 2n), (3, 8, 8)
        In a step of Radau's the packed nodes that turn fast, and at its stages their angles, all packed
        reactions, and how the rates of those nodes' reactions follow the angles.
    equations, turn, turn_order : (24, 24), (24,), (24,)
        Of the angles.
    n, steps, first, separable
        Nodes, load steps, number of the first of them, and whether nodes may open.
    force, length, rate_zero, near
        Round-off of forces and lengths; rates that count as zero, relative; distance from a limit at
        which a node is there, relative to the force.
    force_scale, length_scale, accuracy
        Of the scene; error allowed for one passage of the course, relative to the length scale.
    step, time, h
        Load steps done, share of the next that is done, and the step to try.
    method, capped
        EXPLICIT or RADAU, and whether the explicit step is shorter than its accuracy asks.
    long, wait, patience, apex_ahead
        Step of Radau's to try, explicit ones before that and after the next refusal, time to an apex from
        where on one goes there.
    kind, event_node; came_kind, came_node
        The event ahead, or not yet dealt with; what the present step began with.
    """

    kappa: Reals
    exchanged: Reals
    friction: Reals
    free: Flags
    contact: Integers
    resting: Flags
    apex: Flags
    path: Reals
    u: Reals
    out: Reals
    welded: Reals
    base: Reals
    rate: Reals
    next_rate: Reals
    next_out: Reals
    direction: Reals
    slipped: Reals
    work: Reals
    opened: Flags
    closed: Flags
    node: Integers
    A: Reals
    B: Reals
    f: Reals
    load_q: Reals
    load_p: Reals
    q: Reals
    p: Reals
    stage_q: Reals
    unit: Reals
    size: Reals
    normal: Reals
    M: Reals
    order: Shorts
    sizes: Shorts
    routines: Integers
    drive: Reals
    load_size: float
    speed: Reals
    k: Reals
    k_q: Reals
    mu: Reals
    heat: Reals
    slip: Reals
    curve: Reals
    limits: Reals
    room_rate: Reals
    correction: Reals
    candidate: Flags
    arrived: Flags
    chosen: Flags
    active: Flags
    wanted: Flags
    at_zero: Flags
    before: Integers
    held: Reals
    scratch: Reals
    bend: Reals
    fast: Integers
    angle: Reals
    reactions: Reals
    bends: Reals
    equations: Reals
    turn: Reals
    turn_order: Shorts
    n: int
    steps: int
    first: int
    separable: bool
    force: float
    length: float
    rate_zero: float
    near: float
    force_scale: float
    length_scale: float
    accuracy: float
    s: int
    exchanges: int
    passes: int
    step: int
    time: float
    h: float
    method: int
    capped: bool
    long: float
    wait: int
    patience: int
    apex_ahead: float
    kind: int
    event_node: int
    came_kind: int
    came_node: int
    concerned: int
    factored: bool
    crowd: int
    events: int
    entered: bool
    error: float
    taken: int
    effort: int
    allowed: int
    signature: Hash
    last_states: Hash


structref.define_boxing(SlidingType, Sliding)
SLIDING = SlidingType(fields(Sliding))


@structref.register
class CurveRecordType(types.StructRef):
    """Compiled type of :class:`CurveRecord`."""


class CurveRecord(NamedState):
    """Room for the steps of a path, filled from the first row on; no room: nothing is recorded.

    Attributes
    ----------
    time, duration : (r,)
        Beginning, in load steps from that of the period, and length of a step.
    u : (r, N)
        Slips and gaps at its beginning.
    curve : (r, 4, N)
        At the share x of the step they are u + Σ x^(k+1) curve_k.
    contact : (r, n)
        Contact states within the step.
    node, kind : (r,)
        What happened at its beginning.
    rows, room
        Rows filled, and r.
    """

    time: Reals
    duration: Reals
    u: Reals
    curve: Reals
    contact: Integers
    node: Integers
    kind: Integers
    rows: int
    room: int


structref.define_boxing(CurveRecordType, CurveRecord)
CURVE_RECORD = CurveRecordType(fields(CurveRecord))


def curve_room(rows: int, n: int) -> CurveRecord:
    """Room for so many steps of n nodes."""
    shapes = {"u": (rows, 3 * n), "curve": (rows, DEGREE, 3 * n), "contact": (rows, n)}
    record = made(CURVE_RECORD, shapes | dict.fromkeys(("time", "duration", "node", "kind"), rows))
    record.set(room=rows)
    return record


OF_PLACES = ("u", "out", "welded", "base", "rate", "next_rate", "next_out", "held", "scratch")  # (N,)
OF_SLIPS = ("direction", "load_q", "q", "stage_q", "unit", "normal", "slip")  # (2n,)
OF_NODES = (
    "slipped", "work", "f", "load_p", "p", "size", "speed", "room_rate", "correction", "drive", "contact",
    "node", "before", "resting", "apex", "opened", "closed", "candidate", "arrived", "chosen", "active",
    "wanted", "at_zero",
)  # (n,)  # fmt: skip
OF_STAGES = ("k", "k_q", "mu", "heat")  # (STAGES, 2n) or (STAGES, n)


def sliding(
    kappa: FloatArray, friction: FloatArray, path: FloatArray, first: int, separable: bool
) -> Sliding:
    """A state at rest at the origin, all nodes closed, at the beginning of its course.

    kappa is (3n, 3n), friction (n,), path the welded reactions (steps + 1, 3n); ``first`` is the number
    of the first load step.
    """
    n, most = len(friction), 3 * MOST_FAST
    by_kind = ((OF_PLACES, 3 * n), (OF_SLIPS, 2 * n), (OF_NODES, n), (OF_STAGES, STAGES * 2 * n))
    shapes = {name: size for names, size in by_kind for name in names}
    shapes |= {"A": 4 * n * n, "B": 2 * n * n, "M": n * n, "limits": n * n, "curve": DEGREE * 2 * n}
    shapes |= {"bend": 3 * DEGREE, "fast": MOST_FAST, "angle": most, "reactions": 3 * 2 * n}
    shapes |= {"bends": most * MOST_FAST, "equations": most * most, "turn": most, "turn_order": most}
    sl = made(
        SLIDING,
        shapes | {"free": 3 * n, "order": n, "sizes": 4},
        kappa=np.array(kappa, dtype=float, order="C"),
        exchanged=np.array(kappa, dtype=float, order="C"),
        friction=np.array(friction, dtype=float),
        routines=solver_routines(),
    )
    sl.set(n=n, separable=separable)
    sl.hold(path=np.ascontiguousarray(path, dtype=float))
    sl.set(steps=len(path) - 1, first=first)
    begin_sliding(sl)
    return sl


@entered
def begin_sliding(sl: Sliding) -> None:
    """Put the state at the start of its course and count from zero."""
    sl.passes, sl.step, sl.time, sl.entered, sl.concerned = 0, 0, 0.0, False, -1
    sl.kind, sl.event_node, sl.came_kind, sl.came_node = LOAD_STEP, -1, LOAD_STEP, -1
    sl.method, sl.capped, sl.h, sl.long, sl.wait, sl.patience = EXPLICIT, False, 1.0, 1.0, 0, 20
    sl.apex_ahead, sl.events, sl.crowd, sl.error, sl.taken = np.inf, 0, 0, 0.0, 0
    sl.signature, sl.last_states = np.uint64(0), np.uint64(0)
    for i in range(sl.n):
        sl.slipped[i], sl.work[i] = 0.0, 0.0
        sl.opened[i], sl.closed[i] = 0, 0


def lead(sl: Sliding, path: FloatArray, first: int) -> None:
    """Lead the state along these welded reactions (steps + 1, 3n) from now on."""
    if sl.path is not path:
        sl.hold(path=path)
        sl.set(steps=len(path) - 1, first=first)


class Measures(NamedTuple):
    """What counts as zero, and how accurate a path is to be.

    Attributes
    ----------
    force, length
        Round-off of forces and lengths.
    rate_zero
        Rates that count as zero, relative to the largest.
    near
        Distance from a limit at which a node is there [force].
    force_scale, length_scale
        Of the scene.
    accuracy
        Error allowed for one passage of the course, relative to the length scale.
    """

    force: float
    length: float
    rate_zero: float
    near: float
    force_scale: float
    length_scale: float
    accuracy: float


def resume_sliding(sl: Sliding, time: float, kind: int = JUMPS) -> None:
    """Go on after a jump, or what else has changed the state, from this share of the load step on."""
    sl.set(time=time, kind=kind, event_node=-1, entered=False, came_kind=kind, came_node=-1)
    sl.set(events=sl.events + 1)
