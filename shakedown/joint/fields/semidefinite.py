"""The stiffness of a problem: symmetric, and positive semi-definite."""

from collections.abc import Mapping

import numpy as np

from shakedown.ground.errors import ProblemError
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT

CANCELLED = 2.0**-40  # of the largest stiffness: what may be left where larger ones cancel each other


def check_definiteness(arrays: Mapping[str, FloatArray], rounding: float) -> None:
    """Raise ``ProblemError`` unless κ, or A where there is no C, is positive semi-definite.

    Entries off by ``rounding`` of themselves move an eigenvalue by as much of the largest row sum.
    """
    if "C" in arrays:
        matrix = np.block([[arrays["A"], arrays["B"].T], [arrays["B"], arrays["C"]]])
        expected = "keys 'A', 'B', 'C': expected kappa = [[A, B^T], [B, C]] positive semi-definite"
    else:
        matrix, expected = arrays["A"], "key 'A': expected a positive semi-definite matrix"
    scale = np.abs(matrix).max()
    if scale == 0.0:
        return
    eigenvalues = np.linalg.eigvalsh(matrix / scale)
    printed = rounding * float(np.abs(matrix / scale).sum(axis=0).max())
    if eigenvalues[0] < -max(DEFAULT.definiteness * max(eigenvalues[-1], -eigenvalues[0]), printed):
        raise ProblemError(f"{expected}, found the eigenvalue {eigenvalues[0] * scale:.6g}")


def symmetrised(key: str, matrix: FloatArray, rounding: float, largest: float) -> FloatArray:
    """A block of κ, exactly symmetric; raises ``ProblemError`` where it is not so but for its rounding.

    Its entries may be off by ``rounding`` of themselves, and by the round-off of the ``largest`` stiffness.

    Examples
    --------
    >>> symmetrised("C", np.array([[1e-14, 2e-14], [0.0, 0.0]]), 0.0, largest=1.0)
    array([[1.e-14, 1.e-14],
           [1.e-14, 0.e+00]])
    """
    error = np.abs(matrix - matrix.T)
    if error.max() > max(max(DEFAULT.symmetry, 2 * rounding) * np.abs(matrix).max(), CANCELLED * largest):
        i, j = np.unravel_index(int(np.argmax(error)), error.shape)
        raise ProblemError(
            f"key '{key}': expected a symmetric matrix, found {key}[{i},{j}] = {matrix[i, j]:.9g} "
            f"but {key}[{j},{i}] = {matrix[j, i]:.9g}"
        )
    return 0.5 * matrix + 0.5 * matrix.T
