"""A program without cones, kept for many solves: HiGHS from basis to basis, exact to round-off."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

import highspy
import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import DENSE_FROM, ROUND_OFF, FloatArray
from shakedown.ground.errors import SolverError
from shakedown.ground.status import Status
from shakedown.programs.dense_programs import meeting_rows
from shakedown.programs.exact_program import cleaned, polished, sharpened
from shakedown.programs.highs import (
    EXACT_RUNGS,
    OPTIONS,
    RUNGS,
    STATUSES,
    TOLERANCE,
    basis_of,
    made,
    meeting_of,
)
from shakedown.programs.program import INF, Meeting, Point, Program, Solution

FINER = 2.0**14  # factor on costs where HiGHS's tolerance leaves a notable reduced cost


class Simplex:
    """The state of a solver between solves of one program: its sides, bounds and cost may change.

    The data are handed to HiGHS once, equilibrated by powers of two, and every solve starts from the
    basis of the last. Where there is none yet and the program is large, dense interior points lead to
    it. The vertex is solved again from its active rows, so that it is exact to round-off and
    not only to the feasibility tolerance; what round-off leaves of a zero is zero.

    Examples
    --------
    >>> import numpy as np
    >>> held = Simplex(Program(np.array([[1.0, 2.0], [3.0, 1.0]]), np.array([4.0, 6.0]),
    ...     cost=np.array([-1.0, -1.0]), lower=np.zeros(2)))
    >>> held.solve().x
    array([1.6, 1.2])
    """

    def __init__(self, program: Program, *, dense: bool = True) -> None:
        """Hold a program; ``dense`` is for those whose first solve ends at an optimum, far from the start."""
        self.program, self.scales = program.scaled()
        self._may_be_dense = dense
        self._meeting: Meeting | None = None  # of the last vertex, if not found by the solver
        self._made: highspy.Highs | None = None

    @property
    def _highs(self) -> highspy.Highs:
        """The solver, created on first use, as none is needed where the active rows are known."""
        if self._made is None:
            self._made = made(self.program)
            if self._meeting is not None:
                self._made.setBasis(basis_of(self.program, self._meeting))
        return self._made

    def set_rows(self, rows: NDArray[np.intp], left: FloatArray, right: FloatArray) -> None:
        """Change the sides of some rows; the basis stays."""
        program, unit, size = self.program, self.scales.row[rows], self.scales.size
        program.left[rows], program.right[rows] = left * unit / size, right * unit / size
        if self._made:
            for i in rows:
                self._made.changeRowBounds(int(i), program.left[i], program.right[i])

    def solve(self) -> Solution:
        """Solve from the current basis.

        Raises
        ------
        SolverError
            If HiGHS ends without an answer, also from scratch, by the dual method and at loosened tolerances.
        """
        found = self._dense()
        if found is not None:
            self._meeting = found.meeting
            return found
        status, rung = self._warm(), 0
        while status is None and rung < len(RUNGS):
            status, rung = self._with(RUNGS[rung]), rung + 1
        if status is None and self._highs.getModelStatus() == highspy.HighsModelStatus.kUnbounded:
            status = Status.UNBOUNDED  # should not occur, but no method gives another answer
        if status is None:
            reason = self._highs.modelStatusToString(self._highs.getModelStatus())
            raise SolverError(f"the linear program of shape {self.program.matrix.shape} ended as '{reason}'")
        reduced = rung > EXACT_RUNGS
        if status == Status.OPTIMAL and not reduced:
            self._finish()
        basis = self._highs.getBasis()
        if status != Status.OPTIMAL:
            return self._end(status, np.nan, reduced, _nowhere, lambda: meeting_of(basis))
        solution = self._highs.getSolution()
        x, y = np.array(solution.col_value), -np.array(solution.row_dual)
        sharp = partial(_polished, x, y)
        return self._end(status, float(self.program.cost @ x), reduced, sharp, lambda: meeting_of(basis))

    def _end(
        self,
        status: Status,
        value: float,
        reduced: bool,
        point: Callable[[Solution], Point],
        meeting: Callable[[], Meeting],
    ) -> Solution:
        """A solution of the present program, unaffected by later changes of sides and bounds."""
        now = self.program
        kept = replace(
            now, left=now.left.copy(), right=now.right.copy(), lower=now.lower.copy(), upper=now.upper.copy()
        )
        return Solution(status, self.scales.value(value), reduced, kept, self.scales, point, meeting)

    def at(self, active: NDArray[np.intp], fixed: Iterable[int] = ()) -> Solution | None:
        """The vertex in which these rows meet, if it is optimal to the solver's tolerances.

        No solver is asked. Columns that are ``fixed``, and those without an entry, are at a bound, or
        zero where they have none; there must be as many rows as other columns. None where they have
        no vertex, where it breaks another row or bound, or where a multiplier has the wrong sign.
        """
        program = self.program
        held: NDArray[np.bool_] = np.asarray(~program.matrix.any(axis=0))
        held[list(fixed)] = True
        idle, meeting = np.flatnonzero(held), (active, np.flatnonzero(~held))
        x = np.zeros(len(held))
        low, high = program.lower[idle] > -INF, program.upper[idle] < INF
        x[idle] = np.select([low, high], [program.lower[idle], program.upper[idle]])
        try:
            x, y = sharpened(program, x, meeting)
        except np.linalg.LinAlgError:
            return None
        rest = (program.cost + y @ program.matrix)[idle]
        wrong = (
            np.where(program.right < INF, -y, y).max(initial=0.0),  # a limit can only push back
            np.select([low, high], [-rest, rest], np.abs(rest)).max(initial=0.0),
        )
        # a larger reduced cost is not round-off, and matters where slips are large
        if not (np.max(wrong) <= ROUND_OFF and program.violation(x) <= TOLERANCE):  # NaN is rejected, too
            return None
        point, value = (cleaned(program, x) * self.scales.x, y * self.scales.y), float(program.cost @ x)
        return self._end(Status.OPTIMAL, value, False, lambda _: point, lambda: meeting)

    def _dense(self) -> Solution | None:
        """The vertex found by dense interior points, where that is faster than the first simplex."""
        rows, columns = self.program.matrix.shape
        first = self._may_be_dense and not self._made and self._meeting is None
        if not first or not DENSE_FROM <= columns <= rows:
            return None  # a wide program would need a large square matrix
        sides = self.program.inequalities()
        matrix, right, named = (np.concatenate([part[k] for part in sides]) for k in range(3))
        found = meeting_rows(matrix, right, self.program.cost)
        if found is None:
            return None
        named = named[found]
        return self.at(np.sort(named[named >= 0]), -1 - named[named < 0])

    def _warm(self) -> Status | None:
        """Solve from the end of the last solve, optimal or infeasible: usually few pivots away."""
        self._highs.run()
        status = STATUSES.get(self._highs.getModelStatus())
        return None if status == Status.UNBOUNDED and self._limited() else status

    def _limited(self) -> bool:
        """Whether bounds limit all columns with a cost, so that the program cannot be unbounded."""
        best = np.where(self.program.cost > 0, self.program.lower, self.program.upper)
        return bool(np.all(np.isfinite(best[self.program.cost != 0])))

    def _finish(self) -> None:
        """Continue where a reduced cost exceeds round-off, since the solver neglects 1e-10.

        Along a slip with little resistance even that much can change the optimum.
        """
        if self._left_to_gain() <= ROUND_OFF:
            return
        basis, columns = self._highs.getBasis(), np.arange(len(self.program.cost), dtype=np.int32)
        self._highs.changeColsCost(len(columns), columns, self.program.cost * FINER)
        done = self._warm() == Status.OPTIMAL
        basis = self._highs.getBasis() if done else basis
        self._highs.changeColsCost(len(columns), columns, self.program.cost)
        self._highs.setBasis(basis)
        self._highs.run()

    def _left_to_gain(self) -> float:
        """The largest multiplier, of a row or of a column, with the wrong sign."""
        end = self._highs.getSolution()
        y, rest = np.array(end.row_dual), np.array(end.col_dual)
        x, program = np.array(end.col_value), self.program
        pulls = np.where(rest > 0, x > program.lower, x < program.upper) * np.abs(rest)
        limited = program.right < INF
        sides = np.where(limited & (program.left > -INF), 0.0, np.where(limited, y, -y))
        return float(max(pulls.max(initial=0.0), sides.max(initial=0.0)))

    def _with(self, options: dict[str, float]) -> Status | None:
        """Solve from scratch with other options, which are restored afterwards."""
        for name, value in options.items():
            self._highs.setOptionValue(name, value)
        self._highs.clearSolver()
        status = self._warm()
        for name in options:
            self._highs.setOptionValue(name, OPTIONS[name])
        return status


def _polished(x: FloatArray, y: FloatArray, end: Solution) -> Point:
    sharp = polished(end.solved, x, y, end.meeting)
    return sharp[0] * end.scales.x, sharp[1] * end.scales.y


def _nowhere(end: Solution) -> Point:
    rows, columns = end.solved.matrix.shape
    return np.full(columns, np.nan), np.full(rows, np.nan)
