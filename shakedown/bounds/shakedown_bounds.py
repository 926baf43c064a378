"""Both bounds of the load factor."""

from dataclasses import dataclass, field

from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO
from shakedown.bounds.lower import LowerBound, lower_bound
from shakedown.bounds.upper import UpperBound, upper_bound
from shakedown.model.problem import Problem
from shakedown.model.status import Status
from shakedown.tolerances import DEFAULT, Tolerances


@dataclass(frozen=True)
class ShakedownBounds:
    """Both bounds of one problem: between them the outcome depends on the initial state."""

    lower: LowerBound
    upper: UpperBound
    tolerances: Tolerances = field(default=DEFAULT, repr=False)

    @property
    def have_gap(self) -> bool:
        """Whether there are load factors between the bounds, with a safe slip to keep near to."""
        first, last = self.lower.load_factor, self.upper.load_factor
        return self.upper.status == Status.OPTIMAL and bool(first < last * (1 - self.tolerances.feasibility))


def shakedown_bounds(
    problem: Problem, *, certify: bool | None = None, tolerances: Tolerances = DEFAULT
) -> ShakedownBounds:
    """Lower and upper bound of the load factor.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    certify
        Whether to check both in exact arithmetic; by default each where that is quick.
    tolerances
        The tolerances that decide.

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
    upper = upper_bound(problem, certify=certify, tolerances=tolerances)
    exact = problem.n <= LOWER_CERTIFIED_UP_TO if certify is None else certify
    lower = lower_bound(problem, certify=exact, tolerances=tolerances)
    return ShakedownBounds(lower, upper, tolerances)
