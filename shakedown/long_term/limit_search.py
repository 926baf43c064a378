"""The search for the long-term state: compiled loops, and the cases that they hand back to Python."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import DISTINCT, RESOLVED
from shakedown.ground.size_limits import BATCH
from shakedown.ground.status import Outcome
from shakedown.joint.layout import Layout
from shakedown.joint.rigid_slips import can_drift
from shakedown.long_term.cycle_map import limit
from shakedown.long_term.plane.path_check import Scale, path_check
from shakedown.long_term.plane.period_map import period_map
from shakedown.long_term.plane.phase_loop import (
    ANEW,
    FROM_HERE,
    JUMP,
    LEAVES,
    RATES,
    STOPPED,
    search_state,
    settle,
    tell,
)
from shakedown.long_term.plane.search import (
    LIMIT_WANTED,
    SINGULAR,
    Answers,
    SearchState,
    SettlingRules,
    search,
)
from shakedown.motion.checked_law import alone, swing
from shakedown.motion.course import DONE, EFFORT, NO_RATES, PAUSED
from shakedown.motion.evolution import Evolution
from shakedown.motion.plane.event_loop import address_of_loop
from shakedown.motion.plane.plane_events import ROUNDING, PlaneEvents

LONGEST_PERIOD = 8  # cycles
OUTCOMES = (  # by the verdicts of compiled code
    Outcome.UNDECIDED, Outcome.UNDECIDED, Outcome.UNDECIDED, Outcome.UNDECIDED, Outcome.SEPARATION,
    Outcome.SHAKEDOWN, Outcome.CYCLIC_SLIP, Outcome.RATCHETTING, Outcome.SEPARATION,
)  # fmt: skip


def empty_answers(s: int, layout: Layout) -> Answers:
    """Arrays for the answers for s initial states, still undecided."""
    slips = np.full((s, layout.slip_size), np.nan), np.full((s, layout.n), np.nan)
    works, numbers = np.full((2, s), np.nan), np.zeros((3, s), np.int64)
    return Answers._make([*slips, *works, *numbers, np.zeros(s, dtype=np.uint64)])


class LimitSearch:
    """Successive searches for long-term states with the moving state of one evolution.

    Compiled code follows cycle after cycle and comes back where it finds no rates, no limit or no
    way on. The evolution then finds rates, jumps, or says why it stops, and the search goes on.

    Parameters
    ----------
    evolution
        At its start.
    most_cycles, longest_period
        As for :func:`long_term_state`.
    """

    def __init__(self, evolution: Evolution, most_cycles: int, longest_period: int) -> None:
        self.evolution, problem = evolution, evolution.problem
        scale, t = evolution.scale, evolution.tolerances
        rules = SettlingRules(
            most_cycles=most_cycles,
            longest_period=longest_period,
            capacity=min(most_cycles + longest_period, BATCH),  # states between two cycles
            least_force=scale.force,
            limit=t.limit,
            rounding=ROUNDING,
            friction_law=t.friction_law,
            stiffness=float(np.abs(evolution.kappa).max()),
        )
        events = self._events
        runs = events.run_of(True, False), events.run_of(False, False), events.run_of(False, True)
        check = path_check(problem.f, Scale(scale.force, scale.length, t.periodicity * scale.length))
        self.compiled = search(runs, period_map(problem.n), check, rules)
        self._weigh()

    @property
    def _events(self) -> PlaneEvents:
        assert isinstance(self.evolution.method, PlaneEvents)
        return self.evolution.method

    @property
    def search_state(self) -> SearchState:
        """The progress of the present search."""
        return search_state(self.compiled)

    def begin(self, load_factor: float, initial_slip: ArrayLike | None, open_nodes: tuple[int, ...]) -> None:
        """Go to the start at a load factor."""
        self.evolution.begin(load_factor, initial_slip, open_nodes)
        self._weigh()

    def _weigh(self) -> None:
        """Set the scales of the joint at its load factor and from its start."""
        evolution, scale = self.evolution, self.evolution.scale
        share, lost = evolution.tolerances.periodicity, self._events.precision.force
        near, moving = share * scale.length, swing(evolution.problem, evolution.load)
        self._near = near
        self.compiled.set(least_force=scale.force, blurred=0.0 < moving < RESOLVED * lost)
        self.compiled.check.set(force=scale.force, length=scale.length, near=near)
        self.compiled.weight[:] = near / alone(evolution.problem, max(share * moving, DISTINCT * lost))

    def from_here(self, answers: Answers) -> None:
        """Answer for the present state of the evolution, at its start."""
        tell(self.compiled, FROM_HERE, 0.0, 0.0)
        if not self.evolution.held:
            self._give_up()
        self._settle(answers.final_slip, answers, lambda: False)

    def from_slips(self, starts: FloatArray, answers: Answers, stopped: Callable[[], bool]) -> None:
        """Answer for initial slips (s, n), one after the other, until ``stopped()`` is true."""
        tell(self.compiled, ANEW, 0.0, 0.0)
        self._settle(starts, answers, stopped)

    def _settle(self, starts: FloatArray, answers: Answers, stopped: Callable[[], bool]) -> None:
        status, follow = PAUSED, address_of_loop()
        while status != DONE and not stopped():
            status = settle(self.compiled, starts, answers, EFFORT, follow)
            if status == LIMIT_WANTED:
                self._give_limit()
            elif status == SINGULAR:
                self._give_up()
            elif status not in (DONE, PAUSED):
                self._give_way(status)

    def _give_limit(self) -> None:
        """The limit of an affine map that drifts, or nearly so."""
        affine, k = self.compiled.map, self.search_state.nodes
        end = limit(affine.power.ravel()[: k * k].reshape(k, k), affine.change[:k])
        decaying, drift = end.decaying, end.drift
        if not can_drift(self.evolution.problem):  # otherwise what does not decay is merely too slow to tell
            of_nodes = self.compiled.weight[affine.stuck[affine.moves[:k]]]
            decaying = decaying and bool(np.all(of_nodes * np.abs(drift) <= self._near))
            drift = np.zeros_like(drift)
        affine.limit[:k], affine.drift[:k] = end.change, drift
        tell(self.compiled, LIMIT_WANTED, float(decaying), end.contraction)

    def _give_up(self) -> None:
        """Give up a state whose moving nodes are held by nothing."""
        at = self.search_state
        self.evolution.enter_cycle(at.cycles)
        self.evolution.say_not_held()
        tell(self.compiled, STOPPED, 0.0, 0.0)

    def _give_way(self, status: int) -> None:
        """Supply rates, or a state to jump to, where the loop found none; else why the motion stops."""
        evolution, at = self.evolution, self.search_state
        if not at.jumped:
            evolution.enter_cycle(at.cycles)
        if status == NO_RATES and self._events.finds_rates():
            tell(self.compiled, RATES, 0.0, 0.0)
        elif status == NO_RATES and evolution.jump():
            jump = evolution.jumps[-1]
            tell(self.compiled, JUMP, jump.friction_work, jump.damping_work)
        else:
            evolution.say_why(status)
            tell(self.compiled, LEAVES if evolution.left else STOPPED, 0.0, 0.0)
