"""Where a motion began, so that it can be followed again, in whole or in part."""

from dataclasses import dataclass

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.motion.cycle_record import State
from shakedown.motion.integrator import Evolution
from shakedown.motion.reduced_scene import Scene


@dataclass(frozen=True)
class Passage:
    """A joint, its loading and where its motion began.

    Attributes
    ----------
    problem, load_factor, tolerances
        What was followed; the problem is that of the scene where there is one.
    start : (n,)
        Slip at the very start [length].
    open_nodes
        The nodes that were open there.
    scene
        What was left out.
    """

    problem: Problem
    load_factor: float
    tolerances: Tolerances
    start: FloatArray
    open_nodes: tuple[int, ...]
    scene: Scene | None = None

    def motion(self) -> Evolution:
        """The motion at its very start."""
        return Evolution(
            self.problem, self.load_factor, self.start, self.tolerances, open_nodes=self.open_nodes
        )

    def motion_from(self, state: State, done: int) -> Evolution:
        """The motion in a state after so many cycles."""
        evolution = self.motion()
        evolution.state = state
        evolution.enter_cycle(done)
        return evolution
