"""The loading loop, and the frictional constraints in slip space and load factor: rows, or cones in space."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import IntEnum
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.constants import CONE, ROUND_OFF, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.joint.arguments import once_per_problem, real_array, require_problem
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import NO_STIFFNESS, RigidSlips, free_stiffness, rigid_slips

LARGEST_FORCE = 1e150  # its square is still finite


@dataclass(frozen=True, eq=False, repr=False)
class Loading(Result):
    """Welded reactions r_w(λ) = r⁰ + λ r¹ over one period (thesis §5.1).

    Attributes
    ----------
    q0, p0 : (dn,), (n,)
        Constant part r⁰ [force].
    q1, p1 : (m, dn), (m, n)
        Periodic part r¹ = r_w − r⁰ at load factor 1 [force].
    """

    TABLE: ClassVar[str] = "q1 p1"

    q0: FloatArray
    p0: FloatArray
    q1: FloatArray
    p1: FloatArray

    def at(self, load_factor: float) -> tuple[FloatArray, FloatArray]:
        """The welded reactions (q_w, p_w), (m, dn) and (m, n) [force], at a load factor.

        Raises ``UsageError`` where they are too large for floating-point numbers.
        """
        with np.errstate(over="ignore", invalid="ignore"):
            q_w, p_w = self.q0 + load_factor * self.q1, self.p0 + load_factor * self.p1
        largest = max(np.abs(q_w).max(), np.abs(p_w).max())
        if not largest < LARGEST_FORCE:
            raise UsageError(f"load factor: expected loads below {LARGEST_FORCE:g}, found {largest:g}")
        return q_w, p_w


@once_per_problem
def loading(problem: Problem) -> Loading:
    """Split the loading loop of a problem into its constant and its periodic part; done once per problem.

    What is less than the round-off of the largest load of its node is zero, and so is what varies by no more.
    Tangential loads of nodes without friction, which no slip could follow, count beside those of all nodes.

    Examples
    --------
    >>> import shakedown
    >>> loop = loading(shakedown.example("two-node"))
    >>> loop.q0.round(6), loop.p0.round(6)
    (array([  15.8, -400. ]), array([ 588.5, 1300. ]))
    """
    q, p = np.abs(problem.q_w).max(axis=0), np.abs(problem.p_w).max(axis=0)
    noise = ROUND_OFF * np.maximum(problem.layout.by_node(q).max(axis=-1), p)
    along = np.where(problem.f > 0, noise, noise.max()).repeat(problem.directions)
    q0, q1 = _split(problem.q_w, problem.q_mean, along)
    p0, p1 = _split(problem.p_w, problem.p_mean, noise)
    return Loading(q0, p0, q1, p1)


def transient_path(problem: Problem) -> FloatArray:
    """The welded reactions (q_w, p_w) of the load steps before the first period, (k, (d + 1) n) [force].

    Examples
    --------
    >>> import shakedown
    >>> transient_path(shakedown.example("two-node")).shape
    (0, 4)
    """
    if problem.q_transient is None or problem.p_transient is None:
        return problem.layout.zeros(0)
    return problem.layout.joined(problem.q_transient, problem.p_transient)


def loop_path(problem: Problem, load_factor: float) -> FloatArray:
    """The welded reactions (q_w, p_w) of one period at a load factor, (m, (d + 1) n) [force]."""
    return problem.layout.joined(*loading(problem).at(load_factor))


def first_load(problem: Problem, load_factor: float) -> FloatArray:
    """The welded reactions of the first load step, of the transient where there is one [force]."""
    before = transient_path(problem)
    if len(before):
        return np.asarray(before[0])
    loop = loading(problem)
    return problem.layout.joined(loop.q0 + load_factor * loop.q1[0], loop.p0 + load_factor * loop.p1[0])


def ramp_start(problem: Problem, first: FloatArray, start: FloatArray) -> FloatArray:
    """Welded reactions from which the load rises to its first load step, all closed nodes stuck.

    Tangential reactions are zero, normal ones those of the first load step (in
    magnitude), so that an initial state (v, w) that is admissible there stays as it is.
    """
    layout = problem.layout
    v, w = layout.split(start)
    kappa = free_stiffness(problem)
    A, B, _ = layout.blocks(kappa)
    locked_q, locked_p = layout.split(kappa @ start) if w.any() else (A @ v, B @ v)
    return layout.joined(-locked_q, np.abs(first[layout.gaps] + locked_p) - locked_p)


def slip_reach(problem: Problem, load_factor: float) -> FloatArray:
    """Slips that one load step could cause, node by node: the half-width of a box of initial states.

    Largest |q_w| + f |p_w| over the loop, by A_jj, (dn,) [length]; 0 where A_jj = 0.

    Examples
    --------
    >>> import shakedown
    >>> slip_reach(shakedown.example("two-node"), 0.7).round(3)
    array([1.546, 5.326])
    """
    q_w, p_w = loading(problem).at(load_factor)
    force = (problem.law.size(q_w) + problem.law.limit(np.abs(p_w))).max(axis=0).repeat(problem.directions)
    stiffness = np.diag(problem.A)
    return np.asarray(force / np.where(stiffness > 0, stiffness, np.inf))


def with_initial_gap(problem: Problem, gap: ArrayLike) -> Problem:
    """The joint with an initial gap g⁰ between its contact nodes; negative is interference.

    With w = u_n + g⁰, u_n the normal displacement, the reactions are those of the
    displacements (v, w − g⁰): holding the nodes closed (w = 0) takes

        q_w → q_w − Bᵀ g⁰,        p_w → p_w − C g⁰

    at every load step. The periodic part of the loading does not change.

    Parameters
    ----------
    problem
        The joint with its nodes just touching; it needs C.
    gap : () or (n,)
        g⁰ [length], one number or one per node.

    Raises
    ------
    UsageError
        If the gap is not one finite number or one per node.
    ProblemError
        If the problem has no C.

    Examples
    --------
    A press fit of one node: interference 0.1 gives the pressure 0.1 C.

    >>> loose = Problem(A=[[2.0]], B=[[0.5]], C=[[3.0]], f=0.3, q_w=[[0.0]], p_w=[[0.0]])
    >>> tight = with_initial_gap(loose, -0.1)
    >>> tight.p_w.round(6), tight.q_w.round(6)
    (array([[0.3]]), array([[0.05]]))
    """
    require_problem(problem)
    g = real_array("initial gap", gap)
    if g.shape not in ((), (problem.n,)):
        raise UsageError(f"initial gap: expected one number or shape ({problem.n},), found {g.shape}")
    shift = problem.kappa[problem.layout.gaps].T @ np.broadcast_to(g, problem.n)
    return replace(problem, **changed_loads(problem, lambda r: problem.layout.split(r - shift)))


def changed_loads(
    problem: Problem, change: Callable[[FloatArray], tuple[FloatArray, FloatArray]]
) -> dict[str, Any]:
    """The fields of the loading where the reactions (…, (d + 1) n) of load steps become others, (q, p)."""
    found: dict[str, Any] = {}
    for keys in (("q_w", "p_w"), ("q_transient", "p_transient"), ("q_mean", "p_mean")):
        given = [getattr(problem, key) for key in keys]
        if given[0] is None and given[1] is None:
            continue
        if given[0] is None or given[1] is None:  # one mean alone
            given = [loading(problem).q0, loading(problem).p0]
        found |= zip(keys, change(problem.layout.joined(*given)), strict=True)
    return found


def _split(samples: FloatArray, given: FloatArray | None, noise: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The mean of samples, or the given one, and their departure from it; round-off of both is zero."""
    mean = samples.mean(axis=0) if given is None else given
    mean = np.where(np.abs(mean) <= noise, 0.0, mean)
    periodic = samples - mean
    periodic[:, np.abs(periodic).max(axis=0) <= noise] = 0.0
    return mean, periodic


class Side(IntEnum):
    """The kind of a row: one side of the friction of a node, a gap, a disc, or the pressure where f = 0."""

    BACKWARD = 1
    FORWARD = -1
    GAP = 0
    DISC = 2
    PRESSURE = 3


SIDES = (Side.BACKWARD, Side.FORWARD)  # of a node in the plane, in the order of its rows
SIDE_NAMES = {int(side): side.name.lower() for side in Side}


@dataclass(frozen=True, eq=False, repr=False)
class Constraints(Result):
    """Extremal frictional constraints g − G v − λ d ∈ K (thesis (5.3)–(5.7)).

    With one tangential direction K are half-spaces, G v + λ d ≤ g: row 2j is the backward-slip
    limit of node j (side +1, q = f p), row 2j + 1 its forward-slip limit (side −1, q = −f p): the
    thesis's I, II, III, IV, … With two, K are second-order cones: the three rows (f p, q_x, q_y) of a
    node at one load step, and every node has as many as it has extreme load steps. Where f = 0 a row p ≥ 0
    follows (side 3), as |q| ≤ f p does not say it there.
    Programs over the rows take their coefficients from ``coefficients``, not from G: there the slips
    of a body that only friction holds are those relative to its pinned nodes.

    Attributes
    ----------
    G : (r, dn)
        Coefficients of the slip v, with one direction r = 2n and one for each node of f = 0 [force/length].
    d : (r,)
        Coefficients of the load factor λ, at the extreme load step [force].
    g : (r,)
        Right-hand sides: the distance of the mean load from the limit [force].
    node, side, step : (r,)
        Node, side (±1; none: 2, gap: 0, pressure: 3) and extreme load step of every row; of rows of
        transient load steps (:func:`through_transient`) the step counted from −k to −1, before the period.
    rigid
        The slips that change no frictional limit, and where they are pinned.
    """

    G: FloatArray
    d: FloatArray
    g: FloatArray
    node: NDArray[np.intp]
    side: NDArray[np.intp]
    step: NDArray[np.intp]
    rigid: RigidSlips = field(repr=False, compare=False)

    @property
    def n(self) -> int:
        """Number of slips: with one direction that of contact nodes."""
        return self.G.shape[1]

    @cached_property
    def heads(self) -> NDArray[np.intp]:
        """The first row of every cone of K, in order; a half-space has no other."""
        in_disc = self.side == Side.DISC
        return np.flatnonzero(~in_disc | (np.cumsum(in_disc) % CONE == 1))

    @cached_property
    def sided(self) -> NDArray[np.bool_]:
        """The rows (r,) of friction in the plane, two for every closed node: no gaps, no pressures."""
        return np.asarray(np.abs(self.side) == Side.BACKWARD)

    def limits_of(self, node: int) -> NDArray[np.bool_]:
        """The two limits of a node in the plane, among all rows (r,)."""
        return np.asarray(self.sided & (self.node == node))

    @property
    def cones(self) -> NDArray[np.intp]:
        """The sizes of the cones of K in the order of the rows: 1 a half-space, 3 a second-order cone."""
        return np.diff(np.append(self.heads, len(self.g)))

    @cached_property
    def coefficients(self) -> FloatArray:
        """G in the unknowns of programs, (r, dn): zero in the columns of pinned nodes.

        What a rigid slip changes in a gap stays: there the unknown is how far the body has moved. Slopes
        of gaps are as accurate as the largest of them.
        """
        kept, pinned = self.rigid.columns(self.G), list(self.rigid.pinned)
        gaps = np.flatnonzero(self.side == Side.GAP)
        if pinned and gaps.size:
            terms = (np.abs(self.G[gaps]) @ np.abs(self.rigid.motions)).max(axis=0)
            moved = self.G[gaps] @ self.rigid.motions
            kept[np.ix_(gaps, np.array(pinned))] = np.where(np.abs(moved) > NO_STIFFNESS * terms, moved, 0.0)
        return kept

    @cached_property
    def pinned(self) -> tuple[int, ...]:
        """The columns left out: slips set to zero because no row depends on them."""
        return tuple(k for k in self.rigid.pinned if not self.coefficients[:, k].any())

    def slips(self, x: FloatArray) -> FloatArray:
        """The slips (…, n) that the unknowns of a program stand for; at pinned nodes zero."""
        rigid = list(self.rigid.pinned)
        if not rigid:
            return x
        kept = np.array(x)
        moved = kept[..., rigid] * ~np.isin(rigid, self.pinned)
        kept[..., rigid] = 0.0
        return np.asarray(kept + moved @ self.rigid.motions.T)

    def excess(self, slip: FloatArray, load_factor: float) -> FloatArray:
        """Violation (positive) or distance to the limit (negative) of every cone, or row, [force]."""
        rows = self.G @ slip + load_factor * self.d - self.g
        if len(self.heads) == len(rows):
            return rows
        excess, disc = rows[self.heads], self.cones == CONE
        first = self.heads[disc]
        excess[disc] += np.hypot(rows[first + 1], rows[first + 2])  # of a disc |q| − f p
        return np.asarray(excess)

    def relative_excess(self, slip: FloatArray, load_factor: float) -> FloatArray:
        """``excess`` relative to the largest term of each cone, or row."""
        of_slip = np.abs(self.G) @ np.abs(slip) if slip.any() else 0.0  # many entries of G
        terms = np.maximum(of_slip, np.abs(load_factor * self.d))
        size = np.maximum(terms, np.abs(self.g))
        if len(self.heads) < len(size):
            size = np.maximum.reduceat(size, self.heads)
        return self.excess(slip, load_factor) / np.where(size > 0, size, 1.0)


@once_per_problem
def constraints(problem: Problem) -> Constraints:
    """The extremal limits of a problem, with all nodes in contact; built once per problem.

    With one direction only the extreme sample of the loading loop enters, one per row: an LP over
    every load step (thesis (5.16)) has the same solutions. With two, of every node the load steps
    that none of the others implies (:meth:`~shakedown.joint.law.Law.extreme_steps`).

    Examples
    --------
    >>> import shakedown
    >>> rows = constraints(shakedown.example("two-node"))
    >>> rows.G.shape, rows.node, rows.side
    ((4, 2), array([0, 0, 1, 1]), array([ 1, -1,  1, -1]))
    """
    loop, taken = loading(problem), step_loads(problem)
    left = np.broadcast_to(problem.law.cone(loop.q0, loop.p0), taken.shape)
    return _extremal(problem, taken, left, taken.argmax(axis=0), (loop.q1, loop.p1))


def pressure_stiffness(problem: Problem) -> FloatArray:
    """B, (n, dn) [force/length], zero in rows of nodes without friction that are round-off of the stiffness.

    Such a row is the pressure of a single node; nothing beside it shows that it is round-off: a slip
    of 10¹⁷ would press a node that no slip presses. |B_ij| counts beside √(A_ii A_jj).

    Examples
    --------
    >>> loop = {"q_w": [[0.0, 1.0], [0.0, -1.0]], "p_w": [[1.0, 1.0], [2.0, 2.0]]}
    >>> joint = Problem(A=2 * np.eye(2), B=[[1e-17, 0.0], [0.0, 1e-17]], f=[0.0, 0.5], **loop)
    >>> pressure_stiffness(joint)
    array([[0.e+00, 0.e+00],
           [0.e+00, 1.e-17]])
    """
    frictionless, roots = problem.law.frictionless, np.sqrt(np.maximum(np.diagonal(problem.A), 0.0))
    own = problem.layout.by_node(roots).max(axis=-1)[frictionless]
    felt = np.any(np.abs(problem.B[frictionless]) > ROUND_OFF * own[:, None] * roots, axis=1)
    if felt.all():
        return problem.B
    kept = problem.B.copy()
    kept[frictionless[~felt]] = 0.0
    return kept


def stacked(one: Constraints, other: Constraints) -> Constraints:
    """The rows of both constraints, in the columns of the first."""
    parts = ("d", "g", "node", "side", "step")
    both: dict[str, Any] = {part: np.append(getattr(one, part), getattr(other, part)) for part in parts}
    return replace(one, G=np.vstack([one.G, other.G]), **both)


def _extremal(
    problem: Problem,
    taken: FloatArray,
    left: FloatArray,
    worst: NDArray[np.intp],
    path: tuple[FloatArray, FloatArray],
) -> Constraints:
    """The rows that imply those of all load steps, and the least pressures of nodes without friction.

    ``taken`` and ``left`` (m, r) are what load steps take from the slack, and what they leave; ``worst`` (r,)
    the load step that takes most from a half-space, ``path`` the load (q, p).
    """
    law, n = problem.law, problem.n
    pressures = law.rows * n + np.arange(len(law.frictionless))
    if problem.directions > 1:
        node, step = (each.repeat(CONE) for each in law.extreme_steps(*path))
        row = CONE * node + np.tile(np.arange(CONE), len(node) // CONE)
        side = np.full(len(node), Side.DISC)
    else:
        node, row, side = np.repeat(np.arange(n), 2), np.arange(2 * n), np.tile(SIDES, n)
        step = worst[row]
    steps, rows = np.append(step, worst[pressures]), np.append(row, pressures)
    return Constraints(
        G=law.stiffness(problem.A, pressure_stiffness(problem))[rows],
        d=taken[steps, rows],
        g=left[steps, rows],
        node=np.append(node, law.frictionless),
        side=np.append(side, np.full(len(law.frictionless), Side.PRESSURE)),
        step=steps,
        rigid=rigid_slips(problem),
    )


def step_loads(problem: Problem) -> FloatArray:
    """The coefficients of the load factor in the rows of every node at every load step, (m, r).

    With one direction their largest over the loop are the ``d`` of :func:`constraints` [force].
    """
    loop = loading(problem)
    return problem.law.load_terms(loop.q1, loop.p1)


@once_per_problem
def through_transient(problem: Problem) -> Constraints:
    """The extremal limits of the loop, and those of the transient load steps before it.

    The load factor does not scale the transient: d = 0 there. A slip that keeps all of these
    limits is safe before the transient, one that keeps those of the loop alone only after it.

    Examples
    --------
    >>> import shakedown
    >>> block = shakedown.example("receding-block")
    >>> constraints(block).G.shape, through_transient(block).G.shape
    ((66, 33), (132, 33))
    """
    rows = constraints(problem)
    if problem.q_transient is None or problem.p_transient is None or not len(problem.q_transient):
        return rows
    path = problem.q_transient, problem.p_transient
    left = problem.law.cone(*path)
    before = _extremal(problem, np.zeros_like(left), left, left.argmin(axis=0), path)
    return stacked(rows, replace(before, step=before.step - len(left)))


def rows_of(nodes: int | NDArray[np.intp]) -> NDArray[np.intp]:
    """The backward and the forward row of a node of a joint in the plane, (2,); of several, (…, 2)."""
    return 2 * np.asarray(nodes)[..., None] + np.arange(2)


def by_side(rows: NDArray[Any]) -> NDArray[Any]:
    """Values of the 2n rows of friction in the plane, by node and side, backward first, (n, 2, …)."""
    return rows.reshape(-1, 2, *rows.shape[1:])


def rows_named(rows: Constraints, indices: NDArray[np.intp]) -> tuple[tuple[int, int], ...]:
    """(node, side) of some rows, in order, each once."""
    return tuple(dict.fromkeys((int(rows.node[i]), int(rows.side[i])) for i in sorted(indices)))
