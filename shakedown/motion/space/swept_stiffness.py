"""κ with its open nodes eliminated, and the state of a joint in it.

Node by node: u = (v_x, v_y, w), r = (q_x, q_y, p), r = r_w + κ u. Of a closed node u is given, of an
open one r = 0. The matrix N of the symmetric sweep operator takes what is given to what follows,

    out = N given,   given = u and out = r − r_w of closed nodes,
                     given = r_w − r and out = u of open ones,

so that a node that opens or closes costs one update of rank three, and as long as the same nodes are
open nothing has to be eliminated again.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from shakedown.ground.float_array import FloatArray
from shakedown.ground.named_state import borrowing, inner, summing
from shakedown.ground.round_off import ROUND_OFF

MOST_UPDATES = 2000  # updates before N is recomputed from κ, as each adds round-off


class Body(NamedTuple):
    """Constant data: κ (3n, 3n) node by node, friction, the stiffness of each node alone.

    ``tangential`` and ``normal`` (n,) [force/length] weigh slips against tangential reactions and gaps
    against pressures; ``block`` (n,) are the determinants of the nodes' own blocks. ``separable`` is
    False where C is not known.
    """

    kappa: FloatArray
    f: FloatArray
    tangential: FloatArray
    normal: FloatArray
    block: FloatArray
    separable: bool


class Tableau(NamedTuple):
    """N, its open nodes, given and dependent quantities, the welded reactions.

    ``updates`` (2,): how often a node has opened or closed since N was made from κ, and in all.
    """

    N: FloatArray
    is_open: NDArray[np.bool_]
    given: FloatArray
    out: FloatArray
    r_w: FloatArray
    updates: NDArray[np.int64]


@summing
def product(M, u, found):  # type: ignore[no-untyped-def]
    """M u."""
    for i in range(len(u)):
        total = 0.0
        for j in range(len(u)):
            total += M[i, j] * u[j]
        found[i] = total


@borrowing
def shift(tableau, i, x, y, z):  # type: ignore[no-untyped-def]
    """Change the given quantities of node i."""
    k, given, out, N = 3 * i, tableau.given, tableau.out, tableau.N
    given[k] += x
    given[k + 1] += y
    given[k + 2] += z
    first, second, third = N[k], N[k + 1], N[k + 2]
    for j in range(len(out)):
        out[j] += x * first[j] + y * second[j] + z * third[j]


@borrowing
def inverse(M, k, P):  # type: ignore[no-untyped-def]
    """The inverse P of the symmetric block of M at k; returns its determinant."""
    a, b, c = M[k, k], M[k, k + 1], M[k, k + 2]
    d, e, g = M[k + 1, k + 1], M[k + 1, k + 2], M[k + 2, k + 2]
    A, B, C = d * g - e * e, c * e - b * g, b * e - c * d
    det = a * A + b * B + c * C
    P[0, 0], P[0, 1], P[0, 2] = A / det, B / det, C / det
    P[1, 1], P[1, 2], P[2, 2] = (a * g - c * c) / det, (b * c - a * e) / det, (a * d - b * b) / det
    P[1, 0], P[2, 0], P[2, 1] = P[0, 1], P[0, 2], P[1, 2]
    return det


@inner
def exchange(body, tableau, i):  # type: ignore[no-untyped-def]
    """Exchange given and dependent quantities of node i; False where nothing would hold it."""
    k, N, was_open = 3 * i, tableau.N, tableau.is_open[i]
    P = np.empty((3, 3))
    det = inverse(N, k, P)
    if not was_open and not det > ROUND_OFF * body.block[i]:
        return False
    own = np.empty((3, len(N)))
    for s in range(len(N)):
        own[0, s], own[1, s], own[2, s] = N[k, s], N[k + 1, s], N[k + 2, s]
    sign = 1.0 if was_open else -1.0
    for r in range(len(N)):
        if k <= r < k + 3:
            continue
        x = P[0, 0] * own[0, r] + P[0, 1] * own[1, r] + P[0, 2] * own[2, r]
        y = P[1, 0] * own[0, r] + P[1, 1] * own[1, r] + P[1, 2] * own[2, r]
        z = P[2, 0] * own[0, r] + P[2, 1] * own[1, r] + P[2, 2] * own[2, r]
        for s in range(len(N)):
            N[r, s] -= x * own[0, s] + y * own[1, s] + z * own[2, s]
        N[r, k], N[r, k + 1], N[r, k + 2] = sign * x, sign * y, sign * z
        N[k, r], N[k + 1, r], N[k + 2, r] = sign * x, sign * y, sign * z
    for a in range(3):
        for b in range(3):
            N[k + a, k + b] = -P[a, b]
    for a in range(k, k + 3):
        kept = tableau.given[a]
        tableau.given[a], tableau.out[a] = sign * tableau.out[a], -sign * kept
    tableau.is_open[i] = not was_open
    tableau.updates[0] += 1
    tableau.updates[1] += 1
    return True
