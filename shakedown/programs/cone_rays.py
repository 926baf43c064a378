"""How far one may go in a direction before a second-order cone of three rows is left."""

import numpy as np

from shakedown.ground.float_array import FloatArray


def way_to_limits(G: FloatArray, right: FloatArray, centre: FloatArray, directions: FloatArray) -> FloatArray:
    """The largest t at which right − G (centre + t direction) is in the cone, of all cones, (k,).

    Along a direction a cone s = (f p, q) ends where |q|² = (f p)², c + 2 b t + a t² = 0, at the first t > 0.

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
    head, *q = (right - G @ centre).reshape(-1, 3).T[:, :, None]
    if (np.hypot(*q) > head).any():
        return np.zeros(len(directions))
    per_head, *per_q = np.moveaxis((-G @ directions.T).reshape(-1, 3, len(directions)), 1, 0)
    c = np.sum(np.square(q), axis=0) - head**2
    b = np.sum(np.multiply(q, per_q), axis=0) - head * per_head
    a = np.sum(np.square(per_q), axis=0) - per_head**2
    root = b + np.sqrt(np.maximum(b**2 - a * c, 0.0))
    ends = (root > 0) & (b**2 >= a * c)
    return np.asarray(np.divide(-c, root, out=np.full_like(root, np.inf), where=ends).min(axis=0))
