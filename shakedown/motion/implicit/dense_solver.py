"""Linear equations in compiled loops by LAPACK's dgesv, at its address: nothing of it is compiled."""

from typing import Any

import numpy as np
from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import get_cython_function_address, intrinsic

from shakedown.motion.kernels.named_state import inner

ARGUMENTS = 8  # of dgesv, all of them addresses


def address_of_solver() -> int:
    """Where SciPy's dgesv is."""
    return int(get_cython_function_address("scipy.linalg.cython_lapack", "dgesv"))


@intrinsic
def _call(typing: Any, address: Any, arguments: Any) -> Any:
    """Call the function at an address with other addresses; it returns nothing."""

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        pointer = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [pointer] * ARGUMENTS).as_pointer()
        given = [builder.extract_value(values[1], k) for k in range(ARGUMENTS)]
        builder.call(builder.inttoptr(values[0], kind), [builder.inttoptr(value, pointer) for value in given])
        return context.get_dummy_value()

    return types.void(types.int64, types.UniTuple(types.uintp, ARGUMENTS)), generate


call: Any = _call


@inner
def solve_columns(address, columns, right):  # type: ignore[no-untyped-def]
    """Solve M x = right in place, ``columns`` (n, n) the columns of M; False where M is singular.

    Both are overwritten.
    """
    n = len(right)
    sizes, pivots = np.empty(4, dtype=np.int32), np.empty(n, dtype=np.int32)
    sizes[0], sizes[1], sizes[2], sizes[3] = (
        n,
        1,
        n,
        0,
    )  # unknowns, right sides, their stride, what went wrong
    at, matrix, order, found = sizes.ctypes.data, columns.ctypes.data, pivots.ctypes.data, right.ctypes.data
    call(address, (at, at + 4, matrix, at + 8, order, found, at + 8, at + 12))
    return sizes[3] == 0
