"""State after state: the loop that carries searches from phase to phase and enters their answers."""

from shakedown.long_term.settling.leaps import (
    after_confirmation,
    after_leap,
    begin_confirmation,
    begin_leaps,
    leave_leaps,
)
from shakedown.long_term.settling.leaps import next_leap as take_next_leap
from shakedown.long_term.settling.limit_of_powers import find_limit
from shakedown.long_term.settling.path_check import check_rows
from shakedown.long_term.settling.repeats import (
    after_map,
    after_walk,
    begin_search,
    look_for_repeats,
    place_state,
)
from shakedown.long_term.settling.search import (
    CONFIRM,
    HANDED_OVER,
    LEAP,
    LEAVE,
    LIMIT,
    LIMIT_WANTED,
    MAP,
    NEXT_LEAP,
    REPEATS,
    SEARCHING,
    START,
    UNDECIDED,
    WALK,
    Search,
)
from shakedown.motion.kernels.event_loop import DONE, EFFORT, PAUSED, RECORD_FULL, follow
from shakedown.motion.kernels.moving_state import begin
from shakedown.motion.kernels.named_state import entered, inner
from shakedown.motion.kernels.run import Run


@entered
def settle(se, starts, answers, effort):  # type: ignore[no-untyped-def]
    """Answer for one initial slip (s, n) after the other.

    DONE, or PAUSED after so much work, or LIMIT_WANTED. Every call gets one cycle further at least.
    """
    spent = 0
    while se.row < len(starts):
        if se.phase == START:
            begin_search(se, starts[se.row])
        if not se.placed:
            place_state(se)
        if se.verdict == SEARCHING:
            if se.phase == WALK and se.cycles >= se.most_cycles:
                se.verdict = UNDECIDED
            elif se.phase <= CONFIRM:
                run = run_of_phase(se)
                after_call(se, run, follow(run, 1, EFFORT))
                spent += run.active.effort + 100 * run.course.steps
            else:
                decide(se)
        if se.verdict == LIMIT_WANTED:
            return LIMIT_WANTED
        if se.verdict != SEARCHING:
            enter_answer(se, answers, se.row)
            se.row += 1
            se.phase, se.verdict = START, SEARCHING
        if spent > effort:
            return PAUSED
    return DONE


@entered
def restart(se: Search) -> None:
    """Begin with the first of some initial slips."""
    se.row, se.phase, se.verdict = 0, START, SEARCHING


@entered
def nodes_of_map(se: Search) -> int:
    """Number of nodes whose limit is wanted."""
    return se.map.k


@entered
def take_limit(se, decaying, contraction):  # type: ignore[no-untyped-def]
    """Go on with the limit and the drift that have been entered into the map."""
    se.map.decaying, se.map.contraction, se.verdict = decaying, contraction, SEARCHING
    begin_leaps(se)


@inner
def run_of_phase(se: Search) -> Run:
    """The run through the next cycle, at its beginning, or where the loop has returned from it."""
    run = se.cyclic
    if se.cycles == 0:
        run = se.first
    elif se.phase == CONFIRM:
        run = se.recorded
    if not se.resumed:
        begin(run.motion)
        if se.phase == CONFIRM and se.done == 0:
            begin_confirmation(se)
    return run


@inner
def after_call(se: Search, run: Run, status: int) -> None:
    """What follows from a cycle, or from as much of it as has been done at one go."""
    if se.phase == CONFIRM:
        check_rows(se.check, run.active, run.record, run.course, se.done)
    se.resumed = status in (PAUSED, RECORD_FULL)
    if se.resumed:
        return
    if status != DONE:
        se.verdict = HANDED_OVER
        return
    se.cycles += 1
    se.done += 1
    if se.phase == WALK:
        after_walk(se)
    elif se.phase == MAP:
        after_map(se)
    elif se.phase == LEAP:
        after_leap(se)
    else:
        after_confirmation(se)


@inner
def decide(se: Search) -> None:
    """What to do next, where no cycle is to be followed first."""
    if se.phase == REPEATS:
        look_for_repeats(se)
    elif se.phase == LIMIT:
        if find_limit(se.map):
            begin_leaps(se)
        else:
            se.verdict = LIMIT_WANTED
    elif se.phase == NEXT_LEAP:
        take_next_leap(se)
    elif se.phase == LEAVE:
        leave_leaps(se)


@inner
def enter_answer(se, answers, row):  # type: ignore[no-untyped-def]
    """The verdict for one initial slip, and what belongs to it."""
    answers.verdict[row], answers.cycles[row] = se.verdict, se.cycles
    n = se.first.active.n
    for i in range(n):
        answers.final_slip[row, i] = se.first.motion.u[i]
    if se.verdict <= UNDECIDED:
        return
    answers.period[row], answers.signature[row] = se.done, se.signature
    answers.dissipation[row], answers.contraction[row] = se.dissipation / se.done, se.contraction
    for i in range(n):
        answers.slip[row, i] = se.slip[i]
