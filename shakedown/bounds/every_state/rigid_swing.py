"""How far the proof of the swing bound holds for the rigid motions of a floating body."""

from math import inf

import numpy as np

from shakedown.bounds.every_state.admissible_states import AdmissibleStates, StateProgram
from shakedown.bounds.every_state.swing_lines import SwingLines, known_lines
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import solve

TANGENTS = 8  # largest number per node


def rigid_motions(problem: Problem, tolerances: Tolerances = DEFAULT) -> FloatArray:
    """Slips that A does not resist, as columns (n, r): r = 0 but for floating bodies.

    They are the rigid slips, and whatever else A does not resist although it changes pressures.
    """
    known = rigid_slips(problem)
    kept = np.setdiff1d(np.arange(problem.n), known.pinned)
    values, vectors = np.linalg.eigh(problem.A[np.ix_(kept, kept)])
    soft = vectors[:, values <= tolerances.zero_mode * values.max(initial=0.0)]
    more = np.zeros((problem.n, soft.shape[1]))
    more[kept] = soft
    return np.hstack([known.motions, more])


def limited_rigidly(
    problem: Problem, states: AdmissibleStates, lines: SwingLines, rigid: FloatArray, most: float
) -> tuple[SwingLines, float]:
    """How far the rigid motions let the proof reach, at most so far, and the lines that prove it.

    How far (A v)_i can go is concave in the load factor: its tangents at any load factor lie above it
    everywhere. They are taken at the end of the range, then where those before them have led.
    """
    reached = _held_rigidly(lines, rigid, most)
    at = most if most < inf else reached
    for count in range(TANGENTS):
        if reached >= most:
            break
        lines, before = _tangents(problem, states, lines, at), reached
        at = reached = max(before, _held_rigidly(lines, rigid, most))
        if count and reached == before:
            break
    return lines, reached


def _tangents(
    problem: Problem, states: AdmissibleStates, lines: SwingLines, load_factor: float
) -> SwingLines:
    """The lines with those replaced that a tangent at a load factor undercuts there."""
    half = StateProgram(states)
    half.set_load_factors(load_factor, load_factor)
    multipliers, resisting = lines.multipliers.copy(), rigid_slips(problem).columns(problem.A)
    for i in range(problem.n):
        for side, extreme in enumerate(half.swing(i, resisting[i])):
            if np.isfinite(extreme.value) and np.isfinite(lines.values[i, side]):
                multipliers[i, side] = extreme.multipliers
    taken = known_lines(states, multipliers)
    lower = taken.values + load_factor * taken.slopes < lines.values + load_factor * lines.slopes
    return SwingLines(
        np.where(lower[:, :, None], multipliers, lines.multipliers),
        np.where(lower, taken.values, lines.values),
        np.where(lower, taken.slopes, lines.slopes),
        np.where(lower, taken.steps, lines.steps),
    )


def _held_rigidly(lines: SwingLines, rigid: FloatArray, most: float) -> float:
    """Largest λ at which some z in the range of A lies between the lines of all forward and backward slips.

    A node without a line for one side, as no state lets it slip that way, puts no condition there.
    """
    if np.isinf(lines.values).any():
        return 0.0
    node, side = np.nonzero(np.isfinite(lines.values))
    rows = np.zeros((len(node), len(rigid) + 1))
    rows[np.arange(len(node)), node] = np.where(side == 0, -1.0, 1.0)
    rows[:, -1] = lines.slopes[node, side]
    right = -lines.values[node, side]
    if np.any(rows[:, -1] < 0) and _largest_load_factor(rows, right, rigid, 0.0) < 0:
        return 0.0  # fails at the mean load, so nothing is proved from λ = 0 on
    return max(_largest_load_factor(rows, right, rigid, most), 0.0)


def _largest_load_factor(rows: FloatArray, right: FloatArray, rigid: FloatArray, most: float) -> float:
    n, r = rigid.shape
    program = Program(
        np.vstack([rows, np.column_stack([rigid.T, np.zeros(r)])]),
        np.append(right, np.zeros(r)),
        cost=np.append(np.zeros(n), -1.0),
        left=np.append(np.full(len(rows), -INF), np.zeros(r)),
        lower=np.append(np.full(n, -INF), 0.0),
        upper=np.append(np.full(n, INF), most),
    )
    found = solve(program)
    return float(found.x[-1]) if found.optimal else -INF
