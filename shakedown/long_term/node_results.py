"""What the nodes of a simulation do, over the period and at its instants, as a table and as files."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.accumulated_bound import total_slip_bound
from shakedown.files.atomic_write import write_csv
from shakedown.files.vtk_points import write_points, write_points_series
from shakedown.ground.argument_kinds import check_count
from shakedown.ground.constants import LARGEST_LABEL, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import plain, with_unit
from shakedown.ground.status import OPEN, Outcome
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, is_finite
from shakedown.joint.places import corners_of_hull, wound
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import Units, units_of
from shakedown.long_term.rigid_drift import RigidDrift
from shakedown.long_term.state import LongTermState, SteppedState
from shakedown.motion.checked_law import least_slip, length_scales, path_resolution
from shakedown.motion.event_history import EventHistory

STATUSES = STICKS, SLIPS, STAYS_OPEN, MIXED, NOT_KNOWN = "stick", "slip", "open", "mixed", "undecided"
TABLE = (
    "label", "x", "y", "z", "area", "status", "slip_range", "accumulated_slip",
    "p_min", "p_max", "q_max", "work", "tau_delta", "total_slip_bound",
)  # fmt: skip
TRACTIONS = ("pressure_min", "pressure_max", "shear_max", "work_per_area")


@dataclass(frozen=True, eq=False, repr=False)
class NodeResults(Result):
    """Result of :func:`node_results`: arrays with one entry per node, all over one period of P cycles.

    "In contact" are the instants at which the gap is nil. With T the length of the period:

    Attributes
    ----------
    load_factor, outcome, reason, period
        Load factor and long-term state; P = ``period`` cycles, 0 where there is none.
    force_unit, length_unit
        As the joint names them; empty where it names none.
    label : (n,)
        What the node is called in the model; its number where it has no name there.
    coordinates : (n, 3)
        Where it is [length]; NaN where that is not known, of a joint with ``x`` only (x, NaN, NaN).
    area : (n,)
        The contact area that it stands for [length²]; NaN where that is not known.
    status : (n,)
        "stick": closed throughout and without slip; "slip": closed throughout, with slip; "open":
        open throughout; "mixed": open at times; "undecided" where there is no long-term state.
    slip_range : (n,)
        max |v(t₂) − v(t₁)| over instants in contact with |t₂ − t₁| ≤ T [length]: max v − min v where
        nothing ratchets, with two directions the diameter of the orbit. The same as double amplitude, or
        stroke.
    accumulated_slip : (n,)
        Σ|Δv| in contact per cycle, over P cycles and divided by P [length].
    p_min, p_max : (n,)
        Smallest and largest normal reaction [force]; 0 at open nodes.
    q_max : (n,)
        max |q| [force].
    pressure_min, pressure_max, shear_max : (n,)
        The same over the area [force/length²]; NaN where the node has none.
    slip_range_of_directions, q_max_of_directions : (n, 2) or None
        With two tangential directions: the range of either component of the slip, max − min [length], and
        the largest size of either component of q [force]; columns of files end in ``_x`` and ``_y``.
    slip_range_vector : (n, 3) or None
        From one to the other of the two places that are ``slip_range`` apart, along x, y, z of the model
        [length], where the joint knows its tangents; either sign of it says the same.
    normal : (n, 3) or None
        Unit vectors into the first body, where they are known.
    faces : (k, 4) or None
        Corners of the faces of the contact, as of the problem, where their places are known.
    work : (n,)
        Friction work per cycle, −∮ q dv / P in contact, jumps included [force × length].
    work_per_area : (n,)
        The same over the area [force/length].
    tau_delta : (n,)
        τ δ = shear_max × slip_range [force/length], the first parameter of Ruiz, Boddington and Chen
        (Experimental Mechanics 24, 1984, 208–217): the product of the largest shear traction and
        the slip range of the node, which need not occur at one instant.
    total_slip_bound : (n,)
        How far each node slips in all at most, from the initial state until it rests for ever, whatever the
        order of the loads [length]: proved (docs/accumulated.md); NaN where that is not proved.
    wear_coefficient
        k of Archard's law [length²/force], NaN where it was not given.
    wear_volume : (n,)
        k ∮ p |dv| / P per cycle [length³], of both surfaces together (Archard, J. Appl. Phys. 24, 1953,
        981–988), with the pressures of the unworn joint; NaN where k was not given.
    wear_depth : (n,)
        The same over the area [length].
    rigid_drift : RigidDrift or None
        How the first body turns and shifts per cycle, where it drifts as a rigid body.
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor outcome reason period label coordinates area status slip_range accumulated_slip "
        "p_min p_max q_max pressure_min pressure_max shear_max work work_per_area tau_delta "
        "total_slip_bound wear_coefficient wear_depth"
    )
    TABLE: ClassVar[str] = " ".join((*TABLE, *TRACTIONS, "wear_depth"))

    load_factor: float
    outcome: Outcome
    reason: str
    period: int
    force_unit: str
    length_unit: str
    label: tuple[str, ...]
    coordinates: FloatArray
    area: FloatArray
    status: tuple[str, ...]
    slip_range: FloatArray
    accumulated_slip: FloatArray
    p_min: FloatArray
    p_max: FloatArray
    q_max: FloatArray
    work: FloatArray
    total_slip_bound: FloatArray
    wear_coefficient: float
    wear_volume: FloatArray
    slip_range_of_directions: FloatArray | None = None
    q_max_of_directions: FloatArray | None = None
    slip_range_vector: FloatArray | None = None
    normal: FloatArray | None = None
    faces: NDArray[np.intp] | None = None
    rigid_drift: RigidDrift | None = None

    def to_dict(self) -> dict[str, Any]:
        """The words of ``DOCUMENT``; with two tangential directions the components; a rigid drift."""
        more = {} if self.rigid_drift is None else {"rigid_drift": self.rigid_drift.to_dict()}
        return super().to_dict() | {word: plain(part) for word, part in self._components().items()} | more

    def _components(self) -> dict[str, FloatArray]:
        """The components in both directions, by column."""
        both = {"slip_range": self.slip_range_of_directions, "q_max": self.q_max_of_directions}
        return {
            f"{word}_{axis}": values[:, k]
            for word, values in both.items() if values is not None
            for k, axis in enumerate("xy")
        }  # fmt: skip

    @property
    def x(self) -> FloatArray:
        """First coordinate, (n,) [length]."""
        return self.coordinates[:, 0]

    @property
    def y(self) -> FloatArray:
        """Second coordinate, (n,) [length]."""
        return self.coordinates[:, 1]

    @property
    def z(self) -> FloatArray:
        """Third coordinate, (n,) [length]."""
        return self.coordinates[:, 2]

    @property
    def pressure_min(self) -> FloatArray:
        """p_min over the area, (n,) [force/length²]."""
        return self._per_area(self.p_min)

    @property
    def pressure_max(self) -> FloatArray:
        """p_max over the area, (n,) [force/length²]."""
        return self._per_area(self.p_max)

    @property
    def shear_max(self) -> FloatArray:
        """q_max over the area, (n,) [force/length²]."""
        return self._per_area(self.q_max)

    @property
    def work_per_area(self) -> FloatArray:
        """Friction work per cycle over the area, (n,) [force/length]."""
        return self._per_area(self.work)

    @property
    def tau_delta(self) -> FloatArray:
        """Largest shear traction times slip range, (n,) [force/length]."""
        return self.shear_max * self.slip_range

    @property
    def wear_depth(self) -> FloatArray:
        """Archard's wear depth per cycle, (n,) [length]."""
        return self._per_area(self.wear_volume)

    @property
    def units(self) -> dict[str, str]:
        """The unit of every column of a file, in characters that every program shows; empty where unknown."""
        force, length = known = Units(self.force_unit, self.length_unit)
        stress = known.stress.replace("²", "^2")
        slips = ("slip_range", "slip_range_x", "slip_range_y", "accumulated_slip", "total_slip_bound")
        lengths = dict.fromkeys(("x", "y", "z", *slips, "wear_depth"), length)
        forces = dict.fromkeys(("p_min", "p_max", "q_max", "q_max_x", "q_max_y"), force)
        stresses = dict.fromkeys(("pressure_min", "pressure_max", "shear_max"), stress)
        per_area = dict.fromkeys(("work_per_area", "tau_delta"), known.stiffness)
        area = {"area": known.area.replace("²", "^2"), "work": known.work}
        return lengths | forces | stresses | per_area | area

    @checked
    def save(self, path: str | os.PathLike[str], *, tractions: bool = False) -> None:
        """Write one row per node to a table (.csv) or one point per node to a VTK file (.vtu, .vtp).

        Units stand in brackets after the names. A table has ``label`` to ``tau_delta``, with
        ``tractions`` also those and the work per area, and with a wear coefficient the wear depth. A
        VTK file has all of these as numbers at points, for ParaView: ``node`` from 0, ``label`` where
        all labels are whole numbers, ``node_1`` and ``node_2`` where all are pairs of them (12/7),
        ``status`` 0 stick, 1 slip, 2 open, 3 mixed, 4 undecided; and as far as they are known the faces,
        ``normal`` and ``slip_range_vector``. Where a coordinate is not known its points are at 0; where
        none is, nodes stand in a row.

        Raises
        ------
        UsageError
            If the name ends in none of these, or the file cannot be written.

        Examples
        --------
        >>> import shakedown
        >>> nodes = shakedown.node_results(shakedown.long_term_state(shakedown.example("two-node"), 0.9))
        >>> nodes.save("nodes.csv")  # doctest: +SKIP
        """
        ending = Path(path).suffix.lower()
        if ending not in (".csv", ".vtu", ".vtp"):
            raise UsageError(f"{path}: expected a name that ends in .csv, .vtu, .vtp")
        more = TRACTIONS if tractions or ending != ".csv" else ()
        worn = () if np.isnan(self.wear_coefficient) else ("wear_depth",)
        found = {word: getattr(self, word) for word in (*TABLE, *more, *worn)} | self._components()
        columns = {with_unit(word, self.units.get(word, "")): values for word, values in found.items()}
        if ending == ".csv":
            write_csv(path, {word: list(column) for word, column in columns.items()})
        else:
            write_points(path, points_of(self.coordinates), self._numbers(columns), self.faces)

    def _numbers(self, columns: dict[str, Any]) -> dict[str, NDArray[np.generic]]:
        """Columns as data at points, with directions in space where known; the status as a number."""
        label, status = columns.pop("label"), columns.pop("status")
        found = fixed_numbers(label, self.normal) | {"status": np.array(list(map(STATUSES.index, status)))}
        if self.slip_range_vector is not None:
            found[with_unit("slip_range_vector", self.length_unit)] = self.slip_range_vector
        return found | columns

    def _per_area(self, values: FloatArray) -> FloatArray:
        """Values over the area; NaN where a node has none, or a negligible one."""
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            found = values / self.area
        return np.where(np.isfinite(found), found, np.nan)


def labels_of(problem: Problem) -> tuple[str, ...]:
    """The name of each node in the model; its number where it has none."""
    return problem.label or tuple(map(str, range(problem.n)))


def coordinates_of(problem: Problem) -> FloatArray:
    """Where the nodes are, (n, 3); only x where the joint knows no more."""
    if problem.coordinates is not None:
        return problem.coordinates
    places = np.full((problem.n, 3), np.nan)
    if problem.x is not None:
        known = problem.x.reshape(problem.n, -1)  # one, two or three coordinates
        places[:, : known.shape[1]] = known
    return places


def points_of(coordinates: FloatArray) -> FloatArray:
    """Where nodes are drawn, (n, 3) [length]: in a row where their places are unknown."""
    points = coordinates.copy()
    if np.isnan(points).all():
        points[:, 0] = np.arange(len(points))
    return np.nan_to_num(points)


def faces_of(problem: Problem) -> NDArray[np.intp] | None:
    """The faces (k, 4), around the normals where known; None where corners have no place."""
    places, normals = coordinates_of(problem), normals_of(problem)
    if problem.faces is None or not np.isfinite(places[:, :2]).all():
        return None
    return problem.faces if normals is None else wound(problem.faces, np.nan_to_num(places), normals)


def axes_of(problem: Problem) -> FloatArray | None:
    """The directions of slip in the model, (n, d, 3), where they are known."""
    if problem.directions == 2:
        return problem.tangents
    return None if problem.tangent is None else problem.tangent[:, None]


def normals_of(problem: Problem) -> FloatArray | None:
    """Unit vectors into the first body, (n, 3): given, or from both tangents, t₁ × t₂."""
    if problem.normal is None and problem.tangents is not None:
        return np.cross(problem.tangents[:, 0], problem.tangents[:, 1])
    return problem.normal


def fixed_numbers(label: Sequence[str], normal: FloatArray | None) -> dict[str, NDArray[np.generic]]:
    """Numbers at points that no load changes: ``node``, names as far as they are numbers, normals.

    Examples
    --------
    >>> {name: values.tolist() for name, values in fixed_numbers(["12/3", "7/41"], None).items()}
    {'node': [0, 1], 'node_1': [12, 7], 'node_2': [3, 41]}
    """
    found: dict[str, NDArray[np.generic]] = {"node": np.arange(len(label))}
    parts = [text.split("/") for text in label]
    names = {1: ("label",), 2: ("node_1", "node_2")}.get(len(parts[0]), ())
    longest = len(str(LARGEST_LABEL)) - 1  # digits of a label that can be written as an integer
    whole = (text.isascii() and text.isdigit() and len(text) <= longest for own in parts for text in own)
    if all(len(own) == len(names) for own in parts) and all(whole):
        numbers = np.array([list(map(int, own)) for own in parts])
        found |= dict(zip(names, numbers.T, strict=True))
    return found if normal is None else found | {"normal": normal}


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
    (force, length), nothing = units_of(problem), np.full(problem.n, np.nan)
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
        slip_range_vector=None if axes is None else _in_space(problem, extents),
        normal=normals_of(problem),
        faces=faces_of(problem),
        rigid_drift=settled.rigid_drift,
    )


def _total_slip_bound(settled: Settled) -> FloatArray:
    """Bounds on the total slip of nodes from the start, all nodes closed (n,); NaN where not proved."""
    unknown = not isinstance(settled, LongTermState) or settled.outcome != Outcome.SHAKEDOWN
    if unknown or settled.origin.open_nodes:  # type: ignore[union-attr]  # of a long-term state
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


def slip_extents(settled: Settled, tolerances: Tolerances) -> FloatArray:
    """The slip range of each node in contact within a period, as the vector between the two extreme places.

    (dn,) [length]; 0 where a node is never closed.
    """
    layout = settled.problem.layout
    if not settled.period:
        return np.full(layout.slip_size, np.nan)
    if layout.d == 1:
        return _ranges(settled, tolerances)
    path, drift = settled.history.refined(), layout.by_node(settled.drift)
    closed, places, extents = (
        _closed(settled, path, tolerances),
        layout.by_node(path.v),
        np.zeros((layout.n, 2)),
    )
    for node in np.flatnonzero(closed.any(axis=0)):
        time, where = np.flatnonzero(closed[:, node]), places[closed[:, node], node]
        if settled.outcome != Outcome.RATCHETTING:
            extents[node] = farthest_apart(
                corners := corners_of_hull(where), np.full(len(corners), len(corners))
            )
            continue
        time = np.concatenate([time, time + len(closed) - 1])  # a window may extend beyond the end
        later = np.searchsorted(time, time + len(closed))
        extents[node] = farthest_apart(np.concatenate([where, where + drift[node]]), later)
    return extents.ravel()


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

    window = {"size": len(low), "axis": 0, "mode": "nearest"}  # those that the ends cut off are in others
    highest = maximum_filter1d(np.vstack([high, high[1:] + drift]), **window)
    lowest = minimum_filter1d(np.vstack([low, low[1:] + drift]), **window)
    return (highest - lowest).max(axis=0)


def statuses(settled: Settled, tolerances: Tolerances) -> tuple[str, ...]:
    """Whether each node sticks, slips, is open or both over the period."""
    words = np.full(settled.problem.n, STICKS if settled.period else NOT_KNOWN, dtype=object)
    if settled.period:
        none = least_slip(settled.problem, tolerances)
        words[settled.slip_per_cycle > none * length_scales(settled.problem, settled.load_factor)] = SLIPS
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
    """The vector between the two of some places (k, 2) that lie farthest apart.

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
        apart = places[other] - places[own]
        sizes = ((own <= other) & (other < later[own])) * np.einsum("jkd,jkd->jk", apart, apart)
        if sizes.max() > longest @ longest:
            longest = apart[np.unravel_index(sizes.argmax(), sizes.shape)]
    return longest


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
    check_count("instants", instants, 500)
    history, problem = settled.history, settled.problem
    if not isinstance(settled, LongTermState) or not settled.period:
        raise UsageError("save_node_instants: expected a steady period from event to event, found none")
    times = np.linspace(max(float(history.cycle[0]), 0.0), float(history.cycle[-1]), instants)
    at = history.without_round_off(problem).at(times)
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
