"""What the nodes of a simulation do, over the period and at its instants."""

import os
from itertools import combinations_with_replacement
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.accumulated.accumulated_bound import total_slip_bound
from shakedown.files.vtk_points import write_points_series
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import with_unit
from shakedown.ground.status import OPEN, Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, is_finite
from shakedown.joint.problem import Problem
from shakedown.joint.units import units_of
from shakedown.long_term.node_table import (
    MIXED,
    NOT_KNOWN,
    SLIPS,
    STAYS_OPEN,
    STICKS,
    NodeResults,
    axes_of,
    coordinates_of,
    faces_of,
    fixed_numbers,
    labels_of,
    normals_of,
    points_of,
)
from shakedown.long_term.state import LongTermState, SteppedState
from shakedown.motion.checked_law import length_scales, path_resolution
from shakedown.motion.event_history import EventHistory

Settled = LongTermState | SteppedState
BLOCK = 128  # points of a path that are handled together


@checked
def node_results(
    simulation_or_state: object,
    *,
    wear_coefficient: float | None = None,
    tolerances: Tolerances = DEFAULT,
) -> NodeResults:
    """The results of each node over one period of the long-term state (:class:`NodeResults`).

    From event to event every number is exact in the plane: between two events slips, gaps and reactions
    are linear in time. With two tangential directions they are those at five instants of every step of
    the path. With fixed load steps they are those at the ends of load steps.

    Parameters
    ----------
    simulation_or_state
        A long-term state, a simulation, or a run of a verification.
    wear_coefficient
        k ≥ 0 of Archard's law: depth = k × pressure × sliding distance [length²/force].
    tolerances
        The tolerances of the simulation: slips within ``periodicity`` of its length scale count as none.

    Raises
    ------
    UsageError
        If there is no such state, or the coefficient is negative or so large that wear overflows.

    Examples
    --------
    >>> import shakedown
    >>> nodes = node_results(shakedown.long_term_state(shakedown.example("two-node"), 0.9))
    >>> nodes.status, nodes.slip_range.round(4), nodes.accumulated_slip.round(4)
    (('stick', 'slip'), array([0.    , 0.9468]), array([0.    , 1.8936]))
    """
    settled = settled_of(simulation_or_state)
    k = np.nan if wear_coefficient is None else wear_coefficient
    if not (wear_coefficient is None or (is_finite(k) and k >= 0)):
        raise UsageError(f"wear coefficient: expected a number ≥ 0, found {wear_coefficient!r}")
    problem, history, status = settled.problem, settled.history.refined(), statuses(settled, tolerances)
    carries = np.array(status) != STAYS_OPEN  # at open nodes reactions are round-off
    p, q = history.p * carries, history.q * np.repeat(carries, problem.directions)
    force, length = units_of(problem)
    nothing = np.full(problem.n, np.nan)
    area = nothing if problem.node_area is None else problem.node_area
    known = settled.period > 0
    parts = known and problem.directions > 1
    extents, axes = slip_extents(settled, tolerances), axes_of(problem)
    with np.errstate(over="ignore"):  # overflow is refused below
        worn = k * pressed_slip(settled) if known else nothing
        if np.isinf([worn, worn / np.where(area > 0, area, 1.0)]).any():
            raise UsageError(f"wear coefficient: expected one of finite wear, found {wear_coefficient!r}")
    return NodeResults(
        load_factor=settled.load_factor,
        outcome=settled.outcome,
        reason=settled.reason,
        period=settled.period,
        force_unit=force,
        length_unit=length,
        label=labels_of(problem),
        coordinates=coordinates_of(problem),
        area=area,
        status=status,
        slip_range=problem.law.size(extents),
        slip_range_of_directions=_direction_ranges(settled, tolerances) if parts else None,
        accumulated_slip=settled.slip_per_cycle / settled.period if known else nothing,
        p_min=np.maximum(p.min(axis=0), 0.0) if known else nothing,
        p_max=np.maximum(p.max(axis=0), 0.0) if known else nothing,
        q_max=problem.law.size(q).max(axis=0) if known else nothing,
        q_max_of_directions=problem.layout.by_node(np.abs(q).max(axis=0)) if parts else None,
        work=settled.work_per_cycle,
        total_slip_bound=_total_slip_bound(settled),
        wear_coefficient=float(k),
        wear_volume=worn,
        slip_range_vector=None
        if axes is None
        else np.einsum("nd,ndk->nk", problem.layout.by_node(extents), axes),
        normal=normals_of(problem),
        faces=faces_of(problem),
    )


def _total_slip_bound(settled: Settled) -> FloatArray:
    """Bounds on the total slip of nodes from the start, all nodes closed (n,); NaN where not proved."""
    if not isinstance(settled, LongTermState) or settled.outcome != Outcome.SHAKEDOWN:
        return np.full(settled.problem.n, np.nan)
    begun = settled.begun
    if begun.open_nodes:
        return np.full(settled.problem.n, np.nan)
    return total_slip_bound(begun.problem, settled.load_factor, begun.start).total_slip


def settled_of(given: object, who: str = "node_results") -> Settled:
    """The settled state of a simulation, of a run of a verification, or itself."""
    simulation = getattr(given, "simulation", given)
    settled = getattr(simulation, "settled", simulation)
    if not isinstance(settled, LongTermState | SteppedState):
        expected = "a simulation, a long-term state or a run of a verification"
        raise UsageError(f"{who}: expected {expected}, found {type(given).__name__}")
    return settled


def slip_ranges(settled: Settled, tolerances: Tolerances) -> FloatArray:
    """The slip range of each node in contact within a period, (n,) [length]; 0 where it is never closed."""
    return settled.problem.law.size(slip_extents(settled, tolerances))


def slip_extents(settled: Settled, tolerances: Tolerances) -> FloatArray:
    """The slip range as the vector between the two extreme places, (dn,) [length]."""
    if not settled.period:
        return np.full(settled.problem.layout.slip_size, np.nan)
    if settled.problem.directions > 1:
        return _ways(settled, tolerances).ravel()
    path = settled.history
    closed = _closed(settled, path, tolerances)
    return _ranges(settled, path.v, closed, settled.drift)


def _closed(settled: Settled, path: EventHistory, tolerances: Tolerances) -> NDArray[np.bool_]:
    """Whether each node is in contact, (s, n)."""
    nothing = path_resolution(settled.problem, tolerances)
    return np.asarray(path.w <= nothing * length_scales(settled.problem, settled.load_factor))


def _ranges(settled: Settled, v: FloatArray, closed: NDArray[np.bool_], drift: FloatArray) -> FloatArray:
    """max v − min v of each node in contact within a period, (n,)."""
    low, high = np.where(closed, v, np.inf), np.where(closed, v, -np.inf)
    if settled.outcome != Outcome.RATCHETTING:
        found = high.max(axis=0) - low.min(axis=0)
    else:
        found = _widest(low, high, drift)
    return np.where(closed.any(axis=0), found, 0.0)


def _ways(settled: Settled, tolerances: Tolerances) -> FloatArray:
    """The vectors between the two slips farthest apart in a period, with two directions, (n, 2)."""
    path, layout = settled.history.refined(), settled.problem.layout
    closed = _closed(settled, path, tolerances)
    places, drift = layout.by_node(path.v), layout.by_node(settled.drift)
    ways = np.zeros((layout.n, 2))
    for node in np.flatnonzero(closed.any(axis=0)):
        time, where = np.flatnonzero(closed[:, node]), places[closed[:, node], node]
        if settled.outcome != Outcome.RATCHETTING:
            ways[node] = diameter(where)
            continue
        time = np.concatenate([time, time + len(closed) - 1])  # a window may extend beyond the end
        ways[node] = diameter_within(np.concatenate([where, where + drift[node]]), time, len(closed))
    return ways


def _direction_ranges(settled: Settled, tolerances: Tolerances) -> FloatArray:
    """The slip ranges of both directions, (n, 2)."""
    problem, path = settled.problem, settled.history.refined()
    parts, drift = problem.layout.by_node(path.v), problem.layout.by_node(settled.drift)
    closed = _closed(settled, path, tolerances)
    return np.stack([_ranges(settled, parts[..., k], closed, drift[:, k]) for k in range(2)], axis=1)


def _widest(low: FloatArray, high: FloatArray, drift: FloatArray) -> FloatArray:
    """The largest range within any window of one period, where slips (s, n) continue with the drift."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d  # imported late, as few joints ratchet

    s = len(low)
    window = {"size": s, "axis": 0, "mode": "nearest"}
    highest = maximum_filter1d(np.vstack([high, high[1:] + drift]), **window)
    lowest = minimum_filter1d(np.vstack([low, low[1:] + drift]), **window)
    return (highest - lowest)[s // 2 : s // 2 + s].max(axis=0)


def statuses(settled: Settled, tolerances: Tolerances) -> tuple[str, ...]:
    """Whether each node sticks, slips, is open or both over the period."""
    n = settled.problem.n
    words = np.full(n, STICKS if settled.period else NOT_KNOWN, dtype=object)
    if settled.period:
        none = 4 * path_resolution(settled.problem, tolerances)
        slips = settled.slip_per_cycle > none * length_scales(settled.problem, settled.load_factor)
        words[slips] = SLIPS
        words[_opened(settled)] = MIXED
    words[list(settled.open_nodes)] = STAYS_OPEN
    return tuple(words)


def _opened(settled: Settled) -> NDArray[np.bool_]:
    """Whether each node is open at some time of the period."""
    path = settled.history
    if isinstance(settled, LongTermState):
        return np.asarray((path.state[:-1] == OPEN)[np.diff(path.cycle) > 0].any(axis=0))
    return np.asarray((path.w > 0).any(axis=0))


def pressed_slip(settled: Settled) -> FloatArray:
    """∮ p |dv| per cycle, (n,) [force × length]: the work over f, since |q| = f p wherever a node slips."""
    path, law = settled.history.refined(), settled.problem.law
    if isinstance(settled, LongTermState):
        mean, slip = 0.5 * (path.p[1:] + path.p[:-1]), law.size(np.diff(path.v, axis=0))
        pressed = np.where(path.state[:-1] == OPEN, 0.0, mean * slip).sum(axis=0) / settled.period
    else:
        pressed = (path.p * np.abs(settled.step_slip)).sum(axis=0) / settled.period
    return np.where(law.f > 0, settled.work_per_cycle / np.where(law.f > 0, law.f, 1.0), pressed)


def diameter(places: FloatArray) -> FloatArray:
    """The way between the two of some places (k, 2) that lie farthest apart: corners of their convex hull.

    Examples
    --------
    >>> diameter(np.array([[0.0, 0.0], [3.0, 4.0], [1.0, 1.0], [0.0, 1.0]])).tolist()
    [3.0, 4.0]
    """
    return _farthest(corners := _hull(places), corners)


def diameter_within(places: FloatArray, time: NDArray[np.intp], window: int) -> FloatArray:
    """The same for points whose times, (k,) increasing, differ by less than a window.

    Where every pair of two blocks counts, only the corners of their hulls are compared.

    Examples
    --------
    >>> steady = np.column_stack([np.arange(9.0), np.zeros(9)])
    >>> diameter_within(steady, np.arange(9), 4).tolist()
    [3.0, 0.0]
    """
    blocks = [(places[k : k + BLOCK], time[k : k + BLOCK]) for k in range(0, len(places), BLOCK)]
    hulls = [_hull(own) for own, _ in blocks]
    found = [np.zeros(2)]
    for i, j in combinations_with_replacement(range(len(blocks)), 2):
        (one, first), (two, second) = blocks[i], blocks[j]
        if second[-1] - first[0] < window:
            found.append(_farthest(hulls[i], hulls[j]))
        elif second[0] - first[-1] < window:
            near = np.abs(second[None, :] - first[:, None]) < window
            found.append(_way(one, two, np.where(near, _apart(one, two), 0.0)))
    return _longest(found)


def _farthest(one: FloatArray, two: FloatArray) -> FloatArray:
    """The longest vector from a point of one set to one of another, in batches."""
    parts = (one[k : k + BLOCK] for k in range(0, len(one), BLOCK))
    return _longest([_way(part, two, _apart(part, two)) for part in parts])


def _way(one: FloatArray, two: FloatArray, apart: FloatArray) -> FloatArray:
    """The vector between the farthest points of two sets, by their distances."""
    i, j = np.unravel_index(apart.argmax(), apart.shape)
    return np.asarray(two[j] - one[i])


def _longest(ways: list[FloatArray]) -> FloatArray:
    return max(ways, key=lambda way: float(np.hypot(*way)))


def _apart(one: FloatArray, two: FloatArray) -> FloatArray:
    """Distances between points (k, 2) and (l, 2), (k, l)."""
    return np.asarray(np.hypot(*(one[:, None, :] - two[None, :, :]).transpose(2, 0, 1)))


def _hull(places: FloatArray) -> FloatArray:
    """Corners of the convex hull of points (k, 2), by Andrew's monotone chains."""
    ordered = np.unique(places, axis=0).tolist()
    return np.array([*_chain(ordered), *_chain(ordered[::-1])]).reshape(-1, 2)


def _chain(places: list[list[float]]) -> list[list[float]]:
    """The points at which a line around all of them turns left."""
    found: list[list[float]] = []
    for x, y in places:
        while len(found) > 1:
            (x0, y0), (x1, y1) = found[-2:]
            if (x1 - x0) * (y - y0) - (y1 - y0) * (x - x0) > 0:
                break
            found.pop()
        found.append([x, y])
    return found


MOST_INSTANTS = 500


@checked
def save_node_instants(
    simulation_or_state: object, path: str | os.PathLike[str], instants: int = 24
) -> tuple[Path, ...]:
    """Write the nodes at instants of a period: NAME_000.vtp, …, and NAME.pvd, which ParaView opens as one.

    Time is the phase, from 0 to 1 over the recorded period. At every point: ``cycle``, when that is, in
    cycles of the loading; names, ``normal`` and faces as :meth:`NodeResults.save` has them; ``status`` 0
    stick, 1 slip, 2 open; slip ``v`` and tangential reaction ``q``, vectors of three components along the
    axes of the model where the joint knows its tangents, else in x and y of the node; gap ``w`` and normal
    reaction ``p``. Units stand in brackets after the names.

    Parameters
    ----------
    simulation_or_state
        A long-term state, a simulation, or a run of a verification, from event to event.
    path
        NAME.vtp or NAME.vtu.
    instants
        How many, evenly over the recorded period, both ends among them (500 at most).

    Returns
    -------
    paths
        The files, that of all times first; all of them are written, or none.

    Raises
    ------
    UsageError
        If there is no such state or no steady period, the name has another ending, or a file cannot be
        written.

    Examples
    --------
    >>> import shakedown
    >>> state = shakedown.long_term_state(shakedown.example("four-node-3d"), 1.4)
    >>> [path.name for path in save_node_instants(state, "nodes.vtp", 2)]  # doctest: +SKIP
    ['nodes.pvd', 'nodes_000.vtp', 'nodes_001.vtp']
    """
    settled = settled_of(simulation_or_state, "save_node_instants")
    check_count("instants", instants, MOST_INSTANTS)
    history, problem = settled.history, settled.problem
    if not isinstance(settled, LongTermState) or not settled.period or len(history) < 2:
        raise UsageError("save_node_instants: expected a steady period from event to event, found none")
    times = np.linspace(max(float(history.cycle[0]), 0.0), float(history.cycle[-1]), instants)
    at = history.at(times)
    fixed = fixed_numbers(labels_of(problem), normals_of(problem))
    numbers = [fixed | _numbers(problem, at, row) for row in range(instants)]
    points, phase = points_of(coordinates_of(problem)), np.linspace(0.0, 1.0, instants)
    return write_points_series(path, points, phase.tolist(), numbers, faces_of(problem))


def _numbers(problem: Problem, at: EventHistory, row: int) -> dict[str, NDArray[np.generic]]:
    """The data written for one instant."""
    force, length = units_of(problem)
    return {
        "cycle": np.full(problem.n, at.cycle[row]),
        "status": np.abs(at.state[row]),
        with_unit("v", length): _in_space(problem, at.v[row]),
        with_unit("w", length): at.w[row],
        with_unit("q", force): _in_space(problem, at.q[row]),
        with_unit("p", force): at.p[row],
    }


def _in_space(problem: Problem, parts: FloatArray) -> FloatArray:
    """Slips or tangential reactions of the nodes, flat, as vectors (n, 3) of the model."""
    axes = axes_of(problem)
    if axes is None:
        axes = np.tile(np.eye(3)[: problem.directions], (problem.n, 1, 1))
    return np.asarray(np.einsum("nd,ndk->nk", problem.layout.by_node(parts), axes))
