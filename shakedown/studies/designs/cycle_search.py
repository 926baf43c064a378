"""Rounds of a search for cycles: initial slips are simulated, and what cycles is followed down."""

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.assessment.every_limit import JointLimits
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import THREE_DIGITS
from shakedown.ground.status import Outcome
from shakedown.motion.contact_law import admissible
from shakedown.studies.designs.attacking_states import AttackingStates
from shakedown.studies.designs.descent import (
    SLIPPING,
    FoundCycle,
    FoundSeparation,
    Simulator,
    descended,
    lowered,
)

FOLLOWED = 3  # different cycles of a round that are followed down
NEAR = 0.25  # share of a round's states about the best cycle


@dataclass
class CycleSearch:
    """The smallest cycle so far, and how others are sought."""

    simulator: Simulator
    attack: AttackingStates
    accuracy: float
    nothing: float
    best: FoundCycle | None = None
    apart: FoundSeparation | None = None

    def try_witness(self, limits: JointLimits) -> None:
        """Simulate the witness of the first collapse a little above it: there it no longer comes to rest."""
        lower = limits.lower
        if not lower or not (isfinite(lower.load_factor) and np.isfinite(lower.slip).all()):
            return
        load_factor = max((1.0 + self.accuracy) * lower.load_factor, self.nothing)
        self.apart = self.simulator.separation(load_factor, lower.slip) or self.apart

    def lower_separation(self) -> None:
        """Follow the smallest separation down from its own slip."""
        if self.apart is not None:
            self.apart = lowered(self.simulator.separation, self.apart, THREE_DIGITS, self.nothing)

    def look_at(self, load_factor: float, count: int) -> None:
        """Simulate a round of states at a load factor, and follow down what cycles."""
        if self.best is not None and self.best.load_factor <= self.nothing:
            return
        starts, state = self.simulator.steps.done(lambda: self._drawn(load_factor, count))
        self.attack.generator.bit_generator.state = state
        ends = self.simulator.ends(load_factor, starts)
        self._note_separation(load_factor, starts, ends.outcome == Outcome.SEPARATION)
        cycling = np.flatnonzero(np.isin(ends.outcome, SLIPPING))
        strongest = cycling[np.argsort(-ends.dissipation[cycling], kind="stable")]
        _, first = np.unique(ends.signature[strongest], return_index=True)
        for k in strongest[np.sort(first)][:FOLLOWED]:
            cycle = self.simulator.cycle(load_factor, starts[k])
            if cycle is not None:
                self._take(self._descended(cycle))

    def _drawn(self, load_factor: float, count: int) -> tuple[FloatArray, Any]:
        """The initial slips of a round, and the state of the random numbers after them."""
        near = 0 if self.best is None else int(NEAR * count)
        starts = self.attack.drawn(load_factor, count - near)
        if self.best is not None:
            starts = np.vstack([starts, self.attack.near(self.best.slip, load_factor, near)])
        return starts, self.attack.generator.bit_generator.state

    def _descended(self, cycle: FoundCycle) -> FoundCycle:
        simulator = self.simulator
        return simulator.done(lambda: descended(simulator, cycle, self.accuracy, self.nothing))

    def _note_separation(self, load_factor: float, starts: FloatArray, separated: NDArray[np.bool_]) -> None:
        """Keep the smallest load factor at which an admissible state separates."""
        if self.apart is not None and self.apart.load_factor <= load_factor:
            return
        joint, tolerances = self.simulator.problem, self.simulator.tolerances
        places = np.flatnonzero(separated & admissible(joint, load_factor, starts, tolerances))
        if places.size:
            self.apart = FoundSeparation(load_factor, starts[places[0]])

    def _take(self, cycle: FoundCycle) -> None:
        if self.best is None or cycle.load_factor < self.best.load_factor:
            self.best = cycle
