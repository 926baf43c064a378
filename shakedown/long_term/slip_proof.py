"""A verdict with proof: is the motion in a state from which its nodes slip only so far in all?"""

from dataclasses import replace
from math import inf
from typing import NamedTuple

from shakedown.bounds.accumulated.accumulated_bound import total_slip_bound
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.long_term.passage import Approach, Passage
from shakedown.motion.contact_law import path_resolution, scales

MOST = 256  # cycles after which a state is asked about, by doubling from the first on


class SlipProof(NamedTuple):
    """From which state of a motion the slip that is still to come is bounded.

    Attributes
    ----------
    cycles
        After how many cycles the motion is in that state; 0 at its start.
    further
        How far any node can slip in all from then on [length].
    """

    cycles: int
    further: float


def slip_proof(passage: Passage, approach: Approach) -> SlipProof | None:
    """The proof by accumulated slip (docs/accumulated.md), of all nodes closed; None where none is found.

    The start is asked about, then the state at rest. Where that one proves nothing, states near it hardly
    do; where it does, the states after 1, 2, 4, … cycles are asked about, with the error of their path.
    """
    further = further_from_start(passage)
    if further < inf:
        return SlipProof(0, further)
    loop = _after_transient(passage.problem)
    if approach.open_nodes or not _further(loop, passage, approach.final_slip, 0.0) < inf:
        return None
    known = path_resolution(loop, passage.tolerances) * scales(loop, passage.load_factor).length
    for state in passage.passed(approach.first_cycles, min(approach.most, MOST)):
        if state.cycles > MOST:
            break
        if state.open_nodes or state.cycles & (state.cycles - 1):
            continue
        further = _further(loop, passage, state.slip, known + state.error)
        if further < inf:
            return SlipProof(state.cycles, further)
    return None


def further_from_start(passage: Passage) -> float:
    """How far any node can slip in all from the very start on; inf where that is not known."""
    return inf if passage.open_nodes else _further(passage.problem, passage, passage.start, 0.0)


def _further(problem: Problem, passage: Passage, slip: FloatArray, error: float) -> float:
    """How far any node can slip in all from a closed state on, wherever within an error; inf unknown."""
    found = total_slip_bound(problem, passage.load_factor, slip, start_error=error)
    return float(found.total_slip.max()) if found.status == Status.OPTIMAL else inf


@once_per_problem
def _after_transient(problem: Problem) -> Problem:
    """The joint in its loop."""
    if problem.q_transient is None:
        return problem
    return replace(problem, q_transient=None, p_transient=None)
