"""The largest load factor under rows, by a linear program: its status, what proves it, where it begins."""

from dataclasses import replace
from math import inf, nan

import numpy as np

from shakedown.bounds.certificate import Certificate, Disputed, certified_upper, significant
from shakedown.bounds.results import NO_SAFE_STATE, RELIEVING, WEDGING, ZERO_AMPLITUDE, UpperBound
from shakedown.bounds.row_programs import contradiction, load_factor_program
from shakedown.ground.evidence import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints, rows_named
from shakedown.joint.problem import Problem
from shakedown.programs.margin import widest
from shakedown.programs.program import Solution
from shakedown.programs.solver import solve


def limit_of_rows(problem: Problem, rows: Constraints, certify: bool, tolerances: Tolerances) -> UpperBound:
    """λ_max of a joint in the plane over some of its rows; in exact arithmetic where asked for."""
    outcome = solve(load_factor_program(rows, towards=-1.0, tolerances=tolerances))
    found: Certificate | Missing = Missing("")
    if certify:
        found = sought(certified_upper, problem, outcome, tolerances)
    certificate = found if isinstance(found, Certificate) else None
    status = outcome.status if certificate is None else certificate.status
    answer = {Status.OPTIMAL: _optimal, Status.INFEASIBLE: _infeasible, Status.UNBOUNDED: _unbounded}[status]
    return replace(
        answer(rows, outcome, certificate, tolerances),
        uncertified=found.reason if isinstance(found, Missing) else "",
        disputed=isinstance(found, Disputed),
        reduced_accuracy=outcome.reduced_accuracy,
        pinned=rows.pinned,
        in_floats=_in_floats(rows, outcome),
    )


def _in_floats(rows: Constraints, outcome: Solution) -> FloatArray:
    """The slip and the load factor that a program found, (n + 1,); NaN where it found none."""
    if not outcome.optimal:
        return np.full(rows.n + 1, nan)
    return np.append(rows.slips(outcome.x[:-1]), outcome.x[-1])


def _optimal(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> UpperBound:
    if certificate is not None:
        load_factor, y = certificate.load_factor, certificate.multipliers
        slip = significant(rows, certificate.slip, load_factor, tolerances)[:-1]
        active, certified = np.array(certificate.rows, dtype=np.intp), (certificate.low, certificate.high)
    else:
        slip, load_factor = _in_floats(rows, outcome)[:-1], float(outcome.x[-1])
        y, active, certified = outcome.multipliers, outcome.meeting[0], None
    least, missing = _least(rows, tolerances)
    return UpperBound(
        status=Status.OPTIMAL,
        load_factor=load_factor,
        slip=slip,
        active=rows_named(rows, active),
        multipliers=y,
        direction=np.full(rows.n, nan),
        reason="",
        residual=float(rows.relative_excess(slip, load_factor).max()),
        least_load_factor=least,
        certified=certified,
        exact=certificate is not None,
        missing=missing,
    )


def _least(rows: Constraints, tolerances: Tolerances) -> tuple[float, tuple[str, ...]]:
    """λ_lo; NaN where its program fails, and that it did."""
    found = sought(least_load_factor, rows, tolerances)
    return (nan, (f"λ_lo: {found.reason}",)) if isinstance(found, Missing) else (found, ())


def least_load_factor(rows: Constraints, tolerances: Tolerances) -> float:
    """λ_lo ≥ 0, from where on there are safe slips; NaN where there are none."""
    # What is safe is so at every smaller load factor; or v = 0 is safe under the mean load.
    if np.all(rows.d >= 0) or np.all(rows.g >= 0):
        return 0.0
    least = solve(load_factor_program(rows, towards=+1.0, tolerances=tolerances))
    if not least.optimal:
        return nan
    at_mean = rows.relative_excess(rows.slips(least.x[:-1]), 0.0).max()
    return 0.0 if at_mean <= tolerances.feasibility else float(least.x[-1])


def _infeasible(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> UpperBound:
    y, missing = np.full(len(rows.g), nan), tuple[str, ...]()
    if certificate is not None:
        y = certificate.multipliers
    else:
        found = sought(contradiction, rows, tolerances)
        if isinstance(found, Missing):
            missing = (f"multipliers: {found.reason}",)
        else:
            y = found.multipliers
    terms = np.abs(y) @ np.abs(rows.G)
    return UpperBound(
        status=Status.INFEASIBLE,
        load_factor=nan,
        slip=np.full(rows.n, nan),
        active=rows_named(rows, np.flatnonzero(y != 0)) if not missing else (),
        multipliers=y,
        direction=np.full(rows.n, nan),
        reason=NO_SAFE_STATE,
        residual=float(np.max(np.abs(y @ rows.coefficients) / np.where(terms > 0, terms, 1.0))),
        least_load_factor=nan,
        certified=None,
        exact=certificate is not None,
        missing=missing,
    )


def _unbounded(
    rows: Constraints, outcome: Solution, certificate: Certificate | None, tolerances: Tolerances
) -> UpperBound:
    least, missing = _least(rows, tolerances)
    if np.all(rows.d <= 0):
        direction, reason = np.zeros(rows.n), ZERO_AMPLITUDE if not np.any(rows.d) else RELIEVING
    else:
        found, reason = sought(_widest_direction, rows, certificate, tolerances), WEDGING
        if isinstance(found, Missing):
            direction, missing = np.full(rows.n, nan), (*missing, f"direction: {found.reason}")
        else:
            direction = found
    terms = np.maximum(np.max(np.abs(rows.G * direction), axis=1), np.abs(rows.d))
    excess = (rows.G @ direction + rows.d) / np.where(terms > 0, terms, 1.0)
    return UpperBound(
        status=Status.UNBOUNDED,
        load_factor=inf,
        slip=np.full(rows.n, nan),
        active=(),
        multipliers=np.zeros(len(rows.g)),
        direction=direction,
        reason=reason,
        residual=float(excess.max()),
        least_load_factor=least,
        missing=missing,
        certified=None if certificate is None else (inf, inf),
        exact=certificate is not None,
    )


def _widest_direction(
    rows: Constraints, certificate: Certificate | None, tolerances: Tolerances
) -> FloatArray:
    """v with G v + d ≤ 0, with slack to spare where there is any."""
    norms = np.linalg.norm(rows.G, axis=1)
    cap = float(np.max(np.abs(rows.d)[norms > 0] / norms[norms > 0], initial=0.0))
    found = widest(rows.coefficients, norms, -rows.d, cap=cap, tolerances=tolerances)
    return rows.slips(found.x) if found.margin >= 0 or certificate is None else certificate.slip
