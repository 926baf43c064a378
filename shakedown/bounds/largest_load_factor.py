"""The largest load factor with a safe slip: its status, and what proves it."""

from dataclasses import dataclass, replace
from math import inf, nan

import numpy as np

from shakedown.bounds.certificate import (
    Disputed,
    certified_upper,
    contradiction,
    load_factor_program,
    significant,
)
from shakedown.bounds.discs.disc_rows import DiscRows
from shakedown.bounds.discs.enclosure import UNPROVED, enclosed, proved_infeasible, proved_unbounded
from shakedown.bounds.discs.scaled_solution import (
    Carrying,
    UnscaledSolution,
    safest,
    scaled_discs,
    solve_scaled,
)
from shakedown.ground.constants import CONE, NEGLIGIBLE, FloatArray
from shakedown.ground.errors import Missing, SolverError, sought
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem
from shakedown.programs.program import NOWHERE, Solution
from shakedown.programs.self_dual import USABLE
from shakedown.programs.simplex import solve, widest


@dataclass(frozen=True, eq=False)
class Largest:
    """The largest load factor with a safe slip, and what proves it; named as a ``Bound`` is.

    Attributes
    ----------
    x : (k,)
        Slips, or where unbounded their direction, at the unknowns of programs [length].
    y : (j, 3), z : (o,)
        Multipliers of discs and half-spaces.
    carrying
        The discs and half-spaces that determine it.
    end
        The end of the program that it is from, in the plane a linear one; of an unbounded one in space
        that of the program of the least load factor.
    """

    status: Status
    load_factor: float
    x: FloatArray
    y: FloatArray
    z: FloatArray
    carrying: Carrying
    residual: float
    least_load_factor: float = nan
    certified: tuple[float, float] | None = None
    exact: bool = False
    uncertified: str = ""
    missing: tuple[str, ...] = ()
    reduced_accuracy: bool = False
    disputed: bool = False
    end: UnscaledSolution | Solution | None = None

    @property
    def multipliers(self) -> FloatArray:
        """Of all rows, (3j + o,)."""
        return np.append(self.y.ravel(), self.z)


def largest_load_factor(
    rows: DiscRows, certified_for: Problem | None, balanced: bool, tolerances: Tolerances
) -> Largest:
    """λ_max of some limits, certified for the joint whose limits they are where it is given.

    ``balanced``: whether the loading has its own mean, so that a slip that is safe at any load factor is
    safe under the mean. Undecided where there seems to be no limit, but no direction of slips shows it.

    Raises
    ------
    SolverError
        If there is no end, or one that is not proved and misses its own conditions.
    """
    if (balanced, tolerances) not in rows.solved:  # usually just solved, by the search of the zone
        rows.solved[balanced, tolerances] = _limit(rows, balanced, tolerances)
    found: Largest = rows.solved[balanced, tolerances]
    if certified_for is not None:
        proved = _by_exact_arithmetic if rows.in_plane else _proved
        found = proved(certified_for, rows, found, tolerances)
    if found.status == Status.UNBOUNDED and not (found.exact or found.residual <= tolerances.feasibility):
        return replace(found, status=Status.UNDECIDED, load_factor=nan, x=np.full_like(found.x, nan))
    if rows.in_plane or found.status != Status.OPTIMAL or found.certified is not None:
        return found
    missed = _missed(rows, found)
    if not missed <= tolerances.stored_digits:
        raise SolverError(
            f"the largest load factor misses its own conditions: a relative residual of {missed:.1e}"
        )
    return replace(found, reduced_accuracy=found.reduced_accuracy or missed > tolerances.agreement)


def _missed(rows: DiscRows, found: Largest) -> float:
    """How far an optimum breaks its limits, relative to the loads, or is from what its multipliers prove.

    What is left of the balance of multipliers counts at the slips found.
    """
    x, at, y, z, H = found.x, found.load_factor, found.y, found.z, rows.half_spaces
    loads = np.maximum(np.abs(rows.c), at * np.abs(rows.e)).max(axis=1)
    sizes = np.maximum(loads, NEGLIGIBLE * loads.max())  # a smaller load is no scale of its own
    broken = float(np.max(-rows.slack(x, at)[0] / np.where(sizes > 0, sizes, 1.0), initial=0.0))
    balance = (rows.sums @ y).ravel() @ rows.flat - z @ H.coefficients
    gap = abs(np.vdot(y, rows.c) + z @ H.g - at) + np.abs(balance) @ np.abs(x)
    terms = np.vdot(np.abs(y), np.abs(rows.c)) + np.abs(z) @ np.abs(H.g)
    return max(found.residual, broken, float(gap / (terms if terms > 0 else 1.0)))


def relieving(rows: DiscRows) -> bool:
    """Whether the periodic loads bring no node nearer to its limits."""
    slack = rows.e[:, 0] - np.hypot(rows.e[:, 1], rows.e[:, 2])
    return bool(np.all(slack >= 0) and np.all(rows.half_spaces.d <= 0))


def _limit(rows: DiscRows, balanced: bool, tolerances: Tolerances) -> Largest:
    """The limit by programs."""
    direction = np.zeros(rows.stiffness.shape[-1])
    if rows.in_plane or not relieving(rows):
        found = _solved(rows, -1.0, tolerances)
        if found.status == Status.OPTIMAL:
            # λ_lo = 0 where λ_max is, as it is no larger
            least, missing = _least(rows, balanced or not found.load_factor, tolerances)
            return replace(found, least_load_factor=least, missing=missing)
        if found.status != Status.UNBOUNDED:
            return found
        direction = found.x
    if rows.in_plane:
        along, end = _direction(rows, tolerances), found.end
        least, missing = _least(rows, balanced, tolerances)
        if isinstance(along, Missing):
            missing = (*missing, f"direction: {along.reason}")
            return replace(found, load_factor=inf, residual=nan, least_load_factor=least, missing=missing)
        direction = along
    else:
        start = _solved(rows, +1.0, tolerances)
        if start.status != Status.OPTIMAL:
            return start
        least, missing, end = _unless_safe_at_mean(rows, start, tolerances), (), start.end
    none, nothing = np.zeros_like(rows.c), np.zeros_like(rows.half_spaces.g)
    return Largest(
        Status.UNBOUNDED, inf, direction, none, nothing, NOWHERE, _excess_along(rows, direction),
        least_load_factor=least, missing=missing, end=end,
        reduced_accuracy=rows.in_plane and found.reduced_accuracy,
    )  # fmt: skip


def _solved(rows: DiscRows, towards: float, tolerances: Tolerances) -> Largest:
    """The largest (−1) or the smallest (+1) load factor, or that no slip is safe, which multipliers show.

    By a linear program over the rows in the plane, in space by a cone program over discs.
    """
    H, missing = rows.half_spaces, tuple[str, ...]()
    if rows.in_plane:
        end: UnscaledSolution | Solution = solve(load_factor_program(H, towards, tolerances))
        x, at, y, z = end.x[:-1], float(end.x[-1]), np.zeros((0, CONE)), np.zeros_like(H.g)
        carrying = NOWHERE
        if end.optimal:
            z, carrying = end.multipliers, (rows.node, end.meeting[0])
        elif end.status == Status.INFEASIBLE:
            against = sought(contradiction, H, tolerances)
            if isinstance(against, Missing):
                z, missing = np.full_like(H.g, nan), (f"multipliers: {against.reason}",)
            else:
                z, carrying = against.multipliers, (rows.node, np.flatnonzero(against.multipliers))
    else:
        usable = tolerances.stored_digits if towards < 0 else USABLE  # the largest is computed anew
        end = solve_scaled(scaled_discs(rows, towards), usable)
        x, at, y, z, carrying = end.x, end.load_factor, end.y, end.z, end.carrying
    residual = rows.relative_excess(x, at) if end.optimal else _imbalance(rows, y, z)
    reduced = end.reduced_accuracy
    return Largest(
        end.status, at, x, y, z, carrying, residual, reduced_accuracy=reduced, missing=missing, end=end
    )


def _direction(rows: DiscRows, tolerances: Tolerances) -> FloatArray | Missing:
    """x with G v + d ≤ 0 in the plane, with slack where possible."""
    H = rows.half_spaces
    if relieving(rows):
        return np.zeros(H.n)
    norms = np.linalg.norm(H.G, axis=1)
    cap = float(np.max(np.abs(H.d)[norms > 0] / norms[norms > 0], initial=0.0))
    found = sought(widest, H.coefficients, norms, -H.d, cap=cap, tolerances=tolerances)
    return found if isinstance(found, Missing) else found.x


def _by_exact_arithmetic(problem: Problem, rows: DiscRows, found: Largest, tolerances: Tolerances) -> Largest:
    """The limit of a joint in the plane as exact arithmetic has it, its status included."""
    if not isinstance(found.end, Solution):
        return found
    exact = sought(certified_upper, problem, found.end, tolerances)
    if isinstance(exact, Missing):
        return replace(found, uncertified=exact.reason, disputed=isinstance(exact, Disputed))
    proved = replace(
        found,
        status=exact.status,
        load_factor=exact.load_factor,
        x=np.full(len(exact.slip), nan),
        z=exact.multipliers,
        carrying=(rows.node, np.array(exact.rows, dtype=np.intp)),
        exact=True,
    )
    if exact.status == Status.INFEASIBLE:
        residual = _imbalance(rows, found.y, exact.multipliers)
        return replace(proved, residual=residual, least_load_factor=nan, missing=())
    if found.status == Status.INFEASIBLE:  # at loosened tolerances
        least, missing = _least(rows, False, tolerances)
        proved = replace(proved, least_load_factor=least, missing=missing)
    if exact.status == Status.UNBOUNDED:
        known = found.status == Status.UNBOUNDED and found.residual <= 0
        x = found.x if known else exact.slip
        residual = _excess_along(rows, x)
    else:
        x = significant(rows.half_spaces, exact.slip, exact.load_factor, tolerances)[:-1]
        residual = rows.relative_excess(x, exact.load_factor)
    return replace(proved, x=x, residual=residual, certified=(exact.low, exact.high))


def _least(rows: DiscRows, balanced: bool, tolerances: Tolerances) -> tuple[float, tuple[str, ...]]:
    """λ_lo; NaN where its program fails, and that it did."""
    H, still = rows.half_spaces, np.hypot(rows.c[:, 1], rows.c[:, 2]) <= rows.c[:, 0]
    # a safe slip is safe at every smaller load factor; or v = 0 is safe under the mean load
    if balanced or (np.all(still) and np.all(H.g >= 0)) or (rows.in_plane and np.all(H.d >= 0)):
        return 0.0, ()
    found = sought(_solved, rows, +1.0, tolerances)
    if isinstance(found, Missing):
        return nan, (f"λ_lo: {found.reason}",)
    return (_unless_safe_at_mean(rows, found, tolerances) if found.status == Status.OPTIMAL else nan), ()


def _unless_safe_at_mean(rows: DiscRows, found: Largest, tolerances: Tolerances) -> float:
    """The least load factor at which a slip is safe, 0 where this one is so under the mean load."""
    safe = rows.relative_excess(found.x, 0.0) <= tolerances.feasibility
    return 0.0 if safe else max(found.load_factor, 0.0)


def _imbalance(rows: DiscRows, y: FloatArray, z: FloatArray) -> float:
    """What is left of the balance of multipliers, relative to its terms."""
    balance = (rows.sums @ y).ravel() @ rows.flat - z @ rows.half_spaces.coefficients
    terms = (rows.sums @ np.abs(y)).ravel() @ np.abs(rows.flat)
    terms = terms + np.abs(z) @ np.abs(rows.half_spaces.coefficients)
    return float(np.max(np.abs(balance) / np.where(terms > 0, terms, 1.0), initial=0.0))


def _excess_along(rows: DiscRows, direction: FloatArray) -> float:
    """The largest relative violation of e + N v along a direction."""
    gaps = replace(rows.half_spaces, g=-rows.half_spaces.d, d=np.zeros_like(rows.half_spaces.d))
    return replace(rows, c=rows.e, e=np.zeros_like(rows.e), half_spaces=gaps).relative_excess(direction, 0.0)


def _proved(problem: Problem, rows: DiscRows, found: Largest, tolerances: Tolerances) -> Largest:
    """The limit of a joint in space with what is proved of it."""
    end = found.end
    if not isinstance(end, UnscaledSolution):
        return found
    if found.status == Status.OPTIMAL:
        enclosure = enclosed(problem, rows, end, tolerances)
        if isinstance(enclosure, Missing):
            return replace(found, uncertified=enclosure.reason)
        at = float(np.clip(found.load_factor, *enclosure))
        return replace(found, load_factor=at, certified=enclosure, exact=True)
    if found.status == Status.INFEASIBLE:
        proved = proved_infeasible(problem, rows, end)
        return replace(found, exact=proved, uncertified="" if proved else UNPROVED)
    beyond = end.load_factor + end.scaled.load_unit
    far = [safest(rows, beyond).x, end.x + end.scaled.load_unit * found.x]
    if not proved_unbounded(problem, rows, found.x, [*((x, beyond) for x in far), (0.0 * found.x, 0.0)]):
        return replace(found, uncertified=UNPROVED)
    return replace(found, certified=(inf, inf), exact=True)
