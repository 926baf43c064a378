"""Limits, friction work and slips of a joint on finer and finer meshes, and which of these converge."""

from dataclasses import dataclass, field
from enum import StrEnum
from math import inf, isnan, nan
from os import PathLike
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from shakedown.files.table_file import check_table, read_csv, write_csv, write_parquet
from shakedown.ground.errors import ProblemError, found_in
from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import PER_CENT, THREE_DIGITS
from shakedown.ground.shown_values import plain, short
from shakedown.ground.visible_text import shortened
from shakedown.joint.result import Result

SLOWEST = 0.5  # least order of convergence; below it the extrapolated limit is too uncertain
SLOW = (
    0.5 * SLOWEST
)  # order below which there is none: what is left cannot be told from a power of h, or log h
LEVEL = 0.03  # power of h, or relative change over three meshes, below which a number counts as constant
FASTEST = 8.0  # largest order; above it the last change is meaningless
NEAR = 0.25  # largest relative distance of the extrapolated limit; beyond twice this it is open
LIMITS = (
    "impossible_above",
    "proved_from_this_state",
    "proved_from_every_state",
    "averaged_impossible_above",
)
COLUMNS = (*LIMITS, "work", "largest_slip", "slip_limit")
SAME = ("load_factor", "radius", "slip_below")  # settings common to all meshes
HEADINGS = ("size", "nodes", *COLUMNS, "directions", "elements", *SAME, "fingerprint")


class Tendency(StrEnum):
    """The trend of a number as the mesh is refined; ZERO: no slip, or nothing proved, on these meshes."""

    CONVERGES = "converges"
    FALLS = "falls"
    GROWS = "grows"
    ZERO = "zero"
    UNDECIDED = "undecided"


class Trend(NamedTuple):
    """The trend of a sequence of numbers.

    Attributes
    ----------
    verdict
        Whether it converges, falls or grows; zero where it is 0 on all of these meshes, undecided where three
        numbers do not tell.
    limit
        The limit that it converges to, extrapolated; NaN where it does not converge.
    order
        Order of convergence, p of a + c h^p; NaN where the last changes are too small or change sign. Where
        the numbers fall or grow it is the exponent s of h^s between the last two meshes. Else NaN.
    """

    verdict: Tendency
    limit: float = nan
    order: float = nan


def trend(size: FloatArray, values: FloatArray) -> Trend:
    """What numbers do as the element size falls, (k,) both; the last three are looked at.

    Examples
    --------
    >>> h = np.array([0.25, 0.125, 0.0625])
    >>> found = trend(h, 3.0 + 2.0 * h**1.5)
    >>> found.verdict.value, round(found.limit, 6), round(found.order, 6)
    ('converges', 3.0, 1.5)
    >>> trend(h, h**0.1).verdict.value, trend(h, 1.0 - np.log(h)).verdict.value
    ('falls', 'grows')
    """
    if not np.any(values[-3:]):
        return Trend(Tendency.ZERO)
    if len(values) < 3 or not np.isfinite([*values[-3:], *np.log(size[-3:])]).all():
        return Trend(Tendency.UNDECIDED)
    h, (first, second, last) = size[-3:].tolist(), map(float, values[-3:])
    if first == 0.0 or not h[0] > h[1] > h[2]:  # no power of h is 0 on a mesh
        return Trend(Tendency.UNDECIDED)
    before, now = second - first, last - second
    if max(abs(before), abs(now)) <= THREE_DIGITS * abs(last):
        return Trend(Tendency.CONVERGES, last)
    if second == last == 0.0:
        return Trend(Tendency.FALLS)
    if before * now <= 0.0:
        ends = abs(now) <= min(0.5 * abs(before), PER_CENT * abs(last))
        return Trend(Tendency.CONVERGES, last) if ends else Trend(Tendency.UNDECIDED)
    order = _order(h, before / now)
    left = now / ((h[1] / h[2]) ** order - 1.0) if order > 0.0 else inf * now
    near, power = abs(left) <= NEAR * abs(last), nan
    if near and order >= SLOWEST:
        return Trend(Tendency.CONVERGES, last + left, order)
    if second * last > 0:
        power = float(np.log(second / last) / np.log(h[1] / h[2]))
    slow, far = near and order >= SLOW, order >= SLOWEST and abs(left) <= 2.0 * NEAR * abs(last)
    if slow or far or abs(power) < LEVEL or abs(last - first) <= LEVEL * abs(last):
        return Trend(Tendency.UNDECIDED)
    return Trend(Tendency.FALLS if now * last < 0 or last == 0.0 else Tendency.GROWS, order=power)


def _order(h: list[float], ratio: float) -> float:
    """p of a + c h^p, of which the ratio of two changes is known; 0 where no p > 0 has it."""

    def excess(p: float) -> float:
        # (h0^p − h1^p) / (h1^p − h2^p), by expm1 good near p = 0 as well
        return float(np.expm1(p * np.log(h[0] / h[1])) / -np.expm1(p * np.log(h[2] / h[1]))) - ratio

    if excess(1e-6) >= 0.0:
        return 0.0
    return FASTEST if excess(FASTEST) <= 0.0 else float(brentq(excess, 1e-6, FASTEST, xtol=1e-12))


@dataclass(frozen=True, eq=False, repr=False)
class Refinement(Result):
    """Result of :func:`refine`: a table of meshes, and what every column does.

    Attributes
    ----------
    load_factor
        At which the joint is simulated, the same on every mesh.
    radius
        The length over which slips are averaged [length]; None where they are not.
    slip_below
        The length that slips are to stay below [length]; None where that was not asked for.
    size : (k,)
        What the meshes were made from, in order.
    nodes : (k,)
        How many contact nodes they have.
    directions
        Tangential directions of a node.
    numbers
        The other columns: the three numbers of :func:`assess`, λ_max averaged over the radius, the
        friction work per cycle of all nodes [force · length] and the largest slip range of a node [length]
        in the long run at the load factor, from slip zero, and up to which load factor every slip stays
        below the length (:func:`~shakedown.assessment.slip_limit.slip_limit`). NaN where there is none, inf
        where nothing limits it.
    fingerprints
        Fingerprints of the joints (``Problem.fingerprint``), by which a report recognises its own.
    elements : (k,)
        How many elements the contacts have (:func:`~shakedown.joint.contact_surface.element_count`); by
        default (n^(1/d) − 1)^d for n nodes with d directions.
    """

    DOCUMENT: ClassVar[str] = "load_factor radius slip_below"

    load_factor: float
    radius: float | None
    slip_below: float | None
    size: FloatArray
    nodes: NDArray[np.intp]
    directions: int
    numbers: dict[str, FloatArray]
    fingerprints: tuple[str, ...]
    elements: FloatArray = field(default_factory=lambda: np.empty(0))

    def __post_init__(self) -> None:
        if not len(self.elements):
            d = self.directions
            object.__setattr__(self, "elements", (self.nodes.astype(float) ** (1 / d) - 1) ** d)

    def table(self) -> dict[str, NDArray[Any]]:
        """The columns by name, one row per mesh; what all meshes have in common is said of each."""
        same = {name: getattr(self, name) for name in SAME}
        return {
            "size": self.size,
            "nodes": self.nodes,
            **self.numbers,
            "directions": np.full(len(self.nodes), self.directions),
            "elements": self.elements,
            **{name: np.full(len(self.nodes), nan if each is None else each) for name, each in same.items()},
            "fingerprint": np.array(self.fingerprints),
        }

    @classmethod
    def load(cls, path: str | PathLike[str]) -> "Refinement":
        """The table that :meth:`save` wrote as CSV.

        Raises
        ------
        ProblemError
            If there is no such file, or it is another one.
        """
        found = read_csv(path, HEADINGS)
        fingerprints = tuple(found.pop("fingerprint"))
        with found_in(shortened(str(path))):
            try:
                nodes, directions = [np.array(list(map(int, found.pop(n)))) for n in ("nodes", "directions")]
                numbers = {name: np.array([float(x or nan) for x in texts]) for name, texts in found.items()}
                load_factor, *lengths = (float(numbers.pop(name)[0]) for name in SAME)
            except (ValueError, IndexError) as error:
                raise ProblemError(f"expected numbers of one mesh or more, found {error}") from None
            if set(directions) not in ({1}, {2}) or (np.diff(nodes, prepend=0) <= 0).any():
                raise ProblemError("expected meshes of one joint that get finer, found others")
        radius, slip_below = (None if isnan(length) else length for length in lengths)
        meshes = numbers.pop("size"), nodes, int(directions[0])
        elements = numbers.pop("elements")
        return cls(load_factor, radius, slip_below, *meshes, numbers, fingerprints, elements)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the table: CSV in full precision, or Parquet where the name ends in .parquet.

        Raises
        ------
        UsageError
            If the file cannot be written, its name ends in neither, or pandas or pyarrow is missing.
        """
        check_table(path)
        write = write_csv if str(path).lower().endswith("csv") else write_parquet
        write(path, self.columns())

    def columns(self) -> dict[str, Any]:
        """The same, for :meth:`to_frame`."""
        return self.table()

    @property
    def trends(self) -> dict[str, Trend]:
        """The trend of every column; the element size is e^(−1/d), for e elements with d directions."""
        with np.errstate(divide="ignore"):  # a contact of one node has none
            h = np.asarray(self.elements) ** (-1.0 / self.directions)
        return {name: trend(h, values) for name, values in self.numbers.items()}

    @property
    def verdict(self) -> dict[str, str]:
        """``converges``, ``falls``, ``grows``, ``zero`` or ``undecided``, by column."""
        return {name: str(found.verdict) for name, found in self.trends.items()}

    @property
    def limit(self) -> dict[str, float]:
        """The extrapolated limit of every column that converges, else NaN."""
        return {name: found.limit for name, found in self.trends.items()}

    @property
    def order(self) -> dict[str, float]:
        """The order of convergence, or the power of the element size where a column falls or grows."""
        return {name: found.order for name, found in self.trends.items()}

    def to_dict(self) -> dict[str, Any]:
        """The load factor, the radius, the table and what its columns do."""
        about: dict[str, Any] = {"table": self.table(), "verdict": self.verdict}
        about |= {"limit": self.limit, "order": self.order}
        return super().to_dict() | {key: plain(value) for key, value in about.items()}

    def _shown(self) -> Any:
        for name, found in self.trends.items():
            yield name, f"{short(self.numbers[name])} {found.verdict}, limit {found.limit:.6g}"
