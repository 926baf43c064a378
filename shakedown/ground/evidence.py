"""Optional evidence: what a step finds, or why it is missing. It never takes an answer along with it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, ParamSpec, TypeVar

from shakedown.ground.errors import ShakedownError, SolverError

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True)
class Missing:
    """Evidence that was sought and is not there; why, in words."""

    reason: str

    def __bool__(self) -> Literal[False]:
        """False: there is none."""
        return False

    def to_dict(self) -> None:
        """In a document it is null."""


def sought(step: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | Missing:
    """What a step of evidence finds; where its solver comes to no end, why. Nothing else is caught.

    Examples
    --------
    >>> def fails(x):
    ...     raise SolverError("the linear program ended as 'Unknown'")
    >>> sought(abs, -3), sought(fails, -3)
    (3, Missing(reason="the linear program ended as 'Unknown'"))
    """
    return _caught(SolverError, step, *args, **kwargs)


def allowed(step: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | Missing:
    """The same where a step may also refuse what it is given: one point among many that need not exist."""
    return _caught(ShakedownError, step, *args, **kwargs)


def present(found: T | Missing) -> T | None:
    """What was found; None where it is missing."""
    return None if isinstance(found, Missing) else found


def _caught(
    failures: type[ShakedownError], step: Callable[P, T], *args: P.args, **kwargs: P.kwargs
) -> T | Missing:
    try:
        return step(*args, **kwargs)
    except failures as error:
        return Missing(str(error))
