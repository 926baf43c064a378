"""A measure of the difference of slips that no slip can increase, also for bodies held by friction alone."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import ALL_PAIRS_UP_TO, NEGLIGIBLE, SIX_DIGITS, SWEEPS, FloatArray
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips


class DifferenceGauge(NamedTuple):
    """V(e) = max (x_a − x_b) / t_ab, and a number below 1 that relaxing any one node keeps it under.

    Attributes
    ----------
    compared : (N, n)
        x_a as a function of the slips e: slips, their negatives, and 0 for the ground.
    scales : (N, N)
        t, 0 on the diagonal.
    ratio
        For every slip e with V(e) ≤ 1, if node i is set to where either of its limits is met, no
        difference to another node exceeds this share of its scale.
    """

    compared: FloatArray
    scales: FloatArray
    ratio: float


@once_per_problem
def difference_gauge(problem: Problem) -> DifferenceGauge | None:
    """Scales t such that slip cannot raise V, if they are found; worked out once per problem.

    With e_j = c_i·e where a limit of node i is met, Σ_k c_ik = 1 (what is missing is the weight of the
    ground, and nothing is missing where the body floats), the negative weights m are set off against the
    positive ones p in equal shares:

        c_i·e − e_j = (Σ_l p_l (e_l − e_j) + Σ_kl m_k p_l (e_l − e_k)) / Σ p
                    ≤ (Σ_l p_l t_lj + Σ_kl m_k p_l t_lk) / Σ p.

    The largest of these on both sides, as new scales, is a monotone map of the old ones; it is iterated
    until it makes all of them smaller. A node counts the way it goes in the softest slip of the joint; of few
    nodes e_k is compared with −e_j as well, and c e_k = (−c)(−e_k) is taken for positive or negative row by
    row, whichever bounds less: which way tangents point is no matter. None where that does not end, where a
    node is at its own critical friction, and where a rigid slip leaves a node behind or there are two.

    Examples
    --------
    >>> import shakedown
    >>> difference_gauge(shakedown.example("two-node")).ratio < 1
    True
    >>> difference_gauge(shakedown.example("three-node")) is None
    True
    """
    known = _weights(problem)
    if known is None:
        return None
    weights, compared = known
    n, nodes = weights.shape[1:]
    if nodes > n and n <= ALL_PAIRS_UP_TO:  # each sweep takes n⁵ steps
        return _with_sums(weights[:, :, :n], np.vstack([compared[:n], -compared[:n], compared[n:]]))
    p, m = np.maximum(weights, 0.0), np.maximum(-weights, 0.0)
    total = p.sum(axis=2)
    if not np.all(total > 0.0):
        return None
    t = 1.0 - np.eye(nodes)
    for _ in range(SWEEPS):
        new = np.zeros((nodes, nodes))
        new[:n] = _largest(p, m, total, t)
        new[:, :n] = np.maximum(new[:, :n], _largest(p, m, total, t.T).T)
        least, ratio, smaller = _compared(new, t)
        if ratio < 1.0 - NEGLIGIBLE:
            return DifferenceGauge(compared, t, ratio)
        if least >= 1.0:
            return None
        t = smaller
    return None


def _compared(new: FloatArray, t: FloatArray) -> tuple[float, float, FloatArray]:
    """The least and the largest share of new scales in old ones, and the new ones relative to the largest."""
    apart = ~np.eye(len(t), dtype=bool)
    shares, largest = new[apart] / t[apart], new[apart].max()
    smaller = np.where(apart, np.maximum(new / (largest or 1.0), SIX_DIGITS), 0.0)
    return float(shares.min()), float(shares.max()), smaller


def _with_sums(weights: FloatArray, compared: FloatArray) -> DifferenceGauge | None:
    """The gauge that compares x = (e, −e, 0): t is symmetric, and the same for (e_i, e_j) and (−e_i, −e_j).

    ``weights`` (2, n, n): c. Of each row some terms are ``taken`` for negative, beside −x_a: the ground takes
    what is missing on either side.
    """
    n, nodes = weights.shape[1], len(compared)
    c = weights.reshape(-1, n)
    size = np.abs(c)
    place = np.where(c >= 0.0, 0, n) + np.arange(n)  # of |c| x
    opposite, own = np.append(np.roll(np.arange(2 * n), n), 2 * n), np.arange(n)
    taken = np.repeat(c[:, None] < 0.0, nodes, axis=1)
    t, unsettled = 1.0 - np.eye(nodes), True
    for _ in range(SWEEPS):
        bound = _set_off(size, taken, place, opposite, t)
        flips = [*(taken ^ (own == k) for k in own), ~taken] if unsettled else []
        unsettled = False
        for each in flips:
            other = _set_off(size, each, place, opposite, t)
            better = other < bound * (1.0 - NEGLIGIBLE)
            taken = np.where(better[:, :, None], each, taken)
            bound, unsettled = np.where(better, other, bound), unsettled or bool(better.any())
        bound = bound.reshape(2, n, nodes).max(axis=0)
        new = np.vstack([bound, bound[:, opposite], np.zeros((1, nodes))])
        new = np.maximum(new, new.T)
        new[own, n + own] = new[n + own, own] = 2.0 * new[own, -1]
        least, ratio, smaller = _compared(new, t)
        if ratio < 1.0 - NEGLIGIBLE:
            return DifferenceGauge(compared, t, ratio)
        if least >= 1.0 and not unsettled:
            return None
        t = smaller
    return None


def _largest(p: FloatArray, m: FloatArray, total: FloatArray, t: FloatArray) -> FloatArray:
    """How far above node j node i comes at most when it is relaxed, on either side (n, nodes)."""
    above = p @ t
    offset = np.einsum("sik,sik->si", m, above)
    return np.asarray(((above + offset[:, :, None]) / total[:, :, None]).max(axis=0))


def _set_off(
    size: FloatArray,
    taken: NDArray[np.bool_],
    place: NDArray[np.intp],
    opposite: NDArray[np.intp],
    t: FloatArray,
) -> FloatArray:
    """How far above each x_a a relaxed row comes at most (rows, N), with these terms taken for negative."""
    p, m = np.where(taken, 0.0, size[:, None]), np.where(taken, size[:, None], 0.0)
    ground = 1.0 + m.sum(axis=2) - p.sum(axis=2)  # its weight
    above, below = np.maximum(ground, 0.0), np.maximum(-ground, 0.0)
    to_ground = t[place, -1][:, None]
    sums = ((p @ t[place[:, :, None], opposite[place][:, None]]) * m).sum(axis=2)
    sums += (p * t[place].transpose(0, 2, 1)).sum(axis=2) + below * (p * to_ground).sum(axis=2)
    sums += above * ((m * to_ground).sum(axis=2) + t[-1])
    return np.asarray(sums / (p.sum(axis=2) + above))


def _weights(problem: Problem) -> tuple[FloatArray, FloatArray] | None:
    """c of both limits of every node, in units in which a rigid slip is 1 everywhere, and what it is about.

    The ground comes last. Where something holds the joint units are signs: those of its softest slip.
    """
    A, fB, rigid = problem.A, problem.law.limit_rows(problem.B), rigid_slips(problem)
    floats = rigid.motions.shape[1]
    z = rigid.motions[:, 0] if floats else _softest(A)
    if floats > 1 or not np.all(z) or rigid.doubt:
        return None
    A, fB = A * z * z[:, None], fB * z * np.abs(z)[:, None]
    sides = np.stack([A - fB, A + fB])
    own = np.diagonal(sides, axis1=1, axis2=2)
    if not np.all(own > 0.0):
        return None
    weights = -sides / own[:, :, None]
    weights[:, np.arange(problem.n), np.arange(problem.n)] = 0.0
    compared = np.diag(1.0 / z)
    if floats:
        return weights, compared
    ground = (1.0 - weights.sum(axis=2))[:, :, None]
    return np.concatenate([weights, ground], axis=2), np.vstack([compared, np.zeros(problem.n)])


def _softest(A: FloatArray) -> FloatArray:
    """The signs (n,) of the slip that meets least resistance, every node in units of its own."""
    size = np.sqrt(np.where(np.diag(A) > 0.0, np.diag(A), 1.0))
    return np.where(np.linalg.eigh(A / np.outer(size, size))[1][:, 0] < 0.0, -1.0, 1.0)
