"""Initial slips by name: zero, given, safe, witness."""

import numpy as np

from shakedown.bounds.lower import lower_bound
from shakedown.bounds.upper import safe_slip
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import shortened
from shakedown.ground.status import Status
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.problem import Problem

NAMES = ("zero", "given", "safe", "witness")


@checked
def named_start(
    problem: Problem, load_factor: float, name: str, open_nodes: tuple[int, ...] = ()
) -> FloatArray:
    """The initial slip, (dn,), of a given name.

    ``"zero"``; ``"given"``: the first of the problem's own; ``"safe"``: a safe slip at this load factor,
    through the transient load steps too, where there is such a slip; ``"witness"``: the critical slip
    state of the first collapse.

    Raises
    ------
    UsageError
        If the word is none of these, or there is no such state.
    """
    check_load_factor(load_factor)
    if name == "zero":
        return np.zeros(problem.layout.slip_size)
    if name == "given":
        if problem.initial_slip is None:
            raise UsageError("initial slip 'given': expected a problem with initial_slip, found none")
        return problem.initial_slip[0]
    if name == "safe":
        lasting = not open_nodes and not moved_by_transient(problem, load_factor)
        safe = safe_slip(problem, load_factor, open_nodes=open_nodes, transient=lasting)
        return _existing(safe.slip, "a safe slip", load_factor)
    if name == "witness":
        if problem.directions > 1:
            raise UsageError(
                "initial slip 'witness': expected one tangential direction, found two "
                "(it is of a first collapse; zero, safe and given are there in space, too)"
            )
        slip = lower_bound(problem).slip
        return _existing(slip, "a critical slip state of the first collapse", load_factor)
    raise UsageError(
        f"initial slip: expected numbers or one of {', '.join(NAMES)}, found {shortened(name)!r}"
    )


@checked
def moved_by_transient(problem: Problem, load_factor: float) -> bool:
    """Whether the transient load steps move every slip that is safe in the loop."""
    if problem.q_transient is None:
        return False
    return safe_slip(problem, load_factor, transient=True).status == Status.INFEASIBLE


def _existing(slip: FloatArray, what: str, load_factor: float) -> FloatArray:
    if np.isnan(slip).any():
        raise UsageError(f"there is no such initial state: {what} does not exist at {load_factor:g}")
    return slip
