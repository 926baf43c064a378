"""A joint in units of its own, least pressures of admissible states, reactions about which loads swing."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import (
    ALTERNATIONS,
    CONVERGED,
    EPS,
    ERROR_FACTOR,
    ITERATIONS,
    NEGLIGIBLE,
    NEWTON_ROUNDS,
    ROUND_OFF,
    SWEEPS,
    THREE_DIGITS,
    FloatArray,
)
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import loading
from shakedown.joint.fields import is_definite
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips


@dataclass(frozen=True)
class ScaledJoint:
    """κ, friction and loads with slips and gaps of node i in units of ``lengths[i]``, a power of two.

    Reactions are generalised forces then, lengths[i] times those of the node: both sides of every
    friction limit have the same factor, and no result depends on it but by round-off.

    Attributes
    ----------
    law
        Coulomb's law, with the friction coefficients as they are.
    A, B : (dn, dn), (n, dn)
        Tangential stiffness and coupling.
    q0, p0, q1, p1
        Constant and periodic part of the loads, as :class:`~shakedown.joint.constraints.Loading`.
    lengths : (n,)
        Units of slip [length].
    motions : (dn, r)
        Z, the slips that change no reaction; 1 at ``pinned[k]`` and 0 at the other pinned ones [–].
    pinned
        As many slips as there are such motions.
    """

    law: Law
    A: FloatArray
    B: FloatArray
    q0: FloatArray
    p0: FloatArray
    q1: FloatArray
    p1: FloatArray
    lengths: FloatArray
    motions: FloatArray
    pinned: tuple[int, ...]

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return self.law.layout.n

    @property
    def d(self) -> int:
        """Tangential directions of a node, 1 or 2."""
        return self.law.d

    @property
    def f(self) -> FloatArray:
        """Friction coefficients, (n,)."""
        return np.asarray(self.law.f)

    @property
    def fB(self) -> FloatArray:
        """f B, (n, dn): how slips change the friction limits."""
        return np.asarray(self.f[:, None] * self.B)

    @property
    def stiffness(self) -> FloatArray:
        """What powers of two leave of the stiffness of every node, 0.5 to 2, or 1 where it has none: (n,)."""
        own = self.law.layout.by_node(np.diagonal(self.A)).max(axis=1)
        return np.where(own > 0, own, 1.0)

    @property
    def floats(self) -> bool:
        """Whether friction alone holds the body: some slips change no reaction."""
        return bool(self.motions.shape[1])

    def in_balance(self, reactions: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Reactions (dn,) of some slip, from their part at the slips that are not pinned; and their error.

        Such reactions have no resultant along a rigid motion, Zᵀ z = 0; their part may be anything.
        """
        found, pinned, kept = reactions.copy(), list(self.pinned), self.kept
        loose = np.zeros_like(found)
        found[pinned] = -reactions[kept] @ self.motions[kept]
        loose[pinned] = (len(kept) + 2) * EPS * (np.abs(reactions[kept]) @ np.abs(self.motions[kept]))
        return found, loose

    @cached_property
    def kept(self) -> NDArray[np.intp]:
        """The slips that there are and that are not pinned, by number."""
        return np.setdiff1d(np.arange(self.d * self.n), self.pinned)

    @cached_property
    def kept_stiffness(self) -> FloatArray:
        """A in the slips that are kept, (k, k)."""
        return self.A[np.ix_(self.kept, self.kept)]

    @cached_property
    def held(self) -> bool:
        """Whether A is positive definite in the slips that are kept, if any, clear of round-off."""
        A = self.kept_stiffness
        return bool(len(A)) and is_definite(A, 4 * len(A) * EPS * float(np.linalg.norm(A, 1)))

    @cached_property
    def inverse(self) -> NDArray[np.floating]:
        """That of A in the slips that are kept, (k, k)."""
        return np.linalg.inv(self.kept_stiffness)

    @cached_property
    def inverse_error(self) -> float:
        """α ≥ ‖I − A X‖ of this inverse X, round-off of the product included."""
        n, A, size = self.n, self.kept_stiffness, np.abs(self.inverse)
        off = np.abs(np.eye(len(A)) - A @ self.inverse) + (2 * n + 4) * EPS * (np.abs(A) @ size)
        return float(off.sum(axis=0).max(initial=0.0))

    @cached_property
    def pressures_by_forces(self) -> FloatArray:
        """B A⁻¹ in the slips that are kept, (n, k)."""
        return np.asarray(self.B[:, self.kept] @ self.inverse)

    def unscaled(self, reactions: FloatArray) -> FloatArray:
        """Reactions (dn,) in the units of the joint itself [force]."""
        return np.asarray(reactions / np.repeat(self.lengths, self.d))


@once_per_problem
def scaled_joint(problem: Problem) -> ScaledJoint:
    """The joint in units of its own; made once per problem."""
    stiffness = problem.layout.by_node(np.diagonal(problem.A)).max(axis=1)
    relative = np.ldexp(stiffness, -int(np.frexp(stiffness.max(initial=0.0))[1]))  # so that units cancel
    lengths = np.exp2(np.rint(-0.5 * np.log2(np.where(stiffness > 0, relative, 1.0))))
    both, loop, rigid = np.repeat(lengths, problem.directions), loading(problem), rigid_slips(problem)
    return ScaledJoint(
        law=problem.law,
        A=problem.A * both * both[:, None],
        B=problem.B * both * lengths[:, None],
        q0=loop.q0 * both,
        p0=loop.p0 * lengths,
        q1=loop.q1 * both,
        p1=loop.p1 * lengths,
        lengths=lengths,
        motions=rigid.motions / both[:, None] * both[list(rigid.pinned)],
        pinned=rigid.pinned,
    )


TRIES = 4  # to exceed their round-off


@dataclass(frozen=True)
class LeastPressures:
    """Lower bounds of the pressures p_i of all nodes, for every load (docs/universal.md, Lemma 1).

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

    Y ← A⁻¹ (B_iᵀ − (f B)ᵀ|Y|), one product of matrices for all; where that does not converge, Newton's
    method. ``joint.A`` must be regular in the slips that are not pinned. Of a floating body Y is known up
    to rigid slips: it is zero at the pinned slips, to which ``rigid`` (n, dn), rigid slips, is added.
    """
    given = _Equations(joint, sign, np.zeros(joint.B.shape) if rigid is None else rigid)
    y = sign * joint.pressures_by_forces
    sizes = np.abs(y).max(axis=1, initial=0.0) + np.abs(given.rigid).max(axis=1, initial=0.0)
    excess = ROUND_OFF * max(1.0, joint.n / 4) * sizes  # of the weights of friction limits over multipliers
    for _ in range(TRIES):
        y, converged = _swept(given, excess, y)
        for i in np.flatnonzero(~converged).tolist():
            y[i] = _by_newton(given, i, excess[i], y[i])
        found = _solved(given, given.sizes(y, np.arange(joint.n)) + excess[:, None])
        if found.proved.all():
            break
        excess = np.where(found.proved, excess, np.maximum(4.0 * excess, ERROR_FACTOR * found.error))
    return found


def _swept(given: _Equations, excess: FloatArray, start: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The multipliers as far as sweeps bring them, and which of them have converged."""
    y, own = start.copy(), given.sign * given.joint.pressures_by_forces
    fB = given.joint.f[:, None] * given.joint.pressures_by_forces  # f B A⁻¹
    every = going = np.arange(len(y))
    size = np.abs(own).max(axis=1, initial=0.0)
    for _ in range(SWEEPS):
        new = own[going] - (given.sizes(y[going], going) + excess[going, None]) @ fB
        change = np.abs(new - y[going]).max(axis=1, initial=0.0)
        y[going] = new
        largest = np.abs(new).max(axis=1, initial=0.0)
        more = (change > CONVERGED * np.maximum(size[going], largest)) & (largest <= 1e6 * size[going])
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
        rest = given.sign * joint.B[node, joint.kept] - (given.sizes(y[None], one)[0] + excess) @ fB - y @ A
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
    wanted = given.sign * joint.B[:, joint.kept]
    right = wanted - h @ fB
    y = right @ X
    y = np.asarray(y + (right - y @ A) @ X)
    terms = np.abs(wanted) + np.abs(h) @ np.abs(fB) + np.abs(y) @ np.abs(A)
    rest = np.abs(right - y @ A) + (3 * n + 4) * EPS * terms
    largest = (rest @ np.abs(X)).max(axis=1, initial=0.0) * (1.0 + (2 * n + 4) * EPS)
    rigid = np.abs(given.rigid).max(axis=1, initial=0.0)
    error = 1.5 * largest / max(1.0 - alpha, EPS) + 8 * EPS * rigid  # of |Y_j|
    slack = h - (1.0 + 8 * EPS) * given.sizes(y, every)
    proved = np.all(slack >= error[:, None], axis=1) & np.all(np.isfinite(y), axis=1) & (alpha < 0.5)
    known = np.where(np.isfinite(error), error, 0.0)
    return LeastPressures(given.sign, given.multipliers(y, every), h, known, np.asarray(proved))


def pressures_of_floating(joint: ScaledJoint, *, sign: float = 1.0) -> LeastPressures:
    """The bounds p_i ≥ π_i of all nodes (``sign`` −1: −p_i ≥ −P_i) for every slip that friction admits.

    With Y any Y + Z c solves the equations of the multipliers as well, as neither A nor B know rigid slips
    (docs/universal.md, Theorem 7). The c of every node is chosen for the mean load; any is valid.
    """
    c = np.zeros((joint.n, joint.motions.shape[1]))
    for _ in range(ALTERNATIONS):
        given = _Equations(joint, sign, c @ joint.motions.T)
        swept = _swept(given, np.zeros(joint.n), sign * joint.pressures_by_forces)[0]
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
    # each about a digit nearer to the least weighted sum
    for _ in range(12):
        sizes = joint.law.size(Y + c @ Z.T)
        largest = sizes.max(axis=1, keepdims=True)
        weights = limits / np.maximum(sizes, np.where(largest > 0, NEGLIGIBLE * largest, 1.0))
        right = (np.repeat(weights, joint.d, axis=1) * Y + joint.q0) @ Z
        inverse = np.linalg.pinv((weights @ squares).reshape(-1, r, r), hermitian=True)
        c = -np.einsum("irs,is->ir", inverse, right)  # of motions that no weight tells of: none
    c[np.abs(Y).max(axis=1) == 0.0] = 0.0
    return c


@dataclass(frozen=True)
class SlipCurves:
    """The points g(u) u of some nodes, u being a direction in which the node slips (Theorem 4).

    With g(u) = size + lean · u a node that slips along u has g(u) p ≥ π. With one direction the curve is
    two points, with two a limaçon.

    Attributes
    ----------
    size : (k,)
        |1 − f h_i| [–].
    lean : (k, d)
        f Y_i, by the multipliers of the node itself [–].
    loose : (k,)
        How far off these numbers may be, together [–].
    """

    size: FloatArray
    lean: FloatArray
    loose: FloatArray

    @property
    def length(self) -> FloatArray:
        """|lean|, (k,)."""
        return np.asarray(np.linalg.norm(self.lean, axis=-1))

    def point(self, u: FloatArray) -> FloatArray:
        """g(u) u of unit vectors (…, k, d)."""
        return np.asarray((self.size + np.sum(self.lean * u, axis=-1))[..., None] * u)

    def reach(self, y: FloatArray) -> FloatArray:
        """The largest y · t over the points t of every curve, of vectors (…, k, d): (…, k).

        With two directions the largest g(u) u · y is the least value, over ν > 0, of
        |y| (ν + c cos²ψ + γ² cos²ψ / 4ν + γ² sin²ψ / 4(ν + c)), where γ is the size, c = |lean| and
        2ψ the angle between lean and y (the dual of a quadratic form on the unit circle). Every ν is a bound.
        """
        if self.lean.shape[-1] == 1:
            return np.asarray(self.size * np.abs(y[..., 0]) + self.lean[:, 0] * y[..., 0])
        angle, along, across, nu = self._dual(y)
        beside = nu + self.length
        largest = self.length * np.cos(angle) ** 2 + nu + along**2 / nu + across**2 / beside
        return np.asarray(np.hypot(y[..., 0], y[..., 1]) * largest)

    def farthest(self, y: FloatArray) -> FloatArray:
        """The point t that :meth:`reach` reaches, (…, k, d)."""
        if self.lean.shape[-1] == 1:
            return self.point(np.where(y < 0, -1.0, 1.0))
        angle, _, across, nu = self._dual(y)
        beyond = np.arcsin(np.clip(across / (nu + self.length), -1.0, 1.0))
        return self.point(_unit(np.arctan2(y[..., 1], y[..., 0]) - angle + beyond))

    def around(self) -> FloatArray:
        """d + 1 points of every curve with the origin between them, (d + 1, k, d)."""
        if self.lean.shape[-1] == 1:
            return self.point(np.tile([[[1.0]], [[-1.0]]], (1, len(self.size), 1)))
        along = np.arctan2(self.lean[:, 1], self.lean[:, 0])
        aside = np.arccos(-np.minimum(0.5, 0.5 * self.size / np.maximum(self.length, 0.5 * self.size)))
        return self.point(_unit(np.stack([along, along + aside, along - aside])))

    def _dual(self, y: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """ψ, γ cos ψ / 2, γ sin ψ / 2 and the best ν, each (…, k): where both terms' slopes add to 1."""
        x, length = self.lean, self.length
        angle = 0.5 * np.arctan2(x[:, 0] * y[..., 1] - x[:, 1] * y[..., 0], np.sum(x * y, axis=-1))
        along, across = 0.5 * self.size * np.cos(angle), 0.5 * self.size * np.sin(angle)
        least = np.maximum(np.maximum(along, np.abs(across) - length), ROUND_OFF * self.size)
        nu = least
        for _ in range(NEWTON_ROUNDS):
            first, second = along / nu, across / (nu + length)
            square = first**2 + second**2
            slope = first**2 / nu + second**2 / (nu + length)
            before, nu = nu, np.maximum(nu + square * (np.sqrt(square) - 1.0) / slope, least)
            if (np.abs(nu - before) <= NEGLIGIBLE * nu).all():
                break
        return angle, along, across, nu


def slip_curves(joint: ScaledJoint, least: LeastPressures) -> SlipCurves:
    """The curves of all nodes; circles |t| = 1 (Corollary 3) where a curve nearly leaves the origin out."""
    every, f = np.arange(joint.n), joint.f
    lean = f[:, None] * least.multipliers.reshape(joint.n, joint.n, joint.d)[every, every]
    own = f * least.weights[every, every]
    size, long = np.abs(1.0 - own), np.linalg.norm(lean, axis=1)
    inside = size - long * (joint.d == 1) > THREE_DIGITS * (1.0 + long)
    return SlipCurves(
        size=np.where(inside, size, 1.0),
        lean=np.where(inside[:, None], lean, 0.0),
        loose=np.where(inside, f * least.error + 8 * EPS * (1.0 + own + long), 8 * EPS),
    )


def _unit(angle: FloatArray) -> FloatArray:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


@dataclass(frozen=True)
class NodeLoads:
    """The varying loads q¹ of some nodes over a period, and their least friction limits during it.

    Attributes
    ----------
    curves
        What slip in any direction asks of the reaction.
    path : (m, k, d)
        q¹ of these nodes at the load steps [force].
    growing : (m, k)
        f π¹ [force]: what the least friction limit grows by with the load factor.
    constant : (k,)
        f π⁰ > 0 under the mean load [force].
    """

    curves: SlipCurves
    path: FloatArray
    growing: FloatArray
    constant: FloatArray

    def needed(self, centre: FloatArray) -> FloatArray:
        """The 1/λ required for each load step, (m, k), by centres (k, d)."""
        return np.asarray((self.curves.reach(-(centre + self.path)) - self.growing) / self.constant)

    def needed_above(self, centre: FloatArray) -> FloatArray:
        """The largest of :meth:`needed`, rounded up by more than its round-off, (k,)."""
        size = np.abs(self.path).sum(axis=2) + np.abs(centre).sum(axis=1)
        loose = (self.curves.loose + 16 * EPS * (self.curves.size + self.curves.length)) * size
        worst = self.needed(centre) + (loose + 16 * EPS * np.abs(self.growing)) / self.constant
        most = worst.max(axis=0)
        return np.asarray(most + 8 * EPS * np.abs(most))

    def worst(self, centre: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where :meth:`needed` is largest: its value (k,), and the row t, f π⁰, t · q¹ + f π¹ (k, d + 2)."""
        needed, k = self.needed(centre), np.arange(len(centre))
        step = needed.argmax(axis=0)
        point = self.curves.farthest(-(centre + self.path[step, k]))
        right = np.sum(point * self.path[step, k], axis=1) + self.growing[step, k]
        return needed[step, k], np.column_stack([point, self.constant, right])

    def rows(self, points: FloatArray) -> FloatArray:
        """The rows of some points t (j, k, d) at their worst load steps, (k, j, d + 2)."""
        right = (np.einsum("mkd,jkd->jmk", self.path, points) + self.growing).min(axis=1)
        constant = np.broadcast_to(self.constant, right.shape)
        return np.concatenate([points, constant[..., None], right[..., None]], axis=2).swapaxes(0, 1)


def reaction_centres(node_loads: NodeLoads) -> tuple[FloatArray, FloatArray]:
    """Minimise over η the largest (reach of −(η + q¹_k) − f π¹_k) / (f π⁰), for all nodes at once.

    Returns an upper bound of this 1/λ (k,), and η (k, d): under the load factor λ the reaction A v* + q⁰ of
    the node is λ η [force].

    By the exchange algorithm (Remez; the dual simplex method, whose rows are tangents): d + 1 points of
    the curve hold a centre from all sides; the one in which it misses most takes the place of one of them.
    """
    k = len(node_loads.constant)
    loads = np.abs(node_loads.path).max(axis=(0, 2)) + np.abs(node_loads.growing).max(axis=0)
    round_off = 16 * EPS * loads / node_loads.constant  # the error of 1/λ due to round-off of loads
    basis = node_loads.rows(node_loads.curves.around())
    centre, below = _vertex(basis)
    best, above, going = centre.copy(), np.full(k, np.inf), np.ones(k, dtype=bool)
    for _ in range(ITERATIONS if k else 0):  # each exchanges one of d + 1 touching points: 10 to 40 are taken
        reached = node_loads.needed_above(centre)
        better = going & (reached < above)
        above[better], best[better] = reached[better], centre[better]
        needed, new = node_loads.worst(centre)
        found, regular = _exchanged(basis, new)
        open_yet = needed - below > np.maximum(ROUND_OFF * np.abs(needed), round_off)
        going &= open_yet & regular
        if not going.any():
            break
        basis[going] = found[going]
        centre, below = _vertex(basis)
    return above, best


def _vertex(basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Centre and 1/λ where the rows t · η + f π⁰ / λ + (t · q¹ + f π¹) ≥ 0 meet."""
    found = np.linalg.solve(basis[..., :-1], -basis[..., -1:])[..., 0]
    return np.asarray(found[:, :-1]), np.asarray(found[:, -1])


def _exchanged(basis: FloatArray, new: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """The bases with the new row in place of the one whose weight vanishes first, and which are regular."""
    columns, row = basis[..., :-1].swapaxes(1, 2), new[:, :-1]
    weighed = np.zeros_like(row)
    weighed[:, -1] = 1.0
    weights, change = np.moveaxis(np.linalg.solve(columns, np.stack([weighed, row], axis=2)), 2, 0)
    changes = change > ROUND_OFF
    ratio = np.where(changes, np.maximum(weights, 0.0) / np.where(changes, change, 1.0), np.inf)
    leaving, found = ratio.argmin(axis=1), basis.copy()
    found[np.arange(len(found)), leaving] = new
    regular = np.abs(np.linalg.det(found[..., :-1])) > 4 * EPS * found[..., -2].max(axis=1)
    return found, regular & np.isfinite(ratio.min(axis=1))
