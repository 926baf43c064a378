"""The smallest load factor at which a cycle of one pattern of contact states exists, as a linear program."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import STICK, Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import constraints, step_loads
from shakedown.joint.problem import Problem
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory, EventKind
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import solve


@dataclass(frozen=True)
class LeastCycle:
    """The smallest load factor at which a pattern of contact states closes to a cycle.

    Attributes
    ----------
    load_factor
        The smallest λ at which the pattern is possible; the slip in it may have shrunk to nothing there.
    slip : (n,)
        The slip that this cycle has at the first load step [length].
    """

    load_factor: float
    slip: FloatArray


@dataclass(frozen=True)
class CyclePattern:
    """The directions in which nodes slip between the events of a cycle with all nodes closed.

    Between two events everything is linear in time, so that a cycle of the pattern is the slips
    at its E events with: every node within its limits at every event; a node that slips at its
    limit at both ends of the interval, and moved in its own direction; a node that sticks
    unmoved; the last state the first one. The load at an event within the segment from load step
    k to the next is r⁰ + λ r¹_k + β (r¹_(k+1) − r¹_k), 0 ≤ β ≤ λ. All that is linear in the
    slips, the β and λ.

    Attributes
    ----------
    problem
        The joint.
    sample : (E,)
        The load step that each event is at, or comes after.
    within : (E,)
        Whether it lies within the segment that begins there.
    state : (E, n)
        From the event on: 0 stick, +1 backward slip, −1 forward slip.
    """

    problem: Problem
    sample: NDArray[np.intp]
    within: NDArray[np.bool_]
    state: NDArray[np.intp]

    def least(self, tolerances: Tolerances = DEFAULT) -> LeastCycle | None:
        """The smallest λ at which the pattern is a cycle; None where the program finds none.

        Few limits of nodes that stick matter. For each of them the event at which it is violated most is
        taken, as long as there is one.
        """
        rows = self.rows
        taken = rows.equal | rows.kept
        sizes = np.abs(rows.matrix)
        while True:  # ends: every round takes further rows, and there are finitely many
            program = Program(
                rows.matrix[taken],
                rows.right[taken],
                cost=rows.cost,
                left=np.where(rows.equal, rows.right, -INF)[taken],
                lower=rows.lowest,
                tolerances=tolerances,
            )
            found = solve(program)
            if not found.optimal:
                return None
            terms = np.maximum(sizes @ np.abs(found.x), np.abs(rows.right))
            excess = (rows.matrix @ found.x - rows.right) / np.where(terms > 0, terms, 1.0)
            excess[taken] = 0.0
            by_limit = excess[: rows.limits].reshape(-1, len(constraints(self.problem).g))
            worst = by_limit.argmax(axis=0) * by_limit.shape[1] + np.arange(by_limit.shape[1])
            violated = worst[excess[worst] > tolerances.feasibility]
            if violated.size == 0:
                return LeastCycle(float(found.x[-1]), found.x[self.columns[self.first]])
            taken[violated] = True

    @property
    def first(self) -> int:
        """The event at which the first load step is reached."""
        return int(np.flatnonzero((self.sample == 0) & ~self.within)[0])

    @cached_property
    def columns(self) -> NDArray[np.intp]:
        """The unknown that is the slip of each node at each event, (E, n): one per stretch of sticking."""
        moves = self.state != STICK
        parts = np.cumsum(np.vstack([np.zeros((1, self.problem.n), dtype=bool), moves[:-1]]), axis=0)
        parts = np.where((parts == parts[-1]) & ~moves[-1], 0, parts)  # last continues in first
        return parts + np.append(0, np.cumsum(parts.max(axis=0) + 1)[:-1])

    @cached_property
    def rows(self) -> "PatternRows":
        """The program in the slips, the β and λ."""
        slips, events = int(self.columns.max()) + 1, np.flatnonzero(self.within)
        count = slips + len(events) + 1
        share = np.full(len(self.sample), -1)
        share[events] = slips + np.arange(len(events))
        limits, right, equal = self._limits(share, count)
        moved = self._moved(count)
        order = self._order(share, count)
        for part in (limits, moved):  # pinned slips of a floating body vanish at the first load step
            part[:, self.columns[self.first, list(constraints(self.problem).pinned)]] = 0.0
        kept = np.append(np.zeros(len(limits), dtype=bool), np.ones(len(moved) + len(order), dtype=bool))
        return PatternRows(
            matrix=np.vstack([limits, moved, order]),
            right=np.append(right, np.zeros(len(moved) + len(order))),
            equal=np.append(equal, np.zeros(len(moved) + len(order), dtype=bool)),
            kept=kept,
            lowest=np.append(np.full(slips, -INF), np.zeros(len(events) + 1)),
            cost=np.append(np.zeros(count - 1), 1.0),
            limits=len(limits),
        )

    def _limits(
        self, share: NDArray[np.intp], count: int
    ) -> tuple[FloatArray, FloatArray, NDArray[np.bool_]]:
        """Both limits of every node at every event; equalities where the node slips before or after it."""
        rows, steps, size = constraints(self.problem), step_loads(self.problem), len(self.sample)
        matrix = np.zeros((size, len(rows.g), count))
        for event in range(size):
            matrix[event][:, self.columns[event]] = rows.G  # a column per node
            matrix[event][:, -1] = steps[self.sample[event]]
            if share[event] >= 0:
                following = steps[(self.sample[event] + 1) % self.problem.m]
                matrix[event][:, share[event]] = following - steps[self.sample[event]]
        slips = self.state[:, rows.node] == rows.side
        equal = slips | np.roll(slips, 1, axis=0)
        return matrix.reshape(-1, count), np.tile(rows.g, size), equal.ravel()

    def _moved(self, count: int) -> FloatArray:
        """A node slips in its own direction: v before less v after, times the direction, is not positive."""
        events, nodes = np.nonzero(self.state)
        matrix, at = np.zeros((len(events), count)), np.arange(len(events))
        direction = -self.state[events, nodes].astype(float)
        matrix[at, self.columns[events, nodes]] += direction
        matrix[at, self.columns[(events + 1) % len(self.sample), nodes]] -= direction
        return matrix

    def _order(self, share: NDArray[np.intp], count: int) -> FloatArray:
        """The events within a segment keep their order: β ≤ the next β, or λ after the last."""
        events = np.flatnonzero(self.within)
        following = (events + 1) % len(self.sample)
        matrix, at = np.zeros((len(events), count)), np.arange(len(events))
        matrix[at, share[events]] = 1.0
        matrix[at, np.where(self.within[following], share[following], count - 1)] = -1.0
        return matrix


class PatternRows(NamedTuple):
    """matrix · (slips, β, λ) ≤ right, with equality in some rows.

    Attributes
    ----------
    matrix : (R, N)
        Coefficients.
    right : (R,)
        Right-hand sides [force], or 0 [length, load factor].
    equal, kept : (R,)
        Whether a row is an equality; whether it is in the program from the start.
    lowest : (N,)
        Least value of each unknown.
    cost : (N,)
        λ.
    limits
        How many rows are limits: 2n at each event.
    """

    matrix: FloatArray
    right: FloatArray
    equal: NDArray[np.bool_]
    kept: NDArray[np.bool_]
    lowest: FloatArray
    cost: FloatArray
    limits: int


def cycle_pattern(problem: Problem, state: LongTermState) -> CyclePattern | None:
    """The pattern of a cycle; None of a long-term state that is none, or in which nodes open or jump.

    Examples
    --------
    The counter-example to the first collapse cycles from where a cycle of one node alone is
    no longer excluded.

    >>> import shakedown
    >>> joint = shakedown.example("three-node")
    >>> pattern = cycle_pattern(joint, shakedown.long_term_state(joint, 2.6, joint.initial_slip[0]))
    >>> round(pattern.least().load_factor, 4)
    2.4442
    """
    path = state.history
    simple = state.outcome == Outcome.CYCLIC_SLIP and not state.opened.any() and not state.jumps_per_cycle
    if not simple or (problem.f == 0.0).any():
        return None
    at_step = path.kind == EventKind.LOAD_STEP
    last = np.maximum.accumulate(np.where(at_step, np.arange(len(path)), 0))
    sample = np.rint(path.cycle[last] * problem.m).astype(np.intp) % problem.m
    return CyclePattern(problem, sample[:-1], ~at_step[:-1], path.state[:-1].astype(np.intp))


def first_load_slip(problem: Problem, path: EventHistory) -> FloatArray:
    """The slip that a recorded period has at the first load step, (n,) [length]."""
    steps = np.flatnonzero(path.kind == EventKind.LOAD_STEP)
    sample = np.rint(path.cycle[steps] * problem.m).astype(np.intp) % problem.m
    return np.asarray(path.v[steps[sample == 0][0]])
