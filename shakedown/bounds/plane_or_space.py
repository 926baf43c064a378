"""Which methods answer for a joint: rows and linear programs in the plane, discs and cone programs in space.

This is the one place that asks, and it computes nothing. Zones, statuses, certificates and words around the
methods are written once.
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from shakedown.bounds.bound_result import Bound
from shakedown.bounds.energy.energy_results import EnergyBall, Inner
from shakedown.bounds.results import SafeSlip, ZoneLimit
from shakedown.ground.errors import Missing
from shakedown.ground.float_array import FloatArray
from shakedown.ground.tolerances import Tolerances
from shakedown.joint.constraints import Constraints
from shakedown.joint.contact_zone import Zone
from shakedown.joint.problem import Problem


class Methods(Protocol):
    """The interface of a family of methods: a module with these functions and constants.

    Attributes
    ----------
    FEW_NODES
        Above this number a run takes more than hundredths of a second: fewer runs, less accurate, in threads.
    HOLDING_BALL_SOONER
        Whether an energy ball that holds a slip is found sooner than the largest one.
    MOST_ZONES
        Largest number of contact zones solved in a search, whose answer is the best one so far.
    ALL_COMPARED_UP_TO
        Nodes up to which all zones that differ in one node are compared, and searches begin in every start.
    CHANGES_AT_ONCE
        Numbers of nodes changed at once, the first ones first.
    """

    @property
    def FEW_NODES(self) -> float: ...
    @property
    def HOLDING_BALL_SOONER(self) -> bool: ...
    @property
    def MOST_ZONES(self) -> float: ...
    @property
    def ALL_COMPARED_UP_TO(self) -> float: ...
    @property
    def CHANGES_AT_ONCE(self) -> tuple[int, ...]: ...

    def upper(self, zone: Zone, transient: bool, certify: bool | None, tolerances: Tolerances) -> Bound:
        """λ_max of the closed nodes of a zone."""

    def safe_slip(self, zone: Zone, load_factor: float, transient: bool, tolerances: Tolerances) -> SafeSlip:
        """The slip of a zone farthest from slipping."""

    def slip_limits(self, rows: Constraints, v: FloatArray) -> tuple[FloatArray, tuple[int, ...]]:
        """That no slip v(x) of a node is larger than t, in (x, t), and the sizes of the cones of all rows."""

    def zone_limit(self, zone: Zone, compared: bool, tolerances: Tolerances) -> ZoneLimit:
        """λ_max of a zone among others; ``compared``: with its margin where it has no safe slip."""

    def change_weights(self, zone: Zone, found: ZoneLimit, tolerances: Tolerances) -> dict[int, float]:
        """How strongly the multipliers of a zone suggest opening or closing a node."""

    def limits_left(self, zone: Zone, found: ZoneLimit) -> tuple[NDArray[np.intp], FloatArray]:
        """The nodes nearest to opening or closing (k,), and their relative slack."""

    def energy_bound(
        self, zone: Zone, given: FloatArray, distance: float, tolerances: Tolerances, *, split: bool
    ) -> Bound:
        """λ_E of the closed nodes of a zone, from slips (dk,) of these."""

    def strictly_inside(self, zone: Zone, bound: Bound, tolerances: Tolerances) -> Inner | Missing:
        """Where all conditions of a bound have the largest margins, with all nodes closed."""

    def energy_ball(
        self,
        zone: Zone,
        load_factor: float,
        state: FloatArray | None,
        tolerances: Tolerances,
        *,
        transient: bool,
        split: bool,
        best: bool = True,
    ) -> EnergyBall:
        """The largest ball of the closed nodes, or the one that holds a state (dk,) of these best."""

    def no_ball_holds(
        self, zone: Zone, load_factor: float, state: FloatArray, tolerances: Tolerances
    ) -> bool:
        """Whether it is proved, sooner than λ_E is found, that no ball holds a state (dk,) of these."""


def takes_long(problem: Problem) -> bool:
    """Whether runs of a joint take so long that fewer are made, less accurately, in several threads."""
    return problem.n > methods_of(problem).FEW_NODES


def methods_of(problem: Problem) -> Methods:
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
