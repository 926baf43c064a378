"""Search for the long-term state: cycle until the sequence of states repeats, then leap to the limit."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import cycles_in_words
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.long_term.cycle_map import CycleMap, Limit, follow_period, limit
from shakedown.long_term.energy_proof import Passage
from shakedown.long_term.state import LongTermState
from shakedown.long_term.steady_period import settled_state, unsettled_state
from shakedown.motion.cycle_record import CycleRecord, State
from shakedown.motion.event_history import EventHistory
from shakedown.motion.integrator import Evolution

LONGEST_PERIOD = 8  # cycles


class LimitSearch:
    """The evolution, and what has been seen of it."""

    def __init__(
        self,
        problem: Problem,
        load_factor: float,
        initial_slip: ArrayLike | None,
        tolerances: Tolerances,
        longest_period: int = LONGEST_PERIOD,
        record: bool = False,
        open_nodes: Iterable[int] = (),
    ) -> None:
        self.evolution = Evolution(problem, load_factor, initial_slip, tolerances, open_nodes=open_nodes)
        self.start = self.evolution.motion.u[problem.layout.slips].copy()
        self.longest_period = longest_period
        self.near = tolerances.periodicity * self.evolution.scale.length
        self.states: list[State] = []
        self.signatures: list[int] = []
        self.cycles = self.events = 0
        self.record = record
        self.followed: list[CycleRecord] = []  # one by one from the start
        self.passed: list[State] = []  # the states after these cycles
        self.path: EventHistory | None = None  # of these cycles, where it is recorded
        self.pieces: list[EventHistory] = []
        self.on_path = True  # whether no cycle has been leapt over
        self.patience = 0  # cycles to wait before the next extrapolation

    def run(self, max_cycles: int) -> LongTermState:
        while self.cycles < max_cycles:
            record = self.evolution.cycle(record=self.record and self.on_path)
            if record is None:
                break
            self._count([record])
            self.states.append(self.evolution.state)
            self._log([record])
            self.signatures.append(record.signature)
            answer = self._returned() or self._extrapolated()
            if answer is not None:
                return self._settled(answer, max_cycles)
            if self.evolution.stop is not None:
                break
        stop = self.evolution.stop
        reason = stop.reason if stop else f"no periodic state within {self.cycles} cycles"
        state = unsettled_state(self.evolution, self.start, reason)
        return self._settled(state, max_cycles)

    def _settled(self, state: LongTermState, most: int) -> LongTermState:
        """The answer with the effort that it took, and the states that the motion passed through."""
        evolution = self.evolution
        passage = Passage(
            evolution.problem,
            evolution.load_factor,
            evolution.tolerances,
            self.start,
            tuple(self.passed),
            most,
        )
        return replace(
            state,
            cycles_simulated=self.cycles,
            events=self.events,
            passage=passage if self.passed else None,
        )

    def follow_on(self, count: int) -> None:
        """Go on from where the path was left until so many cycles have been followed one by one."""
        evolution = self.evolution
        if not self.on_path:
            evolution.state, evolution.done = self.passed[-1], len(self.followed)
            evolution.pieces = self.pieces
            while len(self.followed) < count:
                record = evolution.cycle(record=self.record)
                if record is None:
                    break
                self.followed.append(record)
        if self.record:
            self.path = evolution.history

    def _log(self, records: list[CycleRecord] | tuple[CycleRecord, ...]) -> None:
        """Keep what the last cycles did, and the state after them."""
        if self.on_path:
            self.followed += records
            self.passed.append(self.states[-1])

    def _leave_path(self) -> None:
        """From here on states are set and tried: the motion from the start is not followed any further."""
        if self.on_path and self.record:
            self.pieces = list(self.evolution.pieces)
        self.on_path = False
        self.evolution.pieces.clear()

    def _count(self, records: list[CycleRecord] | tuple[CycleRecord, ...]) -> None:
        self.cycles += len(records)
        self.events += sum(record.events for record in records)

    def _returned(self) -> LongTermState | None:
        """The long-term state where the present state is that of some cycles ago, to round-off."""
        for period in range(1, min(self.longest_period, len(self.states) - 1) + 1):
            past, present = self.states[-1 - period], self.states[-1]
            if np.abs(past.u - present.u).max() <= 1e-3 * self.near:
                ago = f"{period} cycle{'s' * (period > 1)} before"
                text = f"the state after {self.cycles} cycles is that of {ago}"
                if not self._admissible(present):
                    return self._broken(text)
                factor = self._observed_contraction(present, period)
                return self._confirmed(present, period, np.zeros(len(self.start)), factor, text)
        return None

    def _broken(self, text: str) -> LongTermState:
        """Undecided: the state breaks the friction law."""
        residual = self.evolution.violation(self.evolution.state)
        reason = f"the friction law is violated by {residual:.1e} between two cycles ({text})"
        return unsettled_state(self.evolution, self.start, reason, residual)

    def _observed_contraction(self, final: State, period: int) -> float:
        """Factor per cycle between the last two distances to the final state that stand out of round-off."""
        distances = [float(np.abs(state.u - final.u).max()) for state in self.states[-1 - period :: -period]]
        seen = [distance for distance in distances if distance > 10 * self.near][:2]
        return (seen[0] / seen[1]) ** (1.0 / period) if len(seen) == 2 else 0.0

    def _extrapolated(self) -> LongTermState | None:
        """The long-term state as the limit of the affine cycle map, where the sequence repeats."""
        self.patience -= 1
        if self.patience > 0:
            return None
        for period in range(1, self.longest_period + 1):
            last, before = self.signatures[-period:], self.signatures[-2 * period : -period]
            if len(before) < period or last != before:
                continue
            cycle_map = follow_period(self.evolution, period, record=self.record and self.on_path)
            if cycle_map is None:
                return None
            self._count(cycle_map.records)
            self.states.append(cycle_map.end)
            self._log(cycle_map.records)
            self.signatures += cycle_map.signatures
            if any(record.jumps for record in cycle_map.records):
                return None
            if list(cycle_map.signatures) != last or not self._same_contact(cycle_map):
                return None
            answer = self._limit_of(cycle_map, period)
            if answer is not None:
                return answer
        return None

    @staticmethod
    def _same_contact(cycle_map: CycleMap) -> bool:
        return bool(np.array_equal(cycle_map.start.contact, cycle_map.end.contact))

    def _limit_of(self, cycle_map: CycleMap, period: int) -> LongTermState | None:
        """Approach the limit in doubling leaps; where the sequence changes on the way, go on from there."""
        self._leave_path()
        end = limit(cycle_map.jacobian, cycle_map.increment)
        forever = self._is_free(cycle_map, end)
        power, change = cycle_map.jacobian, cycle_map.increment.copy()
        reached, leap = cycle_map.end, 1
        for _ in range(60):
            # change = Σ_{i < leap} Jⁱ d, power = J^leap
            remaining = np.abs(change - leap * end.drift - end.change).max(initial=0.0)
            if forever and end.decaying and remaining <= 1e3 * self.near:
                answer = self._at_limit(cycle_map, end, period)
                if answer is not None:
                    return answer
                break
            change, power, leap = change + power @ change, power @ power, 2 * leap
            state = cycle_map.displaced(change)
            if not self._passes(state, cycle_map, period):
                break
            reached = state
        self.evolution.state = reached
        self.states = [reached]
        self.signatures.clear()
        self.patience = 2
        return None

    def _is_free(self, cycle_map: CycleMap, end: Limit) -> bool:
        """Whether the drift leaves all reactions as they are, so that it can go on for ever."""
        drift = cycle_map.basis @ end.drift
        change = np.abs(self.evolution.kappa @ drift).max(initial=0.0)
        stiffness = float(np.abs(self.evolution.kappa).max())
        return bool(change <= 1e-3 * self.near * stiffness)

    def _passes(self, state: State, cycle_map: CycleMap, period: int) -> bool:
        """Whether this state is admissible and a period from it runs through the sequence of the map."""
        if not (np.isfinite(state.u).all() and self._admissible(state)):
            return False
        self.evolution.state = state
        signatures = []
        for _ in range(period):
            record = self.evolution.cycle()
            if record is None:
                return False
            self._count([record])
            signatures.append(record.signature)
        return tuple(signatures) == cycle_map.signatures

    def _admissible(self, state: State) -> bool:
        return self.evolution.violation(state) <= self.evolution.tolerances.friction_law

    def _at_limit(self, cycle_map: CycleMap, end: Limit, period: int) -> LongTermState | None:
        drift = cycle_map.basis[: len(self.start)] @ end.drift
        text = (
            f"limit of the affine cycle map of a sequence of contact states that repeats every "
            f"{cycles_in_words(period)}"
        )
        factor = end.contraction ** (1.0 / period)
        return self._confirmed(cycle_map.displaced(end.change), period, drift, factor, text)

    def _confirmed(
        self, state: State, period: int, drift: FloatArray, contraction: float, text: str
    ) -> LongTermState | None:
        """The answer, if one exact period from this state returns to it."""
        evolution, slips = self.evolution, self.evolution.problem.layout.slips
        if not self._admissible(state):
            return None
        self._leave_path()
        evolution.state = state
        records: list[CycleRecord] = []
        while len(records) < period:
            record = evolution.cycle(record=True)
            if record is None:
                return None
            records.append(record)
            self._count([record])
            moved = evolution.state.u - state.u
            moved[slips] -= drift * (len(records) / period)
            error = float(np.abs(moved).max())
            if period % len(records) == 0 and error <= self.near:  # the period may be a shorter one
                share = drift * (len(records) / period)
                return settled_state(evolution, self.start, records, share, contraction, error, text)
        return None
