"""Built-in problems, each a few lines: the thesis's own, a counter-example, finite-element blocks."""

from collections.abc import Callable
from dataclasses import replace
from importlib import resources

import numpy as np

from shakedown.errors import UsageError
from shakedown.files.npz import load_problem
from shakedown.model.problem import Problem


def example(name: str) -> Problem:
    """A built-in problem by name.

    Raises
    ------
    UsageError
        If there is no problem of that name.

    Examples
    --------
    >>> example("two-node").n
    2
    """
    if not isinstance(name, str) or name not in _EXAMPLES:
        raise UsageError(f"no built-in problem '{name}'; there are {', '.join(_EXAMPLES)}")
    return _EXAMPLES[name]()


def example_names() -> tuple[str, ...]:
    """Names of the built-in problems.

    Examples
    --------
    >>> "two-node" in example_names()
    True
    """
    return tuple(_EXAMPLES)


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
    """Separation and stick in turn, without slip, above the critical friction 2/3 (scenario A.6).

    The node closes at a slip that puts the apex of its stick sector on the path
    of the load, so that it opens there again. From the second initial slip the
    same loading shakes down: above the critical friction Melan's theorem fails.
    """
    return _above_critical("one node, separation and stick (A.6)", [1.0, 1.0], [5.0, 1.0], [[0.0], [2.0]])


def one_node_cyclic() -> Problem:
    """Cyclic slip with separation, above the critical friction 2/3 (scenario A.7).

    From the second initial slip the same loading shakes down.
    """
    q_w, p_w = [0.0, 2.0, 2.5], [0.0, 2.5, 4.0]
    return _above_critical("one node, cyclic slip (A.7)", q_w, p_w, [[-0.5], [1.0]])


def _above_critical(name: str, q_w: list[float], p_w: list[float], slips: list[list[float]]) -> Problem:
    return Problem(
        name=name,
        A=[[1.0]],
        B=[[1.5]],
        C=[[4.0]],
        f=0.8,
        q_w=np.reshape(q_w, (-1, 1)),
        p_w=np.reshape(p_w, (-1, 1)),
        initial_slip=slips,
    )


def two_node() -> Problem:
    """The two-node system of thesis §5.3.1–5.3.2, fifty load steps."""
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


def jump() -> Problem:
    """A two-node system above its threshold of uniqueness, whose state jumps (thesis chapter VI).

    κ and the loads are not the printed (6.45) and (6.48). They are constructed to
    have the results that follow from those: the six friction thresholds, the
    slips (−20.727, 30.905) at which both nodes are on their limits, and the end
    state (3.5640, −24.5639), w₂ = 3.3443 with node 0 in forward slip and node 1
    open (the thesis prints (3.5459, −24.5192) and 3.33, from unrounded matrices).
    The energy released and the distance of the load from the jump are this
    system's own.

    The transient starts at q_w1 = 2.6, slightly inside both limits; both nodes
    would reach them at 2.5; the load stays at 2.2.
    """
    end, start = [2.2, 7.129786692], [2.6, 7.129786692]
    p_w = [21.256779174, 3.086571012]
    return Problem(
        name="jump (after chapter VI)",
        A=[[1.564954211097, 0.634685497787], [0.634685497787, 0.435045788903]],
        B=[[-0.370009270859, -0.079602950643], [-0.191764386522, 0.387120296230]],
        C=[[1.4, -0.064581505343], [-0.064581505343, 2.124846593854]],
        f=0.39,
        q_w=[end],
        p_w=[p_w],
        q_transient=[start],
        p_transient=[p_w],
        initial_slip=[-20.75, 30.96],
    )


def block_9() -> Problem:
    """Elastic block, plane strain, nine contact nodes on a rigid plane, top face moved (CalculiX 2.20)."""
    return _shipped("block-9")


def block_33() -> Problem:
    """The same block with 33 contact nodes."""
    return _shipped("block-33")


def receding_block() -> Problem:
    """The receding contact of chapter III, 33 contact nodes; its outer nodes separate."""
    return _shipped("receding-block")


def cantilevered_block() -> Problem:
    """The slanted, cantilevered block of chapter V, nine contact nodes; λ_1 = 0 by lift-off."""
    return _shipped("cantilevered-block")


def _shipped(name: str) -> Problem:
    with resources.as_file(resources.files("shakedown.files") / "data" / f"{name}.npz") as path:
        return load_problem(path)


_EXAMPLES: dict[str, Callable[[], Problem]] = {
    "one-node": one_node,
    "one-node-separation": one_node_separation,
    "one-node-cyclic": one_node_cyclic,
    "two-node": two_node,
    "uncoupled": uncoupled,
    "three-node": three_node,
    "jump": jump,
    "block-9": block_9,
    "block-33": block_33,
    "receding-block": receding_block,
    "cantilevered-block": cantilevered_block,
}
