"""Hard cases for time integration, each with a reason to be hard that is built in and not met by chance."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

import shakedown
from benchmarks.problems import in_units, random_problem
from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading
from shakedown.motion.checked_law import Scales, scales

# A, B, C of two equal nodes
PAIR = [[4.0, -1.0], [-1.0, 4.0]], [[1.0, 0.5], [0.5, 1.0]], [[8.0, -1.0], [-1.0, 8.0]]


@dataclass(frozen=True)
class Scene:
    """A joint, its loop as given (load factor 1), its initial slip and the number of cycles to follow.

    ``raw`` scenes are given to Siconos in their own units, all others in units of
    their force and length scales.
    """

    problem: Problem
    start: FloatArray
    cycles: int = 3
    raw: bool = False

    @property
    def peer_units(self) -> Scales:
        return Scales(1.0, 1.0) if self.raw else scales(self.problem, 1.0)


def joint(A: ArrayLike, B: ArrayLike, C: ArrayLike, f: ArrayLike, q_w: ArrayLike, p_w: ArrayLike) -> Problem:
    """A joint whose loop is all periodic part, so that at load factor 1 it is exactly the one given."""
    n = len(np.atleast_2d(A))
    q_w, p_w = (np.reshape(np.asarray(part, dtype=float), (-1, n)) for part in (q_w, p_w))
    return Problem(A=A, B=B, C=C, f=f, q_w=q_w, p_w=p_w, q_mean=np.zeros(n), p_mean=np.zeros(n))


def one_node(f: float, q_w: ArrayLike, p_w: ArrayLike) -> Problem:
    return joint([[1.0]], [[0.5]], [[2.0]], f, q_w, p_w)


def at_rest(problem: Problem) -> Scene:
    return Scene(problem, np.zeros(problem.n))


def along_the_limit(f: float, unit: float) -> Scene:
    """The load reaches the limit exactly and runs along it, up and down, and never beyond: no slip."""
    p = unit * np.array([2.0, 2.0, 6.0, 1.0, 3.0])
    return at_rest(one_node(f, np.concatenate([[0.0], f * p[1:]]), p))


def from_the_limit() -> Scene:
    """Starts on the limit, is pushed over it, back along it, and over the other one."""
    return at_rest(one_node(0.5, [1.0, 2.0, 1.0, -2.0, 0.0], [2.0, 2.0, 2.0, 2.0, 2.0]))


def corner(sides: tuple[float, float]) -> Scene:
    """Two equal nodes reach their limits (the same ones or opposite ones) at one instant, again and again."""
    q = np.outer([0.0, 1.5, 3.0, -1.5, -3.0, 0.0], sides)
    return at_rest(joint(*PAIR, 0.5, q, np.full_like(q, 3.0)))


def row_of_six() -> Scene:
    """Six nodes with equal loads: all reach their limits at one instant."""
    A = 4 * np.eye(6) - np.eye(6, k=1) - np.eye(6, k=-1)
    B = 0.25 * (np.eye(6, k=1) - np.eye(6, k=-1))
    q = np.outer([0.0, 1.5, 3.0, 0.0, -1.5, -3.0], np.ones(6))
    return at_rest(joint(A, B, 8 * np.eye(6), 0.5, q, np.full_like(q, 3.0)))


def through_the_apex(f: float) -> Scene:
    """The load falls exactly to the apex p = q = 0, rests there and rises again on either side."""
    return at_rest(one_node(f, [0.0, 0.5 * f, 0.0, -0.25 * f, 0.0, 0.0], [2.0, 1.0, 0.0, 0.5, 0.0, 0.0]))


def off_at_the_apex() -> Scene:
    """Down a limit to the apex, off, and back to the place where it left."""
    return at_rest(one_node(0.5, [0.0, 1.0, 0.0, -0.5, 0.0], [2.0, 2.0, 0.0, -1.0, 0.0]))


def two_apexes() -> Scene:
    """Two equal nodes come to the apex at one instant, open, and close at one instant."""
    column = np.ones(2)
    q, p = np.outer([0.0, 0.5, 0.0, -0.5, 0.0], column), np.outer([2.0, 1.0, 0.0, -1.0, 0.0], column)
    return at_rest(joint(*PAIR, 0.5, q, p))


def closing_elsewhere() -> Scene:
    """Opens while it is pushed sideways and closes at another place, in the middle of a load step."""
    return at_rest(one_node(0.5, [0.0, 0.75, 1.5, 2.0, 1.0, 0.0], [2.0, 1.5, -1.0, -2.0, 1.0, 2.0]))


def near_node_threshold(k: int) -> Scene:
    """One node, f/f_c = 1 − 10^−k, f_c = 2; pushed over a limit so little that it slips by 1."""
    f = 2.0 * (1.0 - 10.0**-k)
    over = 1.0 - 0.5 * f  # A − f B
    return at_rest(one_node(f, [0.0, 4.0 * f + over, 0.0, -4.0 * f - 0.5 * (1.0 + 0.5 * f)], [4.0] * 4))


def near_joint_threshold(k: int) -> Scene:
    """Two nodes, f/f_c = 1 − 10^−k, f_c = 1: backward slip of both, each drawing the other on."""
    f = 1.0 - 10.0**-k
    A, B = np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([[0.0, 1.0], [1.0, 0.0]])
    over = (A - f * B) @ np.ones(2)  # load that makes both slip by 1
    slip = A - f * np.array([[-0.0, -1.0], [-1.0, -0.0]])
    q = np.array([np.zeros(2), 4.0 * f + over, np.zeros(2), -4.0 * f - 0.25 * (slip @ np.ones(2))])
    return at_rest(joint(A, B, 8.0 * np.eye(2), f, q, np.full_like(q, 4.0)))


def slipping(n: int, seed: int, m: int, above: float) -> Problem:
    """A random joint whose loop is so many times the largest that it can shake down under."""
    problem = random_problem(n, seed=seed, m=m)
    q_w, p_w = loading(problem).at(above * shakedown.upper_bound(problem).load_factor)
    return joint(problem.A, problem.B, problem.kappa[n:, n:], problem.f, q_w, p_w)


def coarse() -> Scene:
    """A joint whose load steps are so long that a node slips and stops again within one of them."""
    return at_rest(slipping(3, seed=2, m=8, above=1.4))


def graded(k: int) -> Scene:
    """κ of condition 10^k and more; the soft directions slip far."""
    generator = np.random.default_rng(0)
    basis = np.linalg.qr(generator.normal(size=(3, 3)))[0]
    A = basis @ np.diag(10.0 ** -np.linspace(0, k, 3)) @ basis.T
    A = 0.5 * (A + A.T)
    q = np.concatenate([np.zeros((1, 3)), 2.0 * generator.normal(size=(5, 3))])
    return at_rest(joint(A, 0.1 * A, A, 0.5, q, np.full_like(q, 3.0)))


def grazing_limit(over: float) -> Scene:
    """The peak of the loop passes the limit of one of two nodes by ``over``, relative to the force."""
    q = np.zeros((4, 2))
    q[1, 0], q[3, 0] = 1.5 * (1.0 + over), -1.5
    return at_rest(joint(*PAIR, 0.5, q, np.full_like(q, 3.0)))


def grazing_opening(lift: float) -> Scene:
    """The pressure falls to −``lift``: the node just opens, and is pushed sideways while it hangs."""
    return at_rest(one_node(0.5, [0.0, 0.0, 0.25, 0.5, 0.0], [2.0, -lift, 1.0, 2.0, 2.0]))


def slipping_in_units(force: float, length: float, raw: bool) -> Scene:
    return Scene(in_units(slipping(3, seed=1, m=8, above=1.4), force, length), np.zeros(3), raw=raw)


def many_cycles(n: int, cycles: int) -> Scene:
    """A joint that slips in every cycle."""
    return Scene(slipping(n, seed=3, m=4, above=1.5), np.zeros(n), cycles)


FAMILIES: dict[str, dict[str, Callable[[], Scene]]] = {
    "on limits": {
        "along the limit": lambda: along_the_limit(0.5, 1.0),
        "along the limit, decimals": lambda: along_the_limit(0.3, 0.1),
        "from the limit": from_the_limit,
    },
    "corners": {
        "two nodes at once": lambda: corner((1.0, 1.0)),
        "opposite limits at once": lambda: corner((1.0, -1.0)),
        "six nodes at once": row_of_six,
    },
    "apexes": {
        "through the apex": lambda: through_the_apex(0.5),
        "through the apex, decimals": lambda: through_the_apex(0.3),
        "off at the apex": off_at_the_apex,
        "two nodes off at once": two_apexes,
    },
    "long load steps": {"closes elsewhere": closing_elsewhere, "stops within a step": coarse},
    "near threshold": {
        f"{word}, f/f_c = 1 - 1e-{k}": lambda make=make, k=k: make(k)
        for word, make in (("one node", near_node_threshold), ("two nodes", near_joint_threshold))
        for k in (2, 4, 6, 8, 10, 12)
    },
    "ill-conditioned κ": {f"condition 1e{k}": lambda k=k: graded(k) for k in (4, 8, 12, 14)},
    "grazing": {
        **{f"limit passed by {x:.0e}": lambda x=x: grazing_limit(x) for x in (0.0, 1e-4, 1e-8, 1e-12)},
        **{f"opens by {x:.0e}": lambda x=x: grazing_opening(x) for x in (0.0, 1e-4, 1e-8, 1e-12)},
    },
    "units": {
        f"{word} x {x:.0e}{', peers unscaled' * raw}": lambda a=a, b=b, raw=raw: slipping_in_units(a, b, raw)
        for raw in (False, True)
        for x in (1e12, 1e-12)
        for word, a, b in (("forces", x, 1.0), ("lengths", 1.0, x))
    },
    "many cycles": {
        f"{word}, {cycles} cycles": lambda n=n, cycles=cycles: many_cycles(n, cycles)
        for n, word in ((1, "one node"), (2, "two nodes"))
        for cycles in (10**3, 10**5)
    },
}
