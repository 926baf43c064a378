"""What joins many limits to three numbers: which refute each other, which states the loads admit."""

from collections.abc import Iterator
from math import nan

import numpy as np

from shakedown.bounds.bound_result import Bound
from shakedown.ground.constants import CONE, FloatArray
from shakedown.ground.errors import Missing
from shakedown.ground.status import Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import Side, constraints, step_loads
from shakedown.joint.problem import Problem
from shakedown.programs.cone_rays import leaves_cone

THREE_NUMBERS = "impossible_above", "proved_from_this_state", "proved_from_every_state"
REFUTED = "round-off decides: its load factor is {:.7g}, although no slip is safe above {:.7g}"


def not_refuted(load_factor: float, upper: Bound, tolerances: Tolerances = DEFAULT) -> float:
    """What is proved, unless λ_max of closed nodes refutes it: NaN then.

    What is above it by ``agreement`` at most, as round-off in either may put it, is rounded down.

    Examples
    --------
    >>> import shakedown
    >>> upper = shakedown.upper_bound(shakedown.example("two-node"))
    >>> [not_refuted(share * upper.certified[1], upper) / upper.certified[0] for share in (1.0 + 1e-12, 1.1)]
    [1.0, nan]
    """
    if upper.open_nodes or upper.status not in (Status.OPTIMAL, Status.INFEASIBLE):
        return load_factor
    low, high = np.nan_to_num(upper.certified or (upper.load_factor, upper.load_factor)).tolist()
    if not load_factor > high:
        return load_factor
    return low if load_factor <= (1.0 + tolerances.agreement) * high else nan


def admitted_up_to(problem: Problem, slip: FloatArray, tolerances: Tolerances = DEFAULT) -> float:
    """The load factor up to which the first load step admits a slip with all nodes closed; 0 where none.

    The slip stays as it is, also at nodes without friction: λ_U is about states that are admissible so.
    :func:`~shakedown.bounds.onset.first_slip` is about a motion, in which those nodes follow the load.

    Examples
    --------
    >>> import shakedown
    >>> round(admitted_up_to(shakedown.example("two-node"), np.zeros(2)), 4)
    0.9998
    """
    rows, first = constraints(problem), step_loads(problem)[0]
    if rows.relative_excess(slip, 0.0).max() > tolerances.feasibility:
        return 0.0
    slack, law, in_discs = rows.g - rows.G @ slip, problem.law, np.inf
    if problem.directions > 1:
        heads = rows.heads[np.unique(rows.node[rows.heads], return_index=True)[1]]
        limits = slack[heads[:, None] + np.arange(CONE)]
        in_discs = leaves_cone(limits, -law.of_nodes(first)).min()
        slack, first = slack[rows.side != Side.DISC], first[law.rows * problem.n :]
    rising = first > 0
    return max(float(np.min(slack[rising] / first[rising], initial=in_discs)), 0.0)


def open_ends(*results: Bound | Missing) -> Iterator[str]:
    """One sentence for each result that is open or disputed.

    A limit that does not exist, like λ_1 with two tangential directions, is not open.

    Examples
    --------
    >>> import shakedown
    >>> list(open_ends(shakedown.upper_bound(shakedown.example("two-node"))))
    []
    """
    for result in results:
        if isinstance(result, Missing):
            continue
        if result.undecided:
            yield f"{result.symbol} is open: {result.reason}"
        elif result.disputed:
            yield f"{result.symbol} is disputed: {result.uncertified}"
