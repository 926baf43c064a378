"""Compiled loops: how their functions are compiled, and named states, passed by address.

A state is a class whose annotations name its fields and their types, for the reader, for mypy and for the
compiler alike: arrays, numbers, other states. Python makes and keeps all of them, and reads and sets them in
place; compiled code has addresses only, counted by nobody, so that passing a state on, or reading one out of
another, costs nothing. There arrays are one-dimensional, a matrix row after row, and not checked for their
ends.
"""

from collections.abc import Callable, Mapping
from ctypes import Structure, addressof, c_bool, c_double, c_int64, c_size_t, c_uint64
from typing import Annotated, Any, ClassVar, Self, get_args, get_origin

import numba
import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import extending, types
from numba.core.typing.templates import AttributeTemplate
from numba.np.numpy_support import as_dtype
from numpy.typing import NDArray

from shakedown.ground.code_cache import compiled, pipeline

Reals = Annotated[NDArray[np.float64], types.CPointer(types.float64)]
Integers = Annotated[NDArray[np.int64], types.CPointer(types.int64)]
Shorts = Annotated[NDArray[np.int32], types.CPointer(types.int32)]
Flags = Annotated[NDArray[np.uint8], types.CPointer(types.uint8)]
Hash = Annotated[np.uint64, types.uint64]

CONTENT: dict[Any, Any] = {
    types.int64: c_int64,
    types.uint64: c_uint64,
    types.float64: c_double,
    types.boolean: c_bool,
}  # anything else is an address


def entered(function: Callable[..., Any]) -> Any:
    """Compiles a function that is called from Python."""
    return compiled(function, nogil=True, error_model="numpy", no_cfunc_wrapper=True)


def handed_on(function: Callable[..., Any]) -> Any:
    """As ``entered``, for a function that other compiled code has the address of, not compiled into it."""
    return compiled(function, nogil=True, error_model="numpy")


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


def address_of(function: Any, *arguments: types.Type) -> int:
    """Where the compiled form of a function ``handed_on`` lies; it lives as long as the function.

    It is the form that calls from Python compile, and keep, too.
    """
    function.compile(arguments)
    found = function.overloads[arguments]
    return int(found.library.get_pointer_to_function(found.fndesc.llvm_cfunc_wrapper_name))


@extending.intrinsic
def _call_at(typing: Any, address: Any, first: Any, second: Any, third: Any) -> Any:
    """The whole number that the compiled function at an address gives for three arguments."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        kinds = [context.get_value_type(kind) for kind in signature.args[1:]]
        kind = ir.FunctionType(context.get_value_type(signature.return_type), kinds).as_pointer()
        return builder.call(builder.inttoptr(values[0], kind), values[1:])

    return types.int64(types.int64, first, second, third), generate


call_at: Any = _call_at


class StateType(types.Type):
    """Compiled type of a state: its address, and where its fields lie behind it."""

    def __init__(self, name: str, kinds: dict[str, Any], offsets: dict[str, int]) -> None:
        self.kinds, self.offsets = kinds, offsets
        super().__init__(name=name)


class NamedState:
    """A state as Python holds it; its arrays, numbers and states are attributes.

    Parameters
    ----------
    shapes
        The shapes of arrays that are zero at first, as numbers are.
    held
        Other arrays, and states.
    """

    compiled: ClassVar[StateType]
    memory: ClassVar[type[Structure]]
    content: Any

    def __init_subclass__(cls) -> None:
        kinds = {name: _compiled_type(declared) for name, declared in cls.__annotations__.items()}
        placed = [(name, CONTENT.get(kind, c_size_t)) for name, kind in kinds.items()]
        cls.memory = type(cls.__name__, (Structure,), {"_fields_": placed})
        offsets = {name: getattr(cls.memory, name).offset for name in kinds}
        cls.compiled = StateType(f"{cls.__module__}.{cls.__qualname__}", kinds, offsets)

    def __init__(self, shapes: Mapping[str, Any], **held: Any) -> None:
        vars(self)["content"] = self.memory()
        kinds = self.compiled.kinds
        self.hold(**{name: np.zeros(shape, as_dtype(kinds[name].dtype)) for name, shape in shapes.items()})
        self.hold(**held)

    @property
    def address(self) -> int:
        """The address for compiled code."""
        return addressof(self.content)

    def __getattr__(self, name: str) -> Any:
        """A number, as it is now."""
        return getattr(self.content, name)

    def set(self, **numbers: Any) -> None:
        """Set numbers."""
        for name, value in numbers.items():
            setattr(self.content, name, value)

    def hold(self, **held: "NDArray[Any] | NamedState") -> None:
        """Set arrays or states, which the state keeps."""
        for name, part in held.items():
            where = part.address if isinstance(part, NamedState) else self._start(name, part)
            setattr(self.content, name, where)
        vars(self).update(held)

    def _start(self, name: str, array: NDArray[Any]) -> int:
        assert array.dtype == as_dtype(self.compiled.kinds[name].dtype)
        assert array.flags.c_contiguous
        return int(array.__array_interface__["data"][0])

    def with_parts(self, **held: Any) -> Self:
        """A state with the same parts, some replaced."""
        other = type(self)({})
        vars(other)["content"] = self.memory.from_buffer_copy(self.content)
        other.hold(**{name: part for name, part in vars(self).items() if name != "content"} | held)
        return other


def _compiled_type(declared: Any) -> Any:
    numbers = {int: types.int64, float: types.float64, bool: types.boolean}
    if get_origin(declared) is Annotated:
        return get_args(declared)[1]
    return numbers.get(declared) or declared.compiled


extending.register_model(StateType)(extending.models.OpaqueModel)  # an address


@extending.typeof_impl.register(NamedState)
def _kind(state: NamedState, context: Any) -> StateType:
    return state.compiled


@extending.unbox(StateType)
def _address(kind: StateType, state: Any, c: Any) -> extending.NativeValue:
    number = c.pyapi.object_getattr_string(state, "address")
    address = c.pyapi.long_as_voidptr(number)
    c.pyapi.decref(number)
    return extending.NativeValue(address, is_error=c.pyapi.c_api_error())


@extending.infer_getattr
class _Fields(AttributeTemplate):
    key = StateType

    def generic_resolve(self, state: StateType, name: str) -> Any:  # type: ignore[override]
        return state.kinds.get(name)


def _place(context: Any, builder: Any, state: StateType, address: Any, name: str) -> Any:
    """Where a field lies."""
    place = builder.gep(address, [context.get_constant(types.intp, state.offsets[name])])
    return builder.bitcast(place, context.get_data_type(state.kinds[name]).as_pointer())


@extending.lower_getattr_generic(StateType)
def _read(context: Any, builder: Any, state: StateType, address: Any, name: str) -> Any:
    return context.unpack_value(builder, state.kinds[name], _place(context, builder, state, address, name))


@extending.lower_setattr_generic(StateType)
def _write(context: Any, builder: Any, signature: Any, values: Any, name: str) -> None:
    (state, given), (address, value) = signature.args, values
    place = _place(context, builder, state, address, name)
    value = context.cast(builder, value, given, state.kinds[name])
    context.pack_value(builder, state.kinds[name], value, place)
