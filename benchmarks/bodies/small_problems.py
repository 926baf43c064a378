"""Built-in problems that a few lines define, of the thesis and counter-examples, each a file of the package.

``python -m benchmarks.bodies.small_problems`` writes the files.
"""

from dataclasses import replace

import numpy as np

import shakedown
from shakedown import Problem


def one_node() -> Problem:
    """One node below its critical friction k₁₁/|k₂₁| = 2, where Melan's theorem holds (appendix A)."""
    t = np.arange(40) / 40
    return Problem(
        name="one node (appendix A)",
        A=[[1.0]],
        B=[[0.5]],
        C=[[1.0]],
        f=0.5,
        q_w=1.0 * np.cos(2 * np.pi * t)[:, None],
        p_w=2.0 + 0.8 * np.sin(2 * np.pi * t)[:, None],
    )


def one_node_separation() -> Problem:
    """Separation and stick in turn, with a jump in every cycle, above the critical friction 2/3 (A.6).

    The load leaves the sector of stick on its backward side: the node jumps into the
    air, comes back where the load crosses the line of separation, and sticks at the
    same slip until it jumps again. The thesis draws the loop and prints no numbers.
    From the second initial slip the same loading shakes down: above the critical
    friction Melan's theorem fails.
    """
    name = "one node, separation and stick (A.6)"
    loop = [(4.0, 4.0), (4.0, 1.0), (1.0, 1.0), (1.0, 4.0)]
    return _above_critical(name, [(0.0, 4.0), (1.0, 4.0)], loop, [[0.0], [20.0]])


def one_node_cyclic() -> Problem:
    """Cyclic slip with separation and a jump in every cycle, above the critical friction 2/3 (A.7).

    The node comes back with the load on the forward side of its new sector, and slips
    until the load turns. From the second initial slip the same loading shakes down.
    """
    name = "one node, cyclic slip (A.7)"
    loop = [(3.0, 3.0), (3.0, 2.0), (-1.0, 2.0), (1.0, 3.0)]
    return _above_critical(name, [(0.0, 3.0), (1.0, 3.0)], loop, [[0.0], [20.0]])


def _above_critical(
    name: str, transient: list[tuple[float, float]], loop: list[tuple[float, float]], slips: list[list[float]]
) -> Problem:
    """One node with load steps (q_w, p_w)."""
    before, period = np.array(transient), np.array(loop)
    return Problem(
        name=name,
        A=[[1.0]],
        B=[[1.5]],
        C=[[4.0]],
        f=0.8,
        q_w=period[:, :1],
        p_w=period[:, 1:],
        q_transient=before[:, :1],
        p_transient=before[:, 1:],
        initial_slip=slips,
    )


def two_node() -> Problem:
    """The two-node system of thesis §5.3.1–5.3.2, fifty load steps.

    The thesis does not print their number, which is inferred: with t = k/m no other m
    from 8 to 2,000 gives all four of its digits, λ = 0.6574, 0.7391, 1.0525, 2.9349. As
    m → ∞ they tend to 0.6572, 0.7389, 1.0520, 2.9297.
    """
    t = np.arange(50) / 50
    q1, q2 = 15.8 + 200 * np.cos(2 * np.pi * (t - 0.05)), -400 + 700 * np.cos(2 * np.pi * (t + 0.125))
    p1, p2 = 588.5 + 150 * np.sin(2 * np.pi * t), 1300 + 300 * np.sin(2 * np.pi * t)
    return Problem(
        name="two-node system (5.3.1)",
        A=[[243.92, -43.91], [-43.91, 262.78]],
        B=[[320.60, 120.60], [-120.60, 129.93]],
        C=[[804.04, 80.40], [80.40, 642.46]],
        f=0.35,
        q_w=np.column_stack([q1, q2]),
        p_w=np.column_stack([p1, p2]),
    )


def uncoupled() -> Problem:
    """The two-node system with B = 0, where Melan's theorem holds and both bounds coincide."""
    return replace(two_node(), name="two-node system without coupling", B=np.zeros((2, 2)))


def three_node() -> Problem:
    """Cyclic slip below the first collapse: node 0 cycles from λ = 2.4442 on, λ_1 = 3.096.

    While node 0 cycles, each row of the other nodes need only hold for the slip
    that node 0 has when that row is extreme. ``initial_slip`` starts the cycle.
    """
    q1 = np.zeros((8, 3))
    q1[0, 0], q1[2, 1], q1[4, 0], q1[6, 2] = -1.25, -0.75, 1.25, 0.50
    q_mean, p_mean = np.array([-1.01, -0.38, 0.80]), np.array([4.5, 2.5, 4.0])
    return Problem(
        name="three-node counter-example",
        A=[[1.0, 0.6, 0.6], [0.6, 1.0, 0.0], [0.6, 0.0, 1.0]],
        B=[[0.0, 1.8, -1.8], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
        C=20.0 * np.eye(3),
        f=0.5,
        q_w=q_mean + q1,
        p_w=np.tile(p_mean, (8, 1)),
        q_mean=q_mean,
        p_mean=p_mean,
        initial_slip=[2.60902, -0.60226, -0.36541],
    )


def pair_cycle() -> Problem:
    """Two nodes cycle together from λ = 1.699024 on, below λ_1 = 3.096, from where on one alone does.

    The three-node counter-example with its mover split in two, nodes 0 and 1, that do not
    act on each other: each drives the other two nodes half as far, and both together farther.
    """
    movers, others = slice(0, 2), slice(2, 4)
    A, B, q1 = np.eye(4), np.zeros((4, 4)), np.zeros((8, 4))
    A[movers, others] = A[others, movers] = 0.36
    B[movers, others] = 1.8, -1.8
    q1[0, movers], q1[2, 2], q1[4, movers], q1[6, 3] = -1.25, -0.75, 1.25, 0.50
    q_mean, p_mean = np.array([-1.01, -1.01, -0.38, 0.80]), np.array([4.5, 4.5, 2.5, 4.0])
    return Problem(
        name="pair counter-example",
        A=A,
        B=B,
        C=20.0 * np.eye(4),
        f=0.5,
        q_w=q_mean + q1,
        p_w=np.tile(p_mean, (8, 1)),
        q_mean=q_mean,
        p_mean=p_mean,
    )


def two_attractors() -> Problem:
    """Two limit cycles of period 1, both stable, with different dissipation: the initial state decides.

    Found by search, after Andersson, Barber & Ahn (SIAM J. Appl. Math., 2013): joints of this
    family (weak A₁₂, strong B, impulses in turn with quiet steps between) have limit cycles
    of period two, because a slip of one node that the other one drives turns a disturbance
    round. Here the loop is two such loops one after the other, whose impulses differ by up to
    a fifth: what was one limit cycle, entered at either of its two cycles, becomes two. The
    rates are unique (threshold 0.559), and no node opens. Dissipation per cycle is 1.876905
    from the first initial slip and 2.135192 from the second; of slips spread widely about
    half lead to either.
    """
    turns = [(0, +1), (0, -1), (1, -1), (0, +1), (0, -1), (1, +1)]  # (node, sign of the impulse)
    first, second = [0.92, 1.49, 2.31, 1.93, 1.29, 0.97], [1.05, 1.35, 2.17, 1.57, 1.42, 0.93]
    q1 = np.zeros((24, 2))
    for k, ((node, sign), size) in enumerate(zip(turns + turns, first + second, strict=True)):
        q1[2 * k, node] = sign * size
    return Problem(
        name="two attractors",
        A=[[1.0, 0.04], [0.04, 1.0]],
        B=[[-1.06, -1.72], [0.80, -1.24]],
        C=[[10.0, 0.0], [0.0, 10.0]],
        f=0.5,
        q_w=q1,
        p_w=np.full((24, 2), 4.0),
        q_mean=[0.0, 0.0],
        p_mean=[4.0, 4.0],
        initial_slip=[[-0.1, 0.6], [0.2, 0.7]],
    )


def jump() -> Problem:
    """The two-node system of thesis §6.4, (6.45) and (6.48), whose state jumps.

    Its friction is above the threshold of uniqueness, 0.3557 (6.47). The thesis
    prints no way to the discontinuity. Here both nodes start stuck inside their limits at
    q_w1 = 2.6, at the slips with which they would both be on them at 2.501, and
    q_w1 falls to the 2.5 of (6.48). End state: (3.5640, −24.5639), w₂ = 3.3443, node
    0 in forward slip and node 1 open (the thesis prints (3.5459, −24.5192) and
    3.33, from matrices with more digits).
    """
    f, p_w, q_limit = 0.39, [1.0, 1.0], np.array([2.501, 2.0])
    A, B = np.array([[0.4276, 0.1754], [0.1754, 0.1216]]), np.array([[-0.1011, -0.022], [-0.053, 0.1082]])
    side = np.array([-1.0, 1.0])  # node 0 forward, node 1 backward
    start = np.linalg.solve(A - side[:, None] * f * B, side * f * p_w - q_limit)
    return Problem(
        name="jump (chapter VI)",
        A=A,
        B=B,
        C=[[0.3005, 0.0012], [0.0012, 0.5522]],
        f=f,
        q_w=[[2.5, 2.0]],
        p_w=[p_w],
        q_transient=[[2.6, 2.0]],
        p_transient=[p_w],
        initial_slip=start,
    )


def small_problems() -> dict[str, Problem]:
    """All of them by the names of their files."""
    made = {
        "one-node": one_node,
        "one-node-separation": one_node_separation,
        "one-node-cyclic": one_node_cyclic,
        "two-node": two_node,
        "uncoupled": uncoupled,
        "three-node": three_node,
        "pair-cycle": pair_cycle,
        "two-attractors": two_attractors,
        "jump": jump,
    }
    return {name: make() for name, make in made.items()}


if __name__ == "__main__":
    for file, problem in small_problems().items():
        shakedown.save_problem(f"shakedown/files/data/{file}.npz", problem)
