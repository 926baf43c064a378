"""One joint on finer and finer meshes: its limits, friction work and slips, and which of these converge."""

import logging
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from math import inf, nan
from os import PathLike
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

from shakedown.assessment.assess import Assessment, assess
from shakedown.assessment.every_limit import THREE_NUMBERS
from shakedown.assessment.transient_limit import slip_limit
from shakedown.files.atomic_write import check_table, write_table
from shakedown.files.pieces import Arrays, Progress, as_text, function_stamp, run_pieces, text_of
from shakedown.ground.constants import MINOR, THREE_DIGITS, FloatArray, IntArray
from shakedown.ground.errors import Missing, UsageError, attempt, present
from shakedown.ground.shown_values import plain, short, shortened
from shakedown.ground.status import Outcome
from shakedown.joint.arguments import check_load_factor, checked, is_finite, real_array, require_problem
from shakedown.joint.contact_surface import element_count
from shakedown.joint.hat_functions import averaged
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import can_creep
from shakedown.long_term.find_state import long_term_state
from shakedown.long_term.node_results import node_results
from shakedown.long_term.simulation import check_slip_below

Make = Callable[[Any], Problem] | Mapping[Any, Problem]

SLOWEST = 0.5  # least order of convergence; below it the extrapolated limit is too uncertain
FASTEST = 4.25  # above 4, the order of energies on quadratic elements, meshes are too coarse to have one
NEAR = 0.25  # largest relative distance of the extrapolated limit; beyond twice this it is open
AVERAGED = "averaged_impossible_above"
COLUMNS = (*THREE_NUMBERS, AVERAGED, "work", "largest_slip", "slip_limit", "creep", "creep_proved")


# The trend of a number as the mesh is refined; ZERO: no slip, or nothing proved, on these meshes.
CONVERGES, FALLS, GROWS, ZERO, UNDECIDED = "converges", "falls", "grows", "zero", "undecided"


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
        Order of convergence, p of a + c h^p; NaN where the last changes are too small, change sign, or fall
        faster than by any elements, as the meshes are too coarse to tell it. Where the numbers fall or grow
        it is the exponent s of h^s between the last two meshes. Else NaN.
    """

    verdict: str
    limit: float = nan
    order: float = nan

    @property
    def is_slow(self) -> bool:
        """Whether it converges, at an order near the least."""
        return self.verdict == CONVERGES and self.order < 1.5 * SLOWEST


def trend(size: FloatArray, values: FloatArray) -> Trend:
    """What numbers do as the element size falls, (k,) both; the last three are looked at.

    Examples
    --------
    >>> h = np.array([0.25, 0.125, 0.0625])
    >>> found = trend(h, 3.0 + 2.0 * h**1.5)
    >>> found.verdict, round(found.limit, 6), round(found.order, 6)
    ('converges', 3.0, 1.5)
    >>> trend(h, h**0.1).verdict, trend(h, 1.0 - np.log(h)).verdict
    ('falls', 'grows')
    """
    level = 0.03  # power of h, or relative change over three meshes, below which a number counts as constant
    if not np.any(values[-3:]):
        return Trend(ZERO)
    if len(values) < 3 or not np.isfinite([*values[-3:], *np.log(size[-3:])]).all():
        return Trend(UNDECIDED)
    h, (first, second, last) = size[-3:].tolist(), map(float, values[-3:])
    if first == 0.0 or not h[0] > h[1] > h[2]:  # no power of h is 0 on a mesh
        return Trend(UNDECIDED)
    before, now = second - first, last - second
    if max(abs(before), abs(now)) <= THREE_DIGITS * abs(last):
        return Trend(CONVERGES, last)
    if second == last == 0.0:
        return Trend(FALLS)
    order = _order(h, before / now) if before * now > 0.0 else inf
    if order > FASTEST:
        ends = abs(now) <= min(0.5 * abs(before), MINOR * abs(last))
        return Trend(CONVERGES, last) if ends else Trend(UNDECIDED)
    left = now / ((h[1] / h[2]) ** order - 1.0) if order > 0.0 else inf * now
    near, power = abs(left) <= NEAR * abs(last), nan
    if near and order >= SLOWEST:
        return Trend(CONVERGES, last + left, order)
    if second * last > 0:
        power = float(np.log(second / last) / np.log(h[1] / h[2]))
    # order below which there is none: the rest cannot be distinguished from a power of h, or log h
    slow, far = near and order >= 0.25, order >= SLOWEST and abs(left) <= 2.0 * NEAR * abs(last)
    if slow or far or abs(power) < level or abs(last - first) <= level * abs(last):
        return Trend(UNDECIDED)
    return Trend(FALLS if now * last < 0 or last == 0.0 else GROWS, order=power)


def _order(h: list[float], ratio: float) -> float:
    """p of a + c h^p, of which the ratio of two changes is known; 0 where no p > 0 has it, inf where fast."""

    def excess(p: float) -> float:
        # (h0^p − h1^p) / (h1^p − h2^p), by expm1 good near p = 0 as well
        return float(np.expm1(p * np.log(h[0] / h[1])) / -np.expm1(p * np.log(h[2] / h[1]))) - ratio

    if excess(1e-6) >= 0.0:
        return 0.0
    return inf if excess(FASTEST) < 0.0 else float(brentq(excess, 1e-6, FASTEST, xtol=1e-12))


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
        in the long run at the load factor, from slip zero, up to which load factor every slip stays
        below the length (:func:`~shakedown.assessment.transient_limit.slip_limit`), and in the plane, where a
        slip is rigid, λ_c and the load factor below which creep is excluded
        (:func:`~shakedown.assessment.creep_limit.creep_limit`). NaN where there is none, inf where nothing
        limits it.
    elements : (k,)
        How many elements the contacts have (:func:`~shakedown.joint.contact_surface.element_count`).
    """

    DOCUMENT: ClassVar[str] = "load_factor radius slip_below"

    load_factor: float
    radius: float | None
    slip_below: float | None
    size: FloatArray
    nodes: IntArray
    directions: int
    numbers: dict[str, FloatArray]
    elements: FloatArray

    def table(self) -> dict[str, NDArray[Any]]:
        """The columns by name, one row per mesh; what all meshes have in common is repeated in each."""
        same = {name: getattr(self, name) for name in self.DOCUMENT.split()}
        return {
            "size": self.size,
            "nodes": self.nodes,
            **self.numbers,
            "directions": np.full(len(self.nodes), self.directions),
            "elements": self.elements,
            **{name: np.full(len(self.nodes), nan if each is None else each) for name, each in same.items()},
        }

    def save(self, path: str | PathLike[str]) -> None:
        """Write the table: CSV in full precision, or Parquet where the name ends in .parquet.

        Raises
        ------
        UsageError
            If the file cannot be written, its name ends in neither, or pandas or pyarrow is missing.
        """
        write_table(path, self.columns())

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
        return {name: found.verdict for name, found in self.trends.items()}

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


@checked
def refine(
    make: Make,
    sizes: ArrayLike,
    *,
    radius: float | None = None,
    load_factor: float = 1.0,
    slip_below: float | None = None,
    executor: Executor | None = None,
    workers: int | None = 1,
    output: str | PathLike[str] | None = None,
    resume: bool = False,
    progress: Progress | None = None,
) -> Refinement:
    """Find which numbers of a joint converge as its mesh is refined (docs/mesh.md).

    Three meshes or more tell, each with about twice as many elements along an edge as the one before.
    A number a + c h^p is fitted through the last three, h^(−d) the number of elements: it converges where p
    is 0.5 or more and the limit within a quarter of the last number; else it falls or grows, or three meshes
    do not tell. That is evidence, no proof. Where it is 0 on all three it is called zero, no more.

    Parameters
    ----------
    make
        The joint on the mesh of a size: a function of it, or joints by size.
    sizes
        Sizes of the meshes, the coarsest first.
    radius
        The length over which slips are averaged (:func:`averaged`), the same on every mesh [length].
    load_factor
        At which friction work and slips are found.
    slip_below
        Also up to which load factor the slip of every node stays below this length [length].
    executor
        Who works: any :class:`concurrent.futures.Executor`; it is not shut down.
    workers
        Without one the number of processes; a function that makes joints has to be one that can be imported,
        and a script to keep the call under ``if __name__ == "__main__":``.
    output
        Where to write the table (.csv or .parquet). Until then every mesh is kept, as soon as it is known, in
        a file of its own in ``OUTPUT.parts``.
    resume
        Whether to go on with the meshes that a stopped run has left there.
    progress
        Called with (meshes done, meshes in all).

    Raises
    ------
    UsageError
        If an argument is out of range, no joint is made, the meshes do not get finer, or their units differ.

    Examples
    --------
    >>> import shakedown
    >>> joints = {name: shakedown.example(name) for name in ("block-9", "block-33")}
    >>> found = refine({joint.n: joint for joint in joints.values()}, [9, 33])
    >>> found.nodes.tolist(), found.verdict["impossible_above"]
    ([9, 33], 'undecided')
    """
    check_load_factor(load_factor)
    if radius is not None and not (is_finite(radius) and radius > 0):
        raise UsageError(f"radius: expected a length above 0, found {radius!r}")
    if slip_below is not None:
        slip_below = check_slip_below(slip_below)
    real_array("sizes", sizes)
    wanted = tuple(np.ravel(np.asarray(sizes)).tolist())  # whole numbers stay such
    if not wanted or (isinstance(make, Mapping) and not set(wanted) <= set(make)):
        raise UsageError(f"sizes: expected sizes of joints, found {wanted}")
    if output is not None:
        check_table(output)
    how = float(load_factor), radius, slip_below
    if isinstance(make, Mapping):
        _check_one_joint([_about(make[size]) for size in wanted])
        joints = [make[size].fingerprint for size in wanted]
    else:  # the joints are known only afterwards
        joints = [function_stamp(make, wanted[0])]
    run: dict[str, Any] = {"executor": executor, "workers": workers, "progress": progress}
    run |= {"settings": (joints, wanted, how), "output": output, "resume": resume}
    with run_pieces(partial(_mesh, make, wanted, how), len(wanted), **run) as pieces:
        rows = [text_of(piece) for piece in pieces]
        if not isinstance(make, Mapping):
            _check_one_joint(rows)
        found = Refinement(
            *how,
            np.array(wanted, dtype=float),
            np.array([row["nodes"] for row in rows]),
            rows[0]["directions"],
            {name: np.array([float(row[name]) for row in rows]) for name in COLUMNS},
            np.array([float(row["elements"]) for row in rows]),
        )
        if output is not None:
            found.save(output)
    return found


def _about(problem: Problem) -> dict[str, Any]:
    """What a mesh is, and what of the joint it does not change."""
    require_problem(problem)
    return {
        "nodes": problem.n,
        "elements": element_count(problem),
        "directions": problem.directions,
        "units": problem.units,
        "friction": [float(problem.f.min()), float(problem.f.max())],
        "load steps": problem.m,
        "loads": list(problem.load_names or ()),
    }


def _check_one_joint(meshes: Sequence[Mapping[str, Any]]) -> None:
    """Refuse meshes that do not get finer, and other units; say what else differs, which no mesh changes."""
    nodes = [int(mesh["nodes"]) for mesh in meshes]
    spaces, units = (list(dict.fromkeys(mesh[name] for mesh in meshes)) for name in ("directions", "units"))
    if (np.diff(nodes) <= 0).any() or len(spaces) > 1:
        found = f"{shortened(str(nodes))} contact nodes" + " in the plane and in space" * (len(spaces) > 1)
        raise UsageError(f"meshes: expected one joint, the coarsest first, found {found}")
    if len(units) > 1:
        raise UsageError(f"meshes: expected one joint in the same units, found {shortened(repr(units))}")
    kept = ("friction", "load steps", "loads")
    differ = [name for name in kept if any(mesh[name] != meshes[0][name] for mesh in meshes)]
    if differ:
        logging.getLogger("shakedown").warning(
            "the meshes differ in %s: are they one joint?", " and ".join(differ)
        )


def _mesh(
    make: Make, sizes: Sequence[float], how: tuple[float, float | None, float | None], number: int
) -> Arrays:
    """The row of a mesh, as text."""
    size = sizes[number]
    problem = make[size] if isinstance(make, Mapping) else make(size)
    return as_text(_about(problem) | mesh_row(problem, *how))


def mesh_row(
    problem: Problem, load_factor: float, radius: float | None, slip_below: float | None
) -> dict[str, Any]:
    """The numbers of one mesh, by ``COLUMNS``."""
    row: dict[str, Any] = {}
    limits = assess(problem)
    for name in THREE_NUMBERS:
        row[name] = _number(limits, name)
    coarse = None if radius is None else assess(averaged(problem, radius))
    row[AVERAGED] = nan if coarse is None else _number(coarse, THREE_NUMBERS[0])
    creep = present(limits.details.creep) if can_creep(problem) else None
    row["creep"], row["creep_proved"] = (creep.load_factor, creep.proved) if creep else (nan, nan)
    state = long_term_state(problem, load_factor)
    nodes, slips = node_results(state), state.outcome != Outcome.SHAKEDOWN  # else what is left is round-off
    known = nodes.period > 0
    row["work"] = float(slips * nodes.work.sum()) if known else nan
    row["largest_slip"] = float(slips * nodes.slip_range.max()) if known else nan
    row["slip_limit"] = nan if slip_below is None else slip_limit(problem, slip_below).load_factor
    return row


def _number(found: Assessment, name: str) -> float:
    """A limit; NaN where its program did not finish."""
    number = attempt(getattr, found, name)
    return nan if isinstance(number, Missing) else float(number)
