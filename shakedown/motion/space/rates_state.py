"""What the rates of a motion in space are computed with: at an instant, and of the nodes that slip."""

from shakedown.ground.named_state import Flags, Integers, NamedState, Reals, Shorts
from shakedown.motion.implicit.dense_solver import solver_routines


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
