"""The nodes that the mean load opens: the contact zone from which a search for the best one starts."""

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem

PATIENCE = 10  # simultaneous changes allowed without reducing the number of nodes on the wrong side
ALONE = 4  # single changes per node after which the search ends

Mask = NDArray[np.bool_]


def opened_by_mean_load(problem: Problem, *, friction: bool = True) -> tuple[int, ...]:
    """The nodes that open under the mean load, closed ones not slipping, or sliding without friction.

    All nodes that pull or overlap change sides at once, as long as they become fewer; then the last of
    them alone (block principal pivoting, J. J. Júdice and F. M. Pires, Comput. Oper. Res. 21, 1994, 587).
    Without friction that ends in the solution, which is one only; with stuck nodes there may be none or many.
    None opens without C.

    Examples
    --------
    >>> import shakedown
    >>> opened_by_mean_load(shakedown.example("receding-block"), friction=False)[:3]
    (0, 1, 2)
    """
    if problem.C is None:
        return ()
    is_open, best = np.zeros(problem.n, dtype=bool), problem.n + 1
    patience, alone = PATIENCE, ALONE * problem.n
    while (wrong := _on_the_wrong_side(problem, is_open, friction)).any() and alone:
        if wrong.sum() < best:
            best, patience = int(wrong.sum()), PATIENCE
        elif patience:
            patience -= 1
        else:
            wrong[: np.flatnonzero(wrong)[-1]] = False
            alone -= 1
        is_open ^= wrong
    return tuple(int(i) for i in np.flatnonzero(is_open))


def _on_the_wrong_side(problem: Problem, is_open: Mask, friction: bool) -> Mask:
    """Closed nodes that pull and open ones that overlap, with these open under the mean load, (n,)."""
    kappa, layout, loop = problem.kappa, problem.layout, loading(problem)
    r_w, gaps = layout.joined(loop.q0, loop.p0), layout.gaps
    free = np.flatnonzero(layout.joined(np.repeat(is_open | (not friction), layout.d), is_open))
    u = layout.zeros()
    u[free] = _equilibrium(kappa[np.ix_(free, free)], -r_w[free])
    p = r_w[gaps] + kappa[gaps] @ u
    noise = np.abs(r_w[gaps]) + np.abs(kappa[gaps]) @ np.abs(u)
    return np.where(is_open, u[gaps] < 0, p < -8 * problem.n * np.finfo(float).eps * noise)


def _equilibrium(stiffness: FloatArray, force: FloatArray) -> FloatArray:
    """Displacements under a force; the smallest ones where a rigid motion leaves them open."""
    try:
        u = np.linalg.solve(stiffness, force)
    except np.linalg.LinAlgError:
        u = np.full(len(force), np.inf)
    with np.errstate(invalid="ignore"):
        left = np.abs(stiffness @ u - force).max(initial=0.0)
    if left <= NEGLIGIBLE * np.abs(force).max(initial=0.0):
        return np.asarray(u)
    return np.asarray(np.linalg.lstsq(stiffness, force, rcond=None)[0])
