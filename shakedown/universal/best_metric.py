"""The metric in which forward and backward slip of every node are farthest apart."""

import clarabel
import numpy as np
from scipy.sparse import block_array, coo_array, csc_array, csr_array, eye_array, kron, vstack

from shakedown.model.problem import FloatArray
from shakedown.universal.admissible_states import AdmissibleStates
from shakedown.universal.shrinking_box import LimitBox

LEAST_WIDTH = 1e-6  # of the widest side: a side of the box below this does not set a scale
ACCURACY = 1e-7  # of the program: its P is checked by other programs, and the gap that it seeks is larger


def best_metric(states: AdmissibleStates, box: LimitBox) -> FloatArray | None:
    """A symmetric P that keeps P_i · v smaller in forward than in backward slip of node i, by the widest gap.

    For a given P the largest P_i · v in forward slip is a linear program. Its dual, a minimum, is
    written into one program together with the unknown P: maximise δ subject to

        sup_forward P_i·v − inf_backward P_i·v ≤ −δ for every node i,   |P_ij| ≤ 1 in units of the box.

    P need not be definite, as the box bounds the potential ½ vᵀPv − zᵀv; and P_is is free for a
    node s that stands, because z may depend on where it stands. What comes out is a proposal, to be
    checked. None where the program finds no gap, and in a box that is a point.
    """
    n, (low, high, lower, upper) = states.n, box.within
    if not np.any(upper > lower):
        return None
    width = np.maximum(upper - lower, LEAST_WIDTH * (upper - lower).max())
    scale = np.abs(states.G * width).max(axis=1)
    scale = np.where(scale > 0, scale, 1.0)  # a row that no slip changes
    dual = _Dual(
        G=states.G * width / scale[:, None],
        loads=states.loads / scale[:, None],
        value=np.concatenate([(states.g - states.G @ lower) / scale, (upper - lower) / width, [high, -low]]),
    )
    moving = [int(i) for i in np.flatnonzero(~box.standing)]
    number = _unknowns(n, moving)
    above = dual.rows(len(moving), _selection(n, moving, number))
    x = _widest_gap(above, *_bounds(n, moving, len(number)))
    if not x[-1] > 0.0:
        return None
    start = above.shape[1] - 1 - len(number)
    P = np.zeros((n, n))
    for (i, j), place in number.items():
        P[i, j] = P[j, i] = x[start + place] / (width[i] * width[j])
    return P


def _widest_gap(above: csr_array, least: FloatArray, most: FloatArray) -> FloatArray:
    """The columns that make the last one, δ, the largest, subject to all rows ≤ 0 and bounds of the columns.

    Sparse, with as many as a thousand columns per node: by interior points without a vertex.
    """
    columns = eye_array(above.shape[1], format="csr")
    below, beyond = np.isfinite(least), np.isfinite(most)
    matrix = vstack([above, -columns[below], columns[beyond]])
    right = np.concatenate([np.zeros(above.shape[0]), -least[below], most[beyond]])
    cost = np.zeros(above.shape[1])
    cost[-1] = -1.0
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.max_threads = 1
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = ACCURACY
    found = clarabel.DefaultSolver(
        csc_array((len(cost), len(cost))),
        cost,
        csc_array(matrix),
        right,
        [clarabel.NonnegativeConeT(len(right))],
        settings,
    ).solve()
    return np.array(found.x)


class _Dual:
    """Duals of sup {c · x : G x + S α ≤ g, 0 ≤ x ≤ width, Σ α = λ, low ≤ λ ≤ high}.

    The columns are the multipliers of 2n rows and n upper sides, of λ ≤ high and of λ ≥ low.
    """

    def __init__(self, G: FloatArray, loads: FloatArray, value: FloatArray) -> None:
        n, k = G.shape[1], loads.shape[1]
        self.slips = np.column_stack([G.T, np.eye(n), np.zeros((n, 2))])
        self.loads = np.column_stack([loads.T, np.zeros((k, n)), np.ones((k, 1)), -np.ones((k, 1))])
        self.value = value

    def rows(self, nodes: int, selection: coo_array) -> csr_array:
        """Everything as rows ≤ 0; columns: duals by node and side, P, δ."""
        duals = eye_array(2 * nodes)
        return block_array(
            [
                [-kron(duals, self.slips), -selection, None],
                [-kron(duals, self.loads), None, None],
                [kron(eye_array(nodes), np.tile(self.value, 2)[None]), None, np.ones((nodes, 1))],
            ],
            format="csr",
        )


def _unknowns(n: int, moving: list[int]) -> dict[tuple[int, int], int]:
    """The entries of P that matter: (smaller, larger index) and which unknown it is."""
    pairs = [(i, j) for i in range(n) for j in range(i, n) if i in moving or j in moving]
    return {pair: place for place, pair in enumerate(pairs)}


def _selection(n: int, moving: list[int], number: dict[tuple[int, int], int]) -> coo_array:
    """The rows −P_i (forward) and P_i (backward) of every moving node."""
    places = np.array([[number[(min(i, j), max(i, j))] for j in range(n)] for i in moving])
    columns = np.repeat(places[:, None, :], 2, axis=1).ravel()
    signs = np.tile(np.repeat([-1.0, 1.0], n), len(moving))
    return coo_array((signs, (np.arange(columns.size), columns)), shape=(columns.size, len(number)))


def _bounds(n: int, moving: list[int], unknowns: int) -> tuple[FloatArray, FloatArray]:
    """Multipliers ≥ 0, but of either sign in the active row; |P| ≤ 1; δ ≤ 1."""
    least = np.zeros((len(moving), 2, 3 * n + 2))
    for c, i in enumerate(moving):
        least[c, 0, 2 * i + 1] = least[c, 1, 2 * i] = -np.inf
    most = np.concatenate([np.full(least.size, np.inf), np.ones(unknowns + 1)])
    return np.concatenate([least.ravel(), -np.ones(unknowns), np.array([-np.inf])]), most
