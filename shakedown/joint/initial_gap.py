"""Initial gaps and interference: a joint whose bodies do not just touch when unloaded."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.joint.arguments import real_array, require_problem
from shakedown.joint.problem import Problem

Parts = tuple[tuple[str, str], ...]
LOADS: Parts = (("q_w", "p_w"), ("q_transient", "p_transient"))


def with_initial_gap(problem: Problem, gap: ArrayLike) -> Problem:
    """The joint with an initial gap g⁰ between its contact nodes; negative is interference.

    With w = u_n + g⁰, u_n the normal displacement, the reactions are those of the
    displacements (v, w − g⁰): holding the nodes closed (w = 0) takes

        q_w → q_w − Bᵀ g⁰,        p_w → p_w − C g⁰

    at every load step. The periodic part of the loading does not change.

    Parameters
    ----------
    problem
        The joint with its nodes just touching; it needs C.
    gap : () or (n,)
        g⁰ [length], one number or one per node.

    Raises
    ------
    UsageError
        If the gap is not one finite number or one per node.
    ProblemError
        If the problem has no C.

    Examples
    --------
    A press fit of one node: interference 0.1 gives the pressure 0.1 C.

    >>> loose = Problem(A=[[2.0]], B=[[0.5]], C=[[3.0]], f=0.3, q_w=[[0.0]], p_w=[[0.0]])
    >>> tight = with_initial_gap(loose, -0.1)
    >>> tight.p_w.round(6), tight.q_w.round(6)
    (array([[0.3]]), array([[0.05]]))
    """
    require_problem(problem)
    g = real_array("initial gap", gap)
    if g.shape not in ((), (problem.n,)):
        raise UsageError(f"initial gap: expected one number or shape ({problem.n},), found {g.shape}")
    g = np.broadcast_to(g, problem.n)
    change = -problem.kappa[problem.n :].T @ g  # (q, p), 2n
    q, p = change[: problem.n], change[problem.n :]
    shifted: dict[str, FloatArray] = {}
    for keys in (*LOADS, ("q_mean", "p_mean")):
        for key, part in zip(keys, (q, p), strict=True):
            if getattr(problem, key) is not None:
                shifted[key] = getattr(problem, key) + part
    return replace(problem, **shifted)  # type: ignore[arg-type]  # the keys are fields
