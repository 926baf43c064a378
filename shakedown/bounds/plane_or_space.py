"""Which methods answer for a joint: rows and linear programs in the plane, discs and cone programs in space.

This is the one place that asks, and it computes nothing. Zones, statuses, certificates and words around the
methods are written once. ``plane_methods`` and ``space_methods`` have the same functions, and constants:
``FEW_NODES`` (above this number a run takes more than hundredths of a second: fewer runs, less accurate, in
threads), ``HOLDING_BALL_SOONER`` (whether an energy ball that holds a slip is found sooner than the largest
one), ``MOST_ZONES`` (largest number of contact zones solved in a search, whose answer is the best one so
far), ``ALL_COMPARED_UP_TO`` (nodes up to which all zones that differ in one node are compared, and searches
begin in every start), ``CHANGES_AT_ONCE`` (numbers of nodes changed at once, the first ones first).
"""

from typing import Any

from shakedown.joint.problem import Problem


def takes_long(problem: Problem) -> bool:
    """Whether runs of a joint take so long that fewer are made, less accurately, in several threads."""
    return problem.n > methods_of(problem).FEW_NODES


def methods_of(problem: Problem) -> Any:
    """The methods of a joint; those of the other kind are not loaded.

    Examples
    --------
    >>> import shakedown
    >>> methods_of(shakedown.example("two-node")).__name__
    'shakedown.bounds.plane_methods'
    """
    if problem.directions > 1:
        from shakedown.bounds import space_methods

        return space_methods
    from shakedown.bounds import plane_methods

    return plane_methods
