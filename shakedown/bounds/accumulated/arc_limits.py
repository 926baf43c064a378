"""How far nodes are from slipping in a direction, and what slip of other nodes takes from that."""

from typing import NamedTuple

import numpy as np

from shakedown.bounds.accumulated.lids import MARGIN, NoLids
from shakedown.bounds.accumulated.slip_arcs import Arcs, Numbers
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem

START = "start"


class Slacks(NamedTuple):
    """min(base − λ fall, before): the smallest slack under all loads up to a load factor.

    Attributes
    ----------
    base, fall, before : (…,)
        Under the mean load, what the load factor takes from it, and under the transient load steps [force].
    """

    base: FloatArray
    fall: FloatArray
    before: FloatArray

    @property
    def elastic(self) -> float:
        """The load factor at which the first slack that the mean load leaves is used up; inf without one."""
        falling = (self.fall > 0.0) & (self.base > 0.0)
        if falling.any():
            return float(np.min(self.base[falling] / self.fall[falling]))
        return np.inf if not self.fall.any() else 1.0

    def at(self, load_factor: float) -> FloatArray:
        """At a load factor, (…,)."""
        return np.minimum(self.base - load_factor * self.fall, self.before)


class ArcLimits:
    """The limits g_i(e) = f_i p_i + e · q_i of a joint about an initial slip, with margins above round-off.

    ``reach`` (n, n) bounds what slip of a node changes in the limit of another [force/length].
    """

    def __init__(self, problem: Problem, start: FloatArray, start_error: FloatArray) -> None:
        n, d = problem.n, problem.directions
        self.problem = problem
        self._fB = problem.law.limit_rows(problem.B).reshape(n, n, d)
        self._A = problem.A.reshape(n, d, n, d)
        self._start, self._error = start.reshape(n, d), start_error
        self.reach = np.linalg.norm(self._fB, axis=2) + np.linalg.norm(self._A, axis=(1, 3))

    def slacks(self, node: Numbers, e: FloatArray) -> Slacks:
        """Of nodes (c,) in directions (c, k, d), (c, k): at the initial slip, wherever within its error."""
        found = Slacks(*(np.empty(e.shape[:2]) for _ in Slacks._fields))
        for i in np.unique(node).tolist():
            for part, values in zip(found, self._slacks_of(i, e[node == i]), strict=True):
                part[node == i] = values
        return found

    def _slacks_of(self, i: int, e: FloatArray) -> Slacks:
        fB, A, start = self._fB[i], self._A[i], self._start
        locked = np.sum(fB * start) + e @ np.sum(A * start, axis=(1, 2))
        terms = np.sum(np.abs(fB * start)) + np.abs(e) @ np.sum(np.abs(A * start), axis=(1, 2))
        off = np.flatnonzero(self._error)
        rows = fB[off] + np.einsum("cke,ejx->ckjx", e, A[:, off])
        locked -= np.linalg.norm(rows, axis=3) @ self._error[off] + NEGLIGIBLE * terms
        loop, before = loading(self.problem), self.problem.layout.split(transient_path(self.problem))
        mean = self._least(i, e, loop.q0[None], loop.p0[None])
        fall = np.maximum(-self._least(i, e, loop.q1, loop.p1), 0.0)
        return Slacks(mean + locked, fall, self._least(i, e, *before) + locked)

    def _least(self, i: int, e: FloatArray, q: FloatArray, p: FloatArray) -> FloatArray:
        """The smallest f p + e · q over load steps, less a margin; inf where there is none."""
        q, p = self.problem.layout.by_node(q)[:, i].T, self.problem.f[i] * p[:, i]
        values = p + e @ q - NEGLIGIBLE * (np.abs(p) + np.abs(e) @ np.abs(q))
        return np.asarray(values.min(axis=-1, initial=np.inf))

    def check_pressed(self, load_factor: float) -> None:
        """Raise ``NoLids`` unless the first load presses all nodes, at every load factor up to one.

        The load rises to it under these pressures; where it admits the initial slip they are positive anyway.
        """
        problem, loop = self.problem, loading(self.problem)
        before = problem.layout.split(transient_path(problem))[1]
        first = before[:1] if len(before) else np.stack([loop.p0, loop.p0 + load_factor * loop.p1[0]])
        p = first.min(axis=0) + problem.B @ self._start.ravel()
        p -= np.linalg.norm(problem.B.reshape(*self._fB.shape), axis=2) @ self._error
        if not p.min() > 0.0:
            raise NoLids(START, int(p.argmin()))

    def slopes(self, node: Numbers, e: FloatArray, arcs: Arcs) -> FloatArray:
        """What slip in arcs at least adds to the limits of nodes (p,) in directions (p, d), (p, K)."""
        i = node[:, None]
        rows = self._fB[i, arcs.node]
        for x in range(e.shape[1]):
            rows += e[:, x, None, None] * self._A[i, x, arcs.node]
        return arcs.least(rows) - MARGIN * self.reach[i, arcs.node]
