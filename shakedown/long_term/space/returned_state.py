"""The long-term state of a motion known only to an accuracy, with its evidence."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import ClassVar

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import DISTINCT, RESOLVED
from shakedown.ground.status import Outcome
from shakedown.ground.work_limit import work_again
from shakedown.long_term.limit_search import OUTCOMES
from shakedown.long_term.passage import FirstCycles, Passage
from shakedown.long_term.plane.search import Answers
from shakedown.long_term.space.proved_verdict import heeding_proofs
from shakedown.long_term.space.return_search import ReturnSearch
from shakedown.long_term.space.settled import ReturnRules, Settled, opened_and_closed
from shakedown.long_term.state import LongTermState
from shakedown.motion.checked_law import Scales, law_resolution, scales, swing
from shakedown.motion.event_history import CurvedHistory, curved_violations
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import cycles_of
from shakedown.motion.space.space_events import PathSteps, SpaceEvents
from shakedown.motion.viscous_jump import Jump

TIGHTER = 0.125  # factor on the uncertainty allowed in leaps from one search to the next that confirms it
NOT_CERTAIN = "a cycle exists, not certainly the one that this motion reaches"
VERDICTS = {outcome: code for code, outcome in reversed(list(enumerate(OUTCOMES)))}


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class ReturnedState(LongTermState):
    """A long-term state found cycle by cycle, as it is with two tangential directions.

    The numbers are those of one period followed from the state found, to the accuracy of the motion.

    Attributes
    ----------
    error
        Estimated distance of ``final_slip`` from where the motion really ends, largest entry [length]: from
        the rate at which the cycles close in, and from what leaps ahead leave open; where it ratchets apart
        from rigid slip, which goes on for ever. NaN where undecided.
    first_cycles
        What the search has passed through before it first leapt.
    jumps
        Those of the cycles that it has followed. Of a joint in uncoupled ``parts`` both are told by these.
    """

    DOCUMENT: ClassVar[str] = f"{LongTermState.DOCUMENT} error"

    error: float
    first_cycles: FirstCycles = field(repr=False, compare=False)
    jumps: tuple[Jump, ...] = field(repr=False)


class ReturnedStates:
    """Search after search for long-term states over one motion, as :class:`LimitSearch` is in the plane.

    Parameters
    ----------
    motion
        The joint at a load factor.
    most_cycles, longest_period
        As for :func:`long_term_state`.
    """

    def __init__(self, motion: Evolution, most_cycles: int, longest_period: int) -> None:
        self.motion, self.layout = motion, motion.problem.layout
        self.rules = rules_of(motion, motion.scale, most_cycles, longest_period)

    def from_slips(self, starts: FloatArray, answers: Answers, stopped: Callable[[], bool]) -> None:
        """Answer for initial slips (s, 2n), one after the other, until ``stopped()`` is true."""
        motion, found, paths = self.motion, list[Settled](), list[list[PathSteps]]()
        for start in starts:
            if stopped():
                return
            motion.begin(motion.load_factor, start)
            found.append(carefully(motion, self.rules))
            paths.append(_period_path(motion, found[-1]))
        for k, (start, each) in enumerate(zip(starts, lawful(motion, found, paths), strict=True)):
            if each.outcome == Outcome.SHAKEDOWN:  # as a state would be, which proofs would leave as it is
                _enter_rest(each, answers, k)
                continue
            begun = Passage(motion.problem, motion.load_factor, motion.tolerances, start, ())
            state = _state(begun, each, start, motion.scale, self.rules.most_cycles)
            enter(heeding_proofs(state), answers, k)


def enter(state: LongTermState, answers: Answers, k: int) -> None:
    """Enter a long-term state into a row of answers."""
    answers.final_slip[k], answers.slip[k] = state.final_slip, state.slip_per_cycle
    answers.dissipation[k], answers.contraction[k] = state.dissipation_per_cycle, state.contraction
    answers.verdict[k], answers.period[k] = VERDICTS[state.outcome], state.period
    answers.cycles[k], answers.signature[k] = state.cycles_simulated, state.signature


def _enter_rest(found: Settled, answers: Answers, k: int) -> None:
    """The same of what has come to rest, without a state being made."""
    (record,) = found.records
    answers.final_slip[k], answers.slip[k] = record.end_slip, record.slip
    answers.dissipation[k], answers.contraction[k] = record.dissipation, found.contraction
    answers.verdict[k], answers.period[k] = VERDICTS[found.outcome], found.period
    answers.cycles[k], answers.signature[k] = found.cycles, found.signature


def returned_state(begun: Passage, most_cycles: int, longest_period: int) -> ReturnedState:
    """What a joint settles into from where its motion begins.

    Parameters
    ----------
    begun
        The joint, its loading and where its motion begins.
    most_cycles, longest_period
        As for :func:`long_term_state`.
    """
    motion, scale = begun.motion(), scales(begun.problem, begun.load_factor)
    start = motion.state.u[begun.problem.layout.slips].copy()
    rules = rules_of(motion, scale, most_cycles, longest_period)
    found = settled(motion, rules)
    return _state(begun, found, start, scale, most_cycles)


def settled(motion: Evolution, rules: ReturnRules) -> Settled:
    """The long-term state of a motion; undecided where the period found breaks the friction law."""
    found = carefully(motion, rules)
    return lawful(motion, [found], [_period_path(motion, found)])[0]


def _period_path(motion: Evolution, found: Settled) -> list[PathSteps]:
    """The period found, followed once more, piece by piece; none where there is no period."""
    if not found.period:
        return []
    motion.pieces.clear()
    motion.state = found.start
    motion.enter_cycle(max(found.cycles - found.period, 1))
    with work_again():
        for _ in cycles_of(motion, found.period, record=True):
            pass
    return motion.recorded()


def lawful(motion: Evolution, found: list[Settled], paths: list[list[PathSteps]]) -> list[Settled]:
    """What was found, undecided where the path of a period breaks the friction law."""
    if not any(paths):
        return found
    history = motion.after_the_first_cycle([piece for path in paths for piece in path])
    assert isinstance(history, CurvedHistory)
    rows = np.array([sum(len(piece.time) for piece in path) for path in paths])
    violations = curved_violations(motion.problem, motion.load_factor, history, rows)
    most = law_resolution(motion.problem, motion.tolerances)
    return [
        each.held_against_law(violation, most) if each.period else each
        for each, violation in zip(found, violations.tolist(), strict=True)
    ]


def carefully(motion: Evolution, rules: ReturnRules) -> Settled:
    """The long-term state of a motion; where leaps leave it in doubt, as a stricter search confirms it.

    Where none does within the cycles allowed, the reason says so.
    """
    begun, care = motion.checkpoint(), 1.0
    found = ReturnSearch(motion, rules).settle()
    while found.doubtful:
        care *= TIGHTER
        motion.restore(begun)
        left = replace(rules, most_cycles=rules.most_cycles - found.cycles + found.looked)
        again = ReturnSearch(motion, left, care).settle()
        if not again.period:
            return replace(found, reason=f"{found.reason}: {NOT_CERTAIN}", cycles=found.cycles + again.cycles)
        agreed, again = again.is_like(found), again.after(found)
        if agreed:
            return again
        found = again
    return found


def rules_of(motion: Evolution, scale: Scales, most_cycles: int, longest_period: int) -> ReturnRules:
    """The rules of a search over cycles with the accuracy of the motion."""
    assert isinstance(motion.method, SpaceEvents)
    measures = motion.method.measures
    lost = DISTINCT * measures.near
    noise = max(measures.accuracy, lost / scale.force) * scale.length
    moving = swing(motion.problem, motion.load)
    stiffest = np.diag(motion.problem.A).reshape(motion.problem.n, -1).max(axis=1)
    stiffness = np.maximum(stiffest * scale.length / scale.force, 1.0)
    return ReturnRules(most_cycles, longest_period, noise, stiffness, 0.0 < moving < RESOLVED * lost)


def _state(begun: Passage, found: Settled, start: FloatArray, scale: Scales, most: int) -> ReturnedState:
    problem, period, records = begun.problem, found.period, found.records
    nothing = np.full(problem.n, np.nan)
    opened, closed = opened_and_closed(records) if period else (np.zeros(problem.n, dtype=bool),) * 2
    return ReturnedState(
        problem=problem,
        load_factor=begun.load_factor,
        initial_slip=start,
        outcome=found.outcome,
        reason=found.reason,
        period=period,
        final_slip=found.state.u[problem.layout.slips].copy(),
        drift=found.drift,
        slip_per_cycle=np.sum([each.slip for each in records], axis=0) if period else nothing,
        friction_dissipation_per_cycle=_mean([each.friction_dissipation for each in records]),
        jump_dissipation_per_cycle=_mean([each.jump_dissipation for each in records]),
        jumps_per_cycle=_mean([float(len(each.jumps)) for each in records]),
        open_nodes=tuple(np.flatnonzero(opened & ~closed).tolist()),
        cycles_simulated=found.cycles,
        slides_away=found.stop is not None and found.stop.slides_away,
        dissipations=np.array([each.dissipation for each in records]),
        opened=opened,
        events=found.events,
        contraction=found.contraction,
        return_error=found.return_error / scale.length,
        signature=found.signature,
        stop=found.stop,
        met=found.violation,
        most_cycles=most,
        begun=begun,
        goal=found.start,
        error=found.error,
        first_cycles=found.first_cycles,
        jumps=found.jumps,
    )


def _mean(values: list[float]) -> float:
    return float(np.mean(values)) if values else np.nan
