"""Both bounds of the load factor."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Literal

from shakedown.bounds.certificate import LOWER_CERTIFIED_UP_TO
from shakedown.bounds.upper import UpperBound, upper_bound
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import checked, require_plane
from shakedown.joint.constraints import constraints, through_transient
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result
from shakedown.planar.collapse.lower import LowerBound, lower_bound


@dataclass(frozen=True, eq=False, repr=False)
class ShakedownBounds(Result):
    """Both bounds of one problem: between them the outcome depends on the initial state.

    The lower bound is that of the joint with all nodes closed; the upper one names the nodes
    that are open (``upper.open_nodes``), and is then no bound but of that zone. Both are about
    the loop, and so about slips that are locked in when transient load steps are over.
    ``through_transient`` is the largest load factor at which one slip is safe under these too;
    None where there are none, or where nodes are open.
    """

    lower: LowerBound
    upper: UpperBound
    tolerances: Tolerances = field(default=DEFAULT, repr=False)
    through_transient: UpperBound | None = None

    def columns(self) -> dict[str, Any]:
        """The safe slip, the witness and the load factor at which each node collapses."""
        lower, upper = self.lower, self.upper
        return {"safe_slip": upper.slip, "witness": lower.slip, "collapses_at": lower.per_node}

    @property
    def have_gap(self) -> bool:
        """Whether there are load factors between the bounds, with a safe slip to keep near to.

        Never where nodes are open: the bounds are then of different zones.
        """
        first, last = self.lower.load_factor, self.upper.load_factor
        if self.upper.open_nodes:
            return False
        return self.upper.status == Status.OPTIMAL and bool(first < last * (1 - self.tolerances.feasibility))


@checked
def shakedown_bounds(
    problem: Problem,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    certify: bool | None = None,
    tolerances: Tolerances = DEFAULT,
) -> ShakedownBounds:
    """Lower and upper bound of the load factor.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    open_nodes
        The nodes that stay open, for the upper bound (:func:`upper_bound`).
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
    require_plane("bounds", problem)
    upper = upper_bound(problem, open_nodes=open_nodes, certify=certify, tolerances=tolerances)
    exact = problem.n <= LOWER_CERTIFIED_UP_TO if certify is None else certify
    lower = lower_bound(problem, certify=exact, tolerances=tolerances)
    before = None
    if not upper.open_nodes and through_transient(problem) is not constraints(problem):
        before = upper_bound(problem, transient=True, tolerances=tolerances)
    return ShakedownBounds(lower, upper, tolerances, before)
