"""The friction law at every instant of a recorded path."""

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import OPEN
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.motion.checked_law import law_violation, reactions, scales
from shakedown.motion.event_history import EventHistory, EventKind
from shakedown.motion.space.curved_history import CurvedHistory

WITHIN = (0.25, 0.5, 0.75)  # shares of a step at which the limits are checked


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


def curved_violation(problem: Problem, load_factor: float, history: CurvedHistory) -> float:
    """Largest relative violation of the law along a path, re-computed from its slips and gaps.

    Of one path as :func:`curved_violations` of several.
    """
    return float(curved_violations(problem, load_factor, history, np.array([len(history)]))[0])


def curved_violations(
    problem: Problem, load_factor: float, history: CurvedHistory, rows: NDArray[np.intp]
) -> FloatArray:
    """The same of several paths, one after the other in one history, each of so many rows, (k,).

    At the beginning of every step the whole law, the slip being that of the step at the rate there; that
    the step ends where the next begins; at its end and within it that limits are kept, gaps and pressures
    not negative. Within a step a polynomial stands for the path, so that this is some multiple of the
    accuracy asked for (:func:`law_resolution`).
    """
    found, path = np.zeros(len(rows)), np.repeat(np.arange(len(rows)), rows)
    steps = np.flatnonzero((history.duration > 0) & np.append(path[1:] == path[:-1], False))
    if not len(steps):
        return found
    scale = scales(problem, load_factor)

    def at(share: float, slip: FloatArray) -> FloatArray:
        there = history.within(steps, np.full(len(steps), share))
        q, p = reactions(problem, there.q_w, there.p_w, there.v, there.w)
        return np.asarray(law_violation(problem.f, q, p, there.w, slip, scale).max(axis=1))

    opened = np.repeat(history.state[steps] == OPEN, 2, axis=1)
    first = np.where(opened, 0.0, history.curve[steps][:, 0, problem.layout.slips])
    still = np.zeros_like(first)
    broken = [at(0.0, first), *(at(share, still) for share in (1.0, *WITHIN))]
    end, after = history.within(steps, np.ones(len(steps))), history.rows(steps + 1)
    smooth = (after.kind != EventKind.JUMPS)[:, None]
    gaps = (smooth * np.abs(part) for part in (end.v - after.v, end.w - after.w))
    broken += [part.max(axis=1) / scale.length for part in gaps]
    np.maximum.at(found, path[steps], np.max(broken, axis=0))
    return found
