"""The closing box: shakedown of weakly coupled joints from every initial state, by one linear system."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np

from shakedown.bounds.coupling import coupling
from shakedown.model.arguments import require_problem
from shakedown.model.constraints import constraints
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class ClosingBox(Result):
    """The box into which every motion with all nodes closed is drawn.

    Attributes
    ----------
    load_factor
        The largest at which, for all smaller ones too, every node's forward slip inside the box
        ends below where its backward slip begins: all slip ceases. 0 where even the mean load
        leaves this open, NaN where the coupling ratio is not below 1, and for a load domain: the
        box of the long run needs that every load step returns in each period.
    node
        The node that ends it; −1 where none does.
    lower, upper : (n,)
        The box at ``load_factor`` [length] (at 0 where that is infinite); NaN where there is none.
    """

    load_factor: float
    node: int
    lower: FloatArray
    upper: FloatArray


def closing_box(problem: Problem) -> ClosingBox:
    """The largest load factor at which the closing box proves shakedown from every initial state.

    With N the slip-to-slip influence and ρ(N) < 1, the limits between which node i comes to rest
    are a contraction of those of the others. Its fixed point is affine in λ as long as

        largest forward limit over box and loop < smallest backward limit over box and loop

    for every node: one system of 2n equations with two right-hand sides, then the first λ at
    which one of n affine functions vanishes.

    Examples
    --------
    >>> import shakedown
    >>> closing = closing_box(shakedown.example("two-node"))
    >>> round(closing.load_factor, 7), closing.node
    (0.6543765, 1)
    """
    require_problem(problem)
    n, missing = problem.n, np.full(problem.n, nan)
    if problem.is_domain or not coupling(problem).bound < 1.0:
        return ClosingBox(nan, -1, missing, missing)
    rows = constraints(problem)
    own = np.abs(rows.G[np.arange(2 * n), rows.node])[:, None]
    loads = np.column_stack([rows.g, -rows.d]) / own  # at λ = 0, and per unit of λ
    up, down = loads[0::2], -loads[1::2]  # smallest backward limit, largest forward limit, others at zero
    influence = rows.G / own
    influence[np.arange(2 * n), rows.node] = 0.0
    lower = -influence[1::2]  # forward limit = down − lower · v
    upper = influence[0::2]  # backward limit = up − upper · v
    # (l, u) = (down, up) − K (l, u): the least forward limit and the largest backward one over the box.
    K = np.block([[np.minimum(lower, 0), np.maximum(lower, 0)], [np.maximum(upper, 0), np.minimum(upper, 0)]])
    box = np.linalg.solve(np.eye(2 * n) + K, np.vstack([down, up]))
    low, high = box[:n], box[n:]
    first = (
        up - np.maximum(upper, 0) @ high - np.minimum(upper, 0) @ low
    )  # smallest backward limit over the box
    last = (
        down - np.maximum(lower, 0) @ low - np.minimum(lower, 0) @ high
    )  # largest forward limit over the box
    gap = first - last
    if np.any(gap[:, 0] <= 0):
        node, load_factor = int(np.argmin(gap[:, 0])), 0.0
    else:
        ends = np.divide(gap[:, 0], -gap[:, 1], out=np.full(n, inf), where=gap[:, 1] < 0)
        node, load_factor = int(np.argmin(ends)), float(ends.min())
    at = load_factor if load_factor < inf else 0.0
    return ClosingBox(
        load_factor, node if load_factor < inf else -1, low @ np.array([1.0, at]), high @ np.array([1.0, at])
    )
