"""Both bounds of the load factor."""

from dataclasses import dataclass

from shakedown.bounds.lower import LowerBound, lower_bound
from shakedown.bounds.upper import UpperBound, upper_bound
from shakedown.model.problem import Problem


@dataclass(frozen=True)
class ShakedownBounds:
    """Both bounds of one problem: between them the outcome depends on the initial state."""

    lower: LowerBound
    upper: UpperBound

    @property
    def have_gap(self) -> bool:
        """Whether there are load factors between the bounds, with a safe slip to keep near to."""
        first, last = self.lower.load_factor, self.upper.load_factor
        return self.upper.status == "optimal" and bool(first < last * (1 - 1e-9))


def shakedown_bounds(problem: Problem, *, certify: bool | None = None) -> ShakedownBounds:
    """Lower and upper bound of the load factor.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    certify
        Whether to check both in exact arithmetic; by default where that is quick.

    Raises
    ------
    SolverError
        If a linear program ends without an answer.

    Examples
    --------
    >>> import shakedown
    >>> bounds = shakedown.shakedown_bounds(shakedown.example("two-node"))
    >>> round(bounds.lower.load_factor, 6), round(bounds.upper.load_factor, 6)
    (0.657373, 0.739146)
    """
    return ShakedownBounds(lower_bound(problem, certify=certify), upper_bound(problem, certify=certify))
