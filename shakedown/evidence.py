"""Optional evidence: what a step finds, or why it is missing. It never takes an answer along with it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import ParamSpec, TypeVar

from shakedown.errors import SolverError

P = ParamSpec("P")
T = TypeVar("T")


@dataclass(frozen=True)
class Missing:
    """Evidence that was sought and is not there; why, in words."""

    reason: str


def sought(step: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | Missing:
    """What a step of evidence finds; where its solver comes to no end, that and nothing else is caught.

    Examples
    --------
    >>> def fails(x):
    ...     raise SolverError("the linear program ended as 'Unknown'")
    >>> sought(abs, -3), sought(fails, -3)
    (3, Missing(reason="the linear program ended as 'Unknown'"))
    """
    try:
        return step(*args, **kwargs)
    except SolverError as error:
        return Missing(str(error))
