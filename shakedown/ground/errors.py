"""The exceptions that the toolkit raises, in one tree, and what is missing where an optional step failed."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Literal

from shakedown.ground.constants import P, T
from shakedown.ground.shown_values import one_line


class ShakedownError(Exception):
    """Base class of every exception that the toolkit raises on purpose.

    Its text is one line of bounded length without control characters, whatever
    names, keys and paths went into it.
    """

    def __str__(self) -> str:
        return one_line(super().__str__())


class ProblemError(ShakedownError, ValueError):
    """The problem data are wrong; the message says what, where, expected and found."""


def wrong_key(key: str, expected: str, found: object) -> ProblemError:
    """The error of a problem in which the value of a key is not what is expected."""
    return ProblemError(f"key '{key}': expected {expected}, found {found}")


class UsageError(ShakedownError, ValueError):
    """An argument of a library call is outside what the call is defined for."""


class BudgetExceeded(ShakedownError):
    """The work asked for is larger than the budget; nothing was computed."""


class SolverError(ShakedownError, RuntimeError):
    """A numerical solver ended in a state from which no checked result follows."""


def not_installed(where: str, package: str, extra: str) -> str:
    """The line about an optional package that is missing, with the command that installs it from a clone.

    Examples
    --------
    >>> not_installed("to_frame", "pandas", "frames")
    "to_frame: expected pandas, found it not installed; in a clone: pip install '.[frames]'"
    """
    return f"{where}: expected {package}, found it not installed; in a clone: pip install '.[{extra}]'"


@contextmanager
def found_in(where: object) -> Iterator[None]:
    """Add to a ``ProblemError`` raised inside where it was found."""
    try:
        yield
    except ProblemError as error:
        raise ProblemError(f"{where}: {error}") from None


@dataclass(frozen=True)
class Missing:
    """Evidence that was not found, with the reason in words."""

    reason: str

    def __bool__(self) -> Literal[False]:
        """False: there is none."""
        return False

    def to_dict(self) -> None:
        """In a document it is null."""


def attempt(step: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | Missing:
    """The result of a step; where its solver does not finish, the reason. Nothing else is caught.

    Examples
    --------
    >>> def fails(x):
    ...     raise SolverError("the linear program ended as 'Unknown'")
    >>> attempt(abs, -3), attempt(fails, -3)
    (3, Missing(reason="the linear program ended as 'Unknown'"))
    """
    return _caught(SolverError, step, *args, **kwargs)


def attempt_any(step: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | Missing:
    """The same where a step may also refuse its arguments, as one point among many that need not exist."""
    return _caught(ShakedownError, step, *args, **kwargs)


def present(found: T | Missing) -> T | None:
    """The evidence; None where it is missing."""
    return None if isinstance(found, Missing) else found


def _caught(
    failures: type[ShakedownError], step: Callable[P, T], *args: P.args, **kwargs: P.kwargs
) -> T | Missing:
    try:
        return step(*args, **kwargs)
    except failures as error:
        return Missing(str(error))
