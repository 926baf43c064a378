"""The swing bound in exact arithmetic: multipliers that balance without round-off."""

from importlib import import_module
from typing import TYPE_CHECKING

import numpy as np

from shakedown.model.loading import loading
from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.integer_algebra import enclosure
from shakedown.programs.linear_program import Solution
from shakedown.universal.admissible_states import different_steps

if TYPE_CHECKING:
    from flint import fmpq

Line = tuple["fmpq", "fmpq"]  # value at λ = 0, slope


def proved_swing(problem: Problem, ends: list[tuple[Solution, Solution]]) -> float | None:
    """A load factor below which forward and backward slip of every node are apart, without round-off.

    The rows that a float solution ended on are taken as equalities and solved exactly for the
    multipliers. Where these have the right signs and balance every column, they bound (A v)_i by
    a line in λ, for every λ; forward and backward line of a node meet in a rational number.

    Parameters
    ----------
    problem
        The problem as stored: every float is a rational number.
    ends
        Per node, how the programs of its forward and of its backward slip ended.

    Returns
    -------
        The largest float that is proved, or None where some program did not end in multipliers
        that are exactly right.
    """
    exact, proved = ExactStates(problem), None
    for node, pair in enumerate(ends):
        lines = [exact.line(2 * node + 1, -1, pair[0]), exact.line(2 * node, 1, pair[1])]
        if lines[0] is None or lines[1] is None:
            return None
        value, slope = lines[0][0] + lines[1][0], lines[0][1] + lines[1][1]
        if slope < 0:
            meet = -value / slope
            proved = meet if proved is None or meet < proved else proved
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
        fB, taken = f[:, None] * B, different_steps(problem)
        self.G = np.stack([A - fB, -A - fB], axis=1).reshape(2 * n, n)
        self.g = np.stack([f * p0 - q0, f * p0 + q0], axis=1).reshape(2 * n)
        self.S = np.stack([q - f * p, -q - f * p], axis=2).reshape(len(q), 2 * n)[taken].T

    def line(self, row: int, sign: int, end: Solution) -> Line | None:
        """A line in λ below sign · (A v)_i over the states with one row of node i active."""
        n, k = self.n, self.S.shape[1]
        active, free = [int(i) for i in end.active], [int(j) for j in end.free]
        if end.status != "optimal" or len(active) != len(free) or n + k in free:
            return None
        columns = {j: self._column(j) for j in range(n + k)}
        cost = [sign * x for x in self.A[row // 2]]
        fmpq_mat = self._flint.fmpq_mat
        square = fmpq_mat([[columns[j][i] for i in active] for j in free])
        try:
            solved = square.solve(fmpq_mat([[cost[j] if j < n else self._zero] for j in free]))
        except ZeroDivisionError:
            return None
        y = dict(zip(active, solved.entries(), strict=True))
        if any(weight > 0 for i, weight in y.items() if i != row):
            return None
        for j in set(range(n + k)) - set(free):
            reduced = (cost[j] if j < n else self._zero) - sum(
                (w * columns[j][i] for i, w in y.items()), self._zero
            )
            if reduced < 0 or (j < n and reduced != 0):
                return None
        value = sum((weight * self.g[i] for i, weight in y.items() if i < 2 * n), self._zero)
        return value, y.get(2 * n, self._zero)

    def _column(self, j: int) -> list["fmpq"]:
        """A column of the program, its last row Σ α ≤ λ."""
        if j < self.n:
            return [*self.G[:, j], self._zero]
        return [*self.S[:, j - self.n], self._zero + 1]

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
