"""The metric in which forward and backward slip of every node are farthest apart."""

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import block_diag, bmat, coo_array, csr_array

from shakedown.model.problem import FloatArray
from shakedown.universal.admissible_states import AdmissibleStates
from shakedown.universal.shrinking_box import LimitBox

SIMPLEX_UP_TO = 12  # nodes; beyond, the interior point method of HiGHS is much quicker
LEAST_WIDTH = 1e-6  # of the widest side: a side of the box below this does not set a scale


def best_metric(states: AdmissibleStates, box: LimitBox) -> FloatArray | None:
    """A symmetric P that keeps P_i · v smaller in forward than in backward slip of node i, by the widest gap.

    For a given P the largest P_i · v in forward slip is a linear program. Its dual, a minimum, is
    written into one program together with the unknown P, for every node and side: maximise δ
    subject to  sup_forward P_i·v − inf_backward P_i·v ≤ −δ  and |P_ij| ≤ 1 in units of the box.
    P need not be definite, as the box bounds the potential ½ vᵀPv − zᵀv; and P_is is free for a node s that
    stands, because z may depend on where it stands.

    Returns None where the program does not end.
    """
    n = states.n
    low, high, lower, upper = box.within
    width = np.maximum(upper - lower, LEAST_WIDTH * (upper - lower).max())
    scale = np.abs(states.G * width).max(axis=1)
    G, S = states.G * width / scale[:, None], states.loads / scale[:, None]
    room = (states.g - states.G @ lower) / scale
    moving = [int(i) for i in np.flatnonzero(~box.standing)]
    pairs = [(i, j) for i in range(n) for j in range(i, n) if not (box.standing[i] and box.standing[j])]
    number = {pair: c for c, pair in enumerate(pairs)}
    k, size = S.shape[1], 3 * n + 2  # columns of one dual: 2n rows, n upper sides, high, low
    slips = np.column_stack([G.T, np.eye(n), np.zeros((n, 2))])
    loads = np.column_stack([S.T, np.zeros((k, n)), np.ones((k, 1)), -np.ones((k, 1))])
    value = np.concatenate([room, (upper - lower) / width, [high, -low]])
    duals = 2 * len(moving)
    rows: list[int] = []
    columns: list[int] = []
    entries: list[float] = []
    for c, i in enumerate(moving):
        for side, sign in enumerate((-1.0, 1.0)):
            rows += [(2 * c + side) * n + j for j in range(n)]
            columns += [number[(min(i, j), max(i, j))] for j in range(n)]
            entries += [sign] * n
    metric = coo_array((entries, (rows, columns)), shape=(duals * n, len(pairs)))
    # sup c·x over x ≥ 0, slips x ≤ …: duals ≥ 0 with (dual of x) ≥ c.
    above = bmat(
        [
            [-block_diag([csr_array(slips)] * duals), -metric, None],
            [-block_diag([csr_array(loads)] * duals), None, None],
            [
                block_diag([csr_array(np.tile(value, 2)[None])] * len(moving)),
                None,
                np.ones((len(moving), 1)),
            ],
        ],
        format="csr",
    )
    least = np.zeros((len(moving), 2, size))
    for c, i in enumerate(moving):
        least[c, 0, 2 * i + 1] = least[c, 1, 2 * i] = -np.inf  # active rows have multipliers of either sign
    most = np.concatenate([np.full(least.size, np.inf), np.ones(len(pairs) + 1)])
    bounds = np.column_stack([np.concatenate([least.ravel(), -np.ones(len(pairs)), [-np.inf]]), most])
    cost = np.zeros(above.shape[1])
    cost[-1] = -1.0
    found = linprog(
        cost,
        A_ub=above,
        b_ub=np.zeros(above.shape[0]),
        bounds=bounds,
        method="highs" if n <= SIMPLEX_UP_TO else "highs-ipm",
    )
    if found.x is None:
        return None
    P = np.zeros((n, n))
    for (i, j), place in number.items():
        P[i, j] = P[j, i] = found.x[duals * size + place] / (width[i] * width[j])
    return P
