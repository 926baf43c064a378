"""The largest load factor with a safe slip, the least one, and the slip with most room, over discs."""

import logging
from dataclasses import dataclass, replace
from math import inf, nan

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.discs.disc_program import (
    Basis,
    DiscEnd,
    DiscProgram,
    ScaledDiscs,
    basis_of,
    in_units,
    scaled_discs,
)
from shakedown.bounds.discs.disc_rows import DiscRows
from shakedown.bounds.discs.enclosure import UNPROVED, enclosed, proved_infeasible, proved_unbounded
from shakedown.bounds.discs.polish import polished
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints
from shakedown.joint.problem import Problem
from shakedown.programs.interior.self_dual import SelfDualEnd, self_dual_end
from shakedown.programs.program import Program
from shakedown.programs.solver import solve

LOGGER = logging.getLogger("shakedown")
ACCURATE = 1e-9  # of an end: less is said to be of reduced accuracy
CARRIES = 1e-9  # share of the largest multiplier from where on a disc is said to determine an end
NOTHING = 1e-14  # of a load factor, in numbers near 1: it is round-off
INSIDE = 1.05  # σ over |y| from where on multipliers point well inside their cone
LARGE = 1000  # nodes, from where on time and memory are announced
SECONDS, BYTES = 4e-8, 1100.0  # per node cubed, per node squared: measured on one core with 20 load steps


@dataclass(frozen=True, eq=False)
class DiscLimit:
    """The largest load factor over discs, and what proves it; the words of ``UpperBound``.

    Attributes
    ----------
    x : (k,)
        Slips, or where unbounded their direction, at the unknowns of programs [length].
    multipliers : (3j + o,)
        Of discs and half-spaces.
    discs
        The discs that determine it.
    """

    status: Status
    load_factor: float
    x: FloatArray
    multipliers: FloatArray
    discs: NDArray[np.intp]
    residual: float
    least_load_factor: float = nan
    certified: tuple[float, float] | None = None
    exact: bool = False
    uncertified: str = ""
    missing: tuple[str, ...] = ()
    reduced_accuracy: bool = False


def largest_load_factor(
    rows: DiscRows, certified_for: Problem | None, balanced: bool, tolerances: Tolerances
) -> DiscLimit:
    """λ_max of some limits, certified for the joint whose limits they are where it is given.

    ``balanced``: whether the loading has its own mean, so that a slip that is safe at any load factor is
    safe under the mean.

    Raises
    ------
    SolverError
        If no road comes to an end.
    """
    announce(rows)
    basis = basis_of(rows)
    if not relieving(rows):
        best = end_of(scaled_discs(rows, basis, -1.0), tolerances)
        if best.status == Status.INFEASIBLE:
            return _infeasible(rows, best, certified_for)
        if best.optimal:
            least, missing = _least(rows, basis, balanced, tolerances)
            return replace(_optimal(rows, best, certified_for), least_load_factor=least, missing=missing)
        direction = best.x
    else:
        direction = np.zeros(rows.stiffness.shape[-1])
    start = end_of(scaled_discs(rows, basis, +1.0), tolerances)
    if not start.optimal:
        return _infeasible(rows, start, certified_for)
    return _unbounded(rows, basis, direction, start, certified_for, tolerances)


def announce(rows: DiscRows) -> None:
    """Say beforehand what a large program takes."""
    n = len(rows.stiffness)
    if n >= LARGE:
        minutes, gigabytes = SECONDS * n**3 / 60.0, BYTES * n**2 / 2.0**30
        LOGGER.warning("upper bound of %d nodes: about %.0f min and %.1f GiB", n, np.ceil(minutes), gigabytes)


def relieving(rows: DiscRows) -> bool:
    """Whether the periodic loads bring no node nearer to its limits."""
    room = rows.e[:, 0] - np.hypot(rows.e[:, 1], rows.e[:, 2])
    return bool(np.all(room >= 0) and np.all(rows.gaps.d <= 0))


def end_of(scaled: ScaledDiscs, tolerances: Tolerances) -> DiscEnd:
    """The end of a program: by interior points of its own, else by those of :func:`solve`; polished."""
    end = self_dual_end(scaled.program)
    if end.status == Status.UNDECIDED:
        end = _second_road(scaled.program, tolerances)
    return in_units(scaled, polished(scaled.program, end))


def _second_road(program: DiscProgram, tolerances: Tolerances) -> SelfDualEnd:
    """The end of the same program, as rows and cones."""
    K = program.Q.shape[-1]
    discs = np.concatenate([program.Q[program.rows.node], program.E[:, :, None]], axis=2)
    matrix = np.vstack([program.linear, -discs.reshape(-1, K + 1)])
    cones = (3,) * len(program.C)
    found = solve(Program(matrix, program.right, program.cost, cones, tolerances=tolerances))
    y, x = np.nan_to_num(found.multipliers), np.nan_to_num(found.x)
    slack = program.right - program.times(x)
    if found.status == Status.UNBOUNDED:
        slack, x = -program.times(x), x / -float(program.cost @ x)
    accuracy = max(abs(each) for each in found.residuals) if found.optimal else ACCURATE
    return SelfDualEnd(found.status, x, slack, y, accuracy, ())


def _optimal(rows: DiscRows, best: DiscEnd, certified_for: Problem | None) -> DiscLimit:
    load_factor = best.load_factor if best.load_factor > NOTHING * best.scaled.load_unit else 0.0
    found: tuple[float, float] | Missing = Missing("")
    if certified_for is not None:
        found = enclosed(certified_for, rows, best)
    certified = None if isinstance(found, Missing) else found
    if certified is not None:
        load_factor = min(max(load_factor, certified[0]), certified[1])
    return DiscLimit(
        status=Status.OPTIMAL,
        load_factor=load_factor,
        x=best.x,
        multipliers=np.append(best.y.ravel(), best.gap_y),
        discs=_carrying(best),
        residual=rows.relative_excess(best.x, load_factor),
        certified=certified,
        exact=certified is not None,
        uncertified=found.reason if isinstance(found, Missing) else "",
        reduced_accuracy=best.accuracy > ACCURATE,
    )


def _carrying(end: DiscEnd) -> NDArray[np.intp]:
    """The discs that determine an end: those with a multiplier, in numbers near 1."""
    triples = end.scaled.program.cones.parts(end.end.multipliers)[1]
    return np.flatnonzero(triples[:, 0] > CARRIES * triples[:, 0].max(initial=0.0))


def _least(
    rows: DiscRows, basis: Basis, balanced: bool, tolerances: Tolerances
) -> tuple[float, tuple[str, ...]]:
    """λ_lo; NaN where its program fails, and that it did."""
    still = np.hypot(rows.c[:, 1], rows.c[:, 2]) <= rows.c[:, 0]
    if balanced or (np.all(still) and np.all(rows.gaps.g >= 0)):
        return 0.0, ()
    found = sought(end_of, scaled_discs(rows, basis, +1.0), tolerances)
    if isinstance(found, Missing):
        return nan, (f"λ_lo: {found.reason}",)
    return _least_of(rows, found, tolerances), ()


def _least_of(rows: DiscRows, end: DiscEnd, tolerances: Tolerances) -> float:
    if not end.optimal:
        return nan
    at_mean = rows.relative_excess(end.x, 0.0)
    return 0.0 if at_mean <= tolerances.feasibility else max(end.load_factor, 0.0)


def _infeasible(rows: DiscRows, end: DiscEnd, certified_for: Problem | None) -> DiscLimit:
    balance = (rows.sums @ end.y).ravel() @ rows.flat - end.gap_y @ rows.gaps.coefficients
    terms = (rows.sums @ np.abs(end.y)).ravel() @ np.abs(rows.flat)
    terms = terms + np.abs(end.gap_y) @ np.abs(rows.gaps.coefficients)
    proved = certified_for is not None and proved_infeasible(certified_for, rows, end)
    return DiscLimit(
        status=Status.INFEASIBLE,
        load_factor=nan,
        x=end.x,
        multipliers=np.append(end.y.ravel(), end.gap_y),
        discs=_carrying(end),
        residual=float(np.max(np.abs(balance) / np.where(terms > 0, terms, 1.0), initial=0.0)),
        exact=proved,
        uncertified=UNPROVED if certified_for is not None and not proved else "",
        reduced_accuracy=end.accuracy > ACCURATE,
    )


def _unbounded(
    rows: DiscRows,
    basis: Basis,
    direction: FloatArray,
    start: DiscEnd,
    certified_for: Problem | None,
    tolerances: Tolerances,
) -> DiscLimit:
    along = replace(rows, c=rows.e, gaps=_gap_loads(rows, -rows.gaps.d, rows.gaps.d))
    least, proved = _least_of(rows, start, tolerances), False
    if certified_for is not None:
        beyond = start.load_factor + start.scaled.load_unit
        safe = safest(rows, basis, beyond, tolerances).x
        proved = proved_unbounded(certified_for, rows, direction, (safe, beyond))
    return DiscLimit(
        status=Status.UNBOUNDED,
        load_factor=inf,
        x=direction,
        multipliers=np.zeros(3 * len(rows.c) + len(rows.gaps.g)),
        discs=np.zeros(0, dtype=np.intp),
        residual=along.relative_excess(direction, 0.0),
        least_load_factor=least,
        certified=(inf, inf) if proved else None,
        exact=proved,
        uncertified=UNPROVED if certified_for is not None and not proved else "",
    )


def _gap_loads(rows: DiscRows, g: FloatArray, d: FloatArray) -> Constraints:
    return replace(rows.gaps, g=g, d=d)


@dataclass(frozen=True, eq=False)
class ZoneLimit:
    """λ_max of a zone that is compared with others.

    Attributes
    ----------
    load_factor
        −inf where the zone has no safe slip, inf where nothing limits it.
    x : (k,)
        Where it is reached, at the unknowns of programs; empty without a limit.
    multipliers : (3j + o,)
        Of discs and gaps; empty where nothing limits it.
    margin
        By how much (negative) its limits exclude every slip under the mean load [length]; else 0.
    """

    load_factor: float
    x: FloatArray
    multipliers: FloatArray
    margin: float = 0.0


def zone_limit(rows: DiscRows, tolerances: Tolerances) -> ZoneLimit:
    """λ_max of a zone, for a search among zones."""
    nothing, found = np.zeros(0), largest_load_factor(rows, None, True, tolerances)
    if found.status == Status.UNBOUNDED:
        return ZoneLimit(inf, nothing, nothing)
    if found.status == Status.OPTIMAL:
        return ZoneLimit(found.load_factor, found.x, found.multipliers)
    margin = safest(rows, basis_of(rows), 0.0, tolerances).margin
    return ZoneLimit(-inf, nothing, found.multipliers, margin)


def wishes(
    rows: DiscRows, x: FloatArray, load_factor: float, multipliers: FloatArray, tolerances: Tolerances
) -> dict[int, float]:
    """How strongly limits ask for a node of the joint to be opened (at its apex) or closed (its gap presses).

    Without a safe slip (an empty x) a node is at its apex where its multipliers point inside the cone.
    """
    y, gap_y = multipliers[: 3 * len(rows.c)].reshape(-1, 3), multipliers[3 * len(rows.c) :]
    of_gaps = gap_y * np.maximum(np.abs(rows.gaps.G).max(axis=1, initial=0.0), np.abs(rows.gaps.d))
    wish = {int(rows.gaps.node[k]): float(of_gaps[k]) for k in np.flatnonzero(of_gaps > 0)}
    sizes = np.abs(rows.stiffness).max(axis=(1, 2))
    shares = (rows.sums @ y[:, 0]) * np.maximum(sizes, _largest_load(rows))
    if x.size:
        s = rows.c + load_factor * rows.e + (rows.flat @ x).reshape(-1, 3)[rows.node]
        terms = (np.abs(rows.flat) @ np.abs(x)).reshape(-1, 3)[rows.node] + np.abs(rows.c)
        apex = (np.abs(s) <= tolerances.feasibility * terms.max(axis=1)[:, None]).all(axis=1)
    else:
        apex = y[:, 0] > INSIDE * np.hypot(y[:, 1], y[:, 2])
        apex &= y[:, 0] > CARRIES * y[:, 0].max(initial=0.0)
    for node in np.unique(rows.node[apex]).tolist():
        wish[int(rows.names[node])] = float(shares[node])
    return wish


def _largest_load(rows: DiscRows) -> FloatArray:
    found = np.zeros(len(rows.stiffness))
    np.maximum.at(found, rows.node, np.abs(rows.e).max(axis=1))
    return found


@dataclass(frozen=True, eq=False)
class Safest:
    """The slip with most room at one load factor.

    Attributes
    ----------
    x : (k,)
        It, at the unknowns of programs [length].
    margin
        The radius of a ball of slips around it, all of them safe [length]; negative where none is.
    cap
        The largest margin that was looked for.
    discs
        Those that limit it.
    reduced_accuracy
        Whether the interior points reached less than their tolerances.
    """

    x: FloatArray
    margin: float
    cap: float
    discs: NDArray[np.intp]
    reduced_accuracy: bool


def safest(rows: DiscRows, basis: Basis, load_factor: float, tolerances: Tolerances) -> Safest:
    """max t: f p − |q| ≥ t (f |B_i| + |A_i|) at every node and load step, gaps likewise.

    A change δ of the slips changes f p − |q| by (f|B_i| + |A_i|) |δ| at most: slips up to t away are safe.
    The unknown of the program is t + cap ≥ 0.
    """
    slopes = np.linalg.norm(rows.stiffness[:, 0], axis=1) + np.linalg.norm(
        rows.stiffness[:, 1:], axis=(1, 2), ord=2
    )
    gap_slopes = np.linalg.norm(rows.gaps.coefficients, axis=1)
    c, g = rows.c + load_factor * rows.e, rows.gaps.g - load_factor * rows.gaps.d
    reach = np.abs(rows.c).max(axis=1) + np.abs(load_factor * rows.e).max(axis=1)
    gap_reach = np.abs(rows.gaps.g) + np.abs(load_factor * rows.gaps.d)
    steep, gap_steep = slopes[rows.node] > 0, gap_slopes > 0
    distances = np.append(
        reach[steep] / slopes[rows.node][steep], gap_reach[gap_steep] / gap_slopes[gap_steep]
    )
    cap = 2.0 * float(distances.max(initial=0.0)) or 1.0
    down = np.zeros_like(c)
    down[:, 0] = -slopes[rows.node]
    moved = replace(rows, c=c - cap * down, e=down, gaps=_gap_loads(rows, g + cap * gap_slopes, gap_slopes))
    end = end_of(scaled_discs(moved, basis, -1.0, 2.0 * cap), tolerances)
    return Safest(end.x, end.load_factor - cap, cap, _carrying(end), end.accuracy > ACCURATE)
