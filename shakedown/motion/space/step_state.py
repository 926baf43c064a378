"""What a step along the smooth path in space is taken with, and how long the next one is to be."""

from shakedown.ground.named_state import Integers, NamedState, Reals, Shorts
from shakedown.motion.space.moving_state import DEGREE

EXPLICIT, RADAU = range(2)  # methods
STAGES = 7  # of a step
PATIENCE = 20  # explicit steps after one of Radau's that was refused
MOST_FAST = 8  # nodes whose angles are unknown in a step of Radau's


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
