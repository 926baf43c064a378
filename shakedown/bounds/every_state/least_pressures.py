"""Lower bounds of the pressure of closed nodes over all admissible slips, by duality, without programs."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import (
    ALTERNATIONS,
    EPS,
    ITERATIONS,
    MISJUDGED,
    NEGLIGIBLE,
    ROUND_OFF,
    SETTLED,
    SWEEPS,
)

TRIES = 4  # to exceed their round-off
WEIGHTINGS = 12  # reweightings of the nodes, each about a digit nearer to the least weighted sum


@dataclass(frozen=True)
class LeastPressures:
    """Lower bounds of the pressures p_i of all nodes, for every load (docs/universal.md, statement 6.1).

    With multipliers Y and weights h of a node, A Y + (f B)ᵀ h = B_iᵀ and h_j ≥ |Y_j|, every slip that is
    admissible under a load has

        p_i  ≥  p_w,i − Σ_j (f_j h_j p_w,j + Y_j · q_w,j).

    Attributes
    ----------
    sign
        1, or −1 of the largest pressures: then B_i is −B_i, and the bounds are those of −p_i.
    multipliers : (n, dn)
        Y [–], of every node i; of a floating body one of many, which rigid slips tell apart.
    weights : (n, n)
        h, larger than they need be by more than the round-off in Y.
    error : (n,)
        How far any |Y_j| may be from that of the exact solution Y of the equation with these weights.
    proved : (n,)
        Whether h_j ≥ |Y_j| for that exact solution; where not, the bounds are −inf.
    """

    sign: float
    multipliers: FloatArray
    weights: FloatArray
    error: FloatArray
    proved: NDArray[np.bool_]

    def at(self, joint: ScaledJoint, q: FloatArray, p: FloatArray) -> FloatArray:
        """The bounds under loads (m, dn) and (m, n), or their parts, less all round-off: (m, n) [force].

        They are linear in the load: a bound at r⁰ + λ r¹ is that at r⁰ and λ times that at r¹.
        """
        limit = joint.f * p
        found = self.sign * p - limit @ self.weights.T - q @ self.multipliers.T
        terms = np.abs(p) + np.abs(limit) @ np.abs(self.weights).T + np.abs(q) @ np.abs(self.multipliers).T
        loose = (3 * joint.n + 4) * EPS * terms + np.abs(q).sum(axis=1)[:, None] * self.error
        return np.where(self.proved, found - loose, -np.inf)


@dataclass(frozen=True)
class _Equations:
    """A y + (f B)ᵀ h = ± B_iᵀ for all nodes, in the slips that are not pinned; Y is y and a rigid slip."""

    joint: ScaledJoint
    sign: float
    rigid: FloatArray

    @property
    def right(self) -> FloatArray:
        """± B_i, (n, k)."""
        return np.asarray(self.sign * self.joint.B[:, self.joint.kept])

    @property
    def without_friction(self) -> FloatArray:
        """y for f = 0, (n, k)."""
        return np.asarray(self.sign * self.joint.pressures_by_forces)

    def multipliers(self, y: FloatArray, nodes: NDArray[np.intp]) -> FloatArray:
        """Y of some nodes (c, dn)."""
        Y = self.rigid[nodes]
        Y[:, self.joint.kept] += y
        return Y

    def sizes(self, y: FloatArray, nodes: NDArray[np.intp]) -> FloatArray:
        """|Y_j| of some nodes (c, n)."""
        return self.joint.law.size(self.multipliers(y, nodes))


def least_pressures(
    joint: ScaledJoint, *, rigid: FloatArray | None = None, sign: float = 1.0
) -> LeastPressures:
    """Solve A Y + (f B)ᵀ|Y| = B_iᵀ for all nodes at once, and bound what round-off leaves.

    Y ← A⁻¹ (B_iᵀ − (f B)ᵀ|Y|), one product of matrices for all; where that does not settle, Newton's
    method. ``joint.A`` must be regular in the slips that are not pinned. Of a floating body Y is known up
    to rigid slips: it is zero at the pinned slips, to which ``rigid`` (n, dn), rigid slips, is added.
    """
    given = _Equations(joint, sign, np.zeros(joint.B.shape) if rigid is None else rigid)
    y = given.without_friction
    sizes = np.abs(y).max(axis=1, initial=0.0) + np.abs(given.rigid).max(axis=1, initial=0.0)
    excess = ROUND_OFF * max(1.0, joint.n / 4) * sizes  # of the weights of friction limits over multipliers
    for _ in range(TRIES):
        y, settled = _swept(given, excess, y)
        for i in np.flatnonzero(~settled).tolist():
            y[i] = _by_newton(given, i, excess[i], y[i])
        found = _solved(given, given.sizes(y, np.arange(joint.n)) + excess[:, None])
        if found.proved.all():
            break
        excess = np.where(found.proved, excess, np.maximum(4.0 * excess, MISJUDGED * found.error))
    return found


def _swept(given: _Equations, excess: FloatArray, start: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The multipliers as far as sweeps bring them, and which of them have settled."""
    y, own = start.copy(), given.without_friction
    fB = given.joint.f[:, None] * given.joint.pressures_by_forces  # f B A⁻¹
    every = going = np.arange(len(y))
    size = np.abs(own).max(axis=1, initial=0.0)
    for _ in range(SWEEPS):
        new = own[going] - (given.sizes(y[going], going) + excess[going, None]) @ fB
        change = np.abs(new - y[going]).max(axis=1, initial=0.0)
        y[going] = new
        largest = np.abs(new).max(axis=1, initial=0.0)
        more = (change > SETTLED * np.maximum(size[going], largest)) & (largest <= 1e6 * size[going])
        if not more.any():
            break
        going = going[more]
    again = own - (given.sizes(y, every) + excess[:, None]) @ fB
    return y, np.asarray(np.abs(again - y).max(axis=1, initial=0.0) <= 0.1 * excess)


def _by_newton(given: _Equations, node: int, excess: float, start: FloatArray) -> FloatArray:
    """The multipliers of one node by Newton's method, from zero; the best that it meets."""
    joint, one = given.joint, np.array([node])
    A, fB, every = joint.kept_stiffness, joint.fB[:, joint.kept], np.arange(joint.n)
    y, best, least = np.zeros_like(start), start, np.inf
    for _ in range(ITERATIONS):
        rest = given.right[node] - (given.sizes(y[None], one)[0] + excess) @ fB - y @ A
        if (size := float(np.abs(rest).max())) < least:
            best, least = y.copy(), size
        slopes = np.zeros((joint.n, joint.n, joint.d))  # of |Y_j| in Y
        slopes[every, every] = -joint.law.layout.by_node(joint.law.direction(given.multipliers(y, one)[0]))
        try:
            y = y + np.linalg.solve(A + fB.T @ slopes.reshape(joint.n, -1)[:, joint.kept], rest)
        except np.linalg.LinAlgError:
            break
    return best


def _solved(given: _Equations, h: FloatArray) -> LeastPressures:
    """The multipliers that belong to given weights; not proved where the weights are too small.

    With X ≈ A⁻¹ and ‖I − A X‖ ≤ α < 1 the error r A⁻¹ of a residual r is at most ‖r X‖ / (1 − α).
    """
    joint, every, n = given.joint, np.arange(len(h)), len(h)
    A, X, fB, alpha = joint.kept_stiffness, joint.inverse, joint.fB[:, joint.kept], joint.inverse_error
    right = given.right - h @ fB
    y = right @ X
    y = np.asarray(y + (right - y @ A) @ X)
    terms = np.abs(given.right) + np.abs(h) @ np.abs(fB) + np.abs(y) @ np.abs(A)
    rest = np.abs(right - y @ A) + (3 * n + 4) * EPS * terms
    largest = (rest @ np.abs(X)).max(axis=1, initial=0.0) * (1.0 + (2 * n + 4) * EPS)
    error = 1.5 * largest / max(1.0 - alpha, EPS) + 8 * EPS * np.abs(given.rigid).max(
        axis=1, initial=0.0
    )  # of |Y_j|
    slack = h - (1.0 + 8 * EPS) * given.sizes(y, every)
    proved = np.all(slack >= error[:, None], axis=1) & np.all(np.isfinite(y), axis=1) & (alpha < 0.5)
    known = np.where(np.isfinite(error), error, 0.0)
    return LeastPressures(given.sign, given.multipliers(y, every), h, known, np.asarray(proved))


def pressures_of_floating(joint: ScaledJoint, *, sign: float = 1.0) -> LeastPressures:
    """The bounds p_i ≥ π_i of all nodes (``sign`` −1: −p_i ≥ −P_i) for every slip that friction admits.

    With Y any Y + Z c solves the equations of the multipliers as well, as neither A nor B know rigid slips
    (docs/universal.md, statement 6.7). The c of every node is chosen for the mean load; any is valid.
    """
    c = np.zeros((joint.n, joint.motions.shape[1]))
    for _ in range(ALTERNATIONS):
        given = _Equations(joint, sign, c @ joint.motions.T)
        swept = _swept(given, np.zeros(joint.n), given.without_friction)[0]
        c = c + _best_parts(joint, given.multipliers(swept, np.arange(joint.n)))
    return least_pressures(joint, rigid=c @ joint.motions.T, sign=sign)


def _best_parts(joint: ScaledJoint, Y: FloatArray) -> FloatArray:
    """The c (n, r) with the least Σ_j (f_j p_j |Y_j + Z_j c| + (Y_j + Z_j c) · q_j) under the mean load.

    By least squares again and again, with weights that make them the sum of the lengths.
    """
    n, Z = joint.n, joint.motions
    r = Z.shape[1]
    by_node = Z.reshape(n, joint.d, r)
    squares = np.einsum("jar,jas->jrs", by_node, by_node).reshape(n, r * r)
    limits = np.maximum(joint.f * joint.p0, NEGLIGIBLE * np.abs(joint.f * joint.p0).max())
    c = np.zeros((len(Y), r))
    if not limits.any():  # then no c costs less than another
        return c
    for _ in range(WEIGHTINGS):
        sizes = joint.law.size(Y + c @ Z.T)
        largest = sizes.max(axis=1, keepdims=True)
        weights = limits / np.maximum(sizes, np.where(largest > 0, NEGLIGIBLE * largest, 1.0))
        right = (np.repeat(weights, joint.d, axis=1) * Y + joint.q0) @ Z
        inverse = np.linalg.pinv((weights @ squares).reshape(-1, r, r), hermitian=True)
        c = -np.einsum("irs,is->ir", inverse, right)  # of motions that no weight tells of: none
    c[np.abs(Y).max(axis=1) == 0.0] = 0.0
    return c
