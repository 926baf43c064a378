"""The data of one run of the compiled loops in space.

The joint and its moving state; arrays for the path; a step along the smooth path, and which one comes next.
"""

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import get_cython_function_address, intrinsic
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.named_state import Flags, Hash, Integers, NamedState, Reals, Shorts
from shakedown.motion.course import Course, EventKind

DEGREE = 4  # of the polynomial between the ends of a step


@intrinsic
def _call(typing: Any, address: Any, arguments: Any) -> Any:
    """Call the function at an address with addresses as arguments; no result."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        pointer, count = ir.IntType(8).as_pointer(), arguments.count
        kind = ir.FunctionType(ir.VoidType(), [pointer] * count).as_pointer()
        given = [builder.inttoptr(builder.extract_value(values[1], k), pointer) for k in range(count)]
        builder.call(builder.inttoptr(values[0], kind), given)
        return context.get_dummy_value()

    return types.void(types.int64, arguments), generate


call: Any = _call


@intrinsic
def _address(typing: Any, pointer: Any) -> Any:
    """Where a pointer points."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.ptrtoint(values[0], ir.IntType(64))

    return types.int64(pointer), generate


address: Any = _address


def solver_routines() -> NDArray[np.int64]:
    """The addresses of the routines that factorise and solve."""
    found = [get_cython_function_address("scipy.linalg.cython_lapack", f"dget{k}") for k in ("rf", "rs")]
    return np.array(found, dtype=np.int64)


class CompiledJoint(NamedState):
    """The stiffness and the friction of n nodes, and which of them nothing holds.

    A *place* is a displacement with its reaction: those of slip, node by node, then those of the gaps,
    N = 3n in all. Of a place that is *free* (an open node's, the slip of a frictionless one) the reaction is
    given, zero, and the displacement follows; of any other place it is the other way round.

    Attributes
    ----------
    kappa : (N, N)
        Contact stiffness [force / length].
    exchanged : (N, N)
        Outputs from inputs: κ with the free places exchanged (:mod:`.speeds`).
    friction : (n,)
        Friction coefficients.
    free : (N,)
        1 where a place is free.
    exchanges
        Made one by one since ``exchanged`` was made afresh (:func:`.speeds.arrange_afresh`).
    """

    kappa: Reals
    exchanged: Reals
    friction: Reals
    free: Flags
    n: int
    exchanges: int


class SpaceMotion(NamedState):
    """The moving state, and what has been counted since :func:`begin`.

    Attributes
    ----------
    u : (N,)
        Slips and gaps [length].
    out : (N,)
        Reactions [force]; displacements of free places [length].
    contact : (n,)
        STICK, SLIP or OPEN.
    resting : (n,)
        1 where a node has come to rest on its cone and has not left it since: neither speed nor slack.
    direction : (2n,)
        Unit vectors along which nodes at the apex slip.
    slip, work : (n,)
        Path length in contact [length]; what friction dissipates [force × length].
    opened, closed : (n,)
        1 where the node was open, and where it was closed.
    passes
        How often the whole course has been passed.
    step, time
        Load steps done, and share done of the next, which has been ``entered``; whether the motion is
        ``under_way`` there, on a path whose rates are chosen.
    node, kind
        What the present step began with.
    concerned
        The node for which the motion stopped, or −1.
    events_in_step
        Events within the present load step.
    events, error
        Events other than load steps; estimated error of the path [length].
    signature, last_states
        Of the sequence of contact states, and of those entered last.
    """

    u: Reals
    out: Reals
    contact: Integers
    resting: Flags
    direction: Reals
    slip: Reals
    work: Reals
    opened: Flags
    closed: Flags
    passes: int
    step: int
    time: float
    entered: bool
    under_way: bool
    node: int
    kind: int
    concerned: int
    events_in_step: int
    events: int
    error: float
    signature: Hash
    last_states: Hash


class CurveRecord(NamedState):
    """Arrays for the steps of a path, filled from the first row on; no capacity: nothing is recorded.

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
    rows, capacity
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
    capacity: int


def empty_curve_record(rows: int, n: int) -> CurveRecord:
    """Arrays for so many steps of n nodes."""
    shapes = {"u": (rows, 3 * n), "curve": (rows, DEGREE, 3 * n), "contact": (rows, n)}
    record = CurveRecord(shapes | dict.fromkeys(("time", "duration", "node", "kind"), rows))
    record.set(capacity=rows)
    return record


EXPLICIT, RADAU = range(2)  # methods
STAGES = 7  # of a step
EXPLICIT_STEPS = 20  # after a rejected Radau step
MOST_FAST = 8  # nodes whose angles are unknowns of a Radau step


class SpaceRates(NamedState):
    """Rates of n nodes from an instant on, and the choice between slip and stick that they follow from.

    Attributes
    ----------
    welded, base, rate : (N,)
        Rates of the load, of the outputs while nothing slips, and of the outputs, per load step.
    apex : (n,)
        1 where the reaction of a node vanishes at the present instant.
    candidate, arrived, chosen : (n,)
        1 where a node is on its cone, has just reached it, is to be packed.
    active, wanted, at_zero : (n,)
        Packed: 1 where a node slips, is to slip, sticks without a rate of slack.
    slack_rate : (n,)
        Packed: rates of the slacks while nothing slips.
    before, held : (n,), (N,)
        Contact states and displacements before the instant.
    """

    welded: Reals
    base: Reals
    rate: Reals
    apex: Flags
    candidate: Flags
    arrived: Flags
    chosen: Flags
    active: Flags
    wanted: Flags
    at_zero: Flags
    slack_rate: Reals
    before: Integers
    held: Reals


class Slipping(NamedState):
    """The s nodes that slip, *packed*: one after the other; and the equations of their speeds.

    Attributes
    ----------
    node, s
        Nodes that slip, (s,), and their number.
    A, B, f : (2s, 2s), (s, 2s), (s,)
        Stiffness, coupling and friction.
    load_q, load_p : (2s,), (s,)
        Rates of their reactions while nothing slips; ``load_size`` the largest in a rate of slack.
    q, p : (2s,), (s,)
        Reactions at the beginning of the step.
    unit, size : (2s,), (s,)
        Directions of slip where rates are asked for, and |q| there.
    normal : (2s,)
        Scratch: how a limit moves with the slips.
    limits : (s, s)
        Matrix of the speeds in the present directions.
    M, order, factored
        Triangular factors of such a matrix, (s, s), and their row exchanges, (s,); whether they are those of
        the packed nodes.
    sizes, routines : (4,), (2,)
        Of LAPACK: unknowns, right sides, what went wrong, "N"; addresses of what factorises and what solves.
    drive, speed, correction : (s,)
        Right-hand side −z, solution, and what is taken from it.
    """

    node: Integers
    s: int
    A: Reals
    B: Reals
    f: Reals
    load_q: Reals
    load_p: Reals
    load_size: float
    q: Reals
    p: Reals
    unit: Reals
    size: Reals
    normal: Reals
    limits: Reals
    M: Reals
    order: Shorts
    factored: bool
    sizes: Shorts
    routines: Integers
    drive: Reals
    speed: Reals
    correction: Reals


def empty_slipping(n: int) -> Slipping:
    """Arrays for n nodes that slip."""
    shapes = {"A": 4 * n * n, "B": 2 * n * n, "M": n * n, "limits": n * n, "sizes": 4}
    shapes |= dict.fromkeys(("load_q", "q", "unit", "normal"), 2 * n)
    of_nodes = ("node", "f", "load_p", "p", "size", "order", "drive", "speed", "correction")
    return Slipping(shapes | dict.fromkeys(of_nodes, n), routines=solver_routines())


class Step(NamedState):
    """A step of the nodes that slip, packed as in :class:`.Slipping`, and which one to try next.

    Rows of arrays are for n nodes.

    Attributes
    ----------
    method
        EXPLICIT or RADAU.
    k, k_q, mu, dissipation : (7, 2n), (7, 2n), (7, n), (7, n)
        Rates of slip and reaction, speeds and dissipation at the stages.
    stage_q : (2s,)
        Reactions at a stage.
    slip : (2s,)
        Slip of the step [length].
    curve : (4, 2n)
        Slip at the share x of the step is Σ x^(k+1) curve_k.
    next_out, next_rate : (N,)
        Outputs and their rates at the end.
    bend : (3, 4)
        Outputs of one node within the step, as ``curve``.
    scratch : (N,)
    fast : (8,)
        In a step of Radau's the packed nodes that turn fast.
    angle, reactions, bends : (3, 8), (3, 2n), (3, 8, 8)
        At its stages their angles, all packed reactions, and how the rates of those nodes' reactions follow
        the angles.
    equations, turn, turn_order : (24, 24), (24,), (24,)
        Of the angles.
    force_scale, length_scale
        Of the scene.
    accuracy
        Error allowed for one passage of the course, relative to the length scale.
    h
        Explicit step to try.
    long, wait, apex_ahead
        Step of Radau's to try, explicit ones before that, time to an apex from where on one goes there.
    taken
        Steps taken.
    effort, allowed
        Multiplications and additions, and after how many of them a loop returns.
    """

    n: int
    method: int
    k: Reals
    k_q: Reals
    mu: Reals
    dissipation: Reals
    stage_q: Reals
    slip: Reals
    curve: Reals
    next_out: Reals
    next_rate: Reals
    bend: Reals
    scratch: Reals
    fast: Integers
    angle: Reals
    reactions: Reals
    bends: Reals
    equations: Reals
    turn: Reals
    turn_order: Shorts
    force_scale: float
    length_scale: float
    accuracy: float
    h: float
    long: float
    wait: int
    apex_ahead: float
    taken: int
    effort: int
    allowed: int


def empty_step(n: int) -> Step:
    """Arrays for a step of n nodes."""
    shapes = {"k": STAGES * 2 * n, "k_q": STAGES * 2 * n, "mu": STAGES * n, "dissipation": STAGES * n}
    shapes |= {"stage_q": 2 * n, "slip": 2 * n, "curve": DEGREE * 2 * n, "bend": 3 * DEGREE}
    most = 3 * MOST_FAST
    shapes |= {"fast": MOST_FAST, "angle": most, "reactions": 6 * n, "bends": most * MOST_FAST}
    shapes |= {"equations": most * most, "turn": most, "turn_order": most}
    step = Step(shapes | dict.fromkeys(("next_out", "next_rate", "scratch"), 3 * n))
    step.set(n=n)
    return step


class SpaceRun(NamedState):
    """A joint and its moving state, with the data of rates and steps, course and record."""

    joint: CompiledJoint
    motion: SpaceMotion
    rates: SpaceRates
    slipping: Slipping
    step: Step
    course: Course
    record: CurveRecord


def run_in_space(kappa: FloatArray, friction: FloatArray, course: Course, record: CurveRecord) -> SpaceRun:
    """A state at rest at the origin of a joint (κ (3n, 3n), f (n,)), at the beginning of a course."""
    n = len(friction)
    joint = CompiledJoint(
        {"free": 3 * n},
        kappa=np.array(kappa, dtype=float, order="C"),
        exchanged=np.array(kappa, dtype=float, order="C"),
        friction=np.array(friction, dtype=float),
    )
    joint.set(n=n)
    of_motion = {"u": 3 * n, "out": 3 * n, "direction": 2 * n}
    of_motion |= dict.fromkeys(("contact", "resting", "slip", "work", "opened", "closed"), n)
    flags = ("apex", "candidate", "arrived", "chosen", "active", "wanted", "at_zero")
    of_rates = dict.fromkeys(("welded", "base", "rate", "held"), 3 * n)
    run = SpaceRun(
        {},
        joint=joint,
        motion=SpaceMotion(of_motion),
        rates=SpaceRates(of_rates | dict.fromkeys((*flags, "slack_rate", "before"), n)),
        slipping=empty_slipping(n),
        step=empty_step(n),
        course=course,
        record=record,
    )
    begin(run)
    return run


def begin(run: SpaceRun) -> None:
    """Put the state at the start of its course and count from zero."""
    motion = run.motion
    for counted in (motion.slip, motion.work, motion.opened, motion.closed):
        counted[:] = 0
    motion.set(passes=0, step=0, time=0.0, entered=False, under_way=False, concerned=-1, events=0, error=0.0)
    motion.set(events_in_step=0, node=-1, kind=EventKind.LOAD_STEP, signature=0, last_states=0)
    run.step.set(method=EXPLICIT, h=1.0, long=1.0, wait=0, apex_ahead=np.inf, taken=0)


def resume(run: SpaceRun, time: float, kind: int = EventKind.JUMPS) -> None:
    """Continue after a jump or another change of the state, from a given share of the load step."""
    motion = run.motion
    motion.set(time=time, node=-1, kind=kind, entered=False, under_way=False, events=motion.events + 1)
