"""The loop over initial states that carries searches from phase to phase, and enters their answers."""

from enum import IntEnum

import numpy as np

from shakedown.ground.constants import FloatArray
from shakedown.ground.named_state import call_at, entered, inner
from shakedown.ground.status import BACKWARD_SLIP, STICK
from shakedown.long_term.plane import period_map
from shakedown.long_term.plane.search import PlaneSearch, begin_check, broken_law, check_rows, end_check
from shakedown.motion.course import CALL_OPERATIONS, LoopEnd
from shakedown.motion.plane.active_set import add_product, factorize, larger
from shakedown.motion.plane.moving_state import PlaneRun, begin

Phase = IntEnum("Phase", "START WALK MAP LEAP CONFIRM REPEATS LIMIT NEXT_LEAP LEAVE", start=0)
Verdict = IntEnum(
    "Verdict", "SEARCHING UNDECIDED BROKEN BLURRED LEFT SHAKEDOWN CYCLIC_SLIP RATCHETTING SEPARATION", start=0
)
"""BLURRED: no slip, but beside the loads at rest those that change are next to round-off."""
Instruction = IntEnum("Instruction", "ANEW FROM_HERE RATES JUMP STAYS STOPPED LEAVES LIMIT_FOUND", start=0)


@entered
def run_searches(se, starts, answers, effort, follow):  # type: ignore[no-untyped-def]
    """Answer for one initial slip (s, n) after the other; only the first search may have been begun.

    DONE, or PAUSED after so much work, or why Python is asked: LIMIT_WANTED, SINGULAR, or what
    ``follow``, which is given by its address, says where the motion stops. Every call gets one
    cycle further at least.
    """
    spent, status = 0, LoopEnd.DONE
    while se.row < len(starts) and status == LoopEnd.DONE:
        if se.phase == Phase.START:
            begin_search(se, starts[se.row])
        status = continue_search(se, follow, effort - spent)
        spent += se.spent
        if status == LoopEnd.DONE:
            enter_answer(se, answers, se.row)
            se.row += 1
            se.phase, se.verdict = Phase.START, Verdict.SEARCHING
            if spent > effort:
                return LoopEnd.PAUSED
    return status


@inner
def continue_search(se: PlaneSearch, follow: int, effort: int) -> int:
    """Go on with the present search until it is DONE; else as :func:`run_searches`."""
    se.spent = 0
    while se.verdict == Verdict.SEARCHING:
        if not se.placed and not place_state(se):
            if se.phase == Phase.WALK or not se.from_limit:
                return LoopEnd.SINGULAR
            se.phase = Phase.LEAVE
        if se.phase == Phase.WALK and se.cycles >= se.most_cycles:
            se.verdict = Verdict.UNDECIDED
        elif se.phase <= Phase.CONFIRM:
            run = run_of_phase(se)
            status: int = call_at(follow, run, 1, CALL_OPERATIONS)
            se.spent += run.active.effort + 100 * run.course.steps
            if status not in (LoopEnd.DONE, LoopEnd.PAUSED, LoopEnd.RECORD_FULL):
                return status
            after_call(se, run, status)
        elif se.phase == Phase.LIMIT and not period_map.find_limit(se.map):
            return LoopEnd.LIMIT_WANTED
        else:
            choose_phase(se)
        if se.spent > effort and se.verdict == Verdict.SEARCHING:
            return LoopEnd.PAUSED
    return LoopEnd.DONE


@inner
def run_of_phase(se: PlaneSearch) -> PlaneRun:
    """The run through the next cycle, at its beginning or where the loop returned from it."""
    run = se.cyclic
    if se.cycles == 0:
        run = se.first
    elif se.phase == Phase.CONFIRM:
        run = se.recorded
    if not se.resumed:
        begin(run.motion)
        se.jump_friction, se.jump_damping, se.jumped = 0.0, 0.0, 0
        if se.phase == Phase.CONFIRM and se.done == 0:
            begin_confirmation(se)
    return run


@inner
def after_call(se: PlaneSearch, run: PlaneRun, status: int) -> None:
    """Evaluate a cycle, or the part of it that was done in one call."""
    if se.phase == Phase.CONFIRM:
        check_rows(se.check, run.active, run.record, run.course, se.done)
    se.resumed = status != LoopEnd.DONE
    if se.resumed:
        return
    se.cycles += 1
    se.done += 1
    se.events += run.motion.events
    if se.phase == Phase.WALK:
        after_walk(se)
    elif se.phase == Phase.MAP:
        after_map(se)
    elif se.phase == Phase.LEAP:
        after_leap(se)
    else:
        after_confirmation(se)


@inner
def choose_phase(se: PlaneSearch) -> None:
    """Go to the next phase, where no cycle has to be followed first."""
    if se.phase == Phase.REPEATS:
        look_for_repeats(se)
    elif se.phase == Phase.LIMIT:  # without drift
        for j in range(2 * se.first.active.n):
            se.drift[j] = 0.0
        begin_leaps(se)
    elif se.phase == Phase.NEXT_LEAP:
        next_leap(se)
    else:
        leave_leaps(se)


@inner
def enter_answer(se, answers, row):  # type: ignore[no-untyped-def]
    """Enter the verdict for one initial slip with its numbers."""
    answers.verdict[row], answers.cycles_simulated[row] = se.verdict, se.cycles
    n = se.first.active.n
    for i in range(n):
        answers.final_slip[row, i] = se.first.motion.u[i]
    if se.verdict < Verdict.SHAKEDOWN:
        return
    answers.period[row], answers.signature[row] = se.done, se.signature
    answers.dissipation[row] = se.friction / se.done + se.damping / se.done
    answers.contraction[row] = se.contraction
    for i in range(n):
        answers.slip_per_cycle[row, i] = se.slip[i]


@entered
def instruct(se: PlaneSearch, word: int, one: float, other: float) -> None:
    """Pass on what Python has found, or requests.

    ANEW, from the first of some initial slips; FROM_HERE, a search from the present state; RATES
    have been found where there were none; a JUMP, of which friction has taken ``one`` and damping
    ``other``; the state STAYS where nothing loads it and there are no rates; STOPPED, the motion cannot go
    on, or it LEAVES; the LIMIT_FOUND, entered into the map, which decays (``one`` > 0) by a factor ``other``.
    """
    if word == Instruction.ANEW:
        se.row, se.phase, se.verdict = 0, Phase.START, Verdict.SEARCHING
    elif word == Instruction.FROM_HERE:
        se.row = 0
        begin_walk(se)
    elif word == Instruction.LIMIT_FOUND:
        se.map.decaying, se.map.contraction = one > 0.0, other
        begin_leaps(se)
    elif word in (Instruction.RATES, Instruction.JUMP, Instruction.STAYS):
        run = se.cyclic if se.cycles else se.first
        if se.phase == Phase.CONFIRM:
            run = se.recorded
            if word == Instruction.RATES:
                run.record.rows -= 1  # recorded again when they are taken
            check_rows(se.check, run.active, run.record, run.course, se.done)
        if word != Instruction.RATES:
            se.jump_friction += one
            se.jump_damping += other
            se.jumped += 1
            se.jumps += word == Instruction.JUMP
        se.resumed = True
    elif se.phase == Phase.LEAP or (se.phase == Phase.CONFIRM and se.from_limit):
        se.phase, se.resumed = Phase.LEAVE, False
    else:
        se.verdict = Verdict.LEFT if word == Instruction.LEAVES else Verdict.UNDECIDED


# Cycles one by one, until the state returns or its contact states repeat.


@inner
def begin_search(se: PlaneSearch, start: FloatArray) -> None:
    """Begin at rest with this slip: the load before the first step, and what counts as zero."""
    act, path, goal, locked = se.first.active, se.first.course.path, se.goal, se.force
    n, m, force = act.n, 2 * act.n, se.least_force
    for i in range(n):
        goal[i], goal[n + i] = start[i], 0.0
        se.contact[i] = BACKWARD_SLIP if act.f[i] == 0.0 else STICK
    for j in range(m):
        total = 0.0
        for i in range(n):
            total += abs(act.kappa[j * m + i]) * abs(goal[i])
        force = larger(force, total)
        locked[j] = 0.0
    add_product(act, goal, locked)
    for i in range(n):
        path[i] = -locked[i]
        path[n + i] = abs(path[m + n + i] + locked[n + i]) - locked[n + i]
    for course in (se.first.course, se.cyclic.course, se.recorded.course):
        course.force, course.residual = se.limit * force, se.rounding * force
    begin_walk(se)
    se.placed = False


@inner
def begin_walk(se: PlaneSearch) -> None:
    """Begin before any cycle is followed."""
    se.first.motion.parameters = 0
    se.cycles, se.events, se.remembered, se.signed, se.wait, se.resumed = 0, 0, 0, 0, 0, False
    se.phase, se.verdict, se.placed, se.from_limit = Phase.WALK, Verdict.SEARCHING, True, False


@inner
def place_state(se: PlaneSearch) -> bool:
    """Continue from the goal; False where its moving nodes are not held."""
    act, mo = se.first.active, se.first.motion
    for j in range(2 * act.n):
        mo.u[j] = se.goal[j]
    for i in range(act.n):
        act.state[i] = se.contact[i]
    se.placed = factorize(act) != 0
    return se.placed


@inner
def remember(se: PlaneSearch, u: FloatArray) -> None:
    """Store a state; where there are too many, the older half is dropped."""
    m = 2 * se.first.active.n
    if se.remembered == se.capacity:
        se.remembered = se.capacity // 2
        for j in range(se.remembered * m):
            se.past[j] = se.past[(se.capacity - se.remembered) * m + j]
    for j in range(m):
        se.past[se.remembered * m + j] = u[j]
    se.remembered += 1


@inner
def keep_signature(se: PlaneSearch) -> None:
    """Append the signature of the last cycle and drop the oldest."""
    most = 2 * se.longest_period
    if se.signed == most:
        for k in range(most - 1):
            se.signatures[k] = se.signatures[k + 1]
        se.signed = most - 1
    se.signatures[se.signed] = np.int64(se.first.motion.signature)
    se.signed += 1


@inner
def after_walk(se: PlaneSearch) -> None:
    """Where the state equals that of some cycles ago, one period has to confirm it."""
    act, mo = se.first.active, se.first.motion
    remember(se, mo.u)
    keep_signature(se)
    se.period = returned_after(se)
    if se.period == 0:
        se.phase = Phase.REPEATS
        return
    if not admissible(se, mo.u):
        se.verdict = Verdict.BROKEN
    se.contraction = observed_contraction(se, se.period)
    for j in range(2 * act.n):
        se.goal[j], se.drift[j] = mo.u[j], 0.0
    for i in range(act.n):
        se.contact[i] = act.state[i]
    se.phase, se.done, se.placed, se.from_limit = Phase.CONFIRM, 0, False, False


@inner
def returned_after(se: PlaneSearch) -> int:
    """The number of cycles after which the state returned, to round-off; 0 where it did not."""
    last = se.remembered - 1
    for period in range(1, min(se.longest_period, last) + 1):
        if distance(se, last - period, last) <= 1e-3 * se.check.near:
            return period
    return 0


@inner
def distance(se: PlaneSearch, one: int, other: int) -> float:
    """Largest difference of two states of the past, weighted."""
    m, far = 2 * se.first.active.n, 0.0
    for j in range(m):
        far = larger(far, se.weight[j] * abs(se.past[one * m + j] - se.past[other * m + j]))
    return far


@inner
def observed_contraction(se: PlaneSearch, period: int) -> float:
    """Factor per cycle between the last two distances to the present state that exceed round-off."""
    last, nearer = se.remembered - 1, 0.0
    for one in range(last - period, -1, -period):
        far = distance(se, one, last)
        if far > 10.0 * se.check.near:
            if nearer > 0.0:
                return (nearer / far) ** (1.0 / period)
            nearer = far
    return 0.0


@inner
def admissible(se: PlaneSearch, u: FloatArray) -> bool:
    """Whether a state between two cycles obeys the contact and friction law."""
    act, course, r = se.first.active, se.cyclic.course, se.force
    n, m, worst = act.n, 2 * act.n, 0.0
    for j in range(m):
        r[j] = course.path[course.steps * m + j]
    add_product(act, u, r)
    for i in range(n):
        worst = larger(worst, broken_law(se.check, se.check.f[i], r[i], r[n + i], u[n + i], 0.0))
    return worst <= se.friction_law


@inner
def look_for_repeats(se: PlaneSearch) -> None:
    """Where the sequence of contact states repeats, follow one more period with its derivative."""
    se.wait -= 1
    se.phase = Phase.WALK
    if se.wait > 0:
        return
    for period in range(1, se.longest_period + 1):
        if sequence_repeats(se, period):
            period_map.begin_map(se.map, se.first.active, se.first.motion)
            se.phase, se.period, se.done, se.jumps = Phase.MAP, period, 0, 0
            return


@inner
def sequence_repeats(se: PlaneSearch, period: int) -> bool:
    """Whether the last cycles have the signatures of those before, which then become ``wanted``."""
    if se.signed < 2 * period:
        return False
    for k in range(period):
        last = se.signatures[se.signed - period + k]
        if last != se.signatures[se.signed - 2 * period + k]:
            return False
        se.wanted[k] = last
    return True


@inner
def after_map(se: PlaneSearch) -> None:
    """The map of the period, if it passed through the expected sequence."""
    act, mo = se.first.active, se.first.motion
    keep_signature(se)
    if se.done < se.period:
        return
    mo.parameters = 0
    remember(se, mo.u)
    se.phase = Phase.LIMIT if se.jumps == 0 else Phase.WALK
    for k in range(se.period):
        if se.signatures[se.signed - se.period + k] != se.wanted[k]:
            se.phase = Phase.WALK
    for i in range(act.n):
        if act.state[i] != se.map.contact[i]:
            se.phase = Phase.WALK
    for j in range(2 * act.n):
        se.reached[j] = mo.u[j]
    period_map.end_map(se.map, mo)


# Leaps along the affine map of a period to its limit.


@inner
def begin_leaps(se: PlaneSearch) -> None:
    """Before the limit the leaps towards it."""
    for i in range(se.first.active.n):
        se.contact[i] = se.map.contact[i]
    se.leap, se.leaps, se.phase = 1.0, 0, Phase.NEXT_LEAP


@inner
def next_leap(se: PlaneSearch) -> None:
    """Try the limit where it is near, otherwise the state twice as many periods ahead."""
    pm = se.map
    se.phase, se.done, se.placed = Phase.LEAVE, 0, False
    if se.leaps == 60:  # each twice as far as the one before
        return
    se.leaps += 1
    near = pm.decaying and period_map.distance_to_limit(pm, se.leap, se.weight) <= 1e3 * se.check.near
    if near:
        period_map.displace(pm, pm.limit, se.goal)
    else:
        period_map.double_leap(pm)
        se.leap *= 2.0
        period_map.displace(pm, pm.change, se.goal)
    if admissible(se, se.goal):
        se.phase = Phase.CONFIRM if near else Phase.LEAP
        se.from_limit, se.contraction = True, pm.contraction ** (1.0 / se.period)


@inner
def after_leap(se: PlaneSearch) -> None:
    """Leap further if the period has passed through the sequence of the map."""
    se.signatures[se.done - 1] = np.int64(se.first.motion.signature)
    if se.done < se.period:
        return
    se.phase = Phase.NEXT_LEAP
    for k in range(se.period):
        if se.signatures[k] != se.wanted[k]:
            se.phase = Phase.LEAVE
            return
    for j in range(2 * se.first.active.n):
        se.reached[j] = se.goal[j]


@inner
def leave_leaps(se: PlaneSearch) -> None:
    """Continue cycle by cycle from the last state found to pass through the sequence."""
    for j in range(2 * se.first.active.n):
        se.goal[j] = se.reached[j]
    se.remembered, se.signed, se.wait, se.phase, se.placed = 0, 0, 2, Phase.WALK, False
    remember(se, se.goal)


# The verdict of one period that returns to its goal and obeys the friction law.


@inner
def begin_confirmation(se: PlaneSearch) -> None:
    """Count from the start of the period."""
    n = se.first.active.n
    se.friction, se.damping, se.jumps = 0.0, 0.0, 0
    for i in range(n):
        se.slip[i], se.opened[i] = 0.0, 0
    begin_check(se.check, n)


@inner
def after_confirmation(se: PlaneSearch) -> None:
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
        se.phase = Phase.LEAVE if se.from_limit else Phase.REPEATS


@inner
def judge_period(se: PlaneSearch, share: float) -> None:
    """The verdict of the confirmed period, if it obeys the friction law."""
    act, mo, check, near = se.first.active, se.first.motion, se.check, se.check.near
    se.signature = end_check(check, act, se.recorded.course, mo.u, se.done)
    breathing, drifts, slip = False, False, 0.0
    for i in range(act.n):
        breathing = breathing or (se.opened[i] == 1 and check.always_open[i] == 0)
        drifts = drifts or se.weight[i] * abs(share * se.drift[i]) > near
        slip = larger(slip, se.weight[i] * se.slip[i])
    if not check.violation <= se.friction_law:
        se.verdict = Verdict.BROKEN
    elif slip <= 4.0 * near:
        se.verdict = Verdict.BLURRED if se.blurred else Verdict.SEPARATION if breathing else Verdict.SHAKEDOWN
    else:
        se.verdict = Verdict.RATCHETTING if drifts else Verdict.CYCLIC_SLIP
