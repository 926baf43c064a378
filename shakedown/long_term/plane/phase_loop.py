"""The loop over initial states that carries searches from phase to phase and enters their answers."""

from shakedown.ground.named_state import call_at, entered, inner
from shakedown.long_term.plane.leaps import after_leap, begin_leaps, leave_leaps
from shakedown.long_term.plane.leaps import next_leap as take_next_leap
from shakedown.long_term.plane.limit_of_powers import find_limit
from shakedown.long_term.plane.path_check import check_rows
from shakedown.long_term.plane.period_verdict import after_confirmation, begin_confirmation
from shakedown.long_term.plane.repeats import (
    after_map,
    after_walk,
    begin_search,
    begin_walk,
    look_for_repeats,
    place_state,
)
from shakedown.long_term.plane.search import (
    CONFIRM,
    LEAP,
    LEAVE,
    LEFT,
    LIMIT,
    LIMIT_WANTED,
    MAP,
    NEXT_LEAP,
    REPEATS,
    SEARCHING,
    SHAKEDOWN,
    SINGULAR,
    START,
    UNDECIDED,
    WALK,
    SearchState,
    Settler,
)
from shakedown.motion.course import DONE, EFFORT, PAUSED, RECORD_FULL
from shakedown.motion.plane.moving_state import PlaneRun, begin

ANEW, FROM_HERE, RATES, JUMP, STOPPED, LEAVES = range(6)  # instructions to a search, besides LIMIT_WANTED


@entered
def settle(se, starts, answers, effort, follow):  # type: ignore[no-untyped-def]
    """Answer for one initial slip (s, n) after the other; only the first search may have been begun.

    DONE, or PAUSED after so much work, or why Python is asked: LIMIT_WANTED, SINGULAR, or what
    ``follow``, which is given by its address, says where the motion stops. Every call gets one
    cycle further at least.
    """
    spent, status = 0, DONE
    while se.row < len(starts) and status == DONE:
        if se.phase == START:
            begin_search(se, starts[se.row])
        status = seek(se, follow, effort - spent)
        spent += se.spent
        if status == DONE:
            enter_answer(se, answers, se.row)
            se.row += 1
            se.phase, se.verdict = START, SEARCHING
            if spent > effort:
                return PAUSED
    return status


@inner
def seek(se: Settler, follow: int, effort: int) -> int:
    """Go on with the present search until it is DONE; else as :func:`settle`."""
    se.spent = 0
    while se.verdict == SEARCHING:
        if not se.placed and not place_state(se):
            if se.phase == WALK or not se.from_limit:
                return SINGULAR
            se.phase = LEAVE
        if se.phase == WALK and se.cycles >= se.most_cycles:
            se.verdict = UNDECIDED
        elif se.phase <= CONFIRM:
            run = run_of_phase(se)
            status: int = call_at(follow, run, 1, EFFORT)
            se.spent += run.active.effort + 100 * run.course.steps
            if status not in (DONE, PAUSED, RECORD_FULL):
                return status
            after_call(se, run, status)
        elif se.phase == LIMIT and not find_limit(se.map):
            return LIMIT_WANTED
        else:
            choose_phase(se)
        if se.spent > effort and se.verdict == SEARCHING:
            return PAUSED
    return DONE


@inner
def run_of_phase(se: Settler) -> PlaneRun:
    """The run through the next cycle, at its beginning or where the loop returned from it."""
    run = se.cyclic
    if se.cycles == 0:
        run = se.first
    elif se.phase == CONFIRM:
        run = se.recorded
    if not se.resumed:
        begin(run.motion)
        se.jump_friction, se.jump_damping, se.jumped = 0.0, 0.0, 0
        if se.phase == CONFIRM and se.done == 0:
            begin_confirmation(se)
    return run


@inner
def after_call(se: Settler, run: PlaneRun, status: int) -> None:
    """Evaluate a cycle, or the part of it that was done in one call."""
    if se.phase == CONFIRM:
        check_rows(se.check, run.active, run.record, run.course, se.done)
    se.resumed = status != DONE
    if se.resumed:
        return
    se.cycles += 1
    se.done += 1
    se.events += run.motion.events
    if se.phase == WALK:
        after_walk(se)
    elif se.phase == MAP:
        after_map(se)
    elif se.phase == LEAP:
        after_leap(se)
    else:
        after_confirmation(se)


@inner
def choose_phase(se: Settler) -> None:
    """Go to the next phase, where no cycle has to be followed first."""
    if se.phase == REPEATS:
        look_for_repeats(se)
    elif se.phase == LIMIT:
        begin_leaps(se)
    elif se.phase == NEXT_LEAP:
        take_next_leap(se)
    else:
        leave_leaps(se)


@inner
def enter_answer(se, answers, row):  # type: ignore[no-untyped-def]
    """Enter the verdict for one initial slip with its numbers."""
    answers.verdict[row], answers.cycles[row] = se.verdict, se.cycles
    n = se.first.active.n
    for i in range(n):
        answers.final_slip[row, i] = se.first.motion.u[i]
    if se.verdict < SHAKEDOWN:
        return
    answers.period[row], answers.signature[row] = se.done, se.signature
    answers.dissipation[row] = se.friction / se.done + se.damping / se.done
    answers.contraction[row] = se.contraction
    for i in range(n):
        answers.slip[row, i] = se.slip[i]


@entered
def tell(se: Settler, word: int, one: float, other: float) -> None:
    """Pass on what Python has found, or requests.

    ANEW, from the first of some initial slips; FROM_HERE, a search from the present state; RATES
    have been found where there were none; a JUMP, of which friction has taken ``one`` and damping
    ``other``; STOPPED, the motion cannot go on, or it LEAVES; the LIMIT_WANTED, entered into the map,
    which decays (``one`` > 0) by a factor ``other``.
    """
    if word == ANEW:
        se.row, se.phase, se.verdict = 0, START, SEARCHING
    elif word == FROM_HERE:
        se.row = 0
        begin_walk(se)
    elif word == LIMIT_WANTED:
        se.map.decaying, se.map.contraction = one > 0.0, other
        begin_leaps(se)
    elif word in (RATES, JUMP):
        run = se.cyclic if se.cycles else se.first
        if se.phase == CONFIRM:
            run = se.recorded
            if word == RATES:
                run.record.rows -= 1  # recorded again when they are taken
            check_rows(se.check, run.active, run.record, run.course, se.done)
        if word == JUMP:
            se.jump_friction += one
            se.jump_damping += other
            se.jumped += 1
            se.jumps += 1
        se.resumed = True
    elif se.phase == LEAP or (se.phase == CONFIRM and se.from_limit):
        se.phase, se.resumed = LEAVE, False
    else:
        se.verdict = LEFT if word == LEAVES else UNDECIDED


def search_state(se: Settler) -> SearchState:
    """The progress and the counters of a search."""
    at = se.content
    return SearchState(
        at.phase, at.cycles, at.events, at.period, at.done, at.jumped, at.jumps, at.from_limit, se.map.k,
        at.contraction, at.far, at.friction, at.damping, se.check.violation, at.signature,
    )  # fmt: skip
