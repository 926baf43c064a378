"""Matrix Market files, as Ansys and others export them, with a map file."""

import os
import warnings

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.io import mmread

from shakedown.errors import ProblemError
from shakedown.readers.stiffness import Stiffness, with_map
from shakedown.readers.text import read_lines


def read_matrix_market(path: str | os.PathLike[str], dofs: NDArray[np.intp] | None = None) -> Stiffness:
    """Read a real Matrix Market matrix; a symmetric one is mirrored.

    Parameters
    ----------
    path
        The file.
    dofs : (N, 2)
        The map, which the format does not hold.

    Raises
    ------
    ProblemError
        If the file is malformed or there is no map of its size.
    """
    name = os.fspath(path)
    banner = read_lines(path)[0].lower()
    if "complex" in banner or "pattern" in banner:
        raise ProblemError(f"{name}: line 1: expected a real matrix, found '{banner.strip()}'")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            matrix = mmread(name)
    except (ValueError, OverflowError, IndexError, TypeError) as error:
        raise ProblemError(f"{name}: expected a Matrix Market file, found damaged data ({error})") from None
    return with_map(sparse.csr_array(matrix).astype(float), dofs, name, "Matrix Market")
