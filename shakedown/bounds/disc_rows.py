"""The program of λ_max in space: its discs, and the unknowns that rigid slips leave."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import lapack, solve_triangular

from shakedown.ground.constants import CONE, SIX_DIGITS, FloatArray, IntArray, Mask
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import (
    Constraints,
    Side,
    constraints,
    loading,
    pressure_stiffness,
    rows_named,
    stacked,
    transient_path,
)
from shakedown.joint.contact_zone import Zone
from shakedown.joint.law import Law
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips

RANK = 64 * np.finfo(float).eps  # relative size of a diagonal of the triangular factor that counts as zero


@dataclass(frozen=True, eq=False)
class Basis:
    """N = D Q R with orthonormal Q: changes of limits with slips, D a size of every node or half-space.

    Attributes
    ----------
    Q : (3n + o, K)
        The rows of the discs' nodes, then those of the half-spaces.
    to_slips : (k, K)
        R⁻¹, in the slips that some limit depends on; those of the others are zero.
    sizes : (n + o,)
        D [force/length].
    """

    Q: FloatArray
    to_slips: FloatArray
    sizes: FloatArray


Discs = tuple[IntArray, IntArray]  # rows of load steps, and nodes


@dataclass(frozen=True, eq=False)
class DiscRows:
    """The limits s_j = c_j + λ e_j + N_i v in a second-order cone, for every disc j, of node i.

    As triples, s = (f p, q_x, q_y): |(q_x, q_y)| ≤ f p. The discs of a node differ in their loads only, so
    N is stored once per node. Half-spaces g − G v − λ d ≥ 0 follow: the pressures of closed nodes without
    friction, and gaps that stay open. In the plane there are no discs: all limits are half-spaces.

    Attributes
    ----------
    stiffness : (n, 3, k)
        N, the change of (f p, q_x, q_y) with the slips [force/length]; zero in the columns of pinned slips.
    node, step : (j,)
        Node and load step of every disc; steps of a transient are counted from −k to −1.
    c, e : (j, 3)
        Its triple without slip: what the constant part leaves, and what a load factor adds [force].
    half_spaces
        The half-spaces, as rows in the same columns, with nodes of the whole joint; of none it has no rows.
    names
        The number of each of the n nodes in the whole joint.
    in_plane
        Whether all of them are half-spaces, for linear programs.
    solved
        The ends of the programs of these limits that are known, by direction (−1: the largest load factor)
        and the tolerances that decide.
    """

    stiffness: FloatArray
    node: IntArray
    step: IntArray
    c: FloatArray
    e: FloatArray
    half_spaces: Constraints
    names: IntArray
    in_plane: bool = False
    solved: dict[tuple[float, Tolerances], Any] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def basis(self) -> Basis:
        """Orthonormal columns for the slips in these limits, every node in units of its own stiffness."""
        stiffness, gaps = self.stiffness, self.half_spaces.coefficients
        of_nodes, of_gaps = np.linalg.norm(stiffness, axis=(1, 2)), np.linalg.norm(gaps, axis=1)
        sizes, of_rows = np.append(of_nodes, of_gaps), np.append(np.repeat(of_nodes, CONE), of_gaps)
        rows = np.vstack([stiffness.reshape(CONE * len(stiffness), stiffness.shape[-1]), gaps])
        M = rows * (1.0 / np.where(of_rows > 0, of_rows, 1.0))[:, None]
        known = np.flatnonzero(M.any(axis=0))
        if not known.size:
            return Basis(np.zeros((len(M), 0)), np.zeros((M.shape[1], 0)), sizes)
        lengths = np.linalg.norm(M[:, known], axis=0)
        Q = M[:, known] / lengths
        R, dependent = lapack.dpotrf(Q.T @ Q)  # Q R⁻¹ is orthonormal to the digits that squares leave
        if not dependent and np.diag(R).min() > SIX_DIGITS:
            to_slips = np.zeros((M.shape[1], len(R)))
            to_slips[known] = solve_triangular(R, np.eye(len(R)), check_finite=False) / lengths[:, None]
            return Basis(solve_triangular(R, Q.T, trans=1, check_finite=False).T, to_slips, sizes)
        U, values, V = np.linalg.svd(Q, full_matrices=False)
        kept = values > RANK * len(M) * values[0]
        to_slips = np.zeros((M.shape[1], int(kept.sum())))
        to_slips[known] = V[kept].T / values[kept] / lengths[:, None]
        return Basis(np.ascontiguousarray(U[:, kept]), to_slips, sizes)

    @cached_property
    def sums(self) -> sparse.csr_matrix:
        """The matrix that sums over the discs of each node, (n, j)."""
        count = len(self.node)
        shape = (len(self.stiffness), count)
        return sparse.csr_matrix((np.ones(count), (self.node, np.arange(count))), shape=shape)

    @cached_property
    def frictionless(self) -> Mask:
        """The discs (j,) of nodes that never have a limit above zero: their reactions must vanish."""
        limited: Mask = np.logical_or.reduce(self.stiffness[:, 0] != 0, axis=1)
        limited[self.node[(self.c[:, 0] != 0) | (self.e[:, 0] != 0)]] = True
        return np.asarray(~limited[self.node])

    def under(self, **loads: Any) -> "DiscRows":
        """The same limits with other loads; the basis is worked out once for both.

        ``loads`` are c, e, node, step, and half-spaces with the same coefficients.
        """
        found = replace(self, **loads)
        vars(found)["basis"] = self.basis  # where a cached property keeps its value
        return found

    @property
    def flat(self) -> FloatArray:
        """N as a matrix, (3n, k)."""
        return self.stiffness.reshape(CONE * len(self.stiffness), self.stiffness.shape[-1])

    def slack(self, x: FloatArray, load_factor: float) -> tuple[FloatArray, FloatArray]:
        """f p − |q| of every disc, and what the half-spaces leave, at unknowns (k,) [force, length]."""
        s = self.c + load_factor * self.e + (self.flat @ x).reshape(-1, 3)[self.node]
        H = self.half_spaces
        return s[:, 0] - np.hypot(s[:, 1], s[:, 2]), H.g - H.coefficients @ x - load_factor * H.d

    def relative_excess(self, x: FloatArray, load_factor: float) -> float:
        """The largest violation, relative to the largest term of its disc or half-space."""
        of_slip = (np.abs(self.flat) @ np.abs(x)).reshape(-1, 3)[self.node]
        terms = np.maximum(of_slip, np.maximum(np.abs(self.c), np.abs(load_factor * self.e))).max(axis=1)
        H = self.half_spaces
        moved = np.abs(H.coefficients) @ np.abs(x)
        others = np.maximum(moved, np.maximum(np.abs(H.g), np.abs(load_factor * H.d)))
        slacks = [
            slack / np.where(size > 0, size, 1.0)
            for slack, size in zip(self.slack(x, load_factor), (terms, others), strict=True)
        ]
        return -float(min(each.min(initial=np.inf) for each in slacks))

    def named(self, discs: IntArray, others: IntArray) -> tuple[tuple[int, int], ...]:
        """(node, load step) of some discs and half-spaces, each once; in the plane (node, side)."""
        if self.in_plane:
            return rows_named(self.half_spaces, others)
        nodes = np.append(self.names[self.node[discs]], self.half_spaces.node[others]).tolist()
        steps = np.append(self.step[discs], self.half_spaces.step[others]).tolist()
        return tuple(sorted(set(zip(nodes, steps, strict=True))))

    def with_pressures(self, y: FloatArray, z: FloatArray) -> FloatArray:
        """Multipliers (j, 3) of p, q_x and q_y where a node has no friction, from y and those of pressures.

        Of its discs one is at the load step of its least pressure.
        """
        y = y.copy()
        y[self.frictionless, 0] = 0.0
        for row in np.flatnonzero(self.half_spaces.side == Side.PRESSURE):
            own = self.names[self.node] == self.half_spaces.node[row]
            least = np.flatnonzero(own & (self.step == self.half_spaces.step[row]))
            y[least[0], 0] = z[row]
        return y


@once_per_problem
def disc_rows(problem: Problem) -> DiscRows:
    """The limits of a joint with all nodes closed; built once per problem.

    Examples
    --------
    >>> loop = {"q_w": [[1.0, 0.0], [-1.0, 0.0]], "p_w": [[3.0], [3.0]]}
    >>> rows = disc_rows(Problem(A=2 * np.eye(2), B=[[0.5, 0.0]], f=0.5, **loop))
    >>> rows.c[0], rows.e.tolist()
    (array([1.5, 0. , 0. ]), [[0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    """
    if problem.directions == 1:
        return _half_spaces_alone(constraints(problem))
    loop, law, rigid = loading(problem), problem.law, rigid_slips(problem)
    node, step = law.extreme_steps(loop.q1, loop.p1)
    constant = triples(law, loop.q0[None], loop.p0[None])[0]
    A, fB = rigid.columns(problem.A), rigid.columns(law.limit_rows(problem.B))
    return DiscRows(
        stiffness=np.concatenate([fB[:, None], A.reshape(problem.n, 2, -1)], axis=1),
        node=node,
        step=step,
        c=constant[node],
        e=triples(law, loop.q1, loop.p1)[step, node],
        half_spaces=_pressures(problem, loop.p0, -loop.p1, np.arange(problem.m), (step, node)),
        names=np.arange(problem.n),
    )


def zone_rows(zone: Zone, transient: bool = False) -> DiscRows:
    """The limits of the closed nodes of a zone and the gaps of its open ones; of a transient besides.

    Raises
    ------
    UsageError
        If nodes are open before the transient.
    """
    if zone.problem.directions == 1 and (transient or zone.open_nodes):
        return _half_spaces_alone(zone.rows(transient))
    if transient:
        zone.check_transient()
    rows = disc_rows(zone.joint)
    if zone.open_nodes:
        names = np.array(zone.closed_nodes, dtype=np.intp)
        pressures = replace(rows.half_spaces, node=names[rows.half_spaces.node])
        rows = replace(rows, half_spaces=stacked(pressures, zone.gap_rows), names=names)
    problem, path = zone.problem, transient_path(zone.problem)
    if not (transient and len(path)):
        return rows
    law, steps, (q, p) = problem.law, np.arange(-len(path), 0), problem.layout.split(path)
    node, step = law.extreme_steps(q, p)
    before = triples(law, q, p)[step, node]
    pressures = _pressures(problem, np.zeros(problem.n), -p, steps, (step, node))
    pressures = replace(pressures, g=-pressures.d, d=np.zeros_like(pressures.d))
    return replace(
        rows,
        node=np.append(rows.node, node),
        step=np.append(rows.step, steps[step]),
        c=np.vstack([rows.c, before]),
        e=np.vstack([rows.e, np.zeros_like(before)]),
        half_spaces=stacked(rows.half_spaces, pressures),
    )


def _half_spaces_alone(limits: Constraints) -> DiscRows:
    """The limits of a joint in the plane."""
    none, no_disc = np.zeros(0, dtype=np.intp), np.zeros((0, CONE))
    return DiscRows(np.zeros((0, CONE, limits.n)), none, none, no_disc, no_disc, limits, none, in_plane=True)


def triples(law: Law, q: FloatArray, p: FloatArray) -> FloatArray:
    """(f p, q_x, q_y) of every node at some load steps, (m, n, 3)."""
    return np.concatenate([law.limit(p)[..., None], law.layout.by_node(q)], axis=-1)


def _pressures(problem: Problem, p0: FloatArray, less: FloatArray, step: IntArray, at: Discs) -> Constraints:
    """The pressures of nodes without friction, with the load steps (m,) that take most from them.

    ``less`` (m, n) is what they take from p0 (n,) at load factor 1; of load steps that take as much it is
    that of a disc, ``at`` the load steps and nodes of the discs.
    """
    frictionless, of_discs = problem.law.frictionless, np.full_like(less, -np.inf)
    of_discs[at] = less[at]
    return Constraints(
        G=-pressure_stiffness(problem)[frictionless],
        d=less[:, frictionless].max(axis=0),
        g=p0[frictionless],
        node=frictionless,
        side=np.full(len(frictionless), Side.PRESSURE),
        step=step[of_discs[:, frictionless].argmax(axis=0)],
        rigid=rigid_slips(problem),
    )
