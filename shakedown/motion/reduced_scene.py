"""What a scene needs: nodes that can never separate, and nodes that can never reach a friction limit.

At any time of a scene the state satisfies |q| ≤ f p and w ≥ 0 at every node, and
the load is a convex combination of the load steps (and of the start of the
initial ramp). Over this polyhedron of v, w and weights a linear program gives
the smallest normal reaction of a node, or its least distance from a limit. As
long as no node of a set has moved, all of them have their initial slips and no
gaps; if every one of them then keeps a distance from its limits (or from
p = 0), none is ever the first to move. The largest such sets are found by
starting from all nodes and leaving out those that can move, until nothing
changes. Jumps are not covered: their states are not in equilibrium.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.joint.arguments import check_load_factor, checked, checked_initial_slip, require_plane
from shakedown.joint.loading import loading, loop_path, ramp_start, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.motion.contact_law import scales
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import solve


@dataclass(frozen=True, eq=False, repr=False)
class Scene(Result):
    """A problem at one load factor and initial slip, reduced to the nodes that can move.

    Attributes
    ----------
    problem
        The reduced problem: nodes that no LP shows to be stuck for ever; the
        others a constant part of its loading. Without C where none of its
        nodes can separate.
    moving : (n,)
        Nodes of the full problem that are kept.
    separable : (n,)
        Nodes that no LP shows to stay closed.
    initial_slip : (n,)
        Slip at the start, which the fixed nodes keep [length].
    clearance : (n,)
        Least distance of the fixed nodes from their limits, NaN at the others,
        relative to the force scale.
    normal : (n,)
        Least normal reaction of the moving nodes that stay closed, NaN at the
        others, relative to the force scale.
    """

    DOCUMENT: ClassVar[str] = "moving separable initial_slip clearance normal"

    problem: Problem
    moving: NDArray[np.bool_]
    separable: NDArray[np.bool_]
    initial_slip: FloatArray
    clearance: FloatArray
    normal: FloatArray

    def spread(self, values: NDArray[Any], rest: ArrayLike) -> NDArray[Any]:
        """Values of the moving nodes (last axis) in the order of all nodes, ``rest`` at the others."""
        out = np.empty((*values.shape[:-1], len(self.moving)), dtype=values.dtype)
        out[...] = rest
        out[..., self.moving] = values
        return out


@checked
def reduced_scene(problem: Problem, load_factor: float, initial_slip: ArrayLike | None = None) -> Scene:
    """Leave out of a problem what cannot happen at a load factor from an initial slip.

    Parameters
    ----------
    problem, load_factor
        The joint and λ.
    initial_slip : (n,), optional
        Slip at the start [length]; zero by default.

    Examples
    --------
    >>> import shakedown
    >>> scene = reduced_scene(shakedown.example("two-node"), 0.9)
    >>> scene.moving, scene.separable
    (array([ True,  True]), array([ True, False]))
    """
    require_plane("reduced scene", problem)
    check_load_factor(load_factor, problem)
    start = checked_initial_slip(problem, initial_slip)
    states = _States(problem, load_factor, start)
    closed, fixed = np.ones(problem.n, dtype=bool), np.ones(problem.n, dtype=bool)
    while True:  # ends: every round frees a node, or lets one open
        clearance = states.least(closed, fixed, fixed, states.clearance)
        normal = states.least(closed, fixed, closed & ~fixed, states.normal)
        can_slip, can_open = fixed & (clearance <= NEGLIGIBLE), closed & ~fixed & (normal <= NEGLIGIBLE)
        if not (can_slip | can_open).any():
            break
        fixed &= ~can_slip
        closed &= ~can_open
    moving = ~fixed
    if not moving.any():
        moving[0] = True  # a problem has at least one node
        clearance[0] = np.nan
    return Scene(
        problem=_reduced(problem, moving, bool((moving & ~closed).any()), start),
        moving=moving,
        separable=~closed,
        initial_slip=start,
        clearance=np.where(moving, np.nan, clearance),
        normal=np.where(closed & moving, normal, np.nan),
    )


class _States:
    """The polyhedron of slips v, gaps w and weights of load steps, and least values over it."""

    def __init__(self, problem: Problem, load_factor: float, start: FloatArray) -> None:
        self.n, self.start, layout = problem.n, start, problem.layout
        self.scale = scales(problem, load_factor)
        loads = [transient_path(problem), loop_path(problem, load_factor)]
        at_rest = layout.joined(start, np.zeros(self.n))
        loads.insert(0, ramp_start(problem, np.vstack(loads)[0], at_rest)[None])
        self.loads = np.unique(np.vstack(loads), axis=0) / self.scale.force
        q_w, p_w = layout.split(self.loads)
        C = np.zeros_like(problem.A) if problem.C is None else problem.C
        unit = self.scale.length / self.scale.force
        # reactions in units of force per unknown: slips, gaps (units of length), weights
        q = np.hstack([problem.A * unit, problem.B.T * unit, q_w.T])
        self.p = np.hstack([problem.B * unit, C * unit, p_w.T])
        rows = problem.law.of_nodes(problem.law.cone(q.T, self.p.T))
        self.sides = np.ascontiguousarray(np.moveaxis(rows, 0, -1))

    def normal(self, i: int) -> FloatArray:
        """Normal reaction of node i as rows of costs."""
        return self.p[i][None]

    def clearance(self, i: int) -> FloatArray:
        """Distances of node i from its two limits as rows of costs."""
        return self.sides[i]

    def least(
        self,
        closed: NDArray[np.bool_],
        fixed: NDArray[np.bool_],
        nodes: NDArray[np.bool_],
        costs: Callable[[Any], FloatArray],
    ) -> FloatArray:
        """Least value of the costs of each of the nodes; −inf where there is none."""
        n, m, start = self.n, len(self.loads), self.start / self.scale.length
        lower = np.concatenate([np.where(fixed, start, -INF), np.zeros(n), np.zeros(m)])
        upper = np.concatenate([np.where(fixed, start, INF), np.where(closed, 0.0, INF), np.ones(m)])
        used = np.flatnonzero(lower < upper)
        constant = np.where(lower == upper, np.where(np.isfinite(lower), lower, 0.0), 0.0)
        rows = np.vstack([self.sides[:, 0], self.sides[:, 1], self.p])
        sum_row = np.concatenate([np.zeros(rows.shape[1] - m), np.ones(m)])
        matrix = np.vstack([rows, sum_row])
        out = np.full(n, np.nan)
        for i in np.flatnonzero(nodes):
            values = []
            for cost in costs(i):
                program = Program(
                    matrix[:, used],
                    np.append(np.full(len(rows), INF), 1.0),
                    cost=cost[used],
                    left=np.append(-(rows @ constant), 1.0),
                    lower=lower[used],
                    upper=upper[used],
                )
                end = solve(program)
                values.append(cost[used] @ end.x + cost @ constant if end.optimal else -np.inf)
            out[i] = min(values)
        return out


def _reduced(problem: Problem, moving: NDArray[np.bool_], separable: bool, start: FloatArray) -> Problem:
    """The problem of the moving nodes, the others at their initial slips."""
    locked = np.where(moving, 0.0, start)
    q, p = (problem.A @ locked)[moving], (problem.B @ locked)[moving]
    loop = loading(problem)
    block = np.ix_(moving, moving)

    def shifted(samples: FloatArray | None, by: FloatArray) -> FloatArray | None:
        return None if samples is None else samples[..., moving] + by

    return Problem(
        name=problem.name,
        units=problem.units,
        source=problem.source,
        load_names=problem.load_names,
        load_mean=problem.load_mean,
        load_amplitude=problem.load_amplitude,
        load_units=problem.load_units,
        load_path=problem.load_path,
        **problem.node_data(np.flatnonzero(moving)),
        A=problem.A[block],
        B=problem.B[block],
        C=problem.C[block] if separable and problem.C is not None else None,
        q_w=problem.q_w[:, moving] + q,
        p_w=problem.p_w[:, moving] + p,
        q_mean=loop.q0[moving] + q,
        p_mean=loop.p0[moving] + p,
        q_transient=shifted(problem.q_transient, q),
        p_transient=shifted(problem.p_transient, p),
    )
