"""The 2n frictional constraints in slip space and load factor."""

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.joint.derived import once_per_problem
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import ROUND_OFF, RigidSlips, rigid_slips

BACKWARD, FORWARD = +1, -1
GAP = 0  # the row of an open node: its gap
SIDE_NAMES = {BACKWARD: "backward", FORWARD: "forward", GAP: "gap"}


@dataclass(frozen=True, eq=False, repr=False)
class Constraints(Result):
    """Extremal frictional constraints G v + λ d ≤ g (thesis (5.3)–(5.7)).

    Row 2j is the backward-slip limit of node j (side +1, q = f p), row 2j + 1
    its forward-slip limit (side −1, q = −f p): the thesis's I, II, III, IV, …
    Programs over the rows take their coefficients from ``coefficients``, not from G: there the slips
    of a body that only friction holds are those relative to its pinned nodes.

    Attributes
    ----------
    G : (2n, n)
        Coefficients of the slip v [force/length].
    d : (2n,)
        Coefficients of the load factor λ, at the extreme load step [force].
    g : (2n,)
        Right-hand sides: the distance of the mean load from the limit [force].
    node, side, step : (2n,)
        Node, side (±1) and extreme load step of every row; of rows of transient load steps
        (:func:`through_transient`) the step counted from −k to −1, before the period.
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

    def __post_init__(self) -> None:
        for array in (self.G, self.d, self.g, self.node, self.side, self.step):
            array.setflags(write=False)

    @property
    def n(self) -> int:
        """Number of contact nodes."""
        return self.G.shape[1]

    @cached_property
    def coefficients(self) -> FloatArray:
        """G in the unknowns of programs, (2n, n): zero in the columns of pinned nodes.

        What a rigid slip changes in a gap stays: there the unknown is how far the body has moved.
        """
        kept, pinned = self.rigid.columns(self.G), list(self.rigid.pinned)
        gaps = np.flatnonzero(self.side == GAP)
        if pinned and gaps.size:
            terms = np.abs(self.G[gaps]) @ np.abs(self.rigid.motions)
            moved = self.G[gaps] @ self.rigid.motions
            kept[np.ix_(gaps, np.array(pinned))] = np.where(np.abs(moved) > ROUND_OFF * terms, moved, 0.0)
        return kept

    @cached_property
    def pinned(self) -> tuple[int, ...]:
        """The columns that are left out: the slips that are set to zero because no row knows them."""
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
        """Violation (positive) or distance to the limit (negative) of every row, (2n,) [force]."""
        return self.G @ slip + load_factor * self.d - self.g

    def relative_excess(self, slip: FloatArray, load_factor: float) -> FloatArray:
        """``excess`` relative to the largest term of each row, (2n,)."""
        terms = np.maximum(np.abs(self.G) @ np.abs(slip), np.abs(load_factor * self.d))
        size = np.maximum(terms, np.abs(self.g))
        return self.excess(slip, load_factor) / np.where(size > 0, size, 1.0)


@once_per_problem
def constraints(problem: Problem) -> Constraints:
    """The 2n extremal rows of a problem, with all nodes in contact; built once per problem.

    Of the loading loop only the extreme samples enter, one per row: an LP over
    every load step (thesis (5.16)) has the same solutions.

    Examples
    --------
    >>> import shakedown
    >>> rows = constraints(shakedown.example("two-node"))
    >>> rows.G.shape, rows.node, rows.side
    ((4, 2), array([0, 0, 1, 1]), array([ 1, -1,  1, -1]))
    """
    n, f, fB = problem.n, problem.f, problem.f[:, None] * problem.B
    loop, steps = loading(problem), step_loads(problem)
    return Constraints(
        G=_interleaved(problem.A - fB, -(problem.A + fB)),
        d=steps.max(axis=0),
        g=_interleaved(f * loop.p0 - loop.q0, f * loop.p0 + loop.q0),
        node=np.repeat(np.arange(n), 2),
        side=np.tile([BACKWARD, FORWARD], n),
        step=steps.argmax(axis=0),
        rigid=rigid_slips(problem),
    )


def step_loads(problem: Problem) -> FloatArray:
    """The coefficients of the load factor in the 2n rows at every load step, (m, 2n) [force].

    Their largest over the loop are the ``d`` of :func:`constraints`.
    """
    loop, f = loading(problem), problem.f
    return np.stack([loop.q1 - f * loop.p1, -loop.q1 - f * loop.p1], axis=2).reshape(problem.m, -1)


@once_per_problem
def through_transient(problem: Problem) -> Constraints:
    """The extremal rows of the loop, and those of the transient load steps before it, (2n,) or (4n,).

    The load factor does not scale the transient: d = 0 there. A slip that keeps all of these
    rows is safe before the transient, one that keeps those of the loop alone only after it.

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
    reach = problem.f * problem.p_transient
    room = np.stack([reach - problem.q_transient, reach + problem.q_transient], axis=2)
    room = room.reshape(len(room), -1)
    return replace(
        rows,
        G=np.vstack([rows.G, rows.G]),
        d=np.append(rows.d, np.zeros_like(rows.d)),
        g=np.append(rows.g, room.min(axis=0)),
        node=np.tile(rows.node, 2),
        side=np.tile(rows.side, 2),
        step=np.append(rows.step, room.argmin(axis=0) - len(room)),
    )


def rows_named(rows: Constraints, indices: NDArray[np.intp]) -> tuple[tuple[int, int], ...]:
    """(node, side) of some rows, in order, each once."""
    return tuple(dict.fromkeys((int(rows.node[i]), int(rows.side[i])) for i in sorted(indices)))


def _interleaved(backward: NDArray, forward: NDArray) -> NDArray:
    return np.stack([backward, forward], axis=1).reshape(2 * len(backward), *backward.shape[1:])
