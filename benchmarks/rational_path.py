"""The path of a small joint in rational arithmetic: no round-off, and no code of the integrators.

At every instant each node's state is known exactly, so that "on the limit" and
"at the apex" have no tolerance. The rates are found by trying every combination
of what the nodes may do next (at most 4ⁿ). Slow, for a few nodes and cycles.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np

from benchmarks.rational_reference import solve_fractions
from shakedown import Problem
from shakedown.ground.constants import FloatArray
from shakedown.joint.constraints import loading

STICK, BACKWARD, FORWARD, OPEN = "stick", "backward", "forward", "open"
SIDE = {BACKWARD: 1, FORWARD: -1}
Vector = list[Fraction]


class NoPath(Exception):
    """The rates at some instant do not exist, or are not unique."""


@dataclass(frozen=True)
class RationalPath:
    """Slips and gaps (v, w) after every load step, and from which cycle on they repeat (or None)."""

    u: list[Vector]
    repeats: int | None
    m: int

    def slips(self, cycles: int) -> FloatArray:
        """Slips after every load step of so many cycles, (cycles * m, n), rounded once."""
        n, known = len(self.u[0]) // 2, len(self.u) // self.m
        if cycles > known and self.repeats is None:
            raise ValueError(f"the path is known for {known} cycles and does not repeat")
        rounded = np.array([[float(x) for x in u[:n]] for u in self.u]).reshape(known, self.m, n)
        index = [min(c, known - 1) for c in range(cycles)]
        return rounded[index].reshape(cycles * self.m, n)


def rational_path(
    problem: Problem, load_factor: float, start: FloatArray, cycles: int, stop_at_repeat: bool = False
) -> RationalPath:
    """The path from ``start`` (n,), approached as by ``Evolution``: q grows from zero, then load step 0."""
    n = problem.n
    kappa = [_exact(row) for row in problem.kappa]
    f, u = _exact(problem.f), _exact(np.concatenate([start, np.zeros(n)]))
    loop = [_exact(row) for row in np.hstack(loading(problem).at(load_factor))]
    locked = _times(kappa, u)
    load = [-x for x in locked[:n]] + [abs(a + b) - b for a, b in zip(loop[0][n:], locked[n:], strict=True)]
    states: list[Vector] = []
    for cycle in range(cycles):
        for target in loop:
            u, load = _load_step(kappa, f, u, load, target), target
            states.append(u)
        # The state at the end of a cycle, with the load there, determines the next cycle.
        if stop_at_repeat and cycle > 0 and states[-1] == states[-1 - len(loop)]:
            for target in loop:
                u, load = _load_step(kappa, f, u, load, target), target
                states.append(u)
            return RationalPath(states, cycle + 1, len(loop))
    return RationalPath(states, None, len(loop))


def one_step_holds(problem: Problem, path: RationalPath) -> bool:
    """Whether the exact states after the load steps solve the equations of single load steps.

    These know only the state before the step: a closed node slips one way, by
    v − v_old, and is on that limit at the end. An integrator with fixed load
    steps follows the path exactly where this holds, and cannot where it does not.
    """
    n, kappa, f = problem.n, [_exact(row) for row in problem.kappa], _exact(problem.f)
    loop = [_exact(row) for row in np.hstack(loading(problem).at(1.0))]
    for k in range(1, len(path.u)):
        u, before = path.u[k], path.u[k - 1]
        r = [a + b for a, b in zip(loop[k % path.m], _times(kappa, u), strict=True)]
        for i in range(n):
            slip = u[i] - before[i]
            if u[n + i] == 0 and slip != 0 and r[i] != (-1 if slip > 0 else 1) * f[i] * r[n + i]:
                return False
    return True


def _exact(values: FloatArray) -> Vector:
    return [Fraction(float(x)) for x in values]


def _times(kappa: list[Vector], u: Vector) -> Vector:
    return [sum((k * x for k, x in zip(row, u, strict=True) if x), Fraction(0)) for row in kappa]


def _load_step(kappa: list[Vector], f: Vector, u: Vector, start: Vector, end: Vector) -> Vector:
    """Carry u from event to event while the load goes from ``start`` to ``end``."""
    n, time = len(f), Fraction(0)
    welded = [b - a for a, b in zip(start, end, strict=True)]
    while time < 1:
        r = [a + time * d + k for a, d, k in zip(start, welded, _times(kappa, u), strict=True)]
        options = [_options(f[i], r[i], r[n + i], u[n + i]) for i in range(n)]
        states, motion, rate = _rates(kappa, f, u, r, welded, options)
        times = [1 - time, *_event_times(f, u, r, states, motion, rate)]
        duration = min(times)
        u = [x + duration * d for x, d in zip(u, motion, strict=True)]
        time += duration
    return u


def _options(f: Fraction, q: Fraction, p: Fraction, w: Fraction) -> tuple[str, ...]:
    """What a node may do next, from its exact state."""
    if w > 0:
        return (OPEN,)
    if w < 0 or p < 0 or abs(q) > f * p:
        raise NoPath("the state breaks the friction law")
    if p == 0:
        return (STICK, BACKWARD, FORWARD, OPEN)
    sides = tuple(state for state, s in SIDE.items() if s * q == f * p)
    return (STICK, *sides)


def _rates(kappa, f, u, r, welded, options) -> tuple[tuple[str, ...], Vector, Vector]:
    """The one combination of states whose rates are admissible."""
    found: list[tuple[tuple[str, ...], Vector, Vector]] = []
    for states in product(*options):
        motion = _moving(kappa, f, welded, states)
        if motion is None:
            continue
        rate = [d + k for d, k in zip(welded, _times(kappa, motion), strict=True)]
        if _admissible(f, u, r, states, motion, rate):
            if found and found[0][1] != motion:
                raise NoPath("the rates are not unique")
            found.append((states, motion, rate))
    if not found:
        raise NoPath("there are no rates: the state jumps")
    return found[0]


def _moving(kappa: list[Vector], f: Vector, welded: Vector, states: tuple[str, ...]) -> Vector | None:
    """Rates of v, w with the nodes in given states; None where they are not determined."""
    n, unknown, equations = len(f), [], []
    for i, state in enumerate(states):
        if state in SIDE:
            s = SIDE[state]
            unknown.append(i)
            row = [a - s * f[i] * b for a, b in zip(kappa[i], kappa[n + i], strict=True)]
            equations.append((row, s * f[i] * welded[n + i] - welded[i]))
        elif state == OPEN:
            unknown += [i, n + i]
            equations += [(kappa[i], -welded[i]), (kappa[n + i], -welded[n + i])]
    matrix = [[row[j] for j in unknown] for row, _ in equations]
    solution = solve_fractions(matrix, [right for _, right in equations])
    if solution is None:
        return None
    motion = [Fraction(0)] * (2 * n)
    for j, x in zip(unknown, solution, strict=True):
        motion[j] = x
    return motion


def _admissible(f, u, r, states, motion, rate) -> bool:
    n = len(f)
    for i, state in enumerate(states):
        q_rate, p_rate, apex = rate[i], rate[n + i], r[n + i] == 0
        if state == OPEN:
            holds = u[n + i] > 0 or motion[n + i] >= 0
        elif state in SIDE:
            holds = SIDE[state] * motion[i] <= 0 and (not apex or p_rate >= 0)
        else:
            reached = [s for s in (1, -1) if s * r[i] == f[i] * r[n + i]]
            holds = all(s * q_rate <= f[i] * p_rate for s in reached) and (not apex or p_rate >= 0)
        if not holds:
            return False
    return True


def _event_times(f, u, r, states, motion, rate) -> Iterator[Fraction]:
    """Times until something that is still away is used up."""
    n = len(f)
    for i, state in enumerate(states):
        if state == OPEN:
            guards = [(u[n + i], motion[n + i])]
        elif state == STICK:
            guards = [(f[i] * r[n + i] - s * r[i], f[i] * rate[n + i] - s * rate[i]) for s in (1, -1)]
        else:
            guards = [(r[n + i], rate[n + i])]
        for distance, change in guards:
            if distance > 0 and change < 0:
                yield distance / -change
