"""The verdict in the plane, of one period that returns to its goal and obeys the friction law."""

from shakedown.ground.named_state import inner
from shakedown.long_term.plane.path_check import begin_check, end_check
from shakedown.long_term.plane.search import (
    BLURRED,
    BROKEN,
    CYCLIC_SLIP,
    LEAVE,
    RATCHETTING,
    REPEATS,
    SEPARATION,
    SHAKEDOWN,
    Settler,
)
from shakedown.motion.plane.active_set import larger


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
