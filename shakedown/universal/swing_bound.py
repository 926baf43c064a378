"""The swing bound: below it every motion with all nodes closed shakes down, by linear programs."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.upper import upper_bound
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.result import Result
from shakedown.model.status import Status
from shakedown.programs.linear_program import INF, LinearProgram
from shakedown.tolerances import DEFAULT, Tolerances
from shakedown.universal.admissible_states import (
    AdmissibleStates,
    StateProgram,
    Swing,
    admissible_states,
    first_overlap,
)
from shakedown.universal.exact_swing import proved_swing

CERTIFIED_UP_TO = 20  # nodes up to which exact arithmetic is quick enough not to be asked for


@dataclass(frozen=True, eq=False, repr=False)
class SwingBound(Result):
    """Largest load factor at which no node can slip forward and backward at the same reaction A v.

    Attributes
    ----------
    status
        ``"optimal"``, or ``"unbounded"`` where no load factor ends it.
    load_factor
        λ_S; inf where unbounded. Where it is certified, a float that is no larger than what is proved.
    node
        The node that ends it; −1 where none does, or where the rigid motion of a floating body does.
    forward_slip, backward_slip : (n,)
        Two slips, admissible at two loads of the hull of the loop, at which ``node`` can slip
        forward and backward at the same (A v)_node [length]; NaN where there is no such node.
    multipliers : (n, 2, 2n)
        y ≤ 0 (of either sign in the active row) with yᵀG = −A_i in forward slip and A_i in backward
        slip of node i: they bound (A v)_i there, :meth:`gaps`. NaN where there is no such slip.
    certified
        Whether the load factor was proved in exact arithmetic.
    programs
        How many programs in two states were needed beside the 2n in one.
    """

    status: str
    load_factor: float
    node: int
    forward_slip: FloatArray
    backward_slip: FloatArray
    multipliers: FloatArray
    certified: bool
    programs: int

    def gaps(self, problem: Problem, load_factor: float) -> FloatArray:
        """By how much (A v)_i is larger in backward than in forward slip at least, (n,) [force].

        Follows from ``multipliers`` by products of matrices alone, for every load factor. Positive
        throughout proves shakedown from every initial state, as long as all nodes stay closed.
        """
        states = admissible_states(problem)
        worst = np.minimum(np.min(-self.multipliers @ states.loads, axis=2), 0.0)
        return np.sum(self.multipliers @ states.g + load_factor * worst, axis=1)


def swing_bound(
    problem: Problem, *, certify: bool | None = None, tolerances: Tolerances = DEFAULT
) -> SwingBound:
    """The swing bound λ_S of a joint whose nodes stay closed.

    Of all states that are admissible somewhere in the loop, take those in which node i is at its
    forward limit, and those in which it is at its backward limit. If every (A v)_i of the first
    is smaller than every one of the second, for every node, the elastic energy of the distance
    to one fixed slip falls whenever a node slips, and the joint shakes down from every state.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    certify
        Whether to prove the number in exact arithmetic; by default where that is quick.
    tolerances
        ``feasibility`` decides how clearly a node must pass without a program of its own;
        ``zero_mode`` what is a rigid motion.

    Raises
    ------
    SolverError
        If a linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> swing = swing_bound(shakedown.example("two-node"))
    >>> round(swing.load_factor, 7), swing.node, swing.certified
    (0.6035788, 1, True)
    """
    states = admissible_states(problem)
    order = _by_own_swing(states)
    load_factor, forward, backward = first_overlap(states, order[0], problem.A[order[0]])
    node, programs = int(order[0]), 1
    extremes: dict[int, Swing] = {}
    half = StateProgram(states, nested=True)
    _hold(half, load_factor)
    for i in order[1:]:
        if load_factor == 0.0:
            break
        extremes[int(i)] = pair = half.swing(int(i), problem.A[i])
        if pair.apart(tolerances.feasibility):
            continue
        programs += 1
        found, *slips = first_overlap(states, int(i), problem.A[i])
        if found < load_factor:
            load_factor, node, (forward, backward) = found, int(i), slips
            _hold(half, load_factor)
    if load_factor > 0.0:
        for i in range(problem.n):
            if i not in extremes or not extremes[i].apart(tolerances.feasibility):
                extremes[i] = half.swing(i, problem.A[i])
    rigid = rigid_motions(problem, tolerances)
    if rigid.shape[1] and load_factor > 0.0:
        held = upper_bound(problem, certify=False, tolerances=tolerances).load_factor
        limited = min(_held_rigidly(half, problem.A, rigid, load_factor), held)
        if limited < load_factor:
            load_factor, node = limited, -1
    return _result(problem, load_factor, node, (forward, backward), extremes, programs, certify)


def _result(
    problem: Problem,
    load_factor: float,
    node: int,
    slips: tuple[FloatArray, FloatArray],
    extremes: dict[int, Swing],
    programs: int,
    certify: bool | None,
) -> SwingBound:
    n, proved = problem.n, None
    if (n <= CERTIFIED_UP_TO if certify is None else certify) and 0.0 < load_factor < inf and node >= 0:
        proved = proved_swing(
            problem, [(extremes[i].forward.end, extremes[i].backward.end) for i in range(n)]
        )
    multipliers = np.full((n, 2, 2 * n), np.nan)
    for i, pair in extremes.items():
        multipliers[i] = [e.multipliers for e in pair]
    missing = np.full(n, np.nan)
    forward, backward = slips if node >= 0 and load_factor < inf else (missing, missing)
    return SwingBound(
        status=Status.OPTIMAL if load_factor < inf else Status.UNBOUNDED,
        load_factor=load_factor if proved is None else min(proved, load_factor),
        node=node if load_factor < inf else -1,
        forward_slip=forward,
        backward_slip=backward,
        multipliers=multipliers,
        certified=proved is not None,
        programs=programs,
    )


def _by_own_swing(states: AdmissibleStates) -> NDArray[np.intp]:
    """Nodes in the order of the load factors at which they would slip to and fro on their own, B = 0."""
    room = states.g[::2] + states.g[1::2]
    swing = states.loads.max(axis=1)
    swing = swing[::2] + swing[1::2]
    return np.argsort(np.divide(room, swing, out=np.full(states.n, inf), where=swing > 0))


def _hold(half: StateProgram, load_factor: float) -> None:
    half.set_load_factors(
        load_factor if load_factor < inf else 0.0, load_factor if load_factor < inf else INF
    )


def rigid_motions(problem: Problem, tolerances: Tolerances = DEFAULT) -> FloatArray:
    """Slips that A does not resist, as columns (n, r): r = 0 but for floating bodies."""
    values, vectors = np.linalg.eigh(problem.A)
    return vectors[:, values <= tolerances.zero_mode * max(values[-1], 0.0)]


def _held_rigidly(half: StateProgram, A: FloatArray, rigid: FloatArray, load_factor: float) -> float:
    """Largest λ at which some z in the range of A lies between all forward and backward slips.

    Each extreme is bounded by its tangent at one load factor, for all others; the largest load
    factor that these lines allow is proved, and the tangents there allow a larger one.
    """
    n, proved = len(A), 0.0
    for _ in range(MOST_TANGENTS):
        rows, right = [], []
        for i in range(n):
            for extreme, sign in zip(half.swing(i, A[i]), (-1.0, 1.0), strict=True):
                if np.isinf(extreme.value) and extreme.value > 0:
                    continue
                if np.isinf(extreme.value):
                    return 0.0
                row = np.zeros(n + 1)  # sign · z_i ≤ value + slope (λ − λ₀)
                row[i], row[-1] = sign, -extreme.slope
                rows.append(row)
                right.append(extreme.value - extreme.slope * load_factor)
        reached = _largest_load_factor(np.array(rows), np.array(right), rigid, load_factor)
        if reached <= proved:
            break
        proved = load_factor = reached
        _hold(half, load_factor)
    return proved


MOST_TANGENTS = 20  # each set of tangents ends on the next vertex of a piecewise linear function


def _largest_load_factor(rows: FloatArray, right: FloatArray, rigid: FloatArray, most: float) -> float:
    n, r = rigid.shape
    program = LinearProgram(
        np.vstack([rows, np.column_stack([rigid.T, np.zeros(r)])]),
        cost=np.append(np.zeros(n), -1.0),
        lower=np.append(np.full(len(rows), -INF), np.zeros(r)),
        upper=np.append(right, np.zeros(r)),
        column_lower=np.append(np.full(n, -INF), 0.0),
        column_upper=np.append(np.full(n, INF), most),
    )
    vertex = program.solve().vertex
    return 0.0 if vertex is None else float(vertex.x[-1])
