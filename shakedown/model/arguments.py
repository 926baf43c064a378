"""Checks of the arguments that several functions take."""

from math import isfinite
from numbers import Integral, Real

import numpy as np
from numpy.typing import ArrayLike

from shakedown.errors import ProblemError, UsageError
from shakedown.model.magnitudes import check_slip
from shakedown.model.problem import FloatArray, Problem
from shakedown.visible_text import shortened


def is_finite(value: object) -> bool:
    """Whether a value is one finite real number, as a float."""
    try:
        return isinstance(value, Real) and isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False


def check_load_factor(load_factor: float) -> None:
    """Raise ``UsageError`` unless a load factor is a finite number ≥ 0."""
    if not (is_finite(load_factor) and load_factor >= 0):
        raise UsageError(f"load factor: expected a number >= 0, found {shortened(repr(load_factor))}")


def check_count(name: str, count: int) -> None:
    """Raise ``UsageError`` unless a number of cycles, threads, … is whole and at least 1."""
    if not isinstance(count, Integral):
        raise UsageError(f"{name}: expected a whole number, found {count!r}")
    if count < 1:
        raise UsageError(f"{name}: expected at least 1, found {count}")


def require_problem(problem: object) -> None:
    """Raise ``UsageError`` where something else is given as a problem."""
    if not isinstance(problem, Problem):
        raise UsageError(f"problem: expected a Problem, found {type(problem).__name__}")


def real_array(name: str, values: ArrayLike) -> FloatArray:
    """A private float64 copy; raises ``UsageError`` unless all of it is real and finite."""
    try:
        array = np.array(values)
    except ValueError:  # ragged
        raise UsageError(f"{name}: expected a regular array of numbers, found ragged rows") from None
    if array.dtype.kind not in "fiu":
        raise UsageError(f"{name}: expected real numbers, found {values!r}")
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is not finite
        array = array.astype(np.float64)
    if not np.isfinite(array).all():
        raise UsageError(f"{name}: expected finite numbers, found {array[~np.isfinite(array)][0]}")
    return array


def check_arguments(load_factor: float, cycles: int) -> None:
    """Raise ``UsageError`` where the load factor or the number of cycles is out of range."""
    check_load_factor(load_factor)
    check_count("cycles", cycles)


def checked_initial_slip(problem: Problem, initial_slip: ArrayLike | None) -> FloatArray:
    """An initial slip as a private array (n,), zero by default; raises ``UsageError`` if mis-shaped."""
    require_problem(problem)
    slip = np.zeros(problem.n) if initial_slip is None else real_array("initial slip", initial_slip)
    if slip.shape != (problem.n,):
        raise UsageError(f"initial slip: expected shape ({problem.n},), found {slip.shape}")
    stiffness = max(float(np.abs(K).max()) for K in (problem.A, problem.B, problem.C) if K is not None)
    try:
        check_slip("initial slip", stiffness, float(np.abs(slip).max()))
    except ProblemError as error:
        raise UsageError(str(error)) from None
    return slip


def checked_damping(problem: Problem, damping: ArrayLike | None) -> FloatArray | None:
    """The diagonal of D as a private array (2n,); raises ``UsageError`` unless it is positive throughout."""
    if damping is None:
        return None
    D = real_array("damping", damping)
    if D.shape != (2 * problem.n,) or not (D > 0).all():
        raise UsageError(f"damping: expected {2 * problem.n} positive numbers, found {damping}")
    return D
