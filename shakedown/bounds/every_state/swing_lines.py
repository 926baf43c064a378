"""How far A v can go in forward and in backward slip of every node: two lines in the load factor each."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.admissible_states import AdmissibleStates
from shakedown.bounds.every_state.limit_multipliers import limits_used
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import rows_of


@dataclass(frozen=True)
class SwingLines:
    """±(A v)_i ≤ value + λ slope in forward (+) and backward (−) slip of node i, for every λ ≥ 0.

    Attributes
    ----------
    multipliers : (n, 2, 2n)
        Y with Yᵀ G = ± A_i, ≥ 0 but in the active row, from which the lines follow.
    values, slopes : (n, 2)
        Y · g, and the most that a load of the loop adds to it, negative where each takes
        something away [force]; NaN where not known.
    steps : (n, 2)
        The column of the loads that adds most.
    """

    multipliers: FloatArray
    values: FloatArray
    slopes: FloatArray
    steps: NDArray[np.intp]

    def meetings(self) -> FloatArray:
        """Load factors below which forward and backward slip of each node are apart (n,); −inf if unknown."""
        value, slope = self.values.sum(axis=1), self.slopes.sum(axis=1)
        meeting = np.divide(-value, slope, out=np.full(len(value), inf), where=slope > 0)
        return np.where(np.isnan(value), -inf, np.where(value < 0, meeting, 0.0))


def known_lines(states: AdmissibleStates, multipliers: FloatArray) -> SwingLines:
    """The lines that follow from multipliers."""
    adds = -multipliers @ states.loads
    return SwingLines(multipliers, multipliers @ states.g, adds.max(axis=2), adds.argmax(axis=2))


def meeting_states(
    states: AdmissibleStates, lines: SwingLines, node: int, load_factor: float, tolerances: Tolerances
) -> tuple[FloatArray, FloatArray] | None:
    """The forward and the backward slip on which the lines of a node rest, if both are admissible.

    Then the node can slip both ways at the same A v where its lines meet, by duality. None also where
    the slips are so large, for example along a rigid motion, that round-off hides whether they are.
    """
    if not load_factor > -inf:
        return None
    pair: list[FloatArray] = []
    backward, forward = rows_of(node)
    for side, active in enumerate((forward, backward)):
        rows = limits_used(lines.multipliers[node, side], states.n)
        rows[node] = active
        right = states.g - load_factor * states.loads[:, lines.steps[node, side]]
        try:
            slip = np.asarray(np.linalg.solve(states.G[rows], right[rows]), dtype=float)
        except np.linalg.LinAlgError:
            return None
        if not _rests_on(states, right, rows, slip, tolerances):
            return None
        pair.append(slip)
    A_i = 0.5 * (states.G[backward] - states.G[forward])
    apart = np.abs(A_i @ (pair[0] - pair[1]))
    if not apart <= tolerances.feasibility * _force(states, load_factor):
        return None
    return pair[0], pair[1]


def _rests_on(
    states: AdmissibleStates,
    right: FloatArray,
    rows: NDArray[np.intp],
    slip: FloatArray,
    tolerances: Tolerances,
) -> bool:
    """Whether a slip keeps to every limit and reaches some, relative to the terms and to the forces."""
    excess = states.G @ slip - right
    terms = np.maximum((np.abs(states.G) * np.abs(slip)).max(axis=1), np.abs(states.g))
    near = tolerances.feasibility * np.minimum(terms, np.abs(right).max())
    return bool(np.all(excess <= near) and np.all(np.abs(excess[rows]) <= near[rows]))


def _force(states: AdmissibleStates, load_factor: float) -> float:
    """The largest force that the mean load or the loop brings at a load factor."""
    return float(max(np.abs(states.g).max(), load_factor * np.abs(states.loads).max()))
