"""Descent from a cycle to the smallest load factor that its kind reaches."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.campaign.recorded_steps import RecordedSteps
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import FOUR_DIGITS, ITERATIONS
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.many_states import long_term_states
from shakedown.long_term.state import LongTermState
from shakedown.motion.checked_law import admissible, path_accuracy, scales
from shakedown.studies.cycle_pattern import cycle_pattern, first_load_slip
from shakedown.studies.samplers import BLOCK

SLIPPING = (Outcome.CYCLIC_SLIP, Outcome.RATCHETTING)
ROUNDED = 16  # units in the last place allowed as error of the data
SHARES = (1e-4, 1e-2, 0.1, 0.5)  # shares of the way back from the end of a pattern at which it is simulated
BELOW = (1e-6, 1e-4, 1e-2)  # how far below the end of a pattern another one is sought

T = TypeVar("T")


class FoundCycle(NamedTuple):
    """A cycle at a load factor, from a slip at the first load step.

    Attributes
    ----------
    load_factor
        λ.
    slip : (n,)
        Slip at the first load step [length].
    state
        What the joint settles into from there.
    """

    load_factor: float
    slip: FloatArray
    state: LongTermState


class FoundSeparation(NamedTuple):
    """A load factor at which contact opens and closes in every period, or is lost, from a slip in contact.

    Attributes
    ----------
    load_factor
        λ.
    slip : (n,)
        Admissible slip at the first load step [length].
    """

    load_factor: float
    slip: FloatArray


Found = TypeVar("Found", FoundCycle, FoundSeparation)


class Ends(NamedTuple):
    """The results for many slips: outcome, dissipation per cycle and signature, (s,) each."""

    outcome: NDArray[np.str_]
    dissipation: FloatArray
    signature: NDArray[np.uint64]


@dataclass
class Simulator:
    """Long-term states of one joint, counted, and recorded as they are found.

    Attributes
    ----------
    problem
        The joint, without transient load steps.
    tolerances
        What decides.
    steps
        Where what is found is recorded.
    tries
        How many states have been simulated.
    undecided
        How many of them came to no verdict.
    """

    problem: Problem
    tolerances: Tolerances
    steps: RecordedSteps
    tries: int = 0
    undecided: int = 0

    def done(self, step: Callable[[], T]) -> T:
        """The result of a step of the search, recorded together with the counters."""
        found = self.steps.done(lambda: (step(), self.tries, self.undecided))
        result, self.tries, self.undecided = found
        return result

    def state(self, load_factor: float, slip: FloatArray) -> LongTermState:
        """The long-term state from a slip."""
        state = self.steps.done(
            lambda: long_term_state(self.problem, load_factor, slip, tolerances=self.tolerances)
        )
        self.count([state.outcome])
        return state

    def ends(self, load_factor: float, slips: FloatArray) -> Ends:
        """The results for many slips (s, n), in batches."""
        batches = [slips[first : first + BLOCK] for first in range(0, len(slips), BLOCK)]
        found = [self.steps.done(partial(self._batch, load_factor, batch)) for batch in batches]
        ends = Ends(*map(np.concatenate, zip(*found, strict=True)))
        self.count(ends.outcome)
        return ends

    def _batch(self, load_factor: float, slips: FloatArray) -> Ends:
        found = long_term_states(self.problem, load_factor, slips, tolerances=self.tolerances)
        return Ends(found.outcome, found.dissipation, found.signature)

    def count(self, outcomes: ArrayLike) -> None:
        """Count simulations by their outcome."""
        self.tries += len(np.asarray(outcomes))
        self.undecided += int(np.count_nonzero(np.asarray(outcomes) == Outcome.UNDECIDED))

    def separation(self, load_factor: float, slip: FloatArray) -> FoundSeparation | None:
        """The separation that an admissible slip leads to; None where it leads to none."""
        if not admissible(self.problem, load_factor, slip[None], self.tolerances)[0]:
            return None
        apart = self.state(load_factor, slip).outcome == Outcome.SEPARATION
        return FoundSeparation(load_factor, slip) if apart else None

    def least_dissipation(self, load_factor: float) -> float:
        """The least dissipation per cycle that exceeds the round-off of the data [force × length].

        The accuracy of the stiffness, that of floats or the one that the problem states, with two
        directions at least that of the path, times the force
        and the length that the loads bring.
        """
        scale = scales(self.problem, load_factor)
        path = path_accuracy(self.problem, self.tolerances)
        accuracy = max(self.problem.stiffness_accuracy or 0.0, path, float(np.finfo(float).eps))
        return ROUNDED * accuracy * scale.force * scale.length

    def resolved(self, state: LongTermState) -> bool:
        """Whether a cycle dissipates more than round-off; slip of frictionless nodes alone never does."""
        slipping = state.slip_per_cycle > 0
        if not self.problem.f[slipping].any():
            return True
        return state.dissipation_per_cycle > self.least_dissipation(state.load_factor)

    def cycle(self, load_factor: float, slip: FloatArray) -> FoundCycle | None:
        """The cycle from a slip, restarted at its own state; None where the data resolve none."""
        return self.done(lambda: self._cycle(load_factor, slip))

    def _cycle(self, load_factor: float, slip: FloatArray) -> FoundCycle | None:
        for _ in range(2):  # the second run starts on the cycle
            state = self.state(load_factor, slip)
            if state.outcome not in SLIPPING or not self.resolved(state):
                return None
            slip = first_load_slip(self.problem, state.history)
        return FoundCycle(load_factor, state.initial_slip, state)


def descended(simulator: Simulator, cycle: FoundCycle, accuracy: float, nothing: float) -> FoundCycle:
    """The cycle with the smallest load factor that is reached from another one, pattern by pattern.

    The smallest load factor with the pattern of a cycle follows from one linear program
    (:class:`CyclePattern`). A little above it the pattern is simulated; a little below it
    another one may go on. What has no such pattern (nodes open, jump or ratchet) is lowered
    by bisection from its own state. So is every cycle in space, to four digits.

    Parameters
    ----------
    simulator
        The joint.
    cycle
        Where to begin.
    accuracy
        To which the end of a pattern is approached, relative to λ.
    nothing
        A load factor that counts as zero: there the descent ends.
    """
    if simulator.problem.directions > 1:
        return lowered(simulator.cycle, cycle, FOUR_DIGITS, nothing)
    for _ in range(ITERATIONS):
        lower = next(_lower_cycles(simulator, cycle, accuracy), None)
        if lower is None:
            return cycle
        cycle = lower
        if cycle.load_factor <= nothing:
            return cycle
    return cycle


def lowered(
    again: Callable[[float, FloatArray], Found | None], found: Found, finest: float, nothing: float
) -> Found:
    """What is found again at a smaller load factor from its own slip, half as far down each time it dies."""
    step = 0.5
    while step > finest and found.load_factor > nothing:
        below = again((1.0 - step) * found.load_factor, found.slip)
        if below is None:
            step *= 0.5
        else:
            found = below
    return found


def _lower_cycles(simulator: Simulator, cycle: FoundCycle, accuracy: float) -> Iterator[FoundCycle]:
    """Cycles at smaller load factors, the best guess first."""
    pattern = cycle_pattern(simulator.problem, cycle.state)
    least = None if pattern is None else pattern.least(simulator.tolerances)
    if least is None:
        yield from _continued(simulator, cycle, accuracy)
        return
    gap = cycle.load_factor - least.load_factor
    for share in BELOW:
        target = (1.0 - share) * least.load_factor
        if 0.0 < target < cycle.load_factor:
            found = simulator.cycle(target, least.slip)
            if found is not None:
                yield found
    for share in SHARES:
        if gap * (1.0 - share) > accuracy * cycle.load_factor:
            found = simulator.cycle(
                least.load_factor + share * gap, least.slip + share * (cycle.slip - least.slip)
            )
            if found is not None:
                yield found


def _continued(simulator: Simulator, cycle: FoundCycle, accuracy: float) -> Iterator[FoundCycle]:
    """The cycle at a smaller load factor, from its own slip: half as far down each time it dies."""
    step = 0.5
    while step > accuracy:
        found = simulator.cycle((1.0 - step) * cycle.load_factor, cycle.slip)
        if found is not None:
            yield found
        step *= 0.5
