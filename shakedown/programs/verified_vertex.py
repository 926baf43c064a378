"""The optimal vertex of a linear program, proved by exact residuals instead of an exact solution."""

from __future__ import annotations

from math import ldexp
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.round_off import EPS, SIX_DIGITS
from shakedown.ground.size_limits import DENSE_FROM
from shakedown.ground.status import Status
from shakedown.programs.exact_program import ExactProgram, ExactVertex
from shakedown.programs.integer_algebra import enclosure, integer_matrix, product

if TYPE_CHECKING:
    from flint import fmpz_mat

Bits = NDArray[np.intc]

DIGITS = 220  # bits of the solutions behind the point
REFINEMENTS = 12  # each adds what the condition of the matrix leaves of 53 bits
ROUNDING = EPS / 2
SAFETY = 1.0 + SIX_DIGITS  # covers the rounding of sums of numbers ≥ 0, and of integers converted to floats


def verified_vertex(program: ExactProgram, active: list[int], free: list[int]) -> ExactVertex | None:
    """The optimum where the active rows meet, if that can be proved with a margin; None where it cannot.

    With an approximate inverse R and ‖1 − R M‖ ≤ α < 1 the solution of M x = b is within
    ‖R (b − M x̃)‖ / (1 − α) of x̃, whatever x̃ is; the residual is computed in integers, so that a few
    refinements give x and the multipliers y to sixty digits. If with that error all
    other rows hold and every y is positive, the exact vertex is the optimum.

    Returns
    -------
        Numerators and denominators (powers of two) of x and y, so near to the exact ones that
        cost · x lies between the same two neighbouring floats. None also where a further row meets
        the vertex, a multiplier vanishes, or the optimum is a float: exact arithmetic has to tell.
    """
    if len(active) < DENSE_FROM or len(active) != len(free) or not program.depends_only_on(free):
        return None
    try:
        end = _verified(program.columns(free), active)
    except (OverflowError, np.linalg.LinAlgError):  # beyond the range of floats, or no vertex at all
        return None
    return None if end is None else end.among(free, len(program.cost))


def _verified(program: ExactProgram, active: list[int]) -> ExactVertex | None:
    table = np.array(program.matrix, dtype=object).astype(float)
    row_bits, column_bits = _bits(table[active])
    scaled = np.ldexp(table[active], row_bits[:, None] + column_bits)
    inverse: FloatArray = np.asarray(np.linalg.inv(scaled), dtype=float)
    square = integer_matrix([program.matrix[i] for i in active])
    right = [program.right[i] for i in active]
    x = _refined(square, right, inverse, scaled, row_bits, column_bits)
    y = _refined(square.transpose(), program.cost, inverse.T, scaled.T, column_bits, row_bits)
    if x is None or y is None or not _positive(y, row_bits):
        return None
    if not _others_hold(program, table, active, x, column_bits) or not _one_float(program, x, column_bits):
        return None
    multipliers = dict(zip(active, y.numerators, strict=True))
    return ExactVertex(Status.OPTIMAL, x.numerators, 1 << x.bits, multipliers, 1 << y.bits)


class _Refined(NamedTuple):
    """Numerators over 2**bits, and by how much each is off at most, in units of its column."""

    numerators: list[int]
    bits: int
    error: float


def _bits(matrix: FloatArray) -> tuple[Bits, Bits]:
    """Exponents of two by which rows and columns are multiplied, so that the entries are near 1."""
    rows = -np.frexp(np.abs(matrix).max(axis=1))[1]
    columns = np.abs(np.ldexp(matrix, rows[:, None])).max(axis=0)
    return rows, -np.frexp(columns)[1]


def _left_over(inverse: FloatArray, matrix: FloatArray) -> float:
    """A bound on the largest row sum of 1 − R M, where every entry of M is rounded once."""
    size = len(matrix)
    rest = np.abs(np.eye(size) - inverse @ matrix)
    rounding = (size + 4) * ROUNDING * (np.abs(inverse) @ np.abs(matrix) + np.eye(size))
    return float((rest + rounding).sum(axis=1).max() * SAFETY)


def _refined(
    matrix: fmpz_mat,
    right: list[int],
    inverse: FloatArray,
    scaled: FloatArray,
    row_bits: Bits,
    column_bits: Bits,
) -> _Refined | None:
    """The solution of matrix · x = right, by refinement with exact residuals."""
    left_over = _left_over(inverse, scaled)
    if not left_over < 0.5:
        return None
    rows, columns = row_bits.tolist(), column_bits.tolist()
    largest = max(x.bit_length() + k for x, k in zip(right, rows, strict=True))
    bits = max(DIGITS - min(columns) - largest, 0)
    numerators = [0] * len(right)
    residual = _residual(matrix, right, numerators, bits, rows)
    for _ in range(REFINEMENTS):
        change = inverse @ residual
        if np.abs(change).max() <= ldexp(1.0, largest - DIGITS + 32):
            break
        steps = [round(ldexp(d, bits + k)) for d, k in zip(change, columns, strict=True)]
        numerators = [x + step for x, step in zip(numerators, steps, strict=True)]
        residual = _residual(matrix, right, numerators, bits, rows)
    error = float((np.abs(inverse) @ np.abs(residual)).max()) * SAFETY / (1.0 - left_over)
    return _Refined(numerators, bits, error)


def _residual(
    matrix: fmpz_mat, right: list[int], numerators: list[int], bits: int, rows: list[int]
) -> FloatArray:
    """right − matrix · x, computed in integers, in units of the rows."""
    values = product(matrix, numerators)
    return np.array([_float((b << bits) - v, k - bits) for b, v, k in zip(right, values, rows, strict=True)])


def _float(number: int, exponent: int) -> float:
    """number · 2**exponent, rounded."""
    cut = max(number.bit_length() - 64, 0)
    return ldexp(float(number >> cut), cut + exponent)


def _positive(y: _Refined, row_bits: Bits) -> bool:
    values = [_float(number, -y.bits - k) for number, k in zip(y.numerators, row_bits.tolist(), strict=True)]
    return min(values) > y.error * SAFETY


def _others_hold(
    program: ExactProgram, table: FloatArray, active: list[int], x: _Refined, column_bits: Bits
) -> bool:
    """Whether all rows that are not active hold, with room for the error of x."""
    values, hold = product(program.table, x.numerators), []
    reach = (np.abs(np.ldexp(table, column_bits)).sum(axis=1) * (x.error * SAFETY)).tolist()
    meeting = set(active)
    for i, (value, right) in enumerate(zip(values, program.right, strict=True)):
        if i not in meeting:
            hold.append(_float((right << x.bits) - value, -x.bits) > reach[i] * SAFETY)
    return all(hold)


def _one_float(program: ExactProgram, x: _Refined, column_bits: Bits) -> bool:
    """Whether cost · x lies between the same two floats throughout the error of x."""
    value = sum(c * number for c, number in zip(program.cost, x.numerators, strict=True))
    steps = (
        ldexp(x.error * SAFETY, x.bits + k) * abs(c)
        for c, k in zip(program.cost, column_bits.tolist(), strict=True)
    )
    step = int(sum(steps)) + 1
    ends = [enclosure(value + sign * step, 1 << x.bits) for sign in (-1, 1)]
    return ends[0] == ends[1] and ends[0][0] < ends[0][1]
