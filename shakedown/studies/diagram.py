"""Limits of the load factor over one or two parameters, and the regions between them."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from enum import StrEnum
from functools import cached_property
from math import inf, nan
from os import PathLike
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.files.table_file import check_table, write_csv, write_parquet
from shakedown.ground.errors import UsageError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import plain
from shakedown.ground.status import FROM_HERE, SYMBOLS, Status
from shakedown.ground.visible_text import shortened, with_unit
from shakedown.joint.arguments import check_load_factor
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result, frame
from shakedown.studies.design_point import DesignPoint, SlipAllowed
from shakedown.studies.parameters import FACTORS

if TYPE_CHECKING:
    from pandas import DataFrame

WITH_UNIT = re.compile(r"(?P<name>.+) \[(?P<unit>[^\[\]]+)\]")  # a heading
COLUMNS = {name: symbol.replace("λ", "lambda") for name, symbol in SYMBOLS.items()}


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
    load_factors_simulated
        Where the joint was simulated from the state asked about.
    points
        The point of every combination, the last parameter running fastest.
    """

    name: str
    parameters: tuple[str, ...]
    meanings: tuple[str, ...]
    units: tuple[str, ...]
    values: tuple[FloatArray, ...]
    bounds: tuple[str, ...]
    load_factors_simulated: tuple[float, ...]
    points: tuple[DesignPoint, ...] = field(repr=False)

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

    @cached_property
    def lower(self) -> FloatArray:
        """First collapse λ_1."""
        return self.load_factors("lower")

    @cached_property
    def universal(self) -> FloatArray:
        """λ_U, below which shakedown from every state is proved."""
        return self.load_factors("universal")

    @cached_property
    def energy(self) -> FloatArray:
        """λ_E, below which shakedown from this state is proved."""
        return self.load_factors("energy")

    @cached_property
    def accumulated(self) -> FloatArray:
        """λ_S, below which bounds of all slips prove shakedown from this state."""
        return self.load_factors("accumulated")

    @cached_property
    def from_this_state(self) -> FloatArray:
        """The largest limit proved from this state, as ``assess`` has it; NaN where none was asked for."""
        return self._grid([point.proved_from_this_state for point in self.points])

    @cached_property
    def transient(self) -> FloatArray:
        """λ_T, up to which the history from this state shakes down."""
        return self.load_factors("transient")

    @cached_property
    def transient_interval(self) -> tuple[FloatArray, FloatArray]:
        """Where λ_T lies: shakedown is proved at the first, a cycle was found at the second."""
        limits = [point.limits.get("transient") for point in self.points]
        low, high = ([np.nan if x is None else getattr(x, end) for x in limits] for end in ("low", "high"))
        return self._grid(low), self._grid(high)

    @cached_property
    def upper(self) -> FloatArray:
        """λ_max, above which no slip is safe with all nodes in contact."""
        return self.load_factors("upper")

    @property
    def guarantee(self) -> NDArray[np.str_]:
        """Whether λ_1 is a guarantee: ``"proved"``, ``"evidence"`` or empty."""
        return self._grid([point.guarantee for point in self.points])

    @property
    def contradictions(self) -> tuple[str, ...]:
        """Every contradiction between limits, with the values of the parameters."""
        return tuple(f"{self._at(point)}: {text}" for point in self.points for text in point.contradictions)

    @property
    def outcomes(self) -> NDArray[np.str_]:
        """What becomes of the joint at each simulated load factor (last axis); empty without a joint."""
        nothing = ("",) * len(self.load_factors_simulated)
        entries = [[str(x) for x in point.outcomes or nothing] for point in self.points]
        return np.array(entries, dtype=np.str_).reshape(*self.shape, len(nothing))

    @property
    def slip_criteria(self) -> tuple[SlipAllowed | None, ...]:
        """Up to which load factor slips stay below the given length, point by point; None without one."""
        return tuple(point.slip_criterion for point in self.points)

    def load_factors(self, name: str) -> FloatArray:
        """The load factors of a limit by its name; NaN where there is none."""
        self._check(name)
        return self._grid([point.load_factor(name) for point in self.points])

    def status(self, name: str) -> NDArray[np.str_]:
        """How each load factor of a limit was found (:class:`Status`); ``"no joint"`` where there is none."""
        self._check(name)
        return self._grid(
            [str(p.limits[name].status) if name in p.limits else str(Region.NO_JOINT) for p in self.points]
        )

    @cached_property
    def boundaries(self) -> Boundaries:
        """Where the regions of the load factor meet; NaN where there is no joint.

        Nothing is concluded from a limit with conditions (proved only from some load factor on, or
        for a joint that is partly open).
        """
        joints = np.where([point.exists for point in self.points], 0.0, np.nan)
        every = joints + [_proved_from_every_state(point) for point in self.points]
        this = joints + np.nan_to_num(self.from_this_state.ravel(), posinf=inf)
        never = joints + [_never_from(point) for point in self.points]
        return Boundaries(*(x.reshape(self.shape) for x in (every, np.maximum(every, this), never)))

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
        document = {
            "name": self.name,
            "parameters": [
                {"name": name, "values": values.tolist()}
                for name, values in zip(self.parameters, self.values, strict=True)
            ],
            "bounds": list(self.bounds),
            "load_factors_simulated": list(self.load_factors_simulated),
            "points": [self._point(point) for point in self.points],
            "contradictions": list(self.contradictions),
        }
        return {word: plain(value) for word, value in document.items()}

    def columns(self) -> dict[str, list[Any]]:
        """What a table of the points holds: heading, with unit, → one entry per point."""
        return dict(self._columns())

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
        parts = {heading: WITH_UNIT.fullmatch(heading) for heading in self.columns()}
        names = {heading: found["name"] if found else heading for heading, found in parts.items()}
        table = frame({names[heading]: values for heading, values in self.columns().items()})
        table.attrs["units"] = {found["name"]: found["unit"] for found in parts.values() if found}
        return table

    def save(self, path: str | PathLike[str]) -> None:
        """Write one row per point: CSV in full precision, or Parquet where the name ends in .parquet.

        Raises
        ------
        UsageError
            If the file cannot be written, its name ends in neither, or Parquet is asked for
            where pandas or pyarrow is missing.
        """
        check_table(path)
        write = write_csv if str(path).lower().endswith("csv") else write_parquet
        write(path, self.columns())

    def _check(self, name: str) -> None:
        if name not in SYMBOLS:
            raise UsageError(f"limit: expected one of {', '.join(SYMBOLS)}, found {shortened(repr(name))}")

    def _grid(self, entries: list[Any]) -> NDArray[Any]:
        return np.array(entries).reshape(self.shape)

    def _at(self, point: DesignPoint) -> str:
        pairs = zip(self.parameters, point.values, strict=True)
        return ", ".join(f"{name} = {value:g}" for name, value in pairs)

    def _point(self, point: DesignPoint) -> dict[str, Any]:
        return {
            "values": dict(zip(self.parameters, point.values, strict=True)),
            "exists": point.exists,
            "reason": point.reason,
            "guarantee": point.guarantee,
            "proved_from_this_state": point.proved_from_this_state,
            "open_nodes": list(point.open_nodes),
            "outcomes": [str(outcome) for outcome in point.outcomes],
            **({} if point.slip_criterion is None else {"slip_criterion": point.slip_criterion._asdict()}),
            **{name: limit._asdict() for name, limit in point.limits.items()},
        }

    def _columns(self) -> Iterator[tuple[str, list[Any]]]:
        for k, (name, unit) in enumerate(zip(self.parameters, self.units, strict=True)):
            yield with_unit(name, unit), [point.values[k] for point in self.points]
        for name in self.bounds:
            yield f"{COLUMNS[name]} [1]", self.load_factors(name).ravel().tolist()
            if name == "transient":
                for end, factors in zip(("proved", "cycling"), self.transient_interval, strict=True):
                    yield f"{COLUMNS[name]}_{end} [1]", factors.ravel().tolist()
            yield f"{COLUMNS[name]}_status", self.status(name).ravel().tolist()
            if name == "lower":
                yield "guarantee", [point.guarantee for point in self.points]
        if {*self.bounds} & {*FROM_HERE}:
            yield "proved_from_this_state [1]", self.from_this_state.ravel().tolist()
        for k, load_factor in enumerate(self.load_factors_simulated):
            yield f"outcome at lambda = {load_factor!r}", self.outcomes[..., k].ravel().tolist()
        if any(self.slip_criteria):
            known = [slips or SlipAllowed(nan, nan, nan) for slips in self.slip_criteria]
            yield "lambda_slip [1]", [slips.load_factor for slips in known]
            yield "largest_slip_range", [slips.largest for slips in known]
        yield "open_nodes", [" ".join(map(str, point.open_nodes)) for point in self.points]
        yield "remark", ["; ".join(_remarks(point)) for point in self.points]


def _proved_from_every_state(point: DesignPoint) -> float:
    """λ_U; 0 where it is not known."""
    limit = point.limits.get("universal")
    proved = limit is not None and limit.status in (Status.OPTIMAL, Status.UNBOUNDED)
    return limit.load_factor if limit is not None and proved else 0.0


def _never_from(point: DesignPoint) -> float:
    """λ_max of the whole joint, above which nothing shakes down in contact; inf where it is not known."""
    limit = point.limits.get("upper")
    if limit is None or point.open_nodes or limit.status == Status.UNDECIDED:
        return inf
    return 0.0 if limit.status == Status.INFEASIBLE else limit.load_factor


def _remarks(point: DesignPoint) -> Iterator[str]:
    """Remarks on a point besides its numbers."""
    if point.reason:
        yield point.reason
    for name, limit in point.limits.items():
        if limit.remark and limit.status != Status.OPTIMAL:
            yield f"{SYMBOLS[name]}: {limit.remark}"
    yield from point.contradictions
