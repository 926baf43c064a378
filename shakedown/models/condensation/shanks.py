"""Shanks of bolts: springs between what two patches move on average."""

from collections.abc import Sequence

from scipy import sparse

from shakedown.ground.float_array import FloatArray


def with_shanks(K: sparse.csr_array, shanks: Sequence[tuple[float, FloatArray]]) -> sparse.csr_array:
    """K + Σ k e eᵀ, of shanks with stiffness k that get shorter by e · u.

    Examples
    --------
    >>> import numpy as np
    >>> with_shanks(sparse.csr_array((2, 2)), [(3.0, np.array([1.0, -1.0]))]).toarray().tolist()
    [[3.0, -3.0], [-3.0, 3.0]]
    """
    for stiffness, shortening in shanks:
        if stiffness:
            e = sparse.csr_array(shortening[None])
            K = K + stiffness * (e.T @ e)
    return K
