"""How strongly slip of one node moves the limits of the others."""

from dataclasses import dataclass
from math import nan

import numpy as np

from shakedown.model.derived import once_per_problem
from shakedown.model.problem import FloatArray, Problem
from shakedown.model.result import Result
from shakedown.model.rigid_slips import rigid_slips
from shakedown.uniqueness.weak_coupling import influence

WEAK = 1.0 / 3.0  # weak coupling: no cycle at all is possible below the first collapse
_TRACE = 1e-10  # of coupling between all nodes makes the Perron vector positive where N is reducible
_LEAST_WEIGHT = 1e-12  # of a node that hardly takes part in the coupling


@dataclass(frozen=True, eq=False, repr=False)
class Coupling(Result):
    """Slip-to-slip influence N and its spectral radius.

    With every other slip fixed, node i may slip between L_i and U_i, where its
    rows are met. If the other slips change by δ, both limits change by at most
    N |δ|, N_ij = max over the sides of |A_ij ∓ f_i B_ij| / (A_ii ∓ f_i B_ii).

    Attributes
    ----------
    ratio
        ρ, the spectral radius of N; NaN where a node is at or above its own
        critical friction A_ii / |B_ii|, where N is not defined.
    bound
        A number ≥ ρ with N d ≤ bound · d for the vector below (Collatz–Wielandt).
    weights : (n,)
        d > 0, the Perron vector of N, largest entry 1.
    influence : (n, n)
        N.
    """

    ratio: float
    bound: float
    weights: FloatArray
    influence: FloatArray


@once_per_problem
def coupling(problem: Problem) -> Coupling:
    """The coupling ratio ρ of a problem; worked out once per problem.

    Examples
    --------
    >>> import shakedown
    >>> round(coupling(shakedown.example("two-node")).ratio, 4)
    0.4274
    """
    n, N = problem.n, influence(problem.A, problem.f[:, None] * problem.B)
    if N is None:
        return Coupling(nan, nan, np.full(n, nan), np.full((n, n), nan))
    ratio = float(np.abs(np.linalg.eigvals(N)).max())
    values, vectors = np.linalg.eig(N + _TRACE * (ratio or 1.0))
    weights = np.abs(np.real(vectors[:, np.argmax(np.real(values))]))
    weights = np.maximum(weights / weights.max(), _LEAST_WEIGHT)
    least = 1.0 if rigid_slips(problem).pinned else 0.0  # A z = 0 gives |z| <= N |z|
    return Coupling(ratio, max(float(np.max(N @ weights / weights)), least), weights, N)
