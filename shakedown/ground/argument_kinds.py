"""Checks of arguments against their annotations, used by every public function and class."""

import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from decimal import Decimal
from functools import wraps
from inspect import get_annotations, signature, unwrap
from itertools import chain, islice, repeat
from numbers import Integral, Real
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, Union, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.constants import MOST_ENTRIES, P, T
from shakedown.ground.errors import ShakedownError, UsageError
from shakedown.ground.shown_values import short

LARGEST_WHOLE = int(np.iinfo(np.int64).max) + 1  # compiled loops cannot count to such numbers


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
    """A whole number within the range of compiled loops, as an int; None for anything else.

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


class Kind(NamedTuple):
    """A kind of argument: how it is read (None: it is of another kind), and its description."""

    read: Callable[[Any], Any]
    expected: str
    or_none: bool = False


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """Read arguments as their annotations say, before anything is computed; refuse others in one line.

    Whatever NumPy takes for a number is one, and comes to the function as a float or an int, alone and
    in lists of them: fractions, decimal numbers, ``np.int64(3)``, arrays without axes. Flags are true
    or false. A path, a function, a class of this toolkit, a dictionary is one. What an annotation says
    otherwise (``ArrayLike``, ``Any``) is left to the function.

    ``help`` shows names and defaults only, as in SciPy: the docstring has shapes and units, and annotations
    of NumPy's types would fill a screen.

    Raises
    ------
    UsageError
        If an argument is of another kind.
    """
    inner = unwrap(function)
    names = inner.__code__.co_varnames[: inner.__code__.co_argcount]
    kinds: dict[str, Kind] = {}

    @wraps(function)
    def guarded(*args: P.args, **kwargs: P.kwargs) -> T:
        if not kinds:
            kinds.update(_kinds(inner.__annotations__, inner.__globals__))
        placed = [
            _read(kinds, name, value) for name, value in zip(chain(names, repeat("")), args, strict=False)
        ]
        named = {name: _read(kinds, name, value) for name, value in kwargs.items()}
        return function(*placed, **named)

    shown = signature(inner)
    bare = [each.replace(annotation=each.empty) for each in shown.parameters.values()]
    vars(guarded)["__signature__"] = shown.replace(parameters=bare, return_annotation=shown.empty)
    return guarded


def check_fields(instance: Any, error: type[ShakedownError] = UsageError, only: Sequence[str] = ()) -> None:
    """The same for the fields of a frozen dataclass, or some of them, from its ``__post_init__``."""
    cls = type(instance)
    kinds = dict[str, Kind]()
    for base in reversed(cls.__mro__):
        kinds |= _kinds(get_annotations(base), vars(sys.modules[base.__module__]))
    for name in only or [each.name for each in fields(instance)]:
        try:
            value = _read(kinds, name, getattr(instance, name), f"{cls.__name__}: {name}")
        except UsageError as refusal:
            raise error(str(refusal)) from None
        object.__setattr__(instance, name, value)


def _read(kinds: Mapping[str, Kind], name: str, value: Any, shown_name: str = "") -> Any:
    kind = kinds.get(name)
    if kind is None or (value is None and kind.or_none):
        return value
    found = kind.read(value)
    if found is None:
        shown = type(value).__name__ if hasattr(value, "__dict__") else short(value)
        raise UsageError(f"{shown_name or name.replace('_', ' ')}: expected {kind.expected}, found {shown}")
    return found


def _kinds(annotations: Mapping[str, Any], scope: dict[str, Any]) -> dict[str, Kind]:
    """The kinds that annotations name, by argument."""
    found = {}
    for name, annotation in annotations.items():
        if isinstance(annotation, str):
            try:
                annotation = eval(annotation, scope)  # an annotation of our own modules
            except NameError:  # known to type checkers only
                continue
        kind = _kind_of(annotation)
        if kind is not None and name != "return":
            found[name] = kind
    return found


def _kind_of(annotation: Any) -> Kind | None:
    """The kind that an annotation names, or None where the function checks it."""
    origin, members = get_origin(annotation) or annotation, get_args(annotation)
    if origin in (Union, UnionType):
        return _any_of(members)
    if origin is Literal:
        words = " or ".join(map(repr, members))
        return _that(lambda value: isinstance(value, str) and value in members, words)
    if origin in SIMPLE:
        return SIMPLE[origin]
    if origin in (Iterable, Sequence, tuple):
        return _several(members, fixed=origin is tuple and Ellipsis not in members)
    ours = getattr(origin, "__module__", "").startswith(("shakedown", "matplotlib", "skfem", "concurrent"))
    if not (ours and isinstance(origin, type)) or getattr(origin, "_is_protocol", False):
        return None
    article = "an" if origin.__name__[0] in "AEIOU" else "a"
    return _that(lambda value: isinstance(value, origin), f"{article} {origin.__name__}")


def _that(fits: Callable[[Any], bool], expected: str) -> Kind:
    """The kind of values that pass a test, and stay as they are."""
    return Kind(lambda value: value if fits(value) else None, expected)


def _any_of(members: tuple[Any, ...]) -> Kind | None:
    """One of several kinds, the first that fits; None where one of them is not known."""
    kinds = [_kind_of(member) for member in members if member is not NoneType]
    known = [kind for kind in kinds if kind is not None]
    if len(known) < len(kinds):
        return None

    def read(value: Any) -> Any:
        return next((found for kind in known if (found := kind.read(value)) is not None), None)

    or_none = NoneType in members
    expected = dict.fromkeys([kind.expected for kind in known] + ["None"] * or_none)
    return Kind(read, " or ".join(expected), or_none)


def _several(members: tuple[Any, ...], *, fixed: bool) -> Kind | None:
    """Several values of one kind, as a tuple, or as many as an annotation says; one text is several."""
    each = _kind_of(members[0])
    if each is None or (fixed and len(set(members)) > 1):
        return None

    def read(value: Any) -> Any:
        if isinstance(value, str) and str in members:
            return value
        try:
            found = tuple(map(each.read, islice(value, MOST_ENTRIES + 1)))  # an iterator may have no end
        except TypeError:
            return None
        fits = len(found) == len(members) if fixed else len(found) <= MOST_ENTRIES
        return found if fits and not any(item is None for item in found) else None

    plural = f"{each.expected.split(' ', 1)[-1]}s"
    return Kind(read, f"{len(members) if fixed else 'several'} {plural}")


def _numbers(value: Any) -> NDArray[Any] | None:
    """Numbers in an array, or in anything that NumPy converts to one."""
    try:
        array = value if isinstance(value, np.ndarray) else real_values(value)
    except ValueError:  # ragged
        return None
    return array if array.dtype.kind in "fiub" else None


def _flag(value: object) -> bool | None:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    whole = whole_number(value)
    return bool(whole) if whole in (0, 1) else None


SIMPLE: dict[Any, Kind] = {
    bool: Kind(_flag, "true or false"),
    int: Kind(whole_number, "a whole number"),
    float: Kind(real_number, "a number"),
    str: _that(lambda value: isinstance(value, str), "text"),
    os.PathLike: _that(lambda value: isinstance(value, os.PathLike), "a path"),
    np.ndarray: Kind(_numbers, "an array of numbers"),
    Mapping: _that(lambda value: isinstance(value, Mapping), "a dictionary"),
    Callable: _that(callable, "a function"),
}


def check_count(name: str, count: int, most: int = LARGEST_WHOLE, least: int = 1) -> int:
    """A number of cycles, threads, …; raises ``UsageError`` unless it is whole and within its limits."""
    whole = whole_number(count)
    if whole is None or not least <= whole <= most:
        limits = f">= {least}" if most == LARGEST_WHOLE else f"from {least} to {most:,}"
        raise UsageError(f"{name}: expected a whole number {limits}, found {short(count)}")
    return whole


def check_seed(seed: int) -> int:
    """The seed of what is random; raises ``UsageError`` unless it is whole and at least 0."""
    return check_count("seed", seed, least=0)
