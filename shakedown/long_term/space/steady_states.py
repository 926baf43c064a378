"""The long-term states of a motion known only to an accuracy, with their evidence."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.constants import DISTINCT, RESOLVED, FloatArray
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.ground.work_limit import work_again
from shakedown.joint.problem import Problem
from shakedown.long_term.passage import Passage
from shakedown.long_term.plane.search import Answers
from shakedown.long_term.space.followed_cycles import SearchRules, Settled
from shakedown.long_term.space.proved_verdict import overruled_by_proofs
from shakedown.long_term.space.steady_search import SteadySearch
from shakedown.long_term.state import LongTermState, of_long_term_period
from shakedown.motion.checked_law import law_resolution, swing
from shakedown.motion.event_history import CurvedHistory, EventHistory, curved_violations
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import cycles_of
from shakedown.motion.space.space_events import SpaceEvents

TIGHTER = 0.125  # factor on the uncertainty allowed in leaps from one search to the next that confirms it
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
        begun = Passage.of(self.motion, open_nodes)
        found = self._settled()
        return self._lawful([begun], [found], [self._path(found)])[0]

    def from_slips(self, starts: FloatArray, _: Answers, stopped: Callable[[], bool]) -> list[LongTermState]:
        """The long-term states from initial slips (s, 2n), one after the other; none once ``stopped()``."""
        begun, found, paths = list[Passage](), list[Settled](), list[list[EventHistory]]()
        for start in starts:
            if stopped():
                return []
            self.motion.begin(self.motion.load_factor, start)
            begun.append(Passage.of(self.motion))
            found.append(self._settled())
            paths.append(self._path(found[-1]))
        return self._lawful(begun, found, paths)

    @property
    def _rules(self) -> SearchRules:
        """The rules of a search with the accuracy of the motion."""
        motion, scale = self.motion, self.motion.scale
        assert isinstance(motion.method, SpaceEvents)
        measures = motion.method.measures
        lost = DISTINCT * measures.precision.settled
        noise = max(measures.accuracy, lost / scale.force) * scale.length
        moving = swing(motion.problem, motion.load)
        stiffest = np.diag(motion.problem.A).reshape(motion.problem.n, -1).max(axis=1)
        stiffness = np.maximum(stiffest * scale.length / scale.force, 1.0)
        blurred = 0.0 < moving < RESOLVED * lost
        return SearchRules(self.most_cycles, self.longest_period, noise, stiffness, blurred)

    def _settled(self) -> Settled:
        """What the motion settles into; where leaps leave it in doubt, as a stricter search confirms it.

        Where none does within the cycles allowed, the reason says so.
        """
        motion, rules, care = self.motion, self._rules, 1.0
        begun, done = motion.state, motion.done
        found = SteadySearch(motion, rules).settle()
        while found.doubtful:
            care *= TIGHTER
            motion.state = begun
            motion.enter_cycle(done)
            cycles, probes = found.followed.count, found.followed.probes
            left = replace(rules, most_cycles=rules.most_cycles - cycles + probes)
            again = SteadySearch(motion, left, care).settle()
            again.followed.count += cycles
            again.followed.probes += probes
            if not again.period:
                found.followed.count = again.followed.count
                return replace(found, reason=f"{found.reason}: {NOT_CERTAIN}")
            if again.is_like(found):
                return again
            found = again
        return found

    def _path(self, found: Settled) -> list[EventHistory]:
        """The period found, followed once more; none where there is no period."""
        motion = self.motion
        if not found.period:
            return []
        motion.pieces.clear()
        motion.state = found.start
        motion.enter_cycle(max(found.followed.count - found.period, 1))
        with work_again():
            for _ in cycles_of(motion, found.period, record=True):
                pass
        return [motion.history]

    def _lawful(
        self, begun: list[Passage], found: list[Settled], paths: list[list[EventHistory]]
    ) -> list[LongTermState]:
        """The states as proofs leave them, undecided where the path of a period breaks the friction law."""
        motion = self.motion
        violations, most = np.full(len(found), np.nan), law_resolution(motion.problem, motion.tolerances)
        if any(paths):
            history = CurvedHistory.joined([piece for path in paths for piece in path])
            rows = np.array([sum(map(len, path)) for path in paths])
            violations = curved_violations(motion.problem, motion.load_factor, history, rows)
        each = zip(begun, found, violations.tolist(), strict=True)
        return [
            overruled_by_proofs(self._state(start, one, violation, not violation <= most))
            for start, one, violation in each
        ]

    def _state(self, begun: Passage, found: Settled, violation: float, broken: bool) -> LongTermState:
        """The long-term state from what was found, and the violation of the law in its period, if any."""
        problem, cycles, stop = begun.problem, found.followed, found.stop
        nothing, decided = np.full_like(found.drift, np.nan), found.period > 0 and not broken
        broken = broken and found.period > 0
        met = f"the friction law is violated by {violation:.1e} in the period found ({found.reason})"
        return LongTermState(
            problem=problem,
            load_factor=begun.load_factor,
            initial_slip=begun.start,
            outcome=Outcome.UNDECIDED if broken else found.outcome,
            reason=met if broken else found.reason,
            final_slip=found.state.u[problem.layout.slips].copy(),
            drift=found.drift if decided else nothing,
            cycles_simulated=cycles.count,
            slides_away=stop is not None and stop.slides_away,
            events=cycles.events,
            contraction=found.contraction if decided else np.nan,
            return_error=found.return_error / self.motion.scale.length if decided else np.nan,
            error=found.error if decided else np.nan,
            stop=stop,
            met=violation if found.period else np.nan,
            most_cycles=self.most_cycles,
            begun=begun,
            goal=found.start,
            first_cycles=tuple(cycles.passed),
            jumps=tuple(cycles.jumps),
            **of_long_term_period(found.records if decided else [], problem.n),
        )
