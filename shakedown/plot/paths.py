"""What pictures read from a result: its path, an instant, pressures, slip and work of each node."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import SIX_DIGITS, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import few, with_unit
from shakedown.ground.status import OPEN
from shakedown.joint.arguments import in_the_plane_only, require_plane
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import units_of
from shakedown.long_term.state import LongTermState
from shakedown.motion.event_history import EventHistory, recorded_path

Recorded = Any  # a path, or a result that has recorded one


def of_kind(found: Result, kind: str) -> Any:
    """A result of the studies, which stand above this package, after a check of the name of its class."""
    names = [each.__name__ for each in type(found).__mro__]
    if kind not in names:
        raise UsageError(f"found: expected a result {kind}, found {names[0]}")
    return found


def path_in_the_plane(result: Recorded, problem: Problem | None) -> EventHistory:
    """As :func:`recorded_path`, with or without its joint; ``UsageError`` where the joint is one in space."""
    if problem is not None:
        require_plane("picture", problem)
    path = recorded_path(result)
    if path.v.shape != path.p.shape:
        raise UsageError(in_the_plane_only("picture"))
    return path if problem is None else path.without_round_off(problem)


def pressed(problem: Problem, path: EventHistory) -> NDArray[np.bool_]:
    """Where nodes are closed and p exceeds the resolution of a path, so that q/(f p) is defined, (s, n)."""
    limit = problem.law.limit(path.p)
    return np.asarray((path.state != OPEN) & (limit > SIX_DIGITS * np.abs(limit).max(initial=0.0)))


def time_in_words(cycle: float) -> str:
    """The time of an instant, as pictures write it."""
    return f"t = {few(cycle)} cycles"


def at_instant(path: EventHistory, cycle: float | None, *, sheared: bool = False) -> tuple[EventHistory, str]:
    """The state at a time, by default when the total pressure is largest, and its name in a picture.

    On request the default is the time when the sum of the tangential reactions is largest.
    """
    time = float(path.cycle[extreme_rows(path)[2 * sheared]]) if cycle is None else cycle
    return path.at(np.array([time])), time_in_words(time)


def extreme_rows(path: EventHistory) -> tuple[int, int, int]:
    """The rows with the largest and the smallest total pressure, and with the largest tangential reactions.

    Once the first period has begun. Among rows of the same total up to round-off, the one with the largest
    tangential reactions is taken: where the pressure is constant, a row without load would show nothing.
    """
    begun = path.cycle >= 0
    rows = np.flatnonzero(begun) if begun.any() else np.arange(len(path.cycle))
    total, sheared = path.p[rows].sum(axis=1), np.abs(path.q[rows]).sum(axis=1)
    near = SIX_DIGITS * np.abs(total).max()
    most = np.where(total >= total.max() - near, sheared, -1.0).argmax()
    least = np.where(total <= total.min() + near, sheared, -1.0).argmax()
    return int(rows[most]), int(rows[least]), int(rows[sheared.argmax()])


def work_of_nodes(result: Recorded) -> FloatArray:
    """−∫ q dv in contact along a path, (n,) [force × length]: in space of a long-term state as integrated."""
    path = recorded_path(result)
    if isinstance(result, LongTermState) and result.period and path.v.shape != path.p.shape:
        return np.asarray(result.period * result.work_per_cycle)
    return np.asarray(_work_of_steps(path.refined()).sum(axis=0))


def slip_of_nodes(result: Recorded, problem: Problem) -> FloatArray:
    """Σ|Δv| in contact along a path, (n,) [length]."""
    if isinstance(result, LongTermState) and result.period:
        return np.asarray(result.slip_per_cycle)
    return np.asarray(_slip_of_steps(recorded_path(result).refined(), problem).sum(axis=0))


def so_far(state: LongTermState, cycles: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Slip Σ|Δv| in contact and friction work of a period up to some times, each (s, n)."""
    path, problem = state.history.refined(), state.problem
    found = []
    for steps, total in (
        (_slip_of_steps(path, problem), slip_of_nodes(state, problem)),
        (_work_of_steps(path), work_of_nodes(state)),
    ):
        grown = np.concatenate([np.zeros((1, problem.n)), np.cumsum(steps, axis=0)])
        grown *= total / np.where(grown[-1] != 0, grown[-1], 1.0)  # steps are close to what was integrated
        found.append(np.stack([np.interp(cycles, path.cycle, node) for node in grown.T], axis=1))
    return found[0], found[1]


def _work_of_steps(path: EventHistory) -> FloatArray:
    steps = -0.5 * (path.q[1:] + path.q[:-1]) * np.diff(path.v, axis=0)
    closed = path.state[:-1] != OPEN  # the state of a row holds until the next one
    return np.where(closed, steps.reshape(*path.p[1:].shape, -1).sum(axis=-1), 0.0)


def _slip_of_steps(path: EventHistory, problem: Problem) -> FloatArray:
    return np.where(path.state[:-1] != OPEN, problem.law.size(np.diff(path.v, axis=0)), 0.0)


def normal_reactions(what: str, p: FloatArray, problem: Problem) -> tuple[FloatArray, str]:
    """Normal reactions (…, n), or pressures where areas are known, and their name with its unit."""
    units = units_of(problem)
    if problem.node_area is None:
        return p, with_unit(what, units.force)
    named = what.replace("normal reaction p", "pressure").replace("reaction", "pressure")
    return _per_area(p, problem.node_area), with_unit(named, units.stress)


def work_and_name(work: FloatArray, problem: Problem) -> tuple[FloatArray, str]:
    """Friction work of the nodes (…, n), per area where areas are known, and its name with its unit."""
    units = units_of(problem)
    if problem.node_area is None:
        return work, with_unit("friction work", units.work)
    return _per_area(work, problem.node_area), with_unit("friction work per area", units.stiffness)


def _per_area(values: FloatArray, area: FloatArray) -> FloatArray:
    """Values per area; a node without area has none."""
    with np.errstate(over="ignore"):  # where an area is almost zero
        found = values / np.where(area > 0, area, np.nan)
    return np.where(np.isfinite(found), found, np.nan)


def chosen_nodes(nodes: Iterable[int], n: int) -> list[int]:
    """The nodes named, at least one; ``UsageError`` where there is none of a number."""
    chosen = list(nodes)
    wrong = [str(node) for node in chosen if not 0 <= node < n]
    if wrong or not chosen:
        raise UsageError(f"nodes: expected numbers from 0 to {n - 1}, found {(wrong or ['none'])[0]}")
    return chosen
