"""Leaps along the affine map of a period to its limit."""

import numpy as np

from shakedown.ground.named_state import inner
from shakedown.long_term.plane.limit_of_powers import double_leap
from shakedown.long_term.plane.period_map import along_basis, displace, distance_to_limit
from shakedown.long_term.plane.repeats import admissible, remember
from shakedown.long_term.plane.search import CONFIRM, LEAP, LEAVE, NEXT_LEAP, WALK, Settler
from shakedown.motion.plane.active_set import add_product, largest

MOST_LEAPS = 60


@inner
def begin_leaps(se: Settler) -> None:
    """Before the limit the leaps towards it; a drift that changes reactions cannot last."""
    act, pm, m = se.first.active, se.map, 2 * se.first.active.n
    for j in range(m):
        se.drift[j], se.force[j] = along_basis(pm, pm.drift, j), 0.0
    add_product(act, se.drift, se.force)
    if not largest(se.force, m) <= 1e-3 * se.check.near * se.stiffness:
        pm.decaying = False  # there is no limit
    for j in range(act.n, m):
        se.drift[j] = 0.0  # gaps cannot grow for ever
    for i in range(act.n):
        se.contact[i] = pm.contact[i]
    se.leap, se.leaps, se.phase = 1.0, 0, NEXT_LEAP


@inner
def next_leap(se: Settler) -> None:
    """Try the limit where it is near, otherwise the state twice as many periods ahead."""
    pm = se.map
    se.phase, se.done, se.placed = LEAVE, 0, False
    if se.leaps == MOST_LEAPS:
        return
    se.leaps += 1
    near = pm.decaying and distance_to_limit(pm, se.leap, se.weight) <= 1e3 * se.check.near
    if near:
        displace(pm, pm.limit, se.goal)
    else:
        double_leap(pm)
        se.leap *= 2.0
        displace(pm, pm.change, se.goal)
    if admissible(se, se.goal):
        se.phase = CONFIRM if near else LEAP
        se.from_limit, se.contraction = True, pm.contraction ** (1.0 / se.period)


@inner
def after_leap(se: Settler) -> None:
    """Leap further if the period has passed through the sequence of the map."""
    se.signatures[se.done - 1] = np.int64(se.first.motion.signature)
    if se.done < se.period:
        return
    se.phase = NEXT_LEAP
    for k in range(se.period):
        if se.signatures[k] != se.wanted[k]:
            se.phase = LEAVE
            return
    for j in range(2 * se.first.active.n):
        se.reached[j] = se.goal[j]


@inner
def leave_leaps(se: Settler) -> None:
    """Continue cycle by cycle from the last state found to pass through the sequence."""
    for j in range(2 * se.first.active.n):
        se.goal[j] = se.reached[j]
    se.remembered, se.signed, se.patience, se.phase, se.placed = 0, 0, 2, WALK, False
    remember(se, se.goal)
