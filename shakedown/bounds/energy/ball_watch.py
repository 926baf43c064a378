"""Whether the states that a motion passes through are in an energy ball: asked after every cycle."""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from shakedown.bounds.energy.energy_ball import EnergyBall, energy_ball
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import real_array
from shakedown.joint.problem import Problem


class BallWatch:
    """Looks for a ball at one load factor that holds a slip state; remembers what it has found.

    A state inside a ball that is known costs one product. Else the ball that holds it best is sought
    (:func:`energy_ball` with ``around``), unless a state next to it was so far from all balls that this one
    is in none either: the margin R − ‖v − v*‖ of the best ball changes by no more than the state does.
    That only saves time: where ``proves`` says True a ball holds the state.

    The transient load steps are over. Of open nodes a ball is for states with exactly these open.

    Attributes
    ----------
    problem, load_factor
        The joint, and the load factor of the motion.
    open_nodes, split, tolerances
        As :func:`energy_ball` takes them.
    ball
        The ball that held a state last; None before.

    Examples
    --------
    >>> import shakedown
    >>> watch = BallWatch(shakedown.example("two-node-3d"), 0.5)
    >>> watch.proves(np.zeros(4)), watch.proves(np.full(4, 1e-3)), watch.proves(np.full(4, 40.0))
    (True, True, False)
    >>> watch.margin(np.zeros(4)) > 0
    True
    """

    def __init__(
        self,
        problem: Problem,
        load_factor: float,
        open_nodes: Iterable[int] = (),
        split: bool = True,
        tolerances: Tolerances = DEFAULT,
    ) -> None:
        self.problem, self.load_factor = problem, load_factor
        self.open_nodes, self.split, self.tolerances = tuple(open_nodes), split, tolerances
        self.ball: EnergyBall | None = None
        self._far: list[tuple[FloatArray, EnergyBall]] = []

    def proves(self, slip: ArrayLike) -> bool:
        """Whether a ball holds a slip state, by more than round-off: then the motion shakes down.

        With a slip (dn,) of the whole joint [length], closed and admissible; raises as
        :func:`energy_ball`, but where a solver finds no end no ball is found.
        """
        state = real_array("slip", slip)
        if self.ball is not None and bool(self.ball.contains(state)):
            return True
        if any(self._apart(state, other, ball) < ball.shortfall for other, ball in self._far):
            return False
        found = sought(
            energy_ball,
            self.problem,
            self.load_factor,
            around=state,
            transient=False,
            open_nodes=self.open_nodes,
            split=self.split,
            tolerances=self.tolerances,
        )
        if isinstance(found, Missing):
            return False
        if found.status != Status.INFEASIBLE and bool(found.contains(state)):
            self.ball = found
            return True
        if found.shortfall > 0:
            self._far = [(state, found)]
        return False

    def margin(self, slip: ArrayLike) -> float:
        """How far a slip state may be off and stay in the ball last found [√(force · length)]; −inf: none."""
        return -np.inf if self.ball is None else float(self.ball.margin(slip))

    def _apart(self, state: FloatArray, other: FloatArray, ball: EnergyBall) -> float:
        zone = self.problem.layout.slips_of(
            [i for i in range(self.problem.n) if i not in set(self.open_nodes)]
        )
        return float(ball.metric.norm((state - other)[zone]))
