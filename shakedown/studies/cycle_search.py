"""Rounds of a search for cycles: initial slips are drawn and simulated, and cycles are followed down."""

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.assessment.every_limit import JointLimits
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import THREE_DIGITS
from shakedown.ground.size_limits import CONE
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import constraints, step_loads
from shakedown.joint.loading import first_load
from shakedown.joint.problem import Problem
from shakedown.motion.checked_law import admissible
from shakedown.programs.cone_rays import way_to_limits
from shakedown.programs.program import Program
from shakedown.programs.simplex import Simplex
from shakedown.studies.descent import (
    SLIPPING,
    FoundCycle,
    FoundSeparation,
    Simulator,
    descended,
    lowered,
)

FOLLOWED = 3  # different cycles per round that are followed down
NEAR = 0.25  # share of a round's states drawn near the best cycle
CORNER = 0.3  # exponent of the mixture: below 1, so that most states lie near a face
OUTSIDE = (0.3, 1.0, 5.0, 30.0)  # reaches of states drawn without regard to the limits
DIRECTIONS = 2  # random directions beside the 2n of the nodes, for each node


class AttackingStates:
    """Draws initial slips of a joint at a load factor.

    At the first load step every motion with all nodes closed is in the polytope of the slips
    that are admissible there. Its extreme points, in the directions of the nodes and in random
    ones, come from linear programs; between them any state may be drawn. Where it is unbounded,
    slips of all sizes are drawn about the given ones. With two tangential directions it is an
    intersection of cones, and its points farthest from one inside take the place of the extreme ones.
    """

    def __init__(
        self, problem: Problem, known: FloatArray, generator: np.random.Generator, tolerances: Tolerances
    ) -> None:
        self.problem, self.known, self.generator, self.tolerances = problem, known, generator, tolerances

    def drawn(self, load_factor: float, count: int) -> FloatArray:
        """Slips at a load factor, (count, n): the known ones, extreme ones, and mixtures of them."""
        corners = self._corners(load_factor, count)
        first = np.vstack([self.known, corners])[:count]
        more = count - len(first)
        if more <= 0:
            return first
        if len(corners) > self.problem.layout.slip_size:
            weights = self.generator.dirichlet(np.full(len(corners), CORNER), more)
            return np.vstack([first, weights @ corners])
        return np.vstack([first, self._anywhere(load_factor, more)])

    def near(self, slip: FloatArray, load_factor: float, count: int) -> FloatArray:
        """Slips around one, (count, n), at distances of all magnitudes."""
        reach = self._size(load_factor) * 10.0 ** self.generator.uniform(-4.0, 0.0, (count, 1))
        return slip + reach * self.generator.normal(size=(count, len(slip)))

    def _anywhere(self, load_factor: float, count: int) -> FloatArray:
        reach = self._size(load_factor) * self.generator.choice(OUTSIDE, (count, 1))
        about = self.known[self.generator.integers(len(self.known), size=count)]
        return about + reach * self.generator.normal(size=about.shape)

    def _size(self, load_factor: float) -> float:
        """A length scale: loads over stiffness."""
        rows = constraints(self.problem)
        size = np.abs(rows.g).max() + load_factor * np.abs(rows.d).max()
        return float(size / np.diag(self.problem.A).mean())

    def _corners(self, load_factor: float, most: int) -> FloatArray:
        """Extreme points of the slips admissible under the first load, those that exist, at most so many."""
        if self.problem.directions > 1:
            return self._farthest(load_factor, most)
        rows, n = constraints(self.problem), self.problem.n
        limits = rows.g - load_factor * step_loads(self.problem)[0]
        program = Simplex(Program(rows.coefficients, limits, cost=np.ones(n), tolerances=self.tolerances))
        directions = np.vstack([np.eye(n), -np.eye(n), self.generator.normal(size=(DIRECTIONS * n, n))])
        found = []
        for direction in self.generator.permutation(directions)[:most]:
            program.set_cost(direction)
            end = program.solve()
            if end.optimal:
                found.append(end.x)
        return np.array(found).reshape(-1, n)

    def _farthest(self, load_factor: float, most: int) -> FloatArray:
        """The farthest slips that the first load admits, in directions from an admissible one, if any."""
        problem = self.problem
        q_w, p_w = problem.layout.split(first_load(problem, load_factor))
        at_ease = np.linalg.lstsq(problem.A, -q_w, rcond=None)[0]  # no tangential reaction
        starts = np.vstack([at_ease, self.known])
        inside = starts[admissible(problem, load_factor, starts, self.tolerances)]
        if not len(inside):
            return np.empty((0, len(q_w)))
        size = len(q_w)
        directions = np.vstack(
            [np.eye(size), -np.eye(size), self.generator.normal(size=(DIRECTIONS * size, size))]
        )
        directions = self._size(load_factor) * self.generator.permutation(directions)[:most]
        law, discs = problem.law, slice(CONE * problem.n)
        G, right = law.stiffness(problem.A, problem.B)[discs], law.cone(q_w, p_w)[discs]
        way = way_to_limits(G, right, inside[0], directions)
        within = np.minimum(way, OUTSIDE[-1])  # where no disc limits a direction
        return np.asarray(inside[0] + within[:, None] * directions)


@dataclass
class CycleSearch:
    """The smallest cycle so far, and the search for smaller ones."""

    simulator: Simulator
    attack: AttackingStates
    accuracy: float
    nothing: float
    best: FoundCycle | None = None
    apart: FoundSeparation | None = None

    def try_witness(self, limits: JointLimits) -> None:
        """Simulate the critical slip state slightly above the first collapse, where it cycles as a rule."""
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
        """Simulate a round of states at a load factor, and follow down the cycles found."""
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
