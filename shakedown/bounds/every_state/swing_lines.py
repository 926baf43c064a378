"""The range of A v in forward and backward slip of every node, as lines in the load factor."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.every_state.admissible_states import AdmissibleStates
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import ITERATIONS, SETTLED
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import rows_of
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.scaling import power_of_two

BALANCED = 64 * np.finfo(float).eps  # round-off of a balance of forces, relative to its terms


def limit_multipliers(problem: Problem, tolerances: Tolerances = DEFAULT) -> FloatArray:
    """Y with Yᵀ G = A_i for forward and −A_i for backward slip of node i, Y ≥ 0 but in the active row.

    By duality of linear programs (A v)_i ≤ Y · (g − S α) wherever node i can slip forward, whatever the
    load factor. While no state brings a node to both its limits the best multipliers use one limit of
    every node. With s_j = y_j⁺ − y_j⁻ they solve

        Aᵀ s − (f B)ᵀ |s| = ± A_i,    |s_i| replaced by ∓ s_i for the active row,

    an equation in absolute values, which has one solution where the motion is unique. It is iterated
    for all nodes at once; for a node for which that does not settle, by Newton's method, which changes
    the sides of the nodes until they are those that were assumed.

    Returns
    -------
    (n, 2, r)
        By node and by side, forward first; of the rows of all limits; NaN where neither iteration ends.

    Examples
    --------
    >>> import shakedown
    >>> Y = limit_multipliers(shakedown.example("three-node"))
    >>> Y[1, 0].round(6), limits_used(Y[1, 0], 3)
    (array([ 0.,  0.,  0., -1.,  0.,  0.]), array([0, 3, 4]))
    """
    n = problem.n
    size = np.array([power_of_two(float(np.sqrt(a))) for a in np.diagonal(problem.A)])
    found = np.full((n, 2, n, 2), np.nan)  # the limits by node and side
    A = problem.A / size / size[:, None]
    fB = problem.law.limit_rows(problem.B) / size / size[:, None]
    pinned = list(rigid_slips(problem).pinned)
    A[pinned], fB[:, pinned] = 0.0, 0.0  # no balance is required in the columns of pinned slips
    flexibility = np.linalg.pinv(A, rcond=tolerances.zero_mode, hermitian=not pinned)
    for side, sign in enumerate((1.0, -1.0)):
        s = _iterated(flexibility @ fB.T, sign)
        for i in np.flatnonzero(~_balanced(A, fB, s, sign)):
            s[:, i] = _corrected(A, fB, sign, int(i))
        s = np.where(_balanced(A, fB, s, sign), s, np.nan)
        s = s.T * size[:, None] / size
        own = np.diagonal(s)
        found[:, side] = np.stack([np.maximum(s, 0.0), np.maximum(-s, 0.0)], axis=2)
        active, other = (1, 0) if sign > 0 else (0, 1)
        nodes = np.arange(n)
        found[nodes, side, nodes, other] = np.where(np.isfinite(own), 0.0, np.nan)
        found[nodes, side, nodes, active] = -sign * own
    pressures = np.zeros((n, 2, len(problem.law.smooth)))  # not used: what the limits give is a bound
    return np.concatenate([found.reshape(n, 2, -1), pressures], axis=2)


def _iterated(influence: FloatArray, sign: float) -> FloatArray:
    """s of every node as columns; columns that have not settled after the last sweep are far from balance."""
    s = start = sign * np.eye(len(influence))
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(ITERATIONS):
            before, s = s, start + influence @ _folded(s, sign)
            if np.abs(s - before).max() <= SETTLED * np.abs(s).max():
                break
    return s


def _folded(s: FloatArray, sign: float) -> FloatArray:
    """|s|, but of either sign in the active row of each node."""
    folded = np.abs(s)
    np.fill_diagonal(folded, -sign * np.diagonal(s))
    return folded


def _balanced(A: FloatArray, fB: FloatArray, s: FloatArray, sign: float) -> NDArray[np.bool_]:
    """Which columns of s solve their equation to round-off."""
    with np.errstate(over="ignore", invalid="ignore"):
        terms = np.abs(A) @ np.abs(s) + np.abs(fB).T @ np.abs(s) + np.abs(A)
        rest = np.abs(A @ s - fB.T @ _folded(s, sign) - sign * A)
        return np.asarray(np.all(rest <= BALANCED * terms.max(axis=0), axis=0))


def _corrected(A: FloatArray, fB: FloatArray, sign: float, node: int) -> FloatArray:
    """s of one node, by Newton's method; NaN where it comes to no end."""
    side = np.where(np.arange(len(A)) == node, -sign, 1.0)
    for _ in range(ITERATIONS):
        try:
            s = _solved((A.T - side[:, None] * fB).T, sign * A[:, node])
        except np.linalg.LinAlgError:
            break
        before, side = side, np.where(s < 0, -1.0, 1.0)
        side[node] = -sign
        if np.array_equal(before, side):
            return np.asarray(s)
    return np.full(len(A), np.nan)


def _solved(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """The solution; the smallest one where no balance is asked for in some rows, which are zero."""
    asked = matrix.any(axis=1)
    if asked.all():
        return np.asarray(np.linalg.solve(matrix, right))
    return np.asarray(np.linalg.lstsq(matrix[asked], right[asked], rcond=None)[0])


def limits_used(multipliers: FloatArray, n: int) -> NDArray[np.intp]:
    """The limit of each of n nodes that carries its multiplier (…, n); the backward one where none does."""
    pairs = multipliers[..., : 2 * n].reshape(*multipliers.shape[:-1], -1, 2)
    backward = rows_of(np.arange(pairs.shape[-2]))[..., 0]
    return np.asarray(backward + (pairs[..., 1] != 0.0))


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
