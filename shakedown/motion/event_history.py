"""The path of a motion: its events, and the states at these.

The path of a motion in two tangential directions: events, and smooth curves between them.

The friction law at every instant of a recorded path.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import NEGLIGIBLE, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.status import OPEN, STICK
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.motion.checked_law import law_violation, least_slip, reactions, scales, scales_of
from shakedown.motion.course import EventKind
from shakedown.motion.space.space_run import DEGREE


@dataclass(frozen=True, eq=False, repr=False)
class EventHistory(Result):
    """The path of a motion, one row per event; between rows everything is linear in time.

    With fixed load steps there is a row for each, the state at its end; what lies between is not known.

    Attributes
    ----------
    cycle : (s,)
        Time in cycles; what precedes the first period has negative times.
    kind : (s,)
        What happened at that time (:class:`EventKind`).
    node : (s,)
        The node that it happened to; −1 where it concerns none.
    v, w : (s, n)
        Slips and gaps [length].
    q, p : (s, n)
        Reactions [force].
    q_w, p_w : (s, n)
        Welded reactions [force].
    state : (s, n)
        State from this time on: 0 stick, +1 backward slip, −1 forward slip, 2 open. With fixed
        load steps that during the step.
    """

    cycle: FloatArray
    kind: NDArray[np.int64]
    node: NDArray[np.int64]
    v: FloatArray
    w: FloatArray
    q: FloatArray
    p: FloatArray
    q_w: FloatArray
    p_w: FloatArray
    state: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.cycle)

    @classmethod
    def none(cls, layout: Layout) -> "EventHistory":
        """A path on which nothing is recorded."""
        slips, empty = np.empty((0, layout.slip_size)), np.empty((0, layout.n))
        numbers = np.empty(0, dtype=np.int64)
        state = empty.astype(np.int64)
        return cls(np.empty(0), numbers, numbers, slips, empty, slips, empty, slips, empty, state)

    @classmethod
    def joined(cls, pieces: "Sequence[EventHistory]") -> Self:
        """One path after the other."""
        columns = ([getattr(part, key) for part in pieces] for key in cls.__dataclass_fields__)
        return cls(*(np.concatenate(column) for column in columns))

    def rows(self, index: NDArray[np.intp] | NDArray[np.bool_]) -> Self:
        """The history at chosen rows only."""
        return type(self)(*(getattr(self, key)[index] for key in self.__dataclass_fields__))

    def refined(self) -> "EventHistory":
        """The path with enough rows for linear interpolation; without curves the path itself."""
        return self

    def without_round_off(self, problem: Problem, tolerances: Tolerances = DEFAULT) -> Self:
        """The same path, on which nodes stick that slip by no more in all than what counts as none.

        A node that comes to its limit and no further is there in the state of a slip: whether it is
        depends on the last bit.

        Examples
        --------
        >>> import shakedown
        >>> joint = shakedown.example("two-node")
        >>> path = shakedown.long_term_state(joint, 0.9, [2.0, 1.0]).history
        >>> path.without_round_off(joint).state.any(axis=0)
        array([False,  True])
        """
        slip = np.where(self.state[:-1] != OPEN, problem.law.size(np.diff(self.v, axis=0)), 0.0).sum(axis=0)
        none = least_slip(problem, tolerances) * scales_of(problem, self.q_w, self.p_w).length
        return replace(self, state=np.where((slip <= none) & (self.state != OPEN), STICK, self.state))

    def at(self, cycle: FloatArray) -> "EventHistory":
        """The exact states at given times in cycles, by linear interpolation or on the curves between rows.

        At a jump the state after it counts. The last load step of m begins at 1 − 1/m of a
        cycle: the end of a cycle is the beginning of the next one.

        Raises
        ------
        UsageError
            If a time lies before the first event or after the last.

        Examples
        --------
        >>> import shakedown
        >>> from shakedown.motion.evolution import evolve
        >>> evolve(shakedown.example("two-node"), 0.9, cycles=2).history.at([0.0, 1.0]).v.round(4)
        array([[0.    , 0.    ],
               [0.    , 0.7132]])
        """
        cycle, (first, last), lasting = np.asarray(cycle, dtype=float), self.cycle[[0, -1]], self._lasting
        outside = cycle[~((cycle >= first - NEGLIGIBLE) & (cycle <= last + NEGLIGIBLE))]
        if outside.size:
            raise UsageError(f"cycle: expected times from {first:g} to {last:g}, found {outside[0]:g}")
        row = np.clip(np.searchsorted(self.cycle, cycle, side="right") - 1, 0, len(self) - 1)
        span = lasting[row]
        share = np.where(span > 0, (cycle - self.cycle[row]) / np.where(span > 0, span, 1.0), 0.0)
        return self.within(row, np.clip(share, 0.0, 1.0))

    @property
    def _lasting(self) -> FloatArray:
        """How long the path goes on from each row as that says, (s,) [cycles]."""
        return np.diff(self.cycle, append=self.cycle[-1:])

    def within(self, row: NDArray[np.intp], share: FloatArray) -> "EventHistory":
        """The states at a share of the way from rows to the next ones, (k,) of both."""
        what = np.full(len(row), EventKind.LOAD_STEP, dtype=np.int64), np.full(len(row), -1, dtype=np.int64)
        linear = self.v, self.w, self.q, self.p, self.q_w, self.p_w
        v, w, q, p, q_w, p_w = (self._between(part, row, share) for part in linear)
        cycle = self.cycle[row] + share * self._lasting[row]
        return EventHistory(cycle, *what, v, w, q, p, q_w, p_w, self.state[row])

    def _between(self, values: FloatArray, row: NDArray[np.intp], share: FloatArray) -> FloatArray:
        after = np.minimum(row + 1, len(self) - 1)
        return np.asarray(values[row] + share[:, None] * (values[after] - values[row]))


WITHIN = (0.0, 0.25, 0.5, 0.75)  # shares of a step at which its curve is checked


def recorded_path(result: Any, name: str = "result") -> EventHistory:
    """The path of a result that has recorded one, or the path itself; ``UsageError`` where there is none."""
    path = result if isinstance(result, EventHistory) else getattr(result, "history", None)
    if not isinstance(path, EventHistory) or not len(path):
        raise UsageError(f"{name}: expected recorded events (record=True, method 'event'), found none")
    return path


@dataclass(frozen=True, eq=False, repr=False)
class CurvedHistory(EventHistory):
    """A path whose slips are curves: one row per step of it, from its beginning to that of the next row.

    Slips, tangential reactions and their like are (…, 2n), node by node. Contact states are 0 stick,
    1 slip, 2 open; rows at which nothing happens have the kind :attr:`EventKind.CURVES`.

    Attributes
    ----------
    duration : (s,)
        Length of the step [cycles].
    curve, reaction_curve : (s, 4, 3n)
        At the share x of the step (v, w) has changed by Σ x^(k+1) curve_k, and (q, p) likewise.
    """

    duration: FloatArray
    curve: FloatArray
    reaction_curve: FloatArray

    def within(self, row: NDArray[np.intp], share: FloatArray) -> "CurvedHistory":
        """The states at a share of the step that begins in a row, (k,) of both."""
        n = self.w.shape[1]

        def along(values: FloatArray, curve: FloatArray, places: slice) -> FloatArray:
            total = values[row]
            for power in range(DEGREE):  # one power at a time, as curves of all rows take most of the memory
                total += share[:, None] ** (power + 1) * curve[row, power, places]
            return total

        slips, gaps = slice(0, 2 * n), slice(2 * n, 3 * n)
        what = np.full(len(row), EventKind.CURVES, dtype=np.int64), np.full(len(row), -1, dtype=np.int64)
        nothing = np.broadcast_to(0.0, (len(row), *self.curve.shape[1:]))  # a broadcast view takes no memory
        return CurvedHistory(
            self.cycle[row] + share * self.duration[row],
            *what,
            along(self.v, self.curve, slips),
            along(self.w, self.curve, gaps),
            along(self.q, self.reaction_curve, slips),
            along(self.p, self.reaction_curve, gaps),
            self._between(self.q_w, row, share),
            self._between(self.p_w, row, share),
            self.state[row],
            np.zeros(len(row)),
            nothing,
            nothing,
        )

    def refined(self) -> "CurvedHistory":
        """The path with enough rows within every step for linear interpolation."""
        return self._refined

    @cached_property
    def _refined(self) -> "CurvedHistory":
        count = np.where(self.duration > 0, len(WITHIN), 1)
        row, first = np.repeat(np.arange(len(self)), count), np.cumsum(count) - count
        share = np.array(WITHIN)[np.arange(len(row)) - first[row]]
        return self.within(row, share)

    @property
    def _lasting(self) -> FloatArray:
        return self.duration


def path_violation(
    problem: Problem, load_factor: float, tolerances: Tolerances, history: EventHistory
) -> float:
    """Largest relative violation of the law, re-computed from slips and gaps.

    In the plane slip counts from row to row; of a curved path see :func:`curved_violations`.
    """
    if isinstance(history, CurvedHistory):
        return float(curved_violations(problem, load_factor, history, np.array([len(history)]))[0])
    scale = scales(problem, load_factor)
    near = tolerances.periodicity * scale.length
    open_at_all = (history.w[1:] > near) | (history.w[:-1] > near)
    at_rest = open_at_all | (history.kind[1:] == EventKind.JUMPS)[:, None]
    slip = np.where(at_rest, 0.0, np.diff(history.v, axis=0))
    q, p = reactions(problem, history.q_w, history.p_w, history.v, history.w)
    return float(law_violation(problem.f, q[1:], p[1:], history.w[1:], slip, scale).max(initial=0.0))


def curved_violations(
    problem: Problem, load_factor: float, history: CurvedHistory, rows: NDArray[np.intp]
) -> FloatArray:
    """Largest relative violation of the law along curved paths, re-computed from slips and gaps.

    They stand one after the other in one history, each of so many rows, (k,). At the beginning of every step
    the whole law, the slip being that of the step at the rate there; that the step ends where the next
    begins; at its end and within it that limits are kept, gaps and pressures not negative. Within a step a
    polynomial stands for the path, so that this is some multiple of the accuracy asked for
    (:func:`law_resolution`).
    """
    found, path = np.zeros(len(rows)), np.repeat(np.arange(len(rows)), rows)
    steps = np.flatnonzero((history.duration > 0) & np.append(path[1:] == path[:-1], False))
    if not len(steps):
        return found
    scale = scales(problem, load_factor)

    def at(share: float, slip: FloatArray) -> FloatArray:
        there = history.within(steps, np.full(len(steps), share))
        q, p = reactions(problem, there.q_w, there.p_w, there.v, there.w)
        return np.asarray(law_violation(problem.f, q, p, there.w, slip, scale).max(axis=1))

    opened = np.repeat(history.state[steps] == OPEN, 2, axis=1)
    first = np.where(opened, 0.0, history.curve[steps][:, 0, problem.layout.slips])
    still = np.zeros_like(first)
    broken = [at(0.0, first), *(at(share, still) for share in (*WITHIN[1:], 1.0))]
    end, after = history.within(steps, np.ones(len(steps))), history.rows(steps + 1)
    smooth = (after.kind != EventKind.JUMPS)[:, None]
    gaps = (smooth * np.abs(part) for part in (end.v - after.v, end.w - after.w))
    broken += [part.max(axis=1) / scale.length for part in gaps]
    np.maximum.at(found, path[steps], np.max(broken, axis=0))
    return found
