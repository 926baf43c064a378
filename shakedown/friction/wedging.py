"""Wedging: slips locked in without any load (thesis §4.3.2)."""

from dataclasses import dataclass

import numpy as np

from shakedown.model.problem import FloatArray, Problem
from shakedown.programs.linear_program import INF, LinearProgram

LARGEST_PROBLEM = 100  # nodes
LARGEST = 1e8  # coefficient up to which a wedged state is looked for
ROUND_OFF = 1e-11  # reactions, relative to the terms of their sum, that count as zero
CLOSE = 1e-9  # relative gap at which the search ends


@dataclass(frozen=True)
class Wedging:
    """The friction coefficient from which on a joint can hold itself wedged.

    Attributes
    ----------
    low, high
        Below ``low`` no slip v ≠ 0 has |A v| ≤ f B v, for ``high`` the witness
        has; infinite where none has for any friction.
    slip : (n,)
        The witness: locked-in slip, scaled to max |v| = 1; NaN where there is none.
    """

    low: float
    high: float
    slip: FloatArray

    @property
    def value(self) -> float:
        """The threshold; NaN where only an interval is known."""
        return self.high if self.low >= self.high * (1 - 2 * CLOSE) or self.low == self.high else np.nan


def wedging_threshold(problem: Problem, phi: FloatArray) -> Wedging:
    """Smallest t for which some v ≠ 0 satisfies |A v| ≤ t φ B v, by linear programs in v with Σ B v = 1.

    Each witness gives an upper value t = max |A v|_j / (φ B v)_j, and the program just below
    t the next witness, or the proof that there is none (Dinkelbach's method).

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> wedged = wedging_threshold(shakedown.example("one-node"), np.ones(1))
    >>> round(wedged.value, 6)
    2.0
    """
    none = np.full(problem.n, np.nan)
    if problem.n > LARGEST_PROBLEM:  # the programs would take minutes
        return Wedging(0.0, np.inf, none)
    if not problem.B.any():
        return Wedging(np.inf, np.inf, none)
    scale = np.abs(problem.A).max() / np.abs(problem.B).max()
    slip = wedged_slip(problem, phi, LARGEST * scale)
    if slip is None:
        return Wedging(np.inf, np.inf, none)
    while True:
        high = friction_used(problem, phi, slip)
        if not np.isfinite(high):  # pressure of the size of round-off only: a rigid motion
            return Wedging(np.inf, np.inf, none)
        if high <= CLOSE * scale:
            return Wedging(0.0, high, slip / np.abs(slip).max())
        below = high * (1 - CLOSE)
        better = wedged_slip(problem, phi, below)
        if better is None or friction_used(problem, phi, better) >= high:
            return Wedging(below, high, slip / np.abs(slip).max())
        slip = better


def friction_used(problem: Problem, phi: FloatArray, slip: FloatArray) -> float:
    """Smallest t with |A v| ≤ t φ B v for a given v; infinite where there is none."""
    q, p = np.abs(problem.A @ slip), phi * (problem.B @ slip)
    no_q = ROUND_OFF * (np.abs(problem.A) @ np.abs(slip))
    no_p = ROUND_OFF * phi * (np.abs(problem.B) @ np.abs(slip))
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where(p > no_p, q / p, np.where((q <= no_q) & (p >= -no_p), 0.0, np.inf))
    return float(ratios.max())


def wedged_slip(problem: Problem, phi: FloatArray, t: float) -> FloatArray | None:
    """A v with Σ B v > 0 that satisfies |A v| ≤ t φ B v with most to spare; None where none does.

    All stiffnesses are divided by their size, so that v and what is to spare are numbers near 1.
    """
    n, A, B = problem.n, problem.A, t * phi[:, None] * problem.B
    size = np.abs(A).max() + np.abs(B).max()
    A, B, row = A / size, B / size, np.full((n, 1), -1.0)
    pressure = problem.B.sum(axis=0) / np.abs(problem.B).max()
    matrix = np.vstack([np.hstack([A - B, row]), np.hstack([-A - B, row]), [[*pressure, 0.0]]])
    program = LinearProgram(
        matrix,
        cost=np.append(np.zeros(n), 1.0),
        lower=np.append(np.full(2 * n, -INF), 1.0),
        upper=np.append(np.zeros(2 * n), 1.0),
        column_lower=np.full(n + 1, -INF),
        column_upper=np.full(n + 1, INF),
    )
    outcome = program.solve()
    if outcome.vertex is None or outcome.vertex.x[n] > 1e-12:
        return None
    return outcome.vertex.x[:n]
