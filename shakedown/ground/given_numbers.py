"""Numbers as they are given: whatever NumPy would take for one number, as a float or an int of Python."""

from decimal import Decimal
from numbers import Integral, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

LARGEST_WHOLE = int(np.iinfo(np.int64).max) + 1  # numbers from here on no compiled loop can count


def real_number(value: object) -> float | None:
    """A real number as a float, NaN and infinity among them; None of anything else.

    Fractions, decimal numbers, numbers of NumPy and arrays without axes are numbers; flags, text and
    what is beyond all floats are none.

    Examples
    --------
    >>> from fractions import Fraction
    >>> real_number(Fraction(1, 4)), real_number(np.int64(3)), real_number(True), real_number(10**400)
    (0.25, 3.0, None, None)
    """
    value = _without_axes(value)
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real | Decimal):
        return None
    try:
        return float(value)
    except (OverflowError, ValueError):  # a signalling NaN of decimal numbers
        return None


def whole_number(value: object) -> int | None:
    """A whole number that can be counted to as an int; None of anything else.

    Examples
    --------
    >>> whole_number(np.int64(3)), whole_number(3.0), whole_number(True), whole_number(10**400)
    (3, None, None, None)
    """
    value = _without_axes(value)
    if isinstance(value, bool | np.bool_) or not isinstance(value, Integral):
        return None
    found = int(value)
    return found if abs(found) < LARGEST_WHOLE else None


def real_values(values: ArrayLike) -> NDArray[Any]:
    """What is given as an array; one of Python's objects becomes floats where all are numbers.

    Raises
    ------
    ValueError
        If it is ragged.

    Examples
    --------
    >>> from fractions import Fraction
    >>> real_values([Fraction(1, 2), 1])
    array([0.5, 1. ])
    """
    array = np.asarray(values)
    if array.dtype.kind != "O":
        return array
    numbers = [real_number(value) for value in array.ravel()]
    if not numbers or None in numbers:
        return array
    return np.array(numbers, dtype=np.float64).reshape(array.shape)


def _without_axes(value: object) -> object:
    return value.item() if isinstance(value, np.ndarray) and value.ndim == 0 else value
