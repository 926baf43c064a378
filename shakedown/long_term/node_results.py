"""What the nodes of a simulation do, over the period and at its instants."""

import os
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
        slip_range_of_directions=problem.layout.by_node(_ranges(settled, tolerances)) if parts else None,
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
    unknown = not isinstance(settled, LongTermState) or settled.outcome != Outcome.SHAKEDOWN
    if unknown or settled.begun.open_nodes:  # type: ignore[union-attr]  # of a long-term state
        return np.full(settled.problem.n, np.nan)
    return total_slip_bound(settled.problem, settled.load_factor, settled.initial_slip).total_slip


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
    layout = settled.problem.layout
    if not settled.period:
        return np.full(layout.slip_size, np.nan)
    if layout.d == 1:
        return _ranges(settled, tolerances)
    path, drift = settled.history.refined(), layout.by_node(settled.drift)
    closed, places, ways = _closed(settled, path, tolerances), layout.by_node(path.v), np.zeros((layout.n, 2))
    for node in np.flatnonzero(closed.any(axis=0)):
        time, where = np.flatnonzero(closed[:, node]), places[closed[:, node], node]
        if settled.outcome != Outcome.RATCHETTING:
            ways[node] = farthest_apart(
                corners := corners_of_hull(where), np.full(len(corners), len(corners))
            )
            continue
        time = np.concatenate([time, time + len(closed) - 1])  # a window may extend beyond the end
        later = np.searchsorted(time, time + len(closed))
        ways[node] = farthest_apart(np.concatenate([where, where + drift[node]]), later)
    return ways.ravel()


def _closed(settled: Settled, path: EventHistory, tolerances: Tolerances) -> NDArray[np.bool_]:
    """Whether each node is in contact, (s, n)."""
    nothing = path_resolution(settled.problem, tolerances)
    return np.asarray(path.w <= nothing * length_scales(settled.problem, settled.load_factor))


def _ranges(settled: Settled, tolerances: Tolerances) -> FloatArray:
    """max v − min v of each slip in contact within a period, (dn,) [length]."""
    path = settled.history.refined()
    closed = np.repeat(_closed(settled, path, tolerances), settled.problem.directions, axis=1)
    low, high = np.where(closed, path.v, np.inf), np.where(closed, path.v, -np.inf)
    if settled.outcome != Outcome.RATCHETTING:
        found = high.max(axis=0) - low.min(axis=0)
    else:
        found = _widest(low, high, settled.drift)
    return np.where(closed.any(axis=0), found, 0.0)


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
        words[settled.opened] = MIXED
    words[list(settled.open_nodes)] = STAYS_OPEN
    return tuple(words)


def pressed_slip(settled: Settled) -> FloatArray:
    """∮ p |dv| per cycle, (n,) [force × length]: the work over f, since |q| = f p wherever a node slips."""
    path, law = settled.history.refined(), settled.problem.law
    if isinstance(settled, LongTermState):
        mean, slip = 0.5 * (path.p[1:] + path.p[:-1]), law.size(np.diff(path.v, axis=0))
        pressed = np.where(path.state[:-1] == OPEN, 0.0, mean * slip).sum(axis=0) / settled.period
    else:
        pressed = (path.p * np.abs(settled.step_slip)).sum(axis=0) / settled.period
    return np.where(law.f > 0, settled.work_per_cycle / np.where(law.f > 0, law.f, 1.0), pressed)


def farthest_apart(places: FloatArray, later: NDArray[np.intp]) -> FloatArray:
    """The way between the two of some places (k, 2) that lie farthest apart.

    Each is compared with those after it up to a number, (k,).

    Examples
    --------
    >>> corners = np.array([[0.0, 0.0], [3.0, 4.0], [1.0, 1.0], [0.0, 1.0]])
    >>> [farthest_apart(corners, np.array(later)).tolist() for later in ([4, 4, 4, 4], [1, 3, 4, 4])]
    [[3.0, 4.0], [-2.0, -3.0]]
    """
    longest, number, chunk = np.zeros(2), np.arange(len(places)), 64  # at a time, as memory is to stay small
    for first in range(0, len(places), chunk):
        own, other = number[first : first + chunk, None], number[first : later[first : first + chunk].max()]
        ways = places[other] - places[own]
        sizes = ((own <= other) & (other < later[own])) * np.einsum("jkd,jkd->jk", ways, ways)
        if sizes.max() > longest @ longest:
            longest = ways[np.unravel_index(sizes.argmax(), sizes.shape)]
    return longest


def corners_of_hull(places: FloatArray) -> FloatArray:
    """Corners of the convex hull of points (k, 2); both ends where they lie on a line."""
    from scipy.spatial import ConvexHull, QhullError  # imported late, as it is only needed in space

    scaled = places - places[0]
    scaled /= np.abs(scaled).max() or 1.0
    try:
        return np.asarray(places[ConvexHull(scaled).vertices])
    except QhullError:
        along = scaled @ scaled[np.abs(scaled).sum(axis=1).argmax()]
        return np.array([places[along.argmin()], places[along.argmax()]])


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
