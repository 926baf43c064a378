"""A joint with two tangential directions and its moving state for compiled loops; arrays for paths."""

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import Flags, Hash, Integers, NamedState, Reals
from shakedown.ground.size_limits import BLOCK, DENSE_FROM

REACHES_LIMIT, STOPS, CURVES = range(6, 9)  # kinds of event, after those of motion.course
DEGREE = 4  # of the polynomial between the ends of a step
TOGETHER = 16  # places exchanged in one pass through the matrix


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
        Outputs from inputs: κ with the free places exchanged (:mod:`.exchange`).
    friction : (n,)
        Friction coefficients.
    free : (N,)
        1 where a place is free.
    exchanges
        Made since ``exchanged`` was made afresh.
    changing, pivots, old_rows : (p,), (p,), (p, N)
        Places that are exchanged together, their pivots, and their rows just before.
    kept, kept_free, keeps : (N, N), (N,)
        ``exchanged`` and ``free`` as made afresh at the beginning of a cycle; whether κ is as it was then.
    pressed, displaced, known
        κ u, (N,), and u it is of, (N,); whether it has been worked out.
    part, parts : …, (N / part, N)
        A number of places, and what every so many have in it.
    """

    kappa: Reals
    exchanged: Reals
    friction: Reals
    free: Flags
    n: int
    exchanges: int
    changing: Integers
    pivots: Reals
    old_rows: Reals
    kept: Reals
    kept_free: Flags
    keeps: bool
    pressed: Reals
    displaced: Reals
    part: int
    parts: Reals
    known: bool


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
        The event ahead, or not yet dealt with.
    came_node, came_kind
        What the present step began with.
    concerned
        The node for which the motion stopped, or −1.
    crowd
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
    came_node: int
    came_kind: int
    concerned: int
    crowd: int
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


def compiled_joint(kappa: FloatArray, friction: FloatArray) -> CompiledJoint:
    """The joint of a stiffness (3n, 3n) and friction coefficients (n,), nothing free."""
    N = len(kappa)
    part = DENSE_FROM if kappa.size > BLOCK else N
    shapes = {"parts": (-(-N // part), N), "old_rows": (TOGETHER, N)}
    of_places = dict.fromkeys(("free", "kept_free", "pressed", "displaced"), N)
    joint = CompiledJoint(
        of_places | dict.fromkeys(("changing", "pivots"), TOGETHER) | shapes,
        kappa=np.array(kappa, dtype=float, order="C"),
        exchanged=np.array(kappa, dtype=float, order="C"),
        kept=np.empty((N, N)),
        friction=np.array(friction, dtype=float),
    )
    joint.set(n=len(friction), part=part)
    return joint


def motion_at_rest(n: int) -> SpaceMotion:
    """A state at rest at the origin, all nodes closed."""
    shapes = {"u": 3 * n, "out": 3 * n, "direction": 2 * n}
    return SpaceMotion(shapes | dict.fromkeys(("contact", "resting", "slip", "work", "opened", "closed"), n))


def empty_curve_record(rows: int, n: int) -> CurveRecord:
    """Arrays for so many steps of n nodes."""
    shapes = {"u": (rows, 3 * n), "curve": (rows, DEGREE, 3 * n), "contact": (rows, n)}
    record = CurveRecord(shapes | dict.fromkeys(("time", "duration", "node", "kind"), rows))
    record.set(capacity=rows)
    return record
