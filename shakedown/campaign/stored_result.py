"""Results and arrays as bytes, and back to the last bit: the format of a run's own records.

The bytes of results are a pickle, but what reads them makes results of this package, arrays and numbers
only: no file can make it call anything else. Arrays alone are an NPZ archive, of which a part can be read.
"""

import copyreg
import pickle
import struct
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from fractions import Fraction
from functools import cached_property
from importlib import import_module
from io import BytesIO
from typing import Any, NamedTuple
from zipfile import ZIP_STORED, BadZipFile, ZipFile, ZipInfo

import numpy as np
from numpy.typing import NDArray

from shakedown.files.npy import read_array, read_header
from shakedown.ground.errors import ProblemError
from shakedown.joint.problem import Problem

OTHERS = {(kind.__module__, kind.__name__): kind for kind in (Fraction, deque)}
BROKEN = (
    pickle.UnpicklingError, ArithmeticError, AttributeError, EOFError, ImportError, LookupError, MemoryError,
    RecursionError, TypeError, ValueError,
)  # fmt: skip


def stored(result: Any, problem: Problem | None = None) -> bytes:
    """A result as bytes; of the joint that it is about, if of any, they only say that it is this one.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = shakedown.upper_bound(joint)
    >>> again = restored(stored(found, joint), joint)
    >>> again.load_factor == found.load_factor, bool((again.slip == found.slip).all())
    (True, True)
    """
    buffer = BytesIO()
    _Writer(buffer, problem).dump(result)
    return buffer.getvalue()


def restored(content: bytes, problem: Problem | None = None) -> Any:
    """The result that :func:`stored` made bytes of.

    Raises
    ------
    ProblemError
        If they are none of its.
    """
    try:
        return _Reader(BytesIO(content), problem).load()
    except BROKEN as error:
        raise ProblemError(f"expected a stored result, found a damaged one ({error})") from None


class Folded(NamedTuple):
    """Many values of one dataclass or named tuple: its fields, each a list, or one array and sizes."""

    kind: type
    columns: list[Any]


def folded(values: Sequence[Any]) -> Folded | None:
    """Values of one kind as they are quickly stored; None of none.

    Examples
    --------
    >>> from shakedown.motion.cycle_record import Stop
    >>> stops = [Stop("it leaves", 1.5, 0), Stop("it slides", 2.5, -1)]
    >>> unfolded(folded(stops)) == stops
    True
    """
    if not values:
        return None
    kind = type(values[0])
    names = kind._fields if hasattr(kind, "_fields") else [field.name for field in fields(kind)]
    columns: list[Any] = []
    for name in names:
        column = [getattr(value, name) for value in values]
        if isinstance(column[0], np.ndarray):
            columns.append((np.concatenate(column), [len(array) for array in column]))
        else:
            columns.append(column)
    return Folded(kind, columns)


def unfolded(found: Folded | None) -> list[Any]:
    """The values again; their arrays are parts of one."""
    if found is None:
        return []
    columns = [_cut(*column) if isinstance(column, tuple) else column for column in found.columns]
    return [found.kind(*values) for values in zip(*columns, strict=True)]


def _cut(whole: NDArray[Any], sizes: list[int]) -> list[NDArray[Any]]:
    ends = np.cumsum(sizes).tolist()
    return [whole[end - size : end] for size, end in zip(sizes, ends, strict=True)]


class _Writer(pickle.Pickler):
    def __init__(self, file: BytesIO, problem: Problem | None) -> None:
        super().__init__(file, protocol=5)
        self.problem = problem

    def persistent_id(self, thing: Any) -> str | None:
        return "problem" if thing is self.problem and thing is not None else None

    def reducer_override(self, thing: Any) -> Any:
        """Arrays and their numbers by functions of our own, and results without what follows from them."""
        if isinstance(thing, np.ndarray) and not thing.dtype.hasobject:
            by_columns = thing.flags.f_contiguous and not thing.flags.c_contiguous
            content = thing.tobytes("F" if by_columns else "C")
            return array_of, (thing.dtype.str, thing.shape, by_columns, content)
        if isinstance(thing, np.generic) and not thing.dtype.hasobject:
            return number_of, (thing.dtype.str, thing.tobytes())
        if isinstance(thing, Enum):  # by its value: Python 3.11 up to 3.11.3 would have getattr find the name
            return type(thing), (thing.value,)
        if is_dataclass(thing) and not isinstance(thing, type):
            return copyreg.__newobj__, (type(thing),), _fields_of(thing)  # type: ignore[attr-defined]
        return NotImplemented


def _fields_of(thing: Any) -> dict[str, Any]:
    """The attributes of a result but for those that are worked out from the others when they are read."""
    kind = type(thing)
    return {k: v for k, v in vars(thing).items() if not isinstance(getattr(kind, k, None), cached_property)}


def array_of(kind: str, shape: tuple[int, ...], by_columns: bool, content: bytes) -> NDArray[Any]:
    """An array of its own, laid out in memory as it was."""
    values = np.frombuffer(bytearray(content), dtype=np.dtype(kind))
    return values.reshape(shape, order="F" if by_columns else "C")


def number_of(kind: str, content: bytes) -> Any:
    """A number of NumPy's."""
    return np.frombuffer(content, dtype=np.dtype(kind))[0]


class _Reader(pickle.Unpickler):
    def __init__(self, file: BytesIO, problem: Problem | None) -> None:
        super().__init__(file)
        self.problem = problem

    def persistent_load(self, name: Any) -> Problem:
        if name != "problem" or self.problem is None:
            raise pickle.UnpicklingError(f"no {name!r}")
        return self.problem

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) in OTHERS:
            return OTHERS[module, name]
        if module == __name__ and name in ("array_of", "number_of"):
            return globals()[name]
        if module.startswith("shakedown.") and "__main__" not in module and "." not in name:
            found = getattr(import_module(module), name)
            if isinstance(found, type) and _holds_values_only(found):
                return found
        raise pickle.UnpicklingError(f"{module}.{name} is no result")


def _holds_values_only(kind: type) -> bool:
    """Whether it is a dataclass, a named tuple, an enumeration or a dictionary: making one does nothing."""
    return is_dataclass(kind) or hasattr(kind, "_fields") or issubclass(kind, Enum | dict)


def packed(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Arrays by name as the bytes of an NPZ archive.

    Examples
    --------
    >>> unpacked(packed({"slip": np.array([0.5, 0.25])}))["slip"]
    array([0.5 , 0.25])
    """
    buffer = BytesIO()
    np.savez(buffer, allow_pickle=False, **arrays)
    return buffer.getvalue()


def unpacked(piece: bytes, *keys: str) -> dict[str, NDArray[Any]]:
    """The arrays that :func:`packed` put together, all of them or some.

    Raises
    ------
    ProblemError
        If the bytes are none of its: another archive, one that claims more than it holds, …
    """
    try:
        with ZipFile(BytesIO(piece)) as archive:
            members = {info.filename.removesuffix(".npy"): info for info in archive.infolist()}
            return {key: _array(archive, members[key]) for key in keys or members}
    except (BadZipFile, KeyError, EOFError, RuntimeError, ValueError, OverflowError, struct.error) as error:
        raise ProblemError(f"expected arrays, found damaged ones ({error})") from None


def _array(archive: ZipFile, info: ZipInfo) -> NDArray[Any]:
    if info.compress_type != ZIP_STORED:  # a compressed member may expand without end
        raise ProblemError("expected arrays as they are, found compressed ones")
    with archive.open(info) as file:
        header = read_header(file)
    with archive.open(info) as file:
        return read_array(file, header, info.file_size)
