"""Linear equations in compiled loops, by LAPACK called through its address."""

from typing import Any, NamedTuple

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import get_cython_function_address, intrinsic
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import inner

NO_TRANSPOSE = ord("N")


class Factors(NamedTuple):
    """Equations of the slipping nodes, factorised, for as long as the same nodes slip and are open.

    ``columns`` (2n, 2n): the columns of a matrix, then its factors; ``slipping`` (n,) the nodes, of which
    ``known`` (2,) says how many there are and how often nodes had opened or closed, or −1 where there
    are no factors. ``sizes`` and ``pivots`` are LAPACK's, ``routines`` the addresses of what factorises
    and of what solves.
    """

    columns: FloatArray
    slipping: NDArray[np.int64]
    known: NDArray[np.int64]
    sizes: NDArray[np.int32]
    pivots: NDArray[np.int32]
    routines: NDArray[np.int64]


def no_factors(n: int) -> Factors:
    """Arrays for the equations of n nodes."""
    return Factors(
        np.empty((2 * n, 2 * n)), np.empty(n, dtype=np.int64), np.full(2, -1), np.zeros(5, dtype=np.int32),
        np.empty(2 * n, dtype=np.int32), solver_routines(),
    )  # fmt: skip


@intrinsic
def _call(typing: Any, address: Any, arguments: Any) -> Any:
    """Call the function at an address with addresses as arguments; no result."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        pointer, count = ir.IntType(8).as_pointer(), arguments.count
        kind = ir.FunctionType(ir.VoidType(), [pointer] * count).as_pointer()
        given = [builder.inttoptr(builder.extract_value(values[1], k), pointer) for k in range(count)]
        builder.call(builder.inttoptr(values[0], kind), given)
        return context.get_dummy_value()

    return types.void(types.int64, arguments), generate


call: Any = _call


@intrinsic
def _address(typing: Any, pointer: Any) -> Any:
    """Where a pointer points."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        return builder.ptrtoint(values[0], ir.IntType(64))

    return types.int64(pointer), generate


address: Any = _address


def solver_routines() -> NDArray[np.int64]:
    """The addresses of the routines that factorise and solve."""
    found = [get_cython_function_address("scipy.linalg.cython_lapack", f"dget{k}") for k in ("rf", "rs")]
    return np.array(found, dtype=np.int64)


@inner
def factorise(factors, n):  # type: ignore[no-untyped-def]
    """Factorise the first n columns; False where they are singular."""
    sizes = factors.sizes  # unknowns, space for a column, right sides, what went wrong, whether transposed
    sizes[0], sizes[1], sizes[2], sizes[3], sizes[4] = n, len(factors.pivots), 1, 0, NO_TRANSPOSE
    at, matrix, order = sizes.ctypes.data, factors.columns.ctypes.data, factors.pivots.ctypes.data
    call(factors.routines[0], (at, at, matrix, at + 4, order, at + 12))
    return sizes[3] == 0


@inner
def solve(factors, right):  # type: ignore[no-untyped-def]
    """Solve for a right side, in place, with the factors."""
    at, matrix, order = factors.sizes.ctypes.data, factors.columns.ctypes.data, factors.pivots.ctypes.data
    call(
        factors.routines[1],
        (at + 16, at, at + 8, matrix, at + 4, order, right.ctypes.data, at + 4, at + 12),
    )
