"""What is proved from one state: the larger of energy and box bound, and of every state where it is one."""

from typing import TYPE_CHECKING, NamedTuple, TypeGuard

import numpy as np

from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import CONE, Side, constraints, step_loads
from shakedown.joint.problem import Problem
from shakedown.programs.cone_rays import leaves_cone

if TYPE_CHECKING:
    from shakedown.bounds.collapse.box_bound import BoxBound
    from shakedown.bounds.energy.energy_bound import EnergyBound


ENERGY, BOX = "λ_E", "λ_box"


class FromState(NamedTuple):
    """Between which load factors shakedown is proved from one state, and by which bound.

    Attributes
    ----------
    symbol
        λ_E or λ_box, whichever is the larger.
    load_factor
        Where the proof ends; NaN where nothing is proved.
    least_load_factor
        Where it begins: zero but for a λ_E of a mean load that is not safe by itself.
    """

    symbol: str
    load_factor: float
    least_load_factor: float


def from_state(energy: "EnergyBound", box: "BoxBound | None") -> FromState:
    """The larger of both bounds of the same state; λ_E where there is no other.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = from_state(shakedown.energy_bound(joint), shakedown.box_bound(joint))
    >>> found.symbol, round(found.load_factor, 5)
    ('λ_box', 0.73159)
    """
    if box_proves_more(box, energy):
        return FromState(BOX, box.load_factor, 0.0)
    return FromState(ENERGY, energy.load_factor, energy.least_load_factor)


def box_proves_more(box: "BoxBound | None", energy: "EnergyBound") -> "TypeGuard[BoxBound]":
    """Whether the box proves more than the energy, of the same state alone and with all nodes closed."""
    if box is None or energy.open_nodes or energy.distance > 0 or np.isnan(box.load_factor):
        return False
    return bool(energy.least_load_factor > 0 or not box.load_factor <= energy.load_factor)


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
