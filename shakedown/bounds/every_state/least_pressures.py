"""What presses a closed node at least, over all admissible slips: by duality, without programs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.bounds.every_state.sectors import Sectors
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, ITERATIONS, ROUND_OFF, SETTLED, SWEEPS

TRIES, MORE = 4, 2.0  # to exceed the round-off in them; by so many times


@dataclass(frozen=True)
class LeastPressures:
    """Lower bounds of the pressures p_i of nodes that slip in given sectors, for every load.

    With multipliers Y and weights h, A Y + (f B)ᵀ h = B_iᵀ and h_j ≥ |Y_j| (of the node that slips: the
    reach of Y_i in its sector), every slip that is admissible under a load has

        p_i  ≥  p_w,i − Σ_j (f_j h_j p_w,j + Y_j · q_w,j).

    Attributes
    ----------
    sectors
        Which node slips in which directions.
    multipliers : (c, 2n)
        Y [–].
    weights : (c, n)
        h, larger than they need be by more than the round-off in Y.
    error : (c,)
        How far any |Y_j| may be from that of the exact solution Y of the equation with these weights.
    proved : (c,)
        Whether h_j ≥ |Y_j| for that exact solution; where not, the bounds are −inf.
    """

    sectors: Sectors
    multipliers: FloatArray
    weights: FloatArray
    error: FloatArray
    proved: NDArray[np.bool_]

    def at(self, joint: ScaledJoint, q: FloatArray, p: FloatArray) -> FloatArray:
        """The bounds under loads (m, 2n) and (m, n), or their parts, less all round-off: (m, c) [force].

        They are linear in the load: a bound at r⁰ + λ r¹ is that at r⁰ and λ times that at r¹.
        """
        limit, own = joint.f * p, p[:, self.sectors.node]
        found = own - limit @ self.weights.T - q @ self.multipliers.T
        terms = np.abs(own) + np.abs(limit) @ np.abs(self.weights).T + np.abs(q) @ np.abs(self.multipliers).T
        loose = (3 * joint.n + 4) * EPS * terms + np.abs(q).sum(axis=1)[:, None] * self.error
        return np.where(self.proved, found - loose, -np.inf)


def least_pressures(joint: ScaledJoint, sectors: Sectors) -> LeastPressures:
    """Solve A Y + (f B)ᵀ|Y| = B_iᵀ for all sectors at once, and bound what round-off leaves.

    Y ← A⁻¹ (B_iᵀ − (f B)ᵀ|Y|), one product of matrices for all; where that does not settle, Newton's
    method. ``joint.A`` must be regular.
    """
    inverse = np.linalg.inv(joint.A)
    own, others = (joint.B @ inverse)[sectors.node], joint.fB @ inverse
    size = np.abs(own).max(axis=1, initial=0.0)
    # the weights of the friction limits exceed the multipliers
    excess, Y = ROUND_OFF * max(1.0, joint.n / 4) * size, own
    for _ in range(TRIES):
        Y, settled = _iterated(own, others, excess, sectors, Y)
        for c in np.flatnonzero(~settled):
            Y[c] = _by_newton(joint, sectors, int(c), excess[c], Y[c])
        found = _solved(joint, inverse, sectors, np.asarray(_sizes(Y, sectors) + excess[:, None]))
        if found.proved.all():
            break
        excess = np.where(found.proved, excess, np.maximum(4.0 * excess, MORE * found.error))
    return found


def _solved(
    joint: ScaledJoint, inverse: NDArray[np.floating], sectors: Sectors, h: FloatArray
) -> LeastPressures:
    """The multipliers that belong to given weights; not proved where the weights are too small."""
    fB, right = joint.fB, joint.B[sectors.node]
    Y = (right - h @ fB) @ inverse
    Y = np.asarray(Y + (right - h @ fB - Y @ joint.A) @ inverse)
    error = _error(joint, inverse, right, h, Y)
    slack = h - (1.0 + 8 * EPS) * _sizes(Y, sectors)
    proved = np.all(slack >= error[:, None], axis=1) & np.all(np.isfinite(Y), axis=1)
    known = np.where(np.isfinite(error), error, 0.0)
    return LeastPressures(sectors, Y, h, known, np.asarray(proved))


def _iterated(
    own: FloatArray, others: FloatArray, excess: FloatArray, sectors: Sectors, start: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The multipliers as far as sweeps bring them, and which of them have settled."""
    Y, going = start.copy(), np.arange(len(own))
    size = np.abs(own).max(axis=1, initial=0.0)
    for _ in range(SWEEPS):
        part = Sectors(sectors.node[going], sectors.middle[going], sectors.half)
        new = own[going] - (_sizes(Y[going], part) + excess[going, None]) @ others
        change = np.abs(new - Y[going]).max(axis=1, initial=0.0)
        Y[going] = new
        bounded = np.abs(new).max(axis=1, initial=0.0) <= 1e6 * size[going]
        more = (change > SETTLED * np.maximum(size[going], np.abs(new).max(axis=1, initial=0.0))) & bounded
        if not more.any():
            return Y, _settled(own, others, excess, sectors, Y)
        going = going[more]
    return Y, _settled(own, others, excess, sectors, Y)


def _settled(
    own: FloatArray, others: FloatArray, excess: FloatArray, sectors: Sectors, Y: FloatArray
) -> NDArray[np.bool_]:
    """Which multipliers one more sweep changes by less than the excess."""
    again = own - (_sizes(Y, sectors) + excess[:, None]) @ others
    return np.asarray(np.abs(again - Y).max(axis=1, initial=0.0) <= 0.1 * excess)


def _by_newton(joint: ScaledJoint, sectors: Sectors, c: int, excess: float, start: FloatArray) -> FloatArray:
    """The multipliers of one sector by Newton's method, from zero; the best that it meets."""
    one = Sectors(sectors.node[[c]], sectors.middle[[c]], sectors.half)
    fB, right, n = joint.fB, joint.B[sectors.node[c]], joint.n
    Y, best, least = np.zeros_like(start), start, np.inf
    for _ in range(ITERATIONS):
        rest = right - (_sizes(Y[None], one)[0] + excess) @ fB - Y @ joint.A
        if (size := float(np.abs(rest).max())) < least:
            best, least = Y.copy(), size
        slopes = np.zeros((n, 2 * n))
        slopes[np.arange(n)[:, None], np.arange(2 * n).reshape(n, 2)] = _slopes(Y, one)
        try:
            Y = Y + np.linalg.solve(joint.A + fB.T @ slopes, rest)
        except np.linalg.LinAlgError:
            break
    return best


def _slopes(Y: FloatArray, one: Sectors) -> FloatArray:
    """The directions (n, 2) whose products with Y are its sizes."""
    parts = Y.reshape(-1, 2)
    size = np.hypot(parts[:, 0], parts[:, 1])[:, None]
    found = np.divide(parts, size, out=np.zeros_like(parts), where=size > 0)
    found[one.node[0]] = one.farthest(parts[[one.node[0]]])[0]
    return found


def _sizes(Y: FloatArray, sectors: Sectors) -> FloatArray:
    """|Y_j| (c, n), and of the node that slips the reach in its sector."""
    parts = Y.reshape(len(Y), -1, 2)
    found = np.hypot(parts[..., 0], parts[..., 1])
    every = np.arange(len(Y))
    found[every, sectors.node] = sectors.reach(parts[every, sectors.node])
    return np.asarray(found)


def _error(
    joint: ScaledJoint, inverse: NDArray[np.floating], right: FloatArray, h: FloatArray, Y: FloatArray
) -> FloatArray:
    """How far multipliers are at most from the exact solution with these weights, (c,).

    With X ≈ A⁻¹ and ‖I − A X‖ ≤ α < 1 the error r A⁻¹ of a residual r is at most ‖r X‖ / (1 − α).
    """
    n, fB = joint.n, joint.fB
    terms = np.abs(right) + np.abs(h) @ np.abs(fB) + np.abs(Y) @ np.abs(joint.A)
    rest = np.abs(right - h @ fB - Y @ joint.A) + (3 * n + 4) * EPS * terms
    size = np.abs(inverse)
    off = np.abs(np.eye(2 * n) - joint.A @ inverse) + (2 * n + 4) * EPS * (np.abs(joint.A) @ size)
    alpha = float(off.sum(axis=0).max(initial=0.0))
    if not alpha < 0.5:
        return np.full(len(Y), np.inf)
    bound = (rest @ size).max(axis=1, initial=0.0) * (1.0 + (2 * n + 4) * EPS) / (1.0 - alpha)
    return np.asarray(1.5 * bound)  # |Y_j| of two components
