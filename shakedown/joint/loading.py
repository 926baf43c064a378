"""The loading loop: its constant part, its periodic part and the load factor."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result

LARGEST_FORCE = 1e150  # its square is still a number


@dataclass(frozen=True, eq=False, repr=False)
class Loading(Result):
    """Welded reactions r_w(λ) = r⁰ + λ r¹ over one period (thesis §5.1).

    Attributes
    ----------
    q0, p0 : (n,)
        Constant part r⁰ [force].
    q1, p1 : (m, n)
        Periodic part r¹ = r_w − r⁰ at load factor 1 [force].
    """

    TABLE: ClassVar[str] = "q1 p1"

    q0: FloatArray
    p0: FloatArray
    q1: FloatArray
    p1: FloatArray

    def __post_init__(self) -> None:
        for array in (self.q0, self.p0, self.q1, self.p1):
            array.setflags(write=False)

    def at(self, load_factor: float) -> tuple[FloatArray, FloatArray]:
        """The welded reactions (q_w, p_w), each (m, n) [force], at a load factor.

        Raises ``UsageError`` where they are too large for floating-point numbers.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            q_w, p_w = self.q0 + load_factor * self.q1, self.p0 + load_factor * self.p1
        largest = max(np.abs(q_w).max(), np.abs(p_w).max())
        if not largest < LARGEST_FORCE:
            raise UsageError(f"load factor: expected loads below {LARGEST_FORCE:g}, found {largest:g}")
        return q_w, p_w


@once_per_problem
def loading(problem: Problem) -> Loading:
    """Split the loading loop of a problem into its constant and its periodic part; done once per problem.

    Examples
    --------
    >>> import shakedown
    >>> loop = loading(shakedown.example("two-node"))
    >>> loop.q0.round(6), loop.p0.round(6)
    (array([  15.8, -400. ]), array([ 588.5, 1300. ]))
    """
    q0 = problem.q_w.mean(axis=0) if problem.q_mean is None else problem.q_mean
    p0 = problem.p_w.mean(axis=0) if problem.p_mean is None else problem.p_mean
    return Loading(q0, p0, _cleaned(problem.q_w, q0), _cleaned(problem.p_w, p0))


def transient_path(problem: Problem) -> FloatArray:
    """The welded reactions (q_w, p_w) of the transient load steps before the first period, (k, 2n) [force].

    Examples
    --------
    >>> import shakedown
    >>> transient_path(shakedown.example("two-node")).shape
    (0, 4)
    """
    if problem.q_transient is None or problem.p_transient is None:
        return np.empty((0, 2 * problem.n))
    return np.hstack([problem.q_transient, problem.p_transient])


def ramp_start(problem: Problem, first: FloatArray, start: FloatArray) -> FloatArray:
    """Welded reactions (2n,) from which the load rises to its first load step, all closed nodes stuck.

    Tangential reactions are zero, normal ones those of the first load step (in
    magnitude), so that an initial state (v, w) that is admissible there stays as it is.
    """
    n = problem.n
    v, w = start[:n], start[n:]
    locked_q, locked_p = problem.A @ v, problem.B @ v
    if w.any():
        locked_q, locked_p = np.split(problem.kappa @ start, 2)
    return np.concatenate([-locked_q, np.abs(first[n:] + locked_p) - locked_p])


def slip_reach(problem: Problem, load_factor: float) -> FloatArray:
    """Slips that one load step could cause, node by node: the half-width of a box of initial states.

    Largest |q_w| + f |p_w| over the loop, by A_jj, (n,) [length]; 0 where A_jj = 0.

    Examples
    --------
    >>> import shakedown
    >>> slip_reach(shakedown.example("two-node"), 0.7).round(3)
    array([1.546, 5.326])
    """
    q_w, p_w = loading(problem).at(load_factor)
    force = (np.abs(q_w) + problem.f * np.abs(p_w)).max(axis=0)
    stiffness = np.diag(problem.A)
    return np.asarray(force / np.where(stiffness > 0, stiffness, np.inf))


def _cleaned(samples: FloatArray, mean: FloatArray) -> FloatArray:
    """samples − mean, with the round-off of the mean of a constant column set to exact zero."""
    periodic = samples - mean
    size = np.maximum(np.abs(samples).max(axis=0), np.abs(mean))
    constant = np.abs(periodic).max(axis=0) <= 4 * np.finfo(float).eps * size
    periodic[:, constant] = 0.0
    return periodic
