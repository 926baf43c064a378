"""One-sided derivatives of the largest load factor that rows allow, from an optimum and its multipliers."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from shakedown.ground.errors import SolverError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.programs.program import INF, Program, ball
from shakedown.programs.scaling import equilibration
from shakedown.programs.solver import solve

SAME = 10 * NEGLIGIBLE  # relative to the terms of a derivative: differences between optima that are no kink


@dataclass(frozen=True)
class OneSidedOptimum:
    """The rows that are reached at an optimum of max λ, to first order: W x' + d λ' ≤ what a parameter gains.

    With the envelope theorem λ' is the gain weighted with the multipliers. Where there are several
    multipliers y, or several optimal x, it is max over x, min over y (Gol'shtein), one linear program.

    Attributes
    ----------
    W : (k, N)
        Slopes of the rows reached, over the unknowns x [force/unit of x].
    d : (k,)
        Their coefficients of λ [force].
    multipliers : (k,)
        Some y ≥ 0 with Wᵀ y = 0 and dᵀ y = 1; with a ``tip`` ‖Wᵀ y‖ ≤ tipᵀ y.
    tip : (k,)
        Where the optimum is the tip of a cone: what ‖x'‖ takes from the rows; else zero.
    rows, slack
        All rows (K, N) and their slacks (K,), which keep x; None where x is bent by a cone.
    ray : (N,)
        With a cone the only direction along which x can be changed at all.
    tolerances
        Those of the programs; ``degeneracy`` decides what is regular.
    programs
        Whether a derivative may take a program of its own.
    """

    W: FloatArray
    d: FloatArray
    multipliers: FloatArray
    tip: FloatArray
    rows: FloatArray | None
    slack: FloatArray
    ray: FloatArray | None
    tolerances: Tolerances
    programs: bool

    def derivative(self, gain: FloatArray, turn: FloatArray) -> FloatArray:
        """dλ as a parameter falls, and as it grows, (2,), per unit of it; NaN where there is none.

        Parameters
        ----------
        gain : (k, 2)
            Change of the slack of the rows as the parameter falls, and as it grows.
        turn : (k, N)
            How the change as it grows varies with x.
        """
        return np.array([-self._rate(gain[:, 0], -turn), self._rate(gain[:, 1], turn)])

    def _rate(self, gain: FloatArray, turn: FloatArray) -> float:
        moves = turn.any() and not self._stays(turn)
        if not moves and (self._determined or not gain.any()):
            return float(self.multipliers @ gain)
        if moves and self.rows is None:
            return float("nan")
        if not self.programs:
            raise SolverError(
                "its optimum is degenerate, and every derivative there needs a program of its own"
            )
        return self._by_program(gain, turn if moves else np.zeros_like(turn))

    @cached_property
    def _columns(self) -> FloatArray:
        sizes = np.abs(self.W).max(axis=0, initial=0.0)
        return np.where(sizes > 0, 1.0 / np.where(sizes > 0, sizes, 1.0), 1.0)

    @cached_property
    def _determined(self) -> bool:
        """Whether the multipliers are unique."""
        if len(self.d) == 1:
            return True
        matrix = np.column_stack([self.W, self.d])
        row, column = equilibration(matrix, self.tolerances.equilibration_sweeps)
        values = np.linalg.svd(matrix * row[:, None] * column, compute_uv=False)
        regular = values > SAME * values[0]
        return not self.tip.any() and int(regular.sum()) == len(self.d)

    @cached_property
    def _elsewhere(self) -> FloatArray:
        """Directions (N, q) in which x may change and stay optimal."""
        share = self.multipliers * np.abs(self.W).max(axis=1, initial=0.0)
        held = self.W[share > SAME * share.max(initial=0.0)] * self._columns
        if self.ray is not None:
            moved, terms = held @ (self.ray / self._columns), np.abs(held) @ np.abs(self.ray / self._columns)
            return (
                self.ray[:, None] if np.all(np.abs(moved) <= SAME * terms) else np.zeros((len(self.ray), 0))
            )
        values, directions = np.linalg.svd(held / np.abs(held).max(axis=1, keepdims=True))[1:]
        rank = int((values > SAME * values.max(initial=0.0)).sum())
        return (directions[rank:] * self._columns).T

    def _stays(self, turn: FloatArray) -> bool:
        """Whether all optimal x have the same gain."""
        moved, terms = turn @ self._elsewhere, np.abs(turn) @ np.abs(self._elsewhere)
        return bool(np.all(np.abs(moved) <= SAME * terms))

    def _by_program(self, gain: FloatArray, turn: FloatArray) -> float:
        """Max λ' over the changes x', and over other optima x + w where their gains differ."""
        size, cones = self.W.shape[1], tuple[int, ...]()
        if self.tip.any():
            matrix = np.column_stack([self.W, self.tip, self.d])
            matrix = np.vstack([matrix, ball(size, size + 2)])
            right, cones = np.append(gain, np.zeros(size + 1)), (size + 1,)
        else:
            matrix, right = np.column_stack([self.W, self.d]), gain
            if turn.any() and self.rows is not None:
                matrix = np.hstack([-turn, matrix])
                keep = np.hstack([self.rows, np.zeros((len(self.rows), size + 1))])
                matrix, right = np.vstack([matrix, keep]), np.append(gain, self.slack)
        cost = np.append(np.zeros(matrix.shape[1] - 1), -1.0)
        end = solve(Program(matrix, right, cost, cones, lower=np.array(-INF), tolerances=self.tolerances))
        return float(end.x[-1]) if end.status == Status.OPTIMAL else float("nan")
