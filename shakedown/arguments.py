"""Checks of the arguments that several functions take."""

from math import isfinite
from numbers import Integral

from shakedown.errors import UsageError


def check_load_factor(load_factor: float) -> None:
    """Raise ``UsageError`` unless a load factor is a finite number ≥ 0."""
    if not (isfinite(load_factor) and load_factor >= 0):
        raise UsageError(f"load factor: expected a number >= 0, found {load_factor}")


def check_count(name: str, count: int) -> None:
    """Raise ``UsageError`` unless a number of cycles, threads, … is whole and at least 1."""
    if not isinstance(count, Integral):
        raise UsageError(f"{name}: expected a whole number, found {count}")
    if count < 1:
        raise UsageError(f"{name}: expected at least 1, found {count}")
