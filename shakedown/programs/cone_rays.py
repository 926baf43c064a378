"""The distance in a given direction to the boundary of second-order cones of three rows."""

import numpy as np

from shakedown.ground.constants import FloatArray


def leaves_cone(start: FloatArray, along: FloatArray) -> FloatArray:
    """The largest t ≥ 0 at which ``start + t along`` is in the cone |(x, y)| ≤ h, from its point ``start``.

    Vectors (…, 3) are (h, x, y). inf where it never leaves; 0 where it does so at once.

    Examples
    --------
    >>> leaves_cone(np.array([1.0, 0.0, 0.5]), np.array([[0.0, 0.0, 2.0], [2.0, 0.0, 2.0]]))
    array([0.25,  inf])
    """
    size = np.ldexp(1.0, np.frexp(np.abs(along).max(axis=-1))[1])
    c, x, y = np.moveaxis(start, -1, 0)  # |(x, y) + t b|² − (c + t d)² = α t² + 2 β t + γ, and γ ≤ 0
    d, b_x, b_y = np.moveaxis(along / size[..., None], -1, 0)
    alpha, beta = b_x**2 + b_y**2 - d**2, x * b_x + y * b_y - c * d
    gamma = np.minimum(x**2 + y**2 - c**2, 0.0)
    root = np.sqrt(np.maximum(beta**2 - alpha * gamma, 0.0))
    ends = (beta**2 >= alpha * gamma) & ((alpha > 0) | (beta > 0))
    top, below = np.where(beta > 0, -gamma, root - beta), np.where(beta > 0, beta + root, alpha)
    return np.divide(top, below, out=np.full_like(top, np.inf), where=ends) / size
