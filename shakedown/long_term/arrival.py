"""What transient load steps leave of an initial state, before a prediction is made from it."""

from dataclasses import replace

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.loading import loading, transient_path
from shakedown.joint.problem import Problem
from shakedown.motion.integrator import Evolution
from shakedown.motion.kernels.contact_status import OPEN


def arrives_closed(
    problem: Problem, load_factor: float, start: FloatArray, tolerances: Tolerances = DEFAULT
) -> bool:
    """Whether all nodes are closed at the first load step of the loop, when the transient is over.

    What is said of every closed state is then said of this one. True where there is no transient:
    that the start is admissible is another matter.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> arrives_closed(shakedown.example("receding-block"), 0.1, np.zeros(33))
    False
    """
    if not len(transient_path(problem)):
        return True
    q_w, p_w = loading(problem).at(load_factor)
    first = {"q_w": q_w[:1], "p_w": p_w[:1], "q_mean": q_w[0], "p_mean": p_w[0]}
    evolution = Evolution(replace(problem, **first), 1.0, start, tolerances)
    return evolution.cycle() is not None and not (evolution.state.contact == OPEN).any()
