"""A joint with some nodes open, and the joints that a joint falls into."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.argument_kinds import checked
from shakedown.ground.constants import ROUND_OFF, FloatArray
from shakedown.ground.errors import ProblemError, UsageError
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import node_numbers, once_per_problem
from shakedown.joint.constraints import (
    Constraints,
    Side,
    changed_loads,
    constraints,
    loading,
    stacked,
    through_transient,
)
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import (
    MOTION_ROUND_OFF,
    NO_STIFFNESS,
    free_stiffness,
    rigid_slips,
    stiffness_error,
)
from shakedown.joint.units import NO_LOADS


@dataclass(frozen=True, eq=False)
class Zone:
    """A joint with the nodes of a set O open and carrying nothing, all others closed.

    Where q = p = 0 the displacements of the open nodes follow from equilibrium,

        u_O = −κ_OO⁻¹ (r_w,O + κ_OK (v_K, w_K)),

    and what is left is a joint of the closed nodes K with the stiffness
    κ̃ = κ_KK − κ_KO κ_OO⁻¹ κ_OK and the welded reactions r̃_w = r_w,K − κ_KO κ_OO⁻¹ r_w,O.

    Attributes
    ----------
    problem
        The whole joint.
    open_nodes, closed_nodes
        O and K, in increasing order.
    joint
        The joint of the closed nodes, with κ̃ and r̃_w; the whole joint where O is empty.
    slope : ((d + 1) o, dk)
        −∂(v_O, w_O)/∂v_K [–].
    flexibility : ((d + 1) o, (d + 1) o)
        κ_OO⁻¹ [length/force].
    """

    problem: Problem
    open_nodes: tuple[int, ...]
    closed_nodes: tuple[int, ...]
    joint: Problem
    slope: FloatArray
    flexibility: FloatArray

    @cached_property
    def constraints(self) -> Constraints:
        """The frictional rows of the closed nodes, then one row per open node: it stays open.

        Rows name the nodes of the whole joint; the columns are the slips of the closed nodes.
        """
        rows = constraints(self.joint)
        if not self.open_nodes:
            return rows
        closed = np.array(self.closed_nodes, dtype=np.intp)
        return stacked(replace(rows, node=closed[rows.node]), self.gap_rows)

    @cached_property
    def gap_rows(self) -> Constraints:
        """One row per open node: it stays open at its extreme load step."""
        gaps, loop, welded = self._opened.gaps, loading(self.problem), self._of_open
        h1 = welded(loop.q1, loop.p1)[:, gaps]
        return Constraints(
            G=self.slope[gaps],
            d=h1.max(axis=0),
            g=-welded(loop.q0[None], loop.p0[None])[0, gaps],
            node=np.array(self.open_nodes, dtype=np.intp),
            side=np.full(len(self.open_nodes), Side.GAP),
            step=h1.argmax(axis=0),
            rigid=rigid_slips(self.joint),
        )

    def rows(self, transient: bool) -> Constraints:
        """The limits that a safe slip keeps: of the loop, and of the transient where it is still to come."""
        if not transient:
            return self.constraints
        self.check_transient()
        return through_transient(self.problem)

    def check_transient(self) -> None:
        """Raise ``UsageError`` where nodes are open before the transient."""
        if self.open_nodes:
            raise UsageError(f"transient: expected all nodes closed, found {len(self.open_nodes)} open")

    @property
    def _opened(self) -> Layout:
        """The places of the displacements of an open node among those of all open nodes."""
        return replace(self.problem.layout, n=len(self.open_nodes))

    def _of_open(self, q: FloatArray, p: FloatArray) -> FloatArray:
        """κ_OO⁻¹ r_w,O for some load steps (m, dn), (m, n): (m, (d + 1) o)."""
        layout = self.problem.layout
        return layout.joined(q, p)[:, layout.of_nodes(self.open_nodes)] @ self.flexibility.T

    @property
    def pinned(self) -> tuple[int, ...]:
        """The slips of the whole joint, by number, set to zero because no row depends on them."""
        of_closed = self.problem.layout.slips_of(self.closed_nodes).tolist()
        return tuple(of_closed[k] for k in self.constraints.pinned)

    def spread(self, slip: FloatArray, elsewhere: float = np.nan) -> FloatArray:
        """The slips of the closed nodes (dk,) among those of all nodes (dn,)."""
        layout = self.problem.layout
        everywhere = np.full(layout.slip_size, elsewhere)
        everywhere[layout.slips_of(self.closed_nodes)] = slip
        return everywhere

    def slips(self, slip: FloatArray) -> FloatArray:
        """Slips of all nodes (n,) [length]: of open ones their displacement under the mean load."""
        loop = loading(self.problem)
        return self.displacements(slip, loop.q0[None], loop.p0[None])[0, self.problem.layout.slips]

    def follow(self, change: FloatArray) -> FloatArray:
        """Change of the slips of all nodes (…, dn) with that of the closed ones (…, dk); open ones follow."""
        layout = self.problem.layout
        everywhere = np.zeros((*change.shape[:-1], layout.slip_size))
        everywhere[..., layout.slips_of(self.closed_nodes)] = change
        everywhere[..., layout.slips_of(self.open_nodes)] = -change @ self.slope[self._opened.slips].T
        return everywhere

    def displacements(self, slip: FloatArray, q_w: FloatArray, p_w: FloatArray) -> FloatArray:
        """u = (v, w) of all nodes, (m, (d + 1) n) [length], with the closed ones at ``slip`` (dk,).

        Parameters
        ----------
        slip : (dk,)
            Slips of the closed nodes [length].
        q_w, p_w : (m, dn), (m, n)
            Welded reactions of the whole joint [force].
        """
        layout = self.problem.layout
        u = layout.zeros(len(q_w))
        u[:, layout.slips_of(self.closed_nodes)] = slip
        if self.open_nodes:
            u[:, layout.of_nodes(self.open_nodes)] = -self.slope @ slip - self._of_open(q_w, p_w)
        return u


@checked
def contact_zone(problem: Problem, open_nodes: Iterable[int], *, tolerances: Tolerances = DEFAULT) -> Zone:
    """The joint of the closed nodes where the others are open and carry no load.

    Parameters
    ----------
    problem
        The whole joint; it needs C where a node is open.
    open_nodes
        The nodes of O, numbered from 0.
    tolerances
        ``singular_pivot`` decides whether κ_OO holds the open nodes in place.

    Raises
    ------
    UsageError
        If a node is not one of the joint's, no node stays closed, or κ_OO is singular.
    ProblemError
        If the problem has no C.

    Examples
    --------
    >>> import shakedown
    >>> zone = contact_zone(shakedown.example("two-node"), [1])
    >>> zone.closed_nodes, zone.joint.A.round(2), zone.joint.B.round(2)
    ((0,), array([[219.67]]), array([[344.3]]))
    """
    chosen = sorted(set(node_numbers("open nodes", open_nodes, problem.n)))
    k = [i for i in range(problem.n) if i not in set(chosen)]
    if not k:
        raise UsageError(
            f"open nodes: expected at least one node that stays closed, found all {problem.n} open"
        )
    if not chosen:
        return Zone(problem, (), tuple(k), problem, np.zeros((0, problem.layout.slip_size)), np.zeros((0, 0)))
    kappa, layout = problem.kappa, problem.layout
    closed = replace(layout, n=len(k))
    free, held = layout.of_nodes(chosen), layout.of_nodes(k)
    resisting = free_stiffness(problem)[np.ix_(free, free)]
    flexibility = _inverse(kappa[np.ix_(free, free)], resisting, chosen, tolerances)
    follow = _without_round_off(flexibility @ kappa[np.ix_(free, held)])  # −∂u_O/∂u_K
    # round-off of the condensed stiffness, relative to the terms of its difference
    known = problem.stiffness_accuracy is not None
    accuracy = max(stiffness_error(problem), MOTION_ROUND_OFF if known else NO_STIFFNESS)
    parts = kappa[np.ix_(held, held)], kappa[np.ix_(held, free)], follow
    A, B, C = closed.blocks(_condensed(*parts, accuracy))
    given = problem.initial_slip
    joint = replace(
        problem,
        **NO_LOADS,  # these work along displacements of the whole joint
        A=A,
        B=B,
        C=C,
        initial_slip=None if given is None else given[:, layout.slips_of(k)],
        **problem.node_data(k),
        **changed_loads(problem, lambda r: closed.split(r[..., held] - r[..., free] @ follow)),
    )
    return Zone(problem, tuple(chosen), tuple(k), joint, follow[:, closed.slips], flexibility)


def _condensed(held: FloatArray, tie: FloatArray, follow: FloatArray, accuracy: float) -> FloatArray:
    """κ of the closed nodes, the slips and gaps of those that nothing holds without any stiffness.

    Where a node and open ones alone are what can move, all that is left of its stiffness is the round-off
    of the difference, and nothing next to it would tell that.
    """
    left = held - tie @ follow
    noise = accuracy * (np.abs(held) + np.abs(tie) @ np.abs(follow))
    loose = np.flatnonzero((np.abs(left) <= noise).all(axis=1))
    left[loose], left[:, loose] = 0.0, 0.0
    return left


def _without_round_off(follow: FloatArray) -> FloatArray:
    """The matrix by which open nodes follow closed ones, with round-off of the largest entry set to zero.

    For similar bodies B should vanish. With round-off in its place a gap would seem to depend on slips that
    are large enough, and a pressure on open nodes to load nodes without friction along the surface.
    """
    noise = MOTION_ROUND_OFF * len(follow) * np.abs(follow).max(initial=0.0)
    return np.where(np.abs(follow) <= noise, 0.0, follow)


def _inverse(
    stiffness: FloatArray, resisting: FloatArray, nodes: list[int], tolerances: Tolerances
) -> FloatArray:
    """κ_OO⁻¹, each displacement measured on its own scale; ``resisting``: κ_OO without rigid motions."""
    diagonal = np.diag(stiffness)
    scale = 1.0 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    held = np.linalg.eigvalsh(resisting * np.outer(scale, scale))
    if not held[0] > tolerances.singular_pivot * held[-1]:
        named = ", ".join(map(str, nodes[:8]))
        raise UsageError(
            f"open nodes: expected nodes that the body holds when open, found {named} free to move"
        )
    values, vectors = np.linalg.eigh(stiffness * np.outer(scale, scale))
    return np.asarray((vectors / values) @ vectors.T * np.outer(scale, scale))


@dataclass(frozen=True, eq=False)
class Part:
    """Nodes of a joint that are coupled with no other node.

    Attributes
    ----------
    nodes, slips
        Their numbers in the whole joint, and the places of their slips there.
    joint
        The joint of these nodes alone, without unit loads.
    """

    nodes: NDArray[np.intp]
    slips: NDArray[np.intp]
    joint: Problem

    def renumbered(self, text: str) -> str:
        """A text about nodes of the part, with the numbers that they have in the whole joint.

        Examples
        --------
        >>> import shakedown
        >>> part = Part(np.array([3, 7]), np.array([3, 7]), shakedown.example("two-node"))
        >>> part.renumbered("nodes 0, 1 open, node 1 after 5 cycles")
        'nodes 3, 7 open, node 7 after 5 cycles'
        """

        def in_whole(found: re.Match[str]) -> str:
            return re.sub(r"\d+", lambda number: str(self.nodes[int(number.group())]), found.group())

        return re.sub(r"\bnodes? \d+(, \d+)*", in_whole, text)

    def among(self, nodes: Collection[int]) -> tuple[int, ...]:
        """Those of some nodes of the whole joint that are the part's, by its own numbers."""
        return tuple(np.flatnonzero(np.isin(self.nodes, list(nodes))).tolist())

    def number(self, node: int) -> int:
        """The number of a node of the part in the whole joint; −1, no node, stays."""
        return int(self.nodes[node]) if node >= 0 else node


def coupled_parts(problem: Problem, open_nodes: Collection[int] = ()) -> tuple[Part, ...]:
    """The parts that a joint falls into, in the order of their first nodes; mostly one, the joint itself.

    So it is, too, where all nodes of a part are open, which is then no joint in contact, and where a part
    alone is no valid joint, as its stiffness is round-off beside that of others.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> apart = shakedown.Problem(
    ...     A=np.kron(joint.A, np.eye(2)), B=np.kron(joint.B, np.eye(2)), f=0.4,
    ...     q_w=np.repeat(joint.q_w, 2, axis=1), p_w=np.repeat(joint.p_w, 2, axis=1),
    ... )
    >>> [part.nodes.tolist() for part in coupled_parts(apart)], coupled_parts(joint)[0].joint is joint
    ([[0, 2], [1, 3]], True)
    """
    parts = _parts(problem)
    if not parts or any(len(part.among(open_nodes)) == len(part.nodes) for part in parts):
        return (Part(np.arange(problem.n), np.arange(problem.layout.slip_size), problem),)
    return parts


def of_nodes(parts: Sequence[Part], values: Iterable[FloatArray]) -> FloatArray:
    """What is known of the nodes of each part, (…, k), for the nodes of the whole joint, (…, n)."""
    return np.concatenate(list(values), axis=-1)[..., np.argsort(np.concatenate([p.nodes for p in parts]))]


def of_slips(parts: Sequence[Part], values: Iterable[FloatArray]) -> FloatArray:
    """The same of slips, (…, dk): (…, dn)."""
    return np.concatenate(list(values), axis=-1)[..., np.argsort(np.concatenate([p.slips for p in parts]))]


def weakest(bounds: Sequence[Any]) -> int:
    """Which of the bounds on the load factors of parts is that of the whole joint.

    The first one that is infeasible, else the first one that is undecided, else the smallest.
    """
    ranks = {Status.INFEASIBLE: -2.0, Status.UNDECIDED: -1.0}
    return min(range(len(bounds)), key=lambda k: ranks.get(bounds[k].status, bounds[k].load_factor))


@once_per_problem
def _parts(problem: Problem) -> tuple[Part, ...]:
    """The parts, where there are several."""
    labels = part_numbers(problem)
    if not labels.any():
        return ()
    try:
        return tuple(_part(problem, np.flatnonzero(labels == k)) for k in range(labels.max() + 1))
    except ProblemError:
        return ()


def part_numbers(problem: Problem) -> NDArray[np.intp]:
    """The number of the part of every node, (n,); couplings that are round-off are none.

    |A_ij| counts beside √(A_ii A_jj), |C_ij| beside √(C_ii C_jj), and |B_ij| beside √(C_ii A_jj), or
    √(A_ii A_jj) without C, in whatever units nodes are.
    """
    n, d, A, C = problem.n, problem.directions, problem.A, problem.C
    own = problem.layout.by_node(np.sqrt(np.maximum(np.diagonal(A), 0.0))).max(axis=-1)
    normal = own if C is None else np.sqrt(np.maximum(np.diagonal(C), 0.0))
    coupled = np.abs(A).reshape(n, d, n, d).max(axis=(1, 3)) > ROUND_OFF * np.outer(own, own)
    coupled |= np.abs(problem.B).reshape(n, n, d).max(axis=2) > ROUND_OFF * np.outer(normal, own)
    if C is not None:
        coupled |= np.abs(C) > ROUND_OFF * np.outer(normal, normal)
    if coupled[0].all():
        return np.zeros(n, dtype=np.intp)
    from scipy.sparse import csr_array  # needed only where some entries are zero
    from scipy.sparse.csgraph import connected_components

    return np.asarray(connected_components(csr_array(coupled), directed=False)[1], dtype=np.intp)


def _part(problem: Problem, nodes: NDArray[np.intp]) -> Part:
    slips = problem.layout.slips_of(nodes)
    joint = replace(
        problem,
        **NO_LOADS,  # these work along displacements of the whole joint
        A=problem.A[np.ix_(slips, slips)],
        B=problem.B[np.ix_(nodes, slips)],
        C=None if problem.C is None else problem.C[np.ix_(nodes, nodes)],
        initial_slip=None if problem.initial_slip is None else problem.initial_slip[:, slips],
        **changed_loads(problem, lambda r: (r[..., slips], r[..., problem.layout.gaps_of(nodes)])),
        **problem.node_data(nodes),
    )
    return Part(nodes, slips, joint)
