"""How far the first collapse is a guarantee of shakedown from every initial state."""

from dataclasses import dataclass
from itertools import product
from math import nan

import numpy as np

from shakedown.problem import Problem


@dataclass(frozen=True)
class GuaranteeStatus:
    """Status of the guarantee below the first collapse, with the evidence.

    Attributes
    ----------
    guarantee
        ``"proved"``, ``"single-node-excluded"`` or ``"evidence"``.
    reason
        Why, in words.
    coupling_ratio
        ρ; NaN where undefined or not computed.
    single_node_bound
        Load factor below which no node alone can slip cyclically; NaN where not computed.
    """

    guarantee: str
    reason: str
    coupling_ratio: float = nan
    single_node_bound: float = nan


def guarantee_status(problem: Problem, load_factor: float) -> GuaranteeStatus:
    """What is proved about shakedown from every initial state below the first collapse.

    Examples
    --------
    >>> import shakedown
    >>> guarantee_status(shakedown.example("uncoupled"), 0.6).reason
    "no coupling (B = 0): Melan's theorem holds, both bounds coincide"
    """
    if not problem.B.any():
        return GuaranteeStatus("proved", "no coupling (B = 0): Melan's theorem holds, both bounds coincide")
    if problem.n > 2:
        return GuaranteeStatus("evidence", "more than two coupled nodes: there is no proof, only simulation")
    if not _unique_in_contact(problem):
        return GuaranteeStatus(
            "evidence", "friction at or above the threshold of uniqueness: there is no proof"
        )
    nodes = "one node" if problem.n == 1 else "two nodes"
    return GuaranteeStatus("proved", f"{nodes} below the friction thresholds: proved (thesis §4.4)")


def _unique_in_contact(problem: Problem) -> bool:
    """Whether every principal minor of A ± f B is positive, for one or two nodes."""
    fB = problem.f[:, None] * problem.B
    for signs in product((-1.0, 1.0), repeat=problem.n):
        matrix = problem.A + np.array(signs)[:, None] * fB
        if np.any(np.diag(matrix) <= 0) or np.linalg.det(matrix) <= 0:
            return False
    return True
