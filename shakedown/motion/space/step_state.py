"""The data of a step along the smooth path in space, and the control of the next one."""

from shakedown.ground.named_state import Flags, Integers, NamedState, Reals, Shorts
from shakedown.motion.space.dense_solver import solver_routines
from shakedown.motion.space.moving_state import DEGREE

EXPLICIT, RADAU = range(2)  # methods
STAGES = 7  # of a step
PATIENCE = 20  # explicit steps after a rejected Radau step
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


def empty_space_rates(n: int) -> SpaceRates:
    """Arrays for the rates of n nodes."""
    of_places = dict.fromkeys(("welded", "base", "rate", "held"), 3 * n)
    flags = ("apex", "candidate", "arrived", "chosen", "active", "wanted", "at_zero")
    return SpaceRates(of_places | dict.fromkeys((*flags, "slack_rate", "before"), n))


def empty_slipping(n: int) -> Slipping:
    """Arrays for n nodes that slip."""
    shapes = {"A": 4 * n * n, "B": 2 * n * n, "M": n * n, "limits": n * n, "sizes": 4}
    shapes |= dict.fromkeys(("load_q", "q", "unit", "normal"), 2 * n)
    of_nodes = ("node", "f", "load_p", "p", "size", "order", "drive", "speed", "correction")
    return Slipping(shapes | dict.fromkeys(of_nodes, n), routines=solver_routines())


class Step(NamedState):
    """A step of the nodes that slip, packed as in :class:`.Slipping`, rows of arrays for n nodes.

    Attributes
    ----------
    method
        EXPLICIT or RADAU.
    k, k_q, mu, heat : (7, 2n), (7, 2n), (7, n), (7, n)
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
    """

    n: int
    method: int
    k: Reals
    k_q: Reals
    mu: Reals
    heat: Reals
    stage_q: Reals
    slip: Reals
    curve: Reals
    next_out: Reals
    next_rate: Reals
    bend: Reals
    scratch: Reals


class Turning(NamedState):
    """In a step of Radau's the angles of the nodes that turn fast, and their equations.

    Attributes
    ----------
    fast : (8,)
        Packed nodes that turn fast.
    angle, reactions, bends : (3, 8), (3, 2n), (3, 8, 8)
        At the stages their angles, all packed reactions, and how the rates of those nodes' reactions follow
        the angles.
    equations, turn, turn_order : (24, 24), (24,), (24,)
        Of the angles.
    """

    fast: Integers
    angle: Reals
    reactions: Reals
    bends: Reals
    equations: Reals
    turn: Reals
    turn_order: Shorts


class StepControl(NamedState):
    """How accurate steps are to be, which one to try, and what they cost.

    Attributes
    ----------
    force_scale, length_scale
        Of the scene.
    accuracy
        Error allowed for one passage of the course, relative to the length scale.
    h, capped
        Explicit step to try, and whether it is shorter than its accuracy asks.
    long, wait, patience, apex_ahead
        Step of Radau's to try, explicit ones before that and after the next refusal, time to an apex from
        where on one goes there.
    taken
        Steps taken.
    effort, allowed
        Multiplications and additions, and after how many of them a loop returns.
    """

    force_scale: float
    length_scale: float
    accuracy: float
    h: float
    capped: bool
    long: float
    wait: int
    patience: int
    apex_ahead: float
    taken: int
    effort: int
    allowed: int


def empty_step(n: int) -> Step:
    """Arrays for a step of n nodes."""
    shapes = {"k": STAGES * 2 * n, "k_q": STAGES * 2 * n, "mu": STAGES * n, "heat": STAGES * n}
    shapes |= {"stage_q": 2 * n, "slip": 2 * n, "curve": DEGREE * 2 * n, "bend": 3 * DEGREE}
    step = Step(shapes | dict.fromkeys(("next_out", "next_rate", "scratch"), 3 * n))
    step.set(n=n)
    return step


def empty_turning(n: int) -> Turning:
    """Arrays for the angles of the nodes that turn fast among n."""
    most = 3 * MOST_FAST
    shapes = {"fast": MOST_FAST, "angle": most, "reactions": 3 * 2 * n, "bends": most * MOST_FAST}
    return Turning(shapes | {"equations": most * most, "turn": most, "turn_order": most})
