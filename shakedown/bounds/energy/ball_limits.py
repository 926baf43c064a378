"""The frictional limits of joints in space with the slack that a ball of slips needs at each of them."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.energy.energy_metric import EnergyMetric, energy_metric
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import CONE
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import Side
from shakedown.joint.contact_zone import Zone
from shakedown.joint.derived import once_per_problem
from shakedown.joint.law import Law
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import RigidSlips, rigid_slips
from shakedown.programs.shared_blocks import SharedBlocks

Places = NDArray[np.intp]
OWN = 32 * np.finfo(float).eps  # relative round-off of a pressure determined by its node's own reaction


@dataclass(frozen=True, eq=False)
class DiscLimits:
    """a_i |q| + s_i R ≤ f_i p at every node and load step; rows a · v + λ d + s R ≤ g of gaps.

    (f p, q) = g − G_i v − λ d of a node i at a load step. Of the change of a pressure the ``share`` c_i is
    tied to the change of the node's own tangential reaction, a_i = √(1 + f_i² |c_i|²), and s_i = f_i γ_i(c_i)
    is the rest (docs/energy.md, section 8).

    Attributes
    ----------
    G : (n, 3, 2n)
        Coefficients of the slip in the discs of every node [force/length].
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
        A_ii times ``metric.unit``², so that γ² adds up [(force/length)²].
    gaps : (k, 2n)
        Coefficients of the slip in the rows of open nodes, as forces.
    gap_d, gap_g, gap_spread, gap_node, gap_step : (k,)
        Their other coefficients; the open nodes, and their extreme load steps.
    closed : (n,)
        The closed nodes by their numbers in the whole joint.
    metric
        The energy norm.
    rigid
        The slips that change no frictional limit, and where they are pinned.
    shared_blocks
        G by unit vectors of the energy norm, (n, 3, r): the same for all shares, load factors and slips.
    """

    G: FloatArray
    node: Places
    step: Places
    d: FloatArray
    g: FloatArray
    f: FloatArray
    share: FloatArray
    own: FloatArray
    least: FloatArray
    stiffness: FloatArray
    gaps: FloatArray
    gap_d: FloatArray
    gap_g: FloatArray
    gap_spread: FloatArray
    gap_node: Places
    gap_step: Places
    closed: Places
    metric: EnergyMetric
    rigid: RigidSlips
    shared_blocks: SharedBlocks

    @property
    def n(self) -> int:
        """Number of slips."""
        return self.G.shape[2]

    @cached_property
    def stretch(self) -> FloatArray:
        """a of every node, (n,)."""
        return np.sqrt(1.0 + self.f**2 * np.einsum("ij,ij->i", self.share, self.share))

    @cached_property
    def spread(self) -> FloatArray:
        """s of every node against relative radii, (n,) [force/length]."""
        off = self.share - self.own
        return self.f * np.sqrt(self.least**2 + np.einsum("ij,ijk,ik->i", off, self.stiffness, off))

    def shared(self, share: FloatArray) -> "DiscLimits":
        """The same limits with other shares."""
        return replace(self, share=share)

    def reactions(self, slip: FloatArray, load_factor: float) -> FloatArray:
        """(f p, q) of every disc, (K, 3) [force]."""
        return np.asarray(self.g - (self.G @ slip)[self.node] - load_factor * self.d)

    def slack(self, slip: FloatArray, load_factor: float, radius: float = 0.0) -> FloatArray:
        """Distance to the limit of every disc and gap (K + k,), less what a relative radius needs [force]."""
        u, node = self.reactions(slip, load_factor), self.node
        slack = u[:, 0] - self.stretch[node] * np.hypot(u[:, 1], u[:, 2])
        gap = self.gap_g - self.gaps @ slip - load_factor * self.gap_d
        need = 0.0 if radius == 0 else radius
        return np.append(slack - need * self.spread[node], gap - need * self.gap_spread)

    def sizes(self, slip: FloatArray, load_factor: float, radius: float = 0.0) -> FloatArray:
        """The largest term of every disc and gap, (K + k,) [force]; 1 where all are zero."""
        moved = (np.abs(self.G) @ np.abs(slip)).max(axis=1)[self.node]
        moved = np.append(moved, np.abs(self.gaps) @ np.abs(slip))
        loads = np.append(np.abs(self.d).max(axis=1), np.abs(self.gap_d)) * abs(load_factor)
        left = np.append(np.abs(self.g).max(axis=1), np.abs(self.gap_g))
        need = radius * np.append(self.spread[self.node], self.gap_spread) if radius else 0.0
        terms = np.maximum(np.maximum(moved, loads), np.maximum(left, need))
        return np.where(terms > 0, terms, 1.0)

    def names(self, indices: Places) -> tuple[tuple[int, int], ...]:
        """(node, load step) of some discs and gaps, in order."""
        node = np.append(self.closed[self.node], self.gap_node)
        step = np.append(self.step, self.gap_step)
        return tuple((int(node[i]), int(step[i])) for i in sorted(indices))


def disc_limits(zone: Zone, *, transient: bool = True, tolerances: Tolerances = DEFAULT) -> DiscLimits:
    """The limits of the closed nodes, shares zero, and of every open node that it stays open.

    Parameters
    ----------
    zone
        The closed and the open nodes. The columns are the slips of the closed nodes.
    transient
        Whether the transient load steps, where the problem has them, are still to come.

    Examples
    --------
    >>> import shakedown
    >>> from shakedown.joint.contact_zone import contact_zone
    >>> t = 2 * np.pi * np.arange(8)[:, None] / 8
    >>> joint = shakedown.Problem(
    ...     A=np.eye(2), B=[[0.5, 0.0]], f=0.4, q_w=np.hstack([np.cos(t), np.sin(t)]), p_w=3.0 + 0.0 * t
    ... )
    >>> limits = disc_limits(contact_zone(joint, ()))
    >>> limits.d.shape, limits.spread.round(3), limits.own
    ((8, 3), array([0.2]), array([[0.5, 0. ]]))
    """
    transient = transient and len(transient_path(zone.problem)) > 0
    known, which = _known_limits(zone.joint), (transient, tolerances)
    if which not in known:
        known[which] = _of_closed(zone.joint, transient, tolerances)
    limits = known[which]
    return _with_gaps(limits, zone, transient, tolerances) if zone.open_nodes else limits


@once_per_problem
def _known_limits(problem: Problem) -> dict[tuple[bool, Tolerances], DiscLimits]:
    """Cached limits of one problem: each costs an eigenvalue problem and serves all load factors."""
    return {}


def _of_closed(problem: Problem, transient: bool, tolerances: Tolerances) -> DiscLimits:
    law, loop, rigid, n = problem.law, loading(problem), rigid_slips(problem), problem.n
    metric = energy_metric(problem.A, problem.B, rigid, tolerances=tolerances)
    if not metric.inverse.shape[1]:  # no slip stores energy: one zero direction is used
        nothing = np.zeros((1, 2 * n))
        metric = replace(metric, root=nothing, inverse=nothing.T)
    node, step = _extreme_steps(law, loop.q1, loop.p1)
    d = law.of_nodes(law.against(loop.q1, loop.p1))[step, node]
    g = law.of_nodes(law.cone(loop.q0, loop.p0))[node]
    before = transient_path(problem)
    if transient and len(before):
        parts = problem.layout.split(before)
        early, when = _extreme_steps(law, *parts)
        g = np.vstack([g, law.of_nodes(law.cone(*parts))[when, early]])
        d = np.vstack([d, np.zeros((len(early), CONE))])
        node, step = np.append(node, early), np.append(step, when - len(before))
    order = np.argsort(node, kind="stable")
    own, least, stiffness = _own_parts(problem, metric, tolerances)
    none, G = np.zeros(0), np.moveaxis(law.of_nodes(law.stiffness(problem.A, problem.B).T), 0, -1)
    return DiscLimits(
        G=G,
        node=node[order],
        step=step[order],
        d=d[order],
        g=g[order],
        f=problem.f,
        share=np.zeros((n, 2)),
        own=own,
        least=least,
        stiffness=stiffness,
        gaps=np.zeros((0, 2 * n)),
        gap_d=none,
        gap_g=none,
        gap_spread=none,
        gap_node=none.astype(np.intp),
        gap_step=none.astype(np.intp),
        closed=np.arange(n),
        metric=metric,
        rigid=rigid,
        shared_blocks=SharedBlocks((G.reshape(-1, 2 * n) @ metric.inverse).reshape(n, CONE, -1)),
    )


def _extreme_steps(law: Law, q: FloatArray, p: FloatArray) -> tuple[Places, Places]:
    """The load steps that matter whatever the share: f |c| < 1, and so a < √2."""
    return Law(law.f / np.sqrt(2.0), 2).extreme_steps(q, p)


def _own_parts(
    problem: Problem, metric: EnergyMetric, tolerances: Tolerances
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """A_ii⁻¹ B_ii of every node, γ there, and A_ii.

    γ(c)² = γ² there + (c − c_i)ᵀ A_ii (c − c_i): a sum, so that nothing cancels.
    """
    n, A, B = problem.n, problem.A, problem.B
    rows, at = A.reshape(n, 2, -1), np.arange(n)
    blocks = A.reshape(n, 2, n, 2)[at, :, at, :]
    coupling = B.reshape(n, n, 2)[at, at]
    own = np.einsum(
        "ijk,ik->ij", np.linalg.pinv(blocks, rcond=tolerances.zero_mode, hermitian=True), coupling
    )
    rest = B - np.einsum("ij,ijk->ik", own, rows)
    terms = np.abs(B) + np.einsum("ij,ijk->ik", np.abs(own), np.abs(rows))
    rest = np.where(np.abs(rest) <= OWN * terms, 0.0, rest)
    sizes = metric.sizes.reshape(n, 2).max(axis=1)
    least = metric.relative_dual_norms(rest, sizes, tolerances, rigid=False)
    return own, least, blocks * metric.unit**2


def _with_gaps(limits: DiscLimits, zone: Zone, transient: bool, tolerances: Tolerances) -> DiscLimits:
    """With the rows of the open nodes; a gap is multiplied by ``metric.unit``², so that it is a force."""
    whole, metric, limits_of = zone.constraints, limits.metric, zone.problem.layout
    gap = whole.side == Side.GAP
    slope, d, g = whole.G[gap], whole.d[gap], whole.g[gap]
    node, step, force = whole.node[gap], whole.step[gap], metric.unit**2
    lengths = np.abs(slope) @ (force / metric.sizes)
    spread = metric.relative_dual_norms(slope, lengths, tolerances)  # inf where a rigid slip changes it
    before = transient_path(zone.problem)
    if transient and len(before):
        u = zone.displacements(np.zeros(slope.shape[1]), *limits_of.split(before))
        early = u[:, limits_of.gaps_of(node)]
        slope, d, g = np.vstack([slope, slope]), np.append(d, 0.0 * d), np.append(g, early.min(axis=0))
        spread, node = np.tile(spread, 2), np.tile(node, 2)
        step = np.append(step, early.argmin(axis=0) - len(before))
    return replace(
        limits,
        gaps=force * slope,
        gap_d=force * d,
        gap_g=force * g,
        gap_spread=force * spread,
        gap_node=node,
        gap_step=step,
        closed=np.array(zone.closed_nodes, dtype=np.intp),
    )


def without_margin(limits: DiscLimits) -> str:
    """Why no ball can exist whatever the load, in words; empty where one may."""
    smooth = limits.closed[limits.f == 0.0]
    if smooth.size:
        return f"node {smooth[0]} has no friction, and so no margin to its limit"
    for node, spread, what in (
        (limits.closed, limits.least, "pressure"),
        (limits.gap_node, limits.gap_spread, "gap"),
    ):
        unbounded = np.flatnonzero(np.isinf(spread))
        if unbounded.size:
            return (
                f"node {node[unbounded[0]]}: a slip without tangential energy changes its {what} "
                "(with a normal stiffness added, kappa would not be positive semi-definite)"
            )
    return ""
