"""The search for the long-term state in space: cycles, with leaps along slow approaches, until it is clear.

After every cycle it asks: is the joint at rest, does its state repeat, does it come to a cycle that it has
all but reached; and if none is so, whether a leap leads on.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.constants import (
    DISTINCT,
    ERROR_FACTOR,
    FOUR_DIGITS,
    MINOR,
    NEGLIGIBLE,
    RESOLVED,
    SEVEN_DIGITS,
    SIX_DIGITS,
    THREE_DIGITS,
    FloatArray,
)
from shakedown.ground.shown_values import cycles_in_words, nodes_in_words
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.ground.work_limit import work_again
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import can_drift
from shakedown.long_term.motion_start import MotionStart
from shakedown.long_term.plane.search import Answers
from shakedown.long_term.proved_outcome import overruled_by_proofs
from shakedown.long_term.space import followed_cycles
from shakedown.long_term.space.extrapolation import SLOW_AFTER, Leaps
from shakedown.long_term.space.followed_cycles import FollowedCycles, Period, SearchRules, drift_goes_on
from shakedown.long_term.state import VARIES_LITTLE, LongTermState, of_long_term_period, opened_and_closed
from shakedown.motion.checked_law import law_resolution, load_range
from shakedown.motion.event_history import CurvedHistory, EventHistory, curved_violations
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import CycleRecord, State, cycles_of
from shakedown.motion.space.space_events import SpaceEvents

# Change per period, relative to its slip, below which a state counts as periodic: the way to rest is at
# least half that slip, and would take 1 / (2 PERIODIC) periods.
PERIODIC = 10 * NEGLIGIBLE


class SteadySearch:
    """Search for the long-term state of a motion, from its present state.

    Parameters
    ----------
    motion
        The joint, at the start of a cycle.
    origin
        Where the motion began.
    rules
        When to end.
    care
        What leaps may be uncertain by, as a share of what they may be otherwise.
    """

    def __init__(self, motion: Evolution, origin: MotionStart, rules: SearchRules, care: float = 1.0) -> None:
        self.origin, self.rules, self.layout = origin, rules, motion.problem.layout
        self.cycles = FollowedCycles(motion, rules.longest_period)
        self.measure = self.cycles.measure
        self.leaps = Leaps(self.cycles, rules.longest_period, care)
        self.none = rules.noise / rules.stiffness  # slip (n,) that counts as none [length]
        self.repeated = [0] * rules.longest_period  # by period: cycles in a row that end where one has begun
        self.rest_since = self.cycle_since = 0  # cycle from which on it is expected

    def run(self) -> LongTermState:
        """Follow cycles until the outcome is clear, the motion stops or the cycles allowed are spent."""
        cycles, most = self.cycles, self.rules.most_cycles
        # budget of extra cycles for slopes, as a multiple of the cycles allowed
        while cycles.count < most + min(cycles.probes, 3 * most):
            if not cycles.follow():
                return self._undecided(self._why_stopped())
            found = self._at_rest() or self._repeats() or self._approaches()
            if found is not None:
                return found
            awaits_verdict = any(0 < times <= p for p, times in enumerate(self.repeated, start=1))
            if self.leaps.try_one(by_slopes=not awaits_verdict):
                self.repeated = [0] * self.rules.longest_period
        spent = f"no periodic state within {most} cycles"
        return self._rest_in_round_off() or self._undecided(spent)

    def _at_rest(self) -> LongTermState | None:
        """Whether nothing slips any more: exactly for one cycle, or for two within the accuracy."""
        last = list(self.cycles.records)[-2:]
        most = [float((record.slip * self.rules.stiffness).max()) for record in last]
        exact = most[-1] == 0.0 and not self.cycles.change(1).any()
        noise = self.rules.noise
        if not exact and (len(last) < 2 or max(most) > noise or self._grows()):
            return None
        if self.cycles.leaps and not exact and most[1] > THREE_DIGITS * noise and self._to_come(1)[0] > noise:
            return None
        breathing = np.flatnonzero(last[-1].opened & last[-1].closed)
        if breathing.size:
            nodes = nodes_in_words(breathing)
            return self._found(
                Outcome.SEPARATION, f"no frictional slip, but opening and closing every cycle: {nodes}", 1
            )
        if self.rules.blurred and not exact:
            return self._undecided(VARIES_LITTLE)
        how = "in the last cycle" if exact else "beyond the accuracy in the last two cycles"
        return self._found(Outcome.SHAKEDOWN, f"no frictional slip {how}{self._extrapolated}", 1)

    def _grows(self) -> bool:
        """Whether a node has slipped more than in the cycle before, which leads away from rest.

        Node by node, as another's slip may hide it. Slip far below the noise that grows is round-off.
        """
        before, now = (self.cycles.records[-k].slip for k in (2, 1))
        return bool((now > np.maximum(before, THREE_DIGITS * self.none)).any())

    def _repeats(self) -> LongTermState | None:
        """Cyclic slip or ratchetting with the shortest period over which states repeat, up to rigid slips."""
        states, measure = self.cycles.states, self.measure
        most = min(self.rules.longest_period, len(states) - 1)
        u = np.array([states[-1 - q].u for q in range(most + 1)])
        changes = np.linalg.norm(measure.seen(u[0] - u[1:]), axis=1)
        self.leaps.find_period(u)
        small = PERIODIC * np.linalg.norm(self.cycles.slip(1, most) * measure.slips)
        round_off, least = followed_cycles.STATE_ROUND_OFF * measure.at_most(u[0]), changes.min()
        if least <= small + round_off:  # a product with the whole stiffness, mostly not needed
            round_off = followed_cycles.STATE_ROUND_OFF * measure.terms(u[0])
        if least > small + round_off:
            self.repeated = [0] * self.rules.longest_period
            return None
        for p in range(1, most + 1):
            slip = self.cycles.slip(1, p)
            size = float(np.linalg.norm(slip * measure.slips))
            slips = float((slip * self.rules.stiffness).max()) > self.rules.noise
            again = slips and changes[p - 1] <= max(PERIODIC * size, round_off)
            self.repeated[p - 1] = self.repeated[p - 1] + 1 if again else 0
            if self.repeated[p - 1] > p and changes[: p - 1].min(initial=np.inf) > self._may_approach(p):
                found = self._slips_for_ever(p)
                if found is not None:
                    return found
        return None

    def _may_approach(self, p: int) -> float:
        """How far the states of a period may still move together, as changes fade [energy norm]."""
        states = self.cycles.states
        last, before = (self.measure.size(states[-1 - k].u - states[-1 - k - p].u) for k in (0, p))
        periods = before / (before - last) if before > last else np.inf
        # times the fading part; twice that separates states on both sides of their limit
        return 4.0 * last * min(periods, self.rules.most_cycles)

    def _approaches(self) -> LongTermState | None:
        """The outcome where the change falls along a line to a cycle that is next to the state."""
        p, found = self.leaps.period, None
        if not self.cycles.leaps or len(self.cycles.states) <= p:
            return None
        decay, now = self.leaps.last()
        left = self._share_left(decay.to_come(now, self.measure))
        if decay.slip_ends(now, self.none) and not self.cycles.records[-1].opened.any():
            if left <= FOUR_DIGITS and not self.rest_since:
                self.rest_since = self.cycles.count
            if left <= SEVEN_DIGITS or self._rests_unseen(now):
                return self._slip_fades()
        slip = float(np.linalg.norm(now.slip * self.measure.slips))
        # enough where rest is excluded: another slip that lasts as long may yet end
        little = self.cycles.motion.tolerances.slip_change * slip
        if now.size < little and decay.slip_lasts(now) and not self.cycles.records[-1].opened.any():
            found = self._slips_for_ever(p)
        if found is not None or now.size > SIX_DIGITS * slip:
            return found
        # what may be left of the way to a cycle along a line, of that so far
        if left <= 1e-5 and decay.slip_lasts(now):
            return self._slips_for_ever(p)
        expected = decay.comes_to_a_cycle(now, self.measure, PERIODIC * slip)
        self.cycle_since = (self.cycle_since or self.cycles.count) if expected else 0
        if expected and self.cycle_since <= self.cycles.count - SLOW_AFTER:
            return self._slips_for_ever(p, long_expected=True)
        return None

    def _rest_in_round_off(self) -> LongTermState | None:
        """Rest, where the slip falls to none with changes that are round-off of the state."""
        cycles = self.cycles
        if not cycles.leaps or len(cycles.states) < 2 or cycles.records[-1].opened.any():
            return None
        decay, now = self.leaps.decays[0], cycles.last(1)
        lost = followed_cycles.STATE_ROUND_OFF * self.measure.terms(now.state)
        near = now.size <= lost and self._share_left(decay.to_come(now, self.measure, lost)) <= MINOR
        return self._slip_fades() if near and decay.slip_ends(now, self.none, 0.0) else None

    def _slip_fades(self) -> LongTermState:
        """Rest, as it is expected."""
        return self._found(Outcome.SHAKEDOWN, f"slip fades away with the changes{self._extrapolated}", 1)

    def _share_left(self, ahead: FloatArray | None) -> float:
        """The largest share of its slip that a node has still to go, where more than none; ∞ unknown.

        Relative to its own slip since the search began, as another one may have gone far and may hide it.
        """
        if ahead is None:
            return np.inf
        state = self.cycles.states[-1].u
        left, come = self.layout.slip_distances(ahead), self.layout.slip_distances(state - self.cycles.start)
        counts = left > self.none
        return float((left[counts] / np.maximum(come, self.none)[counts]).max(initial=0.0))

    def _rests_unseen(self, now: Period) -> bool:
        """Whether rest has long been expected, and no node changes by more than the accuracy of motion."""
        long = 0 < self.rest_since <= self.cycles.count - SLOW_AFTER
        return long and bool((self.layout.slip_distances(now.change) <= self.none).all())

    def _slips_for_ever(self, p: int, long_expected: bool = False) -> LongTermState | None:
        """The outcome where the same slip occurs in every period of p cycles, if that is clear.

        Long expected is a cycle whose end the leaps do not come nearer to.
        """
        cycles, decay = self.cycles, self.leaps.decays[p - 1]
        now, every = cycles.last(p), cycles_in_words(p)
        most = float(now.slip.max())
        clear = THREE_DIGITS * float((now.slip * self.rules.stiffness).max())
        error = max(record.error for record in list(cycles.records)[-p:])
        differs = np.abs(cycles.slip(p + 1, 2 * p) - now.slip).max() > THREE_DIGITS * most
        floats, forgotten = can_drift(cycles.motion.problem), len(cycles.states) <= 2 * p  # by a leap
        if (floats and forgotten) or error > clear or differs or decay.slip_ends(now, self.none):
            return None
        walks, all_drifts = False, False
        if floats:
            walks, all_drifts = drift_goes_on(cycles, p, decay.drift_left(now), self.none, error)
        cyclic = np.abs(now.change).max() <= SIX_DIGITS * most and not walks
        if not cyclic and (long_expected or decay.slip_lasts(now)):
            cyclic = not floats or self._is_held(p, now.slip) or (long_expected and decay.drift_ends(now))
        if cyclic:
            return self._found(Outcome.CYCLIC_SLIP, f"slip per {every} constant{self._extrapolated}", p)
        if walks or all_drifts or (floats and decay.drift_lasts(now)):
            return self._found(Outcome.RATCHETTING, f"drift per {every} constant{self._extrapolated}", p)
        return None

    def _is_held(self, p: int, slip: FloatArray) -> bool:
        """Whether nodes that stick, or all but stick, leave no room for a rigid slip, while none opens."""
        opens = bool(opened_and_closed(list(self.cycles.records)[-p:], self.layout.n)[0].any())
        if opens or not self.measure.rigid.shape[1]:  # a body that moves only where nodes open
            return not opens
        return followed_cycles.is_held(self.layout, self.measure.rigid, slip, self.none)

    def _to_come(self, period: int, drifts: bool = False) -> tuple[float, float]:
        """What later periods may add to a state, and the factor per cycle by which changes fade."""
        return self.cycles.to_come(period, self.leaps.rate if self.cycles.leaps else None, drifts)

    @property
    def _extrapolated(self) -> str:
        """The known cycles that led to the last state."""
        return "; approach extrapolated" if self.cycles.leaps else ""

    def _found(self, outcome: Outcome, reason: str, period: int) -> LongTermState:
        """The answer; for a cycle the period is followed again from the end of the search."""
        cycles, leaps, drifts = self.cycles, self.leaps, outcome == Outcome.RATCHETTING
        (left, rate), start = self._to_come(period, drifts), cycles.motion.state
        if drifts or outcome == Outcome.CYCLIC_SLIP:
            if cycles.leaps:
                now = cycles.last(period)
                farthest = leaps.decays[period - 1].farthest(now, self.layout, self.measure, drifts)
                left = max(left, ERROR_FACTOR * farthest)
            if not cycles.follow(period):
                return self._undecided(f"{self._why_stopped()}, after {reason}")
        moved, error = cycles.change(period), leaps.error + leaps.rigid_error
        drift = np.zeros_like(moved)
        if drifts:  # where it stands on its way says nothing
            drift, error = moved, leaps.error_apart
        return self._state(
            outcome,
            reason,
            start,
            list(cycles.records)[-period:],
            drift=drift[self.layout.slips],
            contraction=rate,
            return_error=float(np.abs(moved - drift).max()) / cycles.motion.scale.length,
            error=max(left, self.rules.noise) + cycles.error + error,
        )

    def doubts(self, found: LongTermState) -> bool:
        """Whether leaps leave more open than the slip of a period: the motion may reach another cycle."""
        if found.outcome not in (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING):
            return False
        rigid_error = self.leaps.rigid_error if found.outcome == Outcome.CYCLIC_SLIP else 0.0
        return bool(found.error - rigid_error > found.slip_per_cycle.max())

    def _why_stopped(self) -> str:
        stop = self.cycles.motion.stop
        return stop.reason if stop else "the motion cannot be followed"

    def _undecided(self, reason: str) -> LongTermState:
        motion, nothing = self.cycles.motion, np.full(self.layout.slip_size, np.nan)
        numbers = dict.fromkeys(("contraction", "return_error", "error"), np.nan)
        return self._state(
            Outcome.UNDECIDED, reason, motion.state, [], stop=motion.stop, drift=nothing, **numbers
        )

    def _state(
        self, outcome: Outcome, reason: str, goal: State, records: list[CycleRecord], **found: Any
    ) -> LongTermState:
        """The long-term state with the numbers of the cycles of its period."""
        cycles, origin, stop = self.cycles, self.origin, found.get("stop")
        return LongTermState(
            problem=origin.problem,
            load_factor=origin.load_factor,
            initial_slip=origin.start,
            outcome=outcome,
            reason=reason,
            final_slip=cycles.motion.state.u[self.layout.slips],
            cycles_simulated=cycles.count,
            slides_away=stop is not None and stop.slides_away,
            events=cycles.events,
            most_cycles=self.rules.most_cycles,
            origin=origin,
            goal=goal,
            first_cycles=tuple(cycles.passed),
            jumps=tuple(cycles.jumps),
            **found,
            **of_long_term_period(records, origin.problem.n),
        )


NOT_CERTAIN = "a cycle exists, not certainly the one that this motion reaches"


class SteadySearches:
    """Search after search for long-term states over one motion in space, cycle by cycle.

    The numbers of a state are those of one period followed from it, to the accuracy of the motion.

    Parameters
    ----------
    problem, tolerances
        The joint, and what decides.
    most_cycles, longest_period
        As for :func:`long_term_state`.
    """

    def __init__(self, problem: Problem, t: Tolerances, most_cycles: int, longest_period: int) -> None:
        self.motion = Evolution(problem, 0.0, None, t)
        self.most_cycles, self.longest_period = most_cycles, longest_period

    def begin(self, load_factor: float, initial_slip: ArrayLike | None, open_nodes: tuple[int, ...]) -> None:
        """Go to the start at a load factor."""
        self.motion.begin(load_factor, initial_slip, open_nodes)

    def state(self, open_nodes: tuple[int, ...]) -> LongTermState:
        """The long-term state of the motion from its start, with the given nodes open there."""
        found = self._settled_state(MotionStart.of(self.motion, open_nodes))
        return self._lawful([found], [self._path(found)])[0]

    def from_slips(self, starts: FloatArray, _: Answers, stopped: Callable[[], bool]) -> list[LongTermState]:
        """The long-term states from initial slips (s, 2n), one after the other; none once ``stopped()``."""
        found, paths = list[LongTermState](), list[list[EventHistory]]()
        for start in starts:
            if stopped():
                return []
            self.motion.begin(self.motion.load_factor, start)
            found.append(self._settled_state(MotionStart.of(self.motion)))
            paths.append(self._path(found[-1]))
        return self._lawful(found, paths)

    @property
    def _rules(self) -> SearchRules:
        """The rules of a search with the accuracy of the motion."""
        motion, scale = self.motion, self.motion.scale
        assert isinstance(motion.method, SpaceEvents)
        lost = DISTINCT * motion.method.courses[False].residual
        noise = max(motion.method.accuracy, lost / scale.force) * scale.length
        moving = load_range(motion.problem, motion.load)
        stiffest = np.diag(motion.problem.A).reshape(motion.problem.n, -1).max(axis=1)
        stiffness = np.maximum(stiffest * scale.length / scale.force, 1.0)
        blurred = 0.0 < moving < RESOLVED * lost
        return SearchRules(self.most_cycles, self.longest_period, noise, stiffness, blurred)

    def _settled_state(self, origin: MotionStart) -> LongTermState:
        """What the motion settles into; where leaps leave it in doubt, as a stricter search confirms it.

        Where none does within the cycles allowed, the reason says so.
        """
        motion, rules, care = self.motion, self._rules, 1.0
        at_start, done, search = motion.state, motion.done, SteadySearch(motion, origin, rules)
        found, probes = search.run(), search.cycles.probes
        while search.doubts(found):
            # of the uncertainty allowed in leaps, from one search to the next that confirms it
            care *= 0.125
            motion.state = at_start
            motion.enter_cycle(done)
            left = replace(rules, most_cycles=rules.most_cycles - found.cycles_simulated + probes)
            search = SteadySearch(motion, origin, left, care)
            again, probes = search.run(), probes + search.cycles.probes
            cycles = found.cycles_simulated + again.cycles_simulated
            again = replace(again, cycles_simulated=cycles, most_cycles=rules.most_cycles)
            if not again.period:
                return replace(found, reason=f"{found.reason}: {NOT_CERTAIN}", cycles_simulated=cycles)
            # of the slip per period: by so little it is uncertain, and differs from the one before
            slip, before = again.slip_per_cycle.max(), found.slip_per_cycle.max()
            alike = (again.outcome, again.period) == (found.outcome, found.period)
            found = again
            if alike and abs(slip - before) <= THREE_DIGITS * slip:
                break
        return found

    def _path(self, found: LongTermState) -> list[EventHistory]:
        """The period found, followed once more; none where there is no period."""
        motion = self.motion
        if not found.period:
            return []
        motion.state = found.goal
        motion.enter_cycle(1)  # not the first, and no matter which
        with work_again():
            for _ in cycles_of(motion, found.period, record=True):
                pass
        return [motion.history]

    def _lawful(self, found: list[LongTermState], paths: list[list[EventHistory]]) -> list[LongTermState]:
        """The states as proofs leave them, undecided where the path of a period breaks the friction law."""
        motion = self.motion
        violations, most = np.full(len(found), np.nan), law_resolution(motion.problem, motion.tolerances)
        if any(paths):
            history = CurvedHistory.joined([piece for path in paths for piece in path])
            rows = np.array([sum(map(len, path)) for path in paths])
            violations = curved_violations(motion.problem, motion.load_factor, history, rows)
        return [
            overruled_by_proofs(
                state if not state.period else state.checked(violation, most, "in the period found")
            )
            for state, violation in zip(found, violations.tolist(), strict=True)
        ]
