"""The start of a motion, so that it can be followed again, and the effect of the transient on it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import MISJUDGED
from shakedown.ground.status import OPEN
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.conjugate_loads import NO_LOADS
from shakedown.joint.loading import first_load, loading, loop_path, transient_path
from shakedown.joint.problem import Problem
from shakedown.motion.evolution import Evolution
from shakedown.motion.method import CycleRecord, State, cycles_of

LONGEST_TRANSIENT = 12  # random load steps

FirstCycles = tuple[tuple[CycleRecord, State], ...]
"""The cycles that a search followed before its first leap, and the states at their ends."""


class Passed(NamedTuple):
    """A state between two cycles of a motion.

    Attributes
    ----------
    cycles
        After how many cycles.
    slip : (n,)
        The slip then [length].
    open_nodes
        The nodes that are open then.
    error
        The possible error of every node, twice the estimate [length]; 0 for exact paths.
    """

    cycles: int
    slip: FloatArray
    open_nodes: tuple[int, ...]
    error: float


@dataclass(frozen=True)
class Passage:
    """A joint, its loading and where its motion began.

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
    def of(cls, motion: Evolution, open_nodes: tuple[int, ...] = ()) -> "Passage":
        """That of a motion at its start."""
        start = motion.state.u[motion.problem.layout.slips].copy()
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

    def passed(self, first_cycles: FirstCycles | None, most: int) -> Iterator[Passed]:
        """The states after successive cycles: the stored ones, then others up to a given number."""
        error = 0.0
        for done, (record, state) in enumerate(self._cycles(first_cycles or (), most), start=1):
            error += MISJUDGED * record.error
            open_nodes = tuple(np.flatnonzero(state.contact == OPEN).tolist())
            yield Passed(done, record.end_slip, open_nodes, error)

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

    What is said of every closed state is then said of this one. True where there is no transient:
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
    motion = Passage(replace(problem, **at_first), 1.0, tolerances, start, ()).motion()
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
    open in the end has its displacement; of a body that slides away it is the slip up to there, and none of
    one that nothing holds.

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
    ends = loop[generator.integers(problem.m, size=(2, generator.integers(1, LONGEST_TRANSIENT + 1)))]
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
    if motion.cycle(record=True) is not None:
        u = motion.method.u
    else:
        u = motion.pieces[-1].u[-1] if motion.pieces else np.zeros(problem.layout.size)
    return u[problem.layout.slips].copy()
