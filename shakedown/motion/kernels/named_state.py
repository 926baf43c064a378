"""Named states of the compiled loops: handed down as one pointer, their fields declared once.

A state is a class whose annotations name its fields and their types, for the
reader, for mypy and for the compiler alike. Its arrays are made by the caller,
who keeps them: compiled code has their addresses only, so that passing a state
on costs nothing, and what it writes the caller sees. There they are one-dimensional,
a matrix row after row, and not checked for their ends. The numbers of a state
live in compiled code; what of them the caller needs is returned to it.
"""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, TypeVar, get_args, get_origin

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.experimental import structref
from numba.extending import intrinsic
from numpy.typing import NDArray

from shakedown.motion.kernels.code_stamp import stamped
from shakedown.motion.kernels.linked_code import pipeline

Reals = Annotated[NDArray[np.float64], types.CPointer(types.float64)]
Integers = Annotated[NDArray[np.int64], types.CPointer(types.int64)]
Shorts = Annotated[NDArray[np.int32], types.CPointer(types.int32)]
Flags = Annotated[NDArray[np.uint8], types.CPointer(types.uint8)]
Hash = Annotated[np.uint64, types.uint64]

NUMBERS = {int: types.int64, float: types.float64, bool: types.boolean}


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
    """A state as Python holds it; its arrays are attributes."""


def fields(state: type) -> list[tuple[str, types.Type]]:
    """Names and compiled types of the fields that the annotations of a class declare."""
    return [(name, _compiled_type(kind)) for name, kind in state.__annotations__.items()]


def _compiled_type(kind: Any) -> types.Type:
    return get_args(kind)[1] if get_origin(kind) is Annotated else NUMBERS[kind]


def keeping(state: State, parts: Mapping[str, Any]) -> State:
    """The state, keeping the arrays, or states, that it was made of as its attributes."""
    vars(state).update(parts)
    return state
