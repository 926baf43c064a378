"""What cannot be written to: the arrays of a problem and of results, in copies of these, too."""

from contextlib import nullcontext
from dataclasses import is_dataclass
from functools import cached_property, wraps
from typing import Any

import numpy as np


class ReadOnly:
    """Base of frozen dataclasses whose arrays are read-only, and those in their parts.

    Tuples, lists, dictionaries and frozen dataclasses are parts, and so is what a ``cached_property``
    works out later. Arrays that somebody else holds as well stay as they are: here is a view of them.
    A copy, shallow or deep, and what comes out of a pickle is read-only again. A class with a
    ``__post_init__`` of its own calls this one at its end.

    Examples
    --------
    >>> import copy
    >>> from dataclasses import dataclass
    >>> @dataclass(frozen=True)
    ... class Slip(ReadOnly):
    ...     slip: np.ndarray
    >>> given = np.zeros(2)
    >>> made = Slip(given)
    >>> [array.flags.writeable for array in (made.slip, copy.deepcopy(made).slip, given)]
    [False, False, True]
    """

    def __init_subclass__(cls, **words: Any) -> None:
        super().__init_subclass__(**words)
        for attribute in vars(cls).values():
            if isinstance(attribute, cached_property):
                attribute.func = _read_only_once_found(attribute.func)
                if hasattr(attribute, "lock"):  # one for all objects, up to Python 3.11: threads would wait
                    attribute.lock = nullcontext()

    def __post_init__(self) -> None:
        for name, value in list(self.__dict__.items()):
            if (held := read_only(value)) is not value:
                self.__dict__[name] = held

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        ReadOnly.__post_init__(self)


def _read_only_once_found(find: Any) -> Any:
    @wraps(find)
    def found(self: Any) -> Any:
        return read_only(find(self))

    return found


def read_only(value: Any) -> Any:
    """The same value, its arrays as read-only views; the value itself where nothing in it can be written.

    Examples
    --------
    >>> given = np.zeros(2), "slip"
    >>> read_only(given)[0].flags.writeable, given[0].flags.writeable
    (False, True)
    """
    kind = type(value)
    if kind is np.ndarray:
        view = value.view() if value.flags.writeable else value
        view.flags.writeable = False
        return view
    if kind in (tuple, list) or (isinstance(value, tuple) and hasattr(value, "_fields")):
        parts = [read_only(part) for part in value]
        if all(new is old for new, old in zip(parts, value, strict=True)):
            return value
        return value._make(parts) if hasattr(value, "_make") else kind(parts)
    if kind is dict:
        entries = {key: read_only(part) for key, part in value.items()}
        return entries if any(entries[key] is not part for key, part in value.items()) else value
    if is_dataclass(kind) and kind.__dataclass_params__.frozen and not issubclass(kind, ReadOnly):  # type: ignore[attr-defined]
        ReadOnly.__post_init__(value)
    return value
