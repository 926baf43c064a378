"""What a function that makes joints is recognised by when a killed run goes on with it."""

from collections.abc import Callable

from shakedown.ground.errors import ShakedownError
from shakedown.joint.problem import Problem


def function_stamp(make: Callable[..., Problem], *first: object) -> str:
    """Its name, and the fingerprint of what it makes of its first arguments: it may have been changed.

    Examples
    --------
    >>> import shakedown
    >>> function_stamp(shakedown.example, "two-node")[:45]
    'shakedown.files.examples.example 3053854690ce'
    """
    try:
        made = make(*first)
        found = made.fingerprint if isinstance(made, Problem) else type(made).__name__
    except ShakedownError as error:  # no such joint, which is an answer too
        found = str(error)
    return f"{getattr(make, '__module__', '')}.{getattr(make, '__qualname__', repr(make))} {found}"
