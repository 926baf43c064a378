"""The results per node over a period, as a table and as files."""

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from shakedown.files.atomic_write import write_csv
from shakedown.files.vtk_points import write_points
from shakedown.ground.constants import LARGEST_LABEL, FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import plain, with_unit
from shakedown.ground.status import Outcome
from shakedown.joint.arguments import checked
from shakedown.joint.places import wound
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.units import Units

STATUSES = STICKS, SLIPS, STAYS_OPEN, MIXED, NOT_KNOWN = "stick", "slip", "open", "mixed", "undecided"
ENDINGS = (".csv", ".vtu", ".vtp")
TABLE = (
    "label", "x", "y", "z", "area", "status", "slip_range", "accumulated_slip",
    "p_min", "p_max", "q_max", "work", "tau_delta", "total_slip_bound",
)  # fmt: skip
TRACTIONS = ("pressure_min", "pressure_max", "shear_max", "work_per_area")
LONGEST_NUMBER = len(str(LARGEST_LABEL)) - 1  # digits of a label that can be written as an integer


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

    def to_dict(self) -> dict[str, Any]:
        """The words of ``DOCUMENT``, and with two tangential directions the components."""
        return super().to_dict() | {word: plain(values) for word, values in self._components().items()}

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
        if ending not in ENDINGS:
            raise UsageError(f"{path}: expected a name that ends in {', '.join(ENDINGS)}")
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
    if all(len(own) == len(names) and all(map(_is_whole, own)) for own in parts):
        numbers = np.array([list(map(int, own)) for own in parts])
        found |= dict(zip(names, numbers.T, strict=True))
    return found if normal is None else found | {"normal": normal}


def _is_whole(text: str) -> bool:
    return text.isascii() and text.isdigit() and len(text) <= LONGEST_NUMBER
