"""The distance in a given direction to the boundary of second-order cones of three rows."""

import numpy as np

from shakedown.ground.float_array import FloatArray


def way_to_limits(G: FloatArray, right: FloatArray, centre: FloatArray, directions: FloatArray) -> FloatArray:
    """The largest t at which right − G (centre + t direction) is in the cone, of all cones, (k,).

    Parameters
    ----------
    G, right : (3r, dn), (3r,)
        Second-order cones of three rows each [force/length, force].
    centre : (dn,)
        Slips [length].
    directions : (k, dn)
        Slips for t = 1 [length].

    Returns
    -------
    (k,)
        inf where none is ever left; 0 where the centre itself is in none of them.

    Examples
    --------
    A node that is pressed by 1 with f = 0.5, and how far its spring reaches:

    >>> way_to_limits(np.vstack([np.zeros(2), -np.eye(2)]), np.array([0.5, 0.0, 0.0]), np.zeros(2), np.eye(2))
    array([0.5, 0.5])
    """
    start = (right - G @ centre).reshape(-1, 3)
    if (np.hypot(start[:, 1], start[:, 2]) > start[:, 0]).any():
        return np.zeros(len(directions))
    along = (-directions @ G.T).reshape(len(directions), -1, 3)
    return np.asarray(leaves_cone(start, along).min(axis=-1))


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
