"""The friction law along a recorded path in two tangential directions, from its slips and gaps alone."""

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.joint.problem import Problem
from shakedown.motion.contact_law import law_violation, reactions, scales
from shakedown.motion.directed.curved_history import CurvedHistory
from shakedown.motion.directed.sliding import DEGREE
from shakedown.motion.event_history import EventKind
from shakedown.motion.kernels.contact_status import OPEN

WITHIN = (0.25, 0.5, 0.75)  # shares of a step at which the limits are looked at


def curved_violation(problem: Problem, load_factor: float, history: CurvedHistory) -> float:
    """Largest relative violation of the law along a path, re-computed from its slips and gaps.

    At both ends of every step the whole law, the slip being that of the step at the rate there; within
    it that limits are kept, gaps and pressures not negative; and that the step ends where the next begins.
    """
    steps = np.flatnonzero(history.duration > 0)
    steps = steps[steps + 1 < len(history)]
    if not len(steps):
        return 0.0
    scale = scales(problem, load_factor)

    def at(share: float, slip: FloatArray) -> float:
        there = history.within(steps, np.full(len(steps), share))
        q, p = reactions(problem, there.q_w, there.p_w, there.v, there.w)
        return float(law_violation(problem.f, q, p, there.w, slip, scale).max())

    slips = history.curve[steps][:, :, problem.layout.slips]
    first, last = slips[:, 0], np.einsum("k,skj->sj", np.arange(1.0, DEGREE + 1), slips)
    opened = np.repeat(history.state[steps] == OPEN, 2, axis=1)
    first, last = np.where(opened, 0.0, first), np.where(opened, 0.0, last)
    worst = [at(0.0, first), at(1.0, last), *(at(share, np.zeros_like(first)) for share in WITHIN)]
    end = history.within(steps, np.ones(len(steps)))
    jumps = history.kind[steps + 1] == EventKind.JUMPS
    gaps = [
        np.abs(part[~jumps]).max(initial=0.0)
        for part in (end.v - history.v[steps + 1], end.w - history.w[steps + 1])
    ]
    return max(*worst, *(float(gap) / scale.length for gap in gaps))
