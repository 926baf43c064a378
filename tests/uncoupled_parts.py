"""Joints of several parts that nothing couples."""

import numpy as np
from scipy.linalg import block_diag

from benchmarks.drawn_joints import drawn_joint, drawn_joint_in_space
from benchmarks.problems import in_units
from shakedown import Problem

FORCES = ("q_w", "p_w", "q_mean", "p_mean")


def pair(joint: str, number: int, decades: int) -> list[Problem]:
    """Two drawn joints with as many load steps, the second one in other units."""
    drawn = drawn_joint if joint == "plane" else drawn_joint_in_space
    found = [drawn(9, 2 * number + k) for k in (0, 1)]
    m, normal = min(each.m for each in found), all(each.C is not None for each in found)
    first, second = (with_mean(each, m, normal) for each in found)
    length, force = 10.0**decades, 10.0**decades if number % 2 else 1.0
    return [first, in_units(second, force, length)]


def with_mean(problem: Problem, m: int | None = None, normal: bool = True) -> Problem:
    """A joint of nodes and the first m load steps alone, with their mean where it has none of its own."""
    q_w, p_w = problem.q_w[:m], problem.p_w[:m]
    return Problem(
        A=problem.A,
        B=problem.B,
        C=problem.C if normal else None,
        f=problem.f,
        q_w=q_w,
        p_w=p_w,
        q_mean=q_w.mean(axis=0) if problem.q_mean is None else problem.q_mean,
        p_mean=p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean,
    )


def joined(parts: list[Problem]) -> Problem:
    """One joint of several that nothing couples."""
    stiffness = {key: [getattr(part, key) for part in parts] for key in ("A", "B", "C")}
    return Problem(
        **{key: None if blocks[0] is None else block_diag(*blocks) for key, blocks in stiffness.items()},
        **{key: np.concatenate([getattr(part, key) for part in parts], axis=-1) for key in ("f", *FORCES)},
    )
