"""Safe slips: slips that satisfy every frictional constraint, with as much slack as possible."""

from collections.abc import Iterable
from typing import Literal

from shakedown.bounds.best_zone import chosen_zone
from shakedown.bounds.plane_or_space import methods_of
from shakedown.bounds.results import SafeSlip as SafeSlip
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import check_load_factor, checked
from shakedown.joint.problem import Problem


@checked
def safe_slip(
    problem: Problem,
    load_factor: float,
    *,
    open_nodes: Iterable[int] | Literal["auto"] = (),
    transient: bool = False,
    tolerances: Tolerances = DEFAULT,
) -> SafeSlip:
    """The safe slip farthest from slipping: max t with G v + t‖Gᵢ‖ ≤ g − λ d (thesis (5.4)).

    From this slip, locked in when the transient load steps are over, the system shakes down at
    once: no node ever moves. The transient itself may move it: ``transient``.

    Parameters
    ----------
    problem
        The contact and its loading loop.
    load_factor
        λ ≥ 0, the factor on the periodic part of the loading.
    open_nodes, transient
        As for :func:`upper_bound`, which of a zone gives the least safe slip; this one has the most slack.
    tolerances
        ``feasibility`` decides what is safe.

    Raises
    ------
    UsageError
        If the load factor is negative or not finite, or nodes are open before the transient.

    Examples
    --------
    >>> import shakedown
    >>> safe = shakedown.safe_slip(shakedown.example("two-node"), 0.70)
    >>> safe.status.value, bool(safe.margin > 0)
    ('optimal', True)
    >>> shakedown.safe_slip(shakedown.example("two-node"), 0.75).status.value
    'infeasible'
    """
    check_load_factor(load_factor, problem)
    zone, _ = chosen_zone(problem, open_nodes, tolerances)
    return methods_of(problem).safe_slip(zone, load_factor, transient, tolerances)
