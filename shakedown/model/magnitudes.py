"""How large and how small numbers may be: beyond, products of three of them are no numbers any more."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from shakedown.errors import ProblemError

LARGEST = 1e100  # of a stiffness, force or length, in whatever units: its square is still a number
SMALLEST = 1e-100  # of the largest entry of an array that is not zero
NEGLIGIBLE = 1e-30  # entries so much smaller than the largest of their array are taken as zero
LARGEST_FRICTION = 1e12
LARGEST_LENGTH = 1e75  # of a slip, force over stiffness

STIFFNESS, FORCES = ("A", "B", "C"), ("q_w", "p_w", "q_mean", "p_mean", "q_transient", "p_transient")


def in_range(key: str, array: NDArray[np.float64]) -> NDArray[np.float64]:
    """A finite array whose size can be calculated with; what is negligible in it becomes zero.

    Raises
    ------
    ProblemError
        If its largest magnitude is neither 0 nor between 1e-100 and 1e100.

    Examples
    --------
    >>> in_range("A", np.array([2.0, 5e-324]))
    array([2., 0.])
    """
    sizes = np.abs(array)
    largest = float(sizes.max(initial=0.0))
    if largest and not SMALLEST <= largest <= LARGEST:
        raise ProblemError(
            f"key '{key}': expected the largest magnitude to be 0 or between {SMALLEST:g} and {LARGEST:g}, "
            f"found {largest:g} (choose other units)"
        )
    return np.where(sizes < NEGLIGIBLE * largest, 0.0, array)


def check_ratios(arrays: Mapping[str, NDArray[np.float64]]) -> None:
    """Check what the arrays of a problem, by key, mean for each other.

    Raises
    ------
    ProblemError
        If a friction coefficient exceeds 1e12, forces over stiffness are no
        lengths between 1e-75 and 1e75, or stiffness times the initial slip no
        forces below 1e100.
    """
    friction = _largest(arrays, ("f",))
    if friction > LARGEST_FRICTION:
        raise ProblemError(
            f"key 'f': expected friction coefficients up to {LARGEST_FRICTION:g}, found {friction:g}"
        )
    stiffness, force = _largest(arrays, STIFFNESS), _largest(arrays, FORCES)
    length = force / stiffness if stiffness else 0.0
    if length and not 1 / LARGEST_LENGTH <= length <= LARGEST_LENGTH:
        raise ProblemError(
            f"keys 'A', 'q_w', …: expected forces over stiffness between {1 / LARGEST_LENGTH:g} and "
            f"{LARGEST_LENGTH:g}, found {length:g}"
        )
    check_slip("key 'initial_slip'", stiffness, _largest(arrays, ("initial_slip",)))


def check_slip(what: str, stiffness: float, slip: float) -> None:
    """Raise ``ProblemError`` where an initial slip is so large that its reactions are no numbers."""
    if slip > LARGEST or stiffness * slip > LARGEST:
        raise ProblemError(
            f"{what}: expected slips with reactions up to {LARGEST:g}, found the slip {slip:g}"
        )


def _largest(arrays: Mapping[str, NDArray[np.float64]], keys: tuple[str, ...]) -> float:
    return max((float(np.abs(arrays[key]).max(initial=0.0)) for key in keys if key in arrays), default=0.0)
