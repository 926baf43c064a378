"""The limits that an energy ball must keep within, and the energy metric."""

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.constants import CONE, SIX_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import UsageError
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import Side, constraints, loading, through_transient, transient_path
from shakedown.joint.contact_zone import Zone
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import RigidSlips, rigid_slips
from shakedown.programs.program import power_of_two


@dataclass(frozen=True)
class EnergyMetric:
    """‖e‖_A = sqrt(eᵀ A e), the energy norm of a difference of slips; ½ ‖e‖²_A is its elastic energy.

    Directions of slip that cost no energy (rigid motions of a body that is held by the
    contact alone) have no length: the norm is that of the slips relative to the
    pinned nodes. A is divided by ``scale`` before anything is computed, so that a change of
    units by a power of two changes no other bit.

    Attributes
    ----------
    scale
        A power of two near the stiffness [force/length].
    root : (r, n)
        ‖e‖_A = unit · ‖root e‖, r the rank of A.
    inverse : (n, r)
        root · inverse = I: the slips of unit vectors, zero at pinned nodes [1].
    free : (n, n − r)
        Directions of slip without energy, the rigid slips first.
    stiffest
        Largest energy, doubled, of a slip of one node alone by a unit length [force/length].
    sizes : (n,)
        Size of a row of A against a slip of unit energy, to which what should vanish is compared.
    pinned
        The nodes at which rigid slips are pinned.
    """

    scale: float
    root: FloatArray
    inverse: FloatArray
    free: FloatArray
    stiffest: float
    sizes: FloatArray
    pinned: tuple[int, ...] = ()

    @property
    def unit(self) -> float:
        """The root of ``scale`` [√(force/length)]."""
        return float(np.sqrt(self.scale))

    def norm(self, difference: ArrayLike) -> FloatArray:
        """‖e‖_A of differences of slip (…, n) [√(force · length)]."""
        return np.asarray(self.unit * np.linalg.norm(np.asarray(difference) @ self.root.T, axis=-1))

    def relative_dual_norms(
        self, rows: FloatArray, sizes: FloatArray, tolerances: Tolerances, *, rigid: bool = True
    ) -> FloatArray:
        """Largest change of rows · e over all ‖root e‖ ≤ 1; inf where a free direction changes a row.

        Parameters
        ----------
        rows : (k, n)
            Linear functions of the slip [force/length].
        sizes : (k,)
            What the change along a free direction is compared to [force/length].
        rigid
            Whether rigid slips may change the rows: those of friction they do not, by their definition.
        """
        norms = np.linalg.norm(rows @ self.inverse, axis=1)
        free = self.free if rigid else self.free[:, len(self.pinned) :]
        leak = np.abs(rows @ free).max(axis=1, initial=0.0)
        return np.where(leak <= tolerances.zero_mode * np.maximum(sizes, norms), norms, np.inf)


def energy_metric(
    A: FloatArray, B: FloatArray, rigid: RigidSlips | None = None, *, tolerances: Tolerances = DEFAULT
) -> EnergyMetric:
    """The energy norm of a tangential stiffness A (n, n), with the coupling B (n, n) next to it.

    An eigenvalue of A that is zero to the tolerance counts as zero where slip in
    its direction changes no pressure either, as it must where κ ⪰ 0. Rigid slips, where they are
    known, are free by their definition, and the rest is the energy of the slips relative to the pinned nodes.

    Examples
    --------
    >>> metric = energy_metric(np.array([[4.0, 0.0], [0.0, 9.0]]), np.zeros((2, 2)))
    >>> metric.norm([[1.0, 0.0], [1.0, 1.0]]) ** 2
    array([ 4., 13.])
    """
    scale = power_of_two(float(np.diagonal(A).max()))
    lengths = np.array([1.0 / power_of_two(float(np.sqrt(a))) for a in np.diagonal(A) / scale])
    known = RigidSlips(np.zeros((len(A), 0)), ()) if rigid is None else rigid
    kept = np.setdiff1d(np.arange(len(A)), known.pinned)
    values, vectors = np.linalg.eigh((A / scale * lengths * lengths[:, None])[np.ix_(kept, kept)])
    directions = np.zeros((len(A), len(kept)))
    directions[kept] = lengths[kept, None] * vectors
    sizes = scale / lengths
    largest = float(values.max(initial=0.0))
    pressed = sizes.reshape(len(B), -1).max(axis=1)  # the largest of a node's directions
    leak = (np.abs(B @ directions) / pressed[:, None]).max(axis=0)
    soft = values <= tolerances.zero_mode * largest
    # round-off of an eigenvalue is this per node, relative to the largest
    free = soft & ((leak <= tolerances.zero_mode) | (values <= len(A) * 8 * np.finfo(float).eps * largest))
    lasting, nodes, d = np.sqrt(values[~free]), np.arange(len(B)), len(A) // len(B)
    root = np.zeros((len(lasting), len(A)))
    root[:, kept] = (vectors[:, ~free] * lasting).T / lengths[kept]
    root[:, list(known.pinned)] = -root @ known.motions
    return EnergyMetric(
        scale=scale,
        root=root,
        inverse=directions[:, ~free] / lasting,
        free=np.hstack([known.motions, directions[:, free]]),
        stiffest=float(np.linalg.eigvalsh(A.reshape(len(B), d, -1, d)[nodes, :, nodes, :]).max()),
        sizes=sizes,
        pinned=known.pinned,
    )


OWN = 32 * np.finfo(float).eps  # relative round-off of a pressure determined by its node's own reaction


class Rows(NamedTuple):
    """Rows G v + λ d + s R ≤ g, all of them forces.

    Attributes
    ----------
    G : (k, dn)
        Coefficients of the slip [force/length].
    slopes : (k, r)
        The same by unit vectors of the energy norm.
    d, g, spread : (k,)
        Coefficients of the load factor, right-hand sides, coefficients s of the radius.
    node, side : (k,)
        Node of every row, and its side; of gaps with two directions the load step.
    """

    G: FloatArray
    slopes: FloatArray
    d: FloatArray
    g: FloatArray
    spread: FloatArray
    node: IntArray
    side: IntArray

    def followed_by(self, others: "Rows") -> "Rows":
        """These rows and others."""
        return Rows(*(np.concatenate(both) for both in zip(self, others, strict=True)))


@dataclass(frozen=True, eq=False)
class BallLimits:
    """Discs a_i |q| + s_i R ≤ f_i p of nodes at load steps, and rows G v + λ d + s R ≤ g.

    With two directions every extreme load step of a node is a disc, (f p, q) = g − G_i v − λ d. Of the change
    of a pressure the ``share`` c_i is tied to the change of the node's own tangential reaction,
    a_i = √(1 + f_i² |c_i|²), and s_i = f_i γ_i(c_i) is the rest (docs/energy.md, eqs. 1 to 3). With one
    direction a disc is two rows, of which each has the best share that its side may have, and no factor.
    The rows of gaps that stay open are the last ones.

    Attributes
    ----------
    G : (n, 3, dn)
        Coefficients of the slip in the discs of every node; n = 0 with one direction [force/length].
    node, step : (K,)
        Node and load step of every disc, by node; steps of a transient before the period are negative.
    d, g : (K, 3)
        Coefficients of the load factor, and what the constant part leaves [force].
    f : (n,)
        Friction coefficients.
    share : (n, 2)
        c of every node [1].
    own : (n, 2)
        c at which γ is least, A_ii⁻¹ B_ii [1].
    least : (n,)
        That γ, against relative radii [force/length]; inf where nothing bounds a pressure.
    stiffness : (n, 2, 2)
        A_ii times ``metric.scale``, so that γ² adds up [(force/length)²].
    blocks
        G by unit vectors of the energy norm, (n, 3, r): the same for all shares, load factors and slips.
    rows
        The rows.
    gap_count
        How many of the rows are gaps.
    closed : (n,)
        The closed nodes by their numbers in the whole joint.
    metric
        The energy norm; radii are relative to ``metric.unit``.
    rigid
        The slips that change no frictional limit, and where they are pinned.
    """

    G: FloatArray
    blocks: FloatArray
    rows: Rows
    closed: IntArray
    metric: EnergyMetric
    rigid: RigidSlips
    node: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    step: IntArray = field(default_factory=lambda: np.zeros(0, dtype=np.intp))
    d: FloatArray = field(default_factory=partial(np.zeros, (0, CONE)))
    g: FloatArray = field(default_factory=partial(np.zeros, (0, CONE)))
    f: FloatArray = field(default_factory=partial(np.zeros, 0))
    share: FloatArray = field(default_factory=partial(np.zeros, (0, 2)))
    own: FloatArray = field(default_factory=partial(np.zeros, (0, 2)))
    least: FloatArray = field(default_factory=partial(np.zeros, 0))
    stiffness: FloatArray = field(default_factory=partial(np.zeros, (0, 2, 2)))
    gap_count: int = 0

    @property
    def n(self) -> int:
        """Number of slips."""
        return self.rows.G.shape[1]

    @cached_property
    def stretch(self) -> FloatArray:
        """a of every node, (n,)."""
        return np.sqrt(1.0 + self.f**2 * np.einsum("ij,ij->i", self.share, self.share))

    @cached_property
    def node_spread(self) -> FloatArray:
        """s of the discs of every node, (n,) [force/length]."""
        off = self.share - self.own
        return self.f * np.sqrt(self.least**2 + np.einsum("ij,ijk,ik->i", off, self.stiffness, off))

    @property
    def spread(self) -> FloatArray:
        """s of every disc and row, (K + k,) [force/length]."""
        return np.append(self.node_spread[self.node], self.rows.spread)

    @property
    def hold_below(self) -> bool:
        """Whether limits that hold at a load factor hold at every smaller one."""
        along = self.stretch[self.node] * np.hypot(self.d[:, 1], self.d[:, 2])
        return bool((self.d[:, 0] >= along).all() and (self.rows.d >= 0).all())

    def shared(self, share: FloatArray) -> "BallLimits":
        """The same limits with other shares."""
        return replace(self, share=share)

    def reactions(self, slip: FloatArray, load_factor: float) -> FloatArray:
        """(f p, q) of every disc, (K, 3) [force]."""
        return np.asarray(self.g - (self.G @ slip)[self.node] - load_factor * self.d)

    def slack(self, slip: FloatArray, load_factor: float, radius: float = 0.0) -> FloatArray:
        """Distance to the limit of every disc and row (K + k,), less what a relative radius needs [force]."""
        u = self.reactions(slip, load_factor)
        discs = u[:, 0] - self.stretch[self.node] * np.hypot(u[:, 1], u[:, 2])
        slack = np.append(discs, self.rows.g - self.rows.G @ slip - load_factor * self.rows.d)
        return slack - radius * self.spread if radius else slack

    def sizes(self, slip: FloatArray, load_factor: float, radius: float = 0.0) -> FloatArray:
        """The largest term of every disc and row, (K + k,) [force]; 1 where all are zero."""
        moved = (np.abs(self.G) @ np.abs(slip)).max(axis=1)[self.node]
        moved = np.append(moved, np.abs(self.rows.G) @ np.abs(slip))
        loads = np.append(np.abs(self.d).max(axis=1), np.abs(self.rows.d)) * abs(load_factor)
        left = np.append(np.abs(self.g).max(axis=1), np.abs(self.rows.g))
        need = radius * self.spread if radius else 0.0
        terms = np.maximum(np.maximum(moved, loads), np.maximum(left, need))
        return np.where(terms > 0, terms, 1.0)

    def relative_slack(self, slip: FloatArray, load_factor: float, radius: float = 0.0) -> FloatArray:
        """The slack of every disc and row, relative to its largest term, (K + k,)."""
        return self.slack(slip, load_factor, radius) / self.sizes(slip, load_factor, radius)

    def residual(self, slip: FloatArray, load_factor: float, radius: float) -> float:
        """The largest violation of a limit by a ball, relative to its terms."""
        return -float(np.min(self.relative_slack(slip, load_factor, radius)))

    def names(self, indices: IntArray) -> tuple[tuple[int, int], ...]:
        """(node, side) of some rows, (node, load step) of some discs, in order, each once."""
        node = np.append(self.closed[self.node], self.rows.node)
        side = np.append(self.step, self.rows.side)
        return tuple(dict.fromkeys((int(node[i]), int(side[i])) for i in sorted(indices)))


def ball_limits(zone: Zone, *, transient: bool = True, tolerances: Tolerances = DEFAULT) -> BallLimits:
    """The limits of the closed nodes, shares zero, and of every open node that it stays open.

    Within a ball of radius R about v* the gap of an open node i falls below that at v* by
    ‖∂w_i/∂v_K‖ R at most, the dual norm of its slope in the energy norm of the condensed
    joint; that much slack it needs.

    Parameters
    ----------
    zone
        The closed and the open nodes. The columns are the slips of the closed nodes.
    transient
        Whether the transient load steps, where the problem has them, are still to come. They are not scaled
        by the load factor.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown.joint.contact_zone import contact_zone
    >>> limits = ball_limits(contact_zone(shakedown.example("two-node"), [1]))
    >>> limits.rows.G.shape, limits.rows.node, limits.rows.side
    ((3, 1), array([0, 0, 1]), array([ 1, -1,  0]))
    >>> t = 2 * np.pi * np.arange(8)[:, None] / 8
    >>> joint = shakedown.Problem(
    ...     A=np.eye(2), B=[[0.5, 0.0]], f=0.4, q_w=np.hstack([np.cos(t), np.sin(t)]), p_w=3.0 + 0.0 * t
    ... )
    >>> limits = ball_limits(contact_zone(joint, ()))
    >>> limits.d.shape, limits.node_spread.round(3), limits.own
    ((8, 3), array([0.2]), array([[0.5, 0. ]]))
    """
    transient = transient and len(transient_path(zone.problem)) > 0
    known, which = _known_limits(zone.joint), (transient, tolerances)
    if which not in known:
        known[which] = _of_closed(zone.joint, transient, tolerances)
    limits = known[which]
    return _with_gaps(limits, zone, transient, tolerances) if zone.open_nodes else limits


@once_per_problem
def _known_limits(problem: Problem) -> dict[tuple[bool, Tolerances], BallLimits]:
    """Cached limits of one problem: each costs an eigenvalue problem and serves all load factors."""
    return {}


def _of_closed(problem: Problem, transient: bool, tolerances: Tolerances) -> BallLimits:
    rigid, slips = rigid_slips(problem), problem.layout.slip_size
    metric = energy_metric(problem.A, problem.B, rigid, tolerances=tolerances)
    if not metric.inverse.shape[1]:  # no slip stores energy: one zero direction is used
        nothing = np.zeros((1, slips))
        metric = replace(metric, root=nothing, inverse=nothing.T)
    closed = np.arange(problem.n)
    if problem.directions == 2:
        none, width = np.zeros((2, 0), dtype=np.intp), metric.inverse.shape[1]
        no_rows = Rows(np.zeros((0, slips)), np.zeros((0, width)), *np.zeros((3, 0)), *none)
        discs = _discs(problem, metric, transient, tolerances)
        return BallLimits(rows=no_rows, closed=closed, metric=metric, rigid=rigid, **discs)
    rows, no_disc = _rows(problem, metric, transient, tolerances), np.zeros((0, CONE, slips))
    return BallLimits(no_disc, no_disc @ metric.inverse, rows, closed, metric, rigid)


def _rows(problem: Problem, metric: EnergyMetric, transient: bool, tolerances: Tolerances) -> Rows:
    """The limits of a joint in the plane: two extremal rows a node, two more for its transient load steps."""
    found = through_transient(problem) if transient else constraints(problem)
    rows = np.flatnonzero(found.sided)
    spread = spreads(problem.A, problem.B, problem.f, metric, tolerances=tolerances).ravel()
    terms = problem.law.stiffness_terms(problem.A, problem.B)[: len(spread)]
    times = len(rows) // len(spread)
    G = cleaned(found.G[rows], np.tile(terms, (times, 1)))
    slopes, spread = G @ metric.inverse, np.tile(spread, times)
    return Rows(G, slopes, found.d[rows], found.g[rows], spread, found.node[rows], found.side[rows])


def spreads(
    A: FloatArray, B: FloatArray, f: FloatArray, metric: EnergyMetric, *, tolerances: Tolerances = DEFAULT
) -> FloatArray:
    """f γ of every node in the plane and side, (n, 2) [force/length]: what slip can do to a limit.

    The best share of a limit is B_ii / A_ii, which for the backward limit (column 0) must not
    exceed 1/f, and for the forward limit (column 1) not fall below −1/f.
    """
    law, least = Law(f), own_parts(A, B, metric, tolerances)[1]
    sides = np.repeat(law.limit(least)[:, None], 2, axis=1)
    for column, sign in enumerate((1.0, -1.0)):
        beyond = np.flatnonzero(sign * f * np.diagonal(B) > np.diagonal(A))  # above its own critical friction
        limit = law.limit_rows(B)[beyond] - sign * A[beyond]
        sizes = metric.sizes[beyond]
        sides[beyond, column] = metric.relative_dual_norms(limit, sizes, tolerances, rigid=False)
    return sides


def own_parts(
    A: FloatArray, B: FloatArray, metric: EnergyMetric, tolerances: Tolerances
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A_ii⁻¹ B_ii of every node (n, d), γ there (n,), and A_ii times ``metric.scale`` (n, d, d).

    Of the change B_i e of a pressure the part c (A e)_i is tied to the node's own tangential reaction;
    γ = max |(B_i − c A_i) e| over ‖e‖ ≤ 1 (in units of ``metric.unit``) is the rest.
    γ(c)² = γ² there + (c − c_i)ᵀ A_ii (c − c_i): a sum, so that nothing cancels.
    """
    n = len(B)
    d, at = len(A) // n, np.arange(n)
    rows, blocks = A.reshape(n, d, -1), A.reshape(n, d, n, d)[at, :, at, :]
    inverses = np.linalg.pinv(blocks, rcond=tolerances.zero_mode, hermitian=True)
    own = np.einsum("ijk,ik->ij", inverses, B.reshape(n, n, d)[at, at])
    rest = B - np.einsum("ij,ijk->ik", own, rows)
    terms = np.abs(B) + np.einsum("ij,ijk->ik", np.abs(own), np.abs(rows))
    rest = np.where(np.abs(rest) <= OWN * terms, 0.0, rest)
    sizes = metric.sizes.reshape(n, d).max(axis=1)
    least = metric.relative_dual_norms(rest, sizes, tolerances, rigid=False)
    return own, least, blocks * metric.scale


def _discs(problem: Problem, metric: EnergyMetric, transient: bool, tolerances: Tolerances) -> dict[str, Any]:
    """The limits of a joint in space: the discs of the load steps that matter."""
    law, loop, n = problem.law, loading(problem), problem.n
    # those that matter whatever the share: f |c| < 1, and so a < √2
    extreme_steps = Law(law.f / np.sqrt(2.0), 2).extreme_steps
    node, step = extreme_steps(loop.q1, loop.p1)
    d = law.of_nodes(law.load_terms(loop.q1, loop.p1))[step, node]
    g = law.of_nodes(law.cone(loop.q0, loop.p0))[node]
    if transient:
        before = transient_path(problem)
        parts = problem.layout.split(before)
        early, when = extreme_steps(*parts)
        g = np.vstack([g, law.of_nodes(law.cone(*parts))[when, early]])
        d = np.vstack([d, np.zeros((len(early), CONE))])
        node, step = np.append(node, early), np.append(step, when - len(before))
    order = np.argsort(node, kind="stable")
    own, least, stiffness = own_parts(problem.A, problem.B, metric, tolerances)
    G = np.moveaxis(law.of_nodes(law.stiffness(problem.A, problem.B).T), 0, -1)
    return {
        "G": G,
        "node": node[order],
        "step": step[order],
        "d": d[order],
        "g": g[order],
        "f": problem.f,
        "share": np.zeros((n, 2)),
        "own": own,
        "least": least,
        "stiffness": stiffness,
        "blocks": (G.reshape(CONE * n, -1) @ metric.inverse).reshape(n, CONE, -1),
    }


def _with_gaps(limits: BallLimits, zone: Zone, transient: bool, tolerances: Tolerances) -> BallLimits:
    """With the rows of the open nodes; a gap is multiplied by ``metric.scale``, so that it is a force."""
    whole, metric, layout = zone.constraints, limits.metric, zone.problem.layout
    gap, closed = whole.side == Side.GAP, np.array(zone.closed_nodes, dtype=np.intp)
    slope, d, g, node, force = whole.G[gap], whole.d[gap], whole.g[gap], whole.node[gap], metric.scale
    side = whole.step[gap] if layout.d > 1 else whole.side[gap]
    lengths, slopes = np.abs(slope) @ (force / metric.sizes), force * slope @ metric.inverse
    # inf where a rigid slip changes it
    spread = force * metric.relative_dual_norms(slope, lengths, tolerances)
    rows = Rows(force * slope, slopes, force * d, force * g, spread, node, side)
    if transient:
        before = transient_path(zone.problem)
        u = zone.displacements(np.zeros(slope.shape[1]), *layout.split(before))
        early = u[:, layout.gaps_of(node)]
        when = early.argmin(axis=0) - len(before) if layout.d > 1 else side
        rows = rows.followed_by(rows._replace(d=0.0 * d, g=force * early.min(axis=0), side=when))
    kept = limits.rows._replace(node=closed[limits.rows.node])
    return replace(limits, rows=kept.followed_by(rows), gap_count=len(rows.g), closed=closed)


def pressed_limits(limits: BallLimits, problem: Problem) -> BallLimits:
    """The same with every pressure positive within the ball, from λ = 0 on (docs/energy.md, Theorem 5).

    For the closed joint whose limits they are. Pressures are linear in λ, so the least of a node's load steps
    at λ and that of the constant part and of the transient suffice.
    """
    loop, slopes = loading(problem), -problem.B @ limits.metric.inverse
    spread = (1.0 + SIX_DIGITS) * np.linalg.norm(slopes, axis=1)  # strictly positive
    node, step = limits.closed, loop.p1.argmin(axis=0)
    rows = Rows(-problem.B, slopes, -loop.p1.min(axis=0), loop.p0, spread, node, step)
    _, before = problem.layout.split(transient_path(problem))
    constant = np.vstack([loop.p0, before]).min(axis=0)
    rows = rows.followed_by(rows._replace(d=0.0 * rows.d, g=constant, side=np.full(problem.n, -1)))
    return replace(limits, rows=rows.followed_by(limits.rows))


def without_margin(zone: Zone, limits: BallLimits) -> str:
    """Why no ball can exist whatever the load, in words; empty where one may.

    A frictionless node has no margin, and a pressure that changes under a slip that
    costs no energy has no bound within any ball.
    """
    frictionless = limits.closed[zone.joint.f == 0.0]
    if frictionless.size:
        return f"node {frictionless[0]} has no friction, and so no margin to a limit"
    unbounded = np.flatnonzero(np.isinf(limits.spread))
    if unbounded.size:
        first = unbounded[0]
        what = "pressure" if first < len(limits.spread) - limits.gap_count else "gap"
        return (
            f"node {limits.names(unbounded[:1])[0][0]}: a slip without tangential energy changes its {what} "
            "(with a normal stiffness added, kappa would not be positive semi-definite)"
        )
    return ""


def check_resolved(limits: BallLimits, slip: FloatArray, distance: float, tolerances: Tolerances) -> None:
    """Raise ``UsageError`` where a slip, or a distance around it, drowns the loads in its round-off."""
    rows = slice(len(limits.rows.g) - limits.gap_count)
    loads = _largest(limits.g, limits.rows.g[rows], limits.d, limits.rows.d[rows])
    most = tolerances.stored_digits / np.finfo(float).eps * loads
    G, around = (limits.G.reshape(-1, limits.n), limits.rows.G[rows]), 0.0
    with np.errstate(over="ignore"):
        locked = _largest(*(np.abs(part) @ np.abs(slip) for part in G))
        if distance > 0.0:
            steepest = _largest(*(np.linalg.norm(part @ limits.metric.inverse, axis=1) for part in G))
            around = steepest * distance / limits.metric.unit
    for name, found in (("initial slip", locked), ("distance", around)):
        if loads > 0 and found > most:
            raise UsageError(f"{name}: expected reactions below {most:.3g} from it, found {found:.3g}")


def _largest(*parts: FloatArray) -> float:
    return max(float(np.abs(part).max(initial=0.0)) for part in parts)


def cleaned(difference: FloatArray, terms: FloatArray) -> FloatArray:
    """A difference, with what is round-off of its terms set to exact zero."""
    return np.where(np.abs(difference) <= 4 * np.finfo(float).eps * terms, 0.0, difference)
