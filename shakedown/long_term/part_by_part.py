"""What becomes of a joint in uncoupled parts: that of each part alone, in scales of its own, put together."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import reduce
from math import lcm
from operator import attrgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import nodes_in_words
from shakedown.ground.status import Outcome
from shakedown.ground.work_limit import work_again
from shakedown.joint.coupled_parts import Part, of_nodes, of_slips
from shakedown.joint.problem import Problem
from shakedown.long_term.state import LongTermState
from shakedown.motion.checked_law import scales
from shakedown.motion.method import State

ORDER = Outcome.SHAKEDOWN, Outcome.SEPARATION, Outcome.CYCLIC_SLIP, Outcome.RATCHETTING, Outcome.UNDECIDED
PRIME = 1099511628211  # of hashes
OF_SLIPS, OF_NODES = ("initial_slip", "final_slip", "drift"), ("slip_per_cycle", "opened")
SUMS = [
    "friction_dissipation_per_cycle",
    "jump_dissipation_per_cycle",
    "jumps_per_cycle",
    "dissipations",
    "events",
]
MOST_REASONS = 3  # in words


def joined_state(
    problem: Problem, open_nodes: tuple[int, ...], parts: Sequence[Part], found: Sequence[LongTermState]
) -> LongTermState:
    """The long-term state of a joint from those of its parts.

    The outcome is the worst, the period the least common multiple; where a part is undecided or has come
    apart there is none, and no slip, drift or work per cycle of all.
    """
    worst, period = max(found, key=_rank), lcm(*(state.period for state in found))
    cycles = max(state.cycles_simulated for state in found)
    states = [_over(period, state, cycles) for state in found]

    def slips(value: Callable[[LongTermState], FloatArray]) -> FloatArray:
        return of_slips(parts, map(value, states))

    def nodes(value: Callable[[LongTermState], NDArray[Any]]) -> NDArray[Any]:
        return of_nodes(parts, map(value, states))

    u = problem.layout.joined(
        slips(lambda state: state.goal.u[state.problem.layout.slips]),
        nodes(lambda state: state.goal.u[state.problem.layout.gaps]),
    )
    lengths = [scales(each, worst.load_factor).length for each in (problem, *(part.joint for part in parts))]
    missed = [state.return_error * length for state, length in zip(states, lengths[1:], strict=True)]
    opened = [part.number(i) for part, state in zip(parts, states, strict=True) for i in state.open_nodes]
    more: dict[str, Any] = {word: slips(attrgetter(word)) for word in OF_SLIPS}
    more |= {word: nodes(attrgetter(word)) for word in OF_NODES}
    more |= {word: sum(getattr(state, word) for state in states) for word in SUMS}
    return replace(
        worst,
        problem=problem,
        reason=_reason(parts, found),
        period=period,
        open_nodes=tuple(sorted(opened)),
        cycles_simulated=cycles,
        slides_away=any(state.slides_away for state in states),
        contraction=float(np.max([state.contraction for state in states])),
        return_error=float(np.max(missed)) / lengths[0],
        error=float(np.max([state.error for state in states])),
        signature=reduce(lambda known, state: (known ^ state.signature) * PRIME % 2**64, states, 0),
        met=float(np.fmax.reduce([state.met for state in states])),
        begun=replace(
            worst.begun, problem=problem, start=slips(lambda state: state.begun.start), open_nodes=open_nodes
        ),
        goal=State(u, nodes(lambda state: state.goal.contact)),
        first_cycles=None,
        jumps=(),
        proof=None,
        parts=tuple(found),
        **more,
    )


def _rank(state: LongTermState) -> float:
    """How bad an outcome is; worse than ratchetting is a part that has come apart for good."""
    apart = state.outcome == Outcome.SEPARATION and not state.period
    return ORDER.index(Outcome.RATCHETTING) + 0.5 if apart else ORDER.index(state.outcome)


def _over(period: int, state: LongTermState, cycles: int) -> LongTermState:
    """The state of a part over a multiple of its period, in step with others after so many cycles."""
    if not period:
        return state.without_period()
    times, ahead = period // state.period, (cycles - state.cycles_simulated) % state.period
    goal, start = state.goal, state.final_slip - state.drift
    if ahead:
        motion = state.motion()
        with work_again():
            motion.advance(ahead)
        goal = motion.state
        start = goal.u[state.problem.layout.slips]
    return replace(
        state,
        goal=goal,
        final_slip=start + times * state.drift if ahead or times > 1 else state.final_slip,
        drift=times * state.drift,
        slip_per_cycle=times * state.slip_per_cycle,
        dissipations=np.tile(np.roll(state.dissipations, -ahead), times),
    )


def _reason(parts: Sequence[Part], found: Sequence[LongTermState]) -> str:
    """Why the worst parts do what they do, and what the others do."""
    most, said, others = max(map(_rank, found)), dict[str, list[int]](), set[str]()
    for part, state in zip(parts, found, strict=True):
        if _rank(state) == most:
            said.setdefault(part.renumbered(state.reason), []).extend(part.nodes.tolist())
        else:
            others.add(state.outcome.value)
    if len(said) == 1 and not others:
        return next(iter(said))
    texts = [f"{text} ({nodes_in_words(sorted(nodes))})" for text, nodes in said.items()][:MOST_REASONS]
    left = [f"the nodes uncoupled from them: {', '.join(sorted(others))}"] * bool(others)
    return "; ".join([*texts, *left])
