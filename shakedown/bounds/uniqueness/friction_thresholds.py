"""Friction coefficients above which the evolution stops being unique, jumps or wedges.

Thesis (4.1), (4.23), (6.4)–(6.10); the determinants stand in ``bounds.uniqueness``.
"""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from shakedown.bounds.uniqueness.coupling import coupling_limit, energy_limit
from shakedown.bounds.uniqueness.moving_sets import LARGEST_SET, LostAt, every_set, first_to_lose, grown_set
from shakedown.bounds.uniqueness.scaled_stiffness import ScaledStiffness, held, scaled_stiffness
from shakedown.bounds.uniqueness.wedging import Wedging, wedging_threshold
from shakedown.ground.blas_threads import on_one_thread
from shakedown.ground.errors import Missing, sought
from shakedown.ground.float_array import FloatArray
from shakedown.ground.shown_values import plain
from shakedown.ground.size_limits import ALL_SUBSETS_UP_TO
from shakedown.ground.tolerances import DEFAULT, Tolerances
from shakedown.joint.arguments import NO_SIGNS, checked, require_plane
from shakedown.joint.problem import Problem
from shakedown.joint.result import Result


@dataclass(frozen=True, eq=False, repr=False)
class Threshold(Result):
    """Where uniqueness ends, in the unit of :class:`FrictionThresholds`.

    Attributes
    ----------
    low, high
        It is certainly not lost below ``low``, and it is lost at ``high``; equal
        where all sets of nodes have been tried, infinite where it is never lost.
    slipping, sides, separated
        The set for which it is lost at ``high``: slipping nodes, their sides
        (+1 backward, −1 forward) and the open nodes.
    """

    DOCUMENT: ClassVar[str] = "low high value slipping sides separated"

    low: float
    high: float
    slipping: tuple[int, ...] = ()
    sides: tuple[int, ...] = ()
    separated: tuple[int, ...] = ()

    @property
    def value(self) -> float:
        """The threshold; NaN where only an interval is known."""
        return self.high if self.low == self.high else np.nan


@dataclass(frozen=True, eq=False, repr=False)
class FrictionThresholds(Result):
    """Result of :func:`friction_thresholds`.

    Thresholds other than ``single_node`` are friction coefficients where all
    nodes have the same one, else the common factor on the given coefficients.

    Attributes
    ----------
    single_node : (n,)
        A_jj / |B_jj|, a friction coefficient: where node j alone, all others
        stuck, loses uniqueness (4.1).
    factor
        Whether the other thresholds are factors on f.
    uniqueness_in_contact
        Where the evolution with all nodes closed stops being unique.
    uniqueness
        The same over every set of separated nodes; None without C.
    wedging
        Where a state of self-stress can hold the body without load.
    """

    single_node: FloatArray
    factor: bool
    uniqueness_in_contact: Threshold
    uniqueness: Threshold | None
    wedging: Wedging

    def to_dict(self) -> dict[str, Any]:
        """A threshold of which only an interval is known is None; the interval stands beside it."""
        known: dict[str, Any] = {"single_node": self.single_node}
        for name in ("uniqueness_in_contact", "uniqueness", "wedging"):
            threshold: Threshold | Wedging | None = getattr(self, name)
            ends = None if threshold is None else [threshold.low, threshold.high]
            known |= {name: None if threshold is None else threshold.value, f"{name}_interval": ends}
        return plain(known | {"unit": "factor on f" if self.factor else "friction coefficient"})


@checked
@on_one_thread
def friction_thresholds(problem: Problem, *, tolerances: Tolerances = DEFAULT) -> FrictionThresholds:
    """Friction coefficients at which a single node, all nodes together or a wedged state make trouble.

    Exact up to eight nodes in contact (six with separation); beyond, an
    interval: below it the sum of dissipation and stored energy of every motion
    is positive or the coupling ratio is less than 1, above it a small set of nodes
    is known to lose uniqueness.

    Parameters
    ----------
    problem
        The joint; its loading plays no part.
    tolerances
        What counts as zero.

    Examples
    --------
    >>> import shakedown
    >>> limits = friction_thresholds(shakedown.example("two-node"))
    >>> limits.single_node.round(4), round(limits.uniqueness.value, 4), limits.uniqueness.slipping
    (array([0.7608, 2.0225]), 0.6306, (0, 1))
    """
    require_plane("friction thresholds", problem, NO_SIGNS)
    factor = bool(np.ptp(problem.f) > 0)
    stiffness = scaled_stiffness(problem, problem.f if factor else np.ones(problem.n), tolerances)
    contact, anywhere = _uniqueness(stiffness, separation=False), None
    if problem.C is not None:
        anywhere = _uniqueness(stiffness, separation=True)
        if contact.high < anywhere.high:  # no node open is one of the sets
            anywhere = replace(contact, low=min(anywhere.low, contact.high))
    # Self-stress A v = t S φ B v, S between −1 and 1, needs a determinant that vanishes at t or below.
    safe = contact.low * stiffness.friction_unit if held(stiffness.A, stiffness.tolerances) else 0.0
    return FrictionThresholds(
        single_node=_single_node(stiffness),
        factor=factor,
        uniqueness_in_contact=contact,
        uniqueness=anywhere,
        wedging=_wedging(stiffness, safe),
    )


def _wedging(stiffness: ScaledStiffness, safe: float) -> Wedging:
    """Where a program of the search fails, what is known without it."""
    found = sought(wedging_threshold, stiffness, safe)
    if not isinstance(found, Missing):
        return found
    return Wedging(safe / stiffness.friction_unit, np.inf, np.full(stiffness.n, np.nan), reason=found.reason)


def _single_node(stiffness: ScaledStiffness) -> FloatArray:
    a, b = np.diag(stiffness.A), np.abs(np.diag(stiffness.B))
    return np.where(b > 0, a / np.where(b > 0, b, 1.0), np.inf)


def _uniqueness(stiffness: ScaledStiffness, *, separation: bool) -> Threshold:
    n, unit = stiffness.n, stiffness.friction_unit
    if n <= (ALL_SUBSETS_UP_TO if separation else LARGEST_SET):
        lost = first_to_lose(stiffness, every_set(n, separation=separation))
        return _threshold(lost.factor, lost, unit)
    low = energy_limit(stiffness, separation=separation)
    if not separation:
        low = max(low, coupling_limit(stiffness))
    lost = grown_set(stiffness, separation=separation)
    return _threshold(min(low, lost.factor), lost, unit)


def _threshold(low: float, lost: LostAt, unit: float) -> Threshold:
    moving = lost.moving if lost.sides else None
    return Threshold(
        low=low / unit,
        high=lost.factor / unit,
        slipping=moving.slipping if moving else (),
        sides=lost.sides,
        separated=moving.separated if moving else (),
    )
