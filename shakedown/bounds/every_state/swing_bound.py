"""The swing bound: below it every motion with all nodes closed shakes down, by linear programs."""

from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple

import numpy as np

from shakedown.bounds.every_state.admissible_states import (
    AdmissibleStates,
    StateProgram,
    admissible_states,
    first_overlap,
)
from shakedown.bounds.every_state.exact_swing import proved_swing
from shakedown.bounds.every_state.rigid_swing import limited_rigidly, rigid_motions
from shakedown.bounds.every_state.swing_lines import (
    SwingLines,
    known_lines,
    limit_multipliers,
    meeting_states,
)
from shakedown.bounds.upper import upper_bound
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import EXTRAS_UP_TO
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIDES, checked, require_plane
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import rigid_slips


@dataclass(frozen=True, eq=False, repr=False)
class SwingBound(Result):
    """Largest load factor at which no node can slip forward and backward at the same reaction A v.

    Attributes
    ----------
    status
        ``"optimal"``, or ``"unbounded"`` where no load factor ends it.
    load_factor
        λ_swing; inf where unbounded. Where it is certified, a float that is no larger than what is proved;
        else exact to the accuracy of the linear programs.
    node
        The node that ends it; −1 where none does, or where the rigid motion of a floating body does.
    forward_slip, backward_slip : (n,)
        Two slips, admissible at two loads of the hull of the loop, at which ``node`` can slip
        forward, and backward at no larger (A v)_node [length]; NaN where there is no such node.
    multipliers : (n, 2, 2n)
        y ≤ 0 (of either sign in the active row) with yᵀG = −A_i in forward slip and A_i in backward
        slip of node i: they bound (A v)_i there, :meth:`gaps`. NaN where there is no such slip.
    certified
        Whether the load factor was proved in exact arithmetic, by its ``multipliers``. They prove less
        where a node can be brought to both its limits; then nothing is certified.
    programs
        How many linear programs in two states were needed, because a bound by multipliers was not sharp.
    uncertified
        Why the proof in exact arithmetic failed where it was tried; else empty.
    """

    status: Status
    load_factor: float
    node: int
    forward_slip: FloatArray
    backward_slip: FloatArray
    multipliers: FloatArray
    certified: bool
    programs: int
    uncertified: str = ""

    def gaps(self, problem: Problem, load_factor: float) -> FloatArray:
        """Lower bounds of (A v)_i in backward minus forward slip, (n,) [force].

        Follows from ``multipliers`` by products of matrices alone, for every load factor. Positive
        throughout proves shakedown from every initial state, as long as all nodes stay closed.
        """
        states = admissible_states(problem)
        worst = np.min(-self.multipliers @ states.loads, axis=2)
        return np.sum(self.multipliers @ states.g + load_factor * worst, axis=1)


@checked
def swing_bound(
    problem: Problem, *, certify: bool | None = None, tolerances: Tolerances = DEFAULT
) -> SwingBound:
    """The swing bound λ_swing of a joint whose nodes stay closed.

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
        ``feasibility`` decides how clearly a node must pass without a program of its own, and how near
        a proof in exact arithmetic must come to certify;
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
    require_plane("swing bound", problem, NO_SIDES)
    states = admissible_states(problem)
    lines = known_lines(states, limit_multipliers(problem, tolerances))
    found = _first(problem, states, lines, tolerances)
    if np.isnan(lines.values).any() and found.load_factor > 0.0:
        lines = _completed(problem, states, lines, found.load_factor)
    rigid = rigid_motions(problem, tolerances)
    if rigid.shape[1] and found.load_factor > 0.0:
        held = upper_bound(problem, certify=False, tolerances=tolerances).load_factor
        lines, limited = limited_rigidly(problem, states, lines, rigid, min(found.load_factor, held))
        if limited >= found.load_factor * (1.0 - tolerances.feasibility):
            found = found._replace(load_factor=min(limited, found.load_factor))
        else:
            nowhere = np.full(problem.n, np.nan)
            found = found._replace(load_factor=limited, node=-1, forward=nowhere, backward=nowhere)
    return _result(problem, found, lines, certify, tolerances)


class _First(NamedTuple):
    """The smallest load factor at which a node can slip both ways at the same A v, and where."""

    load_factor: float
    node: int
    forward: FloatArray
    backward: FloatArray
    programs: int


def _first(problem: Problem, states: AdmissibleStates, lines: SwingLines, tolerances: Tolerances) -> _First:
    """The nodes in the order in which their lines meet: once that is later than what is found, all are apart.

    A meeting point is exact where the states on which the two lines rest are admissible; else,
    and where lines are missing, a program in two states decides.
    """
    nowhere = np.full(problem.n, np.nan)
    found, half = _First(inf, -1, nowhere, nowhere, 0), None
    stiffness = rigid_slips(problem).columns(problem.A)
    meetings = lines.meetings()
    for i in np.argsort(meetings).tolist():
        meeting = float(meetings[i])
        if meeting >= found.load_factor or found.load_factor == 0.0:
            break
        pair = meeting_states(states, lines, i, meeting, tolerances)
        if pair is not None:
            return found._replace(load_factor=meeting, node=i, forward=pair[0], backward=pair[1])
        if meeting == -inf and found.load_factor < inf:
            half = half or StateProgram(states)
            half.set_load_factors(found.load_factor, found.load_factor)
            if half.swing(i, stiffness[i]).apart(tolerances.feasibility):
                continue
        overlap, forward, backward = first_overlap(states, i, stiffness[i])
        if overlap < found.load_factor:
            found = _First(overlap, i, forward, backward, found.programs)
        found = found._replace(programs=found.programs + 1)
    return found


def _completed(
    problem: Problem, states: AdmissibleStates, lines: SwingLines, load_factor: float
) -> SwingLines:
    """Lines that are missing, from linear programs: tangents at one load factor."""
    half = StateProgram(states)
    if load_factor < inf:
        half.set_load_factors(load_factor, load_factor)
    stiffness = rigid_slips(problem).columns(problem.A)
    multipliers, unbounded = lines.multipliers.copy(), np.zeros(lines.values.shape, dtype=bool)
    for i in np.flatnonzero(np.isnan(lines.values).any(axis=1)).tolist():
        for side, extreme in enumerate(half.swing(i, stiffness[i])):
            multipliers[i, side], unbounded[i, side] = extreme.multipliers, extreme.value == -inf
    known = known_lines(states, multipliers)
    return replace(known, values=np.where(unbounded, inf, known.values))


def _result(
    problem: Problem, found: _First, lines: SwingLines, certify: bool | None, tolerances: Tolerances
) -> SwingBound:
    load_factor, proved, uncertified = found.load_factor, None, ""
    certify = problem.n <= EXTRAS_UP_TO if certify is None else certify
    if certify and 0.0 < load_factor < inf and found.node >= 0:
        found_exactly = sought(proved_swing, problem, lines)
        if isinstance(found_exactly, Missing):
            uncertified = found_exactly.reason
        else:
            proved = found_exactly
        if proved is not None and proved < load_factor * (1.0 - tolerances.feasibility):
            proved = None  # the lines leave a gap, which the program in two states has closed
    return SwingBound(
        status=Status.OPTIMAL if load_factor < inf else Status.UNBOUNDED,
        load_factor=load_factor if proved is None else min(proved, load_factor),
        node=found.node,
        forward_slip=found.forward,
        backward_slip=found.backward,
        multipliers=-lines.multipliers,
        certified=proved is not None,
        uncertified=uncertified,
        programs=found.programs,
    )
