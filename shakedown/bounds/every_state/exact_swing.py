"""The swing bound in exact arithmetic: multipliers that balance without round-off."""

from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.admissible_states import different_steps
from shakedown.bounds.every_state.swing_lines import SwingLines, limits_used
from shakedown.ground.float_array import FloatArray
from shakedown.joint.constraints import rows_of
from shakedown.joint.law import Law
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.integer_algebra import enclosure

if TYPE_CHECKING:
    from flint import fmpq

Line = tuple["fmpq", "fmpq"]  # value at λ = 0, slope


def proved_swing(problem: Problem, lines: SwingLines) -> float | None:
    """A load factor below which forward and backward slip of every node are apart, without round-off.

    The limits that carry the multipliers of a line are taken as equalities and solved exactly for
    them. Where these have the right signs and balance every column, they bound (A v)_i by
    a line in λ, for every λ; forward and backward line of a node meet in a rational number.

    Parameters
    ----------
    problem
        The problem as stored: every float is a rational number.
    lines
        The lines of all nodes in floats.

    Returns
    -------
        The largest float that is proved, or None where some multipliers are not exactly right.
    """
    exact, proved = ExactStates(problem), None
    if not exact.sure:
        return None
    for node, multipliers in enumerate(lines.multipliers):
        backward, forward = rows_of(node).tolist()
        found = [exact.line(forward, 1, multipliers[0]), exact.line(backward, -1, multipliers[1])]
        if found[0] is None or found[1] is None:
            return None
        value, slope = found[0][0] + found[1][0], found[0][1] + found[1][1]
        if slope > 0:
            meet = -value / slope
            proved = meet if proved is None or meet < proved else proved
        elif value >= 0:
            return 0.0
    if proved is None:
        return None
    low, _ = enclosure(int(proved.p), int(proved.q))
    return max(low, 0.0)


class ExactStates:
    """The rows of :class:`AdmissibleStates` as rational numbers."""

    def __init__(self, problem: Problem) -> None:
        self._flint = import_module("flint")
        n, f = problem.n, self._rationals(problem.f)
        A, B = self._rationals(problem.A), self._rationals(problem.B)
        q, q0 = self._split(problem.q_w, problem.q_mean, loading(problem).q1)
        p, p0 = self._split(problem.p_w, problem.p_mean, loading(problem).p1)
        self.n, self.A = n, A
        rigid = rigid_slips(problem)
        self.sure, self._pinned = not rigid.doubt, list(rigid.pinned)
        self._kept = np.setdiff1d(np.arange(n), rigid.pinned)
        law = Law(f)
        self.G, self.g = law.stiffness(A, B), law.cone(q0, p0)
        self.S = law.against(q, p)[different_steps(problem)].T

    def line(self, row: int, sign: int, multipliers: FloatArray) -> Line | None:
        """A line in λ above sign · (A v)_i over the states with one row of node i active."""
        if not np.isfinite(multipliers).all():  # the program did not finish
            return None
        node = row // 2
        rows = limits_used(multipliers, self.n)
        rows[node] = row
        y = self._balancing(rows, sign * self.A[node], multipliers[rows])
        if y is None:
            return None
        if any(weight < 0 for i, weight in zip(rows, y, strict=True) if i != row):
            return None
        value = sum((weight * self.g[i] for i, weight in zip(rows, y, strict=True)), self._zero)
        adds = [
            -sum((weight * self.S[i, k] for i, weight in zip(rows, y, strict=True)), self._zero)
            for k in range(self.S.shape[1])
        ]
        return value, max(adds)

    def _balancing(
        self, rows: NDArray[np.intp], target: np.ndarray, floats: FloatArray
    ) -> "list[fmpq] | None":
        """y with Σ y_j row_j = target in the columns that are not pinned.

        Of a body that can move as a whole as many multipliers are free: those of the pinned nodes keep
        the value that they have in floats.
        """
        kept, y = self._kept, self._rationals(floats)
        rest = target[kept] - (y[self._pinned, None] * self.G[rows[self._pinned]][:, kept]).sum(axis=0)
        square = self._flint.fmpq_mat(self.G[np.ix_(rows[kept], kept)].T.tolist())
        try:
            y[kept] = square.solve(self._flint.fmpq_mat([[x] for x in rest])).entries()
        except ZeroDivisionError:
            return None
        return list(y)

    @property
    def _zero(self) -> "fmpq":
        return self._flint.fmpq(0)

    def _rationals(self, array: FloatArray) -> np.ndarray:
        found = np.empty(array.shape, dtype=object)
        for place, x in np.ndenumerate(array):
            found[place] = self._flint.fmpq(*float(x).as_integer_ratio())
        return found

    def _split(
        self, samples: FloatArray, mean: FloatArray | None, periodic: FloatArray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Periodic part and mean; a column that ``loading`` takes as constant is constant here too."""
        exact = self._rationals(samples)
        constant = (
            exact.sum(axis=0) / self._flint.fmpq(len(samples)) if mean is None else self._rationals(mean)
        )
        moving = np.any(periodic != 0, axis=0).astype(int).astype(object)
        return (exact - constant) * moving, constant
