"""The end of a search: leaps along the affine map to its limit, and one period that confirms it."""

import numpy as np

from shakedown.ground.named_state import inner
from shakedown.long_term.plane.limit_of_powers import double_leap
from shakedown.long_term.plane.path_check import begin_check, end_check
from shakedown.long_term.plane.period_map import along_basis, displace, distance_to_limit
from shakedown.long_term.plane.repeats import admissible, remember
from shakedown.long_term.plane.search import (
    BLURRED,
    BROKEN,
    CONFIRM,
    CYCLIC_SLIP,
    LEAP,
    LEAVE,
    NEXT_LEAP,
    RATCHETTING,
    REPEATS,
    SEPARATION,
    SHAKEDOWN,
    WALK,
    Settler,
)
from shakedown.motion.plane.active_set import add_product, larger, largest

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


@inner
def begin_confirmation(se: Settler) -> None:
    """Count from the start of the period."""
    n = se.first.active.n
    se.friction, se.damping, se.jumps = 0.0, 0.0, 0
    for i in range(n):
        se.slip[i], se.opened[i] = 0.0, 0
    begin_check(se.check, n)


@inner
def after_confirmation(se: Settler) -> None:
    """The answer, if the period, or a shorter one, has returned to the goal."""
    mo, n, far = se.first.motion, se.first.active.n, 0.0
    for i in range(n):
        se.slip[i] += mo.slip[i]
        se.opened[i] |= mo.opened[i]
    friction = mo.dissipation + se.jump_friction
    se.works[se.done - 1] = friction + se.jump_damping
    se.friction += friction
    se.damping += se.jump_damping
    share = se.done / se.period
    for j in range(2 * n):
        far = larger(far, se.weight[j] * abs(mo.u[j] - se.goal[j] - share * se.drift[j]))
    se.far = far
    if se.period % se.done == 0 and far <= se.check.near:
        judge_period(se, share)
    elif se.done == se.period:
        se.phase = LEAVE if se.from_limit else REPEATS


@inner
def judge_period(se: Settler, share: float) -> None:
    """The verdict of the confirmed period, if it obeys the friction law."""
    act, mo, check, near = se.first.active, se.first.motion, se.check, se.check.near
    se.signature = end_check(check, act, se.recorded.course, mo.u, se.done)
    breathing, drifts, slip = False, False, 0.0
    for i in range(act.n):
        breathing = breathing or (se.opened[i] == 1 and check.always_open[i] == 0)
        drifts = drifts or se.weight[i] * abs(share * se.drift[i]) > near
        slip = larger(slip, se.weight[i] * se.slip[i])
    if not check.violation <= se.friction_law:
        se.verdict = BROKEN
    elif slip <= 4.0 * near:
        se.verdict = BLURRED if se.blurred else SEPARATION if breathing else SHAKEDOWN
    else:
        se.verdict = RATCHETTING if drifts else CYCLIC_SLIP
