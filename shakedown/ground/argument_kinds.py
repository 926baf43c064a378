"""Checks of arguments against their annotations, used by every public function and class."""

import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from decimal import Decimal
from functools import wraps
from inspect import get_annotations, unwrap
from itertools import chain, islice, repeat
from numbers import Integral, Number, Real
from types import NoneType, UnionType
from typing import Any, Literal, NamedTuple, ParamSpec, TypeVar, Union, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.ground.constants import MANY
from shakedown.ground.errors import ShakedownError, UsageError
from shakedown.ground.shown_values import short, shortened

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


P = ParamSpec("P")
T = TypeVar("T")


class Unfit(Exception):
    """Raised where an argument is of another kind."""


class Kind(NamedTuple):
    """A kind of argument: how it is read (or ``Unfit``), and its description."""

    read: Callable[[Any], Any]
    expected: str


def checked(function: Callable[P, T]) -> Callable[P, T]:
    """Read arguments as their annotations say, before anything is computed; refuse others in one line.

    Whatever NumPy takes for a number is one, and comes to the function as a float or an int, alone and
    in lists of them: fractions, decimal numbers, ``np.int64(3)``, arrays without axes. Flags are true
    or false. A path, a function, a class of this toolkit, a dictionary is one. What an annotation says
    otherwise (``ArrayLike``, ``Any``) is left to the function.

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
            inner = unwrap(function)
            kinds.update(_kinds(inner.__annotations__, inner.__globals__))
        placed = [
            _read(kinds, name, value) for name, value in zip(chain(names, repeat("")), args, strict=False)
        ]
        named = {name: _read(kinds, name, value) for name, value in kwargs.items()}
        return function(*placed, **named)

    return guarded


def check_fields(instance: Any, error: type[ShakedownError] = UsageError, only: Sequence[str] = ()) -> None:
    """The same for the fields of a frozen dataclass, or some of them, from its ``__post_init__``."""
    cls = type(instance)
    kinds = {}
    for base in reversed(cls.__mro__):
        scope = vars(sys.modules[base.__module__])
        kinds.update(_kinds(get_annotations(base), scope))
    for each in fields(instance):
        if each.name in kinds and (not only or each.name in only):
            try:
                value = _read(kinds, each.name, getattr(instance, each.name), f"{cls.__name__}: {each.name}")
            except UsageError as refusal:
                raise error(str(refusal)) from None
            object.__setattr__(instance, each.name, value)


def _read(kinds: Mapping[str, Kind], name: str, value: Any, said: str = "") -> Any:
    kind = kinds.get(name)
    if kind is None:
        return value
    try:
        return kind.read(value)
    except Unfit:
        said = said or name.replace("_", " ")
        raise UsageError(f"{said}: expected {kind.expected}, found {_found(value)}") from None


def _found(value: object) -> str:
    """The value given instead, for a message: numbers and text as they are, else their type."""
    if isinstance(value, Integral) and abs(int(value)) >= LARGEST_WHOLE:
        return f"{written(value)}, beyond 2^63"
    plain = value is None or isinstance(value, Number | Decimal | str | bytes | np.generic | np.ndarray)
    return written(value) if plain or isinstance(value, list | tuple) else type(value).__name__


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
        return _any_of([_kind_of(member) for member in members])
    if origin is Literal:
        words = " or ".join(map(repr, members))
        return Kind(lambda value: _where(isinstance(value, str) and value in members, value), words)
    if origin in SIMPLE:
        return SIMPLE[origin]
    if origin in (Iterable, Sequence, tuple):
        return _several(origin, members)
    if not isinstance(origin, type):
        return None
    if getattr(origin, "_is_protocol", False) and origin.__module__.startswith("shakedown"):
        parts = [name for name in vars(origin) if not name.startswith("_")]
        said = (origin.__doc__ or origin.__name__).splitlines()[0].rstrip(".").rstrip(",")
        return Kind(
            lambda value: _where(all(hasattr(value, name) for name in parts), value),
            said[:1].lower() + said[1:],
        )
    if origin is np.ndarray:
        return _array_of(members)
    if origin.__module__.startswith(("shakedown", "matplotlib", "skfem", "concurrent")):
        article = "an" if origin.__name__[0] in "AEIOU" else "a"
        expected = f"{article} {origin.__name__}"
        return Kind(lambda value: _where(isinstance(value, origin), value), expected)
    return None


def _any_of(kinds: Sequence[Kind | None]) -> Kind | None:
    """One of several kinds, the first that fits; None where one of them is not known."""
    known = [kind for kind in kinds if kind is not None]
    if len(known) < len(kinds):
        return None

    def read(value: Any) -> Any:
        for kind in known:
            try:
                return kind.read(value)
            except Unfit:
                continue
        raise Unfit

    return Kind(read, " or ".join(dict.fromkeys(kind.expected for kind in known)))


def _several(origin: Any, members: tuple[Any, ...]) -> Kind:
    """Several values, each read as its kind where that is known; a tuple has a fixed number."""
    kinds = [_kind_of(member) for member in members if member is not Ellipsis]
    count = len(members) if origin is tuple and Ellipsis not in members and members else None
    needed = "__len__" if origin is Sequence else "__iter__"
    each = kinds[0] if kinds else None
    if each is None or not (each.expected in (WHOLE, NUMBER, TEXT) or count):
        return Kind(lambda value: _where(_is_listed(value, needed), value), "several values")

    def read(value: Any) -> Any:
        if isinstance(value, str) and each.expected == TEXT:
            return value
        _where(_is_listed(value, needed) and not isinstance(value, str | bytes | Mapping), value)
        listed = list(islice(value, MANY + 1))  # an iterator may have no end
        _where(len(listed) == count if count else len(listed) <= MANY, value)
        readers = kinds if count else [each] * len(listed)
        return tuple(
            item if kind is None else kind.read(item) for kind, item in zip(readers, listed, strict=True)
        )

    said = {WHOLE: "whole numbers", NUMBER: "numbers", TEXT: "texts"}.get(each.expected, "values")
    return Kind(read, f"{count or 'several'} {said}")


def _array_of(members: tuple[Any, ...]) -> Kind | None:
    """Numbers in an array, or in anything that NumPy converts to one."""
    (dtype,) = get_args(members[1]) if len(members) == 2 else (None,)
    if dtype not in (np.float64, np.int64):
        return None
    accepted = "fiub" if dtype is np.float64 else "iu"

    def read(value: Any) -> Any:
        if isinstance(value, np.ndarray) and value.dtype.kind in accepted:
            return value
        try:
            array = real_values(value)
        except ValueError:  # ragged
            raise Unfit from None
        return _where(array.dtype.kind in accepted, array)

    return Kind(read, "an array of numbers" if dtype is np.float64 else "an array of whole numbers")


def _where(fits: bool, value: Any) -> Any:
    """The value itself where it fits."""
    if not fits:
        raise Unfit
    return value


def _is_listed(value: object, member: str) -> bool:
    """Whether a value can be iterated or has a length; an array without axes has neither."""
    return hasattr(value, member) and not isinstance(value, type) and getattr(value, "ndim", 1) > 0


def _flag(value: object) -> bool:
    if isinstance(value, bool | np.bool_):
        return bool(value)
    whole = whole_number(value)
    return bool(_where(whole in (0, 1), whole))


def _number_or_unfit(read: Callable[[object], Any]) -> Callable[[object], Any]:
    def number(value: object) -> Any:
        found = read(value)
        return _where(found is not None, found)

    return number


WHOLE, NUMBER, TEXT = "a whole number", "a number", "text"
SIMPLE: dict[Any, Kind] = {
    NoneType: Kind(lambda value: _where(value is None, value), "None"),
    bool: Kind(_flag, "true or false"),
    int: Kind(_number_or_unfit(whole_number), WHOLE),
    float: Kind(_number_or_unfit(real_number), NUMBER),
    str: Kind(lambda value: _where(isinstance(value, str), value), TEXT),
    os.PathLike: Kind(lambda value: _where(isinstance(value, os.PathLike), value), "a path"),
    Mapping: Kind(lambda value: _where(isinstance(value, Mapping), value), "a dictionary"),
    Callable: Kind(lambda value: _where(callable(value), value), "a function"),
}


def written(value: object) -> str:
    """A value as Python writes it, in short."""
    try:
        return shortened(repr(value))
    except ValueError:  # a whole number of thousands of digits, in a list perhaps
        return short(value)


def check_count(name: str, count: int, most: int = LARGEST_WHOLE) -> None:
    """Raise ``UsageError`` unless a number of cycles, threads, … is whole, at least 1 and at most so many."""
    whole = whole_number(count)
    if whole is None:
        raise UsageError(f"{name}: expected a whole number, found {written(count)}")
    if whole < 1:
        raise UsageError(f"{name}: expected at least 1, found {whole}")
    if whole > most:
        raise UsageError(f"{name}: expected at most {most:,}, found {whole}")


def check_seed(seed: int) -> int:
    """The seed of what is random; raises ``UsageError`` unless it is whole and at least 0."""
    whole = whole_number(seed)
    if whole is None or whole < 0:
        raise UsageError(f"seed: expected a whole number >= 0, found {written(seed)}")
    return whole
