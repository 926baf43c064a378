"""What is proved from every state, from this one, and what is impossible: three numbers of many limits."""

from math import inf, isnan, nan
from typing import Protocol

from shakedown.assessment.from_state import FromState, admitted_up_to
from shakedown.bounds.energy.energy_bound import EnergyBound
from shakedown.bounds.every_state.universal_bound import UniversalBound
from shakedown.bounds.results import UpperBound
from shakedown.ground.status import Status
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.problem import Problem


class NumberedLimits(Protocol):
    """The limits that the numbers are made of."""

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
    def is_open_from_state(self) -> bool: ...
    @property
    def open_nodes(self) -> tuple[int, ...]: ...


def proved_from_every_state(limits: NumberedLimits) -> float:
    """λ_U; 0 where nothing is proved, NaN where a program of the proof came to no end."""
    if limits.universal.status == Status.UNDECIDED:
        return nan
    return 0.0 if isnan(limits.universal.load_factor) else limits.universal.load_factor


def proved_from_this_state(limits: NumberedLimits) -> float:
    """The largest of what is proved of the state asked about; NaN where a program came to no end."""
    here = limits.from_state
    known = [nan if here.least_load_factor > 0 else here.load_factor, _as_one_of_all(limits)]
    proved = [number for number in known if not isnan(number)]
    if proved:
        return max(proved)
    return nan if limits.is_open_from_state else 0.0


def _as_one_of_all(limits: NumberedLimits) -> float:
    """Up to where this state is one of those that λ_U is about; NaN where that is not known."""
    if limits.open_nodes or limits.distance > 0 or limits.universal.after_transient:
        return nan
    every = proved_from_every_state(limits)
    return min(every, admitted_up_to(limits.problem, limits.energy.initial_slip, limits.tolerances))


def impossible_above(limits: NumberedLimits) -> float:
    """λ_max, the upper end of what encloses it; inf where nodes are open, 0 where no slip is safe."""
    upper = limits.upper
    if upper.open_nodes:
        return inf
    if upper.status == Status.INFEASIBLE:
        return 0.0
    return upper.load_factor if upper.certified is None else max(upper.load_factor, upper.certified[1])
