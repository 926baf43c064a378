"""The box into which every motion is drawn in the long run, shrunk by linear programs."""

from dataclasses import dataclass
from math import inf

import numpy as np
from numpy.typing import NDArray

from shakedown.model.problem import FloatArray
from shakedown.programs.linear_program import INF
from shakedown.tolerances import Tolerances
from shakedown.universal.admissible_states import AdmissibleStates, Confinement, StateProgram


@dataclass(frozen=True)
class LimitBox:
    """What every motion with all nodes closed comes to, for every load factor of an interval.

    Attributes
    ----------
    within
        The interval and the box.
    standing : (n,)
        Nodes that in the end cannot slip in one of the two directions, and so come to rest.
    forward : (n,)
        The largest slip at which a node can slip forward [length]; −inf where it cannot.
    backward : (n,)
        The smallest slip at which it can slip backward [length]; inf where it cannot.
    """

    within: Confinement
    standing: NDArray[np.bool_]
    forward: FloatArray
    backward: FloatArray

    def closes(self, margin: float) -> bool:
        """Whether all slip ceases: each node slips forward only below where it slips backward."""
        moving = ~self.standing
        forward, backward = self.forward[moving], self.backward[moving]
        return bool(np.all(backward - forward > margin * np.maximum(np.abs(forward), np.abs(backward))))

    @property
    def bounded(self) -> bool:
        """Whether every side of the box has been found."""
        return bool(np.all(np.isfinite(self.within.lower)) and np.all(np.isfinite(self.within.upper)))


def no_box(n: int, low: float, high: float) -> LimitBox:
    """Nothing known yet."""
    within = Confinement(low, high, np.full(n, -INF), np.full(n, INF))
    return LimitBox(within, np.zeros(n, dtype=bool), np.full(n, inf), np.full(n, -inf))


class BoxShrinker:
    """Rounds that shrink a box, every side by at most two linear programs per round.

    In the long run v_i comes down to its lowest value by slipping backward there, or it ceases
    to slip backward and comes to rest where every load step of the loop admits it.
    """

    def __init__(self, states: AdmissibleStates, tolerances: Tolerances) -> None:
        self.states, self._tolerances = states, tolerances
        self.anywhere = StateProgram(states)
        self._at_step = StateProgram(states)

    def shrink(self, box: LimitBox, rounds: int) -> LimitBox:
        """Shrink a box so many times, or until its sides move little."""
        for _ in range(rounds):
            before, box = box, self._round(box)
            sizes = [b.within.upper - b.within.lower for b in (before, box)]
            if before.bounded and np.all(sizes[1] > (1 - self._tolerances.box_gain) * sizes[0]):
                break
        return box

    def _round(self, box: LimitBox) -> LimitBox:
        n, (low, high) = self.states.n, box.within[:2]
        lower, upper = box.within.lower.copy(), box.within.upper.copy()
        forward, backward = np.empty(n), np.empty(n)
        for program in (self.anywhere, self._at_step):
            program.confine(box.within)
        for i in range(n):
            direction = np.zeros(n)
            direction[i] = 1.0
            self.anywhere.activate(2 * i)
            backward[i] = self.anywhere.least(direction).value
            if backward[i] > lower[i]:
                rest = self._rest(2 * i + 1, direction)
                lower[i] = max(lower[i], self._outward(min(backward[i], rest), -1.0, upper[i]))
            self.anywhere.activate(2 * i + 1)
            forward[i] = -self.anywhere.least(-direction).value
            if forward[i] < upper[i]:
                rest = -self._rest(2 * i, -direction)
                upper[i] = min(upper[i], self._outward(max(forward[i], rest), 1.0, lower[i]))
            if lower[i] > upper[i]:  # one place to rest, missed by round-off
                lower[i], upper[i] = box.within.lower[i], box.within.upper[i]
            for program in (self.anywhere, self._at_step):
                program.set_side(i, lower[i], upper[i])
        standing = box.standing | (backward == inf) | (forward == -inf)
        return LimitBox(Confinement(low, high, lower, upper), standing, forward, backward)

    def _rest(self, row: int, direction: FloatArray) -> float:
        """Least direction · v at the load step in which a row is extreme; −inf where there is no state."""
        self._at_step.hold_load(int(self.states.extreme[row]))
        value = self._at_step.least(direction).value
        return value if value < inf else -inf

    def _outward(self, value: float, sign: float, opposite: float) -> float:
        """A side of the box, moved by what round-off may have taken from it."""
        size = max(abs(value), abs(opposite)) if np.isfinite(opposite) else abs(value)
        return value + sign * self._tolerances.feasibility * size
