"""What every simulation is asked for and where it starts: load factor, cycles, slip, damping, ramp."""

import numpy as np
from numpy.typing import ArrayLike

from shakedown.arguments import check_count, check_load_factor, real_array, require_problem
from shakedown.errors import UsageError
from shakedown.problem import FloatArray, Problem


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
    return slip


def checked_damping(problem: Problem, damping: ArrayLike | None) -> FloatArray | None:
    """The diagonal of D as a private array (2n,); raises ``UsageError`` unless it is positive throughout."""
    if damping is None:
        return None
    D = real_array("damping", damping)
    if D.shape != (2 * problem.n,) or not (D > 0).all():
        raise UsageError(f"damping: expected {2 * problem.n} positive numbers, found {damping}")
    return D


def ramp_start(problem: Problem, first: FloatArray, start: FloatArray) -> FloatArray:
    """Welded reactions (2n,) from which the load rises to its first load step, all nodes stuck.

    Tangential reactions are zero, normal ones those of the first load step (in
    magnitude), so that an initial slip that is admissible there stays as it is.
    """
    n = problem.n
    locked_q, locked_p = problem.A @ start, problem.B @ start
    return np.concatenate([-locked_q, np.abs(first[n:] + locked_p) - locked_p])
