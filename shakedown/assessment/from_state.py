"""What is proved from one state: the largest of its bounds, and of every state where it is one."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.limit_names import SYMBOLS
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import CONE, Side, constraints, step_loads
from shakedown.joint.problem import Problem
from shakedown.programs.cone_rays import leaves_cone

if TYPE_CHECKING:
    from shakedown.bounds.accumulated.accumulated_bound import AccumulatedBound
    from shakedown.bounds.collapse.box_bound import BoxBound
    from shakedown.bounds.energy.energy_bound import EnergyBound


ENERGY, BOX, SLIP = (SYMBOLS[word] for word in ("energy", "box", "accumulated"))


class FromState(NamedTuple):
    """Between which load factors shakedown is proved from one state, and by which bound.

    Attributes
    ----------
    symbol
        λ_E, λ_box or λ_S, whichever is the largest.
    load_factor
        Where the proof ends; NaN where nothing is proved.
    least_load_factor
        Where it begins: zero but for a λ_E of a mean load that is not safe by itself.
    """

    symbol: str
    load_factor: float
    least_load_factor: float


def from_state(
    energy: "EnergyBound", box: "BoxBound | None" = None, slip: "AccumulatedBound | None" = None
) -> FromState:
    """The largest of the bounds of the same state; λ_E where no other proves more.

    The others are of the state alone, with all nodes closed.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = from_state(shakedown.energy_bound(joint), shakedown.box_bound(joint))
    >>> found.symbol, round(found.load_factor, 5)
    ('λ_box', 0.73159)
    """
    best = FromState(ENERGY, energy.load_factor, energy.least_load_factor)
    if energy.open_nodes or energy.distance > 0:
        return best
    for symbol, other in ((BOX, box), (SLIP, slip)):
        if other is None or np.isnan(other.load_factor):
            continue
        if best.least_load_factor > 0 or not other.load_factor <= best.load_factor:
            best = FromState(symbol, other.load_factor, 0.0)
    return best


def admitted_up_to(problem: Problem, slip: FloatArray, tolerances: Tolerances = DEFAULT) -> float:
    """Up to which load factor the first load step admits a slip with all nodes closed; 0 where none does.

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
