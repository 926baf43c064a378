"""Lower bounds of the pressure of closed nodes over all admissible slips, by duality, without programs."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.scaled_joint import ScaledJoint
from shakedown.bounds.every_state.sectors import Sectors, every_direction
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
    """Lower bounds of the pressures p_i of nodes that slip in given sectors, for every load.

    With multipliers Y and weights h, A Y + (f B)ᵀ h = B_iᵀ and h_j ≥ |Y_j| (of the node that slips: the
    reach of Y_i in its sector), every slip that is admissible under a load has

        p_i  ≥  p_w,i − Σ_j (f_j h_j p_w,j + Y_j · q_w,j).

    Attributes
    ----------
    sectors
        Which node slips in which directions.
    sign
        1, or −1 of the largest pressures: then B_i is −B_i, and the bounds are those of −p_i.
    multipliers : (c, 2n)
        Y [–]; of a floating body one of many, which rigid slips tell apart.
    weights : (c, n)
        h, larger than they need be by more than the round-off in Y.
    error : (c,)
        How far any |Y_j| may be from that of the exact solution Y of the equation with these weights.
    proved : (c,)
        Whether h_j ≥ |Y_j| for that exact solution; where not, the bounds are −inf.
    """

    sectors: Sectors
    sign: float
    multipliers: FloatArray
    weights: FloatArray
    error: FloatArray
    proved: NDArray[np.bool_]

    def at(self, joint: ScaledJoint, q: FloatArray, p: FloatArray) -> FloatArray:
        """The bounds under loads (m, 2n) and (m, n), or their parts, less all round-off: (m, c) [force].

        They are linear in the load: a bound at r⁰ + λ r¹ is that at r⁰ and λ times that at r¹.
        """
        limit, own = joint.f * p, self.sign * p[:, self.sectors.node]
        found = own - limit @ self.weights.T - q @ self.multipliers.T
        terms = np.abs(own) + np.abs(limit) @ np.abs(self.weights).T + np.abs(q) @ np.abs(self.multipliers).T
        loose = (3 * joint.n + 4) * EPS * terms + np.abs(q).sum(axis=1)[:, None] * self.error
        return np.where(self.proved, found - loose, -np.inf)


@dataclass(frozen=True)
class _Equations:
    """A y + (f B)ᵀ h = ± B_iᵀ for all sectors, in the slips that are not pinned; Y is y and a shift.

    ``others`` is f B A⁻¹, ``inverse_error`` that of A⁻¹.
    """

    A: FloatArray
    inverse: NDArray[np.floating]
    inverse_error: float
    fB: FloatArray
    others: FloatArray
    right: FloatArray
    kept: NDArray[np.intp]
    shift: FloatArray
    sectors: Sectors

    def part(self, columns: NDArray[np.intp]) -> "_Equations":
        """Those of some sectors."""
        right, shift, sectors = self.right[columns], self.shift[columns], self.sectors.part(columns)
        return replace(self, right=right, shift=shift, sectors=sectors)

    def multipliers(self, y: FloatArray) -> FloatArray:
        """Y (c, 2n)."""
        Y = self.shift.copy()
        Y[:, self.kept] += y
        return Y

    def sizes(self, y: FloatArray) -> FloatArray:
        """|Y_j| (c, n), and of the node that slips the reach in its sector."""
        parts = self.multipliers(y).reshape(len(y), -1, 2)
        found = np.hypot(parts[..., 0], parts[..., 1])
        every = np.arange(len(y))
        found[every, self.sectors.node] = self.sectors.reach(parts[every, self.sectors.node])
        return np.asarray(found)


def least_pressures(
    joint: ScaledJoint, sectors: Sectors, *, shift: FloatArray | None = None, sign: float = 1.0
) -> LeastPressures:
    """Solve A Y + (f B)ᵀ|Y| = B_iᵀ for all sectors at once, and bound what round-off leaves.

    Y ← A⁻¹ (B_iᵀ − (f B)ᵀ|Y|), one product of matrices for all; where that does not settle, Newton's
    method. ``joint.A`` must be regular in the slips that are not pinned. Of a floating body Y is known up
    to rigid slips: it is zero at the pinned slips, to which ``shift`` (c, 2n), rigid slips, is added.
    """
    given, own = _equations(joint, sectors, shift, sign)
    size = np.abs(own).max(axis=1, initial=0.0)
    # the weights of the friction limits exceed the multipliers
    shifted = np.abs(given.shift).max(axis=1, initial=0.0)
    excess, y = ROUND_OFF * max(1.0, joint.n / 4) * (size + shifted), own
    for _ in range(TRIES):
        y, settled = _iterated(given, own, excess, y)
        for c in np.flatnonzero(~settled):
            y[c] = _by_newton(given.part(np.array([c])), excess[c], y[c])
        found = _solved(given, np.asarray(given.sizes(y) + excess[:, None]), sign)
        if found.proved.all():
            break
        excess = np.where(found.proved, excess, np.maximum(4.0 * excess, MISJUDGED * found.error))
    return found


def nearly_least(joint: ScaledJoint, sectors: Sectors, shift: FloatArray, sign: float) -> FloatArray:
    """Multipliers Y (c, 2n) as in :func:`least_pressures`, from sweeps only, without proof."""
    given, own = _equations(joint, sectors, shift, sign)
    return given.multipliers(_iterated(given, own, np.zeros(len(own)), own)[0])


def _equations(
    joint: ScaledJoint, sectors: Sectors, shift: FloatArray | None, sign: float
) -> tuple[_Equations, FloatArray]:
    """The equations, and their solution y without friction."""
    kept, node = joint.kept, sectors.node
    given = _Equations(
        A=joint.kept_stiffness,
        inverse=joint.inverse,
        inverse_error=joint.inverse_error,
        fB=joint.fB.take(kept, axis=1),
        others=joint.limits_by_forces,
        right=sign * joint.B.take(kept, axis=1)[node],
        kept=kept,
        shift=np.zeros((len(sectors), 2 * joint.n)) if shift is None else shift,
        sectors=sectors,
    )
    return given, np.asarray(sign * joint.pressures_by_forces[node])


def _solved(given: _Equations, h: FloatArray, sign: float) -> LeastPressures:
    """The multipliers that belong to given weights; not proved where the weights are too small."""
    y = (given.right - h @ given.fB) @ given.inverse
    y = np.asarray(y + (given.right - h @ given.fB - y @ given.A) @ given.inverse)
    error = _error(given, h, y) + 8 * EPS * np.abs(given.shift).max(axis=1, initial=0.0)
    slack = h - (1.0 + 8 * EPS) * given.sizes(y)
    proved = np.all(slack >= error[:, None], axis=1) & np.all(np.isfinite(y), axis=1)
    known = np.where(np.isfinite(error), error, 0.0)
    return LeastPressures(given.sectors, sign, given.multipliers(y), h, known, np.asarray(proved))


def _iterated(
    given: _Equations, own: FloatArray, excess: FloatArray, start: FloatArray
) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The multipliers as far as sweeps bring them, and which of them have settled."""
    y, going, others = start.copy(), np.arange(len(own)), given.others
    size = np.abs(own).max(axis=1, initial=0.0)
    for _ in range(SWEEPS):
        new = own[going] - (given.part(going).sizes(y[going]) + excess[going, None]) @ others
        change = np.abs(new - y[going]).max(axis=1, initial=0.0)
        y[going] = new
        bounded = np.abs(new).max(axis=1, initial=0.0) <= 1e6 * size[going]
        more = (change > SETTLED * np.maximum(size[going], np.abs(new).max(axis=1, initial=0.0))) & bounded
        if not more.any():
            break
        going = going[more]
    again = own - (given.sizes(y) + excess[:, None]) @ others
    return y, np.asarray(np.abs(again - y).max(axis=1, initial=0.0) <= 0.1 * excess)


def _by_newton(one: _Equations, excess: float, start: FloatArray) -> FloatArray:
    """The multipliers of one sector by Newton's method, from zero; the best that it meets."""
    n, right = len(one.fB), one.right[0]
    y, best, least = np.zeros_like(start), start, np.inf
    for _ in range(ITERATIONS):
        rest = right - (one.sizes(y[None])[0] + excess) @ one.fB - y @ one.A
        if (size := float(np.abs(rest).max())) < least:
            best, least = y.copy(), size
        slopes = np.zeros((n, 2 * n))
        places = np.arange(n)[:, None], np.arange(2 * n).reshape(n, 2)
        slopes[places] = _slopes(one.multipliers(y[None])[0], one.sectors)
        try:
            y = y + np.linalg.solve(one.A + one.fB.T @ slopes[:, one.kept], rest)
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


def _error(given: _Equations, h: FloatArray, y: FloatArray) -> FloatArray:
    """A bound on the distance of multipliers from the exact solution with these weights, (c,).

    With X ≈ A⁻¹ and ‖I − A X‖ ≤ α < 1 the error r A⁻¹ of a residual r is at most ‖r X‖ / (1 − α).
    """
    n, A, fB, right = len(given.fB), given.A, given.fB, given.right
    terms = np.abs(right) + np.abs(h) @ np.abs(fB) + np.abs(y) @ np.abs(A)
    rest = np.abs(right - h @ fB - y @ A) + (3 * n + 4) * EPS * terms
    size, alpha = np.abs(given.inverse), given.inverse_error
    if not alpha < 0.5:
        return np.full(len(y), np.inf)
    bound = (rest @ size).max(axis=1, initial=0.0) * (1.0 + (2 * n + 4) * EPS) / (1.0 - alpha)
    return np.asarray(1.5 * bound)  # |Y_j| of two components


def pressures_of_floating(joint: ScaledJoint, *, sign: float = 1.0) -> LeastPressures:
    """The bounds p_i ≥ π_i of all nodes (``sign`` −1: −p_i ≥ −P_i) for every slip that friction admits.

    With Y any Y + Z c solves the equations of the multipliers as well, as neither A nor B know rigid slips
    (docs/universal.md, statement 6.7). The c of every node is chosen for the mean load; any is valid.
    """
    directions = every_direction(np.arange(joint.n))
    c = np.zeros((joint.n, joint.motions.shape[1]))
    for _ in range(ALTERNATIONS):
        c = c + _best_parts(joint, nearly_least(joint, directions, c @ joint.motions.T, sign))
    return least_pressures(joint, directions, shift=c @ joint.motions.T, sign=sign)


def _best_parts(joint: ScaledJoint, Y: FloatArray) -> FloatArray:
    """The c (n, r) with the least Σ_j (f_j p_j |Y_j + Z_j c| + (Y_j + Z_j c) · q_j) under the mean load.

    By least squares again and again, with weights that make them the sum of the lengths.
    """
    n, Z = joint.n, joint.motions
    r = Z.shape[1]
    by_node = Z.reshape(n, 2, r)
    squares = np.einsum("jar,jas->jrs", by_node, by_node).reshape(n, r * r)
    limits = np.maximum(joint.f * joint.p0, NEGLIGIBLE * np.abs(joint.f * joint.p0).max())
    c = np.zeros((len(Y), r))
    if not limits.any():  # then no c costs less than another
        return c
    for _ in range(WEIGHTINGS):
        parts = (Y + c @ Z.T).reshape(len(Y), n, 2)
        sizes = np.hypot(parts[..., 0], parts[..., 1])
        largest = sizes.max(axis=1, keepdims=True)
        weights = limits / np.maximum(sizes, np.where(largest > 0, NEGLIGIBLE * largest, 1.0))
        right = (np.repeat(weights, 2, axis=1) * Y + joint.q0) @ Z
        inverse = np.linalg.pinv((weights @ squares).reshape(-1, r, r), hermitian=True)
        c = -np.einsum("irs,is->ir", inverse, right)  # of motions that no weight tells of: none
    c[np.abs(Y).max(axis=1) == 0.0] = 0.0
    return c
