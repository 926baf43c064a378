"""The rows of a problem as a linear program, in floats and without round-off."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.constants import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import once_per_problem
from shakedown.joint.constraints import Constraints, pressure_stiffness
from shakedown.joint.law import Law
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.joint.rigid_slips import rigid_slips
from shakedown.programs.exact_program import IntegerRows
from shakedown.programs.program import INF, Program
from shakedown.programs.solver import Widest, widest


def load_factor_program(rows: Constraints, towards: float, tolerances: Tolerances = DEFAULT) -> Program:
    """Maximise (−1) or minimise (+1) λ ≥ 0 over the columns (v, λ), subject to every row."""
    return Program(
        np.column_stack([rows.coefficients, rows.d]),
        rows.g,
        cost=np.append(np.zeros(rows.n), towards),
        cones=() if len(rows.heads) == len(rows.g) else tuple(rows.cones.tolist()),
        lower=np.append(np.full(rows.n, -INF), 0.0),
        tolerances=tolerances,
    )


def reversed_rows(program: Program, chosen: NDArray[np.bool_]) -> Program:
    """The program with some rows reversed: upper limits become lower limits."""
    return program.with_signs(np.where(chosen, -1.0, 1.0))


def contradiction(rows: Constraints, tolerances: Tolerances) -> Widest:
    """How far the rows exclude every safe slip at any load factor, and the multipliers that show it."""
    matrix = np.column_stack([rows.coefficients, rows.d])
    sizes = np.abs(matrix).max(axis=1)
    norms = np.where(sizes > 0, sizes, 1.0)
    return widest(matrix, norms, rows.g, cap=INF, signed=rows.n, tolerances=tolerances)


Exact = NDArray[np.object_]  # fractions (FLINT's fmpq), element by element


@dataclass(frozen=True)
class ExactRows:
    """The constraint rows of the problem as stored, each scaled to integers by a positive number.

    Attributes
    ----------
    matrix
        [G | d], r rows of n + 1 integers; zero in the columns of pinned slips.
    right
        g, r integers.
    factors
        Those positive numbers.
    """

    matrix: IntegerRows
    right: list[int]
    factors: list[Fraction]


@once_per_problem
def exact_rows(problem: Problem) -> ExactRows:
    """The rows of ``constraints(problem)``, in the unknowns of programs, without any round-off.

    Built once per problem. The columns of pinned slips are zero, and so are pressures without friction that
    are round-off: exact arithmetic would take what stands there for a spring.

    Every stored number is a binary fraction, so the rows are rational: the sample
    mean divides by m. A column of the loading that ``loading`` takes as constant, or as without a mean,
    is so here too.

    Examples
    --------
    >>> import shakedown
    >>> loop = {"q_w": [[1.0], [-1.0]], "p_w": [[3.0], [3.0]]}
    >>> rows = exact_rows(shakedown.Problem(A=[[2.0]], B=[[0.5]], f=0.5, **loop))
    >>> [[x / rows.matrix[0][1] for x in row] for row in rows.matrix], rows.right[0] / rows.matrix[0][1]
    ([[1.75, 1.0], [-2.25, 1.0]], 1.5)
    """
    rigid = rigid_slips(problem)
    A, B = (exact_numbers(rigid.columns(part)) for part in (problem.A, pressure_stiffness(problem)))
    loop = loading(problem)
    q0 = _mean(problem.q_w, problem.q_mean, loop.q0)
    p0 = _mean(problem.p_w, problem.p_mean, loop.p0)
    law = Law(exact_numbers(problem.f))
    return _whole(np.column_stack([law.stiffness(A, B), _extremes(problem, law, q0, p0), law.cone(q0, p0)]))


def exact_numbers(array: FloatArray) -> Exact:
    """Stored numbers as fractions, element by element."""
    from flint import fmpq

    flat = [fmpq(*x.as_integer_ratio()) for x in array.ravel().tolist()]
    exact = np.empty(len(flat), dtype=object)
    exact[:] = flat
    return exact.reshape(array.shape)


def _mean(samples: FloatArray, given: FloatArray | None, in_floats: FloatArray) -> Exact:
    if given is not None:
        return exact_numbers(in_floats)
    return np.asarray(exact_numbers(np.where(in_floats != 0.0, samples, 0.0)).sum(axis=0) / len(samples))


def _extremes(problem: Problem, law: Law, q0: Exact, p0: Exact) -> Exact:
    """d: the largest of ±q¹ − f p¹ over the load steps."""
    loop = loading(problem)
    q1, p1 = (
        np.where((periodic != 0.0).any(axis=0), exact_numbers(samples) - mean, mean - mean)
        for periodic, samples, mean in ((loop.q1, problem.q_w, q0), (loop.p1, problem.p_w, p0))
    )
    return np.asarray(law.against(q1, p1).max(axis=0))


def _whole(rows: Exact) -> ExactRows:
    """Every row times the least common denominator of its entries."""
    from flint import fmpq_mat

    matrix: IntegerRows = []
    right: list[int] = []
    factors: list[Fraction] = []
    for row in rows.tolist():
        numerators, denominator = fmpq_mat(1, len(row), row).numer_denom()
        *left, last = (int(x) for x in numerators.entries())
        matrix.append(left)
        right.append(last)
        factors.append(Fraction(int(denominator)))
    return ExactRows(matrix, right, factors)
