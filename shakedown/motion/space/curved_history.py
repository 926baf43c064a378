"""The path of a motion in two tangential directions: events, and smooth curves between them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import NEGLIGIBLE
from shakedown.motion.event_history import EventHistory, EventKind
from shakedown.motion.space.moving_state import DEGREE

WITHIN = (0.0, 0.25, 0.5, 0.75)  # shares of a step at which its curve is checked


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

        after = np.minimum(row + 1, len(self) - 1)

        def between(values: FloatArray) -> FloatArray:
            return np.asarray(values[row] + share[:, None] * (values[after] - values[row]))

        slips, gaps = slice(0, 2 * n), slice(2 * n, 3 * n)
        nothing = np.broadcast_to(0.0, (len(row), *self.curve.shape[1:]))  # a broadcast view takes no memory
        return CurvedHistory(
            cycle=self.cycle[row] + share * self.duration[row],
            kind=np.full(len(row), EventKind.CURVES, dtype=np.int64),
            node=np.full(len(row), -1, dtype=np.int64),
            v=along(self.v, self.curve, slips),
            w=along(self.w, self.curve, gaps),
            q=along(self.q, self.reaction_curve, slips),
            p=along(self.p, self.reaction_curve, gaps),
            q_w=between(self.q_w),
            p_w=between(self.p_w),
            state=self.state[row],
            duration=np.zeros(len(row)),
            curve=nothing,
            reaction_curve=nothing,
        )

    def refined(self) -> "CurvedHistory":
        """The path with enough rows within every step for linear interpolation."""
        return self._refined

    @cached_property
    def _refined(self) -> "CurvedHistory":
        lasts = self.duration > 0
        row = np.repeat(np.arange(len(self)), np.where(lasts, len(WITHIN), 1))
        first = np.cumsum(np.where(lasts, len(WITHIN), 1)) - np.where(lasts, len(WITHIN), 1)
        share = np.array(WITHIN)[np.arange(len(row)) - first[row]]
        return self.within(row, share)

    def at(self, cycle: FloatArray) -> "CurvedHistory":
        """The states at given times in cycles, on the curves between rows.

        Raises
        ------
        UsageError
            If a time lies before the first row or after the last.

        Examples
        --------
        >>> import shakedown
        >>> from shakedown.motion.evolve import evolve
        >>> evolve(shakedown.example("four-node-3d"), 1.4, cycles=1).history.at([0.5]).v.shape
        (1, 8)
        """
        cycle = np.asarray(cycle, dtype=float)
        first, last = self.cycle[[0, -1]]
        outside = cycle[~((cycle >= first - NEGLIGIBLE) & (cycle <= last + NEGLIGIBLE))]
        if outside.size:
            raise UsageError(f"cycle: expected times from {first:g} to {last:g}, found {outside[0]:g}")
        row = np.clip(np.searchsorted(self.cycle, cycle, side="right") - 1, 0, len(self) - 1)
        span = self.duration[row]
        share = np.where(span > 0, (cycle - self.cycle[row]) / np.where(span > 0, span, 1.0), 0.0)
        return self.within(row, np.clip(share, 0.0, 1.0))
