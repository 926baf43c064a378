"""Checks of the arguments that several functions take."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from inspect import unwrap
from itertools import chain
from math import isfinite
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, ParamSpec, TypeVar, Union, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike

from shakedown.errors import ProblemError, UsageError
from shakedown.model.field_values import check_slip
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.result import Result
from shakedown.shown_values import short
from shakedown.tolerances import Tolerances
from shakedown.visible_text import shortened

P = ParamSpec("P")
T = TypeVar("T")
LARGEST_WHOLE = 2**63  # numbers from here on no compiled loop can count


class Kind(NamedTuple):
    """What an argument may be: a test, and what to say of it."""

    holds: Callable[[Any], bool]
    expected: str


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """Refuse arguments of a wrong kind in one line, before anything is computed.

    The annotations decide: a :class:`Problem`, :class:`Tolerances`, a result or what has the
    members of a protocol, true or false, a number that a computer can hold, a mapping or
    something to iterate over. Whatever else an annotation says is left to the function.

    Raises
    ------
    UsageError
        If an argument is of another kind.
    """
    code = unwrap(function).__code__
    names = code.co_varnames[: code.co_argcount]
    kinds: dict[str, Kind] = {}

    @wraps(function)
    def guarded(*args: P.args, **kwargs: P.kwargs) -> T:
        if not kinds:
            kinds.update(_kinds(function))
        for name, value in chain(zip(names, args, strict=False), kwargs.items()):
            kind = kinds.get(name)
            if kind is not None and not kind.holds(value):
                found = short(value) if isinstance(value, Real | str | np.ndarray) else type(value).__name__
                raise UsageError(f"{name.replace('_', ' ')}: expected {kind.expected}, found {found}")
        return function(*args, **kwargs)

    return guarded


def _kinds(function: Callable[..., Any]) -> dict[str, Kind]:
    """What the annotations of a function tell, by the names of its arguments."""
    inner = unwrap(function)
    found = {}
    for name, annotation in inner.__annotations__.items():
        if isinstance(annotation, str):
            try:
                annotation = eval(annotation, inner.__globals__)  # what the module itself has written
            except NameError:  # known to type checkers only
                continue
        kind = _kind_of(annotation)
        if kind is not None and name != "return":
            found[name] = kind
    return found


def _kind_of(annotation: Any) -> Kind | None:
    """The kind that an annotation names, or None where it is left to the function."""
    if get_origin(annotation) in (Union, UnionType):
        kinds = [_kind_of(member) for member in get_args(annotation)]
        known = [kind for kind in kinds if kind is not None]
        if len(known) < len(kinds):
            return None
        return Kind(
            lambda value: any(kind.holds(value) for kind in known),
            " or ".join(kind.expected for kind in known),
        )
    if get_origin(annotation) is Literal:
        return Kind(lambda value: isinstance(value, str), "text")
    simple: dict[Any, Kind] = {
        NoneType: Kind(lambda value: value is None, "None"),
        bool: Kind(_is_flag, "true or false"),
        int: Kind(_is_whole, "a whole number below 2^63"),
        float: Kind(_is_number, "a number below 1e308"),
        str: Kind(lambda value: isinstance(value, str), "text"),
        Mapping: Kind(lambda value: isinstance(value, Mapping), "a dictionary"),
        Iterable: Kind(lambda value: _has(value, "__iter__"), "several values"),
        Sequence: Kind(lambda value: _has(value, "__len__"), "several values"),
    }
    origin = get_origin(annotation) or annotation
    if origin in simple:
        return simple[origin]
    if not isinstance(origin, type):
        return None
    if issubclass(origin, Problem | Tolerances | Result):
        return Kind(lambda value: isinstance(value, origin), f"a {origin.__name__}")
    if getattr(origin, "_is_protocol", False) and origin.__module__.startswith("shakedown"):
        members = [name for name in vars(origin) if not name.startswith("_")]
        said = (origin.__doc__ or origin.__name__).splitlines()[0].rstrip(".").rstrip(",")
        return Kind(lambda value: all(hasattr(value, name) for name in members), said[:1].lower() + said[1:])
    return None


def _has(value: object, member: str) -> bool:
    """Whether something has a member, and no whole number in it is too large to be counted.

    An array without axes can be neither counted nor gone through.
    """
    listed = value if isinstance(value, list | tuple) else ()
    fits = all(abs(item) < LARGEST_WHOLE for item in listed if isinstance(item, int))
    return fits and hasattr(value, member) and getattr(value, "ndim", 1) > 0


def _is_flag(value: object) -> bool:
    return isinstance(value, bool | np.bool_) or (isinstance(value, Integral) and value in (0, 1))


def _is_whole(value: object) -> bool:
    """A number that is none too large, or text: which of them make sense is the function's matter."""
    if isinstance(value, Integral):
        return abs(int(value)) < LARGEST_WHOLE
    return isinstance(value, Real | str)


def _is_number(value: object) -> bool:
    """Likewise, for any number."""
    try:
        return isinstance(value, str) or (isinstance(value, Real) and float(value) is not None)
    except OverflowError:
        return False


def is_finite(value: object) -> bool:
    """Whether a value is one finite real number, as a float."""
    try:
        return isinstance(value, Real) and isfinite(value)
    except OverflowError:  # a whole number beyond all floats
        return False


def check_load_factor(load_factor: float) -> None:
    """Raise ``UsageError`` unless a load factor is a finite number ≥ 0."""
    if not (is_finite(load_factor) and load_factor >= 0):
        raise UsageError(f"load factor: expected a number >= 0, found {_written(load_factor)}")


def check_count(name: str, count: int) -> None:
    """Raise ``UsageError`` unless a number of cycles, threads, … is whole and at least 1."""
    if not isinstance(count, Integral):
        raise UsageError(f"{name}: expected a whole number, found {_written(count)}")
    if count < 1:
        raise UsageError(f"{name}: expected at least 1, found {short(int(count))}")


def check_seed(seed: int) -> int:
    """The seed of what is random; raises ``UsageError`` unless it is whole and at least 0."""
    if not isinstance(seed, Integral) or seed < 0:
        raise UsageError(f"seed: expected a whole number >= 0, found {_written(seed)}")
    return int(seed)


def _written(value: object) -> str:
    """A value as Python writes it, in short."""
    try:
        return shortened(repr(value))
    except ValueError:  # a whole number of thousands of digits, in a list perhaps
        return short(value)


def require_problem(problem: object) -> None:
    """Raise ``UsageError`` where something else is given as a problem."""
    if not isinstance(problem, Problem):
        raise UsageError(f"problem: expected a Problem, found {type(problem).__name__}")


def real_array(name: str, values: ArrayLike) -> FloatArray:
    """A private float64 copy; raises ``UsageError`` unless all of it is real and finite."""
    try:
        array = np.array(values)
    except ValueError:  # ragged
        raise UsageError(f"{name}: expected a regular array of numbers, found ragged rows") from None
    if array.dtype.kind not in "fiu":
        raise UsageError(f"{name}: expected real numbers, found {_written(values)}")
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is not finite
        array = array.astype(np.float64)
    if not np.isfinite(array).all():
        raise UsageError(f"{name}: expected finite numbers, found {array[~np.isfinite(array)][0]}")
    return array


def node_numbers(name: str, nodes: Iterable[int], n: int) -> tuple[int, ...]:
    """Some of n nodes by number, in the order given; raises ``UsageError`` for anything else."""
    given = list(nodes)
    for node in given:
        if isinstance(node, bool | np.bool_) or not isinstance(node, Integral) or not 0 <= node < n:
            raise UsageError(f"{name}: expected node numbers from 0 to {n - 1}, found {short(node)}")
    return tuple(int(node) for node in given)


def check_arguments(load_factor: float, cycles: int) -> None:
    """Raise ``UsageError`` where the load factor or the number of cycles is out of range."""
    check_load_factor(load_factor)
    check_count("cycles", cycles)


def checked_initial_slip(problem: Problem, initial_slip: ArrayLike | None) -> FloatArray:
    """An initial slip as a private array (n,), zero by default; raises ``UsageError`` if mis-shaped."""
    require_problem(problem)
    slip = np.zeros(problem.n) if initial_slip is None else real_array("initial slip", initial_slip)
    if slip.shape != (problem.n,):
        raise UsageError(f"initial slip: expected shape ({problem.n},), found {slip.shape}")
    stiffness = max(float(np.abs(K).max()) for K in (problem.A, problem.B, problem.C) if K is not None)
    try:
        check_slip("initial slip", stiffness, float(np.abs(slip).max()))
    except ProblemError as error:
        raise UsageError(str(error)) from None
    return slip


def checked_damping(problem: Problem, damping: ArrayLike | None) -> FloatArray | None:
    """The diagonal of D as a private array (2n,); raises ``UsageError`` unless it is positive throughout."""
    if damping is None:
        return None
    D = real_array("damping", damping)
    if D.shape != (2 * problem.n,) or not (D > 0).all():
        raise UsageError(f"damping: expected {2 * problem.n} positive numbers, found {damping}")
    return D
