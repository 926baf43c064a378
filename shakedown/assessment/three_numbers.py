"""Proved from every state, proved from this state, impossible above: three numbers from many limits."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, isnan, nan
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from shakedown.ground.errors import Missing
from shakedown.ground.float_array import FloatArray
from shakedown.ground.size_limits import CONE
from shakedown.ground.status import SYMBOLS, Status
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.constraints import Side, constraints, step_loads
from shakedown.joint.loading import loading
from shakedown.joint.problem import Problem
from shakedown.programs.cone_rays import leaves_cone

if TYPE_CHECKING:  # they load solvers
    from shakedown.bounds.accumulated.accumulated_bound import AccumulatedBound
    from shakedown.bounds.collapse.lower import LowerBound
    from shakedown.bounds.energy.energy_bound import EnergyBound
    from shakedown.bounds.every_state.universal_bound import UniversalBound
    from shakedown.bounds.results import UpperBound

REFUTED = "round-off decides: its load factor is {:.7g}, although no slip is safe above {:.7g}"
ENERGY, SLIP = SYMBOLS["energy"], SYMBOLS["accumulated"]


class FromState(NamedTuple):
    """Between which load factors shakedown is proved from one state, and by which bound.

    Attributes
    ----------
    symbol
        λ_E or λ_S, whichever is the larger.
    load_factor
        Where the proof ends; NaN where nothing is proved.
    least_load_factor
        Where it begins: zero, except for λ_E where the mean load alone is not safe.
    """

    symbol: str
    load_factor: float
    least_load_factor: float


def from_state(energy: EnergyBound, slip: AccumulatedBound | None = None) -> FromState:
    """The larger of the bounds for one state; λ_E where λ_S, which is for all nodes closed, proves no more.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> found = from_state(shakedown.energy_bound(joint), shakedown.accumulated_bound(joint))
    >>> found.symbol, round(found.load_factor, 5)
    ('λ_S', 0.73159)
    """
    by_energy = FromState(ENERGY, energy.load_factor, energy.least_load_factor)
    if energy.open_nodes or energy.distance > 0 or slip is None or isnan(slip.load_factor):
        return by_energy
    more = by_energy.least_load_factor > 0 or not slip.load_factor <= by_energy.load_factor
    return FromState(SLIP, slip.load_factor, 0.0) if more else by_energy


def not_refuted(load_factor: float, upper: UpperBound, tolerances: Tolerances = DEFAULT) -> float:
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


def first_to_leave(problem: Problem, slip: FloatArray, load_factor: float) -> tuple[int, str]:
    """The node that is first beyond its limits in the first load step, and whether it would slip or open.

    Examples
    --------
    >>> import shakedown
    >>> joint = shakedown.example("two-node")
    >>> first_to_leave(joint, np.zeros(2), admitted_up_to(joint, np.zeros(2)))
    (0, 'slip')
    """
    loop, law = loading(problem), problem.law
    q = loop.q0 + load_factor * loop.q1[0] + problem.A @ slip
    p = loop.p0 + load_factor * loop.p1[0] + problem.B @ slip
    size = law.size(q) + law.limit(np.abs(p))
    node = int(np.argmax(law.excess(q, p) / np.where(size > 0, size, 1.0)))
    return node, "slip" if p[node] > 0 else "open"


class NumberedLimits(Protocol):
    """The limits from which the three numbers are taken."""

    @property
    def problem(self) -> Problem: ...
    @property
    def distance(self) -> float: ...
    @property
    def tolerances(self) -> Tolerances: ...
    @property
    def zone(self) -> object: ...
    @property
    def universal(self) -> UniversalBound: ...
    @property
    def upper(self) -> UpperBound: ...
    @property
    def energy(self) -> EnergyBound: ...
    @property
    def from_state(self) -> FromState: ...
    @property
    def open_nodes(self) -> tuple[int, ...]: ...


def proved_from_every_state(limits: NumberedLimits) -> float:
    """λ_U; 0 where nothing is proved, NaN where a program of the proof did not finish."""
    universal = limits.universal
    if universal.status == Status.UNDECIDED:
        return nan
    return 0.0 if isnan(universal.load_factor) else not_refuted(universal.load_factor, limits.upper)


def proved_from_this_state(limits: NumberedLimits) -> float:
    """The largest limit proved for the state in question; NaN where a program did not finish."""
    here = limits.from_state
    known = [nan if here.least_load_factor > 0 else here.load_factor, _as_one_of_all(limits)]
    proved = [number for number in known if not isnan(number)]
    if proved:
        return max(proved)
    return nan if limits.energy.status == Status.UNDECIDED else 0.0


def _as_one_of_all(limits: NumberedLimits) -> float:
    """Up to where this state is among those that λ_U is about; NaN where that is not known."""
    if limits.open_nodes or limits.distance > 0 or limits.universal.after_transient:
        return nan
    every = proved_from_every_state(limits)
    return min(every, admitted_up_to(limits.problem, limits.energy.initial_slip, limits.tolerances))


def impossible_above(limits: NumberedLimits) -> float:
    """The upper end of what encloses λ_max; inf where nodes are open, 0 where no slip is safe."""
    upper = limits.upper
    if upper.open_nodes:
        return inf
    if upper.status == Status.INFEASIBLE:
        return 0.0
    return upper.load_factor if upper.certified is None else max(upper.load_factor, upper.certified[1])


def open_ends(
    *results: LowerBound | UpperBound | EnergyBound | UniversalBound | Missing,
) -> Iterator[str]:
    """One sentence for each result that is open or disputed.

    A limit that does not exist, like λ_1 with two tangential directions, is not open.

    Examples
    --------
    >>> import shakedown
    >>> list(open_ends(shakedown.upper_bound(shakedown.example("two-node"))))
    []
    """
    from shakedown.bounds.collapse.lower import LowerBound
    from shakedown.bounds.energy.energy_bound import EnergyBound
    from shakedown.bounds.every_state.universal_bound import UniversalBound
    from shakedown.bounds.results import UpperBound

    names = {LowerBound: "λ_1", UpperBound: "λ_max", EnergyBound: "λ_E", UniversalBound: "λ_U"}
    for result in results:
        if isinstance(result, Missing):
            continue
        name = names[type(result)]
        if result.status == Status.UNDECIDED:
            yield f"{name} is open: {result.reason}"
        elif isinstance(result, LowerBound | UpperBound) and result.disputed:
            yield f"{name} is disputed: {result.uncertified}"
