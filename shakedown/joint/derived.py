"""Data derived from a problem alone are built once and kept with it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from typing import Any, TypeVar

from shakedown.joint.arguments import require_problem
from shakedown.joint.problem import Problem

T = TypeVar("T")


class _Kept(dict[str, object]):
    """The results kept with one problem; neither copied nor pickled, as they can be rebuilt."""

    def __reduce__(self) -> tuple[type, tuple[()]]:
        return _Kept, ()


def once_per_problem(build: Callable[[Problem], T]) -> Callable[[Problem], T]:
    """Cache a function of a problem: computed at the first call, the same object afterwards.

    A :class:`Problem` does not change once it is made, nor may what is kept with
    it. Raises ``UsageError`` where something else is given as a problem.
    """
    name = f"{build.__module__}.{build.__qualname__}"

    @wraps(build)
    def kept(problem: Problem) -> T:
        require_problem(problem)
        results = problem.__dict__.setdefault("_derived", _Kept())
        if name not in results:
            results[name] = build(problem)
        found: T = results[name]
        return found

    return kept


@contextmanager
def lent(problem: Problem, name: str, settings: object, build: Callable[[], T]) -> Iterator[T]:
    """A reusable object that is costly to build for a problem, for one user at a time.

    The last one with these settings, unless it is in use; else a new one.
    """
    results = problem.__dict__.setdefault("_derived", _Kept())
    found: Any = results.pop(name, None)
    thing: T = found[1] if found is not None and found[0] == settings else build()
    yield thing
    results[name] = settings, thing
