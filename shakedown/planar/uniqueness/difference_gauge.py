"""A measure of how far slips are apart that no slip can raise: for bodies that friction alone holds, too."""

from typing import NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips

SWEEPS = 400  # of the search for the scales, each four products of matrices
CLEARLY = 1e-9  # below 1, so that round-off decides nothing
LEAST = 1e-6  # scale of two nodes, relative to the largest


class DifferenceGauge(NamedTuple):
    """V(e) = max (e_i − e_j) / t_ij, and a number below 1 that relaxing any one node keeps it under.

    Attributes
    ----------
    scales : (n, n) or (n + 1, n + 1)
        t, 0 on the diagonal; the last node is the ground, e = 0, where something holds the body.
    ratio
        For every slip e with V(e) ≤ 1, if node i is set to where either of its limits is met, no
        difference to another node exceeds this share of its scale.
    """

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
    until it makes all of them smaller. None where it does not, where a node is at its own
    critical friction, and where a rigid slip leaves a node behind or there are two.

    Examples
    --------
    >>> import shakedown
    >>> difference_gauge(shakedown.example("two-node")).ratio < 1
    True
    >>> difference_gauge(shakedown.example("three-node")) is None
    True
    """
    weights = _weights(problem)
    if weights is None:
        return None
    n, nodes = problem.n, weights.shape[2]
    p, m = np.maximum(weights, 0.0), np.maximum(-weights, 0.0)
    total = p.sum(axis=2)
    apart, t = ~np.eye(nodes, dtype=bool), 1.0 - np.eye(nodes)
    if not np.all(total > 0.0):
        return None
    for _ in range(SWEEPS):
        new = np.zeros((nodes, nodes))
        new[:n] = _largest(p, m, total, t)
        new[:, :n] = np.maximum(new[:, :n], _largest(p, m, total, t.T).T)
        ratio = float((new[apart] / t[apart]).max())
        if ratio < 1.0 - CLEARLY:
            return DifferenceGauge(t, ratio)
        t = np.where(apart, np.maximum(new / new[apart].max(), LEAST), 0.0)
    return None


def _largest(p: FloatArray, m: FloatArray, total: FloatArray, t: FloatArray) -> FloatArray:
    """How far above node j node i comes at most when it is relaxed, on either side (n, nodes)."""
    above = p @ t
    offset = np.einsum("sik,sik->si", m, above)
    return np.asarray(((above + offset[:, :, None]) / total[:, :, None]).max(axis=0))


def _weights(problem: Problem) -> FloatArray | None:
    """c of both limits of every node, in units in which a rigid slip is 1 everywhere; the ground last."""
    A, fB, rigid = problem.A, problem.law.limit_rows(problem.B), rigid_slips(problem)
    floats = rigid.motions.shape[1]
    if floats:
        z = rigid.motions[:, 0]
        if floats > 1 or not np.all(z) or rigid.doubt:
            return None
        A, fB = A * z * z[:, None], fB * z * np.abs(z)[:, None]
    sides = np.stack([A - fB, A + fB])
    own = np.diagonal(sides, axis1=1, axis2=2)
    if not np.all(own > 0.0):
        return None
    weights = -sides / own[:, :, None]
    weights[:, np.arange(problem.n), np.arange(problem.n)] = 0.0
    ground = (1.0 - weights.sum(axis=2))[:, :, None]
    return np.asarray(weights if floats else np.concatenate([weights, ground], axis=2))
