"""Checks of the arguments that several functions take, and what is computed once for a problem."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from math import isfinite
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from shakedown.ground.argument_kinds import check_count, real_number, whole_number
from shakedown.ground.argument_kinds import checked as checked
from shakedown.ground.constants import FloatArray, T
from shakedown.ground.errors import UsageError
from shakedown.ground.shown_values import short
from shakedown.joint.fields import LARGEST, check_slip, finite_array
from shakedown.joint.problem import Problem

PLANE_SO_FAR = "it exists in the plane only, so far"  # the reason why one tangential direction is required
NO_SIDES = "it needs the two opposite limits of a node, and in space the limit is a disc"
NO_SIGNS = "uniqueness is decided by the signs of slips"


def is_finite(value: object) -> bool:
    """Whether a value is one finite real number, as a float."""
    number = real_number(value)
    return number is not None and isfinite(number)


def check_load_factor(load_factor: float, problem: Problem | None = None) -> None:
    """Raise ``UsageError`` unless a load factor is a finite number ≥ 0, with forces that are numbers."""
    if not (is_finite(load_factor) and float(load_factor) >= 0):
        raise UsageError(f"load factor: expected a finite number >= 0, found {short(load_factor)}")
    loads = () if problem is None else (problem.q_w, problem.p_w, problem.q_mean, problem.p_mean)
    largest = max((float(np.abs(load).max()) for load in loads if load is not None), default=1.0)
    if load_factor > LARGEST or load_factor * largest > LARGEST:
        raise UsageError(f"load factor: expected reactions up to {LARGEST:g}, found {short(load_factor)}")


def require_problem(problem: object) -> None:
    """Raise ``UsageError`` where something else is given as a problem."""
    if not isinstance(problem, Problem):
        raise UsageError(f"problem: expected a Problem, found {type(problem).__name__}")


def require_plane(what: str, problem: object, why: str = PLANE_SO_FAR) -> None:
    """Raise ``UsageError`` where a feature of joints in the plane is requested for a joint in space.

    Parameters
    ----------
    what
        What is asked for, in the words of the line.
    problem
        The joint; something else is refused, too.
    why
        Why only the plane has it.
    """
    require_problem(problem)
    assert isinstance(problem, Problem)
    if problem.directions > 1:
        raise UsageError(in_the_plane_only(what, why))


def in_the_plane_only(what: str, why: str = PLANE_SO_FAR) -> str:
    """A line that says that joints in space lack a feature, and why.

    Examples
    --------
    >>> in_the_plane_only("first collapse", NO_SIDES)
    'first collapse: expected one tangential direction, found two (it needs the two opposite limits ...)'
    """
    return f"{what}: expected one tangential direction, found two ({why})"


def real_array(name: str, values: ArrayLike) -> FloatArray:
    """A private float64 copy; raises ``UsageError`` unless all of it is real and finite."""
    return finite_array(name, name, values, UsageError)


def node_numbers(name: str, nodes: Iterable[int], n: int) -> tuple[int, ...]:
    """Some of n nodes by number, in the order given; raises ``UsageError`` for anything else."""
    found = []
    for node in nodes:
        number = whole_number(node)
        if number is None or not 0 <= number < n:
            raise UsageError(f"{name}: expected node numbers from 0 to {n - 1}, found {short(node)}")
        found.append(number)
    return tuple(found)


def check_arguments(load_factor: float, cycles: int, problem: Problem | None = None) -> None:
    """Raise ``UsageError`` where the load factor or the number of cycles is out of range."""
    check_load_factor(load_factor, problem)
    check_count("cycles", cycles)


def checked_initial_slip(
    problem: Problem, initial_slip: ArrayLike | None, name: str = "initial slip"
) -> FloatArray:
    """An initial slip as a private array (dn,), zero by default; raises ``UsageError`` if mis-shaped."""
    require_problem(problem)
    size = problem.layout.slip_size
    slip = np.zeros(size) if initial_slip is None else real_array(name, initial_slip)
    if slip.shape != (size,):
        raise UsageError(f"{name}: expected shape ({size},), found {slip.shape}")
    stiffness = max(float(np.abs(K).max()) for K in (problem.A, problem.B, problem.C) if K is not None)
    check_slip(name, stiffness, float(np.abs(slip).max()), UsageError)
    return slip


def checked_damping(problem: Problem, damping: ArrayLike | None) -> FloatArray | None:
    """The diagonal of D as a private array ((d + 1) n,); raises ``UsageError`` unless positive throughout."""
    if damping is None:
        return None
    D = real_array("damping", damping)
    size = problem.layout.size
    if D.shape != (size,) or not (D > 0).all():
        raise UsageError(f"damping: expected {size} positive numbers, found {damping}")
    return D


def once_per_problem(build: Callable[[Problem], T]) -> Callable[[Problem], T]:
    """Cache a function of a problem: computed at the first call, the same object afterwards.

    A :class:`Problem` does not change once it is made, nor may what is kept with
    it. Raises ``UsageError`` where something else is given as a problem.
    """
    name = f"{build.__module__}.{build.__qualname__}"

    @wraps(build)
    def kept(problem: Problem) -> T:
        require_problem(problem)
        results = problem.__dict__.setdefault("_derived", {})
        if name not in results:
            results[name] = build(problem)
        found: T = results[name]
        return found

    return kept


@contextmanager
def reused(problem: Problem, settings: object, build: Callable[[], T]) -> Iterator[T]:
    """A reusable search that is costly to build for a problem, for one user at a time.

    The last one with these settings, unless it is in use; else a new one.
    """
    results = problem.__dict__.setdefault("_derived", {})
    found: Any = results.pop("search", None)
    thing: T = found[1] if found is not None and found[0] == settings else build()
    yield thing
    results["search"] = settings, thing
