"""The long-term states of a motion known only to an accuracy, with their evidence."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.constants import DISTINCT, RESOLVED, THREE_DIGITS, FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.ground.work_limit import work_again
from shakedown.joint.problem import Problem
from shakedown.long_term.passage import Passage
from shakedown.long_term.plane.search import Answers
from shakedown.long_term.space.followed_cycles import SearchRules
from shakedown.long_term.space.proved_verdict import overruled_by_proofs
from shakedown.long_term.space.steady_search import SteadySearch
from shakedown.long_term.state import LongTermState
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
        found = self._settled(Passage.of(self.motion, open_nodes))
        return self._lawful([found], [self._path(found)])[0]

    def from_slips(self, starts: FloatArray, _: Answers, stopped: Callable[[], bool]) -> list[LongTermState]:
        """The long-term states from initial slips (s, 2n), one after the other; none once ``stopped()``."""
        found, paths = list[LongTermState](), list[list[EventHistory]]()
        for start in starts:
            if stopped():
                return []
            self.motion.begin(self.motion.load_factor, start)
            found.append(self._settled(Passage.of(self.motion)))
            paths.append(self._path(found[-1]))
        return self._lawful(found, paths)

    @property
    def _rules(self) -> SearchRules:
        """The rules of a search with the accuracy of the motion."""
        motion, scale = self.motion, self.motion.scale
        assert isinstance(motion.method, SpaceEvents)
        lost = DISTINCT * motion.method.precision.settled
        noise = max(motion.method.accuracy, lost / scale.force) * scale.length
        moving = swing(motion.problem, motion.load)
        stiffest = np.diag(motion.problem.A).reshape(motion.problem.n, -1).max(axis=1)
        stiffness = np.maximum(stiffest * scale.length / scale.force, 1.0)
        blurred = 0.0 < moving < RESOLVED * lost
        return SearchRules(self.most_cycles, self.longest_period, noise, stiffness, blurred)

    def _settled(self, begun: Passage) -> LongTermState:
        """What the motion settles into; where leaps leave it in doubt, as a stricter search confirms it.

        Where none does within the cycles allowed, the reason says so.
        """
        motion, rules, care = self.motion, self._rules, 1.0
        at_start, done, search = motion.state, motion.done, SteadySearch(motion, begun, rules)
        found, probes = search.settle(), search.cycles.probes
        while search.doubts(found):
            care *= TIGHTER
            motion.state = at_start
            motion.enter_cycle(done)
            left = replace(rules, most_cycles=rules.most_cycles - found.cycles_simulated + probes)
            search = SteadySearch(motion, begun, left, care)
            again, probes = search.settle(), probes + search.cycles.probes
            cycles = found.cycles_simulated + again.cycles_simulated
            again = replace(again, cycles_simulated=cycles, most_cycles=rules.most_cycles)
            if not again.period:
                return replace(found, reason=f"{found.reason}: {NOT_CERTAIN}", cycles_simulated=cycles)
            if _are_alike(again, found):
                return again
            found = again
        return found

    def _path(self, found: LongTermState) -> list[EventHistory]:
        """The period found, followed once more; none where there is no period."""
        motion = self.motion
        if not found.period:
            return []
        motion.pieces.clear()
        motion.state = found.goal
        motion.enter_cycle(max(found.cycles_simulated - found.period, 1))
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


def _are_alike(one: LongTermState, other: LongTermState) -> bool:
    """Whether outcome and slip of a period are the same of two searches, within their certainty."""
    alike = (one.outcome, one.period) == (other.outcome, other.period)
    # of the slip per period: by so little it is uncertain, and differs from the one before
    slip, before = one.slip_per_cycle.max(), other.slip_per_cycle.max()
    return alike and bool(abs(slip - before) <= THREE_DIGITS * slip)
