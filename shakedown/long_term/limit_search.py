"""The search for the long-term state: compiled loops, and the cases that they hand back to Python."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import null_space

from shakedown.ground.constants import BATCH, DISTINCT, NEGLIGIBLE, RESOLVED, FloatArray, Mask
from shakedown.ground.shown_values import count, cycles_in_words, nodes_in_words
from shakedown.ground.status import Outcome
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.law import Layout
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.long_term.motion_start import MotionStart
from shakedown.long_term.plane.period_map import limit, period_map
from shakedown.long_term.plane.phase_loop import Instruction, Verdict, instruct, run_searches
from shakedown.long_term.plane.search import Answers, PlaneSearch, path_check, plane_search
from shakedown.long_term.proved_outcome import overruled_by_proofs
from shakedown.long_term.state import VARIES_LITTLE, LongTermState
from shakedown.motion.checked_law import alone, load_range
from shakedown.motion.course import CALL_OPERATIONS, LoopEnd
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import State
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
    problem, tolerances
        The joint, and what decides.
    most_cycles, longest_period
        As for :func:`long_term_state`.
    """

    def __init__(self, problem: Problem, t: Tolerances, most_cycles: int, longest_period: int) -> None:
        self.evolution = evolution = Evolution(problem, 0.0, None, t)
        capacity, events = min(most_cycles + longest_period, BATCH), self._events  # states between two cycles
        runs = events.run_of(True, False), events.run_of(False, False), events.run_of(False, True)
        check = path_check(problem.f)
        self.compiled = plane_search(runs, period_map(problem.n), check, capacity, longest_period)
        self.compiled.set(
            most_cycles=most_cycles,
            limit=t.limit,
            rounding=ROUNDING,
            friction_law=t.friction_law,
            stiffness=float(np.abs(evolution.kappa).max()),
        )

    @property
    def _events(self) -> PlaneEvents:
        assert isinstance(self.evolution.method, PlaneEvents)
        return self.evolution.method

    def begin(self, load_factor: float, initial_slip: ArrayLike | None, open_nodes: tuple[int, ...]) -> None:
        """Go to the start at a load factor, and set the scales of the joint there."""
        self.evolution.begin(load_factor, initial_slip, open_nodes)
        evolution, scale = self.evolution, self.evolution.scale
        share, lost = evolution.tolerances.periodicity, self._events.courses[False].force
        near, moving = share * scale.length, load_range(evolution.problem, evolution.load)
        self.compiled.set(least_force=scale.force, blurred=0.0 < moving < RESOLVED * lost)
        self.compiled.check.set(force=scale.force, length=scale.length, near=near)
        self.compiled.weight[:] = near / alone(evolution.problem, max(share * moving, DISTINCT * lost))

    def state(self, open_nodes: tuple[int, ...]) -> LongTermState:
        """The long-term state of the motion from its start, with the given nodes open there."""
        motion, layout = self.evolution, self.evolution.problem.layout
        origin, answers = MotionStart.of(motion, open_nodes), empty_answers(1, layout)
        self.from_here(answers)
        at, verdict = self.compiled, int(answers.verdict[0])
        known, left, nan = verdict >= Verdict.SHAKEDOWN, verdict == Verdict.LEFT, np.full(layout.n, np.nan)
        cycles = at.done if known else np.nan
        always_open = at.check.always_open == 1 if known else np.full(layout.n, left)
        opened = at.opened == 1 if known else np.full(layout.n, left)
        reason, met = _reason(motion, at, verdict)
        found = LongTermState(
            problem=motion.problem,
            load_factor=motion.load_factor,
            initial_slip=origin.start,
            outcome=OUTCOMES[verdict],
            reason=reason + _events_in_words(at, opened & ~always_open) if known else reason,
            period=at.done if known else 0,
            final_slip=answers.final_slip[0],
            drift=at.done / at.period * at.drift[layout.slips] if known else nan,
            slip_per_cycle=answers.slip_per_cycle[0],
            friction_dissipation_per_cycle=at.friction / cycles,
            jump_dissipation_per_cycle=at.damping / cycles,
            jumps_per_cycle=at.jumps / cycles,
            open_nodes=tuple(np.flatnonzero(always_open).tolist()),
            cycles_simulated=at.cycles,
            slides_away=motion.stop is not None and motion.stop.slides_away,
            dissipations=at.works[: at.done].copy() if known else np.array([]),
            opened=opened,
            events=at.events,
            contraction=answers.contraction[0],
            return_error=at.far / motion.scale.length if known else np.nan,
            signature=int(answers.signature[0]),
            stop=motion.stop,
            met=met,
            most_cycles=at.most_cycles,
            origin=origin,
            goal=State(at.goal.copy(), at.contact.copy()) if known else motion.state,
        )
        return overruled_by_proofs(found)

    def from_here(self, answers: Answers) -> None:
        """Answer for the present state of the evolution, at its start."""
        instruct(self.compiled, Instruction.FROM_HERE, 0.0, 0.0)
        if not self.evolution.held:
            self._give_up()
        self._run(answers.final_slip, answers, lambda: False)

    def from_slips(
        self, starts: FloatArray, answers: Answers, stopped: Callable[[], bool]
    ) -> tuple[LongTermState, ...]:
        """Enter the answers for initial slips (s, n), one after the other, until ``stopped()`` is true."""
        instruct(self.compiled, Instruction.ANEW, 0.0, 0.0)
        self._run(starts, answers, stopped)
        return ()

    def _run(self, starts: FloatArray, answers: Answers, stopped: Callable[[], bool]) -> None:
        status, follow = LoopEnd.PAUSED, address_of_loop()
        while status != LoopEnd.DONE and not stopped():
            status = run_searches(self.compiled, starts, answers, CALL_OPERATIONS, follow)
            if status == LoopEnd.LIMIT_WANTED:
                self._give_limit()
            elif status == LoopEnd.SINGULAR:
                self._give_up()
            elif status not in (LoopEnd.DONE, LoopEnd.PAUSED):
                self._give_way(status)

    def _give_limit(self) -> None:
        """The limit of an affine map that drifts, or nearly so; only a rigid slip can drift for ever.

        The map leaves rigid slips as they are. They are taken out of it beforehand, as it has few digits of
        them where a body is hardly held within the period.
        """
        affine, layout = self.compiled.map, self.evolution.problem.layout
        k, stuck = affine.k, affine.stuck[: affine.t]
        J, d, moving = affine.power.ravel()[: k * k].reshape(k, k), affine.change[:k], affine.moves[:k]
        motions = rigid_slips(self.evolution.problem).motions
        motions = motions @ null_space(motions[np.delete(stuck, moving)], rcond=NEGLIGIBLE)
        Z = np.linalg.qr(motions[stuck[moving]])[0]
        rest = np.eye(k) - Z @ Z.T
        deflated = rest @ J @ rest
        change, slow, contraction = limit(deflated, rest @ d)
        drift = motions @ np.linalg.lstsq(motions[stuck[moving]], d + J @ change)[0]
        # less the rigid slip that Jⁱ · change tends to
        change -= Z @ (Z.T + np.linalg.lstsq(np.eye(k) - deflated.T, rest @ J.T @ Z)[0].T) @ change
        # what else does not decay is merely too slow to tell
        still = self.compiled.weight[stuck[moving]] * np.abs(slow) <= self.compiled.check.near
        decaying = contraction < 1.0 and bool(still.all())
        affine.limit[:k], affine.drift[:k] = change, drift[stuck[moving]]
        self.compiled.drift[:] = 0.0
        self.compiled.drift[layout.slips] = drift
        instruct(self.compiled, Instruction.LIMIT_FOUND, float(decaying), contraction)

    def _give_up(self) -> None:
        """Give up a state whose moving nodes are held by nothing."""
        self.evolution.enter_cycle(self.compiled.cycles)
        self.evolution.say_not_held()
        instruct(self.compiled, Instruction.STOPPED, 0.0, 0.0)

    def _give_way(self, status: int) -> None:
        """Supply rates, or a state to jump to, where the loop found none; else why the motion stops."""
        evolution, at = self.evolution, self.compiled
        if not at.jumped:
            evolution.enter_cycle(at.cycles)
        before = len(evolution.jumps)
        if status == LoopEnd.NO_RATES and self._events.finds_rates():
            instruct(at, Instruction.RATES, 0.0, 0.0)
        elif status == LoopEnd.NO_RATES and evolution.jump():
            new = evolution.jumps[before:]  # none where the state keeps its place
            friction, damping = (new[0].friction_work, new[0].damping_work) if new else (0.0, 0.0)
            instruct(at, Instruction.JUMP if new else Instruction.STAYS, friction, damping)
        else:
            evolution.say_why(status)
            instruct(at, Instruction.LEAVES if evolution.left else Instruction.STOPPED, 0.0, 0.0)


def _reason(evolution: Evolution, at: PlaneSearch, verdict: int) -> tuple[str, float]:
    """The basis of the verdict in words, and the violation of the friction law, NaN where there is none."""
    if verdict in (Verdict.UNDECIDED, Verdict.LEFT):
        stop = evolution.stop
        return stop.reason if stop else f"no periodic state within {count(at.cycles, 'cycle')}", np.nan
    text = f"limit of the cycles, whose contact states repeat every {cycles_in_words(at.period)}"
    if not at.from_limit:
        cycle, before = at.cycles - at.done, at.cycles - at.done - at.period
        text = f"cycle {cycle} repeats cycle {before}" if before else f"the start is back after cycle {cycle}"
    if verdict == Verdict.BLURRED:
        return f"{VARIES_LITTLE} ({text})", np.nan
    if verdict != Verdict.BROKEN:
        return text, np.nan
    if at.done == 0:
        residual = evolution.violation(evolution.state)
        return f"the friction law is violated by {residual:.1e} between two cycles ({text})", residual
    broken = f"the friction law is violated by {at.check.violation:.1e} in the period found ({text})"
    return broken, at.check.violation


def _events_in_words(at: PlaneSearch, breathing: Mask) -> str:
    """The nodes that open and close in a period, and its jumps, in words."""
    every, text = cycles_in_words(at.done), ""
    if breathing.any():
        text += f"; opening and closing every {every}: {nodes_in_words(np.flatnonzero(breathing))}"
    if at.jumps:
        text += f"; {at.jumps} jump{'s' if at.jumps > 1 else ''} in every {every}"
    return text
