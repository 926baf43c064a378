"""The limits of the load factor over one or two parameters of a joint, and the regions between them."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property, partial
from itertools import product
from math import inf, nan
from os import PathLike
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.bounds.registry import BOUNDS, Claim, kinds_of
from shakedown.files.atomic_write import check_table, write_table
from shakedown.files.pieces import Arrays, Progress, as_text, function_stamp, run_pieces, text_of
from shakedown.ground.constants import FloatArray, Mask
from shakedown.ground.errors import ShakedownError, UsageError
from shakedown.ground.shown_values import plain, shortened, with_unit
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked, checked_initial_slip, real_array
from shakedown.joint.contact_zone import contact_zone
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result, frame
from shakedown.long_term.simulation import check_slip_below
from shakedown.models.importing.import_model import Import
from shakedown.studies.design_point import FACTORS, Variation, checked_variation, design_point, no_point

if TYPE_CHECKING:
    from pandas import DataFrame


class Region(StrEnum):
    """The region of a load factor of a joint.

    EVERY_STATE
        Shakedown is proved from every initial state: λ < λ_U.
    THIS_STATE
        Shakedown is proved from the state asked about: below the largest limit that proves it.
    DEPENDS
        It depends on the state, or is open.
    NEVER
        With all nodes in contact there is no shakedown: λ > λ_max.
    NO_JOINT
        The parameters make no joint.
    """

    EVERY_STATE = "proved from every state"
    THIS_STATE = "proved from this state"
    DEPENDS = "depends on the state"
    NEVER = "never"
    NO_JOINT = "no joint"


class Boundaries(NamedTuple):
    """Load factors at which one region ends and the next begins, one per point.

    Attributes
    ----------
    every
        Below it shakedown is proved from every state; 0 where nothing is.
    this
        Below it shakedown is proved from this state; not less than ``every``.
    never
        Above it there is no shakedown with all nodes in contact; inf where that is not known.
    """

    every: FloatArray
    this: FloatArray
    never: FloatArray


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Result):
    """Result of :func:`sweep`: the limits of the load factor over a grid of one or two parameters.

    The load factors of a limit are the attribute of its name in ``BOUNDS``: ``lower`` (λ_1), ``universal``
    (λ_U), ``energy`` (λ_E), ``accumulated`` (λ_S), ``transient`` (λ_T), ``creep`` (λ_c), ``upper``
    (λ_max).

    Arrays have one axis per parameter, in the order of ``parameters``. NaN stands for a limit
    that does not exist, is not known or was not asked for, inf for one at infinity;
    ``status`` tells which.

    Attributes
    ----------
    name
        Name of the joint.
    parameters
        Names of the parameters.
    meanings
        Which parameter of :func:`with_parameter` each one is; empty for a number of a
        configuration, and for a function's own.
    units
        Their units; empty where these are not known.
    values
        Their values, one rising array each.
    bounds
        Names of the limits that were asked for.
    points
        The record of every combination, the last parameter running fastest: what
        :func:`~shakedown.studies.design_point.design_point` says.
    """

    name: str
    parameters: tuple[str, ...]
    meanings: tuple[str, ...]
    units: tuple[str, ...]
    values: tuple[FloatArray, ...]
    bounds: tuple[str, ...]
    points: tuple[dict[str, Any], ...] = field(repr=False)

    def __repr__(self) -> str:
        grid = " x ".join(
            f"{name} = {v[0]:g} … {v[-1]:g} ({len(v)})" if len(v) > 1 else f"{name} = {v[0]:g}"
            for name, v in zip(self.parameters, self.values, strict=True)
        )
        return f"Sweep({self.name or 'unnamed problem'!r}, {grid}, bounds={', '.join(self.bounds)})"

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each parameter."""
        return tuple(len(values) for values in self.values)

    def is_factor(self, axis: int) -> bool:
        """Whether a parameter is a factor on a quantity of the joint."""
        return self.meanings[axis] in FACTORS

    def __getattr__(self, name: str) -> FloatArray:
        """The load factors of a limit by its name in ``BOUNDS``."""
        if name not in BOUNDS:
            raise AttributeError(f"a sweep has no {name!r}")
        return self.load_factors(name)

    @cached_property
    def from_this_state(self) -> FloatArray:
        """The largest limit proved from this state, as ``assess`` has it; NaN where none was asked for."""
        return self._grid("proved_from_this_state")

    @property
    def guarantee(self) -> NDArray[np.str_]:
        """Whether λ_1 is a guarantee: ``"proved"``, ``"evidence"`` or empty."""
        return self._grid("guarantee")

    @property
    def contradictions(self) -> tuple[str, ...]:
        """Every contradiction between limits, with the values of the parameters."""
        return tuple(
            f"{', '.join(f'{name} = {value:g}' for name, value in point['values'].items())}: {text}"
            for point in self.points
            for text in point["contradictions"]
        )

    def load_factors(self, name: str) -> FloatArray:
        """The load factors of a limit by its name; NaN where there is none."""
        return self._of_limits(name, "load_factor", nan)

    @cached_property
    def in_zone(self) -> Mask:
        """Where nodes are open in the state that λ_max and λ_E belong to: they are those of a zone."""
        return self._entries([bool(point["open_nodes"]) for point in self.points])

    def of_joint(self, name: str) -> FloatArray:
        """The same, but NaN for the λ_max of a zone, which excludes nothing of the whole joint."""
        hidden = self.in_zone & (BOUNDS[name].claim == Claim.IMPOSSIBLE)
        return np.where(hidden, nan, self.load_factors(name))

    def status(self, name: str) -> NDArray[np.str_]:
        """How each load factor of a limit was found (:class:`Status`); ``"no joint"`` where there is none."""
        return self._of_limits(name, "status", Region.NO_JOINT).astype(np.str_)

    def _of_limits(self, name: str, word: str, none: Any) -> NDArray[Any]:
        """What every point says of a limit."""
        if name not in BOUNDS:
            raise UsageError(f"limit: expected one of {', '.join(BOUNDS)}, found {shortened(repr(name))}")
        return self._entries([point.get(name, {}).get(word, none) for point in self.points])

    @cached_property
    def boundaries(self) -> Boundaries:
        """Where the regions of the load factor meet; NaN where there is no joint.

        Nothing is concluded from a limit with conditions (proved only from some load factor on, or
        for a joint that is partly open).
        """
        joints = np.where(self._grid("exists"), 0.0, nan)
        proved = np.isin(self.status("universal"), (Status.OPTIMAL, Status.UNBOUNDED))
        every = joints + np.where(proved, self.universal, 0.0)
        this = joints + np.nan_to_num(self.from_this_state, posinf=inf)
        nowhere = ~self.in_zone & (self.status("upper") == Status.INFEASIBLE)
        never = joints + np.where(nowhere, 0.0, np.nan_to_num(self.of_joint("upper"), nan=inf, posinf=inf))
        return Boundaries(every, np.maximum(every, this), never)

    def regions(self, load_factor: float) -> NDArray[np.str_]:
        """The :class:`Region` that a load factor lies in, at every point of the grid.

        Raises ``UsageError`` unless the load factor is a finite number ≥ 0.
        """
        check_load_factor(load_factor)
        every, this, never = self.boundaries
        cases = {
            Region.NO_JOINT: np.isnan(every),
            Region.EVERY_STATE: load_factor < every,
            Region.THIS_STATE: load_factor < this,
            Region.NEVER: load_factor > never,
        }
        return np.select(list(cases.values()), [str(case) for case in cases], str(Region.DEPENDS))

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain numbers, texts and lists."""
        pairs = zip(self.parameters, self.values, strict=True)
        document = {
            "name": self.name,
            "parameters": [{"name": name, "values": values} for name, values in pairs],
            "bounds": self.bounds,
            "points": [
                {name: value for name, value in point.items() if name != "contradictions"}
                for point in self.points
            ],
            "contradictions": self.contradictions,
        }
        return {word: plain(value) for word, value in document.items()}

    def columns(self) -> dict[str, list[Any]]:
        """What a table of the points holds: heading, with unit, → one entry per point."""
        return {with_unit(name, unit): values for name, unit, values in self._columns()}

    def to_frame(self, problem: Problem | None = None) -> "DataFrame":
        """The points as a table of pandas: names alone over the columns, their units in ``attrs["units"]``.

        Raises
        ------
        UsageError
            If pandas is not installed.

        Examples
        --------
        >>> import shakedown
        >>> found = shakedown.sweep(shakedown.example("two-node"), {"f": [0.3, 0.4]}, bounds=["upper"])
        >>> table = found.to_frame()
        >>> list(table)[:2], table.attrs["units"]
        (['f', 'lambda_max'], {'f': '1', 'lambda_max': '1'})
        """
        table = frame({name: values for name, _, values in self._columns()})
        table.attrs["units"] = {name: unit for name, unit, _ in self._columns() if unit}
        return table

    def save(self, path: str | PathLike[str]) -> None:
        """Write one row per point: CSV in full precision, or Parquet where the name ends in .parquet.

        Raises
        ------
        UsageError
            If the file cannot be written, its name ends in neither, or Parquet is asked for
            where pandas or pyarrow is missing.
        """
        write_table(path, self.columns())

    def _grid(self, word: str) -> NDArray[Any]:
        """What every point says under one key, on the grid."""
        return self._entries([point[word] for point in self.points])

    def _entries(self, entries: list[Any]) -> NDArray[Any]:
        return np.array(entries).reshape(self.shape)

    def _columns(self) -> Iterator[tuple[str, str, list[Any]]]:
        """Name, unit and entries of each column."""
        points = self.points
        for name, unit in zip(self.parameters, self.units, strict=True):
            yield name, unit, [point["values"][name] for point in points]
        for name in self.bounds:
            symbol = BOUNDS[name].symbol.replace("λ", "lambda")
            yield symbol, "1", self.load_factors(name).ravel().tolist()
            if name == "transient":
                for heading, end in (("proved", "low"), ("cycling", "high")):
                    yield f"{symbol}_{heading}", "1", self._of_limits(name, end, nan).ravel().tolist()
            if name == "creep":
                yield f"{symbol}_proved", "1", self._of_limits(name, "low", nan).ravel().tolist()
            yield f"{symbol}_status", "", self.status(name).ravel().tolist()
            if name == "lower":
                yield "guarantee", "", [point["guarantee"] for point in points]
        if {*self.bounds} & {kind.name for kind in kinds_of(Claim.THIS_STATE)}:
            yield "proved_from_this_state", "1", [point["proved_from_this_state"] for point in points]
        if any("slip_criterion" in point for point in points):
            known = [point.get("slip_criterion", {}) for point in points]
            yield "lambda_slip", "1", [slips.get("load_factor", nan) for slips in known]
            yield "largest_slip_range", "", [slips.get("largest", nan) for slips in known]
        yield "open_nodes", "", [" ".join(map(str, point["open_nodes"])) for point in points]
        yield "remark", "", ["; ".join(self._remarks(point)) for point in points]

    def _remarks(self, point: dict[str, Any]) -> Iterator[str]:
        """Remarks on a point besides its numbers."""
        if point["reason"]:
            yield point["reason"]
        for name in self.bounds:
            limit = point.get(name, {"remark": ""})
            if limit["remark"] and limit["status"] != Status.OPTIMAL:
                yield f"{BOUNDS[name].symbol}: {limit['remark']}"
        yield from point["contradictions"]


@checked
def sweep(
    joint: Problem | Import | Callable[..., Problem],
    vary: Mapping[str, ArrayLike],
    *,
    bounds: Sequence[str] | None = None,
    initial_slip: ArrayLike | None = None,
    open_nodes: Iterable[int] | Literal["auto"] = "auto",
    quick: bool = False,
    slip_below: float | None = None,
    executor: Executor | None = None,
    workers: int | None = 1,
    output: str | PathLike[str] | None = None,
    resume: bool = False,
    progress: Progress | None = None,
    tolerances: Tolerances = DEFAULT,
) -> Sweep:
    """Compute the limits of the load factor over one or two parameters of a joint.

    Every point is checked for contradictions between its limits (λ_U ≤ λ_1 ≤ λ_max, λ_E and
    λ_S ≤ λ_max, no cycle below a proved limit). Where the parameters make no joint the point says why.

    Parameters
    ----------
    joint
        A joint, of which named parameters are varied (:func:`with_parameter`). If it is from
        :func:`import_model`, every number of its configuration is a parameter too, named by its
        dotted key, with tables and entries of lists counted from 1
        (``"load.2.history.harmonics.1.sin"``), and so is every constant load, by its name and in
        its unit (``"bolt preload"``); there ``"friction.factor"`` is the factor on the friction and
        ``"f"`` the coefficient. Or a function of one or two parameters that returns a joint; its
        parameters may have any names in ``vary``.
    vary
        Name → rising values, for one or two parameters.
    bounds
        Which limits: ``"lower"`` (λ_1), ``"universal"`` (λ_U), ``"energy"`` (λ_E),
        ``"accumulated"`` (λ_S, the :func:`accumulated_bound`),
        ``"transient"`` (λ_T), ``"creep"`` (λ_c), ``"upper"`` (λ_max); by default all that the joint has
        but λ_c: with two tangential directions λ_U, λ_E, λ_S, λ_T and λ_max.
    initial_slip : (n,), optional
        The state that λ_E, λ_S and λ_T are about [length]; zero by default.
    open_nodes
        The nodes that stay open, for λ_max and λ_E; ``"auto"``: those of the best zone found.
    quick
        Whether λ_T is computed to 0.1 % only, which is faster.
    slip_below
        A limit on the slip range of every node in the long run [length]. The load factor up to which it holds
        from the given state is found as well (:class:`~shakedown.assessment.transient_limit.SlipLimit`).
    executor
        What runs the computations: any :class:`concurrent.futures.Executor`, as of threads, loky, MPI or
        ``dask.distributed.Client(…).get_executor()``. It is not shut down.
    workers
        Without an executor the number of processes, None one for each core; a function that makes joints has
        to be one that can be imported, and a script to keep the call under ``if __name__ == "__main__":``.
    output
        Where to write the table (:meth:`Sweep.save`). Until it is written every point is kept, as soon as it
        is known, in a file of its own in ``OUTPUT.parts``.
    resume
        Whether to go on with the points that a stopped run has left there.
    progress
        Called with (points done, points in all).
    tolerances
        What decides (:class:`Tolerances`).

    Raises
    ------
    UsageError
        If an argument is out of range, a joint has no such limit, or a function returns no problem.
    BudgetExceeded
        If there are more than a million points.
    SolverError
        If a worker dies.

    Examples
    --------
    >>> import shakedown
    >>> found = sweep(shakedown.example("two-node"), {"f": [0.2, 0.35]}, bounds=["lower", "upper"])
    >>> found.lower.round(4), found.upper.round(4)
    (array([0.4044, 0.6574]), array([0.4262, 0.7391]))
    >>> found.regions(0.5).tolist()
    ['never', 'depends on the state']
    """
    variation, values = checked_variation(joint, vary)
    asked: dict[str, Any] = {
        "bounds": _checked_bounds(bounds, variation.base),
        "initial_slip": None if initial_slip is None else real_array("initial slip", initial_slip),
        "open_nodes": open_nodes if isinstance(open_nodes, str) else tuple(open_nodes),
        "quick": bool(quick),
        "slip_below": None if slip_below is None else check_slip_below(slip_below),
        "tolerances": tolerances,
    }
    if variation.base is not None:
        checked_initial_slip(variation.base, asked["initial_slip"])
        contact_zone(variation.base, () if open_nodes == "auto" else asked["open_nodes"])
    if output is not None:
        check_table(output)
    places = list(product(*(array.tolist() for array in values)))  # the last parameter runs fastest
    settings = asked | {"initial_slip": plain(asked["initial_slip"])}  # in full, however many nodes
    run: dict[str, Any] = {"executor": executor, "workers": workers, "progress": progress}
    run |= {"settings": (_stamp(variation, places[0]), variation.parameters, places, settings)}
    run |= {"output": output, "resume": resume}
    with run_pieces(partial(_point, variation, places, asked), len(places), **run) as pieces:
        about = variation.name, variation.parameters, variation.meanings, variation.units
        points = tuple(text_of(piece) for piece in pieces)
        found = Sweep(*about, values, asked["bounds"], points)
        if output is not None:
            found.save(output)
    return found


def _point(
    variation: Variation, places: Sequence[tuple[float, ...]], asked: dict[str, Any], number: int
) -> Arrays:
    """A point of a sweep, as text."""
    values = dict(zip(variation.parameters, places[number], strict=True))
    try:
        problem = variation.at(places[number])
    except ShakedownError as error:
        return as_text(no_point(values, str(error)))
    return as_text(design_point(problem, values, **asked))


def _stamp(variation: Variation, first: tuple[float, ...]) -> object:
    """What tells joints apart, and functions that make them."""
    joint, base = variation.joint, variation.base
    if base is None:
        return function_stamp(joint, *first)  # type: ignore[arg-type]
    return base.fingerprint, joint.sources if isinstance(joint, Import) else None


def _checked_bounds(bounds: Sequence[str] | None, base: Problem | None) -> tuple[str, ...]:
    absent = [] if base is None else [name for name, kind in BOUNDS.items() if not kind.exists_for(base)]
    there = tuple(name for name in BOUNDS if name not in absent)
    if bounds is None:
        return tuple(name for name in there if BOUNDS[name].claim != Claim.CREEP)
    names = (bounds,) if isinstance(bounds, str) else tuple(bounds)
    if not names or len(set(names)) < len(names) or not set(names) <= set(there):
        found, where = ", ".join(map(str, names)) or "none", " with two directions" * bool(absent)
        raise UsageError(f"bounds{where}: expected some of {', '.join(there)}, each once, found {found}")
    return names
