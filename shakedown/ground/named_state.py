"""Named states of the compiled loops: handed down as one pointer, their fields declared once.

A state is a class whose annotations name its fields and their types, for the
reader, for mypy and for the compiler alike. Its arrays are made in Python and kept
there: compiled code has their addresses only, so that passing a state on costs
nothing, and what it writes Python sees. There they are one-dimensional, a matrix
row after row, and not checked for their ends. The numbers of a state live in
compiled code; Python reads and sets them in place.
"""

from collections.abc import Callable, Mapping
from ctypes import Structure, c_bool, c_double, c_int64, c_size_t, c_uint64
from functools import cache, cached_property
from typing import Annotated, Any, TypeVar, get_args, get_origin

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.experimental import structref
from numba.extending import intrinsic
from numba.np.numpy_support import as_dtype
from numpy.typing import NDArray

from shakedown.ground.code_stamp import stamped
from shakedown.ground.linked_code import pipeline

Reals = Annotated[NDArray[np.float64], types.CPointer(types.float64)]
Integers = Annotated[NDArray[np.int64], types.CPointer(types.int64)]
Shorts = Annotated[NDArray[np.int32], types.CPointer(types.int32)]
Flags = Annotated[NDArray[np.uint8], types.CPointer(types.uint8)]
Hash = Annotated[np.uint64, types.uint64]

NUMBERS = {int: types.int64, float: types.float64, bool: types.boolean}
CONTENT: dict[Any, Any] = {
    types.int64: c_int64,
    types.uint64: c_uint64,
    types.float64: c_double,
    types.boolean: c_bool,
}  # anything else is an address


def entered(function: Callable[..., Any]) -> Any:
    """Compiles a function that is called from Python."""
    options: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
    return stamped(numba.njit(function, cache=True, **options))


def handed_on(function: Callable[..., Any]) -> Any:
    """As ``entered``, for a function that other compiled code has the address of, not compiled into it."""
    return stamped(numba.njit(function, cache=True, nogil=True, error_model="numpy"))


inner: Any = numba.njit(  # type: ignore[call-overload]
    error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, **pipeline()
)
"""Compiles a function that only compiled code calls."""

borrowing: Any = numba.njit(  # type: ignore[call-overload]
    error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True, _nrt=False, **pipeline()
)
"""As ``inner``, for functions that make no array: those of the caller are not counted, which costs locks."""

summing: Any = numba.njit(  # type: ignore[call-overload]
    error_model="numpy",
    no_cpython_wrapper=True,
    no_cfunc_wrapper=True,
    fastmath={"reassoc", "contract"},
    **pipeline(),
)
"""As ``inner``, for sums that may be taken in any order, so that they are vectorised."""

State = TypeVar("State")


def address_of(function: Any, *arguments: types.Type) -> int:
    """Where the compiled form of a function ``handed_on`` lies; it lives as long as the function.

    It is the form that calls from Python compile, and keep, too.
    """
    function.compile(arguments)
    found = function.overloads[arguments]
    return int(found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name))


@intrinsic
def _call_at(typing: Any, address: Any, first: Any, second: Any, third: Any) -> Any:
    """The whole number that the compiled function at an address gives for three arguments."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in signature.args[1:]]
        kind = ir.FunctionType(context.get_value_type(signature.return_type), kinds).as_pointer()
        return builder.call(builder.inttoptr(values[0], kind), values[1:])

    return types.int64(types.int64, first, second, third), generate


call_at: Any = _call_at


class NamedState(structref.StructRefProxy):
    """A state as Python holds it; its arrays and numbers are attributes."""

    @cached_property
    def content(self) -> Any:
        """The fields where compiled code has them: addresses of arrays, and numbers."""
        kind: Any = type(self)
        return _content(kind).from_buffer(self._meminfo)

    def __getattr__(self, name: str) -> Any:
        """A number, as it is now."""
        return getattr(self.content, name)

    def set(self, **numbers: Any) -> None:
        """Set numbers."""
        content = self.content
        for name, value in numbers.items():
            setattr(content, name, value)

    def hold(self, **arrays: NDArray[Any]) -> None:
        """Set arrays, which the state keeps."""
        kind: Any = type(self)
        elements = _elements(kind)
        for name, array in arrays.items():
            assert array.dtype == elements[name]
            assert array.flags.c_contiguous
            setattr(self.content, name, array.__array_interface__["data"][0])
        vars(self).update(arrays)

    def hold_zeros(self, shapes: Mapping[str, Any]) -> None:
        """Set arrays of zeros."""
        kind: Any = type(self)
        elements = _elements(kind)
        self.hold(**{name: np.zeros(shape, elements[name]) for name, shape in shapes.items()})


@cache
def fields(state: Any) -> list[tuple[str, types.Type]]:
    """Names and compiled types of the fields that the annotations of a class declare."""
    return [(name, _compiled_type(kind)) for name, kind in state.__annotations__.items()]


def _compiled_type(kind: Any) -> types.Type:
    return get_args(kind)[1] if get_origin(kind) is Annotated else NUMBERS[kind]


@cache
def _elements(state: Any) -> dict[str, np.dtype[Any]]:
    """What the arrays are made of."""
    arrays = [(name, kind) for name, kind in fields(state) if isinstance(kind, types.CPointer)]
    return {name: as_dtype(kind.dtype) for name, kind in arrays}


@cache
def _content(state: Any) -> Any:
    """How the fields lie in memory."""
    kinds = [(name, CONTENT.get(kind, c_size_t)) for name, kind in fields(state)]
    return type(state.__name__, (Structure,), {"_fields_": kinds})


def made(kind: types.StructRef, shapes: Mapping[str, Any], **arrays: NDArray[Any]) -> Any:
    """A state of a compiled type with these arrays, and some of zeros; all numbers are zero."""
    state = _maker(kind)()
    state.hold_zeros(shapes)
    state.hold(**arrays)
    return state


@cache
def _maker(kind: types.StructRef) -> Any:
    """Makes a state with nothing in it."""

    def new():  # type: ignore[no-untyped-def]
        return structref.new(kind)

    return entered(new)


def keeping(state: State, parts: Mapping[str, Any]) -> State:
    """The state, keeping the arrays, or states, that it was made of as its attributes."""
    vars(state).update(parts)
    return state
