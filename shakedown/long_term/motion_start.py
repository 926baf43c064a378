"""The first cycles of a motion, and what bounds are known of its start."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from math import inf
from typing import Any, TypeGuard

import numpy as np

from shakedown.bounds.accumulated_bound import ACCURACY, accumulated_bound, total_slip_bound
from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.energy_ball import no_ball_holds
from shakedown.bounds.energy.energy_bound import energy_bound
from shakedown.bounds.upper import upper_bound
from shakedown.ground.constants import ERROR_FACTOR, NEGLIGIBLE, FloatArray
from shakedown.ground.errors import Missing, attempt_any, present
from shakedown.ground.status import OPEN, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import first_load, loading, loop_path, transient_path
from shakedown.joint.problem import Problem
from shakedown.joint.units import NO_LOADS
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import CycleRecord, State, cycles_of

FirstCycles = tuple[tuple[CycleRecord, State], ...]
"""The cycles that a search followed before its first leap, and the states at their ends."""


@dataclass(frozen=True)
class MotionStart:
    """A joint, its loading and the state from which its motion starts.

    Attributes
    ----------
    problem, load_factor, tolerances
        What was followed.
    start : (n,)
        Slip at the very start [length].
    open_nodes
        The nodes that were open there.
    """

    problem: Problem
    load_factor: float
    tolerances: Tolerances
    start: FloatArray
    open_nodes: tuple[int, ...]

    @classmethod
    def of(cls, motion: Evolution, open_nodes: tuple[int, ...] = ()) -> "MotionStart":
        """That of a motion at its start."""
        start = motion.state.u[motion.problem.layout.slips]
        return cls(motion.problem, motion.load_factor, motion.tolerances, start, open_nodes)

    def motion(self) -> Evolution:
        """The motion at its start: exact in the plane, to the accuracy of the tolerances in space."""
        return Evolution(
            self.problem, self.load_factor, self.start, self.tolerances, open_nodes=self.open_nodes
        )

    def motion_from(self, state: State, done: int) -> Evolution:
        """The motion in the state after a number of cycles."""
        evolution = self.motion()
        evolution.state = state
        evolution.enter_cycle(done)
        return evolution

    def passed(
        self, first_cycles: FirstCycles | None, most: int
    ) -> Iterator[tuple[int, FloatArray, tuple[int, ...], float]]:
        """After successive cycles, the stored ones, then others up to a given number: the state.

        How many cycles those are, the slip [length], the open nodes, and the possible error of every node,
        twice the estimate [length]; 0 for exact paths.
        """
        error = 0.0
        for done, (record, state) in enumerate(self._cycles(first_cycles or (), most), start=1):
            error += ERROR_FACTOR * record.error
            open_nodes = tuple(np.flatnonzero(state.contact == OPEN).tolist())
            yield done, record.end_slip, open_nodes, error

    def _cycles(self, first_cycles: FirstCycles, most: int) -> Iterator[tuple[CycleRecord, State]]:
        yield from first_cycles
        done = len(first_cycles)
        motion = self.motion_from(first_cycles[-1][1], done) if first_cycles else self.motion()
        for record in cycles_of(motion, max(most - done, 0)):
            yield record, motion.state


def arrives_closed(
    problem: Problem, load_factor: float, start: FloatArray, tolerances: Tolerances = DEFAULT
) -> bool:
    """Whether all nodes are closed at the first load step of the loop, when the transient is over.

    What holds for every closed state then holds for this one. True where there is no transient:
    that the start is admissible is another matter.

    Examples
    --------
    >>> import numpy as np, shakedown
    >>> arrives_closed(shakedown.example("receding-block"), 0.1, np.zeros(33))
    False
    """
    if not len(transient_path(problem)):
        return True
    q_w, p_w = loading(problem).at(load_factor)
    at_first = NO_LOADS | {"q_w": q_w[:1], "p_w": p_w[:1], "q_mean": q_w[0], "p_mean": p_w[0]}
    motion = MotionStart(replace(problem, **at_first), 1.0, tolerances, start, ()).motion()
    return motion.cycle() is not None and not (motion.state.contact == OPEN).any()


def slip_after_transient(
    problem: Problem,
    load_factor: float,
    generator: np.random.Generator,
    *,
    overload: float = 1.0,
    tolerances: Tolerances = DEFAULT,
) -> FloatArray:
    """Slip after a random transient from slip zero, and then the first load of the motion, (dn,) [length].

    The transient has 1 to 12 load steps, each anywhere between two load steps of the loop. A node that is
    open in the end has its displacement; of a body that slides away, or where the work allowed is spent, it
    is the slip up to there, and none of one that nothing holds.

    Parameters
    ----------
    problem, load_factor
        The joint and λ.
    generator
        Of the random numbers.
    overload
        How many times λ the load factor of the transient is.
    tolerances
        Those of the motion.

    Examples
    --------
    >>> import shakedown
    >>> joint, generator = shakedown.example("two-node"), np.random.default_rng(0)
    >>> slip_after_transient(joint, 0.7, generator, overload=2.0).shape
    (2,)
    """
    split, loop = problem.layout.split, loop_path(problem, overload * load_factor)
    # 1 to 12 random load steps
    ends = loop[generator.integers(problem.m, size=(2, generator.integers(1, 13)))]
    share = generator.random((ends.shape[1], 1))
    before_q, before_p = split(ends[0] + share * (ends[1] - ends[0]))
    q, p = split(first_load(problem, load_factor))
    passed = replace(
        problem,
        **NO_LOADS,  # in one go, as every joint is checked anew
        q_w=q[None],
        p_w=p[None],
        q_mean=q,
        p_mean=p,
        initial_slip=None,
        q_transient=before_q,
        p_transient=before_p,
    )
    motion = Evolution(passed, 0.0, None, tolerances)
    motion.cycle()
    return motion.u[problem.layout.slips].copy()


SURELY_ABOVE = 1.0 + DEFAULT.agreement  # times λ_max: beyond its uncertainty
SURELY_BELOW = 1.0 - NEGLIGIBLE  # times a proved load factor: below its round-off


def bound_proves(bound: Bound | Missing, load_factor: float) -> TypeGuard[Bound]:
    """Whether a bound proves shakedown at a load factor, beyond its round-off."""
    if isinstance(bound, Missing):
        return False
    return bool(bound.least_load_factor <= load_factor < SURELY_BELOW * bound.load_factor)


def bound_of_start(origin: MotionStart, kind: str = "energy") -> Bound | Missing:
    """λ_E, or λ_S (``"accumulated"``), of the start, computed once; λ_S is Missing where nodes are open."""
    known, key = _bounds_of_starts(origin.problem), _key(origin, kind)
    if key not in known:
        if kind == "energy":
            zone: dict[str, Any] = {"open_nodes": origin.open_nodes, "tolerances": origin.tolerances}
            known[key] = attempt_any(energy_bound, origin.problem, origin.start, certify=False, **zone)
        elif origin.open_nodes:
            known[key] = Missing("λ_S is about all nodes closed")
        else:
            known[key] = accumulated_bound(origin.problem, origin.start)
    found: Bound | Missing = known[key]
    return found


def is_known(origin: MotionStart) -> bool:
    """Whether λ_E of the start is known already."""
    return _key(origin, "energy") in _bounds_of_starts(origin.problem)


def store_bound(origin: MotionStart, bound: Bound) -> None:
    """Store a limit that is proved from a start: λ_E or λ_S."""
    _bounds_of_starts(origin.problem).setdefault(_key(origin, bound.kind), bound)


def proving_bound(origin: MotionStart) -> Bound | None:
    """λ_E of the start where it proves shakedown; not worked out where no ball is seen to hold the start."""
    asked = origin.problem, origin.load_factor, origin.start, origin.open_nodes, origin.tolerances
    if not is_known(origin) and attempt_any(no_ball_holds, *asked):
        return None
    bound = bound_of_start(origin)
    return bound if bound_proves(bound, origin.load_factor) else None


def total_slip_from(problem: Problem, load_factor: float, slip: FloatArray, error: float = 0.0) -> float:
    """The bound on the total slip of any node from a closed state known to an error; inf where unknown."""
    found = total_slip_bound(problem, load_factor, slip, start_error=error)
    return float(found.total_slip.max()) if found.status == Status.OPTIMAL else inf


def total_slip_from_start(origin: MotionStart) -> float:
    """The bound on the total slip of any node from the start; inf where it is not known.

    λ = 0 comes first, where the absence of a bound is found soonest. Nothing bounds it at load
    factors larger than one at which nothing does, as the conditions of a bound cover all smaller ones.
    """
    of_starts, key = _bounds_of_starts(origin.problem), _key(origin, "unbounded slip")
    least, known = of_starts.get(key, inf), of_starts.get(_key(origin, "accumulated"))
    if known and known.status == Status.INFEASIBLE:
        least = 0.0
    elif known and known.status == Status.OPTIMAL:
        least = min(least, (1.0 + 2.0 * ACCURACY[origin.problem.directions]) * known.load_factor)
    further = inf
    if origin.open_nodes or origin.load_factor >= least:
        return further
    for load_factor in (0.0, origin.load_factor):
        further = total_slip_from(origin.problem, load_factor, origin.start)
        if further == inf:
            of_starts[key] = load_factor
            break
    return further


def _key(origin: MotionStart, kind: str) -> object:
    return kind, origin.start.tobytes(), origin.open_nodes, origin.tolerances


@once_per_problem
def _bounds_of_starts(problem: Problem) -> dict[object, Any]:
    """Known proofs from a start of one problem, by kind, start, open nodes and tolerances.

    Also the least load factor asked about at which total slip has no bound ("unbounded slip").
    """
    return {}


@once_per_problem
def known_limits(problem: Problem) -> dict[str, Bound | Missing]:
    """λ_max and λ_U of a problem with all nodes closed, by their words, where they are known."""
    return {}


def known_limit(problem: Problem, name: str, find: Callable[[Problem], Bound]) -> Bound | None:
    """One of these limits, computed once; None where it comes to no end."""
    known = known_limits(problem)
    if name not in known:
        known[name] = attempt_any(find, problem)
    return present(known[name])


def lambda_max(problem: Problem) -> float:
    """λ_max with all nodes closed; inf where unbounded, NaN where no slip is safe."""
    found = known_limit(problem, "upper", upper_bound)
    return inf if found is None else found.load_factor


def above_lambda_max(origin: MotionStart) -> bool:
    """Whether a load factor is known to exceed λ_max, beyond its round-off."""
    known = "upper" in known_limits(origin.problem)
    return known and origin.load_factor > SURELY_ABOVE * lambda_max(origin.problem)
