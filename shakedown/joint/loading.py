"""The loading loop: its constant and its periodic part, the load factor, the effect of initial gaps."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import UsageError
from shakedown.joint.arguments import once_per_problem, real_array, require_problem
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import free_stiffness

LARGEST_FORCE = 1e150  # its square is still finite
MEAN_ROUND_OFF = 4 * np.finfo(float).eps  # round-off of a mean, relative to the largest sample


@dataclass(frozen=True, eq=False, repr=False)
class Loading(Result):
    """Welded reactions r_w(λ) = r⁰ + λ r¹ over one period (thesis §5.1).

    Attributes
    ----------
    q0, p0 : (dn,), (n,)
        Constant part r⁰ [force].
    q1, p1 : (m, dn), (m, n)
        Periodic part r¹ = r_w − r⁰ at load factor 1 [force].
    """

    TABLE: ClassVar[str] = "q1 p1"

    q0: FloatArray
    p0: FloatArray
    q1: FloatArray
    p1: FloatArray

    def at(self, load_factor: float) -> tuple[FloatArray, FloatArray]:
        """The welded reactions (q_w, p_w), (m, dn) and (m, n) [force], at a load factor.

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

    A mean that is the round-off of its sum alone is zero.

    Examples
    --------
    >>> import shakedown
    >>> loop = loading(shakedown.example("two-node"))
    >>> loop.q0.round(6), loop.p0.round(6)
    (array([  15.8, -400. ]), array([ 588.5, 1300. ]))
    """
    q0 = _mean(problem.q_w, problem.q_mean)
    p0 = _mean(problem.p_w, problem.p_mean)
    return Loading(q0, p0, _cleaned(problem.q_w, q0), _cleaned(problem.p_w, p0))


def transient_path(problem: Problem) -> FloatArray:
    """The welded reactions (q_w, p_w) of the load steps before the first period, (k, (d + 1) n) [force].

    Examples
    --------
    >>> import shakedown
    >>> transient_path(shakedown.example("two-node")).shape
    (0, 4)
    """
    if problem.q_transient is None or problem.p_transient is None:
        return problem.layout.zeros(0)
    return problem.layout.joined(problem.q_transient, problem.p_transient)


def loop_path(problem: Problem, load_factor: float) -> FloatArray:
    """The welded reactions (q_w, p_w) of one period at a load factor, (m, (d + 1) n) [force]."""
    return problem.layout.joined(*loading(problem).at(load_factor))


def first_load(problem: Problem, load_factor: float) -> FloatArray:
    """The welded reactions of the first load step, of the transient where there is one [force]."""
    before = transient_path(problem)
    if len(before):
        return np.asarray(before[0])
    loop = loading(problem)
    return problem.layout.joined(loop.q0 + load_factor * loop.q1[0], loop.p0 + load_factor * loop.p1[0])


def ramp_start(problem: Problem, first: FloatArray, start: FloatArray) -> FloatArray:
    """Welded reactions from which the load rises to its first load step, all closed nodes stuck.

    Tangential reactions are zero, normal ones those of the first load step (in
    magnitude), so that an initial state (v, w) that is admissible there stays as it is.
    """
    layout = problem.layout
    v, w = layout.split(start)
    kappa = free_stiffness(problem)
    A, B, _ = layout.blocks(kappa)
    locked_q, locked_p = layout.split(kappa @ start) if w.any() else (A @ v, B @ v)
    return layout.joined(-locked_q, np.abs(first[layout.gaps] + locked_p) - locked_p)


def slip_reach(problem: Problem, load_factor: float) -> FloatArray:
    """Slips that one load step could cause, node by node: the half-width of a box of initial states.

    Largest |q_w| + f |p_w| over the loop, by A_jj, (dn,) [length]; 0 where A_jj = 0.

    Examples
    --------
    >>> import shakedown
    >>> slip_reach(shakedown.example("two-node"), 0.7).round(3)
    array([1.546, 5.326])
    """
    q_w, p_w = loading(problem).at(load_factor)
    force = (problem.law.size(q_w) + problem.law.limit(np.abs(p_w))).max(axis=0).repeat(problem.directions)
    stiffness = np.diag(problem.A)
    return np.asarray(force / np.where(stiffness > 0, stiffness, np.inf))


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
    shift = problem.kappa[problem.layout.gaps].T @ g
    return replace(problem, **changed_loads(problem, lambda r: problem.layout.split(r - shift)))


def changed_loads(
    problem: Problem, change: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
) -> dict[str, Any]:
    """The fields of the loading where the reactions (…, (d + 1) n) of load steps become others, (q, p)."""
    found: dict[str, Any] = {}
    for keys in (("q_w", "p_w"), ("q_transient", "p_transient"), ("q_mean", "p_mean")):
        given = [getattr(problem, key) for key in keys]
        if given[0] is None and given[1] is None:
            continue
        if given[0] is None or given[1] is None:  # one mean alone
            given = [loading(problem).q0, loading(problem).p0]
        found |= zip(keys, change(problem.layout.joined(*given)), strict=True)
    return found


def no_mean(samples: FloatArray, mean: FloatArray) -> NDArray[np.bool_]:
    """The columns (k,) of samples (m, k) whose mean is nothing but the round-off of their sum."""
    return np.asarray(np.abs(mean) <= MEAN_ROUND_OFF * np.abs(samples).max(axis=0))


def _mean(samples: FloatArray, given: FloatArray | None) -> FloatArray:
    if given is not None:
        return given
    mean = samples.mean(axis=0)
    return np.where(no_mean(samples, mean), 0.0, mean)


def _cleaned(samples: FloatArray, mean: FloatArray) -> FloatArray:
    """samples − mean, with the round-off of the mean of a constant column set to exact zero."""
    periodic = samples - mean
    size = np.maximum(np.abs(samples).max(axis=0), np.abs(mean))
    constant = np.abs(periodic).max(axis=0) <= MEAN_ROUND_OFF * size
    periodic[:, constant] = 0.0
    return periodic
