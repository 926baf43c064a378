"""How strongly slip of one node moves the limits of the others."""

from dataclasses import dataclass
from math import nan

import numpy as np

from shakedown.bounds.uniqueness.weak_coupling import influence, row_coupling_ratio
from shakedown.ground.float_array import FloatArray
from shakedown.joint.arguments import NO_SIGNS, require_plane
from shakedown.joint.derived import once_per_problem
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.joint.rigid_slips import rigid_slips


@dataclass(frozen=True, eq=False, repr=False)
class Coupling(Result):
    """Slip-to-slip influence of either side's limits, and the coupling ratio ρ*.

    With every other slip fixed, node i may slip between L_i and U_i, where its
    rows are met. If the other slips change by δ, U_i changes by at most (N₊ |δ|)_i and
    L_i by at most (N₋ |δ|)_i, N∓_ij = |A_ij ± f_i B_ij| / (A_ii ± f_i B_ii).

    Attributes
    ----------
    ratio
        ρ*, the least number for which some d > 0 has N₊ d ≤ ρ* d and N₋ d ≤ ρ* d; NaN where a node is
        at or above its own critical friction A_ii / (f_i |B_ii|), where it is not defined. Below 1
        the motion is unique and λ_1 is the limit of shakedown (docs/guarantee.md, statement 3).
    bound
        A number ≥ ρ* that the weights prove, rounded up.
    weights : (n,)
        These d > 0, largest entry 1: in their norm no limit moves by more than ρ* times the slips.
    influence : (2, n, n)
        N₊ of the backward limits, N₋ of the forward limits.
    """

    ratio: float
    bound: float
    weights: FloatArray
    influence: FloatArray


@once_per_problem
def coupling(problem: Problem) -> Coupling:
    """The coupling ratio ρ* of a problem; worked out once per problem.

    Examples
    --------
    >>> import shakedown
    >>> round(coupling(shakedown.example("two-node")).ratio, 4)
    0.4274
    >>> coupling(shakedown.example("three-node")).bound < 1
    False
    """
    require_plane("coupling", problem, NO_SIGNS)
    n, fB = problem.n, problem.law.limit_rows(problem.B)
    N, found = influence(problem.A, fB), row_coupling_ratio(problem.A, fB)
    if N is None or found is None:
        return Coupling(nan, nan, np.full(n, nan), np.full((2, n, n), nan))
    least = 1.0 if rigid_slips(problem).pinned else 0.0  # A z = B z = 0 gives |z| <= N |z|, but for round-off
    return Coupling(max(found.ratio, least), max(found.bound, least), found.weights, N)
