"""The swing bound sharpened: in the box of the long run, and in the metric that suits it."""

from dataclasses import dataclass

import numpy as np

from shakedown.errors import UsageError
from shakedown.model.arguments import checked
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.result import Result
from shakedown.model.rigid_slips import rigid_slips
from shakedown.tolerances import DEFAULT, Tolerances
from shakedown.universal.admissible_states import admissible_states
from shakedown.universal.best_metric import best_metric
from shakedown.universal.shrinking_box import BoxShrinker, LimitBox, no_box

ROUNDS = 5  # of the box, per interval
STEP = 0.5  # of what is open, or of what was too much at once


@dataclass(frozen=True)
class ProvedInterval:
    """Why every motion with all nodes closed shakes down, for every load factor of an interval.

    Attributes
    ----------
    box
        The box of the long run.
    metric : (n, n)
        Symmetric P but for the columns of standing nodes: P_i · v in forward slip of node i is smaller
        than in backward slip, everywhere in the box. None where the box closes by itself.
    """

    box: LimitBox
    metric: FloatArray | None


@dataclass(frozen=True, eq=False, repr=False)
class SharpenedSwing(Result):
    """How far the proof reaches beyond the swing bound.

    Attributes
    ----------
    load_factor
        Up to here every load factor is proved, given that those up to the start are.
    intervals
        One proof per interval, each beginning where the last one ends.
    tried
        How many intervals were tried.
    limited_by
        ``"gain"`` (a further interval would add too little) or ``"effort"`` (as many as
        allowed were tried).
    """

    load_factor: float
    intervals: tuple[ProvedInterval, ...]
    tried: int
    limited_by: str


@checked
def sharpened_swing(
    problem: Problem, start: float, target: float, *, intervals: int = 20, tolerances: Tolerances = DEFAULT
) -> SharpenedSwing:
    """Climb from a proved load factor towards a target, interval by interval.

    On each interval of load factors the box of the long run is shrunk, from no box at all, and
    forward and backward slip inside it are held apart: by the box itself, in the metric A, in one
    that has served before, or in the one that does it best. An interval is half of what is left to
    climb; one that fails is cut in half. Only the search of a metric is costly: hundredths of a
    second for ten nodes, a few seconds for thirty, growing with the fourth power of their number.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    start, target
        Load factors: proved already, and not to be exceeded.
    intervals
        How many to try at most.
    tolerances
        ``box_gain`` decides which gains are too small to go on.

    Raises
    ------
    UsageError
        If the load steps are the corners of a load domain: the box of the long run needs that
        each of them returns in every period.
    SolverError
        If a linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> climb = sharpened_swing(joint, 0.6035788, 0.6573734)
    >>> round(climb.load_factor, 4), len(climb.intervals) <= climb.tried
    (0.6541, True)
    """
    if problem.is_domain:
        raise UsageError("load_path: expected a loop that returns to each load step, found a load domain")
    if rigid_slips(problem).pinned:  # a body that can move as a whole has no box
        return SharpenedSwing(start, (), 0, "gain")
    shrinker = BoxShrinker(admissible_states(problem), tolerances)
    proved: list[ProvedInterval] = []
    least_step = tolerances.box_gain * target
    aim = target - least_step  # nearer to the target the slips have no room to be apart
    reached, tried, step, known = start, 0, STEP * (aim - start), None
    metrics = [problem.A]
    while tried < intervals and step > least_step:
        tried += 1
        high = min(reached + step, aim)
        box = _narrowed(known, reached, high) if known else no_box(problem.n, reached, high)
        box = shrinker.shrink(box, ROUNDS)
        found = _apart_in(shrinker, box, metrics, tolerances)
        if found is None:
            known, step = box, step * STEP
        else:
            proved.append(found)
            reached, known, step = high, None, STEP * (aim - high)
            step = step if step > least_step else aim - high
    return SharpenedSwing(reached, tuple(proved), tried, "gain" if step <= least_step else "effort")


def _narrowed(box: LimitBox, low: float, high: float) -> LimitBox:
    """The same box, for part of its interval."""
    return LimitBox(box.within._replace(low=low, high=high), box.standing, box.forward, box.backward)


def _apart_in(
    shrinker: BoxShrinker, box: LimitBox, metrics: list[FloatArray], tolerances: Tolerances
) -> ProvedInterval | None:
    """The proof that all slip in a box ceases, if there is one; a metric that is found joins those known."""
    if not box.bounded:
        return None
    if box.closes(tolerances.feasibility):
        return ProvedInterval(box, None)
    for P in metrics[:1] + metrics[:0:-1]:
        if _holds_apart(shrinker, box, P, tolerances):
            return ProvedInterval(box, P)
    best = best_metric(shrinker.states, box)
    if best is None or not _holds_apart(shrinker, box, best, tolerances):
        return None
    metrics.append(best)
    return ProvedInterval(box, best)


def _holds_apart(shrinker: BoxShrinker, box: LimitBox, P: FloatArray, tolerances: Tolerances) -> bool:
    """Whether P_i · v in forward slip is below that in backward slip, for every node that moves."""
    program = shrinker.anywhere
    program.confine(box.within)
    return all(
        program.swing(int(i), P[i]).apart(tolerances.feasibility) for i in np.flatnonzero(~box.standing)
    )
