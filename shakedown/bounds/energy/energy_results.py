"""Results of the energy method: a ball of slips at one load factor, and the largest load factor with one."""

from dataclasses import dataclass, field
from math import inf, nan
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from shakedown.bounds.bound_result import Bound, Evidence
from shakedown.bounds.energy.ball_limits import EnergyMetric
from shakedown.ground.constants import FloatArray
from shakedown.ground.errors import UsageError
from shakedown.ground.status import Status
from shakedown.joint.arguments import real_array
from shakedown.joint.contact_zone import Zone
from shakedown.joint.result import Result

# Why there is no energy ball, or no end to it, in the words of an answer.
NO_SAFE_SLIP = "no slip keeps every node within its friction limits at this load factor"
NOT_HELD = "no ball at this load factor reaches the state given"
NO_SLACK = "no slip leaves every node a margin to both its friction limits at this load factor"
ALL_ADMISSIBLE = "slip of one node shifts no limit of another: every admissible state shakes down"
WEDGED = "the centre may move away without end, and the radius grows with it: this is one ball of many"
TOO_FAR = "no safe slip is close enough to the initial slip"
AT_NO_LOAD = "no load factor is proved for all of its uncoupled parts at once"
UNLIMITED = "the ball about some safe slip holds the initial slip at every load factor"


@dataclass(frozen=True, eq=False, repr=False)
class EnergyBall(Result):
    """A ball of slips that no motion leaves, and in which every motion shakes down.

    A joint with all nodes closed, at a slip that is admissible under its load and less
    than ``radius`` away from ``slip`` in the energy norm, comes to rest after a finite
    total slip; no node ever opens. This holds at ``load_factor``, in whatever order the
    loads of the loop and those in between are passed. With open nodes it is said of a state
    in which these are open, in equilibrium, and all others closed: it stays so; distances
    are those of the closed nodes' slips, in the energy norm of the joint that is left.

    Attributes
    ----------
    status
        ``"optimal"``; ``"infeasible"`` (there is no ball: ``radius`` is 0, ``slip`` NaN);
        ``"unbounded"`` (``radius`` can be as large as one likes; where it is inf about one
        centre, every admissible state shakes down, else one ball is given).
    load_factor
        The load factor asked for.
    radius
        R [√(force · length)], the square root of twice an energy.
    slip : (n,)
        v*, the centre: a safe slip [length]; of an open node its displacement under the mean load.
    active
        (node, side) of the rows that limit the ball; with two directions (node, load step).
    residual
        Largest violation of a row, relative to its terms.
    reason
        The status in words; empty where optimal.
    metric
        The energy norm.
    inner_radius
        ``radius`` less what round-off may hide: within it a state is inside for certain.
    zone
        The open nodes and the joint of the closed ones; None with all nodes closed.
    share : (n, 2)
        With two directions what part c of the change of its own tangential reaction is counted as the
        change of the pressure of every closed node (docs/energy.md, section 8) [1]; else empty.
    shortfall
        Where no ball was found to hold the state given: how far that is from one,
        −max (R − ‖v − v*‖) [√(force · length)]; else NaN. States less than that away from it are in none
        with the same shares.
    """

    status: Status
    load_factor: float
    radius: float
    slip: FloatArray
    active: tuple[tuple[int, int], ...]
    residual: float
    reason: str
    metric: EnergyMetric = field(repr=False)
    inner_radius: float
    zone: Zone | None = field(default=None, repr=False)
    share: FloatArray = field(default_factory=lambda: np.zeros((0, 2)), repr=False)
    shortfall: float = nan

    @property
    def open_nodes(self) -> tuple[int, ...]:
        """The nodes that stay open."""
        return () if self.zone is None else self.zone.open_nodes

    @property
    def pinned(self) -> tuple[int, ...]:
        """Where the joint can move as a whole: the slips that ``slip`` is given relative to, by number."""
        closed = self._closed
        return tuple(int(closed[k]) for k in self.metric.pinned)

    @property
    def nodes(self) -> tuple[int, ...]:
        """The nodes that limit the ball."""
        return tuple(dict.fromkeys(node for node, _ in self.active))

    def distance(self, slip: ArrayLike) -> FloatArray:
        """Energy distance of slips (…, n) from the centre, (…) [√(force · length)]; inf without a ball."""
        given = real_array("slip", slip)
        if given.ndim == 0 or given.shape[-1] != len(self.slip):
            raise UsageError(f"slip: expected shape (..., {len(self.slip)}), found {given.shape}")
        if self.status == Status.INFEASIBLE:
            return np.full(given.shape[:-1], inf)
        with np.errstate(over="ignore", invalid="ignore"):  # overflow: too far away
            away = self.metric.norm(self._of_closed(given - self.slip))
        return np.where(np.isnan(away), inf, away)

    def margin(self, slip: ArrayLike) -> FloatArray:
        """``radius`` − ``distance(slip)``: how far slips (…, n) may be off and stay in the ball, (…)."""
        return np.asarray(self.radius - self.distance(slip))

    def single_node_margin(self, slip: ArrayLike) -> FloatArray:
        """How far any one node of slips (…, n) may be off, the others in place, (…) [length].

        A slip x of node j alone has the energy norm x √A_jj; with two directions at most that of the
        stiffest of its directions.
        """
        return np.asarray(self.margin(slip) / np.sqrt(self.metric.stiffest))

    def contains(self, slip: ArrayLike, *, off: float = 0.0) -> np.bool_ | np.ndarray:
        """Whether slips (…, n) are inside the ball, by more than round-off, (…).

        Wherever every node may be that is ``off`` by no more [length].
        """
        most = off * len(self._closed) * float(np.sqrt(self.metric.stiffest))
        return np.less(self.distance(slip) + most, self.inner_radius)

    def at(self, direction: ArrayLike, reach: float = 1.0) -> FloatArray:
        """Slips (…, n) on the surface, or at ``reach`` times the radius, along vectors (…, r).

        Directions are those of the energy norm: normally distributed numbers give
        states spread evenly over the surface. r is the rank of A.
        """
        away = np.asarray(direction, dtype=float)
        away = away / np.linalg.norm(away, axis=-1, keepdims=True)
        relative = self.radius / self.metric.unit
        change = reach * relative * (away @ self.metric.inverse.T)
        return np.asarray(self.slip + (change if self.zone is None else self.zone.follow(change)))

    def _of_closed(self, slips: FloatArray) -> FloatArray:
        return slips if self.zone is None else slips[..., self._closed]

    @property
    def _closed(self) -> NDArray[np.intp]:
        """The slips of the closed nodes among those of all nodes."""
        if self.zone is None:
            return np.arange(len(self.slip))
        return self.zone.problem.layout.slips_of(self.zone.closed_nodes)


@dataclass(frozen=True, eq=False, repr=False)
class EnergyCertificate(Result):
    """Numbers that strictly satisfy the conditions of the energy bound in exact arithmetic.

    Of a joint in uncoupled parts each part has a ball of its own; ``radius`` is that of the part with the
    least load factor.

    Attributes
    ----------
    load_factor
        A load factor at which shakedown is proved without any round-off.
    slip : (n,)
        The centre of the ball [length].
    radius
        A radius that reaches the initial state and the distance around it [√(force · length)].
    """

    load_factor: float
    slip: FloatArray
    radius: float


@dataclass(frozen=True, eq=False, repr=False)
class BallEvidence(Evidence):
    """What only λ_E has, below which every motion from around an initial slip is proved to shake down.

    At every load factor strictly between ``least_load_factor`` and ``load_factor`` a
    motion that begins with all nodes closed, at a slip within the energy distance
    ``distance`` of ``initial_slip``, comes to rest after a finite total slip, and no
    node ever opens. With open nodes it is said of a motion that begins with exactly these
    open, in equilibrium, and all others closed: it stays so. From all nodes closed at the
    same slips another state may be reached. It is infeasible where nothing is proved at any load factor,
    unbounded where shakedown is proved at every one from the least on, undecided where no solver came to an
    end that the rows confirm.

    Its ``slip`` (dn,) is v*, the safe slip in the middle of the ball at λ_E [length]. ``active`` are the
    rows that limit λ_E; where infeasible those that contradict each other. ``residual`` is the largest
    violation of a row at (slip, radius, λ_E), relative to its terms; where infeasible, by how much the
    multipliers fail to prove it. ``multipliers`` μ ≥ 0 (k,) prove λ_E, dᵀμ = 1, of the rows of the closed
    nodes and then of the gaps, each kind with its transient after it; zero or empty unless optimal. With two
    directions there is one for each of ``active``, that of its radius f p: at a reaction q* that of a q is
    −q*/|q*| times as large. ``certified`` is the load factor of ``certificate``. Each part of a joint in
    uncoupled parts has a ball of its own, at its own λ_E, of which ``slip`` is the centre (v₀ where that is
    unbounded); all else is that of the part with the least one.

    Attributes
    ----------
    radius
        Radius of that ball, ‖v₀ − v*‖ + distance [√(force · length)]; NaN unless optimal.
    initial_slip : (dn,)
        v₀ [length]; of an open node its displacement under the mean load.
    distance
        δ, the energy distance asked for [√(force · length)].
    gap
        Load factor that the multipliers prove not to be exceeded, relative to λ_E, less 1.
    certificate
        What exact arithmetic confirms (up to 40 nodes, all closed, A exactly positive
        semi-definite), else None.
    share : (n, 2)
        With two directions what part c of the change of its own tangential reaction is counted as the
        change of the pressure of every closed node (docs/energy.md, section 8) [1]; else empty.
    """

    DOCUMENT: ClassVar[str] = (
        "load_factor least_load_factor slip radius distance status reason certified uncertified residual "
        "initial_slip open_nodes active gap pinned"
    )
    TABLE: ClassVar[str] = "initial_slip slip"

    radius: float
    initial_slip: FloatArray
    distance: float
    gap: float
    certificate: EnergyCertificate | None = None
    share: FloatArray = field(default_factory=lambda: np.zeros((0, 2)), repr=False)


def no_bound(start: FloatArray, distance: float, reason: str, status: Status = Status.INFEASIBLE) -> Bound:
    """A bound that proves nothing from a slip, with the reason."""
    nowhere = np.full(len(start), nan)
    return Bound(
        kind="energy",
        status=status,
        load_factor=nan,
        evidence=BallEvidence(nan, start, distance, nan),
        slip=nowhere,
        reason=reason,
        least_load_factor=nan,
    )
