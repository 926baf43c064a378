"""The friction law at every instant of a recorded path."""

import numpy as np

from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.motion.contact_law import law_violation, reactions, scales
from shakedown.motion.directed.curved_history import CurvedHistory
from shakedown.motion.directed.curved_violation import curved_violation
from shakedown.motion.event_history import EventHistory, EventKind


def path_violation(
    problem: Problem, load_factor: float, tolerances: Tolerances, history: EventHistory
) -> float:
    """Largest relative violation of the law, re-computed from slips and gaps.

    In the plane slip counts from row to row; of a curved path see :func:`curved_violation`.
    """
    if isinstance(history, CurvedHistory):
        return curved_violation(problem, load_factor, history)
    scale = scales(problem, load_factor)
    near = tolerances.periodicity * scale.length
    open_at_all = (history.w[1:] > near) | (history.w[:-1] > near)
    at_rest = open_at_all | (history.kind[1:] == EventKind.JUMPS)[:, None]
    slip = np.where(at_rest, 0.0, np.diff(history.v, axis=0))
    q, p = reactions(problem, history.q_w, history.p_w, history.v, history.w)
    at_end = law_violation(problem.f, q[1:], p[1:], history.w[1:], slip, scale)
    return float(at_end.max(initial=0.0))
