"""The exceptions that the toolkit raises, in one tree."""

from collections.abc import Iterator
from contextlib import contextmanager

from shakedown.ground.visible_text import one_line


class ShakedownError(Exception):
    """Base class of every exception that the toolkit raises on purpose.

    Its text is one line of bounded length without control characters, whatever
    names, keys and paths went into it.
    """

    def __str__(self) -> str:
        return one_line(super().__str__())


class ProblemError(ShakedownError, ValueError):
    """The problem data are wrong; the message says what, where, expected and found."""


class UsageError(ShakedownError, ValueError):
    """An argument of a library call is outside what the call is defined for."""


class BudgetExceeded(ShakedownError):
    """The work asked for is larger than the budget; nothing was computed."""


class SolverError(ShakedownError, RuntimeError):
    """A numerical solver ended in a state from which no checked result follows."""


@contextmanager
def found_in(where: object) -> Iterator[None]:
    """Say of a ``ProblemError`` that is raised inside in what it was found."""
    try:
        yield
    except ProblemError as error:
        raise ProblemError(f"{where}: {error}") from None
